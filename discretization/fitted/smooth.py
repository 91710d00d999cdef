"""Contact lines that follow the depth without an event, all free surfaces at once.

Between two depths a free surface moves smoothly if its lines, at depths in between, are in stable
equilibrium or held where they are all the way, move one way, and its energy changes by the work of
its force,

    |E(end) - E(start) - ∫P dd| <= 1e-12 · (sums of the terms' absolute values),

a jump, however short, leaves its energy unbalanced. The depths in between are crowded towards the
end, d = start + (end - start)(2t - t²) at Gauss-Lobatto points t: next to where an equilibrium
disappears a line moves as the root of the distance in depth, which is smooth in t.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.fitted.integrals import Integrals
from discretization.fitted.resting import Resting
from discretization.fitted.spectral import rounded
from discretization.fitted.surfaces import At

Array = NDArray[np.float64]
_DEGREE = 12  # of the Lobatto rule in t
_NEWTON = 48  # where an equilibrium disappears the steps only halve
_STILL = 1e-15  # of the position and l: a step of Newton's method that is rounding
_ROUNDED = 1e-12  # of the same: it may be, if it shrinks no more
_LOCAL = 1e-5  # of the same: the changes of D are those of the step before
_ULPS = 4.0  # a line so many roundings from a corner is at it
_EVEN = 4e-15  # of the size of depths: D - d that is rounding, where a step need not be
_BACK = 1e-7  # of the position and l, as little as lines may move back by rounding there
_DIFFERENCE = 1e-6  # of the room between two lines, or of l, for the change of D
BALANCED = 1e-12  # of the energy's terms


class Moved(NamedTuple):
    """Lines of free surfaces at the end of a smooth motion (n, 2), which of them moved so, ∫P dd.

    margin (n,): square of the stiffness against moving them at the end, nan if none moves.
    """

    lines: Array
    smooth: NDArray[np.bool_]
    work: Array
    margin: Array


@dataclass(frozen=True, eq=False)
class Smooth:
    """Smooth motion of the lines of free surfaces."""

    resting: Resting
    integrals: Integrals

    def over(self, lines: Array, start: float, end: float) -> Moved:
        """The lines (n, 2) of these surfaces, at rest at the depth start, taken to the depth end."""
        n = len(lines)
        found = Moved(lines.copy(), np.zeros(n, bool), np.zeros(n), np.full(n, math.nan))
        inner = np.isfinite(lines)
        kinds = inner.all(axis=1), inner[:, 0] & ~inner[:, 1], inner[:, 1] & ~inner[:, 0]
        for kind in kinds:
            if kind.any():
                own = self._alike(lines[kind], start, end)
                for whole, part in zip(found, own, strict=True):
                    whole[kind] = part
        found.smooth[~inner.any(axis=1)] = True
        return found

    def _alike(self, lines: Array, start: float, end: float) -> Moved:
        """The same for gaps alone, left lines of tails alone or right ones alone."""
        t, weights, _ = rounded(_DEGREE)
        t = (t + 1) / 2
        depths = start + (end - start) * t * (2 - t)
        depths[-1] = end
        way = 1 if end >= start else -1
        x, good, margin = self._followed(lines, depths, way)
        if not good.any():
            return Moved(x[:, -1], good, np.zeros(len(x)), margin)
        energy, size, force = np.zeros((3, *x.shape[:2]))
        energy[good], size[good], force[good] = self._totals(x[good], depths, way)
        work = force @ (weights * (1 - t)) * (end - start)
        change = energy[:, -1] - energy[:, 0]
        good &= np.abs(change - work) <= BALANCED * size.max(axis=1)
        return Moved(self._snapped(x[:, -1]), good, work, margin)

    def _followed(
        self, lines: Array, depths: Array, way: int
    ) -> tuple[Array, NDArray[np.bool_], Array]:
        """Lines (n, j, 2) at depths (j,), by Newton's method; whether they are in equilibrium."""
        n, j = len(lines), depths.size
        x = np.repeat(lines[:, None, :], j, axis=1)
        inner = np.isfinite(lines)
        free = inner & (self._drives(lines, depths[-1], way) < 0)
        size = np.abs(np.where(inner, lines, 0.0)).sum(axis=1) + self._length
        rates, last, room = np.zeros((n, j, 2, 2)), np.full(n, math.inf), self._rooms(lines, way)
        good, active, near = np.ones(n, bool), free.any(axis=1), False
        high = self.resting.size
        for _ in range(_NEWTON):
            own = np.flatnonzero(active)
            if not own.size:
                break
            value, fresh = self._rest_depths(x[own], room[:, own], way, not near)
            if fresh is not None:
                rates[own] = fresh
            off = np.where(free[own, None], value - depths[:, None], 0.0)
            new = np.clip(x[own] - _solved(rates[own], off, free[own]), *room[:, own, None])
            new = np.where(free[own, None], new, x[own])
            with np.errstate(invalid="ignore"):
                now = np.nanmax(np.abs(new - x[own]), axis=(1, 2))
            x[own], even = new, np.abs(off).max(axis=(1, 2))
            rounding = (now <= _ROUNDED * size[own]) | (even <= _EVEN * high)
            done = (now <= _STILL * size[own]) | ((last[own] / 2 <= now) & rounding)
            stuck = free[own, None] & ((new == room[0, own, None]) | (new == room[1, own, None]))
            stopped = stuck.any(axis=(1, 2)) & (even > _EVEN * high)  # by a corner
            good[own] = (new[..., 0] < new[..., 1]).all(axis=1) & ~(done & stopped)
            near = bool((now <= np.minimum(_LOCAL * size[own], last[own] / 8)).all())
            last[own], active[own] = now, ~done & good[own]
        stable, margin = _margins(rates, free)
        with np.errstate(invalid="ignore"):  # from where they are, and one way
            whole = np.concatenate([lines[:, None], x], axis=1)
            moved = way * np.diff(whole, axis=1) * (1.0, -1.0)
            good &= ~(moved[:, 0] > _BACK * size[:, None]).any(axis=1)
        good &= ~active & stable & ~(moved < -_BACK * size[:, None, None]).any(axis=(1, 2))
        held = inner & ~free
        if held.any():
            rests = self._drives(x[:, -1], depths[-1], way) >= -_EVEN * high
            good &= (rests | ~held).all(axis=1)
        return x, good, margin

    @property
    def _length(self) -> float:
        return self.resting.scene.elastocapillary_length

    def _rooms(self, lines: Array, way: int) -> Array:
        """Between which places lines (n, 2) move without passing a corner, (2, n, 2).

        A line at a corner is on that side of it to which it moves.
        """
        known, found = self.resting.profile.joints, np.empty((2, *lines.shape))
        for own, side in ((0, 1), (1, -1)):
            at = np.searchsorted(known, lines[:, own], side="right" if side * way > 0 else "left")
            at = np.clip(at, 1, known.size - 1)
            lo, hi = known[at - 1], known[at]
            found[:, :, own] = (
                lo + _ULPS * np.spacing(np.abs(lo)),
                hi - _ULPS * np.spacing(np.abs(hi)),
            )
        return np.where(np.isfinite(lines), found, lines)

    def _snapped(self, lines: Array) -> Array:
        """Lines next to a corner put on it."""
        known = self.resting.profile.joints
        at = np.clip(np.searchsorted(known, lines), 1, known.size - 1)
        for near in (known[at - 1], known[at]):
            close = np.abs(lines - near) <= 2 * _ULPS * np.spacing(np.abs(near))
            lines = np.where(close, near, lines)
        return lines

    def _drives(self, lines: Array, depth: float, way: int) -> Array:
        """way (D - d) just ahead of lines (n, 2) on this way: negative where they move."""
        found, profile = np.full(lines.shape, -math.inf), self.resting.profile
        inner = np.isfinite(lines[0])
        facing = [At(x, np.asarray(profile.indenter.height(x))) if i else None
                  for i, x in zip(inner, lines.T, strict=True)]  # fmt: skip
        for own, side in ((0, 1), (1, -1)):
            if inner[own]:
                x = lines[:, own]
                f, f1 = profile.beside(x, side * way)
                x = np.nextafter(x, side * way * math.inf)
                rest = self.resting.rest(side, x, f, f1, facing[1 - own], way)
                found[:, own] = way * (rest - depth)
        return found

    def _rest_depths(
        self, x: Array, room: Array, way: int, rates: bool
    ) -> tuple[Array, Array | None]:
        """D of both lines (n, j, 2), and its changes (n, j, 2, 2): of the first with the second."""
        flat, inner = x.reshape(-1, 2), np.isfinite(x[0, 0])
        if inner.all():
            h = _DIFFERENCE * np.minimum(flat[:, 1] - flat[:, 0], self._length)
        else:
            h = np.full(len(flat), _DIFFERENCE * self._length)
        steps = (0, 1, -1) if rates else (0,)
        z = flat[:, :, None] + np.multiply.outer(h, steps)[:, None]
        if rates:
            lo, hi = np.repeat(room, x.shape[1], axis=1)[..., None]
            z[..., 1:] = np.clip(z[..., 1:], lo, hi)
        f, f1 = np.zeros((2, *z.shape))
        for own in np.flatnonzero(inner):
            f[:, own] = self.resting.profile.indenter.height(z[:, own])
            f1[:, own] = self.resting.profile.indenter.slope(z[:, own])
        moved, other = ([0, 1, 2, 0, 0], [0, 0, 0, 1, 2]) if rates else ([0], [0])
        value, rate = np.zeros_like(flat), np.zeros((*flat.shape, 2))
        for own, side in ((0, 1), (1, -1)):
            if not inner[own]:
                continue
            at = (part[:, own, moved].ravel() for part in (z, f, f1))
            facing = (part[:, 1 - own, other].ravel() for part in (z, f))
            rest = self.resting.rest(side, *at, At(*facing) if inner.all() else None, way)
            rest = np.reshape(rest, (-1, len(moved)))
            value[:, own] = rest[:, 0]
            if rates:
                for which, (one, two) in ((own, (1, 2)), (1 - own, (3, 4))):
                    if not inner[which]:
                        continue
                    width = z[:, which, 1] - z[:, which, 2]
                    rate[:, own, which] = (rest[:, one] - rest[:, two]) / width
        return value.reshape(x.shape), rate.reshape(*x.shape, 2) if rates else None

    def _totals(self, lines: Array, depths: Array, way: int) -> tuple[Array, Array, Array]:
        """Energy, the sum of its terms' absolute values, and force of surfaces (n, j, 2)."""
        x, d = lines.reshape(-1, 2), np.tile(depths, len(lines))
        ends: list[At | None] = []
        total = np.zeros((3, d.size))
        for column, sign in ((0, 1.0), (1, -1.0)):
            z = x[:, column]
            if not np.isfinite(z[0]):
                ends.append(None)
                continue
            ends.append(At(z, np.asarray(self.resting.profile.indenter.height(z), float)))
            total += (
                sign * self.integrals.contact(z, d, self.resting.work(way)) * [[1], [sign], [1]]
            )
        energy, force = self.resting.surfaces.stored(*ends, d)
        total += np.array([energy, energy, force])
        shape = lines.shape[:2]
        return tuple(part.reshape(shape) for part in total)  # type: ignore[return-value]


