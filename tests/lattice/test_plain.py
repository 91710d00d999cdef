"""The plain method on nodes: against the fast one, by brute force, and its own certificate."""

import itertools
import math
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest
from support.example_scenes import adhesive, plain, rippled, steep
from support.lattices import lattice
from truth.paths.random_paths import path_case

from discretization import Lattice, NodalEnergy, load_path, minimise
from discretization.lattice.plain import Plain
from discretization.lattice.state import on_lattice, on_route
from discretization.lattice.walk import Front, Walk, ends_of
from discretization.nodes.row import Row
from discretization.nodes.thresholds import Thresholds
from discretization.paths.lattice_branch import LatticeBranch
from discretization.profile import resolve
from energy import FlatPunch, Parabola, PowerLaw, Profile, Scene, Wedge, terms

BODIES = {
    "parabola": lambda x: Parabola(0.02 * x),
    "wedge": lambda x: Wedge(0.1 * x),
    "power": lambda x: PowerLaw(500.0 * x, 3.0),
    "punch": lambda x: FlatPunch(5e-3 * x),
}


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("body", BODIES)
def test_the_fast_method_has_the_same_contacts_and_energies(geometry, body, monkeypatch):
    monkeypatch.setattr("discretization.lattice.walk._LOOKED", 8)  # as if there were many nodes
    rng = np.random.default_rng(len(body))
    attached = 0
    for _ in range(12):
        indenter = BODIES[body](rng.uniform(0.5, 2))
        if geometry == "line" and rng.random() < 0.4:
            indenter = indenter.tilted(rng.uniform(-0.02, 0.02))
        work = rng.choice([0.0, 10 ** rng.uniform(-3, -1)], p=[0.2, 0.8])
        scene = replace(adhesive(indenter, w=0.07 * work), geometry=geometry)
        delta = scene.critical_separation or 1e-3
        depth = delta * rng.uniform(-0.6 if geometry == "line" else 0.0, 2.0)
        spacing = scene.elastocapillary_length / rng.uniform(2, 40)
        fast = on_lattice(scene, depth, spacing)
        lattice = Lattice.of(scene, spacing)
        plain = on_route(Row.of(lattice.scene_on_nodes(scene), lattice, depth), depth, "plain")
        assert np.array_equal(plain.nodes, fast.nodes)
        if not fast.contacts.size:
            continue
        assert np.abs(plain.contacts - fast.contacts).max() <= 1e-7 * spacing
        for name, scale in fast.scales.items():
            assert plain.scales[name] == pytest.approx(scale, rel=1e-9, abs=0)
            assert abs(getattr(plain, name) - getattr(fast, name)) <= 1e-9 * scale
        attached += 1
    assert attached > 5


@pytest.mark.parametrize("body", [Parabola(2.0), Wedge(0.1), FlatPunch(1.0)])
def test_springs_that_stiffen_are_answered_by_nodes_alone(body, monkeypatch):
    """Written down in one place. With γ₁ = 1 the surface beyond the line has u'² = 2 spring(u)."""

    def spring(u, *, k):
        u = np.asarray(u, float)
        return terms.Density(k / 2 * u**2 + k * u**4, k * u + 4 * k * u**3, k + 12 * k * u**2)

    monkeypatch.setattr("energy.terms.spring", spring)
    scene = plain(body)
    nodes = {"method": "lattice", "spacing": 0.02}
    state = minimise(scene, 0.3, **nodes)
    g = 0.3 - body.height(x := np.linspace(0, state.half_width, 2001))
    held = spring(g, k=1.0)
    slope = math.copysign(math.sqrt(2 * spring(g[-1], k=1.0).value), g[-1])
    pressed = (held.first[1:] + held.first[:-1]).sum() * x[1]
    assert state.force == pytest.approx(pressed + 2 * slope, rel=1e-3)
    assert state.line_slopes[1][0, 1] == pytest.approx(-slope, rel=3e-3)
    assert state.pinned.all() or body.slope(x[-1]) - slope == pytest.approx(0.2, rel=1e-3)
    assert sum(state.force_parts.values()) == pytest.approx(state.force, rel=1e-3)
    assert sum(state.energy_parts.values()) == pytest.approx(state.energy, rel=1e-3)
    for asked in (lambda: minimise(scene, 0.3), lambda: load_path(scene, depths=[0.3], **nodes)):
        with pytest.raises(ValueError, match="springs that are not linear"):
            asked()


QUADRATIC = {"twice as stiff": (2.0, 0.0), "with a pressure": (1.0, 1e-3)}


