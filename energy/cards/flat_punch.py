"""Flat punch of half-width a, Eqs. (21)-(23).

The contact line is pinned at the edge for d > −δ₀; at d = −δ₀ every contact width is neutral
and the punch lets go at once. That is the end of the *metastable* branch: the detached state
has the lower energy already at the shallower `global_pull_off_depth`.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, excess, finite, non_negative, positive
from energy.cards._surface import joined
from energy.cards._types import Values
from energy.cards.plane import critical_depth, critical_separation
from energy.cards.tail import elastocapillary_length

_REMEDY = "the punch has let go, pass d >= -sqrt(2w/k)"


def displacement(
    x: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """u = −δ₀ exp(−(|x| − a)/l) outside, −δ₀ under the punch, Eq. (21): at detachment.

    ValueError for a <= 0, k <= 0, γ₁ < 0 or w < 0.
    """
    x = finite("x", x)
    a = positive("a", a)
    u_a = np.asarray(critical_depth(k, w))
    return joined(x, a, u_a, u_a, np.asarray(elastocapillary_length(k, gamma1)))


def force(
    d: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike | None = None
) -> Values:
    """P = 2k (a + l) d, Eq. (11) with the line pinned at the edge.

    Valid for d >= −δ₀. w does not enter the value: given, it makes smaller depths a ValueError.
    """
    d = finite("d", d)
    a = positive("a", a)
    k = positive("k", k)
    if w is not None:
        excess("d", d, critical_depth(k, w), _REMEDY)
    return 2.0 * k * (a + elastocapillary_length(k, gamma1)) * d


def force_at_detachment(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """P = −2^(3/2) √w (a √k + √γ₁), Eq. (22): `force` at d = −δ₀."""
    return -adhesion_force(a=a, k=k, gamma1=gamma1, w=w)


def adhesion_force(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """F_A = 2^(3/2) √w (a √k + √γ₁), Eq. (23), of the metastable branch.

    The globally stable punch bears only 2k δ₀ √(a (a + l)). ValueError for a <= 0, k <= 0,
    γ₁ < 0 or w < 0.
    """
    a = positive("a", a)
    k = positive("k", k)
    w = non_negative("w", w)
    bracket = a * np.sqrt(k) + np.sqrt(non_negative("gamma1", gamma1))
    pull: Values = 2.0 * np.sqrt(2.0 * w) * bracket
    return pull


def energy(d: ArrayLike, *, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """U = k (a + l) d² − 2wa: springs in contact, two tails, adhesion. ValueError for d < −δ₀."""
    d = finite("d", d)
    a = positive("a", a)
    k = positive("k", k)
    excess("d", d, critical_depth(k, w), _REMEDY)
    stored = k * (a + elastocapillary_length(k, gamma1)) * d**2
    return stored - 2.0 * non_negative("w", w) * a


def detachment_depth(*, k: ArrayLike, w: ArrayLike) -> Values:
    """d = −δ₀, Eq. (20): the end of the metastable branch, with `energy` 2wl left to lose."""
    return critical_depth(k, w)


def global_pull_off_depth(*, a: ArrayLike, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """d = −δ₀ √(a/(a + l)): below it the detached state has the lower energy (`energy` > 0)."""
    a = positive("a", a)
    ell = elastocapillary_length(k, gamma1)
    share: Array = np.sqrt(a / (a + ell))
    return -critical_separation(k, w) * share
