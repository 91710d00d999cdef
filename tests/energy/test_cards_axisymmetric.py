"""The closed forms with rotational symmetry against each other, quadrature and many digits."""

import itertools

import mpmath as mp
import numpy as np
import pytest
from card_cases import DT, T, decades, every, ratios
from hypothesis import given
from hypothesis import strategies as st
from scenes import check
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from energy import cards
from energy.cards.axisymmetric import _bessel

axi = cards.axisymmetric
EIGHTH_ORDER = [1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]
radii = st.floats(-4, 4).map(lambda e: 10.0**e)  # a/l


class Round:
    """A shape with its card, the same as c rⁿ, and a state on the branch that is followed."""

    def __init__(self, kind, ell, k, alpha, ratio, up):
        n = {"cone": 1.0, "sphere": 2.0}.get(kind) or float(kind)
        self.delta0 = alpha * ell
        c = alpha * ratio / (ell ** (n - 1.0)) if n > 1 else 0.9 * alpha * min(1.0, ratio)
        self.card = {"cone": axi.cone, "sphere": axi.sphere}.get(kind, axi.power_law)
        own = {"cone": {"delta": float(np.arctan(c))}, "sphere": {"R": 0.5 / c}}
        self.args = {"k": k, "gamma1": k * ell**2, "w": k * self.delta0**2 / 2}
        self.power = {"c": c, "n": n, **self.args}
        self.args = {**own.get(kind, {"c": c, "n": n}), **self.args}
        self.layer = {"k": k, "gamma1": k * ell**2}
        self.c, self.n, self.ell, self.k, self.w = c, n, ell, k, self.args["w"]
        self.least = axi.power_law.detachment(**self.power)
        self.a = float(self.least.half_width) * (1.0 + up)
        self.d = float(self("depth", self.a))

    def __call__(self, name, *values):
        return getattr(self.card, name)(*values, **self.args)

    def height(self, r):
        return self.c * np.abs(r) ** self.n

    def slope(self, r):
        return self.c * self.n * np.abs(r) ** (self.n - 1)

    def parts(self, d, a):
        """Springs, contact surface, free surface and adhesion of the energy, by quadrature."""
        r, dr = a * T**4, 4 * a * T**3 * DT
        springs = np.pi * self.k * ((d - self.height(r)) ** 2 * r * dr).sum()
        surface = np.pi * self.layer["gamma1"] * (self.slope(r) ** 2 * r * dr).sum()
        free = axi.surface.energy(d - self.height(a), a=a, **self.layer)
        return np.array([springs, surface, free, -np.pi * self.w * a**2])


shapes, named = (
    st.builds(Round, st.sampled_from(kinds), decades, decades, ratios, ratios, ratios)
    for kinds in (["cone", "sphere", "1.0", "1.5", "2.0", "3.7"], ["cone", "sphere"])
)


@pytest.mark.slow
def test_bessel_functions_keep_their_digits():
    for s in [*np.geomspace(1e-8, 1e8, 200).tolist(), 24.9999999, 25.0, 25.0000001]:
        with mp.workdps(60):
            q = mp.besselk(0, s) / mp.besselk(1, s)
            steeper = mp.mpf(s) ** 2 * (q**2 - 1) + s * q
            p = mp.besseli(1, s) / mp.besseli(0, s)
            exact = [float(v) for v in (q, steeper, p)]
        check(_bessel.decay(s), exact[0], 3e-15)
        check(_bessel.growth(s), exact[1], 1e-12)
        check(_bessel.disc(s), exact[2], 3e-15)
    ends = np.array([0.0, 1e-300, 1e300, np.inf])
    check(_bessel.growth(ends), np.array([0.0, 0.0, 0.5, 0.5]), 1e-15, 1e-300)
    check(_bessel.decay(ends)[[0, 2, 3]], np.array([0.0, 1.0, 1.0]), 1e-15)


