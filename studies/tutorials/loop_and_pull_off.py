"""
A loop, its jumps and the pull-off force
========================================

A cylinder touches a soft gel, is pressed, and pulled off. Between its jumps loading and unloading
coincide, so that the area of the loop is the energy that the jumps release.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from discretization import load_path
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies

layer = ElasticLayer(E=2.5e3, nu=0.3, h=5e-6)  # Pa, 1, m
surfaces = SurfaceEnergies.from_work(gamma1=0.07, w=6e-5)  # N/m, J/m²
scene = Scene(layer, surfaces, Parabola(R=0.02))  # m
# Down to about δ₀ = 0.42 µm, and up beyond -δ₀, where the last contact is lost; 4 nm a step.
depths = np.concatenate([np.linspace(0, 4e-7, 100), np.linspace(4e-7, -6e-7, 300)])
path = load_path(scene, depths=depths)
print(path)
print(f"loop area ∮P dd = {path.work():.6g} J/m, released in jumps: {path.dissipated:.6g} J/m")

pull = path.pull_off
plt.plot(1e6 * path.depth, 1e3 * path.force, "-", label="loop under imposed depth")
plt.fill_between(1e6 * path.depth, 1e3 * path.force, alpha=0.15)
for event in path.events:
    plt.plot(1e6 * event.depth, 1e3 * event.before.force, "kx")
    place = 1e6 * event.depth, 1e3 * event.before.force
    plt.annotate(event.kind, place, (6, 6), textcoords="offset points")
plt.plot(1e6 * pull.depth, 1e3 * pull.force, "o", label=f"pull-off, {1e3 * pull.force:.1f} mN/m")
plt.xlabel("depth d in µm")
plt.ylabel("force P in mN/m")
plt.title("Touch, press, pull off: a cylinder on a gel")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