def _solved(rate: Array, off: Array, free: NDArray[np.bool_]) -> Array:
    """The solution (n, j, 2) of rate · step = off for the free lines of each surface, else 0."""
    (a, b), (c, e) = rate[..., 0, :].T, rate[..., 1, :].T  # each (j, n)
    r, s = off.T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        det = a * e - b * c
        both = np.array([(e * r - b * s) / det, (a * s - c * r) / det])
        alone = np.array([r / a, s / e])
    found = np.where(free.all(axis=1), both, alone).T
    return np.where(free[:, None], found, 0.0)


def _margins(rate: Array, free: NDArray[np.bool_]) -> tuple[NDArray[np.bool_], Array]:
    """Whether free lines are stable at all depths (n,), and the square of the stiffness at the end.

    D must grow outwards of every line, and with both lines free their matrix be definite.
    """
    (a, b), (c, e) = rate[..., 0, :].T, rate[..., 1, :].T
    det, both = a * e - b * c, free.all(axis=1)
    stable = (~free[:, 0] | (a > 0)) & (~free[:, 1] | (e < 0)) & (~both | (det < 0))
    least = np.where(both, det, np.where(free[:, 0], a, np.where(free[:, 1], e, math.nan)))
    return np.asarray(stable.all(axis=0)), least[-1] ** 2
