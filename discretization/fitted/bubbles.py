"""Small gaps at re-entrant corners of a contact, below what a lattice resolves (small slopes).

A surface that is pressed with u = g > 0 into a corner at which f' falls by J opens a gap there if
J > 2√(2w/γ₁): its two lines carry √(2w/γ₁) each, and the curvature u/l² of the free surface has to
make up for the rest, so they are about (J - 2√(2w/γ₁)) l²/(2g) away from the corner.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from energy import Scene

Array = NDArray[np.float64]
_ASIDE = 1e-9


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
    aside = _ASIDE * scene.elastocapillary_length
    fall = scene.indenter.slope(corners - aside) - scene.indenter.slope(corners + aside)
    rest = fall - 2 * math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
    g = depth - scene.indenter.height(corners)
    opens = (rest > 0) & (g > 0)
    at = corners[opens]
    reach = rest[opens] * scene.elastocapillary_length**2 / (2 * g[opens])
    return np.column_stack([at - reach, at + reach])
