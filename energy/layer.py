"""The elastic layer: a bed of independent springs, Eqs. (2) and (3), or its exact response."""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike

from energy.arrays import Array
from energy.checks import finite, option, positive

RESPONSES = ("springs", "layer")
_SERIES = 1.6  # 2qh, up to which sinh 2qh - 2qh is summed, as its terms cancel
_TERMS = [1 / math.factorial(n) for n in range(3, 33, 2)]
_FLATTEST = -40.0
_STEEPEST = 50.0
_STEP = 0.05  # of ln qh
_SMALL = 1e-4  # qh, below which the ratio to springs is a parabola to rounding


@dataclass(frozen=True)
class ElasticLayer:
    """Elastic layer bonded to a rigid base, without shear stress on its surface.

    Parameters
    ----------
    E : float
        Young's modulus [stress], > 0.
    nu : float
        Poisson's ratio, between -1 and 0.5; 0.5 itself with response "layer" alone.
    h : float
        Thickness [length], > 0.
    response : {"springs", "layer"}
        "springs" is the limit of a thin, compressible layer, "layer" exact linear elasticity.

    Raises
    ------
    ValueError
        For a number outside these ranges, and an unknown response.

    Notes
    -----
    Springs have the stiffness per area k = Ẽ/h with Ẽ = E(1-ν)/((1+ν)(1-2ν)), Eqs. (2) and (3);
    `stiffness_at` has that of the layer.

    Examples
    --------
    >>> from energy import ElasticLayer
    >>> print(f"{ElasticLayer(E=2.5e3, nu=0.3, h=5e-6).stiffness:.4g}")  # Pa/m
    6.731e+08
    """

    E: float
    nu: float
    h: float
    response: str = "springs"

    def __post_init__(self) -> None:
        positive("E", self.E)
        if self.h == np.inf:
            raise ValueError(
                f"h = {self.h!r} is a half-space; take h much larger than the contact, with "
                "response='layer'"
            )
        positive("h", self.h)
        option("response", self.response, RESPONSES)
        if not -1 < finite("nu", self.nu) <= 0.5:
            raise ValueError(f"nu = {self.nu!r} is outside (-1, 0.5]; give a Poisson's ratio")
        if self.nu == 0.5 and not self.exact:
            raise ValueError(
                f"nu = {self.nu!r} is outside (-1, 0.5): an incompressible layer has no springs; "
                "give response='layer' or a smaller Poisson's ratio"
            )

    @property
    def exact(self) -> bool:
        """Whether the response is that of linear elasticity."""
        return self.response == "layer"

    @property
    def shear_modulus(self) -> float:
        """G = E/(2(1+ν)) [stress]."""
        return self.E / (2 * (1 + self.nu))

    @property
    def modulus(self) -> float:
        """Modulus of uniaxial compression Ẽ = E(1-ν)/((1+ν)(1-2ν)) [stress], Eq. (2); inf for ½."""
        if self.nu == 0.5:
            return np.inf
        return self.E * (1 - self.nu) / ((1 + self.nu) * (1 - 2 * self.nu))

    @property
    def stiffness(self) -> float:
        """Stiffness per area k = Ẽ/h [stress/length], Eq. (3): what no variation meets."""
        return self.modulus / self.h

    def stiffness_at(self, q: ArrayLike) -> Array:
        """Stiffness per area k(q) [stress/length] of the surface displaced as cos qx, q >= 0.

        Springs: k, Eq. (3). The layer, with κ = qh, K = 3 - 4ν (K. L. Johnson, Contact Mechanics,
        1985, §5.8; in plane strain and about an axis alike):

            k(q) = (G/h) κ/(1-ν) [2K cosh 2κ + 1 + K² + 4κ²]/[2K sinh 2κ - 4κ]

        from k at q = 0 to that of a half-space, Gq/(1-ν). q [1/length] of any shape.
        """
        q = np.asarray(q, float)
        if not self.exact:
            return np.full(q.shape, self.stiffness)
        return self.shear_modulus / self.h * relative_stiffness(self.nu, q * self.h)


def effective_length(layer: ElasticLayer, gamma1: float) -> float:
    """ℓ = (1/π) ∫₀^∞ ln[(k(q) + γ₁q²)/k] dq/q² [length], l for springs.

    By the trapezoidal rule in ln q, where the integrand decays both ways; for qh -> 0 the ratio is
    1 + (l² - c₂h²) q². ValueError for an incompressible layer, whose k is infinite.
    """
    if not layer.exact:
        return float(np.sqrt(gamma1 / layer.stiffness))
    if layer.nu == 0.5:
        raise ValueError(
            "nu = 0.5: an incompressible layer has no effective length, as without variation "
            "nothing displaces it; give a smaller Poisson's ratio"
        )
    t = np.arange(_FLATTEST, _STEEPEST, _STEP)
    qh = np.exp(t)
    still = 2 * (1 - layer.nu) / (1 - 2 * layer.nu)
    tension = gamma1 / (layer.shear_modulus * layer.h)
    more = (relative_stiffness(layer.nu, qh) - still + tension * qh**2) / still
    flat = (tension / still - second_order(layer.nu)) * qh**2
    more = np.where(qh < _SMALL, flat, more)
    return float(layer.h / np.pi * _STEP * (np.log1p(more) / qh).sum())


def second_order(nu: Any) -> Any:
    """c₂ = ν(4ν - 1)/(3(1 - ν)(1 - 2ν)) of the bonded layer, k(q) = k (1 - c₂q²h²); 0 for 0, ¼."""
    return nu * (4 * nu - 1) / (3 * (1 - nu) * (1 - 2 * nu))


def relative_stiffness(nu: float, qh: ArrayLike) -> Array:
    """k(q) h/G of the bonded layer, sums of positive numbers only."""
    kappa = np.asarray(qh, float)
    ratio = 3 - 4 * nu
    decay = np.exp(-2 * kappa)
    part = np.minimum(2 * kappa, _SERIES)
    series = part**3 * polyval(part**2, _TERMS) * decay  # (sinh 2κ - 2κ) exp(-2κ)
    far = (1 - decay**2) / 2 - 2 * kappa * decay
    bulging = np.where(2 * kappa < _SERIES, series, far)
    above = ratio * (1 + decay**2) + (1 + ratio**2 + 4 * kappa**2) * decay
    below = 2 * ratio * bulging + 8 * kappa * (1 - 2 * nu) * decay
    with np.errstate(divide="ignore", invalid="ignore"):
        found = kappa / (1 - nu) * above / below
        still = np.divide(2 * (1 - nu), 1 - 2 * nu)
    return np.where(kappa > 0, found, still)
