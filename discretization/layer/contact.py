"""One contact of a layer, condensed to its line: where it rests, and what it takes.

With the poles of k (poles.py), v_j = u - φ_j of pole j and the flow ψ obey, with the measure m (1,
or r about an axis) and both known at the line,

    -(m v')' + τ_j m v = (m f')',    -(m ψ')' + τ₁ m ψ = m u    on 0 < x < a,

v'(0) + f'(0) = ψ'(0) = 0. With these on elements (elements.py) it is known what the fields pull at
the line from inside. Outside, the layer and the surface are balanced by u = Σ A exp(-λ(x-a)) of the
decays of `Poles` (about an axis K₀(λr)), in which φ_j is τ_j/(τ_j - λ²) of u, and ψ 1/(τ₁ - λ²).
That every φ_j and ψ has one value and one slope at the line are, with u = d - f(a) there, as many
linear equations as decays. So all is linear in u(a) and 1, and the reaction of all that is free or
pressed beside a line is

    S = γ₁ (σ u(a) + s₀).

Of ∂U/∂a = m [γ₁/2 (f' - S/γ₁)² - w] the line rests where that vanishes, m the length of the line:

    D(a) = f(a) + (f'(a) - s₀ - √(2w/γ₁))/σ,    P = whole ∫₀ᵃ p dm + whole m S,

with the layer's pressure p = k₀u + k₁ψ + Σ c_j v_j. The square is left because f' γ₁ - S is the
force on the line and a line that advances takes the surface along. What is stored at fixed a is
½ whole (∫p u dm + m S u(a)), and whole γ₁/2 ∫f'² dm of the surface in contact.
"""

import functools
import math
from typing import Any

import numpy as np
import scipy

from discretization.layer.body import Body
from discretization.layer.elements import DEGREE, Fields, elements, grid
from discretization.layer.poles import poles
from discretization.surfaces.network import rounded
from energy.arrays import Array, Complex

_INTO = np.array([1] + [0] * (DEGREE - 1) + [-1])  # of a corner the slope inside the element
_LARGEST = 2e4  # complex arguments of Bessel functions; beyond, 1/z² terms are the last that count


def decayed(power: int, decays: Complex, a: float, beside: Array) -> Complex:
    """Fields outside a contact, 1 at the line, so far beside it (k,), and their slopes (2, n, k).

    exp(-λx), or about an axis K₀(λ(a + x))/K₀(λa).
    """
    found = np.exp(-np.outer(decays, beside)) * np.stack([decays**0, -decays])[..., None]
    if power:
        there = np.outer(decays, a + beside)
        found *= np.array([_bessel(i, there) for i in (0, 1)]) / _bessel(0, decays[:, None] * a)
    return found


def _bessel(order: int, z: Complex) -> Complex:
    """K(z) exp(z)."""
    real, near, found = z.imag == 0, np.abs(z) <= _LARGEST, np.empty_like(z)
    of_reals = scipy.special.k1e if order else scipy.special.k0e
    found[real], near, far = of_reals(z.real[real]), near & ~real, ~near & ~real
    found[near], far_z = scipy.special.kve(order, z[near]), z[far]
    found[far] = np.sqrt(math.pi / (2 * far_z)) * (1 + (4 * order - 1) / (8 * far_z))
    return found


class Contact:
    """One of half-width or radius a, with poles to a tolerance; first: see `elements.grid`.

    f: of the profile at the line, slopes, weights (e, 13): at nodes, and with the measure, of both
    sides or all around; stretched: γ₁/2 ∫f'²; u (2, e, 13): of nodes, of what is linear in u(a) and
    1. So are reaction (2,): σ, s₀; lines (2,): what these pull in all; amplitudes (n, 2): A.
    outside (n - 1, n): ψ, and φ of the other poles, of what decays by each λ.
    """

    def __init__(self, body: Body, a: float, tolerance: float, first: float = 0.5) -> None:
        scene, self.body, self.a, self.tolerance = body.scene, body, a, tolerance
        self.poles = found = poles(scene.layer, scene.gamma1, tolerance)
        tau: Complex = np.append(found.first, found.tau)
        self.elements = own = elements(body.power, grid(body, a, np.abs(tau).max() ** -0.5, first))
        self.weights = body.whole * a ** (body.power + 1) * own.mass
        self.f, self.slopes = float(body.height(a)), body.slope(a * own.x, _INTO)
        self.stretched = scene.gamma1 / 2 * float((self.weights * self.slopes**2).sum())
        self.u = np.array([np.ones_like(own.x), self.f - body.height(a * own.x)])
        risen = -(self.slopes * own.mass / own.half) @ rounded(DEGREE)[2]
        loads = [*(a * a * own.mass * self.u), a * risen]
        self.fields = fields = Fields(own, a * a * tau, np.stack(loads, axis=1))
        parts = [[1], [0]], fields.given[:, :1], [fields.own[1:], -fields.given[1, 1:]]
        outwards, z = found.decays.copy(), found.decays * a
        outwards *= _bessel(1, z) / _bessel(0, z) if body.power else 1.0
        matrix = np.ones((outwards.size,) * 2, complex)
        self.outside = np.append(1, found.tau)[:, None] / (tau[:, None] - found.decays**2)
        matrix[1:] = (fields.own[:, None] + a * outwards) * self.outside
        high = np.abs(matrix).max(axis=1, keepdims=True)
        self.amplitudes = np.linalg.solve(matrix / high, np.concatenate(parts, axis=1).T / high)
        self.reaction = (outwards @ self.amplitudes).real
        self.lines = scene.gamma1 * body.whole * a**body.power * self.reaction

    @functools.cached_property
    def pressures(self) -> Array:
        """At nodes (2, e, 13)."""
        at_line, c = self.outside @ self.amplitudes, np.append(self.poles.flow, self.poles.c)
        at_line[1:] = [1, 0] - at_line[1:]
        return self.poles.still * self.u + self.fields.total(at_line.T, c)

    @functools.cached_property
    def form(self) -> Array:
        """∫p u + m S u(a) (2, 2), p and S of the first, u of the second."""
        found = (self.pressures * self.weights).reshape(2, -1) @ self.u.reshape(2, -1).T
        found[:, 0] += self.lines
        return np.asarray(found)

    @property
    def taken(self) -> Array:
        """σ, s₀, dP/du, and P₀ and U₀ at u(a) = 0, without adhesion (5,)."""
        return np.array([*self.reaction, *self.form[:, 0], self.form[1, 1] / 2 + self.stretched])


def at_depth(taken: Any, u: Any) -> tuple[Any, Any]:
    """The force, and the energy without adhesion, of what is `taken` at a u(a)."""
    _, _, rate, force, stored = taken
    return rate * u + force, stored + force * u + rate * u * u / 2
