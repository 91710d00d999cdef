"""Where a contact line rests in rotational symmetry: Eq. (16) with the surfaces of `surface`.

The angle law at the line is that of the line contact, f' + u' = α, Eqs. (12) and (15).
"""

from numpy.typing import ArrayLike

from energy.cards._checks import finite, positive, unwrap
from energy.cards._types import Values
from energy.cards.axisymmetric._bessel import decay, disc, scaled
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length


def depth(
    f_a: ArrayLike,
    slope_a: ArrayLike,
    a: ArrayLike,
    *,
    k: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
) -> Values:
    """d = f(a) − (δ₀ − l f'(a)) q(a/l), q = K₀/K₁: the depth at which an outer line rests at a.

    Eq. (16) for a ≫ l, where q → 1 − l/(2a).
    """
    ell = elastocapillary_length(k, gamma1)
    delta0 = critical_separation(k, w)
    q = decay(scaled(positive("a", a), ell))
    return unwrap(finite("f_a", f_a) - (delta0 - ell * finite("slope_a", slope_a)) * q)


def inner_depth(
    f_b: ArrayLike,
    slope_b: ArrayLike,
    b: ArrayLike,
    *,
    k: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
) -> Values:
    """d = f(b) − (δ₀ + l f'(b)) I₀(b/l)/I₁(b/l): the inner line of a ring, a free disc within.

    Under a flat face a disc needs more than δ₀, the more the smaller it is. ValueError for γ₁ = 0.
    """
    ell = elastocapillary_length(k, positive("gamma1", gamma1))
    delta0 = critical_separation(k, w)
    share = disc(scaled(positive("b", b), ell))
    return unwrap(finite("f_b", f_b) - (delta0 + ell * finite("slope_b", slope_b)) / share)
