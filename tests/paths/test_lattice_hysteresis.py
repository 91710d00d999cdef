"""States and paths on nodes that depend on the way: two works of adhesion, patterns."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive
from test_many_contacts import bumps
from truth.scenes import case_of

from discretization import History, load_path, minimise
from energy import (
    ElasticLayer,
    Parabola,
    Patches,
    Plane,
    PowerLaw,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

SPACING = 1e-4
HYSTERETIC = adhesive(Parabola(0.02), w=0.001, opening=0.003)
STRIPED = replace(adhesive(Parabola(0.05)), pattern=Patches.stripes(0.004, 0.25, 1.0, 0.1))
BOTH = replace(
    adhesive(bumps([0.0, 3e-4, 1e-4]), w=2e-4, opening=4e-4),
    pattern=Patches.stripes(0.003, 0.5, 1.0, 0.1),
)
SCENES = {"opening": HYSTERETIC, "pattern": STRIPED, "both": BOTH}


@pytest.mark.parametrize("depth", [-2.5, -0.6, 0.3, 1.7, 4.0])
@pytest.mark.parametrize("name", SCENES)
def test_the_state_is_the_end_of_its_path(name, depth):
    scene = SCENES[name]
    depth = depth * scene.critical_separation
    spacing = SPACING if name != "both" else 4e-5
    state = minimise(scene, depth, method="lattice", spacing=spacing)
    path = load_path(scene, depths=[max(depth, 0.0), depth], method="lattice", spacing=spacing)
    assert len(state.contacts) == (len(path.inner[-1]) // 2 + 1 if state.contacts.size else 0)
    assert state.force == pytest.approx(path.force[-1], rel=1e-12, abs=0)
    assert state.energy == pytest.approx(path.energy[-1], rel=1e-12, abs=0)
    if not state.contacts.size:
        assert math.isnan(path.contacts[-1, 0]) and state.label == "detached"
        return
    assert state.certificate.ok and state.label == "adhered"
    assert state.contacts[0, 0] == path.contacts[-1, 0]
    assert state.contacts[-1, 1] == path.contacts[-1, 1]
    assert state.error_estimate["force"] > 0


@pytest.mark.parametrize("depth", [-1.5, -0.7, 0.4, 2.0])
def test_hysteresis_on_nodes_tends_to_that_on_the_fitted_mesh(depth):
    depth *= HYSTERETIC.critical_separation
    exact = load_path(HYSTERETIC, depths=[0.0, depth])
    errors = []
    for spacing in (4e-4, 2e-4, 1e-4, 5e-5):
        states = [
            minimise(HYSTERETIC, depth, method="lattice", spacing=spacing * stretch)
            for stretch in (0.9, 1.0, 1.13)
        ]
        scale = states[0].scales["energy"]
        errors.append(max(abs(state.energy - exact.energy[-1]) for state in states) / scale)
    assert errors[-1] <= 0.3 * errors[0]
    assert errors[-1] <= 0.01  # a line that is held keeps the node on which it came to rest


@pytest.mark.parametrize("name", SCENES)
def test_the_parts_of_the_energy_know_the_pattern(name):
    scene = SCENES[name]
    spacing = 2e-5
    state = minimise(scene, 1.5 * scene.critical_separation, method="lattice", spacing=spacing)
    total, scale = sum(state.energy_parts.values()), state.scales["energy"]
    assert total == pytest.approx(state.energy, rel=0, abs=2e-3 * scale)
    assert sum(state.force_parts.values()) == pytest.approx(
        state.force, rel=0, abs=2e-3 * state.scales["force"]
    )


def test_a_pattern_of_one_factor_is_another_work_of_adhesion():
    for seed in range(6):
        case = case_of("small", seed)
        plain, w = case.scene, case.scene.work_of_adhesion
        doubled = SurfaceEnergies.from_work(plain.gamma1, 2 * w)
        patched = replace(plain, pattern=Patches([0.0], [2.0, 2.0]))
        given = {"method": "lattice", "spacing": case.feature / 20}
        ours = minimise(patched, case.depth, **given)
        theirs = minimise(replace(plain, surfaces=doubled), case.depth, **given)
        assert ours.nodes == pytest.approx(theirs.nodes, rel=1e-12, abs=0)
        scale = theirs.scales["energy"] or 1.0
        assert ours.energy == pytest.approx(theirs.energy, rel=0, abs=0.02 * scale)


@pytest.mark.parametrize(
    "given",
    [{"branch": "global"}, {"method": "lattice", "spacing": 1e-4, "branch": "global"}],
    ids=str,
)
@pytest.mark.parametrize("name", ["opening", "pattern"])
def test_without_a_path_the_state_is_not_known(name, given):
    with pytest.raises(ValueError, match=rf"{name} = .* use branch='adhered'"):
        minimise(SCENES[name], 1e-3, **given)


def test_no_path_is_followed_for_a_plane():
    given = {"method": "lattice", "spacing": 1e-4}
    with pytest.raises(ValueError, match="opening = "):
        minimise(replace(HYSTERETIC, indenter=Plane()), 1e-3, **given)
    path = load_path(HYSTERETIC, depths=[0.0, 1e-3], **given)
    assert minimise(HYSTERETIC, 1e-3, **given).force == pytest.approx(path.force[-1], rel=1e-12)


LEVELS = (0.1, 0.05, 0.025, 0.0125)  # spacings
OFFSETS = (1.0, 0.97, 0.93, 0.9)  # of spacings: where nodes are from the lines


def adhering(body, w=0.02, opening=0.03, **options):
    closes, opens = (SurfaceEnergies.from_work(1.0, work) for work in (w, opening))
    return Scene(ElasticLayer(1.0, 0.0, 1.0), closes, body, opening=opens, **options)


def hills():
    x = np.linspace(-15, 15, 301)
    f = 0.12 * np.cos(2 * np.pi * x / 5 + 0.4) + 0.004 * x**2
    return Sampled(x, f, kind="smooth")


def there_and_back(*turns):
    """Depths from turn to turn."""
    legs = [np.linspace(*each, 9)[1:] for each in itertools.pairwise(turns)]
    return np.concatenate([turns[:1], *legs])


ONE = there_and_back(0.0, 0.6, 0.1, 0.3, -0.2, -0.05)
MANY = there_and_back(-0.1, 0.15, 0.05, 0.1, -0.12, 0.02)
TURNED = {"geometry": "axisymmetric"}
SCENES_HYSTERESIS = {  # with depths, and a bound on the errors on the finest nodes
    "parabola": (adhering(Parabola(10.0)), ONE, 2e-5),
    "tilted": (adhering(Parabola(10.0).tilted(0.02)), ONE, 2e-5),
    "wedge": (adhering(Wedge(0.05)), ONE, 3e-6),
    "sphere": (adhering(Parabola(10.0), **TURNED), ONE, 5e-5),
    "cubic about an axis": (adhering(PowerLaw(0.1, 3.0), **TURNED), ONE, 2e-4),
    "hills": (adhering(hills(), 0.006, 0.011), MANY, 5e-5),
}


def worst(scene, depths, exact, spacing):
    """The largest errors of force and half-width over the offsets, relative to the largest."""
    found = []
    for offset in OFFSETS:
        path = load_path(scene, depths=depths, method="lattice", spacing=offset * spacing)
        off = [getattr(path, name) - getattr(exact, name) for name in ("force", "half_width")]
        found.append([np.abs(part).max() for part in off])
    return np.max(found, axis=0) / [np.abs(exact.force).max(), exact.half_width.max()]


@pytest.mark.slow
@pytest.mark.parametrize("name", SCENES_HYSTERESIS)
def test_paths_with_held_lines_are_of_second_order(name):
    scene, depths, cap = SCENES_HYSTERESIS[name]
    spacings = np.array(LEVELS) / (2 if name == "hills" else 1)
    exact = load_path(scene, depths=depths)
    errors = np.array([worst(scene, depths, exact, spacing) for spacing in spacings])
    orders = np.polyfit(np.log(spacings), np.log(errors), 1)[0]
    if name == "hills":  # lines that face each other are told within half a link of their nodes
        assert (errors[:, 1] <= 0.03 * spacings / exact.half_width.max()).all(), errors
        orders = orders[:1]
    assert ((orders > 1.7) & (orders < 2.4)).all(), (orders, errors)
    assert errors[-1].max() <= cap, errors


@pytest.mark.parametrize("name", ["parabola", "sphere", "hills"])
def test_a_held_line_stays_where_it_is_to_the_last_bit(name):
    scene = SCENES_HYSTERESIS[name][0]
    depths = np.concatenate(
        [[0.15], np.linspace(0.1499, 0.13, 20), np.linspace(0.1305, 0.1499, 20)]
    )
    path = load_path(scene, depths=depths, method="lattice", spacing=0.05)
    assert (path.contacts == path.contacts[0]).all()
    assert set(path.inner) == {path.inner[0]}
    assert np.isfinite(path.contacts).all()
    on_nodes = np.abs(path.contacts[0] / 0.05 - np.round(path.contacts[0] / 0.05))
    assert on_nodes.max() > 1e-3
    # what is free beside the contact answers linearly then
    slopes = np.diff(path.force) / np.diff(path.depth)
    assert slopes == pytest.approx(np.full(40, slopes[1]), rel=1e-9, abs=0)


@pytest.mark.parametrize("name", ["parabola", "sphere", "hills"])
def test_neither_the_steps_nor_where_a_path_was_left_matter(name, tmp_path):
    scene, depths, _ = SCENES_HYSTERESIS[name]
    nodes = {"method": "lattice", "spacing": 0.0431}
    whole = load_path(scene, depths=depths, **nodes)
    turns = load_path(scene, depths=depths[::8], **nodes)
    assert turns.force == pytest.approx(whole.force[::8], rel=1e-12, abs=0)
    same = {"rel": 1e-12, "abs": 0, "nan_ok": True}
    assert turns.contacts == pytest.approx(whole.contacts[::8], **same)
    for cut in (5, 13, 20, 33):
        load_path(scene, depths=depths[:cut], **nodes).to_csv(tmp_path / "path.csv")
        first = History.from_csv(tmp_path / "path.csv")
        rest = load_path(scene, depths=depths[cut:], after=first, **nodes)
        for one in ("force", "energy", "contacts"):
            assert np.array_equal(getattr(rest, one), getattr(whole, one), equal_nan=True), one
        assert rest.inner == whole.inner
        assert repr(rest.events) == repr(whole.events)  # nan is like itself
    closed = load_path(scene, depths=[*depths, -1.0], **nodes)
    assert closed.work() == pytest.approx(closed.dissipated, rel=1e-12, abs=0)


def test_a_state_that_is_asked_for_is_that_of_the_path():
    scenes = [SCENES_HYSTERESIS[name][0] for name in ("parabola", "sphere", "hills")]
    patches = Patches((-0.8, -0.1, 0.55), (1.0, 0.5, 2.0, 1.2))
    found = 0
    for scene in [*scenes, replace(scenes[0], pattern=patches)]:
        for depth in (0.13, 0.02, -0.03, -0.08, -0.12):
            state = minimise(scene, depth, method="lattice", spacing=0.05)
            touch = state.scene.indenter.height(np.linspace(-15, 15, 601)).min()
            depths = [max(depth, touch), depth]
            path = load_path(scene, depths=depths, method="lattice", spacing=0.05)
            assert state.force == pytest.approx(path.force[-1], rel=1e-12, abs=0)
            if state.contacts.size:
                lines = [path.contacts[-1, 0], *path.inner[-1], path.contacts[-1, 1]]
                assert state.contacts.ravel() == pytest.approx(lines, rel=1e-12, abs=1e-14)
                found += 1
    assert found >= 16


def test_errors_of_held_lines_are_known():
    """Over spacings, i.e. over where the lines are between nodes."""
    dice, ratios = np.random.default_rng(5), []
    for name in ("parabola", "tilted", "wedge", "sphere", "cubic about an axis", "hills"):
        scene = SCENES_HYSTERESIS[name][0]
        for depth in dice.uniform(-0.09, 0.3, 2):
            exact = minimise(scene, depth)
            for spacing in 10 ** dice.uniform(-2, -1.2, 3):
                state = minimise(scene, depth, method="lattice", spacing=spacing)
                scales = {"half_width": state.half_width, **state.scales}
                ratios += [
                    abs(getattr(state, one) - getattr(exact, one)) / scales[one] / estimate
                    for one, estimate in state.error_estimate.items()
                ]
    assert len(ratios) == 6 * 2 * 3 * 3
    assert np.max(ratios) <= 2
    assert np.mean(np.array(ratios) > 1) <= 0.02
    assert math.isfinite(np.sum(ratios))


def polygon(x, z, *works):
    return adhering(Sampled(np.array(x), np.array(z)), *works)


POLYGONS = [  # with a depth and a spacing; every line of them is at a corner
    (
        [-10, -4, -3.55, -3.1, -2.7, -2.2, -1.8, -1.3, 1.5, 2.0, 2.4, 3.6, 9.6],
        [4.02, 0.02, 0.04, 0.06, 0.04, 0.06, 0.02, 0, 0.06, 0.02, 0.0, 0.04, 4.04],
        (0.0428, 0.0723),
        -0.3,
    ),
    (
        [-13.1, -7.1, -0.9, -0.3, 0.6, 2.6, 3.0, 3.4, 4.2, 4.6, 10.6],
        [4.04, 0.04, 0.0, 0.06, 0.04, 0.04, 0.04, 0.0, 0.04, 0.06, 4.06],
        (0.0144183, 0.0359632),
        -0.285429,
    ),
    (
        [-10.6, -4.6, -4.2, -2.8, -2.2, -2.1, -1.4, -0.9, -0.2, 3.0, 9.0],
        [4.0, 0.0, 0.0, 0.02, 0.02, 0.02, 0.02, 0.0, 0.0, 0.0, 4.0],
        (0.0026743, 0.0057558),
        -0.0228083,
    ),
]


def test_errors_of_lines_that_are_held_at_corners_of_a_polygon_are_known():
    """There nodes are of first order; equal summits touch at once, as soon as they are pressed."""
    ratios, dice = [], np.random.default_rng(2)
    for x, z, works, depth in POLYGONS:
        scene = polygon(x, z, *works)
        path = load_path(scene, depths=[1e-9, depth])
        for spacing in dice.uniform(0.02, 0.08, 12):
            state = minimise(scene, depth, method="lattice", spacing=spacing)
            scales = {"half_width": state.half_width, **state.scales}
            ratios += [
                abs(getattr(state, one) - getattr(path, one)[-1]) / scales[one] / estimate
                for one, estimate in state.error_estimate.items()
            ]
    ratios = np.array(ratios)
    assert np.count_nonzero(ratios > 0) > 60
    assert np.max(ratios) <= 2
