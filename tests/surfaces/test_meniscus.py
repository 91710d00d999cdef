"""The reference for rotational symmetry with finite slopes, before it is used; and its limits."""

import numpy as np
import pytest
from scenes import check
from scipy.integrate import solve_bvp
from scipy.optimize import minimize_scalar
from truth import meniscus

from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Parabola,
    PowerLaw,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

axi = cards.axisymmetric
STEEP = [0.3, np.radians(45), np.radians(80)]


@pytest.mark.parametrize("radius", [1e-4, 1e-2, 1.0, 30.0, 1e6])
def test_faint_surfaces_are_those_of_small_slopes(radius):
    layer, phi = {"a": radius, "k": 1.0, "gamma1": 1.0}, 1e-5
    found = meniscus.outside(radius, phi)
    check(axi.surface.slope_at_line(found.height, **layer), -phi, phi**2)
    check(2 * np.pi * found.energy, axi.surface.energy(found.height, **layer), phi**2)
    if radius < 100:
        inner = meniscus.disc(radius, phi)
        layer = {"b": radius, "k": 1.0, "gamma1": 1.0}
        pulled = axi.surface.disc_force(inner.height, **layer)
        check(pulled, 2 * np.pi * radius * phi, phi**2)
        check(2 * np.pi * inner.energy, axi.surface.disc_energy(inner.height, **layer), phi**2)


@pytest.mark.parametrize("phi", STEEP)
@pytest.mark.parametrize("radius", [1e-2, 1.0, 30.0])
def test_collocation_finds_the_same_surface(radius, phi):
    """solve_bvp in arc length, where nothing is singular, with the decay of K₀ at its far end."""
    found = meniscus.outside(radius, phi)
    reach = 12.0

    def rise(s, y):
        r, h, tilt = y
        return [np.cos(tilt), -np.sin(tilt), -h - np.sin(tilt) / r]

    def ends(near, far):
        q = np.array(axi.surface.slope_at_line(1.0, a=far[0], k=1.0, gamma1=1.0))
        return [near[0] - radius, near[2] - phi, np.sin(far[2]) + q * far[1]]

    s = np.concatenate([[0], np.geomspace(1e-3 * radius, reach, 300)])
    first = found.height * np.exp(-s)
    found_again = solve_bvp(
        rise, ends, s, [radius + s, first, phi * np.exp(-s)], tol=1e-10, max_nodes=100_000
    )
    assert found_again.success
    check(found_again.y[1, 0], found.height, 3e-9)


@pytest.mark.parametrize("phi", STEEP)
@pytest.mark.parametrize("radius", [1e-3, 1.0, 1e3])
def test_what_the_surface_carries_is_what_it_pulls_with(radius, phi):
    """d(energy) = force × d(height): 2πγ₁ a sin φ, the energy of the surface by its length."""
    steps = phi * (1 + 1e-3 * np.arange(-2, 3))
    found = [meniscus.outside(radius, step) for step in steps]
    rule = np.array([1, -8, 0, 8, -1]) / 12
    stored = rule @ [one.energy for one in found]
    check(stored, radius * np.sin(phi) * (rule @ [one.height for one in found]), 1e-8)


@pytest.mark.slow
@pytest.mark.parametrize("phi", STEEP)
def test_both_laws_of_the_meniscus_are_its_limits(phi):
    narrow, wide = np.array([0.1, 0.03, 0.01, 0.003, 0.001]), np.array([10.0, 30, 100, 300, 1e3])
    layer = {"k": 1.0, "gamma1": 1.0}
    off = [
        meniscus.outside(a, phi).height / axi.finite.height_narrow(phi, a=a, **layer) - 1
        for a in narrow
    ]
    slowly = np.log(1 / narrow)  # a² ln (1/a) to a constant factor
    order = np.polyfit(np.log(narrow), np.log(np.abs(off) / slowly), 1)[0]
    assert 1.7 < order < 2.4
    assert abs(off[-1]) < 1e-5
    off = [
        meniscus.outside(a, phi).height / axi.finite.height_wide(phi, a=a, **layer) - 1
        for a in wide
    ]
    assert -2.1 < np.polyfit(np.log(wide), np.log(np.abs(off)), 1)[0] < -1.9
    assert abs(off[-1]) < 1e-6


def scene_of(indenter, w=0.02):
    layer = ElasticLayer(2.5e3, 0.3, 5e-6)  # l = 10 µm
    surfaces = SurfaceEnergies.from_work(0.07, w)
    return Scene(layer, surfaces, indenter, slopes="finite", geometry="axisymmetric")


@pytest.mark.slow
@pytest.mark.parametrize(
    "indenter",
    [Circle(3e-5), Parabola(1e-5), Wedge(0.5), PowerLaw(6e8, 3.0), Circle(3e-7)],
    ids=repr,
)
def test_force_is_the_slope_of_the_energy(indenter):
    scene = scene_of(indenter)
    for a in (0.2, 0.4, 0.6):
        a *= 0.5 * getattr(indenter, "R", 1e-5)
        states = [meniscus.state(scene, a * (1 + 1e-3 * i)) for i in (-2, -1, 0, 1, 2)]
        rule = np.array([1, -8, 0, 8, -1]) / 12
        rise = rule @ [one.energy for one in states]
        work = states[2].force * (rule @ [one.depth for one in states])
        assert abs(rise - work) <= 1e-7 * max(abs(work), abs(states[2].energy) * 1e-3)


def test_small_slopes_are_the_limit_of_small_works_of_adhesion():
    errors = []
    for w in (1e-4, 1e-5, 1e-6):
        R = 2e-2
        scene, a = scene_of(Parabola(R), w), 1e-5
        found = meniscus.state(scene, a)
        args = {"R": R, "k": scene.stiffness, "gamma1": scene.gamma1, "w": w}
        errors.append(abs(found.force / axi.sphere.force_of_radius(a, **args) - 1))
    assert 0.9 < np.log10(errors[0] / errors[2]) / 2 < 1.1
    assert errors[2] < 1e-5


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.007, 0.07, 0.1])
def test_a_small_sphere_is_pulled_off_a_liquid(w):
    """F_A = πRw at R/l = 1e-2; at R/l = 1 the springs are felt."""
    pulls = []
    for ratio in (1e-2, 1.0):
        scene = scene_of(Circle(ratio * 1.0198e-5), w)
        R, deficit = scene.indenter.R, scene.surfaces.angle_deficit
        least = minimize_scalar(
            lambda b, scene=scene, R=R: meniscus.state(scene, R * np.sin(b)).force,
            bounds=(0.3 * deficit, min(0.7 * deficit, 1.5)),
            method="bounded",
            options={"xatol": 1e-4},
        )
        pulls.append(-least.fun / axi.finite.adhesion_force_small_sphere(R=R, w=w))
    assert abs(pulls[0] - 1) < 1e-3
    assert abs(pulls[1] - 1) > 0.02


def test_the_edge_of_a_punch_and_a_surface_that_is_no_graph():
    scene = scene_of(FlatPunch(1e-5), 0.02)
    found = meniscus.state(scene, 1e-5)  # where the line comes free of the edge
    assert found.depth < 0 and found.force < 0
    with pytest.raises(ValueError, match="overhang"):
        meniscus.state(scene_of(FlatPunch(1e-5), 0.08), 1e-5)
