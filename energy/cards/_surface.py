"""The whole surface: what the indenter prescribes in contact, the decaying tail outside.

Displacements are positive downwards, into the layer.

Imported: `unwrap` makes a number of an array without axes.
"""

import numpy as np

from energy.cards._checks import Array, unwrap


def joined(x: Array, a: Array, inside: Array, u_a: Array, ell: Array) -> Array:
    """Displacement at positions x of a surface in contact on |x| <= a; all arguments broadcast.

    `inside` for |x| <= a, u_a exp(−(|x| − a)/l) beyond, with u_a the displacement at the line and
    l = `ell`, both as lengths; l = 0 gives a step to 0 at |x| = a.
    """
    beyond = np.maximum(np.abs(x) - a, 0.0)
    # l = 0 makes exp(−∞) = 0 outside, and 0/0 inside, where the value is not taken.
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        tail = u_a * np.exp(-beyond / ell)
    return unwrap(np.where(beyond > 0.0, tail, inside))
