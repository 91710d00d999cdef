"""Which branch follows the load path of a scene.

A branch is the family of states at imposed depths, from which paths under any control are read
(branch.py). Depths are positive down into the layer.

`route` names the solver of a scene: "layer" for one contact of a layer with its exact response
(`LayerBranch`), "springs" without surface tension (`SpringsBranch`), and others for contact lines
on the fitted mesh. `refinable` is whether the paths of several contacts of a line contact are found
on nodes and then refined (`RefinedBranch`); otherwise one contact is followed on the mesh
(`OneContactBranch`), up to where a second one begins. `LatticeBranch` follows any number of
contacts on nodes.
"""

from __future__ import annotations

from collections.abc import Callable

from discretization.paths.branch import Branch
from discretization.paths.lattice_branch import LatticeBranch
from discretization.paths.layer_branch import LayerBranch
from discretization.paths.one_contact import OneContactBranch
from discretization.paths.refined_branch import RefinedBranch
from discretization.paths.springs import SpringsBranch
from discretization.routes import refinable, route
from energy import Scene


def branch_of(
    scene: Scene, rtol: float, spacing: float | None, deepest: Callable[[], float]
) -> Branch:
    """The branch of a scene under imposed depths.

    Parameters
    ----------
    scene : Scene
    rtol : float
        Relative error of the exact response of a layer.
    spacing : float or None
        Of nodes, None for the fitted mesh [length].
    deepest : callable
        Finds the largest depth of the programme, where the branch has to know it [length].

    Returns
    -------
    Branch

    Raises
    ------
    ValueError
        If the profile is not known as far as the path reaches.
    """
    if spacing is not None:
        return LatticeBranch.of(scene, spacing, deepest())
    chosen = route(scene, "path", nodes=False)
    if chosen == "layer":
        return LayerBranch(scene, rtol)
    if chosen == "springs":
        return SpringsBranch.of(scene, deepest())
    if refinable(scene):
        return RefinedBranch.of(scene, deepest())
    return OneContactBranch.of(scene, deepest())
