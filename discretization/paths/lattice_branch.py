"""The metastable branch of one contact on the lattice, followed from state to state.

A contact line passes the link from node m to m+1, outwards from where contact begins, at the depth

    d_m = f_m + (f_{m+1} - f_m - G)/(1 - λ),      G: `Lattice.critical_gap`,

where both contact sets have the same energy (../lattice/fronts.py). So heights are turned to depths
once, and afterwards a line moves by comparing numbers: it advances while d_m <= d and recedes while
d_{m-1} > d, at O(1) per link and without a solve. Force and energy come from running sums over the
heights. A line that moves smoothly releases nothing at any link, hence a branch walked there and
back has no loop area.

Between the nodes the line is where d_m, taken at the middles of the links, equals d; force and
energy reported for a step are interpolated there. States, events and the ledger are those of the
contact sets.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.lattice.fronts import Contact, Region, heights, region
from discretization.lattice.judgement import certify, rounding
from discretization.lattice.nodes import Lattice
from discretization.lattice.sums import measured
from discretization.lattice.unseen import Unseen, looked_between, unseen
from discretization.paths.lattice_side import Side, build, factors
from energy import Scene

Array = NDArray[np.float64]
_INTERIOR = 0.499
_OF_ADHESION = ("opening", "neighbours")  # judged here where the work of adhesion is not uniform


class Links(NamedTuple):
    """A contact of `left` and `right` links beside the node that touches first; its ends in x."""

    left: int
    right: int
    ends: tuple[float, float]


State = Links | None


@dataclass(frozen=True, eq=False)
class LatticeBranch:
    """States of one contact on fixed nodes under a prescribed depth; None: detached."""

    scene: Scene
    lattice: Lattice
    where: Region
    left: Side
    right: Side
    deepest: float

    @functools.cached_property
    def hidden(self) -> Unseen:
        """What the nodes do not see of the profile."""
        return unseen(self.scene, self.deepest, self.lattice)

    @classmethod
    def of(cls, scene: Scene, spacing: float, deepest: float) -> LatticeBranch:
        """deepest: the largest depth of the programme, which says how many nodes are needed.

        ValueError for finite slopes and for springs without tension.
        """
        if scene.slopes != "small" or not scene.gamma1:
            raise ValueError(
                f"slopes = {scene.slopes!r} with gamma1 = {scene.gamma1!r}: a load path on the "
                "lattice needs small slopes and gamma1 > 0; use method='fitted'"
            )
        lattice = Lattice.of(scene, spacing)
        where = region(lattice, scene.indenter, deepest)
        return cls(scene, lattice, where, *build(scene, lattice, where, deepest), deepest)

    @property
    def touch(self) -> float:
        """Depth at which contact begins."""
        return float(self.right.f[self.right.start])

    @property
    def smooth(self) -> bool:
        """Whether P is a smooth function of d between events."""
        return False

    @property
    def lift(self) -> float:
        """How far below touching a contact can be held: δ₀ of opening."""
        return self.scene.opened.critical_separation

    def _state(self, left: int, right: int) -> Links:
        sides = (self.left, left), (self.right, right)
        x, y = (float(side.x[side.start + links]) for side, links in sides)
        return Links(left, right, (x, y))

    def contact(self, depth: float, *lines: float) -> State:
        """The state whose lines are less than half a link from these positions; nan: detached."""
        if math.isnan(lines[0]):
            return None
        sides = zip((self.left, self.right), lines, strict=True)
        return self._state(*(side.links(x, self.lattice.spacing) for side, x in sides))

    def follow(self, before: State, depth: float) -> State:
        """The state at this depth when it was `before` on the way here."""
        if before is None:
            if depth < self.touch:
                return None
            before = self._state(0, 0)
        left, right = self.left.moved(before.left, depth), self.right.moved(before.right, depth)
        return self._state(left, right) if left + right > 0 or depth >= self.touch else None

    def jump(self, state: State, start: float, end: float) -> tuple[float, State, State] | None:
        """The first depth on the way at which a line crosses several links at once."""
        if state is None:
            return None
        found = []
        for side, links in ((self.left, state.left), (self.right, state.right)):
            at, jumps = side.crossed(links, end)
            if jumps.any():
                found.append(float(at[np.argmax(jumps)]))
        if not found:
            return None
        rising = end >= max(found)
        depth = min(found) if rising else max(found)
        after = depth if rising else math.nextafter(depth, -math.inf)  # there links still hold
        return depth, self._before(state, depth, rising), self.follow(state, after)

    def _before(self, state: Links, depth: float, rising: bool) -> Links:
        """The state just before the links that are crossed at this depth."""
        counts = []
        for side, links in ((self.left, state.left), (self.right, state.right)):
            at, _ = side.crossed(links, depth)
            done = int(np.count_nonzero(at < depth if rising else at > depth))
            counts.append(links + done if rising else links - done)
        return self._state(*counts)

    def pinned(self, state: State) -> tuple[str, str]:
        """What holds each line: "edge", "tip" or "" where it is free."""
        if state is None:
            return ("", "")
        held, corners = [], np.asarray(self.scene.indenter.corners, float)
        for side, links in ((self.left, state.left), (self.right, state.right)):
            at = side.start + links
            tip = links == 0 and side.x[at] in corners
            edge = at == side.x.size - 1 and math.isinf(side.closes[at])
            held.append("edge" if edge else "tip" if tip else "")
        return held[0], held[1]

    def force(self, state: State, depth: float) -> float:
        """P of the contact set."""
        if state is None:
            return 0.0
        middle = self.lattice.spring * (depth - self.touch)
        return middle + sum(
            float(self._pull(side, links, depth))
            for side, links in ((self.left, state.left), (self.right, state.right))
        )

    def _pull(self, side: Side, links: Array | int, depth: Array | float) -> Array:
        """Force of one side without the middle node."""
        at = links + side.start
        springs = self.lattice.spring * (links * depth - side.sum_f[at])
        return np.asarray(springs + self.lattice.tail_force(depth - side.f[at]))

    def energy(self, state: State, depth: float) -> float:
        """U of the contact set."""
        if state is None:
            return 0.0
        middle = self.lattice.spring / 2 * (depth - self.touch) ** 2
        return middle + sum(
            float(self._stored(side, links, depth))
            for side, links in ((self.left, state.left), (self.right, state.right))
        )

    def _stored(self, side: Side, links: Array | int, depth: Array | float) -> Array:
        """Energy of one side without the middle node."""
        lat, at = self.lattice, links + side.start
        squares = links * depth**2 - 2 * depth * side.sum_f[at] + side.sum_f2[at]
        stretch = lat.link * side.sum_df2[at] + lat.end_stiffness * (depth - side.f[at]) ** 2
        return np.asarray(
            (lat.spring * squares + stretch) / 2 - lat.w * lat.spacing * side.bonds[at]
        )

    def friction(self, before: State, after: State) -> float:
        """(w_opening - w) for every link that opened without a jump."""
        if before is None or after is None or self.scene.opening is None:
            return 0.0
        opened = sum(
            float(side.bonds[side.start + max(old, new)] - side.bonds[side.start + new])
            for side, old, new in (
                (self.left, before.left, after.left),
                (self.right, before.right, after.right),
            )
        )
        more = self.scene.opened.work_of_adhesion - self.scene.work_of_adhesion
        return opened * self.lattice.spacing * more

    def work(self, before: State, start: float, end: float) -> float:
        """∫P dd from one depth to another without a jump: P is linear between crossed links."""
        if before is None or start == end:
            return 0.0
        done = self.lattice.spring * (end - start) * ((start + end) / 2 - self.touch)
        for side, links in ((self.left, before.left), (self.right, before.right)):
            at, _ = side.crossed(links, end)
            cuts = np.concatenate([[start], at, [end]])
            count = links + np.sign(end - start) * np.arange(at.size + 1)
            middles = (cuts[1:] + cuts[:-1]) / 2
            done += float(np.diff(cuts) @ self._pull(side, count.astype(int), middles))
        return done

    def observed(self, depths: Array, states: Sequence[Links]) -> tuple[Array, Array, Array]:
        """Lines (n, 2), P and U (n,) of states, interpolated between the nodes.

        AccuracyWarning where their surfaces miss what the nodes do not see; NotCertifiedError where
        one would open inside its contact, on a patch that adheres less.
        """
        if self.scene.pattern is not None:
            for state, depth in zip(states, depths.tolist(), strict=True):
                if self._torn(state, depth):
                    raise NotCertifiedError(
                        f"the contact at depth = {depth!r} violates opening: it would open on a "
                        "patch inside, and of several contacts none are followed with a pattern; "
                        "give smaller tensile depths, or a pattern without bare patches"
                    )
        lines = np.array([state.ends for state in states])
        looked_between(self.scene, self.lattice, self.hidden, depths, lines, stacklevel=4)
        spacing = self.lattice.spacing
        middle = self.lattice.spring * (depths - self.touch)
        force, energy, x = middle, middle * (depths - self.touch) / 2, np.empty_like(lines)
        for column, side in enumerate((self.left, self.right)):
            start = side.start
            links = np.rint(side.way * (lines[:, column] - side.x[start]) / spacing).astype(int)
            zeta = self._between(side, links, depths)
            beside = np.clip(links + np.sign(zeta).astype(int), -start, side.x.size - 1 - start)
            width, count = side.x[-1] - side.x[0], max(side.x.size - 1, 1)
            x[:, column] = side.x[start + links] + zeta * width / count
            for total, part in ((force, self._pull), (energy, self._stored)):
                own = part(side, links, depths)
                total += own + np.abs(zeta) * (part(side, beside, depths) - own)
        return x, force, energy

    def _between(self, side: Side, links: Array, depths: Array) -> Array:
        """Where the depth of closing equals d, in links from the last contact node: -1/2..1/2."""
        if not side.opens.size:  # the body ends at the node that touches first
            return np.zeros(links.size)
        at = links + side.start
        outer, inner = side.closes[at], side.opens[np.maximum(at - 1, 0)]
        tip = (links == 0) & np.isin(side.x[side.start], self.scene.indenter.corners)
        free = (at > 0) & ~tip & np.isfinite(outer) & (outer > inner)
        width = np.where(free, outer - inner, 1.0)
        zeta = np.where(free, (depths - inner) / width - 0.5, 0.0)
        return np.clip(zeta, -_INTERIOR, _INTERIOR)

    def certify(self, state: State, depth: float) -> None:
        """NotCertifiedError unless the contact set is in equilibrium."""
        if state is None:
            return
        lowest = self.where.lowest
        uniform = self.scene.opening is None and self.scene.pattern is None
        nodes = Contact(lowest - state.left, lowest + state.right, self.lattice.critical_gap)
        sums = measured(self.lattice, self.scene.indenter, depth, nodes)
        judged = certify(self.lattice, self.scene.indenter, depth, self.where, nodes, sums)
        failures = [name for name in judged.failures if uniform or name not in _OF_ADHESION]
        for side, links in ((self.left, state.left), (self.right, state.right)):
            below = side.moved(links, math.nextafter(depth, -math.inf))
            if links not in (side.moved(links, depth), below):
                failures.append("neighbours")
        if not uniform and self._torn(state, depth):
            failures.append("opening")
        if failures:
            raise NotCertifiedError(
                f"the state at depth = {depth!r} violates {', '.join(failures)} ({judged}); the "
                "path stops before it"
            )

    def _torn(self, state: Links, depth: float) -> bool:
        """Whether a node between two contact links is pulled by more than their adhesion holds.

        Opening it alone changes the energy by -r²/(2(kΔx + 2t)) + (w of both links) Δx.
        """
        lat, lowest = self.lattice, self.where.lowest
        nodes = np.arange(lowest - state.left, lowest + state.right + 1, dtype=float)
        g = depth - heights(lat, self.scene.indenter, nodes)
        work = self.scene.opened.work_of_adhesion * factors(self.scene, lat.x(nodes[:-1] + 0.5))
        pull = -lat.spring * g[1:-1] + lat.link * np.diff(g, 2)
        held = np.sqrt(2 * (lat.spring + 2 * lat.link) * (work[1:] + work[:-1]) * lat.spacing)
        noise = rounding(lat, max(abs(depth), float(np.abs(g).max()), self.lift))
        return bool((pull > held + noise).any())
