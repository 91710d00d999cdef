"""Lattice states of any profile against reference solutions, which know no lattice."""

import math
import warnings

import numpy as np
import pytest
from truth.compare import reference
from truth.scenes import case_of

from discretization import AccuracyWarning, load_path, minimise
from discretization.lattice.accuracy import unseen
from discretization.nodes.lattice import Lattice
from energy import ElasticLayer, Profile, Scene, SurfaceEnergies

LEVELS = 4


def ripples(height, wavelength, phase=0.0):
    """x²/2 with ripples, and k = 1."""
    q = 2 * math.pi / wavelength
    return Profile(
        lambda x: np.square(x) / 2 + height * (1 - np.cos(q * np.asarray(x) + phase)),
        lambda x: np.asarray(x) + height * q * np.sin(q * np.asarray(x) + phase),
        extent=(-2, 2),
    )


def scene_of(indenter, gamma1, w):
    return Scene(ElasticLayer(1, 0.0, 1.0), SurfaceEnergies.from_work(gamma1, w), indenter)


def spacing_of(case):
    length = case.scene.elastocapillary_length or case.feature
    return min(length / 12, case.feature / 8)


def on_nodes(case, spacing):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # the coarser levels
        return minimise(case.scene, case.depth, method="lattice", spacing=spacing)


def errors_of(kind, seeds):
    """Errors of P (n, LEVELS) on nodes of the spacing that resolves a case, half of it, ..."""
    found = []
    for seed in seeds:
        case = case_of(kind, seed)
        truth, _ = reference(case)
        if truth is None or not resolved(case, truth.half_width):
            continue
        states = [on_nodes(case, spacing_of(case) / 2**level) for level in range(LEVELS)]
        found.append([abs(state.force - truth.force) / truth.force_scale for state in states])
    return np.array(found)


def resolved(case, half_width):
    """Whether the case is not too long for a test, and its contacts not too small for its nodes."""
    lo, hi = case.scene.indenter.extent
    return (hi - lo) / spacing_of(case) < 2e4 and half_width > spacing_of(case)


def test_contacts_that_began_on_the_way_stay():
    """A single contact is in equilibrium here, too, but the path has three."""
    scene = scene_of(ripples(0.01, 0.2), 0.0025, 1.25e-5)
    state = minimise(scene, 0.03, method="lattice", spacing=1e-3)
    assert len(state.contacts) == 3
    assert state.force == pytest.approx(0.0066820, abs=5e-8)
    path = load_path(scene, depths=[0.0, 0.01, 0.03], method="lattice", spacing=1e-3)
    assert path.force[-1] == pytest.approx(state.force, rel=5e-3)
    assert len(path.inner[-1]) == 4


@pytest.mark.parametrize("first", range(0, 60, 20)[:2])
def test_adhered_states_are_those_of_the_walk(first):
    seen = 0
    for seed in range(first, first + 10):
        case = case_of("small", seed)
        truth, _ = reference(case)
        if truth is None or not resolved(case, truth.half_width):
            continue
        state = on_nodes(case, spacing_of(case) / 8)
        assert len(state.contacts) == len(truth.contacts), seed
        assert abs(state.force - truth.force) <= 2e-3 * truth.force_scale, seed
        seen += 1
    assert seen >= 3


def test_without_adhesion_the_force_converges_with_second_order():
    """The worst are the narrowest contacts: a few links wide on the coarsest nodes."""
    errors = errors_of("no_adhesion", range(12))
    usual, worst = np.median(errors, axis=0), errors.max(axis=0)
    assert len(errors) >= 4
    assert worst[-1] <= 1e-5
    assert 3.5 < (usual[0] / usual[-1]) ** (1 / (LEVELS - 1)) < 5


@pytest.mark.parametrize("spacing", [0.2, 0.15])
def test_ripples_narrower_than_the_spacing_give_a_warning(spacing):
    scene = scene_of(ripples(0.01, 0.2, 1.0), 0.0025, 1.25e-5)
    with pytest.warns(AccuracyWarning, match="narrower than the spacing"):
        minimise(scene, 0.03, method="lattice", spacing=spacing)
    with pytest.warns(AccuracyWarning, match="narrower than the spacing"):
        load_path(scene, depths=[0.0, 0.03], method="lattice", spacing=spacing)
    minimise(scene, 0.03, method="lattice", spacing=0.01)  # and none where they are resolved


def test_a_tip_between_the_nodes_gives_a_warning_where_the_surface_is_above_it():
    """A tip of width 0.02 at x = 0.55, one deep enough and one that is not."""

    def body(deep):
        return Profile(
            lambda x: np.square(x) / 2 - deep * np.exp(-(((np.asarray(x) - 0.55) / 0.01) ** 2)),
            lambda x: (
                np.asarray(x)
                + 2e4 * deep * (np.asarray(x) - 0.55) * np.exp(-(((x - 0.55) / 0.01) ** 2))
            ),
            extent=(-2, 2),
        )

    with pytest.warns(AccuracyWarning, match=r"at x = 0\.5[45]"):
        minimise(scene_of(body(0.3), 0.01, 1e-4), 0.01, method="lattice", spacing=0.1)
    quiet = scene_of(body(0.13), 0.01, 1e-4)
    assert unseen(quiet, 0.01, Lattice.of(quiet, 0.1)).x.size
    minimise(quiet, 0.01, method="lattice", spacing=0.1)


def test_a_contact_between_two_nodes_gives_a_warning():
    body = Profile(
        lambda x: 2 * (np.asarray(x) - 0.05) ** 2, lambda x: 4 * (np.asarray(x) - 0.05), (-2, 2)
    )
    with pytest.warns(AccuracyWarning, match="narrower than the spacing"):
        state = minimise(scene_of(body, 0.01, 0.0), 1e-3, method="lattice", spacing=0.1)
    assert not state.contacts.size


def test_contacts_narrower_than_two_links_are_known_to_their_own_size():
    body = Profile(lambda x: 20 * np.square(x), lambda x: 40 * np.asarray(x), extent=(-1, 1))
    state = minimise(scene_of(body, 0.04, 1e-4), 1e-3, method="lattice", spacing=0.05)
    assert state.contacts.size and np.diff(state.nodes).max() <= 0.05
    assert min(state.error_estimate.values()) >= 1
    fine = minimise(scene_of(body, 0.04, 1e-4), 1e-3, method="lattice", spacing=5e-4)
    assert max(fine.error_estimate.values()) <= 0.1
