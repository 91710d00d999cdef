"""The global minimum against enumeration, against known limits, and at size."""

import math

import numpy as np
import pytest
from lattices import Found, enumerated, over, pressed, random_lattice, unpruned
from scenes import adhesive, roughness

from discretization import NodalEnergy
from discretization.lattice import lowest
from discretization.lattice.judge import totals
from discretization.lattice.lowest import global_minimum, window
from discretization.nodes import ground
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Row
from energy import FlatPunch, Parabola, PowerLaw, Sampled, Wedge


@pytest.mark.parametrize("start", range(0, 300, 50))
def test_all_contact_sets_enumerated(start):
    untied = several = 0
    for seed in range(start, start + 50):
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
    assert untied >= 35
    assert several >= 5


@pytest.mark.parametrize("seed", range(8))
def test_nothing_is_lost_by_pruning(seed):
    rng = np.random.default_rng(seed)
    n, ell, delta = 80, 10 ** rng.uniform(-0.5, 2), 10 ** rng.uniform(-1, 0.5)
    f = roughness(n, n * rng.uniform(0.3, 1), 10 ** rng.uniform(0.3, 1.5), seed)
    lattice = Lattice(1.0, 0.0, 1.3, 1.3 * ell**2, 1.3 * delta**2 / 2)
    result = Found.of(lattice, rng.uniform(-0.2, 0.5) * f.max() - f)
    assert abs(result.energy - unpruned(lattice, result.g)) <= 1e-12 * result.proof.scale
    assert result.proof.violation <= 1e-13


def waves_and_tips(seed):
    """Lattice and nodes of spacing 1 where links adhere as they like."""
    rng = np.random.default_rng(seed)
    n, ell, delta = (
        int(rng.integers(15, 100)),
        10 ** rng.uniform(0.5, 2.3),
        10 ** rng.uniform(-1.5, 1),
    )
    h = 10 ** rng.uniform(-2, 0.7) * np.cos(
        np.arange(n) * rng.uniform(0.02, 0.6) + rng.uniform(0, 6)
    )
    h += 10 ** rng.uniform(-3, -0.3) * rng.normal(size=n).cumsum()
    h += rng.uniform(0.01, 0.3) - h.min()
    h *= np.where(rng.random(n) < rng.uniform(0, 0.6), rng.uniform(0.1, 1, n), 1.0)
    lattice = Lattice(1.0, 0.0, 1.3, 1.3 * ell**2, 1.3 * delta**2 / 2)
    adhere = rng.random(n) < rng.uniform(0.05, 1)
    bonds = np.where(adhere, 10 ** rng.uniform(-2, 1.5, n), 0.0) * lattice.w * lattice.spacing
    bonds[0] = 0.0
    return (
        lattice,
        h,
        lowest._chain(lattice, h * 1e-9)._replace(
            height=np.append(h, (0.0, 0.0)), bonds=np.append(bonds, (0.0, 0.0))
        ),
    )


def stiffness(lattice):
    """Of a node between two tails, half of it."""
    return lattice.spring / 2 + lattice.end_stiffness


def among_all_starts(lattice, h, bonds):
    """Least energy, comparing all lines in z = λ⁻²ˣ, y = h λ⁻ˣ that run below the nodes."""
    h, root = np.append(h, 0.0), np.exp(lattice.log_decay * np.arange(h.size + 1.0))
    root[-1] = 1e6 * root[-2]
    z, y, value = np.append(0, root**2), np.append(0, h * root), np.zeros(h.size + 1)
    for j in range(1, h.size + 1):
        slope = (y[j] - y[:j]) / (z[j] - z[:j])
        newer = np.append(np.maximum.accumulate(slope[:0:-1])[::-1], -math.inf)
        cost = stiffness(lattice) * slope * (y[j] - y[:j])
        cost[-1] -= bonds[j - 1]
        value[j] = (value[:j] + cost)[slope >= newer].min()
    return value[-1]


