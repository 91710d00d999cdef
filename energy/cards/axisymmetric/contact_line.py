"""Where a contact line rests in rotational symmetry: Eq. (16) with the surfaces of `surface`.

The angle law at the line is that of the line contact, f' + u' = α, Eqs. (12) and (15).

Conventions: f is positive upwards, the depth d of the level f = 0 and displacements u downwards,
slopes are d/dr. An outer line, at r = a, has the contact on its inner side; the inner line of a
ring, at r = b, has it on its outer side, where the angle law is −f' − u' = α. l = √(γ₁/k),
δ₀ = √(2w/k), α = δ₀/l; `decay(s)` is K₀(s)/K₁(s), `disc(s)` is I₁(s)/I₀(s).

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `scaled(a, l)` is s = a/l, and ∞ where l = 0. `Values` is a float for numbers, an array
for arrays. `unwrap` makes a number of an array without axes. `finite` and `positive` check an
argument, whose name comes first, and return it as float64.
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
    """Depth at which an outer contact line rests.

    d = f(a) − (δ₀ − l f'(a)) q(a/l), q = K₀/K₁.

    Eq. (16) for a ≫ l, where q → 1 − l/(2a).

    Parameters
    ----------
    f_a : array_like
        Height of the profile at the line [m].
    slope_a : array_like
        Slope of the profile at the line [1].
    a : array_like
        Radius of the contact [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].
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
    """Depth at which the inner line of a ring rests.

    d = f(b) − (δ₀ + l f'(b)) I₀(b/l)/I₁(b/l), with a free disc inside the ring.

    Under a flat face a disc needs more than δ₀, the more the smaller it is.

    Parameters
    ----------
    f_b : array_like
        Height of the profile at the inner line [m].
    slope_b : array_like
        Slope of the profile at the inner line [1].
    b : array_like
        Radius of the inner line of a ring [m].
    k, gamma1, w : array_like
        Stiffness of the foundation [N/m³], surface tension [N/m] and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].

    Raises
    ------
    ValueError
        For γ₁ = 0.
    """
    ell = elastocapillary_length(k, positive("gamma1", gamma1))
    delta0 = critical_separation(k, w)
    i1_over_i0 = disc(scaled(positive("b", b), ell))
    lift = (delta0 + ell * finite("slope_b", slope_b)) / i1_over_i0  # −u at the line
    return unwrap(finite("f_b", f_b) - lift)
