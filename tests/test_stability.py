"""Energy and force on the same lattice against 50-digit arithmetic."""

from __future__ import annotations

import itertools
import math

import mpmath as mp
import numpy as np
import pytest
from scenes import adhesive

from discretization import NodalEnergy, on_lattice
from discretization.certificate import measured
from discretization.lattice import fronts
from discretization.lattice.nodes import Lattice
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, Wedge

DX = 0.013


def exact(lattice, height, depth, first, last):
    """Energy and force of the contact set first..last, tails by the characteristic root."""
    dx, k, gamma1, w, d = map(
        mp.mpf, (lattice.spacing, lattice.k, lattice.gamma1, lattice.w, depth)
    )
    kappa = k * dx**2 / gamma1
    lam = 1 + kappa / 2 - mp.sqrt(kappa + kappa**2 / 4)
    g = [d - height(dx * i) for i in range(first, last + 1)]
    ends = (g[0], g[-1])
    energy = sum(k * dx * u**2 / 2 for u in g) - w * dx * (last - first)
    energy += sum(gamma1 / dx * (q - p) ** 2 / 2 for p, q in itertools.pairwise(g))
    energy += sum(gamma1 / dx * (1 - lam) * u**2 / 2 for u in ends)
    force = k * dx * sum(g) + k * dx * lam / (1 - lam) * sum(ends)
    return energy, force


@pytest.mark.parametrize("decade", range(-3, 9))
@pytest.mark.parametrize("shape", ["parabola", "wedge"])
def test_twelve_digits_for_any_ratio_of_length_to_spacing(decade, shape):
    with mp.workdps(50):
        ell, a = 10.0**decade * DX, 150 * DX
        k, alpha = 37.0, 0.3
        gamma1, w = k * ell**2, k * (alpha * min(ell, a)) ** 2 / 2
        if shape == "parabola":
            R = 2000 * DX
            indenter = Parabola(R)
            f, rise = a**2 / (2 * R), a / R

            def height(x):
                return x**2 / (2 * mp.mpf(R))
        else:
            delta = 0.05
            indenter = Wedge(delta)
            f, rise = a * math.tan(delta), math.tan(delta)

            def height(x):
                return abs(x) * mp.mpf(math.tan(delta))

        d = f - math.sqrt(2 * w / k) + ell * rise
        scene = Scene(ElasticLayer(k, 0.0, 1.0), SurfaceEnergies.from_work(gamma1, w), indenter)
        lattice = Lattice.of(scene, DX)
        where = fronts.region(lattice, indenter, d)
        contact = fronts.adhered(lattice, indenter, d, where)
        sums = measured(lattice, indenter, d, contact)
        energy, force = exact(lattice, height, d, contact.first, contact.last)
        assert contact.last - contact.first > 100
        assert abs(sums.energy - energy) <= 1e-12 * sums.energy_scale
        assert abs(sums.force - force) <= 1e-12 * sums.force_scale
        assert abs(sums.force_by_reactions - force) <= 1e-12 * sums.force_scale * max(
            1, lattice.link / lattice.spring / 1e3
        )


@pytest.mark.parametrize("decade", range(-3, 9))
def test_the_line_is_where_extended_precision_puts_it(decade):
    """No admissible neighbouring contact set has a lower energy, compared with 50 digits."""
    with mp.workdps(50):
        ell, R = 10.0**decade * DX, 2000 * DX
        k, alpha = 37.0, 0.3
        a = 150 * DX
        gamma1, w = k * ell**2, k * (alpha * min(ell, a)) ** 2 / 2
        d = a**2 / (2 * R) - math.sqrt(2 * w / k) + ell * a / R
        scene = Scene(ElasticLayer(k, 0.0, 1.0), SurfaceEnergies.from_work(gamma1, w), Parabola(R))
        lattice = Lattice.of(scene, DX)
        where = fronts.region(lattice, scene.indenter, d)
        first, last, _ = fronts.adhered(lattice, scene.indenter, d, where)

        def energy(n):
            return exact(lattice, lambda x: x**2 / (2 * mp.mpf(R)), d, -n, n)[0]

        kappa = mp.mpf(k) * mp.mpf(DX) ** 2 / gamma1
        lam = 1 + kappa / 2 - mp.sqrt(kappa + kappa**2 / 4)
        g = [d - (mp.mpf(DX) * i) ** 2 / (2 * mp.mpf(R)) for i in range(last + 1)]
        assert first == -last
        assert on_lattice(scene, d, DX).certificate.ok
        assert energy(last) <= energy(last + 1)
        if lam * g[last - 1] >= g[last]:  # without its last link the surface stays clear
            assert energy(last) <= energy(last - 1)


def test_exact_tail_equals_a_long_chain_of_nodes():
    scene = adhesive(Parabola(0.02))
    lattice = Lattice.of(scene, scene.elastocapillary_length / 20)
    far = np.zeros(2001, bool)
    far[0] = True
    u = NodalEnergy(lattice, far).relaxed(np.full(2001, 0.7))
    expected = 0.7 * lattice.decay ** np.arange(2001)
    assert np.abs(u - expected).max() <= 1e-12
    chain = NodalEnergy(lattice, far)
    short = NodalEnergy(lattice, far[:1])
    assert chain.value(u) == pytest.approx(short.value([0.7]), rel=1e-12, abs=0)
