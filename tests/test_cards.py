"""The closed forms against each other, against quadrature and against 50-digit arithmetic.

What is held fixed is imposed (material, geometry, depth); no expected number comes from a run.
"""

import inspect
import itertools
from typing import Any, NamedTuple

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from scipy.integrate import quad
from scipy.optimize import minimize_scalar

from energy import cards

every = settings(derandomize=True, deadline=None, max_examples=60)
NODES, WEIGHTS = np.polynomial.legendre.leggauss(60)
T, DT = 0.5 + 0.5 * NODES, 0.5 * WEIGHTS
EIGHTH_ORDER = [1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]


def check(value, expected, rel, scale=0.0):
    """|value − expected| <= rel · max(|expected|, scale): no absolute tolerance, no unit."""
    value, expected = np.asarray(value), np.asarray(expected)
    assert value.shape == expected.shape
    assert (abs(value - expected) <= rel * np.maximum(abs(expected), scale)).all()


class Case(NamedTuple):
    """A card module with its parameters, the same profile as c|x|ⁿ, least depth and depth."""

    card: Any
    args: dict[str, float]
    c: float
    n: float
    ell: float
    delta0: float
    least: float
    d: float

    def height(self, x):
        return self.c * np.abs(x) ** self.n

    def slope(self, x):
        return self.c * self.n * np.abs(x) ** (self.n - 1)

    def __call__(self, name, *values):
        return getattr(self.card, name)(*values, **self.args)

    def pick(self, *names):
        return {name: self.args[name] for name in names}


def build(kind, ell, alpha, k, ratio, lift, adhesive=True):
    """`ratio`: c as δ₀/max(l, δ₀)ⁿ; `lift`: depth above the least one in units of δ₀."""
    n, size = {"wedge": 1.0, "parabola": 2.0}.get(kind) or float(kind), ell * alpha
    c, delta0 = ratio * size / max(ell, size) ** n, size * adhesive
    geometry = {"wedge": {"delta": float(np.arctan(c))}, "parabola": {"R": 0.5 / c}}
    args = {"k": k, "gamma1": k * ell**2, "w": 0.5 * k * delta0**2}
    c = float(np.tan(np.arctan(c))) if kind == "wedge" else c
    least = min(ell * c - delta0, 0.0) if n == 1 else -delta0
    card = getattr(cards, kind if kind in geometry else "power_law")
    args |= geometry.get(kind, {"c": c, "n": n})
    return Case(card, args, c, n, ell, delta0, least, least + lift * size)


decades = st.floats(-5, 5).map(lambda e: 10.0**e)
ratios = st.floats(-2, 2).map(lambda e: 10.0**e)
KINDS = ["wedge", "parabola", "1.0", "1.5", "2.0", "3.7"]
paper_shapes, all_shapes = (
    st.builds(build, st.sampled_from(kinds), decades, ratios, decades, ratios, ratios)
    for kinds in (KINDS[:2], KINDS)
)


def parts(case, a):
    """Springs, contact surface, tails and adhesion of the energy at (d, a), by quadrature."""
    x, dx = a * T**4, 4 * a * T**3 * DT
    springs = case.args["k"] * ((case.d - case.height(x)) ** 2 * dx).sum()
    surface = case.args["gamma1"] * (case.slope(x) ** 2 * dx).sum()
    tails = case.args["k"] * case.ell * (case.d - case.height(a)) ** 2
    return np.array([springs, surface, tails, -2 * case.args["w"] * a])


@every
@given(decades, decades, decades)
def test_tail_solves_its_equation_and_stores_its_energy(k, ell, u_a):
    layer, a, x, h = {"k": k, "gamma1": k * ell**2}, 3.3 * ell, 3.9 * ell, 1e-3 * ell

    def u(x):
        return cards.tail.displacement(x, a=a, u_a=u_a, **layer)

    curvature = np.dot([-1, 16, -30, 16, -1], u(x + h * np.arange(-2, 3))) / (12 * h**2)
    check(layer["gamma1"] * curvature, k * u(x), 1e-8)
    assert u(-a) == u_a == u(a)
    slope = np.dot([-25, 48, -36, 16, -3], u(a + h * np.arange(5))) / (12 * h)
    check(cards.tail.slope_at_line(u_a, **layer), slope, 1e-9)
    check(-cards.tail.amplitude(u_a, a=a, **layer) * np.exp(-x / ell), u(x), 1e-13)
    squares = quad(lambda s: (u(a + s * ell) / u_a) ** 2, 0, 40, epsabs=0)[0] * ell * u_a**2
    stored = (k / 2 + layer["gamma1"] / (2 * ell**2)) * squares  # u' = −u/l
    check(cards.tail.energy(u_a, **layer), stored, 1e-10)


