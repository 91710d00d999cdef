"""The closed forms with rotational symmetry against each other, quadrature and many digits."""

import itertools

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.optimize import minimize_scalar
from support.card_cases import DT, EIGHTH_ORDER, Round, T, decades, every, ratios
from support.comparison import check

from energy import cards
from energy.cards.axisymmetric import _bessel

axi = cards.axisymmetric
radii = st.floats(-4, 4).map(lambda e: 10.0**e)  # a/l


def integral(f, p, q):
    """Of what is smooth, from p to q."""
    return (q - p) * DT @ f(p + (q - p) * T)


def rounds(kinds):
    """Random shapes of these kinds."""
    return st.builds(Round, st.sampled_from(kinds), decades, decades, ratios, ratios, ratios)


shapes = rounds(["cone", "sphere", "1.0", "1.5", "2.0", "3.7"])
named = rounds(["cone", "sphere"])
SECOND = [-9, 128, -1008, 8064, -14350, 8064, -1008, 128, -9]  # over 5040 h²: second derivative
FORWARD = [-147, 360, -450, 400, -225, 72, -10]  # over 60 h: the first, from one side


@every
@given(decades, decades, radii, decades)
def test_free_surface_equation_and_energy(k, ell, ratio, height):
    """Free surfaces solve their equation and store their energy."""
    layer = {"k": k, "gamma1": k * ell**2}
    a = ratio * ell
    h = 0.02 * min(a, ell)
    outer = {"a": a, "u_a": height, **layer}
    inner = {"b": a, "u_b": height, **layer}

    def around(r):
        return axi.surface.displacement(r, **outer)

    def inside(r):
        return axi.surface.disc_displacement(r, **inner)

    for at, u in ((1.3 * a, around), (0.9 * a, inside)):
        near = np.asarray(u(at + h * np.arange(-4, 5)))
        bend = np.dot(SECOND, near) / (5040 * h**2)
        slope = np.dot(EIGHTH_ORDER, near) / h
        # 1e-8 of it is 6.5 · 9 · 2⁻⁵³: the weights of u, and what it is off by next to 40 digits
        rounded = 6.5e-7 * near[4] / h**2
        scale = abs(slope) / min(at, ell) + rounded
        check(ell**2 * (bend + slope / at), near[4], 1e-8, ell**2 * scale)
        assert u(a) == height
    slope = axi.surface.slope_at_line(height, a=a, **layer)
    noise = (1e-3 + 4e-5 * ratio) * height / h
    beyond = around(a + 0.5 * h * np.arange(7))
    check(slope, np.dot(FORWARD, beyond) / (30 * h), 1e-9, noise)
    pull = axi.surface.force(height, a=a, **layer)
    stored = axi.surface.energy(height, a=a, **layer)
    check(-2 * np.pi * a * layer["gamma1"] * slope, pull, 1e-13)
    check(stored, pull * height / 2, 1e-13)
    # the springs below the surface carry what it pulls with
    points = np.geomspace(a, a + 40 * ell, 12).tolist()
    pieces = itertools.pairwise(points)
    carried = sum(integral(lambda r: r * around(r), *ends) for ends in pieces)
    check(2 * np.pi * k * carried, pull, 1e-9)
    r = a * (1 - T**4)
    dr = 4 * a * T**3 * DT
    held = axi.surface.disc_force(height, b=a, **layer)
    if ratio < 100:
        check(2 * np.pi * k * (inside(r) * r * dr).sum(), held, 1e-9)
    check(2 * axi.surface.disc_energy(height, b=a, **layer), held * height, 1e-14)


@every
@given(shapes)
def test_every_line_meets_its_conditions(case):
    a = case.a
    f_a = case.height(a)
    slope_a = case.slope(a)
    scale = case.delta0 + f_a + case.ell * slope_a
    rests = axi.contact_line.depth(f_a, slope_a, a, w=case.w, **case.layer)
    check(rests, case.d, 1e-13, scale)
    check(axi.power_law.depth(a, **case.power), case.d, 1e-13, scale)
    kink = slope_a + axi.surface.slope_at_line(case.d - f_a, a=a, **case.layer)
    steepest = scale / case.ell / _bessel.decay(a / case.ell)
    check(kink, case.delta0 / case.ell, 1e-11, steepest)
    check(case.card.radius(case.d, **case.args), a, 1e-9)  # flat near the turn of d(a)
    check(case("depth", case("radius", case.d)), case.d, 1e-13, scale)


