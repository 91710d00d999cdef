"""Power law f = c rⁿ, n >= 1, turned about its axis: n = 1 a cone, n = 2 a sphere, R = 1/(2c).

The natural unknown is the radius a of the contact. The line rests at a at the depth

    d = c aⁿ − D q,    D = δ₀ − l n c aⁿ⁻¹,    q = K₀/K₁ at a/l.

Where adhesion pulls (w > 0; for a cone c < α), d(a) falls from a = 0 to the radius at which the
contact detaches under imposed depth, and rises from there on: the branch that is followed. A cone
with c >= α does not adhere, and its line is never pinned at the tip: a(d) grows from d = 0 on.

Conventions: the depth d of the lowest point and displacements u are positive into the layer, forces
P where the indenter is pressed. l = √(γ₁/k), δ₀ = √(2w/k), α = √(2w/γ₁); with s = a/l, `decay(s)`
is q and `growth(s)` is s² q'(s) = s² (q² − 1) + sq, between 0 and ½. The surface is displaced by −D
q at the line. All arguments but n broadcast; every card raises ValueError for n < 1, an array n, c
<= 0, k <= 0, γ₁ < 0 and w < 0. `crossing` finds where a function becomes positive between two ends.

Imported: `critical_separation(k, w)` is δ₀ = √(2w/k). `elastocapillary_length(k, gamma1)` is
l = √(γ₁/k). `scaled(a, l)` is s = a/l, and ∞ where l = 0. `joined(x, a, inside, u_a, l)` is
`inside` where |x| <= a, and beyond the surface that decays from u_a. `Values` is a float for
numbers, an array for arrays. `excess(name, value, bound, remedy)` is value − bound, 0 where it is
negative by rounding, and an error below. `refuse(name, value, bad, remedy)` raises ValueError where
`bad` is true. `unwrap` makes a number of an array without axes.

A `Jump` has the force, depth and radius of the contact and `energy_released`, >= 0; a `PullOff` the
first three.
"""

import numpy as np
from numpy.typing import ArrayLike

from energy.cards._checks import Array, excess, finite, positive, refuse, unwrap
from energy.cards._types import Jump, PullOff, Values
from energy.cards.axisymmetric._bessel import decay, growth, scaled
from energy.cards.axisymmetric._roots import crossing
from energy.cards.axisymmetric._surface import joined
from energy.cards.plane import critical_separation
from energy.cards.tail import elastocapillary_length

# Where `pull_off` looks for a. At its root n c aⁿ⁺¹ <= (2a + 2l + l/2) δ₀, since q <= 1,
# growth <= ½, D <= δ₀ and f'' >= 0. Of 2a and 5l/2 one is the larger: n c aⁿ <= 4δ₀ where it is 2a,
# n c aⁿ⁺¹ <= 5l δ₀ where it is 5l/2.
_MOST_WITHOUT_TENSION = 4.0  # of δ₀/(nc), the n-th power of a radius
_MOST_WITH_TENSION = 5.0  # of l δ₀/(nc), the power n + 1 of a radius
# An upper end of the radius at a depth, over the root of c aⁿ = d + δ₀, where `depth` is at least
# d: a thousandth more, since that power is rounded.
_MARGIN = 1.001


