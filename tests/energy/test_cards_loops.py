"""Jumps and loops of the cards: by 50-digit energies and by quadrature of P(d)."""

import itertools

import mpmath as mp
import numpy as np
import pytest
from card_cases import KINDS, Case, decades, every, ratios
from hypothesis import given
from hypothesis import strategies as st
from scenes import check
from scipy.integrate import quad

from energy import cards

fixed, dead, machine, two = (
    cards.displacement_control,
    cards.load_control,
    cards.machine_control,
    cards.two_works,
)


def branch_work(case, start, top, stop):
    """∫P dd from start up to top and from there down to stop, by quadrature of the card's P(d)."""
    force = lambda d: case("force", max(d, case.least))  # noqa: E731

    def integral(p, q):
        points = [x for x in (0.0, case.q) if min(p, q) < x < max(p, q)]
        return quad(force, p, q, points=points or None, epsabs=0, epsrel=1e-11, limit=200)

    up, down = integral(start, top), integral(top, stop)
    return up[0] + down[0], abs(up[0]) + abs(down[0])


@pytest.mark.parametrize("seed", range(12))
def test_loop_areas_by_quadrature_of_both_branches(seed):
    rng = np.random.default_rng(seed)
    kind = ("wedge", "parabola", "1.5", "3.7")[seed % 4]
    ell, k, ratio, alpha = 10.0 ** rng.uniform([-4, -4, -0.7, -1], [4, 4, 0.2, 1])
    case = Case(kind, ell, alpha * ell, k, ratio, 1.0)
    name = case.name
    top = case.delta0 * rng.uniform(0.2, 2)
    area = getattr(fixed, f"{name}_loop_area")(**case.args)
    work, scale = branch_work(case, 0.0, top, case.least)
    check(area, work, 1e-9, scale)
    if case.n not in (1, 2) or name == "power_law":
        return
    start, stop = (getattr(dead, f"{name}_{x}")(**case.args) for x in ("jump_in", "detachment"))
    work, scale = branch_work(case, start.depth, start.depth + top, stop.depth)
    work += stop.force * (case.least - stop.depth)  # the load falls on to the end of the branch
    check(getattr(dead, f"{name}_loop_area")(**case.args), work, 1e-9, scale)
    K = case.stiffness(10 ** rng.uniform(-1, 1))
    start, stop = (
        getattr(machine, f"{name}_{x}")(**case.args, K=K) for x in ("jump_in", "detachment")
    )
    work, scale = branch_work(case, start.depth, start.depth + top, stop.depth)
    work += stop.force**2 / (2 * K) - K * start.depth**2 / 2  # along the lines of the spring
    check(getattr(machine, f"{name}_loop_area")(**case.args, K=K), work, 1e-9, scale)


@pytest.mark.parametrize(("a", "ell"), [(2.5e-3, 4e-5), (3e-5, 7e-4), (0.3, 0.0)])
def test_flat_punch_loop_and_maxwell_point(a, ell):
    k, w, K = 2.7e6, 0.043, 5.1e3
    args = {"a": a, "k": k, "gamma1": k * ell**2, "w": w}
    delta0, force = np.sqrt(2 * w / k), lambda d: cards.flat_punch.force(d, **args)
    first, last = fixed.flat_punch_jump_in(**args), fixed.flat_punch_detachment(**args)
    work = -quad(force, -delta0, 0.0, epsabs=0)[0]
    check(fixed.flat_punch_loop_area(**args), work, 1e-12)
    check(first.energy_released + last.energy_released, work, 1e-12)
    check(last.force, force(-delta0), 1e-14)
    check(last.depth, -delta0, 1e-14)
    assert dead.flat_punch_loop_area(**args) == fixed.flat_punch_loop_area(**args)
    on_machine = machine.flat_punch_detachment(**args, K=K)
    assert on_machine[:3] == last[:3]
    check(on_machine.energy_released - last.energy_released, last.force**2 / (2 * K), 1e-12)
    total = machine.flat_punch_loop_area(**args, K=K)
    check(total, work + last.force**2 / (2 * K), 1e-12)
    maxwell, energy = fixed.flat_punch_global_pull_off(**args), cards.flat_punch.energy
    check(energy(maxwell.depth, **args), 0.0, 1e-14, w * a)
    check(maxwell.force, force(maxwell.depth), 1e-14)
    assert maxwell.half_width == a
    narrower = {**args, "a": a * np.logspace(0, -9, 100)}
    way = energy(maxwell.depth, **narrower)  # the contact unzips under the face
    barrier = fixed.flat_punch_barrier(**args)
    check(barrier, max(way), 1e-6, 1e-3 * w * a)
    assert (np.diff(way) > 0).all() or ell == 0 == barrier


