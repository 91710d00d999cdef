"""Which branch follows the load paths of a scene."""

from __future__ import annotations

import contextlib
import functools
from collections.abc import Callable

import numpy as np

from discretization.paths.branch import Branch, moved
from discretization.paths.control import Control
from discretization.paths.fitted_many import FittedMany
from discretization.paths.lattice_branch import LatticeBranch
from discretization.paths.springs_branch import SpringsBranch
from discretization.profile import resolve
from discretization.routes import route
from energy import Scene

_SHALLOW = 1e-12  # of the thickness: the first depth that is tried
_DEEPER = 4.0  # times as deep: the next one
_LESS, _TURNS = 0.95, 60  # of the depth: what is tried where the profile is not known so far


def branch_of(scene: Scene, rtol: float, spacing: float | None, deepest: float) -> Branch:
    """The branch for depths up to the deepest, on nodes if there is a spacing."""
    if spacing is not None:
        return LatticeBranch.of(scene, spacing, deepest)
    if route(scene, "path", nodes=False) == "springs":
        return SpringsBranch.of(scene, rtol, deepest)
    return FittedMany.of(scene, deepest)


def branch_for(
    scene: Scene, control: Control, rtol: float, spacing: float | None, deepest: float
) -> Branch:
    """The branch for values of the control up to `deepest`.

    Of a load or a machine it is that for depths down to one at which the force is enough, or to one
    at which it has left the known profile: the programme may end before that.
    """
    made = functools.partial(branch_of, scene, rtol, spacing)
    if control.stiffness is None:
        return made(deepest)

    def enough(depth: float, force: float) -> bool:
        return bool(control.value(depth, force) >= deepest)

    if scene.work_of_adhesion == 0 or scene.gamma1 == 0:
        touch = resolve(scene, 0.0).touch
        room = _resisting(scene, touch, enough)
        for turn in range(_TURNS):  # as far as the profile is known
            with contextlib.suppress(ValueError):
                return made(touch + room * _LESS**turn)
        return made(touch + room * _LESS**_TURNS)
    depth, size = 0.0, scene.opened.critical_separation
    while True:
        branch = made(depth)
        depth = max(depth, branch.touch)
        try:
            force = branch.force(moved(branch, branch.first, depth))
            deeper = branch.touch + (2 * (depth - branch.touch) or size)
            if enough(depth, force):
                return made(deeper + size) if isinstance(branch, LatticeBranch) else branch
        except ValueError:
            return branch
        depth = deeper


def _resisting(scene: Scene, touch: float, enough: Callable[[float, float], bool]) -> float:
    """How far below touching the springs below the profile alone resist enough.

    While the contact is pressed nothing pulls without adhesion, or without tension, so that
    P >= k ∫ max(d - f, 0) dx; the trapezoidal rule, as the depth is only a bound.
    """
    above = _SHALLOW * scene.layer.h
    while True:
        profile = resolve(scene, touch + above)
        pressed = np.maximum(touch + above - profile.f, 0.0) * scene.measure(profile.x)
        area = float((pressed[1:] + pressed[:-1]) @ np.diff(profile.x)) / 2
        if enough(touch + above, scene.stiffness * area / 2):
            return 2 * above
        above *= _DEEPER
