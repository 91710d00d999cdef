"""Integrals over profiles that do not say where they are smooth, and whether their errors do.

The reference integrates each smooth piece by itself: the pieces are polynomials of degree two, so
that twenty Gauss points are exact for small slopes and exact to rounding for finite ones.
"""

import math
import warnings

import mpmath as mp
import numpy as np
import pytest
from support.example_scenes import plain
from support.hostile_scenes import ASKED

from discretization import AccuracyWarning, minimise, quadrature
from discretization.equilibrium import QUANTITIES
from discretization.profile import resolve
from discretization.quadrature import Integrals, refined
from energy import ElasticLayer, FlatPunch, Parabola, PowerLaw, Profile, Sampled, Scene, Wedge

LINES = (-0.83, 1.17)
SIMPLE = {  # cuts, slope at the first, jumps of the slope there, curvature between and beyond
    "rounded punch": ([-0.3, 0.4], 0.0, [0.0, 0.0], [0.5, 0.0, 0.5]),
    "sphero-cone": ([-0.31, 0.31], -0.155, [0.0, 0.0], [0.0, 0.5, 0.0]),
    "flat with a conical rim": ([-0.5, 0.7], -0.2, [0.2, 0.2], [0.0, 0.0, 0.0]),
    "kink": ([0.1234567], 0.0, [0.1], [0.5, 0.5]),
    "kink close to the middle": ([0.1701], 0.05, [0.1], [0.5, 0.5]),
}


class Bent:
    """f of pieces of constant curvature between cuts, with jumps of the slope at them."""

    def __init__(self, cuts, start, jumps, curvature):
        self.cuts, self.jumps, self.curvature = map(np.asarray, (cuts, jumps, curvature))
        width = np.diff(self.cuts)
        bend = self.curvature[1:-1]
        before = start + np.concatenate([[0], np.cumsum(bend * width + self.jumps[:-1])])
        self.slopes = np.append(before[0], before + self.jumps)
        rises = self.slopes[1:-1] * width + bend * width**2 / 2
        self.heights = np.concatenate([[0], [0], np.cumsum(rises)])
        self.at = np.append(self.cuts[0], self.cuts)

    def height(self, x):
        i = np.searchsorted(self.cuts, x, side="right")
        s = np.asarray(x) - self.at[i]
        return self.heights[i] + s * (self.slopes[i] + s * self.curvature[i] / 2)

    def slope(self, x):
        i = np.searchsorted(self.cuts, x, side="right")
        return self.slopes[i] + (np.asarray(x) - self.at[i]) * self.curvature[i]

    def profile(self, convex, known=False):
        corners = self.cuts[self.jumps != 0] if known else ()
        knots = self.cuts[self.jumps == 0] if known else ()
        return Profile(self.height, self.slope, (-50, 50), corners, convex, knots)


def random_bent(rng, convex):
    n = rng.integers(1, 6)
    least = 0 if convex else -0.2
    jumps = rng.uniform(least / 2, 0.2, n) * (rng.random(n) < 0.4) * (rng.random() < 0.5)
    curvature = rng.uniform(least, 0.5, n + 1) * (rng.random(n + 1) < 0.8)
    curvature[[0, -1]] = np.maximum(curvature[[0, -1]], 0.05)
    return Bent(np.sort(rng.uniform(-2, 2, n)), -rng.uniform(0.05, 0.4), jumps, curvature)


def scene_of(indenter, slopes="small", w=0.01, gamma1=1.0):
    return plain(indenter, w=w, gamma1=gamma1, slopes=slopes)


