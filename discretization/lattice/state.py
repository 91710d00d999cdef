"""Equilibria on a lattice: which method finds the contacts, and the end of a path from first touch.

Contacts of a convex profile are alone all the way, and found without following the path.
"""

import functools
import math
from dataclasses import replace

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.lattice import line
from discretization.lattice.accuracy import Unseen, estimated, looked_at, unseen
from discretization.lattice.assembly import Question, of_contacts, on_row
from discretization.lattice.judge import totals
from discretization.lattice.lowest import on_lowest
from discretization.lattice.plain import on_plain, overhang, turning
from discretization.lattice.walk import Walk
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Contacts, Row
from discretization.profile import resolve
from discretization.routes import question_of, route
from energy import Plane, Scene

_TIE = 1e-12  # of δ₀: a line stays where both sides cost the same


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
    answer = _ON_NODES[route(scene, question_of(method, branch), nodes=True)]
    state = answer(asked, Row.of(asked.scene, lattice, depth))
    return replace(state, scene=scene, errors=functools.partial(estimated, on_lattice))


def looked_at_on_lattice(
    scene: Scene, depth: float, spacing: float, *, branch: str, method: str
) -> Equilibrium:
    """`on_lattice`, looked at between the nodes: AccuracyWarning where they do not see enough."""
    state = on_lattice(scene, depth, spacing, branch=branch, method=method)
    lattice = Lattice.of(scene, spacing)
    seen = lattice.seen(scene)
    if state.contacts.size or scene.indenter.convex:
        hidden = unseen(seen, depth, lattice)
    else:  # anywhere
        profile = resolve(seen, depth)
        hidden = Unseen(*np.array([[profile.lowest], [profile.touch], [0.0]]))
    looked_at([state], hidden, lattice, stacklevel=3)
    return state


def _plane(scene: Scene, depth: float, branch: str, lattice: Lattice) -> Equilibrium:
    """The endless plane: every link is alike, so one link decides for all (case study 1)."""
    work, cost = lattice.w, lattice.k / 2 * depth**2 - lattice.w  # per area
    apart = Certificate.undeformed()
    state = detached(scene, depth, branch, lattice.tail, apart, lattice.spacing)
    if depth < 0 and cost > 2e-12 * work:
        return state
    if -depth > turning(lattice):
        raise ValueError(overhang(depth, "", depth, turning(lattice)))
    gain, balanced = max(0.0, cost) / work if depth < 0 else 0.0, abs(cost) <= 1e-10 * work
    everywhere = np.array([[-math.inf, math.inf]])
    return replace(
        state,
        contacts=everywhere,
        nodes=everywhere,
        pinned=np.zeros((1, 2), bool),
        force=math.copysign(math.inf, depth) if depth else 0.0,
        energy=0.0 if balanced else math.copysign(math.inf, cost),
        neutral=depth < 0 and balanced,
        certificate=apart._replace(neighbours=gain),
    )


def on_path(asked: Question, row: Row) -> Equilibrium:
    """The certified state of the contacts on this path; of one convex contact, or of least energy.

    NotCertifiedError and ValueError as `of_contacts`.
    """
    deepest, walk = max(asked.depth, row.lowest), Walk(row)
    nodes = walk.touched(deepest)
    row.refuse_unknown(deepest, nodes)
    way = [(deepest, nodes)]
    if asked.depth < deepest:
        tie = _TIE * asked.scene.opened.critical_separation
        nodes = walk.moved(nodes, deepest, asked.depth + tie)
        way.append((asked.depth, nodes))
    before: Contacts = ()
    known: line.Lines | None = None
    if nodes and asked.scene.hysteretic:  # where lines are depends on the way
        for depth, there in way:
            (known,) = line.moved(row, [there], np.array([depth]), before, known or ())
            before = there
    raised = nodes and asked.branch == "global" and asked.depth <= row.lowest
    if raised and totals(on_row(row, nodes, asked.depth)).energy > 0:
        nodes = ()
    return of_contacts(asked, row, nodes, known)


_ON_NODES = {"path": on_path, "plain": on_plain, "lowest": on_lowest}
