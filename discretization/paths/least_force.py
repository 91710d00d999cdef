"""Where P is least between the recorded states of a path on nodes, on a stretch without events.

There contacts only grow with the depth. A node that closes was a gap v >= 0 above the indenter, so
that the surface is pulled up nowhere by it, and P = k ∫u dx falls; and at fixed contacts P rises
with the depth, by more the larger these are. So between two depths d < e, with the contacts C at e,

    P >= P_C(d),

which costs a difference of running sums (`Row.totals`). Between nodes contacts reach up to one link
further: what that would add to P is subtracted, twice since the cubic through links may overshoot.
Only where this bound is below the least force that is known already, contacts are followed again
and P is drawn between the nodes.

Conventions
-----------
Depths are positive down into the layer [length], P is positive where pressed and negative where
pulled, so that the least P is the pull-off force. Recorded states are in the order of the path,
with the depth growing (`direction` 1) or falling (-1). Contacts are arrays of nodes (n, 2m), the
first and the last node of each of m contacts from left to right, counted from the first node of the
row; a link is what lies between two neighbouring nodes. Along a `LatticeSegment` t runs from 0 to
1, with `depths(t)`; its `trace` has the depths at which contacts change, each with the contacts
from there on. `facing_sides` has -1 for first and 1 for last nodes, the directions outwards.

`Control(0.0)` is a dead load, for which C, the value of the control along a segment, is P.
`evenly_spaced` are t at which P is sampled, `at_changes` these with the t at which contacts change.
`Curve.sampled` is P at such samples, its `refined(i, -1)` the point of the minimum next to sample
i, and `snapshot` the state at a point, with its force. `LatticeBranch.contact` is the point with
given lines, `point` that with given contacts, `pinned_at` where its outermost lines are pinned.
`Walk.track` follows contacts from a depth to another: it gives its trace, the depth of the first
event or None, and the contacts beyond that. `contacts_at` makes pairs of a flat array of first and
last nodes.

A `Snapshot` is a state with its depth, force, energy and lines; `Branch.walk` takes contacts on
nodes from depth to depth.
"""

from __future__ import annotations

import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.lattice.subgrid import facing_sides
from discretization.nodes.row import Row
from discretization.paths.branch import Snapshot
from discretization.paths.control import Control, Curve, at_changes, evenly_spaced
from discretization.paths.lattice_branch import LatticeBranch, LatticeSegment, contacts_at
from energy.arrays import Array, Indices, Nodes

# Of the largest force: forces that differ by less are the same, as sums over a thousand nodes leave
# some hundred roundings. 1e-14 or 1e-12 changes none of 20 random paths (`python -m
# tests.sensitivity discretization.paths.least_force NOISE`).
NOISE = 1e-13
# Times what P changes by if all lines are one link further out: once for the link, and once as the
# cubic through links may overshoot (see the module).
_FURTHER = 2.0
# Links: lines that face each other and are closer stay on their nodes, since both would move by a
# link and the gap has to keep two, between which one node is free.
_APART = 4
_LOAD = Control(0.0)  # C is P


class UnknownError(Exception):
    """Something happens on a stretch that is no event of its path."""


class Stretch(NamedTuple):
    """Recorded states in contact along which the depth changes in one direction.

    Attributes
    ----------
    depths, forces : ndarray (n,)
        d [length] and P [force/length], in the order of the path.
    lines : ndarray (n, 2m)
        x of both ends of all contacts, from left to right [length].
    """

    depths: Array
    forces: Array
    lines: Array

    @property
    def direction(self) -> int:
        """1 if the depth grows, -1 if it falls."""
        return 1 if self.depths[-1] > self.depths[0] else -1


