"""The closed forms against each other, against quadrature and against 50-digit arithmetic.

What is held fixed is imposed (material, geometry, depth); no expected number comes from a run.
"""

import itertools

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize_scalar
from support.card_cases import (
    DT,
    EIGHTH_ORDER,
    KINDS,
    SIGNS,
    Case,
    Exact,
    T,
    decades,
    every,
    ratios,
)
from support.comparison import check

from energy import cards


def case_of(kind, ell, alpha, k, ratio, lift):
    """A case by α = δ₀/l in place of δ₀."""
    return Case(kind, ell, ell * alpha, k, ratio, lift)


def cases_of(kinds):
    """Random cases of these kinds."""
    kind = st.sampled_from(kinds)
    return st.builds(case_of, kind, decades, ratios, decades, ratios, ratios)


shapes = cases_of(KINDS)
of_paper = cases_of(["wedge", "parabola"])


@every
@given(decades, decades, decades)
def test_tail_solves_its_equation_and_stores_its_energy(k, ell, u_a):
    gamma1 = k * ell**2
    layer = {"k": k, "gamma1": gamma1}
    a = 3.3 * ell
    x = 3.9 * ell  # outside of the contact
    h = 1e-3 * ell  # the step of differences

    def u(x):
        return cards.tail.displacement(x, a=a, u_a=u_a, **layer)

    around = u(x + h * np.arange(-2, 3))
    curvature = np.dot([-1, 16, -30, 16, -1], around) / (12 * h**2)
    check(gamma1 * curvature, k * u(x), 1e-8)
    assert u(-a) == u_a == u(a)
    beyond = u(a + h * np.arange(5))
    slope = np.dot([-25, 48, -36, 16, -3], beyond) / (12 * h)
    check(cards.tail.slope_at_line(u_a, **layer), slope, 1e-9)
    amplitude = cards.tail.amplitude(u_a, a=a, **layer)
    check(-amplitude * np.exp(-x / ell), u(x), 1e-13)
    squares = quad(lambda s: (u(a + s * ell) / u_a) ** 2, 0, 40, epsabs=0)[0] * ell * u_a**2
    stored = (k / 2 + gamma1 / (2 * ell**2)) * squares  # u' = −u/l
    check(cards.tail.energy(u_a, **layer), stored, 1e-10)


@every
@given(decades, st.floats(-0.9, 0.49), decades)
def test_uniaxial_modulus_is_made_of_the_lame_constants(E, nu, h):
    shear = E / (2 * (1 + nu))
    lame = 2 * shear * nu / (1 - 2 * nu)
    check(cards.foundation.modulus(E, nu), lame + 2 * shear, 1e-12)
    check(cards.foundation.stiffness(E, nu, h) * h, cards.foundation.modulus(E, nu), 1e-15)


@every
@given(decades, st.floats(1e-9, 2.0), decades)
def test_young_angle(gamma1, share, gamma2):
    line = cards.contact_line
    w = share * gamma1
    gamma12 = gamma1 + gamma2 - w
    scale = gamma1 + gamma2
    check(gamma12 + gamma1 * np.cos(line.angle(gamma1, gamma2, gamma12)), gamma2, 1e-14, scale)
    check(line.work_of_adhesion(gamma1, gamma2, gamma12), w, 1e-14, scale)
    exact = line.angle_deficit(w, gamma1)
    small = line.angle_deficit_small(w, gamma1)
    check(gamma1 * (1 - np.cos(exact)), w, 1e-15, gamma1)
    check(gamma1 * small**2 / 2, w, 1e-14)
    if share < 0.1:
        assert share / 12 - 1e-15 < exact / small - 1 < share / 12 * (1 + share) + 1e-15
    # a flat face at any slope, f(a) = d + 2 l sin((π − θ)/2), keeps the separation δ₀
    ell = cards.tail.elastocapillary_length(2.7, gamma1)
    d_c = cards.plane.critical_depth(2.7, w)
    check(2 * ell * np.sin(exact / 2), -d_c, 1e-14)