@every
@given(decades, st.floats(1e-9, 2.0), decades)
def test_young_angle(gamma1, share, gamma2):
    line, w = cards.contact_line, share * gamma1
    gamma12, scale = gamma1 + gamma2 - w, gamma1 + gamma2
    theta = line.angle(gamma1, gamma2, gamma12)
    check(gamma12 + gamma1 * np.cos(theta), gamma2, 1e-14, scale)
    check(line.work_of_adhesion(gamma1, gamma2, gamma12), w, 1e-14, scale)
    exact, small = line.angle_deficit(w, gamma1), line.angle_deficit_small(w, gamma1)
    check(gamma1 * (1 - np.cos(exact)), w, 1e-15, gamma1)
    check(gamma1 * small**2 / 2, w, 1e-14)
    if share < 0.1:
        assert share / 12 - 1e-15 < exact / small - 1 < share / 12 * (1 + share) + 1e-15
    # a flat face at any slope, f(a) = d + 2 l sin((π − θ)/2), keeps the separation δ₀
    ell, d_c = cards.tail.elastocapillary_length(2.7, gamma1), cards.plane.critical_depth(2.7, w)
    check(2 * ell * np.sin(exact / 2), -d_c, 1e-14)


@every
@given(all_shapes)
def test_every_contact_meets_the_line_conditions(case):
    a, line, layer = case("half_width", case.d), cards.contact_line, case.pick("k", "gamma1")
    f_a, slope_a, w = case.height(a), case.slope(a), case.args["w"]
    scale = abs(case.d) + case.delta0 + case.ell * slope_a
    residual = line.line_residual(case.d, f_a, slope_a, w=w, **layer)
    if a == 0 and case.n == 1:  # pinned at the tip: the line would recede, had it a place to go
        assert residual >= -1e-13 * scale and case.d >= 0
        return
    check(residual, 0.0, 1e-13, scale)
    check(line.depth(f_a, slope_a, w=w, **layer), case.d, 1e-13, scale)
    check(case("depth", a), case.d, 1e-13, scale)
    alpha, u_a = line.angle_deficit_small(w, layer["gamma1"]), case.d - f_a
    theta = line.boundary_condition(slope_a, cards.tail.slope_at_line(u_a, **layer))
    check(theta, np.pi - alpha, 1e-13, 1 + scale / case.ell)
    residual = line.boundary_residual(slope_a, u_a, np.pi - alpha, **layer)
    check(residual, 0.0, 1e-13, 1 + scale / case.ell)


@every
@given(all_shapes)
def test_energy_is_the_functional_and_force_its_slope_and_the_integral_of_the_springs(case):
    a, d, ell, layer = case("half_width", case.d), case.d, case.ell, case.pick("k", "gamma1")
    terms = parts(case, a)
    check(case("energy", d), terms.sum(), 1e-12, abs(terms).sum())
    shift = 0.3 * min(case.delta0, d - case.least)
    for neighbour in (case("half_width", d + s * shift) for s in (-1, 1)):
        assert parts(case, neighbour).sum() >= terms.sum() - 1e-14 * abs(terms).sum()
    force, scale = case("force", d), 2 * layer["k"] * (a + ell) * (abs(d) + case.delta0)
    kink = abs(d - (ell * case.c - case.delta0)) if case.n == 1 and case.least == 0 else np.inf
    h = 0.02 * min(d - case.least, kink)
    slope = np.dot(EIGHTH_ORDER, case("energy", d + h * np.arange(-4, 5)))
    check(slope, force * h, 1e-9, scale * h + 1e-5 * abs(terms).sum())
    x, dx = (a * T**4, a + 40 * ell * T), (4 * a * T**3 * DT, 40 * ell * DT)
    u = [case.card.displacement(x, d=d, **case.args) for x in x]
    check(2 * layer["k"] * np.vdot(u, dx), force, 1e-12, scale)
    if case.n == int(case.n):
        check(cards.force.total(d, a, f=case.height, **layer), force, 1e-12, scale)
        pull = cards.force.surface_small_slope(-1e-5 * ell, **layer)
        check(cards.force.surface(1e-5, gamma1=layer["gamma1"]), pull, 1e-10)


