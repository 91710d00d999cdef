"""The spectral free surface, and how wrong what is read of it may be."""

import math

import numpy as np
import pytest

from discretization.surfaces import surfaces_of
from discretization.surfaces.mesh import linear
from discretization.surfaces.protocol import At
from discretization.surfaces.response import DEGREES, chosen, response
from discretization.surfaces.spectral import rounded
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, cards


def test_the_linear_free_surface_converges_spectrally():
    found = [response("small", degree) for degree in DEGREES["small"]]
    errors = [abs(linear(degree).reaction - 1) for degree in (2, 4, 6)]
    assert errors[0] <= 1e-3
    assert errors[1] <= 1e-3 * errors[0]
    assert errors[2] <= 1e-4 * errors[1]
    best = found[-1].surface(1.0)
    assert abs(best.reaction - 1) <= 1e-14
    assert abs(best.slope + 1) <= 1e-13
    assert abs(best.area - 1) <= 1e-14


def rounding(surface):
    """Of the angle of u'(0) = Σ d_j u_j, whose nodal values are known to one part in 2⁵²."""
    derivative = np.abs(rounded(surface.degree)[2][0]).sum() * 2 / surface.lengths[0]
    steepness = surface.slope**2 if surface.slopes == "finite" else 0.0
    return np.finfo(float).eps * abs(surface.u[0]) * derivative / (1 + steepness)


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_a_response_knows_how_wrong_it_is(slopes):
    for degree in DEGREES[slopes]:
        found = response(slopes, degree)
        for u in (-1.29, -0.4, 1e-4, 0.7, 1.2):
            pull = u * math.sqrt(1 - u * u / 4) if slopes == "finite" else u
            phi = 2 * math.asin(u / 2) if slopes == "finite" else u
            surface = found.surface(u)
            slope = surface.slope
            read = math.atan(slope) if slopes == "finite" else slope
            assert abs(found.reaction(u) / pull - 1) <= found.error + 2e-12
            assert abs(found.area(u) / pull - 1) <= found.error + 1e-14
            assert abs(read + phi) <= 3 * found.mismatch + rounding(surface)


def test_the_tolerance_chooses_the_degree():
    for slopes in ("small", "finite"):
        degrees = [chosen(slopes, 10.0**-n).degree for n in range(1, 14)]
        assert degrees == sorted(degrees)
        assert degrees[0] == DEGREES[slopes][0] < degrees[-1]
        assert chosen(slopes, 1e-8).mismatch <= 1e-9


def test_the_steep_free_surface_obeys_its_own_first_integral():
    found = chosen("finite", 1e-8)
    for u in (-1.3, -0.4, 1e-4, 0.7, 1.2, 1.41):
        surface = found.surface(u)
        phi = 2 * math.asin(u / 2)
        assert abs(surface.reaction - math.sin(phi)) <= 1e-12 * abs(u)
        assert abs(surface.reaction - found.reaction(u)) <= 1e-12 * abs(u)
        assert abs(math.atan(surface.slope) + phi) <= 1e-9
        energy = cards.finite.tail_energy(u, k=1.0, gamma1=1.0)
        assert surface.energy == pytest.approx(energy, rel=1e-12, abs=0)
        assert found.energy(u) == pytest.approx(energy, rel=1e-12, abs=0)
        heights = abs(u) * np.array([0.9, 0.6, 0.3])
        x = cards.finite.meniscus(heights, u_a=abs(u), k=1.0, gamma1=1.0)
        assert np.abs(np.abs(surface.displacement(x)) - heights).max() <= 1e-12


@pytest.mark.parametrize("geometry", ["line", "axisymmetric"])
def test_a_gap_of_any_width_moves_its_lines_by_what_it_pulls(geometry):
    """Where it hardly displaces one of them, too: without adhesion a tip has just touched there."""
    surfaces = SurfaceEnergies.from_work(1.0, 0.0)
    scene = Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, Parabola(1.0), geometry=geometry)
    free = surfaces_of(scene, 1e-8).free
    for width in (1e-6, 1e-2, 1.0, 30.0, 39.5, 40.5, 59.0, 90.0):
        for u, v in ((0.1, 1e-13), (1e-13, 0.1), (0.1, 0.1)):
            assert free(At(2.0, -u), At(2.0 + width, -v), 0.0).residual <= 1e-12
