"""References of least energy, without adhesion, without tension; the walk by another definition."""

import itertools
import math

import numpy as np
import pytest
import test_balance as no_adhesion_paths
from scenes import adhesive

from energy import Profile, Scene, cards
from truth import sets
from truth.ground import Ground, Outside
from truth.obstacle import hull_lines, obstacle
from truth.penetration import penetration
from truth.scenes import case_of
from truth.springs import springs
from truth.surfaces import surface_of
from truth.test_truth import BODY, LAYER, WORK, R, ripples
from truth.totals import adhered, imbalance, state_of
from truth.walk import Walk


def test_no_adhesion_parabola():
    scene = adhesive(BODY, w=0.0)
    for depth in (1e-9, 1e-4, 1e-3):
        found = obstacle(scene, 0.01, depth)
        same = {"R": R, "k": scene.stiffness, "gamma1": scene.gamma1}
        a = cards.nonadhesive.parabola_half_width(depth, **same)
        assert abs(found.half_width - a) <= 1e-11 * a
        P = cards.nonadhesive.parabola_force(depth, **same)
        assert abs(found.force - P) <= 1e-12 * P


def test_springs_of_a_parabola():
    scene = adhesive(BODY, gamma1=0.0)
    depth, k, w = 1e-3, scene.stiffness, scene.work_of_adhesion
    a = math.sqrt(2 * R * depth)
    found = springs(scene, 0.01, depth)
    assert abs(found.half_width - a) <= 1e-13 * a
    assert abs(found.force - 4 / 3 * k * depth * a) <= 1e-13 * found.force
    energy = 8 / 15 * k * depth**2 * a - 2 * w * a
    assert abs(found.energy - energy) <= 1e-13 * found.energy_scale


def test_no_adhesion_has_pressure_inside_and_clearance_outside():
    """Which is sufficient, as the problem is convex."""
    several = 0
    for seed in range(40):
        case = case_of("no_adhesion", seed)
        found = obstacle(case.scene, case.feature, case.depth)
        several += len(found.contacts) > 1
        assert_pressed(case.scene, case.feature, case.depth, found, case.scale)
    assert several >= 10


@pytest.mark.parametrize(
    ("kind", "seed"), [("polygon", s) for s in (104, 107, 115, 125, 131, 136)] + [("plateau", 15)]
)
def test_no_contact_is_lost_at_a_corner_next_to_a_node(kind, seed):
    scene, feature, low, depths = no_adhesion_paths.case(kind, seed)
    for depth in depths[depths > low + 0.01 * (depths.max() - low)].tolist():
        found = obstacle(scene, feature, depth)
        assert_pressed(scene, feature, depth, found, depth - low)


def assert_pressed(scene, feature, depth, found, scale):
    """Clearance outside, pressure inside, and lines that push or nothing."""
    ground, surface = Ground(scene.indenter, feature), surface_of(scene)
    lines = found.contacts.ravel()
    assert not sets.dips(lines, depth, ground, surface, scene)
    assert (imbalance(lines, depth, ground, surface) >= -1e-9 * scale / surface.length).all()
    for left, right in found.contacts:
        x = np.linspace(left, right, 101)
        g = depth - scene.indenter.height(x)
        pull = np.diff(scene.indenter.slope(x)) * scene.gamma1  # of γ₁ f'' over each part
        push = scene.stiffness * (g[1:] + g[:-1]) / 2 * np.diff(x)
        assert (pull + push >= -1e-9 * scene.stiffness * scale * (right - left)).all()


def test_the_hull_of_the_obstacle_is_that_of_all_triples():
    rng = np.random.default_rng(3)
    for _ in range(40):
        x = np.sort(rng.uniform(0, 5, 14))
        g = rng.normal(size=14)
        u = np.maximum(g, 0)
        for i, j in itertools.product(range(14), repeat=2):
            u = np.maximum(u, g[i] * np.exp(-np.abs(x - x[i])))
            if i < j:
                p, q, t = x - x[i], x[j] - x, x[j] - x[i]
                chord = (g[i] * np.sinh(q) + g[j] * np.sinh(p)) / math.sinh(t)
                u = np.where((p >= 0) & (q >= 0), np.maximum(u, chord), u)
        on = np.flatnonzero(u <= g + 1e-12)
        lines = hull_lines(x, g, 1.0, 0.0)
        found = np.concatenate(
            [np.flatnonzero((x >= a) & (x <= b)) for a, b in lines.reshape(-1, 2)] or [on[:0]]
        )
        assert found.tolist() == on.tolist()


