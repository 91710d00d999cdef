"""Where gaps open and close without adhesion: at crests of the profile, as narrow as one likes.

In contact the profile presses with kg + γ₁f'', g = d - f. Without adhesion a gap opens where that
would become negative, and the last of one is gone where it does no more: at the depth

    d = max (f - l² f'')

over what may be in contact, at the place where that is largest (fitted/tension.py).

Conventions
-----------
Depths d grow as the indenter goes down; heights f of the profile are positive upwards. A
`Happening` is an event that ends the free surfaces `before` and begins those `after`, with its
depth on the nodes, `at`, and its refined depth, `depth`; its direction is 1 where the depth grows,
so that a gap closes (it has no surface after it), and -1 where it falls, so that a gap opens (none
before it). Lines (1, 2) of the gap are its left and its right one, both at the crest.

`pull` looks in contact, between two positions and at a depth, for where the profile would pull the
surface: `worst` is the largest pull over k, -(d - f) - l² f'' [length], so that d + worst is the
depth of the crest, and `ends` are both ends of where it pulls; 0 and nan if nowhere.

Of a `Life`, a free surface, `trace` has depths on nodes, each with the contact nodes at its ends
from there on, and `lines_at` the positions of these; of its `nodes`, `spacing` is how far apart
they are and `margin` by how much depths on them may be off. `scene.work_of_adhesion` is that of
closing, that of `scene.opened` of opening.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discretization.fitted.tension import pull
from discretization.refine.equations import Equations
from discretization.refine.events import NotRefined
from discretization.refine.lives import Happening

# Halved or doubled neither changes a result (`python -m tests.sensitivity
# discretization.refine.crests`).
_AROUND = 4.0  # spacings of nodes: so far from the nodes of a gap its crest may be
_BELOW = (1e-3, 1e-7)  # margins below the crest's depth, from where its place is narrowed down


@dataclass(frozen=True, eq=False)
class Crests:
    """What finds the depths and places at which gaps are as narrow as one likes.

    Attributes
    ----------
    equations : Equations
    """

    equations: Equations

    def find(self, events: Sequence[Happening]) -> list[Happening]:
        """Those of these events that are of this kind.

        Their depths and lines are written into them, and that they are smooth.
        """
        found = [event for event in events if self._is_one(event)]
        for event in found:
            self._find(event)
        return found

    def _is_one(self, event: Happening) -> bool:
        """Whether a gap opens or closes at an event, and contacts do not adhere when they do so."""
        scene = self.equations.scene
        if event.direction > 0:
            return not scene.work_of_adhesion and len(event.before) == 1 and not event.after
        opens_inside = not event.before and len(event.after) == 1
        return opens_inside and not scene.opened.work_of_adhesion

    def _find(self, event: Happening) -> None:
        """Write the depth and the place of the crest into an event of a gap.

        NotRefined unless it is near the nodes of the gap.
        """
        (life,) = event.before or event.after
        ends = life.lines_at(life.trace[-1 if event.before else 0][1])
        nodes = life.nodes
        low, high = ends + _AROUND * nodes.spacing * np.array([-1.0, 1.0])
        scene = self.equations.scene
        profile = self.equations.profile
        # The pull is read a little below the depth, where the profile pulls around the crest: the
        # middle of that is the crest. First the depth is that on the nodes, and may be too low.
        depth = event.at
        place = np.nan
        for below in _BELOW:
            start = depth - below * nodes.margin
            found = pull(scene, profile, low, high, start)
            if not found.worst > 0:
                start = depth - nodes.margin
                found = pull(scene, profile, low, high, start)
            depth = start + found.worst
            place = float(np.mean(found.ends))
        if not low < place < high:
            raise NotRefined(f"the crest near depth = {event.at!r} is not found", event.at)
        event.smooth = True
        event.depth = depth
        at_crest = np.array([[place, place]])
        if event.before:
            event.lines_before = at_crest
        else:
            event.lines_after = at_crest
