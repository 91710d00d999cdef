"""The life of surfaces in smooth pieces: lines at Gauss-Lobatto points, energy against work.

A piece ends where a line reaches or leaves a corner, or moves for the first time. On every piece

    |U(end) - U(start) - ∫P dd| <= TOLERANCE · k l δ²,    δ the size of the depths of the path,

or it is halved: a jump, however short, and a surface taken for another leave its energy unbalanced.
Depths are start + (end - start)(2t - t²) at Gauss-Lobatto points t: next to a fold a line moves as
the root of what is left, which is smooth in t.

Conventions
-----------
Depths grow as the indenter goes down. A `Life` is a free surface from its birth, at depth `start`
with lines `first`, to its end, at depth `end` with lines `last`; its direction is 1 where the depth
grows and -1 where it falls, and all lives of a route have the same. Lines (..., 2) are its left and
its right one [length], -inf and inf where a tail has none. Depths of a part or a piece are in the
order of the route, from `start` to `end`, at the DEGREE + 1 points of the rule. In arrays over p
parts with j depths each lines are (p, j, 2).

`Events.rest` takes lines to rest by Newton's method, no further than `reach`: the lines, whether
they are `at_rest`, and which are `pinned`. FROM_NODES, of l, is how far lines may rest from their
nodes; `Life.guesses(depths)` are the positions of these nodes, and `Life.passed` the ends of its
pieces times the direction. `Totals.of_surfaces` has the energy and force of surfaces with what they
bound. `gauss_lobatto(n)` has the n + 1 points z and weights of the rule on -1 <= z <= 1, and
`to_legendre(n)` the matrix by which rows of values at these points become coefficients of Legendre
polynomials.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial import legendre

from discretization.refine.events import Events, NotRefined
from discretization.refine.lives import Life, Piece
from discretization.refine.nodes import FROM_NODES
from discretization.refine.totals import Totals
from discretization.surfaces.network import gauss_lobatto, to_legendre
from energy.arrays import Array, Indices, Mask

# Of the Lobatto rule in t, exact for polynomials of degree 23. A part on which that is not enough
# does not balance and is halved: 6 or 24 changes none of 8 random paths by 1e-9
# (`python -m tests.sensitivity discretization.refine.balance`).
DEGREE = 12
# Of the energy's scale: what a piece may be off by, or it is halved; a tenth of what certificates
# tolerate. Forces that are read off the polynomials of a piece are as good as its balance.
TOLERANCE = 1e-10
REFUSED = 1e-9  # of the same, of a piece that halving does not mend: what certificates tolerate


class PieceRules(NamedTuple):
    """How lives are divided into pieces; δ is the size of depths.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 8 random states and
    paths as they are to 1e-9: `python -m tests.sensitivity discretization.refine.balance`.

    Attributes
    ----------
    halvings : int
        Of a part at most: 1/4096 of it.
    first : int
        Parts of a life at first: few profiles are so smooth that one is enough.
    cut_rounds : int
        Rounds in which the depth of a corner is enclosed: 16 times 4 bits are more than those of a
        depth.
    cut_parts : int
        Depths in each of these rounds.
    short : float
        Of δ: a part that is not divided, as its energy would be rounding.
    newton_rounds : int
        Of Newton's method from the nodes.
    halves : int
        For each surface, of parts that do not balance: where there are more, nothing balances, and
        halving all of them again would take twice as long each time. In 239 of 240 random paths
        there are 10 at most, in one 124.
    """

    halvings: int = 12
    first: int = 4
    cut_rounds: int = 16
    cut_parts: int = 15
    short: float = 1e-11
    newton_rounds: int = 16
    halves: int = 256


_PIECE = PieceRules()


class _Part(NamedTuple):
    """A part of a life that may be a piece.

    Attributes
    ----------
    life : Life
    start, end : float
        Its depths [length].
    first, last : ndarray (2,) or None
        Lines there, where they are known [length].
    whole : Piece or None
        That of which it is a half, from which lines are guessed.
    """

    life: Life
    start: float
    end: float
    first: Array | None
    last: Array | None
    whole: Piece | None = None


class _Change(NamedTuple):
    """Between which depths of a part a line becomes pinned, or free.

    Attributes
    ----------
    part : _Part
    start, end : float
        Those depths [length].
    lines : ndarray (2,)
        Lines at the start [length].
    """

    part: _Part
    start: float
    end: float
    lines: Array


def depths_of(start: float, end: float) -> Array:
    """The depths d = start + (end - start)(2t - t²) of a piece at Gauss-Lobatto points t.

    Parameters
    ----------
    start, end : float
        [length].

    Returns
    -------
    ndarray (DEGREE + 1,)
        [length].
    """
    t = (gauss_lobatto(DEGREE)[0] + 1) / 2
    depths = start + (end - start) * (t * (2 - t))
    depths[-1] = end
    return depths


def drawn(pieces: Sequence[Piece], which: Indices, depths: Array) -> Array:
    """Lines at depths, by the polynomials of t through the points of pieces.

    Parameters
    ----------
    pieces : sequence of Piece
    which : ndarray of int (...)
        The number of the piece on which each of the depths is.
    depths : ndarray (...)
        [length].

    Returns
    -------
    ndarray (..., 2)
        [length].
    """
    start = np.array([piece.depths[0] for piece in pieces])[which]
    end = np.array([piece.depths[-1] for piece in pieces])[which]
    left = np.clip((end - depths) / (end - start), 0.0, 1.0)
    # As `left` is (1 - t)², this is 2t - 1, which goes from -1 to 1 as the points of the rule do.
    t = 1 - 2 * np.sqrt(left)
    # What the value at each point of the rule has for its share in the polynomial there.
    shares = legendre.legvander(t, DEGREE) @ to_legendre(DEGREE).T

    at_points = np.array([piece.lines for piece in pieces])
    has_line = np.isfinite(at_points)
    finite = np.where(has_line, at_points, 0.0)
    found = np.einsum("...i,...ij->...j", shares, finite[which])

    lowest = at_points.min(axis=1)
    highest = at_points.max(axis=1)
    found = np.clip(found, lowest[which], highest[which])
    first = at_points[:, 0]
    return np.where(has_line[:, 0][which], found, first[which])


def drawn_lives(lives: Sequence[Life], depths: Array) -> Array:
    """Lines of surfaces at depths on their lives, by the polynomials of their pieces.

    Parameters
    ----------
    lives : sequence of Life
        n of them.
    depths : ndarray (n, k)
        [length].

    Returns
    -------
    ndarray (n, k, 2)
        [length]; of a life too short for pieces the first or last ones.
    """
    found = np.empty((*depths.shape, 2))
    long_lives = list[int]()
    pieces = list[Piece]()
    which = np.zeros(depths.shape, int)
    for i, life in enumerate(lives):
        if not life.pieces:
            early = life.direction * (depths[i] - (life.start + life.end) / 2) <= 0
            found[i] = np.where(early[:, None], life.first, life.last)
            continue
        own = np.searchsorted(life.passed[:-1], life.direction * depths[i])
        first = int(own.min())
        which[i] = own - first + len(pieces)
        pieces += life.pieces[first : int(own.max()) + 1]
        long_lives.append(i)
    if long_lives:
        found[long_lives] = drawn(pieces, which[long_lives], depths[long_lives])
    return found


def work(totals: Totals, piece: Piece) -> float:
    """∫P dd over a piece [energy/length].

    By the Lobatto rule in t, of d = start + (end - start)(2t - t²): dd = (end - start) 2(1 - t) dt.
    """
    _, force = totals.of_surfaces(piece.lines, piece.depths)
    points, weights, _ = gauss_lobatto(DEGREE)
    step = piece.depths[-1] - piece.depths[0]
    return float(force @ (weights * (1 - points) / 2) * step)


def _quarters(life: Life) -> list[_Part]:
    """A life in four parts of equal depths: few profiles are so smooth that one is enough.

    Of their ends only those of the life are known: its first and its last lines.
    """
    depths = np.linspace(life.start, life.end, _PIECE.first + 1).tolist()
    ends: list[Array | None] = [life.first, *([None] * (_PIECE.first - 1)), life.last]
    return [
        _Part(life, depths[i], depths[i + 1], ends[i], ends[i + 1]) for i in range(_PIECE.first)
    ]


def _guesses(parts: Sequence[_Part], depths: Array) -> Array:
    """Lines (p, k, 2) near those of p parts at depths (p, k) on them.

    Those of the polynomials of the whole that the part is a half of, else of the nodes.
    """
    guesses = np.empty((*depths.shape, 2))
    halves = list[int]()
    wholes = list[Piece]()
    for i, part in enumerate(parts):
        if part.whole is None:
            guesses[i] = part.life.guesses(depths[i])
        else:
            halves.append(i)
            wholes.append(part.whole)
    if halves:
        which = np.arange(len(halves))[:, None] + np.zeros(depths.shape[1], int)
        guesses[halves] = drawn(wholes, which, depths[halves])
    return guesses


@dataclass(frozen=True, eq=False)
class Balance:
    """What divides lives into smooth pieces on which the energy balances the work.

    Attributes
    ----------
    events : Events
        Takes lines to rest.
    totals : Totals
    scale : float
        k l δ² of the path, by which the balance is judged [energy/length].
    """

    events: Events
    totals: Totals
    scale: float

    def pieces(self, lives: Sequence[Life]) -> None:
        """Find the pieces of all these lives, from their known start to their known end.

        A part is a piece if |U(end) - U(start) - ∫P dd| <= TOLERANCE · k l δ² and no line changes
        between pinned and free on it; else it is cut where one does, or halved. After 12 halvings,
        or where it is shorter than 1e-11 δ, REFUSED · k l δ² will do.

        Parameters
        ----------
        lives : sequence of Life
            Pieces and cuts are written into them.

        Raises
        ------
        NotRefined
            If a part does not balance even so, or more and more parts do not.
        """
        size = self.events.equations.size
        todo = list[_Part]()
        for life in lives:
            if abs(life.end - life.start) > _PIECE.short * size:
                todo += _quarters(life)
        for turn in range(_PIECE.halvings + 1):
            if not todo:
                break
            todo = self._divided(todo, last=turn == _PIECE.halvings)
        for life in lives:
            life.pieces.sort(key=lambda piece: life.direction * float(piece.depths[0]))
            life.passed = np.array([life.direction * piece.depths[-1] for piece in life.pieces])

    def _divided(self, todo: list[_Part], *, last: bool) -> list[_Part]:
        """Keep parts that are pieces with their lives; the rest in smaller parts.

        last: whether parts are not divided again, so that they must balance to REFUSED.
        """
        depths = np.array([depths_of(part.start, part.end) for part in todo])
        lines, pinned, good = self._at_rest(todo, depths)
        same = (pinned[:, 1:] == pinned[:, :-1]).all(axis=2)  # between neighbouring depths
        same[:, 0] = True  # at the ends lines may be pinned on either side
        same[:, -1] = True
        off = self._off_balance(lines, depths, todo[0].life.direction)
        balanced = good & same.all(axis=1) & (off <= TOLERANCE)
        rest = list[_Part]()
        to_cut = list[_Change]()
        for i, part in enumerate(todo):
            short = last or abs(part.end - part.start) <= _PIECE.short * self.events.equations.size
            if balanced[i] or (short and good[i] and off[i] <= REFUSED):
                part.life.pieces.append(Piece(depths[i], lines[i]))
            elif short:
                raise NotRefined(
                    f"between depth = {part.start!r} and {part.end!r} energy and work differ by "
                    f"{off[i]:.1e} of their scale",
                    part.start,
                )
            elif good[i] and not same[i].all():
                j = int(np.argmin(same[i]))
                to_cut.append(_Change(part, depths[i, j], depths[i, j + 1], lines[i, j]))
            else:
                middle = (part.start + part.end) / 2
                whole = Piece(depths[i], lines[i]) if good[i] else None
                rest.append(_Part(part.life, part.start, middle, part.first, None, whole))
                rest.append(_Part(part.life, middle, part.end, None, part.last, whole))
        surfaces = {id(part.life) for part in todo}
        if len(rest) > _PIECE.halves * len(surfaces):
            start = rest[0].start
            raise NotRefined(f"from depth = {start!r} on energy and work differ", start)
        if to_cut:
            rest += self._cut(to_cut)
        return rest

    def _off_balance(self, lines: Array, depths: Array, direction: int) -> Array:
        """|U(end) - U(start) - ∫P dd| over k l δ² of parts (p,), with lines (p, j, 2)."""
        energy, force = self.totals.of_surfaces(lines.reshape(-1, 2), depths.ravel(), direction)
        points, weights, _ = gauss_lobatto(DEGREE)
        steps = depths[:, -1] - depths[:, 0]
        done = force.reshape(depths.shape) @ (weights * (1 - points) / 2) * steps
        grown = np.diff(energy.reshape(depths.shape)[:, [0, -1]])[:, 0]
        return np.asarray(np.abs(grown - done) / self.scale)

    def _at_rest(self, parts: list[_Part], depths: Array) -> tuple[Array, Mask, Mask]:
        """Lines (p, j, 2) at depths (p, j), which are pinned, and whether parts are at rest (p,).

        Lines are looked for from those of the nodes or the whole, and where that fails from those
        at either end of the life. Known ends are left as they are: next to a fold Newton's method
        hardly converges.
        """
        lines = _guesses(parts, depths)
        pinned = np.zeros(lines.shape, bool)
        good = np.zeros(depths.shape, bool)
        for i, part in enumerate(parts):
            if part.first is not None:
                lines[i, 0] = part.first
                good[i, 0] = True
            if part.last is not None:
                lines[i, -1] = part.last
                good[i, -1] = True
        self._settle(parts, depths, lines, lines, pinned, good)
        for known in ("first", "last"):
            ends = np.array([getattr(part.life, known) for part in parts])
            starts = np.repeat(ends[:, None], depths.shape[1], axis=1)
            self._settle(parts, depths, starts, lines, pinned, good)
        return lines, pinned, np.asarray(good.all(axis=1))

    def _settle(
        self,
        parts: list[_Part],
        depths: Array,
        starts: Array,
        lines: Array,
        pinned: Mask,
        good: Mask,
    ) -> None:
        """Take the lines that are not `good` yet to rest from `starts` (p, j, 2).

        `lines` (p, j, 2), which are `pinned` (p, j, 2) and `good` (p, j) change in place.
        """
        row, column = np.nonzero(~good)
        if not row.size:
            return
        found = self.events.rest(
            [parts[i].life for i in row],
            starts[row, column][:, None],
            depths[row, column][:, None],
            reach=FROM_NODES * self.events.equations.length,
            rounds=_PIECE.newton_rounds,
        )
        lines[row, column] = found.lines
        pinned[row, column] = found.pinned
        good[row, column] = found.at_rest

    def _cut(self, changes: list[_Change]) -> list[_Part]:
        """Parts on both sides of the depths at which lines become pinned, or free.

        Those depths, which become cuts of the lives, are enclosed: of some depths in a range the
        last before which nothing has changed, and the next one, are the next range.
        """
        lives = [change.part.life for change in changes]
        low = np.array([change.start for change in changes])
        high = np.array([change.end for change in changes])
        lines = np.array([change.lines for change in changes])
        before = self.events.rest(lives, lines[:, None], low[:, None]).pinned
        share = np.arange(1, _PIECE.cut_parts + 1) / (_PIECE.cut_parts + 1)
        for _ in range(_PIECE.cut_rounds):
            depths = low[:, None] + (high - low)[:, None] * share
            guess = np.repeat(lines[:, None], _PIECE.cut_parts, axis=1)
            found = self.events.rest(lives, guess, depths)
            alike = (found.pinned.reshape(guess.shape) == before[:, None]).all(axis=2)
            alike &= found.at_rest.reshape(depths.shape)
            count = np.where(alike.all(axis=1), _PIECE.cut_parts, np.argmin(alike, axis=1))
            ends = np.column_stack([low, depths, high])
            rows = np.arange(len(changes))
            low = ends[rows, count]
            high = ends[rows, count + 1]
            at = found.lines.reshape(guess.shape)
            lines = np.where(count[:, None] > 0, at[rows, np.maximum(count - 1, 0)], lines)
        rest = list[_Part]()
        for (part, *_), depth, there in zip(changes, low.tolist(), lines, strict=True):
            part.life.cuts.append(depth)
            rest.append(_Part(part.life, part.start, depth, part.first, there))
            rest.append(_Part(part.life, depth, part.end, there, part.last))
        return [
            part
            for part in rest
            if abs(part.end - part.start) > _PIECE.short * self.events.equations.size
        ]
