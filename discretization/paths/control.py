"""What holds the indenter: an imposed depth, a dead load, or a spring to a drive.

C(d), the value of the control at which the state at a depth is in equilibrium, is the depth itself,
P(d), or d + P(d)/K for a machine of stiffness K. What happens as the control changes is read off
the path at imposed depths: as the control rises, the depth is where the running maximum of C, on
the path down from the present state, first reaches it; as it falls, where the running minimum of C
does, on the path up. (The indenter moves in the direction in which it is pushed, and stops where P
balances the push.) Where the running extreme is flat the indenter jumps.
"""

from __future__ import annotations

import functools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial import Legendre

from discretization.paths.branch import PathSegment, Point
from discretization.roots import crossings
from discretization.surfaces.network import gauss_lobatto, on_elements, to_legendre
from energy.arrays import Array, Indices
from energy.checks import positive


class CurveRules(NamedTuple):
    """How C on a segment is represented, and how its peaks are refined.

    Attributes
    ----------
    degree : int
        Of the polynomials that represent C: chosen, like `drawn`, by the time of load paths. No
        result depends on them by more than `drawn`, as peaks and crossings are refined with exact
        C.
    drawn : float
        Of the range of P: what C may be off by on a part of a segment.
    finest : float
        Of a segment: parts that short are not halved again.
    least : int
        Samples of a segment where P is only known between nodes.
    resolved : float
        Of the range of C around a peak: what it may be off by there.
    zooms : int
        Rounds, each of which narrows a peak to 0.3 of its interval or finds it.
    narrower : float
        Of the last interval on each side of a peak: its Gauss-Lobatto points are 0.12 apart.
    wider : float
        Of the distance of two samples: a zero may lie so far beyond one.
    imaginary : float
        Of t: roots of C' whose imaginary part is less are real but for rounding.
    noise : float
        Times the rounding of C: by less it does not turn.
    felt : float
        Times the same: less is nothing but rounding.
    epsilon : float
        Rounding of depths, relative to them.
    rounding : float
        Of the terms of C.
    """

    degree: int = 12
    drawn: float = 1e-6
    finest: float = 1 / 256
    least: int = 128
    resolved: float = 1e-12
    zooms: int = 40
    narrower: float = 0.15
    wider: float = 1e-9
    imaginary: float = 1e-6
    noise: float = 100.0
    felt: float = 8.0
    epsilon: float = 2e-16
    rounding: float = 1e-15


_CURVE = CurveRules()


@dataclass(frozen=True)
class Control:
    """An imposed depth, a dead load, or a machine.

    Attributes
    ----------
    stiffness : float or None
        K [force/length²]: None for an imposed depth, 0 for a dead load.
    """

    stiffness: float | None

    @classmethod
    def of(cls, given: str, stiffness: Any) -> Control:
        """The control of a programme.

        Parameters
        ----------
        given : {"depth", "force", "drive"}
        stiffness : float or None
            K of the machine, for drives [force/length²].

        Returns
        -------
        Control

        Raises
        ------
        ValueError
            If the stiffness of a machine is not positive.
        """
        if given == "drive":
            positive("machine_stiffness", stiffness)
        return cls({"depth": None, "force": 0.0}.get(given, stiffness))

    def value(self, depth: Any, force: Any) -> Any:
        """C, the value at which this force balances; numbers or arrays."""
        if self.stiffness is None:
            return depth
        return depth + force / self.stiffness if self.stiffness else force

    def work(self, start: float, end: float, value: float) -> float:
        """The work of the load as the indenter moves at this value: 0, F Δd or ∫K (D - d) dd."""
        if self.stiffness is None or start == end:
            return 0.0
        return self.load((start + end) / 2, value) * (end - start)

    def load(self, depth: float, value: float) -> float:
        """The force that the control exerts at a depth and a value of it."""
        return self.stiffness * (value - depth) if self.stiffness else value


