"""The walk against another definition of the same state, without depths in between.

Contacts only grow while the depth does, and a larger contact grows more easily. So the adhered
state at a depth is the smallest contact that contains the first touch and does not grow by either
rule: a line advances while f' + u' < √(2w/γ₁), and what the free surface presses on is in contact
(an obstacle problem between the contacts). Here on nodes, from first touch, at the final depth.
"""

import math

import numpy as np

from truth.ground import Ground
from truth.scenes import case_of
from truth.surfaces import surface_of
from truth.totals import adhered, state_of
from truth.walk import Walk

PER_FEATURE = 100


def pressed(t, g, forced):
    """Nodes of the surface that hangs over the obstacle g and is held on the forced nodes."""
    on = []
    for c in range(t.size):
        while on and not forced[on[-1]]:
            b, a = on[-1], on[-2] if len(on) > 1 else None
            if a is None:
                below = g[b] < g[c] * math.exp(t[b] - t[c])
            else:
                p, q = t[b] - t[a], t[c] - t[b]
                chord = (g[a] * math.sinh(q) + g[c] * math.sinh(p)) / math.sinh(p + q)
                below = g[b] < chord
            if not below:
                break
            on.pop()
        if forced[c] or not on or g[c] > g[on[-1]] * math.exp(t[on[-1]] - t[c]):
            on.append(c)
    return np.array(on)


def ends_of(on):
    """First and last of each run of neighbouring nodes."""
    breaks = np.flatnonzero(np.diff(on) > 1)
    return np.r_[on[:1], on[breaks + 1]], np.r_[on[breaks], on[-1:]]


def closure(case):
    """The smallest contact at the case's depth that does not grow."""
    scene, surface = case.scene, surface_of(case.scene)
    ground = Ground(scene.indenter, min(case.feature, surface.length))
    x = np.linspace(
        ground.lo, ground.hi, int((ground.hi - ground.lo) / ground.feature * PER_FEATURE)
    )
    step, t, g = x[1] - x[0], x / surface.length, case.depth - ground.height(x)
    held = np.zeros(x.size, bool)
    held[np.argmax(g)] = True
    while True:
        on = pressed(t, g, held)
        if len(on) > 1 and not np.isin(on, np.flatnonzero(held)).all():
            held[on] = True
        first, last = ends_of(np.flatnonzero(held))
        u = [-math.inf, *x[np.column_stack([first, last]).ravel()], math.inf]
        grown = held.copy()
        for j, (left, right) in enumerate(zip(u[::2], u[1::2], strict=True)):
            for line, side, other in ((left, 1, right), (right, -1, left)):
                if not math.isfinite(line):
                    continue
                at, width = line + side * step / 2, abs(other - line) - step / 2
                own = case.depth - float(ground.height(at))
                tilt = surface.tail(own)
                if math.isfinite(other) and width > 0:
                    far = case.depth - float(ground.height(other))
                    tilt = float(surface.facing(own, far, width))
                if side * float(ground.slope(at, side)) + tilt < surface.deficit:
                    grown[(last[j - 1] if side > 0 else first[j]) + side] = True
        if (grown == held).all():
            lines = np.array(u[1:-1])
            return state_of(lines, case.depth, ground, surface, scene), step
        held = grown


def test_the_walk_ends_in_the_smallest_contact_that_does_not_grow():
    compared = several = 0
    for seed in range(45):
        case = case_of("small", seed)
        lo, hi = case.scene.indenter.extent
        if case.above < 0 or hi - lo > 80 * case.feature or case.shape == "tiny":
            continue  # retracted, many nodes, or narrower than a node
        found = adhered(Walk(case.scene, case.feature), case.depth)
        other, step = closure(case)
        assert len(other.contacts) == len(found.contacts), seed
        assert np.abs(other.contacts - found.contacts).max() <= 10 * step, seed
        compared += 1
        several += len(found.contacts) > 1
    assert compared >= 20
    assert several >= 5
