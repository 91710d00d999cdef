"""Equilibria on a lattice: which method finds the contacts, and the end of a path from first touch.

A convex profile has a single contact at any depth, which is found without following the path.

Conventions
-----------
Depths are positive down into the layer; P is positive if compressive; U is 0 for the flat surface
without contact. Contacts on nodes are `Contacts`, the first and last node of each in numbers of the
row, () if detached; `lines` are x between the nodes [length], the left and the right one of each
contact. "Lines that resist" stay where they are over a range of depths, as opening takes more than
closing: `scene.hysteretic`.

`route(scene, kind, nodes=True)` names the solver: "plain" one contact by `on_plain`, "lowest" all
contact sets by `on_lowest`, or "path" the walk from first touch (`Walk`). LOWEST are the methods
that ask for the second. `on_row` and `on_plain` make a `State`, contacts with displacements of the
nodes, None if detached; it has a `balance`, the energy, force and sizes of their terms on nodes, a
`certificate`, and `passed`, the changes as lines pass links beside them: arrays (1, 2m, 6) of one
state, 2m lines, and the links j = -3 ... 2 of `subgrid.LINKS`, outwards from the line's node.
`subgrid.between` has x of the lines, and what they add to U and P beyond the nodes;
`subgrid.moved` x of lines that resist. `detached` is the equilibrium without contact;
`refuse_turning` raises a ValueError where a surface of finite slope would turn over, at more than
the displacement `turning(lattice)`, `overhang` is its message, and `Row.refuse_unknown` does where
a contact reaches the end of the known profile. `warn_state` and `warn_unresolved` warn where states
depend on what lies between the nodes; `unseen` are such places.
"""

import functools
import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import Certificate
from discretization.equilibrium import Equilibrium, detached
from discretization.lattice import subgrid
from discretization.lattice.accuracy import estimated
from discretization.lattice.certificate import State, on_row
from discretization.lattice.lowest import on_lowest
from discretization.lattice.plain import SteepTail, on_plain, overhang, refuse_turning, turning
from discretization.lattice.unresolved import unseen, warn_state, warn_unresolved
from discretization.lattice.walk import Walk
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import Contacts, Row
from discretization.routes import LOWEST, route
from energy import Plane, Scene


class Ties(NamedTuple):
    """What counts as equal when a line, or a plane, may move at no cost.

    At a tenth or ten times its value each leaves the 6 or more random states and paths that read it
    as they are to 1e-9 (`plane` and `plane_stays` are not read there): `python -m tests.sensitivity
    discretization.lattice.state`.

    Attributes
    ----------
    depth : float
        Of δ₀: a line stays where both sides cost the same to this part of the depth.
    link : float
        Of wΔx: what a line may pay for a link if it rests anywhere at no cost.
    plane : float
        Of w: what an endless plane may cost that is taken for neutral,
    plane_stays : float
        and one that stays in contact: twice the part of the depth above, as the cost is its square.
    """

    depth: float = 1e-12
    link: float = 1e-10
    plane: float = 1e-10
    plane_stays: float = 2e-12


_TIES = Ties()


def on_lattice(
    scene: Scene,
    depth: float,
    spacing: float,
    *,
    branch: str = "adhered",
    origin: float | None = None,
    method: str = "lattice",
    row: Row | None = None,
    lattice: Lattice | None = None,
) -> Equilibrium:
    """The certified equilibrium at an imposed depth on nodes.

    min U[u] s.t. u_i >= d - f(x_i), U that of `NodalEnergy`; a, P and U are interpolated between
    the nodes.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    spacing : float
        Distance of the nodes [length].
    branch : {"adhered", "global"}
    origin : float, optional
        Where one node is [length]; by default as `Lattice.of` chooses.
    method : {"lattice", "shortest_path", "oracle"}
        As in `minimise`, which checks the arguments.
    row, lattice : optional
        Where they are known.

    Returns
    -------
    Equilibrium

    Raises
    ------
    ValueError
        If the spacing is too large for the body, or the contact leaves the known profile.
    NotCertifiedError
        If no equilibrium was found.
    """
    lattice = lattice or Lattice.of(scene, spacing, origin)
    if isinstance(scene.indenter, Plane):
        if method != "lattice":
            raise ValueError(f"method = {method!r} needs an end to the plane: use 'lattice'")
        return _plane(scene, depth, branch, lattice)
    chosen = route(scene, "search" if method in LOWEST else branch, nodes=True)
    row = row or Row.of(lattice.scene_on_nodes(scene), lattice, depth)
    state = on_route(row, depth, chosen, branch, method)
    return replace(state, scene=scene, errors=functools.partial(estimated, on_lattice))


def on_route(
    row: Row, depth: float, chosen: str, branch: str = "adhered", method: str = "lattice"
) -> Equilibrium:
    """The certified state that a solver finds on a row of nodes.

    Parameters
    ----------
    row : Row
    depth : float
        [length].
    chosen : {"plain", "lowest", "path"}
        The solver, as `route` names it.
    branch, method : str
        As of `on_lattice`.

    Returns
    -------
    Equilibrium

    Raises
    ------
    ValueError, NotCertifiedError
        As `on_lattice`.
    """
    scene = row.scene
    lines = None  # x of lines that resist, which the nodes do not give
    proof = None
    if chosen == "plain":
        found = on_plain(row, depth, branch)
    else:
        if chosen == "lowest":
            nodes, proof = on_lowest(row, depth, method)
            method = "shortest_path" if row.lattice.w and proof else method
        else:
            nodes, lines = on_path(row, depth)
        if nodes:
            row.refuse_unknown(depth, nodes)
        found = on_row(row, nodes, depth) if nodes else None
    # A solver that follows the path has not compared its state with that without contact.
    if found and branch == "global" and chosen != "lowest" and depth <= row.lowest:
        found = None if found.balance.energy > 0 else found
    if found is None:
        size = max(abs(depth), scene.critical_separation) or 1.0
        certificate = Certificate.undeformed(max(0.0, (depth - row.lowest) / size))
        observables: dict[str, Any] = {}
    else:
        certificate = found.certificate
        observables = _observables(found, lines)
    certificate.demand(
        f"the state found at depth = {depth!r}",
        "rounding has spoilt it, or the solver's tolerance, or a profile that is said to be convex "
        "is not; try another spacing or method",
    )
    lattice = row.lattice
    flat = detached(scene, depth, branch, lattice.tail, certificate, lattice.spacing)
    return replace(flat, method=method, proof=proof, **observables)


