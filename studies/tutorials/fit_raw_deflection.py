"""
From a raw deflection to a sentence
===================================

A force microscope wrote the position of its piezo in nm and the deflection of its cantilever in
volts (`raw_deflection.txt`, simulated). Spring constant and sensitivity turn volts into a force,
and the fit finds work of adhesion w, surface tension γ₁ and the zero of the depth. The sphere's
radius is known to 2 % only, which the intervals contain. One point is a spike: it is named and left
out.
"""

import sys
from pathlib import Path

import matplotlib.pyplot as plt

from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
from studies import Reading, fit, read_curve

HERE = Path(sys.argv[0]).parent  # the folder of this script

# The film, the sphere, and energies to start from: a factor 1.5 to 2 off is near enough.
film = ElasticLayer(E=30e3, nu=0.45, h=0.3e-6)  # Pa, 1, m
start = SurfaceEnergies.from_work(gamma1=0.045, w=0.5e-4)  # J/m²
scene = Scene(film, start, Parabola(R=5e-6), geometry="axisymmetric")

# A force about an axis is not per length: width = 1.
instrument = Reading(width=1.0, spring_constant=0.08, sensitivity=50e-9)  # N/m, m/V
curve = read_curve(HERE / "raw_deflection.txt", instrument)
found = fit(scene, curve, profiles=False, alternatives=False, uncertainties={"R": 0.02})
print(found)


def plus_minus(name: str) -> str:
    """An estimate and half of its interval at 95 %, in mJ/m²."""
    low, high = found[name].interval
    return f"{1e3 * found[name].value:.3g} ± {1e3 * (high - low) / 2:.1g} mJ/m²"


sentence = f"w = {plus_minus('w')} and γ₁ = {plus_minus('gamma1')}, both at 95 %"
print(sentence)

drive = 1e9 * (curve.drive - found["offset"].value)
force = 1e9 * (curve.force - found.line)
left_out = found.model.data.spikes
plt.plot(drive, force, ".", color="grey", label="measured, less the line without contact")
plt.plot(drive[left_out], force[left_out], "rx", label="left out")
plt.plot(drive, 1e9 * (found.fitted - found.line), "k-", lw=1, label="fit")
plt.xlabel("position of the piezo above first touch, d + P/K, in nm")
plt.ylabel("force P in nN")
plt.title(sentence, fontsize=10)
plt.legend()
plt.savefig(sys.argv[1] if len(sys.argv) > 1 else Path(__file__).stem + ".png", dpi=120)
