"""States of one contact of a layer on nodes: which contact, its certificate and error estimate."""

from __future__ import annotations

import functools
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium, detached
from discretization.layer.body import lowest
from discretization.layer.nodes import KNOWN, Nodes, compliance
from discretization.surfaces.protocol import At, alone
from discretization.surfaces.small import SmallSurfaces
from energy import Scene, SurfaceEnergies

Array = NDArray[np.float64]
_FIRST, _MOST = 32, 4096  # nodes on each side that are tried
_SPARE = 4  # links beyond the line, for polynomials
_LEAST = 8  # nodes of a contact whose error is known
_CLEAR = 64  # places beside a contact at which the surface is compared with the indenter
_SAFE = 4.0  # times the difference of two spacings
_COARSE = 0.05  # relative errors that are no small ones: nodes do not resolve the free surface
_STEP = 1e-2  # of γ₁: a difference as good as the nodes
_LUCKY = 0.05  # of the errors of force and energy: where half-widths happen to agree


@dataclass(frozen=True, eq=False)
class NodeFields:
    """The surface of a layer held down at nodes, and the forces there.

    a: where the line is between node n and the next; all that is asked is interpolated between the
    contacts that end at these, moved sideways to the line.
    """

    nodes: Nodes
    depth: float
    n: int
    a: float

    @functools.cached_property
    def _ends(self) -> list[tuple[int, float]]:
        """The outermost nodes of both contacts, and their shares."""
        last = self.nodes.x.size - 1
        i = min(max(int(np.searchsorted(self.nodes.x, self.a, side="right")) - 1, 0), last)
        part = (self.a - float(self.nodes.x[i])) / self.nodes.spacing if i < last else 0.0
        return [(i, 1 - part), *([(i + 1, part)] if part > 0 else [])]

    def beside(self, distance: Array) -> Array:
        """u so far beside the line."""
        found, x = np.zeros(distance.size), self.nodes.x
        places = np.concatenate([x[n] + distance for n, _ in self._ends])
        response = compliance(self.nodes.scene, places, x).reshape(-1, distance.size, x.size)
        for each, (n, share) in zip(response, self._ends, strict=True):
            found += share * (each[:, : n + 1] @ self.nodes.forces(self.depth, n))
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
        scene, first = self.nodes.scene, int(self.nodes.scene.axisymmetric)
        own, apex, step = self.nodes.x[first : self.n], self.nodes.apex, self.nodes.spacing / 2
        share = scene.measure(own) * self.nodes.spacing * (1 if scene.axisymmetric else 2)
        share = np.where((own == 0) & (not scene.axisymmetric), share / 2, share)
        rise = scene.indenter.slope(apex + own + np.array([[-step], [step]]))
        bend = np.diff(rise, axis=0)[0] / (2 * step)
        if scene.axisymmetric:
            bend += rise.mean(axis=0) / own
        force = self.nodes.forces(self.depth, self.n)[first:-1]
        return np.interp(np.abs(x - apex), own, force / share - scene.gamma1 * bend)

    def parts(self, state: Any) -> dict[str, float]:
        """As readings.parts_of, with what is stored in the layer for the springs.

        The energy of the surface is γ₁ ∂U/∂γ₁, as the displacements are those of least energy.
        """
        scene, surface = self.nodes.scene, self._stretched()
        adhesion = -scene.work_of_adhesion * state.contact_area
        lines = -scene.gamma1 * float((state.line_slopes[1] * scene.measure(state.contacts)).sum())
        return {
            "springs": float(state.energy - adhesion - surface),
            "surface": surface,
            "adhesion": adhesion,
            "pressure": state.force - lines,
            "lines": lines,
        }

    def _stretched(self) -> float:
        """γ₁ ∂U/∂γ₁ = -γ₁/2 F (∂C/∂γ₁) F, by a difference, between the nodes as all else."""
        scene, x = self.nodes.scene, self.nodes.x[: self._ends[-1][0] + 1]
        tensions = (part * scene.gamma1 for part in (1 - _STEP, 1 + _STEP))
        scenes = (replace(scene, surfaces=SurfaceEnergies.from_work(t, 0.0)) for t in tensions)
        less, more = (compliance(each, x, x) for each in scenes)
        found = 0.0
        for n, share in self._ends:
            force, own = self.nodes.forces(self.depth, n), slice(n + 1)
            found += share * float(force @ (less - more)[own, own] @ force) / (4 * _STEP)
        return found


