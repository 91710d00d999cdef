"""States and paths on nodes that depend on the way: two works of adhesion, patterns."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import L, plain
from test_controls import SCENES

from discretization import load_path, minimise
from energy import Parabola, PowerLaw, Sampled, Wedge


@pytest.mark.parametrize("name", ["opening", "ripples, pattern", "ripples, both"])
def test_the_parts_of_the_energy_know_the_pattern(name):
    scene = SCENES[name]
    state = minimise(scene, 1.5 * scene.critical_separation, method="lattice", spacing=L / 1000)
    for one, parts in (("energy", state.energy_parts), ("force", state.force_parts)):
        off = abs(sum(parts.values()) - getattr(state, one))
        assert off <= 2e-3 * state.scales[one]


LEVELS = (0.1, 0.05, 0.025, 0.0125)  # spacings
OFFSETS = (1.0, 0.97, 0.93, 0.9)  # of spacings: where nodes are from the lines


def adhering(body, w=0.02, opening=0.03, **options):
    return replace(plain(body, w=w, opening=opening), **options)


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


@pytest.mark.slow
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