@every
@given(paper_shapes)
def test_shapes_against_power_law(case):
    power, d, a = cards.power_law, case.d, case("half_width", case.d)
    same = {"c": case.c, "n": case.n, **case.pick("k", "gamma1", "w")}
    reach = a + (case.ell + case.delta0 / case.c if case.n == 1 else 0)
    check(power.half_width(d, **same), a, 1e-14, reach)
    size = abs(d) + case.delta0 + case.ell * case.slope(a)
    force = 2 * same["k"] * (a + case.ell) * size
    check(power.force(d, **same), case("force", d), 1e-13, force)
    check(power.energy(d, **same), case("energy", d), 1e-13, abs(parts(case, a)).sum())
    check(power.depth(a, **same), case("depth", a), 1e-14, size)
    check(power.detachment_depth(**same), case.least, 1e-14, size)
    if a > 0:  # Eq. (29) against (25) and (27)
        check(case("force_of_width", a), case("force", d), 1e-13, force)


@every
@given(paper_shapes)
def test_pull_off_is_the_minimum_of_the_force(case):
    force_min, d_min, a_min = case("pull_off")
    top = 4 * (a_min + case.ell)
    scan = case("force_of_width", np.linspace(0, top, 500))
    best = minimize_scalar(
        lambda a: case("force_of_width", a), bounds=(0, top), options={"xatol": 1e-9 * top}
    )
    least = case.card.detachment_depth(**(case.args if case.n == 1 else case.pick("k", "w")))
    check(least, case.least, 1e-13, 1e-3 * case.delta0)
    if case.n == 1 and case.ell * case.c > case.delta0:
        assert (force_min, d_min, a_min) == (0, 0, 0) < (scan.min(),) and case("force", 0.0) == 0
        return
    check(force_min, min(best.fun, scan[0]), 1e-9, abs(scan).max())
    check(a_min, best.x, 1e-6, top)
    check(case("adhesion_force"), -force_min, 1e-15)
    check(d_min, case("depth", a_min), 1e-13, case.delta0 + case.ell * case.slope(a_min))
    if case.n == 2:
        released = cards.parabola.energy_released(**case.pick("k", "gamma1", "w"))
        check(released, case("energy", least), 1e-14)


@pytest.mark.parametrize(("a", "ell"), [(2.5e-3, 4e-5), (3e-5, 7e-4), (0.3, 0.0)])
def test_flat_punch(a, ell):
    k, w, punch = 2.7e6, 0.043, cards.flat_punch
    layer = {"k": k, "gamma1": k * ell**2}
    args, delta0 = {"a": a, "w": w, **layer}, cards.plane.critical_separation(k, w)
    check(k * delta0**2 / 2, w, 1e-14)  # Eq. (18): a spring lets go when it stores w
    check(cards.contact_line.cut_level(2 * delta0, k=k, w=w), 3 * delta0, 1e-14)
    d = delta0 * np.array([-0.8, 1.7])
    force, h = punch.force(d, **args), 1e-3 * delta0
    check(force, (punch.energy(d + h, **args) - punch.energy(d - h, **args)) / (2 * h), 1e-9)
    check(force, cards.force.total(d, a, f=np.zeros_like, **layer), 1e-13)
    least, leaves = punch.detachment_depth(k=k, w=w), punch.global_pull_off_depth(**args)
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
    shallow, q = cards.wedge.tip_pinned_depths(**args)
    assert shallow == 0 < q == cards.wedge.depth(0.0, **args)
    d = q * np.array([0.0, 0.4, 1 - 1e-9, 1 + 1e-9])
    a, force, energy = (
        getattr(cards.wedge, s)(d, **args) for s in ("half_width", "force", "energy")
    )
    assert (a[:3] == 0).all() and 0 < a[3] < 1e-8 * q / np.tan(0.31)
    check(force[:3], 2 * np.sqrt(2.7e6 * 0.19) * d[:3], 1e-14)
    check(np.array([force[3], energy[3]]), np.array([force[2], energy[2]]), 1e-7)
    check(cards.wedge.force_of_width(0.0, **args), force[2], 1e-8)
    assert cards.wedge.tip_pinned_depths(**{**args, "w": 0.05}) == (0, 0)