@every
@given(decades, decades, radii, decades)
def test_free_surfaces_solve_their_equation_and_store_their_energy(k, ell, ratio, height):
    layer, a = {"k": k, "gamma1": k * ell**2}, ratio * ell
    h = 0.02 * min(a, ell)
    outer = {"a": a, "u_a": height, **layer}
    inner = {"b": a, "u_b": height, **layer}
    for at, u in (
        (1.3 * a, lambda r: axi.surface.displacement(r, **outer)),
        (0.9 * a, lambda r: axi.surface.disc_displacement(r, **inner)),
    ):
        near = np.asarray(u(at + h * np.arange(-4, 5)))
        bend = np.dot([-9, 128, -1008, 8064, -14350, 8064, -1008, 128, -9], near) / (5040 * h**2)
        slope = np.dot(EIGHTH_ORDER, near) / h
        rounded = 2e-7 * near[4] / h**2  # each of terms of 6.5 near/h², and of u
        scale = abs(slope) / min(at, ell) + rounded
        check(ell**2 * (bend + slope / at), near[4], 1e-8, ell**2 * scale)
        assert u(a) == height
    slope = axi.surface.slope_at_line(height, a=a, **layer)
    noise = (1e-3 + 4e-5 * ratio) * height / h
    numbers = axi.surface.displacement(a + 0.5 * h * np.arange(7), **outer)
    check(slope, np.dot([-147, 360, -450, 400, -225, 72, -10], numbers) / (30 * h), 1e-9, noise)
    pull, stored = axi.surface.force(height, a=a, **layer), axi.surface.energy(height, a=a, **layer)
    check(-2 * np.pi * a * layer["gamma1"] * slope, pull, 1e-13)
    check(stored, pull * height / 2, 1e-13)
    # the springs below the surface carry what it pulls with
    points = np.geomspace(a, a + 40 * ell, 12).tolist()
    carried = sum(
        quad(lambda r: r * axi.surface.displacement(r, **outer), *ends, epsrel=1e-11, limit=200)[0]
        for ends in itertools.pairwise(points)
    )
    check(2 * np.pi * k * carried, pull, 1e-9)
    r, dr = a * (1 - T**4), 4 * a * T**3 * DT
    disc = axi.surface.disc_displacement(r, **inner)
    if ratio < 100:
        check(
            2 * np.pi * k * (disc * r * dr).sum(),
            axi.surface.disc_force(height, b=a, **layer),
            1e-9,
        )
    twice = axi.surface.disc_force(height, b=a, **layer) * height
    check(2 * axi.surface.disc_energy(height, b=a, **layer), twice, 1e-14)


@every
@given(shapes)
def test_every_line_meets_its_conditions(case):
    a, f_a, slope_a = case.a, case.height(case.a), case.slope(case.a)
    scale = case.delta0 + f_a + case.ell * slope_a
    check(axi.contact_line.depth(f_a, slope_a, a, w=case.w, **case.layer), case.d, 1e-13, scale)
    check(axi.power_law.depth(a, **case.power), case.d, 1e-13, scale)
    kink = slope_a + axi.surface.slope_at_line(case.d - f_a, a=a, **case.layer)
    check(kink, case.delta0 / case.ell, 1e-11, scale / case.ell / _bessel.decay(a / case.ell))
    check(case.card.radius(case.d, **case.args), a, 1e-9)  # flat near the turn of d(a)
    check(case("depth", case("radius", case.d)), case.d, 1e-13, scale)


@every
@given(shapes)
def test_force_and_energy_are_those_of_the_stationary_functional(case):
    a, d, k, ell = case.a, case.d, case.k, case.ell
    terms, force = case.parts(d, a), case("force_of_radius", a)
    pressed = np.pi * k * a**2 * (abs(d) + case.delta0)
    scale = pressed + 2 * np.pi * k * a * ell * (case.delta0 + ell * case.slope(a))
    check(axi.power_law.energy_of_radius(a, **case.power), terms.sum(), 1e-12, abs(terms).sum())
    check(axi.power_law.force_of_radius(a, **case.power), force, 1e-13, scale)
    if case.n == int(case.n):
        check(axi.force.total(d, a, f=case.height, **case.layer), force, 1e-12, scale)
    h = 1e-3 * a
    moved = [case.parts(d, a + i * h).sum() for i in range(-4, 5)]
    check(np.dot(EIGHTH_ORDER, moved), 0.0, 1e-11, abs(terms).sum())
    energies = axi.power_law.energy_of_radius(a + h * np.arange(-4, 5), **case.power)
    depths = axi.power_law.depth(a + h * np.arange(-4, 5), **case.power)
    rise, fall = np.dot(EIGHTH_ORDER, energies), np.dot(EIGHTH_ORDER, depths)
    check(rise, force * fall, 1e-9, scale * abs(fall) + 1e-4 * abs(terms).sum())


