"""Equilibria on a lattice: contact set, certificate, contact lines between the nodes."""

from __future__ import annotations

import functools
import math
from dataclasses import replace

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.lattice.accuracy import estimated
from discretization.lattice.assembly import Question
from discretization.lattice.ground import Ground
from discretization.lattice.lowest import on_lowest
from discretization.lattice.nodes import Lattice
from discretization.lattice.path_state import on_one_contact, on_path
from discretization.lattice.springs import on_springs
from discretization.lattice.unseen import Unseen, looked_at, unseen
from discretization.routes import question_of, route
from energy import Plane, Scene

ON_NODES = {
    "one contact": on_one_contact,
    "path": on_path,
    "springs": on_springs,
    "lowest": on_lowest,
    "rings": on_lowest,
}


def on_lattice(
    scene: Scene,
    depth: float,
    spacing: float,
    *,
    branch: str = "adhered",
    origin: float | None = None,
    method: str = "lattice",
) -> Equilibrium:
    """Certified equilibrium at an imposed depth on nodes `spacing` apart, one of them on `origin`.

    min U[u] s.t. u_i >= d - f(x_i), U that of `NodalEnergy`; a, P and U are interpolated between
    the nodes. branch, and method "lattice", "shortest_path" or "oracle", are those of `minimise`,
    which looks at its arguments first; origin: by default that of `Lattice.of`.

    ValueError for a spacing too large for the body, and for a contact that would leave the profile;
    NotCertifiedError if no equilibrium was found.
    """
    lattice = Lattice.of(scene, spacing, origin)
    if isinstance(scene.indenter, Plane):
        if method != "lattice":
            raise ValueError(f"method = {method!r} needs an end to the plane: use 'lattice'")
        return _plane(scene, depth, branch, lattice)
    asked = Question(lattice.seen(scene), depth, branch, method)
    ground = Ground.of(lattice, asked.scene.indenter, depth)
    state = ON_NODES[route(scene, question_of(method, branch), nodes=True)](asked, ground)
    return replace(state, scene=scene, errors=functools.partial(estimated, on_lattice))


def looked_at_on_lattice(
    scene: Scene, depth: float, spacing: float, *, branch: str, method: str
) -> Equilibrium:
    """`on_lattice`, looked at between the nodes: AccuracyWarning where they do not see enough."""
    state = on_lattice(scene, depth, spacing, branch=branch, method=method)
    lattice = Lattice.of(scene, spacing)
    hidden = unseen(lattice.seen(scene), depth, lattice)
    if not state.contacts.size and depth > hidden.touch:
        hidden = Unseen(np.array([hidden.lowest]), np.array([hidden.touch]), np.zeros(1))
    looked_at([state], hidden, lattice, stacklevel=3)
    return state


def _plane(scene: Scene, depth: float, branch: str, lattice: Lattice) -> Equilibrium:
    """The endless plane: every link is alike, so one link decides for all (case study 1)."""
    gap, cost, _ = map(float, lattice.advance(0.0, 0.0, depth))
    adheres = lattice.gamma1 or branch == "global" or depth < 0
    lift = max(abs(depth), scene.critical_separation) or 1.0
    apart = Certificate.undeformed(max(0.0, depth / lift))
    state = detached(scene, depth, branch, lattice.tail, apart, lattice.spacing)
    if gap > (lattice.critical_gap * (1 + 1e-12) if adheres else 0.0):
        return state
    if gap > 0:
        lattice.refuse_overhang(depth, depth)
    gain = max(0.0, cost) / (lattice.w * lattice.spacing) if gap > 0 else 0.0
    balanced = abs(cost) <= 1e-10 * lattice.w * lattice.spacing
    everywhere = np.array([[-math.inf, math.inf]])
    return replace(
        state,
        contacts=everywhere,
        nodes=everywhere,
        pinned=np.zeros((1, 2), bool),
        force=math.copysign(math.inf, depth) if depth else 0.0,
        energy=0.0 if balanced else math.copysign(math.inf, cost),
        neutral=gap > 0 and balanced,
        certificate=Certificate(0.0, 0.0, 0.0, gain, 0.0),
    )
