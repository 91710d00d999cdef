"""What the poles of a layer do beside a contact line in closed form, for line contacts and an axis.

A field that decays by λ outside a contact of half-width, or radius, a pulls at the line with
λ, or λ K₁(λa)/K₀(λa), over its value there. Inside, a field -φ'' + τφ = τu (about an axis with
-(rφ')'/r) with u = u(a) + f(a) - f(x) obeys, r² = τ, from Green's identity with cosh rx, or I₀(rx),

    -φ'(a) = r t(a) [u(a) - φ(a)] + r ∫₀ᵃ t(x, a) f'(x) dx,

t(x, a) = sinh rx/cosh ra, or (x/a) I₁(rx)/I₀(ra), and t(a) = t(a, a). Scaled Bessel functions, and
beyond where those end, their first terms for large arguments.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray
from scipy.special import i0e, i1e, ive, k0e, k1e, kve

from discretization.layer.poles import paired
from energy import Scene

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
_LARGEST = 2e4  # complex arguments of Bessel functions; beyond, 1/z² terms are the last that count


def lowest(scene: Scene) -> float:
    """x of the lowest point of an indenter that is mirrored about it, or turned about an axis."""
    return 0.0 if scene.axisymmetric else scene.mirror or 0.0


class Line:
    """A line contact that is mirrored about 0.

    whole: what an integral over 0 <= x counts with; power: of x in the measure of that. outside:
    pull of fields (n,) over their value at lines (m,), (m, n). inside: t(x, a) (n, k) of r (n,) at
    x (k,), which are `beside` = a - x from the line. decayed: fields (n, k) outside, 1 at the line,
    or their slopes (order 1), so far beside it.
    """

    whole, power = 2.0, 0

    def outside(self, decays: Complex, a: Array) -> Complex:
        """λ."""
        return np.broadcast_to(decays, (a.size, decays.size))

    def inside(self, r: Complex, x: Array, beside: Array, a: float) -> Complex:
        """sinh rx/cosh ra."""

        def found(r: Complex) -> Complex:
            return -np.exp(-r * beside) * np.expm1(-2 * r * x) / (1 + np.exp(-2 * r * a))

        return paired(found, found, r[:, None])

    def decayed(self, decays: Complex, a: float, beside: Array, order: int) -> Complex:
        """exp(-λx)."""
        return np.asarray(np.exp(-np.outer(decays, beside)) * (-decays[:, None]) ** order)


class Axis:
    """A contact about an axis, likewise."""

    whole, power = 2 * math.pi, 1

    def outside(self, decays: Complex, a: Array) -> Complex:
        """λ K₁(λa)/K₀(λa)."""
        z = np.outer(decays, a)
        return np.asarray((_k(1, z) / _k(0, z)).T * decays)

    def inside(self, r: Complex, x: Array, beside: Array, a: float) -> Complex:
        """(x/a) I₁(rx)/I₀(ra)."""
        found = _i(1, np.outer(r, x)) / _i(0, (r * a)[:, None])
        return np.asarray(found * np.exp(-np.outer(r.real, beside)) * (x / a))

    def decayed(self, decays: Complex, a: float, beside: Array, order: int) -> Complex:
        """K₀(λ(a + x))/K₀(λa)."""
        found = _k(order, np.outer(decays, a + beside)) / _k(0, decays[:, None] * a)
        less = np.exp(-np.outer(decays, beside))
        return np.asarray(found * less * (-decays[:, None]) ** order)


Geometry = Line | Axis


def _i(order: int, z: Complex) -> Complex:
    """I(z) exp(-Re z), Re z >= 0."""

    def above(z: Complex) -> Complex:
        near = np.where(np.abs(z) < _LARGEST, z, 1.0)
        with np.errstate(divide="ignore", invalid="ignore"):
            far = np.exp(1j * z.imag) / np.sqrt(2 * math.pi * z) * (1 - (4 * order - 1) / (8 * z))
        return np.where(np.abs(z) < _LARGEST, ive(order, near), far)

    return paired(i1e if order else i0e, above, z)


def _k(order: int, z: Complex) -> Complex:
    """K(z) exp(z)."""

    def above(z: Complex) -> Complex:
        near = np.where(np.abs(z) < _LARGEST, z, 1.0)
        far = np.sqrt(math.pi / (2 * z)) * (1 + (4 * order - 1) / (8 * z))
        return np.where(np.abs(z) < _LARGEST, kve(order, near), far)

    return paired(k1e if order else k0e, above, z)
