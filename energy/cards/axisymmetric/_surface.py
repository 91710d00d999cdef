"""The whole surface: what the indenter prescribes in contact, the decaying surface outside.

Displacements are positive downwards, into the layer; x is a distance from the axis, of either sign.

Imported: `scaled(a, l)` is s = a/l, and ∞ where l = 0. `unwrap` makes a number of an array without
axes.
"""

import numpy as np
import scipy

from energy.cards._checks import Array, unwrap
from energy.cards.axisymmetric._bessel import scaled


def joined(x: Array, a: Array, inside: Array, u_a: Array, ell: Array) -> Array:
    """Displacement at x of a surface in contact on |x| <= a; all arguments broadcast.

    `inside` for |x| <= a, u_a K₀(|x|/l)/K₀(a/l) beyond, with u_a the displacement at the line and
    l = `ell`; l = 0 gives a step to 0 at |x| = a.
    """
    r = np.maximum(np.abs(x), a)
    # k0e(s) is exp(s) K₀(s), which does not vanish where K₀ does. l = 0 makes NaN, not taken.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        at_r = scipy.special.k0e(scaled(r, ell))
        at_line = scipy.special.k0e(scaled(a, ell))
        outside = u_a * at_r / at_line * np.exp(-(r - a) / ell)
    return unwrap(np.where(r > a, np.where(ell > 0.0, outside, 0.0), inside))