@every
@given(decades, decades, decades, decades, ratios)
def test_no_adhesion_and_no_tension(R, k, d, lift, tension):
    none, ell = cards.nonadhesive, tension * np.sqrt(R * d)
    layer = {"k": k, "gamma1": k * ell**2}
    a = none.parabola_half_width(d, R=R, **layer)
    check(cards.parabola.half_width(d, R=R, w=0.0, **layer), a, 1e-15)
    total = cards.force.total(d, a, f=lambda x: x**2 / (2 * R), **layer)
    check(none.parabola_force(d, R=R, **layer), total, 1e-11)  # Eq. (40) against (11) and (39)
    check(none.parabola_residual(a, d, R=R, **layer), 0.0, 1e-14, R * d)
    check(none.line_residual(d, a**2 / (2 * R), a / R, **layer), 0.0, 1e-14, d)
    check(none.slope_jump(a / R, d - a**2 / (2 * R), **layer), 0.0, 1e-14, d / ell)
    dry = none.interfacial_energy(layer["gamma1"], 2.3)
    check(cards.contact_line.work_of_adhesion(layer["gamma1"], 2.3, dry), 0.0, 1e-15, dry)
    check(cards.contact_line.angle(layer["gamma1"], 2.3, dry), none.contact_angle(), 1e-6)
    bare, w, x = {"k": k, "gamma1": 0.0}, 0.5 * k * (lift * d) ** 2, np.array([0.5, 1.01])
    for kind, geometry, c, n in [
        ("wedge", {"delta": 0.3}, np.tan(0.3), 1),
        ("parabola", {"R": R}, 0.5 / R, 2),
        ("power_law", {"c": 0.7, "n": 3}, 0.7, 3),
    ]:
        card, args = getattr(cards, kind), {**geometry, **bare}
        a, level = card.half_width(d, w=w, **args), d * (1 + lift)
        check(c * a**n, level, 1e-13)
        u = card.displacement(a * x, d=d, w=w, **args)
        check(u, np.array([d - c * (a / 2) ** n, 0]), 1e-13, level)
        elastic = cards.force.elastic(d, a, f=lambda x, c=c, n=n: c * abs(x) ** n, k=k)
        check(card.force(d, w=w, **args), elastic, 1e-12, k * a * level)
        assert card.half_width(0.0, w=0.0, **args) == 0 == card.energy(0.0, w=0.0, **args)


def exact(case):
    """a, P and U from Eqs. (25), (33) or (16), (11) and the energy, in 50-digit arithmetic."""
    k, gamma1, w, d, n = map(mp.mpf, (*case.pick("k", "gamma1", "w").values(), case.d, case.n))
    geometry = {s: mp.mpf(value) for s, value in case.args.items() if s in ("delta", "R", "c")}
    (name, value), ell, delta0 = geometry.popitem(), mp.sqrt(gamma1 / k), mp.sqrt(2 * w / k)
    c = {"delta": mp.tan(value), "R": 1 / (2 * value), "c": value}[name]
    if n == 1:
        a = max((d + delta0) / c - ell, mp.mpf(0))
    elif n == 2:
        a = mp.sqrt(ell**2 + (d + delta0) / c) - ell
    else:
        a = ((d + delta0) / c) ** (1 / n)  # above the root
        for _ in range(60):  # Newton for ln a
            misfit = mp.log(c * a ** (n - 1) * (a + n * ell) / (d + delta0))
            a *= mp.exp(-misfit / (n - 1 + a / (a + n * ell)))
    f, slope, u_a = c * a**n, c * n * a ** (n - 1), d - c * a**n
    force = 2 * k * (a * (d - f / (n + 1)) + ell * u_a)
    springs = a * k * (d**2 - 2 * d * f / (n + 1) + f**2 / (2 * n + 1))
    lines = a * (gamma1 * slope**2 / (2 * n - 1) - 2 * w)
    return float(a), float(force), float(springs + lines + k * ell * u_a**2)


