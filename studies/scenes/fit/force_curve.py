"""A measured force–depth curve: its turning points, its noise, its points in contact."""

import math
from itertools import pairwise
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from studies.shared import Array

CLEAR = 5.0  # times the noise: a force, or a way back, that is there
ROUNDING = 1e-9  # of a way back, relative to the range of depths


class Curve(NamedTuple):
    """Depth [m] and force per length [N/m] in the order measured, (n,) each."""

    depth: Array
    force: Array


def noise(force: Array) -> float:
    """Standard deviation of the noise on a smooth curve with few jumps, from third differences.

    0 for fewer than 8 points, which do not tell.
    """
    if force.size < 8:
        return 0.0
    return float(np.median(np.abs(np.diff(force, 3)))) / (0.6745 * math.sqrt(20))


def turning_points(depth: Array) -> tuple[int, ...]:
    """Indices at which loading turns into unloading or back, by more than the depth's own noise."""
    least = max(CLEAR * noise(depth), ROUNDING * float(np.ptp(depth)))
    found: list[int] = []
    far, sense = 0, 0  # the point farthest in the present direction, +1 for growing depth
    for i, value in enumerate(depth.tolist()):
        beyond = value - float(depth[far])
        if sense * beyond >= 0 and sense:
            far = i
        elif abs(beyond) > least:
            if sense:
                found.append(far)
            far, sense = i, 1 if beyond > 0 else -1
    return tuple(found)


def loading(depth: Array) -> NDArray[np.bool_]:
    """Whether a point lies on a branch of growing depth (n,); a turning point ends its branch."""
    ends = [0, *turning_points(depth), depth.size - 1]
    grows = np.zeros(depth.size, bool)
    for start, end in pairwise(ends):
        grows[start + (start > 0) : end + 1] = depth[end] > depth[start]
    return grows


def contacts(curve: Curve) -> tuple[slice, ...]:
    """The pieces of a curve with a contact each: cut where the depth turns and no force is left."""
    weak = np.abs(curve.force) <= CLEAR * noise(curve.force)
    grows = loading(curve.depth)
    cuts = [i for i in turning_points(curve.depth) if weak[i] and not grows[i]]
    return tuple(slice(a, b) for a, b in pairwise([0, *cuts, curve.depth.size]))


def in_contact(curve: Curve) -> NDArray[np.bool_]:
    """All points but those without force at the beginning and at the end of each contact (n,)."""
    used = np.zeros(curve.force.size, bool)
    clear = np.flatnonzero(np.abs(curve.force) > CLEAR * noise(curve.force))
    for piece in contacts(curve):
        own = clear[(clear >= piece.start) & (clear < piece.stop)]
        if own.size:
            used[own[0] : own[-1] + 1] = True
    return used


class Mark(NamedTuple):
    """A depth between two points at which contact begins ("touch") or is lost ("detachment").

    error: standard deviation of a depth that may lie anywhere between them.
    """

    kind: str
    depth: float
    error: float


def marks(curve: Curve) -> tuple[Mark, ...]:
    """The ends of contact that the curve shows: pulled on one side, without force on the other."""
    used, clear = in_contact(curve), 2 * CLEAR * noise(curve.force)
    found = []
    for piece in contacts(curve):
        inside = piece.start + np.flatnonzero(used[piece])
        ends = (("touch", 0, -1), ("detachment", -1, 1)) if inside.size else ()
        for kind, at, step in ends:
            near, beside = int(inside[at]), int(inside[at]) + step
            if piece.start <= beside < piece.stop and curve.force[near] < -clear:
                a, b = sorted((curve.depth[near], curve.depth[beside]))
                if b > a:
                    found.append(Mark(kind, float(a + b) / 2, float(b - a) / math.sqrt(12)))
    return tuple(found)
