"""What the energy and the force are made of, and which state is the lowest."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq
from support.example_scenes import DELTA0, SCENE, L, adhesive, plain, rough, two

from discretization import minimise
from energy import FlatPunch, Parabola, Plane, PowerLaw, Wedge, cards


def of_punch(state):
    """Half of what its tails store is in springs; (9), (10)."""
    k = state.scene.stiffness
    a = 2 * L
    d = state.depth
    tail = k * L * d * d / 2
    return k * d * d * a + tail, tail, -2 * a * 0.002, 2 * a * k * d, 2 * k * L * d


def of_parabola(state):
    k = state.scene.stiffness
    a = state.half_width
    d = state.depth
    R = 0.02
    u = d - a * a / (2 * R)
    springs = k * (d * d * a - d * a**3 / (3 * R) + a**5 / (20 * R * R)) + k * L * u * u / 2
    surface = state.scene.gamma1 * a**3 / (3 * R * R) + k * L * u * u / 2
    return springs, surface, -2 * a * 0.002, 2 * k * (d * a - a**3 / (6 * R)), 2 * k * L * u


def of_springs(state):
    springs, _, adhesion, pressure, _ = of_parabola(state)
    return springs, 0, adhesion, pressure, 0


def of_steep_punch(state):
    """k u²/2 = γ₁(1 - cos φ): a tail stores 2γ₁l(1 - cos φ/2) in its surface; sin φ acts."""
    gamma1 = state.scene.gamma1
    phi = 2 * math.asin(0.45)
    surface = 4 * gamma1 * L * (1 - math.cos(phi / 2))
    return None, surface, -4 * L * 0.05, None, 2 * gamma1 * math.sin(phi)


PUNCH = FlatPunch(2 * L)
STEEP = {"w": 0.05, "slopes": "finite"}
NODES = {"method": "lattice", "spacing": L / 400}
PARTS = [  # scene, depth, options, springs, surface, adhesion, pressure and lines, their errors
    (adhesive(PUNCH), 0.7 * DELTA0, {}, of_punch, 1e-13),
    (adhesive(PUNCH), 0.7 * DELTA0, NODES, of_punch, 1e-5),
    (adhesive(Parabola(0.02)), 0.4 * DELTA0, {}, of_parabola, 1e-12),
    (adhesive(PUNCH, **STEEP), 0.9 * L, {}, of_steep_punch, 1e-10),
    (adhesive(Parabola(0.02), gamma1=0.0), DELTA0, {}, of_springs, 1e-12),
    (adhesive(Parabola(0.02)), -2 * DELTA0, {}, lambda s: (0, 0, 0, 0, 0), 0),
    (adhesive(Wedge(0.5)), L / 4, {}, lambda s: (None, None, 0, 0, s.force), 1e-12),  # a point
    (adhesive(Plane()), -DELTA0 / 2, {}, lambda s: (math.inf, 0, -math.inf, -math.inf, 0), 0),
]


@pytest.mark.parametrize(("scene", "depth", "options", "parts", "error"), PARTS)
def test_parts_of_energy_and_force_are_those_of_the_closed_forms(
    scene, depth, options, parts, error
):
    state = minimise(scene, depth, **options)
    found = {**state.energy_parts, **state.force_parts}
    assert list(found) == ["springs", "surface", "adhesion", "pressure", "lines"]
    for value, known in zip(found.values(), parts(state), strict=True):
        assert known is None or value == pytest.approx(known, rel=error, abs=0)


@pytest.mark.parametrize("options", [{}, {"method": "lattice", "spacing": L / 4}])
@pytest.mark.parametrize("kind", [{}, {"slopes": "finite"}, {"geometry": "axisymmetric"}])
def test_a_surface_without_contact_has_no_angle_and_is_flat(kind, options):
    state = minimise(replace(adhesive(Parabola(0.02)), **kind), -2 * DELTA0, **options)
    assert state.contact_angles.shape == state.line_slopes[1].shape == (0, 2)
    assert math.isnan(state.contact_angle)
    assert state.label == "detached"
    assert not state.displacement(np.linspace(0, L, 5)).any()


@pytest.mark.parametrize(
    ("method", "spacing", "count"), [("auto", None, 6), ("lattice", L / 40, 12)]
)
def test_global_is_never_above_adhered_for_rough_indenters(method, spacing, count):
    """To rounding on the fitted mesh, and as far as nodes know the energy."""
    options = {"method": method, "spacing": spacing}
    several = 0
    lower = 0
    for seed in range(count):
        scene = rough(seed)
        depth = np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
        lowest = minimise(scene, depth, branch="global", **options)
        assert lowest.label == ("global" if lowest.contacts.size else "detached")
        if spacing:
            assert lowest.method == "shortest_path"
            assert lowest.proof.violation <= 1e-13
        several += len(lowest.contacts) > 1
        adhered = minimise(scene, depth, **options)
        size = adhered.scales["energy"]
        known = (adhered.uncertainty["energy"] if spacing else 0.0) + 1e-12 * size
        assert lowest.energy <= adhered.energy + known
        lower += lowest.energy < adhered.energy - max(known, 1e-6 * abs(adhered.energy))
    assert several >= 2
    assert lower >= 2


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("half_width", [0.3 * L, 4 * L])
def test_maxwell_point_of_the_flat_punch(half_width, geometry):
    """Where the energies are equal the lowest state detaches; on the path the contact holds."""
    scene = replace(adhesive(FlatPunch(half_width)), geometry=geometry)
    line = geometry == "line"
    given = {"a": half_width, "k": scene.stiffness, "gamma1": scene.gamma1}
    given["w"] = scene.work_of_adhesion
    punch = cards.flat_punch if line else cards.axisymmetric.flat_punch
    depth = float(punch.global_pull_off_depth(**given))
    lattice = {"method": "lattice", "spacing": half_width / 200}
    for options, width in (({}, 1e-12 if line else 1e-9), (lattice, 1e-4)):
        above, below = (
            minimise(scene, depth * (1 + side * width), branch="global", **options)
            for side in (-1, 1)
        )
        assert (above.label, below.label) == ("global", "detached")
        assert above.force == pytest.approx(float(punch.force(depth, **given)), rel=2 * width)
        assert minimise(scene, depth * 1.01, **options).label == "metastable"


@pytest.mark.parametrize(
    ("scene", "depth", "spacing"),
    [(rough(seed, w=0.0, n=301), 1.2, L / 20) for seed in range(5)]
    + [(adhesive(two(0.6 * L, lift=5e-4)), depth, L / 12) for depth in (-0.5, 0.0, 0.6)],
)
def test_every_method_finds_the_same_lowest_state(scene, depth, spacing):
    """The mixed-integer oracle, too: without adhesion its programme has no integers."""
    if scene.work_of_adhesion:
        pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    options = {"branch": "global", "spacing": spacing}
    ours, auto, theirs, searched = (
        minimise(scene, depth * DELTA0, method=method, **options)
        for method in ("lattice", "auto", "oracle", "shortest_path")
    )
    assert ours.label == ("detached" if depth < 0 else "global")
    assert searched.proof.violation <= 1e-13
    assert theirs.proof is None
    assert (theirs.method, searched.method) == ("oracle", "shortest_path")
    assert auto.method == ours.method == ("shortest_path" if scene.work_of_adhesion else "lattice")
    for other in (auto, theirs, searched):
        assert other.label == ours.label
        assert np.array_equal(other.nodes, ours.nodes)
        assert other.energy == pytest.approx(ours.energy, rel=1e-13, abs=0)
        assert other.force == pytest.approx(ours.force, rel=1e-13, abs=0)
    if not scene.work_of_adhesion:
        adhered = minimise(scene, depth * DELTA0, method="lattice", spacing=spacing)
        assert adhered.energy == ours.energy


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
    rng = np.random.default_rng(3)
    labels = set()
    for _ in range(12):
        scene = plain(body, w=10 ** rng.uniform(-3, 0))
        depth = scene.critical_separation * rng.uniform(-1, 0.2)
        spacing = rng.uniform(0.02, 0.1)
        found, searched = (
            minimise(scene, depth, method=method, branch="global", spacing=spacing)
            for method in ("lattice", "shortest_path")
        )
        labels.add(found.label)
        assert found.label == searched.label
        size = searched.scales["energy"] or 1.0
        assert found.energy == pytest.approx(searched.energy, rel=0, abs=1e-13 * size)
        assert found.contacts == pytest.approx(searched.contacts, rel=0, abs=1e-13)
    assert labels == {"global", "detached"}


def test_lowest_state_finite_slopes_convex_body():
    """Finite slopes of a convex body have a lowest state on the lattice."""
    labels = set()
    finite = replace(SCENE, slopes="finite")
    for depth in np.linspace(-1, 0.2, 5) * DELTA0:
        coarse = minimise(finite, depth, branch="global", method="lattice", spacing=L / 50)
        exact = minimise(finite, depth, branch="global")
        labels.add(coarse.label)
        assert coarse.label == exact.label
        apart = abs(coarse.energy - exact.energy) / (exact.scales["energy"] or 1.0)
        assert apart <= 4 * coarse.error_estimate["energy"]
    assert labels == {"global", "detached"}


def test_the_lowest_state_detaches_where_its_energy_vanishes():
    """To rounding, not where the lattice that shows the contacts says so."""
    scene = adhesive(two(0.6 * L, lift=5e-4))
    even = brentq(lambda d: minimise(scene, d).energy, -0.9 * DELTA0, 0.0, xtol=1e-13 * DELTA0)
    held = even + 1e-12 * DELTA0
    gone = even - 1e-12 * DELTA0
    assert minimise(scene, gone, branch="global").label == "detached"
    state = minimise(scene, held, branch="global")
    assert state.label == "global"
    assert -0.9 * DELTA0 < held < 0
    assert abs(state.energy) <= 1e-10 * state.scales["energy"]
