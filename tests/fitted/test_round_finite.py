"""Rotational symmetry with finite slopes against the Young-Laplace equation, up to 80 degrees."""

import math

import numpy as np
import pytest
from truth import meniscus

from discretization import load_path, minimise
from discretization.equilibrium import QUANTITIES
from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Indenter,
    Parabola,
    PowerLaw,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

axi = cards.axisymmetric
MOST = math.radians(80)


def turned(indenter: Indenter, ell, stress, deficit) -> Scene:
    """Surfaces with this π - θ, in units of `ell` and `stress`."""
    surfaces = SurfaceEnergies.from_work(stress * ell, stress * ell * (1 - math.cos(deficit)))
    layer = ElasticLayer(stress / ell, 0.0, 1.0)
    return Scene(layer, surfaces, indenter, slopes="finite", geometry="axisymmetric")


SHAPES = {  # with the angle β of inclination at the radius a
    "cone": lambda a, beta: Wedge(beta),
    "parabola": lambda a, beta: Parabola(a / math.tan(beta)),
    "sphere": lambda a, beta: Circle(a / math.sin(beta)),
    "power": lambda a, beta: PowerLaw(math.tan(beta) / (3 * a**2), 3.0),
    "sum": lambda a, beta: Parabola(2 * a / math.tan(beta)) + Wedge(math.atan(math.tan(beta) / 2)),
}


def drawn(rng, shape):
    """A stable state: the scene, the radius of its line and what is known of it."""
    while True:
        ell, stress = 10 ** rng.uniform(-4, 4, 2)
        a, deficit = ell * 10 ** rng.uniform(-2.5, 1.5), math.radians(rng.uniform(3, 110))
        beta = deficit * rng.uniform(0.05, 1.4)
        if max(beta, abs(deficit - beta)) > MOST:
            continue
        scene = turned(SHAPES[shape](a, beta), ell, stress, deficit)
        try:
            before, near, state = (meniscus.state(scene, a * part) for part in (0.9, 0.95, 1.0))
        except ValueError:
            continue
        if before.depth < near.depth < state.depth:
            return scene, a, state


@pytest.mark.parametrize("shape", SHAPES)
def test_every_state_is_that_of_the_young_laplace_equation(shape):
    rng = np.random.default_rng(300 + list(SHAPES).index(shape))
    for _ in range(2):
        scene, a, exact = drawn(rng, shape)
        state = minimise(scene, exact.depth)
        scales = {"half_width": a, **state.scales}
        known = {"half_width": a, "force": exact.force, "energy": exact.energy}
        for name in QUANTITIES:
            error = abs(getattr(state, name) - known[name]) / scales[name]
            assert error <= 1e-9
            assert error <= 10 * state.error_estimate[name]
        assert abs(state.angle_deficit - scene.surfaces.angle_deficit) <= 1e-9


@pytest.mark.parametrize("degrees", [5.0, 40.0, 80.0])
@pytest.mark.parametrize("ratio", [3e-3, 0.2, 7.0, 300.0])
def test_a_pinned_line_of_a_punch(ratio, degrees):
    phi, a = math.radians(degrees), ratio * 3e-5
    scene = turned(FlatPunch(a), 3e-5, 2e3, min(phi * 1.1, 1.5))
    free, k, length = meniscus.outside(ratio, phi), scene.stiffness, 3e-5
    d = -free.height * length
    state = minimise(scene, d)
    force = math.pi * k * a**2 * d - 2 * math.pi * a * scene.gamma1 * math.sin(phi)
    energy = math.pi * a**2 * (k * d**2 / 2 - scene.work_of_adhesion)
    energy += 2 * math.pi * scene.gamma1 * length**2 * free.energy
    assert abs(state.force / force - 1) <= 1e-9
    assert abs(state.energy - energy) <= 1e-9 * state.scales["energy"]
    assert abs(state.angle_deficit - phi) <= 1e-8


@pytest.mark.parametrize("degrees", [20.0, 75.0])
def test_menisci_of_minimised_states_follow_both_laws(degrees):
    phi, length = math.radians(degrees), 3e-5
    layer = {"k": 2e3 / length, "gamma1": 2e3 * length}
    for ratio, law in ((1e-3, axi.finite.height_narrow), (1e3, axi.finite.height_wide)):
        a = ratio * length
        height = float(law(phi, a=a, **layer))
        state = minimise(turned(FlatPunch(a), length, 2e3, 1.1 * phi), -height)
        assert abs(state.angle_deficit / phi - 1) < 3e-5


@pytest.mark.parametrize("degrees", [30.0, 80.0])
def test_a_small_true_sphere_is_pulled_off_with_pi_R_w(degrees):
    """The pull is largest where the line stands at half the contact angle's deficit."""
    length, stress, R = 3e-5, 2e3, 3e-7
    scene = turned(Circle(R), length, stress, math.radians(degrees))
    known = float(axi.finite.adhesion_force_small_sphere(R=R, w=scene.work_of_adhesion))
    forces = []
    for part in (0.45, 0.5, 0.55):
        depth = meniscus.state(scene, R * math.sin(part * math.radians(degrees))).depth
        forces.append(minimise(scene, float(depth)).force)
    assert abs(-forces[1] / known - 1) < 1e-3
    assert forces[1] < min(forces[0], forces[2])


def test_gentle_slopes_are_small_slopes():
    errors = []
    for degrees in (3.0, 1.0, 0.3):
        bend = 1e-4 / math.radians(degrees)  # the same state, but for its heights
        scene = turned(Parabola(bend), 3e-5, 2e3, math.radians(degrees))
        small = Scene(scene.layer, scene.surfaces, scene.indenter, geometry="axisymmetric")
        pair = minimise(scene, 0.0), minimise(small, 0.0)
        errors.append(abs(pair[0].force / pair[1].force - 1))
    assert 1.8 < np.polyfit(np.log([3.0, 1.0, 0.3]), np.log(errors), 1)[0] < 2.2
    assert errors[-1] < 1e-4


def test_a_sphere_is_wetted_up_to_its_equator():
    """Where Young's angle meets a flat surface, d = R (1 - cos δ), the force is that of springs."""
    R, w = 0.05, 0.9
    scene = turned(Circle(R), 1.0, 1.0, math.acos(1 - w))
    flat = minimise(scene, R * w)
    assert flat.radius == pytest.approx(R * math.sqrt(1 - (1 - w) ** 2), rel=1e-13, abs=0)
    cap = math.pi * (R * w) ** 2 * (R - R * w / 3)  # ∫ (d - f) dA
    size = scene.stiffness * R**2 * flat.radius
    assert flat.force == pytest.approx(scene.stiffness * cap, rel=0, abs=1e-12 * size)
    depths = [0.0, R * w, 0.06, 0.065]
    for depth, off in zip(depths, (0.1, 6e-3, 4e-4, 6e-6), strict=True):
        state = minimise(scene, depth)
        assert 0 < 1 - state.radius / R < off
        assert max(state.error_estimate.values()) <= 1e-9
    path = load_path(scene, depths=[*depths, *depths[::-1], -0.1])
    assert [event.kind for event in path.events] == ["jump-in", "detachment"]
    assert path.half_width[1] == pytest.approx(flat.radius, rel=1e-13, abs=0)
    assert path.dissipated == pytest.approx(path.work(), rel=1e-9, abs=0)
    with pytest.raises(ValueError, match=r"spreads the contact to x = 0\.05, where the profile"):
        minimise(scene, 0.07)
