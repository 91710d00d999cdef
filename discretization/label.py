"""What is known of an equilibrium among all states of its scene at its depth, in one word.

"detached"    the flat surface without contact
"neutral"     a contact line rests anywhere in a range: states of any width have this energy
"global"      no state has less energy
"metastable"  a state with less energy is known
"adhered"     the state of the path from first touch; whether another has less is not known

state: an `Equilibrium`, which is built on this module, not it on that.
"""

from __future__ import annotations

from typing import Any

import numpy as np

from discretization.routes import one_contact


def label(state: Any) -> str:
    """The word for this state.

    "global" was searched for, or is the only minimum where w = 0 (a convex problem). Otherwise the
    detached state, with energy 0, is compared: it exists up to first touch, d <= min f. Of a convex
    indenter with tension it is the only other minimum, as the force on each line grows outwards.
    """
    if not state.contacts.size:
        return "detached"
    if state.neutral:
        return "neutral"
    if state.scene.opening is not None or state.scene.pattern is not None:
        return "adhered"
    if state.branch == "global" or not state.scene.work_of_adhesion:
        return "global"
    if (state.energy > 0 and state.indentation <= 0) or _springs_left_beside(state):
        return "metastable"
    return "global" if one_contact(state.scene) else "adhered"


def _springs_left_beside(state: Any) -> bool:
    """Whether springs without tension would gain w by attaching just beside the contact (γ₁ = 0).

    They would at every end but that of a body: they are all but in contact already.
    """
    ends = np.isfinite(state.contacts) & ~state.pinned
    return not state.scene.gamma1 and bool(ends.any())
