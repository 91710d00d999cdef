"""The lowest of all states, by a dynamic programme over contact nodes (small slopes).

Between contact nodes i < j hangs a free surface, admissible if it does not penetrate: the slope
with which it leaves i to reach j is not less than for any node between, as surfaces that leave i
are ordered by that slope. The energy is a sum over such gaps, links in contact and two tails, and
cost[j] = min over i of cost[i] + gap(i, j) finds its minimum over all contact sets of the nodes.
The lines found that way then move to rest by Newton's method, which can only lower the energy.
"""

import math

import numpy as np

from .ground import Ground, Outside, Surfaces, refined_minima
from .surfaces import surface_of
from .totals import NOTHING, polished, state_of

PER_FEATURE = 24  # nodes: the contact set need only be near enough for Newton's method
FEWEST = 32  # nodes low enough for contact; with fewer the lowest part is looked at closer
MOST = 2400  # nodes: the programme takes n² steps
FINEST = 1e-8  # of the feature: how close it is looked at
LOW = 3.0  # δ₀: no contact reaches farther below the surface
TIE = 1e-13  # of δ₀ and the depth: rounding of v


def lowest(scene, feature, depth):
    """The state of least energy, detached included."""
    surface = surface_of(scene)
    ground = Ground(scene.indenter, min(feature, surface.length))
    lines = best_lines(scene, ground, surface, depth)
    if not lines.size:
        return NOTHING
    if lines[0] <= ground.lo or lines[-1] >= ground.hi:
        raise Outside("the contact reaches an end of the profile")
    lines = polished(lines, depth, ground, surface, near=0.2)
    if dips(lines, depth, ground, surface, scene):
        raise Outside("the lowest contact set on nodes misses a tip between them")
    found = state_of(lines, depth, ground, surface, scene)
    tie = TIE * scene.critical_separation
    penetrates = depth > ground.lowest(tie)[0] + tie  # a flat surface
    return found if found.energy < 0 or penetrates else NOTHING


def best_lines(scene, ground, surface, depth):
    """First and last node of each contact of the cheapest set; empty if none is cheaper than 0."""
    x = _nodes(scene, ground, depth)
    if not x.size:
        return x
    g = depth - ground.height(x)
    left = surface.tail_energy(g) + _through(x, g, surface.length)
    right = surface.tail_energy(g) + _through(-x[::-1], g[::-1], surface.length)[::-1]
    linked = np.diff(x) <= 1.5 * np.median(np.diff(x))
    links = np.where(linked, _links(scene, ground, depth, x), np.inf)
    cost = left
    before = np.full(x.size, -1)
    for i in range(x.size - 1):
        if np.isfinite(cost[i]):  # of all ways to i by now, so that it may be gone on from
            gaps = _gaps(x[i:], g[i:], surface)
            through = cost[i] + np.append(links[i], gaps[1:])
            lower = through < cost[i + 1 :]
            cost[i + 1 :][lower] = through[lower]
            before[i + 1 :][lower] = i
    last = int(np.argmin(cost + right))
    path = [last]
    while before[path[-1]] >= 0:
        path.append(int(before[path[-1]]))
    return _ends(x, np.array(path[::-1]), linked)


def _nodes(scene, ground, depth):
    """Evenly spaced nodes where contact may be; corners are among them to within a spacing."""
    low = depth + LOW * scene.critical_separation
    tips = [at for at, _ in refined_minima(ground.height, ground.nodes, ground.heights, depth)]
    x = ground.nodes
    f = ground.heights
    while True:
        near = np.union1d(x[f <= low], tips)
        if not near.size:
            return near
        around = np.searchsorted(x, near[[0, -1]]) + np.array([-1, 1])
        first, last = x[np.clip(around, 0, x.size - 1)]
        if near.size > FEWEST or last - first < FINEST * ground.feature:
            break
        x = np.linspace(first, last, 16 * FEWEST)
        f = ground.height(x)
    count = math.ceil((last - first) / ground.feature * PER_FEATURE)
    x = np.linspace(first, last, min(MOST, max(count, 400)))
    return np.union1d(x[ground.height(x) <= low], tips)


def _gaps(x, g, surface):
    """Energy of the free surface from the first node to each (n - 1,), inf where it penetrates."""
    t = np.minimum((x[1:] - x[0]) / surface.length, 300.0)
    m = -np.expm1(-t)
    one_over_sinh = 2 * (1 - m) / (m * (2 - m))  # 1/sinh t
    tanh_of_half = m / (2 - m)  # tanh t/2
    here = g[0]
    there = g[1:]
    slope = (there - here) * one_over_sinh - here * tanh_of_half
    highest_before = np.maximum.accumulate(np.append(-np.inf, slope[:-1]))
    energy = (there - here) ** 2 * one_over_sinh + (there**2 + here**2) * tanh_of_half
    energy *= surface.gamma1 / (2 * surface.length)
    return np.where(slope >= highest_before, energy, np.inf)


def _through(x, g, length):
    """Infinite where a tail to the left would penetrate: g_i exp(-(x_i - x_m)/l) < g_m."""
    highest = np.full(x.size, -np.inf)
    for i in range(1, x.size):
        highest[i] = max(highest[i - 1], g[i - 1]) * np.exp((x[i] - x[i - 1]) / length)
    return np.where(g >= highest, 0.0, np.inf)


def _links(scene, ground, depth, x):
    """Energy of contact between neighbouring nodes, by Simpson's rule."""
    k = scene.stiffness
    gamma1 = scene.gamma1
    w = scene.work_of_adhesion
    middle = (x[1:] + x[:-1]) / 2

    def density(at, slope):
        return k / 2 * (depth - ground.height(at)) ** 2 + gamma1 / 2 * slope**2 - w

    ends = density(x[:-1], ground.slope(x[:-1], 1)) + density(x[1:], ground.slope(x[1:], -1))
    return np.diff(x) / 6 * (ends + 4 * density(middle, ground.slope(middle, 1)))


def _ends(x, path, linked):
    """Lines of the runs of links on a path over the nodes."""
    together = (np.diff(path) == 1) & linked[np.minimum(path[:-1], linked.size - 1)]
    starts = np.concatenate([[True], ~together])
    ends = np.concatenate([~together, [True]])
    return np.column_stack([x[path[starts]], x[path[ends]]]).ravel()


def dips(lines, depth, ground, surface, scene):
    """Where the free surfaces of these lines penetrate the profile: (v, x)."""
    tie = TIE * (scene.critical_separation + abs(depth))
    ends = [-math.inf, *lines, math.inf]
    free = Surfaces(ground, surface, tie)
    pairs = zip(ends[::2], ends[1::2], strict=True)
    return [dip for pair in pairs for dip in free.dips(*pair, depth) if dip[0] < -tie]