@pytest.mark.parametrize("kind", KINDS)
@pytest.mark.parametrize("alpha", [3e-7, 2e-3, 0.7, 1.3, 4e2, 5e6])
def test_against_fifty_digits(kind, alpha):
    for ratio, lift, adhesive in itertools.product((1e-6, 0.6, 40.0), (1e-3, 1.7, 3e5), (1, 0)):
        case = build(kind, 3.1e-4, alpha, 7.3e5, ratio, lift, adhesive)
        with mp.workdps(50):
            a, force, energy = exact(case)
        n, depth = case.n, abs(case.d) + case.delta0
        loss = a * depth / (lift * 3.1e-4 * alpha)  # of digits in d + δ0, and in its difference to
        loss += 0 if n > 1 else case.ell + depth / case.c  # l tan δ
        check(case("half_width", case.d), a, 4e-15, loss)
        bare = n > 1 and not adhesive  # a sum of positive terms: every digit counts
        k, stored = case.args["k"], abs(parts(case, a)).sum()
        pull = 2 * k * ((a + case.ell) * depth + case.delta0 * loss)
        check(case("force", case.d), force, 2e-14, 0 if bare else pull)
        check(case("energy", case.d), energy, 2e-14, 0 if bare else stored)


# Arguments in SI with the powers of (force, length) in their units; none of them is 1.
VALUES = {
    "E": (8.3e3, 1, -2), "R": (0.013, 0, 1), "a": (2.1e-3, 0, 1), "beta": (0.05, 0, 0),
    "c": (3.3, 0, -0.5), "d": (3.4e-5, 0, 1), "delta": (0.2, 0, 0), "f_a": (1.7e-5, 0, 1),
    "gamma1": (0.031, 1, -1), "gamma12": (0.047, 1, -1), "gamma2": (0.021, 1, -1),
    "h": (1.3e-3, 0, 1), "k": (1.1e7, 1, -3), "n": (1.5, 0, 0), "nu": (0.4, 0, 0),
    "slope_a": (0.11, 0, 0), "slope_f": (0.07, 0, 0), "slope_u": (0.23, 0, 0),
    "theta": (2.9, 0, 0), "u_a": (-2.3e-5, 0, 1), "w": (4.3e-3, 1, -1), "x": (2.2e-3, 0, 1),
}  # fmt: skip
FUNCTIONS = {
    f"{module}.{name}": function
    for module in set(cards.__all__) - {"PullOff"}
    for name, function in inspect.getmembers(getattr(cards, module), inspect.isfunction)
    if function.__module__ == f"energy.cards.{module}" and name[0] != "_"
}


def call(function, F=1.0, L=1.0, **overrides):
    """The function at VALUES, in units of force and length F and L times smaller."""
    values = {s: v * F**p * L**q for s, (v, p, q) in VALUES.items()}
    values = {"f": lambda x: x**2 / (0.026 * L), **values, **overrides}
    used = inspect.signature(function).parameters
    first = [values[s] for s, p in used.items() if p.kind != p.KEYWORD_ONLY]
    keywords = {s: values[s] for s, p in used.items() if p.kind == p.KEYWORD_ONLY and s in values}
    return function(*first, **keywords)


@pytest.mark.parametrize("name", sorted(FUNCTIONS))
def test_units_arrays_and_nan(name):
    function = FUNCTIONS[name]
    plain = np.ravel(call(function))
    for units in ({"F": 1e6}, {"L": 1e3}):
        scaled = np.ravel(call(function, **units))
        assert ((scaled == 0) == (plain == 0)).all()
        powers = np.log((scaled / plain)[plain != 0]) / np.log(*units.values())
        check(powers, np.round(powers), 1e-13, 1)
    for s in set(inspect.signature(function).parameters) - {"order"}:
        with pytest.raises(ValueError, match=rf"\b{s}\b.* finite"):
            call(function, **{s: (lambda x: np.nan * x) if s == "f" else np.nan})
        if s not in ("n", "f"):
            pair = VALUES[s][0] * np.array([1, 1.001])
            scalars = np.array([np.ravel(call(function, **{s: v})) for v in pair]).T
            arrays = [np.broadcast_to(v, 2) for v in np.atleast_2d(call(function, **{s: pair}))]
            check(arrays, scalars, 1e-15)


