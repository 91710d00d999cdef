"""Load paths: the quasi-static, rate-independent response to a programme, with its events.

The indenter starts out of contact, touches, and follows the programme; contact lines move downhill
in energy at once. Every step is cut at the events it meets, each located by root finding. A load or
a machine is read off the path at imposed depths (paths/control.py).
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.paths.branch import Point
from discretization.paths.branches import branch_for
from discretization.paths.control import Control
from discretization.paths.history import History
from discretization.paths.load_path import LoadPath
from energy import Scene
from energy.checks import array, finite, option, positive
from energy.description import alike, described

Array = NDArray[np.float64]
DEPTH = Control(None)
METHODS = ("fitted", "lattice")


def load_path(
    scene: Scene,
    *,
    depths: ArrayLike | None = None,
    forces: ArrayLike | None = None,
    drives: ArrayLike | None = None,
    machine_stiffness: float | None = None,
    method: str = "fitted",
    spacing: float | None = None,
    rtol: float = 1e-8,
    after: History | None = None,
    save: str | Path | None = None,
    every: int = 100,
) -> History:
    """The response of a scene to a programme of imposed depths, forces, or drives of a machine.

    Exactly one of `depths` [length], `forces` [force/length] and `drives` [length] (n,) is given.
    machine_stiffness K [force/length²]: the indenter hangs on a spring whose far end is at the
    drive D, P = K (D - d). A path under imposed depth starts out of contact where the first depth
    is below touching, and by touching else; under force and machine control it starts at first
    touch. Without long-range attraction contact begins on touching, at d = min f. With C(d) the
    value of the control at which the state at a depth is in equilibrium, P(d) or d + P(d)/K, the
    indenter is where the running maximum of C on its way down first reaches a value that rises, and
    where the running minimum on its way up first reaches one that falls; it jumps where that is
    flat.

    method "fitted": contact lines as unknowns, for any profile with any number of contacts. Between
    two depths lines move smoothly if the energy changes by the work of the force; else an event is
    looked for, a contact that begins, meets another, closes or jumps, and enclosed to rounding, so
    that the energy balance closes. The profile is resolved first, as for `minimise`.
    "lattice": fixed nodes `spacing` apart: a line takes O(1) per link it passes; for any number of
    contacts of rough and measured profiles with many corners, with patterns and separate works of
    adhesion (small slopes, gamma1 > 0). A load is balanced by the force interpolated between the
    nodes; the energy balance is that of contact sets, and closes exactly.
    rtol: relative error asked of the fitted mesh's surfaces and integrals; the lattice has its
    spacing instead.
    after: a history of the same scene and control that this programme continues; it becomes the
    first part of the result. save: a file in which the history so far is kept, written anew every
    `every` steps and at the end; if it exists, it must hold the beginning of this very programme,
    and the path goes on from there, with the same result to the last bit as if it had not stopped.

    ValueError for an unusable programme or a scene that the method cannot follow;
    NotCertifiedError if a state is no equilibrium: the path never continues from one;
    AccuracyWarning where the profile varies within the least distance at which events are sought.
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene = {scene!r} is not a Scene; build one with energy.Scene(...)")
    name, values = _programme(depths=depths, forces=forces, drives=drives)
    control = _control(name, machine_stiffness)
    if not 0 < finite("rtol", rtol) < 1:
        raise ValueError(f"rtol = {rtol!r} is outside (0, 1); give a relative error such as 1e-8")
    if every != int(finite("every", every)) or every < 1:
        raise ValueError(f"every = {every!r} is no number of steps; give at least 1")
    option("method", method, METHODS)
    if (method == "lattice") != (spacing is not None):
        raise ValueError(f"spacing = {spacing!r} with method = {method!r}: a lattice needs one")
    spacing = None if spacing is None else positive("spacing", spacing)
    if save is not None and Path(save).exists():
        after = _begun(History.from_csv(save, scene), values, save)
        values = values[len(after.values) :]
    deepest = max([*values, *(after.depth if after is not None else ())])
    branch = branch_for(scene, control, rtol, spacing, float(deepest))
    path = LoadPath(branch, control, Point(-math.inf, None))
    history = History.empty(scene, name.removesuffix("s"), machine_stiffness, rtol, spacing)
    if after is not None:
        _same(after, history)
        _go_to_end(path, after)
        history = after
    return _followed(path, history, values, save, every)


def _followed(
    path: LoadPath, history: History, values: Array, save: str | Path | None, every: int
) -> History:
    """The history extended by these values, and kept in a file after so many of them each."""
    size = every if save is not None else values.size
    for start in range(0, values.size, size):
        part = values[start : start + size]
        path.go(part)
        path.branch.certify(path.point)
        history = history.extended(path.branch, part, *path.recorded())
        if save is not None:
            history.to_csv(save)
    return history


def _go_to_end(path: LoadPath, history: History) -> None:
    """Put a path where this one ended."""
    last = history.at(-1)
    path.step, path.value = len(history.values), float(history.values[-1])
    path.point = path.branch.contact(last.depth, *last.lines)
    path.pinned = path.branch.pinned(path.point)


def _begun(saved: History, values: Array, save: str | Path) -> History:
    if not np.array_equal(saved.values, values[: saved.values.size]):
        raise ValueError(
            f"save = {str(save)!r} holds another programme than this one begins with; give another "
            "file, or the same programme"
        )
    return saved


def _same(after: History, history: History) -> None:
    for name in ("control", "machine_stiffness", "rtol", "spacing"):
        if getattr(after, name) != getattr(history, name):
            raise ValueError(
                f"{name} = {getattr(history, name)!r} differs from that of the path to continue, "
                f"{getattr(after, name)!r}; give the same"
            )
    if not alike(described(after.scene), described(history.scene)):
        raise ValueError(
            f"scene = {history.scene!r} is not that of the path to continue; give the same"
        )


def _programme(**given: ArrayLike | None) -> tuple[str, Array]:
    """Name of the control and its values. ValueError unless one is given, finite, not empty."""
    named = {name: value for name, value in given.items() if value is not None}
    if len(named) != 1:
        raise ValueError(
            f"a load path needs exactly one of {', '.join(given)}; got {', '.join(named) or 'none'}"
        )
    (name, raw), *_ = named.items()
    values = array(name, raw)
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise ValueError(f"{name} = {raw!r} must be a list of at least one finite number")
    return name, values


def _control(name: str, machine_stiffness: float | None) -> Control:
    if name == "drives" and machine_stiffness is not None:
        return Control(positive("machine_stiffness", machine_stiffness))
    if name == "drives" or machine_stiffness is not None:
        raise ValueError(
            f"machine_stiffness = {machine_stiffness!r} with {name}: drives need a machine "
            "stiffness K > 0 [force/length per unit length of contact], other controls have none"
        )
    return DEPTH if name == "depths" else Control(0.0)
