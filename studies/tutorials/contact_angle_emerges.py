"""
The contact angle emerges
=========================

Nothing below knows Young's law. The energy of a parabola's contact is computed for many widths,
each with its free surface relaxed, and the width of least energy is taken: first in forty lines of
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
WIDEST = 6.0  # half-widths that are tried end here; that of least energy is 2.7
FAR = 12.0  # the free surface ends so far from the line, where exp(-12) of it is left


def slopes(u, dx):
    """Slopes of the links of a free surface, whose last node is followed by one at rest."""
    return np.diff(np.append(u, 0.0)) / dx


def free_surface(u_line, dx):
    """Displacements of the nodes outside a contact: Newton's method for the least energy."""
    u = u_line * np.exp(-np.arange(round(FAR / dx)) * dx)
    for _ in range(20):
        stretch = np.hypot(1, slopes(u, dx))
        pull = gamma1 * slopes(u, dx) / stretch
        stiffness = gamma1 / stretch**3 / dx
        residual = k * dx * u[1:] - np.diff(pull)
        bands = np.zeros((3, residual.size))
        bands[0, 1:] = -stiffness[1:-1]
        bands[1] = k * dx + stiffness[:-1] + stiffness[1:]
        bands[2, :-1] = -stiffness[1:-1]
        u[1:] -= solve_banded((1, 1), bands, residual)
    return u


def free_energy(u, dx):
    """Energy of the springs outside a contact, and of the true lengths of their surface."""
    springs = np.sum(k * dx * u[1:] ** 2 / 2)
    surface = np.sum(gamma1 * dx * (np.hypot(1, slopes(u, dx)) - 1))
    return springs + surface


def contact_energies(f, dx):
    """Energy of the contact up to each node: springs, and a surface that follows the indenter."""
    springs = k * dx * (d - f) ** 2 / 2
    links = (gamma1 - w) * np.hypot(dx, np.diff(f)) - gamma1 * dx
    return np.cumsum(springs) + np.append(0.0, np.cumsum(links))


def by_hand(dx):
    """θ at the contact of least energy among all that end at a node."""
    x = np.arange(round(WIDEST / dx)) * dx
    f = x**2 / (2 * R)
    total = []
    for height, energy in zip(f, contact_energies(f, dx), strict=True):
        u = free_surface(d - height, dx)
        total.append(energy + free_energy(u, dx))
    best = int(np.argmin(total))
    u = free_surface(d - f[best], dx)
    of_indenter = np.arctan(x[best] / R)
    of_surface = np.arctan((u[1] - u[0]) / dx)
    return 180 - np.degrees(of_indenter + of_surface)


scene = Scene(
    ElasticLayer(k, 0.0, 1.0), SurfaceEnergies.from_work(gamma1, w), Parabola(R), slopes="finite"
)
counts = np.array([10, 20, 40, 80])
plain = [abs(by_hand(1 / n) - young) for n in counts]
states = [minimise(scene, d, method="lattice", spacing=1 / n) for n in counts]
angles = [np.degrees(state.contact_angle) for state in states]
print("θ on", counts, "nodes in l:", np.round(angles, 4), f"Young: {young:.1f}°")

plt.loglog(counts, plain, "s", label="40 lines of numpy: the line on a node")
plt.loglog(counts, np.abs(angles - young), "o", label='method="lattice": the line between nodes')
plt.loglog(counts, 20 / counts**2, "k:", label="second order")
plt.xticks(counts, labels=[str(n) for n in counts])
plt.minorticks_off()
plt.xlabel("nodes in the elastocapillary length l")
plt.ylabel("|θ − 120°| in degrees")
plt.title("Young's angle from energies alone")
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
