"""Jumps and loops of the cards: by 50-digit energies and by quadrature of P(d)."""

import itertools
import math

import mpmath as mp
import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.integrate import quad
from support.card_cases import KINDS, Case, Exact, decades, every, ratios
from support.comparison import check

from energy import cards

fixed = cards.displacement_control
dead = cards.load_control
machine = cards.machine_control
two = cards.two_works


def branch_work(case, start, top, stop):
    """∫P dd from start up to top and from there down to stop, by quadrature of the card's P(d)."""
    force = lambda d: case("force", max(d, case.least))  # noqa: E731

    def integral(p, q):
        points = [x for x in (0.0, case.q) if min(p, q) < x < max(p, q)]
        return quad(force, p, q, points=points or None, epsabs=0, epsrel=1e-11, limit=200)

    up = integral(start, top)
    down = integral(top, stop)
    return up[0] + down[0], abs(up[0]) + abs(down[0])


@pytest.mark.parametrize("seed", range(12))
def test_loop_areas_by_quadrature_of_both_branches(seed):
    """And what a dead load does on to the end of the branch, or a machine along its spring."""
    rng = np.random.default_rng(seed)
    kind = ("wedge", "parabola", "1.5", "3.7")[seed % 4]
    ell, k, ratio, alpha = 10.0 ** rng.uniform([-4, -4, -0.7, -1], [4, 4, 0.2, 1])
    case = Case(kind, ell, alpha * ell, k, ratio, 1.0)
    top = case.delta0 * rng.uniform(0.2, 2)
    K = case.stiffness(10 ** rng.uniform(-1, 1))
    ways = [(fixed, {}, lambda start, stop: 0.0)]
    if case.name != "power_law":
        ways.append((dead, {}, lambda start, stop: stop.force * (case.least - stop.depth)))
        spring = lambda start, stop: stop.force**2 / (2 * K) - K * start.depth**2 / 2  # noqa: E731
        ways.append((machine, {"K": K}, spring))
    for control, more, beside in ways:
        start, stop, area = (
            getattr(control, f"{case.name}_{what}")(**case.args, **more)
            for what in ("jump_in", "detachment", "loop_area")
        )
        work, scale = branch_work(case, start.depth, start.depth + top, stop.depth)
        check(area, work + beside(start, stop), 1e-9, scale)
        check(area, start.energy_released + stop.energy_released, 1e-12)


@pytest.mark.parametrize(("a", "ell"), [(2.5e-3, 4e-5), (3e-5, 7e-4), (0.3, 0.0)])
def test_flat_punch_loop_and_maxwell_point(a, ell):
    k = 2.7e6
    w = 0.043
    K = 5.1e3
    args = {"a": a, "k": k, "gamma1": k * ell**2, "w": w}
    delta0 = np.sqrt(2 * w / k)

    def force(d):
        return cards.flat_punch.force(d, **args)

    first = fixed.flat_punch_jump_in(**args)
    last = fixed.flat_punch_detachment(**args)
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
    maxwell = fixed.flat_punch_global_pull_off(**args)
    energy = cards.flat_punch.energy
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
    k = 2.7e6
    w = 2.3e-3
    layer = {"k": k, "gamma1": k * ell**2}
    args = {"c": c, "n": n, **layer, "w": w, "w_closing": share * w}
    delta0 = np.sqrt(2 * w / k)

    def f(x):
        return c * abs(x) ** n

    pinned = delta0 * (1 - np.sqrt(share))
    end = cards.power_law.detachment_depth(c=c, n=n, **layer, w=w)
    nodes, weights = np.polynomial.legendre.leggauss(40)

    def work(start, stop, a, kink=math.nan):
        """∫P dd over the half-width that the path has at each depth, in parts at a kink of P."""
        inside = [kink] if min(start, stop) < kink < max(start, stop) else []
        total = 0.0
        for p, q in itertools.pairwise([start, *inside, stop]):
            d = (p + q) / 2 + (q - p) / 2 * nodes
            forces = cards.force.total(d, a(d), f=f, **layer)
            total += (q - p) / 2 * np.dot(weights, forces)
        return total

    advancing = lambda d: two.half_widths(d, **args)[0]  # noqa: E731
    receding = lambda d: two.half_widths(np.maximum(d, end), **args)[1]  # noqa: E731
    for low, high in ((-0.2 * delta0, 3 * delta0), (0.1 * delta0, 0.6 * delta0)):
        if low < end:
            continue
        wide = advancing(high)
        narrow = receding(low)
        area = two.cycle_area(**args, d_min=low, d_max=high)
        if high - low <= pinned:
            assert area == 0
            continue
        tip = ell * c - delta0 if n == 1 else low  # P(d) has a kink where the line reaches the tip
        way = work(low, low + pinned, lambda d: narrow)  # noqa: B023
        way += work(low + pinned, high, advancing, tip + pinned if n == 1 else low)
        way += work(high, high - pinned, lambda d: wide)  # noqa: B023
        check(area, way + work(high - pinned, low, receding, tip), 1e-9, w * (wide + ell))
    top = 2.4 * delta0
    tip, closing_tip = (ell * c - delta0, ell * c - delta0 + pinned) if n == 1 else (end, 0.0)
    wide = advancing(top)
    way = work(0.0, top, advancing, closing_tip) + work(top, top - pinned, lambda d: wide)
    way += work(top - pinned, end, receding, tip)
    check(two.loop_area(**args, d_max=top), way, 1e-6, w * wide)


