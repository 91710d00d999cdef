"""Random scenes for the closed forms, and their energies in 50 digits."""

import mpmath as mp
import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from energy import cards

axi = cards.axisymmetric
every = settings(derandomize=True, deadline=None, max_examples=40)
EIGHTH_ORDER = [1 / 280, -4 / 105, 1 / 5, -4 / 5, 0, 4 / 5, -1 / 5, 4 / 105, -1 / 280]
SIGNS = (-1.0) ** np.arange(60)
T, DT = (0.5 * part for part in np.polynomial.legendre.leggauss(60))
T = 0.5 + T  # Gauss points and weights on [0, 1]
KINDS = ["wedge", "parabola", "1.0", "1.5", "2.0", "3.7"]


class Shape:
    """c|x|ⁿ with its card and all of its parameters."""

    def height(self, x):
        return self.c * np.abs(x) ** self.n

    def slope(self, x):
        return self.c * self.n * np.abs(x) ** (self.n - 1)

    def __call__(self, name, *values):
        return getattr(self.card, name)(*values, **self.args)


class Case(Shape):
    """A card with its parameters, the same profile as c|x|ⁿ, least depth and depth."""

    def __init__(self, kind, ell, size, k, ratio, lift, adhesive=True):
        """`size`: δ₀ if adhesive; `ratio`: c size⁻¹ max(l, size)ⁿ; `lift`: (d − least)/size."""
        n = {"wedge": 1.0, "parabola": 2.0}.get(kind) or float(kind)
        c = ratio * size / max(ell, size) ** n
        self.delta0 = size * adhesive
        geometry = {"wedge": {"delta": float(np.arctan(c))}, "parabola": {"R": 0.5 / c}}
        self.card = getattr(cards, kind if kind in geometry else "power_law")
        self.geometry = geometry.get(kind, {"c": c, "n": n})
        self.layer = {"k": k, "gamma1": k * ell**2}
        self.args = {**self.geometry, **self.layer, "w": 0.5 * k * self.delta0**2}
        self.kind = kind
        self.n = n
        self.ell = ell
        self.c = np.tan(np.arctan(c)) if kind == "wedge" else c
        self.q = ell * self.c - self.delta0 if n == 1 else -self.delta0  # least for a free line
        self.least = min(self.q, 0.0)
        self.d = self.least + lift * size

    @property
    def name(self):
        """wedge, parabola or power_law."""
        return self.card.__name__.rsplit(".", 1)[1]

    def stiffness(self, ratio):
        """A machine stiffness K = κk, κ a ratio of the scene's lengths."""
        return ratio * self.args["k"] * np.sqrt(self.ell * self.delta0)

    def parts(self, a):
        """Springs, contact surface, tails and adhesion of the energy at (d, a), by quadrature."""
        x = a * T**4
        dx = 4 * a * T**3 * DT
        springs = self.args["k"] * ((self.d - self.height(x)) ** 2 * dx).sum()
        surface = self.args["gamma1"] * (self.slope(x) ** 2 * dx).sum()
        tails = self.args["k"] * self.ell * (self.d - self.height(a)) ** 2
        return np.array([springs, surface, tails, -2 * self.args["w"] * a])


class Round(Shape):
    """A shape with its card, the same as c rⁿ, and a state on the branch that is followed."""

    def __init__(self, kind, ell, k, alpha, ratio, up):
        n = {"cone": 1.0, "sphere": 2.0}.get(kind) or float(kind)
        self.delta0 = alpha * ell
        c = alpha * ratio / (ell ** (n - 1.0)) if n > 1 else 0.9 * alpha * min(1.0, ratio)
        self.card = {"cone": axi.cone, "sphere": axi.sphere}.get(kind, axi.power_law)
        own = {"cone": {"delta": float(np.arctan(c))}, "sphere": {"R": 0.5 / c}}
        self.args = {"k": k, "gamma1": k * ell**2, "w": k * self.delta0**2 / 2}
        self.power = {"c": c, "n": n, **self.args}
        self.args = {**own.get(kind, {"c": c, "n": n}), **self.args}
        self.layer = {"k": k, "gamma1": k * ell**2}
        self.c = c
        self.n = n
        self.ell = ell
        self.k = k
        self.w = self.args["w"]
        self.least = axi.power_law.detachment(**self.power)
        self.a = float(self.least.half_width) * (1.0 + up)
        self.d = float(self("depth", self.a))

    def parts(self, d, a):
        """Springs, contact surface, free surface and adhesion of the energy, by quadrature."""
        r = a * T**4
        dr = 4 * a * T**3 * DT
        springs = np.pi * self.k * ((d - self.height(r)) ** 2 * r * dr).sum()
        surface = np.pi * self.layer["gamma1"] * (self.slope(r) ** 2 * r * dr).sum()
        free = axi.surface.energy(d - self.height(a), a=a, **self.layer)
        return np.array([springs, surface, free, -np.pi * self.w * a**2])


