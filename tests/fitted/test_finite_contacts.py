"""Several contacts with finite slopes: their gaps; against single ones, small slopes, energies."""

import math
from dataclasses import replace

import numpy as np
import pytest
from scenes import DELTA0, L, adhesive, steep, two, wavy
from truth.surfaces import Finite

from discretization import load_path, minimise
from discretization.surfaces.finite_gap import solved
from discretization.surfaces.finite_range import DEGREE, rest_displacement
from energy import Parabola, Profile

DEPTH = 2.0 * DELTA0
EPSILON = float(np.finfo(float).eps)
REFERENCE = Finite(adhesive(Parabola(1.0), k=1.0, gamma1=1.0, w=0.01, slopes="finite"))


def finite(w=0.002, **given):
    """Six crests 2 l apart."""
    return replace(wavy(w, crests=6, **given), slopes="finite")


def flattened(share, slopes):
    """The same, all heights and √w a share of what they are; the slopes are too."""
    body, scene = wavy(crests=6).indenter, adhesive(Parabola(1.0), w=0.002 * share**2)
    lower = Profile(
        lambda x: share * body.height(x), lambda x: share * body.slope(x), extent=body.extent
    )
    return replace(scene, indenter=lower, slopes=slopes)


def lips(c, inner, outer):
    """Lips at ±c, of these radii towards each other and away from each other."""

    def radius(x):
        return np.where(np.abs(x) < c, inner, outer)

    return Profile(
        lambda x: (np.abs(np.asarray(x, float)) - c) ** 2 / radius(x),
        lambda x: 2 * np.sign(x) * (np.abs(np.asarray(x, float)) - c) / radius(x),
        extent=(-4 * c, 4 * c),
        corners=(0.0,),
    )


def gaps(count=60):
    """u at both lines and the length of random gaps that do not turn over."""
    rng, found = np.random.default_rng(2), []
    while len(found) < count:
        length, size = 10 ** rng.uniform(-5, 1.5), 10 ** rng.uniform(-2, 0.1)
        left, rise = rng.uniform(-1, 1, 2) * size
        rise = left + 4 * rise * min(length, 1.0) - left  # as the reference knows it
        ends = np.array([left, left + rise])
        if np.abs(REFERENCE.facing(ends, ends[::-1], length)).max() < 1.5:
            found.append((left, rise, length))
    return found


@pytest.fixture(scope="module")
def states():
    return {w: minimise(finite(w), DEPTH) for w in (0.0, 0.002)}


def test_a_gap_is_that_of_its_first_integral():
    for left, rise, length in gaps():
        right, found = left + rise, solved(left, rise, length)
        pulls = -np.sin(REFERENCE.facing(np.array([left, right]), np.array([right, left]), length))
        assert found.residual <= 1e-12
        assert np.allclose(found.reactions, pulls, rtol=0, atol=1e-12)
        assert found.area == pytest.approx(pulls.sum(), rel=0, abs=1e-14 + 1e-12 * length)
        assert found.energy == pytest.approx(REFERENCE.gap_energy(left, right, length), rel=1e-12)
        x = np.linspace(0, length, 23)
        shape = REFERENCE.gap_shape(x, length, left, right)
        u, slope = found.at(x, length - x)
        assert np.allclose(u, shape, rtol=0, atol=1e-12)
        inclined = np.arctan(slope[[0, -1]])
        assert np.allclose(inclined, [-1, 1] * np.arcsin(pulls), rtol=0, atol=1e-11)


def test_a_gap_notices_what_is_not_its_minimum():
    found = solved(0.3, 0.4, 0.9)
    bent = 1e-6 * np.sin(np.arange(found.rises.size)).reshape(found.rises.shape)
    assert replace(found, rises=found.rises + bent).residual > 1e-9
    assert replace(found, p=found.p + bent).residual > 1e-9
    assert replace(found, left=found.left + 1e-6).residual > 1e-9


def test_the_displacement_at_rest_has_the_inclination_asked_for():
    left, rise, length = np.array(gaps()).T
    p = 2 * np.sin(REFERENCE.facing(left, left + rise, length) / 2)
    near = np.minimum(length, 1.0)
    assert np.allclose((rest_displacement(p, rise, length) - left) * near, 0, atol=1e-13)
    for own, up, apart, u in zip(p.tolist(), rise.tolist(), length.tolist(), left, strict=True):
        found = rest_displacement(own, up, apart)
        assert (found - u) * min(apart, 1.0) == pytest.approx(0.0, abs=1e-13)


