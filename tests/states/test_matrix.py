"""States over geometry, slopes, profile and adhesion: every question of each of them.

Lattices are held against the fitted mesh; that is against closed forms (tests/fitted) and truth.
"""

import functools
import math
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from support.example_scenes import (
    ALPHA,
    DELTA0,
    L,
    adhesive,
    dimple,
    rescaled,
    rippled,
    steep,
    turned,
    two,
    wavy,
)

from discretization import NotCertifiedError, load_path, minimise
from energy import Circle, FlatPunch, Parabola, PowerLaw, Sampled, Wedge
from studies.shared.random_cases import SHAPES, random_case, random_steep_case

A = 1.7 * L  # a radius of contacts about an axis
X = np.linspace(-0.05, 0.06, 4001)
ASYMMETRIC = Sampled(X, 40 * np.abs(X) ** 3 + 0.5 * X**2, kind="smooth").tilted(0.003).shifted(1e-3)
BUMPS = rippled(0.9, 2 * L, 0.7 * DELTA0, (0, 12 * L))  # a sphere with rings
CASES = {  # scene, depth over δ₀
    "wedge": (adhesive(Wedge(0.05)), 0.3),
    "parabola": (adhesive(Parabola(0.02)), 0.7),
    "cubic": (adhesive(PowerLaw(40.0, 3.0)), 1.7),
    "punch": (adhesive(FlatPunch(3.3 * L)), -0.7),
    "no adhesion": (adhesive(Parabola(0.02), w=0.0), 0.3),
    "asymmetric": (adhesive(ASYMMETRIC), 0.2),
    "two": (adhesive(two(0.6 * L, lift=5e-4)), 0.3),
    "crests": (wavy(crests=4), 2.3),
    "crests without adhesion": (wavy(0.0, crests=4), 2.3),
    "steep crests": (replace(wavy(crests=3), slopes="finite"), 2.0),
    "steep crests without adhesion": (replace(wavy(0.0, crests=3), slopes="finite"), 2.0),
    "steep wedge": (steep(Wedge(0.3), 0.8), 0.3),
    "steep parabola": (steep(Parabola(0.02), 0.3), 0.5),
    "steep cubic": (steep(PowerLaw(4000.0, 3.0), 0.1), 1.5),
    "steep punch": (steep(FlatPunch(0.03), 0.8), -0.97),
    "tilted, steep": (steep(Parabola(0.02).tilted(0.1), 0.6), 0.2),
    "rippled, steep": (steep(rippled(0.02, 0.006, 4e-5), 0.3), 0.2),
    "sphere": (turned(Parabola(A / (0.9 * ALPHA))), 0.2),
    "cone": (turned(Wedge(math.atan(0.6 * ALPHA))), 0.3),
    "cubic about an axis": (turned(PowerLaw(0.3 * ALPHA / A**2, 3.0)), 0.3),
    "arc": (turned(Circle(A / (0.9 * ALPHA))), 0.3),
    "cylinder": (turned(FlatPunch(A)), -0.5),
    "sphere without adhesion": (turned(Parabola(A / (0.9 * ALPHA)), w=0.0), 0.5),
    "ring": (turned(dimple()), 0.1),
    "wide ring": (turned(dimple()), 1.2),
    "disc and rings": (turned(BUMPS), 0.5),
}
PINNED = ("punch", "steep punch", "cylinder")
LINKS = np.array([15, 40, 120])
FINER = {  # times as many, where contacts, gaps or waves are as narrow as so many links
    "crests without adhesion": 4,
    "rippled, steep": 1.5,
}


@functools.cache
def solved(name, **options):
    scene, depth = CASES[name]
    return minimise(scene, depth * DELTA0, **options)


RINGS = ("ring", "wide ring", "disc and rings")
# steep, and about an axis, nodes support one contact
ON_NODES = [name for name in CASES if not name.startswith("steep crests") and name not in RINGS]


def on_nodes(name, links, **options):
    return solved(name, method="lattice", spacing=L / links, **options)


class States:
    def __getitem__(self, name):
        return solved(name)


@pytest.fixture
def states():
    return States()


def field(state):
    """k∫u dx, or dA, over contacts, gaps and tails, by Gauss's rule of the displacement."""
    length = state.scene.elastocapillary_length
    x = state.contacts.ravel()
    round_ = state.scene.axisymmetric
    ends = [0.0 if round_ else x[0] - 40 * length, *x, x[-1] + 40 * length]
    cuts = np.unique(np.concatenate([np.linspace(*pair, 33) for pair in pairwise(ends)]))
    points, weights = np.polynomial.legendre.leggauss(20)
    half = np.diff(cuts)[:, None] / 2
    middle = (cuts[1:] + cuts[:-1])[:, None] / 2
    at = (middle + half * points).ravel()
    weights = (half * weights).ravel() * (2 * math.pi * at if round_ else 1.0)
    return state.scene.stiffness * float(weights @ state.displacement(at))