class _Shape:
    """The indenter and the layer of a card, and what they have at a radius a of the contact.

    Parameters
    ----------
    c, n, k, gamma1, w
        As the cards have them.

    Attributes
    ----------
    c, n, k
        The same, checked.
    ell, delta0 : ndarray
        l and δ₀ [m].
    """

    def __init__(
        self, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
    ) -> None:
        """Check the arguments, and take l and δ₀ from them."""
        exponent = finite("n", n)
        refuse("n", exponent, exponent < 1.0, "must be >= 1: a cusp has no small slopes")
        if np.ndim(exponent) > 0:
            raise ValueError(f"n = {n!r} must be one number: loop over exponents")
        self.c = positive("c", c)
        self.n = float(exponent)
        self.k = positive("k", k)
        self.ell = np.asarray(elastocapillary_length(k, gamma1))[()]
        self.delta0 = np.asarray(critical_separation(k, w))[()]

    def driven(self, a: Array) -> Array:
        """D = δ₀ − l f'(a) [m]; the displacement at the line is −D q."""
        return self.delta0 - self.ell * self.n * self.c * a ** (self.n - 1.0)

    def bend(self, a: Array) -> Array:
        """l f''(a) [1]; 0 for a cone."""
        n = self.n
        return self.ell * n * (n - 1.0) * self.c * a ** (n - 2.0) if n > 1.0 else 0.0 * a

    def depth(self, a: Array) -> Array:
        """d [m] at which a line rests at a, the formula of the module."""
        return self.c * a**self.n - self.driven(a) * decay(scaled(a, self.ell))

    def depth_slope(self, a: Array) -> Array:
        """a² dd/da [m²], which is finite for a → 0."""
        s = scaled(a, self.ell)
        rise = self.n * self.c * a ** (self.n + 1.0) + a**2 * self.bend(a) * decay(s)
        return rise - self.driven(a) * self.ell * growth(s)

    def force(self, a: Array) -> Array:
        """P/(πk) [m³], the formula of `force_of_radius`."""
        n = self.n
        q = decay(scaled(a, self.ell))
        pressed = n * self.c * a ** (n + 2.0) / (n + 2.0)
        return pressed - a * (a * q + 2.0 * self.ell) * self.driven(a)

    def force_slope(self, a: Array) -> Array:
        """dP/da/(πk) [m²]."""
        s = scaled(a, self.ell)
        q = decay(s)
        steeper = self.ell * growth(s) + 2.0 * a * q + 2.0 * self.ell
        pressed = self.n * self.c * a ** (self.n + 1.0)
        bent = a * (a * q + 2.0 * self.ell) * self.bend(a)
        return pressed + bent - steeper * self.driven(a)

    def least_radius(self) -> Array:
        """Where d(a) turns: 0 if it rises from the start.

        At the root n c aⁿ⁺¹ <= D l growth <= δ₀ l/2, so that it lies below `top`.
        """
        top = (self.delta0 * self.ell / (self.n * self.c)) ** (1.0 / (self.n + 1.0))
        return crossing(self.depth_slope, np.zeros_like(top), top)

    def radius(self, d: ArrayLike) -> Array:
        """The radius at a depth, on the branch where it grows with the depth.

        ValueError below the least depth of that branch.
        """
        d = finite("d", d)
        least = self.least_radius()
        remedy = "the contact has detached, pass d >= that of detachment(...)"
        depth_of_point = np.where(self.ell > 0.0, 0.0, -self.delta0)  # a → 0, where q → 0 with l
        lowest = np.where(least > 0.0, self.depth(least), depth_of_point)
        over = excess("d", d, unwrap(lowest), remedy, scale=self.delta0)
        top = ((np.maximum(d, lowest) + self.delta0) / self.c) ** (1.0 / self.n)
        a = crossing(lambda r: self.depth(r) - d, np.minimum(least, top), _MARGIN * top)
        # At the least depth itself, where d(a) is flat, the radius is known better than by its
        # root.
        return unwrap(np.where(over > 0.0, np.maximum(a, least), least))


