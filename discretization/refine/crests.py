"""Where gaps open and close without adhesion: at crests of the profile, as narrow as one likes.

In contact the profile presses with kg + γ₁f'', g = d - f. Without adhesion a gap opens where that
would become negative, and the last of one is gone where it does no more: at the depth

    d = max (f - l² f'')

over what may be in contact, at the place where that is largest (fitted/tension.py).
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
    """What finds the depths and places at which gaps are as narrow as one likes."""

    equations: Equations

    def find(self, events: Sequence[Happening]) -> list[Happening]:
        """Those of these events that are of this kind, with their depths and lines (1, 2)."""
        return [event for event in events if self._is_one(event) and self._found(event)]

    def _is_one(self, event: Happening) -> bool:
        scene = self.equations.scene
        if event.direction > 0:
            return not scene.work_of_adhesion and len(event.before) == 1 and not event.after
        torn = not event.before and len(event.after) == 1
        return torn and not scene.opened.work_of_adhesion

    def _found(self, event: Happening) -> bool:
        (life,) = event.before or event.after
        ends = life.lines_at(life.trace[-1 if event.before else 0][1])
        nodes = life.nodes
        low, high = ends + _AROUND * nodes.spacing * np.array([-1.0, 1.0])
        depth = event.at
        place = np.nan
        scene, profile = self.equations.scene, self.equations.profile
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
        return True
