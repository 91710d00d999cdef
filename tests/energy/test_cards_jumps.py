"""Jumps of the cards: 50-digit energies, descent, limits, `minimise`.

The reference knows the functional U(a, d) of any half-width and depth, not its equilibria.
"""

import mpmath as mp
import numpy as np
import pytest
from card_cases import KINDS, Case, decades, every, ratios
from hypothesis import given
from hypothesis import strategies as st
from scenes import adhesive, check
from scipy.optimize import minimize_scalar

from discretization import minimise
from energy import FlatPunch, Parabola, PowerLaw, Wedge, cards

fixed, dead, machine = cards.displacement_control, cards.load_control, cards.machine_control


def random_cases(kinds):
    """Scenes of these kinds; lift is of no use here."""
    return st.builds(
        lambda kind, ell, alpha, k, ratio: Case(kind, ell, ell * alpha, k, ratio, 1.0),
        *(st.sampled_from(kinds), decades, ratios, decades, ratios),
    ).filter(lambda case: abs(case.q) > 1e-3 * case.delta0)  # tan δ = α has its own test


of_paper, shapes = random_cases(KINDS[:2]), random_cases(KINDS)
machines = st.floats(-3, 3).map(lambda e: 10.0**e)  # K/k in units of √(l δ₀)


class Exact:
    """U(a, d) of f = c|x|ⁿ and its derivatives in 50 digits, for floats a card was given."""

    def __init__(self, case):
        k, gamma1, w, n = map(mp.mpf, (*case.layer.values(), case.args["w"], case.n))
        name, value = next(iter(case.geometry.items()))
        value = mp.mpf(value)
        self.c = {"delta": mp.tan(value), "R": 1 / (2 * value), "c": value}[name]
        self.k, self.n, self.ell, self.delta0 = k, n, mp.sqrt(gamma1 / k), mp.sqrt(2 * w / k)
        self.q = self.ell * self.c - self.delta0 if n == 1 else -self.delta0
        self.end = min(self.q, mp.mpf(0))

    def force(self, a, d):
        f = self.c * a**self.n
        return 2 * self.k * (a * (d - f / (self.n + 1)) + self.ell * (d - f))

    def energy(self, a, d):
        n, f, slope = self.n, self.c * a**self.n, self.c * self.n * a ** (self.n - 1)
        springs = a * (d**2 - 2 * d * f / (n + 1) + f**2 / (2 * n + 1)) + self.ell * (d - f) ** 2
        lines = a * ((self.ell * slope) ** 2 / (2 * n - 1) - self.delta0**2)
        return self.k * (springs + lines)

    def depth(self, a):
        """Eq. (16)."""
        slope = self.c * self.n * a ** (self.n - 1)
        return self.c * a**self.n + self.ell * slope - self.delta0

    def depth_on(self, a, K, drive=0):
        """d that balances P(a, d) = K (drive − d): P is linear in d."""
        at0, at1 = self.force(a, mp.mpf(0)), self.force(a, mp.mpf(1))
        return (K * drive - at0) / (at1 - at0 + K)

    def jump_in(self, K, start):
        """a, d, P and the energy released where the descent at fixed drive 0 stops."""
        if self.q >= 0:
            return mp.mpf(0), mp.mpf(0), mp.mpf(0), mp.mpf(0)
        on = (lambda a: mp.mpf(0)) if K is None else (lambda a: self.depth_on(a, K))
        log = mp.findroot(
            lambda x: mp.log((self.depth(mp.exp(x)) + self.delta0) / (on(mp.exp(x)) + self.delta0)),
            mp.log(start),
        )
        a = mp.exp(log)
        d = on(a)
        return a, d, self.force(a, d), -self.energy(a, d) - (K or 0) * d**2 / 2

    def rate(self, a, K):
        """dP/da + K dd/da on the branch: negative where it is unstable."""
        pull = lambda x: self.force(x, self.depth(x)) + K * self.depth(x)  # noqa: E731
        h = a * mp.mpf(10) ** -15
        return (pull(a + h) - pull(a - h)) / h


def agrees(jump, a, d, force, released, case, exact, rel=1e-13):
    """Each field to rounding times the loss of digits in q = l tan δ − δ₀."""
    loss = 1.0
    if case.n == 1 and exact.q != 0:
        loss = float((exact.ell * exact.c + exact.delta0) / abs(exact.q))
    for value, expected in zip(jump, (force, d, a, released), strict=True):
        check(value, float(expected), rel * loss)


@every
@given(shapes)
def test_jump_in_at_imposed_depth_ends_where_descent_does(case):
    kind = case.name
    jump = getattr(fixed, f"{kind}_jump_in")(**case.args)
    with mp.workdps(50):
        exact = Exact(case)
        agrees(jump, *exact.jump_in(None, jump.half_width or 1), case, exact)


