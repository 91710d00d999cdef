"""The certificate of any number of contacts on the lattice, and the least energy of all sets."""

import math
from dataclasses import replace

import numpy as np
import pytest
from lattices import (
    displacement,
    mask_of,
    nodes_of,
    of_heights,
    over,
    random_lattice,
    unpruned,
)
from scenes import DELTA0, SCENE, L, adhesive, roughness, two

from discretization import Lattice, NodalEnergy
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.judge import judge, totals
from discretization.lattice.lowest import global_minimum
from discretization.lattice.state import on_lattice
from discretization.nodes import ground
from energy import Profile


def merged(nodes):
    return np.array([[nodes[0, 0], nodes[-1, 1]]])


def split(nodes):
    first, last = nodes[0]
    return np.concatenate([[[first, first + 1], [first + 3, last]], nodes[1:]])


MOVES = {
    "left line out": (lambda n: n + np.array([[-1, 0], [0, 0]]), {"neighbours"}),
    "left line in": (lambda n: n + np.array([[1, 0], [0, 0]]), {"neighbours"}),
    "inner line out": (lambda n: n + np.array([[0, 1], [0, 0]]), {"neighbours"}),
    "inner line in": (lambda n: n + np.array([[0, 0], [1, 0]]), {"neighbours"}),
    "right line out": (lambda n: n + np.array([[0, 0], [0, 1]]), {"neighbours"}),
    "merged": (merged, {"opening"}),
    "split": (split, {"neighbours", "penetration"}),
    "one alone": (lambda n: n[1:], {"penetration"}),
}


@pytest.mark.parametrize("name", MOVES)
def test_the_certificate_rejects_other_contact_sets(name):
    # pressed in deep and close together: neither contact can go
    scene, depth = adhesive(two(0.35 * L, 0.0006, 0.001, 5e-4)), 1.5e-3
    state = on_lattice(scene, depth, L / 1000, branch="global")
    lattice, nodes = nodes_of(state)
    assert len(nodes) == 2
    move, failures = MOVES[name]
    moved = over(lattice, scene.indenter, depth, *map(tuple, move(nodes).tolist()))
    assert set(judge(moved, totals(moved)).failures) == failures


def rough_lattice(seed):
    """Lattice, heights and |d| of a rough profile; l/Δx from 0.1 to 1e7."""
    rng = np.random.default_rng(seed)
    n, ell = int(10 ** rng.uniform(2, 2.7)), 10 ** rng.uniform(-1, 7)
    k, height = 10 ** rng.uniform(-3, 3, 2)
    w = k * (height * 10 ** rng.uniform(-1.5, 1.5)) ** 2 / 2 * (rng.random() > 0.2)
    f = roughness(n, n / 3, 10 ** rng.uniform(0.3, 1.5), seed)
    return Lattice(1.0, 0.0, k, k * ell**2, w), height * (rng.uniform(-1, 3) - f)


@pytest.mark.parametrize("scene", [random_lattice, rough_lattice])
def test_the_certificate_accepts_every_global_minimum(scene):
    judgements = 0
    for seed in range(100):
        lattice, g = scene(seed)
        ends, _ = global_minimum(lattice, g)
        if len(ends):
            contacts = of_heights(lattice, g, ends)
            certificate = judge(contacts, totals(contacts))
            assert certificate.ok, (seed, certificate)
            judgements += 1
    assert judgements >= 50


def crowded(seed):
    """Lattice and heights of a profile with teeth, near which adhesion is strong."""
    rng = np.random.default_rng(seed + 10**6)
    n, ell = int(rng.integers(4, 40)), 10 ** rng.uniform(-0.5, 1.5)
    f = np.abs(rng.normal(size=n)) ** rng.choice([0.5, 1, 2])
    lift = 10 ** rng.uniform(-0.7, 0.7)
    g = rng.uniform(-0.5, 1) * max(1, lift) - f
    return Lattice(1.0, 0.0, 2.0, 2.0 * ell**2, lift**2), g


# 1772: a tooth that two advancing lines bring into contact; at the others a line would gain energy
# by pushing the surface through a tooth
@pytest.mark.parametrize("seed", [1772, 3277, 3576, 4495, 5523, *range(40)])
def test_crowded_contacts_are_the_least_of_all_spans(seed):
    lattice, g = crowded(seed)
    ends, proof = global_minimum(lattice, g)
    rounding = 1e-12 * (proof.scale or 1.0)
    assert proof.attained == pytest.approx(unpruned(lattice, g), rel=0, abs=rounding)
    if len(ends):
        contacts = of_heights(lattice, g, ends)
        assert judge(contacts, totals(contacts)).ok


class Bent(ContactSet):
    """Contacts whose free surface is off at one node."""

    @property
    def u(self):
        u = super().u.copy()
        u[(self.nodes[0][1] + self.nodes[1][0]) // 2] += 1e-7 * DELTA0
        return u


def test_the_certificate_notices_force_and_balance():
    scene, depth = adhesive(two(0.6 * L, lift=5e-4)), 0.05 * DELTA0
    lattice, nodes = nodes_of(on_lattice(scene, depth, L / 100, branch="global"))
    contacts = over(lattice, scene.indenter, depth, *map(tuple, nodes.tolist()))
    sums = totals(contacts)
    assert judge(contacts, sums).ok
    assert judge(contacts, sums._replace(force=sums.force * (1 + 1e-7))).failures == ("force",)
    bent = Bent(contacts.row, contacts.nodes, depth)
    assert "stationarity" in judge(bent, totals(bent)).failures


def test_the_certificate_notices_a_tail_out_of_balance():
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1e-4)
    contacts = of_heights(lattice, [0.01, 0.01, 0.01], [[0, 2]])
    assert judge(contacts, totals(contacts)).ok
    vars(lattice).update(log_decay=lattice.log_decay * (1 + 1e-7))
    again = replace(contacts)
    assert "stationarity" in judge(again, totals(again)).failures


