"""Contacts on nodes at a depth near which nothing happens to them.

Pressed from first touch on, lines come to the first places where they rest, and so they do when
they are pulled: which state that is depends on the barriers on their path, not on the order in
which they are passed. Nodes may have an event a little too early or too late. So contacts are only
believed where nodes have no event from a margin before the depth to a margin beyond.

Conventions
-----------
Depths grow as the indenter goes down [length]. Contacts are ((first, last), ...), their first and
last nodes from left to right, counted from 0 in the row of nodes; () is detached. `pressed` has the
contacts at a depth at once; `Walk.moved` those that others become at another depth, and
`Walk.track` how they come there up to the first event: its depth, None if there is none, the
contacts after it, and, last in its trace, those before. CREEPING is how many links lines may pass
at one depth without that being an event.
"""

from __future__ import annotations

import numpy as np

from discretization.lattice.walk import paired
from discretization.nodes.row import Contacts
from discretization.refine.lives import CREEPING
from discretization.refine.nodes import FoundNodes
from discretization.refine.pressed import pressed

# Of a contact at first touch: nodes lose narrower ones too early by a part of δ₀. 0 or 8 changes
# none of 3 random states (`python -m tests.sensitivity discretization.refine.steady _LINKS 0 2`).
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
        Empty if detached. None where nodes have an event less than a margin away from the depth
        on the path, or from first touch.
    """
    touch = nodes.row.lowest
    first = _pressed(nodes, max(depth, touch), margin)
    if not first or depth >= touch:
        return first or None  # no node touches, although the profile does
    if any(right - left < _LINKS for left, right in first):
        return None
    # Down from first touch; in the margin around the depth no event may happen on that path.
    before = min(touch, depth + margin)
    known = nodes.walk.moved(first, touch, before)
    at_depth = _without_event(nodes, known, before, depth)
    if at_depth is None or _without_event(nodes, at_depth, depth, depth - margin) is None:
        return None
    return at_depth


def _pressed(nodes: FoundNodes, depth: float, margin: float) -> Contacts | None:
    """The contacts pressed to a depth of first touch or more; None where an event is near.

    Before first touch by less than a margin the contact of the lowest node is pressed.
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
    """Contacts moved from one depth to another; None where more happens than lines creeping."""
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
