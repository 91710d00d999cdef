"""The layer against two truths of its own: nodes with the kernel itself, and finite elements."""

import math

import numpy as np
import pytest
from support import layer_elements
from support.bonded_layers import BODIES, GEOMETRIES, QUANTITIES, layer, off, random_scene, scene_of

from discretization import minimise
from energy import FlatPunch, Parabola, PowerLaw, Wedge

EVERY = [(kind, geometry) for geometry in GEOMETRIES for kind in BODIES]
SHAPES = {"line": layer_elements.Line(), "axisymmetric": layer_elements.Axis()}
NARROW = 0.4
WIDE = 3.0  # every ν, and every geometry, with both
PLACES = [
    (0.0, "line", WIDE), (0.0, "axisymmetric", NARROW), (0.3, "line", NARROW),
    (0.3, "axisymmetric", WIDE), (0.45, "line", WIDE), (0.45, "axisymmetric", NARROW),
]  # fmt: skip
PARTS = ("springs", "surface")


def on_nodes(scene, depth, a, links):
    return minimise(scene, depth, method="lattice", spacing=a / links)


@pytest.mark.parametrize(("kind", "geometry"), EVERY)
@pytest.mark.parametrize("seeds", [range(1), pytest.param(range(1, 5), marks=pytest.mark.slow)])
def test_nodes_and_poles_agree_within_the_estimate_of_the_nodes(kind, geometry, seeds):
    for seed in seeds:
        rng = np.random.default_rng([seed, *map(ord, kind + geometry)])
        scene, depth, _ = random_scene(rng, kind, geometry, widest=0.7)
        fitted = minimise(scene, depth, rtol=1e-6)
        if not fitted.half_width:
            continue
        nodes = on_nodes(scene, depth, fitted.half_width, 24.3 if kind != "punch" else 24)
        for q in QUANTITIES:
            known = nodes.uncertainty[q] + fitted.uncertainty[q]
            apart = abs(getattr(nodes, q) - getattr(fitted, q))
            assert apart <= known, (seed, q, scene, depth)  # infinite: not resolved


@pytest.mark.slow
def test_nodes_and_poles_agree_for_any_layer_width_and_tension():
    """ν in (-0.9, ½], l/h in 0.01…10, a/h in 0.1…100; nodes say what they do not resolve."""
    rng = np.random.default_rng(7)
    errors = []
    refused = 0
    for i in range(16):
        nu = float(rng.uniform(-0.9, 0.5)) if i % 4 else 0.5
        gamma = layer(min(nu, 0.49)).stiffness * 10 ** rng.uniform(-4, 2)
        wide = 10 ** rng.uniform(-1, 2)
        scene = scene_of(Parabola(wide / 0.1), nu, gamma, gamma * 0.005, GEOMETRIES[i % 2])
        fitted = minimise(scene, 0.05 * wide, rtol=1e-6)
        found = []
        try:
            for links in (16.3, 32.3, 64.3):
                nodes = on_nodes(scene, 0.05 * wide, fitted.half_width, links)
                found.append(off(nodes, fitted))
                for q in QUANTITIES:
                    known = nodes.uncertainty[q] + fitted.uncertainty[q]
                    assert abs(getattr(nodes, q) - getattr(fitted, q)) <= known, (i, links, q)
        except ValueError as error:
            if "use method='fitted'" not in str(error):
                raise
            refused += 1
            continue
        if math.isfinite(nodes.error_estimate["force"]):
            errors.append(found)
    assert refused <= 4
    assert len(errors) >= 9
    second, third = np.moveaxis(np.array(errors), 1, 0)[1:]
    assert (third <= 0.03).all()
    assert (np.median(third, axis=0) <= 2e-3).all()
    assert (np.abs(np.median(np.log2(second / third), axis=0) - 2) <= 0.2).all()


@pytest.mark.slow
@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_nodes_are_of_second_order(geometry, nu):
    """By the worst error of three offsets of the nodes from the line."""
    scene = scene_of(Parabola(40.0), nu, geometry=geometry)
    fitted = minimise(scene, 0.03, rtol=1e-7)

    def worst(n):
        nodes = (on_nodes(scene, 0.03, fitted.half_width, n + part) for part in (0.0, 0.3, 0.6))
        return np.max([off(each, fitted) for each in nodes], axis=0)

    errors = worst(15), worst(60)
    order = np.log(errors[0] / errors[1]) / math.log(4)
    assert (order >= 1.6).all()
    assert (errors[1] <= 4e-3).all()


