"""Free surfaces: small slopes in closed form, finite slopes from the first integral or collocation.

The reference solutions ask a surface for its tilt at a contact line, its shape, its energy and its
area, the same for both kinds of slopes. g is the displacement at a line, "outward" away from the
contact. The tilt is u' for small slopes and atan u' for finite ones, so that a line rests where

    lean(f') + tilt = deficit,      deficit = √(2w/γ₁)  or  2 asin √(w/(2γ₁))     (12), (15)

and advances while the left side is less: moving it by da changes the energy of small slopes by
(γ₁/2 (f' + u')² - w) da.
"""

import numpy as np

FAR = 36.0  # decay lengths beyond which exp(-t) is less than rounding


def surface_of(scene):
    """The free surfaces of this scene. ValueError without surface tension."""
    if not scene.gamma1:
        raise ValueError("gamma1 = 0: springs are independent; use truth.sets.springs")
    return (Small if scene.slopes == "small" else Finite)(scene)


class Small:
    """Small slopes: γ₁ u'' = k u (5), tails exp(-x/l) (6) and gaps of sinh."""

    def __init__(self, scene):
        self.k, self.gamma1 = scene.stiffness, scene.gamma1
        self.length = scene.elastocapillary_length
        self.deficit = scene.surfaces.small_slope_deficit

    def lean(self, slope):
        """The indenter's outward slope as a tilt."""
        return slope

    def tail(self, g):
        """Outward tilt of a tail at its line."""
        return -g / self.length

    def facing(self, own, other, width):
        """Outward tilt of a gap's surface at the line with displacement `own`."""
        t = np.minimum(width / self.length, 10 * FAR)
        return -((own - other) / np.sinh(t) + own * np.tanh(t / 2)) / self.length

    def tail_shape(self, s, g):
        """u at distances s >= 0 from the line."""
        return g * np.exp(-s / self.length)

    def gap_shape(self, p, width, left, right):
        """u at distances p from the left line of a gap; left, right: u at its lines."""
        p, q, t = p / self.length, (width - p) / self.length, width / self.length
        whole = -np.expm1(-2 * t)
        one = left * np.exp(-p) * -np.expm1(-2 * q)
        return (one + right * np.exp(-q) * -np.expm1(-2 * p)) / whole

    def tail_area(self, g):
        """∫u dx of a tail."""
        return g * self.length

    def gap_area(self, left, right, width):
        """∫u dx of a gap."""
        return self.length * (left + right) * np.tanh(width / self.length / 2)

    def tail_energy(self, g):
        """∫(k/2 u² + γ₁/2 u'²) dx of a tail."""
        return self.gamma1 / (2 * self.length) * g * g

    def gap_energy(self, left, right, width):
        """∫(k/2 u² + γ₁/2 u'²) dx of a gap."""
        t = np.minimum(width / self.length, 10 * FAR)
        terms = (left - right) ** 2 / np.sinh(t) + (left**2 + right**2) * np.tanh(t / 2)
        return self.gamma1 / (2 * self.length) * terms


