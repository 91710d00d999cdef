"""The whole surface: what the indenter prescribes in contact, the decaying surface outside."""

import numpy as np
import scipy

from energy.cards._checks import Array, unwrap
from energy.cards.axisymmetric._bessel import scaled


def joined(x: Array, a: Array, inside: Array, u_a: Array, ell: Array) -> Array:
    """`inside` for |x| <= a, u_a K₀(|x|/l)/K₀(a/l) beyond; l = 0 gives a step at |x| = a."""
    r = np.maximum(np.abs(x), a)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        there, at_line = (scipy.special.k0e(scaled(place, ell)) for place in (r, a))
        tail = u_a * there / at_line * np.exp(-(r - a) / ell)
    return unwrap(np.where(r > a, np.where(ell > 0.0, tail, 0.0), inside))
