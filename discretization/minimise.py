"""Find the equilibrium of a scene at a depth with the cheapest method that answers."""

from __future__ import annotations

import warnings

from discretization.certificate import AccuracyWarning
from discretization.equilibrium import Equilibrium
from discretization.fitted.several import on_several
from discretization.fitted.single import on_one_contact
from discretization.fitted.springs import on_springs
from discretization.lattice.state import looked_at_on_lattice, on_lattice
from discretization.layer.node_state import on_layer_nodes
from discretization.layer.state import on_layer
from discretization.routes import question_of, route, usable
from energy import Scene
from energy.checks import finite, option, positive

METHODS = ("auto", "lattice", "fitted", "shortest_path", "oracle")
ON_NODES = ("lattice", "shortest_path", "oracle")
LOWEST = ("shortest_path", "oracle")
BRANCHES = ("adhered", "global")
ON_MESH = {
    "one contact": on_one_contact,
    "several contacts": on_several,
    "springs": on_springs,
    "layer": on_layer,
}


def minimise(
    scene: Scene,
    depth: float,
    *,
    method: str = "auto",
    branch: str = "adhered",
    spacing: float | None = None,
    rtol: float = 1e-8,
) -> Equilibrium:
    """Equilibrium of the scene at an imposed depth: min U[u] s.t. u >= d - f.

    branch "adhered": the state of the quasi-static path that touches first and then moves to this
    depth, with several contacts followed from event to event; w = 0 is convex, and for γ₁ = 0
    springs are independent: nothing to follow there.
    "global": the lowest energy of all states, detached included.
    method "lattice": fixed nodes `spacing` apart, accurate to O(spacing²); of "global" it finds the
    minimum over all contact sets of these nodes (small slopes); with finite slopes, and without
    tension, it answers states of one contact, and around an axis those of one contact of a convex
    indenter with small slopes. "fitted": a mesh anchored at the contact lines, accurate to rounding
    times the problem's condition; where the profile is not convex with any number of contacts, of
    "global" for small slopes: a lattice finds the topology.
    "auto": "fitted", or "lattice" for "global" with a spacing. "shortest_path": "global" on the
    lattice with its `proof`. "oracle": the same by solvers of cvxpy, for checking; with w > 0 for
    at most 100 nodes, and with the test extra.

    ValueError for an unusable argument or a depth at which the contact would leave the profile;
    NotCertifiedError if no equilibrium was found; AccuracyWarning if the error estimate stays above
    rtol, or if the surface between the nodes misses a feature of the profile that is narrower than
    their distance.
    """
    usable(scene, rtol, method, METHODS)
    finite("depth", depth)
    option("branch", branch, BRANCHES)
    if method == "auto" and branch == "global" and spacing is not None:
        method = "lattice"
    if method in LOWEST and branch != "global" and scene.work_of_adhesion:
        raise ValueError(
            f"branch = {branch!r} is not what method={method!r} finds: use branch='global'"
        )
    if method in ON_NODES:
        way = route(scene, question_of(method, branch), nodes=True)
        if spacing is None:
            raise ValueError(f"spacing = None: method={method!r} needs the distance of its nodes")
        if way == "layer":
            spacing = positive("spacing", spacing)
            return on_layer_nodes(scene, float(depth), spacing, branch=branch)
        return looked_at_on_lattice(scene, float(depth), spacing, branch=branch, method=method)
    way = route(scene, branch, nodes=False)
    if spacing is not None:
        raise ValueError(f"spacing = {spacing!r} needs method='lattice'; {method!r} has no spacing")
    if way == "plane":
        return on_lattice(scene, float(depth), _any_length(scene), branch=branch)
    state = ON_MESH[way](scene, float(depth), branch=branch, rtol=rtol)
    if max(state.error_estimate.values()) > rtol:
        warnings.warn(
            f"rtol = {rtol!r} not reached: estimated relative errors {state.error_estimate}; ask "
            "for a larger rtol",
            AccuracyWarning,
            stacklevel=2,
        )
    return state


def _any_length(scene: Scene) -> float:
    """A length of the scene, for the endless plane: every spacing gives the same answer."""
    lengths = (scene.elastocapillary_length, scene.critical_separation, scene.layer.h)
    return next(length for length in lengths if length > 0)
