"""The whole surface: what the indenter prescribes in contact, the decaying tail outside."""

import numpy as np

from energy.cards._checks import Array, unwrap


def joined(x: Array, a: Array, inside: Array, u_a: Array, ell: Array) -> Array:
    """`inside` for |x| <= a, u_a exp(−(|x| − a)/l) beyond; l = 0 gives a step at |x| = a."""
    beyond = np.maximum(np.abs(x) - a, 0.0)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore", under="ignore"):
        tail = u_a * np.exp(-beyond / ell)
    return unwrap(np.where(beyond > 0.0, tail, inside))
