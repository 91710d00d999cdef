"""Load paths: the quasi-static, rate-independent response to a programme, with its events.

The indenter starts out of contact, touches, and follows the programme; contact lines move downhill
in energy at once. Every step is cut at the events it meets, each located by root finding.

Depths d are positive downwards, forces if the indenter is pressed. A `Control` is what is imposed,
"depth", "force" or "drive" of a machine: control.value(d, P) is its value C at which a state is in
equilibrium, and `control.stiffness` is None under an imposed depth, 0 under a dead load, else K.

A `LoadPath` follows the programme: `go` records a `Point` (the contacts at a depth) for every
value, `resume` continues a path from its last state, and `History.extended` adds what was recorded.
`branch_of` chooses what has the states at imposed depths, whose `certify` raises NotCertifiedError
for a point that is no equilibrium. `usable_on_path` is whether nodes follow it, ValueError if
nothing can; `chosen_spacing` is the distance of the nodes where none is given. `resolution` and
`warn_coarse` are for nodes further apart than l. `History.unresolved` is a sentence on a pull-off
force that nodes do not resolve, "" if they do, and of its `validity`, one has the name "parts on
nodes" if a part could not be refined, with what follows, its `consequence`. `on_the_way_to` adds
the values that were given to errors on profiles that are not known far enough. `array` checks
numbers, `described` and `alike` compare scenes. `resolve(scene, depth)` is the profile with samples
`x` and heights `f`, as far as contact is possible at the depth; `measure(x)` is 1, about an axis
2πx; δ₀ = √(2w/k) is `critical_separation`, for contacts that open that of `opened`, and l is
`elastocapillary_length`.
"""

import math
import warnings

import numpy as np
from numpy.typing import ArrayLike

from discretization.certificate import AccuracyWarning
from discretization.nodes.choice import chosen_spacing
from discretization.paths.branch import Point
from discretization.paths.choice import branch_of
from discretization.paths.control import Control
from discretization.paths.history import History
from discretization.paths.load_path import LoadPath
from discretization.profile import on_the_way_to, resolve
from discretization.readings import resolution, warn_coarse
from discretization.routes import usable_on_path
from energy import Scene
from energy.arrays import Array
from energy.checks import array
from energy.description import alike, described

METHODS = ("auto", "fitted", "lattice")
# Of the thickness: the depth of indentation that is tried first where nothing adheres, and doubled
# until the force is large enough. Forces of less are none in practice.
_SHALLOW = 1e-12


