"""Random scenes with their closed-form answers, over eight decades of length and stress."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from energy import (
    ElasticLayer,
    FlatPunch,
    Parabola,
    PowerLaw,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)

SHAPES = ("flat", "wedge", "parabola", "power")


@dataclass(frozen=True)
class Case:
    """A scene, a depth, and what the cards say of it."""

    scene: Scene
    depth: float
    half_width: float
    force: float
    energy: float
    shape: str

    @property
    def resolved(self) -> float:
        """min(l, a)."""
        return min(self.scene.elastocapillary_length, self.half_width)


def random_case(rng: np.random.Generator, shape: str) -> Case:
    """A state of the adhered branch with a/l in 0.03..30 and δ₀/l in 0.01..1 in random units."""
    length, stress = 10.0 ** rng.uniform(-4, 4, 2)
    nu, thickness = rng.uniform(-0.5, 0.45), length * rng.uniform(0.1, 10)
    k = stress / length
    unit = ElasticLayer(1.0, nu, thickness).stiffness
    layer = ElasticLayer(k / unit, nu, thickness)
    ell, a = length, length * 10 ** rng.uniform(-1.5, 1.5)
    alpha = 10 ** rng.uniform(-2, 0)
    gamma1, w = k * ell**2, k * (alpha * ell) ** 2 / 2
    m = {"k": k, "gamma1": gamma1, "w": w}
    delta0 = alpha * ell
    if shape == "flat":
        indenter, d = FlatPunch(a), delta0 * rng.uniform(-0.99, 2)
        force = cards.flat_punch.force(d, a=a, **m)
        energy = cards.flat_punch.energy(d, a=a, **m)
    elif shape == "wedge":
        delta = math.atan(alpha * rng.uniform(0.1, 0.95))
        indenter, d = Wedge(delta), cards.wedge.depth(a, delta=delta, **m)
        force = cards.wedge.force(d, delta=delta, **m)
        energy = cards.wedge.energy(d, delta=delta, **m)
    elif shape == "parabola":
        R = ell * 10 ** rng.uniform(0, 2)
        indenter, d = Parabola(R), cards.parabola.depth(a, R=R, **m)
        force, energy = cards.parabola.force(d, R=R, **m), cards.parabola.energy(d, R=R, **m)
    else:
        n = rng.uniform(1.5, 5)
        c = alpha * 10 ** rng.uniform(-1, 1) * a ** (1 - n)
        indenter, d = PowerLaw(c, n), cards.power_law.depth(a, c=c, n=n, **m)
        force = cards.power_law.force(d, c=c, n=n, **m)
        energy = cards.power_law.energy(d, c=c, n=n, **m)
    scene = Scene(layer, SurfaceEnergies.from_work(gamma1, w), indenter)
    return Case(scene, float(d), a, float(force), float(energy), shape)


def adhesive(indenter, *, k=130.0, gamma1=0.07, w=0.002) -> Scene:
    """A scene in which no parameter is 1."""
    return Scene(ElasticLayer(k * 0.03, 0.0, 0.03), SurfaceEnergies.from_work(gamma1, w), indenter)
