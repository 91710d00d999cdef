"""
Adhesion hysteresis
===================

Many surfaces gain little energy on closing and cost more to open. `Scene(..., opening=...)` gives a
contact that opens energies of its own: then its line stays where it is, while the force changes,
until the angle has become that of opening. The loop has an area that no jump accounts for.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from discretization import load_path
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies

layer = ElasticLayer(E=2.5e3, nu=0.3, h=5e-6)  # Pa, 1, m
closing = SurfaceEnergies.from_work(gamma1=0.07, w=2e-5)  # N/m, J/m²
# To some δ₀ = 0.24 µm of closing, and beyond -δ₀ of the strongest opening, -0.49 µm; 5 nm a step.
depths = np.concatenate([np.linspace(0, 4e-7, 80), np.linspace(4e-7, -6e-7, 200)])  # m
figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4.2), layout="constrained")
for w in (2e-5, 4e-5, 8e-5):
    opening = SurfaceEnergies.from_work(gamma1=0.07, w=w)
    scene = Scene(layer, closing, Parabola(R=0.02), opening=opening)
    path = load_path(scene, depths=depths)
    jumps = sum(event.energy_released for event in path.events)
    print(
        f"w of opening = {w:.0e} J/m²: pull-off {1e3 * path.pull_off.force:.2f} mN/m, loop area "
        f"{path.work():.3e} J/m, of which in jumps {jumps:.3e}"
    )
    label = f"opening: w = {1e6 * w:.0f} µJ/m²"
    left.plot(1e6 * path.depth, 1e3 * path.force, label=label)
    right.plot(1e6 * path.depth, 1e6 * path.half_width)

left.set(xlabel="depth d in µm", ylabel="force P in mN/m")
right.set(xlabel="depth d in µm", ylabel="half-width a in µm")
left.legend(title="closing: w = 20 µJ/m²")
figure.suptitle("A line that opens at another angle than it closes stays in between")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
