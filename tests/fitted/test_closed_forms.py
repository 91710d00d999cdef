"""The fitted mesh against closed forms: random states of each kind, and paths about an axis."""

from __future__ import annotations

import functools
import math
from collections.abc import Callable
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from support.comparison import check
from support.example_scenes import turned as about_axis
from truth.meniscus import quadrature

from discretization import load_path, minimise
from energy import (
    Circle,
    ElasticLayer,
    FlatPunch,
    Indenter,
    Parabola,
    Patches,
    PowerLaw,
    Profile,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)
from studies.shared.random_cases import SHAPES, Case, random_case, random_steep_case


def _sampled(a: float, rise: float, n: float) -> Indenter:
    r = np.linspace(0, 2.5 * a, 40)
    return Sampled(r, rise * a * ((r / a) ** 2 / 2 + n / 40 * (r / a) ** 4), kind="smooth")


def _cosh(a: float, rise: float, n: float) -> Indenter:
    steep = rise / math.sinh(1)
    return Profile(
        lambda x: a * steep * (np.cosh(np.asarray(x) / a) - 1),
        lambda x: steep * np.sinh(np.asarray(x) / a),
        extent=(0.0, 4 * a),
        convex=True,
    )


DRAWN: dict[str, Callable[[float, float, float], Indenter]] = {
    "flat": lambda a, rise, n: FlatPunch(a),
    "cone": lambda a, rise, n: Wedge(math.atan(rise)),
    "parabola": lambda a, rise, n: Parabola(a / rise),
    "power": lambda a, rise, n: PowerLaw(rise / (n * a ** (n - 1)), n),
    "circle": lambda a, rise, n: Circle(a * math.hypot(1, 1 / rise)),
    "sampled": _sampled,
    "function": _cosh,
    "sum": lambda a, rise, n: Parabola(2 * a / rise) + Wedge(math.atan(rise / 2)),
}


def random_round_case(rng: np.random.Generator, shape: str) -> Case:
    """A state of the adhered branch with a/l in 10⁻³..10³ and δ₀/l in 0.01..1 in random units."""
    length, stress = 10.0 ** rng.uniform(-4, 4, 2)
    nu = rng.uniform(-0.5, 0.45)
    thickness = length * rng.uniform(0.1, 10)
    k = stress / length
    layer = ElasticLayer(k / ElasticLayer(1.0, nu, thickness).stiffness, nu, thickness)
    while True:
        a = length * 10 ** rng.uniform(-3, 3)
        alpha = 10 ** rng.uniform(-2, 0)
        indenter = DRAWN[shape](a, alpha * 10 ** rng.uniform(-1, 1), rng.uniform(1.5, 5))
        surfaces = SurfaceEnergies.from_work(k * length**2, k * (alpha * length) ** 2 / 2)
        scene = Scene(layer, surfaces, indenter, geometry="axisymmetric")
        least = resting_depth(scene, a)
        if shape == "flat":
            least *= -rng.uniform(-0.99, 2)
            break
        if resting_depth(scene, 0.9 * a) < resting_depth(scene, 0.95 * a) < least:
            break
    return Case(scene, least, a, *totals(scene, least, a), shape)


def resting_depth(scene: Scene, a: float) -> float:
    """The depth at which a line rests at this radius."""
    f, slope = (float(v(a)) for v in (scene.indenter.height, scene.indenter.slope))
    layer = {"k": scene.stiffness, "gamma1": scene.gamma1, "w": scene.work_of_adhesion}
    return float(cards.axisymmetric.contact_line.depth(f, slope, a, **layer))


def totals(scene: Scene, d: float, a: float) -> tuple[float, float]:
    """Force and energy of a contact of radius a at a depth, small slopes."""
    k = scene.stiffness
    gamma1 = scene.gamma1
    f = scene.indenter
    r, dr = quadrature(f, a)
    displaced = d - f.height(r)
    slope = f.slope(r)
    edge = {"a": a, "k": k, "gamma1": gamma1}
    u_a = d - float(f.height(a))
    surface = cards.axisymmetric.surface
    force = 2 * math.pi * k * float(displaced @ (r * dr)) + surface.force(u_a, **edge)
    density = k * displaced**2 + gamma1 * slope**2 - 2 * scene.work_of_adhesion
    energy = math.pi * float(density @ (r * dr)) + surface.energy(u_a, **edge)
    return float(force), float(energy)


