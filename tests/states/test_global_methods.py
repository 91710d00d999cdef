"""Every way to the lowest energy: the same answer, or a refusal in words."""

from dataclasses import replace

import numpy as np
import pytest
from scenes import DELTA0, SCENE, L, adhesive, plain, rough, two

from discretization import minimise
from energy import FlatPunch, Parabola, Plane, PowerLaw, Sampled, Wedge


@pytest.mark.parametrize("seed", range(5))
def test_without_adhesion_every_method_agrees(seed):
    scene = rough(seed, w=0.0, n=301)
    options = {"branch": "global", "spacing": L / 20}
    ours = minimise(scene, 1.2 * DELTA0, method="lattice", **options)
    assert ours.label == "global" and ours.method == "lattice"
    assert minimise(scene, 1.2 * DELTA0, method="lattice", spacing=L / 20).energy == ours.energy
    for method in ("oracle", "shortest_path"):
        theirs = minimise(scene, 1.2 * DELTA0, method=method, spacing=L / 20)
        assert theirs.method == method and theirs.label == "global"
        assert np.array_equal(theirs.nodes, ours.nodes)
        assert theirs.energy == pytest.approx(ours.energy, rel=1e-13, abs=0)
        assert theirs.force == pytest.approx(ours.force, rel=1e-13, abs=0)
    assert minimise(scene, -0.1 * DELTA0, method="lattice", spacing=L / 20).label == "detached"


@pytest.mark.parametrize("depth", [-0.5, 0.0, 0.6])
def test_shortest_path_equals_the_mixed_integer_oracle(depth):
    pytest.importorskip("pyscipopt", reason="the mixed-integer solver is in the test extra")
    scene = adhesive(two(0.6 * L, lift=5e-4))
    options = {"branch": "global", "spacing": L / 12}
    ours = minimise(scene, depth * DELTA0, method="shortest_path", **options)
    theirs = minimise(scene, depth * DELTA0, method="oracle", **options)
    assert theirs.method == "oracle" and theirs.proof is None
    assert theirs.label == ours.label == ("detached" if depth < 0 else "global")
    assert np.array_equal(theirs.nodes, ours.nodes)
    assert theirs.energy == ours.energy


def test_the_plane_is_endless_or_detached():
    scene = adhesive(Plane())
    assert minimise(scene, -0.9 * DELTA0, branch="global").label == "global"
    assert minimise(scene, -0.9 * DELTA0).label == "global"  # its energy is that of no end
    assert minimise(scene, -1.1 * DELTA0, branch="global").label == "detached"
    with pytest.raises(ValueError, match="end to the plane"):
        minimise(scene, 0.0, branch="global", method="shortest_path", spacing=L)


FINITE = replace(SCENE, slopes="finite")
OPEN_ENDED = adhesive(Sampled(np.linspace(-L, L, 9), np.array([3, 1, 2, 0, 2, 0, 3, 1, 0]) * 1e-3))


@pytest.mark.parametrize(
    ("scene", "options", "says"),
    [
        (OPEN_ENDED, {}, "not known any more"),
        (replace(OPEN_ENDED, slopes="finite"), {}, "slopes='small'"),
        (OPEN_ENDED, {"method": "lattice", "spacing": L / 20}, "not known any more"),
        (FINITE, {"method": "shortest_path", "spacing": L / 20}, "slopes = 'finite'"),
        (SCENE, {"method": "shortest_path"}, "spacing = None"),
        (SCENE, {"method": "shortest_path", "spacing": L, "branch": "adhered"}, "'adhered'"),
        (SCENE, {"method": "oracle", "spacing": L / 400}, "too many for integers"),
        (adhesive(Parabola(1), gamma1=0), {"method": "oracle", "spacing": L}, "gamma1 = 0"),
        (SCENE, {"method": "fitted", "spacing": L}, "has no spacing"),
    ],
)
def test_refuses(scene, options, says):
    with pytest.raises(ValueError, match=says):
        minimise(scene, 0.0, **{"branch": "global", **options})


