"""γ₁ = 0: every spring by itself. Touched where f <= d; below first touch, points without width."""

import numpy as np
from scipy.optimize import brentq

from .ground import Ground, Outside
from .totals import NOTHING, State, points

ROUNDING = 1e-15


def springs(scene, feature, depth):
    """The adhered state: {f <= d} in contact, for d below first touch nothing of any width."""
    ground = Ground(scene.indenter, feature)
    return of_level(scene, ground, intervals(ground, depth), depth)


def of_level(scene, ground, contacts, depth):
    """Force and energy of the springs in these contacts (m, 2) at this depth."""
    if not len(contacts):
        return NOTHING
    k, w = scene.stiffness, scene.work_of_adhesion
    x, weights = points(contacts, ground)
    g = depth - ground.height(x)
    force, spring, held = k * (weights @ g), k / 2 * (weights @ g**2), w * weights.sum()
    size = k * (weights @ np.abs(g))
    return State(contacts, float(force), float(spring - held), float(size), float(spring + held))


def intervals(ground, depth):
    """Where f <= depth (m, 2). Outside if that reaches an end of the profile."""
    x, f = ground.monotone
    inside = f <= depth + ROUNDING * np.abs(f).max()
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
