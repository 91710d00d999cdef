"""States of one contact found by plain.py: certificate, lines between the nodes, free surface."""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.equilibrium import Equilibrium
from discretization.lattice import line
from discretization.lattice.assembly import (
    Question,
    certified,
    is_neutral,
    refuse_unknown,
    without_contact,
)
from discretization.lattice.ground import Ground
from discretization.lattice.nodal_energy import NodalEnergy
from discretization.lattice.nodes import Lattice
from discretization.lattice.plain import Plain, far, turning
from discretization.lattice.shares import LatticeTail
from discretization.rounding import EPSILON
from energy import terms

Array = NDArray[np.float64]
Indices = NDArray[np.intp]
_TURNS = 24  # of Newton's method for single nodes


class Sums(NamedTuple):
    """U and P of a state, and the sums of their terms' absolute values."""

    energy: float
    force: float
    energy_scale: float
    force_scale: float


def on_plain(asked: Question, ground: Ground) -> Equilibrium:
    """The certified state of one contact on the path, or of least energy. Errors as `of_contacts`.

    Without tension springs attach where they touch; for the lowest energy, where that pays.
    """
    lattice, depth = ground.lattice, asked.depth
    reach = lattice.critical_gap
    if not lattice.gamma1 and asked.branch == "adhered":
        reach = min(reach, max(0.0, ground.lowest - depth))
    plain = Plain(ground, depth, reach)
    found = plain.contact()
    if found is None:
        return without_contact(asked, ground)
    refuse_unknown(ground, depth, *found)
    state = PlainState.of(plain, *found)
    if asked.branch == "global" and depth <= ground.lowest and state.sums.energy > 0:
        return without_contact(asked, ground)
    ends = [plain.end(found[1], 1)]
    if not plain.mirrored and found[0] != lattice.axis:
        ends.append(plain.end(found[0], -1))
    pair = line.outer(ground, reach, ends)
    for x, node in zip((pair[0].x, pair[1].x), found, strict=True):
        refuse_overhang(ground, depth, x, node)
    touched = asked.branch == "adhered" and not lattice.gamma1
    certificate = judged(state, ends, touched)
    if "penetration" in certificate.failures:
        raise ValueError(
            f"depth = {depth!r}: beyond the contact the surface is in the indenter; with slopes = "
            f"{lattice.slopes!r} nodes answer states of one contact only: use method='fitted'"
        )
    tail = SteepTail(lattice.tail.rate, lattice) if lattice.slopes == "finite" else lattice.tail
    neutral = is_neutral(lattice, found, ends[0])
    return certified(asked, ground, [found], [pair], state.sums, certificate, tail, neutral=neutral)


def refuse_overhang(ground: Ground, depth: float, x: float, node: int) -> None:
    """ValueError for a line at which a surface of finite slope would all but turn over."""
    lattice = ground.lattice
    limit, u = turning(lattice), depth - float(ground.indenter.height(np.array([x]))[0])
    own = abs(depth - float(ground.heights(node, node)[0])) - lattice.spacing
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
    """The relaxed surface of one contact: its energy, u and f of the nodes (inf: none known)."""

    ground: Ground
    depth: float
    model: NodalEnergy
    u: Array
    f: Array

    @classmethod
    def of(cls, plain: Plain, first: int, last: int) -> PlainState:
        """Nodes up to where the free surfaces are linear; all, of a profile that is not convex."""
        ground, lattice, (lo, hi, _) = plain.ground, plain.ground.lattice, plain.ground.where
        start, stop = first - far(lattice), last + far(lattice)
        if not ground.indenter.convex:
            start, stop = min(start, lo), max(stop, hi)
        start = max(start, 0) if lattice.axis == 0 else start
        nodes = np.arange(start, stop + 1)
        f = np.full(nodes.size, math.inf)
        known = slice(max(lo, start) - start, min(hi, stop) - start + 1)
        f[known] = ground.heights(max(lo, start), min(hi, stop))
        model = NodalEnergy(lattice, (nodes >= first) & (nodes <= last), start)
        return cls(ground, plain.depth, model, model.relaxed(plain.depth - f), f)

    @functools.cached_property
    def sums(self) -> Sums:
        """Energy and force, the latter of all springs."""
        lat, terms = self.model.lattice, self.model.terms(self.u)
        springs = lat.spring * lat.on_nodes(self.u, self.model.nodes)
        ends = zip(self.model.ends, self.u[[0, -1]], strict=True)
        beyond = [float(place.tail_force(u)) for place, u in ends]
        return Sums(
            sum(terms.values()),
            float(springs.sum()) + sum(beyond),
            sum(map(abs, terms.values())),
            float(np.abs(springs).sum()) + sum(map(abs, beyond)),
        )

    @functools.cached_property
    def size(self) -> float:
        """δ of judge.py: the largest of |d|, |u| at the lines and δ₀."""
        lat, held = self.model.lattice, self.u[self.model.contact]
        lift = math.sqrt(2 * lat.w / lat.k)
        return max(abs(self.depth), abs(float(held[0])), abs(float(held[-1])), lift)