class Finite:
    """Finite slopes: k u = γ₁ (sin φ)', u' = tan φ.

    A tail has the first integral k/2 u² = γ₁ (1 - cos φ), so |u| = 2l sin(φ/2) = 2l sech((s+s₀)/l)
    with the arc length s; a gap is solved by Newton's method at Chebyshev points.
    """

    def __init__(self, scene):
        self.k, self.gamma1 = scene.stiffness, scene.gamma1
        self.length = scene.elastocapillary_length
        self.deficit = scene.surfaces.angle_deficit

    def lean(self, slope):
        """The indenter's outward slope as an angle."""
        return np.arctan(slope)

    def tail(self, g):
        """Outward angle of a tail at its line; beyond ±π/2 it is not a graph."""
        return -2 * np.arcsin(np.clip(g / (2 * self.length), -1, 1))

    def facing(self, own, other, width):
        """Outward angle of a gap's surface at the line with displacement `own`."""
        own, other, width = np.broadcast_arrays(
            *(np.asarray(a, float) for a in (own, other, width))
        )
        tilt = np.asarray(self.tail(own), float).copy()
        near = width < FAR * self.length
        if near.any():
            slope = self._gap(own[near], other[near], width[near])[2][:, 0]
            tilt[near] = np.arctan(slope)
        return tilt if tilt.ndim else float(tilt)

    def tail_shape(self, s, g):
        """u at distances s >= 0 from the line."""
        s = np.asarray(s, float)
        if g == 0:
            return np.zeros_like(s)
        x, start = s / self.length, np.arccosh(2 * self.length / abs(g))
        arc = x + 2 * (1 - np.tanh(start))  # above the solution, from where Newton is monotone
        for _ in range(60):
            cosine = 1 - 2 / np.cosh(arc + start) ** 2
            step = (arc - 2 * (np.tanh(arc + start) - np.tanh(start)) - x) / cosine
            arc = arc - step
            if np.abs(step).max(initial=0.0) <= 1e-15 * (1 + np.abs(x).max(initial=0.0)):
                break
        return np.sign(g) * 2 * self.length / np.cosh(arc + start)

    def gap_shape(self, p, width, left, right):
        """u at distances p from the left line of a gap; left, right: u at its lines."""
        if width >= FAR * self.length:
            return self.tail_shape(p, left) + self.tail_shape(width - p, right)
        points, u, _, _ = self._gap(*(np.array([v], float) for v in (left, right, width)))
        return _interpolated(points, u[0], 2 * np.asarray(p) / width - 1)

    def tail_area(self, g):
        """∫u dx = l² sin φ of a tail."""
        return self.length**2 * -np.sin(self.tail(g))

    def gap_area(self, left, right, width):
        """∫u dx = l² [sin φ] of a gap."""
        angles = self.facing(np.array([left, right]), np.array([right, left]), width)
        return -(self.length**2) * np.sin(angles).sum()

    def tail_energy(self, g):
        """∫(k/2 u² + γ₁(√(1+u'²) - 1)) dx = 4/3 γ₁ l (1 - cos³(φ/2)) of a tail."""
        half = np.cos(np.asarray(self.tail(g)) / 2)
        sine = (g / (2 * self.length)) ** 2  # 1 - cos² without cancellation
        return 4 / 3 * self.gamma1 * self.length * sine * (1 + half + half**2) / (1 + half)

    def gap_energy(self, left, right, width):
        """∫(k/2 u² + γ₁(√(1+u'²) - 1)) dx of a gap."""
        if width >= FAR * self.length:
            return self.tail_energy(left) + self.tail_energy(right)
        _, u, slope, weights = self._gap(*(np.array([v], float) for v in (left, right, width)))
        square = slope[0] ** 2
        density = self.k / 2 * u[0] ** 2 + self.gamma1 * square / (1 + np.sqrt(1 + square))
        return width / 2 * weights @ density

    def _gap(self, left, right, width):
        """Points in [-1, 1], u and u' there (n, N), weights: l² u'' = u (1 + u'²)^(3/2)."""
        t = width / self.length
        N = 24 + 2 * int(np.ceil(t.max()))
        x, D, weights = _chebyshev(N)
        scale = (2 / t)[:, None]
        a, b, at = left[:, None] / self.length, right[:, None] / self.length, (1 + x) / 2
        small = Small.gap_shape(_Unit, at * t[:, None], t[:, None], a, b)
        u, second = small, (D @ D)[None] * scale[:, :, None] ** 2
        for _ in range(60):
            slope = (u @ D.T) * scale
            root = np.sqrt(1 + slope**2)
            residual = u @ (D @ D).T * scale**2 - u * root**3
            jacobian = second - (3 * u * root * slope * scale)[:, :, None] * D[None]
            jacobian[:, range(N), range(N)] -= root**3
            jacobian[:, [0, -1], :] = 0
            jacobian[:, [0, -1], [0, -1]] = 1
            residual[:, [0, -1]] = 0
            step = np.linalg.solve(jacobian, residual[:, :, None])[:, :, 0]
            size = np.abs(step).max(axis=1) / (np.abs(u).max(axis=1) + 1e-300)
            u = u - step
            if size.max() <= 1e-12:
                break
        return x, u * self.length, (u @ D.T) * scale, weights


class _Unit:
    length = 1.0


_known: dict = {}


def _chebyshev(n):
    """Chebyshev-Lobatto points increasing in [-1, 1], derivative matrix, Clenshaw-Curtis weights."""
    if n not in _known:
        theta = np.pi * np.arange(n)[::-1] / (n - 1)
        x = np.cos(theta)
        c = np.where((np.arange(n) == 0) | (np.arange(n) == n - 1), 2.0, 1.0)
        c = c * (-1.0) ** np.arange(n)
        D = np.outer(c, 1 / c) / (x[:, None] - x + np.eye(n))
        D -= np.diag(D.sum(axis=1))
        even = np.arange(0, n, 2)
        moments = np.zeros(n)
        moments[even] = 2 / (1 - even.astype(float) ** 2)
        weights = np.linalg.solve(np.cos(np.outer(np.arange(n), theta)), moments)
        _known[n] = x, D, weights
    return _known[n]


def _interpolated(points, values, x):
    """Barycentric interpolation at Chebyshev-Lobatto points."""
    weights = (-1.0) ** np.arange(points.size)
    weights[[0, -1]] /= 2
    apart = np.asarray(x, float)[..., None] - points
    exact = apart == 0
    ratio = weights / np.where(exact, 1.0, apart)
    found = (ratio @ values) / ratio.sum(axis=-1)
    return np.where(exact.any(axis=-1), (exact * values).sum(axis=-1), found)