@pytest.mark.parametrize(("n", "c", "ell"), [(1.0, 0.04, 3e-4), (2.0, 1.7, 3e-4), (1.0, 0.4, 2e-4)])
@pytest.mark.parametrize("share", [0.0, 0.36])
def test_two_works_cycle_and_loop_by_quadrature(n, c, ell, share):
    k, w = 2.7e6, 2.3e-3
    layer = {"k": k, "gamma1": k * ell**2}
    args = {"c": c, "n": n, **layer, "w": w, "w_closing": share * w}
    delta0, f = np.sqrt(2 * w / k), lambda x: c * abs(x) ** n
    pinned = delta0 * (1 - np.sqrt(share))
    end = cards.power_law.detachment_depth(c=c, n=n, **layer, w=w)

    def force(d, a):
        return cards.force.total(d, a, f=f, **layer)

    def work(start, stop, a):  # Σ over the half-width the path has at each depth
        nodes, weights = np.polynomial.legendre.leggauss(40)
        d = (start + stop) / 2 + (stop - start) / 2 * nodes
        return (stop - start) / 2 * sum(v * force(x, a(x)) for x, v in zip(d, weights, strict=True))

    advancing = lambda d: two.half_widths(d, **args)[0]  # noqa: E731
    receding = lambda d: two.half_widths(max(d, end), **args)[1]  # noqa: E731
    for low, high in ((-0.2 * delta0, 3 * delta0), (0.1 * delta0, 0.6 * delta0)):
        if low < end:
            continue
        wide, narrow = advancing(high), receding(low)
        area = two.cycle_area(**args, d_min=low, d_max=high)
        if high - low <= pinned:
            assert area == 0
            continue
        tip = ell * c - delta0 if n == 1 else low  # P(d) has a kink where the line reaches the tip
        closing_tip = tip + pinned if n == 1 else low
        turn = [low, min(low + pinned, high)]
        way = work(*turn, lambda d: narrow)  # noqa: B023
        for p, q in segments(turn[1], high, closing_tip):
            way += work(p, q, advancing)
        way += work(high, high - pinned, lambda d: wide)  # noqa: B023
        for p, q in segments(high - pinned, low, tip):
            way += work(p, q, receding)
        check(area, way, 1e-9, w * (wide + ell))
    top = 2.4 * delta0
    tip, closing_tip = (ell * c - delta0, ell * c - delta0 + pinned) if n == 1 else (end, 0.0)
    wide = advancing(top)
    way = sum(work(p, q, advancing) for p, q in segments(0.0, top, closing_tip))
    way += work(top, top - pinned, lambda d: wide)
    way += sum(work(p, q, receding) for p, q in segments(top - pinned, end, tip))
    check(two.loop_area(**args, d_max=top), way, 1e-6, w * wide)


def segments(start, stop, kink):
    """start -> stop, cut at the kink if it lies between."""
    inside = min(start, stop) < kink < max(start, stop)
    points = [start, kink, stop] if inside else [start, stop]
    return list(itertools.pairwise(points))


