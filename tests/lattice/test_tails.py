"""The eliminated tails of the lattice, against chains of nodes."""

import itertools
from dataclasses import replace

import numpy as np
import pytest
from scenes import adhesive, steep

from discretization import Lattice, NodalEnergy
from energy import Parabola


def test_an_advance_changes_energy_and_force_as_two_relaxed_chains_say():
    scene = adhesive(Parabola(0.02))
    lattice = Lattice.of(scene, scene.elastocapillary_length / 8)
    nodes = np.arange(-40, 41)
    f = scene.indenter.height(lattice.x(nodes))
    for last, depth in itertools.product((3, 9), (1e-3, -5e-3)):
        i = last + 40
        values, forces = [], []
        for end in (last, last + 1):
            energy = NodalEnergy(lattice, (nodes >= -2) & (nodes <= end))
            u = energy.relaxed(depth - f)
            values.append(energy.value(u))
            forces.append(energy.gradient(u)[energy.contact].sum())
        _, rest, stiffness = lattice.beside(last, 1)
        gap = f[i + 1] - f[i] - rest * (depth - f[i])
        work = scene.work_of_adhesion * lattice.spacing
        assert stiffness / 2 * lattice.critical_gap**2 == pytest.approx(work, rel=1e-13)
        change, size = values[1] - values[0], scene.gamma1 * lattice.spacing
        energy, force = stiffness / 2 * gap**2 - work, -stiffness * rest * gap
        assert energy == pytest.approx(change, rel=0, abs=1e-11 * size)
        expected = forces[1] - forces[0]
        assert force == pytest.approx(expected, rel=0, abs=1e-13 * scene.gamma1)


@pytest.mark.parametrize("slopes", ["small", "finite"])
def test_nodal_energy_derivatives(slopes):
    scene = replace(steep(Parabola(0.02)), slopes=slopes)
    lattice = Lattice.of(scene, scene.elastocapillary_length / 5)
    rng, size = np.random.default_rng(3), 12
    u = rng.uniform(-0.5, 0.5, size) * scene.elastocapillary_length
    energy, step = NodalEnergy(lattice, np.arange(size) % 5 > 1), 1e-5 * np.abs(u).max()
    band = energy.hessian(u)
    hessian = np.diag(band[0]) + np.diag(band[1, :-1], -1) + np.diag(band[1, :-1], 1)
    for i, unit in enumerate(step * np.eye(size)):
        slope = (energy.value(u + unit) - energy.value(u - unit)) / (2 * step)
        assert slope == pytest.approx(energy.gradient(u)[i], rel=1e-6, abs=1e-8 * scene.gamma1)
        change = (energy.gradient(u + unit) - energy.gradient(u - unit)) / (2 * step)
        assert np.abs(change - hessian[i]).max() <= 1e-7 * hessian[i, i]
