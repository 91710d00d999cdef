"""What a contact does to the layer, by which the assumptions of the model are judged.

state: an `Equilibrium`, which is built on this module, not it on that.
"""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from energy.validity import Deformation

Array = NDArray[np.float64]
_SAMPLES = 257  # of each contact


def range_of_heights(state: Any) -> tuple[float, float]:
    """Least and largest f in contact, looked for at many points; nan without contact.

    Where the layer is pressed anywhere, the least is that of the whole profile: were it free, the
    surface would stand above it by more than anywhere in contact.
    """
    if not state.contacts.size:
        return math.nan, math.nan
    f = state.scene.indenter.height(_points_in_contact(state))
    return float(f.min()), float(f.max())


def deformation(state: Any) -> Deformation:
    """Indentation, largest displacement, narrowest contact and steepest slope of a state.

    Free surfaces move and bend most at their lines.
    """
    steepest = float(np.abs(state.scene.indenter.slope(_points_in_contact(state))).max())
    if np.isfinite(state.contacts).all():
        steepest = max(steepest, float(np.max(np.abs(state.line_slopes))))
    farthest = max(abs(state.depth - height) for height in state.range_of_heights)
    widths = state.contacts[:, 1] - state.contacts[:, 0]
    narrowest = float(np.min(np.where(state.at_axis[:, 0], widths, widths / 2)))
    return Deformation(state.indentation, farthest, narrowest, steepest)


def _points_in_contact(state: Any) -> Array:
    """Many x in contact, with the ends, corners, knots and the apex among them."""
    indenter, known = state.scene.indenter, state.contacts
    if not np.isfinite(known).all():
        return np.zeros(1)
    even = np.linspace(known[:, 0], known[:, 1], _SAMPLES).ravel()
    apex = [] if indenter.apex is None else [indenter.apex]
    kinks = np.concatenate([np.asarray(p, float) for p in (indenter.corners, indenter.knots, apex)])
    return np.concatenate([even, kinks[state.inside(kinks)]])