@pytest.mark.parametrize("name", QUADRATIC)
def test_quadratic_springs_other_than_those_of_the_layer_are_known_to_nodes_alone(
    name, monkeypatch
):
    """The mesh would return the state of k u²/2, which a second derivative does not tell apart."""
    factor, pressure = QUADRATIC[name]
    scene = plain(Parabola(2.0))
    assert scene.hookean

    def spring(scene, u):
        whole = terms.spring(u, k=factor * scene.stiffness)
        p = pressure * scene.stiffness * scene.layer.h
        return terms.Density(whole.value - p * u, whole.first - p, whole.second)

    monkeypatch.setattr(Scene, "spring", spring)
    scene = replace(scene)
    assert not scene.hookean
    assert not Lattice.of(scene, 0.02).linear
    with pytest.raises(ValueError, match="springs that are not linear"):
        minimise(scene, 0.3)
    minimise(scene, 0.3, method="lattice", spacing=0.02)


def test_springs_twice_as_stiff_are_those_of_another_layer(monkeypatch):
    """Nodes, by Newton's method, against nodes of linear springs."""
    scene = plain(Parabola(2.0))
    stiff = replace(scene, layer=replace(scene.layer, E=2 * scene.layer.E))
    nodes = {"method": "lattice", "spacing": 0.02}
    expected = minimise(stiff, 0.3, **nodes)
    monkeypatch.setattr(Scene, "spring", lambda scene, u: terms.spring(u, k=2 * scene.stiffness))
    state = minimise(replace(scene), 0.3, **nodes)
    assert state.half_width == pytest.approx(expected.half_width, rel=1e-9)
    assert state.force == pytest.approx(expected.force, rel=1e-9)
    assert state.energy == pytest.approx(expected.energy, rel=1e-9)


@pytest.mark.parametrize("seed", [0, pytest.param(1, marks=pytest.mark.slow)])
def test_a_node_in_contact_may_be_pulled_as_far_as_energy_allows(seed):
    """However steep the links beside it are: of all nodes within the contact, one after another."""
    rng = np.random.default_rng(seed)
    length = steep(Parabola(0.02), 0.1).elastocapillary_length
    x = np.arange(-6, 7) * length / 3
    f = (0.14 * (np.arange(13) % 2) + rng.uniform(0, 0.04, 13)) * length
    body = Profile(
        lambda at: np.interp(at, x, f),
        lambda at: np.zeros_like(at),
        extent=(float(x[0]), float(x[-1])),
    )
    scene = steep(body, 0.1)
    lattice = Lattice.of(scene, length / 3)
    opened = set()
    delta = scene.critical_separation
    for depth in np.linspace(f.max() + 3 * delta, f.min() - delta, 40).tolist():
        plain = Plain(Row.of(scene, lattice, depth), depth, lattice.w)
        first = plain.row.first
        state = plain.relaxed((-5 - first, 5 - first))
        held = np.flatnonzero(state.model.contact)[1:-1]
        gains = [-math.inf]
        for node in held[state.model.gradient(state.u)[held] < 0].tolist():
            contact = np.arange(state.u.size) != node
            whole = NodalEnergy(lattice, contact | True)
            less = NodalEnergy(lattice, contact)
            gains.append(whole.value(state.u) - less.value(less.relaxed(state.u)))
        failed = state.certificate.opening > 1e-9
        size = lattice.w * length
        if abs(max(gains)) > 1e-9 * size:
            assert failed == (max(gains) > 0)
        opened.add(failed)
    assert opened == {False, True}


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("body", BODIES)
def test_without_tension_every_spring_is_by_itself(geometry, body):
    """Attached where touched, or for the lowest energy where that pays."""
    scene = replace(adhesive(BODIES[body](1.0), gamma1=0.0), geometry=geometry)
    delta = scene.critical_separation
    spacing = {"punch": 1.25e-4}.get(body, 1.3e-4)
    for share in (1.5, 0.3, 0.0, -0.4, -0.99, -1.01):
        for branch in ("adhered", "global"):
            state = minimise(scene, share * delta, method="lattice", spacing=spacing, branch=branch)
            lowest = state.branch == "global"
            level = share * delta + (delta if lowest else 0.0)
            if share < 0 and not lowest:
                level = 0.0 if share >= -1 else -1.0  # what has touched holds
            if share < -1:
                level = -1.0
            x = Lattice.of(scene, spacing).x(np.arange(-1100, 1101))
            on = x[scene.indenter.height(x) <= level + 1e-12 * delta]
            on = on[on >= 0] if geometry == "axisymmetric" else on
            assert state.contacts.shape == (min(1, on.size), 2), (share, branch)
            if not on.size:
                assert state.label == "detached"
                continue
            assert state.nodes[0] == pytest.approx([on[0], on[-1]], rel=0, abs=1e-12)
            g = share * delta - scene.indenter.height(on)
            area = np.full(on.size, state.spacing)
            if geometry == "axisymmetric":
                area = 2 * math.pi * area * np.where(on > 0, on, area / 8)
            energy = area @ (scene.stiffness / 2 * g**2 - scene.work_of_adhesion)
            beside = scene.stiffness * (delta + abs(share * delta)) ** 2 + scene.work_of_adhesion
            assert abs(state.energy - energy) <= 2 * area[-1] * beside and state.certificate.ok
            force = minimise(scene, share * delta, branch=branch).force  # of a punch the very same
            assert body != "punch" or state.force == pytest.approx(force, rel=1e-11, abs=0)


