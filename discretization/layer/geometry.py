"""What the poles of a layer do on both sides of a contact line, for line contacts and an axis.

A field that decays by λ outside a contact of half-width, or radius, a pulls at the line with
λ, or λ K₁(λa)/K₀(λa), over its value there. Inside, a field -φ'' + τφ = τu (about an axis with
-(rφ')'/r) with u = u(a) + f(a) - f(x) obeys, r² = τ, from Green's identity with cosh rx, or I₀(rx),

    -φ'(a) = r t(a) [u(a) - φ(a)] + r ∫₀ᵃ t(x, a) f'(x) dx,

t(x, a) = sinh rx/cosh ra, or (x/a) I₁(rx)/I₀(ra), and t(a) = t(a, a). Scaled Bessel functions, and
beyond where those end, their first terms for large arguments.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray
from scipy.special import ive, kve

from energy import Scene

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
_UNFELT = 38.0  # decay lengths, beyond which nothing is left
_LARGEST = 2e4  # arguments of Bessel functions; beyond, 1/z² terms are the last that count


def lowest(scene: Scene) -> float:
    """x of the lowest point of an indenter that is mirrored about it, or turned about an axis."""
    return 0.0 if scene.axisymmetric else float(scene.indenter.apex or 0.0)


class Geometry(Protocol):
    """A line contact that is mirrored about 0, or one about an axis."""

    whole: float

    def measure(self, x: Any) -> Any:
        """What an integral over x counts with, over `whole`."""

    def outside(self, decays: Complex, a: float) -> Complex:
        """Pull of fields outside over their value at the line."""

    def inside(self, r: Complex, x: Array, beside: Array, a: float) -> Complex:
        """t(x, a) (n, k) of poles r (n,) at x (k,), which are `beside` = a - x from the line."""

    def decayed(self, decays: Complex, a: float, beside: Array) -> tuple[Complex, Complex]:
        """Fields and their slopes (n, k) outside, so far beside a line where they are 1."""

    def moment(self, x: Array, a: float) -> Array:
        """∫ₓᵃ (a² - x²)/2 as a weight: what flow at x adds to the force inside a."""


class Line:
    """A line contact."""

    whole = 2.0

    def measure(self, x: Any) -> Any:
        """1."""
        return np.ones_like(x)

    def outside(self, decays: Complex, a: float) -> Complex:
        """λ."""
        return decays

    def inside(self, r: Complex, x: Array, beside: Array, a: float) -> Complex:
        """sinh rx/cosh ra."""
        found = -np.exp(-np.outer(r, beside)) * np.expm1(-2 * np.outer(r, x))
        return np.asarray(found / (1 + np.exp(-2 * r * a))[:, None])

    def decayed(self, decays: Complex, a: float, beside: Array) -> tuple[Complex, Complex]:
        """exp(-λx)."""
        found = np.exp(-np.outer(decays, beside))
        return found, -decays[:, None] * found

    def moment(self, x: Array, a: float) -> Array:
        """(a² - x²)/2."""
        return (a - x) * (a + x) / 2


class Axis:
    """A contact about an axis."""

    whole = 2 * math.pi

    def measure(self, x: Any) -> Any:
        """r."""
        return x

    def outside(self, decays: Complex, a: float) -> Complex:
        """λ K₁(λa)/K₀(λa)."""
        z = decays * a
        near = np.where(np.abs(z) < _LARGEST, z, 1.0)
        far = 1 + 1 / (2 * z) - 1 / (8 * z * z)
        return decays * np.where(np.abs(z) < _LARGEST, kve(1, near) / kve(0, near), far)

    def inside(self, r: Complex, x: Array, beside: Array, a: float) -> Complex:
        """(x/a) I₁(rx)/I₀(ra)."""
        decay, found = np.outer(r.real, beside), np.zeros((r.size, x.size), complex)
        felt = decay < _UNFELT
        found[felt] = _scaled(1, np.outer(r, x)[felt]) * np.exp(-decay[felt])
        return np.asarray(found / _scaled(0, r * a)[:, None] * (x / a))

    def decayed(self, decays: Complex, a: float, beside: Array) -> tuple[Complex, Complex]:
        """K₀(λ(a + x))/K₀(λa)."""
        z, less = np.outer(decays, a + beside), np.exp(-np.outer(decays, beside))
        found, slope = (
            _scaled_k(order, z) / _scaled_k(0, decays * a)[:, None] * less for order in (0, 1)
        )
        return found, -decays[:, None] * slope

    def moment(self, x: Array, a: float) -> Array:
        """(a² - r²)/4."""
        return (a - x) * (a + x) / 4


def _scaled(order: int, z: Complex) -> Complex:
    """I(z) exp(-Re z), Re z >= 0."""
    near = np.where(np.abs(z) < _LARGEST, z, 1.0)
    with np.errstate(divide="ignore", invalid="ignore"):
        far = np.exp(1j * z.imag) / np.sqrt(2 * math.pi * z) * (1 - (4 * order - 1) / (8 * z))
    return np.where(np.abs(z) < _LARGEST, ive(order, near), far)


def _scaled_k(order: int, z: Complex) -> Complex:
    """K(z) exp(z)."""
    near = np.where(np.abs(z) < _LARGEST, z, 1.0)
    far = np.sqrt(math.pi / (2 * z)) * (1 + (4 * order - 1) / (8 * z))
    return np.where(np.abs(z) < _LARGEST, kve(order, near), far)
