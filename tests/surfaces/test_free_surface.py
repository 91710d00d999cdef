"""The spectral free surface of one line, and of two."""

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import minimize_scalar
from scipy.special import i0e, i1e, k0e, k1e
from support.comparison import check
from support.example_scenes import L, adhesive, plain, steep
from truth import meniscus
from truth.surfaces import Finite

from discretization import minimise
from discretization.fitted.rest_depths import surfaces_of
from discretization.surfaces.finite_gap import DEGREE, rest_displacement, single
from discretization.surfaces.network import Line, semi_infinite_stiffness
from discretization.surfaces.protocol import LinePosition
from discretization.surfaces.rings import stiffness
from energy import Circle, ElasticLayer, FlatPunch, Parabola, Profile, Scene, SurfaceEnergies, cards


def test_the_linear_free_surface_converges_spectrally():
    errors = [abs(semi_infinite_stiffness(degree) - 1) for degree in (1, 2, 3, 4)]
    assert all(after <= 0.1 * before for before, after in itertools.pairwise(errors))
    assert abs(semi_infinite_stiffness(10) - 1) <= 1e-14


@pytest.mark.parametrize("side", [1, -1])
def test_free_surface_about_an_axis_bessel(side):
    """The free surface about an axis is that of Bessel functions."""
    s = 2.0 ** np.linspace(-25, 10, 800)
    exact = k1e(s) / k0e(s) if side > 0 else i1e(s) / i0e(s)
    assert stiffness(side, s) == pytest.approx(exact, rel=2e-14, abs=0)


def test_the_steep_free_surface_obeys_its_own_first_integral():
    displaced = np.array([-1.3, -0.4, 1e-4, 0.7, 1.2, 1.41])
    for u in displaced:
        surface = single(float(u), -float(u), math.inf)
        phi = 2 * math.asin(u / 2)
        rounding = 1e-12 * abs(u)
        pull = float(surface.pulls.sum())
        assert abs(pull - math.sin(phi)) <= rounding
        assert abs(surface.area - pull) <= rounding
        assert surface.pulls[0] == pytest.approx(pull, rel=1e-15)
        assert surface.residual <= 1e-12
        assert abs(math.atan(float(surface.at(np.zeros(1), np.full(1, 40.0))[1][0])) + phi) <= 1e-9
        exact = cards.finite.tail_energy(u, k=1.0, gamma1=1.0)
        assert surface.energy == pytest.approx(exact, rel=1e-12, abs=0)
        heights = abs(u) * np.array([0.9, 0.6, 0.3])
        x = cards.finite.meniscus(heights, u_a=abs(u), k=1.0, gamma1=1.0)
        found = surface.at(x, 40.0 - x)[0]
        assert np.abs(np.abs(found) - heights).max() <= 1e-12


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_a_gap_of_any_width_moves_its_lines_by_what_it_pulls(geometry):
    """Where it hardly displaces one of them, too: without adhesion a tip has just touched there."""
    scene = replace(plain(Parabola(1.0), w=0.0), geometry=geometry)
    free = surfaces_of(scene).solve
    for width in (1e-6, 1e-2, 1.0, 30.0, 39.5, 40.5, 59.0, 90.0):
        for u, v in ((0.1, 1e-13), (1e-13, 0.1), (0.1, 0.1)):
            assert free(LinePosition(2.0, -u), LinePosition(2.0 + width, -v), 0.0).residual <= 1e-12


EPSILON = float(np.finfo(float).eps)


REFERENCE = Finite(adhesive(Parabola(1.0), k=1.0, gamma1=1.0, w=0.01, slopes="finite"))


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
    rng = np.random.default_rng(2)
    found = []
    while len(found) < count:
        length = 10 ** rng.uniform(-5, 1.5)
        size = 10 ** rng.uniform(-2, 0.1)
        left, rise = rng.uniform(-1, 1, 2) * size
        rise = left + 4 * rise * min(length, 1.0) - left  # as the reference knows it
        ends = np.array([left, left + rise])
        if np.abs(REFERENCE.facing(ends, ends[::-1], length)).max() < 1.5:
            found.append((left, rise, length))
    return found


