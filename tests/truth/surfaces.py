"""Free surfaces: small slopes in closed form, finite slopes from the first integral or collocation.

The reference solutions ask a surface for its tilt at a contact line, its shape, its energy and its
area, the same for both kinds of slopes. g is the displacement at a line, "outward" away from the
contact. The tilt is u' for small slopes and atan u' for finite ones, so that a line rests where

    lean(f') + tilt = deficit,      deficit = √(2w/γ₁)  or  2 asin √(w/(2γ₁))     (12), (15)

and advances while the left side is less: da changes small-slope energy by (γ₁/2 (f' + u')² - w) da.
"""

import functools

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
        self.k = scene.stiffness
        self.gamma1 = scene.gamma1
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
        from_left = p / self.length
        from_right = (width - p) / self.length
        # sinh(q)/sinh(t) and sinh(p)/sinh(t), scaled so that nothing overflows
        of_left = left * np.exp(-from_left) * -np.expm1(-2 * from_right)
        of_right = right * np.exp(-from_right) * -np.expm1(-2 * from_left)
        return (of_left + of_right) / -np.expm1(-2 * (width / self.length))

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
    with the arc length s. In a gap k/2 u² + γ₁ cos φ is another constant: with p = 2l sin(φ/2) and
    dτ = cos(φ/2) ds/l it reads u² - p² = const, and du/dτ = p, dp/dτ = u. So u and p are the sinh
    and cosh of small slopes in τ, and only x is not: dx/dτ = l (1 - p²/2l²)/√(1 - p²/4l²). The one
    unknown of a gap is its range of τ, T, from its width. Below lengths are in units of l.
    """

    def __init__(self, scene):
        self.k = scene.stiffness
        self.gamma1 = scene.gamma1
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
        scaled = [np.asarray(v, float) / self.length for v in (own, other, width)]
        own, other, width = np.broadcast_arrays(*scaled)
        T = _range(own, other, width)
        p_at_line = _p(own, other, T, np.zeros_like(T))
        tilt = 2 * np.arcsin(np.clip(p_at_line / 2, -1, 1))
        return tilt if tilt.ndim else float(tilt)

    def tail_shape(self, s, g):
        """u at distances s >= 0 from the line."""
        s = np.asarray(s, float)
        if g == 0:
            return np.zeros_like(s)
        x = s / self.length
        start = np.arccosh(2 * self.length / abs(g))
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
        x = np.asarray(p, float) / self.length
        left = np.asarray(left, float) / self.length
        right = np.asarray(right, float) / self.length
        T, ends, passed = _tabulated(float(left), float(right), float(width) / self.length)
        panel = np.clip(np.searchsorted(passed, x) - 1, 0, ends.size - 2)
        tau = np.interp(x, passed, ends)
        for _ in range(8):  # Newton's method for x(τ) = x
            off = passed[panel] + _across(left, right, T, ends[panel], tau) - x
            tau = tau - off / _rate(_p(left, right, T, tau))
            if np.abs(off).max(initial=0.0) <= 1e-9 * passed[-1]:  # the next would be rounding
                break
        return self.length * Small.gap_shape(_Unit, tau, T, left, right)

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
        """∫(k/2 u² cos φ + γ₁(1 - cos φ)) ds, ds = l dτ/cos(φ/2), of a gap."""
        left = float(left) / self.length
        right = float(right) / self.length
        T, ends, _ = _tabulated(left, right, float(width) / self.length)
        half = np.diff(ends)[:, None] / 2
        middle = (ends[1:] + ends[:-1])[:, None] / 2
        tau = middle + half * GAUSS[0]
        p2 = _p(left, right, T, tau) ** 2
        u = Small.gap_shape(_Unit, tau, T, left, right)
        density = (u**2 * (1 - p2 / 2) + p2) / 2 / np.sqrt(1 - p2 / 4)
        return self.gamma1 * self.length * float(np.sum(half * GAUSS[1] * density))


@functools.lru_cache(maxsize=256)
def _tabulated(left, right, width):
    """T of a gap, the ends of its panels in τ, and x there."""
    T = float(_range(*(np.array(v) for v in (left, right, width))))
    ends = np.linspace(0, T, _panels(T) + 1)
    passed = np.cumsum(_across(left, right, T, ends[:-1], ends[1:]))
    return T, ends, np.concatenate([[0.0], passed])


class _Unit:
    """A length of 1, for the shapes of `Small` in τ."""

    length = 1.0


GAUSS = np.polynomial.legendre.leggauss(20)


def _panels(T):
    """How many panels of Gauss's rule resolve exponentials over this range."""
    return int(np.ceil(np.max(T, initial=0.0) / 2)) + 1