@every
@given(shapes)
def test_every_contact_meets_the_line_conditions(case):
    a = case("half_width", case.d)
    line = cards.contact_line
    w = case.args["w"]
    f_a = case.height(a)
    slope_a = case.slope(a)
    scale = abs(case.d) + case.delta0 + case.ell * slope_a
    residual = line.line_residual(case.d, f_a, slope_a, w=w, **case.layer)
    if a == 0 and case.n == 1:  # pinned at the tip: the line would recede, had it a place to go
        assert residual >= -1e-13 * scale
        assert 0 <= case.d <= case.q
        return
    check(residual, 0.0, 1e-13, scale)
    check(line.depth(f_a, slope_a, w=w, **case.layer), case.d, 1e-13, scale)
    check(case("depth", a), case.d, 1e-13, scale)
    alpha = line.angle_deficit_small(w, case.layer["gamma1"])
    u_a = case.d - f_a
    theta = line.boundary_condition(slope_a, cards.tail.slope_at_line(u_a, **case.layer))
    check(theta, np.pi - alpha, 1e-13, 1 + scale / case.ell)
    residual = line.boundary_residual(slope_a, u_a, np.pi - alpha, **case.layer)
    check(residual, 0.0, 1e-13, 1 + scale / case.ell)


@every
@given(shapes)
def test_energy_is_the_functional_and_force_its_derivative(case):
    """Energy is the functional and force its slope and the integral of the springs."""
    a = case("half_width", case.d)
    d = case.d
    ell = case.ell
    k = case.args["k"]
    terms = case.parts(a)
    force = case("force", d)
    check(case("energy", d), terms.sum(), 1e-12, abs(terms).sum())
    shift = 0.3 * min(case.delta0, d - case.least)
    for neighbour in (case("half_width", d - shift), case("half_width", d + shift)):
        assert case.parts(neighbour).sum() >= terms.sum() - 1e-14 * abs(terms).sum()
    scale = 2 * k * (a + ell) * (abs(d) + case.delta0)
    h = 0.02 * min(d - case.least, abs(d - case.q))
    slope = np.dot(EIGHTH_ORDER, case("energy", d + h * np.arange(-4, 5)))
    check(slope, force * h, 1e-9, scale * h + 1e-5 * abs(terms).sum())
    points = SIGNS * (a * T**4), SIGNS * (a + 40 * ell * T)  # either side of x = 0
    dx = (4 * a * T**3 * DT, 40 * ell * DT)
    u = [case.card.displacement(x, d=d, **case.args) for x in points]
    check(2 * k * np.vdot(u, dx), force, 1e-12, scale)
    if case.n == int(case.n):
        check(cards.force.total(d, a, f=case.height, **case.layer), force, 1e-12, scale)
        pull = cards.force.surface_small_slope(-1e-5 * ell, **case.layer)
        check(cards.force.surface(1e-5, gamma1=case.args["gamma1"]), pull, 1e-10)


@every
@given(of_paper)
def test_pull_off_is_the_minimum_of_the_force(case):
    force_min, d_min, a_min = case("pull_off")
    top = 4 * (a_min + case.ell)
    scan = case("force_of_width", np.linspace(0, top, 500))
    least = case.card.detachment_depth(
        **({"k": case.args["k"], "w": case.args["w"]} if case.n == 2 else case.args)
    )
    check(least, case.least, 1e-14, case.delta0)
    if case.q > 3e-15 * case.delta0:  # a sharp wedge never pulls
        assert (force_min, d_min, a_min) == (0, 0, 0)
        assert scan.min() > 0 == case("force", 0.0)
        return
    best = minimize_scalar(
        lambda a: case("force_of_width", a), bounds=(0, top), options={"xatol": 1e-9 * top}
    )
    check(force_min, min(best.fun, scan.min()), 1e-9, abs(scan).max())
    assert force_min <= scan.min() + 1e-13 * abs(scan).max()
    check(a_min, best.x, 1e-6, top)
    check(case("adhesion_force"), -force_min, 1e-14, abs(scan).max())
    check(d_min, case("depth", a_min), 1e-13, case.delta0 + case.ell * case.slope(a_min))
    if case.n == 2:
        released = cards.parabola.energy_released(w=case.args["w"], **case.layer)
        check(released, case("energy", least), 1e-14)


