"""What double precision leaves, in one place, and what a user's own height(x) is off by, measured.

The arithmetic of a height may lose digits that the height itself has not: cosh(x) - 1 is a multiple
of 2⁻⁵³ however small x is. Over a short step the height must change by the integral of the slope,

    f(x + s) - f(x) = ∫ f' dx,    s = 2⁻¹⁰ of a panel,

which Gauss points give exactly for a profile that is smooth on s. What the two differ by is the
rounding of f. Corners nobody declared fall on few of the steps, whose differences are left out.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from energy import Indenter

Array = NDArray[np.float64]
EPSILON = float(np.finfo(float).eps)
ROUNDING = 16 * EPSILON  # of the sizes of the terms that a result is summed from, a dozen or so
_STEPS = 32  # steps of a contact in which heights are read
_SHORT = 2.0**-10  # of a panel: a slope is smooth there, a height changes by more than its rounding
_LEFT_OUT = 2  # of the steps, those with the largest differences
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(6)
_GOLDEN = 0.6180339887498949  # irrational: no period of the profile falls on all steps


def height_rounding(indenter: Indenter, ends: Array) -> float:
    """How far f(x) is off by its own arithmetic [length], on panels with ends (n, 2).

    0 for indenters that say where they are smooth: their heights are computed without such a loss.
    """
    if indenter.complete or not (ends[:, 1] > ends[:, 0]).any():
        return 0.0
    wide = ends[ends[:, 1] > ends[:, 0]]
    lo, hi = wide[np.arange(_STEPS) * len(wide) // _STEPS].T
    start = lo + (hi - lo) * (1 - _SHORT) * (np.arange(_STEPS) * _GOLDEN % 1)
    stop = np.minimum(start + _SHORT * (hi - lo), hi)
    x = start[:, None] + np.outer(stop - start, (_POINTS + 1) / 2)
    rise = (np.asarray(indenter.slope(x), float) @ _WEIGHTS) * ((stop - start) / 2)
    step = np.asarray(indenter.height(stop), float) - np.asarray(indenter.height(start), float)
    return float(np.sort(np.abs(step - rise))[-1 - _LEFT_OUT])
