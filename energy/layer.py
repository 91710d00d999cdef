"""The elastic layer: a bed of independent springs, Eqs. (2) and (3)."""

from __future__ import annotations

from dataclasses import dataclass

from energy.checks import finite, positive


@dataclass(frozen=True)
class ElasticLayer:
    """Thin elastic layer bonded to a rigid base.

    E: Young's modulus [stress]; nu: Poisson's ratio in (-1, 0.5); h: thickness [length].
    ValueError for anything outside.
    """

    E: float
    nu: float
    h: float

    def __post_init__(self) -> None:
        positive("E", self.E)
        positive("h", self.h)
        if not -1 < finite("nu", self.nu) < 0.5:
            raise ValueError(
                f"nu = {self.nu!r} is outside (-1, 0.5); an incompressible layer has no "
                "Winkler limit: give a Poisson's ratio below 0.5"
            )

    @property
    def modulus(self) -> float:
        """Modulus of uniaxial compression Ẽ = E(1-ν)/((1+ν)(1-2ν)) [stress], Eq. (2)."""
        return self.E * (1 - self.nu) / ((1 + self.nu) * (1 - 2 * self.nu))

    @property
    def stiffness(self) -> float:
        """Stiffness per area k = Ẽ/h [stress/length], Eq. (3)."""
        return self.modulus / self.h