def monotone(depths: Array, forces: Array, lines: Array) -> Iterator[Stretch]:
    """The stretches of states in the order of a path, cut where the depth turns back.

    Neighbours share the state at which it turns. States that are all at one depth have none.

    Parameters
    ----------
    depths, forces : ndarray (n,)
        d [length] and P.
    lines : ndarray (n, 2m)
        x of both ends of all contacts [length].
    """
    moved = np.flatnonzero(np.diff(depths))
    if not moved.size:
        return
    turns = moved[1:][np.diff(np.sign(np.diff(depths)[moved])) != 0]
    ends = [0, *turns.tolist(), depths.size - 1]
    for first, last in itertools.pairwise(ends):
        own = slice(first, last + 1)
        yield Stretch(depths[own], forces[own], lines[own])


@dataclass(frozen=True)
class Bounded:
    """A stretch with what the force is no less than along it.

    Attributes
    ----------
    branch : LatticeBranch
        The states on the nodes.
    stretch : Stretch
    nodes : ndarray of int (n, 2m)
        The nodes nearest to its lines.
    bounds : ndarray (n - 1,)
        What P is no less than between neighbouring states [force/length].
    """

    branch: LatticeBranch
    stretch: Stretch
    nodes: Nodes
    bounds: Array

    @property
    def least(self) -> float:
        """What P is no less than on all of the stretch."""
        return float(self.bounds.min())

    def turn(self, known: float) -> Snapshot | None:
        """The state strictly within the stretch at which P is least.

        None if P there is not less than at both ends, or if P promises nowhere to be less than
        `known`, the least force that is known of the path so far.

        Raises
        ------
        UnknownError
            If the stretch cannot be followed as one segment.
        """
        segment, inside = self._segment(np.flatnonzero(self.bounds < known))
        t = at_changes(segment)
        own = np.flatnonzero((t >= inside[0]) & (t <= inside[1]))
        drawn = own[self._promising(segment, t[own], known)]
        if not drawn.size:
            return None
        value = np.full(t.size, np.inf)  # where P is not drawn it is not the least
        value[drawn] = segment.forces(segment.depths(t[drawn]))
        i = int(value.argmin())
        ends = self.stretch.forces[[0, -1]]
        if value[i] >= ends.min() - NOISE * np.abs(value[drawn]).max():
            return None
        if i in (own[0], own[-1]):  # it may be less beyond what has been followed
            raise UnknownError
        return self.branch.snapshot(Curve.sampled(segment, _LOAD, t, value).refined(i, -1))

    def _segment(self, promising: Indices) -> tuple[LatticeSegment, tuple[float, float]]:
        """The segment of the stretch, and the t between which contacts on it have been followed.

        promising: numbers of the parts, between neighbouring states, on which P may be less than
        known. The contacts are followed from the last recorded state before these.
        """
        branch = self.branch
        depths = self.stretch.depths
        first, last = depths[[0, -1]].tolist()
        start = branch.contact(first, *self.stretch.lines[0].tolist())
        end = branch.point(contacts_at(self.nodes[-1]), last, start)
        segment = LatticeSegment(
            branch, start, end, None, False, [(first, tuple(self.nodes[0].tolist()))]
        )
        inside = self._about(segment, promising)
        begin, goal = segment.depths(np.array(inside)).tolist()
        direction = self.stretch.direction
        before = int(np.searchsorted(direction * depths, direction * begin, "right")) - 1
        known = max(before, 0)  # the recorded state from which it is followed
        here = contacts_at(self.nodes[known])
        trace, at, _ = branch.walk.track(here, float(depths[known]), goal)
        pinned = {branch.pinned_at(each[0], each[-1]) for depth, each in trace if depth != last}
        if len(pinned) > 1 or at not in (None, last):
            raise UnknownError
        segment.trace = [(first, tuple(self.nodes[known].tolist())), *trace[1:]]
        return segment, inside

    def _about(self, segment: LatticeSegment, promising: Indices) -> tuple[float, float]:
        """t before and after all parts that promise less: the second sample beyond them each.

        So the least P, if it is on them, has samples on both sides.

        segment: that of the stretch; promising: numbers of its parts between neighbouring states on
        which P may be the least of the path, increasing.
        """
        t = evenly_spaced()
        direction = self.stretch.direction
        reached = direction * segment.depths(t)
        low, high = direction * self.stretch.depths[[promising[0], promising[-1] + 1]]
        before = int(np.searchsorted(reached, low, "right")) - 2
        beyond = int(np.searchsorted(reached, high)) + 1
        return float(t[max(before, 0)]), float(t[min(beyond, t.size - 1)])

    def _promising(self, segment: LatticeSegment, t: Array, known: float) -> Indices:
        """Numbers of the samples t next to which P between the nodes may be less than known.

        Samples where contacts change are among them, so that these do not change in between: the
        bound is that of the contacts from the first of two samples on, at the smaller depth.
        """
        depths = segment.depths(t)
        direction = self.stretch.direction
        changes = np.array([depth for depth, _ in segment.trace])
        contacts = np.array([nodes for _, nodes in segment.trace])
        contacts = contacts.reshape(len(segment.trace), -1)
        last = np.searchsorted(direction * changes, direction * depths[:-1], side="right") - 1
        shallower = np.minimum(depths[:-1], depths[1:])
        promising = _bound(self.branch.row, contacts[last], shallower) < known
        before = np.append(promising, False)
        after = np.append(False, promising)
        return np.flatnonzero(before | after)


