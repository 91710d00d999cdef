"""States of one contact found by plain.py: certificate, lines between the nodes, free surface."""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.equilibrium import Equilibrium
from discretization.lattice.assembly import (
    Question,
    certified,
    is_neutral,
    refuse_unknown,
    without_contact,
)
from discretization.lattice.between import Ends, lines_between
from discretization.lattice.judge import Move, Part, judge, totals
from discretization.lattice.plain import Plain, far, turning
from discretization.lattice.stencil import INWARDS
from discretization.nodes.lattice import Lattice, LatticeTail
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.row import Row

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]


def on_plain(asked: Question, row: Row) -> Equilibrium:
    """The certified state of one contact on the path, or of least energy. Errors as `of_contacts`.

    Without tension springs attach where they touch; for the lowest energy, where that pays.
    """
    lattice, depth = row.lattice, asked.depth
    reach = lattice.critical_gap
    if not lattice.gamma1 and asked.branch == "adhered":
        reach = min(reach, max(0.0, row.lowest - depth))
    plain = Plain(row, depth, reach)
    found = plain.contact()
    if found is None:
        return without_contact(asked, row)
    nodes = ((found[0] - row.first, found[1] - row.first),)
    refuse_unknown(row, depth, nodes)
    state = PlainState.of(plain, *found)
    sums = totals(state)
    if asked.branch == "global" and depth <= row.lowest and sums.energy > 0:
        return without_contact(asked, row)
    lines = lines_between(row, np.array(nodes), np.array([depth]), ends=state.ends, lone=True)
    for x, node in zip(lines.x[0].tolist(), found, strict=True):
        refuse_overhang(row, depth, x, node)
    certificate = judge(state, sums)
    if "penetration" in certificate.failures:
        raise ValueError(
            f"depth = {depth!r}: beyond the contact the surface is in the indenter; with slopes = "
            f"{lattice.slopes!r} nodes answer states of one contact only: use method='fitted'"
        )
    tail = SteepTail(lattice.tail.rate, lattice) if lattice.slopes == "finite" else lattice.tail
    neutral = is_neutral(row, state.ends[1])
    return certified(asked, row, nodes, lines, sums, certificate, tail, neutral=neutral)


def refuse_overhang(row: Row, depth: float, x: float, node: int) -> None:
    """ValueError for a line at which a surface of finite slope would all but turn over."""
    lattice = row.lattice
    limit, u = turning(lattice), depth - float(row.indenter.height(np.array([x]))[0])
    own = abs(depth - float(row.heights(node, node)[0])) - lattice.spacing
    if max(abs(u), own) > limit:
        raise ValueError(overhang(depth, f" x = {x!r}", u, limit))


def overhang(depth: float, where: str, u: float, limit: float) -> str:
    """What to say of a surface that would all but turn over."""
    return (
        f"depth = {depth!r}: at the contact line{where} the surface is displaced by {u!r}, more "
        f"than 1.3 l + Δx = {limit!r}, where it would all but turn over; use method='fitted', a "
        "smaller |depth|, a smaller w or a blunter indenter"
    )