@pytest.mark.parametrize("few", [1, 32])
@pytest.mark.parametrize("far", [1.0, 300.0])
def test_the_starts_not_asked_are_not_the_best(few, far, monkeypatch):
    """Where links adhere as they like; hardly any starts are asked, and none far before."""
    monkeypatch.setattr(lowest, "_FEW", few)
    monkeypatch.setattr(lowest, "_FAR", far)
    for seed in range(300):
        lattice, h, chain = waves_and_tips(seed)
        truth = among_all_starts(lattice, h, chain.bonds)
        error = abs(lowest._cheapest(chain, 0.0)[0] - truth)
        assert error <= 1e-11 * max(abs(truth), stiffness(lattice) * h.max() ** 2), seed


def test_a_start_without_an_admissible_span_beats_no_other():
    """A walk that is pulled everywhere; one seed in two thousand shows it."""
    rng = np.random.default_rng(1937)
    n, ell = int(rng.integers(20, 90)), 10 ** rng.uniform(0, 1.8)
    depth = 10 ** rng.uniform(-1.5, 0)
    assert rng.random() < 0.5
    g = -0.3 - depth * np.abs(rng.normal(size=n).cumsum())
    lattice = Lattice(1.0, 0.0, 1.0, ell**2, 10 ** rng.uniform(-1, 1))
    result = Found.of(lattice, g)
    assert abs(result.energy - unpruned(lattice, g)) <= 1e-13 * result.proof.scale


@pytest.mark.parametrize("start", range(0, 40, 10))
def test_plateaus_and_tips(start):
    """Pulled surfaces under plateaus of different depth: tails and spans blocked by tips."""
    for seed in range(start, start + 10):
        rng = np.random.default_rng(seed)
        lattice = Lattice(1.0, 0.0, 1.3, 1.3 * rng.uniform(2, 8) ** 2, 0.65)
        widths = rng.choice([1, 2, 3, 8, 12], size=9)
        depths = rng.uniform(0.02, 0.9, size=9) + 3.0 * (np.arange(9) % 2)
        result = Found.of(lattice, -np.repeat(depths, widths))
        g, scale = result.g, result.proof.scale or lattice.w
        assert abs(result.energy - unpruned(lattice, g)) <= 1e-12 * scale
        assert (result.u() >= g - 1e-14).all()
        assert result.proof.violation <= 1e-13


def test_without_adhesion_it_is_the_convex_solution():
    for seed in range(5):
        f = roughness(3000, 300, 10, seed)
        lattice = Lattice(0.1, 0.0, 2.7, 2.7 * 30, 0.0)
        result = Found.of(lattice, 0.6 * f.max() - f)
        u, held = result.u(), result.in_contact
        force = NodalEnergy(lattice, held).gradient(u)
        scale = (lattice.spring + 4 * lattice.link) * np.abs(u).max()
        assert np.abs(force[~held]).max() <= 1e-14 * scale
        assert force[held].min() >= -1e-14 * scale
        assert (u - result.g).min() >= -1e-14 * np.abs(u).max()
        assert 10 < np.count_nonzero(held) < 2900


def test_flat_punch_leaves_where_its_energy_vanishes():
    """Before the metastable state does at -δ₀, near d = -δ₀ √(a/(a + l))."""
    scene = adhesive(FlatPunch(0.03))
    ell, delta = scene.elastocapillary_length, scene.critical_separation
    lattice = Lattice.of(scene, ell / 100)
    links = ground.region(lattice, scene.indenter, 0.0).last
    pull = lattice.spring * (links + 1) / 2 + lattice.end_stiffness
    leaves = -math.sqrt(lattice.w * lattice.spacing * links / pull)
    assert leaves == pytest.approx(-delta * math.sqrt(0.03 / (0.03 + ell)), rel=1e-2, abs=0)
    for factor, contacts in ((1 - 1e-9, [[0, links]]), (1 + 1e-9, [])):
        result = Found.of(lattice, np.full(links + 1, factor * leaves))
        assert result.contacts.tolist() == contacts


@pytest.mark.parametrize(("more", "contacts"), [(2e-13, [[0, 1]]), (2e-12, [])])
def test_of_equal_energies_the_one_with_more_contact(more, contacts):
    """Two nodes with an energy of 2 more wΔx; 1e-12 wΔx are a tie."""
    lattice = Lattice(1.0, 0.0, 1.3, 1.3 * 4.0, 0.2)
    leaves = -math.sqrt(lattice.w / (lattice.spring + lattice.end_stiffness))
    assert Found.of(lattice, np.full(2, leaves * (1 + more))).contacts.tolist() == contacts