class Curve(NamedTuple):
    """C on a segment, monotone between samples.

    Attributes
    ----------
    segment : PathSegment
    control : Control
    t, value : ndarray (j,)
        Samples of the segment, t from 0 to 1, and C there.
    ends, nodal : ndarray
        Of the parts of the segment on which C is a polynomial of t, and C at the Gauss-Lobatto
        points of all of them; empty where P is only known between nodes.
    rounding : float
        Of C.
    """

    segment: PathSegment
    control: Control
    t: Array
    value: Array
    ends: Array
    nodal: Array
    rounding: float

    @classmethod
    def of(cls, segment: PathSegment, control: Control) -> Curve:
        """C by polynomials on parts of the segment, which are halved until these represent it.

        A part is not halved any further if its last two coefficients c of degree 12 are

            2 max |c| <= 1e-6 (largest less smallest P) + 8 roundings of C,

        or if it is 1/256 of the segment.

        Parameters
        ----------
        segment : PathSegment
        control : Control

        Returns
        -------
        Curve
        """
        if not segment.smooth:
            t = at_changes(segment)
            return cls.sampled(segment, control, t, _values(segment, control, t))
        rounding = _rounding(segment, control)
        parts = _representing(segment, control, rounding)
        ends = np.array([0.0, *(part.t[-1] for part in parts)])
        nodal = np.append(parts[0].value[0], [part.value[1:] for part in parts])
        turns = np.concatenate([_turns(part.series) for part in parts])
        at_turns = _values(segment, control, turns, roughly=True) if turns.size else turns
        samples = np.concatenate([[0.0], *(part.t[1:] for part in parts), turns])
        t, first = np.unique(samples, return_index=True)
        return cls(segment, control, t, np.append(nodal, at_turns)[first], ends, nodal, rounding)

    @classmethod
    def sampled(cls, segment: PathSegment, control: Control, t: Array, value: Array) -> Curve:
        """The curve of a segment where P is only known between nodes, with C at samples t (j,)."""
        none = np.empty(0)
        return cls(segment, control, t, value, none, none, _rounding(segment, control))

    def peak(self, side: int) -> int:
        """The number of the first sample after which exact C falls (side 1) or rises (-1).

        The last one if there is none.
        """
        for i in np.flatnonzero(
            side * np.diff(self.value) < -_CURVE.noise * self.rounding
        ).tolist():
            start, after = side * _values(self.segment, self.control, self.t[i : i + 2])
            if after - start < -_CURVE.noise * self.rounding:
                return int(i)
        return self.value.size - 1

    def refined(self, i: int, side: int) -> Point:
        """The peak at an inner sample, to rounding, by polynomials on less and less around it.

        The search ends where a polynomial that turns represents C,

            2 max |c| <= 1e-12 (largest less smallest C) + 8 roundings of C,

        where C varies by no more than 8 roundings, or after 40 rounds. It begins with the part
        around the peak on which C is less by no more than it may be off.
        """
        known = (
            _CURVE.drawn * np.ptp(self.value) if self.ends.size else _CURVE.noise * self.rounding
        )
        low, high = self._around(i, side, known)
        for _ in range(_CURVE.zooms):
            (part,) = _parts(self.segment, self.control, [(low, high)])
            top = float(part.t[np.argmax(side * part.value)])
            turns = _turns(part.series)
            spread = np.ptp(part.value)
            if turns.size and part.off <= _CURVE.resolved * spread + _CURVE.felt * self.rounding:
                top = float(turns[np.argmin(np.abs(turns - top))])
                break
            reach = _CURVE.narrower * (high - low)
            low = max(top - reach, low)
            high = min(top + reach, high)
            if spread <= _CURVE.felt * self.rounding or not low < high:
                break
        if low == 0:
            start, peak = side * _values(self.segment, self.control, np.array([0.0, top]))
            if start >= peak - _CURVE.rounding * abs(peak):  # d hardly changes with t there
                top = 0.0
        return self.segment.points(self.segment.depths(np.array([top])))[0]

    def _around(self, i: int, side: int, known: float) -> tuple[float, float]:
        """t before and after a peak at a sample, where C is less by more than it may be off."""
        more = side * (self.value - self.value[i])
        last = i + int(np.argmax(np.append(more[i:], 1.0) > 0)) - 1  # before C passes the peak
        low = self.t[:i][more[:i] < -known].max(initial=0.0)
        high = self.t[i:last][more[i:last] < -known].min(initial=self.t[last])
        return low, high

    def reached(self, values: Array, side: int, first: int, stop: int | None = None) -> list[Point]:
        """Where C first reaches values, from one sample to another.

        Parameters
        ----------
        values : ndarray (n,)
            Of the control, in the order in which it changes.
        side : {1, -1}
            Whether they rise or fall.
        first, stop : int
            Numbers of samples.

        Returns
        -------
        list of Point
            As many as are reached.
        """
        highest = np.maximum.accumulate(side * self.value[first:stop])
        before = side * self.value[max(first - 1, 0)]  # a peak from which C falls
        k = np.searchsorted(highest, np.maximum(side * values, before))
        k = k[k < highest.size]
        found = self.t[first + k]
        inner = k > 0
        if inner.any():
            found[inner] = self._crossings(values[: k.size][inner], first + k[inner])
        return self.segment.points(self.segment.depths(found))

    def _crossings(self, values: Array, k: Indices) -> Array:
        """t at which C is each value (n,), between the samples k - 1 and k."""
        low = self.t[k - 1]
        high = self.t[k]
        noise = self.rounding
        wider = _CURVE.wider * (high - low)  # the samples are only as good as the polynomial
        rise = (self.value[k] - self.value[k - 1]) / (high - low)
        guess = np.clip(low + (values - self.value[k - 1]) / rise, low, high)
        if self.ends.size:
            drawn = functools.partial(on_elements, self.ends, self.nodal)
            guess = crossings(lambda t, i: drawn(t)[0] - values[i], low, high, guess, rise, noise)
            rise = drawn(guess)[1]
        low = np.maximum(low - wider, 0.0)
        high = np.minimum(high + wider, 1.0)

        def off(t: Array, i: Indices) -> Array:
            """Exact C less the values."""
            return _values(self.segment, self.control, t) - values[i]

        return crossings(off, low, high, guess, rise, noise)