def test_a_node_far_out_on_a_steep_flank_is_compared_with_too():
    """Its link is all but vertical, and has hardly a stiffness for Newton's method."""
    lattice = Lattice.of(steep(Parabola(0.02), 1.0), 1e-3)
    model = NodalEnergy(lattice, np.arange(80) < 2)
    u = model.relaxed(np.where(np.arange(80) == 1, -1e7, -1e-14))
    assert np.isfinite(model.value(u))
    assert u[1] == -1e7


NODES = 40
HELD = [(6, 12), (18, 24)]  # a gap of six links


def case(seed, ell=4.0):
    """Thresholds for random heights, each with the depth in sight of its contacts."""
    rng = np.random.default_rng(seed)
    return rules_of(lattice(ell, w=2e-3), 0.01 * rng.normal(size=NODES).cumsum() / 6)


def rules_of(lattice, f):
    """Thresholds of one work of adhesion."""
    return Thresholds(lattice, f, np.full(f.size - 1, lattice.w * lattice.spacing))


def energy(rules, contacts, depth):
    """U of these contacts at a depth, its terms' size, and u - g."""
    held = np.zeros(NODES, bool)
    for first, last in contacts:
        held[first : last + 1] = True
    model = NodalEnergy(rules.lattice, held)
    g = depth - rules.f
    u = model.relaxed(g)
    return model.value(u), sum(map(abs, model.balance(u).terms.values())), u - g


def equal(rules, one, other, depth):
    """`other` has the lower energy above the depth and the higher one below."""
    rise = []
    for at in (depth - 1e-4, depth, depth + 1e-4):
        (first, size, _), (second, _, _) = (energy(rules, c, at) for c in (one, other))
        rise.append((second - first) / size)
    assert abs(rise[1]) <= 1e-13
    assert rise[0] > 1e-8 and rise[2] < -1e-8


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("links", [6, 3, 2])
def test_a_line_passes_a_link_or_the_last_two(seed, links):
    rules = case(seed)
    first = 12 + links
    one = (6, 12)
    right = (first, 24)
    closed = [(6, 24)] if links == 2 else [(6, 13), right]
    equal(rules, [one, right], closed, rules.advance(12, 1, first))
    closed = [(6, 24)] if links == 2 else [one, (first - 1, 24)]
    equal(rules, [one, right], closed, rules.advance(first, -1, 12))
    equal(rules, [right], [(first, 25)], rules.advance(24, 1, None))
    equal(rules, [one], [(5, 12)], rules.advance(6, -1, None))


@pytest.mark.parametrize("seed", range(6))
def test_a_node_is_torn_out_of_a_contact(seed):
    rules = case(seed)
    depth, (_, left, right, _) = Walk(SimpleNamespace(thresholds=(rules, rules))).opened_inside(
        6, 24
    )
    parts = [(6, left), (right, 24)]
    node = left + 1
    equal(rules, parts, [(6, 24)], depth)
    for other in set(range(7, 24)) - {node}:  # all others hold or are pressed
        opened, _, clear = energy(rules, [(6, other - 1), (other + 1, 24)], depth)
        pressed = clear.min() < -1e-14
        assert pressed or opened >= energy(rules, [(6, 24)], depth)[0]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("left", "right"), [(12, 18), (None, 6), (24, None)])
def test_the_surface_touches_the_first_node_in_its_way(seed, left, right):
    rules = case(seed)
    contacts = [pair for pair in HELD if left in pair or right in pair]
    depth, node = rules.touches(left, right)
    free = slice(0 if left is None else left + 1, NODES if right is None else right)
    clear = energy(rules, contacts, depth)[2]
    assert abs(clear[node]) <= 1e-14
    assert clear[free].min() >= -1e-14
    assert rules.pulled(left, node, right) == pytest.approx(depth, rel=0, abs=1e-12)
    assert rules.pulled(left, node, right) < depth  # what has just touched stays
    held = tuple(sorted([*contacts, (node, node)]))
    before, after = ends_of(held)[2 * held.index((node, node)) :][:4:3]
    lets_go = Walk(SimpleNamespace(thresholds=(rules, rules))).pulled(before, node, after)
    assert lets_go.depth == rules.pulled(left, node, right)
    assert lets_go.ends == ()


