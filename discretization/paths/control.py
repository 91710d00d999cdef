"""What holds the indenter: an imposed depth, a dead load, or a spring to a drive.

C(d), the value of the control at which the state at a depth is in equilibrium, is the depth itself,
P(d), or d + P(d)/K for a machine of stiffness K. What happens as the control changes is read off
the path at imposed depths: as the control rises, the depth is where the running maximum of C, on
the path down from the present state, first reaches it; as it falls, where the running minimum of C
does, on the path up. (The indenter moves in the direction in which it is pushed, and stops where P
balances the push.) Where the running extreme is flat the indenter jumps.

Conventions
-----------
The depth d is positive down into the layer [length]. The force P is positive where the indenter is
pressed; for a line contact it is that per length. The value of a control is a depth, a force F that
presses the indenter, or the position D of the far end of a machine's spring, positive down: the
spring presses with K (D - d).

`side` is 1 where the value rises, and with it the depth, and -1 where both fall: side · C has its
running maximum in either case, and a peak is a maximum of that.

A segment (`PathSegment`) is a part of the path in depth between two events, over which t runs from
0 to 1; `depths(t)` are its depths, `forces(depths)` is P there, and `points(depths)` are the
contacts. C is represented by values at Gauss-Lobatto points of parts of the segment, and by the
Legendre series of the polynomials through these.

`PathSegment.smooth` is whether P is a smooth function of d on it; on nodes it is not, as lines pass
links. `gauss_lobatto(degree)` has degree + 1 points from -1 to 1, both ends among them; values at
these times the matrix `to_legendre` are Legendre coefficients (`coef`), and `on_elements(ends,
values, t)` are the polynomials through such values on each element, and their slopes, at t.
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

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 6 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.paths.control`.

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
        K of the machine [force/length, or force/length² for a line contact]; None for an imposed
        depth, as of an infinitely stiff machine, 0 for a dead load.
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
        """C, the value of the control at which a state of this depth and force is in equilibrium.

        Numbers or arrays.
        """
        if self.stiffness is None:
            return depth
        return depth + force / self.stiffness if self.stiffness else force

    def work(self, start: float, end: float, value: float) -> float:
        """The work of the control on the indenter as this moves between two depths.

        It is 0, F Δd or ∫K (D - d) dd with the value F or D, which stays; the force is linear in d,
        so it is that at the mean depth times the distance.
        """
        if self.stiffness is None or start == end:
            return 0.0
        return self.load((start + end) / 2, value) * (end - start)

    def load(self, depth: float, value: float) -> float:
        """The force that a dead load, or a machine at a depth and a value, exerts."""
        return self.stiffness * (value - depth) if self.stiffness else value


class Curve(NamedTuple):
    """C on a segment, monotone between samples.

    Attributes
    ----------
    segment : PathSegment
    control : Control
    t, value : ndarray (j,)
        Samples of the segment, increasing from 0 to 1, and C there. Peaks of C are among them.
    ends : ndarray (p + 1,)
        t at the ends of the p parts of the segment on which C is a polynomial; empty where P is
        only known between nodes.
    nodal : ndarray (12 p + 1,)
        C at the Gauss-Lobatto points of all parts, of which neighbours share their end; or empty.
    rounding : float
        What rounding leaves of C.
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
        # Each part begins with the point at which the one before ends.
        nodal = np.append(parts[0].value[0], [part.value[1:] for part in parts])
        # Where the polynomials turn C has its peaks: there it is sampled as well.
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

        By more than rounding, that is. The values of samples may be those of polynomials; so where
        these fall, it is looked at whether exact C does. The last sample if there is none.
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

        Parameters
        ----------
        i : int
            The number of the sample, as of `peak`.
        side : {1, -1}
            1 for a maximum of C, -1 for a minimum.

        Returns
        -------
        Point
            The contacts at the peak.
        """
        off = (  # what the values of samples may be off by
            _CURVE.drawn * np.ptp(self.value) if self.ends.size else _CURVE.noise * self.rounding
        )
        low, high = self._around(i, side, off)
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
            # Next to t = 0 the depth hardly changes with t: the peak may be the start itself.
            start, peak = side * _values(self.segment, self.control, np.array([0.0, top]))
            if start >= peak - _CURVE.rounding * abs(peak):
                top = 0.0
        return self.segment.points(self.segment.depths(np.array([top])))[0]

    def _around(self, i: int, side: int, off: float) -> tuple[float, float]:
        """t before and after a peak at the sample i, where C is less by more than it may be `off`.

        After the peak no further than the last sample before C passes it; before it down to 0.
        """
        more = side * (self.value - self.value[i])
        last = i + int(np.argmax(np.append(more[i:], 1.0) > 0)) - 1
        low = self.t[:i][more[:i] < -off].max(initial=0.0)
        high = self.t[i:last][more[i:last] < -off].min(initial=self.t[last])
        return low, high

    def reached(self, values: Array, side: int, first: int, stop: int | None = None) -> list[Point]:
        """The contacts where C first reaches each of some values, from one sample to another.

        Parameters
        ----------
        values : ndarray (n,)
            Of the control, in the order in which it changes.
        side : {1, -1}
            1 where they rise, -1 where they fall.
        first, stop : int
            Numbers of the first sample, and of the one after the last; None: of all.

        Returns
        -------
        list of Point
            As many as are reached, in the order of the values.
        """
        highest = np.maximum.accumulate(side * self.value[first:stop])
        # If the sample before the first one is a peak from which C falls, values below it have been
        # reached there: then only what reaches it again counts.
        before = side * self.value[max(first - 1, 0)]
        k = np.searchsorted(highest, np.maximum(side * values, before))
        k = k[k < highest.size]
        found = self.t[first + k]
        inner = k > 0  # a value reached between two samples; the first of all is taken as it is
        if inner.any():
            found[inner] = self._crossings(values[: k.size][inner], first + k[inner])
        return self.segment.points(self.segment.depths(found))

    def _crossings(self, values: Array, k: Indices) -> Array:
        """t (n,) at which C is each value (n,), between the samples k - 1 and k (n,).

        First where the polynomials are, then, from there on, where exact C is.
        """
        low = self.t[k - 1]
        high = self.t[k]
        noise = self.rounding
        # Values at samples are only as good as the polynomials: exact C may be the value a little
        # beyond one of them.
        wider = _CURVE.wider * (high - low)
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
    """C on a part of a segment.

    Attributes
    ----------
    t, value : ndarray (13,)
        Gauss-Lobatto points of the part, its ends among them, and C there.
    series : Legendre
        The polynomial of t through these.
    off : float
        What it may be off by: twice the larger one of its last two coefficients.
    """

    t: Array
    value: Array
    series: Legendre
    off: float


def _values(segment: PathSegment, control: Control, t: Array, *, roughly: bool = False) -> Array:
    """C (j,) on a segment at t (j,); roughly: with P as good as `PathSegment.forces` draws it."""
    depths = segment.depths(t)
    return np.asarray(control.value(depths, segment.forces(depths, roughly=roughly)), float)


def _rounding(segment: PathSegment, control: Control) -> float:
    """What rounding leaves of C on a segment, from that of the depth and of P.

    `Control.value` is linear, but may have a constant, which is subtracted and rounds by itself.
    """
    deepest = max(abs(segment.start.depth), abs(segment.end.depth))
    constant = control.value(0.0, 0.0)
    rounding = control.value(_CURVE.epsilon * deepest, segment.rounding) - constant
    return float(rounding + _CURVE.rounding * abs(constant))


def evenly_spaced() -> Array:
    """t at which every segment is sampled where P is only known between nodes."""
    return np.linspace(0, 1, _CURVE.least)


def at_changes(segment: Any) -> Array:
    """t at which lines pass links of nodes on a segment, and some evenly spaced ones, increasing.

    segment: one with a `trace`, depths at which links are passed with the nodes from there on.
    """
    span = segment.end.depth - segment.start.depth or 1.0
    share = (np.array([depth for depth, _ in segment.trace]) - segment.start.depth) / span
    # The inverse of share = t² (3 - 2t), by which `PathSegment.depths` vary.
    passed = 0.5 - np.sin(np.arcsin(1 - 2 * np.clip(share, 0, 1)) / 3)
    return np.union1d(evenly_spaced(), passed)


def _representing(segment: PathSegment, control: Control, rounding: float) -> list[_Part]:
    """The parts of a segment, in their order, on each of which one polynomial represents C.

    All parts that are not represented yet are halved at once; see `Curve.of` for when one is.

    rounding: what rounding leaves of C.
    """
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
    """C on the parts of a segment with these ends (t at the first and the last point of each).

    roughly: with P only as good as `PathSegment.forces` draws it.
    """
    points = gauss_lobatto(_CURVE.degree).points
    t = np.array([np.interp(points, [-1.0, 1.0], both) for both in ends])
    values = _values(segment, control, t.ravel(), roughly=roughly).reshape(t.shape)
    for at, value, both in zip(t, values, ends, strict=True):
        series = Legendre(value @ to_legendre(_CURVE.degree), domain=both)
        yield _Part(at, value, series, 2 * float(np.abs(series.coef[-2:]).max()))


def _turns(series: Legendre) -> Array:
    """t inside its domain at which a polynomial turns: real roots of its derivative."""
    rounding = _CURVE.rounding * float(np.abs(series.coef).max())
    roots = series.deriv().trim(rounding).roots()
    low, high = series.domain
    inside = (roots.real > low) & (roots.real < high)
    return np.asarray(roots.real[inside & (np.abs(roots.imag) <= _CURVE.imaginary)])
