"""Many states of a sweep at once, with the columns that one state has.

Conventions:

- A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁ and `work_of_adhesion` w.
- `NotCertifiedError` is raised where no state passes its own checks.
- `minimise_many(scene, depths, w=..., gamma1=..., stiffness=...)` are `Equilibria`, arrays (n,):
  `half_width`, `force`, `energy`, `contact_angle`, whether they are `in_contact` and `stable`.
- `walls` of an indenter are its vertical edges, `apex` the x of its lowest point.
- OBSERVABLES are what is read off one state, QUANTITIES what has an error estimate; `assumptions`
  of a `Deformation` say how far the model holds.
"""

import math
from collections.abc import Sequence

import numpy as np

from discretization import Equilibria, NotCertifiedError, minimise_many
from discretization.readings import OBSERVABLES
from energy import Indenter, Scene
from energy.arrays import Array
from energy.validity import Deformation, assumptions
from studies.scenes.file import SceneFile
from studies.shared import QUANTITIES

Row = dict[str, float | str]
_NEUTRAL = 1e-9  # of δ₀: so near to it the line of a punch may rest anywhere


def vectorised(given: SceneFile) -> bool:
    """Whether what a file describes may be found together with other states.

    Parameters
    ----------
    given : SceneFile

    Returns
    -------
    bool
    """
    options = given.options
    on_mesh = options.get("method", "auto") in ("auto", "fitted") and "spacing" not in options
    adhered = options.get("branch", "adhered") == "adhered"
    body = given.scene.indenter
    one_contact = body.symmetric and body.convex and body.apex == 0
    return on_mesh and adhered and one_contact


def of_states(scenes: Sequence[Scene], depths: Array) -> list[Row | None]:
    """What `of_state` says of many states that differ in depth, surface energies and layer alone.

    Parameters
    ----------
    scenes : sequence of Scene
        n of them.
    depths : ndarray (n,)

    Returns
    -------
    list of dict or None
        None where a state is better found by itself: where `minimise_many` refuses it, and for
        contacts of a point, without tension, and within rounding of where the line of a punch may
        move.
    """
    work = np.array([scene.work_of_adhesion for scene in scenes])
    gamma1 = np.array([scene.gamma1 for scene in scenes])
    stiffness = np.array([scene.stiffness for scene in scenes])
    try:
        states = minimise_many(scenes[0], depths, w=work, gamma1=gamma1, stiffness=stiffness)
    except (ValueError, NotCertifiedError):
        if len(scenes) == 1:
            return [None]
        half = len(scenes) // 2
        return [
            *of_states(scenes[:half], depths[:half]),
            *of_states(scenes[half:], depths[half:]),
        ]
    body = scenes[0].indenter
    touch = float(body.height(0.0))
    separation = np.sqrt(2 * work / stiffness)
    is_point = states.in_contact & (states.half_width == 0)
    by_itself = (gamma1 == 0) | is_point | ~states.stable
    if body.walls:
        by_itself |= np.abs(depths - touch + separation) <= _NEUTRAL * separation
    rows: list[Row | None] = []
    for i, deformed in enumerate(_deformations(body, states, depths)):
        rows.append(None if by_itself[i] else _row(scenes[i], states, i, deformed))
    return rows


def _deformations(body: Indenter, states: Equilibria, depths: Array) -> list[Deformation]:
    """What each of the states does to the layer."""
    a = states.half_width
    indentation = depths - float(body.height(0.0))
    at_line = depths - np.asarray(body.height(a), float)
    slope_of_indenter = np.abs(np.asarray(body.slope(a), float))
    slope_of_surface = np.abs(math.pi - states.contact_angle - slope_of_indenter)
    displacement = np.maximum(np.abs(indentation), np.abs(at_line))
    slope = np.fmax(slope_of_indenter, slope_of_surface)  # detached, there is no angle
    each = zip(indentation.tolist(), displacement.tolist(), a.tolist(), slope.tolist(), strict=True)
    return [Deformation(*values) for values in each]


def _row(scene: Scene, states: Equilibria, i: int, deformed: Deformation) -> Row:
    """What `of_state` says of one of many states in contact, or detached."""
    touches = bool(states.in_contact[i])
    detached_is_lower = states.energy[i] > 0 and deformed.indentation <= 0
    if not touches:
        label = "detached"
    elif detached_is_lower and scene.work_of_adhesion:
        label = "metastable"
    else:
        label = "global"
    judged = assumptions(scene, deformed if touches else None)
    broken = [one.name for one in judged if not one.holds]
    return {
        **{name: float(getattr(states, name)[i]) for name in OBSERVABLES[1:]},
        **{f"error_{name}": float(states.uncertainty[name][i]) for name in QUANTITIES},
        "label": label,
        "violated": "; ".join(broken),
    }
