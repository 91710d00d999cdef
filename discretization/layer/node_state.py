"""States of one contact of a layer on nodes: which contact, its certificate and error estimate."""

import functools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import Body
from discretization.layer.nodes import KNOWN, Nodes, compliance
from discretization.layer.state import certified
from discretization.readings import with_surface
from discretization.surfaces.protocol import At, alone
from discretization.surfaces.small import SmallSurfaces
from energy import Scene, SurfaceEnergies
from energy.arrays import Array

_FIRST, _MOST = 32, 4096  # nodes on each side that are tried
_SPARE = 4  # links beyond the line, for polynomials
_LEAST = 8  # nodes of a contact whose error is known
_CLEAR = 64  # nodes beside a contact at which the surface is compared with the indenter, at most
_SAFE = 4.0  # times the difference of two spacings
_COARSE = 0.05  # relative errors that are no small ones: nodes do not resolve the free surface
_STEP = 1e-2  # of γ₁: a difference as good as the nodes
_LUCKY = 0.05  # of the errors of force and energy: where half-widths happen to agree


@dataclass(frozen=True, eq=False)
class NodeState:
    """The surface of a layer held down at nodes up to the n-th, and the forces there.

    The line, at a, is between that one and one of its neighbours. What is asked of the fields is
    interpolated between the contacts that end at these, moved sideways to the line.
    """

    nodes: Nodes
    depth: float
    n: int

    body = property(lambda self: self.nodes.body)
    a = property(lambda self: self.found[0])
    force = property(lambda self: self.found[1])
    energy = property(lambda self: self.found[2])
    x = property(lambda self: self.nodes.x[: self.n + 1])
    outermost = property(lambda self: float(self.x[-1]))
    pinned = property(lambda self: self.n == self.nodes.x.size - 1)

    @functools.cached_property
    def found(self) -> tuple[float, float, float]:
        """a, P and U."""
        a = self.nodes.line(self.depth, self.n)
        return a, *self.nodes.between(self.depth, a)

    @functools.cached_property
    def forces(self) -> Array:
        """On them (n + 1,)."""
        return self.nodes.forces(self.depth, self.n)

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """Sums of the sizes of the terms of force and energy."""
        bound = self.body.scene.work_of_adhesion * float(self.body.area(self.x[-1]))
        stored = float(self.forces @ (self.depth - self.body.height(self.x))) / 2
        return {"force": float(np.abs(self.forces).sum()), "energy": stored + bound}

    def beside(self, distance: Array) -> Array:
        """u so far beside the line."""
        found, x = np.zeros(distance.size), self.nodes.x
        i = max(int(np.searchsorted(x, self.a, side="right")) - 1, 0)
        part = max((self.a - float(x[i])) / self.nodes.spacing, 0.0)
        for n, share in ((i, 1 - part), (i + 1, part)):
            if share:
                response = compliance(self.body.scene, x[n] + distance, x[: n + 1])
                found += share * (response @ self.nodes.forces(self.depth, n))
        return found

    def shape(
        self, z: Array, left: At | None, right: At | None, depth: float
    ) -> tuple[Array, Array]:
        """u and u' of the free surface, u' by differences over half a link."""
        side = 1 if left is not None else -1
        distance, step = np.abs(z - alone(left, right).x), self.nodes.spacing / 2
        steps = (distance + i * step for i in range(3))
        three = self.beside(np.concatenate(list(steps))).reshape(3, -1)
        slope = (4 * three[1] - three[2] - 3 * three[0]) / (2 * step)
        return three[0], side * slope

    def pressure(self, state: Any, x: Array) -> Array:
        """The force on nodes over what each one stands for, less the tension's share.

        Not of the innermost ring, which stands for more, and of the outermost node, on which the
        line pulls, too.
        """
        body, step, own = self.body, self.nodes.spacing, self.x[self.body.power : -1]
        share = body.whole * own**body.power * np.where(own > 0, step, step / 2)
        middle = own + step / 2 * np.array([[-1], [1]])
        bend = np.diff(middle**body.power * body.slope(middle), axis=0)[0] / step
        pressed = self.forces[body.power : -1] / share - body.scene.gamma1 * bend / own**body.power
        return np.interp(np.abs(x - body.apex), own, pressed)

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force in parts; the energy of the surface is γ₁ ∂U/∂γ₁, as U is the least."""
        scene, nodes = self.body.scene, self.nodes

        def stored(part: float) -> float:
            tension = SurfaceEnergies.from_work(part * scene.gamma1, 0.0)
            body = Body(replace(scene, surfaces=tension))
            other = Nodes.of(body, nodes.spacing, self.n + _SPARE)
            return other.between(self.depth, self.a)[1]

        return with_surface(state, (stored(1 + _STEP) - stored(1 - _STEP)) / (2 * _STEP))

    @functools.cached_property
    def certificate(self) -> Certificate:
        """The conditions of ../certificate.py, judged by the displacements that the forces give.

        At the nodes: the line is anywhere in its link, and the surface of a state that is right to
        second order may be inside the indenter there. Nodes that do not resolve it have an error
        that is not known.
        """
        nodes, body, x, own = self.nodes, self.body, self.x, slice(self.n + 1)
        g, through, pulled = self.depth - body.height(x), 0.0, 0.0
        size, last = float(np.abs(g).max()) or 1.0, 2 * (nodes.x.size - 1) - self.n
        ahead = np.unique(np.geomspace(1, max(1, last), _CLEAR).astype(int))
        places = x[-1] + nodes.spacing * ahead
        places = places[places <= body.edge]
        if places.size:
            u = compliance(body.scene, places, x) @ self.forces
            through = float((self.depth - body.height(places) - u).max())
        if not body.scene.work_of_adhesion:
            pulled = -float(self.forces.min())
        rests, n, depth = nodes.rest_depths, self.n, self.depth
        links = [0.0, *(depth - rests[n : n + 1]), *(rests[max(n - 1, 0) : n] - depth)]
        lower, rate = nodes.lower[own, own], nodes.rate[own]
        by_energy = float((nodes.start[own] + depth * rate) @ rate)
        return Certificate(
            max(0.0, through) / size,
            float(np.abs(lower @ (lower.T @ self.forces) - g).max()) / size,
            max(0.0, pulled) / self.scales["force"],
            float(max(links)) / size,
            abs(by_energy - float(self.forces.sum())) / self.scales["force"],
        )

    def errors(self, state: Any) -> dict[str, float]:
        """As the difference from nodes further apart says, of second order; not known of few."""
        unknown, nodes = dict.fromkeys(QUANTITIES, float("inf")), self.nodes
        if self.n < _LEAST:
            return unknown
        worst, sizes = np.full(3, KNOWN), np.array([self.a, *self.scales.values()])
        for times in (2, 3):
            coarse = Nodes.of(nodes.body, times * nodes.spacing, 1 + (nodes.x.size - 1) // times)
            other = coarse.last(self.depth)
            if other is None or other < 1:
                return unknown
            found = NodeState(coarse, self.depth, other).found
            off = np.abs(np.subtract(found, self.found))
            worst = np.maximum(worst, _SAFE * off / (times**2 - 1) / sizes)
        worst[1:] = worst.max()  # by what a line moves they change as well
        if self.n < nodes.x.size - 1:
            worst[0] = max(worst[0], _LUCKY * worst[1])
        return (
            unknown if worst.max() > _COARSE else dict(zip(QUANTITIES, worst.tolist(), strict=True))
        )


def on_layer_nodes(scene: Scene, depth: float, spacing: float, *, branch: str) -> Equilibrium:
    """Certified state on the way from first touch, with its error estimate.

    ValueError where the contact reaches the end of a known profile, or has too many nodes.
    """
    body, count = Body(scene), _FIRST
    while True:
        nodes = Nodes.of(body, spacing, count)
        n, last = nodes.last(depth), nodes.x.size - 1
        if n is None:
            flat = Certificate.undeformed()
            return detached(scene, depth, branch, SmallSurfaces(scene), flat, spacing)
        if n == last or 0 <= n <= last - _SPARE:
            break
        if nodes.x.size < count or count >= _MOST:
            raise ValueError(
                f"depth = {depth!r} spreads the contact over the whole known profile, or more than "
                f"{_MOST} nodes; give a wider profile, a larger spacing, or a smaller depth"
            )
        count *= 2
    return certified(NodeState(nodes, depth, n), branch, spacing)
