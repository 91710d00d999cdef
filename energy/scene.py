"""A scene: layer, surfaces and indenter."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import ArrayLike

from energy import terms
from energy.arrays import Array
from energy.axis import about_axis, check_rings, difference
from energy.checks import not_a_class, option
from energy.indenter import Indenter, as_indenter
from energy.layer import ElasticLayer, effective_length
from energy.pattern import Patches
from energy.surfaces import SurfaceEnergies
from energy.terms import GEOMETRIES, SLOPES


@dataclass(frozen=True)
class Scene:
    """Layer, surfaces and indenter: everything but the depth.

    Parameters
    ----------
    layer : ElasticLayer
    surfaces : SurfaceEnergies
    indenter : Indenter, or any object with vectorised height(x) and slope(x)
    slopes : {"small", "finite"}
        The paper's energy, or that of the surfaces' true lengths.
    opening : SurfaceEnergies, optional
        Of a contact that is being opened, where they differ from those of one being closed
        (adhesion hysteresis); with the same γ₁ and no smaller work of adhesion.
    pattern : Patches, optional
        Factor on the work of adhesion along the surface.
    geometry : {"line", "axisymmetric"}
        Everything per length of a line contact; or the profile f(r) and the pattern turned about
        r = 0, with forces and energies in full. `indenter` then is the mirror-symmetric profile:
        half-profiles, which begin at r = 0, are mirrored.

    Raises
    ------
    ValueError
        For wrong types, an unknown `slopes` or `geometry`, an `opening` that does not fit, w > 2γ₁
        with finite slopes (no Young angle: the layer would spread over the whole indenter), and
        for rotational symmetry a profile or pattern that is not symmetric about 0, or a plane.

    Notes
    -----
    l = √(γ₁/k), over which the free surface decays, and δ₀ = √(2w/k), by which adhesion lifts it.

    Examples
    --------
    >>> from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
    >>> layer, surfaces = ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(0.07, 6e-5)
    >>> scene = Scene(layer, surfaces, Parabola(R=0.02))
    >>> print(f"l = {scene.elastocapillary_length:.3g}, δ₀ = {scene.critical_separation:.3g}")
    l = 1.02e-05, δ₀ = 4.22e-07
    """

    layer: ElasticLayer
    surfaces: SurfaceEnergies
    indenter: Indenter
    slopes: str = "small"
    opening: SurfaceEnergies | None = None
    pattern: Patches | None = None
    geometry: str = "line"

    def __post_init__(self) -> None:
        for name in ("layer", "surfaces", "opening", "pattern"):
            not_a_class(name, getattr(self, name))
        for name, kind in (("layer", ElasticLayer), ("surfaces", SurfaceEnergies)):
            if not isinstance(getattr(self, name), kind):
                raise ValueError(
                    f"{name} = {getattr(self, name)!r} is not of energy.{kind.__name__}; build one"
                )
        option("slopes", self.slopes, SLOPES)
        object.__setattr__(self, "indenter", as_indenter(self.indenter))
        if self.opening is not None:
            self._check_opening(self.opening)
        if self.pattern is not None and not isinstance(self.pattern, Patches):
            raise ValueError(f"pattern = {self.pattern!r} must be Patches(...) or None")
        if option("geometry", self.geometry, GEOMETRIES) == "axisymmetric":
            self._turn()
        w = self.opened.work_of_adhesion
        if self.slopes == "finite" and w > 2 * self.gamma1:
            raise ValueError(
                f"w = {w!r} exceeds 2 gamma1 = {2 * self.gamma1!r}: with finite slopes there is no "
                "Young angle; lower w, raise gamma1 or use slopes='small'"
                f"{self.opened.surfaces.doubt}"
            )

    def _check_opening(self, opening: SurfaceEnergies) -> None:
        if not isinstance(opening, SurfaceEnergies):
            raise ValueError(f"opening = {opening!r} must be SurfaceEnergies(...) or None")
        if opening.gamma1 != self.gamma1 or opening.work_of_adhesion < self.work_of_adhesion:
            raise ValueError(
                f"opening = {opening!r} must have the gamma1 = {self.gamma1!r} of surfaces and a "
                f"work of adhesion not below theirs, {self.work_of_adhesion!r}"
            )

    def _turn(self) -> None:
        object.__setattr__(self, "indenter", about_axis(self.indenter, self._length))
        if self.pattern is not None:
            check_rings(self.pattern)

    @property
    def _length(self) -> float:
        """The largest of those that displacements vary over."""
        return max(self.elastocapillary_length, self.critical_separation, self.layer.h)

    @functools.cached_property
    def mirror(self) -> float | None:
        """x about which the profile is its own mirror image, None if it is not about any known.

        As the profile says, or else by its heights on samples, about the middle of its extent, or
        0; see `energy.axis.difference`.
        """
        body, (lo, hi) = self.indenter, self.indenter.extent
        if body.symmetric:
            return body.apex
        centre = (lo + hi) / 2 if math.isfinite(hi - lo) else 0.0
        return None if difference(body, centre, self._length) else centre

    @property
    def axisymmetric(self) -> bool:
        """Whether the profile is turned about r = 0."""
        return self.geometry == "axisymmetric"

    def measure(self, x: ArrayLike) -> Array:
        """What an integral over x counts with: 1, or 2πr for r = x with rotational symmetry."""
        x = np.asarray(x, float)
        return 2 * math.pi * x if self.axisymmetric else np.ones_like(x)

    @property
    def per_length(self) -> str:
        """What follows N and J in the units of force and energy: "/m", nothing around an axis."""
        return "" if self.axisymmetric else "/m"

    @functools.cached_property
    def opened(self) -> Scene:
        """This scene with the surface energies of a contact that is being opened."""
        return self if self.opening is None else replace(self, surfaces=self.opening, opening=None)

    @functools.cached_property
    def stiffness(self) -> float:
        """k = Ẽ/h, Eq. (3)."""
        return self.layer.stiffness

    def spring(self, u: ArrayLike) -> terms.Density:
        """What springs store per area at a displacement u, and its derivatives; `terms.spring`."""
        return terms.spring(u, k=self.stiffness)

    @functools.cached_property
    def hookean(self) -> bool:
        """Whether `spring` is quadratic, as nearly all that knows a free surface needs it to be."""
        return self.spring(np.zeros(2)).quadratic

    @functools.cached_property
    def gamma1(self) -> float:
        """Surface tension γ₁ of the layer."""
        return self.surfaces.gamma1

    @functools.cached_property
    def work_of_adhesion(self) -> float:
        """w = γ₁ + γ₂ - γ₁₂, Eq. (1)."""
        return self.surfaces.work_of_adhesion

    @functools.cached_property
    def elastocapillary_length(self) -> float:
        """l = √(γ₁/k), Eq. (7)."""
        return math.sqrt(self.gamma1 / self.stiffness)

    @functools.cached_property
    def effective_length(self) -> float:
        """ℓ, which stands for l in Eq. (16) of a layer; see energy.layer.effective_length."""
        return effective_length(self.layer, self.gamma1)

    @functools.cached_property
    def critical_separation(self) -> float:
        """δ₀ = √(2w/k), Eq. (20)."""
        return math.sqrt(2 * self.work_of_adhesion / self.stiffness)

    @property
    def path_dependent(self) -> bool:
        """Whether where a line rests depends on the way it came: by its work, or a pattern."""
        return self.opening is not None or self.pattern is not None

    @functools.cached_property
    def hysteretic(self) -> bool:
        """Whether a contact line resists both ways: two works of adhesion, or springs alone."""
        return self.opening is not None or not self.gamma1
