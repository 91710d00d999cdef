"""What a contact of a layer takes at any half-width, as polynomials between computed ones.

What a contact of half-width a takes does not depend on the depth. So it is computed once at the
nodes of panels in log₂ a, octaves halved until the polynomials tell it, and read from there: σ, s₀,
the force at u(a) = 0 and its change with u(a), and the energy at u(a) = 0.
"""

from __future__ import annotations

import bisect
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.body import Body
from discretization.layer.contact import Contacts, contacts
from discretization.surfaces.spectral import coefficients, polynomial, rounded

Array = NDArray[np.float64]
_DEGREE = 10
_HALVINGS = 3
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
        self.ends = np.log2(np.unique([*body.breaks, min(body.edge, 2.0**60)]))
        self.panels: dict[tuple[float, float], list[Panel]] = {}
        self.singles: dict[float, Array] = {}

    def rest_depth(self, a: Array, excess: float, side: Any) -> Array:
        """D of half-widths (n,); see `Body.rest_depth`. A corner is asked for on both sides."""
        reaction = self.singles.get(float(a[0])) if a.size == 1 else None
        reaction = self.at(a, 2) if reaction is None else reaction
        return self.body.rest_depth(a, reaction, excess, side)

    def taken(self, a: Array, depth: Array) -> tuple[Array, Array]:
        """P, and U without adhesion, of half-widths at depths (n,)."""
        u, (_, _, rate, force, stored) = depth - self.body.height(a), self.at(a)
        return rate * u + force, stored + force * u + rate * u * u / 2

    def at(self, a: Array, size: int = 5) -> Array:
        """σ, s₀, dP/du, P₀ and U₀ at half-widths (n,), the first of these (size, n).

        Of a panel that is asked for a single time nothing but this half-width is computed.
        """
        t = np.log2(a)
        found, keys = np.empty((size, a.size)), [self._key(x) for x in t.tolist()]
        single = np.array([key not in self.panels and keys.count(key) == 1 for key in keys])
        if single.any():
            found[:, single] = self._rows(a[single], size).T
            self.singles.update((x, found[:2, a == x]) for x in a[single].tolist())
        for key in dict.fromkeys(keys):
            own = np.array([other == key for other in keys])
            if (single & own).any():
                self.panels[key] = []
                continue
            self.panels[key] = self.panels.get(key) or self._made(*key, _HALVINGS)
            found[:, own] = self._read(key, t[own])[:size]
        return found

    def _read(self, key: tuple[float, float], t: Array) -> Array:
        found = np.empty((5, t.size))
        for panel in self.panels[key]:
            own = (t <= panel.hi) & (t >= panel.lo)
            at = (2 * t[own] - panel.lo - panel.hi) / (panel.hi - panel.lo)
            found[:, own] = polynomial(_DEGREE, at, panel.values)
        return found

    def _key(self, t: float) -> tuple[float, float]:
        """The ends of the panel around log₂ a, one that has been made if there is any."""
        for key, panels in self.panels.items():
            if panels and key[0] <= t <= key[1]:
                return key
        octave = math.floor(t)
        inner = self.ends[(self.ends > octave) & (self.ends < octave + 1)].tolist()
        ends = [float(octave), *inner, octave + 1.0]
        i = bisect.bisect_left(ends[1:-1], t)
        return ends[i], ends[i + 1]

    def _made(self, lo: float, hi: float, left: int) -> list[Panel]:
        z, _, _ = rounded(_DEGREE)
        t = (lo + hi) / 2 + (hi - lo) / 2 * z
        values = self._rows(np.minimum(np.exp2(t), self.body.edge))
        tail = np.abs(coefficients(_DEGREE, values.T)[:, -2:]).max(axis=1)
        slope = abs(float(self.body.slope(2.0**hi, -1)))
        rest = np.abs(values[:, 1]).max() + slope + self.body.excess(self.body.scene.opened)
        lift = rest / values[:, 0].min()  # by which u(a) may change
        size = np.array([values[:, 0].min(), rest, values[:, 2].max(), 0.0, 0.0])
        size[3:] = values[:, 2].max() * lift, values[:, 2].max() * lift**2
        if left and (tail > _KNOWN * self.tolerance * size).any():
            middle = (lo + hi) / 2
            return self._made(lo, middle, left - 1) + self._made(middle, hi, left - 1)
        return [Panel(lo, hi, values)]

    def _rows(self, a: Array, size: int = 5) -> Array:
        """What is taken (n, size); breaks lie elsewhere in every contact that has any inside."""
        alike = not any(0 < x < a.max() for x in self.body.breaks)
        groups = [a] if alike else np.split(a, a.size)
        return np.concatenate(
            [self._taken(contacts(self.body, own, self.tolerance), size) for own in groups]
        )

    def _taken(self, own: Contacts, size: int) -> Array:
        if size == 2:
            return own.reaction
        whole, form = self.body.geometry.whole, own.form
        stored = form[:, 1, 1] / 2 + own.stretched
        return np.column_stack([own.reaction, whole * form[:, :, 0], whole * stored])
