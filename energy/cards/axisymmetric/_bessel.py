"""The Bessel functions of the free surfaces, in combinations that neither overflow nor cancel.

With s = r/l: q = K₀/K₁ of the surface outside a contact, p = I₀/I₁ of a disc inside a ring. q obeys

    q' = q² + q/s − 1,    q = 1 − 1/(2s) + 3/(8s²) − ... for s → ∞,

where the three terms of q' cancel but for 1/(2s²); the coefficients follow from the equation.

Conventions: radii r are >= 0 and l is the elastocapillary length; u_a and u_b are the displacements
at an outer line of radius a and at the inner line, of radius b, of a ring, positive into the layer;
slopes are du/dr. Without tension l = 0 and s = ∞, where q = p = 1.

Imported: `unwrap` makes a number of an array without axes.
"""

import numpy as np
import scipy
from numpy.typing import ArrayLike

from energy.cards._checks import Array, unwrap

# From this s on the series of q in 1/s takes over. There the first of the terms that are left out
# is 6e-21, and 5e-18 in the series of s² q'; for larger s they are smaller.
_FAR = 25.0
_TERMS = 30


def _coefficients() -> Array:
    """c_n (_TERMS,) of q = Σ c_n s⁻ⁿ: c_0 = 1, 2c_n = −n c_{n−1} − Σ_{0<i<n} c_i c_{n−i}.

    The terms in s⁻ⁿ of q² + q/s − 1 − q' = 0, with q² = Σ_n s⁻ⁿ Σ_i c_i c_{n−i}.
    """
    c = np.ones(_TERMS)
    for n in range(1, _TERMS):
        c[n] = -0.5 * (n * c[n - 1] + c[1:n] @ c[n - 1 : 0 : -1])
    return c


_C = _coefficients()


def scaled(a: ArrayLike, ell: ArrayLike) -> Array:
    """s = a/l of radii a and elastocapillary lengths l = `ell`; ∞ where l = 0."""
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        return np.where(np.asarray(ell) > 0.0, np.asarray(a) / ell, np.inf)


def _series(s: Array, coefficients: Array) -> Array:
    """Σ c_n s⁻ⁿ where s >= _FAR, and numbers without a meaning elsewhere."""
    inverse = 1.0 / np.maximum(s, _FAR)
    if not (s >= _FAR).any():
        return np.asarray(inverse)  # saves the polynomial where no caller takes its value
    return np.asarray(np.polynomial.polynomial.polyval(inverse, coefficients))


def decay(s: ArrayLike) -> Array:
    """q = K₀(s)/K₁(s), from 0 at s = 0 to 1: the slope outside a line is −u_a/(l q)."""
    s = np.asarray(s, float)
    near = np.where((s > 0.0) & (s < _FAR), s, 1.0)  # 1 where the quotient is not taken
    quotient = np.where(s > 0.0, scipy.special.k0e(near) / scipy.special.k1e(near), 0.0)
    return unwrap(np.where(s < _FAR, quotient, _series(s, _C)))


def growth(s: ArrayLike) -> Array:
    """s² q'(s) = s² (q² − 1) + s q, which rises from 0 to ½."""
    s = np.asarray(s, float)
    near = np.minimum(s, _FAR)
    q = decay(near)
    series = -_series(s, _C[1:] * np.arange(1, _TERMS))  # s² q' = −Σ n c_n s⁻⁽ⁿ⁻¹⁾
    return unwrap(np.where(s < _FAR, near * (near * (q * q - 1.0) + q), series))


def disc(s: ArrayLike) -> Array:
    """1/p = I₁(s)/I₀(s), from 0 to 1: a free disc meets its line with the slope u_b/(l p)."""
    s = np.asarray(s, float)
    near = np.where(np.isfinite(s), s, 1.0)  # 1 where the quotient is not taken
    return unwrap(np.where(np.isfinite(s), scipy.special.i1e(near) / scipy.special.i0e(near), 1.0))
