"""The half-infinite free tails of a lattice: the surface they describe, their elimination.

Small slopes: a factor λ per node. Finite slopes, in units k = γ₁ = l = 1 with spacing h = Δx/l: a
tail whose first node is displaced by u pulls at it with S(u) (the node's own spring not counted);
its next node is at u'. Balance of the first link and of that node are one functional equation,

    u' = u - h σ(S(u)),    S(u) = h u' + S(u'),    σ(q) = q/√(1-q²): slope of a link pulling by q.

S is odd, S = u s(z) with z = u², and smooth; with the slope σ(S) = u p(z), the bracket [a,b] of a
divided difference and q = 1 - h p, u' = q u, the equation divided by h u' is free of cancellation:

    p (D + h) = 1,    D = s(z) + q (1+q) z s[z, q²z],    p = s/√(1 - z s²).

s is the polynomial that obeys it at the Chebyshev points of 0 <= z <= reach², by Newton's method
from the linear tail p = √(1+h²/4) - h/2. Likewise ψ(u) = u (1 + z r(z)) with ψ(u') = λ ψ(u), in
which a step along the tail is a factor λ: node j is at ψ⁻¹(λʲ ψ(u)).
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import NDArray

from discretization.lattice.finite_spans import ENDLESS, finite_span
from discretization.lattice.shares import shares

Array = NDArray[Any]
TURNING = 1.3  # displacement in l; at √2 a surface of finite slope turns over
_POINTS = 40  # Chebyshev points: the coefficients are rounding from there on
_LEAST_LINKS = 8  # between two lines, however near, to read a slope from
_NEWTON = 40  # steps of Newton's method


@dataclass(frozen=True, eq=False)
class TailResponse:
    """Chebyshev coefficients of s, of its mean over 0..z and of r on 0 <= z <= reach²."""

    h: float
    reach: float
    s: Array
    mean: Array
    r: Array

    def _at(self, coefficients: Array, z: Array | float) -> Array:
        return chebyshev.chebval(2 / self.reach**2 * z - 1, coefficients)

    def _derivative(self, coefficients: Array, z: Array | float) -> Array:
        return 2 / self.reach**2 * self._at(chebyshev.chebder(coefficients), z)

    def reaction(self, u: Array) -> Array:
        """S(u) = dF/du; beyond ±reach that at ±reach."""
        u = np.clip(u, -self.reach, self.reach)
        return u * self._at(self.s, u * u)

    def stiffness(self, u: Array) -> Array:
        """S'(u)."""
        z = u * u
        return self._at(self.s, z) + 2 * z * self._derivative(self.s, z)

    def energy(self, u: Array) -> Array:
        """F(u) = ∫₀ᵘ S du."""
        return u * u / 2 * self._at(self.mean, u * u)

    def fall(self, u: Array) -> Array:
        """(u - u')/h, the slope of the tail's first link."""
        pull = self.reaction(u)
        return pull / np.sqrt((1 - pull) * (1 + pull))

    def after(self, u: Array) -> Array:
        """u', the tail's next node."""
        return u - self.h * self.fall(u)

    def parting(self, u: Array, rise: Array) -> Array:
        """√(2 cost/h) of putting the next node at u - h·rise, with the sign of rise - fall.

        The cost is the change of ½h v² + h(√(1+((u-v)/h)²) - 1) + F(v) from v = u' to that v,
        written with second divided differences so that nothing cancels. Beyond ±reach, where no
        state is accepted, S is constant and F(u) the only reference.
        """
        fall, steep = self.fall(u), np.sqrt(1 + rise * rise)
        flat, moved = np.sqrt(1 + fall * fall), u - self.h * rise
        y, z = (np.clip(v, -self.reach, self.reach) for v in (u - self.h * fall, moved))
        tail = self._at(self.s, y * y) + (y + z) ** 2 * self._bend(y * y, z * z)
        link = 2 / (flat * (flat * steep + 1 + fall * rise))
        inside = np.abs(rise - fall) * np.sqrt(self.h**2 + self.h * tail + link)
        outside = moved * moved + 2 * (rise * rise / (1 + steep) - rise * self.reaction(u))
        size = np.where(np.abs(u) <= self.reach, inside, np.sqrt(np.maximum(outside, 0)))
        return np.copysign(size, rise - fall)

    def _bend(self, y: Array, z: Array) -> Array:
        """Second divided difference of ∫s dz at y, y, z, by that of Chebyshev's recurrence."""
        scale = 2 / self.reach**2
        y, z = scale * y - 1, scale * z - 1
        value, before = y, np.ones_like(y)
        slope, slope_before = np.ones_like(y), np.zeros_like(y)
        bend, bend_before, total = np.zeros_like(y), np.zeros_like(y), np.zeros_like(y)
        for c in chebyshev.chebint(self.s)[2:]:
            bend, bend_before = 2 * (z * bend + slope) - bend_before, bend
            slope, slope_before = 2 * (y * slope + value) - slope_before, slope
            value, before = 2 * y * value - before, value
            total = total + c * bend
        return scale * total

    def flow(self, u: Array | float, factor: Array) -> Array:
        """Where the tail is after ψ has decayed by `factor`: ψ⁻¹(factor·ψ(u)), by Newton's method.

        ψ is concave for u > 0, so the steps rise towards the solution from u = ψ.
        """
        target = factor * self._psi(u)[0]
        found = target
        for _ in range(_NEWTON):
            value, slope = self._psi(found)
            found = found + (step := (target - value) / slope)
            if np.all(np.abs(step) <= 1e-15 * np.abs(found)):
                break
        return found

    def steepness(self, u: Array) -> Array:
        """ψ/ψ' at u: the outward slope of the flow is that times ln λ/h."""
        value, slope = self._psi(u)
        return value / slope

    def _psi(self, u: Array | float) -> tuple[Array, Array]:
        z = u * u
        r = self._at(self.r, z)
        return u * (1 + z * r), 1 + z * (3 * r + 2 * z * self._derivative(self.r, z))