@every
@given(of_paper, machines)
def test_jump_in_under_load_and_machine_ends_where_descent_does(case, ratio):
    kind, K = case.name, case.stiffness(ratio)
    for jump, k in (
        (getattr(machine, f"{kind}_jump_in")(**case.args, K=K), K),
        (getattr(dead, f"{kind}_jump_in")(**case.args), 0.0),
    ):
        with mp.workdps(50):
            exact = Exact(case)
            a, d, force, released = exact.jump_in(mp.mpf(k), jump.half_width or 1)
            agrees(jump, a, d, force if k else 0, released, case, exact)


@pytest.mark.parametrize("kind", KINDS[:2])
@pytest.mark.parametrize("K", [None, 0.0, 1.7, 40.0])
def test_jump_in_is_a_descent_to_the_minimum_of_the_functional(kind, K):
    case = Case(kind, 0.031, 0.017, 2.7, 0.23, 1.0)
    name, control = f"{kind}_jump_in", fixed if K is None else machine if K else dead
    jump = getattr(control, name)(**case.args, **({"K": K} if K else {}))

    def total(a, d):
        case.d = d
        return case.parts(a).sum() + 0.5 * (K or 0.0) * d**2

    def lowest(a):
        if K is None:
            return total(a, 0.0)
        h = 0.01  # U is quadratic in d
        low, mid, high = total(a, -h), total(a, 0.0), total(a, h)
        return total(a, 0.5 * h * (low - high) / (low - 2 * mid + high))

    way = [lowest(a) for a in np.linspace(0, jump.half_width, 50)]
    assert way[0] == 0 and (np.diff(way) < 0).all()
    best = minimize_scalar(lowest, bounds=(0, 3 * jump.half_width), options={"xatol": 1e-9})
    check(jump.half_width, best.x, 1e-6)
    check(jump.energy_released, -best.fun, 1e-11)


@every
@given(of_paper, machines)
def test_detachment_is_the_end_of_stability(case, ratio):
    kind, K = case.name, case.stiffness(ratio)
    on_machine = getattr(machine, f"{kind}_detachment")(**case.args, K=K)
    under_load = getattr(dead, f"{kind}_detachment")(**case.args)
    critical = getattr(machine, f"{kind}_critical_stiffness")(**case.args)
    with mp.workdps(50):
        exact = Exact(case)
        for jump, stiff in ((on_machine, K), (under_load, 0.0)):
            if exact.q >= 0:
                assert tuple(jump) == (0, 0, 0, 0)
                continue
            stiff = mp.mpf(stiff)
            tiny = mp.mpf(10) ** -20 * exact.ell
            a = mp.mpf(0)
            if exact.rate(tiny, stiff) < 0:
                a = mp.findroot(lambda a: exact.rate(a, stiff), jump.half_width or exact.ell)  # noqa: B023
            assert (a > 0) == (stiff < critical) or abs(stiff / critical - 1) < 1e-12
            d, end = exact.depth(a), exact.end
            force = exact.force(a, d)
            released = exact.energy(a, d)
            released += force**2 / (2 * stiff) if stiff else -force * (d - end)
            loss = lost_digits(exact, a, stiff)
            check(jump.half_width, float(a), 1e-13 * loss)
            size = float(exact.delta0 + exact.ell * exact.c) if case.n == 1 else case.delta0
            check(jump.depth, float(d), 1e-13, size)
            check(jump.force, float(force), 1e-13, float(2 * exact.k * (a + exact.ell) * size))
            check(jump.energy_released, float(released), 1e-13 * lost_digits(exact, None, 0))


def lost_digits(exact, a, stiff):
    """Condition of a (or of what q alone fixes) in δ₀, l and tan δ."""
    if exact.n == 1 and a is None:
        return 4 * float((exact.ell * exact.c + exact.delta0) / abs(exact.q))
    if a is None or a == 0:
        return 4
    size = a + 2 * exact.ell + stiff / exact.k
    if exact.n == 1:
        return 4 * float((size + exact.delta0 / exact.c) / a)
    return 4 * float(size / a)


@every
@given(of_paper)
def test_controls_meet(case):
    kind, k = case.name, case.args["k"]
    width = 2 * (case.ell + getattr(dead, f"{kind}_jump_in")(**case.args).half_width)
    soft, stiff = 1e-10 * k * case.ell, 1e10 * k * width
    stiff *= 1 + case.delta0 / (case.c * case.ell)
    for event in ("jump_in", "detachment"):
        at = {K: getattr(machine, f"{kind}_{event}")(**case.args, K=K) for K in (soft, stiff)}
        pulled = getattr(dead, f"{kind}_{event}")(**case.args)
        imposed = getattr(fixed, f"{kind}_{event}")(**case.args)
        size = 2 * k * width * (case.delta0 + case.ell * case.c * (case.n == 1))
        scales = (size, case.delta0, width, size * case.delta0)
        spring = at[soft].force ** 2 / (2 * soft) if event == "detachment" else 0.0
        for i, scale in enumerate(scales[:3]):
            check(at[soft][i], pulled[i], 1e-7, scale)
            check(at[stiff][i], imposed[i], 1e-7, scale)
        check(at[stiff].energy_released, imposed.energy_released, 1e-7)
        if event == "jump_in":
            check(at[soft].energy_released, pulled.energy_released, 1e-7)
        elif pulled.half_width > 0.1 * case.ell:
            assert at[soft].energy_released > spring * (1 - 1e-3)
        shape = case("pull_off")
        if event == "detachment":
            for value, expected, scale in zip(pulled, shape, scales[:3], strict=False):
                check(value, expected, 1e-13, scale)
            assert at[stiff].force >= shape.force * (1 + 1e-13)