def exact(body, depth, left, right, slopes, w=0.01):
    """Energy and force of a contact without free surfaces, k = γ₁ = 1."""
    t, weights = np.polynomial.legendre.leggauss(20)
    ends = np.array([left, *(c for c in body.cuts if left < c < right), right])
    half = np.diff(ends)[:, None] / 2
    x = ends[:-1, None] + half * (1 + t)
    weights = half * weights
    g = depth - body.height(x)
    s = body.slope(x)
    stretch = np.sqrt(1 + s * s)
    surface = s * s / 2 - w if slopes == "small" else (1 - w) * stretch - 1
    return float((weights * (g * g / 2 + surface)).sum()), float((weights * g).sum())


def compared(one, other, **options):
    """(error, estimate) of a, P and U of states that should be alike; none if one warns."""
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always", AccuracyWarning)
        own, true = (minimise(scene, **options) for scene in (one, other))
    if caught:
        return []
    estimates = [own.error_estimate[name] + true.error_estimate[name] for name in QUANTITIES]
    sizes = (own.half_width, *own.scales.values())
    off = [abs(getattr(own, name) - getattr(true, name)) for name in QUANTITIES]
    return list(zip(np.divide(off, sizes), estimates, strict=True))


def judged(found, truth):
    """(estimate, error) of energy and force over their scales."""
    for name, off, value in zip(("energy", "force"), found.errors, truth, strict=True):
        scale = getattr(found, f"{name}_scale")
        own = getattr(found, name)
        yield off / scale, abs(own - value) / scale


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("name", SIMPLE)
def test_jumps_that_are_not_declared_are_found_by_local_halving(name, slopes):
    body = Bent(*SIMPLE[name])
    points = []
    profile = body.profile(convex=True)
    height = profile.height
    object.__setattr__(profile, "height", lambda x: points.append(np.size(x)) or height(x))
    ends = np.array([LINES])
    fine = refined(scene_of(profile, slopes), 0.1, ends, ())
    for estimate, error in judged(fine, exact(body, 0.1, *LINES, slopes)):
        assert error <= max(10 * estimate, 1e-14)
        assert estimate <= 1e-12
    assert sum(points) <= 100_000


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_integrals_of_random_profiles_are_as_good_as_they_say(slopes):
    rng = np.random.default_rng(None if ASKED else 3)
    for _ in range(ASKED or 100):
        body = random_bent(rng, True)
        convex = rng.random() < 0.5
        left, right = np.sort(rng.uniform(-3, 3, 2)).tolist()
        ends = np.array([[left, right]])
        scene = scene_of(body.profile(convex), slopes)
        depth = float(rng.uniform(-0.1, 1))
        fine = refined(scene, depth, ends, ())
        for estimate, error in judged(fine, exact(body, depth, left, right, slopes)):
            assert error <= max(10 * estimate, 1e-14)
            assert estimate <= 1e-12


def test_the_reference_is_right():
    """Against 30 digits, at a kink."""
    body = Bent(*SIMPLE["kink"])
    cut, (left, right) = float(body.cuts[0]), LINES

    def density(x):
        s = mp.mpf(x) - cut
        slope = s / 2 + (0.1 if s > 0 else 0)
        f = s * s / 4 + (s / 10 if s > 0 else 0)
        return (0.1 - f) ** 2 / 2 + (1 - 0.01) * mp.sqrt(1 + slope**2) - 1

    with mp.workdps(30):
        truth = mp.quad(density, [left, cut, right])
    assert exact(body, 0.1, left, right, "finite")[0] == pytest.approx(float(truth), rel=1e-14)


@pytest.mark.parametrize("slopes", ["small", "finite"])
@pytest.mark.parametrize("convex", [True, False])
def test_states_of_random_profiles_are_as_good_as_they_say(convex, slopes):
    """Against the same profile with its jumps declared, where every panel is smooth."""
    rng = np.random.default_rng(None if ASKED else 4)
    several = 0
    for _ in range(ASKED or 24):
        body = random_bent(rng, True)
        rtol = 10.0 ** rng.choice([-4, -8, -12])
        if not convex and body.jumps.any():  # where lines rest on corners, they have to be known
            continue
        depth = float(rng.uniform(0.05, 0.5))
        w = 0.01 * rng.integers(2)
        depth += float(body.height(np.linspace(-8, 8, 4001)).min())
        scenes = (scene_of(body.profile(convex, known), slopes, w) for known in (False, True))
        for error, estimate in (found := compared(*scenes, depth=depth, rtol=rtol)):
            assert error <= 10 * estimate, (body.cuts, depth)
        several += bool(found)
    assert several >= (ASKED or 24) // 4


