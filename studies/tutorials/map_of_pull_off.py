"""
A map of a hundred thousand states
==================================

`minimise_many` finds the states of one contact for arrays of depths, works of adhesion and tensions
at once. Here: how does the pull-off force of a sphere change with both surface energies? On springs
it falls from 2πRw to πRw as tension takes over, and depends on Λ = l/√(Rδ₀) alone. (Towards the
upper left corner the contact at pull-off is no longer wide against the film, h/a > 0.1: there the
numbers are those of the model, and of a thinner film with the same Λ.)
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from discretization import minimise_many
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies

R = 2e-3  # m
layer = ElasticLayer(E=500.0, nu=0.3, h=1e-6)  # Pa, 1, m
sphere = Scene(layer, SurfaceEnergies.from_work(0.03, 1e-6), Parabola(R), geometry="axisymmetric")
w = np.geomspace(1e-7, 1e-6, 16)[:, None, None]  # J/m²
gamma1 = np.geomspace(1e-3, 0.3, 16)[None, :, None]  # N/m
lift = np.sqrt(2 * w / layer.stiffness)  # δ₀: depths in units of it
# From just before -δ₀, where the last contact is lost: the pull-offs lie from -0.15 to 0.01 δ₀.
states = minimise_many(sphere, lift * np.linspace(-0.99, 0.3, 400), w=w, gamma1=gamma1)
pull_off = -states.force.min(axis=-1)
ratio = pull_off / (2 * np.pi * R * w[..., 0])
print(f"{states.force.size} states; F/2πRw from {ratio.min():.3f} to {ratio.max():.3f}")

shown = plt.contourf(w.ravel(), gamma1.ravel(), ratio.T, levels=20, cmap="viridis")
plt.colorbar(shown, label="pull-off force over 2πRw")
size = np.sqrt(gamma1[..., 0] / layer.stiffness) / np.sqrt(R * lift[..., 0])  # Λ
lines = plt.contour(w.ravel(), gamma1.ravel(), size.T, [0.1, 0.3, 1.0], colors="white")
plt.clabel(lines, fmt="Λ = %g")
plt.xscale("log")
plt.yscale("log")
plt.xlabel("work of adhesion w in J/m²")
plt.ylabel("surface tension γ₁ in N/m")
plt.title("Pull-off of a sphere: tension halves it")
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
