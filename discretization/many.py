"""Many states at once: equilibria of one contact for arrays of depths and surface energies.

What is computed with is flat: n states, the elements of the broadcast arguments in their order
(`States` with `depth`, `work` w, `gamma1` and `stiffness` k, each (n,)). Messages name a state by
its place in the shape of the result.

The depth d is positive down into the layer, the force if the indenter is pressed, as in
`Equilibria`. A `SingleContact` has the scene's apex, where the contact begins, its height, and the
free surfaces (`surfaces_of`); `lowest_point` finds the apex of a convex profile that does not say
it, from a length of the scene on: l, δ₀ (`critical_separation`) or h, the first that is not 0.
`solved` gives the `ManyStates` of all states, `put` fills a part of them in, `detached` are states
without contact; `lost` marks those whose contact leaves the profile or whose surface turns over,
and `off_half_width`, `off_force`, `off_energy` are absolute errors, by the names in QUANTITIES. A
residual above TOLERANCE is no equilibrium. `usable` and `vectorised` raise ValueError for scenes
that are not served; `on_one_contact` and `on_springs` find one state, for its message alone.
`finite`, `not_negative` and `positive` raise ValueError unless a number is that, or if it is beyond
LARGEST = 1e60 or, but for 0, below its inverse.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from discretization.certificate import TOLERANCE, NotCertifiedError
from discretization.equilibrium import QUANTITIES
from discretization.fitted.many_lines import States
from discretization.fitted.many_states import ManyStates, solved
from discretization.fitted.rest_depths import surfaces_of
from discretization.fitted.single_contact import SingleContact, lowest_point
from discretization.fitted.states import on_one_contact
from discretization.paths.springs import on_springs
from discretization.routes import usable, vectorised
from energy import Scene, SurfaceEnergies
from energy.arrays import Array, Mask
from energy.checks import LARGEST, array, finite, not_negative, positive

# States that are found together: what they need stays in the processor's cache, or, of the meshes
# of steep surfaces, which have 225 nodes each, in some ten megabytes.
_TOGETHER = {"small": 8192, "finite": 1024}


@dataclass(frozen=True, eq=False)
class Equilibria:
    """States of one contact for arrays of depths, works of adhesion, tensions and stiffnesses.

    Every field has the shape to which the arguments of `minimise_many` broadcast.

    Attributes
    ----------
    half_width : array
        a [length], the radius around an axis; 0 where there is no contact.
    force : array
        P [force/length], or [force] around an axis; positive if it presses.
    energy : array
        U [energy/length], or [energy] around an axis; 0 for the undeformed surface.
    contact_angle : array
        θ [rad], the mean over the contact lines, measured at the free surface found; nan without a
        contact line.
    in_contact : array of bool
        Whether the indenter touches.
    stable : array of bool
        Whether the force on every contact line drives it back where it is displaced, or a corner
        holds it; True without contact. False: the state rests on a fold, and is no minimum.
    residual : array
        Certificate: by how much the depth d violates that of rest, D >= d just outside of each
        contact line and D <= d just inside, over the terms of D. Rounding, if it is right.
    uncertainty : dict of arrays
        What half_width, force and energy may be off by: rounding times the condition of each.
    """

    half_width: Array
    force: Array
    energy: Array
    contact_angle: Array
    in_contact: Mask
    stable: Mask
    residual: Array
    uncertainty: dict[str, Array]

    def __repr__(self) -> str:
        """The shape of the arguments, and how many of the states are in contact."""
        return f"Equilibria(shape={self.force.shape}, in contact: {int(self.in_contact.sum())})"


def minimise_many(
    scene: Scene,
    depths: ArrayLike,
    *,
    w: ArrayLike | None = None,
    gamma1: ArrayLike | None = None,
    stiffness: ArrayLike | None = None,
) -> Equilibria:
    """Equilibria of one contact for arrays of depths and parameters, found together.

    They are the states that `minimise` finds one by one: those of the branch "adhered", of the path
    that touches first and then moves to the depth.

    Parameters
    ----------
    scene : Scene
        Of one contact: a convex indenter, turned about an axis a punch, wedge, parabola, power law
        or circle; with springs, and without `opening` and `pattern`.
    depths : array_like
        d [length].
    w, gamma1, stiffness : array_like, optional
        Work of adhesion w [energy/area], surface tension γ₁ [energy/area], and stiffness of the
        layer k = Ẽ/h [stress/length]; those of the scene where they are not given. They broadcast
        with the depths and with each other.

    Returns
    -------
    Equilibria
        Half-widths, forces, energies and angles, with their certificate.

    Raises
    ------
    ValueError
        For an unusable argument, a scene that may have several contacts, or a state whose contact
        would leave the profile, or whose surface would turn over; the message names the first.
    NotCertifiedError
        If a state is no equilibrium.

    Notes
    -----
    ∂U/∂a = 0 is solved for all states by bracketing and secants, as D(a) = d with the depth D at
    which the free surface on its mesh lets the line rest (discretization/surfaces).

    Examples
    --------
    >>> import numpy as np
    >>> from discretization import minimise_many
    >>> from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
    >>> layer, surfaces = ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(0.07, 6e-5)
    >>> scene = Scene(layer, surfaces, Parabola(0.02))
    >>> works = np.array([3e-5, 6e-5])
    >>> states = minimise_many(scene, [[0.0], [3e-7]], w=works)
    >>> print(np.array2string(states.half_width * 1e6, precision=2))
    [[ 99.56 120.16]
     [144.87 160.08]]
    """
    usable(scene, 0.5, "auto", ("auto",), None)
    vectorised(scene)
    given = {
        "depths": depths,
        "w": scene.work_of_adhesion if w is None else w,
        "gamma1": scene.gamma1 if gamma1 is None else gamma1,
        "stiffness": scene.stiffness if stiffness is None else stiffness,
    }
    values = {name: _checked(name, value) for name, value in given.items()}
    shape = _shape(values)
    states = States(*(np.broadcast_to(value, shape).ravel() for value in values.values()))
    if scene.slopes == "finite":
        _check_angles(states, shape)
    found = _found(scene, states, shape)
    arrays: dict[str, Any] = {n: v.reshape(shape) for n, v in found._asdict().items()}
    del arrays["lost"]  # such states have been refused
    uncertainty = {name: arrays.pop(f"off_{name}") for name in QUANTITIES}
    return Equilibria(**arrays, uncertainty=uncertainty)


# What each argument has to be: functions of a name and a number that raise ValueError unless it is.
_CHECKS: dict[str, Callable[[str, float], float]] = {
    "depths": finite,
    "w": not_negative,
    "gamma1": not_negative,
    "stiffness": positive,
}


def _checked(name: str, given: Any) -> Array:
    """An array of numbers that can be computed with. ValueError names the first that cannot.

    All are tested at once by what `_CHECKS` demands of one, and the first that fails is given to
    that for its message.
    """
    values = array(name, given)
    check = _CHECKS[name]
    wrong = ~np.isfinite(values)
    if check is not finite:
        wrong |= (values < 1 / LARGEST) & (values != 0)
    if check is positive:
        wrong |= values == 0
    if wrong.any():
        place = np.unravel_index(int(wrong.argmax()), values.shape)
        check(name + _index(place), float(values[place]))
    return values


def _index(place: tuple[Any, ...]) -> str:
    """The place in an array as it is written in Python, "" for a single number."""
    return f"[{', '.join(str(int(i)) for i in place)}]" if place else ""


def _shape(values: dict[str, Array]) -> tuple[int, ...]:
    """The shape to which the arguments broadcast. ValueError if they do not."""
    try:
        return np.broadcast_shapes(*(value.shape for value in values.values()))
    except ValueError:
        shapes = ", ".join(f"{name} {value.shape}" for name, value in values.items())
        raise ValueError(
            f"the arguments have shapes that do not broadcast: {shapes}; give numbers, arrays of "
            "one shape, or axes of length 1 where one of them does not vary"
        ) from None


def _check_angles(states: States, shape: tuple[int, ...]) -> None:
    """Raise ValueError for w > 2γ₁, for which there is no Young angle.

    states: all of them (n,); shape: that of the result, in which the message names the first.
    """
    wrong = states.work > 2 * states.gamma1
    if wrong.any():
        i = int(wrong.argmax())
        place = _index(np.unravel_index(i, shape))
        raise ValueError(
            f"w = {float(states.work[i])!r} exceeds 2 gamma1 = {2 * float(states.gamma1[i])!r} at "
            f"{place or 'this state'}: with finite slopes there is no Young angle; lower w, raise "
            "gamma1 or use slopes='small'"
        )


def _found(scene: Scene, states: States, shape: tuple[int, ...]) -> ManyStates:
    """All states (n,), certified, found in parts of some thousand.

    Raises ValueError for the first that is lost, and NotCertifiedError for the first that is no
    equilibrium, of the first part that has such states.

    shape: that of the result, in which messages name states. `lost` are those whose contact leaves
    the known profile or whose surface turns over.
    """
    apex, touch = _lowest(scene)
    contact = SingleContact(scene, surfaces_of(scene), apex, touch)
    count = states.depth.size
    together = _TOGETHER[scene.slopes]
    found = ManyStates.detached(count)
    for start in range(0, count, together):
        own = np.arange(start, min(start + together, count))
        part = solved(contact, states.of(own))
        found.put(own, part)
        if part.lost.any():
            i = start + int(part.lost.argmax())
            raise ValueError(_refusal(scene, states, i, shape))
        wrong = ~(part.residual <= TOLERANCE)
        if wrong.any():
            i = start + int(wrong.argmax())
            raise NotCertifiedError(
                f"{_named(states, i, shape)} is no equilibrium: residual = "
                f"{float(found.residual[i])!r}; use minimise there, which says more"
            )
    return found


def _lowest(scene: Scene) -> tuple[float, float]:
    """Position of the lowest point, where the contact begins, and its height, the depth of that."""
    apex = scene.indenter.apex
    length = scene.elastocapillary_length
    if apex is None:
        apex = lowest_point(scene.indenter, length or scene.critical_separation or scene.layer.h)
    return apex, float(scene.indenter.height(apex))


def _named(states: States, i: int, shape: tuple[int, ...]) -> str:
    """State number i in words, by its place in the result and its parameters."""
    place = _index(np.unravel_index(i, shape))
    numbers = zip(("w", "gamma1", "stiffness"), states.parameters(i)[1:], strict=True)
    others = ", ".join(f"{name} = {value!r}" for name, value in numbers)
    return f"depths{place} = {states.parameters(i)[0]!r} with {others}"


def _refusal(scene: Scene, states: States, i: int, shape: tuple[int, ...]) -> str:
    """What `minimise` says of state number i, whose contact or surface is lost.

    The state is found again by itself, for the message of its error alone. scene, states: as of
    `_found`; shape: that of the result.
    """
    depth, work, gamma1, stiffness = states.parameters(i)
    layer = replace(scene.layer, E=scene.layer.E * stiffness / scene.stiffness)  # k grows with E
    surfaces = SurfaceEnergies.from_work(gamma1, work)
    one = replace(scene, layer=layer, surfaces=surfaces)
    why = "its contact leaves the known profile, or its surface turns over; use a smaller |depth|"
    try:
        (on_one_contact if gamma1 else on_springs)(one, depth, branch="adhered")
    except (ValueError, NotCertifiedError) as error:
        why = str(error)
    return f"{_named(states, i, shape)}: {why}"
