"""
The contact angle emerges
=========================

Nothing below knows Young's law. The energy of a parabola's contact is computed for many widths,
each with its free surface relaxed, and the width of least energy is taken: first in thirty lines of
numpy, then with `minimise(..., method="lattice")`, which finds the line between the nodes, too.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import solveh_banded

from discretization import minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies

k = gamma1 = 1.0  # l = 1
w = d = 0.5
R = 4.0
young = np.degrees(np.arccos(w / gamma1 - 1))  # 120°
WIDEST = 6.0  # half-widths that are tried end here; that of least energy is 2.7
FAR = 12.0  # the free surface ends so far from the line, where exp(-12) of it is left


def free_surface(u_line, dx):
    """Least energy of the surface outside a contact, by Newton's method; its slope at the line."""
    u = u_line * np.exp(-np.arange(round(FAR / dx)) * dx)
    for _ in range(20):  # near the contact of least energy six steps reach rounding
        slopes = np.diff(u, append=0.0) / dx
        stretch = np.hypot(1, slopes)
        stiffness = gamma1 / stretch**3 / dx
        residual = k * dx * u[1:] - np.diff(gamma1 * slopes / stretch)
        bands = [k * dx + stiffness[:-1] + stiffness[1:], -stiffness[1:]]  # on, below the diagonal
        u[1:] -= solveh_banded(bands, residual, lower=True)
    return np.sum(k * dx * u[1:] ** 2 / 2) + np.sum(gamma1 * dx * (stretch - 1)), slopes[0]


def by_hand(dx):
    """θ at the contact of least energy among all that end at a node."""
    x = np.arange(round(WIDEST / dx)) * dx
    f = x**2 / (2 * R)
    springs = np.cumsum(k * dx * (d - f) ** 2 / 2)
    links = (gamma1 - w) * np.hypot(dx, np.diff(f)) - gamma1 * dx
    surface = np.append(0.0, np.cumsum(links))
    outside = np.array([free_surface(d - height, dx) for height in f])
    best = np.argmin(springs + surface + outside[:, 0])
    return 180 - np.degrees(np.arctan(x[best] / R) + np.arctan(outside[best, 1]))


surfaces = SurfaceEnergies.from_work(gamma1, w)
scene = Scene(ElasticLayer(k, 0.0, 1.0), surfaces, Parabola(R), slopes="finite")
counts = np.array([10, 20, 40, 80])
plain = [abs(by_hand(1 / n) - young) for n in counts]
on_nodes = [minimise(scene, d, method="lattice", spacing=1 / n).contact_angle for n in counts]
angles = np.degrees(on_nodes)
print("θ on", counts, "nodes in l:", np.round(angles, 4), f"Young: {young:.1f}°")

plt.loglog(counts, plain, "s", label="30 lines of numpy: the line on a node")
plt.loglog(counts, np.abs(angles - young), "o", label='method="lattice": the line between nodes')
plt.loglog(counts, 20 / counts**2, "k:", label="second order")
plt.xticks(counts, labels=[str(n) for n in counts])
plt.minorticks_off()
plt.xlabel("nodes in the elastocapillary length l")
plt.ylabel("|θ − 120°| in degrees")
plt.title("Young's angle from energies alone")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
