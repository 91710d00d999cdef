"""What is read from a state, whoever found it: energy and force in parts, and what it assumes.

    springs   ∫ k/2 u² dx, over the whole surface
    surface   ∫ γ₁/2 u'² dx, or ∫ γ₁ (√(1+u'²) - 1) dx with finite slopes
    adhesion  -w times the length in contact, along the indenter with finite slopes
    pressure  k ∫ (d - f) dx over the contacts (9)
    lines     -γ₁ Σ sin β over all contact lines (10), β the outward inclination beside each

The parts are integrals over the displacement field and its slopes. Their sums are the energy and
the force up to quadrature and to what `error_estimate` says of the latter.

What a state assumes of the model is said by energy.validity. Of its nodes it assumes one in each l,
and four links in a contact: of 600 random parabolas a was off by at most 7 % inside these limits,
and by up to its own size outside, where the energy may be wrong by orders of magnitude.

state: an `Equilibrium`, which is built on this module, not it on that.
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import AccuracyWarning
from discretization.profile import breaks
from discretization.quadrature import in_contact, summed
from energy import Assumption, Scene, terms
from energy.validity import Deformation

Array = NDArray[np.float64]
STORED, ACTING = ("springs", "surface", "adhesion"), ("pressure", "lines")
_FAR = 48.0  # l: of a free surface without end
_EXACT = 1e-11  # of the free surfaces' parts
_SAMPLES = 257  # of each contact
LINKS, FEWEST = 1.0, 0.5  # spacing over l, and over the half-width of a contact, at most


def parts_of(state: Any) -> dict[str, float]:
    """Energy and force of a state in parts; of a plane without end every part is endless.

    Of a layer with its exact response, its fields know.
    """
    parts = dict.fromkeys((*STORED, *ACTING), 0.0)
    if not state.contacts.size:
        return parts
    if state.scene.layer.exact:
        return dict(state.surfaces.parts(state))
    if not np.isfinite(state.contacts).all():
        bound = -math.inf if state.scene.work_of_adhesion else 0.0
        stored = math.inf if state.depth else 0.0
        return {**parts, "springs": stored, "adhesion": bound, "pressure": state.force}
    found, _ = in_contact(state.scene, state.depth, state.contacts)
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


def half_widths(state: Any) -> Array:
    """Of every contact (m,); the radius of one around the axis."""
    return np.diff(state.contacts)[:, 0] / np.where(state.at_axis[:, 0], 1, 2)


def deformation(state: Any) -> Deformation:
    """What the contact does to the layer, looked at at many x.

    The ends, corners, knots and the apex are among them. Where the layer is pressed anywhere, the
    least height in contact is that of the whole profile: were it free, the surface would stand
    above it by more than anywhere in contact. Free surfaces bend and move most at their lines.
    """
    indenter, ends, x = state.scene.indenter, state.contacts, np.zeros(1)
    bounded = bool(np.isfinite(ends).all())
    if bounded:
        kinks = breaks(indenter)
        even = np.linspace(ends[:, 0], ends[:, 1], _SAMPLES).ravel()
        x = np.concatenate([even, kinks[state.inside(kinks)]])
    u = state.depth - indenter.height(x)
    slopes = [np.abs(indenter.slope(x)).max(), *np.ravel(state.line_slopes if bounded else 0.0)]
    steepest, narrowest = float(np.abs(slopes).max()), float(half_widths(state).min())
    return Deformation(float(u.max()), float(np.abs(u).max()), narrowest, steepest)


def of_nodes(state: Any) -> tuple[Assumption, ...]:
    """What the nodes of a state assume; of an endless plane nothing, as its links are alike."""
    if not np.isfinite(state.contacts).all():
        return ()
    own = ~state.pinned.all(axis=1)
    return resolution(state.scene, state.spacing, half_widths(state)[own])


def resolution(scene: Scene, spacing: float, widths: Array) -> tuple[Assumption, ...]:
    """What nodes `spacing` apart assume of l and of contacts with these half-widths (m,).

    Nothing on a mesh (spacing: nan), of l without tension or for the exact response of a layer, and
    of a without contacts. With rotational symmetry a contact on the axis counts with its radius.
    """
    found, more = [], "; give a smaller spacing, or method='fitted'"
    if spacing > 0 and scene.gamma1 and not scene.layer.exact:
        ratio, far = spacing / scene.elastocapillary_length, "the free surface has too few nodes"
        found.append(Assumption("Δx/l", ratio, LINKS, far + more))
    if spacing > 0 and widths.size:
        least = float(widths.min())
        ratio, few = spacing / least if least else math.inf, "a contact has too few nodes"
        found.append(Assumption("Δx/a", ratio, FEWEST, few + more))
    return tuple(found)


def tell(assumed: tuple[Assumption, ...], stacklevel: int) -> None:
    """AccuracyWarning where the free surface has too few nodes: next to nothing may be right."""
    for one in assumed:
        if one.name == "Δx/l" and not one.holds:
            told = f"the nodes are too far apart: {one}"
            warnings.warn(told, AccuracyWarning, stacklevel=stacklevel + 1)
