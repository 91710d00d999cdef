"""The work done on a load path, and its most tensile state, from the states recorded."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from itertools import pairwise

import numpy as np
from numpy.typing import NDArray

from discretization.paths.branch import Branch, Point, legs
from discretization.paths.control import Control, Curve
from discretization.paths.events import Event, PullOff, Snapshot
from discretization.surfaces.spectral import rounded

Array = NDArray[np.float64]
Segment = tuple[Snapshot, Snapshot]
_NOISE = 1e-13  # of the largest force: a force is no less than another by less
_FEW, _MORE = 6, 10  # degrees of rules to compare; with the ends, as a kink may be beside one
_WORK = 1e-12  # of the integral of a force that is smooth between events


def work(
    branch: Branch, hold: Control, segments: Sequence[Segment], events: Sequence[Event]
) -> float:
    """∫P dd over the segments, and of the load `hold` while the state jumped."""
    total = 0.0
    for run in _runs(segments):
        ways = [(run[0], run[-1])] if branch.ahead else pairwise(run)
        total += sum(branch.work(_point(branch, start), end.depth) for start, end in ways)
    for event in events:
        total += hold.work(event.before.depth, event.after.depth, event.control)
    return total


def integral(
    force: Callable[[Array], Array], start: float, end: float, rtol: float = _WORK
) -> float:
    """∫P dd by Lobatto rules, on parts halved until fewer points agree to rtol of the whole.

    force: P at depths (n,).
    """
    if start == end:
        return 0.0

    def part(lo: float, hi: float, order: int) -> tuple[float, float]:
        points, weights, _ = rounded(order)
        forces = force(np.concatenate([[lo], lo + (points[1:-1] + 1) / 2 * (hi - lo), [hi]]))
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
    found = [least for run in _runs(segments) for least in (*run, *_turns(branch, run))]
    if not found or min(state.force for state in found) >= 0:
        least = min((state.force for state in found), default=math.inf)
        raise ValueError(
            f"least force = {least!r} of this path is not tensile; retract the indenter further"
        )
    state = min(found, key=lambda state: state.force)
    return PullOff(state.force, state.depth, state.half_width)


def _runs(segments: Sequence[Segment]) -> list[list[Snapshot]]:
    """The segments joined where the path goes straight on."""
    runs: list[list[Snapshot]] = []
    for start, end in segments:
        last = runs[-1] if runs else [start]
        on = runs and last[-1] == start
        if on and (last[-1].depth - last[0].depth) * (end.depth - start.depth) >= 0:
            last.append(end)
        else:
            runs.append([start, end])
    return runs


def _turns(branch: Branch, run: list[Snapshot]) -> Iterator[Snapshot]:
    """The states of a run that goes one way at which P is least, between those recorded."""
    if not branch.smooth:
        return
    for leg in legs(branch, _point(branch, run[0]), run[-1].depth):
        curve = Curve.of(leg, Control(0.0), True, 0.0)
        least, ends = int(np.argmin(curve.value)), curve.value[[0, -1]]
        if curve.value[least] < ends.min() - _NOISE * np.abs(curve.value).max():
            (point,) = leg.points(curve.depths(np.array([curve.refined(least, -1)])))
            yield _snapshot(branch, point)


def _point(branch: Branch, state: Snapshot) -> Point:
    return Point(state.depth, branch.contact(state.depth, *state.lines))


def _snapshot(branch: Branch, point: Point) -> Snapshot:
    """A state between the steps; its energy is not asked for."""
    depth, state = point
    force, turned = branch.force(state, depth), branch.scene.axisymmetric
    (left, right), inner = state.ends, tuple(state.lines[1:-1])
    return Snapshot(depth, force, math.nan, left, right, inner, turned)