def test_the_cheapest_set_is_that_of_all_sets(monkeypatch):
    """Over a dozen nodes, by enumeration, with penetration looked for node by node."""
    rng = np.random.default_rng(5)
    for _ in range(4):
        x, z = np.arange(12) * 0.3, rng.uniform(0, 2.0, 12)
        body = Profile(lambda s, z=z, x=x: np.interp(s, x, z), np.zeros_like, (-1, 5))
        scene, depth = Scene(LAYER, WORK(1.0, 0.5), body), rng.uniform(0.2, 1.5)
        ground, surface = Ground(body, 0.3), surface_of(scene)
        monkeypatch.setattr(sets, "_nodes", lambda *_, x=x: x)
        lines = sets.best_lines(scene, ground, surface, depth)
        cheapest = min(_energies(scene, ground, surface, depth, x))
        assert abs(_energy(lines, scene, ground, surface, depth, x) - cheapest) <= 1e-12


def _energies(scene, ground, surface, depth, x):
    """Of every contact set that does not penetrate."""
    for size in range(1, x.size + 1):
        for nodes in itertools.combinations(range(x.size), size):
            g, u = depth - ground.height(x), None
            inside = np.interp(x, x[list(nodes)], g[list(nodes)])
            u = np.where(np.isin(np.arange(x.size), nodes), g, inside)
            for one, two in itertools.pairwise(nodes):
                between = np.arange(one + 1, two)
                u[between] = surface.gap_shape(x[between] - x[one], x[two] - x[one], g[one], g[two])
            u[: nodes[0]] = surface.tail_shape(x[nodes[0]] - x[: nodes[0]], g[nodes[0]])
            u[nodes[-1] + 1 :] = surface.tail_shape(x[nodes[-1] + 1 :] - x[nodes[-1]], g[nodes[-1]])
            if (u >= g - 1e-13).all():
                breaks = np.flatnonzero(np.diff(nodes) > 1)
                first = np.r_[nodes[0], np.array(nodes)[breaks + 1]]
                last = np.r_[np.array(nodes)[breaks], nodes[-1]]
                lines = x[np.column_stack([first, last])].ravel()
                yield _energy(lines, scene, ground, surface, depth, x)


def _energy(lines, scene, ground, surface, depth, x):
    g, links = depth - ground.height(lines), sets._links(scene, ground, depth, x)
    inside = sum(
        links[(x[:-1] >= a - 1e-9) & (x[1:] <= b + 1e-9)].sum() for a, b in lines.reshape(-1, 2)
    )
    free = surface.tail_energy(g[0]) + surface.tail_energy(g[-1])
    gaps = zip(g[1:-1:2], g[2::2], np.diff(lines)[1::2], strict=True)
    return inside + free + sum(surface.gap_energy(*gap) for gap in gaps)


def test_the_lowest_state_is_not_above_the_adhered_one():
    below = 0
    for seed in range(20):
        case = case_of("global", seed)
        try:
            low = sets.lowest(case.scene, case.feature, case.depth)
            other = adhered(Walk(case.scene, case.feature), case.depth)
        except Outside:
            continue
        assert low.energy <= other.energy + 1e-10 * other.energy_scale
        below += low.energy < other.energy - 1e-6 * other.energy_scale
    assert below >= 1


class Stub:
    """What `penetration` reads of a state."""

    def __init__(self, scene, depth, contacts, displacement):
        self.scene, self.depth, self.displacement = scene, depth, displacement
        self.contacts = np.array(contacts, float).reshape(-1, 2)


def test_penetration_is_found_between_samples():
    scene = adhesive(ripples(1e-3, 0.05, 0.5))
    assert penetration(Stub(scene, -1e-5, [], np.zeros_like), 0.05) == 0.0
    deep = penetration(Stub(scene, 1e-7, [], np.zeros_like), 0.05)
    assert abs(deep - 1e-7) <= 1e-15
    flat = Stub(scene, 1e-4, [(-0.01, 0.01)], np.zeros_like)
    inside = np.linspace(0.01, 0.5, 200001)
    deep = max(0.0, float((1e-4 - scene.indenter.height(inside)).max()))
    assert abs(penetration(flat, 0.05) - deep) <= 1e-3 * deep + 1e-12


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


@pytest.mark.slow
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
