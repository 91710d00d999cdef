"""What the energy and the force are made of, and which state is the lowest."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import DELTA0, SCENE, L, adhesive, plain, rough, two

from discretization import minimise
from energy import FlatPunch, Parabola, Plane, PowerLaw, Wedge, cards

STORED = ("springs", "surface", "adhesion")
ACTING = ("pressure", "lines")


def sums(state):
    """Parts less the whole, over the scales of energy and force."""
    energy = sum(state.energy_parts.values()) - state.energy
    force = sum(state.force_parts.values()) - state.force
    return abs(energy) / state.scales["energy"], abs(force) / state.scales["force"]


@pytest.mark.parametrize(("method", "error"), [({}, 1e-13), ({"spacing": L / 400}, 1e-5)])
def test_the_parts_of_a_flat_punch_are_those_of_the_closed_forms(method, error):
    scene, a, d = adhesive(FlatPunch(2 * L)), 2 * L, 0.7 * DELTA0
    state = minimise(scene, d, method="lattice" if method else "auto", **method)
    k, w = scene.stiffness, scene.work_of_adhesion
    tail = k * L * d * d / 2  # of both tails, half of it in springs
    stored = (k * d * d * a + tail, tail, -2 * a * w)
    for name, value in zip(STORED, stored, strict=True):
        assert state.energy_parts[name] == pytest.approx(value, rel=error, abs=0)
    acting = (2 * a * k * d, 2 * k * L * d)  # (9), (10)
    for name, value in zip(ACTING, acting, strict=True):
        assert state.force_parts[name] == pytest.approx(value, rel=error, abs=0)


def test_the_parts_of_a_parabola_are_those_of_the_closed_forms():
    scene, d, R = adhesive(Parabola(0.02)), 0.4 * DELTA0, 0.02
    state = minimise(scene, d)
    k, gamma1, w, a = scene.stiffness, scene.gamma1, scene.work_of_adhesion, state.half_width
    u = d - a * a / (2 * R)
    within = k * (d * d * a - d * a**3 / (3 * R) + a**5 / (20 * R * R))
    parts = {
        "springs": within + k * L * u * u / 2,
        "surface": gamma1 * a**3 / (3 * R * R) + k * L * u * u / 2,
        "adhesion": -2 * a * w,
    }
    for name, value in parts.items():
        assert state.energy_parts[name] == pytest.approx(value, rel=1e-12, abs=0)
    pressure = 2 * k * (d * a - a**3 / (6 * R))
    assert state.force_parts["pressure"] == pytest.approx(pressure, rel=1e-12, abs=0)
    assert state.force_parts["lines"] == pytest.approx(2 * gamma1 * u / L, rel=1e-12, abs=0)


def test_the_parts_of_finite_slopes_are_those_of_the_first_integral():
    """k u²/2 = γ₁(1 - cos φ): a tail stores 2γ₁l(1 - cos φ/2) in its surface; sin φ acts."""
    scene = adhesive(FlatPunch(2 * L), w=0.05, slopes="finite")
    state = minimise(scene, 0.9 * L)
    gamma1, phi = scene.gamma1, 2 * math.asin(0.45)
    surface = 4 * gamma1 * L * (1 - math.cos(phi / 2))
    assert state.energy_parts["surface"] == pytest.approx(surface, rel=1e-10, abs=0)
    assert state.energy_parts["adhesion"] == pytest.approx(-4 * L * 0.05, rel=1e-13, abs=0)
    assert state.force_parts["lines"] == pytest.approx(2 * gamma1 * math.sin(phi), rel=1e-10, abs=0)


def test_the_parts_without_tension_without_contact_and_without_end():
    springs = minimise(adhesive(Parabola(0.02), gamma1=0.0), DELTA0)
    assert springs.energy_parts["surface"] == springs.force_parts["lines"] == 0
    assert max(sums(springs)) <= 1e-14
    apart = minimise(adhesive(Parabola(0.02)), -2 * DELTA0)
    assert apart.energy_parts == dict.fromkeys(STORED, 0.0)
    assert apart.force_parts == dict.fromkeys(ACTING, 0.0)
    endless = minimise(adhesive(Plane()), -0.5 * DELTA0)
    assert endless.energy_parts == {"springs": math.inf, "surface": 0.0, "adhesion": -math.inf}
    assert endless.force_parts == {"pressure": -math.inf, "lines": 0.0}


@pytest.mark.parametrize("options", [{}, {"method": "lattice", "spacing": L / 4}])
@pytest.mark.parametrize("kind", [{}, {"slopes": "finite"}, {"geometry": "axisymmetric"}])
def test_a_surface_without_contact_has_no_angle_and_is_flat(kind, options):
    state = minimise(replace(adhesive(Parabola(0.02)), **kind), -2 * DELTA0, **options)
    assert state.contact_angles.shape == state.line_slopes[1].shape == (0, 2)
    assert math.isnan(state.contact_angle)
    assert not state.displacement(np.linspace(0, L, 5)).any()


def test_a_contact_of_a_point_is_carried_by_its_lines():
    pinned = minimise(adhesive(Wedge(0.5)), 0.5 * L * math.tan(0.5))
    assert pinned.half_width == 0
    assert pinned.force_parts["pressure"] == 0
    assert pinned.force_parts["lines"] == pytest.approx(pinned.force, rel=1e-12, abs=0)
    assert pinned.energy_parts["adhesion"] == 0


@pytest.mark.parametrize(("method", "spacing"), [("auto", None), ("lattice", L / 40)])
def test_global_is_never_above_adhered_for_rough_indenters(method, spacing):
    """To rounding on the fitted mesh, and as far as nodes know the energy."""
    options, several, lower = {"method": method, "spacing": spacing}, 0, 0
    for seed in range(24 if spacing else 8):
        scene = rough(seed)
        depth = np.random.default_rng(seed).uniform(-0.6, 1.5) * DELTA0
        lowest = minimise(scene, depth, branch="global", **options)
        assert lowest.label == ("global" if lowest.contacts.size else "detached")
        if spacing:
            assert lowest.method == "shortest_path" and lowest.proof.violation <= 1e-13
        several += len(lowest.contacts) > 1
        adhered = minimise(scene, depth, **options)
        size = adhered.scales["energy"]
        known = (adhered.uncertainty["energy"] if spacing else 0.0) + 1e-12 * size
        assert lowest.energy <= adhered.energy + known
        lower += lowest.energy < adhered.energy - max(known, 1e-6 * abs(adhered.energy))
    assert several >= 2 and lower >= 2


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
@pytest.mark.parametrize("half_width", [0.3 * L, 4 * L])
def test_maxwell_point_of_the_flat_punch(half_width, geometry):
    """Where the energies are equal the lowest state detaches; on the path the contact holds."""
    scene, line = replace(adhesive(FlatPunch(half_width)), geometry=geometry), geometry == "line"
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


@pytest.mark.parametrize("seed", range(5))
def test_without_adhesion_every_method_agrees(seed):
    scene = rough(seed, w=0.0, n=301)
    options = {"branch": "global", "spacing": L / 20}
    ours = minimise(scene, 1.2 * DELTA0, method="lattice", **options)
    assert ours.label == "global" and ours.method == "lattice"
    assert minimise(scene, 1.2 * DELTA0, method="lattice", spacing=L / 20).energy == ours.energy
    for method in ("oracle", "shortest_path"):
        theirs = minimise(scene, 1.2 * DELTA0, method=method, spacing=L / 20)
        assert theirs.method == method and theirs.label == "global"
        assert np.array_equal(theirs.nodes, ours.nodes)
        assert theirs.energy == pytest.approx(ours.energy, rel=1e-13, abs=0)
        assert theirs.force == pytest.approx(ours.force, rel=1e-13, abs=0)
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


FINITE = replace(SCENE, slopes="finite")


def test_auto_takes_the_lattice_where_a_spacing_is_given():
    state = minimise(adhesive(two(0.6 * L)), 0.0, branch="global", spacing=L / 40)
    assert state.method == "shortest_path" and state.proof.violation <= 1e-13


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
        scene = plain(body, w=10 ** rng.uniform(-3, 0))
        depth, spacing = scene.critical_separation * rng.uniform(-1, 0.2), rng.uniform(0.02, 0.1)
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


def test_finite_slopes_of_a_convex_body_have_a_lowest_state_on_the_lattice():
    labels = set()
    for depth in np.linspace(-1, 0.2, 7) * DELTA0:
        coarse = minimise(FINITE, depth, branch="global", method="lattice", spacing=L / 50)
        exact = minimise(FINITE, depth, branch="global")
        labels.add(coarse.label)
        assert coarse.label == exact.label
        apart = abs(coarse.energy - exact.energy) / (exact.scales["energy"] or 1.0)
        assert apart <= 4 * coarse.error_estimate["energy"]
    assert labels == {"global", "detached"}


def test_the_lowest_state_detaches_where_its_energy_vanishes():
    """To rounding, not where the lattice that shows the contacts says so."""
    scene, held, gone = adhesive(two(0.6 * L, lift=5e-4)), 0.0, -DELTA0
    while held - gone > 1e-12 * DELTA0:
        middle = (held + gone) / 2
        state = minimise(scene, middle, branch="global")
        held, gone = (middle, gone) if state.contacts.size else (held, middle)
    state = minimise(scene, held, branch="global")
    assert state.label == "global" and -0.9 * DELTA0 < held < 0
    assert abs(state.energy) <= 1e-10 * state.scales["energy"]
