"""What happens under a dead load or a machine, read off the depth path.

C(d), the value of the control at which a place of the depth path is in equilibrium, is P(d) for a
dead load and d + P(d)/K for a machine. As the control rises, the depth is where C first reaches it
on the path from the present place with rising depth; as it falls, where C first falls to it on the
path from the present place with falling depth. In between, C may fall before it rises again: the
indenter jumps from the top of C over all that to where C comes back to the same value.

The path is sampled in steps of the depth, fine enough to see every change of lines that is not
smooth; what happens at once is found by bisection, tops of C by Brent's method, values by roots.
"""

import math
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq, minimize_scalar

from ..ground import Outside
from ..totals import NOTHING
from .depth_paths import Place

LARGEST = 1 / 8  # of the depth scale: the longest step on the way
SMALLEST = 1 / 400  # of the depth scale: the shortest
CLOSE = 1e-9  # of the depth scale: what happens at once
KINK = 1e-6  # of the depth scale: where a line leaves a corner, or comes to one
JUMPED = 1e-4  # of the feature: lines that move farther within that have jumped
TOP = 1e-6  # of the depth scale: how well a top of C is located, with few steps
SMOOTH = 0.01  # of the feature: how far lines may be from the mean of those beside


class Control(NamedTuple):
    """stiffness K: 0 for a dead load."""

    stiffness: float

    def value(self, depth, force):
        """The value at which this force and depth are in equilibrium."""
        return depth + force / self.stiffness if self.stiffness else force

    def potential(self, depth, value):
        """Energy of what holds the indenter: -F d or K/2 (D - d)²."""
        return self.stiffness / 2 * (value - depth) ** 2 if self.stiffness else -value * depth


class Jump(NamedTuple):
    """The value at which the indenter jumps, the places and states beside it, and the energy lost.

    step: of the programme.
    """

    value: float
    before: Place
    after: Place
    first: object
    second: object
    released: float
    step: int


class Sample(NamedTuple):
    """A place of the path, and C there times the direction of the control."""

    place: Place
    height: float