@every
@given(shapes)
def test_force_and_energy_are_those_of_the_stationary_functional(case):
    a = case.a
    d = case.d
    k = case.k
    ell = case.ell
    terms = case.parts(d, a)
    force = case("force_of_radius", a)
    pressed = np.pi * k * a**2 * (abs(d) + case.delta0)
    scale = pressed + 2 * np.pi * k * a * ell * (case.delta0 + ell * case.slope(a))
    check(axi.power_law.energy_of_radius(a, **case.power), terms.sum(), 1e-12, abs(terms).sum())
    check(axi.power_law.force_of_radius(a, **case.power), force, 1e-13, scale)
    if case.n == int(case.n):
        check(axi.force.total(d, a, f=case.height, **case.layer), force, 1e-12, scale)
    h = 1e-3 * a
    moved = [case.parts(d, a + i * h).sum() for i in range(-4, 5)]
    check(np.dot(EIGHTH_ORDER, moved), 0.0, 1e-11, abs(terms).sum())
    along = a + h * np.arange(-4, 5)
    energies = axi.power_law.energy_of_radius(along, **case.power)
    depths = axi.power_law.depth(along, **case.power)
    rise = np.dot(EIGHTH_ORDER, energies)
    fall = np.dot(EIGHTH_ORDER, depths)
    check(rise, force * fall, 1e-9, scale * abs(fall) + 1e-4 * abs(terms).sum())


@every
@given(named)
def test_named_shapes_against_power_laws(case):
    a = case.a
    law = axi.power_law
    check(law.depth(a, **case.power), case("depth", a), 1e-12, case.delta0)
    force = case("force_of_radius", a)
    scale = abs(force) + case.k * a**2 * case.delta0
    check(law.force_of_radius(a, **case.power), force, 1e-12, scale)
    for one, other in zip(case("pull_off"), law.pull_off(**case.power), strict=True):
        check(one, other, 1e-11, case.delta0)
    for one, other in zip(case("detachment"), case.least, strict=True):
        check(one, other, 1e-9, case.delta0 * min(1.0, case.k * a**2))
    if case.n == 2:
        bare = {**case.power, "w": 0.0}
        same = {"R": case.args["R"], **case.layer}
        depth = axi.sphere.depth_without_adhesion(a, **same)
        check(depth, law.depth(a, **bare), 1e-13)
        force = axi.sphere.force_without_adhesion(a, **same)
        check(force, law.force_of_radius(a, **bare), 1e-13)


@pytest.mark.slow
@settings(every, max_examples=20)
@given(shapes)
def test_pull_off_and_detachment_are_extremes(case):
    card = axi.power_law
    pulled = card.pull_off(**case.power)
    least = case.least
    assert pulled.half_width > least.half_width > 0
    near = np.geomspace(0.03, 30, 400)
    forces = card.force_of_radius(float(pulled.half_width) * near, **case.power)
    assert (forces >= pulled.force * (1 + 1e-12)).all()
    depths = card.depth(float(least.half_width) * near, **case.power)
    assert (depths >= least.depth - 1e-12 * case.delta0).all()
    with pytest.raises(ValueError, match="has detached, pass d >= "):
        case("radius", float(least.depth) - 1e-6 * case.delta0)
    first = card.jump_in(**case.power)
    area = card.loop_area(**case.power)
    assert first.energy_released > 0 < least.energy_released
    check(first.half_width, case("radius", 0.0), 1e-12)
    check(area, first.energy_released + least.energy_released, 1e-15)


def sphere_at(ratio, k=1.1e7, w=4.3e-3, R=0.013):
    """Arguments of a sphere with this Λ."""
    ell = ratio * np.sqrt(R * np.sqrt(2 * w / k))
    return {"R": R, "k": k, "gamma1": k * ell**2, "w": w}


