"""
A sphere on PDMS beside JKR
===========================

JKR theory holds for a thick layer without surface tension. With `response="layer"` the layer has
its exact response, for any thickness and a Poisson's ratio up to ½: a thick film gives JKR's
3/2 πRw, and the same silicone as a thin, nearly incompressible film sticks harder. In JKR theory
slopes at the line are infinite; here they are steep, as 2w > γ₁ (`path.warnings` says so), but
tension is too weak to matter for the forces.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from discretization import load_path
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies

E = 2e6  # Pa
nu = 0.495
R = 1e-3  # m
w = 0.05  # J/m²
gamma1 = 0.02  # N/m
modulus = E / (1 - nu**2)  # that of a half-space in JKR theory
for h in (1e-3, 1e-4, 4e-5):
    layer = ElasticLayer(E, nu, h, response="layer")
    scene = Scene(layer, SurfaceEnergies.from_work(gamma1, w), Parabola(R), geometry="axisymmetric")
    # pressed by 2 πRw, then pulled by more than 3 πRw, which no film bears
    forces = np.pi * R * w * np.concatenate([np.linspace(0, 2, 15), np.linspace(2, -3.3, 60)])
    path = load_path(scene, forces=forces, rtol=1e-4)
    pull = path.pull_off
    print(*path.warnings)
    print(
        f"h = {1e6 * h:4.0f} µm: F = {-pull.force / (np.pi * R * w):.3f} πRw, "
        f"a = {1e6 * pull.half_width:.1f} µm, h/a = {h / pull.half_width:.2f}"
    )
    touching = path.half_width > 0
    label = f"h = {1e6 * h:.0f} µm: pull-off {-pull.force / (np.pi * R * w):.2f} πRw"
    plt.plot(1e6 * path.half_width[touching], 1e3 * path.force[touching], "o", ms=3, label=label)

a = np.linspace(1e-6, 9e-5, 300)
jkr = 4 * modulus * a**3 / (3 * R) - np.sqrt(8 * np.pi * w * modulus * a**3)
plt.plot(1e6 * a, 1e3 * jkr, "k-", lw=1, label="JKR: pull-off 1.5 πRw")
plt.xlim(left=0)
plt.ylim(-0.35, 0.4)
plt.xlabel("contact radius a in µm")
plt.ylabel("force P in mN")
plt.title("Sphere of 1 mm on PDMS of 2 MPa")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