class Reading:
    """A path under a control, from before first touch on.

    scale: of depths; finer: a factor on the number of steps; marks: depths that are sampled, too.
    """

    def __init__(self, path, control, scale, finer=1.0, marks=()):
        self.path = path
        self.control = control
        self.scale = scale
        self.finer = finer
        self.marks = marks
        self.value = -math.inf
        self.place = Place(-math.inf)
        self.close = CLOSE * scale / finer
        self.jumps = []
        self.step = 0

    def go(self, value, guess=None):
        """To the next value: the place there. guess: of the depth, not needed here."""
        free = self.control.value(self.path.touch, 0.0)
        if self.place.lines and value != self.value:
            way = 1 if value > self.value else -1
            here = self._sample(self.place, self.place.depth, way)
            self._follow(here, here, way * value, way)
        if not self.place.lines:
            self.place = Place(value if self.control.stiffness else -math.inf)
            if value >= free:  # contact begins, and C falls where adhesion pulls
                touching = self._sample(Place(self.path.touch), self.path.touch, +1)
                self._follow(touching, Sample(Place(self.path.touch), free), value, +1)
        self.value = value
        self.step += 1
        return self.place

    def beyond(self, value, window):
        """The values of jumps if the control went on from here to this value and by this much."""
        if not self.place.lines:
            return []
        peek = Reading(self.path, self.control, self.scale, self.finer, self.marks)
        peek.place = self.place
        peek.value = value
        try:
            peek.go(value + window)
        except Outside:
            return []
        return [jump.value for jump in peek.jumps]

    def state(self, place):
        """Force and energy of a place."""
        return self.path.totals(place) if place.lines else NOTHING

    def reached(self, place):
        """C at a place."""
        return self.control.value(place.depth, self.state(place).force)

    def _follow(self, here, top, goal, way):
        """Along the path to where C first has the value, with the jumps on the way.

        here: a sample of the path; top: the highest one so far, here itself if C rises from it.
        """
        before = here
        if here is not top and here.height >= top.height:
            self._record(way * top.height, top.place, here.place)
            top = here
        self.place = here.place
        while here.height < goal:
            for there in self._ahead(here, top, goal, way):
                if here is top and there.height < here.height:
                    top = self._top(before, here, there, way)
                elif here is top and self._at_once(here.place, there.place):  # a stiff machine
                    self._record(way * here.height, here.place, there.place)
                if not there.place.lines:
                    return self._lost(top, here, there, way)
                if here is not top and there.height >= top.height:
                    here = self._back(top, here, there, way)
                    before = top = here
                if there.height >= goal:
                    self.place = self._root(here.place, there.place, goal, way)
                    return None
                if there.height >= top.height:
                    before = here
                    top = there
                here = there
        return None

    def _record(self, value, before, after):
        """A jump, unless it is none."""
        first = self.state(before)
        second = self.state(after)
        released = first.energy - second.energy
        released += self.control.potential(before.depth, value)
        released -= self.control.potential(after.depth, value)
        self.jumps.append(Jump(value, before, after, first, second, released, self.step))

    def _sample(self, start, depth, way):
        """A place on the way from another; where contact is lost, nothing holds the indenter."""
        place = self.path.moved(start, depth)
        return Sample(place, way * self.reached(place) if place.lines else -math.inf)

    def _back(self, top, here, there, way):
        """Where C comes back to its top: the indenter has jumped to there."""
        place = self._root(here.place, there.place, top.height, way)
        self._record(way * top.height, top.place, place)
        return Sample(place, top.height)

    def _lost(self, top, here, there, way):
        """The contact closes before C comes back to its top."""
        value = way * top.height
        held = here.place
        depth = there.place.depth
        while abs(held.depth - depth) > self.close:
            middle = self.path.moved(here.place, (held.depth + depth) / 2)
            held, depth = (middle, depth) if middle.lines else (held, middle.depth)
        self.place = Place(value if self.control.stiffness else held.depth)
        self._record(value, top.place, self.place)

    def _rate(self, place):
        """The most by which C rises with the depth."""
        return self.control.value(1.0, self.path.stiffness(place))

    def _ahead(self, here, top, goal, way):
        """The next samples on the way, up to one step."""
        wanted = goal if here is top else top.height
        least = (wanted - here.height) / self._rate(here.place)  # before that C cannot be there
        step = min(max(least, SMALLEST * self.scale), LARGEST * self.scale) / self.finer
        start = here.place.depth
        depth = self.path.farthest(here.place, start + way * step)
        marks_ahead = [way * mark for mark in self.marks if way * (mark - start) > 0]
        nearest = way * min([way * depth, *marks_ahead])
        there = self._sample(here.place, nearest, way)
        if not self.path.jumps:
            return [there]
        return [*self._between(here, there, way), there]

    def _between(self, here, there, way):
        """Samples between two, so many that lines move smoothly but for what happens at once.

        Where a line leaves a corner, comes to one or jumps over one, samples crowd on both sides.
        """
        a = here.place
        b = there.place
        alike = self.path.passed(a) == self.path.passed(b)
        apart = _apart(a.lines, b.lines)
        least = KINK * self.scale if apart <= JUMPED * self.path.feature else self.close
        smooth = alike and apart <= SMOOTH * self.path.feature
        if smooth or abs(b.depth - a.depth) <= least:
            return []
        middle = self._sample(a, (a.depth + b.depth) / 2, way)
        if alike and len(a.lines) == len(b.lines):
            mean = tuple(np.add(a.lines, b.lines) / 2)
            if _apart(middle.place.lines, mean) <= SMOOTH * self.path.feature:
                return [middle]
        return [*self._between(here, middle, way), middle, *self._between(middle, there, way)]

    def _root(self, start, end, height, way):
        """The place between two where C has a value, times way."""

        known = {start.depth: start, end.depth: end}

        def to(depth):
            if depth not in known:
                before = [d for d in known if way * (depth - d) >= 0]
                known[depth] = self.path.moved(known[max(before, key=lambda d: way * d)], depth)
            return known[depth]

        if way * self.reached(start) >= height:
            return start
        xtol = 1e-11 * self.scale + 1e-16 * abs(end.depth)
        off = lambda d: way * self.reached(to(d)) - height  # noqa: E731
        return to(brentq(off, start.depth, end.depth, xtol=xtol, rtol=1e-15))

    def _at_once(self, a, b):
        """Whether lines jump between two places."""
        if not self.path.jumps or abs(b.depth - a.depth) > self.close:
            return False
        return _apart(a.lines, b.lines) > JUMPED * self.path.feature

    def _top(self, before, here, there, way):
        """The top of C between two samples, of which the one in between is higher."""
        start = before.place
        depth = here.place.depth
        ends = sorted((start.depth - depth, there.place.depth - depth))
        if abs(there.place.depth - here.place.depth) <= 2 * self.close:  # at once
            return Sample(*here)
        tried = [here]
        least = here.height - self._rate(start) * (ends[1] - ends[0])

        def below(off):
            tried.append(self._sample(start, depth + off, way))
            return -max(tried[-1].height, least)

        near = {"xatol": TOP * self.scale / self.finer**4}
        minimize_scalar(below, bounds=ends, method="bounded", options=near)
        return Sample(*max(tried, key=lambda sample: sample.height))


def _apart(lines, others):
    """How far lines are from others, inf if they are not as many."""
    if len(lines) != len(others):
        return math.inf
    return float(np.abs(np.subtract(lines, others)).max(initial=0.0))


class Unique(Reading):
    """Without adhesion: C rises with the depth, each value has one place, and nothing jumps."""

    def beyond(self, value, window):
        return []

    def go(self, value, guess=None):
        """To a value: where it is guessed, or by roots."""
        touch = self.path.touch
        self.value = value
        self.step += 1
        off = value - self.control.value(touch, 0.0)
        if off < 0:
            self.place = Place(value if self.control.stiffness else -math.inf)
            return self.place
        rate = self.control.value(1.0, 0.0) + self.control.value(0.0, self.path.stiffness(None))

        def above(depth):
            self.place = self.path.moved(None, depth)
            return self.reached(self.place) - value

        guess = touch if guess is None or not guess >= touch else guess
        if abs(above(guess)) > CLOSE * rate * self.scale:
            high = touch + off / rate * (1 + 1e-9)  # C rises by no less than rate
            above(brentq(above, touch, high, xtol=self.close))
        return self.place


def reading_of(path, *given):
    """How the path under a control is read off this one; given: as to `Reading`."""
    return (Reading if path.scene.opened.work_of_adhesion else Unique)(path, *given)