@pytest.mark.slow
@pytest.mark.parametrize("ratio", [0.1, 3.0])
def test_pull_off_of_a_sphere(ratio):
    """In 25 digits, without the derivatives that the card is solved with."""
    args = sphere_at(ratio)
    delta0 = cards.plane.critical_separation(args["k"], args["w"])
    ell = np.sqrt(args["gamma1"] / args["k"])
    bare = 2 * np.pi * args["R"] * args["w"]
    pulled = axi.sphere.pull_off(**args)
    detached = axi.sphere.detachment(**args)
    with mp.workdps(25):
        m = 1 / mp.mpf(ratio) ** 2

        def q(s):
            return mp.besselk(0, s) / mp.besselk(1, s)

        def force(s):
            return s**4 / (4 * m**2) - (s**2 * q(s) + 2 * s) * (1 - s / m) / m

        def lift(s):  # d/δ₀
            return s**2 / (2 * m) - (1 - s / m) * q(s)

        least = mp.findroot(lambda s: mp.diff(force, s), float(pulled.half_width / ell))
        deepest = mp.findroot(lambda s: mp.diff(lift, s), float(detached.half_width / ell))
        exact = float(-force(least)), float(lift(deepest))
    check(axi.sphere.adhesion_force(**args) / bare, exact[0], 1e-13)
    check(detached.depth / delta0, exact[1], 1e-13)


def cone_at(ratio):
    """Arguments of a cone with l tan δ/δ₀ = ratio."""
    k = 1.1e7
    w = 4.3e-3
    delta = 0.2
    gamma1 = k * (ratio * np.sqrt(2 * w / k) / np.tan(delta)) ** 2
    return {"delta": delta, "k": k, "w": w, "gamma1": gamma1}


STIFF = np.array([1e-2, 5e-3, 2.5e-3, 1.25e-3])


@pytest.mark.parametrize(
    ("at", "card", "name", "ratios", "order", "band", "most"),
    [
        (sphere_at, "sphere", "adhesion_force_stiff", STIFF, 3, 0.5, 1e-8),
        (sphere_at, "sphere", "adhesion_force_liquid", 0.05 / STIFF, -8, 0.5, 1e-8),
        (sphere_at, "sphere", "detachment_depth_stiff", STIFF**2, 1.3, 0.1, 1e-5),
        (cone_at, "cone", "adhesion_force_stiff", STIFF, 2, 0.2, 1e-5),
    ],
)
def test_expansions_have_their_orders(at, card, name, ratios, order, band, most):
    """The next terms: Λ³ and Λ⁻⁸ ln² Λ, Λ^(4/3) of the depth, and of second order for a cone."""
    args = at(ratios)
    card = getattr(axi, card)
    exact = card.adhesion_force
    scale = card.adhesion_force(**args)
    if "depth" in name:
        exact = lambda **args: card.detachment(**args).depth  # noqa: E731
        scale = cards.plane.critical_separation(args["k"], args["w"])
    errors = abs(getattr(card, name)(**args) - exact(**args)) / scale
    slowly = np.log(4 * ratios**2) ** 2 if "liquid" in name else 1.0
    found = np.polyfit(np.log(ratios), np.log(errors / slowly), 1)[0]
    assert abs(found - order) < band
    assert errors.min() < most


def test_sharp_cone_is_never_pinned():
    """A sharp cone does not adhere and its line is never pinned."""
    args = {"delta": 0.7, "k": 1.1e7, "gamma1": 0.031, "w": 4.3e-3}
    for event in ("pull_off", "detachment", "jump_in"):
        assert not np.any(getattr(axi.cone, event)(**args))
    d = np.array([1e-9, 1e-7, 1e-5, 1e-3])
    a = axi.cone.radius(d, **args)
    assert (np.diff(a) > 0).all()
    assert (a > 0).all()
    check(axi.cone.depth(a, **args), d, 1e-12)
    assert (axi.cone.force(d, **args) > 0).all()
    assert axi.cone.radius(0.0, **args) == 0
    blunt = {"delta": 0.2, "k": 1.1e7, "gamma1": 0.0, "w": 4.3e-3}  # without tension
    delta0 = cards.plane.critical_separation(blunt["k"], blunt["w"])
    bare = 4 / 3 * np.pi * blunt["k"] * delta0**3 / np.tan(0.2) ** 2
    check(axi.cone.adhesion_force(**blunt), bare, 1e-13)


def test_springs_alone():
    k = 1.1e7
    w = 4.3e-3
    R = 0.013
    delta0 = np.sqrt(2 * w / k)
    args = {"R": R, "k": k, "gamma1": 0.0, "w": w}
    d = delta0 * np.array([-0.999, -0.5, 0.0, 2.0])
    a = np.sqrt(2 * R * (d + delta0))
    check(axi.sphere.radius(d, **args), a, 1e-12)
    force = np.pi * k * a**2 * (d - a**2 / (4 * R))
    pulled = axi.sphere.pull_off(**args)
    check(axi.sphere.force(d, **args), force, 1e-11, np.pi * k * a**2 * delta0)
    check(pulled.force, -2 * np.pi * R * w, 1e-13)
    check(pulled.half_width, np.sqrt(2 * R * delta0), 1e-8)
    gone = axi.sphere.detachment(**args)
    assert (gone.depth, gone.energy_released) == (-delta0, 0)
    assert (axi.sphere.displacement(2 * a, d=d, **args) == 0).all()
    tension = k * (np.array([1e-2, 1e-3, 1e-4]) * a[-1]) ** 2
    errors = abs(axi.sphere.radius(d[-1], **{**args, "gamma1": tension}) / a[-1] - 1)
    assert 0.9 < np.log10(errors[0] / errors[2]) / 2 < 1.1
    assert errors[2] < 2e-4