@every
@given(named)
def test_named_shapes_against_power_laws(case):
    force = abs(case("force_of_radius", case.a)) + case.k * case.a**2 * case.delta0
    for name, scale in (("depth", case.delta0), ("force_of_radius", force)):
        check(getattr(axi.power_law, name)(case.a, **case.power), case(name, case.a), 1e-12, scale)
    for one, other in zip(case("pull_off"), axi.power_law.pull_off(**case.power), strict=True):
        check(one, other, 1e-11, case.delta0)
    for one, other in zip(case("detachment"), case.least, strict=True):
        check(one, other, 1e-9, case.delta0 * min(1.0, case.k * case.a**2))
    if case.n == 2:
        bare, a = {**case.power, "w": 0.0}, case.a
        same = {"R": case.args["R"], **case.layer}
        check(axi.sphere.depth_without_adhesion(a, **same), axi.power_law.depth(a, **bare), 1e-13)
        twin = axi.power_law.force_of_radius(a, **bare)
        check(axi.sphere.force_without_adhesion(a, **same), twin, 1e-13)


@pytest.mark.slow
@every
@given(shapes)
def test_pull_off_and_detachment_are_extremes(case):
    pulled, least = axi.power_law.pull_off(**case.power), case.least
    assert pulled.half_width > least.half_width > 0
    a = float(pulled.half_width) * np.geomspace(0.03, 30, 400)
    forces = axi.power_law.force_of_radius(a, **case.power)
    assert (forces >= pulled.force * (1 + 1e-12)).all()
    depths = axi.power_law.depth(
        float(least.half_width) * np.geomspace(0.03, 30, 400), **case.power
    )
    assert (depths >= least.depth - 1e-12 * case.delta0).all()
    assert least.energy_released > 0
    with pytest.raises(ValueError, match="has detached, pass d >= "):
        case("radius", float(least.depth) - 1e-6 * case.delta0)
    first = axi.power_law.jump_in(**case.power)
    assert first.energy_released > 0
    check(first.half_width, case("radius", 0.0), 1e-12)
    area = axi.power_law.loop_area(**case.power)
    check(area, first.energy_released + least.energy_released, 1e-15)


OF_SPHERE = {  # Λ: F_A/(2πRw) and d_c/δ₀, from 40-digit arithmetic elsewhere
    0.1: (0.928964975514, -0.794295),
    0.3: (0.794985771137, -0.592053),
    1.0: (0.554575152060, -0.277566),
    3.0: (0.502146734323, -0.0784981),
}


def sphere_at(ratio, k=1.1e7, w=4.3e-3, R=0.013):
    """Arguments of a sphere with this Λ."""
    ell = ratio * np.sqrt(R * np.sqrt(2 * w / k))
    return {"R": R, "k": k, "gamma1": k * ell**2, "w": w}


@pytest.mark.slow
@pytest.mark.parametrize("ratio", OF_SPHERE)
def test_pull_off_of_a_sphere(ratio):
    args, (pulled, depth) = sphere_at(ratio), OF_SPHERE[ratio]
    delta0 = cards.plane.critical_separation(args["k"], args["w"])
    bare = 2 * np.pi * args["R"] * args["w"]
    check(axi.sphere.adhesion_force(**args) / bare, pulled, 2e-12)
    check(axi.sphere.detachment(**args).depth / delta0, depth, 2e-6)
    with mp.workdps(40):  # the same without the derivatives that the card is solved with
        m = 1 / mp.mpf(ratio) ** 2

        def q(s):
            return mp.besselk(0, s) / mp.besselk(1, s)

        def force(s):
            return s**4 / (4 * m**2) - (s**2 * q(s) + 2 * s) * (1 - s / m) / m

        def lift(s):  # d/δ₀
            return s**2 / (2 * m) - (1 - s / m) * q(s)

        start = float(axi.sphere.pull_off(**args).half_width / np.sqrt(args["gamma1"] / args["k"]))
        least = mp.findroot(lambda s: mp.diff(force, s), start)
        turn = float(axi.sphere.detachment(**args).half_width / np.sqrt(args["gamma1"] / args["k"]))
        deepest = mp.findroot(lambda s: mp.diff(lift, s), turn)
        exact = float(-force(least)), float(lift(deepest))
    check(axi.sphere.adhesion_force(**args) / bare, exact[0], 1e-13)
    check(axi.sphere.detachment(**args).depth / delta0, exact[1], 1e-13)


