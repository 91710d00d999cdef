"""w = 0: the smallest u >= g that hangs between its contacts like a free surface, by its hull.

The energy is convex and the state the only one; it is the least majorant of g that is concave with
respect to the free surfaces {exp(x/l), exp(-x/l)}. Over nodes it is found like a convex hull, by
one pass that drops a node that lies below the free surface between its neighbours; then nodes are
added at the contact lines and where the surface still dips below the indenter, and in the end the
lines are polished by Newton's method on f' + u' = 0. Where the profile would pull most at a surface
in contact, g + l² f'' < 0 least, three nodes lie close together, so that no gap is missed there.
"""

import functools
import math

import numpy as np
from scipy.optimize import brentq

from .ground import Ground, Outside, Surfaces, refined_minima
from .surfaces import surface_of
from .totals import NOTHING, State, points, polished, state_of

TIE = 1e-13
ROUNDING = 4e-16  # of the depths: what counts as touching, and noise
ROUNDS = 8
FINER = 4.0
AROUND = 8
MOST = 12
JOINED = 1e-5  # rounds; of the feature
CLOSE = (1e-3, 1e-4, 1e-5)
PULLED = 1e-9  # of the feature; of the depths: a pull
APART = 1e-9  # of the feature: nodes closer than that are one


def obstacle(scene, feature, depth):
    """The state without adhesion. Outside if it reaches an end of the profile."""
    return Hull(scene, feature).state(depth)


class Hull:
    """The states of a scene without adhesion at any depths."""

    def __init__(self, scene, feature):
        self.scene = scene
        self.surface = surface_of(scene)
        self.ground = ground = Ground(scene.indenter, min(feature, self.surface.length))
        inside = ground.corners[(ground.corners > ground.lo) & (ground.corners < ground.hi)]
        beside = JOINED * ground.feature  # a gap opens at every corner that points inwards
        self.lowest = float(np.abs(ground.heights.min()))
        self.extra = [*ground.lowest(TIE * self.lowest)[1], *(inside - beside), *(inside + beside)]

    def state(self, depth):
        """The state at this depth."""
        tie = TIE * (abs(depth) + self.lowest)
        free = Surfaces(self.ground, self.surface, tie)
        extra = [*self.extra, *self._stretched(depth)]
        for _ in range(MOST):
            lines = self._lines(depth, extra)
            ends = [-math.inf, *lines, math.inf]
            pairs = zip(ends[::2], ends[1::2], strict=True)
            dips = [x for pair in pairs for v, x in free.dips(*pair, depth) if v < -tie]
            if not dips:
                return state_of(lines, depth, self.ground, self.surface, self.scene)
            extra = [*extra, *dips]
        raise RuntimeError(f"the obstacle problem at depth = {depth!r} is not solved to rounding")

    @functools.cached_property
    def _pulls(self):
        """(x, f - l² f'') where the profile would pull most, which may be at a knot."""
        ground = self.ground
        near = min(CLOSE) * self.ground.feature

        def stress(x):
            rise = ground.slope(x + near, -1) - ground.slope(x - near, 1)
            return self.surface.length**2 * rise / (2 * near) - ground.height(x)

        x = np.union1d(ground.nodes, np.asarray(ground.indenter.knots, float))
        x = x[(x > ground.lo + near) & (x < ground.hi - near)]
        return refined_minima(stress, x, stress(x), math.inf)

    def _stretched(self, depth):
        """Nodes close to every place where the profile would pull most at this depth."""
        for at, value in self._pulls:
            if depth + value < -PULLED * (abs(depth) + self.lowest):
                yield at
                for close in CLOSE:
                    yield from (at - close * self.ground.feature, at + close * self.ground.feature)

    def _lines(self, depth, extra):
        """Lines of the hull over the ground's nodes and `extra`, zoomed in on and polished."""
        ground = self.ground
        surface = self.surface
        step = self.ground.step
        kept = _with(ground.corners, np.unique(extra), APART * ground.feature)
        nodes = _with(kept, ground.nodes, step / 8)
        noise = ROUNDING * (abs(depth) + self.lowest)
        lines = hull_lines(nodes, depth - ground.height(nodes), surface.length, noise)
        for _ in range(ROUNDS):
            step /= FINER
            near = np.arange(-AROUND, AROUND + 1) * step
            nodes = np.unique(np.concatenate([nodes, *(x + near for x in lines)]))
            nodes = _with(kept, nodes[(nodes >= ground.lo) & (nodes <= ground.hi)], step / 8)
            lines = hull_lines(nodes, depth - ground.height(nodes), surface.length, noise)
        if lines.size and (lines[0] <= ground.lo or lines[-1] >= ground.hi):
            raise Outside("the contact reaches an end of the profile")
        return polished(_joined(lines, ground), depth, ground, surface) if lines.size else lines