def test_the_energy_of_a_gap_changes_by_its_reactions_and_its_first_integral():
    for left, rise, length in [(0.3, 0.4, 0.9), (-0.7, 0.2, 5.0), (0.2, -0.05, 0.05)]:
        step, found = 1e-3 * min(length, 1.0), solved(left, rise, length)

        def rate(*way, at=(left, rise, length), step=step):
            energy = {
                n: solved(*(a + n * step * b for a, b in zip(at, way, strict=True))).energy
                for n in (-2, -1, 1, 2)
            }
            return (8 * (energy[1] - energy[-1]) - (energy[2] - energy[-2])) / (12 * step)

        own, other = found.reactions
        assert rate(1.0, -1.0, 0.0) == pytest.approx(own, rel=0, abs=1e-9)
        assert rate(0.0, 1.0, 0.0) == pytest.approx(other, rel=0, abs=1e-9)
        first = left**2 / 2 + math.sqrt(1 - own**2) - 1
        assert rate(0.0, 0.0, 1.0) == pytest.approx(first, rel=0, abs=1e-9)


def test_a_surface_that_turns_over_is_refused():
    assert solved(1.42, 0.0, 30.0).upright
    assert not solved(1.41, 0.0, 30.0).upright
    lower = rest_displacement(np.full(9, 0.3), np.linspace(0.1, 9.0, 9), 0.7)
    assert lower[1] - lower[0] > 0.1
    # falls short of the line: one problem, whose sum over 2 (DEGREE + 1) nodes, which rounds by
    # half an EPSILON each, gives the range, to which u is 1.5 times as sensitive; of two rows
    assert np.ptp(lower[2:]) <= 2 * 1.5 * (DEGREE + 1) * EPSILON * lower[2]
    scene = steep(lips(2 * L, 0.5 * L, 0.05 * L), ratio=1.9)
    assert len(minimise(scene, -0.5 * L).contacts) == 2
    with pytest.raises(ValueError, match=r"depth = .*between the contact lines.*turn over"):
        minimise(scene, -1.0 * L)


@pytest.mark.parametrize("w", [0.0, 0.002])
def test_states_are_certified_and_have_youngs_angle(states, w):
    state = states[w]
    assert len(state.contacts) >= 5 and state.method == "fitted" and state.certificate.ok
    assert max(state.error_estimate.values()) <= 1e-8
    deficit = 2 * math.asin(math.sqrt(w / (2 * state.scene.gamma1)))
    assert np.abs(state.angle_deficits[~state.pinned] - deficit).max() <= 1e-11
    assert sum(state.energy_parts.values()) == pytest.approx(state.energy, rel=1e-10, abs=0)
    assert sum(state.force_parts.values()) == pytest.approx(state.force, rel=1e-10, abs=0)


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.0, 0.002])
def test_the_force_is_the_derivative_of_the_energy(states, w):
    state, step = states[w], 1e-3 * DELTA0
    energies = {n: minimise(state.scene, DEPTH + n * step).energy for n in (-2, -1, 1, 2)}
    change = 8 * (energies[1] - energies[-1]) - (energies[2] - energies[-2])
    assert change / (12 * step) == pytest.approx(state.force, rel=1e-9, abs=0)


@pytest.mark.parametrize("w", [0.0, 0.002])
def test_the_mirror_image_has_the_mirrored_state(states, w):
    here, there = states[w], minimise(finite(w, mirror=True), DEPTH)
    assert np.abs(there.contacts[::-1, ::-1] + here.contacts).max() <= 1e-11 * L
    assert there.force == pytest.approx(here.force, rel=1e-12, abs=0)
    assert there.energy == pytest.approx(here.energy, rel=1e-12, abs=0)
    x = np.linspace(here.contacts[0, 0], here.contacts[-1, 1], 200)
    assert np.abs(there.displacement(-x) - here.displacement(x)).max() <= 1e-11 * DELTA0


@pytest.mark.parametrize(("unit", "stress"), [(1e-6, 3e4), (1e3, 1e-7)])
def test_no_unit_enters(states, unit, stress):
    here, there = states[0.002], minimise(finite(unit=unit, stress=stress), DEPTH * unit)
    assert np.abs(there.contacts / unit - here.contacts).max() <= 1e-11 * L
    assert there.force / (stress * unit) == pytest.approx(here.force, rel=1e-11, abs=0)