@pytest.mark.parametrize(
    ("name", "ratios", "order"),
    [("stiff", [1e-2, 5e-3, 2.5e-3, 1.25e-3], 3), ("liquid", [5.0, 7.0, 10.0, 14.0, 20.0], -8)],
)
def test_expansions_of_the_pull_off_force_with_their_orders(name, ratios, order):
    """The remainder is Λ³ for Λ → 0, and Λ⁻⁸ ln² Λ for Λ → ∞."""
    args, ratios = sphere_at(np.array(ratios)), np.array(ratios)
    expansion = getattr(axi.sphere, f"adhesion_force_{name}")(**args)
    errors = abs(expansion / axi.sphere.adhesion_force(**args) - 1)
    slowly = np.log(4 * ratios**2) ** 2 if name == "liquid" else 1.0
    assert abs(np.polyfit(np.log(ratios), np.log(errors / slowly), 1)[0] - order) < 0.5
    assert errors.min() < 1e-8


def test_depth_of_detachment_of_a_nearly_tensionless_sphere():
    small = np.geomspace(1e-5, 1e-3, 5)
    args = sphere_at(small)
    delta0 = cards.plane.critical_separation(args["k"], args["w"])
    off = (axi.sphere.detachment_depth_stiff(**args) - axi.sphere.detachment(**args).depth) / delta0
    assert 1.2 < np.polyfit(np.log(small), np.log(abs(off)), 1)[0] < 1.4  # next order Λ^(4/3)
    assert abs(off[0]) < 1e-5


def test_a_sharp_cone_does_not_adhere_and_its_line_is_never_pinned():
    args = {"delta": 0.7, "k": 1.1e7, "gamma1": 0.031, "w": 4.3e-3}
    assert np.array_equal(axi.cone.pull_off(**args), [0, 0, 0])
    assert np.array_equal(axi.cone.detachment(**args), [0, 0, 0, 0])
    assert np.array_equal(axi.cone.jump_in(**args), [0, 0, 0, 0])
    d = np.array([1e-9, 1e-7, 1e-5, 1e-3])
    a = axi.cone.radius(d, **args)
    assert (np.diff(a) > 0).all() and (a > 0).all()
    check(axi.cone.depth(a, **args), d, 1e-12)
    assert (axi.cone.force(d, **args) > 0).all()
    assert axi.cone.radius(0.0, **args) == 0


def test_springs_alone():
    k, w, R = 1.1e7, 4.3e-3, 0.013
    delta0, args = np.sqrt(2 * w / k), {"R": R, "k": k, "gamma1": 0.0, "w": w}
    d = delta0 * np.array([-0.999, -0.5, 0.0, 2.0])
    a = np.sqrt(2 * R * (d + delta0))
    check(axi.sphere.radius(d, **args), a, 1e-12)
    force = np.pi * k * a**2 * (d - a**2 / (4 * R))
    check(axi.sphere.force(d, **args), force, 1e-11, np.pi * k * a**2 * delta0)
    check(axi.sphere.pull_off(**args).force, -2 * np.pi * R * w, 1e-13)
    check(axi.sphere.pull_off(**args).half_width, np.sqrt(2 * R * delta0), 1e-8)
    assert axi.sphere.detachment(**args).depth == -delta0
    assert axi.sphere.detachment(**args).energy_released == 0
    beyond = axi.sphere.displacement(2 * a, d=d, **args)
    assert (beyond == 0).all()
    errors = []
    for ratio in (1e-2, 1e-3, 1e-4):
        layer = {**args, "gamma1": k * (ratio * a[-1]) ** 2}
        errors.append(abs(axi.sphere.radius(d[-1], **layer) / a[-1] - 1))
    assert 0.9 < np.log10(errors[0] / errors[2]) / 2 < 1.1
    assert errors[2] < 2e-4