@pytest.mark.parametrize("kind", ["load_small", "load_opening", "load_pattern"])
@pytest.mark.parametrize("seed", range(4))
def test_parts_that_have_not_changed_keep_their_next_change(kind, seed):
    """After every change the first one is that of all parts, found anew."""
    case = path_case(kind, seed)
    length = case.scene.elastocapillary_length
    deepest = resolve(case.scene, 0.0).touch + 2 * case.scale
    row = LatticeBranch.of(case.scene, min(case.feature, length) / 10, deepest).row
    walk = Walk(row)
    changes = 0
    front = Front(walk, ((row.touch, row.touch),), 1)
    for sign in (1, -1):
        front = Front(walk, front.contacts, sign)
        while front.contacts and front.first()[0].depth < deepest:
            front.apply(*front.first())
            anew = Front(walk, front.contacts, sign)
            assert front.first() == anew.first()
            changes += 1
    assert changes >= 10 and not front.contacts


def test_a_line_passes_a_link_as_a_node_beyond_it_touches():
    """Alone it would have to wait for that, past its jump, by up to 0.7 in the half-width."""
    ripples = rippled(1 / 0.312, 2 * math.pi / 6.45, 0.122, (-8.0, 8.0))
    scene = plain(ripples, w=0.34)
    fitted = minimise(scene, 0.774)
    off = []
    assert fitted.contacts == pytest.approx(np.array([[-2.014, 2.014]]), abs=1e-3)
    for links in (5.0, 6.6, 8.3, 9.2, 12.1, 20.0, 40.0):
        state = minimise(scene, 0.774, method="lattice", spacing=1 / links)
        off.append(abs(state.half_width - fitted.half_width))
        assert off[-1] <= state.error_estimate["half_width"] * state.half_width
    assert off[-1] <= 1e-4 and max(off) <= 1e-3


def test_both_lines_of_a_gap_pass_a_link_at_once():
    f = np.abs(np.arange(NODES) - 15.0) * -0.0023  # a re-entrant corner in the middle of the gap
    rules = rules_of(lattice(4.0, w=2e-3), f + 0.3)
    for left, right in ((13, 17), (12, 18), (11, 19)):
        depth = rules.advance_both(left, right)
        equal(rules, [(6, left), (right, 24)], [(6, left + 1), (right - 1, 24)], depth)
    assert rules.advance_both(13, 17) < min(rules.advance(13, 1, 17), rules.advance(17, -1, 13))
    depth = rules.advance_both(14, 17)
    equal(rules, [(6, 14), (17, 24)], [(6, 24)], depth)
    assert rules.advance_both(14, 16) == np.inf  # there one node closes the gap


def test_advance_against_two_relaxed_chains():
    """An advance changes energy and force as two relaxed chains say."""
    scene = adhesive(Parabola(0.02))
    lattice = Lattice.of(scene, scene.elastocapillary_length / 8)
    nodes = np.arange(-40, 41)
    f = scene.indenter.height(lattice.x(nodes))
    for last, depth in itertools.product((3, 9), (1e-3, -5e-3)):
        i = last + 40
        values = []
        forces = []
        for end in (last, last + 1):
            energy = NodalEnergy(lattice, (nodes >= -2) & (nodes <= end))
            u = energy.relaxed(depth - f)
            values.append(energy.value(u))
            forces.append(energy.gradient(u)[energy.contact].sum())
        _, rest, stiffness = lattice.free_node_response(last, 1)
        gap = f[i + 1] - f[i] - rest * (depth - f[i])
        work = scene.work_of_adhesion * lattice.spacing
        change = values[1] - values[0]
        size = scene.gamma1 * lattice.spacing
        energy = stiffness / 2 * gap**2 - work
        force = -stiffness * rest * gap
        assert energy == pytest.approx(change, rel=0, abs=1e-11 * size)
        expected = forces[1] - forces[0]
        assert force == pytest.approx(expected, rel=0, abs=1e-13 * scene.gamma1)


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_nodal_energy_derivatives(slopes):
    scene = replace(steep(Parabola(0.02)), slopes=slopes)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 5)
    rng = np.random.default_rng(3)
    size = 12
    u = rng.uniform(-0.5, 0.5, size) * scene.elastocapillary_length
    energy = NodalEnergy(lattice, np.arange(size) % 5 > 1)
    step = 1e-5 * np.abs(u).max()
    band = energy.hessian(u)
    hessian = np.diag(band[0]) + np.diag(band[1, :-1], -1) + np.diag(band[1, :-1], 1)
    for i, unit in enumerate(step * np.eye(size)):
        slope = (energy.value(u + unit) - energy.value(u - unit)) / (2 * step)
        assert slope == pytest.approx(energy.gradient(u)[i], rel=1e-6, abs=1e-8 * scene.gamma1)
        change = (energy.gradient(u + unit) - energy.gradient(u - unit)) / (2 * step)
        assert np.abs(change - hessian[i]).max() <= 1e-7 * hessian[i, i]
