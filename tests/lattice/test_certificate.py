"""The certificate must reject what is no equilibrium; sums on nodes against 50-digit arithmetic."""

import contextlib
import itertools
import math
from dataclasses import replace

import mpmath as mp
import numpy as np
import pytest
from support.example_scenes import ALPHA, DELTA0, SCENE, L, adhesive, steep, turned, two
from support.lattices import displacement, mask_of, nodes_of, of_heights, over, pressed

from discretization import Lattice, NodalEnergy, NotCertifiedError
from discretization.certificate import Certificate
from discretization.lattice.certificate import on_row
from discretization.lattice.plain import Plain
from discretization.lattice.state import on_lattice
from discretization.nodes import row as ground
from discretization.nodes.row import Row
from energy import Parabola, Profile, SurfaceEnergies, Wedge

DEPTH = 2e-3
DX = 0.013
LEANING = steep(Parabola(0.02).tilted(0.05), 0.4)
FAINT = SurfaceEnergies.from_work(0.07, 0.0014)
ROUND = turned(Parabola(1.9 * L / ALPHA))
HELD = [  # scenes, and links by which contacts are moved
    (scene, change)
    for scene in (SCENE, LEANING, replace(LEANING, surfaces=FAINT), ROUND)
    for change in ((0, 1), (0, -1), (1, 0), (-1, 0))[: 2 if scene is ROUND else 4]
]
BARE = [adhesive(Parabola(0.02), w=0.0, slopes=slopes) for slopes in ("small", "finite")]


def contacts_of(scene, depth, change=(0, 0)):
    """The contact on nodes, found plainly with finite slopes, its outermost nodes moved."""
    lattice = Lattice.of(scene, L / 100)
    if scene.slopes == "finite":
        plain = Plain(Row.of(lattice.scene_on_nodes(scene), lattice, depth), depth, lattice.w)
        moved = np.add(plain.contact(), change).tolist()
        return plain.relaxed(moved)
    _, (ends,) = nodes_of(on_lattice(scene, depth, L / 100))
    return over(lattice, lattice.scene_on_nodes(scene).indenter, depth, np.add(ends, change))


def judged(*given):
    return contacts_of(*given).certificate


@pytest.mark.parametrize("name", Certificate._fields[:-1])
@pytest.mark.parametrize(
    ("violation", "ok"), [(0.99e-9, True), (1.01e-9, False), (math.nan, False)]
)
def test_a_violation_by_more_than_1e_9_of_its_scale_fails(name, violation, ok):
    given = Certificate.undeformed()._replace(**{name: violation})
    assert given.ok == ok and given.failures == (() if ok else (name,))
    with contextlib.nullcontext() if ok else pytest.raises(NotCertifiedError, match=name):
        given.demand("a state", "try another")


@pytest.mark.parametrize(("scene", "change"), HELD)
def test_one_link_off_costs_energy(scene, change):
    depth = DEPTH if scene is not ROUND else 0.2 * DELTA0
    right = judged(scene, depth)
    wrong = judged(scene, depth, change)
    assert right.ok and right.penetration == right.opening == right.neighbours == 0
    assert right.force <= 1e-13
    assert wrong.failures == ("neighbours",) and wrong.stationarity == right.stationarity


@pytest.mark.parametrize("scene", BARE)
def test_certificate_of_wrong_widths_without_adhesion(scene):
    """Without adhesion a contact too small penetrates and one too large pulls."""
    assert "penetration" in judged(scene, DEPTH, (3, -3)).failures
    assert "neighbours" in judged(scene, DEPTH, (-3, 3)).failures


def exact(lattice, height, depth, first, last):
    """Energy and force of the contact set first..last, tails by the characteristic root."""
    dx, k, gamma1, w, d = map(
        mp.mpf, (lattice.spacing, lattice.k, lattice.gamma1, lattice.w, depth)
    )
    kappa = k * dx**2 / gamma1
    lam = 1 + kappa / 2 - mp.sqrt(kappa + kappa**2 / 4)
    g = [d - height(dx * i) for i in range(first, last + 1)]
    ends = (g[0], g[-1])
    energy = sum(k * dx * u**2 / 2 for u in g) - w * dx * (last - first)
    energy += sum(gamma1 / dx * (q - p) ** 2 / 2 for p, q in itertools.pairwise(g))
    energy += sum(gamma1 / dx * (1 - lam) * u**2 / 2 for u in ends)
    force = k * dx * sum(g) + k * dx * lam / (1 - lam) * sum(ends)
    return energy, force


