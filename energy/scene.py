"""A scene: layer, surfaces and indenter.

`as_indenter` makes an `Indenter` of anything with height(x) and slope(x). About an axis,
`about_axis` gives the mirror-symmetric profile f(|x|), from a half as well, and `check_rings`
refuses a pattern that is not symmetric; `difference(indenter, centre, length)` is a message that
says where a profile is not its mirror image about the centre, "" if it is. `GEOMETRIES` and
`SLOPES` are the words that are known, which `option` checks; `not_a_class` refuses a class.
`surfaces.doubt` ends a message about w > 10 γ₁ with the question whether the two were swapped.
"""

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
        """Check what was given, and take any profile as an `Indenter`."""
        for name in ("layer", "surfaces", "opening", "pattern"):
            not_a_class(name, getattr(self, name))
        for name, kind in (("layer", ElasticLayer), ("surfaces", SurfaceEnergies)):
            given = getattr(self, name)
            if not isinstance(given, kind):
                raise ValueError(f"{name} = {given!r} is not of energy.{kind.__name__}; build one")
        option("slopes", self.slopes, SLOPES)
        object.__setattr__(self, "indenter", as_indenter(self.indenter))
        if self.opening is not None:
            self._check_opening(self.opening)
        if self.pattern is not None and not isinstance(self.pattern, Patches):
            raise ValueError(f"pattern = {self.pattern!r} must be Patches(...) or None")
        option("geometry", self.geometry, GEOMETRIES)
        if self.axisymmetric:
            self._turn_about_axis()
        if self.slopes == "finite":
            self._check_young_angle()

    def _check_young_angle(self) -> None:
        """ValueError where Young's law has no angle."""
        w = self.opened.work_of_adhesion
        if w > 2 * self.gamma1:
            raise ValueError(
                f"w = {w!r} exceeds 2 gamma1 = {2 * self.gamma1!r}: with finite slopes there is no "
                "Young angle; lower w, raise gamma1 or use slopes='small'"
                f"{self.opened.surfaces.doubt}"
            )

    def _check_opening(self, opening: SurfaceEnergies) -> None:
        """ValueError unless a contact that opens has the same tension and adheres as much."""
        if not isinstance(opening, SurfaceEnergies):
            raise ValueError(f"opening = {opening!r} must be SurfaceEnergies(...) or None")
        if opening.gamma1 != self.gamma1 or opening.work_of_adhesion < self.work_of_adhesion:
            raise ValueError(
                f"opening = {opening!r} must have the gamma1 = {self.gamma1!r} of surfaces and a "
                f"work of adhesion not below theirs, {self.work_of_adhesion!r}"
            )

    def _turn_about_axis(self) -> None:
        """Take the profile f(r); ValueError where profile or pattern is not symmetric."""
        object.__setattr__(self, "indenter", about_axis(self.indenter, self._longest))
        if self.pattern is not None:
            check_rings(self.pattern)

    @property
    def _longest(self) -> float:
        """The largest of the lengths l, δ₀ and h of the scene."""
        return max(self.elastocapillary_length, self.critical_separation, self.layer.h)

    @functools.cached_property
    def mirror(self) -> float | None:
        """x [length] about which the profile is its own mirror image; None if none is known.

        It is the apex of a profile that says so. Of others the heights on samples are compared,
        about the middle of the extent, or about 0 if there is none (`energy.axis.difference`).
        """
        if self.indenter.symmetric:
            return self.indenter.apex
        low, high = self.indenter.extent
        centre = (low + high) / 2 if math.isfinite(high - low) else 0.0
        return None if difference(self.indenter, centre, self._longest) else centre

    @property
    def axisymmetric(self) -> bool:
        """Whether the profile is turned about r = 0."""
        return self.geometry == "axisymmetric"

    def measure(self, x: ArrayLike) -> Array:
        """The measure of integrals over x: 1, or 2πr at r = x with rotational symmetry.

        Parameters
        ----------
        x : array_like
            Positions, or radii [length], of any shape.

        Returns
        -------
        ndarray
            [1] or [length], of the shape of x.
        """
        x = np.asarray(x, float)
        return 2 * math.pi * x if self.axisymmetric else np.ones_like(x)

    @property
    def per_length(self) -> str:
        """What follows N and J in the units of force and energy: "/m", nothing around an axis."""
        return "" if self.axisymmetric else "/m"

    @functools.cached_property
    def opened(self) -> Scene:
        """This scene with the surface energies of a contact that is being opened."""
        if self.opening is None:
            return self
        return replace(self, surfaces=self.opening, opening=None)

    @functools.cached_property
    def stiffness(self) -> float:
        """Stiffness per area k = Ẽ/h [stress/length], Eq. (3)."""
        return self.layer.stiffness

    def spring(self, u: ArrayLike) -> terms.Density:
        """Energy of the springs per area, and its derivatives; see `terms.spring`.

        Parameters
        ----------
        u : array_like
            Displacements [length], of any shape.

        Returns
        -------
        terms.Density
        """
        return terms.spring(u, k=self.stiffness)

    @functools.cached_property
    def hookean(self) -> bool:
        """Whether `spring` is k u²/2, as the closed forms of free surfaces need it to be.

        A second derivative that is an array is taken for that of another density.
        """
        # Value and both derivatives at one place fix a quadratic density. A second place, of other
        # sign and size, shows one that is not quadratic but states a constant second derivative.
        u = self.layer.h * np.array([-1.0, 2.0])
        return self.spring(u).hookean(u, self.stiffness)

    @functools.cached_property
    def gamma1(self) -> float:
        """Surface tension γ₁ of the layer [energy/area]."""
        return self.surfaces.gamma1

    @functools.cached_property
    def work_of_adhesion(self) -> float:
        """Work of adhesion w = γ₁ + γ₂ - γ₁₂ [energy/area], Eq. (1)."""
        return self.surfaces.work_of_adhesion

    @functools.cached_property
    def elastocapillary_length(self) -> float:
        """Elastocapillary length l = √(γ₁/k) [length], Eq. (7)."""
        return math.sqrt(self.gamma1 / self.stiffness)

    @functools.cached_property
    def effective_length(self) -> float:
        """ℓ [length], which stands for l in Eq. (16) of a layer; `energy.layer.effective_length`.

        Raises
        ------
        ValueError
            For an incompressible layer.
        """
        return effective_length(self.layer, self.gamma1)

    @functools.cached_property
    def critical_separation(self) -> float:
        """Critical separation δ₀ = √(2w/k) [length], Eq. (20)."""
        return math.sqrt(2 * self.work_of_adhesion / self.stiffness)

    @property
    def path_dependent(self) -> bool:
        """Whether the place where a line rests depends on the direction it came from.

        It does where two works of adhesion differ, or adhesion varies along the surface.
        """
        return self.opening is not None or self.pattern is not None

    @functools.cached_property
    def hysteretic(self) -> bool:
        """Whether a contact line is pinned over a range of depths, in either direction.

        It is with two works of adhesion, and on springs without tension.
        """
        return self.opening is not None or not self.gamma1
