"""Random scenes with their closed-form answers, over eight decades of length and of stress.

They test the numbers of the model, far beyond the limits of independent springs too: only k, γ₁ and
w of a layer enter, its thickness is any.

Conventions:

- A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁, `work_of_adhesion` w, `elastocapillary_length` l =
  √(γ₁/k) and `critical_separation` δ₀ = √(2w/k).
- `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
- `FlatPunch(half_width)` has f = 0 up to its edges; `PowerLaw(c, n)` is f = c|x|ⁿ.
- `cards.flat_punch`, `wedge`, `parabola` and `power_law` have the closed forms of a kind of
  indenter with small slopes: depth(a), force(d) and energy(d), with its parameters, k, γ₁ and w.
- `cards.finite` has those of finite slopes: `depth(f, f')` of a line, `surface_force(u)`, the force
  of both free surfaces, positive where they push, and `tail_energy(u)`, the energy of one, at the
  displacement u of the line.
- QUANTITIES are half_width, force and energy.
- `scales` of a state are sums of the absolute terms of its force and energy.
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.integrate import quad

from discretization import Equilibrium
from energy import (
    ElasticLayer,
    FlatPunch,
    Indenter,
    Parabola,
    PowerLaw,
    Scene,
    SurfaceEnergies,
    Wedge,
    cards,
)
from studies.shared import QUANTITIES


@dataclass(frozen=True)
class Case:
    """A scene at a depth, and what the cards say of it.

    Attributes
    ----------
    scene : Scene
    depth, half_width, force, energy : float
    shape : str
        "flat", "wedge", "parabola" or "power".
    """

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

    def errors(self, state: Equilibrium, half_width: float) -> tuple[float, float, float]:
        """|a - a*|, |P - P*| and |U - U*| over this half-width and the sums of the terms."""
        scales = {"half_width": half_width, **state.scales}
        a, force, energy = (
            0.0 if value == true else float(abs(value - true) / (scales[name] or abs(true)))
            for name in QUANTITIES
            for value, true in [(getattr(state, name), getattr(self, name))]
        )
        return a, force, energy

    @property
    def angle_deficit(self) -> float:
        """π - θ [rad] by Young's law, (15) or (8); nan for a line at an edge, or none."""
        if self.shape in ("flat", "plane"):
            return math.nan
        card = cards.contact_line
        law = card.angle_deficit_small if self.scene.slopes == "small" else card.angle_deficit
        return float(law(self.scene.work_of_adhesion, self.scene.gamma1))


SHAPES = ("flat", "wedge", "parabola", "power")
# Errors of the quadratures: relative to the sum, or to its terms where they cancel, 45 roundings.
# A tenth of the 1e-12 to which the default method is held.
_OF_SUM = 1e-13
_OF_TERMS = 1e-14
Drawn = tuple[Indenter, dict[str, float], Any]  # an indenter, its parameters, its closed forms