def bounded(branch: LatticeBranch, stretches: list[Stretch]) -> list[Bounded]:
    """The stretches with their bounds, in their order.

    Those with the same number of lines are bounded together, as arrays need.
    """
    counts = [each.lines.shape[1] for each in stretches]
    found = dict[int, Bounded]()
    for count in set(counts):
        own = [i for i, other in enumerate(counts) if other == count]
        nodes = branch.nearest(np.concatenate([stretches[i].lines for i in own]))
        depths = np.concatenate([stretches[i].depths for i in own])
        sizes = [stretches[i].depths.size for i in own]
        directions = np.repeat([stretches[i].direction for i in own], sizes)
        # Of every pair of neighbours, also of pairs across stretches, which are left out below.
        deeper = np.where(directions[:-1, None] > 0, nodes[1:], nodes[:-1])
        shallower = np.minimum(depths[:-1], depths[1:])
        bounds = _bound(branch.row, deeper, shallower)
        first = 0
        for i in own:
            last = first + stretches[i].depths.size
            found[i] = Bounded(branch, stretches[i], nodes[first:last], bounds[first : last - 1])
            first = last
    return [found[i] for i in range(len(stretches))]


def _bound(row: Row, nodes: Nodes, depths: Array) -> Array:
    """What P between the nodes is no less than, P_C - 2 max(P_C - P_C', 0); see the module.

    Parameters
    ----------
    row : Row
    nodes : ndarray of int (n, 2m)
        First and last nodes of the contacts C; C' are those with all lines one link further out.
    depths : ndarray (n,)
        The smaller depths d of the parts at whose larger depths these are the contacts [length].

    Returns
    -------
    ndarray (n,)
        [force/length].
    """
    one_link_out = nodes + facing_sides(nodes.shape[1])
    wider = np.clip(one_link_out, 0, row.size - 1)

    # Lines that face each other across a narrow gap stay where they are: it must not close.
    inner = nodes[:, 1:-1]
    gap_links = nodes[:, 2::2] - nodes[:, 1:-1:2]
    is_narrow = np.repeat(gap_links < _APART, 2, axis=1)
    wider[:, 1:-1] = np.where(is_narrow, inner, wider[:, 1:-1])

    _, forces = row.totals(np.concatenate([nodes, wider]), np.tile(depths, 2))
    force, force_of_wider = np.split(forces, 2)
    falls_by = np.maximum(force - force_of_wider, 0.0)
    return np.asarray(force - _FURTHER * falls_by)
