"""Energy and force of an equilibrium in parts, by quadrature over its contacts and free surfaces.

    springs   ∫ k/2 u² dx, over the whole surface
    surface   ∫ γ₁/2 u'² dx, or ∫ γ₁ (√(1+u'²) - 1) dx with finite slopes
    adhesion  -w times the length in contact, along the indenter with finite slopes
    pressure  k ∫ (d - f) dx over the contacts (9)
    lines     -γ₁ Σ sin β over all contact lines (10), β the outward inclination beside each

They are read from the displacement field and its slopes, whoever found those. Their sums are the
energy and the force up to quadrature and to what `error_estimate` says of the latter.

state: an `Equilibrium`, which is built on this module, not it on that.
"""

from __future__ import annotations

import math
from typing import Any, Protocol

import numpy as np
from numpy.typing import NDArray

from discretization.quadrature import in_contact, summed
from energy import terms

Array = NDArray[np.float64]
STORED, ACTING = ("springs", "surface", "adhesion"), ("pressure", "lines")
_FAR = 48.0  # l: of a free surface without end
_EXACT = 1e-11  # of the free surfaces' parts


def parts_of(state: Any) -> dict[str, float]:
    """Energy and force of a state in parts; of a plane without end every part is endless."""
    parts = dict.fromkeys((*STORED, *ACTING), 0.0)
    if not state.contacts.size:
        return parts
    if not np.isfinite(state.contacts).all():
        bound = -math.inf if state.scene.work_of_adhesion else 0.0
        stored = math.inf if state.depth else 0.0
        return {**parts, "springs": stored, "adhesion": bound, "pressure": state.force}
    found, _ = in_contact(state.scene, state.depth, state.contacts, 0.0)
    springs, surface, adhesion, pressure = found.sums.sum(axis=1).tolist()
    parts |= {"adhesion": -adhesion, "pressure": pressure}
    if state.scene.gamma1:
        free = _of_free(state)
        springs, surface, parts["lines"] = springs + free[0], surface + free[1], _of_lines(state)
    return {**parts, "springs": float(springs), "surface": float(surface)}


def _of_lines(state: Any) -> float:
    """-γ₁ Σ sin β, or -γ₁ Σ u' with small slopes (11); about an axis each times 2πr."""
    beside = state.line_slopes[1]
    if state.scene.slopes == "finite":
        beside = beside / np.hypot(1.0, beside)
    return -state.scene.gamma1 * float((beside * state.scene.measure(state.contacts)).sum())


def _of_free(state: Any) -> Array:
    """Springs and surface (2,) of all free surfaces."""
    scene, found = state.scene, np.zeros(2)
    far = _FAR * scene.elastocapillary_length
    for left, right in state.free:

        def density(x: Array, pair: Any = (left, right)) -> Array:
            u, slope = state.surfaces.shape(x, *pair, state.depth)
            surface = terms.surface(slope, gamma1=scene.gamma1, slopes=scene.slopes).value
            return np.array([terms.spring(u, k=scene.stiffness).value, surface]) * scene.measure(x)

        end = left.x + far if right is None else right.x
        start = (
            left.x if left is not None else max(end - far, 0.0 if scene.axisymmetric else -math.inf)
        )
        ends = np.array([[start], [end]])
        found += summed(density, ends, _EXACT, np.zeros((2, 1)), smooth=True).sums.sum(axis=1)
    return found


def with_surface(state: Any, surface: float) -> dict[str, float]:
    """The parts of a state whose surface stores this; the layer itself, for the springs, the rest.

    Lines pull by the slopes beside them, and the rest of the force is the pressure.
    """
    adhesion, lines = -state.scene.work_of_adhesion * state.contact_area, _of_lines(state)
    return {
        "springs": state.energy - adhesion - surface,
        "surface": surface,
        "adhesion": adhesion,
        "pressure": state.force - lines,
        "lines": lines,
    }


class Elastic(Protocol):
    """What presses on the indenter in contact, and stores energy."""

    def pressure(self, state: Any, x: Array) -> Array:
        """In contact at positions."""

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force in parts."""


class Springs:
    """The layer as independent springs, which press with k u."""

    def pressure(self, state: Any, x: Array) -> Array:
        """In contact at positions."""
        return np.asarray(state.scene.stiffness * state.displacement(x))

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force in parts."""
        return parts_of(state)


SPRINGS = Springs()