def _with(kept, nodes, least):
    """These nodes and those of some others (sorted) that are farther than `least` from any.

    Two as close as rounding would hold each other on the hull, however low they lie.
    """
    nodes = nodes[np.diff(nodes, prepend=-math.inf) > least]
    ends = np.concatenate([[-math.inf], kept, [math.inf]])
    after = np.searchsorted(ends, nodes)
    apart = np.minimum(nodes - ends[after - 1], ends[after] - nodes)
    return np.union1d(kept, nodes[apart > least])


def _joined(lines, ground):
    """Without gaps as narrow as noise makes them."""
    narrow = np.flatnonzero(lines[2::2] - lines[1:-1:2] <= JOINED * ground.feature)
    return np.delete(lines, np.concatenate([2 * narrow + 1, 2 * narrow + 2]))


def hull_lines(nodes, g, length, noise):
    """First and last node of each run of neighbouring nodes on the hull (2m,).

    noise: of g; a node is dropped only if it lies lower by more than that.
    """
    t = (nodes / length).tolist()
    high = g.tolist()
    on = []
    for c in np.flatnonzero(g > 0).tolist():
        if on and high[c] <= high[on[-1]] * math.exp(t[on[-1]] - t[c]):
            continue  # below the tail of the last one
        while on and _below(t, high, on, c, noise):
            on.pop()
        on.append(c)
    hull = np.array(on, int)
    if not hull.size:
        return nodes[:0]
    breaks = np.flatnonzero(np.diff(hull) > 1)
    first = np.r_[hull[:1], hull[breaks + 1]]
    last = np.r_[hull[breaks], hull[-1:]]
    return nodes[np.column_stack([first, last]).ravel()]


def _below(t, high, on, c, noise):
    """Whether the last node of the hull lies below the free surface from the one before to c."""
    b = on[-1]
    if len(on) == 1:
        return high[b] + noise < high[c] * math.exp(t[b] - t[c])
    a = on[-2]
    left = t[b] - t[a]
    right = t[c] - t[b]
    if left + right > 600:
        return False
    chord = high[a] * math.sinh(right) + high[c] * math.sinh(left)
    return (high[b] + noise) * math.sinh(left + right) < chord


LEVEL = 1e-15  # of the heights: rounding of a level


def springs(scene, feature, depth):
    """The adhered state: {f <= d} in contact, for d below first touch nothing of any width."""
    ground = Ground(scene.indenter, feature)
    return of_level(scene, ground, intervals(ground, depth), depth)


def of_level(scene, ground, contacts, depth):
    """Force and energy of the springs in these contacts (m, 2) at this depth."""
    if not len(contacts):
        return NOTHING
    k = scene.stiffness
    w = scene.work_of_adhesion
    x, weights = points(contacts, ground)
    g = depth - ground.height(x)
    force = k * (weights @ g)
    spring = k / 2 * (weights @ g**2)
    held = w * weights.sum()
    size = k * (weights @ np.abs(g))
    return State(contacts, float(force), float(spring - held), float(size), float(spring + held))


def intervals(ground, depth):
    """Where f <= depth (m, 2). Outside if that reaches an end of the profile."""
    x, f = ground.monotone
    inside = f <= depth + LEVEL * np.abs(f).max()
    if inside[0] or inside[-1]:
        raise Outside("the contact reaches an end of the profile")
    edges = np.flatnonzero(inside[1:] != inside[:-1])
    found = [_crossing(ground, depth, float(x[i]), float(x[i + 1])) for i in edges.tolist()]
    return np.array(found, float).reshape(-1, 2)


def _crossing(ground, depth, low, high):
    """Where f = depth between two places."""

    def above(x):
        return float(ground.height(x)) - depth

    if above(low) * above(high) >= 0:
        return low if abs(above(low)) <= abs(above(high)) else high
    return brentq(above, low, high, xtol=1e-17 * max(abs(low), abs(high)), rtol=1e-15)