def _p(left, right, T, tau):
    """p = du/dτ of the u with these ends; without cancellation for a small T, or overflow."""
    up = np.exp(tau - T)
    down = np.exp(-tau)
    one = up * (1 + down * down) * ((right - left) / -np.expm1(-2 * T))  # cosh τ / sinh T
    return one + (up - down) * (left / (1 + np.exp(-T)))  # sinh(τ - T/2) / cosh(T/2)


def _rate(p):
    """dx/dτ; where the surface is not a graph, what keeps Newton's method going."""
    p2 = np.minimum(p * p, STEEP)
    return (1 - p2 / 2) / np.sqrt(1 - p2 / 4)


STEEP = 1.999  # p² of a surface that is nearly upright, which has 2


def _across(left, right, T, low, high):
    """x(high) - x(low) for values of τ, (n,) each."""
    half = (high - low)[..., None] / 2
    middle = (high + low)[..., None] / 2
    return (half * GAUSS[1] * _rate(_p(left, right, T, middle + half * GAUSS[0]))).sum(axis=-1)


def _width(left, right, T):
    """x(T) - x(0)."""
    count = _panels(T)
    low = np.arange(count) / count * T[..., None]
    ends = (left[..., None, None], right[..., None, None], T[..., None, None])
    return _across(*ends, low, low + T[..., None] / count).sum(axis=-1)


def _range(left, right, width):
    """T of gaps with these widths and displacements at their lines, by secants in log T."""
    chord = np.arctan2(right - left, width)
    chord = np.clip(chord, -1.2, 1.2)
    T = width * np.cos(chord / 2) / np.cos(chord)
    before = T * 1.01
    off_before = np.log(_width(left, right, T * 1.01) / width)
    for _ in range(60):
        off = np.log(_width(left, right, T) / width)
        if np.abs(off).max(initial=0.0) <= 4e-16:
            break
        with np.errstate(invalid="ignore", divide="ignore"):
            step = off * np.log(T / before) / (off - off_before)
        step = np.where(np.isfinite(step), np.clip(step, -0.3, 0.3), off)
        before = T
        off_before = off
        T = T * np.exp(-step)
        if np.abs(step).max(initial=0.0) <= 1e-15:
            break
    return T


ASIDE = 4e-15  # of the places: to which side of an edge


def breaks(scene):
    """Where the work of adhesion changes."""
    return () if scene.pattern is None else scene.pattern.edges


class Adhesion:
    """The deficit at which a line rests: √(2w/γ₁), with finite slopes 2 asin √(w/(2γ₁))."""

    def __init__(self, scene, ground):
        pattern = scene.pattern
        factors = np.ones(1)
        self.edges = np.empty(0)
        self._aside = ASIDE * max(abs(ground.lo), abs(ground.hi))
        if pattern is not None:
            self.edges = np.asarray(pattern.edges)
            factors = np.asarray(pattern.factors)
        self.deficits = {}
        for way, w in (1, scene.work_of_adhesion), (-1, scene.opened.work_of_adhesion):
            half = np.sqrt(w * factors / (2 * scene.gamma1))
            self.deficits[way] = 2 * np.arcsin(half) if scene.slopes == "finite" else 2 * half

    def deficit(self, x, toward, way):
        """Of a line at x that would move to this side (±1), outwards (way = 1) or inwards (-1)."""
        if not self.edges.size:
            return self.deficits[way][0]
        return self.deficits[way][self.edges.searchsorted(x + self._aside * toward, "right")]
