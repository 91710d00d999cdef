"""Where an increasing function of a radius passes zero."""

from collections.abc import Callable

import numpy as np

from energy.cards._checks import Array, unwrap

_LEAST = 1e-250  # of the upper end: a root below it is returned as 0
_HALVINGS = 72  # of ln(1/_LEAST), down to rounding


def crossing(function: Callable[[Array], Array], lower: Array, upper: Array) -> Array:
    """x in [lower, upper] where function(x) changes from < 0 to >= 0, by bisection in ln x.

    The lower end where it is not negative there, 0 if that is less than 1e-250 of the upper end.
    """
    lower, upper = np.broadcast_arrays(np.asarray(lower, float), np.asarray(upper, float))
    floor = np.maximum(lower, _LEAST * upper)
    some = upper > 0.0
    lo, hi = (np.log(np.where(some, end, 1.0)) for end in (floor, upper))
    for _ in range(_HALVINGS):
        middle = 0.5 * (lo + hi)
        below = function(np.exp(middle)) < 0.0
        lo = np.where(below, middle, lo)
        hi = np.where(below, hi, middle)
    found = np.where(hi > np.log(np.where(some, floor, 1.0)) + 1e-13, np.exp(hi), lower)
    return unwrap(np.where(some, found, 0.0))
