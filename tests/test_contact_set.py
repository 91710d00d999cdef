"""The certificate of any number of contacts on the lattice, and the least energy of all sets."""

import math
from dataclasses import replace

import numpy as np
import pytest
from lattices import nodes_of, of_heights, random_lattice, unpruned
from scenes import DELTA0, SCENE, L, adhesive, roughness, two

from discretization import Lattice, NodalEnergy
from discretization.lattice import fronts
from discretization.lattice.bounds import deepest_contact
from discretization.lattice.contact_set import ContactSet, judged, totals
from discretization.lattice.judgement import certify
from discretization.lattice.obstacle import obstacle
from discretization.lattice.shortest_path import global_minimum
from discretization.lattice.state import on_lattice
from discretization.lattice.sums import measured
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
    where = fronts.region(lattice, scene.indenter, depth)
    move, failures = MOVES[name]
    moved = ContactSet.of(lattice, scene.indenter, depth, where, move(nodes))
    assert set(judged(moved, totals(moved)).failures) == failures


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
        ends = global_minimum(lattice, g, margin=False).contacts
        if len(ends):
            contacts = of_heights(lattice, g, ends)
            certificate = judged(contacts, totals(contacts))
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
    found = global_minimum(lattice, g, margin=False)
    rounding = 1e-12 * (found.proof.scale or 1.0)
    assert found.proof.attained == pytest.approx(unpruned(lattice, g), rel=0, abs=rounding)
    if len(found.contacts):
        contacts = of_heights(lattice, g, found.contacts)
        assert judged(contacts, totals(contacts)).ok


def test_the_certificate_notices_force_and_balance():
    scene, depth = adhesive(two(0.6 * L, lift=5e-4)), 0.05 * DELTA0
    lattice, nodes = nodes_of(on_lattice(scene, depth, L / 100, branch="global"))
    where = fronts.region(lattice, scene.indenter, depth)
    contacts = ContactSet.of(lattice, scene.indenter, depth, where, nodes)
    sums = totals(contacts)
    assert judged(contacts, sums).ok
    assert judged(contacts, sums._replace(force=sums.force * (1 + 1e-7))).failures == ("force",)
    middle = int(contacts.ends[0, 1] + contacts.ends[1, 0]) // 2
    u = contacts.u.copy()
    u[middle] += 1e-7 * contacts.scale
    shifted = replace(contacts)
    shifted.__dict__["u"] = u
    assert "stationarity" in judged(shifted, sums).failures


def test_a_single_contact_is_judged_alike_by_both_certificates():
    for depth in (-0.3 * DELTA0, 0.0, DELTA0):
        lattice = Lattice.of(SCENE, L / 100)
        where = fronts.region(lattice, SCENE.indenter, depth)
        found = fronts.adhered(lattice, SCENE.indenter, depth, where)
        for change in (0, 3):
            nodes = found._replace(last=found.last + change)
            sums = measured(lattice, SCENE.indenter, depth, nodes)
            contacts = ContactSet.of(
                lattice, SCENE.indenter, depth, where, np.array([[nodes.first, nodes.last]])
            )
            ours = totals(contacts)
            for name in ("force", "force_by_reactions", "energy"):
                scale = sums.energy_scale if name == "energy" else sums.force_scale
                assert abs(getattr(ours, name) - getattr(sums, name)) <= 1e-12 * scale
            one = certify(lattice, SCENE.indenter, depth, where, nodes, sums)
            assert judged(contacts, ours).failures == one.failures


def test_one_node_relaxes():
    lattice = Lattice.of(SCENE, L / 3)
    assert NodalEnergy(lattice, [True]).relaxed([0.3]).tolist() == [0.3]
    assert NodalEnergy(lattice, [False]).relaxed([0.3]).tolist() == [0.0]


def test_finite_slopes_are_no_obstacle_problem():
    scene = adhesive(SCENE.indenter, w=0.0, slopes="finite")
    with pytest.raises(ValueError, match="slopes = 'finite'"):
        obstacle(Lattice.of(scene, L / 10), [1e-3])


def test_the_searched_window_leaves_room_for_every_contact():
    """Heights of 1.4 δ₀ at the ends of the first window: clear of adhered, not of all contact."""
    lattice = Lattice.of(SCENE, L / 100)
    c = 1.4 * DELTA0 / (1024 * lattice.spacing) ** 2
    searched = Profile(lambda x: c * np.asarray(x) ** 2, lambda x: 2 * c * np.asarray(x))
    where = fronts.region(lattice, searched, 0.0)
    ends = fronts.heights(lattice, searched, np.array([where.first, where.last], float))
    assert ends.min() > deepest_contact(lattice)


@pytest.mark.parametrize(("bonds", "failures"), [(1.5, {"neighbours"}), (2.5, set())])
def test_the_last_node_of_a_gap_closes_with_two_links(bonds, failures):
    """A notch that costs less than both links, or more."""
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1e-4)
    level = 0.01 * np.ones(13)
    smooth = of_heights(lattice, level, [[0, 12]]).u
    split = of_heights(lattice, np.where(np.arange(13) == 6, -1.0, level), [[0, 5], [7, 12]])
    stiffness = lattice.spring + 2 * lattice.link
    level[6] = split.u[22] - math.sqrt(2 * bonds * lattice.w * lattice.spacing / stiffness)
    assert smooth[22] == 0.01 > split.u[22]
    contacts = of_heights(lattice, level, [[0, 5], [7, 12]])
    assert set(judged(contacts, totals(contacts)).failures) == failures


@pytest.mark.parametrize(("g", "failures"), [(0.01, ()), (-0.01, ("opening",))])
def test_a_lone_node_is_not_pulled(g, failures):
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1.0)
    contacts = of_heights(lattice, [-1.0, g, -1.0], [[1, 1]])
    assert judged(contacts, totals(contacts)).failures == failures