@every
@given(decades, decades, radii, ratios, st.floats(0.01, 4.0))
def test_flat_cylinder(k, ell, ratio, alpha, up):
    a, delta0 = ratio * ell, alpha * ell
    args = {"a": a, "k": k, "gamma1": k * ell**2, "w": k * delta0**2 / 2}
    layer, least = {"k": k, "gamma1": k * ell**2}, axi.flat_punch.detachment_depth(**args)
    d = float(least) * (1 - up)
    free = {"a": a, **layer}
    force = np.pi * k * a**2 * d + axi.surface.force(d, **free)
    check(axi.flat_punch.force(d, **args), force, 1e-13)
    terms = np.array([np.pi * k * (a * d) ** 2 / 2, -args["w"] * np.pi * a**2])
    energy = terms.sum() + axi.surface.energy(d, **free)
    check(axi.flat_punch.energy(d, **args), energy, 1e-13, abs(terms).sum())
    check(axi.surface.slope_at_line(least, **free), alpha, 1e-13)  # where the line comes free
    check(axi.contact_line.depth(0.0, 0.0, a, **layer, w=args["w"]), least, 1e-14)
    check(-axi.flat_punch.adhesion_force(**args), axi.flat_punch.force(least, **args), 1e-13)
    gone = axi.flat_punch.detachment(**args)
    check(gone.energy_released, axi.flat_punch.energy(least, **args), 1e-11, args["w"] * a**2 * 4)
    even = axi.flat_punch.global_pull_off_depth(**args)
    assert even > least
    check(axi.flat_punch.energy(even, **args), 0.0, 1e-13, args["w"] * np.pi * a**2)
    inside, outside = axi.flat_punch.displacement(np.array([0.7, -1.2]) * a, d=d, **args)
    assert inside == d
    check(outside, axi.surface.displacement(1.2 * a, u_a=d, **free), 1e-13, abs(d) * 1e-290)


@every
@given(decades, decades, radii, ratios, st.floats(-1, 1))
def test_inner_line_of_a_ring_makes_the_energy_stationary(k, ell, ratio, alpha, tilt):
    """A flat face tilted towards the axis, f = (r - b) m, with a free disc inside radius b."""
    b, w, gamma1 = ratio * ell, k * (alpha * ell) ** 2 / 2, k * ell**2
    slope = 0.9 * tilt * alpha
    d = float(axi.contact_line.inner_depth(0.0, slope, b, k=k, gamma1=gamma1, w=w))
    assert d < 0

    def energy(r):  # what changes when the line moves by r - b: contact is lost inside r
        t = b + (r - b) * T
        lost = k / 2 * (d - slope * (t - b)) ** 2 + gamma1 / 2 * slope**2 - w
        contact = -2 * np.pi * (lost * t * DT).sum() * (r - b)
        return contact + axi.surface.disc_energy(d - slope * (r - b), b=r, k=k, gamma1=gamma1)

    h = 1e-3 * min(b, ell)
    rise = np.dot(EIGHTH_ORDER, [energy(b + i * h) for i in range(-4, 5)]) / h
    check(rise, 0.0, 1e-8, 2 * np.pi * b * (w + k * d**2) + energy(b) / min(b, ell))


def test_a_small_true_sphere_in_a_liquid():
    R, gamma1 = 0.013, 0.031
    for w in (1e-3, 0.02, 0.06):
        deficit = cards.contact_line.angle_deficit(w, gamma1)
        found = minimize_scalar(
            lambda b, deficit=deficit: -2 * np.pi * R * gamma1 * np.sin(b) * np.sin(deficit - b),
            bounds=(0, deficit),
            method="bounded",
            options={"xatol": 1e-10},
        )
        check(axi.finite.adhesion_force_small_sphere(R=R, w=w), -found.fun, 1e-12)


def test_a_cone_without_tension_and_with_little():
    k, w, delta = 1.1e7, 4.3e-3, 0.2
    delta0, t = np.sqrt(2 * w / k), np.tan(delta)
    bare = 4 / 3 * np.pi * k * delta0**3 / t**2
    same = {"delta": delta, "k": k, "w": w}
    check(axi.cone.adhesion_force(gamma1=0.0, **same), bare, 1e-13)
    small = np.array([1e-2, 5e-3, 2.5e-3, 1.25e-3])
    tension = {"gamma1": k * (small * delta0 / t) ** 2, **same}
    off = axi.cone.adhesion_force_stiff(**tension) / axi.cone.adhesion_force(**tension) - 1
    assert 1.8 < np.polyfit(np.log(small), np.log(abs(off)), 1)[0] < 2.2
    assert abs(off[-1]) < 1e-5
