"""The spectral free surface of one line, and of two."""

import itertools
import math

import numpy as np
import pytest
from scipy.special import i0e, i1e, k0e, k1e

from discretization.surfaces import surfaces_of
from discretization.surfaces.finite_gap import tail, tails
from discretization.surfaces.network import endless
from discretization.surfaces.protocol import At
from discretization.surfaces.rings import stiffness
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards


def test_the_linear_free_surface_converges_spectrally():
    errors = [abs(endless(degree) - 1) for degree in (1, 2, 3, 4)]
    assert all(after <= 0.1 * before for before, after in itertools.pairwise(errors))
    assert abs(endless(10) - 1) <= 1e-14


@pytest.mark.parametrize("side", [1, -1])
def test_the_free_surface_about_an_axis_is_that_of_bessel_functions(side):
    s = 2.0 ** np.linspace(-25, 10, 800)
    exact = k1e(s) / k0e(s) if side > 0 else i1e(s) / i0e(s)
    assert stiffness(12, side, s) == pytest.approx(exact, rel=2e-14, abs=0)


def test_the_steep_free_surface_obeys_its_own_first_integral():
    displaced = np.array([-1.3, -0.4, 1e-4, 0.7, 1.2, 1.41])
    for u, energy, pull in zip(displaced, *tails(displaced), strict=True):
        surface, phi, rounding = tail(float(u)), 2 * math.asin(u / 2), 1e-12 * abs(u)
        assert abs(pull - math.sin(phi)) <= rounding and abs(surface.area - pull) <= rounding
        assert surface.reactions[0] == pytest.approx(pull, rel=1e-15)
        assert surface.residual <= 1e-12
        assert abs(math.atan(float(surface.at(np.zeros(1), np.full(1, 40.0))[1][0])) + phi) <= 1e-9
        exact = cards.finite.tail_energy(u, k=1.0, gamma1=1.0)
        assert surface.energy == pytest.approx(exact, rel=1e-12, abs=0)
        assert energy == pytest.approx(exact, rel=1e-12, abs=0)
        heights = abs(u) * np.array([0.9, 0.6, 0.3])
        x = cards.finite.meniscus(heights, u_a=abs(u), k=1.0, gamma1=1.0)
        found = surface.at(x, surface.length - x)[0]
        assert np.abs(np.abs(found) - heights).max() <= 1e-12


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_a_gap_of_any_width_moves_its_lines_by_what_it_pulls(geometry):
    """Where it hardly displaces one of them, too: without adhesion a tip has just touched there."""
    surfaces = SurfaceEnergies.from_work(1.0, 0.0)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, Parabola(1.0), geometry=geometry)
    free = surfaces_of(scene).free
    for width in (1e-6, 1e-2, 1.0, 30.0, 39.5, 40.5, 59.0, 90.0):
        for u, v in ((0.1, 1e-13), (1e-13, 0.1), (0.1, 0.1)):
            assert free(At(2.0, -u), At(2.0 + width, -v), 0.0).residual <= 1e-12
