"""The depths at which an equilibrium of lines disappears, solved for."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.rests import Rests
from discretization.roots import bracketed

Array = NDArray[np.float64]
CLOSE = 1e-14  # of the size of depths: depths that close enclose an event, D is not known better
_CURVED = 1e-4  # of the room between two lines, or of l, for the change of the stiffness
_NEAR = 1e-4  # of that: the depth of a fold is good to the square of its place
_FOLDED = 12  # steps of Newton's method to a fold


def fold(rests: Rests, lines: Array, way: int) -> float:
    """The depth at which the equilibrium of these lines (2,) disappears ahead; nan: not found.

    There both rest at one depth, and the stiffness against moving them is zero: Newton's
    method for both, from lines not far from there. The depth is good to the square of the step.
    """
    x, inner = lines.copy(), np.isfinite(lines)
    room = rests.rooms(lines[None], way)
    h, near = _CURVED * min(float(x[1] - x[0]), rests.length), False
    for _ in range(_FOLDED):
        step, depth = _step(rests, x, room, h, way)
        if near:
            return depth
        x[inner] -= step
        if not ((room[0, 0] <= x) & (x <= room[1, 0]))[inner].all() or not x[0] < x[1]:
            break
        near = bool(np.abs(step).max() <= _NEAR * h)
    return math.nan


def closing(rests: Rests, lines: Array) -> tuple[float, float]:
    """Where the contact between two surfaces (2, 2) closes, and at which depth; nan: not known.

    There both its lines rest at the same place and depth. The lines that they face stay.
    """
    start, end = float(lines[0, 1]), float(lines[1, 0])

    def at(x: float) -> Array:
        return rests.ahead(np.array([(lines[0, 0], x), (x, lines[1, 1])]), -1)[[0, 1], [1, 0]]

    def apart(x: float) -> float:
        return float(np.subtract(*at(x)))

    if not start < end or not apart(start) > 0 > apart(end):
        return math.nan, math.nan
    x = bracketed(apart, end, start)
    return x, float(at(x).mean())


def _step(rests: Rests, x: Array, room: Array, h: float, way: int) -> tuple[Array, float]:
    """A step of Newton's method towards a fold (1 or 2,), nan: none, and D of the lines."""
    inner, beside = np.isfinite(x), h * np.array([(0.0, 0.0), (1.0, 0.0), (0.0, 1.0)])
    value, rates = rests.rest_depths((x + beside)[:, None], np.repeat(room, 3, axis=1), way, True)
    assert rates is not None
    rate = rates[:, 0]
    if inner.all():
        stiff = rate[:, 0, 0] * rate[:, 1, 1] - rate[:, 0, 1] * rate[:, 1, 0]
        off = np.array([value[0, 0, 0] - value[0, 0, 1], stiff[0]])
        matrix = np.array([rate[0, 0] - rate[0, 1], (stiff[1:] - stiff[0]) / h])
    else:
        own = int(inner[1])
        stiff = rate[:, own, own]
        off, matrix = stiff[:1], (stiff[[[1 + own]]] - stiff[0]) / h
    with np.errstate(all="ignore"):
        solvable = np.isfinite(matrix).all() and np.linalg.det(matrix) != 0
    depth = float(value[0, 0][inner].mean())
    return np.linalg.solve(matrix, off) if solvable else np.full(off.size, math.nan), depth
