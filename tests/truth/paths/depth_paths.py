"""Depth paths that may turn: a place can be kept, and the path taken from it to any other depth.

Each class answers `moved(place, depth)`, the state that the path from `place` comes to, and
`totals(place)`, its force and energy. Nothing is stored: a place is left as often as one likes.
"""

import functools
from typing import NamedTuple

import numpy as np

from ..ground import Ground
from ..obstacle import Hull, intervals, of_level
from ..totals import NOTHING, state_of
from ..walk import Walk

TURNS = 3000  # moves of lines at one depth
APART = 1e-6  # of δ₀: levels closer than that are one


class Place(NamedTuple):
    """A depth, the lines from left to right there, () if detached; without tension their level."""

    depth: float
    lines: tuple[float, ...] = ()
    level: float | None = None


class Adhering:
    """w > 0 with surface tension: the walk, with two works of adhesion and patterns."""

    jumps = True

    def __init__(self, scene, feature):
        self.scene = scene
        self.walk = Walk(scene, feature)
        self.walk.most = TURNS
        self.touch = self.walk.touch
        self.feature = self.walk.feature
        self._first = tuple(self.walk.to(self.touch))

    def moved(self, place, depth):
        """The place that the path comes to at this depth."""
        if not place.lines and depth < self.touch:
            return Place(depth)
        if place.lines:
            self.walk.put(place.lines, place.depth)
        else:
            self.walk.put(self._first, self.touch)
        return Place(depth, tuple(float(x) for x in self.walk.to(depth)))

    def passed(self, place):
        """How many corners and edges each line has reached from the left, and how many passed.

        With two works of adhesion also whether it is about to advance, and to recede.
        """
        corners = self.walk.ground.corners
        found = []
        if self.scene.opening is not None:
            self.walk.put(place.lines, place.depth)
            found = [self.walk.about(i, way) for i in range(len(place.lines)) for way in (1, -1)]
        return [
            *(np.searchsorted(corners, place.lines, s).tolist() for s in ("right", "left")),
            found,
        ]

    def farthest(self, place, depth):
        """How far on the way to a depth to the next sample."""
        return depth

    def totals(self, place):
        """Force and energy there, with the work of closing."""
        walk = self.walk
        return state_of(place.lines, place.depth, walk.ground, walk.surface, self.scene)

    def stiffness(self, place):
        """k times the length at which fixed lines follow the depth: P' is less on every way."""
        length = self.scene.elastocapillary_length
        width = place.lines[-1] - place.lines[0] if place.lines else 0.0
        return self.scene.stiffness * (width + 2 * length)


class Independent:
    """γ₁ = 0: every spring attaches on touching and lets go at u = -δ₀ of opening.

    Springs differ by their f only, so those in contact are the ones with f below a level: pressed,
    no spring with f < d is free; retracted, none with f > d + δ₀ is held.
    """

    jumps = False

    def __init__(self, scene, feature):
        self.scene = scene
        self.ground = Ground(scene.indenter, feature)
        self.feature = feature
        self.touch = self.ground.lowest(0.0)[0]
        self.held = scene.opened.critical_separation

    def moved(self, place, depth):
        """The place that the path comes to at this depth."""
        if not place.lines and depth < self.touch:
            return Place(depth)
        level = self.touch if place.level is None else place.level
        level = min(max(level, depth), depth + self.held)
        if level < self.touch:
            return Place(depth)
        lines = intervals(self.ground, level).ravel().tolist()
        return Place(depth, tuple(lines) or (self.ground.lowest(0.0)[1][0],) * 2, level)

    @functools.cached_property
    def marks(self):
        """Levels at which contacts split, vanish or come to a corner, and every other node's.

        Between two of them no line moves far, and C bends only once: it has tops beside the ones
        where its slope jumps, and where the profile is nearly flat.
        """
        ground = self.ground
        x = np.concatenate([ground.extremes, ground.corners, ground.nodes[::2]])
        levels = np.unique(ground.height(x))
        return levels[np.diff(levels, prepend=-np.inf) > APART * self.held]

    def farthest(self, place, depth):
        """How far on the way to a depth to the next sample: as it falls, to the next mark."""
        if depth > place.depth or not place.lines:
            return depth
        marks = np.append(self.marks, place.level) - self.held
        return float(np.max(marks[marks < place.depth - APART * self.held], initial=depth))

    def totals(self, place):
        """Force and energy there."""
        contacts = np.array(place.lines).reshape(-1, 2)
        return of_level(self.scene, self.ground, contacts, place.depth)

    def stiffness(self, place):
        """An upper bound of P' on the way in, and of what P loses on the way out."""
        width = place.lines[-1] - place.lines[0] if place.lines else 0.0
        return self.scene.stiffness * (width + self.feature)


class Hanging:
    """w = 0: the only state at each depth, whatever the path."""

    jumps = False

    def __init__(self, scene, feature):
        self.scene = scene
        self.length = scene.elastocapillary_length
        hull = Hull(scene, feature)
        self.feature = hull.ground.feature
        self.touch = hull.ground.lowest(0.0)[0]
        self._at = functools.cache(hull.state)

    def moved(self, place, depth):
        """The place at this depth."""
        if depth < self.touch:
            return Place(depth)
        return Place(depth, tuple(self._at(depth).contacts.ravel().tolist()))

    def totals(self, place):
        """Force and energy there."""
        return self._at(place.depth) if place.lines else NOTHING

    def stiffness(self, place):
        """A lower bound of P': the two tails."""
        return 2 * self.scene.stiffness * self.length


def depth_path_of(scene, feature):
    """The depth path of this scene."""
    adhering = Adhering if scene.opened.work_of_adhesion else Hanging
    return (adhering if scene.gamma1 else Independent)(scene, feature)
