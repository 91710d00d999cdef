"""What contacts of a body take, over all half-widths: a load path reads it off.

It does not depend on the depth.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import Body
from discretization.layer.contact import Contacts, each
from discretization.surfaces.network import coefficients, polynomial, rounded

Array = NDArray[np.float64]
_DEGREE = 10
_HALVINGS = 10
_KNOWN = 0.1  # of the tolerance: last coefficients of a panel


class Panel(NamedTuple):
    """Between two half-widths: their logarithms, and what is taken at Lobatto points (11, 5)."""

    lo: float
    hi: float
    values: Array


class Table:
    """σ, s₀, dP/du, and P₀ and U₀ at u(a) = 0, without adhesion, as polynomials in log₂ a.

    Octaves, made where they are asked for, are halved until the polynomials tell it.
    """

    def __init__(self, body: Body, tolerance: float) -> None:
        self.body, self.tolerance = body, tolerance
        self.breaks = np.log2([*body.breaks, body.edge])
        self.panels: dict[tuple[float, float], list[Panel]] = {}

    def at(self, a: Array) -> Array:
        """These five (5, n) of half-widths (n,)."""
        t, found = np.log2(a), np.empty((5, a.size))
        octaves = np.arange(np.floor(t.min()), np.floor(t.max()) + 2)
        inner = (self.breaks > octaves[0]) & (self.breaks < octaves[-1])
        cuts = np.union1d(octaves, self.breaks[inner])
        part = np.maximum(np.searchsorted(cuts, t), 1)
        for i in np.unique(part).tolist():
            key = float(cuts[i - 1]), float(cuts[i])
            self.panels[key] = self.panels.get(key) or self._made(*key, _HALVINGS)
            for lo, hi, values in self.panels[key]:
                own = (t >= lo) & (t <= hi)
                found[:, own] = polynomial(_DEGREE, (2 * t[own] - lo - hi) / (hi - lo), values)
        return found

    def _made(self, lo: float, hi: float, left: int) -> list[Panel]:
        t = (lo + hi) / 2 + (hi - lo) / 2 * rounded(_DEGREE)[0]
        a = np.minimum(np.exp2(t), self.body.edge)
        values = np.concatenate([_five(own) for own in each(self.body, a, self.tolerance)])
        tail = np.abs(coefficients(_DEGREE, values.T)[:, -2:]).max(axis=1)
        slope = abs(float(self.body.slope(2.0**hi, -1)))
        excess = self.body.scene.opened.surfaces.small_slope_deficit
        rest, rate = np.abs(values[:, 1]).max() + slope + excess, values[:, 2].max()
        lift = rest / values[:, 0].min()  # by which u(a) may change
        size = np.array([values[:, 0].min(), rest, rate, rate * lift, rate * lift**2])
        if left and (tail > _KNOWN * self.tolerance * size).any():
            middle = (lo + hi) / 2
            return self._made(lo, middle, left - 1) + self._made(middle, hi, left - 1)
        return [Panel(lo, hi, values)]


def _five(own: Contacts) -> Array:
    stored = own.form[:, 1, 1] / 2 + own.stretched
    return np.column_stack([own.reaction, own.form[:, :, 0], stored])