@pytest.mark.parametrize("decade", range(-3, 9))
@pytest.mark.parametrize("indenter", [Parabola(2000 * DX), Wedge(0.05)])
def test_twelve_digits_for_any_ratio_of_length_to_spacing(decade, indenter):
    """And no admissible contact set with one link more or less on both sides is lower."""

    def height(x):
        if isinstance(indenter, Parabola):
            return x**2 / (2 * mp.mpf(indenter.R))
        return abs(x) * mp.mpf(math.tan(indenter.delta))

    with mp.workdps(50):
        k = 37.0
        ell = 10.0**decade * DX
        a = 150 * DX
        scene = adhesive(indenter, k=k, gamma1=k * ell**2, w=k * (0.3 * min(ell, a)) ** 2 / 2)
        f = float(indenter.height(a))
        rise = float(indenter.slope(a))
        d = f - scene.critical_separation + ell * rise
        lattice = Lattice.of(scene, DX)
        first, last = contact = pressed(lattice, scene, d)
        state = over(lattice, indenter, d, contact)
        sums = state.balance
        reactions = state.balance.forces[state.model.contact].sum()
        energy, force = exact(lattice, height, d, first, last)
        assert first == -last < -50 and on_lattice(scene, d, DX).certificate.ok
        assert abs(sums.energy - energy) <= 1e-12 * sums.scale
        assert abs(sums.force - force) <= 1e-12 * sums.sizes
        slack = max(1, lattice.link_stiffness / lattice.spring_stiffness / 1e3)
        assert abs(reactions - force) <= 1e-12 * sums.sizes * slack
        assert energy <= exact(lattice, height, d, first - 1, last + 1)[0]
        kappa = mp.mpf(lattice.k) * mp.mpf(DX) ** 2 / lattice.gamma1
        lam = 1 + kappa / 2 - mp.sqrt(kappa + kappa**2 / 4)
        before, own = (d - height(mp.mpf(DX) * i) for i in (last - 1, last))
        if lam * before >= own:  # without its last link the surface stays clear
            assert energy <= exact(lattice, height, d, first + 1, last - 1)[0]


MOVES = {  # of contacts of the nodes a to b and c to d, and what fails
    "left line out": (lambda a, b, c, d: [[a - 1, b], [c, d]], {"neighbours"}),
    "left line in": (lambda a, b, c, d: [[a + 1, b], [c, d]], {"neighbours"}),
    "inner line out": (lambda a, b, c, d: [[a, b + 1], [c, d]], {"neighbours"}),
    "inner line in": (lambda a, b, c, d: [[a, b], [c + 1, d]], {"neighbours"}),
    "right line out": (lambda a, b, c, d: [[a, b], [c, d + 1]], {"neighbours"}),
    "merged": (lambda a, b, c, d: [[a, d]], {"opening"}),
    "split": (lambda a, b, c, d: [[a, a + 1], [a + 3, b], [c, d]], {"neighbours", "penetration"}),
    "one alone": (lambda a, b, c, d: [[c, d]], {"penetration"}),
}


@pytest.mark.parametrize("name", MOVES)
def test_the_certificate_rejects_other_contact_sets(name):
    # pressed in deep and close together: neither contact can go
    scene = adhesive(two(0.35 * L, 0.0006, 0.001, 5e-4))
    depth = 1.5e-3
    state = on_lattice(scene, depth, L / 1000, branch="global")
    lattice, nodes = nodes_of(state)
    assert len(nodes) == 2
    move, failures = MOVES[name]
    moved = over(lattice, scene.indenter, depth, *map(tuple, move(*nodes.ravel().tolist())))
    assert set(moved.certificate.failures) == failures


def test_the_certificate_notices_force_and_balance():
    scene = adhesive(two(0.6 * L, lift=5e-4))
    depth = 0.05 * DELTA0
    lattice, nodes = nodes_of(on_lattice(scene, depth, L / 100, branch="global"))
    contacts = over(lattice, scene.indenter, depth, *map(tuple, nodes.tolist()))
    sums = contacts.balance
    assert contacts.certificate.ok
    wrong = replace(contacts)
    vars(wrong)["balance"] = sums._replace(force=sums.force * (1 + 1e-7))
    assert wrong.certificate.failures == ("force",)
    contacts.u[(nodes[0, 1] + nodes[1, 0]) // 2 - contacts.model.first] += 1e-7 * DELTA0
    assert "stationarity" in replace(contacts).certificate.failures


def test_the_certificate_notices_a_tail_out_of_balance():
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1e-4)
    contacts = of_heights(lattice, [0.01, 0.01, 0.01], [[0, 2]])
    assert contacts.certificate.ok
    vars(lattice).update(log_decay=lattice.log_decay * (1 + 1e-7))
    again = on_row(contacts.row, ((0, 2),), contacts.depth)
    assert "stationarity" in again.certificate.failures


