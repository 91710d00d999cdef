"""The equilibrium of a scene at a depth, by the cheapest method that supports it.

Conventions
-----------
The depth d is positive down into the layer, forces if the indenter is pressed. `usable` checks the
arguments and returns the spacing, None for the fitted mesh; `route` names the solver of a scene:
"one contact", "refined contacts" (found on nodes), "several contacts" or "springs" on the mesh,
"layer" for a layer with its exact response, and "plane" for a plane without end, whose nodes all
have the same state, so that any spacing does: l, δ₀ (`critical_separation`) or h, the first that is
not 0. Methods in LOWEST search for the lowest contacts on nodes. What solvers find is certified, or
they raise NotCertifiedError: `on_one_contact`, `on_refined_nodes`, `on_several` and `on_springs` on
the mesh; on nodes `on_lattice`, and `on_lattice_warning`, which warns of features between the
nodes; of layers `on_layer` and `on_layer_nodes`. `error_estimate` are their relative errors by
name. `resolution` and `warn_coarse` are for nodes further apart than l; `on_the_way_to` adds the
depth that was given to errors on profiles that are not known far enough; `option` raises ValueError
for a word that is not known.
"""

import warnings

from discretization.certificate import AccuracyWarning
from discretization.equilibrium import Equilibrium
from discretization.fitted.states import on_one_contact, on_several
from discretization.lattice.state import on_lattice, on_lattice_warning
from discretization.layer.nodes import on_layer_nodes
from discretization.layer.state import on_layer
from discretization.paths.springs import on_springs
from discretization.profile import on_the_way_to
from discretization.readings import resolution, warn_coarse
from discretization.refine.states import on_refined_nodes
from discretization.routes import LOWEST, route, usable
from energy import Scene
from energy.checks import finite, option

METHODS = ("auto", "lattice", "fitted", "shortest_path", "oracle")
BRANCHES = ("adhered", "global")
ON_MESH = {
    "one contact": on_one_contact,
    "refined contacts": on_refined_nodes,
    "several contacts": on_several,
    "springs": on_springs,
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
    """Equilibrium of the scene at an imposed depth.

    Parameters
    ----------
    scene : Scene
        Layer, surfaces and indenter.
    depth : float
        d [length]: of the level f = 0 of the profile below the undeformed surface; negative: above.
    method : {"auto", "fitted", "lattice", "shortest_path", "oracle"}
        "fitted": a mesh anchored at the contact lines, accurate to rounding times the problem's
        condition; any number of contacts. "global": small slopes only; a lattice supplies the
        contacts. "lattice": fixed nodes, accurate to O(spacing²); of "global" the minimum over all
        contact sets of these nodes (small slopes); with finite slopes, and without tension, states
        of one contact, around an axis one contact of a convex indenter with small slopes. "auto":
        "fitted", or "lattice" for "global" with a spacing.
        "shortest_path": "global" on the lattice with its `proof`. "oracle": the same by solvers of
        cvxpy, for checking; with w > 0 for at most 100 nodes, and with the test extra.
    branch : {"adhered", "global"}
        The state of the quasi-static path that touches first and then moves to this depth; or the
        lowest energy of all states, detached included. For w = 0 and for γ₁ = 0 no path matters.
    spacing : float, optional
        Distance of the nodes [length], well below l and the contact; less where edges become nodes.
    rtol : float
        Largest estimated relative error on the fitted mesh without a warning; for the exact
        response of a layer also the one aimed at.

    Returns
    -------
    Equilibrium
        The certified state, with force, contacts, angle, fields, errors and `warnings`.

    Raises
    ------
    ValueError
        For an unusable argument or a depth at which the contact would leave the profile.
    NotCertifiedError
        If no equilibrium was found.

    Warns
    -----
    AccuracyWarning
        If the error estimate stays above rtol on the fitted mesh; if nodes are further apart than
        l, or the surface between them misses a narrower feature of the profile. Other limits of
        the model and of the nodes are in the state's `warnings`.

    Notes
    -----
    min U[u] s.t. u >= d - f, with small slopes U = ∫ (k u²/2 + γ₁ u'²/2) dx - w (contact length).

    Examples
    --------
    >>> from discretization import minimise
    >>> from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
    >>> layer, surfaces = ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(0.07, 6e-5)
    >>> state = minimise(Scene(layer, surfaces, Parabola(0.02)), depth=0.3e-6)
    >>> print(f"a = {state.half_width:.6g} m, P = {state.force:.6g} N/m, {state.label}")
    a = 0.000160077 m, P = 0.0139554 N/m, global
    """
    if method == "auto" and branch == "global" and spacing is not None:
        method = "lattice"
    spacing = usable(scene, rtol, method, METHODS, spacing)
    depth = finite("depth", depth)
    option("branch", branch, BRANCHES)
    if method in LOWEST and branch != "global" and scene.work_of_adhesion:
        raise ValueError(
            f"branch = {branch!r} is not what method={method!r} finds: use branch='global'"
        )
    solver = route(scene, "search" if method in LOWEST else branch, nodes=spacing is not None)
    if spacing is not None:
        if solver == "layer":
            state = on_layer_nodes(scene, depth, spacing, branch=branch)
        else:
            state = on_lattice_warning(scene, depth, spacing, branch=branch, method=method)
        warn_coarse(() if solver == "plane" else resolution(scene, spacing), stacklevel=2)
        return state
    if solver == "plane":  # every spacing gives the same state
        any_length = scene.elastocapillary_length or scene.critical_separation or scene.layer.h
        return on_lattice(scene, depth, any_length, branch=branch)
    if solver == "layer":
        state = on_layer(scene, depth, branch=branch, rtol=rtol)
    else:
        with on_the_way_to("depth", depth):
            state = ON_MESH[solver](scene, depth, branch=branch)
    if max(state.error_estimate.values()) > rtol:
        warnings.warn(
            f"rtol = {rtol!r} not reached: estimated relative errors {state.error_estimate}; ask "
            "for a larger rtol",
            AccuracyWarning,
            stacklevel=2,
        )
    return state
