"""The Bessel functions of the free surfaces, in combinations that neither overflow nor cancel.

With s = r/l: q = K₀/K₁ of the surface outside a contact, p = I₀/I₁ of a disc inside a ring. q obeys

    q' = q² + q/s − 1,    q = 1 − 1/(2s) + 3/(8s²) − ... for s → ∞,

where the three terms of q' cancel but for 1/(2s²); the coefficients follow from the equation.
"""

import numpy as np
import scipy
from numpy.typing import ArrayLike

from energy.cards._checks import Array, unwrap

_FAR = 25.0  # beyond it thirty terms of the series are exact to rounding
_TERMS = 30


def _coefficients() -> Array:
    """c_n of q = Σ c_n s⁻ⁿ: 2c_n = −n c_{n−1} − Σ_{0<i<n} c_i c_{n−i}."""
    c = np.ones(_TERMS)
    for n in range(1, _TERMS):
        c[n] = -0.5 * (n * c[n - 1] + c[1:n] @ c[n - 1 : 0 : -1])
    return c


_C = _coefficients()


def scaled(a: ArrayLike, ell: ArrayLike) -> Array:
    """s = a/l, ∞ without surface tension."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(np.asarray(ell) > 0.0, np.asarray(a) / ell, np.inf)


def _series(s: Array, coefficients: Array) -> Array:
    """Σ c_n s⁻ⁿ where s is large; where it nowhere is, anything."""
    far = 1.0 / np.maximum(s, _FAR)
    some = (s >= _FAR).any()
    return np.asarray(np.polynomial.polynomial.polyval(far, coefficients) if some else far)


def decay(s: ArrayLike) -> Array:
    """q = K₀(s)/K₁(s): the surface outside leaves its line with the slope −u_a/(l q)."""
    s = np.asarray(s, float)
    near = np.where((s > 0.0) & (s < _FAR), s, 1.0)
    outside = np.where(s > 0.0, scipy.special.k0e(near) / scipy.special.k1e(near), 0.0)
    return unwrap(np.where(s < _FAR, outside, _series(s, _C)))


def growth(s: ArrayLike) -> Array:
    """s² q'(s), which rises from 0 to ½."""
    s = np.asarray(s, float)
    near = np.minimum(s, _FAR)
    q = decay(near)
    series = -_series(s, _C[1:] * np.arange(1, _TERMS))
    return unwrap(np.where(s < _FAR, near * (near * (q * q - 1.0) + q), series))


def disc(s: ArrayLike) -> Array:
    """1/p = I₁(s)/I₀(s): a free disc meets the line around it with the slope u_b/(l p)."""
    s = np.asarray(s, float)
    near = np.where(np.isfinite(s), s, 1.0)
    return unwrap(np.where(np.isfinite(s), scipy.special.i1e(near) / scipy.special.i0e(near), 1.0))
