"""Where the lines of many free surfaces rest, at once: D(x) and how it changes with the lines.

Free surfaces stand in rows (n, 2) of a left and a right line, the other line of a tail is infinite.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.resting import TIE, Resting
from discretization.fitted.surfaces import At

Array = NDArray[np.float64]
_DIFFERENCE = 1e-6  # of the room between two lines, or of l, for the change of D
_SMALL = 1e-6  # of l
_ULPS = 4.0  # a line so many roundings from a corner is at it


@dataclass(frozen=True, eq=False)
class Rests:
    """Depths at which lines rest."""

    resting: Resting

    @property
    def length(self) -> float:
        """l."""
        return self.resting.scene.elastocapillary_length

    def rooms(self, lines: Array, way: int) -> Array:
        """Between which places lines (n, 2) move without passing a corner, (2, n, 2).

        A line at a corner is on that side of it to which it moves.
        """
        known, found = self.resting.profile.joints, np.empty((2, *lines.shape))
        for own, side in ((0, 1), (1, -1)):
            at = np.searchsorted(known, lines[:, own], side="right" if side * way > 0 else "left")
            at = np.clip(at, 1, known.size - 1)
            lo, hi = known[at - 1], known[at]
            low, high = (_ULPS * self._spacing(end) for end in (lo, hi))
            found[:, :, own] = lo + low, hi - high
        return np.where(np.isfinite(lines), found, lines)

    def _spacing(self, x: Array) -> Array:
        """Rounding of positions, at 0 of a small part of l: an indenter may divide them by that."""
        return np.spacing(np.maximum(np.abs(x), _SMALL * self.length))

    def snapped(self, lines: Array) -> Array:
        """Lines next to a corner put on it."""
        known = self.resting.profile.joints[1:-1]
        if not known.size:
            return lines
        at = np.searchsorted(known, lines)
        for near in (known[np.maximum(at - 1, 0)], known[np.minimum(at, known.size - 1)]):
            close = np.abs(lines - near) <= 2 * _ULPS * self._spacing(near)
            lines = np.where(close, near, lines)
        return lines

    def ahead(self, lines: Array, way: int, adhesive: bool = True) -> Array:
        """`_ahead` of surfaces of every kind; of a line that is none, ∞."""
        found = np.full(lines.shape, math.inf)
        for own in kinds(lines):
            found[own] = self._ahead(lines[own], way, adhesive)
        return np.where(np.isfinite(lines), found, math.inf)

    def _ahead(self, lines: Array, way: int, adhesive: bool) -> Array:
        """D just ahead of lines (n, 2) that move outwards of contacts (way 1) or inwards (-1).

        Beyond the edge of the body nothing can be touched, D = ∞. adhesive: or without adhesion.
        """
        found, profile = np.zeros(lines.shape), self.resting.profile
        inner = np.isfinite(lines[0])
        facing = [
            self.resting.many(x) if known else None for known, x in zip(inner, lines.T, strict=True)
        ]
        for own, side in ((0, 1), (1, -1)):
            if inner[own]:
                x = lines[:, own]
                f, f1 = profile.beside(x, side * way)
                beside = profile.past(x, side * way)
                place = side, beside, f, f1, facing[1 - own]
                if adhesive:
                    rest = self.resting.rest(*place, way)
                else:
                    rest = self.resting.surfaces.rest_depth(*place, 0.0)
                edge = (way > 0) & np.isin(x, profile.indenter.walls)
                found[:, own] = np.where(edge, math.inf, rest)
        return found

    def reach(self, lines: Array, depth: float, way: int) -> Array:
        """How much further lines (n, 2) can be pressed or retracted before a corner matters.

        Until a free line comes to the next one, or one that is held there comes free; all but
        linear in the depth. nan where there is none.
        """
        found, profile = np.full(lines.shape, math.nan), self.resting.profile
        kept = self.resting.scene.hysteretic or np.isin(lines, profile.indenter.walls).any()
        if profile.joints.size <= 2 and not kept:
            return found
        held = way * (self.ahead(lines, way) - depth)
        room = self.rooms(lines, way)
        for kind in kinds(lines):
            own = lines[kind]
            inner = np.isfinite(own[0])
            facing = [
                self.resting.many(x) if known else None
                for known, x in zip(inner, own.T, strict=True)
            ]
            for i, side in ((0, 1), (1, -1)):
                if inner[i]:
                    x = room[1 if side * way > 0 else 0][kind, i]
                    f, f1 = self.resting.profile.beside(x, -side * way)
                    with np.errstate(over="ignore", invalid="ignore"):  # at the end of a window
                        rest = self.resting.rest(side, x, f, f1, facing[1 - i], way)
                        found[kind, i] = way * (rest - depth)
        found = np.where(held > TIE * self.resting.size, held, found)
        return np.where(np.isfinite(lines) & np.isfinite(found) & (found > 0), found, math.nan)

    def rest_depths(
        self, x: Array, room: Array, way: int, rates: bool
    ) -> tuple[Array, Array | None]:
        """D of both lines (n, j, 2), and its changes (n, j, 2, 2): of the first with the second."""
        flat, inner = x.reshape(-1, 2), np.isfinite(x[0, 0])
        if inner.all():
            h = _DIFFERENCE * np.minimum(flat[:, 1] - flat[:, 0], self.length)
        else:
            h = np.full(len(flat), _DIFFERENCE * self.length)
        steps = (0, 1, -1) if rates else (0,)
        z = flat[:, :, None] + np.multiply.outer(h, steps)[:, None]
        if rates:
            lo, hi = np.repeat(room, x.shape[1], axis=1)[..., None]
            z[..., 1:] = np.clip(z[..., 1:], lo, hi)
        f, f1 = np.zeros((2, *z.shape))
        lined = slice(None) if inner.all() else slice(*(0, 1) if inner[0] else (1, 2))
        f[:, lined] = self.resting.profile.indenter.height(z[:, lined])
        f1[:, lined] = self.resting.profile.indenter.slope(z[:, lined])
        moved, other = ([0, 1, 2, 0, 0], [0, 0, 0, 1, 2]) if rates else ([0], [0])
        value, rate = np.zeros_like(flat), np.zeros((*flat.shape, 2))
        for own, side in ((0, 1), (1, -1)):
            if not inner[own]:
                continue
            at, f_at, slope = (part[:, own, moved].ravel() for part in (z, f, f1))
            beyond, f_beyond = (part[:, 1 - own, other].ravel() for part in (z, f))
            facing = At(beyond, f_beyond) if inner.all() else None
            rest = np.reshape(
                self.resting.rest(side, at, f_at, slope, facing, way), (-1, len(moved))
            )
            value[:, own] = rest[:, 0]
            if rates:
                for which, (one, two) in ((own, (1, 2)), (1 - own, (3, 4))):
                    if not inner[which]:
                        continue
                    width = z[:, which, 1] - z[:, which, 2]
                    with np.errstate(divide="ignore", invalid="ignore"):  # between two corners
                        rate[:, own, which] = (rest[:, one] - rest[:, two]) / width
        return value.reshape(x.shape), rate.reshape(*x.shape, 2) if rates else None


def kinds(lines: Array) -> list[NDArray[np.bool_]]:
    """Which surfaces are gaps, which tails on the right and which on the left, as far as any are.

    What is computed of many surfaces at once is so of one kind.
    """
    inner = np.isfinite(lines)
    found = inner.all(axis=1), inner[:, 0] & ~inner[:, 1], inner[:, 1] & ~inner[:, 0]
    return [np.asarray(own) for own in found if own.any()]


def solved(rate: Array, off: Array, free: NDArray[np.bool_]) -> Array:
    """The solution (n, j, 2) of rate · step = off for the free lines of each surface, else 0."""
    (a, b), (c, e) = rate[..., 0, :].T, rate[..., 1, :].T  # each (j, n)
    r, s = off.T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        det = a * e - b * c
        both = np.array([(e * r - b * s) / det, (a * s - c * r) / det])
        alone = np.array([r / a, s / e])
    found = np.where(free.all(axis=1), both, alone).T
    return np.where(free[:, None], found, 0.0)


def margins(rate: Array, free: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], Array]:
    """Whether free lines are stable at all depths (n,), and the square of the stiffness at the end.

    D must grow outwards of every line, and with both lines free their matrix be definite.
    """
    (a, b), (c, e) = rate[..., 0, :].T, rate[..., 1, :].T
    det, both = a * e - b * c, free.all(axis=1)
    stable = (~free[:, 0] | (a > 0)) & (~free[:, 1] | (e < 0)) & (~both | (det < 0))
    least = np.where(both, det, np.where(free[:, 0], a, np.where(free[:, 1], e, math.nan)))
    return np.asarray(stable.all(axis=0)), least[-1] ** 2