class Exact:
    """U(a, d) of f = c|x|ⁿ and its derivatives in 50 digits, for floats a card was given."""

    def __init__(self, case):
        k, gamma1, w, n = map(mp.mpf, (*case.layer.values(), case.args["w"], case.n))
        name, value = next(iter(case.geometry.items()))
        value = mp.mpf(value)
        self.c = {"delta": mp.tan(value), "R": 1 / (2 * value), "c": value}[name]
        self.k = k
        self.n = n
        self.ell = mp.sqrt(gamma1 / k)
        self.delta0 = mp.sqrt(2 * w / k)
        self.q = self.ell * self.c - self.delta0 if n == 1 else -self.delta0
        self.end = min(self.q, mp.mpf(0))

    def force(self, a, d):
        f = self.c * a**self.n
        return 2 * self.k * (a * (d - f / (self.n + 1)) + self.ell * (d - f))

    def energy(self, a, d):
        n = self.n
        f = self.c * a**self.n
        slope = self.c * self.n * a ** (self.n - 1)
        springs = a * (d**2 - 2 * d * f / (n + 1) + f**2 / (2 * n + 1)) + self.ell * (d - f) ** 2
        lines = a * ((self.ell * slope) ** 2 / (2 * n - 1) - self.delta0**2)
        return self.k * (springs + lines)

    def depth(self, a):
        """Eq. (16)."""
        slope = self.c * self.n * a ** (self.n - 1)
        return self.c * a**self.n + self.ell * slope - self.delta0

    def depth_on(self, a, K, drive=0):
        """d that balances P(a, d) = K (drive − d): P is linear in d."""
        at0 = self.force(a, mp.mpf(0))
        at1 = self.force(a, mp.mpf(1))
        return (K * drive - at0) / (at1 - at0 + K)

    def half_width(self, d):
        """Eqs. (25), (33) or (16) with (11)."""
        n = self.n
        ell = self.ell
        level = (d + self.delta0) / self.c
        if n == 1:
            return max(level - ell, mp.mpf(0))
        if n == 2:
            return mp.sqrt(ell**2 + level) - ell
        a = level ** (1 / n)  # above the root
        for _ in range(60):  # Newton for ln a
            a *= mp.exp(-mp.log(a ** (n - 1) * (a + n * ell) / level) / (n - 1 + a / (a + n * ell)))
        return a

    def jump_in(self, K, start):
        """a, d, P and the energy released where the descent at fixed drive 0 stops."""
        if self.q >= 0:
            return mp.mpf(0), mp.mpf(0), mp.mpf(0), mp.mpf(0)
        on = (lambda a: mp.mpf(0)) if K is None else (lambda a: self.depth_on(a, K))
        log = mp.findroot(
            lambda x: mp.log((self.depth(mp.exp(x)) + self.delta0) / (on(mp.exp(x)) + self.delta0)),
            mp.log(start),
        )
        a = mp.exp(log)
        d = on(a)
        return a, d, self.force(a, d), -self.energy(a, d) - (K or 0) * d**2 / 2

    def rate(self, a, K):
        """dP/da + K dd/da on the branch: negative where it is unstable."""
        pull = lambda x: self.force(x, self.depth(x)) + K * self.depth(x)  # noqa: E731
        h = a * mp.mpf(10) ** -15
        return (pull(a + h) - pull(a - h)) / h


decades = st.floats(-5, 5).map(lambda e: 10.0**e)
ratios = st.floats(-2, 2).map(lambda e: 10.0**e)