def _observables(found: State, known: subgrid.Lines | None) -> dict[str, Any]:
    """The fields in which an equilibrium with contacts differs from the flat surface.

    known: x of the lines if they resist, else None.
    """
    row = found.row
    lattice = row.lattice
    balance = found.balance
    nodes = np.reshape(found.nodes, (1, -1))
    before = None if known is None else np.array([known])
    depths = np.array([found.depth])
    lines, by_line = subgrid.between(row, nodes, depths, found.passed, before, found.work)
    added = by_line.sum(axis=-1)[:, 0]
    steep = not lattice.linear
    single = len(found.nodes) == 1
    if steep:
        refuse_turning(found, lines[0])
    contacts = lines.reshape(-1, 2)
    return {
        "contacts": contacts,
        "nodes": lattice.x(row.first + np.array(found.nodes)),
        "pinned": np.isin(contacts, row.scene.indenter.corners),
        "energy": balance.energy + float(added[0]),
        "force": balance.force + float(added[1]),
        "scales": {"force": balance.sizes, "energy": balance.scale},
        "surfaces": SteepTail(lattice.tail.rate, lattice) if steep else lattice.tail,
        "neutral": single and not row.scene.hysteretic and _neutral(found),
    }


def _neutral(found: State) -> bool:
    """Whether moving the right line of a single contact inwards by three links costs nothing."""
    row = found.row
    passed = found.passed
    inside = np.s_[0, -1, : -subgrid.LINKS[0]]  # of the right line the links j = -3 ... -1
    cost = passed.stored[inside] - row.works[0] * passed.bonds[inside]
    least = _TIES.link * row.lattice.w * row.lattice.cell  # wΔx, what a link gains by adhesion
    indifferent = (passed.gap[inside] > 0) & (np.abs(cost) <= least)
    return least > 0 and bool(indifferent.all())


def on_lattice_warning(scene: Scene, depth: float, spacing: float, **options: Any) -> Equilibrium:
    """The state of `on_lattice`, with an AccuracyWarning where the nodes do not resolve it.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    spacing : float
        Distance of the nodes [length].
    **options : Any
        Those of `on_lattice`.

    Returns
    -------
    Equilibrium

    Warns
    -----
    AccuracyWarning
        Where the nodes do not resolve the profile, or a contact.
    """
    lattice = Lattice.of(scene, spacing)
    state = on_lattice(scene, depth, spacing, lattice=lattice, **options)
    lowest = None
    if not scene.indenter.convex:
        places = unseen(
            lattice.scene_on_nodes(scene), depth, lattice, anywhere=not state.contacts.size
        )
        warn_unresolved([state], places, lattice, stacklevel=3)
        lowest = places.lowest
    warn_state(state, lattice, lowest, stacklevel=3)
    return state


def _plane(scene: Scene, depth: float, branch: str, lattice: Lattice) -> Equilibrium:
    """The endless plane: every link is alike, so one link decides for all (case study 1)."""
    work = lattice.w
    cost = lattice.k / 2 * depth**2 - work  # of contact, per area: u = d everywhere
    apart = Certificate.undeformed()
    state = detached(scene, depth, branch, lattice.tail, apart, lattice.spacing)
    if depth < 0 and cost > _TIES.plane_stays * work:
        return state
    if -depth > turning(lattice):  # by as much it has lifted the surface
        raise ValueError(overhang(depth, "", depth, turning(lattice)))
    gain = max(0.0, cost) / work if depth < 0 else 0.0
    balanced = abs(cost) <= _TIES.plane * work
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


def on_path(row: Row, depth: float) -> tuple[Contacts, subgrid.Lines | None]:
    """The contacts on the path from first touch on, and where lines that resist are.

    Parameters
    ----------
    row : Row
    depth : float
        [length].

    Returns
    -------
    nodes : Contacts
    lines : tuple of float, or None
        x of the lines if opening takes another work of adhesion than closing [length].

    Raises
    ------
    ValueError
        If a contact on the path reaches the end of the known profile.
    """
    deepest = max(depth, row.lowest)  # first touch, if the indenter is withdrawn from there
    walk = Walk(row)
    lines = None
    nodes = walk.touched(deepest)
    row.refuse_unknown(deepest, nodes)
    if row.scene.hysteretic:  # pressed, lines are where they close
        (lines,) = subgrid.moved(row, [nodes], np.array([deepest]), (), ())
    if depth < deepest:
        before = nodes
        tie = _TIES.depth * row.scene.opened.critical_separation
        nodes = walk.moved(nodes, deepest, depth + tie)
        if nodes and lines is not None:
            (lines,) = subgrid.moved(row, [nodes], np.array([depth]), before, lines)
    return nodes, lines
