"""w = 0: the obstacle problem against enumeration, high precision, and its own conditions."""

import math
import os
from dataclasses import replace

import mpmath
import numpy as np
import pytest
from support.lattices import lattice, lowest, obstacle, rough_heights

from discretization.lattice.oracle import CLARABEL, oracle
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy

SIZES = (3, 16, 17, 300, 16**3 + 1, 20_000)  # blocks of 16 nodes


def profiles(rng, n):
    """Heights of different character, each above the surface somewhere."""
    x = np.linspace(-1, 1, n)
    return {
        "parabola": 0.5 - x**2,
        "cusp": 0.3 - np.sqrt(np.abs(x)),
        "tilted": 0.2 + 0.4 * x,
        "steps": 0.1 * np.sign(np.sin(9 * x + 1)),
        "waves": 0.2 + np.cos(40 * x) - 2 * x**2,
        "white": rng.normal(size=n) + 2,
        "rough": rough_heights(rng, n) + 0.2,
    }


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("ell", [0.01, 3.0, 200.0, 4e4])
def test_no_penetration_no_tension_and_balance(n, ell):
    rng = np.random.default_rng(n)
    lat = lattice(ell)
    for name, g in profiles(rng, n).items():
        found = obstacle(lat, g)
        u = found.u
        p = found.multipliers
        energy = NodalEnergy(lat, found.contact)
        noise = 1e-14 * (lat.spring_stiffness + lat.link_stiffness) * np.abs(g).max()
        assert (u >= g).all() and (p >= 0).all(), name
        assert (u[found.contact] == g[found.contact]).all() and found.contact.any(), name
        assert (p[~found.contact] == 0).all(), name
        assert np.abs(energy.gradient(u) - p).max() <= noise, name
        assert found.energy == pytest.approx(energy.value(u), rel=1e-12, abs=0), name
        force = lat.spring_stiffness * u.sum() + lat.end_stiffness * (u[0] + u[-1])
        assert found.force == pytest.approx(force, rel=1e-12, abs=0), name


def solve_exactly(lat, g, held):
    """u and nodal forces in 40 digits, held at g on some nodes: double sweep, exact ends."""
    mpmath.mp.dps = 40
    s = mpmath.mpf(lat.k) * lat.spacing
    t = mpmath.mpf(lat.gamma1) / lat.spacing
    end = t * (1 - mpmath.exp(-2 * mpmath.asinh(mpmath.sqrt(s / t) / 2)))
    n = g.size
    ratio = []
    shift = []
    for i in range(n):
        if held[i]:
            ratio.append(mpmath.mpf(0))
            shift.append(mpmath.mpf(g[i]))
            continue
        diagonal = s + (t if i < n - 1 else end) + (t * (1 - ratio[-1]) if i else end)
        ratio.append(t / diagonal)
        shift.append(t * shift[-1] / diagonal if i else mpmath.mpf(0))
    u = [mpmath.mpf(0)] * (n + 1)
    for i in reversed(range(n)):
        u[i] = shift[i] + (ratio[i] * u[i + 1] if i < n - 1 else 0)
    u = u[:n]
    left = [end * u[0]] + [t * (u[i] - u[i - 1]) for i in range(1, n)]
    right = [t * (u[i] - u[i + 1]) for i in range(n - 1)] + [end * u[-1]]
    return u, [s * u[i] + left[i] + right[i] for i in range(n)]


@pytest.mark.parametrize("ell", [2.0, 1e3, 1e6, 1e8])
def test_keeps_its_digits_as_l_over_spacing_grows(ell):
    lat = lattice(ell)
    two = np.full(400, -math.inf)
    two[50] = 0.3
    two[350] = 0.3 * (1 - 100 / ell)
    parabola = 0.3 - np.linspace(-1, 0.8, 400) ** 2
    for g in (two, parabola, rough_heights(np.random.default_rng(8), 400)):
        found = obstacle(lat, g)
        u, p = solve_exactly(lat, g, found.contact)
        scale = max(p)
        # the exact surface of that contact set penetrates and pulls nowhere: it is the minimum
        assert min(a - b for a, b in zip(u, g, strict=True)) >= 0
        assert min(p) >= -1e-30 * scale
        assert max(abs(a / b - 1) for a, b in zip(found.u, u, strict=True)) <= 2e-13
        wrong = max(abs(a - b) for a, b in zip(found.multipliers, p, strict=True))
        assert wrong <= 1e-13 * scale
        assert abs(found.force / sum(p) - 1) <= 1e-12


def test_without_tension_or_contact():
    g = np.array([-1.0, 0.5, 0.0, 0.25])
    found = obstacle(replace(lattice(3.0), gamma1=0.0), g)
    assert found.u.tolist() == [0, 0.5, 0, 0.25]
    assert found.contact.tolist() == [False, True, False, True]
    assert found.multipliers[1] == pytest.approx(37.0 * 0.03 * 0.5, rel=1e-14, abs=0)
    detached = obstacle(lattice(3.0), g - 0.5)
    assert not detached.u.any() and not detached.contact.any() and detached.force == 0


