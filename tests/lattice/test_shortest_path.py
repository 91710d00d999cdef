"""The global minimum against enumeration, against known limits, and at size."""

import math

import numpy as np
import pytest
from lattices import (
    Found,
    crowded,
    enumerated,
    of_heights,
    plateaus,
    pulled_walk,
    random_lattice,
    rough_row,
    unpruned,
)
from scenes import adhesive, roughness

from discretization import NodalEnergy
from discretization.lattice.judge import judge, totals
from discretization.lattice.lowest import global_minimum
from discretization.nodes.lattice import Lattice
from energy import Sampled


@pytest.mark.parametrize("start", range(0, 120, 40))
def test_no_contact_set_has_less_energy(start):
    """All of them, one by one; and the certificate accepts the one that is found."""
    untied = several = 0
    for seed in range(start, start + 40):
        lattice, g = random_lattice(seed)
        sets, energy = enumerated(lattice, g)
        result = Found.of(lattice, g)
        ours = np.flatnonzero((sets == result.in_contact).all(axis=1))[0]
        model = NodalEnergy(lattice, sets[np.argmin(energy)])
        u = model.relaxed(g)
        scale = sum(map(abs, model.terms(u).values())) or lattice.spring * np.max(g**2)
        least = energy.min()
        assert abs(model.value(u) - least) <= 1e-11 * scale, seed
        assert abs(result.energy - least) <= 1e-10 * scale, seed
        assert abs(energy[ours] - least) <= 1e-13 * scale, seed
        assert (result.u() >= g - 1e-12 * np.abs(g).max()).all(), seed
        assert result.proof.violation <= 1e-13, seed
        if np.count_nonzero(energy <= least + 1e-9 * scale) == 1:
            untied += 1
            assert ours == np.argmin(energy), seed
        several += len(result.contacts) > 1
        assert_certified(lattice, g, result.contacts, seed)
    assert untied >= 25 and several >= 3


def assert_certified(lattice, g, ends, seed):
    if len(ends):
        contacts = of_heights(lattice, g, ends)
        assert judge(contacts, totals(contacts)).ok, seed


@pytest.mark.parametrize(
    ("draw", "seeds"),
    [
        (rough_row, range(8)),
        (plateaus, range(40)),
        # 1772: a tooth that two advancing lines bring into contact; at the next four a line would
        # gain energy by pushing the surface through a tooth
        (crowded, [1772, 3277, 3576, 4495, 5523, *range(40)]),
        (pulled_walk, [1937]),  # a start without an admissible span beats no other
    ],
)
def test_no_admissible_spans_have_less_energy(draw, seeds):
    """All pairs of nodes, in an order in which nothing is left out."""
    for seed in seeds:
        lattice, g = draw(seed)
        result = Found.of(lattice, g)
        scale = result.proof.scale or lattice.w or 1.0
        assert abs(result.energy - unpruned(lattice, g)) <= 1e-12 * scale, seed
        assert (result.u() >= g - 1e-13 * np.abs(g).max()).all(), seed
        assert result.proof.violation <= 1e-13, seed
        assert_certified(lattice, g, result.contacts, seed)


@pytest.mark.parametrize(("more", "contacts"), [(2e-13, [[0, 1]]), (2e-12, [])])
def test_of_equal_energies_the_one_with_more_contact(more, contacts):
    """Two nodes with an energy of 2 more wΔx; 1e-12 wΔx are a tie."""
    lattice = Lattice(1.0, 0.0, 1.3, 1.3 * 4.0, 0.2)
    leaves = -math.sqrt(lattice.w / (lattice.spring + lattice.end_stiffness))
    assert Found.of(lattice, np.full(2, leaves * (1 + more))).contacts.tolist() == contacts


def wavy(depth, n=801):
    """A lattice of spacing 1 in a scene with several contacts, and the scene."""
    x = np.arange(n) - n // 2 + 0.0
    f = 1e-4 * x**2 + 1.4 * (1 - np.cos(x / 10)) + 3e-3 * x
    scene = adhesive(Sampled(x, f - f.min()), k=1.3, gamma1=1.3 * 25.0, w=0.4)
    return Lattice.of(scene, 1.0, origin=0.0), scene


@pytest.mark.parametrize(("depth", "least"), [(-0.3, 1), (0.3, 3), (2.0, 4)])
def test_nodes_out_of_reach_change_nothing_and_mirror_images_agree(depth, least):
    lattice, scene = wavy(depth)
    whole = Found.of(lattice, depth - scene.indenter.z)
    near = np.flatnonzero(whole.g >= -lattice.deepest_contact)
    start, g = near[0], whole.g[near[0] : near[-1] + 1]
    result = Found.of(lattice, g)
    scale = result.proof.scale
    assert g.size < 600
    assert len(result.contacts) >= least
    assert whole.contacts.tolist() == (result.contacts + start).tolist()
    assert abs(whole.energy - result.energy) <= 1e-13 * scale
    mirrored = Found.of(lattice, g[::-1])
    assert mirrored.contacts.tolist() == (g.size - 1 - result.contacts[::-1, ::-1]).tolist()
    assert abs(mirrored.energy - result.energy) <= 1e-13 * scale


@pytest.mark.parametrize("ell", [1e-3, 1.0, 1e2, 1e4])
def test_rough_profiles_are_certified(ell):
    f = roughness(6000, 600, 10)
    for depth, delta in ((0.4, 0.3), (-0.01, 0.5), (0.2, 1.0)):
        lattice = Lattice(1.0, 0.0, 1.0, ell**2, delta**2 / 2)
        result = Found.of(lattice, depth * f.max() - f)
        assert result.proof.violation <= 1e-13 * max(1, ell / 1e2)
        assert (result.u() - result.g).min() >= -1e-13 * f.max()
        assert result.energy <= 1e-15 * result.proof.scale or depth > 0


def test_one_hundred_thousand_nodes():
    f = roughness(10**5, 2000, 20)
    result = Found.of(Lattice(1.0, 0.0, 1.0, 1e4, 0.045), 0.4 * f.max() - f)
    assert len(result.contacts) > 100
    assert result.proof.violation <= 1e-13


def test_what_it_cannot_answer_is_refused():
    for g in (np.zeros(0), np.array([0.0, math.nan]), np.zeros((2, 2))):
        with pytest.raises(ValueError, match="g of shape"):
            global_minimum(Lattice(1.0, 0.0, 1.0, 1.0, 0.1), g)
