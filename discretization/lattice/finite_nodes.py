"""The lattice with finite slopes: true lengths of its links, and a tail that is not a power."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np
from numpy.typing import NDArray

from discretization.lattice.bracket import falling_root
from discretization.lattice.finite_spans import ENDLESS, FiniteSpan, finite_span
from discretization.lattice.nodes import Lattice
from discretization.lattice.tails import (
    TURNING,
    FiniteTail,
    LatticeTail,
    TailResponse,
    tail_response,
)
from discretization.rounding import EPSILON
from energy import Scene

Array = NDArray[Any]
_ROUNDING = 64 * EPSILON  # of energies of surfaces


@dataclass(frozen=True)
class FiniteLattice(Lattice):
    """The lattice with finite slopes.

    Its `gap` is scaled so that with the same `advance_cost` as for small slopes

        ΔE = kΔx g'²/2 + contact link + F(g') - F(g) = √(1+s²) advance_cost(gap),  s = (f'-f)/Δx,

    and has the sign of g_{m+1} below the resting tail: the line advances by the same rule.
    """

    slopes: ClassVar[str] = "finite"
    length: float = field(init=False)
    response: TailResponse = field(init=False, repr=False)

    @classmethod
    def describes(cls, scene: Scene) -> bool:
        return not scene.axisymmetric and scene.slopes == "finite" and scene.gamma1 > 0

    def __post_init__(self) -> None:
        super().__post_init__()
        length = math.sqrt(self.gamma1 / self.k)
        object.__setattr__(self, "length", length)
        object.__setattr__(self, "response", tail_response(self.spacing / length))

    @property
    def contact_tension(self) -> float:
        """γ₁ - w."""
        return self.gamma1 - self.w

    def refuse_overhang(self, depth: float, lift: float, at: str = "", slack: float = 0.0) -> None:
        """Beyond 1.3 l, near √2 l where it turns over, and Δx, to which it is resolved."""
        limit = TURNING * self.length + self.spacing
        if abs(lift) > limit + slack:
            raise ValueError(
                f"depth = {depth!r}: at the contact line{at} the surface is displaced by {lift!r}, "
                f"more than 1.3 l + Δx = {limit!r}, where it would all but turn over; use "
                "method='fitted', a smaller |depth|, a smaller w or a blunter indenter"
            )

    @property
    def tail(self) -> LatticeTail:
        return FiniteTail(self.log_decay / self.spacing, self.length, self.response)

    def tail_energy(self, u):
        return self.gamma1 * self.length * self.response.energy(u / self.length)

    def tail_reaction(self, u):
        return self.gamma1 * self.response.reaction(u / self.length)

    def tail_force(self, u):
        after = self.response.after(u / self.length)
        return self.spring * self.length * after + self.gamma1 * self.response.reaction(after)

    def tail_stiffness(self, u):
        return self.gamma1 / self.length * self.response.stiffness(u / self.length)

    def between(self, left: float, right: float, links: int) -> FiniteSpan:
        """The free surface between two contact nodes displaced by these, in units of l and γ₁.

        Two tails where the nodes are far apart.
        """
        one, other, response = float(left) / self.length, float(right) / self.length, self.response
        if self.log_decay * links < ENDLESS:
            return finite_span(response.h, one, other, int(links))
        u = self.tail_nodes(left, links) + self.tail_nodes(right, links)[::-1]
        ends = np.array([one, other])
        pulls = response.reaction(ends).tolist()
        return FiniteSpan(u / self.length, float(response.energy(ends).sum()), (pulls[0], pulls[1]))

    def tail_nodes(self, u: float, links: int) -> Array:
        """Displacements (links + 1,) of a tail from the node where it is held by u."""
        known = math.ceil(ENDLESS / self.log_decay)
        whole = finite_span(self.response.h, float(u) / self.length, 0.0, known).u[: links + 1]
        return self.length * np.pad(whole, (0, links + 1 - whole.size))

    def _spans(
        self, left: Any, right: Any, f: Any, g: Any, depth: Any
    ) -> tuple[list[FiniteSpan], tuple[int, ...]]:
        """Surfaces between two contact nodes each, and the shape of the array they would be."""
        parts = np.broadcast_arrays(depth - f, depth - g, right - left)
        rows = zip(*(part.flat for part in parts), strict=True)
        return [self.between(*row) for row in rows], parts[0].shape

    def gap_force(self, left, right, f, g, depth):
        found, shape = self._spans(left, right, f, g, depth)
        return self.gamma1 * np.reshape([sum(each.pulls) for each in found], shape)

    def gap_energy(self, left, right, f, g, depth):
        found, shape = self._spans(left, right, f, g, depth)
        return self.gamma1 * self.length * np.reshape([each.energy for each in found], shape)

    def free(self, left: Any, right: Any, u_left: Any, u_right: Any, nodes: Any) -> Array:
        u, rows = np.empty(nodes.size), np.broadcast_arrays(left, right, u_left, u_right, nodes)[:4]
        for start in np.unique(rows[0]):
            own = rows[0] == start
            a, b, one, other = (row[own][0] for row in rows)
            u[own] = self.length * self.between(one, other, int(b - a)).u[nodes[own] - int(a)]
        return u

    def lifted(self, node: Array, side: int, other: Array, u: tuple[Array, ...]) -> tuple[Any, ...]:
        """The same from the energies of the surfaces before and after."""
        (own, beyond, facing), links = u, np.abs(other - node)
        rows = zip(own.tolist(), facing.tolist(), links.tolist(), strict=True)
        free = self.length * np.array([self.between(*row).u[1] for row in rows])
        before = self.gap_energy(0, links, -own, -facing, 0.0)
        after = self.gap_energy(1, links, -beyond, -facing, 0.0)
        after = after + self.link_energies(beyond - own) + self.spring / 2 * beyond**2
        return free - beyond, np.maximum(after - before, 0.0), _ROUNDING * (after + before)

    def tension(self, steps):
        slope = steps / self.spacing
        return self.gamma1 * slope / np.sqrt(1 + slope * slope)

    def link_energies(self, steps: Array) -> Array:
        squares = (steps / self.spacing) ** 2
        return self.gamma1 * self.spacing * squares / (1 + np.sqrt(1 + squares))

    def adhesion(self, links: float, surface: float) -> float:
        return super().adhesion(links, surface) - self.w / self.gamma1 * surface

    def least_stiffness(self, steps: Array) -> float:
        steepest = float(np.max(np.abs(steps), initial=0.0)) / self.spacing
        return self.link / (1 + steepest**2) ** 1.5

    def arc(self, rise):
        return np.hypot(1, rise / self.spacing)

    def gap(self, f, f_next, depth):
        u, rise = (depth - f) / self.length, (f_next - f) / self.spacing
        whole = self.link_over_decay / self.link * np.hypot(1, rise)
        return self.spacing * self.response.parting(u, rise) / np.sqrt(whole)

    def rest_depth(self, f, f_next, work):
        """The same by root finding, as the gap falls with d; where the tail is described."""
        reach = np.sqrt(2 * work / self.link_over_decay)
        guess = super().rest_depth(f, f_next, work)
        width = 1e-3 * (self.length + np.abs(guess - f))
        return falling_root(lambda d: self.gap(f, f_next, d) - reach, guess, width)

    def advance(self, f, f_next, depth):
        gap, g, g_next = self.gap(f, f_next, depth), depth - f, depth - f_next
        energy = self.arc(f_next - f) * self.advance_cost(gap)
        pull = self.tail_reaction(g_next) - self.tail_reaction(g)
        return gap, energy, self.spring * g_next + pull