@every
@given(decades, decades, radii, ratios, st.floats(0.01, 4.0))
def test_flat_cylinder(k, ell, ratio, alpha, up):
    a = ratio * ell
    delta0 = alpha * ell
    punch = axi.flat_punch
    layer = {"k": k, "gamma1": k * ell**2}
    w = k * delta0**2 / 2
    args = {"a": a, **layer, "w": w}
    free = {"a": a, **layer}
    least = punch.detachment_depth(**args)
    even = punch.global_pull_off_depth(**args)
    d = float(least) * (1 - up)
    check(punch.force(d, **args), np.pi * k * a**2 * d + axi.surface.force(d, **free), 1e-13)
    terms = np.array([np.pi * k * (a * d) ** 2 / 2, -w * np.pi * a**2])
    energy = terms.sum() + axi.surface.energy(d, **free)
    check(punch.energy(d, **args), energy, 1e-13, abs(terms).sum())
    check(axi.surface.slope_at_line(least, **free), alpha, 1e-13)  # where the line comes free
    check(axi.contact_line.depth(0.0, 0.0, a, **layer, w=w), least, 1e-14)
    check(-punch.adhesion_force(**args), punch.force(least, **args), 1e-13)
    released = punch.detachment(**args).energy_released
    check(released, punch.energy(least, **args), 1e-11, w * a**2 * 4)
    assert even > least
    check(punch.energy(even, **args), 0.0, 1e-13, w * np.pi * a**2)
    inside, outside = punch.displacement(np.array([0.7, -1.2]) * a, d=d, **args)
    assert inside == d
    check(outside, axi.surface.displacement(1.2 * a, u_a=d, **free), 1e-13, abs(d) * 1e-290)


@every
@given(decades, decades, radii, ratios, st.floats(-1, 1))
def test_inner_line_of_a_ring_makes_the_energy_stationary(k, ell, ratio, alpha, tilt):
    """A flat face tilted towards the axis, f = (r - b) m, with a free disc inside radius b."""
    b = ratio * ell
    w = k * (alpha * ell) ** 2 / 2
    gamma1 = k * ell**2
    slope = 0.9 * tilt * alpha
    d = float(axi.contact_line.inner_depth(0.0, slope, b, k=k, gamma1=gamma1, w=w))
    assert d < 0

    def energy(r):
        """What changes when the line moves by r - b: contact is lost inside r."""
        t = b + (r - b) * T
        springs = k / 2 * (d - slope * (t - b)) ** 2
        density = springs + gamma1 / 2 * slope**2 - w
        contact = -2 * np.pi * (density * t * DT).sum() * (r - b)
        at_line = d - slope * (r - b)
        return contact + axi.surface.disc_energy(at_line, b=r, k=k, gamma1=gamma1)

    h = 1e-3 * min(b, ell)
    rise = np.dot(EIGHTH_ORDER, [energy(b + i * h) for i in range(-4, 5)]) / h
    check(rise, 0.0, 1e-8, 2 * np.pi * b * (w + k * d**2) + energy(b) / min(b, ell))


def test_a_small_true_sphere_in_a_liquid():
    R = 0.013
    gamma1 = 0.031

    def force(inclination, deficit):
        """Of a line where the sphere has this inclination."""
        return -2 * np.pi * R * gamma1 * np.sin(inclination) * np.sin(deficit - inclination)

    options = {"xatol": 1e-10}
    for w in (1e-3, 0.02, 0.06):
        deficit = cards.contact_line.angle_deficit(w, gamma1)
        bounds = (0, deficit)
        found = minimize_scalar(
            force, bounds=bounds, args=(deficit,), method="bounded", options=options
        )
        check(axi.finite.adhesion_force_small_sphere(R=R, w=w), -found.fun, 1e-12)
