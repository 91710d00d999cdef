"""Force and energy of given contacts; their lines polished by Newton's method."""

from typing import NamedTuple

import numpy as np

PANEL = 4  # per feature
GAUSS = np.polynomial.legendre.leggauss(20)
STEP = 1e-5  # of the feature: for difference quotients
NEAR = 1e-3  # of the feature: farther, Newton's method would have gone elsewhere


class State(NamedTuple):
    """A reference solution: contacts (m, 2), force, energy, and the sums of the terms' sizes."""

    contacts: np.ndarray
    force: float
    energy: float
    force_scale: float
    energy_scale: float

    @property
    def half_width(self):
        """Half the total contact length."""
        return float(np.sum(self.contacts[:, 1] - self.contacts[:, 0])) / 2


NOTHING = State(np.empty((0, 2)), 0.0, 0.0, 0.0, 0.0)


def polished(lines, depth, ground, surface, near=NEAR):
    """The lines with lean(f') + tilt = deficit to rounding; those at corners and ends stay."""
    lines = np.array(lines, float)
    known = np.union1d(ground.corners, [ground.lo, ground.hi])
    loose = np.flatnonzero(~np.isin(lines, known))
    if not loose.size:
        return lines
    x = lines
    best = np.abs(imbalance(lines, depth, ground, surface)[loose]).max()
    for _ in range(4):
        value = imbalance(x, depth, ground, surface)
        J = jacobian(x, depth, ground, surface)[np.ix_(loose, loose)]
        if not np.isfinite(J).all():
            break  # an end of the body is next to a line
        x = x.copy()
        x[loose] -= np.linalg.lstsq(J, value[loose], rcond=None)[0]
        if np.abs(x - lines).max() > near * ground.feature or (np.diff(x) < 0).any():
            break
        size = np.abs(imbalance(x, depth, ground, surface)[loose]).max()
        if size < best:
            lines = x
            best = size
    return lines


def jacobian(x, depth, ground, surface):
    """Of the imbalance by the lines, from central differences: of a line and the one it faces.

    All left lines are moved at once, then all right ones, as no two of them face each other.
    """
    J = np.zeros((x.size, x.size))
    step = STEP * ground.feature
    i = np.arange(x.size)
    facing = i + np.where(i % 2, 1, -1)
    for side in (0, 1):
        shift = step * (i % 2 == side)
        two = [imbalance(x + s * shift, depth, ground, surface) for s in (1, -1)]
        rate = (two[0] - two[1]) / (2 * step)
        own = i[i % 2 == side]
        J[own, own] = rate[own]
        own = own[(facing[own] >= 0) & (facing[own] < x.size)]
        J[facing[own], own] = rate[facing[own]]
    return J


def imbalance(lines, depth, ground, surface):
    """lean(f') + tilt - deficit at each line (2m,): 0 at rest."""
    sides = np.where(np.arange(lines.size) % 2, 1.0, -1.0)
    g = depth - ground.height(lines)
    tilt = np.empty_like(g)
    tilt[[0, -1]] = surface.tail(g[[0, -1]])
    if lines.size > 2:
        width = lines[2::2] - lines[1:-1:2]
        left = g[1:-1:2]
        right = g[2::2]
        tilt[1:-1:2] = surface.facing(left, right, width)
        tilt[2::2] = surface.facing(right, left, width)
    return surface.lean(sides * ground.slope(lines, sides)) + tilt - surface.deficit


def state_of(lines, depth, ground, surface, scene):
    """Force k∫u dx and energy of these lines (2m,), by Gauss's rule between the profile's knots."""
    lines = np.asarray(lines, float)
    if not lines.size:
        return NOTHING
    contacts = lines.reshape(-1, 2)
    x, weights = points(contacts, ground)
    g = depth - ground.height(x)
    slope = np.asarray(ground.indenter.slope(x), float)
    k = scene.stiffness
    gamma1 = scene.gamma1
    w = scene.work_of_adhesion
    if scene.pattern is not None:
        w = w * scene.pattern.factor(x)
    spring = k / 2 * g**2
    held = gamma1 / 2 * slope**2 - w
    if scene.slopes == "finite":
        root = np.sqrt(1 + slope**2)
        held = gamma1 * slope**2 / (1 + root) - w * root
    ends = depth - ground.height(lines)
    area = [surface.tail_area(e) for e in ends[[0, -1]]]
    free = []
    free += [surface.tail_energy(e) for e in ends[[0, -1]]]
    for i in range(1, lines.size - 1, 2):
        gap = (float(ends[i]), float(ends[i + 1]), float(lines[i + 1] - lines[i]))
        area.append(surface.gap_area(*gap))
        free.append(surface.gap_energy(*gap))
    return State(
        contacts,
        float(k * (weights @ g + np.sum(area))),
        float(weights @ (spring + held) + np.sum(free)),
        float(k * (weights @ np.abs(g) + np.sum(np.abs(area)))),
        float(weights @ (spring + np.abs(held)) + np.sum(free)),
    )


def points(contacts, ground):
    """Places and weights of Gauss's rule over the contacts, in panels without knots inside."""
    x = []
    weights = []
    knots = np.union1d(ground.corners, np.asarray(ground.indenter.knots, float))
    for left, right in contacts.tolist():
        count = int(np.ceil((right - left) / ground.feature * PANEL)) + 1
        inside = knots[(knots > left) & (knots < right)]
        ends = np.union1d(np.linspace(left, right, count + 1), inside)
        half = np.diff(ends)[:, None] / 2
        middle = (ends[1:] + ends[:-1])[:, None] / 2
        x.append((middle + half * GAUSS[0]).ravel())
        weights.append((half * GAUSS[1]).ravel())
    return np.concatenate(x), np.concatenate(weights)


def adhered(walk, depth):
    """The state of a walk that goes to this depth."""
    lines = polished(walk.to(depth), depth, walk.ground, walk.surface)
    return state_of(lines, depth, walk.ground, walk.surface, walk.scene)
