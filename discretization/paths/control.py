"""What holds the indenter: an imposed depth, a dead load, or a spring to a drive.

C(d), the value of the control at which the state at a depth is in equilibrium, is the depth itself,
P(d), or d + P(d)/K for a machine of stiffness K. What happens as the control changes is read off
the path at imposed depths: as the control rises, the depth is where the running maximum of C on the
way down from the present state first reaches it; as it falls, where the running minimum of C on the
way up does. (The indenter moves in the direction in which it is pushed, and stops where P balances
the push.) Where the running extreme is flat the indenter jumps.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Legendre

from discretization.paths.branch import Leg, Point
from discretization.roots import crossings
from discretization.surfaces.network import gauss_lobatto, on_elements, to_legendre
from energy.arrays import Array, Indices
from energy.checks import positive

_DEGREE = 12  # of the polynomials by which C is drawn
_DRAWN = 1e-6  # of the range of P: what C, as it is drawn on a part of a leg, may be off by
_FINEST = 1 / 256  # of a leg: parts that short are not halved again
_LEAST = 128  # samples of a leg where P is only known between nodes
_RESOLVED = 1e-12  # of the range of C around a peak: what it may be off by there
_ZOOMS = 40  # rounds, each of which narrows a peak or finds it
_NARROWER = 0.15  # of the last, somewhat more than its Gauss-Lobatto points are apart
_WIDER = 1e-9  # of the distance of two samples: a zero may lie so far beyond one
_NOISE = 100.0  # times the rounding of C: by less it does not turn
_FELT = 8.0  # times the same: less is nothing but rounding
_EPSILON = 2e-16  # of depths
_ROUNDING = 1e-15  # of what C is made of


@dataclass(frozen=True)
class Control:
    """stiffness K: None for an imposed depth, 0 for a dead load."""

    stiffness: float | None

    @classmethod
    def of(cls, given: str, stiffness: Any) -> Control:
        """What holds an indenter of which this is given: "depth", "force" or "drive"."""
        if given == "drive":
            positive("machine_stiffness", stiffness)
        return cls({"depth": None, "force": 0.0}.get(given, stiffness))

    def value(self, depth: Any, force: Any) -> Any:
        """C: the value at which this force balances; numbers or arrays."""
        if self.stiffness is None:
            return depth
        return depth + force / self.stiffness if self.stiffness else force

    def work(self, start: float, end: float, value: float) -> float:
        """What the load does on an indenter that moves at this value: 0, F Δd or ∫K (D - d) dd."""
        if self.stiffness is None or start == end:
            return 0.0
        return self.load((start + end) / 2, value) * (end - start)

    def load(self, depth: float, value: float) -> float:
        """Of what holds the indenter, at a depth and a value of the control."""
        return self.stiffness * (value - depth) if self.stiffness else value


class Curve(NamedTuple):
    """C on a leg at t (j,), monotone in between.

    ends, nodal: of the parts of the leg on which C is a polynomial of t, and C at the Gauss-Lobatto
    points of all of them; none where P is only known between nodes. rounding: of C.
    """

    leg: Leg
    control: Control
    t: Array
    value: Array
    ends: Array
    nodal: Array
    rounding: float

    @classmethod
    def of(cls, leg: Leg, control: Control) -> Curve:
        """Drawn by polynomials on parts of the leg, halved until they represent C."""
        rounding, todo = _rounding(leg, control), [(0.0, 1.0)]
        if not leg.smooth:
            t = at_changes(leg)
            return cls.sampled(leg, control, t, _values(leg, control, t))
        parts = list[tuple[Array, Array, Legendre]]()
        while todo:
            drawn, halves = _drawn(leg, control, todo, roughly=True), list[tuple[float, float]]()
            for (low, high), (t, value, series, off) in zip(todo, drawn, strict=True):
                pushed = value - control.value(leg.depths(t), 0.0)
                if high - low > _FINEST and off > _DRAWN * np.ptp(pushed) + _FELT * rounding:
                    halves += [(low, (low + high) / 2), ((low + high) / 2, high)]
                else:
                    parts.append((t, value, series))
            todo = halves
        parts.sort(key=lambda part: float(part[0][0]))
        ends = np.array([0.0, *(at[-1] for at, _, _ in parts)])
        nodal = np.append(parts[0][1][0], [value[1:] for _, value, _ in parts])
        turns = np.concatenate([_turns(fit) for *_, fit in parts])
        more = _values(leg, control, turns, roughly=True) if turns.size else turns
        at = np.concatenate([[0.0], *(at[1:] for at, _, _ in parts), turns])
        t, first = np.unique(at, return_index=True)
        return cls(leg, control, t, np.append(nodal, more)[first], ends, nodal, rounding)

    @classmethod
    def sampled(cls, leg: Leg, control: Control, t: Array, value: Array) -> Curve:
        """Of a leg where P is only known between nodes, with C at samples t (j,)."""
        none = np.empty(0)
        return cls(leg, control, t, value, none, none, _rounding(leg, control))

    def peak(self, side: int) -> int:
        """The first sample after which exact C falls (side 1) or rises (-1); the last if none."""
        for i in np.flatnonzero(side * np.diff(self.value) < -_NOISE * self.rounding).tolist():
            start, after = side * _values(self.leg, self.control, self.t[i : i + 2])
            if after - start < -_NOISE * self.rounding:
                return int(i)
        return self.value.size - 1

    def refined(self, i: int, side: int) -> Point:
        """The peak at an inner sample, to rounding, by polynomials on less and less around it.

        At first where C is less by no more than it may be off, before it passes the peak again.
        """
        known = _DRAWN * np.ptp(self.value) if self.ends.size else _NOISE * self.rounding
        t, more = self.t, side * (self.value - self.value[i])
        last = i + int(np.argmax(np.append(more[i:], 1.0) > 0)) - 1
        low = t[:i][more[:i] < -known].max(initial=0.0)
        high = t[i:last][more[i:last] < -known].min(initial=t[last])
        for _ in range(_ZOOMS):
            ((t, value, series, off),) = _drawn(self.leg, self.control, [(low, high)])
            top, turns = float(t[np.argmax(side * value)]), _turns(series)
            if turns.size and off <= _RESOLVED * np.ptp(value) + _FELT * self.rounding:
                top = float(turns[np.argmin(np.abs(turns - top))])
                break
            reach = _NARROWER * (high - low)
            low, high = max(top - reach, low), min(top + reach, high)
            if np.ptp(value) <= _FELT * self.rounding or not low < high:
                break
        if low == 0:
            start, peak = side * _values(self.leg, self.control, np.array([0.0, top]))
            if start >= peak - _ROUNDING * abs(peak):  # d hardly changes with t there
                top = 0.0
        return self.leg.points(self.leg.depths(np.array([top])))[0]

    def reached(self, values: Array, side: int, first: int, stop: int | None = None) -> list[Point]:
        """Where C first reaches values (n,) from one sample to another, as many as it reaches."""
        highest = np.maximum.accumulate(side * self.value[first:stop])
        before = side * self.value[max(first - 1, 0)]  # a peak from which C falls
        k = np.searchsorted(highest, np.maximum(side * values, before))
        k = k[k < highest.size]
        found, inner = self.t[first + k], k > 0
        if inner.any():
            found[inner] = self._crossings(values[: k.size][inner], first + k[inner])
        return self.leg.points(self.leg.depths(found))

    def _crossings(self, values: Array, k: Indices) -> Array:
        """t at which C is each value (n,), between the samples k - 1 and k."""
        low, high, noise = self.t[k - 1], self.t[k], self.rounding
        wider = _WIDER * (high - low)  # the samples are only as good as the polynomial
        rise = (self.value[k] - self.value[k - 1]) / (high - low)
        guess = np.clip(low + (values - self.value[k - 1]) / rise, low, high)
        if self.ends.size:
            drawn = functools.partial(on_elements, self.ends, self.nodal)
            guess = crossings(lambda t, i: drawn(t)[0] - values[i], low, high, guess, rise, noise)
            rise = drawn(guess)[1]
        low, high = np.maximum(low - wider, 0.0), np.minimum(high + wider, 1.0)
        return crossings(
            lambda t, i: _values(self.leg, self.control, t) - values[i],
            *(low, high, guess, rise, noise),
        )


def _values(leg: Leg, control: Control, t: Array, *, roughly: bool = False) -> Array:
    depths = leg.depths(t)
    return np.asarray(control.value(depths, leg.forces(depths, roughly=roughly)), float)


def _rounding(leg: Leg, control: Control) -> float:
    """Of C on a leg."""
    deepest = max(abs(leg.start.depth), abs(leg.end.depth))
    return float(control.value(_EPSILON * deepest, leg.rounding))


def evenly_spaced() -> Array:
    """t at which every leg is sampled where P is only known between nodes."""
    return np.linspace(0, 1, _LEAST)


def at_changes(leg: Any) -> Array:
    """t at which links are passed, and at least some others."""
    span = leg.end.depth - leg.start.depth or 1.0
    share = (np.array([depth for depth, _ in leg.trace]) - leg.start.depth) / span
    passed = 0.5 - np.sin(np.arcsin(1 - 2 * np.clip(share, 0, 1)) / 3)  # of `Leg.depths`
    return np.union1d(evenly_spaced(), passed)


def _drawn(
    leg: Leg, control: Control, parts: list[tuple[float, float]], *, roughly: bool = False
) -> Iterator[tuple[Array, Array, Legendre, float]]:
    """t at Gauss-Lobatto points of parts, C there, the polynomial, and what it may be off by."""
    t = np.array([np.interp(gauss_lobatto(_DEGREE)[0], [-1.0, 1.0], ends) for ends in parts])
    values = _values(leg, control, t.ravel(), roughly=roughly).reshape(t.shape)
    for at, value, ends in zip(t, values, parts, strict=True):
        series = Legendre(value @ to_legendre(_DEGREE), domain=ends)
        yield at, value, series, 2 * float(np.abs(series.coef[-2:]).max())


def _turns(series: Legendre) -> Array:
    """Where a polynomial turns."""
    turns = series.deriv().trim(_ROUNDING * float(np.abs(series.coef).max())).roots()
    low, high = series.domain
    inside = (turns.real > low) & (turns.real < high)
    return np.asarray(turns.real[inside & (np.abs(turns.imag) <= 1e-6)])