def load_path(
    scene: Scene,
    *,
    depths: ArrayLike | None = None,
    forces: ArrayLike | None = None,
    drives: ArrayLike | None = None,
    machine_stiffness: float | None = None,
    method: str = "auto",
    spacing: float | None = None,
    rtol: float = 1e-8,
    after: History | None = None,
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
    method : {"auto", "fitted", "lattice"}
        Contact lines as unknowns, for any profile with any number of contacts; or fixed nodes, for
        small slopes with gamma1 > 0, around an axis for convex indenters: their force is
        interpolated between the nodes; their energy balance, that of contact sets, is exact.
        "auto": nodes if a spacing is given, or where only nodes can follow the scene; else
        "fitted".
    spacing : float, optional
        Distance of the nodes [length]; a little less where edges become nodes. By default
        "lattice" chooses it by the lengths on which the scene varies (nodes/choice.py).
    rtol : float
        Relative error of the exact response of a layer; the rest is good to rounding.
    after : History, optional
        Of the same scene and control, which this programme continues; the result's first part.

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
        Where the profile varies within the least distance at which events are sought; for nodes
        further apart than l, and where a contact of a few of them is lost at the pull-off force.

    Notes
    -----
    A path under imposed depth starts out of contact where the first depth is below touching, and by
    touching else; under force and machine control it starts at first touch. Without long-range
    attraction contact begins on touching, at d = min f.

    Under load control the indenter jumps to the next depth with the same P, under a machine of
    stiffness K to the next one with the same d + P/K: larger depths as the control rises, smaller
    ones as it falls. A jump is an event.

    Examples
    --------
    >>> from discretization import load_path
    >>> from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
    >>> layer, surfaces = ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(0.07, 6e-5)
    >>> path = load_path(Scene(layer, surfaces, Parabola(0.02)), depths=[0.0, 4e-7, -6e-7])
    >>> [(event.kind, f"{event.depth:.3g}") for event in path.events]
    [('jump-in', '0'), ('detachment', '-4.22e-07')]
    """
    on_nodes = usable_on_path(scene, rtol, method, METHODS, spacing)
    name, values = _programme(machine_stiffness, depths=depths, forces=forces, drives=drives)
    control_name = name.removesuffix("s")  # "depth", "force" or "drive"
    control = Control.of(control_name, machine_stiffness)
    if on_nodes and spacing is None and after is not None:
        spacing = after.spacing
    if on_nodes and spacing is None:
        spacing = chosen_spacing(scene, _deepest(scene, control, float(values.max())))
    warn_coarse(resolution(scene, spacing or math.nan), stacklevel=2)
    before = History(scene, control_name, machine_stiffness, rtol, spacing)  # of no steps
    if after is not None:
        _refuse_another(after, before)
        before = after
    largest = float(np.append(before.values, values).max())
    branch = branch_of(scene, rtol, spacing, lambda: _deepest(scene, control, largest))
    path = LoadPath(branch, control, Point(-math.inf, None))  # far above the layer
    if after is not None:
        path.resume(after.at(-1), len(after), float(after.values[-1]))
    with on_the_way_to(name, float(values[0]), float(values[-1])):
        path.go(values)
    branch.certify(path.point)
    history = before.extended(path, values)
    unrefined = [one for one in history.validity if one.name == "parts on nodes"]
    if unrefined:
        warnings.warn(unrefined[0].consequence, AccuracyWarning, stacklevel=2)
    unresolved = history.unresolved() if spacing else ""
    if unresolved:
        warnings.warn(unresolved, AccuracyWarning, stacklevel=2)
    return history


def _refuse_another(after: History, history: History) -> None:
    """Raise ValueError unless both paths have the same scene, control, tolerance and nodes.

    after: the path to continue; history: an empty one, of what is given now.
    """
    for name in ("control", "machine_stiffness", "rtol", "spacing", "scene"):
        given = getattr(history, name)
        known = getattr(after, name)
        if not alike(described(given), described(known)):
            raise ValueError(
                f"{name} = {given!r} differs from that of the path to continue, {known!r}; give "
                "the same"
            )


def _programme(machine_stiffness: float | None, **given: ArrayLike | None) -> tuple[str, Array]:
    """Name of the argument that is given, such as "depths", and its values (n,).

    Raises ValueError unless exactly one is given, as a list of finite numbers, with a stiffness of
    the machine if, and only if, it is drives.
    """
    named = {name: value for name, value in given.items() if value is not None}
    if len(named) != 1:
        raise ValueError(
            f"a load path needs exactly one of {', '.join(given)}; got {', '.join(named) or 'none'}"
        )
    ((name, raw),) = named.items()
    values = array(name, raw)
    if values.ndim != 1 or not values.size or not np.isfinite(values).all():
        raise ValueError(f"{name} = {raw!r} must be a list of at least one finite number")
    if (name == "drives") != (machine_stiffness is not None):
        raise ValueError(
            f"machine_stiffness = {machine_stiffness!r} with {name}: drives need a machine "
            "stiffness K > 0 [force/length per unit length of contact], other controls have none"
        )
    return name, values


def _deepest(scene: Scene, control: Control, deepest: float) -> float:
    """A depth that is not exceeded by values of the control up to `deepest` [length].

    Under imposed depth it is `deepest` itself. Under a load or a machine depths of indentation grow
    twofold (from δ₀), or fourfold (from next to none), until the force is certainly enough, or the
    known profile ends.
    """
    if control.stiffness is None:
        return deepest
    touch = resolve(scene, 0.0).touch
    reach = scene.opened.critical_separation
    if reach:
        pressed = reach
        factor = 2.0
    else:
        pressed = _SHALLOW * scene.layer.h
        factor = 4.0
    try:
        while control.value(touch + pressed, _least_force(scene, touch + pressed)) < deepest:
            pressed *= factor
    except ValueError:  # beyond the known profile: the depth that was tried before
        pressed /= factor
    return touch + pressed


def _least_force(scene: Scene, depth: float) -> float:
    """A lower bound of the force at a depth to which a contact is pressed, halved for safety.

    k∫u dx with the least u there may be: between the outermost lines no surface is lower than the
    indenter or δ₀ above the undeformed one, and beside them it is pulled up by δ₀ at most, over l.
    Half of that allows for the trapezoidal rule, by which it is summed between samples.
    """
    profile = resolve(scene, depth)
    length = scene.elastocapillary_length
    reach = scene.opened.critical_separation
    g = depth - profile.f
    first, last = np.flatnonzero(g >= -reach)[[0, -1]]
    x = profile.x[first : last + 1]
    u = np.maximum(g[first : last + 1], -reach)
    outermost = np.abs(x[[0, -1]]) + length
    pulled = reach * length * scene.measure(outermost).sum()
    integrand = u * scene.measure(x)
    pressed = (integrand[1:] + integrand[:-1]) @ np.diff(x) / 2
    return scene.stiffness * float(pressed - pulled) / 2
