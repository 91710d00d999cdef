"""
The stiffness of the machine
============================

A motor moves one end of a spring, a cantilever or a load cell, the other holds the indenter. What
is recorded depends on that spring: the softer it is, the earlier the contact is lost, and the more
energy its jumps release. The pull-off force of this lens is the same for all.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from discretization import load_path
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies

# A soft gel under a lens, with so little adhesion that slopes are small, √(2w/γ₁) = 1.5°; any other
# values would do.
layer = ElasticLayer(E=20e3, nu=0.3, h=1e-6)  # Pa, 1, m
surfaces = SurfaceEnergies.from_work(gamma1=0.03, w=1e-5)  # N/m, J/m²
lens = Scene(layer, surfaces, Parabola(R=0.02), geometry="axisymmetric")
# The motor goes down to about δ₀ = 27 nm, positive into the layer, and up to where the softest
# spring below has lost its contact, which happens at -48 nm; in steps of 0.15 nm.
top = 3e-8  # m
bottom = -8e-8  # m
drives = np.concatenate([np.linspace(0, top, 200), np.linspace(top, bottom, 700)])
path = load_path(lens, depths=drives)
plt.plot(1e9 * path.depth, 1e6 * path.force, "k-", label="rigid: the motor is the depth")
# The pressed contact has a stiffness dP/dd of 99 N/m: a spring ten times as stiff, and two softer.
for K in (1000.0, 60.0, 25.0):  # N/m
    path = load_path(lens, drives=drives, machine_stiffness=K)
    pull = path.pull_off
    lost = path.dissipated
    print(
        f"K = {K:4.0f} N/m: pull-off {1e6 * pull.force:.4f} µN at d = {1e9 * pull.depth:.2f} nm, "
        f"energy lost {1e15 * lost:.2f} fJ, events: {', '.join(e.kind for e in path.events)}"
    )
    plt.plot(1e9 * drives, 1e6 * path.force, label=f"spring of K = {K:g} N/m")

plt.xlabel("position of the motor in nm")
plt.ylabel("force P in µN")
plt.title("The same contact held by four machines")
plt.xlim(left=-140)  # room for the legend
plt.legend(loc="lower left")
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
