"""How far free surfaces are from the profile, those of many states at once.

The gap v = u - d + f is read at the samples of the profile that a surface may come near to, and at
its lines; minima are those of the cubics through v and v' there, and exact where v may be small.

Conventions
-----------
Depths d and displacements u grow downwards, heights f of the profile upwards: v is 0 in contact,
positive where the surface is clear of the profile, and negative where it would be in it. A row of
`lines` is a free surface with its left line in column 0 and its right line in column 1 [length],
-inf and inf where a tail has none. `own` has, for each of m places or minima, the number of the row
that it belongs to; the places of a row stand next to each other, from left to right.

`minima_between` has the minima of the cubics between samples, `Minima`: the interval of each, `lo`
and `hi` between which v' grows (equal at a corner), where it is (`at`), v'' there (`bend`, nan at a
corner), v (`value`), and what that may be off by (`off`). `crossings` are zeros of functions, here
of v', between such places. `Resolved.one_sided(x, side)` has f and f' on one side of a corner, and
`Equations.surface` u and u' of free surfaces. δ₀ is `scene.opened.critical_separation`, with the
work of adhesion of opening.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from discretization.refine.equations import Equations
from discretization.roots import Minima, crossings, minima_between
from energy.arrays import Array, Indices

# Of δ₀: samples of the profile that much above both lines are never touched. 1/32 or 1/8 changes
# none of 18 random states and paths by 1e-9 (`python -m tests.sensitivity
# discretization.refine.clearance`).
_HIGHER = 1 / 16
_LEAST = 1e-300  # more than 0: only its sign counts, and it is no subnormal number
# Of how v' varies around a minimum of v: v' there. v is off by the square, 1e-12 of how it varies.
_LEVEL = 1e-6


class Dips(NamedTuple):
    """Minima of the gap v = u - d + f between free surfaces and the profile.

    Attributes
    ----------
    own : ndarray of int (m,)
        Number of the surface of each.
    places, gaps : ndarray (m,)
        Where, and v there [length].
    off : ndarray (m,)
        What v may be off by, as it is that of a cubic [length]; 0 where it is exact.
    """

    own: Indices
    places: Array
    gaps: Array
    off: Array


def dips(equations: Equations, lines: Array, depths: Array, *, below: float = 0.0) -> Dips:
    """Minima of the gap v of free surfaces between their lines.

    At a line, where v = 0, there is none.

    Parameters
    ----------
    equations : Equations
    lines : ndarray (n, 2)
        [length].
    depths : ndarray (n,)
        [length].
    below : float
        Minima whose v may be less than this are found exactly [length].

    Returns
    -------
    Dips
    """
    own, x, f, slope = _samples(equations, lines, depths)
    if not own.size:
        none = np.empty(0)
        return Dips(own, none, none, none)
    with np.errstate(invalid="ignore"):  # beyond an edge of the body
        u, u1 = equations.surface(x, own, lines, depths)
        v = u - depths[own] + f
        v1 = u1 + slope
    # v leaves 0 upwards at a line on either side, so that no minimum is seen there, not even by
    # rounding. At the outermost sample of a tail v is taken to fall towards the contact.
    first = np.append(True, own[1:] != own[:-1])  # of each surface
    last = np.append(first[1:], True)
    has_line = np.isfinite(lines[own])
    v1 = np.where(first, np.where(has_line[:, 0], np.maximum(v1, _LEAST), -1.0), v1)
    v1 = np.where(last, np.where(has_line[:, 1], np.minimum(v1, -_LEAST), 1.0), v1)
    intervals, found = minima_between(x, v, v1, own[1:] == own[:-1])
    surface = own[intervals]
    place = found.at
    gap = found.value
    off = found.off
    near = np.flatnonzero((gap - off < below) & (found.lo < found.hi) & (found.bend > 0))
    if near.size:
        known = Minima(*(part[near] for part in found))
        place[near], gap[near] = _exact(equations, lines, depths, surface[near], known)
        off[near] = 0.0
    return Dips(surface, place, gap, off)


def least_gaps(equations: Equations, lines: Array, depths: Array) -> Array:
    """The least minimum of v of each surface (n,) [length], exact where it is negative.

    0 where none is: at the lines v is 0.
    """
    found = dips(equations, lines, depths)
    least = np.zeros(len(lines))
    np.minimum.at(least, found.own, found.gaps)
    return least


def _samples(
    equations: Equations, lines: Array, depths: Array
) -> tuple[Indices, Array, Array, Array]:
    """The samples that surfaces may touch, and their lines: `own`, x, f and f' (m,).

    Seen from the indenter a surface is at the height d - u. As k u = γ₁ u'', that is nowhere more
    than f at both of its lines and d, which it is far away. So samples of the profile that are
    higher are left out, but for those next to lower ones.
    """
    profile = equations.profile
    start = np.searchsorted(profile.x, lines[:, 0], "right")
    stop = np.searchsorted(profile.x, lines[:, 1], "left")
    counts = np.maximum(stop - start, 0)
    own = np.repeat(np.arange(len(lines)), counts)
    # Numbers of the samples of each surface: start, start + 1, ... of one after the other.
    which = np.arange(own.size) + np.repeat(start - np.cumsum(counts) + counts, counts)
    height = np.asarray(profile.indenter.height(np.where(np.isfinite(lines), lines, 0.0)), float)
    level = np.maximum(np.where(np.isfinite(lines), height, -np.inf).max(axis=1), depths)
    level = level + _HIGHER * equations.scene.opened.critical_separation
    low = profile.f[which] <= level[own]
    kept = low.copy()
    kept[1:] |= low[:-1]
    kept[:-1] |= low[1:]
    own = own[kept]
    which = which[kept]
    # The lines are put before and behind the samples of their surfaces; at a corner the slope is
    # that on the side of the surface.
    with_line = np.argwhere(np.isfinite(lines))
    ends = lines[with_line[:, 0], with_line[:, 1]]
    end_height, end_slope = profile.one_sided(ends, np.where(with_line[:, 1] == 0, 1, -1))
    own = np.concatenate([own, with_line[:, 0]])
    x = np.concatenate([profile.x[which], ends])
    f = np.concatenate([profile.f[which], end_height])
    slope = np.concatenate([profile.slope[which], end_slope])
    rank = np.concatenate([np.arange(which.size), np.where(with_line[:, 1] == 0, -1, which.size)])
    order = np.lexsort((rank, own))
    return own[order], x[order], f[order], slope[order]


def _exact(
    equations: Equations, lines: Array, depths: Array, own: Indices, known: Minima
) -> tuple[Array, Array]:
    """Where minima of v (m,) are exactly [length], and v there: zeros of v' near those of cubics.

    own (m,): the surface of each; known: the minima of the cubics.
    """
    indenter = equations.profile.indenter

    def slope(z: Array, which: Indices) -> Array:
        """v' at places (k,) of the minima with these numbers (k,)."""
        _, u1 = equations.surface(z, own[which], lines, depths)
        return np.asarray(u1 + indenter.slope(z))

    level = _LEVEL * float(((known.hi - known.lo) * known.bend).min())
    places = crossings(slope, known.lo, known.hi, known.at, known.bend, level)
    u, _ = equations.surface(places, own, lines, depths)
    return places, u - depths[own] + np.asarray(indenter.height(places), float)