axi = cards.axisymmetric
K = 1.1e7
GAMMA1 = 0.031
W = 4.3e-3
LAYER = {"k": K, "gamma1": GAMMA1, "w": W}
ELL = np.sqrt(GAMMA1 / K)
DELTA0 = np.sqrt(2 * W / K)


turned = functools.partial(about_axis, k=K, gamma1=GAMMA1, w=W)

DRAWS = {  # how states are drawn, of which shapes, how many, the largest error, and of the angle
    "small": (random_case, SHAPES, 50, 1e-10, 1e-9),
    "finite": (random_steep_case, SHAPES[1:], 40, 1e-11, 1e-9),
    "axisymmetric": (random_round_case, tuple(DRAWN), 40, 1e-11, 1e-10),
}


@pytest.mark.parametrize(
    ("kind", "shape"), [(kind, shape) for kind, draw in DRAWS.items() for shape in draw[1]]
)
def test_ten_digits_over_eight_decades_and_an_honest_estimate(kind, shape):
    """The angle is Young's; the estimates are rarely less than the errors, and never by much."""
    draw, shapes, count, most, off = DRAWS[kind]
    rng = np.random.default_rng(100 + shapes.index(shape))
    found = 0
    understated = 0
    for _ in range(count):
        case = draw(rng, shape)
        state = minimise(case.scene, case.depth)
        if kind == "finite" and case.depth < 0 and state.label == "detached":
            continue  # a wedge lets go before its line reaches such a width
        errors = case.errors(state, case.half_width)
        for error, estimate in zip(errors, state.error_estimate.values(), strict=True):
            assert error <= min(most, 10 * estimate)
            understated += error > estimate
        if shape != "flat":
            young = case.scene.surfaces
            young = young.angle_deficit if kind == "finite" else young.small_slope_deficit
            assert abs(state.angle_deficit - young) <= off * max(young, 1e-3)
        found += 1
    assert found >= count / 2
    assert understated <= found / 30


CASES = {  # an indenter, its card and its parameters
    "sphere": (Parabola(0.013), axi.sphere, {"R": 0.013}),
    "cone": (Wedge(0.01), axi.cone, {"delta": 0.01}),
    "power": (PowerLaw(7e5, 3.0), axi.power_law, {"c": 7e5, "n": 3.0}),
}


@pytest.mark.parametrize("name", CASES)
def test_what_an_equilibrium_says_of_itself(name):
    indenter, card, own = CASES[name]
    args = {**own, **LAYER}
    for d in (-0.1 * DELTA0, 0.0, 3 * DELTA0):
        state = minimise(turned(indenter), d)
        a = float(card.radius(d, **args))
        check(state.radius, a, 1e-12)
        assert state.half_width == state.radius
        assert state.contacts.tolist() == [[0.0, state.radius]]
        check(state.contact_area, np.pi * a**2, 1e-12)
        r = np.array([-1.7, -0.5, 0.0, 0.9, 1.1, 3.0]) * a
        check(state.displacement(r), card.displacement(r, d=d, **args), 1e-10, DELTA0)
        assert (state.pressure(r)[[0, 4, 5]] == 0).all()
        check(state.pressure(r)[1:4], K * (d - indenter.height(r[1:4])), 1e-14)
        parts = state.force_parts
        energies = state.energy_parts
        check(sum(parts.values()), state.force, 1e-12, abs(sum(map(abs, parts.values()))))
        check(sum(energies.values()), state.energy, 1e-12, sum(map(abs, energies.values())))
        check(energies["adhesion"], -W * np.pi * a**2, 1e-11)
        u_a = d - float(indenter.height(a))
        check(parts["lines"], axi.surface.force(u_a, a=a, k=K, gamma1=GAMMA1), 1e-9)
        check(state.force, card.force(d, **args), 1e-11, state.scales["force"])