def apart(state):
    """Energy and force less their parts, and the force less that of the field, over the scales."""
    energy = sum(state.energy_parts.values()) - state.energy
    force = sum(state.force_parts.values()) - state.force
    size = state.scales["force"]
    off = abs(field(state) - state.force)
    return [abs(energy) / state.scales["energy"], abs(force) / size, off / size]


def errors(state, exact):
    """Of lines over l, angles, force and energy; each within what the state says of itself."""
    free = ~np.isnan(exact.contact_angles) & ~exact.pinned
    found = [np.abs(state.contacts - exact.contacts).max() / L]
    found.append(np.abs(state.contact_angles - exact.contact_angles)[free].max(initial=0.0))
    for name in ("force", "energy"):
        error = abs(getattr(state, name) - getattr(exact, name))
        assert error <= state.uncertainty[name] + exact.uncertainty[name]
        found.append(error / exact.scales[name])
    return found


LONG = ("rippled, steep", "steep wedge", "tilted, steep", "steep cubic")
LONG = dict.fromkeys(LONG, pytest.mark.slow)


@pytest.mark.parametrize(
    "name", [pytest.param(name, marks=LONG.get(name, ())) for name in ON_NODES]
)
def test_lattice_convergence_is_second_order(states, name):
    """Lattices converge in second order wherever the lines are between nodes."""
    links = LINKS * FINER.get(name, 1)
    worst = []
    for number in links:
        found = [on_nodes(name, number + part) for part in (0.02, 0.37, 0.68)]
        worst.append(np.max([errors(state, states[name]) for state in found], axis=0))
    own = [2, 3] if name in PINNED else [0, 1, 2, 3]
    orders = -np.polyfit(np.log(links), np.log(np.array(worst)[:, own]), 1)[0]
    assert orders == pytest.approx(np.full(len(own), 2.0), rel=0, abs=0.25)
    assert (worst[-1] <= [1e-4, 1e-3, 1.5e-3, 2e-3]).all()


@pytest.mark.parametrize("name", CASES)
def test_state_certificate_angle_and_parts(states, name):
    """A state is certified with Young's angle and its parts are the whole."""
    state = states[name]
    assert state.certificate.ok
    assert state.method == "fitted"
    assert max(state.error_estimate.values()) <= 1e-8
    kind = {"small": "small_slope_deficit", "finite": "angle_deficit"}[state.scene.slopes]
    young = getattr(state.scene.surfaces, kind)
    free = ~np.isnan(state.contact_angles) & ~state.pinned
    assert np.abs(state.angle_deficits[free] - young).max(initial=0.0) <= 1e-9
    assert free.any() == (name not in PINNED)
    assert max(apart(state)) <= 1e-9
    if name not in ON_NODES:
        return
    coarse, fine = (apart(on_nodes(name, links)) for links in (160, 320))
    assert (np.array(fine) <= np.maximum(np.array(coarse) / 2, 1e-5)).all()


TAKES = ("steep crests", "steep crests without adhesion")


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.slow] * (n in TAKES)) for n in CASES]
)
def test_the_force_is_the_derivative_of_the_energy(states, name):
    (scene, depth), step = CASES[name], 1e-3 * DELTA0
    energy = {n: minimise(scene, depth * DELTA0 + n * step).energy for n in (-2, -1, 1, 2)}
    change = 8 * (energy[1] - energy[-1]) - (energy[2] - energy[-2])
    size = states[name].scales["force"]
    assert change / (12 * step) == pytest.approx(states[name].force, rel=0, abs=1e-8 * size)


@pytest.mark.parametrize("name", ON_NODES)
def test_the_surface_on_nodes_is_that_of_the_mesh(states, name):
    x = np.linspace(0, 6 * L, 200)
    u = states[name].displacement(x)
    off = np.abs(on_nodes(name, 200).displacement(x) - u).max() / np.abs(u).max()
    assert off <= 1e-3


@pytest.mark.parametrize("name", [*TAKES, "disc and rings"])
def test_paths_of_steep_crests_and_rings_raise(name):
    scene, depth = CASES[name]
    with pytest.raises(NotCertifiedError, match="another contact begins"):
        load_path(scene, depths=[0.0, depth * DELTA0])


