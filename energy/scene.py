"""A scene: layer, surfaces and indenter, and how far the model's assumptions hold in it."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import NamedTuple

from energy.checks import option
from energy.indenter import Indenter, as_indenter
from energy.layer import ElasticLayer
from energy.pattern import Patches
from energy.surfaces import SurfaceEnergies
from energy.terms import SLOPES


class Assumption(NamedTuple):
    """One assumption of the model: a dimensionless measure that should stay below its limit."""

    name: str
    value: float
    limit: float
    consequence: str

    @property
    def holds(self) -> bool:
        """Whether the measure does not exceed its limit."""
        return self.value <= self.limit

    def __str__(self) -> str:
        verdict = "holds" if self.holds else f"VIOLATED: {self.consequence}"
        return f"{self.name} = {self.value:.3g} (limit {self.limit:g}): {verdict}"


@dataclass(frozen=True)
class Scene:
    """Everything but the depth. slopes: "small" (the paper's energy) or "finite" (true lengths).

    opening: surface energies of a contact that is being opened, where they differ from those of
    one being closed (adhesion hysteresis); with the same γ₁ and no smaller work of adhesion.

    pattern: factor on the work of adhesion along the surface.

    ValueError for wrong types, an unknown `slopes`, an `opening` that does not fit, and w > 2γ₁
    with finite slopes (no Young angle: the layer would spread over the whole indenter).
    """

    layer: ElasticLayer
    surfaces: SurfaceEnergies
    indenter: Indenter
    slopes: str = "small"
    opening: SurfaceEnergies | None = None
    pattern: Patches | None = None

    def __post_init__(self) -> None:
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
        w = self.opened.work_of_adhesion
        if self.slopes == "finite" and w > 2 * self.gamma1:
            raise ValueError(
                f"w = {w!r} exceeds 2 gamma1 = {2 * self.gamma1!r}: with finite slopes there is no "
                "Young angle; lower w, raise gamma1 or use slopes='small'"
            )

    def _check_opening(self, opening: SurfaceEnergies) -> None:
        if not isinstance(opening, SurfaceEnergies):
            raise ValueError(f"opening = {opening!r} must be SurfaceEnergies(...) or None")
        if opening.gamma1 != self.gamma1 or opening.work_of_adhesion < self.work_of_adhesion:
            raise ValueError(
                f"opening = {opening!r} must have the gamma1 = {self.gamma1!r} of surfaces and a "
                f"work of adhesion not below theirs, {self.work_of_adhesion!r}"
            )

    @functools.cached_property
    def opened(self) -> Scene:
        """This scene with the surface energies of a contact that is being opened."""
        return self if self.opening is None else replace(self, surfaces=self.opening, opening=None)

    @functools.cached_property
    def stiffness(self) -> float:
        """k = Ẽ/h, Eq. (3)."""
        return self.layer.stiffness

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
    def critical_separation(self) -> float:
        """δ₀ = √(2w/k), Eq. (20)."""
        return math.sqrt(2 * self.work_of_adhesion / self.stiffness)

    @functools.cached_property
    def hysteretic(self) -> bool:
        """Whether a contact line resists both ways: two works of adhesion, or springs alone."""
        return self.opening is not None or not self.gamma1

    def validity(
        self, depth: float, half_width: float, slope: float, displacement: float = 0.0
    ) -> tuple[Assumption, ...]:
        """How far the assumptions of the model hold at an equilibrium.

        depth d, contact half-width a, steepest surface inclination |slope| and largest displacement
        |u| at the contact lines: a surface lifted far strains the layer at any d. Conditions of
        Sections 2 and 6: d ≪ h ≪ a, slopes ≪ 1, 2w ≪ γ₁, and for a nearly incompressible layer
        (h/a)² ≪ 1 - 2ν. "≪" is read as "less than a tenth of".
        """
        h, nu = self.layer.h, self.layer.nu
        report = [Assumption("d/h", abs(depth) / h, 0.1, "the layer is strained beyond linearity")]
        if half_width > 0:
            report += [
                Assumption(
                    "u/h", abs(displacement) / h, 0.1, "the layer is strained beyond linearity"
                ),
                Assumption("h/a", h / half_width, 0.1, "the layer is not thin against the contact"),
                Assumption(
                    "(h/a)²/(1-2ν)",
                    (h / half_width) ** 2 / (1 - 2 * nu),
                    0.1,
                    "nearly incompressible: material flows sideways, springs are not independent",
                ),
            ]
        if self.slopes == "small":
            ratio = 2 * self.work_of_adhesion / self.gamma1 if self.gamma1 else math.inf
            if self.work_of_adhesion == 0:
                ratio = 0.0
            report += [
                Assumption(
                    "slope", abs(slope), 0.1, "surfaces are too steep for small-slope energies"
                ),
                Assumption("2w/γ₁", ratio, 0.1, "the contact angle is far from π"),
            ]
        return tuple(report)