OF_SPHERE = {  # Λ: F_A/(2πRw)
    0.1: 0.928964975514,
    0.3: 0.794985771137,
    1.0: 0.554575152060,
    3.0: 0.502146734323,
}


@pytest.mark.parametrize("ratio", OF_SPHERE)
def test_a_sphere_is_pulled_off_where_theory_says(ratio):
    R = 0.013
    gamma1 = K * ratio**2 * 0.013 * DELTA0
    args = {"R": R, "k": K, "gamma1": gamma1, "w": W}
    scene = turned(Parabola(R), gamma1=gamma1)
    there = DELTA0 * np.linspace(-1.1, 1.0, 12)
    first = axi.sphere.jump_in(**args)
    last = axi.sphere.detachment(**args)
    loop = load_path(scene, depths=[*there, *there[::-1]])
    assert [event.kind for event in loop.events] == ["jump-in", "detachment"]
    for event, jump in zip(loop.events, (first, last), strict=True):
        check(event.depth, jump.depth, 1e-11)
        check(event.energy_released, jump.energy_released, 1e-11)
    check(loop.dissipated, first.energy_released + last.energy_released, 1e-11)
    pull = axi.sphere.pull_off(**args)
    pulled = load_path(scene, forces=pull.force * np.array([0.0, 0.5, 0.9, 1.1])).pull_off
    check(pulled.force / (-2 * np.pi * R * W), OF_SPHERE[ratio], 2e-12)
    check(pulled.force, pull.force, 1e-11)
    check(pulled.depth, pull.depth, 1e-9, DELTA0)


@pytest.mark.parametrize("alone", [True, False])
@pytest.mark.parametrize("name", CASES)
def test_a_contact_about_an_axis_is_lost_at_the_radius_of_theory(name, alone):
    """Also by the lines of several contacts, as over a pattern: the axis holds no line."""
    indenter, card, own = CASES[name]
    args = {**own, **LAYER}
    scene = turned(indenter)
    pattern = None if alone else Patches([50 * ELL], [1.0, 1.0])
    loop = load_path(replace(scene, pattern=pattern), depths=DELTA0 * np.array([-0.1, 2.0, -1.1]))
    assert [event.kind for event in loop.events] == ["jump-in", "detachment"]
    first, last = (getattr(card, what)(**args) for what in ("jump_in", "detachment"))
    for event, jump, state in zip(loop.events, (first, last), (0, 1), strict=True):
        there = (event.after, event.before)[state]
        check(event.depth, jump.depth, 1e-11, DELTA0)
        check(event.energy_released, jump.energy_released, 1e-10)
        check(there.half_width, jump.half_width, (1e-11, 1e-5)[state])  # D is flat where it is lost
        assert there.lines[0] == 0 and len(there.lines) == 2


@pytest.mark.parametrize(
    ("share", "alone"), [(0.05, True), (0.4, True), (0.95, True), (1.3, True), (0.4, False)]
)
def test_pinned_line_about_an_axis_is_lost_when_freed(share, alone):
    """Inside the radius of detachment with its own radius, beyond it as a line that moves."""
    args = {"R": 0.013, "k": K, "gamma1": GAMMA1}
    least = axi.sphere.detachment(**args, w=W)
    a = share * float(least.half_width)
    scene = turned(Parabola(0.013), w=0.0, opening=W)
    pattern = None if alone else Patches([50 * ELL], [1.0, 1.0])
    pressed = float(axi.sphere.depth_without_adhesion(a, **args))
    loop = load_path(replace(scene, pattern=pattern), depths=[pressed, -1.5 * DELTA0])
    last = loop.events[-1]
    held = float(axi.contact_line.depth(a * a / 0.026, a / 0.013, a, **LAYER))
    assert last.kind == "detachment"
    check(last.depth, held if share < 1 else least.depth, 1e-11, DELTA0)
    check(last.before.half_width, a if share < 1 else least.half_width, 1e-9 if share < 1 else 1e-5)
    check(loop.work(), loop.dissipated, 1e-9)


