"""States of several contacts, found on nodes and refined.

"adhered" is the end of the path that touches first and then moves to the depth (plan.py). "global"
is what has the least energy of: the lowest contacts of nodes taken to rest, the adhered state, and
none. Nodes are twice as close each time until two of them lead to the same state.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from discretization.certificate import AccuracyWarning, NotCertifiedError
from discretization.equilibrium import Equilibrium
from discretization.fitted.motion import Motion
from discretization.fitted.states import judged, on_several, state_of
from discretization.profile import LOOKS, Resolved, resolve, unknown, warn_hidden
from discretization.refine.equations import Equations, contact_lines, free_surfaces
from discretization.refine.events import Events, NotRefined
from discretization.refine.nodes import FoundNodes, usual_spacing
from discretization.refine.plan import Refinement
from discretization.refine.settle import settle
from discretization.refine.steady import steady_contacts
from energy import Scene
from energy.arrays import Array

MOST_NODES = (
    20_000  # of the usual ones: lines of profiles with narrower features move by themselves
)
CLOSER = (1, 4, 16)  # times closer nodes, where the usual ones lead to no state
_STEADY_CLOSER = (1, 4, 16, 24)  # the same, of which two must lead to the same state
_TOLD_APART = 1.2  # times closer nodes are another row
_SOONER = 1.5  # the depths of events are off by less than this power of the spacing of nodes
_GLOBAL_CLOSER = (0.5, 1, 2, 4)  # the same of those whose lowest contacts are compared
_BESIDE = 1 / 64  # of δ₀: depths beside the imposed one, of which the lowest contacts are tried
_SAME = 1e-9  # of the energy's scale: energies of the same state
_FAR = 0.5  # of l: how far lines may be from their nodes
_REPEATED = 1e-8  # of l: lines found twice
_MOST_CHANGES = 1000  # of contacts on nodes, until those of the profile are found
_PENETRATION = 1e-11  # of the size of depths: below what the certificate tolerates

Lines = tuple[float, ...]


def on_refined_nodes(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """Certified equilibrium of a line contact that may have several contacts.

    NotCertifiedError if it was not found; ValueError for a contact that leaves the known profile;
    AccuracyWarning where the profile is not resolved, or closer nodes might lead to a lower state.
    """
    find = _adhered_state if scene.opened.work_of_adhesion else _bare_state
    places = np.empty(0)
    for _ in range(LOOKS):
        profile = resolve(scene, depth, places)
        if np.ptp(profile.x) > MOST_NODES * usual_spacing(scene, profile):
            return on_several(scene, depth, branch=branch)
        motion = Motion.of(scene, profile, depth)
        state, hidden = find(motion, depth, branch)
        if not hidden.size:
            break
        places = np.union1d(places, hidden)
    if places.size:
        warn_hidden(places, stacklevel=3)
    if branch == "adhered" or not scene.work_of_adhesion:
        return state
    return _Lowest(scene, profile, depth, motion).found(state)


def _adhered_state(motion: Motion, depth: float, branch: str) -> tuple[Equilibrium, Array]:
    """The state at the end of the path from first touch, and places that samples have missed."""
    return judged(motion, adhered(motion, depth), depth, branch)


def _bare_state(motion: Motion, depth: float, branch: str) -> tuple[Equilibrium, Array]:
    """The only state where nothing adheres, whatever the path, and places that samples have missed.

    Its contacts are those on nodes, brought to rest.
    """
    if depth < motion.profile.touch:
        return judged(motion, (), depth, branch)
    search = _Bare(Events(Equations.of(motion.scene, motion.profile, depth)), depth)
    reason = "the lines near those of the nodes do not come to rest"
    for closer in CLOSER:
        nodes = FoundNodes.of(motion.scene, motion.profile, depth, closer)
        lines = search.at_rest(nodes.lines(nodes.adhered(depth)))
        if lines is None:
            continue
        try:
            return judged(motion, lines, depth, branch)
        except NotCertifiedError as why:
            reason = str(why)
    raise NotCertifiedError(
        f"the state at depth = {depth!r} was not found on nodes at most {CLOSER[-1]} times closer "
        f"than usual ({reason}); try another depth, or method='lattice'"
    )


@dataclass(frozen=True, eq=False)
class _Bare:
    """The search for the contacts of a surface that nothing adheres to, near those of nodes."""

    events: Events
    depth: float

    def at_rest(self, lines: Lines) -> Lines | None:
        """Lines at rest near those of nodes, None where they are not found.

        A contact whose lines meet is left out, a gap whose lines meet is closed, and where a
        surface would pass through the profile there is another contact.
        """
        equations = self.events.equations
        lowest = equations.profile.lowest
        lines = lines or (lowest, lowest)
        for _ in range(_MOST_CHANGES):
            surfaces = free_surfaces(lines)
            count = len(surfaces)
            found = settle(equations, surfaces, np.full(count, self.depth), np.ones(count))
            changed = _without_met(found.lines)
            if changed is None and not found.at_rest.all():
                return None
            if changed is None:
                changed = self._with_new(found.lines)
            if changed is None:
                return known_lines(equations, found.lines, self.depth)
            lines = changed
        return None

    def _with_new(self, surfaces: Array) -> Lines | None:
        """Lines with a contact where a surface passes furthest through the profile, None if none does."""
        least = math.inf
        where = math.nan
        for row in surfaces:
            clear, place = self.events.clearance(row, self.depth)
            if clear < least:
                least = clear
                where = place
        if least >= -_PENETRATION * self.events.equations.size:
            return None
        return tuple(sorted((*contact_lines(surfaces), where, where)))


def _without_met(surfaces: Array) -> Lines | None:
    """Lines without the contacts, or else the gaps, whose lines have met; None if none has."""
    lines = contact_lines(surfaces)
    contacts = np.array(lines).reshape(-1, 2)
    kept = contacts[:, 0] <= contacts[:, 1]
    if not kept.all():
        return tuple(contacts[kept].ravel().tolist())
    closed = np.flatnonzero(surfaces[:, 0] >= surfaces[:, 1])
    if not closed.size:
        return None
    inner = [j for i in closed.tolist() for j in (2 * i - 1, 2 * i)]
    return tuple(np.delete(lines, inner).tolist())


def adhered(motion: Motion, depth: float) -> Lines:
    """The lines at the end of the path from first touch to this depth."""
    scene = motion.scene
    at_corners = depth < motion.profile.touch and motion.profile.corners.size
    if not (scene.hysteretic or at_corners):
        lines = _steady(motion, depth)
        if lines is not None:
            return lines
    return _followed(scene, motion.profile, depth)


def _steady(motion: Motion, depth: float) -> Lines | None:
    """Lines near contacts on nodes, where two rows of nodes lead to the same and no event is near.

    None where they do not. With corners contacts narrower than any nodes may stay as the indenter
    is pulled, and where two works of adhesion differ lines depend on where they have been.
    """
    profile = motion.profile
    equations = Equations.of(motion.scene, profile, depth)
    last: Lines | None = None
    spacing = math.inf
    for closer in _STEADY_CLOSER:
        nodes = FoundNodes.of(motion.scene, profile, depth, closer)
        if nodes.spacing > spacing / _TOLD_APART:
            break  # there are as many nodes as are allowed
        spacing = nodes.spacing
        contacts = steady_contacts(nodes, depth, nodes.margin / closer**_SOONER)
        if contacts is None:
            continue
        lines = _at_rest(equations, nodes.lines(contacts), depth)
        if lines is None:
            continue
        if last is not None and _alike(last, lines, equations.length):
            return lines
        last = lines
    return None


def _at_rest(equations: Equations, lines: Lines, depth: float) -> Lines | None:
    """Lines of nodes taken to rest, None where that fails or lines meet."""
    surfaces = free_surfaces(lines)
    count = len(surfaces)
    reach = _FAR * equations.length
    found = settle(equations, surfaces, np.full(count, depth), np.ones(count), reach=reach)
    apart = bool((found.lines[:-1, 1] <= found.lines[1:, 0]).all())
    if not (found.at_rest.all() and apart):
        return None
    return known_lines(equations, found.lines, depth)


def _alike(one: Lines, other: Lines, length: float) -> bool:
    """Whether lines are the same, found twice."""
    if len(one) != len(other):
        return False
    return bool(np.abs(np.subtract(one, other)).max(initial=0.0) <= _REPEATED * length)


def _followed(scene: Scene, profile: Resolved, depth: float) -> Lines:
    """The same by following all lines from event to event (plan.py)."""
    reasons = list[str]()
    for closer in CLOSER:
        try:
            return _adhered(Refinement.of(scene, profile, depth, closer), depth)
        except NotRefined as reason:
            reasons.append(str(reason))
    raise NotCertifiedError(
        f"the state at depth = {depth!r} was not found on nodes at most {CLOSER[-1]} times closer "
        f"than usual ({reasons[-1]}); try another depth: this one may be that of an event, or "
        "method='lattice'"
    )


def _adhered(refinement: Refinement, depth: float) -> Lines:
    contacts, on_nodes, lines = refinement.touched()
    touch = refinement.equations.profile.touch
    if depth == touch:
        return known_lines(refinement.equations, lines, depth)
    stretches = refinement.follow(contacts, on_nodes, lines, touch, depth)
    last = stretches[-1]
    if not last.lives:
        return ()
    return known_lines(refinement.equations, np.array([life.last for life in last.lives]), depth)


def known_lines(equations: Equations, surfaces: Array, depth: float) -> Lines:
    """The lines of contacts; ValueError where they leave the known profile."""
    lines = contact_lines(surfaces)
    low, high = equations.joints[[0, -1]].tolist()
    for line in lines:
        if line in (low, high) and line not in equations.edges:
            raise unknown(depth, line)
    return lines


@dataclass(frozen=True, eq=False)
class _Lowest:
    """The search for the state of least energy."""

    scene: Scene
    profile: Resolved
    depth: float
    motion: Motion

    def found(self, adhered: Equilibrium) -> Equilibrium:
        """The lowest of the adhered state, none, and those of the lowest contacts on nodes."""
        lowest = list[Equilibrium]()
        same = False
        for candidates, count in self._candidates():
            states = [adhered]
            for lines in candidates:
                try:
                    states.append(state_of(self.motion, lines, self.depth, "global"))
                except NotCertifiedError:
                    continue
            lowest.append(min(states, key=lambda state: state.energy))
            if len(lowest) < 2:
                continue
            one, other = lowest[-2:]
            alike = len(one.contacts) == len(other.contacts)
            same = alike and abs(one.energy - other.energy) <= _SAME * other.scales["energy"]
            if same and len(one.contacts) == count:
                break
        if not same:
            self._warn()
        return min(lowest, key=lambda state: state.energy)

    def _warn(self) -> None:
        warnings.warn(
            f"the lowest energy at depth = {self.depth!r} is not the same on nodes each twice as "
            "close as the last: the state found may not be the lowest; give a spacing, or a "
            "smoother profile",
            AccuracyWarning,
            stacklevel=5,
        )

    def _candidates(self) -> Iterator[tuple[set[Lines], int]]:
        """Lines at rest near the lowest contacts of closer and closer nodes, and their number.

        Those of depths a little less and more are among them: two states may have so nearly the
        same energy that nodes take one for the other.
        """
        equations = Equations.of(self.scene, self.profile, self.depth)
        beside = _BESIDE * self.scene.critical_separation
        for closer in _GLOBAL_CLOSER:
            nodes = FoundNodes.of(self.scene, self.profile, self.depth, closer, tips=False)
            candidates: set[Lines] = {()}
            count = 0
            for depth in (self.depth - beside, self.depth + beside, self.depth):
                lines = nodes.lowest(depth)
                count = len(lines) // 2
                rest = self._at_rest(equations, lines)
                if rest is not None:
                    candidates.add(rest)
            yield candidates, count

    def _at_rest(self, equations: Equations, lines: Lines) -> Lines | None:
        """Lines taken to rest, None where that fails; contacts whose lines meet are left out."""
        while lines:
            surfaces = free_surfaces(lines)
            depths = np.full(len(surfaces), self.depth)
            found = settle(equations, surfaces, depths, np.ones(len(surfaces)))
            rest = found.lines
            closed = np.flatnonzero(rest[:-1, 1] > rest[1:, 0])
            if not closed.size:
                at_rest = found.at_rest.all()
                return known_lines(equations, rest, self.depth) if at_rest else None
            kept = [i for i in range(len(lines) // 2) if i not in set(closed.tolist())]
            lines = tuple(x for i in kept for x in lines[2 * i : 2 * i + 2])
        return ()