def test_several_contacts_without_adhesion_need_no_spacing():
    scene = adhesive(two(2 * L), w=0.0)
    state = minimise(scene, 0.5 * DELTA0)
    coarse = minimise(scene, 0.5 * DELTA0, method="lattice", spacing=L / 200)
    assert state.method == "fitted" and len(state.contacts) == len(coarse.contacts) == 2
    assert np.abs(state.contacts - coarse.contacts).max() <= 1e-3 * L


def test_auto_takes_the_lattice_where_a_spacing_is_given():
    state = minimise(adhesive(two(0.6 * L)), 0.0, branch="global", spacing=L / 40)
    assert state.method == "shortest_path" and state.proof.violation <= 1e-13


def test_finite_slopes_of_convex_indenters_compare_two_states():
    for depth, label in ((0.0, "global"), (-0.6 * DELTA0, "detached")):
        assert minimise(FINITE, depth, branch="global").label == label
    assert minimise(FINITE, -0.6 * DELTA0).label == "metastable"


CONVEX = (
    FlatPunch(0.8),
    Wedge(0.2),
    Parabola(5.0),
    PowerLaw(0.2, 5.0),
    Parabola(4.0).tilted(0.1),
    FlatPunch(1.0).tilted(-0.15),
)


@pytest.mark.parametrize("body", CONVEX, ids=repr)
def test_of_a_convex_body_one_contact_or_none_is_the_lowest(body):
    """What the lattice compares is what the search over all contact sets finds."""
    rng, labels = np.random.default_rng(3), set()
    for _ in range(12):
        scene = plain(body, w=10 ** rng.uniform(-3, 0))
        depth, spacing = scene.critical_separation * rng.uniform(-1, 0.2), rng.uniform(0.02, 0.1)
        found, searched = (
            minimise(scene, depth, method=method, branch="global", spacing=spacing)
            for method in ("lattice", "shortest_path")
        )
        labels.add(found.label)
        assert found.label == searched.label
        size = searched.scales["energy"] or 1.0
        assert found.energy == pytest.approx(searched.energy, rel=0, abs=1e-13 * size)
        assert found.contacts == pytest.approx(searched.contacts, rel=0, abs=1e-13)
    assert labels == {"global", "detached"}


def test_finite_slopes_of_a_convex_body_have_a_lowest_state_on_the_lattice():
    labels = set()
    for depth in np.linspace(-1, 0.2, 7) * DELTA0:
        coarse = minimise(FINITE, depth, branch="global", method="lattice", spacing=L / 50)
        exact = minimise(FINITE, depth, branch="global")
        labels.add(coarse.label)
        assert coarse.label == exact.label
        apart = abs(coarse.energy - exact.energy) / (exact.scales["energy"] or 1.0)
        assert apart <= 4 * coarse.error_estimate["energy"]
    assert labels == {"global", "detached"}


def test_the_lowest_state_detaches_where_its_energy_vanishes():
    """To rounding, not where the lattice that shows the contacts says so."""
    scene, held, gone = adhesive(two(0.6 * L, lift=5e-4)), 0.0, -DELTA0
    while held - gone > 1e-12 * DELTA0:
        middle = (held + gone) / 2
        state = minimise(scene, middle, branch="global")
        held, gone = (middle, gone) if state.contacts.size else (held, middle)
    state = minimise(scene, held, branch="global")
    assert state.label == "global" and -0.9 * DELTA0 < held < 0
    assert abs(state.energy) <= 1e-10 * state.scales["energy"]


def test_a_flat_face_without_adhesion_touches_and_is_not_neutral():
    for options in ({}, {"method": "lattice", "spacing": L / 10}):
        assert minimise(adhesive(FlatPunch(L), w=0.0), 0.0, **options).label == "global"
