"""The three surface energies, the work of adhesion (1) and Young's angle (8).

`finite` and `not_negative` check an argument, whose name comes first, and return it as a float.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from energy.checks import finite, not_negative

# A work of adhesion below this share of the largest energy is taken for zero: three energies that
# are each rounded by 1.1e-16, and a difference of at most twice the largest, leave 5.6e-16.
_ROUNDING = 1e-15
# From this w/γ₁ on a message asks whether the two have changed places: measured contact angles give
# w < 2γ₁, and the model needs w well below that.
_DOUBTFUL = 10


@dataclass(frozen=True)
class SurfaceEnergies:
    """Specific surface energies [energy/area], of which γ₁ and the work of adhesion matter.

    Parameters
    ----------
    gamma1, gamma2, gamma12 : float
        Of the layer's free surface (its surface tension), of the indenter, of their interface.

    Attributes
    ----------
    given_by_work : bool
        Whether made by `from_work`: the other two energies are then unknown.

    Raises
    ------
    ValueError
        If gamma1 is negative or the work of adhesion would be.

    Notes
    -----
    w = γ₁ + γ₂ - γ₁₂, Eq. (1), and Young's law γ₁ cos θ = γ₂ - γ₁₂, Eq. (8).

    Examples
    --------
    >>> from energy import SurfaceEnergies
    >>> surfaces = SurfaceEnergies(gamma1=0.07, gamma2=0.03, gamma12=0.06)
    >>> print(f"w = {surfaces.work_of_adhesion:.3g}, θ = {surfaces.contact_angle:.4g} rad")
    w = 0.04, θ = 2.014 rad
    """

    gamma1: float
    gamma2: float
    gamma12: float
    given_by_work: bool = field(default=False, init=False, compare=False)

    def __post_init__(self) -> None:
        """ValueError for a negative tension or work of adhesion."""
        not_negative("gamma1", self.gamma1)
        finite("gamma2", self.gamma2)
        finite("gamma12", self.gamma12)
        if self.work_of_adhesion < 0:
            raise ValueError(
                f"gamma12 = {self.gamma12!r} exceeds gamma1 + gamma2 by "
                f"{-self.work_of_adhesion!r}: contact would cost energy and the surfaces would "
                "never stick; give gamma12 <= gamma1 + gamma2"
            )

    @classmethod
    def from_work(cls, gamma1: float, w: float) -> SurfaceEnergies:
        """Surface energies with this tension and work of adhesion.

        Parameters
        ----------
        gamma1 : float
            Surface tension γ₁ of the layer [energy/area], >= 0.
        w : float
            Work of adhesion [energy/area], >= 0; 0 for surfaces that do not stick.

        Raises
        ------
        ValueError
            If one is negative.

        Notes
        -----
        γ₁₂ = γ₁, so that γ₂ = w exactly.

        Examples
        --------
        >>> from energy import SurfaceEnergies
        >>> SurfaceEnergies.from_work(gamma1=0.07, w=6e-5)
        SurfaceEnergies.from_work(gamma1=0.07, w=6e-05)
        """
        made = cls(gamma1=gamma1, gamma2=not_negative("w", w), gamma12=gamma1)
        object.__setattr__(made, "given_by_work", True)
        return made

    @property
    def given(self) -> dict[str, float]:
        """The numbers it was made of, by name: gamma1 and w, or gamma1, gamma2 and gamma12."""
        if self.given_by_work:
            return {"gamma1": self.gamma1, "w": self.gamma2}
        return {"gamma1": self.gamma1, "gamma2": self.gamma2, "gamma12": self.gamma12}

    def __repr__(self) -> str:
        """As it was made: from γ₁ and w, or from three energies."""
        maker = "SurfaceEnergies.from_work" if self.given_by_work else "SurfaceEnergies"
        return f"{maker}({', '.join(f'{name}={value!r}' for name, value in self.given.items())})"

    @property
    def work_of_adhesion(self) -> float:
        """w = γ₁ + γ₂ - γ₁₂ [energy/area], Eqs. (1) and (17); zero is the non-adhesive case (34).

        A sum that vanishes to rounding counts as zero.
        """
        w = (self.gamma1 - self.gamma12) + self.gamma2
        if self.gamma1 == self.gamma12:  # as `from_work` makes them: nothing was rounded
            return w
        largest = max(self.gamma1, abs(self.gamma2), abs(self.gamma12))
        return 0.0 if abs(w) <= _ROUNDING * largest else w

    @property
    def doubt(self) -> str:
        """The end of a message about w > 2γ₁ where the two may have changed places, else ""."""
        w = self.work_of_adhesion
        gamma1 = self.gamma1
        if not w > _DOUBTFUL * gamma1 > 0:
            return ""
        return f"; w is {w / gamma1:.3g} gamma1: are the two swapped?"

    @property
    def angle_deficit(self) -> float:
        """π - θ [rad] of Young's law without cancellation: 2 asin √(w/(2γ₁)), Eq. (8).

        Raises
        ------
        ValueError
            For γ₁ = 0 and for w > 2γ₁, where there is no angle.
        """
        w = self.work_of_adhesion
        gamma1 = self.gamma1
        if w > 2 * gamma1 or gamma1 == 0:
            raise ValueError(
                f"w = {w!r} with gamma1 = {gamma1!r} has no Young angle (cos θ = w/γ₁ - 1 > 1 or "
                f"undefined); give 0 < gamma1 and w <= 2 gamma1{self.doubt}"
            )
        return 2 * math.asin(math.sqrt(w / (2 * gamma1)))

    @property
    def contact_angle(self) -> float:
        """Young's contact angle θ [rad]: γ₁₂ + γ₁ cos θ - γ₂ = 0, Eq. (8); π for w = 0 (35).

        Raises
        ------
        ValueError
            As `angle_deficit`.
        """
        return math.pi - self.angle_deficit

    @property
    def small_slope_deficit(self) -> float:
        """π - θ [rad] for small slopes: √(2w/γ₁), Eq. (15).

        Raises
        ------
        ValueError
            For γ₁ = 0, where there is no angle.
        """
        if self.gamma1 == 0:
            raise ValueError("gamma1 = 0 has no contact angle; give gamma1 > 0")
        return math.sqrt(2 * self.work_of_adhesion / self.gamma1)
