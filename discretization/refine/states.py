"""States of several contacts: those on nodes, with their lines brought to rest.

"adhered" is the end of the path that touches first and then moves to the depth: where nodes have no
event near the depth (steady.py) and two rows of them lead to the same lines, these. "global" is
what has the least energy of: the lowest contacts of nodes brought to rest, the adhered state, and
none. Nodes are twice as close each time until two of them lead to the same state.

Conventions
-----------
Depths grow as the indenter goes down [length]. `Lines` are the 2m ends of m contacts from left to
right [length], () where all is detached; on nodes contacts are their first and last nodes. The
m + 1 free surfaces of lines are an array with a row (left line, right line) for each from left to
right, -inf and inf for the two tails: `free_surfaces` and `lines_of_surfaces` turn one into the
other. The contact between rows i and i + 1 reaches from [i, 1] to [i + 1, 0]; lines have met, and
the contact is gone, where [i, 1] > [i + 1, 0], and a gap is gone where its left line is not left of
its right one.

`settle` takes the lines of surfaces to rest by Newton's method, here always with the work of
adhesion of closing (direction 1); `Events.clearance` is the least minimum of the gap between a
surface and the indenter, negative where the surface would be in the indenter, and its place.

`steady_contacts` are contacts on nodes at a depth near which nothing happens to them, None where
something does; `usual_spacing` is how far apart nodes have to be, and FROM_NODES, of l, how far
lines may rest from theirs. `state_of` makes a certified `Equilibrium` of lines, or raises
NotCertifiedError; `judged` has with it the places of features that the samples of the profile have
missed: the profile is resolved again around them, LOOKS times at most, and `warn_hidden` names
them. `ContactLines.pressed_surface.search.pulls` is whether the profile would pull the surface up
between two lines. `scene.opened` is the scene with the work of adhesion of opening, and
`scene.hysteretic` whether that is another one; δ₀ is `critical_separation`.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.certificate import AccuracyWarning, NotCertifiedError
from discretization.equilibrium import Equilibrium
from discretization.fitted.contact_lines import ContactLines
from discretization.fitted.states import judged, state_of
from discretization.profile import LOOKS, Resolved, resolve, unknown, warn_hidden
from discretization.refine.equations import Equations, free_surfaces, lines_of_surfaces
from discretization.refine.events import Events
from discretization.refine.nodes import FROM_NODES, FoundNodes, usual_spacing
from discretization.refine.settle import settle
from discretization.refine.steady import steady_contacts
from energy import Scene
from energy.arrays import Array

# Times closer nodes, where the usual ones lead to no path: a factor of 4 costs four times the time
# of the last one. (2, 8, 32) changes none of 8 random paths (`python -m tests.sensitivity
# discretization.refine.states CLOSER 2`).
CLOSER = (1, 4, 16)

Lines = tuple[float, ...]


class SearchRules(NamedTuple):
    """How states of several contacts are found from nodes.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 10
    to 15 random states as they are to 1e-9 (`closer` and `global_closer` times 1.5 or 2): `python
    -m tests.sensitivity discretization.refine.states`.

    Attributes
    ----------
    most_nodes : int
        Of the usual ones: profiles with narrower features have too many.
    closer : tuple of float
        How many times closer nodes are, one after the other, of which two must lead to the same
        state.
    distinct : float
        Nodes are another row if they are this many times closer than the last: less where as many
        are used as are allowed.
    sooner : float
        Depths of events are off by less than this power of the spacing of nodes.
    global_closer : tuple of float
        How many times closer nodes are whose lowest contacts are compared.
    links : int
        Of a contact at least, or nodes may take others for the lowest ones.
    nearby : float
        Of δ₀: how far from the depth the lowest contacts are candidates, too.
    same : float
        Of the energy's scale: energies of the same state.
    repeated : float
        Of l: lines found twice differ by less.
    most_changes : int
        Of contacts on nodes, until those of the profile are found.
    penetration : float
        Of the size of depths: a hundredth of what the certificate tolerates.
    """

    most_nodes: int = 20_000
    closer: tuple[float, ...] = (1, 4, 16, 24)
    distinct: float = 1.2
    sooner: float = 1.5
    global_closer: tuple[float, ...] = (0.5, 1, 2, 4)
    links: int = 4
    nearby: float = 1 / 64
    same: float = 1e-9
    repeated: float = 1e-8
    most_changes: int = 1000
    penetration: float = 1e-11


_SEARCH = SearchRules()


def on_refined_nodes(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """Certified equilibrium of a line contact that may have several contacts.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    branch : {"adhered", "global"}

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotCertifiedError
        If no equilibrium is found.
    ValueError
        If a contact leaves the known profile.

    Warns
    -----
    AccuracyWarning
        If samples do not resolve the profile, or closer nodes might have a lower state.
    """
    places = np.empty(0)
    for _ in range(LOOKS):
        profile = resolve(scene, depth, places)
        contact_lines = ContactLines.of(scene, profile, depth)
        state, hidden = _adhered(contact_lines, depth, branch)
        if not hidden.size:
            break
        places = np.union1d(places, hidden)
    if places.size:
        warn_hidden(places, stacklevel=3)
    if branch == "adhered" or not scene.work_of_adhesion:
        return state
    return _Lowest(scene, profile, depth, contact_lines).found(state)


def _adhered(contact_lines: ContactLines, depth: float, branch: str) -> tuple[Equilibrium, Array]:
    """The state at the end of the path from first touch, and places that samples have missed.

    Where nodes do not decide, or lead to a state that is not certified, lines are moved from first
    touch on instead (../fitted/contact_lines.py), which takes longer. The places (n,) are features
    of the profile between its samples [length].
    """
    lines = _at_once(contact_lines, depth)
    if lines is not None:
        try:
            return judged(contact_lines, lines, depth, branch)
        except NotCertifiedError:
            pass  # nodes have missed something, such as a narrow gap
    return judged(contact_lines, contact_lines.adhered(depth), depth, branch)


def _at_once(contact_lines: ContactLines, depth: float) -> Lines | None:
    """Lines at the end of the path, from contacts on nodes at this depth; None where undecided.

    Nodes do not decide where there would be too many of them; where the indenter is retracted from
    a profile with corners, at which contacts narrower than any nodes may stay; and where two works
    of adhesion differ, so that lines depend on where they have been.
    """
    scene = contact_lines.scene
    profile = contact_lines.profile
    if depth < profile.touch and not scene.opened.work_of_adhesion:
        return ()
    if np.ptp(profile.x) > _SEARCH.most_nodes * usual_spacing(scene, profile):
        return None
    if not scene.opened.work_of_adhesion:
        return _bare(contact_lines, depth)
    if scene.hysteretic or (depth < profile.touch and profile.corners.size):
        return None
    return _steady(contact_lines, depth)


def _bare(contact_lines: ContactLines, depth: float) -> Lines | None:
    """Lines where nothing adheres, so that there is one state, whatever the path.

    None where they are not found, or a contact on the fitted mesh would have a gap in it.
    """
    scene = contact_lines.scene
    nodes = FoundNodes.of(scene, contact_lines.profile, depth)
    search = _Bare(Events(Equations.of(scene, contact_lines.profile, depth)), depth)
    lines = search.at_rest(nodes.lines(nodes.adhered(depth)))
    return None if lines is None or _opens(contact_lines, lines, depth) else lines


def _opens(contact_lines: ContactLines, lines: Lines, depth: float) -> bool:
    """Whether the profile would pull the surface up in a contact: there a gap has to be.

    It is narrower than nodes see. Only for contacts that do not adhere.
    """
    pulls = contact_lines.pressed_surface.search.pulls
    contacts = zip(lines[::2], lines[1::2], strict=True)
    return any(left < right and pulls(left, right, depth) for left, right in contacts)


@dataclass(frozen=True, eq=False)
class _Bare:
    """The search for the contacts of a surface that nothing adheres to, near those of nodes.

    Attributes
    ----------
    events : Events
        What knows the equations of lines and how far surfaces are from the indenter.
    depth : float
        [length].
    """

    events: Events
    depth: float

    def at_rest(self, lines: Lines) -> Lines | None:
        """Lines at rest near those of nodes, None where they are not found.

        Contacts change until lines at rest need no other ones: a contact whose lines meet is left
        out, a gap whose lines meet is closed, and where a surface would pass through the profile
        there is another contact, at first a point. `lines` may be (): then that is the lowest one.
        """
        equations = self.events.equations
        lowest = equations.profile.lowest
        lines = lines or (lowest, lowest)
        for _ in range(_SEARCH.most_changes):
            surfaces = free_surfaces(lines)
            count = len(surfaces)
            found = settle(equations, surfaces, np.full(count, self.depth), np.ones(count))
            changed = _without_met(found.lines)
            if changed is None and not found.at_rest.all():
                return None
            if changed is None:
                changed = self._with_new(found.lines)
            if changed is None:
                return _known(equations, found.lines)
            lines = changed
        return None

    def _with_new(self, surfaces: Array) -> Lines | None:
        """Lines with a further contact where a surface is deepest in the profile; None if none is.

        surfaces (n, 2): the present ones, at rest.
        """
        least = math.inf
        where = math.nan
        for row in surfaces:
            clear, place = self.events.clearance(row, self.depth)
            if clear < least:
                least = clear
                where = place
        if least >= -_SEARCH.penetration * self.events.equations.size:
            return None
        return tuple(sorted((*lines_of_surfaces(surfaces), where, where)))


def _without_met(surfaces: Array) -> Lines | None:
    """Lines without the contacts, or else the gaps, whose lines have met; None if none has.

    surfaces (m + 1, 2): those of the contacts, after Newton's method.
    """
    lines = lines_of_surfaces(surfaces)
    contacts = np.array(lines).reshape(-1, 2)
    kept = contacts[:, 0] <= contacts[:, 1]
    if not kept.all():
        return tuple(contacts[kept].ravel().tolist())
    closed = np.flatnonzero(surfaces[:, 0] >= surfaces[:, 1])
    if not closed.size:
        return None
    inner = [j for i in closed.tolist() for j in (2 * i - 1, 2 * i)]  # both lines of surface i
    return tuple(np.delete(lines, inner).tolist())


def _steady(contact_lines: ContactLines, depth: float) -> Lines | None:
    """Lines near contacts on nodes, where two rows of nodes lead to the same and no event is near.

    None where they do not. Nodes are taken closer and closer; on those that are c times as close
    as usual depths of events are off by a margin that is c^1.5 times less.
    """
    profile = contact_lines.profile
    equations = Equations.of(contact_lines.scene, profile, depth)
    last: Lines | None = None
    spacing = math.inf
    for closer in _SEARCH.closer:
        nodes = FoundNodes.of(contact_lines.scene, profile, depth, closer)
        if nodes.spacing > spacing / _SEARCH.distinct:
            break  # there are as many nodes as are allowed
        spacing = nodes.spacing
        contacts = steady_contacts(nodes, depth, nodes.margin / closer**_SEARCH.sooner)
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
    """Lines of nodes taken to rest nearby.

    None where they do not come to rest within FROM_NODES l, where lines of a contact have passed
    each other, and where one leaves the known profile.
    """
    surfaces = free_surfaces(lines)
    count = len(surfaces)
    reach = FROM_NODES * equations.length
    found = settle(equations, surfaces, np.full(count, depth), np.ones(count), reach=reach)
    apart = bool((found.lines[:-1, 1] <= found.lines[1:, 0]).all())
    if not (found.at_rest.all() and apart):
        return None
    return _known(equations, found.lines)


def _alike(one: Lines, other: Lines, length: float) -> bool:
    """Whether lines are as many, and none of them differs by more than 1e-8 l, `length` being l."""
    if len(one) != len(other):
        return False
    return bool(np.abs(np.subtract(one, other)).max(initial=0.0) <= _SEARCH.repeated * length)


def _known(equations: Equations, surfaces: Array) -> Lines | None:
    """The lines of contacts with surfaces (m + 1, 2); None if one leaves the known profile."""
    lines = lines_of_surfaces(surfaces)
    return None if _unknown(equations, lines) else lines


def known_lines(equations: Equations, surfaces: Array, depth: float) -> Lines:
    """The lines of contacts, if they are on the known profile.

    Parameters
    ----------
    equations : Equations
    surfaces : ndarray (m + 1, 2)
        Lines of the free surfaces [length].
    depth : float
        [length].

    Returns
    -------
    tuple of float
        The 2m lines from left to right [length].

    Raises
    ------
    ValueError
        If a line is at an end of the profile that is not an edge of the body.
    """
    lines = lines_of_surfaces(surfaces)
    for line in _unknown(equations, lines):
        raise unknown(depth, line)
    return lines


def _unknown(equations: Equations, lines: Lines) -> list[float]:
    """Those of 2m lines that are at an end of the profile which is not an edge of the body.

    `joints` have both ends first and last; `edges` are the ends at which the body itself ends.
    """
    ends = equations.joints[[0, -1]].tolist()
    return [line for line in lines if line in ends and line not in equations.edges]


class _Candidates(NamedTuple):
    """States that may be the lowest, as one row of nodes has them.

    Attributes
    ----------
    lines : set of tuple of float
        Their lines at rest; detached is always among them.
    contacts : int
        How many contacts the lowest state on the nodes has at the depth itself.
    spacing : float
        Of the nodes [length].
    """

    lines: set[Lines]
    contacts: int
    spacing: float


@dataclass(frozen=True, eq=False)
class _Lowest:
    """The search for the state of least energy.

    Attributes
    ----------
    scene : Scene
    profile : Resolved
    depth : float
        [length].
    contact_lines : ContactLines
        What makes states of lines.
    """

    scene: Scene
    profile: Resolved
    depth: float
    contact_lines: ContactLines

    def found(self, adhered: Equilibrium) -> Equilibrium:
        """The lowest of the adhered state, none, and those of the lowest contacts on nodes.

        Nodes are closer and closer until two rows of them lead to one state, the latter with as
        many contacts, and none narrower than `links` of them.
        """
        lowest = list[Equilibrium]()  # of each row of nodes
        same = False
        for candidates in self._candidates():
            states = [adhered]
            for lines in candidates.lines:
                try:
                    states.append(state_of(self.contact_lines, lines, self.depth, "global"))
                except NotCertifiedError:
                    continue
            lowest.append(min(states, key=lambda state: state.energy))
            if len(lowest) < 2:
                continue
            one, other = lowest[-2:]
            alike = len(one.contacts) == len(other.contacts)
            same = alike and abs(one.energy - other.energy) <= _SEARCH.same * other.scales["energy"]
            widths = np.diff(other.contacts, axis=1)
            resolved = bool((widths >= _SEARCH.links * candidates.spacing).all())
            if same and resolved and len(one.contacts) == candidates.contacts:
                break
        if not same:
            self._warn()
        return min(lowest, key=lambda state: state.energy)

    def _warn(self) -> None:
        """Warn that closer nodes might have a lower state."""
        warnings.warn(
            f"the lowest energy at depth = {self.depth!r} is not the same on nodes each twice as "
            "close as the last: the state found may not be the lowest; give a spacing, or a "
            "smoother profile",
            AccuracyWarning,
            stacklevel=5,
        )

    def _candidates(self) -> Iterator[_Candidates]:
        """Lines at rest near the lowest contacts of closer and closer nodes.

        Those of depths a little less and more are among them: two states may have so nearly the
        same energy that nodes take one for the other. ValueError where the lowest contacts leave
        the known profile.
        """
        equations = Equations.of(self.scene, self.profile, self.depth)
        nearby = _SEARCH.nearby * self.scene.critical_separation
        for closer in _SEARCH.global_closer:
            nodes = FoundNodes.of(self.scene, self.profile, self.depth, closer, tips=False)
            candidates: set[Lines] = {()}
            count = 0
            for depth in (self.depth - nearby, self.depth + nearby, self.depth):
                lines = nodes.lowest(depth)
                count = len(lines) // 2
                rest = self._at_rest(equations, lines)
                if rest is None:
                    continue
                left = _unknown(equations, rest)
                if not left:
                    candidates.add(rest)
                elif depth == self.depth:
                    raise unknown(depth, left[0])
            yield _Candidates(candidates, count, nodes.spacing)

    def _at_rest(self, equations: Equations, lines: Lines) -> Lines | None:
        """Lines taken to rest, None where that fails; contacts whose lines meet are left out.

        () if that leaves none.
        """
        while lines:
            surfaces = free_surfaces(lines)
            depths = np.full(len(surfaces), self.depth)
            found = settle(equations, surfaces, depths, np.ones(len(surfaces)))
            rest = found.lines
            closed = np.flatnonzero(rest[:-1, 1] > rest[1:, 0])
            if not closed.size:
                return lines_of_surfaces(rest) if found.at_rest.all() else None
            kept = [i for i in range(len(lines) // 2) if i not in set(closed.tolist())]
            lines = tuple(x for i in kept for x in lines[2 * i : 2 * i + 2])
        return ()