@pytest.mark.parametrize("w", [0.0, 0.002])
def test_contacts_many_decay_lengths_apart_are_single_ones(w):
    c, depth = 60 * L, 0.4 * DELTA0
    both, one, other = (
        minimise(adhesive(body, w=w, slopes="finite"), d)
        for body, d in (
            (two(c, lift=0.1 * DELTA0), depth),
            (Parabola(0.005).shifted(-c), depth - 0.1 * DELTA0),
            (Parabola(0.003).shifted(c), depth),
        )
    )
    assert np.allclose(both.contacts, [*one.contacts, *other.contacts], rtol=0, atol=1e-10 * L)
    assert both.force == pytest.approx(one.force + other.force, rel=1e-10, abs=0)
    assert both.energy == pytest.approx(one.energy + other.energy, rel=1e-10, abs=0)
    x = np.linspace(-3 * L, 3 * L, 50)
    assert np.allclose(both.displacement(c + x), other.displacement(c + x), rtol=1e-9, atol=0)


def test_finite_slopes_tend_to_small_ones_as_w_over_gamma1():
    off, shares = [], 0.5 ** np.arange(4)
    for share in shares.tolist():
        small, steeper = (minimise(flattened(share, s), share * DEPTH) for s in ("small", "finite"))
        assert len(small.contacts) == len(steeper.contacts) >= 5
        lines = np.abs(small.contacts - steeper.contacts).max() / L
        off.append((lines, abs(small.force / steeper.force - 1)))
    for errors in np.transpose(off):
        assert 1.9 <= np.polyfit(np.log(shares), np.log(errors), 1)[0] <= 2.1
        assert errors[-1] <= 1e-3


def test_a_contact_begins_in_a_gap_where_its_surface_touches():
    at, lifts = np.array([-2.0, 0.0, 2.0])[:, None] * L, np.array([[0.05], [0.4], [0.0]]) * DELTA0

    def heights(x):
        return (np.ravel(x) - at) ** 2 / (0.3 * L) + lifts

    def slope(x):
        nearest = np.argmin(heights(x), axis=0)
        return (2 * (np.ravel(x) - at[nearest, 0]) / (0.3 * L)).reshape(np.shape(x))

    valleys = (at[1:] + at[:-1] + 0.3 * L * np.diff(lifts, axis=0) / np.diff(at, axis=0)) / 2
    body = Profile(
        lambda x: heights(x).min(axis=0).reshape(np.shape(x)),
        slope,
        (-5 * L, 5 * L),
        valleys[:, 0].tolist(),
    )
    scene = adhesive(body, slopes="finite")
    begun = load_path(scene, depths=np.array([-0.1, 1.0]) * DELTA0).events[-1]
    assert begun.kind == "nucleation" and len(begun.before.inner) == 2
    state = minimise(scene, begun.depth * (1 - 1e-7))
    assert len(state.contacts) == 2
    x = np.linspace(-0.05 * L, 0.05 * L, 2001)
    clearance = state.displacement(x) - (begun.depth - body.height(x))
    assert clearance.min() == pytest.approx(0.0, rel=0, abs=1e-6 * DELTA0)


def test_a_load_path_ends_in_the_adhered_states_and_its_energy_balances():
    scene = adhesive(two(1.2 * L, lift=0.1 * DELTA0), slopes="finite")
    depths = np.array([-0.1, 0.5, -0.8, -1.3]) * DELTA0
    path = load_path(scene, depths=depths)
    assert [e.kind for e in path.events] == ["jump-in", "nucleation", "closing", "detachment"]
    for i in (1, 2):
        state, lines = minimise(scene, depths[i]), path.at(i).lines
        assert len(state.contacts) == 2 or i == 2
        if len(lines) == state.contacts.size:
            assert np.allclose(lines, state.contacts.ravel(), rtol=0, atol=1e-11 * L)
    second, top = path.events[1].after, path.at(1)
    points, weights = np.polynomial.legendre.leggauss(10)
    half = (top.depth - second.depth) / 2
    forces = [minimise(scene, second.depth + half * (1 + t)).force for t in points.tolist()]
    assert top.energy - second.energy == pytest.approx(half * weights @ forces, rel=1e-9, abs=0)