@pytest.mark.parametrize("geometry", GEOMETRIES)
@pytest.mark.parametrize("nu", [0.3, 0.5])
def test_fields_and_angle_of_the_nodes(geometry, nu):
    scene = scene_of(Parabola(40.0), nu, geometry=geometry)
    fitted = minimise(scene, 0.03, rtol=1e-7)
    a = fitted.half_width
    errors = []
    x = a * np.array([0.0, 0.3, 0.7, 1.0, 1.2, 1.7, 3.0, 6.0])
    under = a * np.array([0.2, 0.5, 0.7])
    u = fitted.displacement(x)
    p = fitted.pressure(under)
    for links in (20.3, 40.3):
        nodes = on_nodes(scene, 0.03, a, links)
        errors.append(
            (
                np.abs(nodes.displacement(x) - u).max() / np.abs(u).max(),
                np.abs(nodes.pressure(under) - p).max() / np.abs(p).max(),
                abs(nodes.angle_deficit / fitted.angle_deficit - 1),
            )
        )
    assert (np.array(errors[1]) <= (1e-2, 3e-2, 0.03)).all()
    assert (np.array(errors[1]) <= np.array(errors[0]) * (0.45, 0.95, 0.75)).all()
    assert fitted.angle_deficit == pytest.approx(scene.surfaces.small_slope_deficit, rel=1e-9)


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_parts_of_energy_and_force_on_nodes(geometry):
    scene = scene_of(Parabola(40.0), 0.5, geometry=geometry)
    errors = []
    fitted = minimise(scene, 0.03, rtol=1e-7)
    parts = fitted.energy_parts | fitted.force_parts
    for links in (20, 40):
        nodes = on_nodes(scene, 0.03, fitted.half_width, links)
        own = nodes.energy_parts | nodes.force_parts
        assert sum(nodes.energy_parts.values()) == pytest.approx(nodes.energy, rel=1e-12)
        assert sum(nodes.force_parts.values()) == pytest.approx(nodes.force, rel=1e-12)
        errors.append([abs(own[name] / value - 1) for name, value in parts.items()])
    order = np.log2(np.array(errors[0]) / errors[1])
    assert (order[:3] >= 1.6).all()
    assert (order[3:] >= 0.9).all()  # forces by slopes beside the line


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_parts_of_energy_beside_a_body_that_ends(geometry):
    """The surface is free beyond the edge of a punch."""
    scene = scene_of(FlatPunch(1.2), 0.3, geometry=geometry)
    errors = []
    fitted = minimise(scene, 0.03, rtol=1e-7)
    assert fitted.pinned[0, 1]
    assert fitted.energy_parts["surface"] > 0
    for links in (20, 40):
        nodes = on_nodes(scene, 0.03, 1.2, links)
        errors.append(
            [abs(nodes.energy_parts[name] / fitted.energy_parts[name] - 1) for name in PARTS]
        )
    coarse, fine = np.array(errors)
    assert (fine <= 0.05).all()
    assert (fine <= 0.6 * coarse).all()


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_nodes_of_a_punch_that_is_pulled_off(geometry):
    scene = scene_of(FlatPunch(1.2), 0.3, geometry=geometry)
    held, lost = (on_nodes(scene, depth, 1.2, 24) for depth in (-0.01, -1.0))
    assert held.half_width == pytest.approx(1.2, rel=1e-12)
    assert held.pinned[0, 1]
    assert not lost.contacts.size
    assert not minimise(scene, -1.0).contacts.size


def truths(nu, geometry, heights, a, works, parts, gamma=0.7):
    return layer_elements.rests(SHAPES[geometry], nu, gamma, heights, a, works, parts)


@pytest.mark.parametrize("geometry", GEOMETRIES)
def test_a_layer_of_finite_elements(geometry):
    """Coarse; the depth at which a line rests at 1.5, the force and the energy there."""
    (((depth, force, energy),),) = truths(0.3, geometry, [lambda x: x * x / 80], 1.5, [0.01], 1)
    state = minimise(scene_of(Parabola(40.0), 0.3, geometry=geometry), depth, rtol=1e-6)
    assert state.half_width == pytest.approx(1.5, rel=1e-3)
    assert abs(state.force - force) <= 1e-3 * state.scales["force"]
    assert abs(state.energy - energy) <= 1e-3 * state.scales["energy"]


@pytest.mark.slow
@pytest.mark.parametrize(("nu", "geometry", "a"), PLACES)
def test_a_layer_of_finite_elements_by_its_extrapolated_error(nu, geometry, a):
    """So steep at the line, f' = 0.2, that it rests there in stable equilibrium."""
    radius = a / 0.2
    c = 0.2 / (3 * a * a)
    bodies = [
        (Parabola(radius), lambda x: x * x / (2 * radius)),
        (PowerLaw(c, 3), lambda x: c * x**3),
    ]
    works = [0.0, 0.001, 0.004]
    heights = [height for _, height in bodies]
    found = (truths(nu, geometry, heights, a, works, parts) for parts in (1, 2))
    for (body, _), coarse, fine in zip(bodies, *found, strict=True):
        for w, one, two in zip(works, coarse, fine, strict=True):
            state = minimise(scene_of(body, nu, w=w, geometry=geometry), two[0], rtol=1e-7)
            other = minimise(scene_of(body, nu, w=w, geometry=geometry), one[0], rtol=1e-7)
            scales = np.array([a, state.scales["force"], state.scales["energy"]])
            known = np.array([[s.half_width, s.force, s.energy] for s in (other, state)])
            found = np.array([[a, *one[1:]], [a, *two[1:]]])
            first, second = np.abs(known - found) / scales
            assert (second <= 1e-3).all()
            assert (second <= 0.3 * first + 2e-5).all()


@pytest.mark.parametrize("part", [0.0, 0.02, 0.3])
def test_nodes_pinned_at_a_tip(part):
    """A line contact of one point, pulled by nothing but itself, as the mesh has it."""
    scene = scene_of(Wedge(0.3), 0.3, 0.5, 1e-4)
    depth = part * scene.elastocapillary_length * 0.3
    mesh = minimise(scene, depth)
    nodes = minimise(scene, depth, method="lattice", spacing=0.05)
    assert mesh.half_width <= 1e-9
    assert nodes.half_width == 0
    rounding = 1e-9 * scene.gamma1
    assert nodes.force == pytest.approx(mesh.force, rel=1e-6, abs=rounding)
    length = scene.elastocapillary_length
    assert nodes.energy == pytest.approx(mesh.energy, rel=1e-6, abs=rounding * length)
    with pytest.raises(ValueError, match=r"spacing = 0\.05 leaves no node .* smaller spacing"):
        nodes.pressure(0.0)
