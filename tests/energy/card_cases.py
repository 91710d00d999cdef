"""Random scenes for the closed forms, and how numbers are compared."""

import numpy as np
from hypothesis import settings
from hypothesis import strategies as st

from energy import cards

every = settings(derandomize=True, deadline=None, max_examples=60)
SIGNS = (-1.0) ** np.arange(60)
T, DT = (0.5 * part for part in np.polynomial.legendre.leggauss(60))
T = 0.5 + T  # Gauss points and weights on [0, 1]
KINDS = ["wedge", "parabola", "1.0", "1.5", "2.0", "3.7"]


class Case:
    """A card with its parameters, the same profile as c|x|ⁿ, least depth and depth."""

    def __init__(self, kind, ell, size, k, ratio, lift, adhesive=True):
        """`size`: δ₀ if adhesive; `ratio`: c size⁻¹ max(l, size)ⁿ; `lift`: (d − least)/size."""
        n = {"wedge": 1.0, "parabola": 2.0}.get(kind) or float(kind)
        c, self.delta0 = ratio * size / max(ell, size) ** n, size * adhesive
        geometry = {"wedge": {"delta": float(np.arctan(c))}, "parabola": {"R": 0.5 / c}}
        self.card = getattr(cards, kind if kind in geometry else "power_law")
        self.geometry = geometry.get(kind, {"c": c, "n": n})
        self.layer = {"k": k, "gamma1": k * ell**2}
        self.args = {**self.geometry, **self.layer, "w": 0.5 * k * self.delta0**2}
        self.n, self.ell, self.c = n, ell, np.tan(np.arctan(c)) if kind == "wedge" else c
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

    def height(self, x):
        return self.c * np.abs(x) ** self.n

    def slope(self, x):
        return self.c * self.n * np.abs(x) ** (self.n - 1)

    def __call__(self, name, *values):
        return getattr(self.card, name)(*values, **self.args)

    def parts(self, a):
        """Springs, contact surface, tails and adhesion of the energy at (d, a), by quadrature."""
        x, dx = a * T**4, 4 * a * T**3 * DT
        springs = self.args["k"] * ((self.d - self.height(x)) ** 2 * dx).sum()
        surface = self.args["gamma1"] * (self.slope(x) ** 2 * dx).sum()
        tails = self.args["k"] * self.ell * (self.d - self.height(a)) ** 2
        return np.array([springs, surface, tails, -2 * self.args["w"] * a])


decades = st.floats(-5, 5).map(lambda e: 10.0**e)
ratios = st.floats(-2, 2).map(lambda e: 10.0**e)
