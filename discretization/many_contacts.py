"""The metastable branch of several contacts on the lattice, from change to change.

A state is a list of contacts, node intervals first..last. Between two of them lies a free span of T
links, whose first free node is displaced by A g_i + B g_j, with μ = -ln λ,

    A = sinh μ(T-1)/sinh μT,   B = sinh μ/sinh μT,
    1 - A - B = 2 sinh(μ(T-1)/2) sinh(μ/2)/cosh(μT/2),

and outside two tails, A = λ, B = 0. As d changes, four things can happen, each at a depth that
follows from the heights f of the nodes involved:

    a line passes the next link (n = 1), or closes the last two (n = 2: coalescence), or opens one,
        d = f_i + (f_1 - f_i + B (f_i - f_j) - G)/(1 - A - B),   G = √(2 n wΔx/c),
        c = kΔx + t + t(1 - A(T-1)), the stiffness of the first free node;
    a free node touches:  d = (f_m - a f_i - b f_j)/(1 - a - b), a and b the shape of the span;
    a node inside a contact is torn open (n = 2, both neighbours in contact);
    a lone node, which has no adhesion, is pulled and lets go.

Every change lowers the re-equilibrated energy or leaves it equal; where one calls for others at the
same depth, the state jumps. Forces and energies are those of the contact sets, without
interpolation between the nodes.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.fronts import heights, region
from discretization.lattice import Lattice
from energy import Scene

Array = NDArray[np.float64]
_TIE = 1e-12
_MANY = 10**6


Nodes = tuple[tuple[int, int], ...]


class Contacts(NamedTuple):
    """Node intervals ((first, last), ...) from left to right, and the positions of all lines."""

    nodes: Nodes
    lines: tuple[float, ...]

    @property
    def ends(self) -> tuple[float, float]:
        """x of the outermost lines."""
        return self.lines[0], self.lines[-1]


State = Contacts | None


class Change(NamedTuple):
    """What happens at a depth: the contacts afterwards, and whether it is more than one link."""

    depth: float
    nodes: Nodes
    abrupt: bool


@dataclass(frozen=True, eq=False)
class ManyContacts:
    """States of any number of contacts on fixed nodes under a prescribed depth; None: detached.

    f (n,): heights of the nodes of the window; running sums of f and f² over the nodes, of (Δf)²
    over the links.
    """

    scene: Scene
    lattice: Lattice
    first: int
    f: Array
    sum_f: Array
    sum_f2: Array
    sum_df2: Array

    @classmethod
    def of(cls, scene: Scene, spacing: float, deepest: float) -> ManyContacts:
        """deepest: the largest depth of the programme. ValueError for what cannot be followed."""
        lattice = Lattice.of(scene, spacing)
        for name, given in (("opening", scene.opening), ("pattern", scene.pattern)):
            if given is not None:
                raise ValueError(f"{name} = {given!r} with several contacts is not available")
        if scene.slopes != "small" or not scene.gamma1:
            raise ValueError(
                f"slopes = {scene.slopes!r} with gamma1 = {scene.gamma1!r}: a load path on the "
                "lattice needs small slopes and gamma1 > 0"
            )
        where = region(lattice, scene.indenter, deepest)
        if where.last - where.first > _MANY:
            raise ValueError(
                f"spacing = {spacing!r} puts {where.last - where.first} nodes on the indenter; "
                "give it a finite extent, or a larger spacing"
            )
        f = heights(lattice, scene.indenter, np.arange(where.first, where.last + 1, dtype=float))
        sums = [np.concatenate([[0.0], np.cumsum(part)]) for part in (f, f * f, np.diff(f) ** 2)]
        return cls(scene, lattice, where.first, f, sums[0], sums[1], sums[2])

    @property
    def smooth(self) -> bool:
        """Whether P is a smooth function of d between events."""
        return False

    @property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return float(self.f.min())

    @property
    def lift(self) -> float:
        """How far below touching a contact can be held."""
        return self.scene.critical_separation

    def _state(self, nodes: Nodes) -> State:
        if not nodes:
            return None
        lines = (self.lattice.x(self.first + node) for pair in nodes for node in pair)
        return Contacts(nodes, tuple(float(x) for x in lines))

    def contact(self, *lines: float) -> State:
        """The state with lines here; nan: detached."""
        if math.isnan(lines[0]):
            return None
        lat = self.lattice
        at = [round((x - lat.origin) / lat.spacing) - self.first for x in lines]
        return self._state(tuple(zip(at[::2], at[1::2], strict=True)))

    # the free span of `links` links; None: a tail

    def _shares(self, links: int | None) -> tuple[float, float, float]:
        """A, B and 1 - A - B."""
        lat, mu = self.lattice, self.lattice.log_decay
        if links is None:
            return lat.decay, 0.0, lat.loss
        whole = -math.expm1(-2 * links * mu)
        near = lat.decay * -math.expm1(-2 * (links - 1) * mu) / whole
        far = math.exp(-(links - 1) * mu) * -math.expm1(-2 * mu) / whole
        both = -math.expm1(-(links - 1) * mu) * -math.expm1(-mu) / (1 + math.exp(-links * mu))
        return near, far, both

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def _passes(self, node: int, side: int, other: int | None) -> float:
        """Depth at which a line at `node` passes the link to the next node, on this side."""
        lat, after = self.lattice, node + side
        links = None if other is None else abs(other - node)
        _, far, both = self._shares(links)
        rest = lat.loss if links is None else 1 - self._shares(links - 1)[0]
        bonds = 2 if links == 2 else 1
        stiffness = lat.spring + lat.link + lat.link * rest
        gap = math.sqrt(2 * bonds * lat.w * lat.spacing / stiffness)
        rise = float(self.f[after] - self.f[node])
        if other is not None:
            rise += far * float(self.f[node] - self.f[other])
        return float(self.f[node]) + (rise - gap) / both

    @functools.lru_cache(maxsize=1 << 16)  # noqa: B019
    def _touches(self, left: int | None, right: int | None) -> tuple[float, int]:
        """Depth at which a free node between two contacts (None: none there) touches, and which."""
        mu, n = self.lattice.log_decay, self.f.size
        lo, hi = -1 if left is None else left, n if right is None else right
        m = np.arange(lo + 1, hi)
        if not m.size:
            return math.inf, -1
        if left is not None and right is not None:
            whole = -np.expm1(-2 * mu * (right - left))
            a = np.exp(-mu * (m - left)) * -np.expm1(-2 * mu * (right - m)) / whole
            b = np.exp(-mu * (right - m)) * -np.expm1(-2 * mu * (m - left)) / whole
            half = np.expm1(-mu * (m - left)) * np.expm1(-mu * (right - m))
            rest, shape = half / (1 + math.exp(-mu * (right - left))), a * self.f[left]
            shape = shape + b * self.f[right]
        else:
            from_end = m - left if left is not None else hi - m
            end = left if left is not None else right
            a = np.exp(-mu * from_end)
            rest, shape = -np.expm1(-mu * from_end), a * self.f[end]
        depths = (self.f[m] - shape) / rest
        best = int(np.argmin(depths))
        return float(depths[best]), int(m[best])

    def _spans(self, nodes: Nodes) -> Iterator[tuple[int | None, int | None]]:
        """Last and first contact node on the left and on the right of every free part."""
        ends = [None, *(node for pair in nodes for node in pair), None]
        yield from zip(ends[::2], ends[1::2], strict=True)

    def _lines(self, nodes: Nodes) -> Iterator[tuple[int, int, int | None]]:
        """(contact, side, contact node beyond the free part) of every line."""
        for i, _ in enumerate(nodes):
            yield i, -1, nodes[i - 1][1] if i else None
            yield i, 1, nodes[i + 1][0] if i + 1 < len(nodes) else None

    def _advances(self, nodes: Nodes) -> Iterator[Change]:
        """What can happen as the depth grows."""
        for i, side, other in self._lines(nodes):
            node = nodes[i][side > 0]
            if 0 <= node + side < self.f.size:
                depth = self._passes(node, side, other)
                closing = other is not None and abs(other - node) == 2
                yield Change(depth, _moved(nodes, i, side, 1), closing)
        for left, right in self._spans(nodes) if nodes else ():
            depth, node = self._touches(left, right)
            if node >= 0:
                yield Change(depth, _joined((*nodes, (node, node))), True)
        if not nodes:
            node = int(np.argmin(self.f))
            yield Change(self.touch, ((node, node),), True)

    def _recedes(self, nodes: Nodes) -> Iterator[Change]:
        """What can happen as the depth falls."""
        for i, side, other in self._lines(nodes):
            first, last = nodes[i]
            if first < last:
                node = nodes[i][side > 0]
                depth = self._passes(node - side, side, other)
                yield Change(depth, _moved(nodes, i, side, -1), False)
            elif side > 0:
                yield Change(self._pulled(nodes, i), nodes[:i] + nodes[i + 1 :], True)
        for i, (first, last) in enumerate(nodes):
            if last - first >= 2:
                m = np.arange(first + 1, last)
                near, _, both = self._shares(2)
                gap = math.sqrt(4 * self.lattice.w * self.lattice.spacing / self._alone)
                torn = (self.f[m] - near * (self.f[m - 1] + self.f[m + 1]) - gap) / both
                best = int(np.argmax(torn))
                node = int(m[best])
                parts = (first, node - 1), (node + 1, last)
                yield Change(float(torn[best]), (*nodes[:i], *parts, *nodes[i + 1 :]), True)

    @property
    def _alone(self) -> float:
        return self.lattice.spring + 2 * self.lattice.link

    def _pulled(self, nodes: Nodes, i: int) -> float:
        """Depth below which a lone node is pulled."""
        lat, node = self.lattice, nodes[i][0]
        left = nodes[i - 1][1] if i else None
        right = nodes[i + 1][0] if i + 1 < len(nodes) else None
        rate, load = lat.spring, lat.spring * float(self.f[node])
        for other in (left, right):
            near, far, both = self._shares(None if other is None else abs(other - node))
            rate += lat.link * both
            beyond = 0.0 if other is None else float(self.f[other])
            load += lat.link * ((1 - near) * float(self.f[node]) - far * beyond)
        return load / rate

    def _next(self, nodes: Nodes, end: float) -> Change | None:
        """The first change on the way to a depth; at that very depth, what still has to happen."""
        rising = min(self._advances(nodes), key=lambda change: change.depth)
        if rising.depth <= end:
            return rising
        falling = max(self._recedes(nodes), key=lambda change: change.depth, default=None)
        return falling if falling is not None and falling.depth > end else None

    def _relaxed(self, nodes: Nodes, depth: float) -> Nodes:
        """Contacts once everything that lowers the energy at a fixed depth has happened."""
        for _ in range(_MANY):
            change = self._next(nodes, depth)
            if change is None:
                return nodes
            nodes = change.nodes
        raise NotCertifiedError(f"the contacts at depth = {depth!r} do not come to rest")

    def _walk(self, nodes: Nodes, end: float) -> Iterator[tuple[float, Nodes, Nodes, bool]]:
        """Changes on the way to a depth: where, contacts before and after, whether by a jump."""
        while (change := self._next(nodes, end)) is not None:
            rising = change.depth <= end
            at = change.depth if rising else math.nextafter(change.depth, -math.inf)
            after = self._relaxed(change.nodes, at)
            abrupt = change.abrupt or self._released(nodes, after, change) > self._least
            yield change.depth, nodes, after, abrupt
            nodes = after

    @property
    def _least(self) -> float:
        """Energy below which a change is no jump: rounding."""
        return 1e-9 * self.lattice.w * self.lattice.spacing

    def _released(self, before: Nodes, after: Nodes, change: Change) -> float:
        if after == change.nodes:
            return 0.0
        energies = (self.energy(Contacts(nodes, ()), change.depth) for nodes in (before, after))
        return next(energies) - next(energies) if after else math.inf

    def jump(self, state: State, end: float) -> tuple[float, State, State] | None:
        """First depth on the way at which more than one link changes, and the states beside it."""
        if state is None:
            return None
        for depth, before, after, abrupt in self._walk(state.nodes, end):
            if abrupt:
                self._inside(after, depth)
                return depth, self._state(before), self._state(after)
        return None

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        if before is None and depth < self.touch:
            return None
        nodes = () if before is None else before.nodes
        self._inside(nodes := self._relaxed(nodes, depth), depth)
        return self._state(nodes)

    def _inside(self, nodes: Nodes, depth: float) -> None:
        lo, hi = self.scene.indenter.extent
        for node, end in ((nodes[0][0], lo), (nodes[-1][1], hi)) if nodes else ():
            if node in (0, self.f.size - 1) and end not in self.scene.indenter.walls:
                raise ValueError(
                    f"depth = {depth!r} spreads the contact over the whole known profile; give a "
                    "wider profile or smaller depths"
                )

    def pinned(self, state: State) -> tuple[str, str]:
        """What holds the outermost lines: "edge" or "" where they are free."""
        if state is None:
            return ("", "")
        walls = self.scene.indenter.walls
        ends = zip(state.ends, self.scene.indenter.extent, strict=True)
        near = self.lattice.spacing
        held = ["edge" if end in walls and abs(x - end) < near else "" for x, end in ends]
        return held[0], held[1]

    def _reactions(self, nodes: Nodes, depth: float) -> Iterator[tuple[float, float]]:
        """(g, pull of the free part) of every line."""
        for i, side, other in self._lines(nodes):
            node = nodes[i][side > 0]
            g = depth - float(self.f[node])
            _, far, both = self._shares(None if other is None else abs(other - node))
            # t (g - A g - B g') without cancellation
            apart = 0.0 if other is None else float(self.f[other] - self.f[node])
            yield g, self.lattice.link * (both * g + far * apart)

    def force(self, state: State, depth: float) -> float:
        """P = kΔx Σ g over the contact nodes + the pulls of the free parts."""
        if state is None:
            return 0.0
        total = sum(pull for _, pull in self._reactions(state.nodes, depth))
        for first, last in state.nodes:
            own = float(self.sum_f[last + 1] - self.sum_f[first])
            total += self.lattice.spring * ((last + 1 - first) * depth - own)
        return total

    def energy(self, state: State, depth: float) -> float:
        """U of the contact set."""
        if state is None:
            return 0.0
        lat = self.lattice
        total = sum(g * pull / 2 for g, pull in self._reactions(state.nodes, depth))
        for first, last in state.nodes:
            f = float(self.sum_f[last + 1] - self.sum_f[first])
            f2 = float(self.sum_f2[last + 1] - self.sum_f2[first])
            squares = (last + 1 - first) * depth**2 - 2 * depth * f + f2
            stretch = float(self.sum_df2[last] - self.sum_df2[first])
            total += (lat.spring * squares + lat.link * stretch) / 2
            total -= lat.w * lat.spacing * (last - first)
        return total

    def friction(self, before: State, after: State) -> float:
        """None: there is one work of adhesion."""
        return 0.0

    def work(self, before: State, start: float, end: float) -> float:
        """∫P dd from one depth to another without a jump: P is linear between changes."""
        if before is None or start == end:
            return 0.0
        done, here, nodes = 0.0, start, before.nodes
        for depth, _, after, _ in self._walk(before.nodes, end):
            middle = (here + depth) / 2
            done += (depth - here) * self.force(Contacts(nodes, ()), middle)
            here, nodes = depth, after
        return done + (end - here) * self.force(Contacts(nodes, ()), (here + end) / 2)

    def observed(self, depths: Array, states: Sequence[Contacts]) -> tuple[Array, Array, Array]:
        """Outermost lines (n, 2), P and U (n,) of the contact sets."""
        pairs = list(zip(depths.tolist(), states, strict=True))
        force = np.array([self.force(state, depth) for depth, state in pairs])
        energy = np.array([self.energy(state, depth) for depth, state in pairs])
        return np.array([state.ends for state in states]), force, energy

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError if something would still happen at this depth."""
        if state is None:
            return
        below = math.nextafter(depth, -math.inf)
        if all(self._next(state.nodes, at) is not None for at in (depth, below)):
            raise NotCertifiedError(
                f"the contacts at depth = {depth!r} are not at rest; the path stops before them"
            )


def _moved(nodes: Nodes, i: int, side: int, links: int) -> Nodes:
    """Contact i with its line on one side moved outwards by some links."""
    first, last = nodes[i]
    own = (first - links, last) if side < 0 else (first, last + links)
    return _joined((*nodes[:i], own, *nodes[i + 1 :]))


def _joined(nodes: Nodes) -> Nodes:
    """Contacts in order, neighbouring ones as one."""
    whole: list[tuple[int, int]] = []
    for first, last in sorted(nodes):
        if whole and first <= whole[-1][1] + 1:
            whole[-1] = (whole[-1][0], max(last, whole[-1][1]))
        else:
            whole.append((first, last))
    return tuple(whole)
