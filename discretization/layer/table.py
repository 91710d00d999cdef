"""What a contact of a layer takes at any half-width, as polynomials between computed ones.

What a contact of half-width a takes does not depend on the depth. So it is computed once at the
nodes of panels in log₂ a, octaves halved until the polynomials tell it, and read from there: σ, s₀,
the force at u(a) = 0 and its change with u(a), and the energy at u(a) = 0.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import Body
from discretization.layer.contact import Contacts, contacts
from discretization.surfaces.network import coefficients, polynomial, rounded

Array = NDArray[np.float64]
_DEGREE = 10
_HALVINGS = 10
_KNOWN = 0.1  # of the tolerance: last coefficients of a panel


class Panel(NamedTuple):
    """Between two half-widths: their logarithms, and what is taken there (11, 5)."""

    lo: float
    hi: float
    values: Array


class Table:
    """Panels of a body, made where they are asked for."""

    def __init__(self, body: Body, tolerance: float) -> None:
        self.body, self.tolerance = body, tolerance
        self.breaks = np.log2([*body.breaks, body.edge])
        self.panels: dict[tuple[float, float], list[Panel]] = {}

    def reaction(self, a: Array) -> Array:
        """σ and s₀ (2, n) of half-widths themselves (n,)."""
        return np.concatenate([own.reaction for own in self._contacts(a)]).T

    def taken(self, a: Array, depth: Array) -> tuple[Array, Array]:
        """P, and U without adhesion, of half-widths at depths (n,)."""
        u, (_, _, rate, force, stored) = depth - self.body.height(a), self.at(a)
        return rate * u + force, stored + force * u + rate * u * u / 2

    def at(self, a: Array) -> Array:
        """σ, s₀, dP/du, P₀ and U₀ (5, n) at half-widths (n,), by the polynomials."""
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
        groups = self._contacts(np.minimum(np.exp2(t), self.body.edge))
        values = np.concatenate([_five(own) for own in groups])
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

    def _contacts(self, a: Array) -> list[Contacts]:
        """Breaks lie elsewhere in every contact that has any inside."""
        alike = not any(0 < x < a.max() for x in self.body.breaks)
        groups = [a] if alike else np.split(a, a.size)
        return [contacts(self.body, own, self.tolerance) for own in groups]


def _five(own: Contacts) -> Array:
    stored = own.form[:, 1, 1] / 2 + own.stretched
    return np.column_stack([own.reaction, own.form[:, :, 0], stored])
