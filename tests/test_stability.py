"""Energy and force on the same lattice against 50-digit arithmetic."""

import itertools
import math

import mpmath as mp
import numpy as np
import pytest
from lattices import over, pressed
from scenes import adhesive

from discretization import NodalEnergy
from discretization.lattice.judge import totals
from discretization.lattice.state import on_lattice
from discretization.nodes.lattice import Lattice
from energy import Parabola, Wedge

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
@pytest.mark.parametrize("indenter", [Parabola(2000 * DX), Wedge(0.05)])
def test_twelve_digits_for_any_ratio_of_length_to_spacing(decade, indenter):
    """And no admissible contact set with one link more or less on both sides is lower."""

    def height(x):
        if isinstance(indenter, Parabola):
            return x**2 / (2 * mp.mpf(indenter.R))
        return abs(x) * mp.mpf(math.tan(indenter.delta))

    with mp.workdps(50):
        k, ell, a = 37.0, 10.0**decade * DX, 150 * DX
        scene = adhesive(indenter, k=k, gamma1=k * ell**2, w=k * (0.3 * min(ell, a)) ** 2 / 2)
        f, rise = float(indenter.height(a)), float(indenter.slope(a))
        d, lattice = f - scene.critical_separation + ell * rise, Lattice.of(scene, DX)
        first, last = contact = pressed(lattice, scene, d)
        sums = totals(over(lattice, indenter, d, contact))
        energy, force = exact(lattice, height, d, first, last)
        assert first == -last < -50 and on_lattice(scene, d, DX).certificate.ok
        assert abs(sums.energy - energy) <= 1e-12 * sums.energy_scale
        assert abs(sums.force - force) <= 1e-12 * sums.force_scale
        slack = max(1, lattice.link / lattice.spring / 1e3)
        assert abs(sums.force_by_reactions - force) <= 1e-12 * sums.force_scale * slack
        assert energy <= exact(lattice, height, d, first - 1, last + 1)[0]
        kappa = mp.mpf(lattice.k) * mp.mpf(DX) ** 2 / lattice.gamma1
        lam = 1 + kappa / 2 - mp.sqrt(kappa + kappa**2 / 4)
        before, own = (d - height(mp.mpf(DX) * i) for i in (last - 1, last))
        if lam * before >= own:  # without its last link the surface stays clear
            assert energy <= exact(lattice, height, d, first + 1, last - 1)[0]


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
    assert chain.value(u) == pytest.approx(short.value([0.7]), rel=1e-13, abs=0)
