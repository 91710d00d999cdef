"""What a state does to the layer, for energy.validity, and how far apart its nodes may be.

The free surface needs a node in each l, a contact four links: of 600 random parabolas a was off by
at most 7 % inside these limits, and by up to its own size outside, where the energy may be wrong by
orders of magnitude.
"""

from __future__ import annotations

import math
import warnings
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import AccuracyWarning
from discretization.profile import breaks
from energy import Assumption, Scene
from energy.validity import Deformation

Array = NDArray[np.float64]
_SAMPLES = 257  # of each contact
LINKS, FEWEST = 1.0, 0.5  # spacing over l, and over the half-width of a contact, at most


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
