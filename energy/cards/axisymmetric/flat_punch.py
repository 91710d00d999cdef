"""Flat cylinder of radius a: `energy.cards.flat_punch` turned about its axis.

The line is pinned at the edge until the surface beside it has the slope α; that is at −δ₀ q(a/l),
a smaller lift than the δ₀ of a wide face, under imposed depth and dead load alike.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, excess, finite, positive, unwrap
from energy.cards._types import Jump, Values
from energy.cards.axisymmetric._bessel import decay, growth, scaled
from energy.cards.axisymmetric._surface import joined
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length


def _lengths(a: ArrayLike, k: ArrayLike, gamma1: ArrayLike) -> tuple[Array, Array, Array]:
    """a, l and q(a/l)."""
    a = positive("a", a)
    ell = np.asarray(elastocapillary_length(k, gamma1))[()]
    return a, ell, decay(scaled(a, ell))


def _attached(d: ArrayLike, least: Values) -> Array:
    excess("d", finite("d", d), least, "the punch has detached, pass d >= detachment_depth(...)")
    return finite("d", d)


def displacement(
    x: ArrayLike, *, d: ArrayLike, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """u = d under the face, d K₀(|x|/l)/K₀(a/l) outside. ValueError for d < −δ₀ q."""
    d = _attached(d, detachment_depth(a=a, k=k, gamma1=gamma1, w=w))
    a, ell, _ = _lengths(a, k, gamma1)
    return joined(finite("x", x), a, d, d, ell)


def force(d: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """P = (πka² + 2πγ₁ (a/l)/q) d with the line at the edge. ValueError for d < −δ₀ q."""
    d = _attached(d, detachment_depth(a=a, k=k, gamma1=gamma1, w=w))
    a, ell, q = _lengths(a, k, gamma1)
    return unwrap(np.pi * positive("k", k) * a * (a + 2.0 * ell / q) * d)


def energy(d: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """U = (πk/2)(a² + 2al/q) d² − wπa². ValueError for d < −δ₀ q."""
    d = _attached(d, detachment_depth(a=a, k=k, gamma1=gamma1, w=w))
    delta0, (a, ell, q) = critical_separation(k, w), _lengths(a, k, gamma1)
    stored = (a + 2.0 * ell / q) * d**2 - a * delta0**2
    return unwrap(0.5 * np.pi * positive("k", k) * a * stored)


def adhesion_force(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """F_A = πk δ₀ (a²q + 2al) = πka²δ₀q + 2πa √(2wγ₁), under imposed depth and dead load alike."""
    delta0, (a, ell, q) = critical_separation(k, w), _lengths(a, k, gamma1)
    return unwrap(np.pi * positive("k", k) * delta0 * a * (a * q + 2.0 * ell))


def detachment_depth(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """d = −δ₀ q(a/l): the slope α beside the edge, and the end of the metastable branch."""
    return -critical_separation(k, w) * _lengths(a, k, gamma1)[2]


def detachment(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """(P, d, a, released) = (−F_A, −δ₀q, a, (πk/2) δ₀² (a²(q² − 1) + 2alq)) under imposed depth."""
    delta0, (radius, ell, q) = critical_separation(k, w), _lengths(a, k, gamma1)
    left = ell * (
        ell * growth(scaled(radius, ell)) + radius * q
    )  # a²(q² − 1) + 2alq, not cancelled
    force = -adhesion_force(a=a, k=k, gamma1=gamma1, w=w)
    released = 0.5 * np.pi * positive("k", k) * delta0**2 * left
    return Jump.of(force, -delta0 * q, radius, released)


def global_pull_off_depth(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """d = −δ₀ √(a/(a + 2l/q)): below it the detached state has the lower energy."""
    a, ell, q = _lengths(a, k, gamma1)
    return -critical_separation(k, w) * np.sqrt(a / (a + 2.0 * ell / q))
