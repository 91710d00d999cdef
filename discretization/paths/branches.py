"""Which branch follows the load paths of a scene."""

from __future__ import annotations

import contextlib

import numpy as np

from discretization.paths.branch import Branch
from discretization.paths.control import Control
from discretization.paths.fitted_many import FittedMany
from discretization.paths.lattice_branch import LatticeBranch
from discretization.paths.springs_branch import SpringsBranch
from discretization.profile import resolve
from discretization.routes import route
from energy import Scene

_SHALLOW = 1e-12  # of the thickness: the first depth that is tried where nothing adheres
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

    Of a load or a machine it is that for depths down to twice one at which the force is certainly
    enough, or, where the profile is not known so far, as deep as it is.
    """
    if control.stiffness is None:
        return branch_of(scene, rtol, spacing, deepest)
    touch, below = resolve(scene, 0.0).touch, scene.opened.critical_separation
    below = below or _SHALLOW * scene.layer.h
    with contextlib.suppress(ValueError):
        while control.value(touch + below, _least_force(scene, touch + below)) < deepest:
            below *= _DEEPER
    for turn in range(_TURNS):
        with contextlib.suppress(ValueError):
            return branch_of(scene, rtol, spacing, touch + 2 * below * _LESS**turn)
    return branch_of(scene, rtol, spacing, touch + 2 * below * _LESS**_TURNS)


def _least_force(scene: Scene, depth: float) -> float:
    """Half of what the springs resist at least at a depth to which a contact is pressed.

    No surface stands higher than δ₀ above the undeformed one, or the indenter, between the
    outermost contact lines or beside them, where it decays over l. By the trapezoidal rule, as the
    depth is only a bound.
    """
    profile, reach, length = (
        resolve(scene, depth),
        scene.opened.critical_separation,
        scene.elastocapillary_length,
    )
    x, g = profile.x, depth - profile.f
    inside = np.flatnonzero(g >= -reach)
    own = slice(inside[0], inside[-1] + 1)
    u = np.maximum(g[own], -reach) * scene.measure(x[own])
    ends = x[own][[0, -1]] + (-length, length)
    pressed = float((u[1:] + u[:-1]) @ np.diff(x[own])) / 2
    pulled = reach * length * float(scene.measure(ends).sum())
    return scene.stiffness * (pressed - pulled) / 2