@pytest.mark.slow
@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_load_steps_see_jumps_that_are_not_declared(slopes):
    for cut in np.linspace(0.15, 0.2, 149):
        body = Bent([cut], -0.1, [0.2], [0.2, 0.5])
        scenes = [scene_of(body.profile(True, known), slopes) for known in (True, False)]
        profiles = (resolve(one, 0.3) for one in scenes)
        sums = [Integrals.of(*each, 1.0).at(LINES) for each in zip(scenes, profiles, strict=True)]
        assert np.abs(sums[1] - sums[0]).max() <= 1e-12 * np.abs(sums[0]).max()


def test_who_says_where_it_is_smooth():
    own = Profile(np.cosh, np.sinh, knots=(-1.0, 0.5))
    for shape in (
        FlatPunch(1.0),
        Wedge(0.1),
        Parabola(1.0),
        PowerLaw(1.0, 3.0),
        Sampled([0.0, 1.0, 2.0], [1.0, 0.0, 1.0]),
    ):
        moved = (shape.shifted(0.25), shape.tilted(0.1), shape + Parabola(2.0))
        assert all(one.complete for one in (shape, *moved))
        assert not (shape + own).complete
    assert not any(one.complete for one in (own, own.shifted(0.25), own.tilted(0.1)))
    assert own.shifted(0.25).knots.tolist() == [-0.75, 0.75]
    assert own.tilted(0.1).knots == own.knots
    assert (own + PowerLaw(1.0, 3.0)).knots.tolist() == [-1.0, 0.0, 0.5]


@pytest.mark.parametrize(("off", "halved"), [(45, False), (300, True)])
def test_a_difference_by_rounding_is_not_halved(monkeypatch, off, halved):
    """Halves would be rounded as much: weights off by 45 ε stand for a sum that is rounded more."""
    calls = []
    plain = quadrature.over

    def over(*given):
        calls.append(given)
        found = np.array(plain(*given))
        if len(calls) == 1:  # the panels, and after them their halves
            found[:, :, 0] *= 1 + off * np.finfo(float).eps
        return found

    monkeypatch.setattr(quadrature, "over", over)
    found = refined(scene_of(Parabola(2.0)), 0.3, np.array([[-1.0, 1.0]]), ())
    apart = [found.errors[0] / found.energy_scale, found.errors[1] / found.force_scale]
    assert (len(calls) > 1) == halved  # else each panel and its halves once, all at once
    assert halved or 20 * 2.0**-52 <= max(apart) <= 80 * 2.0**-52


