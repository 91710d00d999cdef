"""Contact lines that follow the depth without an event, all free surfaces at once.

Between two depths a free surface moves smoothly if its lines, at depths in between, are in stable
equilibrium or held all the way, move one way, and its energy changes by the work of its force,

    |E(end) - E(start) - ∫P dd| <= 1e-12 · (sums of the terms' absolute values) + |P| · rounding,

the rounding of depths, by little more of which a contact that has just begun is pressed; a jump,
however short, leaves its energy unbalanced. The depths in between are crowded towards the end,
d = start + (end - start)(2t - t²) at Gauss-Lobatto points t: next to where an equilibrium
disappears a line moves as the root of the distance in depth, which is smooth in t.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.legendre import legval

from discretization.fitted.rest_depths import RestDepths
from discretization.fitted.zeros import EVEN, followed
from discretization.quadrature import Integrals
from discretization.surfaces.network import rounded, to_legendre
from energy.arrays import Array, Mask

DEGREE = 12  # of the Lobatto rule in t
_HALVED, _MOST = 10, 512  # times a part is halved whose energy does not balance, and such parts
BALANCED = 1e-12  # of the energy's terms


class Piece(NamedTuple):
    """Lines (n, p, j, 2) of some free surfaces at depths (p, j) of a way, in p parts (Smooth)."""

    which: tuple[int, ...]
    depths: Array
    lines: Array

    @property
    def ends(self) -> tuple[float, float]:
        """Where the way begins, and ends."""
        return float(self.depths[0, 0]), float(self.depths[-1, -1])

    def of(self, own: set[int]) -> "Piece":
        """Of some of these surfaces."""
        kept = [i for i, which in enumerate(self.which) if which in own]
        return Piece(tuple(self.which[i] for i in kept), self.depths, self.lines[kept])

    def drawn(self, depths: Array, way: int) -> Array:
        """Lines (n, k, 2) at depths on the way, as polynomials of t on each part tell."""
        (n, _, j, _), first = self.lines.shape, self.lines[:, 0, :1]
        parts = np.searchsorted(way * self.depths[:-1, -1], way * depths)
        known = np.where(np.isfinite(self.lines), self.lines, 0.0)
        guess = np.empty((n, depths.size, 2))
        for part in np.unique(parts).tolist():
            own, (start, end) = parts == part, self.depths[part, [0, -1]].tolist()
            t = 1 - 2 * np.sqrt((end - depths[own]) / (end - start))
            series = known[:, part].transpose(0, 2, 1).reshape(-1, j) @ to_legendre(DEGREE)
            guess[:, own] = legval(t, series.T).reshape(n, 2, -1).transpose(0, 2, 1)
        moves = (self.lines != first[:, None]).any(axis=(1, 2))[:, None]
        return np.where(moves, guess, first)


def way_of(start: float, end: float) -> Array:
    """The depths (DEGREE + 1,) of Gauss-Lobatto points on a way."""
    t = (rounded(DEGREE)[0] + 1) / 2
    return np.append(start + (end - start) * (t * (2 - t))[:-1], end)


@dataclass(frozen=True, eq=False)
class Smooth:
    """Smooth motion of the lines of free surfaces."""

    rests: RestDepths
    integrals: Integrals

    def over(
        self, which: tuple[int, ...], lines: Array, start: float, end: float, turns: Any = math.inf
    ) -> tuple[Piece, Mask]:
        """Lines (n, 2) of these surfaces, at rest at one depth, to another; which move smoothly.

        turns: places and depths (2, n, 2), if known, where they would turn back, and come as roots.
        """
        lines, depths = self.rests.snapped(lines), way_of(start, end)
        x, last = np.broadcast_to(turns, (2, *lines.shape))[:, :, None]
        with np.errstate(divide="ignore", invalid="ignore"):
            left = np.sqrt(np.clip((last - depths[:, None]) / (last - start), 0.0, None))
            guess = np.where(np.isfinite(x), x + (lines[:, None] - x) * left, lines[:, None])
        x, good = followed(self.rests, lines, depths, 1 if end >= start else -1, guess, math.inf)
        return Piece(which, depths[None], x[:, None]), good

    def whole(self, pieces: Sequence[Piece], own: set[int]) -> tuple[list[Piece], bool]:
        """Pieces of a way of these surfaces, and whether energies balance; halved as below."""
        parts = [piece.of(own) for piece in pieces]
        depths, lines = ([part[i] for part in parts] for i in (1, 2))
        if not parts or self._balance(np.concatenate(lines, axis=1), np.concatenate(depths)).all():
            return parts, True
        halved = [self.balanced(part, np.ones(len(own), bool)) for part in parts]
        return [part for part, _ in halved], all(good.all() for _, good in halved)

    def balanced(self, piece: Piece, good: Mask) -> tuple[Piece, Mask]:
        """The same in parts on which energies balance; where they do not, a part is halved.

        Where a line passes a jump of a higher derivative of f, ∫P dd only converges on short ones.
        """
        if not good.any():
            return piece, good
        (start, end), own, every = piece.ends, np.flatnonzero(good), good.copy()
        first, smooth, done = piece.lines[own, 0, 0], good[own], list[tuple[Array, Array]]()
        lines, depths, way = piece.lines[own], piece.depths, 1 if end >= start else -1
        for turn in range(_HALVED + 1):
            uneven = ~self._balance(lines, depths) & smooth[:, None]
            if turn == _HALVED or uneven.any(axis=0).sum() > _MOST:
                smooth, uneven = smooth & ~uneven.any(axis=1), np.zeros_like(uneven)
            rough = uneven.any(axis=0)
            done += zip(depths[~rough], lines[:, ~rough].swapaxes(0, 1), strict=True)
            if not rough.any():
                break
            cuts = [(cut[0], (cut[0] + cut[-1]) / 2, cut[-1]) for cut in depths[rough].tolist()]
            halves = np.ravel([way_of(*half) for cut in cuts for half in pairwise(cut)])
            guess = Piece((), depths[rough], lines[:, rough]).drawn(halves, way)
            guess = np.concatenate([first[:, None], guess], axis=1)
            x, good = followed(self.rests, first, np.append(start, halves), way, guess)
            smooth, x[~good] = smooth & good, first[~good, None]
            depths = halves.reshape(-1, DEGREE + 1)
            lines = x[:, 1:].reshape(own.size, *depths.shape, 2)
        done.sort(key=lambda part: way * float(part[0][0]))
        whole = np.tile(piece.lines[:, :1, :1], (1, len(done), DEGREE + 1, 1))
        whole[own] = np.stack([lines for _, lines in done], axis=1)
        every[own] = smooth
        return Piece(piece.which, np.array([depths for depths, _ in done]), whole), every

    def _balance(self, lines: Array, depths: Array) -> Mask:
        """Whether energies balance (n, p), lines (n, p, j, 2) at the depths (p, j) of parts."""
        energy, size, force, work = self._sums(lines, depths)
        rounding = EVEN * self.rests.size * np.abs(force).max(axis=2)
        off = np.abs(energy[..., -1] - energy[..., 0] - work)
        return np.asarray(off <= BALANCED * size.max(axis=2) + rounding)

    def _sums(self, lines: Array, depths: Array) -> tuple[Array, ...]:
        """What `parts` tells (n, p, j) of lines (n, p, j, 2) at depths (p, j), and ∫P dd (n, p)."""
        points, weights, _ = rounded(DEGREE)
        steps = depths[:, -1] - depths[:, 0]
        found = self.parts(lines.reshape(len(lines), -1, 2), depths.ravel(), int(np.sign(steps[0])))
        energy, size, force = found.reshape(3, *lines.shape[:3])
        return energy, size, force, force @ (weights * (1 - points) / 2) * steps

    def work(self, pieces: Sequence[Piece]) -> float:
        """∫P dd on the way of pieces, on the parts of them on which energies balance."""
        return sum(float(self._sums(part.lines, part.depths)[3].sum()) for part in pieces)

    def many(self, lines: Array, depths: Array) -> Array:
        """Energy and force (2, k) of states with as many surfaces (k, n, 2) at depths (k,)."""
        return self.parts(lines.transpose(1, 0, 2), depths, 1)[::2].sum(axis=1)

    def parts(self, lines: Array, depths: Array, way: int) -> Array:
        """Energy, sum of its terms' absolute values, and force (3, n, j) of surfaces (n, j, 2)."""
        (n, j, _), inner = lines.shape, np.isfinite(lines[:, 0])
        x, parts = lines.transpose(0, 2, 1)[inner], np.zeros((3, n, 2, j))
        d, work = np.broadcast_to(depths, x.shape), self.rests.w(way)
        parts[:, inner] = self.integrals.contact(x.ravel(), d.ravel(), work).reshape(3, -1, j)
        parts[::2, :, 1] *= -1
        total = parts.sum(axis=2)
        one, other = inner.T
        for own in (one & other, one & ~other, other & ~one):  # gaps, tails on the right, the left
            if own.any():
                left, right = (self.rests.at(z.ravel()) for z in lines[own].transpose(2, 0, 1))
                at = np.tile(depths, int(own.sum()))
                energy, force = self.rests.surfaces.stored(left, right, at)
                total[:, own] += np.array([energy, energy, force]).reshape(3, -1, j)
        return total
