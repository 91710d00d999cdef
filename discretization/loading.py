"""Load paths: the quasi-static, rate-independent response to a programme, with its events.

The indenter starts out of contact, touches, and follows the programme; contact lines move downhill
in energy at once. Every step is cut at the events it meets, each located by root finding.
"""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.paths.branch import Point
from discretization.paths.control import Control
from discretization.paths.history import History, branch_of
from discretization.paths.load_path import LoadPath
from discretization.profile import resolve
from discretization.readings import resolution, tell
from discretization.routes import usable
from energy import Scene
from energy.checks import array, finite, positive
from energy.description import alike, described

Array = NDArray[np.float64]
METHODS = ("fitted", "lattice")
_SHALLOW = 1e-12  # of the thickness: the first depth that is tried where nothing adheres


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

    Parameters
    ----------
    scene : Scene
    depths, forces, drives : array_like (n,)
        Exactly one: depths [length], forces [force/length], or drives [length].
    machine_stiffness : float
        K [force/length²], with drives: the indenter hangs on a spring whose far end is at the drive
        D, P = K (D - d).
    method : {"fitted", "lattice"}
        Contact lines as unknowns, for any profile with any number of contacts; or fixed nodes, for
        small slopes with gamma1 > 0, around an axis for convex indenters: their force is
        interpolated between the nodes, their energy balance that of contact sets, which closes
        exactly.
    spacing : float
        Distance of the nodes [length], with "lattice".
    rtol : float
        Relative error asked of the exact response of a layer; the rest is good to rounding.
    after : History, optional
        Of the same scene and control, which this programme continues; the result's first part.
    save : path, optional
        A file in which the history so far is kept, written anew every `every` steps and at the end;
        if it exists, it must hold the beginning of this very programme, and the path goes on from
        there, with the same result to the last bit as if it had not stopped.
    every : int

    Returns
    -------
    History
        The certified states at all values, the events between them and the energy lost.

    Raises
    ------
    ValueError
        For an unusable programme or a scene that the method cannot follow.
    NotCertifiedError
        If a state is no equilibrium: the path never continues from one.

    Warns
    -----
    AccuracyWarning
        Where the profile varies within the least distance at which events are sought, and for
        nodes that are further apart than l.

    Notes
    -----
    A path under imposed depth starts out of contact where the first depth is below touching, and by
    touching else; under force and machine control it starts at first touch. Without long-range
    attraction contact begins on touching, at d = min f.

    A dead load is in equilibrium at depths where it is P(d), the drive of a machine where it is
    d + P(d)/K. As one of them rises, the indenter goes down from where it is to the first depth at
    which that number is as large, as it falls, up to the first one at which it is as small: a depth
    that changes by a jump on the way is an event.

    Examples
    --------
    >>> from discretization import load_path
    >>> from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
    >>> layer, surfaces = ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(0.07, 6e-5)
    >>> path = load_path(Scene(layer, surfaces, Parabola(0.02)), depths=[0.0, 4e-7, -6e-7])
    >>> [(event.kind, f"{event.depth:.3g}") for event in path.events]
    [('jump-in', '0'), ('detachment', '-4.22e-07')]
    """
    spacing = usable(scene, rtol, method, METHODS, spacing)
    name, values = _programme(depths=depths, forces=forces, drives=drives)
    control = _control(name, machine_stiffness)
    if every != int(finite("every", every)) or every < 1:
        raise ValueError(f"every = {every!r} is no number of steps; give at least 1")
    if spacing is not None:
        tell(resolution(scene, spacing, np.empty(0)), stacklevel=2)
    history = History(scene, name.removesuffix("s"), machine_stiffness, rtol, spacing)
    if save is not None and Path(save).exists():
        after = History.from_csv(save, scene)
        if not np.array_equal(after.values, values[: len(after)]):
            raise ValueError(
                f"save = {str(save)!r} holds another programme than this one begins with; give "
                "another file, or the same programme"
            )
        values = values[len(after) :]
    deepest = max([*values, *(after.values if after is not None else ())])
    branch = branch_of(scene, rtol, spacing, lambda: _deepest(scene, control, float(deepest)))
    path = LoadPath(branch, control, Point(-math.inf, None))
    if after is not None:
        _same(after, history)
        history = after
        path.resume(history.at(-1), len(history), float(history.values[-1]))
    size = every if save is not None else values.size
    for start in range(0, values.size, size):
        part = values[start : start + size]
        history = history.extended(branch, part, *path.go(part))
        branch.certify(path.point)
        if save is not None:
            history.to_csv(save)
    return history


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
    if (name == "drives") != (machine_stiffness is not None):
        raise ValueError(
            f"machine_stiffness = {machine_stiffness!r} with {name}: drives need a machine "
            "stiffness K > 0 [force/length per unit length of contact], other controls have none"
        )
    if machine_stiffness is not None:
        return Control(positive("machine_stiffness", machine_stiffness))
    return Control(None if name == "depths" else 0.0)


def _deepest(scene: Scene, control: Control, deepest: float) -> float:
    """A depth that is not reached by values of the control up to `deepest`.

    Of a load or a machine one at which the force is certainly enough, or the last one tried at
    which the profile is known.
    """
    if control.stiffness is None:
        return deepest
    touch, reach = resolve(scene, 0.0).touch, scene.opened.critical_separation
    below, deeper = (reach, 2.0) if reach else (_SHALLOW * scene.layer.h, 4.0)
    try:
        while control.value(touch + below, _least_force(scene, touch + below)) < deepest:
            below *= deeper
    except ValueError:
        below /= deeper
    return touch + below


def _least_force(scene: Scene, depth: float) -> float:
    """Half of what the springs resist at least at a depth to which a contact is pressed.

    No surface stands higher than δ₀ above the undeformed one, or the indenter, between the
    outermost contact lines or beside them, where it decays over l. By the trapezoidal rule, as the
    depth is only a bound.
    """
    profile, length = resolve(scene, depth), scene.elastocapillary_length
    reach, x, g = scene.opened.critical_separation, profile.x, depth - profile.f
    inside = np.flatnonzero(g >= -reach)
    own = slice(inside[0], inside[-1] + 1)
    u = np.maximum(g[own], -reach) * scene.measure(x[own])
    ends = np.abs(x[own][[0, -1]]) + length
    pressed = float((u[1:] + u[:-1]) @ np.diff(x[own])) / 2
    pulled = reach * length * float(scene.measure(ends).sum())
    return scene.stiffness * (pressed - pulled) / 2
