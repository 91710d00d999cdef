"""The eliminated tails of finite slopes on the lattice, against chains of nodes."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from lattices import over
from scenes import adhesive, steep

from discretization import Lattice, NodalEnergy
from discretization.lattice.tails import tail_response
from discretization.lattice.totals import totals
from energy import Parabola


@pytest.mark.parametrize("h", [0.02, 0.3, 4.0])
def test_the_collocated_tail_is_a_long_chain_of_nodes(h):
    """Reaction, energy and nodes against Newton's method on all of them."""
    scene = steep(Parabola(0.02))
    ell = scene.elastocapillary_length
    lattice = Lattice.of(scene, h * ell)
    held = np.zeros(int(40 / min(h, 1.0)) + 5, bool)
    held[0] = True
    chain, end = NodalEnergy(lattice, held), NodalEnergy(lattice, held[:1])
    for share in (1e-3, 0.4, -0.9, 1.3, -1.3):
        g = np.where(held, share * ell, 0.0)
        u = chain.relaxed(g)
        assert chain.value(u) == pytest.approx(end.value(g[:1]), rel=1e-12, abs=0)
        assert chain.gradient(u)[0] == pytest.approx(end.gradient(g[:1])[0], rel=1e-12, abs=0)
        decayed = lattice.tail.displacement(lattice.spacing * np.arange(held.size), g[0])
        assert np.abs(u - decayed).max() <= 1e-12 * abs(g[0])


def test_the_tail_keeps_its_digits_for_any_ratio_of_length_to_spacing():
    """Its own balance, and the first integral 1 - cos φ = u²/2 as the spacing vanishes."""
    for h in 10.0 ** np.arange(-9, 4):
        tail = tail_response(h)
        u = np.linspace(-1.3, 1.3, 53)
        after, pull = tail.after(u), tail.reaction(u)
        balance = h * after + tail.reaction(after) - pull
        assert np.abs(balance).max() <= 1e-14 * np.max(np.abs(pull) + h * np.abs(u))
        level = tail.parting(u, 0 * u)  # a node as high as the last: only its spring counts
        assert np.abs(level + u).max() <= 1e-13
        if h <= 1e-3:
            phi = 2 * np.arcsin(u / 2)
            assert np.abs(pull + h * u / 2 - np.sin(phi)).max() <= 50 * h**2 + 1e-14
            slope = math.log1p(-h * tail.fall(np.array(1e-9)) / 1e-9) / h * tail.steepness(u)
            assert np.abs(np.arctan(slope) + phi).max() <= 50 * h**2 + 2e-7


@pytest.mark.parametrize("scene", [steep(Parabola(0.02), 0.5), adhesive(Parabola(0.02))])
def test_an_advance_changes_energy_and_force_as_two_relaxed_chains_say(scene):
    lattice = Lattice.of(scene, scene.elastocapillary_length / 8)
    nodes = np.arange(-40, 41)
    f = scene.indenter.height(lattice.x(nodes))
    for last, depth in itertools.product((3, 9), (1e-3, -5e-3)):
        i = last + 40
        values, forces = [], []
        for end in (last, last + 1):
            energy = NodalEnergy(lattice, (nodes >= -2) & (nodes <= end))
            u = energy.relaxed(depth - f)
            values.append(energy.value(u))
            forces.append(energy.gradient(u)[energy.contact].sum())
        move = f[i], f[i + 1], depth
        assert abs(lattice.advance_cost(lattice.critical_gap)) <= 1e-13 * scene.gamma1
        change, size = values[1] - values[0], scene.gamma1 * lattice.spacing
        _, energy, force = lattice.advance(*move)
        assert energy == pytest.approx(change, rel=0, abs=1e-11 * size)
        expected = forces[1] - forces[0]
        assert force == pytest.approx(expected, rel=0, abs=1e-13 * scene.gamma1)


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_nodal_energy_derivatives(slopes):
    scene = replace(steep(Parabola(0.02)), slopes=slopes)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 5)
    rng, size = np.random.default_rng(3), 12
    u = rng.uniform(-0.5, 0.5, size) * scene.elastocapillary_length
    energy, step = NodalEnergy(lattice, np.arange(size) % 5 > 1), 1e-5 * np.abs(u).max()
    band = energy.hessian(u)
    hessian = np.diag(band[0]) + np.diag(band[1, :-1], -1) + np.diag(band[1, :-1], 1)
    for i, unit in enumerate(step * np.eye(size)):
        slope = (energy.value(u + unit) - energy.value(u - unit)) / (2 * step)
        assert slope == pytest.approx(energy.gradient(u)[i], rel=1e-6, abs=1e-8 * scene.gamma1)
        change = (energy.gradient(u + unit) - energy.gradient(u - unit)) / (2 * step)
        assert np.abs(change - hessian[i]).max() <= 1e-7 * hessian[i, i]


@pytest.mark.parametrize("indenter", [Parabola(0.02), Parabola(0.02).tilted(0.1)])
def test_blocked_sums_are_the_nodal_energy(indenter):
    scene = steep(indenter)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 100, origin=0.0)
    u = 2e-3 - indenter.height(lattice.x(np.arange(-90, 71.0)))
    sums = totals(over(lattice, indenter, 2e-3, (-90, 70)))
    energy = NodalEnergy(lattice, np.ones(u.size, bool))
    for name, value in energy.terms(u).items():
        assert getattr(sums, name) == pytest.approx(value, rel=1e-12, abs=0)
    force = energy.gradient(u).sum()
    assert sums.force_by_reactions == pytest.approx(force, rel=1e-12, abs=0)
    assert sums.force == pytest.approx(force, rel=1e-12, abs=0)
    steepest = np.abs(np.diff(u)).max() / lattice.spacing
    assert sums.stiffness == pytest.approx(
        lattice.link / (1 + steepest**2) ** 1.5, rel=1e-13, abs=0
    )