class _Part(NamedTuple):
    """C on a part of a segment: at Gauss-Lobatto points t, as a polynomial, and its error."""

    t: Array
    value: Array
    series: Legendre
    off: float


def _values(segment: PathSegment, control: Control, t: Array, *, roughly: bool = False) -> Array:
    """C on a segment at t (j,)."""
    depths = segment.depths(t)
    return np.asarray(control.value(depths, segment.forces(depths, roughly=roughly)), float)


def _rounding(segment: PathSegment, control: Control) -> float:
    """The rounding of C on a segment."""
    deepest = max(abs(segment.start.depth), abs(segment.end.depth))
    constant = control.value(0.0, 0.0)
    rounding = control.value(_CURVE.epsilon * deepest, segment.rounding) - constant
    return float(rounding + _CURVE.rounding * abs(constant))


def evenly_spaced() -> Array:
    """t at which every segment is sampled where P is only known between nodes."""
    return np.linspace(0, 1, _CURVE.least)


def at_changes(segment: Any) -> Array:
    """t at which links are passed, and at least some others."""
    span = segment.end.depth - segment.start.depth or 1.0
    share = (np.array([depth for depth, _ in segment.trace]) - segment.start.depth) / span
    passed = 0.5 - np.sin(np.arcsin(1 - 2 * np.clip(share, 0, 1)) / 3)  # of `PathSegment.depths`
    return np.union1d(evenly_spaced(), passed)


def _representing(segment: PathSegment, control: Control, rounding: float) -> list[_Part]:
    """The parts of a segment, in their order, on each of which one polynomial represents C."""
    found = list[_Part]()
    todo = [(0.0, 1.0)]
    while todo:
        halves = list[tuple[float, float]]()
        parts = _parts(segment, control, todo, roughly=True)
        for (low, high), part in zip(todo, parts, strict=True):
            force = part.value - control.value(segment.depths(part.t), 0.0)  # what C has of P
            allowed = _CURVE.drawn * np.ptp(force) + _CURVE.felt * rounding
            if high - low > _CURVE.finest and part.off > allowed:
                middle = (low + high) / 2
                halves += [(low, middle), (middle, high)]
            else:
                found.append(part)
        todo = halves
    return sorted(found, key=lambda part: float(part.t[0]))


def _parts(
    segment: PathSegment,
    control: Control,
    ends: list[tuple[float, float]],
    *,
    roughly: bool = False,
) -> Iterator[_Part]:
    """C on parts of a segment between these ends, all at once."""
    points = gauss_lobatto(_CURVE.degree).points
    t = np.array([np.interp(points, [-1.0, 1.0], both) for both in ends])
    values = _values(segment, control, t.ravel(), roughly=roughly).reshape(t.shape)
    for at, value, both in zip(t, values, ends, strict=True):
        series = Legendre(value @ to_legendre(_CURVE.degree), domain=both)
        yield _Part(at, value, series, 2 * float(np.abs(series.coef[-2:]).max()))


def _turns(series: Legendre) -> Array:
    """t at which a polynomial turns."""
    rounding = _CURVE.rounding * float(np.abs(series.coef).max())
    roots = series.deriv().trim(rounding).roots()
    low, high = series.domain
    inside = (roots.real > low) & (roots.real < high)
    return np.asarray(roots.real[inside & (np.abs(roots.imag) <= _CURVE.imaginary)])
