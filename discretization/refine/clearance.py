"""How far free surfaces are above the profile, those of many states at once."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from discretization.refine.equations import Equations
from discretization.roots import crossings, minima_between
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
        What v may be off by [length], 0 where it is exact.
    """

    own: Indices
    places: Array
    gaps: Array
    off: Array


def dips(equations: Equations, lines: Array, depths: Array, *, below: float = 0.0) -> Dips:
    """Minima of the gap v of free surfaces between their lines.

    Those of the cubics through v and v' at the samples of the profile; exactly where v may be less
    than `below`. At a line, where v = 0, there is none.

    Parameters
    ----------
    equations : Equations
    lines : ndarray (n, 2)
        [length].
    depths : ndarray (n,)
        [length].
    below : float
        [length].

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
    first = np.append(True, own[1:] != own[:-1])
    last = np.append(first[1:], True)
    has_line = np.isfinite(lines[own])
    v1 = np.where(first, np.where(has_line[:, 0], np.maximum(v1, _LEAST), -1.0), v1)
    v1 = np.where(last, np.where(has_line[:, 1], np.minimum(v1, -_LEAST), 1.0), v1)
    k, found = minima_between(x, v, v1, own[1:] == own[:-1])
    lo, hi, at, bend, gap, off = found
    mine = own[k]
    near = np.flatnonzero((gap - off < below) & (lo < hi) & (bend > 0))
    if near.size:
        at[near], gap[near] = _exact(
            equations, lines, depths, mine[near], (lo[near], hi[near], at[near], bend[near])
        )
        off[near] = 0.0
    return Dips(mine, at, gap, off)


def least_gaps(equations: Equations, lines: Array, depths: Array) -> Array:
    """The least of the minima of v (n,) of each surface, at most 0: exact where that is less."""
    found = dips(equations, lines, depths)
    least = np.zeros(len(lines))
    np.minimum.at(least, found.own, found.gaps)
    return least


def _samples(
    equations: Equations, lines: Array, depths: Array
) -> tuple[Indices, Array, Array, Array]:
    """Of each surface the samples it may touch and its lines: whose, x, f and f' (m,).

    As no surface is lower than at its lines and far away, higher samples are left out, but for the
    next ones.
    """
    profile = equations.profile
    start = np.searchsorted(profile.x, lines[:, 0], "right")
    stop = np.searchsorted(profile.x, lines[:, 1], "left")
    counts = np.maximum(stop - start, 0)
    own = np.repeat(np.arange(len(lines)), counts)
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
    equations: Equations, lines: Array, depths: Array, own: Indices, known: tuple[Array, ...]
) -> tuple[Array, Array]:
    """Where minima of v (m,) are exactly, and v there.

    known: between which places each is, about where, and v''.
    """
    lo, hi, at, bend = known
    indenter = equations.profile.indenter

    def slope(z: Array, which: Indices) -> Array:
        _, u1 = equations.surface(z, own[which], lines, depths)
        return np.asarray(u1 + indenter.slope(z))

    level = _LEVEL * float(((hi - lo) * bend).min())
    places = crossings(slope, lo, hi, at, bend, level)
    u, _ = equations.surface(places, own, lines, depths)
    return places, u - depths[own] + np.asarray(indenter.height(places), float)