@dataclass(frozen=True)
class LatticeTail:
    """Free nodes beyond a contact: u decays by exp(-rate) per length, Eq. (6) on the lattice."""

    rate: float

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """u_line exp(-rate·distance)."""
        return u_line * np.exp(-self.rate * distance)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """-rate·u_line."""
        return -self.rate * u_line

    def between(
        self, p: Array, q: Array, width: float, left: float, right: float, radius: float = math.inf
    ) -> Array:
        """[left sinh(rate·q) + right sinh(rate·p)]/sinh(rate·width), small slopes only."""
        near, far, _ = shares(self.rate, p, q)
        return near * left + far * right

    def slope_between(
        self, width: Array, own: Array, other: Array, radius: Any = math.inf
    ) -> Array:
        """Slope of `between` at a line with u = own towards the next one, `width` away."""
        once, twice = np.exp(-self.rate * width), np.expm1(-2 * self.rate * width)
        return self.rate * ((2 + twice) * own - 2 * once * other) / twice


@dataclass(frozen=True)
class FiniteTail(LatticeTail):
    """The same with finite slopes: ψ decays by exp(-rate) per length."""

    length: float
    response: TailResponse

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """ψ⁻¹(ψ(u_line) exp(-rate·distance)): the nodes and a smooth line through them."""
        decayed = np.exp(-self.rate * distance)
        return self.length * self.response.flow(u_line / self.length, decayed)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """-rate·ψ/ψ'."""
        return -self.rate * self.length * self.response.steepness(u_line / self.length)

    def between(
        self, p: Array, q: Array, width: float, left: float, right: float, radius: float = math.inf
    ) -> Array:
        """Cubics through nodes about as far apart as the lattice's, with their u''."""
        if self.rate * width > ENDLESS:
            return self.displacement(p, left) + self.displacement(q, right)
        u, bend, _ = self._through(width, left, right)
        h = width / (u.size - 1)
        i = np.clip((p / h).astype(int), 0, u.size - 2)
        t = p / h - i
        chord = u[i] + t * (u[i + 1] - u[i])
        return np.asarray(
            chord - h * h / 6 * t * (1 - t) * ((2 - t) * bend[i] + (1 + t) * bend[i + 1])
        )

    def slope_between(
        self, width: Array, own: Array, other: Array, radius: Any = math.inf
    ) -> Array:
        """The slope of that line."""
        far = self.rate * width > ENDLESS
        lines = zip(width.tolist(), own.tolist(), other.tolist(), far.tolist(), strict=True)
        return np.array(
            [
                float(self.slope(np.array(u))) if apart else self._through(size, u, v)[2]
                for size, u, v, apart in lines
            ]
        )

    def _through(self, width: float, left: float, right: float) -> tuple[Array, Array, float]:
        """Nodes u, their u'' = u (1 + u'²)^{3/2}/l², and the slope u' at the left line."""
        links = max(_LEAST_LINKS, round(width / (self.response.h * self.length)))
        ends, h = (left / self.length, right / self.length), width / links
        u = self.length * finite_span(h / self.length, *ends, links).u
        bend = u * (1 + np.gradient(u, h) ** 2) ** 1.5 / self.length**2
        return u, bend, float((u[1] - u[0]) / h - h * (2 * bend[0] + bend[1]) / 6)