def in_turn(rng: np.random.Generator, i: int) -> Case:
    """Case number i: small and finite slopes in turn, and every shape."""
    draw = random_steep_case if i % 2 else random_case
    return draw(rng, SHAPES[i // 2 % len(SHAPES)])


def random_case(rng: np.random.Generator, shape: str) -> Case:
    """A state of the adhered branch with a/l in 0.03..30 and δ₀/l in 0.01..1 in random units."""
    length, stress = 10.0 ** rng.uniform(-4, 4, 2)
    nu = rng.uniform(-0.5, 0.45)
    thickness = length * rng.uniform(0.1, 10)
    k = stress / length
    unit = ElasticLayer(1.0, nu, thickness).stiffness
    layer = ElasticLayer(k / unit, nu, thickness)
    ell = length
    a = length * 10 ** rng.uniform(-1.5, 1.5)
    alpha = 10 ** rng.uniform(-2, 0)
    gamma1 = k * ell**2
    w = k * (alpha * ell) ** 2 / 2
    m = {"k": k, "gamma1": gamma1, "w": w}
    delta0 = alpha * ell
    indenter, own, card = _drawn(rng, shape, ell, a, alpha)
    pinned = isinstance(indenter, FlatPunch)
    d = delta0 * rng.uniform(-0.99, 2) if pinned else card.depth(a, **own, **m)
    force, energy = (one(d, **own, **m) for one in (card.force, card.energy))
    scene = Scene(layer, SurfaceEnergies.from_work(gamma1, w), indenter)
    return Case(scene, float(d), a, float(force), float(energy), shape)


def _drawn(rng: np.random.Generator, shape: str, ell: float, a: float, alpha: float) -> Drawn:
    """A random indenter of this shape for small slopes."""
    if shape == "flat":
        return FlatPunch(a), {"a": a}, cards.flat_punch
    if shape == "wedge":
        delta = math.atan(alpha * rng.uniform(0.1, 0.95))
        return Wedge(delta), {"delta": delta}, cards.wedge
    if shape == "parabola":
        R = ell * 10 ** rng.uniform(0, 2)
        return Parabola(R), {"R": R}, cards.parabola
    n = rng.uniform(1.5, 5)
    c = alpha * 10 ** rng.uniform(-1, 1) * a ** (1 - n)
    return PowerLaw(c, n), {"c": c, "n": n}, cards.power_law


def random_steep_case(rng: np.random.Generator, shape: str) -> Case:
    """The same with finite slopes: w/γ₁ in 10⁻³..0.8, a/l in 0.1..10, f'(a) in 0.02..1."""
    ell, stress = 10.0 ** rng.uniform(-4, 4, 2)
    k = stress / ell
    gamma1 = stress * ell
    w = gamma1 * 10 ** rng.uniform(-3, math.log10(0.8))
    a = ell * 10 ** rng.uniform(-1, 1)
    rise = rng.uniform(0.02, 1.0)
    indenter = _steep(shape, a, rise, rng.uniform(1.5, 5))
    surfaces = SurfaceEnergies.from_work(gamma1, w)
    scene = Scene(ElasticLayer(k * ell, 0.0, ell), surfaces, indenter, slopes="finite")
    if isinstance(indenter, FlatPunch):
        d = scene.critical_separation * rng.uniform(-0.99, 1)
    else:
        f = indenter.height(a)
        slope = indenter.slope(a)
        d = float(cards.finite.depth(f, slope, k=k, gamma1=gamma1, w=w))
    return Case(scene, d, a, *steep_totals(scene, d, a), shape)


def _steep(shape: str, a: float, rise: float, n: float) -> Indenter:
    """A profile with the slope `rise` at a."""
    if shape == "flat":
        return FlatPunch(a)
    if shape == "wedge":
        return Wedge(math.atan(rise))
    return Parabola(a / rise) if shape == "parabola" else PowerLaw(rise / (n * a ** (n - 1)), n)


def steep_totals(scene: Scene, d: float, a: float) -> tuple[float, float]:
    """P = 2k ∫₀ᵃ g dx + 2γ₁ sin φ and U = 2 ∫₀ᵃ [k/2 g² + (γ₁-w)√(1+f'²) - γ₁] dx + 2F.

    Parameters
    ----------
    scene : Scene
        With finite slopes, and a symmetric indenter.
    d, a : float
        Depth and half-width.

    Returns
    -------
    force, energy : float
    """
    k = scene.stiffness
    gamma1 = scene.gamma1
    w = scene.work_of_adhesion
    f = scene.indenter
    spring = {"k": k, "gamma1": gamma1}

    def displaced(x: float) -> float:
        """u = d - f at x, in contact."""
        return d - float(f.height(x))

    def density(x: float) -> float:
        """Energy per area in contact: springs, and γ₁ - w on the true arc less γ₁ on the level."""
        arc = math.hypot(1, float(f.slope(x)))
        return k / 2 * displaced(x) ** 2 + (gamma1 - w) * arc - gamma1

    lift = max(abs(d), abs(displaced(a)))
    pressed = quad(displaced, 0, a, epsrel=_OF_SUM, epsabs=_OF_TERMS * lift * a)[0]
    size = k * lift**2 + gamma1 * float(f.slope(a)) ** 2 + w
    stored = quad(density, 0, a, epsrel=_OF_SUM, epsabs=_OF_TERMS * size * a)[0]
    force = 2 * k * pressed + cards.finite.surface_force(displaced(a), **spring)
    energy = 2 * stored + 2 * cards.finite.tail_energy(displaced(a), **spring)
    return float(force), float(energy)
