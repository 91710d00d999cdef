"""The lowest energy of all states, any number of contacts, and the certificate of both."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import SHAPES, adhesive, random_case
from test_shortest_path import random_scene, roughness, unpruned

from discretization import Lattice, NodalEnergy, NotCertifiedError, minimise, on_lattice
from discretization.certificate import certify, measured
from discretization.lattice import fronts
from discretization.lattice.bounds import deepest_contact
from discretization.lattice.contact_set import ContactSet, judged, totals
from discretization.lattice.obstacle import obstacle
from discretization.lattice.oracle import Oracle
from discretization.lattice.shortest_path import global_minimum
from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    Plane,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

SCENE = adhesive(Parabola(0.02))
L, DELTA0 = SCENE.elastocapillary_length, SCENE.critical_separation
ALPHA = math.sqrt(2 * SCENE.work_of_adhesion / SCENE.gamma1)


def two(c, narrow=0.006, wide=0.01, lift=0.0):
    """Two parabolas with their lowest points at ±c, the left one wider and higher."""

    def height(x):
        return np.minimum((np.asarray(x) - c) ** 2 / narrow, (np.asarray(x) + c) ** 2 / wide + lift)

    def slope(x):
        x = np.asarray(x)
        right = (x - c) ** 2 / narrow < (x + c) ** 2 / wide + lift
        return np.where(right, 2 * (x - c) / narrow, 2 * (x + c) / wide)

    return Profile(height, slope, extent=(-4 * c, 4 * c))


def rough(seed, *, w=0.002, n=801, width=20.0, unit=1.0, stress=1.0, mirror=False):
    """A self-affine body `width` l wide, of random roughness; its ends are edges."""
    rng = np.random.default_rng(seed)
    shortest = n * 10 ** rng.uniform(-2, -1)
    z = roughness(n, n / 2, shortest, seed) * 10 ** rng.uniform(-0.5, 0.8) * DELTA0 * unit
    x = np.linspace(-width / 2, width / 2, n) * L * unit
    body = Sampled(x, z[::-1] if mirror else z, kind="smooth") + FlatPunch(0.499 * width * L * unit)
    layer = ElasticLayer(130.0 * 0.03 * stress, 0.0, 0.03 * unit)
    tension = stress * unit
    return Scene(layer, SurfaceEnergies.from_work(0.07 * tension, w * tension), body)


def nodal(state):
    """The contact set itself, with its lines on the nodes, and its nodes from end to end."""
    lattice = Lattice.of(state.scene, state.spacing)
    nodes = np.rint((state.nodes - lattice.origin) / lattice.spacing).astype(int)
    every = np.arange(nodes[0, 0] - 5, nodes[-1, 1] + 6)
    held = ((every >= nodes[:, :1]) & (every <= nodes[:, 1:])).any(axis=0)
    g = state.depth - fronts.heights(lattice, state.scene.indenter, every.astype(float))
    return lattice, nodes, held, np.where(held, g, -math.inf), replace(state, contacts=state.nodes)


@pytest.mark.parametrize("shape", SHAPES)
def test_global_is_never_above_adhered_for_convex_indenters(shape):
    labels = []
    for seed in range(12):
        rng = np.random.default_rng(seed)
        case = random_case(rng, shape)
        depth = rng.uniform(-1.1, 0.5) * case.scene.critical_separation
        for options in ({}, {"method": "lattice", "spacing": case.resolved / 50}):
            lowest = minimise(case.scene, depth, branch="global", **options)
            adhered = minimise(case.scene, depth, **options)
            rounding = 1e-13 * adhered.scales["energy"]
            assert lowest.energy <= min(adhered.energy, math.inf if depth > 0 else 0.0) + rounding
            assert lowest.certificate.ok and lowest.branch == "global"
            labels.append(lowest.label)
            if lowest.label == "global":
                assert np.allclose(lowest.contacts, adhered.contacts, rtol=1e-12, atol=0)
    assert set(labels) == {"global", "detached"}


def test_global_is_never_above_adhered_for_rough_indenters():
    compared, several, lower = 0, 0, 0
    for seed in range(24):
        scene = rough(seed)
        depth = np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
        options = {"method": "lattice", "spacing": L / 40}
        lowest = minimise(scene, depth, branch="global", **options)
        assert lowest.label == ("global" if lowest.contacts.size else "detached")
        assert lowest.method == "shortest_path"
        assert lowest.proof.violation <= 1e-13
        several += len(lowest.contacts) > 1
        try:
            adhered = minimise(scene, depth, **options)
        except NotCertifiedError:
            continue
        lattice, _, held, g, _ = nodal(adhered) if adhered.contacts.size else (None,) * 5
        raw = 0.0
        if lattice is not None:
            model = NodalEnergy(lattice, held)
            raw = model.value(model.relaxed(g))
        assert lowest.proof.attained <= raw + 1e-11 * lowest.scales["energy"]
        compared += 1
        lower += lowest.proof.attained < raw - 1e-6 * abs(raw)
    assert compared >= 10 and several >= 8 and lower >= 3


@pytest.mark.parametrize("half_width", [0.3 * L, 4 * L])
def test_maxwell_point_of_the_flat_punch(half_width):
    scene = adhesive(FlatPunch(half_width))
    material = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    card = cards.displacement_control.flat_punch_global_pull_off(a=half_width, **material)
    for options, width in (({}, 1e-12), ({"method": "lattice", "spacing": half_width / 200}, 1e-4)):
        above = minimise(scene, card.depth * (1 - width), branch="global", **options)
        below = minimise(scene, card.depth * (1 + width), branch="global", **options)
        assert (above.label, below.label) == ("global", "detached")
        assert above.force == pytest.approx(card.force, rel=2 * width, abs=0)
        assert minimise(scene, card.depth * 1.01, **options).label == "metastable"


def test_two_contacts_far_apart_are_two_single_ones():
    c, dx = 60 * L, L / 40
    scene = adhesive(two(c, lift=0.1 * DELTA0))
    both = on_lattice(scene, 0.1 * DELTA0, dx, branch="global")
    narrow, wide = (adhesive(Parabola(R).shifted(0.0)) for R in (0.003, 0.005))
    one = on_lattice(wide, 0.0, dx, branch="global", origin=0.0)
    other = on_lattice(narrow, 0.1 * DELTA0, dx, branch="global", origin=0.0)
    assert len(both.contacts) == 2
    assert both.force == pytest.approx(one.force + other.force, rel=1e-10, abs=0)
    assert both.energy == pytest.approx(one.energy + other.energy, rel=1e-10, abs=0)
    assert np.allclose(
        both.contacts - [[-c], [c]], [one.contacts[0], other.contacts[0]], rtol=1e-10
    )
    assert np.allclose(both.contact_angles, [one.contact_angles[0], other.contact_angles[0]])
    x = np.linspace(-3 * L, 3 * L, 50)
    assert np.allclose(both.displacement(x + c), other.displacement(x), rtol=1e-9, atol=0)
    assert np.allclose(both.pressure(x - c), one.pressure(x), rtol=1e-9, atol=0)


def test_mirrored_scene_gives_the_mirrored_state():
    several = 0
    for seed in range(12):
        for w in (0.0, 0.002):
            one, other = (
                minimise(
                    rough(seed, w=w, mirror=mirror),
                    0.8 * DELTA0,
                    method="lattice",
                    branch="global",
                    spacing=L / 40,
                )
                for mirror in (False, True)
            )
            assert np.allclose(one.contacts, -other.contacts[::-1, ::-1], rtol=0, atol=1e-10 * L)
            assert one.force == pytest.approx(other.force, abs=1e-10 * one.scales["force"])
            assert one.energy == pytest.approx(other.energy, abs=1e-10 * one.scales["energy"])
            several += len(one.contacts) > 1
    assert several >= 8


@pytest.mark.parametrize("seed", range(6))
def test_displacement_of_several_contacts_is_the_balanced_one(seed):
    state = minimise(
        rough(seed), 0.9 * DELTA0, method="shortest_path", branch="global", spacing=L / 40
    )
    lattice, nodes, held, g, raw = nodal(state)
    x = lattice.x(np.arange(nodes[0, 0] - 5, nodes[-1, 1] + 6))
    u, size = raw.displacement(x), np.abs(raw.displacement(x)).max()
    frozen = Oracle(lattice, held.size, "frozen").solve(g, held)
    assert np.abs(u - frozen.u).max() <= 1e-9 * size
    assert np.abs(u - NodalEnergy(lattice, held).relaxed(g)).max() <= 1e-12 * size
    balance = NodalEnergy(lattice, held).gradient(u)[~held]
    assert np.abs(balance).max() <= 1e-14 * (lattice.spring + 4 * lattice.link) * size
    # the lines between the nodes: the surface is continuous there and has the slopes reported
    for i, row in enumerate(state.contacts):
        for side, end in zip((-1, 1), row, strict=True):
            step = 1e-6 * L
            beside = state.displacement(end + side * step * np.arange(3))
            slope = (-3 * beside[0] + 4 * beside[1] - beside[2]) / (2 * step)
            own = state.line_slopes[1][i, (side + 1) // 2]
            assert slope == pytest.approx(own, rel=1e-6, abs=1e-8 * ALPHA)


def test_lines_between_two_contacts_are_recovered_to_second_order():
    """Unequal contacts 1.2 l apart; the worst over grid offsets against one eight times finer."""
    scene, depth = adhesive(two(0.6 * L, lift=5e-4)), 0.05 * DELTA0
    finest = on_lattice(scene, depth, L / 1280, branch="global")
    assert finest.contacts.shape == (2, 2)
    errors = []
    for n in (20, 40, 80, 160):
        states = [
            on_lattice(scene, depth, L / n, branch="global", origin=o * L / n)
            for o in (0.0, 0.21, 0.37, 0.5, 0.83)
        ]
        lines = max(np.abs(s.contacts - finest.contacts).max() for s in states) / L
        force = max(abs(s.force - finest.force) for s in states) / finest.scales["force"]
        energy = max(abs(s.energy - finest.energy) for s in states) / finest.scales["energy"]
        angle = max(np.abs(s.angle_deficits / ALPHA - 1).max() for s in states)
        errors.append((lines, force, energy, angle))
    orders = -np.polyfit(np.log([20, 40, 80, 160]), np.log(errors), 1)[0]
    assert (orders > 1.8).all() and (orders < 2.5).all()
    assert (np.array(errors[-1]) <= [8e-6, 4e-5, 2e-3, 3e-4]).all()


@pytest.mark.parametrize("seed", range(5))
def test_without_adhesion_every_method_agrees(seed):
    scene = rough(seed, w=0.0, n=301)
    options = {"branch": "global", "spacing": L / 20}
    ours = minimise(scene, 1.2 * DELTA0, method="lattice", **options)
    assert ours.label == "global" and ours.method == "lattice"
    assert minimise(scene, 1.2 * DELTA0, method="lattice", spacing=L / 20).energy == ours.energy
    for method in ("oracle", "shortest_path"):
        theirs = minimise(scene, 1.2 * DELTA0, method=method, **options)
        assert theirs.method == method and theirs.label == "global"
        assert np.array_equal(theirs.nodes, ours.nodes)
        assert theirs.energy == pytest.approx(ours.energy, rel=1e-12, abs=0)
        assert theirs.force == pytest.approx(ours.force, rel=1e-12, abs=0)
    assert minimise(scene, -0.1 * DELTA0, method="lattice", spacing=L / 20).label == "detached"


@pytest.mark.parametrize("depth", [-0.5, 0.0, 0.6])
def test_shortest_path_equals_the_mixed_integer_oracle(depth):
    pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    scene = adhesive(two(0.6 * L, lift=5e-4))
    options = {"branch": "global", "spacing": L / 12}
    ours = minimise(scene, depth * DELTA0, method="shortest_path", **options)
    theirs = minimise(scene, depth * DELTA0, method="oracle", **options)
    assert theirs.method == "oracle" and theirs.proof is None
    assert theirs.label == ours.label == ("detached" if depth < 0 else "global")
    assert np.array_equal(theirs.nodes, ours.nodes)
    assert theirs.energy == ours.energy


def merged(nodes):
    return np.array([[nodes[0, 0], nodes[-1, 1]]])


def split(nodes):
    first, last = nodes[0]
    return np.concatenate([[[first, first + 1], [first + 3, last]], nodes[1:]])


MOVES = {
    "left line out": (lambda n: n + np.array([[-1, 0], [0, 0]]), {"neighbours"}),
    "left line in": (lambda n: n + np.array([[1, 0], [0, 0]]), {"neighbours"}),
    "inner line out": (lambda n: n + np.array([[0, 1], [0, 0]]), {"neighbours"}),
    "inner line in": (lambda n: n + np.array([[0, 0], [1, 0]]), {"neighbours"}),
    "right line out": (lambda n: n + np.array([[0, 0], [0, 1]]), {"neighbours"}),
    "merged": (merged, {"opening"}),
    "split": (split, {"neighbours", "penetration"}),
    "one alone": (lambda n: n[1:], {"penetration"}),
}


@pytest.mark.parametrize("name", MOVES)
def test_the_certificate_rejects_other_contact_sets(name):
    # pressed in deep and close together: neither contact can go
    scene, depth = adhesive(two(0.35 * L, 0.0006, 0.001, 5e-4)), 1.5e-3
    state = on_lattice(scene, depth, L / 1000, branch="global")
    lattice, nodes, *_ = nodal(state)
    assert len(nodes) == 2
    where = fronts.region(lattice, scene.indenter, depth)
    move, failures = MOVES[name]
    moved = ContactSet.of(lattice, scene.indenter, depth, where, move(nodes))
    assert set(judged(moved, totals(moved)).failures) == failures


def random_lattice(seed):
    """Lattice, heights and |d| of a rough profile; l/Δx from 0.1 to 1e7."""
    rng = np.random.default_rng(seed)
    n, ell = int(10 ** rng.uniform(2, 2.7)), 10 ** rng.uniform(-1, 7)
    k, height = 10 ** rng.uniform(-3, 3, 2)
    w = k * (height * 10 ** rng.uniform(-1.5, 1.5)) ** 2 / 2 * (rng.random() > 0.2)
    f = roughness(n, n / 3, 10 ** rng.uniform(0.3, 1.5), seed)
    return Lattice(1.0, 0.0, k, k * ell**2, w), height * (rng.uniform(-1, 3) - f)


@pytest.mark.parametrize("scene", [random_scene, random_lattice])
def test_the_certificate_accepts_every_global_minimum(scene):
    judgements = 0
    for seed in range(100):
        lattice, g = scene(seed)
        ends = global_minimum(lattice, g, margin=False).contacts
        if len(ends):
            beyond = np.pad(g, 16, constant_values=-math.inf)
            contacts = ContactSet(lattice, 0, beyond, ends + 16, float(np.abs(g).max()))
            certificate = judged(contacts, totals(contacts))
            assert certificate.ok, (seed, certificate)
            judgements += 1
    assert judgements >= 50


def crowded(seed):
    """Lattice and heights of a profile with teeth, near which adhesion is strong."""
    rng = np.random.default_rng(seed + 10**6)
    n, ell = int(rng.integers(4, 40)), 10 ** rng.uniform(-0.5, 1.5)
    f = np.abs(rng.normal(size=n)) ** rng.choice([0.5, 1, 2])
    lift = 10 ** rng.uniform(-0.7, 0.7)
    g = rng.uniform(-0.5, 1) * max(1, lift) - f
    return Lattice(1.0, 0.0, 2.0, 2.0 * ell**2, lift**2), g


# 1772: a tooth that two advancing lines bring into contact; at the others a line would gain energy
# by pushing the surface through a tooth
@pytest.mark.parametrize("seed", [1772, 3277, 3576, 4495, 5523, *range(40)])
def test_crowded_contacts_are_the_least_of_all_spans(seed):
    lattice, g = crowded(seed)
    found = global_minimum(lattice, g, margin=False)
    rounding = 1e-12 * (found.proof.scale or 1.0)
    assert found.proof.attained == pytest.approx(unpruned(lattice, g), rel=0, abs=rounding)
    if len(found.contacts):
        beyond = np.pad(g, 16, constant_values=-math.inf)
        size = float(np.abs(g).max())
        contacts = ContactSet(lattice, 0, beyond, found.contacts + 16, size)
        assert judged(contacts, totals(contacts)).ok


def test_the_certificate_notices_force_and_balance():
    scene, depth = adhesive(two(0.6 * L, lift=5e-4)), 0.05 * DELTA0
    lattice, nodes, *_ = nodal(on_lattice(scene, depth, L / 100, branch="global"))
    where = fronts.region(lattice, scene.indenter, depth)
    contacts = ContactSet.of(lattice, scene.indenter, depth, where, nodes)
    sums = totals(contacts)
    assert judged(contacts, sums).ok
    assert judged(contacts, sums._replace(force=sums.force * (1 + 1e-7))).failures == ("force",)
    middle = int(contacts.ends[0, 1] + contacts.ends[1, 0]) // 2
    u = contacts.u.copy()
    u[middle] += 1e-7 * contacts.scale
    shifted = replace(contacts)
    shifted.__dict__["u"] = u
    assert "stationarity" in judged(shifted, sums).failures


def test_a_single_contact_is_judged_alike_by_both_certificates():
    for depth in (-0.3 * DELTA0, 0.0, DELTA0):
        lattice = Lattice.of(SCENE, L / 100)
        where = fronts.region(lattice, SCENE.indenter, depth)
        found = fronts.adhered(lattice, SCENE.indenter, depth, where)
        for change in (0, 3):
            nodes = found._replace(last=found.last + change)
            sums = measured(lattice, SCENE.indenter, depth, nodes)
            contacts = ContactSet.of(
                lattice, SCENE.indenter, depth, where, np.array([[nodes.first, nodes.last]])
            )
            ours = totals(contacts)
            for name in ("force", "force_by_reactions", "energy"):
                scale = sums.energy_scale if name == "energy" else sums.force_scale
                assert abs(getattr(ours, name) - getattr(sums, name)) <= 1e-12 * scale
            one = certify(lattice, SCENE.indenter, depth, where, nodes, sums)
            assert judged(contacts, ours).failures == one.failures


def test_no_global_result_depends_on_the_units():
    for seed in (3, 5):
        here = minimise(rough(seed), DELTA0, method="lattice", branch="global", spacing=L / 40)
        assert len(here.contacts) > 1
        for unit, stress in ((1e-6, 3e4), (1e3, 1e-7)):
            there = minimise(
                rough(seed, unit=unit, stress=stress),
                DELTA0 * unit,
                method="lattice",
                branch="global",
                spacing=L / 40 * unit,
            )
            assert np.allclose(there.contacts / unit, here.contacts, rtol=0, atol=1e-9 * L)
            force, energy = there.force / (stress * unit), there.energy / (stress * unit**2)
            assert force == pytest.approx(here.force, abs=1e-9 * here.scales["force"])
            assert energy == pytest.approx(here.energy, abs=1e-9 * here.scales["energy"])
            assert np.allclose(there.contact_angles, here.contact_angles, rtol=0, atol=1e-7)


def test_error_estimates_of_several_contacts_cover_the_error():
    scene, depth = adhesive(two(0.6 * L, lift=5e-4)), 0.05 * DELTA0
    options = {"method": "lattice", "branch": "global"}
    fine, exact = (minimise(scene, depth, spacing=L / n, **options) for n in (100, 1600))
    for name in ("half_width", "force", "energy"):
        scale = {"half_width": exact.half_width, **exact.scales}[name]
        error = abs(getattr(fine, name) - getattr(exact, name)) / scale
        assert error <= fine.error_estimate[name] <= 30 * error


def test_the_plane_is_endless_or_detached():
    scene = adhesive(Plane())
    assert minimise(scene, -0.9 * DELTA0, branch="global").label == "global"
    assert minimise(scene, -0.9 * DELTA0).label == "metastable"
    assert minimise(scene, -1.1 * DELTA0, branch="global").label == "detached"
    with pytest.raises(ValueError, match="end to the plane"):
        minimise(scene, 0.0, branch="global", method="shortest_path", spacing=L)


FINITE = Scene(SCENE.layer, SCENE.surfaces, SCENE.indenter, slopes="finite")
OPEN_ENDED = adhesive(Sampled(np.linspace(-L, L, 9), np.array([3, 1, 2, 0, 2, 0, 3, 1, 0]) * 1e-3))


@pytest.mark.parametrize(
    ("scene", "options", "says"),
    [
        (OPEN_ENDED, {}, "not known any more"),
        (replace(OPEN_ENDED, slopes="finite"), {}, "slopes='small'"),
        (OPEN_ENDED, {"method": "lattice", "spacing": L / 20}, "not known any more"),
        (FINITE, {"method": "shortest_path", "spacing": L / 20}, "slopes = 'finite'"),
        (SCENE, {"method": "shortest_path"}, "spacing = None"),
        (SCENE, {"method": "shortest_path", "spacing": L, "branch": "adhered"}, "'adhered'"),
        (SCENE, {"method": "oracle", "spacing": L / 400}, "too many for integers"),
        (adhesive(Parabola(1), gamma1=0), {"method": "oracle", "spacing": L}, "gamma1 = 0"),
        (SCENE, {"method": "fitted", "spacing": L}, "has no spacing"),
    ],
)
def test_refuses(scene, options, says):
    with pytest.raises(ValueError, match=says):
        minimise(scene, 0.0, **{"branch": "global", **options})


def test_several_contacts_without_adhesion_need_no_spacing():
    scene = adhesive(two(2 * L), w=0.0)
    state = minimise(scene, 0.5 * DELTA0)
    coarse = minimise(scene, 0.5 * DELTA0, method="lattice", spacing=L / 200)
    assert state.method == "fitted" and len(state.contacts) == len(coarse.contacts) == 2
    assert np.abs(state.contacts - coarse.contacts).max() <= 1e-3 * L


def test_auto_takes_the_lattice_where_a_spacing_is_given():
    state = minimise(adhesive(two(0.6 * L)), 0.0, branch="global", spacing=L / 40)
    assert state.method == "shortest_path" and math.isfinite(state.proof.margin)


def test_finite_slopes_of_convex_indenters_compare_two_states():
    for depth, label in ((0.0, "global"), (-0.6 * DELTA0, "detached")):
        assert minimise(FINITE, depth, branch="global").label == label
    assert minimise(FINITE, -0.6 * DELTA0).label == "metastable"


def test_one_node_relaxes():
    lattice = Lattice.of(SCENE, L / 3)
    assert NodalEnergy(lattice, [True]).relaxed([0.3]).tolist() == [0.3]
    assert NodalEnergy(lattice, [False]).relaxed([0.3]).tolist() == [0.0]


def test_finite_slopes_are_no_obstacle_problem():
    scene = Scene(SCENE.layer, SurfaceEnergies.from_work(0.07, 0.0), SCENE.indenter, "finite")
    with pytest.raises(ValueError, match="slopes = 'finite'"):
        obstacle(Lattice.of(scene, L / 10), [1e-3])


def test_the_searched_window_leaves_room_for_every_contact():
    """Heights of 1.4 δ₀ at the ends of the first window: clear of adhered, not of all contact."""
    lattice = Lattice.of(SCENE, L / 100)
    c = 1.4 * DELTA0 / (1024 * lattice.spacing) ** 2
    searched = Profile(lambda x: c * np.asarray(x) ** 2, lambda x: 2 * c * np.asarray(x))
    where = fronts.region(lattice, searched, 0.0)
    ends = fronts.heights(lattice, searched, np.array([where.first, where.last], float))
    assert ends.min() > deepest_contact(lattice)


CONVEX = (
    FlatPunch(0.8),
    Wedge(0.2),
    Parabola(5.0),
    PowerLaw(0.2, 5.0),
    Parabola(4.0).tilted(0.1),
    FlatPunch(1.0).tilted(-0.15),
)


@pytest.mark.parametrize("body", CONVEX, ids=repr)
def test_of_a_convex_body_one_contact_or_none_is_the_lowest(body):
    """What the lattice compares is what the search over all contact sets finds."""
    rng, labels = np.random.default_rng(3), set()
    for _ in range(12):
        surfaces = SurfaceEnergies.from_work(1.0, 10 ** rng.uniform(-3, 0))
        scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, body)
        depth, spacing = scene.critical_separation * rng.uniform(-1, 0.2), rng.uniform(0.02, 0.1)
        found, searched = (
            minimise(scene, depth, method=method, branch="global", spacing=spacing)
            for method in ("lattice", "shortest_path")
        )
        labels.add(found.label)
        assert found.label == searched.label
        size = searched.scales["energy"] or 1.0
        assert found.energy == pytest.approx(searched.energy, rel=0, abs=1e-11 * size)
        assert found.contacts == pytest.approx(searched.contacts, rel=0, abs=1e-9)
    assert labels == {"global", "detached"}


def test_finite_slopes_of_a_convex_body_have_a_lowest_state_on_the_lattice():
    labels = set()
    for depth in np.linspace(-1, 0.2, 7) * DELTA0:
        scene = replace(SCENE, slopes="finite")
        coarse = minimise(scene, depth, branch="global", method="lattice", spacing=L / 50)
        exact = minimise(scene, depth, branch="global")
        labels.add(coarse.label)
        assert coarse.label == exact.label
        apart = abs(coarse.energy - exact.energy) / (exact.scales["energy"] or 1.0)
        assert apart <= 4 * coarse.error_estimate["energy"]
    assert labels == {"global", "detached"}
