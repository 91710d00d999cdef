"""Where an increasing function of a radius passes zero.

Imported: `unwrap` makes a number of an array without axes.
"""

from collections.abc import Callable

import numpy as np

from energy.cards._checks import Array, unwrap

_LEAST = 1e-250  # of the upper end: a root below it is returned as 0
_HALVINGS = 72  # of ln(1/_LEAST) = 576, down to 1e-19: below the rounding of ln x
_AT_THE_LOWER_END = 1e-13  # in ln x, its rounding near ln(_LEAST)


def crossing(function: Callable[[Array], Array], lower: Array, upper: Array) -> Array:
    """The position at which a function becomes positive, by bisection in ln x.

    Parameters
    ----------
    function : callable
        Of an array of positions; it changes from < 0 to >= 0 once.
    lower, upper : ndarray
        Ends of the intervals, >= 0; an interval with `upper` = 0 has the root 0.

    Returns
    -------
    float or ndarray
        The lower end where the function is not negative there, and 0 where the position is less
        than 1e-250 of the upper end.
    """
    lower, upper = np.broadcast_arrays(np.asarray(lower, float), np.asarray(upper, float))
    floor = np.maximum(lower, _LEAST * upper)
    wide = upper > 0.0
    log_floor = np.log(np.where(wide, floor, 1.0))
    log_low = log_floor
    log_high = np.log(np.where(wide, upper, 1.0))
    for _ in range(_HALVINGS):
        middle = 0.5 * (log_low + log_high)
        below = function(np.exp(middle)) < 0.0
        log_low = np.where(below, middle, log_low)
        log_high = np.where(below, log_high, middle)
    # An upper end that has come down to the floor says that the function was never negative.
    above_floor = log_high > log_floor + _AT_THE_LOWER_END
    root = np.where(above_floor, np.exp(log_high), lower)
    return unwrap(np.where(wide, root, 0.0))