def test_one_node_relaxes():
    lattice = Lattice.of(SCENE, L / 3)
    assert NodalEnergy(lattice, [True]).relaxed([0.3]).tolist() == [0.3]
    assert NodalEnergy(lattice, [False]).relaxed([0.3]).tolist() == [0.0]


def test_the_searched_window_leaves_room_for_every_contact():
    """Heights of 1.4 δ₀ at the ends of the first window: clear of adhered, not of all contact."""
    lattice = Lattice.of(SCENE, L / 100)
    c = 1.4 * DELTA0 / (1024 * lattice.spacing) ** 2
    searched = Profile(lambda x: c * np.asarray(x) ** 2, lambda x: 2 * c * np.asarray(x))
    where = ground.region(lattice, searched, 0.0)
    ends = ground.heights(lattice, searched, np.array([where.first, where.last], float))
    assert ends.min() > lattice.deepest_contact


@pytest.mark.parametrize(("bonds", "failures"), [(1.5, {"neighbours"}), (2.5, set())])
def test_the_last_node_of_a_gap_closes_with_two_links(bonds, failures):
    """A notch that costs less than both links, or more."""
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1e-4)
    level = 0.01 * np.ones(13)
    held = np.arange(13) != 6
    lifted = displacement(lattice, level, held)[6]
    level[6] = lifted - math.sqrt(
        2 * bonds * lattice.w * lattice.spacing / (lattice.spring + 2 * lattice.link)
    )
    assert level[0] > lifted > level[6]
    contacts = of_heights(lattice, level, [[0, 5], [7, 12]])
    assert set(judge(contacts, totals(contacts)).failures) == failures


@pytest.mark.parametrize(("g", "failures"), [(0.01, ()), (-0.01, ("opening",))])
def test_a_lone_node_is_not_pulled(g, failures):
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1.0)
    contacts = of_heights(lattice, [-1.0, g, -1.0], [[1, 1]])
    assert judge(contacts, totals(contacts)).failures == failures


APART = [[0, 12], [17, 29]]


@pytest.mark.parametrize(("share", "failures"), [(0.99, set()), (1.01, {"opening"})])
@pytest.mark.parametrize("factor", [None, 1.0, 0.2, 0.0])
@pytest.mark.parametrize("ends", [APART, APART[:1]])
def test_a_node_in_contact_is_pulled_by_no_more_than_its_links_hold(share, factor, failures, ends):
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1e-4)
    g = 0.01 * np.ones(30)
    g[13:17] = -1.0
    stiffness = lattice.spring + 2 * lattice.link
    held = math.sqrt(4 * stiffness * lattice.w * (1.0 if factor is None else factor))
    pull = share * held if held else (share - 1) * lattice.spring * 1e-3
    g[6] -= (pull + lattice.spring * g[6]) / stiffness
    contacts = of_heights(lattice, g[: ends[-1][1] + 1], ends, factor=factor)
    assert set(judge(contacts, totals(contacts)).failures) == failures


@pytest.mark.parametrize(("off", "failures"), [(1e-5, set()), (-1e-5, {"opening"})])
@pytest.mark.parametrize("lone", [0, 1, 2])
def test_a_lone_node_among_contacts_is_not_pulled(off, failures, lone):
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1e-4)
    ends = [[4, 8], [13, 18], [23, 27]]
    ends[lone] = [ends[lone][0]] * 2
    held = mask_of(32, np.array(ends))
    g = np.where(held, 0.01, -1.0)
    others = held.copy()
    others[ends[lone][0]] = False
    g[ends[lone][0]] = displacement(lattice, g, others)[ends[lone][0]] + off
    contacts = of_heights(lattice, g, ends)
    assert set(judge(contacts, totals(contacts)).failures) == failures


@pytest.mark.parametrize("ends", [[[0, 7]], [[3, 9], [14, 14], [20, 27]], [[0, 5], [12, 30]]])
@pytest.mark.parametrize("kind", ["small", "round"])
@pytest.mark.parametrize("factor", [None, 0.3])
def test_totals_are_the_nodal_energy_of_any_contacts(ends, kind, factor):
    scene = adhesive(SCENE.indenter, w=0.02)
    if kind == "round":
        scene = replace(scene, geometry="axisymmetric")
    lattice = Lattice.of(scene, L / 7)
    g = 0.2 * L * (0.3 + np.random.default_rng(3).random(33))
    contacts = of_heights(lattice, g, ends, factor=None if kind == "round" else factor)
    sums, held = totals(contacts), mask_of(36, np.array(ends))
    model = NodalEnergy(lattice, held)
    u = model.relaxed(contacts.depth - contacts.row.f)
    terms, pressed = model.terms(u), model.gradient(u)[held].sum()
    terms["adhesion"] *= 1.0 if kind == "round" or factor is None else factor
    assert abs(sums.energy - sum(terms.values())) <= 1e-12 * sums.energy_scale
    assert sums.energy_scale == pytest.approx(sum(map(abs, terms.values())), rel=1e-12, abs=0)
    assert abs(sums.force_by_reactions - pressed) <= 1e-13 * sums.force_scale
    assert abs(sums.force - pressed) <= 1e-12 * sums.force_scale