def test_a_sharp_wedge_has_no_loop_and_no_adhesion_no_jump():
    sharp = {"delta": 0.31, "k": 2.7e6, "gamma1": 0.19, "w": 2.3e-3}
    assert machine.wedge_critical_stiffness(**sharp) == 0
    dry = {"k": 2.7e6, "gamma1": 0.19, "w": 0.0}
    critical = machine.parabola_critical_stiffness
    assert critical(R=0.9, k=2.7e6, gamma1=0.0, w=2.3e-3) == np.inf
    assert critical(R=2e-4, k=2.7e6, gamma1=0.19, w=2.3e-3) == 0
    assert critical(R=0.9, k=2.7e6, gamma1=0.0, w=0.0) == 0
    for control, more in ((fixed, {}), (dead, {}), (machine, {"K": 3.3e3})):
        for event in ("jump_in", "detachment"):
            assert tuple(getattr(control, f"wedge_{event}")(**sharp, **more)) == (0, 0, 0, 0)
        assert control.wedge_loop_area(delta=0.02, **dry, **more) == 0
        assert control.parabola_loop_area(R=0.3, **dry, **more) == 0


def random_cases(kinds):
    """Scenes of these kinds; lift is of no use here."""
    return st.builds(
        lambda kind, ell, alpha, k, ratio: Case(kind, ell, ell * alpha, k, ratio, 1.0),
        *(st.sampled_from(kinds), decades, ratios, decades, ratios),
    ).filter(lambda case: abs(case.q) > 1e-3 * case.delta0)  # tan δ = α has its own test


of_paper = random_cases(KINDS[:2])
shapes = random_cases(KINDS)
machines = st.floats(-3, 3).map(lambda e: 10.0**e)  # K/k in units of √(l δ₀)


@every
@given(shapes, machines)
def test_jump_in_ends_where_descent_does(case, ratio):
    """At imposed depth (K = None); for the paper's shapes on a machine and under a dead load."""
    kind = case.name
    K = case.stiffness(ratio)
    ways = [(getattr(fixed, f"{kind}_jump_in")(**case.args), None)]
    if case.kind in KINDS[:2]:
        ways.append((getattr(machine, f"{kind}_jump_in")(**case.args, K=K), K))
        ways.append((getattr(dead, f"{kind}_jump_in")(**case.args), 0.0))
    with mp.workdps(50):
        exact = Exact(case)
        loss = 1.0  # of digits in q = l tan δ - δ₀
        if case.n == 1 and exact.q != 0:
            loss = float((exact.ell * exact.c + exact.delta0) / abs(exact.q))
        for jump, k in ways:
            found = exact.jump_in(k if k is None else mp.mpf(k), jump.half_width or 1)
            a, d, force, released = map(float, found)
            for value, known in zip(jump, (0.0 if k == 0 else force, d, a, released), strict=True):
                check(value, known, 1e-13 * loss)


@every
@given(of_paper, machines)
def test_detachment_is_the_end_of_stability(case, ratio):
    kind = case.name
    K = case.stiffness(ratio)
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
            d = exact.depth(a)
            end = exact.end
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


@pytest.mark.parametrize(("control", "more"), [(fixed, {}), (dead, {}), (machine, {"K": 3e3})])
def test_at_the_sharpest_wedge_that_pulls_everything_vanishes(control, more):
    for delta in np.linspace(0.1, 0.5, 40):  # tan δ = α up to rounding, either side
        args = {"delta": delta, "k": 2.7e6, "gamma1": 0.19, "w": 0.19 * np.tan(delta) ** 2 / 2}
        for event in ("jump_in", "detachment"):
            jump = getattr(control, f"wedge_{event}")(**args, **more)
            check(jump.force, 0.0, 1e-7, 0.19)
            check(jump.half_width, 0.0, 1e-7, 3e-4)
            check(jump.energy_released, 0.0, 1e-14, 0.19 * 3e-4)
            assert jump.energy_released >= 0
