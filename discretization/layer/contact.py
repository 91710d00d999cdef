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
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
from scipy.special import k0e, k1e, kve

from discretization.layer import elements as inside
from discretization.layer.body import Body
from discretization.layer.elements import Elements, Swept
from discretization.layer.poles import Poles, poles
from energy.arrays import Array, Complex

_INTO = np.array([1] + [0] * 11 + [-1])  # of a corner the slope inside the element
_LARGEST = 2e4  # complex arguments of Bessel functions; beyond, 1/z² terms are the last that count


def decayed(power: int, decays: Complex, a: Array, beside: Array, order: int) -> Complex:
    """Fields (n, k) outside contacts a (k,), 1 at the line, so far beside it (k,); order 1: slopes.

    exp(-λx), or about an axis K₀(λ(a + x))/K₀(λa).
    """
    found = np.exp(-np.outer(decays, beside)) * (-decays[:, None]) ** order
    if not power:
        return found
    return found * _bessel(order, np.outer(decays, a + beside)) / _bessel(0, np.outer(decays, a))


def _bessel(order: int, z: Complex) -> Complex:
    """K(z) exp(z)."""
    real, far = z.imag == 0, np.abs(z) > _LARGEST
    found = np.sqrt(math.pi / (2 * z)) * (1 + (4 * order - 1) / (8 * z))
    found[real] = (k1e if order else k0e)(z.real[real])
    found[~real & ~far] = kve(order, z[~real & ~far])
    return found


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts of half-widths a (m,) with the same elements in units of a.

    f (m,): of the profile at the line, slopes (m, e, 13) at nodes; u (m, 2, e, 13): of nodes, of
    what is linear in u(a) and 1. So are reaction (m, 2): σ, s₀; amplitudes (m, n, 2): A.
    """

    body: Body
    poles: Poles
    elements: Elements
    a: Array
    f: Array
    slopes: Array
    u: Array
    swept: Swept
    amplitudes: Complex
    reaction: Array

    @property
    def weights(self) -> Array:
        """Of nodes, with the measure (m, e, 13), of both sides or all around."""
        wide = self.body.whole * self.a ** (self.body.power + 1)
        return np.asarray(wide[:, None, None] * self.elements.mass)

    @property
    def stretched(self) -> Array:
        """γ₁/2 ∫f'² (m,)."""
        density = self.body.scene.gamma1 / 2 * self.slopes**2
        return np.asarray((self.weights * density).sum(axis=(1, 2)))

    @functools.cached_property
    def pressure(self) -> Array:
        """At nodes (m, 2, e, 13)."""
        outside = _outside(self.poles)
        outside[1:] = 1 - outside[1:]
        c = np.append(self.poles.flow, self.poles.c)
        fields = inside.total(self.elements, self.swept, outside @ self.amplitudes, c)
        return np.asarray(self.poles.still * self.u + fields)

    @functools.cached_property
    def lines(self) -> Array:
        """What the lines pull in all, (m, 2)."""
        length = self.body.whole * self.a[:, None] ** self.body.power
        return np.asarray(self.body.scene.gamma1 * length * self.reaction)

    @functools.cached_property
    def form(self) -> Array:
        """∫p u + m S u(a) (m, 2, 2), p and S of the first, u of the second."""
        flat = (self.a.size, 2, -1)
        pressed = (self.pressure * self.weights[:, None]).reshape(flat)
        found = pressed @ self.u.reshape(flat).swapaxes(1, 2)
        found[:, :, 0] += self.lines
        return np.asarray(found)


def _outside(poles: Poles) -> Complex:
    """ψ, and φ of the other poles, of what decays by each λ (n, n)."""
    found = 1 / (np.append(poles.first, poles.tau)[:, None] - poles.decays**2)
    found[1:] *= poles.tau[:, None]
    return np.asarray(found)


def contacts(body: Body, a: Array, tolerance: float, first: float = 0.5) -> Contacts:
    """Of half-widths or radii (m,), with poles to a tolerance; first: see `elements.grid`.

    Of several only where no breaks are inside.
    """
    scene, wide, power = body.scene, a[:, None, None], body.power
    response = poles(scene.layer, scene.gamma1, tolerance)
    shortest = 1 / float(np.abs(np.sqrt(response.tau)).max())
    ends = inside.grid(float(a.max()), shortest, body.breaks, body.kinks, first)
    own = inside.elements(power, ends)
    x, f = wide * own.x, body.height(a)
    slopes, u = body.slope(x, _INTO), np.ones((a.size, 2, *own.x.shape))
    u[:, 1] = f[:, None, None] - body.height(x)
    bent = np.zeros_like(u)
    bent[:, 1] = wide * inside.risen(own, slopes)
    flow = (wide**2 * own.mass)[:, None] * u
    tau, real = np.outer(a * a, response.tau), response.tau.imag == 0  # real ones first
    loads = (tau[:, real].real, bent), (tau[:, ~real], bent)
    swept = inside.sweep(own, (response.first * a[:, None] ** 2, flow), *loads)
    outwards = -decayed(power, response.decays, a, np.zeros(a.size), 1).T
    amplitudes = _amplitudes(response, outwards * a[:, None], swept)
    reaction = (outwards[:, None] @ amplitudes)[:, 0].real
    return Contacts(body, response, own, a, f, slopes, u, swept, amplitudes, reaction)


def each(body: Body, a: Array, tolerance: float) -> Iterator[Contacts]:
    """The same in groups: one by one where breaks are inside, else all at once."""
    alike = not any(x < a.max() for x in body.breaks)
    return (contacts(body, part, tolerance) for part in ([a] if alike else np.split(a, a.size)))


def _amplitudes(poles: Poles, out: Complex, found: Swept) -> Complex:
    """A (m, n, 2), by u(a) and what fields take inside; out (m, n): a times what decays pull."""
    wanted = np.concatenate([np.zeros_like(found.given[:, :1]), -found.given], axis=1)
    wanted[:, 1] *= -1
    wanted[:, 0, 0] = 1
    wanted[:, 2:, 0] += found.own[:, 1:]
    fields = (found.own[..., None] + out[:, None]) * _outside(poles)
    matrix = np.concatenate([np.ones_like(out[:, None]), fields], axis=1)
    high = np.abs(matrix).max(axis=2, keepdims=True)
    wide = np.abs(matrix / high).max(axis=1, keepdims=True)
    return np.linalg.solve(matrix / high / wide, wanted / high) / wide.swapaxes(1, 2)