def test_a_sharp_wedge_has_no_loop_and_no_adhesion_no_jump():
    sharp = {"delta": 0.31, "k": 2.7e6, "gamma1": 0.19, "w": 2.3e-3}
    K = {"K": 3.3e3}
    for event in ("jump_in", "detachment"):
        assert tuple(getattr(fixed, f"wedge_{event}")(**sharp)) == (0, 0, 0, 0)
        assert tuple(getattr(dead, f"wedge_{event}")(**sharp)) == (0, 0, 0, 0)
        assert tuple(getattr(machine, f"wedge_{event}")(**sharp, **K)) == (0, 0, 0, 0)
    assert machine.wedge_critical_stiffness(**sharp) == 0
    dry = {"k": 2.7e6, "gamma1": 0.19, "w": 0.0}
    for shape in ({"delta": 0.02}, {"R": 0.3}):
        name = "wedge" if "delta" in shape else "parabola"
        assert getattr(fixed, f"{name}_loop_area")(**shape, **dry) == 0
        assert getattr(dead, f"{name}_loop_area")(**shape, **dry) == 0
        assert getattr(machine, f"{name}_loop_area")(**shape, **dry, **K) == 0


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


def test_forms_quoted_for_the_paper_s_shapes():
    layer = {"k": 2.7e6, "gamma1": 0.19, "w": 2.3e-3}
    k, gamma1, w = layer.values()
    ell, delta0 = np.sqrt(gamma1 / k), np.sqrt(2 * w / k)
    t = np.tan(0.05)
    a0, q = delta0 / t - ell, ell * t - delta0
    wedge = {"delta": 0.05, **layer}
    pull = 2 * w / t - gamma1 * t  # Eq. (30)
    check(fixed.wedge_jump_in(**wedge).force, -pull, 1e-13)
    check(fixed.wedge_loop_area(**wedge), 2 * k * q**2 * (a0 / 3 + ell), 1e-13)
    m = np.sqrt(a0 * (a0 + 2 * ell))
    load = k * t**2 * (a0**2 * (a0 + 2 * ell) + 2 * m**3 / 3)
    check(dead.wedge_loop_area(**wedge), load, 1e-13)
    lets_go = machine.wedge_detachment(**wedge, K=0.3 * k * a0)
    check(lets_go.force, -pull + 0.09 * k * a0**2 * t / 4, 1e-12)
    for R in (0.9, 2e-4):  # Λ < 1 and > 1
        parabola, reach = {"R": R, **layer}, np.sqrt(R * delta0)
        a = np.sqrt(ell**2 + 2 * reach**2) - ell
        area = k * a**3 / R**2 * (a**2 / 5 + 3 * a * ell / 4 + 2 * ell**2 / 3)
        check(fixed.parabola_loop_area(**parabola), 2 * w * ell + area, 1e-12)
        x = (ell / reach) ** 3 / 2
        y = np.cos(np.arccos(x) / 3) if x < 1 else np.cosh(np.arccosh(x) / 3)
        jump = dead.parabola_jump_in(**parabola)
        check(jump.half_width, 2 * reach * y - ell, 1e-12, ell)  # the cubic, by Cardano
        a = jump.half_width
        shape = np.polyval([4, 23, 54, 60, 30], a / ell) * ell**4
        check(jump.energy_released, k * a**3 * shape / (45 * R**2 * (a + ell) ** 2), 1e-13)
        pull = 4 / 3 * k * np.sqrt(R) * delta0**1.5 + 2 / 3 * k * ell**3 / R
        pull = pull if reach > ell else 2 * np.sqrt(2 * w * gamma1)
        check(dead.parabola_detachment(**parabola).force, -pull, 1e-13)
    assert machine.parabola_critical_stiffness(R=0.9, k=k, gamma1=0.0, w=w) == np.inf
    assert machine.parabola_critical_stiffness(R=2e-4, **layer) == 0
    assert machine.parabola_critical_stiffness(R=0.9, k=k, gamma1=0.0, w=0.0) == 0