def test_a_cylinder_detaches_alike_under_depth_and_load():
    a = 0.7 * ELL
    depths = DELTA0 * np.array([-1.0, 0.2, -1.1])
    args = {"a": a, **LAYER}
    gone = axi.flat_punch.detachment(**args)
    loop = load_path(turned(FlatPunch(a)), depths=depths)
    check(loop.events[-1].depth, gone.depth, 1e-12)
    check(loop.events[-1].energy_released, gone.energy_released, 1e-11)
    load = load_path(turned(FlatPunch(a)), forces=gone.force * np.array([0.0, 0.99, 1.01]))
    check(load.pull_off.force, gone.force, 1e-12)
    check(load.pull_off.depth, gone.depth, 1e-12)


def test_lowest_state_of_a_sphere_has_negative_energy():
    """The lowest state of a sphere is the one of negative energy."""
    args = {"R": 0.013, **LAYER}
    least = float(axi.sphere.detachment(**args).depth)
    for d in np.linspace(0.999 * least, 0.3 * DELTA0, 12):
        state = minimise(turned(Parabola(0.013)), float(d), branch="global")
        assert bool(state.contacts.size) == (axi.sphere.energy(d, **args) < 0)


@pytest.mark.parametrize("indenter", [Parabola(0.013), PowerLaw(7e5, 3.0), Circle(1e-3)], ids=repr)
def test_without_adhesion_and_without_tension(indenter):
    for share in (1e-3, 0.1, 1.0, 30.0):
        a = min(share * ELL, 9e-4)
        f = float(indenter.height(a))
        slope = float(indenter.slope(a))
        bare = axi.contact_line.depth(f, slope, a, k=K, gamma1=GAMMA1, w=0.0)
        check(minimise(turned(indenter, w=0.0), float(bare)).radius, a, 1e-11)
        if f < 1e-4 * DELTA0:  # ill-conditioned without tension
            continue
        alone = minimise(turned(indenter, gamma1=0.0), f - DELTA0, branch="global")
        check(alone.radius, a, 1e-11 * max(1.0, DELTA0 / f))
        force = axi.force.elastic(f - DELTA0, a, f=indenter.height, k=K)
        check(alone.force, force, 1e-11 * max(1.0, DELTA0 / f))


@pytest.mark.slow
@pytest.mark.parametrize("R", [1e-4, 1.0])
def test_estimate_is_rounding_for_small_spheres(R):
    """The terms of D that cancel are small there; close to the least D it grows slowly."""
    mpmath.mp.dps = 40
    scene = turned(Circle(R), k=1.0, gamma1=1.0, w=0.3)
    R = mpmath.mpf(R)
    delta0 = mpmath.sqrt(0.6)

    def terms(a):
        f = R - mpmath.sqrt(R * R - a * a)
        f1 = a / mpmath.sqrt(R * R - a * a)
        q = mpmath.besselk(0, a) / mpmath.besselk(1, a)
        return f, f1 * q, -delta0 * q

    def rest(a):
        return sum(terms(a))

    falling = {"solver": "bisect", "verify": False, "maxsteps": 100}
    end = mpmath.findroot(lambda a: mpmath.diff(rest, a), (R * 1e-3, R * 0.9999), **falling)
    least = rest(end)
    for part in (0.5, 1e-3, 1e-6, 1e-9):
        depth = float(least + abs(least) * part)
        state = minimise(scene, depth)
        start = mpmath.asin(state.radius / R)
        a = R * mpmath.sin(mpmath.findroot(lambda t, d=depth: rest(R * mpmath.sin(t)) - d, start))
        felt = mpmath.fsum(map(abs, (depth, *terms(a)))) / mpmath.diff(rest, a) / a
        error = abs(state.radius / a - 1)
        estimate = state.error_estimate["half_width"]
        assert error <= estimate <= 20 * np.finfo(float).eps * (felt + 1)
