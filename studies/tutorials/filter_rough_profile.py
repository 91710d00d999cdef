"""
Where to cut off the noise of a rough profile
=============================================

The noise of a measured profile has slopes, too. Where they are not small against √(2w/γ₁), the kink
of the surface at a contact line, they pin lines that the body itself would not pin, and change the
energy lost in a cycle. A Gaussian filter (ISO 16610-21) removes waves shorter than a cut-off: too
short, and noise stays; too long, and the asperities go.

`rough_profile.txt` is what a profilometer writes of a wavy cylinder that faces up (simulated): it
is turned over when it is read. Left: the energy lost in a cycle of touching, pressing and pulling
off, over the cut-off, beside that of the cylinder without noise, which nobody knows of a
measurement. Right: rms slopes over √(2w/γ₁) of what is left and of what was removed. The slope of
what was removed first grows as noise goes, then stays (only noise was removed, and nearly all of
it), and grows again once asperities go.
Choose the cut-off at the beginning of the flat part: there the loss is within 4 % of what it is
without noise and without a filter, and the rms slope of what is left is that of the body. The right
panel needs no profile without noise.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt
import numpy as np

from discretization import load_path
from energy import ElasticLayer, Sampled, Scene, SurfaceEnergies, read_profile

HERE = Path(sys.argv[0]).parent  # the folder of this script
layer = ElasticLayer(E=2.5e3, nu=0.3, h=5e-6)  # Pa, 1, m
surfaces = SurfaceEnergies.from_work(gamma1=0.07, w=6e-5)  # J/m²
kink = np.sqrt(2 * 6e-5 / 0.07)  # √(2w/γ₁)

scan = read_profile(HERE / "rough_profile.txt", flip=True)  # its header states the units
x = scan.x  # m
wavy = x**2 / (2 * 0.02) + 0.15e-6 * np.cos(2 * np.pi * x / 60e-6 + 1)  # m
cutoffs = 1e-6 * np.array([2.5, 4, 6, 8, 12, 16, 20, 30, 40, 60, 80])  # m


def rms_slope(x, z):
    """The rms slope over √(2w/γ₁)."""
    return np.sqrt(np.mean(np.gradient(z, x) ** 2)) / kink


def energy_lost(body):
    """In nJ/m, in a cycle to 0.2 µm below first touch; on nodes half a sample apart."""
    pressing = np.linspace(0, 0.2, 5)
    pulling = np.linspace(0.2, -0.6, 30)
    depths = body.z.min() + 1e-6 * np.concatenate([pressing, pulling])
    path = load_path(Scene(layer, surfaces, body), depths=depths, spacing=5e-7)
    return 1e9 * path.dissipated


figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
for z, label, style in ((wavy, "without noise", "k--"), (scan.z, "with noise", "o-")):
    lost = []
    left_slopes = []
    removed = []
    for cutoff in cutoffs:
        body = Sampled(x, z).filtered(cutoff)
        before = np.interp(body.x, x, z)
        lost.append(energy_lost(body))
        left_slopes.append(rms_slope(body.x, body.z))
        removed.append(rms_slope(body.x, before - body.z))
    left.plot(1e6 * cutoffs, lost, style, label=label)
    right.plot(1e6 * cutoffs, left_slopes, style, label=f"left, {label}")
    right.plot(1e6 * cutoffs, removed, style, alpha=0.5, label=f"removed, {label}")
    for cutoff, energy, slope in zip(cutoffs, lost, removed, strict=True):
        print(f"{label}: cut-off {1e6 * cutoff:g} µm, {energy:.3g} nJ/m, removed {slope:.3f}")
for axes in (left, right):
    axes.set_xscale("log")
    axes.set_xticks([3, 10, 30, 80], ["3", "10", "30", "80"], minor=False)
    axes.set_xticks([], minor=True)
    axes.set_xlabel("cut-off in µm")
    axes.axvspan(12, 20, color="grey", alpha=0.2, label="choose here")
left.legend(fontsize=8)
right.legend(fontsize=8, ncols=2, loc="upper center")
right.set_ylim(top=0.6)
figure.suptitle("Filtering a measured profile: noise goes first, then asperities")
left.set_ylabel("energy lost in a cycle in nJ/m")
right.set_ylabel("rms slope over √(2w/γ₁)")
figure.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
