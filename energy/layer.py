"""The elastic layer: a bed of independent springs, Eqs. (2) and (3), or its exact response.

`finite` and `positive` check an argument, whose name comes first, and return it as a float;
`option` refuses a word that is not among those that are known.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial.polynomial import polyval
from numpy.typing import ArrayLike

from energy.arrays import Array
from energy.checks import finite, option, positive

RESPONSES = ("springs", "layer")
# sinh y - y, y = 2qh, is summed as a power series up to this y, beyond which the difference loses
# no more than half a digit: sinh 1.6 - 1.6 = 0.78 with sinh 1.6 = 2.4.
_LARGEST_IN_SERIES = 1.6
# Its coefficients 1/3!, 1/5!, ..., 1/31!; the next term is at most 1.6³³/33! = 6e-31.
_SERIES = [1 / math.factorial(n) for n in range(3, 33, 2)]
# The integral for ℓ is taken over t = ln qh. Its integrand is of the size of exp(t) = 4e-18 at the
# lower end, and of 2t exp(-t) = 2e-20 at the upper one; the rounding of the sum is about 1e-13.
_LOWEST_LOG = -40.0
_HIGHEST_LOG = 50.0
# With half the step ℓ changes by less than 1e-13 h for ν <= 0.45, by 1e-12 h for ν = 0.49.
_LOG_STEP = 0.05
# Below this qh a parabola is taken for k(q)/k. What it leaves out, (0.05 ... 8 for ν <= 0.45) q⁴h⁴,
# is less than 1e-15; the difference k(q) - k would lose all digits.
_PARABOLIC = 1e-4


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
        """ValueError for numbers outside their ranges, and an unknown response."""
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
        """Stiffness per area k = Ẽ/h [stress/length], Eq. (3), of a uniform displacement."""
        return self.modulus / self.h

    def stiffness_at(self, q: ArrayLike) -> Array:
        """Stiffness per area of the surface displaced as cos qx.

        Springs: k, Eq. (3). The layer, with κ = qh, K = 3 - 4ν (K. L. Johnson, Contact Mechanics,
        1985, §5.8; in plane strain and about an axis alike):

            k(q) = (G/h) κ/(1-ν) [2K cosh 2κ + 1 + K² + 4κ²]/[2K sinh 2κ - 4κ]

        from k at q = 0 to that of a half-space, Gq/(1-ν).

        Parameters
        ----------
        q : array_like
            Wavenumbers [1/length], >= 0, of any shape.

        Returns
        -------
        ndarray
            k(q) [stress/length], of the shape of q.
        """
        q = np.asarray(q, float)
        if not self.exact:
            return np.full(q.shape, self.stiffness)
        return self.shear_modulus / self.h * relative_stiffness(self.nu, q * self.h)


def effective_length(layer: ElasticLayer, gamma1: float) -> float:
    """The length ℓ that stands for l in Eq. (16) of a layer with its exact response.

        ℓ = (1/π) ∫₀^∞ ln[(k(q) + γ₁q²)/k] dq/q²,    for springs ℓ = l = √(γ₁/k), Eq. (7).

    By the trapezoidal rule in ln q, where the integrand decays at both ends, so that the rule
    converges exponentially; for qh -> 0 the ratio is 1 + (l² - c₂h²) q².

    Parameters
    ----------
    layer : ElasticLayer
    gamma1 : float
        Surface tension γ₁ [energy/area], >= 0.

    Returns
    -------
    float
        ℓ [length], of either sign.

    Raises
    ------
    ValueError
        For an incompressible layer with its exact response, whose k is infinite.
    """
    if not layer.exact:
        return float(np.sqrt(gamma1 / layer.stiffness))
    if layer.nu == 0.5:
        raise ValueError(
            "nu = 0.5: an incompressible layer has no effective length, as no pressure displaces "
            "it uniformly; give a smaller Poisson's ratio"
        )
    log_qh = np.arange(_LOWEST_LOG, _HIGHEST_LOG, _LOG_STEP)
    qh = np.exp(log_qh)
    uniform = 2 * (1 - layer.nu) / (1 - 2 * layer.nu)  # k h/G
    tension = gamma1 / (layer.shear_modulus * layer.h)  # γ₁q² h/G = tension (qh)²
    # (k(q) + γ₁q²)/k - 1, and its leading term (l² - c₂h²) q² where that is all of it
    excess = (relative_stiffness(layer.nu, qh) - uniform + tension * qh**2) / uniform
    parabola = (tension / uniform - second_order(layer.nu)) * qh**2
    excess = np.where(qh < _PARABOLIC, parabola, excess)
    integrand = np.log1p(excess) / qh  # over t = ln qh, since dq/q² = h dt/(qh)
    return float(layer.h / np.pi * _LOG_STEP * integrand.sum())


def second_order(nu: Any) -> Any:
    """The coefficient c₂ of the stiffness of a bonded layer, k(q) = k (1 - c₂q²h² + O(q⁴h⁴)).

        c₂ = ν(4ν - 1)/(3(1 - ν)(1 - 2ν))

    Parameters
    ----------
    nu : float or ndarray
        Poisson's ratio, < ½.

    Returns
    -------
    float or ndarray
        c₂ [1]; 0 for ν = 0 and ¼.
    """
    return nu * (4 * nu - 1) / (3 * (1 - nu) * (1 - 2 * nu))


def relative_stiffness(nu: float, qh: ArrayLike) -> Array:
    """Stiffness k(q) of the bonded layer over G/h; `ElasticLayer.stiffness_at` has the formula.

    Numerator and denominator are multiplied by exp(-2qh), so that nothing overflows, and all terms
    that are added are positive.

    Parameters
    ----------
    nu : float
        Poisson's ratio.
    qh : array_like
        Wavenumber times thickness [1], >= 0, of any shape.

    Returns
    -------
    ndarray
        k(q) h/G [1], of the shape of qh; inf for qh = 0 and ν = ½.
    """
    kappa = np.asarray(qh, float)
    twice = 2 * kappa
    ratio = 3 - 4 * nu
    decay = np.exp(-twice)
    # (sinh 2κ - 2κ) exp(-2κ), the part of the denominator that cancels where κ is small
    in_series = np.minimum(twice, _LARGEST_IN_SERIES)
    series = in_series**3 * polyval(in_series**2, _SERIES) * decay
    difference = (1 - decay**2) / 2 - twice * decay
    remainder = np.where(twice < _LARGEST_IN_SERIES, series, difference)
    numerator = ratio * (1 + decay**2) + (1 + ratio**2 + 4 * kappa**2) * decay
    denominator = 2 * ratio * remainder + 8 * kappa * (1 - 2 * nu) * decay
    with np.errstate(divide="ignore", invalid="ignore"):
        found = kappa / (1 - nu) * numerator / denominator
        uniform = np.divide(2 * (1 - nu), 1 - 2 * nu)
    return np.where(kappa > 0, found, uniform)