@dataclass(frozen=True, eq=False)
class PlainState:
    """The relaxed surface of one contact: the energy, u and g of nodes (-inf: no profile there).

    ends: what passing the links beside its lines takes, by side.
    """

    plain: Plain
    model: NodalEnergy
    u: Array
    g: Array
    ends: dict[int, Ends]
    mirrored = False

    @classmethod
    def of(cls, plain: Plain, first: int, last: int) -> PlainState:
        """Nodes up to where the free surfaces are linear; all, of a profile that is not convex."""
        row, lattice, (lo, hi, _) = plain.row, plain.row.lattice, plain.row.where
        start, stop = first - far(lattice), last + far(lattice)
        if not row.indenter.convex:
            start, stop = min(start, lo), max(stop, hi)
        start = max(start, 0) if lattice.axis == 0 else start
        nodes = np.arange(start, stop + 1)
        g = np.full(nodes.size, -math.inf)
        known = slice(max(lo, start) - start, min(hi, stop) - start + 1)
        g[known] = plain.depth - row.heights(max(lo, start), min(hi, stop))
        model = NodalEnergy(lattice, (nodes >= first) & (nodes <= last), start)
        ends = {side: plain.ends(node, side) for side, node in ((-1, first), (1, last))}
        return cls(plain, model, model.relaxed(g), g, ends)

    @property
    def row(self) -> Row:
        """The row of nodes."""
        return self.plain.row

    @property
    def depth(self) -> float:
        """The depth."""
        return self.plain.depth

    @property
    def at_lines(self) -> tuple[float, float]:
        """u of the first and the last contact node."""
        held = np.flatnonzero(self.model.contact)
        return float(self.u[held[0]]), float(self.u[held[-1]])

    def parts(self) -> Iterator[Part]:
        """All nodes at once."""
        yield Part(self.model, self.u, self.g)

    def opening(self, part: Part, i: Nodes, force: Array) -> Array:
        """The pull per weight on contact nodes whose opening alone lowers the energy.

        Every second node is let go at once: between two that are held it moves alone. The outermost
        ones are not opened here, as these are moves of a line; a lone node has no adhesion.
        """
        model, held = self.model, np.flatnonzero(self.model.contact)
        pull = -force / model.lattice.weight(model.nodes[i])
        if held.size == 1 and model.lattice.gamma1:
            return np.asarray(pull)
        opens = np.zeros(self.u.size, bool)
        for every in held[1:-1:2], held[2:-1:2]:
            contact = model.contact.copy()
            contact[every] = False
            less = NodalEnergy(model.lattice, contact, int(model.nodes[0]))
            gain = model.around(self.u) - less.around(less.relaxed(self.u))
            opens[every] = gain[every] > 0
        return np.asarray(pull[opens[i]])

    def moves(self, noise: float) -> Iterator[Move]:
        """Of the lines, one link outwards or inwards; energies over those of a unit gap."""
        lattice, reach = self.model.lattice, self.plain.reach
        critical, unit = lattice.critical_gap, math.sqrt(lattice.link_over_decay)
        for end in self.ends.values():
            for i, opening in ((INWARDS, False), (INWARDS - 1, True)):
                if end.known[0, i] and (opening or reach == critical):
                    gap = float(end.closing[0, i]) / unit + reach
                    yield Move(opening, gap, gap**2, critical**2)


@dataclass(frozen=True)
class SteepTail(LatticeTail):
    """Free surfaces beyond a contact line with finite slopes, from nodes that begin at the line."""

    lattice: Lattice

    @functools.lru_cache(maxsize=64)  # noqa: B019
    def _nodes(self, u_line: float) -> Array:
        """u outwards."""
        model = NodalEnergy(self.lattice, np.arange(far(self.lattice) + 1) == 0)
        return model.relaxed(np.full(model.contact.size, u_line))

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """u at these distances from the line, linear between nodes."""
        u = self._nodes(float(u_line))
        at = self.lattice.spacing * np.arange(u.size)
        beyond = np.exp(-self.rate * np.maximum(distance - at[-1], 0.0))
        return np.asarray(np.interp(distance, at, u) * beyond)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """u' outwards at lines, of a surface that bends by k u (1 + u'²)^{3/2}/γ₁ beside them."""
        lat, found = self.lattice, np.zeros_like(u_line)
        for i, own in np.ndenumerate(u_line):
            u = self._nodes(float(own))[:4]
            steep = np.gradient(u, lat.spacing, edge_order=2)[:2]
            bend = lat.k / lat.gamma1 * u[:2] * (1 + steep**2) ** 1.5
            found[i] = (u[1] - u[0]) / lat.spacing - lat.spacing / 6 * (2 * bend[0] + bend[1])
        return found
