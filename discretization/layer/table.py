"""What a contact of a layer takes at any half-width, as polynomials between computed ones.

Along a path the half-width a changes, but not what a contact of this half-width takes. So that is
computed once at the nodes of panels in ln a, panels halved until the polynomials tell it, and read
from there: σ, s₀, the force at u(a) = 0 and its change with u(a), and the energy at u(a) = 0.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import Body
from discretization.layer.totals import Layer
from discretization.surfaces.spectral import coefficients, polynomial, rounded

Array = NDArray[np.float64]
_DEGREE = 10
_WIDE = math.log(2.0)  # of the first panels, in ln a
_HALVINGS = 3
_KNOWN = 0.1  # of the tolerance: last coefficients of a panel


class Panel(NamedTuple):
    """Between two half-widths: a (11,) and what is taken there (11, 5)."""

    lo: float
    hi: float
    values: Array


class Table:
    """Panels of a body, made where they are asked for."""

    def __init__(self, body: Body, tolerance: float) -> None:
        self.body, self.tolerance = body, tolerance
        breaks = [x for x in body.profile.breaks if x > 0]
        self.ends = np.log(np.unique([*breaks, min(body.edge, math.exp(40.0))]))
        self.panels: dict[tuple[float, float], list[Panel]] = {}

    def at(self, a: Array) -> Array:
        """σ, s₀, dP/du, P₀ and U₀ (5, n) at half-widths (n,)."""
        t, found = np.log(a), np.empty((5, a.size))
        own = [self._panel(float(x)) for x in t]
        for panel in {id(p): p for p in own}.values():
            here = np.array([p is panel for p in own])
            at = (2 * t[here] - panel.lo - panel.hi) / (panel.hi - panel.lo)
            found[:, here] = polynomial(_DEGREE, at, panel.values)
        return found

    def _panel(self, t: float) -> Panel:
        base = _WIDE * math.floor(t / _WIDE)
        cuts = self.ends[(self.ends > base) & (self.ends < base + _WIDE)]
        cuts = np.concatenate([[base], cuts, [base + _WIDE]])
        i = min(int(np.searchsorted(cuts, t, side="right")) - 1, cuts.size - 2)
        if t == self.ends[-1] and i and cuts[i] == t:
            i -= 1
        key = float(cuts[i]), float(cuts[i + 1])
        if key not in self.panels:
            self.panels[key] = list(self._made(*key, _HALVINGS))
        return next(p for p in self.panels[key] if t <= p.hi)

    def _made(self, lo: float, hi: float, left: int) -> list[Panel]:
        z, _, _ = rounded(_DEGREE)
        t = (lo + hi) / 2 + (hi - lo) / 2 * z
        values = np.array([self._row(min(math.exp(x), self.body.edge)) for x in t])
        tail = np.abs(coefficients(_DEGREE, values.T)[:, -2:]).max(axis=1)
        slope = abs(float(self.body.profile.slope(math.exp(hi), -1)))
        rest = np.abs(values[:, 1]).max() + slope + self.body.excess(self.body.scene.opened)
        lift = rest / values[:, 0].min()  # by which u(a) may change
        size = np.array([values[:, 0].min(), rest, values[:, 2].max(), 0.0, 0.0])
        size[3:] = values[:, 2].max() * lift, values[:, 2].max() * lift**2
        if left and (tail > _KNOWN * self.tolerance * size).any():
            middle = (lo + hi) / 2
            return self._made(lo, middle, left - 1) + self._made(middle, hi, left - 1)
        return [Panel(lo, hi, values)]

    def _row(self, a: float) -> tuple[float, ...]:
        found = self.body.condensed(a, self.tolerance)
        state = Layer(self.body, found, found.f, self.tolerance)
        stored = self.body.geometry.whole * (state.stored(found.f) + state.stretched)
        return found.sigma, found.rest, found.stiffness, found.force, stored