GAP = CLARABEL["tol_gap_rel"]
SCENES = int(os.environ.get("ORACLE_SCENES", "0"))
PROGRAMMES = np.linspace(100, 10_000, SCENES).astype(int).tolist() if SCENES else [100, 700, 2000]


def kkt_residual(lat, g, u, p):
    """Worst of penetration, tension, imbalance and complementarity, each relative to its scale."""
    force = np.abs(p).max()
    imbalance = np.abs(NodalEnergy(lat, np.zeros(g.size, bool)).gradient(u) - p).max()
    height = np.abs(g).max()
    gap = (u - g) / height
    worst = (-gap.min(), -p.min() / force, imbalance / force, (p / force * gap).max())
    return max(0.0, *worst)


@pytest.mark.parametrize("n", PROGRAMMES)
def test_obstacle_equals_the_convex_programme(n):
    rng = np.random.default_rng(n)
    lat = lattice(10 ** rng.uniform(-0.5, 2.5))
    g = rough_heights(rng, n, offset=rng.uniform(-1, 1))
    ours = obstacle(lat, g)
    theirs = oracle(lat, g)
    height = np.abs(g).max()
    force = ours.multipliers.max()
    assert theirs.energy == pytest.approx(ours.energy, rel=GAP, abs=0)
    # U(u) >= U(u*) + K (u_i - u_i*)²/2, K the stiffness of the surface at one node
    within = math.sqrt(2 * GAP * ours.energy / (lat.spring_stiffness + 2 * lat.end_stiffness))
    assert np.abs(theirs.u - ours.u).max() <= within
    assert np.abs(theirs.multipliers - ours.multipliers).max() <= 1e-3 * force
    residual = kkt_residual(lat, g, ours.u, ours.multipliers)
    assert residual <= 2e-15 * (1 + (lat.spring_stiffness + lat.link_stiffness) * height / force)
    assert residual < kkt_residual(lat, g, theirs.u, theirs.multipliers)


def adhesive_scene(rng, n, unit=1.0):
    """Lattice and heights (n,) at which attachment and detachment compete."""
    ell = 10 ** rng.uniform(-0.3, 1)
    height = 0.1 * unit
    lat = lattice(ell, spacing=0.03 * unit)
    g = height * (rng.normal(size=n).cumsum() / math.sqrt(n) + rng.uniform(-0.6, 0.6))
    w = lat.k * height**2 * 10 ** rng.uniform(-1.5, 0.5)
    return Lattice(lat.spacing, 0.0, lat.k, lat.gamma1, w), g


@pytest.mark.parametrize("seed", range(10))
def test_integers_equal_the_best_of_all_contact_sets(seed):
    pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    lat, g = adhesive_scene(np.random.default_rng(seed), 9)
    energy, _, u = lowest(lat, g)
    found = oracle(lat, g)
    scale = max(abs(energy), lat.w * lat.spacing)
    assert found.energy == pytest.approx(energy, rel=0, abs=1e-9 * scale)
    height = np.abs(g).max()
    assert np.abs(found.u - u).max() <= 1e-7 * height
    p = np.where(found.contact, NodalEnergy(lat, found.contact).gradient(found.u), 0)
    noise = 1e-6 * (np.abs(p).max() + lat.spring_stiffness * height)
    assert np.abs(found.multipliers - p).max() <= noise


def test_nodes_out_of_reach_change_nothing():
    pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    lat, g = adhesive_scene(np.random.default_rng(2), 9)
    low = g == g.min()
    energies = []
    for depth in (1e2, math.inf):
        found = oracle(lat, np.where(low, -depth, g))
        assert not found.contact[low].any()
        energies.append(found.energy)
    assert np.ptp(energies) <= 1e-9 * lat.w * lat.spacing


FLAT = lattice(3.0)
STICKY = lattice(3.0, w=1e-3)
SLACK = Lattice(0.03, 0.0, 37.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: oracle(SLACK, np.zeros(5)), "gamma1 = 0"),
        (lambda: oracle(STICKY, np.zeros(101)), "nodes = 101 is too many"),
        (lambda: oracle(FLAT, [1]), "g of shape"),
        (lambda: oracle(FLAT, [[1, 2]]), "g of shape"),
        (lambda: oracle(FLAT, [1, math.nan]), "g of shape"),
    ],
)
def test_the_programme_refuses(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_a_hundred_nodes_are_not_too_many_for_integers():
    pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    assert not oracle(STICKY, np.full(100, -1.0)).contact.any()


def test_the_programme_refuses_integers_without_a_solver(monkeypatch):
    import cvxpy

    monkeypatch.setattr(cvxpy, "installed_solvers", lambda: ["CLARABEL"])
    with pytest.raises(ValueError, match="pip install elastocap\\[test\\]"):
        oracle(STICKY, np.zeros(5))


def test_an_unsolved_programme_is_loud(monkeypatch):
    monkeypatch.setattr("discretization.lattice.oracle.CLARABEL", {"max_iter": 2})
    with pytest.warns(UserWarning, match="inaccurate"), pytest.raises(RuntimeError, match="status"):
        oracle(FLAT, rough_heights(np.random.default_rng(1), 40))