def test_noise_is_not_halved_for_ever_and_counts():
    """As of slopes in a contact so narrow that they are all rounding."""
    rng = np.random.default_rng(1)
    read = [0]

    def density(x):
        read[0] += x.size
        return 1 + 1e-6 * rng.standard_normal((1, *x.shape))

    found = quadrature.summed(density, np.array([[0.0], [1.0]]), 1e-15, np.zeros((1, 1)), smooth=1)
    assert read[0] < 5e6
    assert abs(found.sums.sum() - 1) <= found.off.sum() < 1e-5


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_digits_that_a_height_loses_are_counted_in_the_errors(slopes):
    rng = np.random.default_rng(None if ASKED else 6)
    silent = 0
    lost = 0.0
    for _ in range(ASKED or 60):
        R = 10 ** rng.uniform(-2, 2)
        length = R * 10 ** rng.uniform(-4, -0.5)
        rtol = 10.0 ** rng.choice([-4, -8, -12])
        depth = length**2 / R * 10 ** rng.uniform(-1, 1)
        w = length**2 * (length / R) ** 2 * 10 ** rng.uniform(-4, -1.3) * rng.integers(2)
        heights = (
            lambda x, R=R: R * (np.cosh(np.asarray(x) / R) - 1),
            lambda x, R=R: 2 * R * np.sinh(np.asarray(x) / (2 * R)) ** 2,
        )
        bodies = (
            Profile(height, lambda x, R=R: np.sinh(x / R), (-4 * R, 4 * R), convex=True)
            for height in heights
        )
        scenes = (scene_of(body, slopes, w, length**2) for body in bodies)
        for error, estimate in (found := compared(*scenes, depth=depth, rtol=rtol)):
            assert error <= 10 * estimate
            lost = max(lost, error)
        silent += bool(found)
    assert silent >= 10
    assert lost >= 1e-12  # or the heights lost nothing


@pytest.mark.parametrize("convex", [True, False])
def test_contact_far_from_the_origin(convex):
    """A contact far from the origin is found to the rounding of its position."""
    body = Profile(lambda x: x**2 / 2, lambda x: x, (-1, 1), convex=convex)
    scene, far = (scene_of(one, gamma1=1e-4, w=0.0) for one in (body, body.shifted(345.678)))
    own, true = (minimise(one, 1e-6, rtol=1e-4) for one in (far, scene))
    error = abs(own.half_width - true.half_width) / true.half_width
    assert error <= own.error_estimate["half_width"]
    assert own.error_estimate["half_width"] >= 1e-16 * 345.678 / true.half_width


@pytest.mark.parametrize(("convex", "corners"), [(True, (0.0,)), (True, ()), (False, (0.0,))])
def test_a_lone_tip_of_any_profile(convex, corners):
    """Below l tan δ the line of a wedge without adhesion stays at its tip, P = 2kld."""
    profile = Profile(np.abs, np.sign, (-9, 9), corners, convex)
    state = minimise(scene_of(profile, w=0.0), 0.25)
    assert abs(state.half_width) <= 1e-15
    assert state.force == pytest.approx(0.5, rel=1e-12)
    assert state.error_estimate["force"] <= 1e-12


@pytest.mark.parametrize("depth", [0.0, 1e-3])
@pytest.mark.parametrize("shift", [0.0, 0.3, 1e3])
@pytest.mark.parametrize("unit", [1.0, 1e-6])
def test_angles_of_a_lone_tip_at_any_depth(depth, shift, unit):
    x = unit * np.array([-1, 0, 1])
    z = unit * np.array([0.8, -0.2, 0.8])
    scene = scene_of(Sampled(x, z).shifted(shift * unit), w=0.0, gamma1=unit)
    state = minimise(Scene(ElasticLayer(1, 0, unit), scene.surfaces, scene.indenter), depth * unit)
    assert np.ptp(state.contacts) == 0
    assert np.abs(state.line_slopes[0] - 1).max() <= 1e-14 * (1 + shift)
    pull = depth + 0.2
    assert np.allclose(state.contact_angles, math.pi - 1 + pull, rtol=0, atol=1e-9)


def test_slopes_at_the_edge_of_a_curved_body():
    """Slopes at the edge of a curved body are those of its end."""
    for unit in (1e-6, 1.0):
        scene = scene_of(FlatPunch(0.7 * unit) + Parabola(2.0 * unit), w=0.0, gamma1=unit)
        state = minimise(
            Scene(ElasticLayer(1, 0, unit), scene.surfaces, scene.indenter), 1.5 * unit
        )
        assert state.contacts.tolist() == [[-0.7 * unit, 0.7 * unit]]
        assert state.line_slopes[0] == pytest.approx(np.full((1, 2), 0.35), rel=1e-15)
