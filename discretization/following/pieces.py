"""The depths of a way, and contact lines as polynomials of those between them.

A way is cut into parts, and the depths of each are crowded towards its end,
d = start + (end - start)(2t - t²) at Gauss-Lobatto points t: next to where an equilibrium
disappears a line moves as the root of the distance in depth, which is smooth in t.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.network import polynomial, rounded

Array = NDArray[np.float64]
DEGREE = 12  # of the Lobatto rule in t


class Piece(NamedTuple):
    """Lines (n, p * j, 2) of some free surfaces at depths (p, j) of a way, in p parts (Smooth)."""

    which: tuple[int, ...]
    depths: Array
    lines: Array

    @property
    def start(self) -> float:
        """Where the way begins."""
        return float(self.depths[0, 0])

    @property
    def end(self) -> float:
        """Where the way ends."""
        return float(self.depths[-1, -1])

    def drawn(self, depths: Array, way: int) -> Array:
        """Lines (n, k, 2) at depths on the way, as polynomials of t on each part tell."""
        (n, _, _), (p, j), first = self.lines.shape, self.depths.shape, self.lines[:, :1]
        parts = np.searchsorted(way * self.depths[:-1, -1], way * depths)
        known = np.where(np.isfinite(self.lines), self.lines, 0.0).reshape(n, p, j, 2)
        guess = np.empty((n, depths.size, 2))
        for part in np.unique(parts).tolist():
            own, (start, end) = parts == part, self.depths[part, [0, -1]].tolist()
            t = 1 - 2 * np.sqrt((end - depths[own]) / (end - start))
            values = known[:, part].transpose(1, 0, 2).reshape(j, -1)
            guess[:, own] = polynomial(DEGREE, t, values).reshape(n, 2, -1).transpose(0, 2, 1)
        moves = (self.lines != first).any(axis=1, keepdims=True)
        return np.where(moves, guess, first)


def way_of(start: float, end: float, parts: int = 1) -> Array:
    """The depths (parts * (DEGREE + 1),) of Gauss-Lobatto points on each of the parts of a way."""
    t, cuts = (rounded(DEGREE)[0] + 1) / 2, np.arange(parts + 1) / parts
    depths = start + (end - start) * (cuts[:-1, None] + np.diff(cuts)[:, None] * (t * (2 - t)))
    depths[-1, -1] = end
    return np.asarray(depths.ravel())


def restricted(whole: tuple[Piece, ...], own: set[int]) -> tuple[Piece, ...]:
    """The same pieces with some of their free surfaces."""
    found = []
    for piece in whole:
        kept = [k for k, i in enumerate(piece.which) if i in own]
        if kept:
            which = tuple(piece.which[k] for k in kept)
            found.append(piece._replace(which=which, lines=piece.lines[kept]))
    return tuple(found)
