"""Free surfaces of line contacts with finite slopes, on a mesh anchored at their lines.

D = f + u of the tail or of the gap that is inclined by φ = β - 2 asin √(w/(2γ₁)) at its line,
tan β = f'. A gap stores

    F(u_a, u_b; L) = min over u, u(0) = u_a, u(L) = u_b, of ∫₀^L (k/2 u² + γ₁ (√(1+u'²) - 1)) dx.

In units of l and γ₁, k = γ₁ = l = 1, the elements are laid out in the coordinate τ in which the
surface is a sum of two exponentials (finite_range.py), of a tail of one: p = 2 sin(φ/2) = -u. That
grades them towards steep lines, and u and x are smooth functions of τ however steep the surface
is. The discrete energy is that of the nodal u at the nodes' fixed x, by the Gauss-Lobatto rule in
τ, convex in u:

    F = Σ_i w_i [h_i u_i²/2 + √(h_i² + (du/dτ)_i²) - h_i],    h = dx/dτ.

The exponentials minimise F to rounding, which `residual` measures. As ∂F/∂h_i of the minimum is
u²/2 + cos φ - 1, the same at every node, that is also ∂F/∂L.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.surfaces.finite_range import (
    DEGREE,
    FAR,
    OVERHANG,
    STEEPEST,
    UPRIGHT,
    Mesh,
    mesh_of,
    range_of,
    rate,
    rest_displacement,
)
from discretization.surfaces.network import on_elements, rounded
from discretization.surfaces.protocol import At, Free, Surfaces, alone
from energy.arrays import Array

_INSIDE = 1e-8  # of τ: a step to a place after which the error is rounding
_INVERSE = 8  # steps of Newton's method to it


def sine(p: Any) -> Any:
    """sin φ of p = 2 sin(φ/2)."""
    return p * np.sqrt(np.maximum(1 - p * p / 4, 0.0))


def _ends(left: Array, rise: Array, T: Array) -> tuple[Array, Array]:
    """p at both lines of surfaces displaced by `left` and `left + rise` there."""
    steep, tanh = rise / np.sinh(T), np.tanh(T / 2)
    return steep - left * tanh, steep + (left + rise) * tanh


def _exponentials(left: Array, rise: Array, T: Array, tau: Array) -> tuple[Array, Array]:
    """p and u - left of such surfaces at τ."""
    start, end = _ends(left, rise, T)
    grown, shrunk = np.sinh(tau) / np.sinh(T), np.sinh(T - tau) / np.sinh(T)
    back = np.sinh(tau / 2) * np.sinh((T - tau) / 2) / np.cosh(T / 2)
    return start * shrunk + end * grown, rise * grown - 2 * left * back


@dataclass(frozen=True, eq=False)
class Gaps:
    """Free surfaces between two lines each.

    T (n, 1): the range of τ; p, u, rises (n, nodes): p = du/dτ, u, and how much more that is
    than at the left line, of which a short gap would not leave digits.
    """

    T: Array
    p: Array
    u: Array
    rises: Array

    @property
    def mesh(self) -> Mesh:
        """The elements."""
        return mesh_of(self.T)

    @functools.cached_property
    def half(self) -> Array:
        """Half the elements of the first one."""
        return np.asarray(self.T[0, 0] * np.diff(self.mesh.ends)[:, None] / 2)

    @functools.cached_property
    def h(self) -> Array:
        """dx/dτ at the nodes."""
        return np.asarray(rate(self.p))

    @property
    def upright(self) -> bool:
        """Whether a surface turns over."""
        return bool((np.abs(self.p[:, [0, -1]]) >= STEEPEST * (1 - UPRIGHT / 16)).any())

    @property
    def pulls(self) -> Array:
        """S = ∂F/∂u at both lines (2, n)."""
        return np.array([-sine(self.p[:, 0]), sine(self.p[:, -1])])

    @property
    def energy(self) -> Array:
        """F (n,)."""
        h, square = self.h, self.p * self.p
        density = h * (self.u * self.u / 2) + square / (np.sqrt(h * h + square) + h)
        return np.asarray(self.T[:, 0] * (density @ self.mesh.weights))

    @property
    def area(self) -> Array:
        """∫u dx (n,)."""
        return np.asarray(self.T[:, 0] * ((self.h * self.u) @ self.mesh.weights))

    @property
    def residual(self) -> float:
        """How far the nodal energy of the first surface is from its least, over u and S.

        The imbalance of a node, of a reaction, of the constancy of u²/2 + cos φ.
        """
        (_, weights, d), mesh, half, rises = rounded(DEGREE), self.mesh, self.half, self.rises[0]
        h, u, inclined = self.h[0][mesh.own], self.u[0], rises[mesh.own] @ d.T
        steep = inclined / np.sqrt(half * half * h * h + inclined * inclined)
        pull = half * weights * h * u[mesh.own] + (weights * steep) @ d
        s, t = self.pulls[:, 0].tolist()
        off = np.append(pull[:, :-1].ravel(), pull[-1, -1] - t)
        off[::DEGREE][:-1] += np.append(-s, pull[:-1, -1])
        cosines = math.sqrt(max(1 - s * s, 0.0)) + math.sqrt(max(1 - t * t, 0.0))
        uneven = -rises[-1] * (u[0] + u[-1]) / 2 + (t - s) * (t + s) / cosines
        size = float(abs(u[0]) + abs(u[-1])) + abs(s) + abs(t) or 1.0
        return max(float(np.abs(off).max()), abs(float(uneven)) / size) / size

    @functools.cached_property
    def places(self) -> Array:
        """x of the nodes of the first one: on an element d x = h."""
        d, h = rounded(DEGREE)[2], self.h[0][self.mesh.own]
        parts = np.linalg.solve(d[1:, 1:], (self.half * h)[:, 1:].T).T
        starts = np.append(0.0, np.cumsum(parts[:-1, -1]))
        return np.append(0.0, parts + starts[:, None])

    def at(self, p: Array, q: Array) -> tuple[Array, Array]:
        """u and u' of the first one at distances p from the left and q from the right line (n,).

        Where they are further apart than here, the nearer one counts.
        """
        (T,), left, mesh, places = self.T, self.u[0, :1], self.mesh, self.places
        shape = left, self.rises[0, -1:], T
        half = places[-1] / 2
        x = np.where(p <= q, np.minimum(p, half), 2 * half - np.minimum(q, half))
        tau = np.interp(x, places, T * mesh.nodes)
        for _ in range(_INVERSE):
            off = on_elements(T * mesh.ends, places, tau)[0] - x
            step = off / rate(_exponentials(*shape, tau)[0])
            tau = np.clip(tau - step, 0.0, T)
            if (np.abs(step) <= _INSIDE).all():
                break
        steep, rises = _exponentials(*shape, tau)
        return left + rises, steep / rate(steep)


def surfaces(u: Array, rise: Array, width: Array) -> Gaps:
    """The surfaces displaced by u and u + rise at lines these distances apart, (n, 1).

    One to no other line is one to a line where it is flat, and at most upright.
    """
    if np.isinf(width).all():
        T, u = np.full_like(u, FAR), np.clip(u, -STEEPEST, STEEPEST)
        left = u * np.exp(-FAR * mesh_of(T).nodes)
        return Gaps(T, -left, left, left - u)
    u, rise, width = np.broadcast_arrays(u, rise, np.minimum(width, FAR))
    steepest = 1 + np.abs(u[:, 0]) + 2 * np.abs(rise[:, 0])
    T = range_of(width, lambda T, own: _ends(u[own], rise[own], T), steepest)
    p, rises = _exponentials(u, rise, T, T * mesh_of(T).nodes)
    return Gaps(T, p, u + rises, rises)


@functools.lru_cache(maxsize=1024)
def single(u: float, rise: float, width: float) -> Gaps:
    """A single surface."""
    return surfaces(*(np.full((1, 1), part) for part in (u, rise, width)))


class FiniteSurfaces(Surfaces):
    """Free surfaces of a scene."""

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, steep: Any, w: Any) -> Any:
        """The inclination at rest is known, and the displacement that has it is solved for.

        Where a gap would turn over its inclination is cut at ±π/2; a tail is refused if its line is
        at rest there.
        """
        phi = np.arctan(steep) - 2 * np.arcsin(np.sqrt(w / 2))
        if np.isinf(width).all():
            return 2 * np.sin(phi / 2)
        return rest_displacement(-2 * np.sin(np.maximum(phi, -math.pi / 2) / 2), rise, width)

    def held(self, side: int, s: Any, width: Any, u: Any, rise: Any) -> tuple[Any, Any] | None:
        """From the mesh."""
        found = surfaces(*(np.reshape(part, (-1, 1)) for part in (u, rise, width)))
        upright = found.upright and np.isinf(width).all()
        return None if upright else (found.energy, found.pulls.sum(axis=0))

    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free | None:
        """From the mesh."""
        found = single(u, rise, width)
        if found.upright:
            return None
        one, other = found.pulls[:, 0].tolist()
        return Free(found.energy.item(), (one, other), found.area.item(), found.residual)

    def form(
        self, x: Array, side: int, s: float, width: float, u: float, rise: float
    ) -> tuple[Array, Array]:
        """As the exponentials have it."""
        far = FAR if math.isinf(width) else width
        return single(u, rise, width).at(x, np.maximum(far - x, 0.0))

    def refusal(self, left: At | None, right: At | None, depth: Any) -> str:
        """For which depth and line."""
        line, limit = alone(left, right), OVERHANG * self.scene.elastocapillary_length
        place = f"at the contact line x = {line.x!r}"
        if left is not None and right is not None:
            place = f"between the contact lines x = {left.x!r} and {right.x!r}"
        return (
            f"depth = {depth!r}: {place} the surface, displaced by {depth - line.f!r}, would turn "
            f"over and be no graph u(x), as it does at √2 l = {limit!r} beside a single contact; "
            "use a smaller |depth|, a smaller w or a blunter indenter"
        )
