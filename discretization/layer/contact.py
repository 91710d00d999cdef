"""One contact of a layer, condensed to its line: where it rests, and what it takes.

In units h = G = 1. v_j = u - φ_j of pole j obeys, with the measure m of the geometry and v_j known
at the line,

    -(m v')' + τ_j m v = (m f')'    on 0 < x < a,    v'(0) + f'(0) = 0,

and the flow p₀ of an incompressible layer -(m p₀')' = k₁ m u, p₀'(0) = 0: a pole at τ = 0. With
these on elements (elements.py) it is known what the fields pull at the line from inside. Outside,
the layer and the surface are balanced by u = Σ A exp(-λ(x-a)) of the decays of `Poles` (about an
axis K₀(λr)), in which φ_j is τ_j/(τ_j - λ²) of u. That φ_j has one value and one slope at the line
are, with u = d - f(a) there, as many linear equations as decays. So all is linear in u(a) and 1,
and the reaction of all that is free or pressed beside a line is

    S = Γ (σ u(a) + s₀).

Of ∂U/∂a = m [Γ/2 (f' - S/Γ)² - w] the line rests where that vanishes, m the length of the line:

    D(a) = f(a) + (f'(a) - s₀ - √(2w/Γ))/σ,    P = whole ∫₀ᵃ p dm + whole m S,

with the layer's pressure p = k₀u + Σ c_j v_j + p₀. The square is left because f' Γ - S is the force
on the line and a line that advances takes the surface along. What is stored at fixed a is
½ whole (∫p u dm + m S u(a)), and whole Γ/2 ∫f'² dm of the surface in contact.
"""

from __future__ import annotations

import functools
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from discretization.layer import elements as inside
from discretization.layer.body import Body
from discretization.layer.elements import Elements, Swept
from discretization.layer.poles import Poles

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
_INTO = np.array([1] + [0] * 11 + [-1])  # of a corner the slope inside the element


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts of half-widths a (m,) with the same elements in units of a.

    f, slope (m,): of the profile at the line, slopes (m, e, 13) at nodes; u (m, 2, e, 13): of
    nodes, of what is linear in u(a) and 1. So are reaction (m, 2): σ, s₀; amplitudes (m, n, 2): A.
    """

    poles: Poles
    gamma: float
    power: int
    elements: Elements
    a: Array
    f: Array
    slope: Array
    slopes: Array
    u: Array
    swept: Swept
    amplitudes: Complex
    reaction: Array

    @property
    def length(self) -> Array:
        """m at the lines (m,)."""
        return self.a**self.power

    @property
    def weights(self) -> Array:
        """Of nodes, with the measure (m, e, 13)."""
        return np.asarray(self.a[:, None, None] ** (self.power + 1) * self.elements.mass)

    @property
    def stretched(self) -> Array:
        """½Γ ∫f'² dm (m,)."""
        return np.asarray(self.gamma / 2 * (self.weights * self.slopes**2).sum(axis=(1, 2)))

    @functools.cached_property
    def at_line(self) -> Complex:
        """v there (m, n, 2)."""
        return np.asarray((1 - self.poles.share) @ self.amplitudes)

    @property
    def volumes(self) -> Complex:
        """∫v dm (m, n, 2)."""
        found = inside.volumes(self.elements, self.swept, self.at_line)
        return np.asarray(found * (self.length * self.a)[:, None, None])

    @functools.cached_property
    def pressure(self) -> Array:
        """At nodes (m, 2, e, 13)."""
        own, poles, wide = self.elements, self.poles, self.a[:, None, None]
        found = poles.still * self.u + inside.total(own, self.swept, self.at_line, poles.c)
        if poles.flow:
            load = poles.flow * (wide**2 * own.mass)[:, None] * self.u
            there = ((-poles.flow / poles.decays**2) @ self.amplitudes)[:, None]
            whole = np.moveaxis(load.sum(axis=-1), 1, -1)[:, :, None]
            flowing = inside.sweep(own, np.zeros((self.a.size, 1), complex), load, whole)
            found = found + inside.total(own, flowing, there, np.ones(1, complex))
        return np.asarray(found)

    @functools.cached_property
    def form(self) -> Array:
        """∫p u dm + m S u(a) (m, 2, 2), p and S of the first, u of the second."""
        flat = (self.a.size, 2, -1)
        pressed = (self.pressure * self.weights[:, None]).reshape(flat)
        found = pressed @ self.u.reshape(flat).swapaxes(1, 2)
        found[:, :, 0] += self.gamma * self.length[:, None] * self.reaction
        return np.asarray(found)


def contacts(body: Body, a: Array, tolerance: float) -> Contacts:
    """Of half-widths or radii (m,), with poles to a tolerance.

    Of several only where no breaks are inside.
    """
    poles, geometry = body.poles(tolerance), body.geometry
    shortest = 1 / float(np.abs(np.sqrt(poles.tau)).max())
    ends = inside.grid(float(a.max()), shortest, body.breaks, body.kinks, rough=body.rough)
    own, wide = inside.elements(geometry.power, ends), a[:, None, None]
    x, f = wide * own.x, np.asarray(body.height(a), float)
    slopes = np.asarray(body.slope(x, _INTO))
    u = np.ones((a.size, 2, *own.x.shape))
    u[:, 1] = f[:, None, None] - body.height(x)
    load = np.zeros_like(u)
    load[:, 1] = wide * inside.risen(own, slopes)
    found = inside.sweep(own, poles.tau * a[:, None] ** 2, load)
    flow = poles.flow * (u * own.mass).sum(axis=(2, 3)) * a[:, None]
    amplitudes, reaction = _outside(poles, geometry.outside(poles.decays, a), a, found, flow)
    slope = np.asarray(body.slope(a, -1), float)
    known = (poles, body.gamma, geometry.power, own, a, f, slope, slopes, u)
    return Contacts(*known, found, amplitudes, reaction)


def _outside(
    poles: Poles, out: Complex, a: Array, taken: Swept, flow: Array
) -> tuple[Complex, Array]:
    """A (m, n, 2), and σ, s₀ (m, 2), by what fields take inside; flow (m, 2): k₁ ∫u dm/m."""
    share, one = poles.share, np.array([1.0, 0.0])
    size = np.sqrt(poles.tau)[:, None] * a[:, None, None]
    fields = (taken.own[..., None] + (out * a[:, None])[:, None]) * share / size
    rows = [np.ones((a.size, 1, out.shape[1])), fields]
    wanted = [
        np.broadcast_to(one, (a.size, 1, 2)),
        (taken.own[..., None] * one - taken.given) / size,
    ]
    if poles.flow:
        rows.append((-poles.flow / poles.decays**2 * out)[:, None])
        wanted.append(flow[:, None])
    matrix = np.concatenate(rows, axis=1)
    size = np.abs(matrix).max(axis=1, keepdims=True)
    found = np.linalg.solve(matrix / size, np.concatenate(wanted, axis=1)) / size.swapaxes(1, 2)
    return found, (out[:, None] @ found)[:, 0].real