def test_a_gap_is_that_of_its_first_integral():
    for left, rise, length in gaps():
        right = left + rise
        found = single(left, rise, length)
        pulls = -np.sin(REFERENCE.facing(np.array([left, right]), np.array([right, left]), length))
        assert found.residual <= 1e-12
        assert np.allclose(found.pulls[:, 0], pulls, rtol=0, atol=1e-12)
        assert found.area == pytest.approx(pulls.sum(), rel=0, abs=1e-14 + 1e-12 * length)
        assert found.energy == pytest.approx(REFERENCE.gap_energy(left, right, length), rel=1e-12)
        x = np.linspace(0, length, 23)
        shape = REFERENCE.gap_shape(x, length, left, right)
        u, slope = found.at(x, length - x)
        assert np.allclose(u, shape, rtol=0, atol=1e-12)
        inclined = np.arctan(slope[[0, -1]])
        assert np.allclose(inclined, [-1, 1] * np.arcsin(pulls), rtol=0, atol=1e-11)


def test_a_gap_notices_what_is_not_its_minimum():
    found = single(0.3, 0.4, 0.9)
    bent = 1e-6 * np.sin(np.arange(found.rises.size)).reshape(found.rises.shape)
    assert replace(found, rises=found.rises + bent).residual > 1e-9
    assert replace(found, p=found.p + bent).residual > 1e-9
    assert replace(found, u=found.u + 1e-6).residual > 1e-9


def test_the_displacement_at_rest_has_the_inclination_asked_for():
    left, rise, length = np.array(gaps()).T
    p = 2 * np.sin(REFERENCE.facing(left, left + rise, length) / 2)
    near = np.minimum(length, 1.0)
    assert np.allclose((rest_displacement(p, rise, length) - left) * near, 0, atol=1e-13)
    for own, up, apart, u in zip(p.tolist(), rise.tolist(), length.tolist(), left, strict=True):
        found = rest_displacement(own, up, apart)
        assert (found - u) * min(apart, 1.0) == pytest.approx(0.0, abs=1e-13)


def test_energy_of_a_gap_and_its_first_integral():
    """The energy of a gap changes by its reactions and its first integral."""
    for left, rise, length in [(0.3, 0.4, 0.9), (-0.7, 0.2, 5.0), (0.2, -0.05, 0.05)]:
        step = 1e-3 * min(length, 1.0)
        found = single(left, rise, length)

        def rate(*way, at=(left, rise, length), step=step):
            energy = {
                n: single(*(a + n * step * b for a, b in zip(at, way, strict=True))).energy
                for n in (-2, -1, 1, 2)
            }
            return (8 * (energy[1] - energy[-1]) - (energy[2] - energy[-2])) / (12 * step)

        own, other = found.pulls[:, 0]
        assert rate(1.0, -1.0, 0.0) == pytest.approx(own, rel=0, abs=1e-9)
        assert rate(0.0, 1.0, 0.0) == pytest.approx(other, rel=0, abs=1e-9)
        first = left**2 / 2 + math.sqrt(1 - own**2) - 1
        assert rate(0.0, 0.0, 1.0) == pytest.approx(first, rel=0, abs=1e-9)


def test_a_surface_that_turns_over_is_refused():
    assert single(1.42, 0.0, 30.0).upright
    assert not single(1.41, 0.0, 30.0).upright
    lower = rest_displacement(np.full(9, 0.3), np.linspace(0.1, 9.0, 9), 0.7)
    assert lower[1] - lower[0] > 0.1
    # falls short of the line: one problem, whose sum over 2 (DEGREE + 1) nodes, which rounds by
    # half an EPSILON each, gives the range, to which u is 1.5 times as sensitive; of two rows
    assert np.ptp(lower[2:]) <= 2 * 1.5 * (DEGREE + 1) * EPSILON * lower[2]
    scene = steep(lips(2 * L, 0.5 * L, 0.05 * L), ratio=1.9)
    assert len(minimise(scene, -0.5 * L).contacts) == 2
    with pytest.raises(ValueError, match=r"depth = .*between the contact lines.*turn over"):
        minimise(scene, -1.0 * L)


@pytest.mark.parametrize("degree", [6, 8, 10, 12])
def test_a_gap_converges_to_rounding_at_any_width(degree):
    """σ = tanh(L/2) and σ + 2τ = coth(L/2)."""
    allowed = {6: 2e-12}.get(degree, 4e-15)
    line = Line(degree)
    for length in 10.0 ** np.linspace(-8, 1.8, 40):
        found = line.between(1, 0.0, float(length))
        odd = found.left + 2 * found.tie
        assert found.left == found.right == pytest.approx(math.tanh(length / 2), rel=allowed, abs=0)
        assert odd == pytest.approx(1 / math.tanh(length / 2), rel=allowed, abs=0)