@every
@given(of_paper, machines, st.floats(1.001, 3))
def test_the_critical_machine_separates_two_regimes(case, ratio, factor):
    kind = case.name
    critical = getattr(machine, f"{kind}_critical_stiffness")(**case.args)
    K = critical or case.stiffness(ratio)
    imposed = getattr(fixed, f"{kind}_detachment")(**case.args)
    above = getattr(machine, f"{kind}_detachment")(**case.args, K=K * factor)
    size = case.delta0 + case.ell * case.c
    check(above.depth, imposed.depth, 1e-13, size)
    check(above.force, imposed.force, 1e-13, case.args["k"] * case.ell * size)
    assert above.half_width == imposed.half_width == 0
    if critical:
        below = getattr(machine, f"{kind}_detachment")(**case.args, K=K / factor)
        assert below.half_width > 0
        assert below.depth > imposed.depth


def test_at_the_sharpest_wedge_that_pulls_everything_vanishes():
    for delta in np.linspace(0.1, 0.5, 40):  # tan δ = α up to rounding, either side
        args = {"delta": delta, "k": 2.7e6, "gamma1": 0.19, "w": 0.19 * np.tan(delta) ** 2 / 2}
        for jump in (
            *(getattr(fixed, f"wedge_{event}")(**args) for event in ("jump_in", "detachment")),
            *(getattr(dead, f"wedge_{event}")(**args) for event in ("jump_in", "detachment")),
            *(getattr(machine, f"wedge_{x}")(**args, K=3e3) for x in ("jump_in", "detachment")),
        ):
            check(jump.force, 0.0, 1e-7, 0.19)
            check(jump.half_width, 0.0, 1e-7, 3e-4)
            check(jump.energy_released, 0.0, 1e-14, 0.19 * 3e-4)
            assert jump.energy_released >= 0


@pytest.mark.parametrize(
    ("indenter", "name", "shape"),
    [
        (FlatPunch(0.043), "flat_punch", {"a": 0.043}),
        (Wedge(0.07), "wedge", {"delta": 0.07}),
        (Parabola(0.7), "parabola", {"R": 0.7}),
        (Parabola(0.05), "parabola", {"R": 0.05}),
        (PowerLaw(7.0, 3.1), "power_law", {"c": 7.0, "n": 3.1}),
    ],
)
def test_minimise_before_and_after_the_events(indenter, name, shape):
    scene = adhesive(indenter)
    k, gamma1, w = scene.stiffness, scene.gamma1, scene.work_of_adhesion
    args = {**shape, "k": k, "gamma1": gamma1, "w": w}
    jump = getattr(fixed, f"{name}_jump_in")(**args)
    state = minimise(scene, 0.0)  # before: U = 0
    check(-state.energy, jump.energy_released, 1e-9)
    check(state.half_width, jump.half_width, 1e-9)
    check(state.force, jump.force, 1e-9, 2 * w)
    jump = getattr(fixed, f"{name}_detachment")(**args)
    h = -1e-6 * jump.depth
    before, after = (minimise(scene, jump.depth + s * h, rtol=1e-4) for s in (1, -1))
    check(before.energy - h * before.force - after.energy, jump.energy_released, 1e-8)
    check(before.force, jump.force, 2e-2)  # dP/dd is infinite there for n > 2
    assert after.label == "detached"
    if name not in ("wedge", "parabola"):
        return
    pulled_in = getattr(dead, f"{name}_jump_in")(**args)
    state = minimise(scene, pulled_in.depth)
    check(state.force, 0.0, 1e-9, w)
    check(-state.energy, pulled_in.energy_released, 1e-9)
    K = 0.3 * (getattr(machine, f"{name}_critical_stiffness")(**args) or k * 0.02)
    on_machine = getattr(machine, f"{name}_detachment")(**args, K=K)
    if on_machine.half_width:
        h = 1e-4 * scene.critical_separation
        near = [minimise(scene, on_machine.depth + s * h).force for s in (-1, 1)]
        check((near[1] - near[0]) / (2 * h), -K, 1e-5)
        state = minimise(scene, on_machine.depth)
        check(state.energy + state.force**2 / (2 * K), on_machine.energy_released, 1e-9)
