"""The work done on a load path, and its most tensile state, from the states recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from itertools import chain, pairwise

import numpy as np

from discretization.fitted.spectral import rounded
from discretization.paths.branch import Branch, Point
from discretization.paths.control import Control, moved, point_of_fold
from discretization.paths.events import Event, PullOff, Snapshot

Segment = tuple[Snapshot, Snapshot]
_ENOUGH = 33  # states of a run: between fewer, others are looked at
_FEW, _MORE = 6, 10  # degrees of rules to compare; with the ends, as a kink may be beside one
_WORK = 1e-12  # of the integral of a force that is smooth between events


def work(
    branch: Branch, hold: Control, segments: Sequence[Segment], events: Sequence[Event]
) -> float:
    """∫P dd over the segments, and of the load `hold` while the state jumped."""
    total = 0.0
    for start, end in segments:
        state = branch.contact(start.depth, *start.lines)
        total += branch.work(state, start.depth, end.depth)
    for event in events:
        depths = event.before.depth, event.after.depth
        before, after = (hold.potential(depth, event.control) for depth in depths)
        total += before - after
    return total


def integral(
    force: Callable[[float], float], start: float, end: float, rtol: float = _WORK
) -> float:
    """∫P dd by Lobatto rules, on parts halved until fewer points agree to rtol of the whole."""
    if start == end:
        return 0.0

    def part(lo: float, hi: float, order: int) -> tuple[float, float]:
        points, weights, _ = rounded(order)
        depths = [lo, *(lo + (points[1:-1] + 1) / 2 * (hi - lo)).tolist(), hi]
        forces = np.array([force(depth) for depth in depths])
        weights = weights * ((hi - lo) / 2)
        return float(weights @ forces), float(np.abs(weights) @ np.abs(forces))

    size = part(start, end, _FEW)[1]
    done, parts = 0.0, [(start, end)]
    while parts:
        lo, hi = parts.pop()
        fine = part(lo, hi, _MORE)[0]
        middle = (lo + hi) / 2
        if abs(fine - part(lo, hi, _FEW)[0]) <= rtol * size or middle in (lo, hi):
            done += fine
        else:
            parts += [(lo, middle), (middle, hi)]
    return done


def most_tensile(branch: Branch, segments: Sequence[Segment]) -> PullOff:
    """The state of least force. ValueError if no force is tensile."""
    states = [_least(branch, run) for run in _runs(segments)]
    if not states or min(state.force for state in states) >= 0:
        least = min((state.force for state in states), default=math.inf)
        raise ValueError(
            f"least force = {least!r} of this path is not tensile; retract the indenter further"
        )
    found = min(states, key=lambda state: state.force)
    return PullOff(found.force, found.depth, found.half_width)


def _runs(segments: Sequence[Segment]) -> list[list[Snapshot]]:
    """The segments joined where the path goes straight on."""
    runs: list[list[Snapshot]] = []
    for start, end in segments:
        on = runs and runs[-1][-1] == start and len(runs[-1]) > 1
        if on and (runs[-1][-1].depth - runs[-1][-2].depth) * (end.depth - start.depth) >= 0:
            runs[-1].append(end)
        else:
            runs.append([start, end])
    return runs


def _least(branch: Branch, run: list[Snapshot]) -> Snapshot:
    """The least force of a run that goes one way, between the states recorded as well."""
    if not branch.smooth:
        return min(run, key=lambda state: state.force)
    while len(run) < _ENOUGH and run[0].depth != run[-1].depth:
        halved = chain(*((a, _middle(branch, a, b)) for a, b in pairwise(run)))
        run = [*halved, run[-1]]
    least = min(range(len(run)), key=lambda i: run[i].force)
    beside = sorted(run[max(least - 1, 0) : least + 2], key=lambda state: state.depth)
    low, high = (_point(branch, state) for state in (beside[0], beside[-1]))
    fold = point_of_fold(branch, Control(0.0), high, low)
    return min(run[least], _snapshot(branch, fold), key=lambda state: state.force)


def _middle(branch: Branch, a: Snapshot, b: Snapshot) -> Snapshot:
    return _snapshot(branch, moved(branch, _point(branch, a), (a.depth + b.depth) / 2))


def _point(branch: Branch, state: Snapshot) -> Point:
    return Point(state.depth, branch.contact(state.depth, *state.lines))


def _snapshot(branch: Branch, point: Point) -> Snapshot:
    """A state between the steps; its energy is not asked for."""
    depth, state = point
    lines = (math.nan, math.nan) if state is None else state.ends
    force, turned = branch.force(state, depth), branch.scene.axisymmetric
    return Snapshot(depth, force, math.nan, lines[0], lines[1], axisymmetric=turned)
