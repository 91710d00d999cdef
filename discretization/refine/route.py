"""A route: a part of a path in one direction of the depth, refined.

It gives the lines at any depth on it, and the work done between two depths.

Conventions
-----------
Depths grow as the indenter goes down. The direction of a route is 1 where its depth grows and -1
where it falls; depths times the direction increase along it. A route is a row of stretches
(`Stretch`), numbered from 0, which end at events; on a stretch the same free surfaces, its `lives`,
move smoothly. The motion of a surface (`Life`) is stored in pieces: its lines at the depths of
Gauss-Lobatto points (`Piece`), which `drawn` interpolates by polynomials.

Lines of n free surfaces at k depths are arrays (n, k, 2): surfaces from left to right, each with
its left and its right line [length], -inf and inf where a tail has none. Contacts on nodes are
their first and last nodes.

`depths_of(start, end)` are the DEGREE + 1 depths of a piece at the points of
`gauss_lobatto(DEGREE)`, `drawn` are lines at depths by the polynomials of pieces, and `drawn_lives`
those of surfaces. Of a `Life`, `start`, `end`, `first` and `last` are depths and lines where it
begins and ends, `cuts` the depths at which a line becomes pinned or free, `trace` its depths on
nodes, and `pair(depth)` the contact nodes at both its ends, None of a tail. `Events.rest` takes
lines to rest by Newton's method; `Totals.of_surfaces` has the energy and force of surfaces;
`Equations.joints` are x where lines may be pinned, and `scene.hysteretic` is whether opening takes
another work of adhesion than closing, so that lines also stand where they are.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.nodes.row import Contacts
from discretization.refine.balance import DEGREE, depths_of, drawn, drawn_lives
from discretization.refine.events import NotRefined
from discretization.refine.lives import Life, Piece
from discretization.refine.plan import Refinement, Stretch
from discretization.surfaces.network import gauss_lobatto
from energy.arrays import Array, Mask


class RouteRules(NamedTuple):
    """How lines on a route are found between the points of its pieces.

    Halved or doubled, each leaves 8 random states and paths as they are to 1e-9 (`at_rest`,
    `just_open` are not read there): `python -m tests.sensitivity discretization.refine.route`.

    Attributes
    ----------
    at_rest : float
        Of δ/l, the size of slopes, δ that of depths: how far F of lines next to a fold may be
        from 0.
    rounds : int
        Of Newton's method from the polynomials of a piece.
    reach : float
        Of l: how far lines may be from these.
    just_open : float
        Of the size of depths: by then a gap is about a millionth of l wide, and the force that it
        carries, like the cube of its width, is 0 to rounding.
    """

    at_rest: float = 1e-9
    rounds: int = 16
    reach: float = 0.1
    just_open: float = 1e-12


_RULES = RouteRules()


@dataclass(frozen=True, eq=False)
class Route:
    """Stretches of smooth motion in one direction of the depth, with the events between them.

    Attributes
    ----------
    refinement : Refinement
        What has found it.
    stretches : list of Stretch
        In their order, at least one.
    """

    refinement: Refinement
    stretches: list[Stretch]

    @property
    def direction(self) -> int:
        """1 where the depth grows, -1 where it falls."""
        return self.stretches[0].direction

    @property
    def goal(self) -> float:
        """The depth at which it ends [length]."""
        return self.stretches[-1].end

    def contacts(self, index: int, depth: float) -> tuple[Contacts, float]:
        """Contacts on nodes at a depth on a stretch, and the depth from which on to follow them.

        Parameters
        ----------
        index : int
            Number of the stretch.
        depth : float
            [length].

        Returns
        -------
        contacts : Contacts
        on_nodes : float
            The depth, or that at which the last surface is born on nodes if that is later.

        Raises
        ------
        NotRefined
            If the contacts on nodes overlap.
        """
        lives = self.stretches[index].lives
        ends = [end for life in lives for end in life.pair(depth)][1:-1]
        nodes = [end for end in ends if end is not None]
        contacts = tuple(zip(nodes[::2], nodes[1::2], strict=True))
        if any(first > last for first, last in contacts):
            raise NotRefined(f"contacts on nodes overlap at depth = {depth!r}", depth)
        births = [self.direction * life.trace[0][0] for life in lives]
        return contacts, self.direction * max([self.direction * depth, *births])

    def next_cut(self, index: int, depth: float) -> float:
        """The first depth beyond this one at which a line becomes pinned or free, on a stretch.

        Its end where no line does [length].
        """
        stretch = self.stretches[index]
        cuts = [cut for life in stretch.lives for cut in life.cuts]
        ahead = [cut for cut in cuts if self.direction * (cut - depth) > 0]
        inside = [cut for cut in ahead if self.direction * (cut - stretch.end) < 0]
        return min(inside, key=lambda cut: self.direction * cut, default=stretch.end)

    def lines(self, index: int, depths: Array, *, roughly: bool = False) -> Array:
        """Lines of the free surfaces of a stretch.

        Parameters
        ----------
        index : int
            Number of the stretch.
        depths : ndarray (k,)
            On the stretch [length].
        roughly : bool
            Whether those of the polynomials of the pieces are good enough.

        Returns
        -------
        ndarray (n, k, 2)
            Of n surfaces from left to right [length].

        Raises
        ------
        NotRefined
            If Newton's method does not take them to rest.
        """
        if roughly:
            return self._drawn(index, depths)
        (found,) = lines_of_routes([(self, index, depths)])
        return found

    def _drawn(self, index: int, depths: Array) -> Array:
        """Lines (n, k, 2) of a stretch at depths (k,), by the polynomials of its pieces."""
        lives = self.stretches[index].lives
        return drawn_lives(lives, np.broadcast_to(depths, (len(lives), depths.size)))

    def _demanded(self, index: int, depths: Array, lines: Array, guess: Array, lost: Mask) -> None:
        """Put lines (n, k, 2) that Newton's method has `lost` (n, k) where they are at rest.

        Next to a fold it hardly converges, but the polynomials of the pieces are good there. So
        lines are put on these, `guess` (n, k, 2), or, of gaps about to close, where they close.
        NotRefined if they are not at rest there to rounding.
        """
        lives = self.stretches[index].lives
        all_depths = np.broadcast_to(depths, lost.shape)
        lines[lost] = guess[lost]
        self._close(lives, lines, all_depths, lost)
        self._demand_rest(lives, lines, all_depths, lost)

    def _close(self, lives: list[Life], lines: Array, depths: Array, lost: Mask) -> None:
        """Close gaps that have just opened, or are about to close, where they are not settled.

        The width of such a gap grows like the root of the depth since it opened, so that rounding
        of the depth is felt in more than half of the digits of its lines. Both lines are put where
        they met; the gap is no longer `lost`.
        """
        least = _RULES.just_open * self.refinement.equations.size
        for i, life in enumerate(lives):
            for depth, ends in ((life.start, life.first), (life.end, life.last)):
                if ends[0] != ends[1]:
                    continue
                closed = lost[i] & (np.abs(depths[i] - depth) <= least)
                lines[i, closed] = ends
                lost[i] &= ~closed

    def _demand_rest(self, lives: list[Life], lines: Array, depths: Array, lost: Mask) -> None:
        """Raise NotRefined unless lines that are still `lost` (n, k) are at rest, to rounding.

        At rest is a line where F is 0, at a joint, or, with two works of adhesion, where it has
        stood since the birth of the surface.
        """
        if not lost.any():
            return
        row, column = np.nonzero(lost)
        directions = np.array([float(lives[i].direction) for i in row])
        equations = self.refinement.equations
        values = equations.values(lines[row, column], depths[row, column], directions)
        pinned = np.isin(lines[row, column], equations.joints)
        if equations.scene.hysteretic:
            pinned |= lines[row, column] == np.array([lives[i].first for i in row])
        slope = equations.size / equations.length
        if (np.abs(np.where(pinned, 0.0, values)) > _RULES.at_rest * slope).any():
            depth = float(depths[row[0], column[0]])
            raise NotRefined(f"the contacts at depth = {depth!r} do not come to rest", depth)

    def work(self, index: int, start: float, end: float) -> float:
        """∫P dd on a stretch from one depth to another [energy/length].

        By the rule of the pieces, d = start + (end - start)(2t - t²) and t = (1 + z)/2, so that
        dd = (end - start)(1 - z)/2 dz for the points z of the Gauss-Lobatto rule.
        """
        points, weights, _ = gauss_lobatto(DEGREE)
        total = 0.0
        for life in self.stretches[index].lives:
            for piece in life.pieces:
                part = self._within(piece, start, end)
                if part is None:
                    continue
                depths = depths_of(*part)
                lines = drawn([piece], np.zeros(depths.size, int), depths)
                _, force = self.refinement.totals.of_surfaces(lines, depths)
                total += float(force @ (weights * (1 - points) / 2)) * (part[1] - part[0])
        return total

    def _within(self, piece: Piece, start: float, end: float) -> tuple[float, float] | None:
        """The part of a piece between two depths, in the order of the route; None where none is."""
        first, last = piece.depths[[0, -1]].tolist()
        low = self.direction * max(self.direction * first, self.direction * start)
        high = self.direction * min(self.direction * last, self.direction * end)
        return (low, high) if self.direction * (high - low) > 0 else None


def lines_of_routes(parts: Sequence[tuple[Route, int, Array]]) -> list[Array]:
    """Lines of free surfaces on stretches of routes of one scene, taken to rest all at once.

    Newton's method takes hardly longer for the lines of a whole path than for those of one stretch.

    Parameters
    ----------
    parts : sequence of (Route, int, ndarray (k,))
        Routes, numbers of their stretches, and depths on these [length].

    Returns
    -------
    list of ndarray (n, k, 2)
        As `Route.lines`.

    Raises
    ------
    NotRefined
        If Newton's method does not take lines to rest.
    """
    # One row for every surface at every depth, part after part.
    lives = list[Life]()
    guesses = list[Array]()
    all_depths = list[Array]()
    for route, index, depths in parts:
        own = route.stretches[index].lives
        guesses.append(route._drawn(index, depths))
        lives += [life for life in own for _ in range(depths.size)]
        all_depths += [depths] * len(own)
    refinement = parts[0][0].refinement
    found = refinement.events.rest(
        lives,
        np.concatenate([guess.reshape(-1, 1, 2) for guess in guesses]),
        np.concatenate(all_depths)[:, None],
        reach=_RULES.reach * refinement.equations.length,
        rounds=_RULES.rounds,
    )
    ends = np.cumsum([guess.shape[0] * guess.shape[1] for guess in guesses])[:-1]
    rested = list[Array]()
    lines_of_parts = np.split(found.lines, ends)
    at_rest_of_parts = np.split(found.at_rest, ends)
    for i, (route, index, depths) in enumerate(parts):
        lines = lines_of_parts[i].reshape(guesses[i].shape)
        lost = ~at_rest_of_parts[i].reshape(guesses[i].shape[:2])
        if lost.any():
            route._demanded(index, depths, lines, guesses[i], lost)
        rested.append(lines)
    return rested