def test_the_searched_window_leaves_room_for_every_contact():
    """Heights of 1.4 δ₀ at the ends of the first window: clear of adhered, not of all contact."""
    lattice = Lattice.of(SCENE, L / 100)
    c = 1.4 * DELTA0 / (1024 * lattice.spacing) ** 2
    searched = Profile(lambda x: c * np.asarray(x) ** 2, lambda x: 2 * c * np.asarray(x))
    first, last, _ = ground.region(lattice, searched, 0.0)
    ends = ground.heights(lattice, searched, np.array([first, last], float))
    assert ends.min() > lattice.deepest_contact


@pytest.mark.parametrize(("bonds", "failures"), [(1.5, {"neighbours"}), (2.5, set())])
def test_the_last_node_of_a_gap_closes_with_two_links(bonds, failures):
    """A notch that costs less than both links, or more."""
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1e-4)
    level = 0.01 * np.ones(13)
    held = np.arange(13) != 6
    lifted = displacement(lattice, level, held)[6]
    level[6] = lifted - math.sqrt(
        2
        * bonds
        * lattice.w
        * lattice.spacing
        / (lattice.spring_stiffness + 2 * lattice.link_stiffness)
    )
    assert level[0] > lifted > level[6]
    contacts = of_heights(lattice, level, [[0, 5], [7, 12]])
    assert set(contacts.certificate.failures) == failures


APART = [[0, 12], [17, 29]]


@pytest.mark.parametrize(
    ("share", "failures"), [(0.99, set()), (1 + 2e-14, set()), (1.01, {"opening"})]
)
@pytest.mark.parametrize("factor", [None, 1.0, 0.2, 0.0])
@pytest.mark.parametrize("ends", [APART, APART[:1]])
def test_largest_pull_on_a_node_in_contact(share, factor, failures, ends):
    """A node in contact is pulled by no more than its links hold, but for rounding."""
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, 1e-4)
    g = 0.01 * np.ones(30)
    g[13:17] = -1.0
    stiffness = lattice.spring_stiffness + 2 * lattice.link_stiffness
    held = math.sqrt(4 * stiffness * lattice.w * (1.0 if factor is None else factor))
    pull = share * held if held else (share - 1) * lattice.spring_stiffness * 1e-3
    g[6] -= (pull + lattice.spring_stiffness * g[6]) / stiffness
    contacts = of_heights(lattice, g[: ends[-1][1] + 1], ends, factor=factor)
    assert set(contacts.certificate.failures) == failures


@pytest.mark.parametrize(("share", "failures"), [(0.99, set()), (1.01, {"opening"})])
@pytest.mark.parametrize("closing", [0.0, 3e-5])
def test_links_hold_by_the_work_of_opening(share, closing, failures):
    """Also where closing gains nothing."""
    opening = 1e-4
    lattice = Lattice(1.0, 0.0, 2.0, 50.0, closing)
    g = 0.01 * np.ones(30)
    stiffness = lattice.spring_stiffness + 2 * lattice.link_stiffness
    pull = share * math.sqrt(4 * stiffness * opening)
    g[6] -= (pull + lattice.spring_stiffness * g[6]) / stiffness
    alike = of_heights(lattice, g, [[0, 29]])
    assert alike.certificate.failures == ("opening",)
    scene = replace(alike.row.scene, opening=SurfaceEnergies.from_work(lattice.gamma1, opening))
    row = replace(alike.row, scene=scene)
    vars(row)["f"] = alike.row.f
    contacts = on_row(row, alike.nodes, alike.depth)
    assert set(contacts.certificate.failures) == failures


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
    assert set(contacts.certificate.failures) == failures


@pytest.mark.parametrize("ends", [[[0, 7]], [[3, 9], [14, 14], [20, 27]], [[0, 5], [12, 30]]])
@pytest.mark.parametrize("factor", [None, 0.3])
def test_totals_are_the_nodal_energy_of_any_contacts(ends, factor):
    lattice = Lattice.of(adhesive(SCENE.indenter, w=0.02), L / 7)
    g = 0.2 * L * (0.3 + np.random.default_rng(3).random(33))
    contacts = of_heights(lattice, g, ends, factor=factor)
    sums = contacts.balance
    held = mask_of(36, np.array(ends))
    model = NodalEnergy(lattice, held)
    u = model.relaxed(contacts.depth - contacts.row.f)
    terms = model.balance(u).terms
    pressed = model.gradient(u)[held].sum()
    terms["adhesion"] *= 1.0 if factor is None else factor
    assert abs(sums.energy - sum(terms.values())) <= 1e-12 * sums.scale
    assert sums.scale == pytest.approx(sum(map(abs, terms.values())), rel=1e-12, abs=0)
    reactions = sums.forces[contacts.model.contact].sum()
    assert abs(reactions - pressed) <= 1e-13 * sums.sizes
    assert abs(sums.force - pressed) <= 1e-12 * sums.sizes
