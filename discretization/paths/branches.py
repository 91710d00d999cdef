"""Which branch follows the load paths of a scene."""

from __future__ import annotations

from collections.abc import Callable

from discretization.paths.branch import Branch
from discretization.paths.fitted_branch import FittedBranch
from discretization.paths.fitted_many import FittedMany
from discretization.paths.lattice_branch import LatticeBranch
from discretization.paths.springs_branch import SpringsBranch
from discretization.routes import route
from energy import Scene

_ON_MESH: dict[str, type[FittedBranch | SpringsBranch | FittedMany]] = {
    "one contact": FittedBranch,
    "springs": SpringsBranch,
    "several contacts": FittedMany,
}


def branch_of(scene: Scene, rtol: float, spacing: float | None, deepest: float) -> Branch:
    """The branch for depths up to the deepest, on nodes if there is a spacing."""
    if spacing is not None:
        return LatticeBranch.of(scene, spacing, deepest)
    return _ON_MESH[route(scene, "path", nodes=False)].of(scene, rtol, deepest)


def pressed_by(made: Callable[[float], Branch], enough: Callable[[float, float], bool]) -> Branch:
    """The branch `made` for depths down to one at which the force is enough for the programme.

    Or to one at which it has left the known profile: the programme may end before that.
    """
    depth = 0.0
    while True:
        branch = made(depth)
        if isinstance(branch, FittedBranch):
            return branch
        size = branch.scene.opened.critical_separation or branch.scene.layer.h
        depth = max(depth, branch.touch)
        try:
            force = branch.force(branch.follow(None, depth), depth)
            deeper = branch.touch + (2 * (depth - branch.touch) or size)
            if enough(depth, force):
                return made(deeper + size) if isinstance(branch, LatticeBranch) else branch
        except ValueError:
            return branch
        depth = deeper
