"""The work done on a load path, and its most tensile state, from the states recorded."""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence

import numpy as np
from numpy.polynomial import Legendre, Polynomial

from discretization.paths.branch import Branch, Leg, legs
from discretization.paths.control import Control, Curve
from discretization.paths.events import Event, PullOff, Snapshot

Run = list[Snapshot]
LOAD = Control(0.0)
_DRAWN = 1e-8  # of the range of P: its integral is known to the square
_NOISE = 1e-13  # of the largest force: a force is no less than another by less


def work(branch: Branch, hold: Control, parts: Sequence[Run | Event]) -> float:
    """∫P dd over the parts of a path, and of the load `hold` while the state jumped."""
    total = sum(_work(leg) for run in _runs(parts) for leg in _legs(branch, run))
    for event in parts:
        if isinstance(event, Event):
            total += hold.work(event.before.depth, event.after.depth, event.control)
    return total


def _work(leg: Leg) -> float:
    """∫P dd, exact for the polynomials of t that are P: dd/dt is one as well."""
    if not leg.branch.smooth:
        return leg.work()
    found, far = 0.0, leg.end.depth - leg.start.depth
    for force in Curve.of(leg, LOAD, _DRAWN, roughly=False).series:
        rate = Polynomial([0.0, 6 * far, -6 * far]).convert(force.domain, Legendre)
        sums = (force * rate).integ()
        found += float(np.diff(sums(force.domain))[0])
    return found


def most_tensile(branch: Branch, parts: Sequence[Run | Event]) -> PullOff:
    """The state of least force. ValueError if no force is tensile."""
    found = [least for run in _runs(parts) for least in (*run, *_turns(branch, run))]
    if not found or min(state.force for state in found) >= 0:
        least = min((state.force for state in found), default=math.inf)
        raise ValueError(
            f"least force = {least!r} of this path is not tensile; retract the indenter further"
        )
    state = min(found, key=lambda state: state.force)
    return PullOff(state.force, state.depth, state.half_width)


def _runs(parts: Sequence[Run | Event]) -> list[Run]:
    """Those of the states in contact."""
    runs = [part for part in parts if isinstance(part, list)]
    return [run for part in runs if (run := [s for s in part if not math.isnan(s.left)])]


def _turns(branch: Branch, run: Run) -> Iterator[Snapshot]:
    """The states of a run that goes one way at which P is least, between those recorded."""
    if not branch.smooth:
        return
    for leg in _legs(branch, run):
        curve = Curve.of(leg, LOAD)
        least, ends = int(np.argmin(curve.value)), curve.value[[0, -1]]
        if curve.value[least] < ends.min() - _NOISE * np.abs(curve.value).max():
            (point,) = leg.points(leg.depths(np.array([curve.refined(least, -1)])))
            yield branch.snapshot(point)


def _legs(branch: Branch, run: Run) -> Iterator[Leg]:
    """The legs from the first state of a run to the last."""
    start = branch.contact(run[0].depth, *run[0].lines)
    return legs(branch, start, run[-1].depth)
