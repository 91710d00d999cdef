"""Many states of a sweep at once, with the columns that one state has."""

import math
from collections.abc import Sequence

import numpy as np

from discretization import Equilibria, NotCertifiedError, minimise_many
from discretization.readings import OBSERVABLES
from energy import Scene
from energy.arrays import Array
from energy.validity import Deformation, assumptions
from studies.scenes.file import SceneFile
from studies.shared import QUANTITIES

Row = dict[str, float | str]
_NEUTRAL = 1e-9  # of δ₀: so near to it the line of a punch may rest anywhere


def vectorised(given: SceneFile) -> bool:
    """Whether what a file asks for may be found together with other states."""
    body = given.scene.indenter
    options = given.options
    asked = options.get("method", "auto") in ("auto", "fitted") and "spacing" not in options
    adhered = options.get("branch", "adhered") == "adhered"
    return asked and adhered and body.symmetric and body.convex and body.apex == 0


def of_states(scenes: Sequence[Scene], depths: Array) -> list[Row | None]:
    """What `of_state` says of many states that differ in depth, surface energies and layer alone.

    None where a state is better found by itself: where `minimise_many` refuses it, and for contacts
    of a point, without tension, and within rounding of where the line of a punch may move.
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
    a = states.half_width
    touch = float(body.height(0.0))
    height = np.asarray(body.height(a), float)
    steep = np.abs(np.asarray(body.slope(a), float))
    beside = np.abs(math.pi - states.contact_angle - steep)
    separation = np.sqrt(2 * work / stiffness)
    lone = (gamma1 == 0) | (states.in_contact & (a == 0)) | ~states.stable
    if body.walls:
        lone |= np.abs(depths - touch + separation) <= _NEUTRAL * separation
    return [
        None
        if lone[i]
        else _row(
            scene,
            states,
            i,
            Deformation(
                float(depths[i]) - touch,
                max(abs(float(depths[i]) - touch), abs(float(depths[i] - height[i]))),
                float(a[i]),
                max(float(steep[i]), float(beside[i])),
            ),
        )
        for i, scene in enumerate(scenes)
    ]


def _row(scene: Scene, states: Equilibria, i: int, deformed: Deformation) -> Row:
    """What `of_state` says of one of many states in contact, or detached."""
    touches = bool(states.in_contact[i])
    label = "detached"
    if touches:
        lower = states.energy[i] > 0 and deformed.indentation <= 0 and scene.work_of_adhesion
        label = "metastable" if lower else "global"
    broken = [
        one.name for one in assumptions(scene, deformed if touches else None) if not one.holds
    ]
    return {
        **{name: float(getattr(states, name)[i]) for name in OBSERVABLES[1:]},
        **{f"error_{name}": float(states.uncertainty[name][i]) for name in QUANTITIES},
        "label": label,
        "violated": "; ".join(broken),
    }