@functools.lru_cache(maxsize=64)
def tail_response(h: float) -> TailResponse:
    """Solve the collocation equations for the spacing h = Δx/l."""
    reach = TURNING + 0.02 + 2 * h
    x = chebyshev.chebpts1(_POINTS)
    z, to_coefficients = (x + 1) / 2 * reach**2, np.linalg.inv(chebyshev.chebvander(x, _POINTS - 1))
    p = _first_slopes(h, reach, z, to_coefficients)
    s = to_coefficients @ (p / np.sqrt(1 + z * p * p))
    t, weights = np.polynomial.legendre.leggauss(_POINTS // 2)
    mean = chebyshev.chebval((t + 1)[:, None] * z / reach**2 - 1, s).T @ weights / 2
    r = _conjugacy(h, reach, z, to_coefficients, p)
    return TailResponse(h, reach, _trimmed(s), _trimmed(to_coefficients @ mean), _trimmed(r))


def _first_slopes(h: float, reach: float, z: Array, to_coefficients: Array) -> Array:
    """p at the points z."""
    p = np.full(z.size, _linear(h))
    for _ in range(_NEWTON):
        cosine, q = 1 / np.sqrt(1 + z * p * p), 1 - h * p
        s, spread = p * cosine, q * (1 + q) * z
        difference = _differences(z, q * q * z, reach) @ to_coefficients
        d = s + spread * (difference @ s)
        # the change of s[z, q²z] with q, which is of order h, is left out of the derivative
        jacobian = p[:, None] * (np.eye(z.size) + spread[:, None] * difference) * cosine**3
        jacobian += np.diag(d + h - p * h * (1 + 2 * q) * z * (difference @ s))
        step = np.linalg.solve(jacobian, 1 - p * (d + h))
        change = float(np.max(np.abs(step) / p))
        p = p + step * min(1.0, 0.5 / change)
        if change <= 1e-13:
            return p
    raise ArithmeticError(f"the tail of a lattice with spacing {h!r} l did not converge: {change}")


def _conjugacy(h: float, reach: float, z: Array, to_coefficients: Array, p: Array) -> Array:
    """Coefficients of r: ψ(u') = λ ψ(u), λ = 1 - h p(0), divided by h u z, is linear in r."""
    q = 1 - h * p
    spread, bent = p * q * (1 + q), (p - _linear(h)) / z
    difference = _differences(z, q * q * z, reach) @ to_coefficients
    rows = np.diag(z * bent + spread) + (spread * q * q * z)[:, None] * difference
    return np.asarray(to_coefficients @ np.linalg.solve(rows, -bent))


def _linear(h: float) -> float:
    """p(0) = √(1+h²/4) - h/2 without cancellation: the tail of small slopes."""
    return 1 / (h / 2 + math.hypot(1, h / 2))


def _differences(y: Array, z: Array, reach: float) -> Array:
    """Divided differences of the Chebyshev polynomials at y, z: (points, degrees)."""
    y, z = 2 / reach**2 * y - 1, 2 / reach**2 * z - 1
    value, slope = np.ones((_POINTS, y.size)), np.zeros((_POINTS, y.size))
    value[1], slope[1] = y, 1
    for n in range(1, _POINTS - 1):
        value[n + 1] = 2 * y * value[n] - value[n - 1]
        slope[n + 1] = 2 * (z * slope[n] + value[n]) - slope[n - 1]
    return 2 / reach**2 * slope.T


def _trimmed(coefficients: Array) -> Array:
    """Without the trailing coefficients that are rounding."""
    kept = np.flatnonzero(np.abs(coefficients) > 2e-16 * np.abs(coefficients).max())
    return coefficients[: max(3, kept[-1] + 1)]