def on_layer_nodes(scene: Scene, depth: float, spacing: float, *, branch: str) -> Equilibrium:
    """Certified state on the way from first touch, with its error estimate.

    ValueError where the contact reaches the end of a known profile, or has too many nodes.
    """
    touch, count = float(scene.indenter.height(lowest(scene))), _FIRST
    while True:
        nodes = Nodes.of(scene, spacing, count)
        n = nodes.last(depth, touch)
        if n is None:
            flat = Certificate.undeformed()
            return detached(scene, depth, branch, SmallSurfaces(scene), flat, spacing)
        if n == nodes.x.size - 1 or 0 <= n <= nodes.x.size - 1 - _SPARE:
            return _state(nodes, depth, n, branch, touch)
        if nodes.x.size < count or count >= _MOST:
            raise ValueError(
                f"depth = {depth!r} spreads the contact over the whole known profile, or more than "
                f"{_MOST} nodes; give a wider profile, a larger spacing, or a smaller depth"
            )
        count *= 2


def _state(nodes: Nodes, depth: float, n: int, branch: str, touch: float) -> Equilibrium:
    scene, pinned = nodes.scene, n == nodes.x.size - 1
    a, force, energy = nodes.found(depth, n)
    apex = nodes.apex
    fields = NodeFields(nodes, depth, n, a)
    forces, g = nodes.forces(depth, n), depth - scene.indenter.height(apex + nodes.x[: n + 1])
    bound = scene.work_of_adhesion * float(nodes.area[n])
    scales = {"force": float(np.abs(forces).sum()), "energy": float(forces @ g) / 2 + bound}
    certificate = _certify(nodes, depth, n, fields, forces, g, scales["force"])
    certificate.demand(f"the state at depth = {depth!r}", "use another spacing, or depth")
    x = apex + np.array([[0.0 if scene.axisymmetric else -a, a]])
    raw = float(nodes.x[n])
    return Equilibrium(
        scene,
        depth,
        branch,
        "lattice",
        certificate,
        fields,
        nodes.spacing,
        contacts=x,
        nodes=apex + np.array([[0.0 if scene.axisymmetric else -raw, raw]]),
        pinned=np.array([[pinned or scene.axisymmetric, pinned]]),
        force=force,
        energy=energy,
        scales=scales,
        errors=_errors(nodes, depth, n, touch, (a, force, energy), scales),
    )


def _certify(
    nodes: Nodes, depth: float, n: int, fields: NodeFields, forces: Array, g: Array, scale: float
) -> Certificate:
    """The conditions of ../certificate.py, judged by the displacements that the forces give."""
    scene, x = nodes.scene, nodes.x[: n + 1]
    size = float(np.abs(g).max()) or 1.0
    own = nodes.lower[: n + 1, : n + 1]
    off = own @ (own.T @ forces) - g
    beyond = nodes.x[n + 1 :]
    reach = np.linspace(float(x[-1]), 2 * float(nodes.x[-1]), _CLEAR)[1:]
    places = np.union1d(beyond, reach[reach <= scene.indenter.extent[1]])
    through = 0.0
    if places.size:
        u = compliance(scene, places, x) @ forces
        through = float((depth - scene.indenter.height(nodes.apex + places) - u).max())
    rests, links = nodes.rest_depths, np.array([0.0])
    if n < nodes.x.size - 1:
        links = np.append(links, depth - rests[n])
    if n:
        links = np.append(links, rests[n - 1] - depth)
    pulled = 0.0 if scene.work_of_adhesion else max(0.0, -float(forces.min()) / scale)
    y = nodes.start + depth * nodes.rate
    load = float((y * nodes.rate)[: n + 1].sum())
    return Certificate(
        max(0.0, through) / size if not scene.work_of_adhesion or through > 0 else 0.0,
        float(np.abs(off).max()) / size,
        pulled,
        float(links.max()) / size,
        abs(load - float(forces.sum())) / scale,
    )


def _errors(
    nodes: Nodes,
    depth: float,
    n: int,
    touch: float,
    found: tuple[float, float, float],
    scales: dict[str, float],
) -> dict[str, float]:
    """As the difference from every other node says, of second order; not known of few nodes."""
    if n < _LEAST:
        return dict.fromkeys(QUANTITIES, float("inf"))
    worst, sizes = np.full(3, KNOWN), np.array([found[0], scales["force"], scales["energy"]])
    for times in (2, 3):
        coarse = nodes.coarser(times)
        other = coarse.last(depth, touch)
        if other is None or other < 1:
            return dict.fromkeys(QUANTITIES, float("inf"))
        off = np.abs(np.subtract(coarse.found(depth, other), found)) / (times**2 - 1)
        worst = np.maximum(worst, _SAFE * off / sizes)
    worst[1:] = worst.max()  # by what a line moves they change as well
    if n < nodes.x.size - 1:
        worst[0] = max(worst[0], _LUCKY * worst[1])
    if worst.max() > _COARSE:
        return dict.fromkeys(QUANTITIES, float("inf"))
    return dict(zip(QUANTITIES, worst.tolist(), strict=True))
