"""A measured force–depth curve: its turning points, its noise, its points in contact."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
CLEAR = 5.0  # times the noise: a force, or a way back, that is there


class Curve(NamedTuple):
    """Depth [m] and force per length [N/m] in the order measured, (n,) each."""

    depth: Array
    force: Array


def noise(force: Array) -> float:
    """Standard deviation of the noise on a smooth curve with few jumps, from third differences."""
    if force.size < 8:
        return 0.0
    return float(np.median(np.abs(np.diff(force, 3)))) / (0.6745 * math.sqrt(20))


def in_contact(curve: Curve) -> NDArray[np.bool_]:
    """All points but those without force at the beginning and at the end (n,)."""
    clear = np.flatnonzero(np.abs(curve.force) > CLEAR * noise(curve.force))
    used = np.zeros(curve.force.size, bool)
    if clear.size:
        used[clear[0] : clear[-1] + 1] = True
    return used


class Mark(NamedTuple):
    """A depth between two points at which contact begins ("touch") or is lost ("letting go").

    error: standard deviation of a depth that may lie anywhere between them.
    """

    kind: str
    depth: float
    error: float


def marks(curve: Curve) -> tuple[Mark, ...]:
    """The ends of contact that the curve shows: pulled on one side, without force on the other."""
    used, clear = np.flatnonzero(in_contact(curve)), 2 * CLEAR * noise(curve.force)
    found = []
    for kind, inside, outside in (("touch", 0, -1), ("letting go", -1, 1)):
        near = int(used[inside]) if used.size else 0
        if used.size and 0 <= near + outside < curve.depth.size and curve.force[near] < -clear:
            a, b = sorted((curve.depth[near], curve.depth[near + outside]))
            if b > a:
                found.append(Mark(kind, float(a + b) / 2, float(b - a) / math.sqrt(12)))
    return tuple(found)
