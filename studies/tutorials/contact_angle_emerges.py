"""
The contact angle emerges
=========================

Nothing below knows Young's law. The energy of a parabola's contact is computed for many widths,
each with its free surface relaxed, and the width of least energy is taken: first in twenty lines of
numpy, then with `minimise(..., method="lattice")`, which finds the line between the nodes, too.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np
from scipy.linalg import solve_banded

from discretization import minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies

k = 1.0
gamma1 = 1.0
w = 0.5
R = 4.0
d = 0.5  # l = 1; cos θ = w/γ₁ - 1 gives 120°
young = np.degrees(np.arccos(w / gamma1 - 1))


def free_surface(u_line, dx):
    """Newton's method for the nodes outside a contact: springs and true surface lengths."""
    u = u_line * np.exp(-np.arange(round(12 / dx)) * dx)
    for _ in range(20):
        s = np.diff(np.append(u, 0.0)) / dx
        pull = gamma1 * s / np.hypot(1, s)
        bend = gamma1 / np.hypot(1, s) ** 3 / dx
        residual = k * dx * u[1:] - np.diff(pull)
        bands = np.array([-bend[:-1], k * dx + bend[:-1] + bend[1:], -bend[1:]])
        bands[0, 1:] = -bend[1:-1]
        bands[2, :-1] = -bend[1:-1]
        u[1:] -= solve_banded((1, 1), bands, residual)
    s = np.diff(np.append(u, 0.0)) / dx
    return u, np.sum(k * dx * u[1:] ** 2 / 2) + np.sum(gamma1 * dx * (np.hypot(1, s) - 1))


def by_hand(dx):
    """θ at the contact of least energy among all that end at a node."""
    f = (np.arange(round(6 / dx)) * dx) ** 2 / (2 * R)
    springs = k * dx * (d - f) ** 2 / 2
    links = (gamma1 - w) * np.hypot(dx, np.diff(f)) - gamma1 * dx
    contact = np.cumsum(springs) + np.append(0.0, np.cumsum(links))  # up to each node
    total = [E + free_surface(d - f[m], dx)[1] for m, E in enumerate(contact)]
    m = int(np.argmin(total))
    u = free_surface(d - f[m], dx)[0]
    return 180 - np.degrees(np.arctan(m * dx / R) + np.arctan((u[1] - u[0]) / dx))


scene = Scene(
    ElasticLayer(k, 0.0, 1.0), SurfaceEnergies.from_work(gamma1, w), Parabola(R), slopes="finite"
)
counts = np.array([10, 20, 40, 80])
plain = [abs(by_hand(1 / n) - young) for n in counts]
states = [minimise(scene, d, method="lattice", spacing=1 / n) for n in counts]
angles = [np.degrees(state.contact_angle) for state in states]
print("θ on", counts, "nodes in l:", np.round(angles, 4), f"Young: {young:.1f}°")

plt.loglog(counts, plain, "s", label="20 lines of numpy: the line on a node")
plt.loglog(counts, np.abs(angles - young), "o", label='method="lattice": the line between nodes')
plt.loglog(counts, 20 / counts**2, "k:", label="second order")
plt.xticks(counts, labels=[str(n) for n in counts])
plt.minorticks_off()
plt.xlabel("nodes in the elastocapillary length l")
plt.ylabel("|θ − 120°| in degrees")
plt.title("Young's angle from energies alone")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