@pytest.mark.parametrize(
    ("name", "overrides", "message"),
    [
        ("tail.elastocapillary_length", {"k": 0.0}, "k = 0.0 must be > 0: pass .* Ẽ/h"),
        ("tail.energy", {"gamma1": -0.5}, "gamma1 = -0.5 must be >= 0: pass the surface tension"),
        ("tail.displacement", {"x": 2e-3}, r"abs\(x\) = 0.002 is below 0.0021: .* \|x\| >= a"),
        ("tail.slope_at_line", {"gamma1": 0.0}, "gamma1 = 0.0 must be > 0"),
        ("tail.amplitude", {"a": 1.0}, "a/l = .* overflow: use displacement"),
        ("plane.critical_depth", {"w": -2.0}, "w = -2.0 must be >= 0: pass the work of adhesion"),
        ("contact_line.angle", {"gamma12": 0.1}, "w = .* must be >= 0: lower gamma12"),
        ("contact_line.angle", {"gamma2": 0.2}, "w = .* exceeds 2 gamma1: .* lower gamma2"),
        ("contact_line.angle_deficit", {"w": 0.1}, "w = 0.1 exceeds .* pass w <= 2 gamma1"),
        ("contact_line.cut_level", {"d": -1e-3}, "d = -0.001 is below -2.7.*pass d >= "),
        ("flat_punch.force", {"d": [0.0, -1e-3]}, "d = -0.001 is below -2.7.*pass d >= "),
        ("flat_punch.energy", {"d": -1e-3}, "d = -0.001 is below -2.7.*pass d >= "),
        ("flat_punch.adhesion_force", {"a": 0.0}, "a = 0.0 must be > 0: pass the contact half"),
        ("wedge.depth", {"a": -1.0}, "a = -1.0 must be >= 0"),
        ("wedge.force", {"d": -1e-3}, "d = -0.001 is below .*pass d >= detachment_depth"),
        ("wedge.energy", {"d": -1e-9, "delta": 0.7}, "d = -1e-09 is below 0.0: .*pass d >= "),
        ("wedge.force", {"delta": np.pi / 2}, r"delta = 1.57.*\(0, π/2\): .* in rad"),
        ("wedge.adhesion_force", {"delta": 0.7}, "delta = 0.7.*pass a blunter wedge"),
        ("parabola.energy", {"d": -1e-3}, "d = -0.001 is below -2.7.*pass d >= "),
        ("parabola.pull_off", {"R": -3.0}, "R = -3.0 must be > 0: pass the radius"),
        ("nonadhesive.parabola_half_width", {"d": -1e-9}, "d = -1e-09 is below 0.0.*pass d >= 0"),
        ("nonadhesive.parabola_force", {"d": -1e-9}, "d = -1e-09 is below 0.0.*pass d >= 0"),
        ("power_law.force", {"d": -1e-3}, "d = -0.001 is below -2.7.*pass d >= detach"),
        ("power_law.energy", {"n": 1.0, "c": 9.0, "d": -1e-9}, "d = -1e-09 is below 0.0.*pass d"),
        ("power_law.depth", {"n": 0.9}, "n = 0.9 must be >= 1"),
        ("power_law.depth", {"n": [2.0, 3.0]}, "n = .* must be one number: loop"),
        ("foundation.stiffness", {"nu": 0.5}, r"nu = 0.5 must lie in \(-1, 1/2\)"),
        ("foundation.stiffness", {"h": 0.0}, "h = 0.0 must be > 0: pass the layer thickness"),
        ("force.elastic", {"a": "wide"}, "a = 'wide' is not real: pass a number"),
    ],
)
def test_refusals_name_argument_value_and_remedy(name, overrides, message):
    with pytest.raises(ValueError, match=message):
        call(FUNCTIONS[name], **overrides)
