"""States of one contact found by plain.py: certificate, lines between the nodes, free surface."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.interpolate import CubicHermiteSpline

from discretization.equilibrium import Equilibrium
from discretization.lattice import line
from discretization.lattice.assembly import (
    Question,
    certified,
    is_neutral,
    without_contact,
)
from discretization.lattice.judge import Moves, State, judge, totals
from discretization.lattice.plain import Plain, far, turning
from discretization.nodes.lattice import Lattice, LatticeTail
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.row import Row

Array = NDArray[np.float64]


def on_plain(asked: Question, row: Row) -> Equilibrium:
    """The certified state of one contact on the path, or of least energy. Errors as `of_contacts`.

    Without tension springs attach where they touch; for the lowest energy, where that pays.
    """
    lattice, depth, work = row.lattice, asked.depth, row.lattice.w
    if not lattice.gamma1 and asked.branch == "adhered":
        work = min(work, lattice.k / 2 * max(0.0, row.lowest - depth) ** 2)
    plain = Plain(row, depth, work)
    found = plain.contact()
    if found is None:
        return without_contact(asked, row)
    nodes = ((found[0] - row.first, found[1] - row.first),)
    row.refuse_unknown(depth, nodes)
    passed = plain.advances(found)
    state = relaxed(plain, passed, *found)
    sums, at = totals(state), np.array(nodes)
    if asked.branch == "global" and depth <= row.lowest and sums.energy > 0:
        return without_contact(asked, row)
    beside = line.corners(row, at)
    zeta = line.resting(row, at, [passed.excess(work)], beside)
    lines = line.positions(row, at, zeta)[0]
    for x, node in zip(lines.tolist(), found, strict=True):
        refuse_overhang(row, depth, x, node)
    certificate = judge(state, sums)
    if "penetration" in certificate.failures:
        raise ValueError(
            f"depth = {depth!r}: beyond the contact the surface is in the indenter; with slopes = "
            f"{lattice.slopes!r} nodes answer states of one contact only: use method='fitted'"
        )
    tail = SteepTail(lattice.tail.rate, lattice) if lattice.slopes == "finite" else lattice.tail
    neutral = is_neutral(row, passed)
    energy, force = line.gained(passed, zeta, beside, lattice.w)[:, 0].tolist()
    sums = sums._replace(energy=sums.energy + energy, force=sums.force + force)
    return certified(asked, row, nodes, lines, sums, certificate, tail, neutral=neutral)


def refuse_overhang(row: Row, depth: float, x: float, node: int) -> None:
    """ValueError for a line at which a surface of finite slope would all but turn over."""
    lattice = row.lattice
    limit, u = turning(lattice), depth - float(row.indenter.height(np.array([x]))[0])
    own = abs(depth - float(row.f[node - row.first])) - lattice.spacing
    if max(abs(u), own) > limit:
        raise ValueError(overhang(depth, f" x = {x!r}", u, limit))


def overhang(depth: float, where: str, u: float, limit: float) -> str:
    """What to say of a surface that would all but turn over."""
    return (
        f"depth = {depth!r}: at the contact line{where} the surface is displaced by {u!r}, more "
        f"than 1.3 l + Δx = {limit!r}, where it would all but turn over; use method='fitted', a "
        "smaller |depth|, a smaller w or a blunter indenter"
    )


def relaxed(plain: Plain, passed: line.Advances, first: int, last: int) -> State:
    """The relaxed surface of one contact between these nodes of the lattice.

    passed: what its lines' moves change. The nodes are those up to where the free surfaces are
    linear; all, of a profile that is not convex.
    """
    row, lattice, (lo, hi, _) = plain.row, plain.row.lattice, plain.row.where
    start, stop = first - far(lattice), last + far(lattice)
    if not row.indenter.convex:
        start, stop = min(start, lo), max(stop, hi)
    if lattice.axis == 0:
        start = max(0, start)
    nodes = np.arange(start, stop + 1)
    g, known = np.full(nodes.size, -math.inf), np.arange(max(lo, start), min(hi, stop) + 1)
    g[known - start] = plain.depth - row.f[known - lo]
    model = NodalEnergy(lattice, (nodes >= first) & (nodes <= last), start)
    closes = np.full(2, plain.work == lattice.w)  # else springs attach where they touch
    moves = Moves.of(passed, row.works, closes)
    return State(row, plain.depth, model, model.relaxed(g), g, moves)


@dataclass(frozen=True)
class SteepTail(LatticeTail):
    """Free surfaces beyond a contact line with finite slopes, from nodes that begin at the line.

    Between the nodes u is a cubic, with u'' = k u (1 + u'²)^{3/2}/γ₁ linear from node to node.
    """

    lattice: Lattice

    @functools.lru_cache(maxsize=64)  # noqa: B019
    def _cubic(self, u_line: float) -> CubicHermiteSpline:
        """u outwards of a line."""
        lat = self.lattice
        model = NodalEnergy(lat, np.arange(far(lat) + 1) == 0)
        u = model.relaxed(np.full(model.contact.size, u_line))
        u = np.append(u, math.exp(-lat.log_decay) * u[-1])
        bend = lat.k / lat.gamma1 * u * (1 + np.gradient(u, lat.spacing, edge_order=2) ** 2) ** 1.5
        slope = np.diff(u) / lat.spacing - lat.spacing / 6 * (2 * bend[:-1] + bend[1:])
        return CubicHermiteSpline(lat.spacing * np.arange(slope.size), u[:-1], slope)

    def shape(self, z: Array, left: Any, right: Any, depth: float) -> tuple[Array, Array]:
        """u and u' beside one contact line."""
        line, side = (left, 1) if right is None else (right, -1)
        cubic, distance = self._cubic(float(depth - line.f)), side * (z - line.x)
        near = np.minimum(distance, cubic.x[-1])
        decay = np.exp(self.rate * (near - distance))
        slope = np.where(near < distance, -self.rate * cubic(near), cubic(near, 1))
        return cubic(near) * decay, side * slope * decay
