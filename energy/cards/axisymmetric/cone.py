"""Cone f = r tan δ: the wedge turned about its axis. With t = tan δ and D = δ₀ − lt,

    d = a t − D q,    P = πk (a³t/3 − (a²q + 2al) D).

The line is never pinned at the tip, as that of a wedge is: for t >= α the radius grows from zero at
d = 0 and the cone does not adhere; for t < α it detaches at a > 0.
"""

from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, positive, unwrap, wedge_slope
from energy.cards._types import Jump, PullOff, Values
from energy.cards.axisymmetric import power_law
from energy.cards.axisymmetric._bessel import decay, growth, scaled
from energy.cards.axisymmetric._roots import crossing
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length


def _lengths(
    delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> tuple[Array, Array, Array]:
    """tan δ, l and D."""
    slope = wedge_slope(delta)
    ell = np.asarray(elastocapillary_length(k, gamma1))[()]
    return slope, ell, unwrap(critical_separation(k, w) - ell * slope)


def _as_power_law(delta: ArrayLike) -> dict[str, Any]:
    return {"c": wedge_slope(delta), "n": 1.0}


def radius(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """a of `depth`, on the branch where it grows with d. ValueError below that of `detachment`."""
    return power_law.radius(d, **_as_power_law(delta), k=k, gamma1=gamma1, w=w)


def depth(
    a: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """d = a tan δ − D q, at which a line rests at a > 0, stable or not."""
    slope, ell, driven = _lengths(delta, k, gamma1, w)
    a = positive("a", a)
    return unwrap(slope * a - driven * decay(scaled(a, ell)))


def displacement(
    x: ArrayLike, *, d: ArrayLike, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """u = d − |x| tan δ in contact, (d − a tan δ) K₀(|x|/l)/K₀(a/l) outside. Errors as `radius`."""
    return power_law.displacement(x, d=d, **_as_power_law(delta), k=k, gamma1=gamma1, w=w)


def force(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """P at the depth d: that of `radius`."""
    a = np.asarray(radius(d, delta=delta, k=k, gamma1=gamma1, w=w))
    return unwrap(_force(a, *_lengths(delta, k, gamma1, w), positive("k", k)))


def force_of_radius(
    a: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """P = πk (a³ tan δ/3 − (a²q + 2al) D), a > 0."""
    return unwrap(_force(positive("a", a), *_lengths(delta, k, gamma1, w), positive("k", k)))


def _force(a: Array, slope: Array, ell: Array, driven: Array, k: Array) -> Array:
    q = decay(scaled(a, ell))
    return np.pi * k * (slope * a**3 / 3.0 - a * (a * q + 2.0 * ell) * driven)


def energy(
    d: ArrayLike, *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """U at the depth d; P = dU/dd. ValueError below the depth of `detachment`."""
    return power_law.energy(d, **_as_power_law(delta), k=k, gamma1=gamma1, w=w)


def pull_off(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> PullOff:
    """The most tensile state (P, d, a): a² tan δ = l D (3sq + s²(q² − 1) + 2), s = a/l.

    All 0 for tan δ >= α.
    """
    slope, ell, driven = _lengths(delta, k, gamma1, w)
    pulling = np.maximum(driven, 0.0)

    def rise(a: Array) -> Array:
        s = scaled(a, ell)
        steeper = ell * growth(s) + 2.0 * a * decay(s) + 2.0 * ell
        return slope * a**2 - steeper * pulling

    top = np.maximum(4.0 * pulling / slope, np.sqrt(5.0 * ell * pulling / slope))
    a = crossing(rise, np.zeros_like(top), top)
    d = slope * a - driven * decay(scaled(a, ell))
    return PullOff(
        unwrap(_force(a, slope, ell, driven, positive("k", k))), unwrap(np.asarray(d)), a
    )


def adhesion_force(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """F_A = −P of `pull_off`: the largest pull the contact bears."""
    return -pull_off(delta=delta, k=k, gamma1=gamma1, w=w).force


def adhesion_force_stiff(
    *, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """(4/3) πk δ₀³/tan² δ (1 − ¾ l tan δ/δ₀), l tan δ ≪ δ₀: springs with a little tension."""
    slope, ell, _ = _lengths(delta, k, gamma1, w)
    delta0 = critical_separation(k, w)
    bracket = delta0 - 0.75 * ell * slope
    return unwrap(4 / 3 * np.pi * positive("k", k) * (delta0 / slope) ** 2 * bracket)


def detachment(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """(P, d, a, released) at the least depth, l tan δ = D (q² + q/s − 1), under imposed depth.

    All 0 for tan δ >= α.
    """
    return power_law.detachment(**_as_power_law(delta), k=k, gamma1=gamma1, w=w)


def jump_in(*, delta: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """(P, 0, a, released) on touching at imposed depth; all 0 for tan δ >= α."""
    return power_law.jump_in(**_as_power_law(delta), k=k, gamma1=gamma1, w=w)