def test_energy_of_a_gap_over_its_length():
    """The energy of a gap changes with its length by its derivative."""
    for length in (0.01, 0.4, 3.0, 17.0):
        step = 1e-3 * min(length, 1.0)
        low, high, lower, higher = (
            Line(8).between(1, 0.0, length + n * step) for n in (-1, 1, -2, 2)
        )
        found, moved = (Line(8).between(1, 0.0, each) for each in (length, complex(length, 1e-30)))
        for name in ("left", "tie"):
            change = 8 * (getattr(high, name) - getattr(low, name))
            change -= getattr(higher, name) - getattr(lower, name)
            exact = getattr(moved, name).imag / 1e-30
            size = (found.left + 2 * found.tie) * 1e-11 / min(length, 1.0)
            assert change / (12 * step) == pytest.approx(exact, rel=1e-9, abs=size)


axi = cards.axisymmetric


@pytest.mark.parametrize("radius", [1e-4, 1e-2, 1.0, 30.0, 1e6])
def test_faint_surfaces_are_those_of_small_slopes(radius):
    layer = {"a": radius, "k": 1.0, "gamma1": 1.0}
    phi = 1e-5
    found = meniscus.outside(radius, phi)
    check(axi.surface.slope_at_line(found.height, **layer), -phi, phi**2)
    check(2 * np.pi * found.energy, axi.surface.energy(found.height, **layer), phi**2)


@pytest.mark.slow
@pytest.mark.parametrize("phi", [np.radians(45), np.radians(80)])
def test_both_laws_of_the_meniscus_are_its_limits(phi):
    narrow = np.array([0.1, 0.03, 0.01, 0.003, 0.001])
    wide = np.array([10.0, 30, 100, 300, 1e3])
    layer = {"k": 1.0, "gamma1": 1.0}
    off = [
        meniscus.outside(a, phi, 1e-11).height / axi.finite.height_narrow(phi, a=a, **layer) - 1
        for a in narrow
    ]
    slowly = np.log(1 / narrow)  # a² ln (1/a) to a constant factor
    order = np.polyfit(np.log(narrow), np.log(np.abs(off) / slowly), 1)[0]
    assert 1.7 < order < 2.4
    assert abs(off[-1]) < 1e-5
    off = [
        meniscus.outside(a, phi, 1e-11).height / axi.finite.height_wide(phi, a=a, **layer) - 1
        for a in wide
    ]
    assert -2.1 < np.polyfit(np.log(wide), np.log(np.abs(off)), 1)[0] < -1.9
    assert abs(off[-1]) < 1e-6


def scene_of(indenter, w=0.02):
    layer = ElasticLayer(2.5e3, 0.3, 5e-6)  # l = 10 µm
    surfaces = SurfaceEnergies.from_work(0.07, w)
    return Scene(layer, surfaces, indenter, slopes="finite", geometry="axisymmetric")


@pytest.mark.slow
@pytest.mark.parametrize("w", [0.007, 0.1])
def test_a_small_sphere_is_pulled_off_a_liquid(w):
    """F_A = πRw at R/l = 1e-2; at R/l = 1 the springs are felt."""
    pulls = []
    for ratio in (1e-2, 1.0):
        scene = scene_of(Circle(ratio * 1.0198e-5), w)
        R = scene.indenter.R
        deficit = scene.surfaces.angle_deficit
        least = minimize_scalar(
            lambda b, scene=scene, R=R: meniscus.state(scene, R * np.sin(b), 1e-8).force,
            bounds=(0.3 * deficit, min(0.7 * deficit, 1.5)),
            method="bounded",
            options={"xatol": 1e-4},
        )
        pulls.append(-least.fun / axi.finite.adhesion_force_small_sphere(R=R, w=w))
    assert abs(pulls[0] - 1) < 1e-3
    assert abs(pulls[1] - 1) > 0.02


def test_the_edge_of_a_punch_and_a_surface_that_is_no_graph():
    scene = scene_of(FlatPunch(1e-5), 0.02)
    found = meniscus.state(scene, 1e-5)  # where the line comes free of the edge
    assert found.depth < 0
    assert found.force < 0
    with pytest.raises(ValueError, match="overhang"):
        meniscus.state(scene_of(FlatPunch(1e-5), 0.08), 1e-5)
