"""The lattice programmes in cvxpy against our own minimisers and against enumeration.

ORACLE_SCENES=50 in the environment compares that many random rough scenes of up to 10⁴ nodes.
"""

import math
import os

import numpy as np
import pytest
from lattices import lattice, lowest, obstacle, rough_heights
from scenes import adhesive

from discretization.lattice.oracle import CLARABEL, Oracle
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from energy import Parabola

GAP = CLARABEL["tol_gap_rel"]
SCENES = int(os.environ.get("ORACLE_SCENES", "0"))
SIZES = np.linspace(100, 10_000, SCENES).astype(int).tolist() if SCENES else [100, 700, 2000]


def kkt_residual(lat, g, u, p):
    """Worst of penetration, tension, imbalance and complementarity, each relative to its scale."""
    force = np.abs(p).max()
    imbalance = np.abs(NodalEnergy(lat, np.zeros(g.size, bool)).gradient(u) - p).max()
    height = np.abs(g).max()
    gap = (u - g) / height
    worst = (-gap.min(), -p.min() / force, imbalance / force, (p / force * gap).max())
    return max(0.0, *worst)


@pytest.mark.parametrize("n", SIZES)
def test_obstacle_equals_the_convex_programme(n):
    rng = np.random.default_rng(n)
    lat, g = lattice(10 ** rng.uniform(-0.5, 2.5)), rough_heights(rng, n, offset=rng.uniform(-1, 1))
    ours, theirs = obstacle(lat, g), Oracle(lat, n).solve(g)
    height, force = np.abs(g).max(), ours.multipliers.max()
    assert theirs.energy == pytest.approx(ours.energy, rel=GAP, abs=0)
    # U(u) >= U(u*) + K (u_i - u_i*)²/2, K the stiffness of the surface at one node
    within = math.sqrt(2 * GAP * ours.energy / (lat.spring + 2 * lat.end_stiffness))
    assert np.abs(theirs.u - ours.u).max() <= within
    assert np.abs(theirs.multipliers - ours.multipliers).max() <= 1e-3 * force
    residual = kkt_residual(lat, g, ours.u, ours.multipliers)
    assert residual <= 2e-15 * (1 + (lat.spring + lat.link) * height / force)
    assert residual < kkt_residual(lat, g, theirs.u, theirs.multipliers)


def adhesive_scene(rng, n, unit=1.0):
    """Lattice and heights (n,) at which attachment and detachment compete."""
    ell, height = 10 ** rng.uniform(-0.3, 1), 0.1 * unit
    lat = lattice(ell, spacing=0.03 * unit)
    g = height * (rng.normal(size=n).cumsum() / math.sqrt(n) + rng.uniform(-0.6, 0.6))
    w = lat.k * height**2 * 10 ** rng.uniform(-1.5, 0.5)
    return Lattice(lat.spacing, 0.0, lat.k, lat.gamma1, w), g


@pytest.mark.parametrize("seed", range(10))
def test_integers_equal_the_best_of_all_contact_sets(seed):
    pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    lat, g = adhesive_scene(np.random.default_rng(seed), 9)
    energy, _, u = lowest(lat, g)
    found = Oracle(lat, 9).solve(g)
    scale = max(abs(energy), lat.w * lat.spacing)
    assert found.energy == pytest.approx(energy, rel=0, abs=1e-9 * scale)
    height = np.abs(g).max()
    assert np.abs(found.u - u).max() <= 1e-7 * height
    p = np.where(found.contact, NodalEnergy(lat, found.contact).gradient(found.u), 0)
    noise = 1e-6 * (np.abs(p).max() + lat.spring * height)
    assert np.abs(found.multipliers - p).max() <= noise


def test_integers_know_no_units():
    pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    lat, g = adhesive_scene(np.random.default_rng(2), 16)
    here = Oracle(lat, 16).solve(g)
    assert 0 < here.contact.sum() < 16
    for unit, stress in ((1e-6, 3e4), (1e3, 1e-6)):
        k, w = lat.k * stress / unit, lat.w * stress * unit
        there = Lattice(lat.spacing * unit, 0.0, k, lat.gamma1 * stress * unit, w)
        found = Oracle(there, 16).solve(g * unit)
        assert np.array_equal(found.contact, here.contact)
        assert np.allclose(found.u / unit, here.u, rtol=0, atol=1e-9 * np.abs(g).max())
        assert found.energy == pytest.approx(here.energy * stress * unit**2, rel=1e-8, abs=0)


def test_nodes_out_of_reach_change_nothing():
    pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    lat, g = adhesive_scene(np.random.default_rng(2), 9)
    low = g == g.min()
    energies = []
    for depth in (1e2, math.inf):
        found = Oracle(lat, 9).solve(np.where(low, -depth, g))
        assert not found.contact[low].any()
        energies.append(found.energy)
    assert np.ptp(energies) <= 1e-9 * lat.w * lat.spacing


def test_scene():
    scene = adhesive(Parabola(0.3), w=0.0)
    oracle = Oracle(Lattice.of(scene, 0.004), 81)
    g = 0.02 - oracle.lattice.x(np.arange(-40, 41)) ** 2 / 0.6
    ours, theirs = obstacle(oracle.lattice, g), oracle.solve(g)
    assert np.array_equal(theirs.contact, ours.contact)
    assert theirs.multipliers.sum() == pytest.approx(ours.force, rel=1e-7, abs=0)


FLAT, STICKY = lattice(3.0), lattice(3.0, w=1e-3)
SLACK = Lattice(0.03, 0.0, 37.0, 0.0, 0.0)


@pytest.mark.parametrize(
    ("make", "message"),
    [
        (lambda: Oracle(SLACK, 5), "gamma1 = 0"),
        (lambda: Oracle(STICKY, 10**4), "nodes = 10000 is too many"),
        (lambda: Oracle(FLAT, 1), "nodes = 1 must"),
        (lambda: Oracle(FLAT, 3).solve([1, 2]), "g must be"),
        (lambda: Oracle(FLAT, 2).solve([1, math.nan]), "g must be"),
    ],
)
def test_refuses(make, message):
    with pytest.raises(ValueError, match=message):
        make()


def test_refuses_integers_without_a_solver(monkeypatch):
    import cvxpy

    monkeypatch.setattr(cvxpy, "installed_solvers", lambda: ["CLARABEL"])
    with pytest.raises(ValueError, match="pip install elastocap\\[test\\]"):
        Oracle(STICKY, 5)


def test_an_unsolved_programme_is_loud(monkeypatch):
    monkeypatch.setattr("discretization.lattice.oracle.CLARABEL", {"max_iter": 2})
    with pytest.warns(UserWarning, match="inaccurate"), pytest.raises(RuntimeError, match="status"):
        Oracle(FLAT, 40).solve(rough_heights(np.random.default_rng(1), 40))
