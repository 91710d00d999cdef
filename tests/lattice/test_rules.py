"""The depths of changes on the lattice: where the energies of both contact sets are equal."""

from types import SimpleNamespace

import numpy as np
import pytest
from lattices import lattice
from scenes import plain

from discretization import NodalEnergy, minimise
from discretization.lattice.walk import Walk, parts_of
from discretization.nodes.rules import Rules
from discretization.nodes.waiting import advances, held_nodes
from energy import Profile

NODES = 40
HELD = [(6, 12), (18, 24)]  # a gap of six links


def case(seed, ell=4.0):
    """Rules for random heights, each with the depth in sight of its contacts."""
    rng = np.random.default_rng(seed)
    return rules_of(lattice(ell, w=2e-3), 0.01 * rng.normal(size=NODES).cumsum() / 6)


def rules_of(lattice, f):
    """Rules of one work of adhesion."""
    return Rules(lattice, f, np.full(f.size - 1, lattice.w * lattice.spacing))


def energy(rules, contacts, depth):
    """U of these contacts at a depth, its terms' size, and u - g."""
    held = np.zeros(NODES, bool)
    for first, last in contacts:
        held[first : last + 1] = True
    model, g = NodalEnergy(rules.lattice, held), depth - rules.f
    u = model.relaxed(g)
    return model.value(u), sum(map(abs, model.terms(u).values())), u - g


def equal(rules, one, other, depth):
    """`other` has the lower energy above the depth and the higher one below."""
    rise = []
    for at in (depth - 1e-4, depth, depth + 1e-4):
        (first, size, _), (second, _, _) = (energy(rules, c, at) for c in (one, other))
        rise.append((second - first) / size)
    assert abs(rise[1]) <= 1e-13
    assert rise[0] > 1e-8 and rise[2] < -1e-8


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize("links", [6, 3, 2])
def test_a_line_passes_a_link_or_the_last_two(seed, links):
    rules, first = case(seed), 12 + links
    one, right = (6, 12), (first, 24)
    closed = [(6, 24)] if links == 2 else [(6, 13), right]
    equal(rules, [one, right], closed, rules.passes(12, 1, first))
    closed = [(6, 24)] if links == 2 else [one, (first - 1, 24)]
    equal(rules, [one, right], closed, rules.passes(first, -1, 12))
    equal(rules, [right], [(first, 25)], rules.passes(24, 1, None))
    equal(rules, [one], [(5, 12)], rules.passes(6, -1, None))


@pytest.mark.parametrize("seed", range(6))
def test_a_node_is_torn_out_of_a_contact(seed):
    rules = case(seed)
    depth, node = rules.tears(6, 24)
    parts = [(6, node - 1), (node + 1, 24)]
    equal(rules, parts, [(6, 24)], depth)
    for other in set(range(7, 24)) - {node}:  # all others hold or are pressed
        opened, _, clear = energy(rules, [(6, other - 1), (other + 1, 24)], depth)
        pressed = clear.min() < -1e-14
        assert pressed or opened >= energy(rules, [(6, 24)], depth)[0]


@pytest.mark.parametrize("seed", range(6))
@pytest.mark.parametrize(("left", "right"), [(12, 18), (None, 6), (24, None)])
def test_the_surface_touches_the_first_node_in_its_way(seed, left, right):
    rules = case(seed)
    contacts = [pair for pair in HELD if left in pair or right in pair]
    depth, node = rules.touches(left, right)
    free = slice(0 if left is None else left + 1, NODES if right is None else right)
    clear = energy(rules, contacts, depth)[2]
    assert abs(clear[node]) <= 1e-14
    assert clear[free].min() >= -1e-14
    assert rules.pulled(left, node, right) == pytest.approx(depth, rel=0, abs=1e-12)
    assert rules.pulled(left, node, right) < depth  # what has just touched stays
    held = tuple(sorted([*contacts, (node, node)]))
    falls = Walk(SimpleNamespace(rules=(rules, rules))).changes(parts_of(held), -1)
    lets_go = falls[len(held) + 1 + held.index((node, node))]
    assert lets_go.depth == rules.pulled(left, node, right)
    assert lets_go.parts == ((left, right),)


def test_a_line_waits_where_a_node_would_be_penetrated_once_it_has_passed():
    """The energies compared are those with that node held: no adhesion of it counts."""
    waits = 0
    for seed in range(800):
        rules = case(seed, ell=2.0)
        alone, depth = rules.passes(12, 1, None), advances(rules, 12, 1, None)
        if not depth > alone + 1e-9 or depth == np.inf:
            assert depth >= alone
            continue
        assert energy(rules, [(6, 13)], depth)[2].min() < -1e-9
        before, size, clear = energy(rules, [(6, 12)], depth)
        if clear[:6].min() < -1e-9:  # the other side does not wait
            continue
        nodes, part = held_nodes(rules, 13, None, depth), [(6, 13)]
        after, _, over = energy(rules, sorted([*part, *((n, n) for n in nodes)]), depth)
        links = sum(n + 1 in (*nodes,) for n in (13, *nodes))  # which adhere, but do not count
        work = rules.lattice.w * rules.lattice.spacing
        assert over[14:].min() >= -1e-12
        assert abs(after + links * work - before) <= 1e-9 * size
        waits += 1
    assert waits >= 6


def test_a_line_passes_with_the_node_that_it_would_put_into_the_indenter():
    """So states of coarse nodes have the lines of fitted ones."""
    ripples = Profile(
        lambda x: 0.122 * (1 - np.cos(6.45 * np.asarray(x))) + 0.156 * np.square(x),
        lambda x: 0.122 * 6.45 * np.sin(6.45 * np.asarray(x)) + 0.312 * np.asarray(x),
        extent=(-8.0, 8.0),
    )
    scene = plain(ripples, w=0.34)
    fitted = minimise(scene, 0.774)
    assert fitted.contacts == pytest.approx(np.array([[-2.014, 2.014]]), abs=1e-3)
    for links in (5.0, 5.6, 6.6, 7.4, 8.3, 9.2, 12.1):
        state = minimise(scene, 0.774, method="lattice", spacing=1 / links)
        assert np.abs(state.contacts - fitted.contacts).max() <= 0.1 / links


def test_both_lines_of_a_gap_pass_a_link_at_once():
    f = np.abs(np.arange(NODES) - 15.0) * -0.0023  # a re-entrant corner in the middle of the gap
    rules = rules_of(lattice(4.0, w=2e-3), f + 0.3)
    for left, right in ((13, 17), (12, 18), (11, 19)):
        depth = rules.passes_both(left, right)
        equal(rules, [(6, left), (right, 24)], [(6, left + 1), (right - 1, 24)], depth)
    assert rules.passes_both(13, 17) < min(rules.passes(13, 1, 17), rules.passes(17, -1, 13))
    depth = rules.passes_both(14, 17)
    equal(rules, [(6, 14), (17, 24)], [(6, 24)], depth)
    assert rules.passes_both(14, 16) == np.inf  # there one node closes the gap