def radius(
    d: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Radius of the contact at a depth, on the branch where it grows with the depth.

    The a at which `depth` is d.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        a [m].

    Raises
    ------
    ValueError
        Below the depth of `detachment`, and for parameters out of range.
    """
    return _Shape(c, n, k, gamma1, w).radius(d)


def depth(
    a: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Depth at which a line rests at a radius, stable or not.

    d = c aⁿ − (δ₀ − l n c aⁿ⁻¹) q(a/l), for a > 0.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        d [m].

    Raises
    ------
    ValueError
        For a <= 0, and parameters out of range.
    """
    return unwrap(_Shape(c, n, k, gamma1, w).depth(positive("a", a)))


def displacement(
    x: ArrayLike,
    *,
    d: ArrayLike,
    c: ArrayLike,
    n: float,
    k: ArrayLike,
    gamma1: ArrayLike,
    w: ArrayLike,
) -> Values:
    """Displacement of the surface under the indenter and beside it.

    u = d − c|x|ⁿ in contact, u_a K₀(|x|/l)/K₀(a/l) outside.

    Parameters
    ----------
    x : array_like
        Distances from the axis [m].
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        u [m], of the common shape of all arguments.

    Raises
    ------
    ValueError
        As `radius`.
    """
    shape = _Shape(c, n, k, gamma1, w)
    x = finite("x", x)
    d = finite("d", d)
    a = shape.radius(d)
    u_a = d - shape.c * a**shape.n
    inside = d - shape.c * np.abs(x) ** shape.n
    return joined(x, a, inside, u_a, shape.ell)


def force(
    d: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force at a depth.

    `force_of_radius` at `radius`.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.

    Raises
    ------
    ValueError
        As `radius`.
    """
    shape = _Shape(c, n, k, gamma1, w)
    return unwrap(np.pi * shape.k * shape.force(shape.radius(d)))


def force_of_radius(
    a: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Force at a radius.

    P = πk (n c aⁿ⁺²/(n + 2) − (a²q + 2al)(δ₀ − l n c aⁿ⁻¹)), a > 0.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        P [N], compressive forces positive.

    Raises
    ------
    ValueError
        For a <= 0, and parameters out of range.
    """
    shape = _Shape(c, n, k, gamma1, w)
    return unwrap(np.pi * shape.k * shape.force(positive("a", a)))


def energy(
    d: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Energy of the layer at a depth.

    `energy_of_radius` at `radius`; P = dU/dd.

    Parameters
    ----------
    d : array_like
        Depth of the level f = 0 below the undeformed surface [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        U [J]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        As `radius`.
    """
    shape = _Shape(c, n, k, gamma1, w)
    return _energy(shape, shape.radius(d))


def energy_of_radius(
    a: ArrayLike, *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Energy of the layer at a radius.

    U = π ∫₀ᵃ (k(d − f)² + γ₁f'²) r dr + πγ₁ (a/l)(d − f(a))²/q − wπa², d of `depth`, a > 0.

    Parameters
    ----------
    a : array_like
        Radius of the contact [m].
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        U [J]; 0: undeformed surface without contact.

    Raises
    ------
    ValueError
        For a <= 0, and parameters out of range.
    """
    return _energy(_Shape(c, n, k, gamma1, w), positive("a", a))


def _energy(shape: _Shape, a: Array) -> Values:
    """U [J] at a radius: the integral of `energy_of_radius` in closed form.

    With v = a f'(a) = n c aⁿ, t = l f'(a) = lv/a and u_a = −D q

        U = πk (u_a v a²/(n + 2) + v²a²/(2(n + 1)(n + 2)) + a²t²/(2n)
                + D²(a²(q² − 1) + 2alq)/2 − a²t(2δ₀ − t)/2),

    where a²(q² − 1) + alq = l² growth.
    """
    n = shape.n
    ell = shape.ell
    driven = shape.driven(a)
    s = scaled(a, ell)
    q = decay(s)
    v = n * shape.c * a**n
    t = shape.delta0 - driven
    in_v = v * (v / (2.0 * (n + 1.0)) - driven * q) / (n + 2.0)
    in_t = t * (t / n - (2.0 * shape.delta0 - t)) / 2.0
    in_D = driven**2 * ell * (ell * growth(s) + a * q) / 2.0
    return unwrap(np.pi * shape.k * (a**2 * (in_v + in_t) + in_D))


def pull_off(*, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> PullOff:
    """The most tensile state, where a dead load detaches the contact.

    There dP/da = 0.

    All 0 for a cone with c >= α.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    PullOff
        P [N], d [m] and a [m].

    Raises
    ------
    ValueError
        For n < 1 and other parameters out of range.
    """
    shape = _Shape(c, n, k, gamma1, w)
    n = shape.n
    steep = shape.n * shape.c  # nc, of f' = n c aⁿ⁻¹
    delta0 = shape.delta0
    without_tension = (_MOST_WITHOUT_TENSION * delta0 / steep) ** (1.0 / n)
    with_tension = (_MOST_WITH_TENSION * shape.ell * delta0 / steep) ** (1.0 / (n + 1.0))
    top = np.maximum(without_tension, with_tension)
    a = crossing(shape.force_slope, np.zeros_like(top), top)
    force = np.pi * shape.k * shape.force(a)
    return PullOff(unwrap(force), unwrap(shape.depth(a)), a)


def adhesion_force(
    *, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike
) -> Values:
    """Largest pull that the contact bears.

    F_A = −P of `pull_off`.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        F_A [N], >= 0.

    Raises
    ------
    ValueError
        For n < 1 and other parameters out of range.
    """
    return -pull_off(c=c, n=n, k=k, gamma1=gamma1, w=w).force


def detachment(*, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Detachment under imposed depth.

    (P, d, a, released) at the least depth of the branch, dd/da = 0, under imposed depth.

    With tension always at a > 0; all 0 for a cone with c >= α.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N], d [m], a [m] and the energy released [J].

    Raises
    ------
    ValueError
        For n < 1 and other parameters out of range.
    """
    shape = _Shape(c, n, k, gamma1, w)
    a = shape.least_radius()
    return Jump.of(np.pi * shape.k * shape.force(a), shape.depth(a), a, _energy(shape, a))


def jump_in(*, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Jump:
    """Jump into contact on touching at imposed depth.

    (P, 0, a, released) with a = `radius` at d = 0, where the contact touches; −U is released.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    Jump
        P [N], d [m], a [m] and the energy released [J].

    Raises
    ------
    ValueError
        For n < 1 and other parameters out of range.
    """
    shape = _Shape(c, n, k, gamma1, w)
    a = shape.radius(0.0)
    return Jump.of(np.pi * shape.k * shape.force(a), 0.0, a, -np.asarray(_energy(shape, a)))


def loop_area(*, c: ArrayLike, n: float, k: ArrayLike, gamma1: ArrayLike, w: ArrayLike) -> Values:
    """Energy dissipated in a loop under imposed depth that starts and ends detached.

    ∮P dd, to any depth >= 0 and back, is what both jumps release.

    Parameters
    ----------
    n : float
        Exponent, >= 1.
    c, k, gamma1, w : array_like
        Coefficient of f = c rⁿ [m¹⁻ⁿ], stiffness of the foundation [N/m³], surface tension [N/m]
        and work of adhesion [J/m²].

    Returns
    -------
    float or ndarray
        ∮P dd [J].

    Raises
    ------
    ValueError
        For n < 1 and other parameters out of range.
    """
    first = jump_in(c=c, n=n, k=k, gamma1=gamma1, w=w)
    last = detachment(c=c, n=n, k=k, gamma1=gamma1, w=w)
    return first.energy_released + last.energy_released