@pytest.mark.parametrize(("a", "ell"), [(2.5e-3, 4e-5), (3e-5, 7e-4), (0.3, 0.0)])
def test_flat_punch(a, ell):
    k = 2.7e6
    w = 0.043
    punch = cards.flat_punch
    layer = {"k": k, "gamma1": k * ell**2}
    args = {"a": a, "w": w, **layer}
    delta0 = cards.plane.critical_separation(k, w)
    check(k * delta0**2 / 2, w, 1e-14)  # Eq. (18): a spring lets go when it stores w
    d = delta0 * np.array([-0.8, 1.7])
    h = 1e-3 * delta0
    force = punch.force(d, **args)
    check(force, (punch.energy(d + h, **args) - punch.energy(d - h, **args)) / (2 * h), 1e-9)
    check(force, cards.force.total(d, a, f=np.zeros_like, **layer), 1e-13)
    tilted = cards.force.elastic(d, a, f=lambda x: 0.3 * x, k=k)
    check(tilted, cards.force.elastic(d, a, f=np.zeros_like, k=k), 1e-13, k * a**2)
    least = punch.detachment_depth(k=k, w=w)
    leaves = punch.global_pull_off_depth(**args)
    assert least == -delta0 <= leaves < 0
    tail = cards.tail.displacement(a + 0.7 * ell, a=a, u_a=least, **layer)
    u = punch.displacement(np.array([0.3 * a, a, a + 0.7 * ell]), **args)
    check(u, np.array([least, least, tail]), 1e-14)
    check(punch.force_at_detachment(**args), punch.force(least, **args), 1e-14)
    check(punch.adhesion_force(**args), -punch.force(least, **args), 1e-14)
    check(punch.energy(least, **args), 2 * w * ell, 1e-14, w * a)
    check(punch.energy(leaves, **args), 0.0, 1e-14, w * a)


def test_wedge_is_continuous_where_the_line_leaves_the_tip():
    args = {"delta": 0.31, "k": 2.7e6, "gamma1": 0.19, "w": 2.3e-3}
    wedge = cards.wedge
    shallow, q = wedge.tip_pinned_depths(**args)
    assert shallow == 0 < q == wedge.depth(0.0, **args)
    d = q * np.array([0.0, 0.4, 1 - 1e-9, 1 + 1e-9])
    force = wedge.force(d, **args)
    energy = wedge.energy(d, **args)
    assert (np.sign(wedge.half_width(d, **args)) == [0, 0, 0, 1]).all()
    check(force[:3], 2 * np.sqrt(2.7e6 * 0.19) * d[:3], 1e-14)  # 2kld
    check(force[3], force[2], 1e-7)
    check(energy[3], energy[2], 1e-7)
    assert wedge.tip_pinned_depths(**{**args, "w": 0.05}) == (0, 0)


def test_rounding_at_the_end_of_a_branch_is_forgiven():
    for delta in np.linspace(0.1, 0.5, 40):  # tan δ = α up to rounding, either side
        args = {"delta": delta, "k": 2.7e6, "gamma1": 0.19, "w": 0.19 * np.tan(delta) ** 2 / 2}
        check(cards.wedge.adhesion_force(**args), 0.0, 1e-14, 0.19)
        other_units = {"delta": delta, "k": 2.7e3, "gamma1": 190.0, "w": 1e3 * args["w"]}
        least = cards.wedge.detachment_depth(**other_units) / 1e3
        widths = [cards.wedge.half_width(least, **args)]
        args["c"] = np.tan(args.pop("delta"))
        widths.append(cards.power_law.half_width(least, n=1.0, **args))
        assert max(widths) < 1e-14 * np.sqrt(0.19 / 2.7e6)
    assert cards.contact_line.angle(0.7, 0.1, 0.8) == np.pi  # 0.7 + 0.1 − 0.8 = −1e-16
    args = {"k": 2.7e6, "gamma1": 0.19, "w": 0.0043}
    least = -cards.plane.critical_separation(2.7e6, 0.0043)
    for card, shape in ((cards.parabola, {"R": 0.3}), (cards.power_law, {"c": 0.3, "n": 1.5})):
        assert card.half_width(least * (1 + 4e-16), **shape, **args) == 0
        with pytest.raises(ValueError, match="pass d >= "):
            card.half_width(least * (1 + 1e-14), **shape, **args)
    # a = (level/(nl))^(1/(n − 1)) lies below the range of float64
    assert cards.power_law.half_width(0.0, c=0.9, n=1.001, **args) == 0


