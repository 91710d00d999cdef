"""The spectral free surface of one line, and of two."""

import math

import numpy as np
import pytest

from discretization.surfaces import surfaces_of
from discretization.surfaces.finite_gap import tail, tails
from discretization.surfaces.mesh import linear
from discretization.surfaces.protocol import At
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards


def test_the_linear_free_surface_converges_spectrally():
    errors = [abs(linear(degree).reaction - 1) for degree in (2, 4, 6)]
    assert errors[0] <= 1e-3
    assert errors[1] <= 1e-3 * errors[0]
    assert errors[2] <= 1e-4 * errors[1]
    best = linear(10)
    assert abs(best.reaction - 1) <= 1e-14
    assert abs(best.slope + 1) <= 1e-13
    assert abs(best.area - 1) <= 1e-14


def test_the_steep_free_surface_obeys_its_own_first_integral():
    displaced = np.array([-1.3, -0.4, 1e-4, 0.7, 1.2, 1.41])
    for u, energy, pull in zip(displaced, *tails(displaced), strict=True):
        read, phi = tail(float(u)), 2 * math.asin(u / 2)
        surface, rounding = read.relaxed, 1e-12 * abs(u)
        assert abs(pull - math.sin(phi)) <= rounding and abs(surface.area - pull) <= rounding
        assert read.reactions[0] == pytest.approx(pull, rel=1e-15)
        assert abs(surface.reactions[0] - pull) <= rounding and surface.residual <= 1e-12
        assert abs(math.atan(surface.slope) + phi) <= 1e-9
        exact = cards.finite.tail_energy(u, k=1.0, gamma1=1.0)
        assert surface.energy == pytest.approx(exact, rel=1e-12, abs=0)
        assert energy == pytest.approx(exact, rel=1e-12, abs=0)
        heights = abs(u) * np.array([0.9, 0.6, 0.3])
        x = cards.finite.meniscus(heights, u_a=abs(u), k=1.0, gamma1=1.0)
        assert np.abs(np.abs(surface.displacement(x)) - heights).max() <= 1e-12


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_a_gap_of_any_width_moves_its_lines_by_what_it_pulls(geometry):
    """Where it hardly displaces one of them, too: without adhesion a tip has just touched there."""
    surfaces = SurfaceEnergies.from_work(1.0, 0.0)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, Parabola(1.0), geometry=geometry)
    free = surfaces_of(scene).free
    for width in (1e-6, 1e-2, 1.0, 30.0, 39.5, 40.5, 59.0, 90.0):
        for u, v in ((0.1, 1e-13), (1e-13, 0.1), (0.1, 0.1)):
            assert free(At(2.0, -u), At(2.0 + width, -v), 0.0).residual <= 1e-12