@pytest.mark.parametrize("indenter", [Parabola(0.4), Wedge(0.01), PowerLaw(40.0, 3.0)])
@pytest.mark.parametrize("depth", [2e-4, 1e-3, 5e-3])
def test_a_pressed_convex_indenter_has_the_metastable_contact(indenter, depth):
    scene = adhesive(indenter)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 50)
    row = Row.of(scene, lattice, depth)
    start, g = window(row, depth)
    result = Found.of(lattice, g)
    contact = pressed(lattice, scene, depth)
    assert (result.contacts + row.first + start).tolist() == [list(contact)]
    sums = totals(over(lattice, indenter, depth, contact))
    assert abs(result.energy - sums.energy) <= 1e-13 * sums.energy_scale


def wavy(depth, n=801):
    """A lattice of spacing 1 in a scene with several contacts, and the scene."""
    x = np.arange(n) - n // 2 + 0.0
    f = 1e-4 * x**2 + 1.4 * (1 - np.cos(x / 10)) + 3e-3 * x
    scene = adhesive(Sampled(x, f - f.min()), k=1.3, gamma1=1.3 * 25.0, w=0.4)
    return Lattice.of(scene, 1.0, origin=0.0), scene


@pytest.mark.parametrize(("depth", "least"), [(-0.3, 1), (0.3, 3), (2.0, 4)])
def test_the_window_leaves_nothing_out_and_mirror_images_agree(depth, least):
    lattice, scene = wavy(depth)
    row = Row.of(scene, lattice, depth)
    start, g = window(row, depth)
    result = Found.of(lattice, g)
    whole = Found.of(lattice, depth - scene.indenter.z)
    scale = result.proof.scale
    assert g.size < 600
    assert len(result.contacts) >= least
    assert (whole.contacts - 400).tolist() == (result.contacts + row.first + start).tolist()
    assert abs(whole.energy - result.energy) <= 1e-13 * scale
    mirrored = Found.of(lattice, g[::-1])
    assert mirrored.contacts.tolist() == (g.size - 1 - result.contacts[::-1, ::-1]).tolist()
    assert abs(mirrored.energy - result.energy) <= 1e-13 * scale


def test_contacts_far_apart_do_not_feel_each_other():
    lattice = Lattice(1.0, 0.0, 1.7, 1.7 * 9.0, 0.9)
    i = np.arange(-60, 61)
    tip, blunt = 1.1 - 0.01 * i**2, -0.6 - 0.002 * i**2
    far = np.full(30 * 3, -50.0)
    one, two = (Found.of(lattice, g) for g in (tip, blunt))
    both = Found.of(lattice, np.concatenate([tip, far, blunt]))
    assert len(one.contacts) == len(two.contacts) == 1
    shift = tip.size + far.size
    assert both.contacts.tolist() == [*one.contacts.tolist(), *(two.contacts + shift).tolist()]
    assert abs(both.energy - one.energy - two.energy) <= 1e-13 * both.proof.scale


@pytest.mark.parametrize("length", [1e-9, 1e3])
@pytest.mark.parametrize("force", [1e-6, 1e6])
def test_no_unit_enters(length, force):
    f = roughness(800, 200, 6)
    g = 0.3 * f.max() - f
    one = Found.of(Lattice(1.0, 0.0, 1.7, 1.7 * 64, 0.2), g)
    k, gamma1, w = 1.7 * force / length**3, 1.7 * 64 * force / length, 0.2 * force / length
    other = Found.of(Lattice(length, 0.0, k, gamma1, w), g * length)
    assert len(one.contacts) > 3
    assert other.contacts.tolist() == one.contacts.tolist()
    assert abs(other.energy / force - one.energy) <= 1e-12 * one.proof.scale


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
    with pytest.raises(ValueError, match="gamma1"):
        global_minimum(Lattice(1.0, 0.0, 1.0, 0.0, 0.1), np.zeros(3))
    for g in (np.zeros(0), np.array([0.0, math.nan]), np.zeros((2, 2))):
        with pytest.raises(ValueError, match="g of shape"):
            global_minimum(Lattice(1.0, 0.0, 1.0, 1.0, 0.1), g)