def judged(state: PlainState, ends: list[line.End], touched: bool) -> Certificate:
    """The conditions of judge.py, from the energy of all nodes itself.

    touched: springs only attach where they touch, not where that pays.
    """
    model, lat, held, sums = state.model, state.model.lattice, state.model.contact, state.sums
    size = max(state.size, abs(state.depth - state.ground.lowest))
    if not size:
        return Certificate.undeformed()
    delta, noise = state.size or size, 32 * EPSILON * (lat.spring + 4 * lat.link) * size
    force = model.gradient(state.u)
    pull = lat.per_weight(force, model.nodes)
    through = (state.depth - state.f - state.u)[~held]
    apart = abs(force[held].sum() - sums.force)
    apart -= 4 * EPSILON * math.sqrt(2 * model.terms(state.u)["surface"] * lat.link * held.size)
    return Certificate(
        penetration=max(0.0, float(through.max(initial=0.0))) / delta,
        stationarity=max(0.0, float(np.abs(pull[~held]).max(initial=0.0)) - noise)
        / (lat.spring * delta),
        opening=max(0.0, _opening(state, pull) - noise) / (lat.spring * delta),
        neighbours=max([0.0, *(_gain(lat, end, touched, 32 * EPSILON * size) for end in ends)]),
        force=max(0.0, apart) / (sums.force_scale or 1.0),
    )


def _opening(state: PlainState, pull: Array) -> float:
    """The largest pull per weight on contact nodes that adhesion does not hold.

    A node between two links is held if opening it alone, the others as they are, raises the energy.
    """
    model = state.model
    held = np.flatnonzero(model.contact)
    if not model.lattice.gamma1:
        holds = math.sqrt(2 * model.lattice.spring * model.lattice.w * model.lattice.cell)
        return max(0.0, float((-pull[held]).max()) - holds)
    if held.size == 1:
        return max(0.0, -float(pull[held[0]]))
    pulled = held[1:-1][pull[held[1:-1]] < 0]
    return max(0.0, float((-pull[pulled[_opens(state, pulled)]]).max(initial=0.0)))


def _opens(state: PlainState, i: Indices) -> NDArray[np.bool_]:
    """Whether opening one of these nodes (n,), each between two links, lowers the energy.

    Only that node moves, by Newton's method with steps halved while they would raise the energy.
    """
    lat, nodes, u = state.model.lattice, state.model.nodes, state.u
    weight = lat.on_nodes(np.ones(u.size), nodes)[i]
    links, sides = lat.on_links(np.ones(u.size - 1), nodes), (i - 1, i)

    def terms_at(v: Array) -> tuple[Array, Array, Array]:
        """Energy without adhesion, and its derivatives, over Δx."""
        found = weight * np.array(terms.spring(v, k=lat.k))
        for own, beside in zip(sides, (u[i - 1], u[i + 1]), strict=True):
            slope = (v - beside) / lat.spacing
            link = np.array(terms.surface(slope, gamma1=lat.gamma1, slopes=lat.slopes))
            found += links[own] * link / lat.spacing ** np.arange(3)[:, None]
        return found[0], found[1], found[2]

    v, (closed, first, second) = u[i], terms_at(u[i])
    energy = closed
    for _ in range(_TURNS):
        step = -first / second
        better = terms_at(v + step)[0] <= energy
        v = v + np.where(better, step, step / 2)
        energy, first, second = terms_at(v)
    for own, beside in zip(sides, (u[i - 1], u[i + 1]), strict=True):
        stretch = (u[i] - beside) / lat.spacing
        arc = np.hypot(1.0, stretch) if lat.slopes == "finite" else np.ones(i.size)
        closed = closed - lat.w * links[own] * arc
    return np.asarray(energy < closed)


def _gain(lat: Lattice, end: line.End, touched: bool, noise: float) -> float:
    """Energy gained by a line that moves by one link, over the terms of that change."""
    outwards, inwards = -end.start, -end.start - 1
    gains, reach = [0.0], lat.critical_gap
    if outwards < len(end.gap) and not touched:
        gap = abs(end.gap[outwards]) + noise
        gains.append((reach**2 - gap**2) / ((reach**2 + gap**2) or 1.0))
    if inwards >= 0:
        gap = max(0.0, end.gap[inwards] - noise)
        gains.append((gap**2 - reach**2) / ((reach**2 + gap**2) or 1.0))
    return max(gains)


@dataclass(frozen=True)
class SteepTail(LatticeTail):
    """Free surfaces beyond a contact line with finite slopes, from nodes that begin at the line.

    Between the nodes u is a cubic, with u'' = k u (1 + u'²)^{3/2}/γ₁ linear from node to node.
    """

    lattice: Lattice

    @functools.lru_cache(maxsize=64)  # noqa: B019
    def _nodes(self, u_line: float) -> tuple[Array, Array]:
        """u and u' outwards."""
        lat = self.lattice
        model = NodalEnergy(lat, np.arange(far(lat) + 1) == 0)
        u = model.relaxed(np.full(model.contact.size, u_line))
        u = np.append(u, lat.decay * u[-1])
        bend = lat.k / lat.gamma1 * u * (1 + np.gradient(u, lat.spacing, edge_order=2) ** 2) ** 1.5
        chord = np.diff(u) / lat.spacing
        return u[:-1], chord - lat.spacing / 6 * (2 * bend[:-1] + bend[1:])

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """u at these distances from the line."""
        (u, slope), dx = self._nodes(float(u_line)), self.lattice.spacing
        i = np.minimum((distance / dx).astype(int), u.size - 2)
        t, last = distance / dx - i, dx * (u.size - 1)
        chord, one, other = u[i + 1] - u[i], dx * slope[i], dx * slope[i + 1]
        bend = t * (1 - t) * ((1 - t) * (one - chord) - t * (other - chord))
        beyond = u[-1] * np.exp(-self.rate * np.maximum(distance - last, 0.0))
        return np.where(distance <= last, u[i] + t * chord + bend, beyond)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """u' outwards where the surface is displaced by these: it is the same from there on."""
        most = float(np.abs(u_line).max(initial=0.0))
        if not most:
            return np.zeros_like(u_line)
        u, slope = self._nodes(most)
        u, slope = np.append(0.0, u[::-1]), np.append(0.0, slope[::-1])
        return np.asarray(np.sign(u_line) * np.interp(np.abs(u_line), u, slope))
