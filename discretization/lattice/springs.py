"""γ₁ = 0 with any number of contacts: every node is a spring of its own.

    branch "global"    attached iff g >= 0 or k g²/2 <= w, that is g >= -δ₀
    branch "adhered"   touched first, then moved to this depth: attached iff g >= 0; below touching
                       only the nodes touched, those of least f, while they are pulled by <= δ₀

The certificate judges every known node alone: penetration max(g - u)/δ over free ones; opening, the
tension on an attached one beyond √(2kw)Δx; neighbours, the energy gained by letting go of one or,
where the branch may, by attaching one; force kΔx Σ u_i by both routes.
"""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.equilibrium import Equilibrium
from discretization.lattice import fronts, line, span
from discretization.lattice.contact_set import ContactSet, totals
from discretization.lattice.judgement import rounding
from discretization.lattice.lowest import (
    Pair,
    passed,
    refuse_unknown,
    state_of,
    without_contact,
)
from discretization.lattice.nodes import Lattice
from discretization.lattice.shortest_path import window
from energy import Scene

_TIE = 1e-12


def on_springs(
    scene: Scene, depth: float, branch: str, lattice: Lattice, where: fronts.Region
) -> Equilibrium:
    """Certified state of independent springs on this branch; see the module."""
    first, g = window(lattice, scene.indenter, depth)
    reach = _reach(lattice, branch, float(g.max()))
    nodes = span.runs(g >= -reach * (1 + _TIE)) + first
    if not nodes.size:
        return without_contact(scene, depth, branch, lattice, where)
    refuse_unknown(scene, depth, lattice, where, nodes)
    contacts = ContactSet.of(lattice, scene.indenter, depth, where, nodes)
    sums = totals(contacts)
    certificate = passed(depth, _judged(contacts, branch, sums.force, sums.force_by_reactions))
    lines = _lines(lattice, scene, depth, where, nodes, reach)
    return state_of(scene, depth, branch, lattice, nodes.tolist(), sums, certificate, lines)


def _reach(lattice: Lattice, branch: str, highest: float) -> float:
    """How far attached nodes may be pulled; -inf if there are none. highest: the largest g."""
    most = lattice.critical_gap
    pulled = most if branch == "global" else max(0.0, -highest)
    return pulled if -highest <= most * (1 + _TIE) else -math.inf


def _judged(contacts: ContactSet, branch: str, force: float, reactions: float) -> Certificate:
    lat, mask, delta = contacts.lattice, contacts.mask, contacts.scale
    if delta == 0:  # touching, nothing deformed
        return Certificate.undeformed()
    unit, wdx, noise = lat.spring * delta, lat.w * lat.spacing, rounding(lat, delta)
    free, g = contacts.g[~mask], contacts.g[mask]
    pull = np.maximum(-g * lat.spring - noise, 0.0)
    gain = [pull**2 / (2 * lat.spring) - wdx]
    if branch == "global":
        near = free[np.isfinite(free)]
        gain.append(wdx - (lat.spring * np.abs(near) + noise) ** 2 / (2 * lat.spring))
    gained = max(float(part.max(initial=0.0)) for part in gain)
    size = float(np.abs(contacts.force[mask]).sum())
    return Certificate(
        penetration=max(0.0, float((contacts.g - contacts.u).max()) / delta),
        stationarity=float(np.abs(contacts.force[~mask]).max()) / unit,
        opening=max(0.0, float(pull.max()) - math.sqrt(2 * lat.spring * wdx)) / unit,
        neighbours=max(0.0, gained) / (unit * delta + wdx),
        force=abs(force - reactions) / (size or 1.0),
    )


def _lines(
    lattice: Lattice,
    scene: Scene,
    depth: float,
    where: fronts.Region,
    nodes: NDArray[np.int64],
    reach: float,
) -> list[Pair]:
    """Left and right line of each contact, each found as if it were alone."""
    before = np.append(where.first, nodes[:-1, 1] + 1).tolist()
    after = np.append(nodes[1:, 0] - 1, where.last).tolist()
    found = []
    for (first, last), lo, hi in zip(nodes.tolist(), before, after, strict=True):
        left, right = (
            line.recover(lattice, scene.indenter, depth, (lo, hi), node, side, reach)
            for node, side in ((first, -1), (last, 1))
        )
        found.append((left, right))
    return found
