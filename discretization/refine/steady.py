"""Contacts on nodes at a depth near which nothing happens to them.

Pressed from first touch on, lines come to the first places where they rest, and so they do when
they are pulled: which state that is depends on the barriers on their path, not on the order in
which they are passed. Nodes may have an event a little too early or too late. So contacts are only
believed where nodes have no event from a margin before the depth to a margin beyond.

Conventions
-----------
Depths grow as the indenter goes down [length]. Contacts are ((first, last), ...), their first and
last nodes from left to right, counted from 0 in the row of nodes; () is detached.

Of `FoundNodes`, `walk` is the `Walk` over its row of nodes, and `row.lowest` the height of its
lowest node: the depth at which the first node touches. `pressed(walk, depth)` has the contacts
pressed to a depth at once, which are never (): it begins with the contact of the lowest node, also
at less than its height. `Walk.moved(contacts, from, to)` has those that others become from one
depth to another, () if all are lost where the depth falls.

`Walk.track(contacts, from, to)` is the path between two depths up to the first event: `at` is the
depth of that, None if there is none, `after` the contacts after it, or at the end. An entry of its
`trace` is a depth and the contacts from there on in one row, (first, last, first, last, ...), which
`paired` makes Contacts again; the last one has the contacts before the event. CREEPING is how many
links lines may pass at one depth without that being an event.
"""

from __future__ import annotations

import numpy as np

from discretization.lattice.walk import paired
from discretization.nodes.row import Contacts
from discretization.refine.lives import CREEPING
from discretization.refine.nodes import FoundNodes
from discretization.refine.pressed import pressed

# Links of a contact at first touch: nodes lose narrower ones too early. A parabola's contact of 1,
# 2, 3, 4, 5 or 6 links is lost up to 0.95, 0.61, 0.22, 0.30, 0.14 or 0.12 δ₀ too early (12 radii
# of l/2 to 40 l, l/Δx = 4 to 32, 6 places of the nodes), while the margin is 0.1 δ₀ at most. 0 or 8
# changes none of 3 random states (`python -m tests.sensitivity discretization.refine.steady _LINKS
# 0 2`).
_LINKS = 4


def steady_contacts(nodes: FoundNodes, depth: float, margin: float) -> Contacts | None:
    """The contacts of the path that touches first and then moves to a depth.

    Parameters
    ----------
    nodes : FoundNodes
    depth : float
        [length].
    margin : float
        By how much the depths of events on the nodes may be off [length].

    Returns
    -------
    Contacts or None
        () if detached. None where nodes have an event less than a margin away from the depth on the
        path, or from first touch; and, at less than the depth of first touch, where a contact has
        fewer than _LINKS links at first touch.
    """
    touch = nodes.row.lowest
    first = _pressed(nodes, max(depth, touch), margin)
    if first is None or depth >= touch:
        return first
    if any(right - left < _LINKS for left, right in first):
        return None
    # Retracted from first touch; in the margin around the depth no event may happen on that path.
    before = min(touch, depth + margin)
    known = nodes.walk.moved(first, touch, before)
    at_depth = _without_event(nodes, known, before, depth)
    if at_depth is None or _without_event(nodes, at_depth, depth, depth - margin) is None:
        return None
    return at_depth


def _pressed(nodes: FoundNodes, depth: float, margin: float) -> Contacts | None:
    """The contacts pressed to a depth, at least that of first touch; None where an event is near.

    No event may happen from a margin before the depth to a margin beyond it. A margin before it the
    indenter may not have touched yet: `pressed` then has the contact that the lowest node would
    grow to at that depth if it were in contact, which is the one after the jump at first touch,
    unless lines have an event in the margin.
    """
    before = depth - margin
    known = pressed(nodes.walk, before)
    at_depth = _without_event(nodes, known, before, depth)
    if at_depth is None or _without_event(nodes, at_depth, depth, depth + margin) is None:
        return None
    return at_depth


def _without_event(
    nodes: FoundNodes, contacts: Contacts, start: float, goal: float
) -> Contacts | None:
    """The contacts that others have become from a depth to another; None where there is an event.

    Events at which as many contacts are left, and no line passes more than CREEPING links, do not
    count: the path goes on from there. Contacts are () here only where the indenter is retracted
    from a loss of all contact on, and then nothing comes into contact again. Where it is pressed no
    contact is lost.
    """
    if not contacts:
        return contacts
    while True:
        track = nodes.walk.track(contacts, start, goal)
        if track.at is None:
            return track.after
        before = paired(track.trace[-1][1])
        if len(before) != len(track.after):
            return None
        if np.abs(np.subtract(before, track.after)).max() > CREEPING:
            return None
        contacts = track.after
        start = track.at