@pytest.mark.parametrize("n", [1.01, 8.0, 20.0, 50.0, 300.0])
def test_half_width_of_any_exponent(n):
    """The half-width is found for exponents up to that of a punch, and has its depth (16)."""
    d = np.linspace(-0.9, 3.0, 40)[:, None]
    args = {"c": 1.0, "n": n, "k": 1.0, "gamma1": np.geomspace(1e-6, 1e6, 25), "w": 0.5}
    a = cards.power_law.half_width(d, **args)
    found = cards.power_law.depth(a, **args)
    expected = np.broadcast_to(d, a.shape)
    check(found[a > 0], expected[a > 0], 1e-12, scale=1.0)  # δ₀ = 1


@every
@given(decades, decades, decades, ratios)
def test_no_adhesion(R, k, d, tension):
    none = cards.nonadhesive
    ell = tension * np.sqrt(R * d)
    gamma1 = k * ell**2
    layer = {"k": k, "gamma1": gamma1}
    a = none.parabola_half_width(d, R=R, **layer)
    height = a**2 / (2 * R)
    slope = a / R
    check(cards.parabola.half_width(d, R=R, w=0.0, **layer), a, 1e-15)
    total = cards.force.total(d, a, f=lambda x: x**2 / (2 * R), **layer)
    check(none.parabola_force(d, R=R, **layer), total, 1e-11)  # Eq. (40) against (11) and (39)
    check(none.parabola_residual(a, d, R=R, **layer), 0.0, 1e-14, R * d)
    check(none.line_residual(d, height, slope, **layer), 0.0, 1e-14, d)
    check(none.slope_jump(slope, d - height, **layer), 0.0, 1e-14, d / ell)
    gamma2 = 2.3
    dry = none.interfacial_energy(gamma1, gamma2)
    check(cards.contact_line.work_of_adhesion(gamma1, gamma2, dry), 0.0, 1e-15, dry)
    theta = cards.contact_line.angle(gamma1, gamma2, dry)  # Eq. (35), up to √rounding
    check(theta, none.contact_angle(), 1e-7 * np.sqrt(dry / gamma1))
    assert cards.parabola.half_width(0.0, R=R, k=k, gamma1=0.0, w=0.0) == 0


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("alpha", [3e-7, 2e-3, 0.7, 1.3, 4e2, 5e6, np.inf])
def test_against_fifty_digits(kind, alpha):
    ell, size = (3.1e-4, 3.1e-4 * alpha) if alpha < np.inf else (0.0, 2.3e-5)
    for ratio, lift, adhesive in itertools.product((1e-6, 0.6, 40.0), (1e-3, 1.7, 3e5), (1, 0)):
        case = Case(kind, ell, size, 7.3e5, ratio, lift, adhesive)
        with mp.workdps(50):
            exact = Exact(case)
            d = mp.mpf(case.d)
            a = exact.half_width(d)
            force = float(exact.force(a, d))
            energy = float(exact.energy(a, d))
            a = float(a)
        n = case.n
        k = case.args["k"]
        depth = abs(case.d) + case.delta0
        loss = a * depth / (lift * size)  # of digits: in d + δ₀, and for the wedge in its
        loss += 0 if n > 1 else ell + depth / case.c  # difference to l tan δ
        check(case("half_width", case.d), a, 4e-15, loss)
        bare = n > 1 and not adhesive  # a sum of positive terms: every digit counts
        pull = 2 * k * ((a + ell) * depth + case.delta0 * loss)
        check(case("force", case.d), force, 2e-14, 0 if bare else pull)
        check(case("energy", case.d), energy, 2e-14, 0 if bare else abs(case.parts(a)).sum())
        if ell == 0:  # Eq. (18)
            level = cards.contact_line.cut_level(case.d, k=k, w=case.args["w"])
            check(case.height(a), level, 1e-13, depth)


def test_force_on_a_punch_finite_slopes():
    """γ₁ sin φ on both sides, 1 - cos φ = w/γ₁, at any slope."""
    gamma1 = 0.07
    ratio = np.array([1e-3, 0.3, 0.9, 0.99])
    pull = cards.finite.punch_surface_force_at_detachment(gamma1=gamma1, w=ratio * gamma1)
    check(pull, 2 * gamma1 * np.sqrt(1 - (1 - ratio) ** 2), 1e-12)