@pytest.mark.parametrize("name", [n for n in CASES if n not in (*TAKES, "disc and rings")])
def test_a_state_is_the_end_of_its_path(states, name):
    """On nodes the lines of a path are within a link of those of its contact set."""
    (scene, depth), state = CASES[name], states[name]
    depths = [max(depth, 0.0) * DELTA0, depth * DELTA0]
    path = load_path(scene, depths=depths)
    assert path.at(-1).lines == pytest.approx(state.contacts.ravel(), rel=0, abs=1e-11 * L)
    for one in ("force", "energy"):
        size = 1e-11 * state.scales[one]
        assert getattr(path, one)[-1] == pytest.approx(getattr(state, one), rel=0, abs=size)
    if scene.slopes == "finite" or name in RINGS:
        return  # nodes have no load paths of them
    state = on_nodes(name, 80)
    path = load_path(scene, depths=depths, method="lattice", spacing=L / 80)
    assert path.at(-1).lines == pytest.approx(state.nodes.ravel(), rel=0, abs=0.51 * L / 80)
    for one in ("force", "energy"):
        size = 5e-3 * state.scales[one]
        assert getattr(path, one)[-1] == pytest.approx(getattr(state, one), rel=0, abs=size)


UNITS = (1e-6, 3e4), (1e3, 1e-7)


@pytest.mark.parametrize(  # the crests take time: once is enough
    ("length", "stress", "name"),
    [(*unit, name) for name in CASES for unit in UNITS[: 1 if "crests" in name else 2]],
)
def test_no_state_depends_on_units(states, name, length, stress):
    """Nor on whether a profile is built in, on nodes and on the mesh."""
    scene = rescaled(CASES[name][0], length, stress)
    depth = CASES[name][1]
    nodes = {"method": "lattice", "spacing": length * L / 50}
    pairs = [(states[name], {})]
    if name in ON_NODES:
        pairs.append((on_nodes(name, 50), nodes))
    for here, options in pairs:
        there = minimise(scene, depth * DELTA0 * length, **options)
        assert there.label == here.label or scene.axisymmetric  # not known of functions
        assert np.abs(there.contacts / length - here.contacts).max() <= 1e-11 * L
        angles = there.contact_angles - here.contact_angles
        assert np.abs(angles[np.isfinite(angles)]).max(initial=0.0) <= 1e-10
        power = 1 + scene.axisymmetric
        for one, unit in (("force", length**power), ("energy", length ** (power + 1))):
            size = 1e-11 * here.scales[one]
            assert abs(getattr(there, one) / (stress * unit) - getattr(here, one)) <= size
        for one, other in zip(there.certificate[:-1], here.certificate[:-1], strict=True):
            assert abs(one - other) <= (3e-12 if scene.slopes == "finite" else 1e-13)


@pytest.mark.parametrize("name", [name for name in ON_NODES if CASES[name][0].slopes == "small"])
def test_the_lowest_state_has_no_more_energy_and_a_proof(states, name):
    scene = CASES[name][0]
    lowest = on_nodes(name, 80, branch="global")
    adhered = on_nodes(name, 80)
    mesh = solved(name, branch="global")
    size = adhered.scales["energy"]
    assert lowest.certificate.ok
    assert lowest.label in ("global", "detached")
    if lowest.proof:
        assert lowest.proof.violation <= 1e-12
    assert lowest.energy <= adhered.energy + adhered.uncertainty["energy"]
    assert mesh.energy <= states[name].energy + 1e-12 * size
    assert lowest.contacts.shape == mesh.contacts.shape
    assert lowest.energy == pytest.approx(mesh.energy, rel=0, abs=lowest.uncertainty["energy"])
    if not scene.surfaces.work_of_adhesion:
        assert states[name].label == "global"
        assert lowest.nodes.tolist() == adhered.nodes.tolist()


@pytest.mark.slow
@pytest.mark.parametrize("draw", [random_case, random_steep_case, "round"])
def test_random_states_nodes_against_mesh(draw):
    """Random states on nodes are those of the mesh within their estimates."""
    rng = np.random.default_rng(18)
    ratios = []
    for i in range(20 if draw is random_steep_case else 30):  # these take nodes more time
        case = (random_case if draw == "round" else draw)(rng, SHAPES[i % len(SHAPES)])
        scene = replace(case.scene, geometry="axisymmetric") if draw == "round" else case.scene
        exact = minimise(scene, case.depth)
        spacing = case.resolved / 10 ** rng.uniform(1.3, 2.2)
        state = minimise(scene, case.depth, method="lattice", spacing=spacing)
        if state.contacts.shape != exact.contacts.shape or not exact.half_width:
            continue  # next to detachment, or detached
        if abs(state.half_width / exact.half_width - 1) < 0.1:  # else another state of this depth
            for one, size in state.uncertainty.items():
                ratios.append(abs(getattr(state, one) - getattr(exact, one)) / (size or math.inf))
    assert len(ratios) > 45
    assert np.mean(np.array(ratios) <= 1) > 0.95
    assert max(ratios) < 3
