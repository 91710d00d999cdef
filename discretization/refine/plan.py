"""A route from one depth to another: the events on it, refined, and smooth motion in between.

Nodes have found which events there are and which surfaces end and begin at each (lives.py).
`follow` takes them off the nodes: it finds the depths of events (events.py, crests.py) and the
lines after them (landings.py), event after event, as an event can only be found once the surfaces
that it ends are known; it divides the route at these depths into stretches of smooth motion, finds
that motion (balance.py), and compares with closer nodes. What cannot be refined raises NotRefined
with its depth; a route may then end before it.

Conventions
-----------
Depths grow as the indenter goes down. A direction is 1 where the depth grows and -1 where it falls;
depths times the direction increase along a route, and "earlier", "first" and "beyond" are meant so.

Lines of free surfaces are arrays (n, 2), a row for each surface from left to right, with its left
and its right line [length], -inf and inf where a tail has none. Contacts on nodes are their first
and last nodes; a margin is by how much depths of events on nodes may be off (`FoundNodes.margin`).

A `Life` is a free surface from its birth to its end, a `Happening` an event, which ends the
surfaces `before` and begins those `after`; both are written on as more is known. Surfaces and
events are compared by identity. `Events.rest` takes lines to rest by Newton's method.

Of a `Happening`, `at` is its depth on nodes, `depth` the refined one, nan until it is known, and
`lines_before` and `lines_after` are the lines just before and after it. `Events.enclose` writes the
depths and the lines before events, `Crests.find` those of gaps without adhesion, and
`Landings.land` the lines after; `Landings.agrees` is whether nodes CLOSER times as close find the
same surfaces after an event, `agrees_at_touch` whether they do at first touch. `Cascades` divide
events at which several contacts are lost, `Remnants` find contacts that stay; both return further
events. `walked` has the surfaces and events on nodes. `free_surfaces` are the lines of surfaces (m
+ 1, 2) of 2m lines, `faces_at_touch` the ends (m, 2) of what touches first, nan where they are not
known exactly, and `drawn_lives` lines of surfaces by the polynomials of their pieces. FROM_NODES,
of l, is how far lines may rest from their nodes. `scene.opened` is the scene with the work of
adhesion of opening, and `scene.hysteretic` whether that is another one.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple, TypeVar

import numpy as np

from discretization.nodes.row import Contacts
from discretization.profile import Resolved
from discretization.refine.balance import Balance, drawn_lives
from discretization.refine.cascades import Cascades
from discretization.refine.crests import Crests
from discretization.refine.equations import Equations, free_surfaces
from discretization.refine.events import Events, NotRefined
from discretization.refine.first_touch import faces_at_touch
from discretization.refine.landings import CLOSER, Landings
from discretization.refine.lives import Happening, Life, walked
from discretization.refine.nodes import FROM_NODES, FoundNodes
from discretization.refine.remnants import Remnants
from discretization.refine.totals import Totals
from energy import Scene
from energy.arrays import Array

T = TypeVar("T")

# Of the margin of the nodes: a route that cannot be refined at a depth ends so far before it. 0.25
# or 1 changes no result (`python -m tests.sensitivity discretization.refine.plan ASIDE`).
ASIDE = 0.5


class OrderRules(NamedTuple):
    """When events happen together or too late; δ is the size of depths.

    At a tenth or ten times its value each leaves 8 random states and paths as they are to 1e-9:
    `python -m tests.sensitivity discretization.refine.plan`.

    Attributes
    ----------
    together : float
        Of δ: events so near to each other happen at once.
    late : float
        Of δ: a surface may end that much before it is born, by rounding.
    overlap : float
        Of l: lines of neighbouring surfaces may overlap by that; those of a contact that is lost as
        they meet are known far better.
    """

    together: float = 1e-12
    late: float = 1e-12
    overlap: float = 1e-6


_ORDER = OrderRules()


@dataclass(eq=False)
class Stretch:
    """Smooth motion of all surfaces from one depth to another, and the events at the latter.

    Attributes
    ----------
    direction : {1, -1}
        1 where the depth grows.
    start, end : float
        Depths [length].
    lives : list of Life
        The n surfaces, from left to right.
    before : ndarray (n, 2)
        Their lines at the end, before the events there [length].
    after : ndarray (n', 2) or None
        Lines of the surfaces after the events at the end [length], empty if detached; None where
        there is no event.
    events : list of Happening
        Those at the end, which happen at one depth; from left to right, or one after the other.
    """

    direction: int
    start: float
    end: float
    lives: list[Life]
    before: Array = field(default_factory=lambda: np.empty((0, 2)))
    after: Array | None = None
    events: list[Happening] = field(default_factory=list)


@dataclass(frozen=True, eq=False)
class Refinement:
    """What follows the contacts of a scene, found on nodes of one spacing, off the nodes.

    Attributes
    ----------
    scene : Scene
    nodes : FoundNodes
        The nodes that find the contacts and the order of events.
    equations : Equations
        What has to vanish where lines rest.
    events : Events
        What finds the depths of events.
    landings : Landings
        What finds the lines after events, and asks closer nodes.
    totals : Totals
        Energy and force of surfaces.
    balance : Balance
        What finds the motion between events, in pieces on which energy and work balance.
    """

    scene: Scene
    nodes: FoundNodes
    equations: Equations
    events: Events
    landings: Landings
    totals: Totals
    balance: Balance

    @classmethod
    def of(
        cls,
        scene: Scene,
        profile: Resolved,
        deepest: float,
        closer: int = 1,
        like: Refinement | None = None,
    ) -> Refinement:
        """What follows contacts for depths up to the deepest.

        Parameters
        ----------
        scene : Scene
        profile : Resolved
        deepest : float
            [length].
        closer : int
            How many times closer the nodes are than usual.
        like : Refinement, optional
            The same on other nodes, whose equations and integrals are used again.

        Returns
        -------
        Refinement
        """
        nodes = FoundNodes.of(scene, profile, deepest, closer)
        closer_nodes = FoundNodes.of(scene, profile, deepest, CLOSER * closer)
        equations = Equations.of(scene, profile, deepest) if like is None else like.equations
        totals = Totals.of(equations) if like is None else like.totals
        events = Events(equations)
        delta0 = scene.opened.critical_separation
        displaced = max(delta0, abs(deepest - profile.touch), equations.size * _ORDER.together)
        scale = scene.stiffness * displaced**2 * equations.length
        landings = Landings(events, closer_nodes)
        balance = Balance(events, totals, scale)
        return cls(scene, nodes, equations, events, landings, totals, balance)

    def touched(self) -> tuple[Contacts, float, Array]:
        """The contacts at first touch.

        Returns
        -------
        contacts : Contacts
            On nodes.
        on_nodes : float
            The depth from which on they are followed on the nodes: that at which these touch, or
            without adhesion that at which the profile does [length].
        lines : ndarray (n, 2)
            Of all free surfaces, at rest at the profile's depth of first touch [length].

        Raises
        ------
        NotRefined
            If lines are not found, or closer nodes find another number of contacts.
        """
        touch = self.equations.profile.touch
        contacts = self.nodes.walk.touched(self.nodes.row.lowest)
        if not self.scene.work_of_adhesion:
            faces = faces_at_touch(self.equations, self.nodes, contacts)
            if np.isnan(faces).any():
                lowest = self.equations.profile.lowest
                faces = np.array([[lowest, lowest]])
            return contacts, touch, free_surfaces(tuple(faces.ravel().tolist()))
        route = walked(self.nodes, contacts, self.nodes.row.lowest, self.nodes.row.lowest)
        event = Happening(self.nodes.row.lowest, [], route.first, depth=touch)
        self.landings.land([event])
        if not self.landings.agrees_at_touch(event.lines_after):
            raise NotRefined("closer nodes find other contacts at first touch")
        return contacts, self.nodes.row.lowest, event.lines_after

    def follow(
        self, contacts: Contacts, on_nodes: float, lines: Array, start: float, goal: float
    ) -> list[Stretch]:
        """The route of contacts from one depth to another.

        It ends earlier, before a depth at which events come in another order than on the nodes, or
        closer nodes disagree, unless hardly anything were left of it.

        Parameters
        ----------
        contacts : Contacts
            On nodes, at rest at the depth `on_nodes`.
        on_nodes : float
            [length].
        lines : ndarray (n, 2)
            Of their free surfaces, at rest at the depth `start` [length].
        start, goal : float
            Depths off the nodes [length].

        Returns
        -------
        list of Stretch
            One after the other, at least one.

        Raises
        ------
        NotRefined
            If something on the route cannot be taken off the nodes; with the depth of that.
        """
        direction = 1 if goal >= start else -1
        # Nodes are followed a margin further: what comes too late on them may come before the goal.
        beyond = goal + direction * self.nodes.margin
        if direction * (beyond - on_nodes) < 0:
            beyond = on_nodes
        route = walked(self.nodes, contacts, on_nodes, beyond)
        if len(route.first) != len(lines):
            raise NotRefined(f"nodes at depth = {start!r} have other contacts", start)
        for life, row in zip(route.first, lines, strict=True):
            life.direction = direction
            life.start = start
            life.first = row
        happened, goal = self._refined(route.events, direction, start, goal)
        alive, stretches = self._stretches(route.first, happened, direction, start, goal)
        self._end(alive, goal)
        every = {id(life): life for stretch in stretches for life in stretch.lives}
        self.balance.pieces(list(every.values()))
        self._find_ends(stretches)
        for stretch in stretches:
            try:
                self._agreed(stretch)
            except NotRefined as reason:
                return self._cut_short(stretches, stretch.end, reason)
        return stretches

    def _cut_short(
        self, stretches: list[Stretch], failed: float, reason: NotRefined
    ) -> list[Stretch]:
        """The stretches up to a little before a depth at which they fail for a reason.

        The last one is cut there and has no event at its end. Raises the reason if hardly anything
        were left of them.
        """
        direction = stretches[0].direction
        aside = ASIDE * self.nodes.margin
        goal = failed - direction * aside
        if direction * (goal - stretches[0].start) <= aside:
            raise reason
        kept = [stretch for stretch in stretches if direction * (goal - stretch.start) > 0]
        last = kept[-1]
        last.end = goal
        last.events = []
        last.after = None
        last.before = self._at(last.lives, np.full(len(last.lives), goal)).reshape(-1, 2)
        return kept

    def _refined(
        self, events: list[Happening], direction: int, start: float, goal: float
    ) -> tuple[list[Happening], float]:
        """The events that happen before the goal, with their depths and lines.

        And the goal, or a depth before events that come in another order than on the nodes. Events
        go through three lists: `unknown`, whose depth has not been looked for; `waiting`, whose
        depth has been, but which have not happened (beyond the goal, or to surfaces that are not
        born yet, or not found); and `happened`, with the lines after them.
        """
        happened = list[Happening]()
        unknown = list(events)
        waiting = list[Happening]()
        while True:
            # With two works of adhesion lines stay where they are born, until they move.
            ready = [event for event in unknown if not self.scene.hysteretic or _is_born(event)]
            unknown = _without(unknown, ready)
            self._find_depths(ready, direction, goal)
            waiting += ready
            now = self._happening_now(waiting, happened, direction, goal)
            unknown += Cascades(self.landings).found(now)
            if not now:
                lost = self._lost(waiting, happened, direction, goal)
                if lost is None:
                    return self._in_order(happened, waiting, direction, start, goal)
                now = [self._at_once(*lost)]
                happened = _without(happened, [lost[0]])
                waiting = _without(waiting, [lost[1]])
            waiting = _without(waiting, now)
            self.landings.land(now)
            unknown += Remnants(self.events).found(now)
            for event in now:
                for life, row in zip(event.after, event.lines_after, strict=True):
                    life.start = event.depth
                    life.first = row
            happened += now

    def _find_depths(self, events: list[Happening], direction: int, goal: float) -> None:
        """Write the depths of events and the lines before them; nan stays where they are not found.

        NotRefined where a contact that adheres opens inside before the goal.
        """
        others = _without(events, Crests(self.equations).find(events))
        torn = [e.at for e in others if not e.before and direction * (e.at - goal) < 0]
        if torn:
            raise NotRefined(f"a contact is torn open near depth = {torn[0]!r}", torn[0])
        ending = [event for event in others if event.before]
        if ending:
            self.events.enclose(ending)

    def _in_order(
        self,
        happened: list[Happening],
        left: list[Happening],
        direction: int,
        start: float,
        goal: float,
    ) -> tuple[list[Happening], float]:
        """The events that have happened, and the goal: if one is out of order, up to before that.

        left: the events that have not happened. NotRefined if hardly anything were left of the
        route.
        """
        early = self._first_out_of_order(happened, left, direction, goal)
        if early is None:
            return happened, goal
        aside = ASIDE * self.nodes.margin
        cut = early - direction * aside
        if direction * (cut - start) <= aside:
            raise NotRefined(
                f"events near depth = {early!r} are not in the order of the nodes", early
            )
        return [event for event in happened if direction * (event.depth - cut) < 0], cut

    def _happening_now(
        self, events: list[Happening], before: list[Happening], direction: int, goal: float
    ) -> list[Happening]:
        """Those of these events that happen before the goal to surfaces that are born by then.

        They are born at the start, at events that have happened `before`, or at others of these.
        """
        known = {id(event) for event in before}
        found = list[Happening]()
        for event in events:
            if any(life.born is not None and id(life.born) not in known for life in event.before):
                continue
            if math.isnan(event.depth) or direction * (event.depth - goal) > 0:
                continue
            found.append(event)
            known.add(id(event))
        return found

    def _first_out_of_order(
        self, happened: list[Happening], left: list[Happening], direction: int, goal: float
    ) -> float | None:
        """The first depth of an event that comes in another order than on the nodes, or None.

        Of events that have happened: a surface that it ends is born later. Of those that are left,
        with a depth before the goal: a surface that it ends is not born by the goal.
        """
        late = _ORDER.late * self.equations.size
        early = [event.depth for event in left if direction * (event.depth - goal) <= 0]
        for event in happened:
            births = [life.born.depth for life in event.before if life.born is not None]
            if any(direction * (event.depth - birth) < -late for birth in births):
                early.append(event.depth)
        return min(early, key=lambda depth: direction * depth, default=None)

    def _lost(
        self, events: list[Happening], before: list[Happening], direction: int, goal: float
    ) -> tuple[Happening, Happening] | None:
        """An event that is not found although its surfaces exist, after that at which one is born.

        On the nodes it comes at a depth at which that other event has not happened yet off them: so
        the surface in between may not exist there, and both happen at once. NotRefined where it is
        not so; None where no event is missing before the goal.
        """
        known = {id(event): event for event in before}
        for event in events:
            births = {id(life.born) for life in event.before if life.born is not None}
            if births - set(known) or not math.isnan(event.depth):
                continue
            if direction * (event.at - goal) >= 0:
                continue
            late = [known[i] for i in births if direction * (event.at - known[i].depth) < 0]
            if len(late) != 1:
                raise NotRefined(f"the event near depth = {event.at!r} is not found", event.at)
            return late[0], event
        return None

    def _at_once(self, first: Happening, second: Happening) -> Happening:
        """Two events, the second of a surface that is born at the first, as one event.

        It ends the surfaces that the first one ends, and those that the second one ends but for
        that surface, at rest at the depth of the first; both know it instead of the two events.
        """
        others = [life for life in second.before if life.born is not first]
        before = list[Life]()
        lines = list[Array]()
        known = (
            dict(zip(map(id, others), self.at(others, first.depth), strict=True)) if others else {}
        )
        for life in second.before:
            if id(life) in known:
                before.append(life)
                lines.append(known[id(life)])
            elif not any(one is first.before[0] for one in before):
                before += first.before
                lines += list(first.lines_before)
        after = list[Life]()
        for life in first.after:
            if not any(life is one for one in second.before):
                after.append(life)
            elif not any(one is new for one in after for new in second.after):
                after += second.after
        event = Happening(second.at, before, after, False, first.depth, np.array(lines))
        for life in after:
            life.born = event
        return event

    def _stretches(
        self,
        alive: list[Life],
        happened: list[Happening],
        direction: int,
        start: float,
        goal: float,
    ) -> tuple[list[Life], list[Stretch]]:
        """What is alive at the goal, and the smooth motion between the depths of events.

        alive: the surfaces at the start. How they end is written into those that events end.
        """
        together = _ORDER.together * self.equations.size
        stretches = list[Stretch]()
        depth = start
        events = sorted(happened, key=lambda event: direction * event.depth)
        while events:
            at = events[0].depth
            now = list[Happening]()
            while events and direction * (events[0].depth - at) <= together:
                now.append(events.pop(0))
            stretch = Stretch(direction, depth, at, alive, events=now)
            for event in now:
                self._ended(event, at)
                alive = self._replaced(alive, event)
            stretches.append(stretch)
            depth = at
        stretches.append(Stretch(direction, depth, goal, alive))
        return alive, stretches

    def _ended(self, event: Happening, at: float) -> None:
        """Write into surfaces how they end at an event, at a depth that may be that of several.

        NotRefined where that is before their birth.
        """
        late = _ORDER.late * self.equations.size
        for life, row in zip(event.before, event.lines_before, strict=True):
            life.end = at
            life.last = row
            if event.direction * (life.end - life.start) < -late:
                raise NotRefined(
                    f"events near depth = {at!r} are not in the order of the nodes", at
                )
        for life in event.after:
            life.start = at

    def _replaced(self, alive: list[Life], event: Happening) -> list[Life]:
        """All surfaces after an event, given those before it, both from left to right.

        NotRefined if the event ends one that is not there.
        """
        if _without(event.before, alive):
            raise NotRefined(
                f"events near depth = {event.depth!r} are not in the nodes' order", event.depth
            )
        first = _place(alive, event)
        return [*alive[:first], *event.after, *alive[first + len(event.before) :]]

    def _end(self, alive: list[Life], goal: float) -> None:
        """Write into surfaces their lines at the goal, which ends them."""
        if not alive:
            return
        lines = self.at(alive, goal)
        for life, row in zip(alive, lines, strict=True):
            life.end = goal
            life.last = row

    def at(self, lives: list[Life], depth: float) -> Array:
        """Lines (n, 2) of surfaces at rest at a depth of their lives, found from their nodes.

        NotRefined if they do not come to rest, or only further from there than FROM_NODES.
        """
        guess = np.array([life.guess(depth) for life in lives])
        return self._rest(lives, guess, np.full(len(lives), depth))

    def _at(self, lives: list[Life], depths: Array) -> Array:
        """The same at depths (n,) of their own, found from their motion, which is known."""
        return self._rest(lives, drawn_lives(lives, depths[:, None])[:, 0], depths)

    def _rest(self, lives: list[Life], guess: Array, depths: Array) -> Array:
        """Lines (n, 2) taken to rest at depths (n,) from a guess (n, 2).

        Those that fail are taken from their nodes, then from where they were born.
        """
        reach = FROM_NODES * self.equations.length
        found = self.events.rest(lives, guess[:, None], depths[:, None], reach=reach)
        lines = found.lines
        good = found.at_rest
        for nearby in (self._guesses, self._firsts):
            lost = np.flatnonzero(~good)
            if not lost.size:
                break
            first = nearby([lives[i] for i in lost], depths[lost])
            again = self.events.rest(
                [lives[i] for i in lost], first[:, None], depths[lost, None], reach=reach
            )
            lines[lost] = again.lines
            good[lost] = again.at_rest
        if not good.all():
            depth = float(depths[~good][0])
            raise NotRefined(f"the contacts at depth = {depth!r} do not come to rest", depth)
        return lines

    def _guesses(self, lives: list[Life], depths: Array) -> Array:
        """The positions (n, 2) of the nodes of surfaces at depths (n,)."""
        return np.array([life.guess(d) for life, d in zip(lives, depths.tolist(), strict=True)])

    def _firsts(self, lives: list[Life], depths: Array) -> Array:
        """The lines (n, 2) of surfaces at their birth, whatever the depths."""
        return np.array([life.first for life in lives])

    def _agreed(self, stretch: Stretch) -> None:
        """Write the lines after the events of a stretch. NotRefined where closer nodes disagree.

        The events happen one after the other, so that each finds the lines that the last has left.
        """
        if not stretch.events:
            return
        lives = list(stretch.lives)
        lines = list(stretch.before)
        for event in stretch.events:
            first = _place(lives, event)
            if not event.smooth and not self.landings.agrees(event, np.array(lines), first):
                raise NotRefined(
                    f"closer nodes land elsewhere after the event at {event.depth!r}", event.depth
                )
            own = slice(first, first + len(event.before))
            lives[own] = event.after
            lines[own] = list(event.lines_after)
        stretch.after = np.array(lines).reshape(-1, 2)
        if (stretch.after[:-1, 1] > stretch.after[1:, 0]).any():
            raise NotRefined(f"contacts overlap after the event at {stretch.end!r}", stretch.end)

    def _find_ends(self, stretches: list[Stretch]) -> None:
        """Write the lines of surfaces at the ends of their stretches; of most these are known.

        NotRefined if lines of neighbours have passed each other.
        """
        lives = [life for stretch in stretches for life in stretch.lives]
        depths = np.array([stretch.end for stretch in stretches for _ in stretch.lives])
        lines = np.array([life.last for life in lives]).reshape(-1, 2)
        ends = np.array([life.end for life in lives])
        later = np.flatnonzero(ends != depths)
        if later.size:
            lines[later] = self._at([lives[i] for i in later], depths[later])
        for stretch in stretches:
            stretch.before = lines[: len(stretch.lives)]
            lines = lines[len(stretch.lives) :]
            overlap = stretch.before[:-1, 1] - stretch.before[1:, 0]
            if (overlap > _ORDER.overlap * self.equations.length).any():
                raise NotRefined(f"lines have passed each other at {stretch.end!r}", stretch.end)


def _place(lives: list[Life], event: Happening) -> int:
    """The number of the first surface that an event ends, among surfaces from left to right.

    Of an event that ends none, where a gap opens, the number that the new surface will have: as
    many are on the left of it.
    """
    if event.before:
        return next(i for i, life in enumerate(lives) if life is event.before[0])
    (begins,) = event.lines_after
    return sum(bool(life.guess(event.depth)[1] <= begins[0]) for life in lives)


def _without(items: list[T], others: list[T]) -> list[T]:
    """Those items that are not among others, compared by identity."""
    known = {id(other) for other in others}
    return [item for item in items if id(item) not in known]


def _is_born(event: Happening) -> bool:
    """Whether the refined depth is known at which each surface is born that an event ends."""
    return not any(math.isnan(life.start) for life in event.before)
