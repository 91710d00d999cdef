"""Small gaps at re-entrant corners of a contact, below what a lattice resolves (small slopes).

A surface that is pressed with u = g > 0 into a corner at which f' falls by J may span it. A short
span of length b saves γ₁J²b/8 of surface energy and costs the adhesion w b, so a gap opens where
J > √(8w/γ₁), and grows until the springs pull as strongly: its lines are then about
(J - √(8w/γ₁)) l²/(2g) away from the corner. This only says where to look for them.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from energy import Scene

Array = NDArray[np.float64]


def parted(scene: Scene, depth: float, contacts: Array) -> Array:
    """Contacts (m, 2) with such gaps left out, which merge where they overlap."""
    corners, found = np.asarray(scene.indenter.corners, float), []
    for left, right in contacts.tolist():
        inside = corners[(corners > left) & (corners < right)]
        gaps = _gaps(scene, depth, inside)
        gaps = gaps[(gaps[:, 0] > left) & (gaps[:, 1] < right)]
        apart = np.r_[True, gaps[1:, 0] > np.maximum.accumulate(gaps[:-1, 1])] if len(gaps) else []
        starts = np.flatnonzero(apart)
        ends = np.maximum.reduceat(gaps[:, 1], starts) if len(gaps) else gaps[:, 1]
        found.append(np.column_stack([np.r_[left, ends], np.r_[gaps[starts, 0], right]]))
    return np.concatenate(found) if found else contacts


def _gaps(scene: Scene, depth: float, corners: Array) -> Array:
    """Both lines of the gap at each corner that opens (n, 2)."""
    if not corners.size:
        return np.empty((0, 2))
    fall = scene.indenter.slope_beside(corners, -1) - scene.indenter.slope_beside(corners, 1)
    rest = fall - math.sqrt(8 * scene.work_of_adhesion / scene.gamma1)
    g = depth - scene.indenter.height(corners)
    opens = (rest > 0) & (g > 0)
    at = corners[opens]
    reach = rest[opens] * scene.elastocapillary_length**2 / (2 * g[opens])
    return np.column_stack([at - reach, at + reach])
