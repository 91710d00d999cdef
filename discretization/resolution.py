"""How far apart nodes may be: the free surface needs one in each l, a contact four links.

Of 600 random parabolas a was off by at most 7 % inside these limits, and by up to its own size
outside, where the energy may be wrong by orders of magnitude.
"""

from __future__ import annotations

import math
import warnings

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import AccuracyWarning
from energy import Assumption, Scene

Array = NDArray[np.float64]
LINKS, FEWEST = 1.0, 0.5  # spacing over l, and over the half-width of a contact, at most


def resolution(scene: Scene, spacing: float, half_widths: Array) -> tuple[Assumption, ...]:
    """What nodes `spacing` apart assume of l and of contacts with these half-widths (m,).

    Nothing on a mesh (spacing: nan), of l without tension or for the exact response of a layer, and
    of a without contacts. With rotational symmetry a contact on the axis counts with its radius.
    """
    found, more = [], "; give a smaller spacing, or method='fitted'"
    if spacing > 0 and scene.gamma1 and not scene.layer.exact:
        ratio, far = spacing / scene.elastocapillary_length, "the free surface has too few nodes"
        found.append(Assumption("Δx/l", ratio, LINKS, far + more))
    if spacing > 0 and half_widths.size:
        least = float(half_widths.min())
        ratio, few = spacing / least if least else math.inf, "a contact has too few nodes"
        found.append(Assumption("Δx/a", ratio, FEWEST, few + more))
    return tuple(found)


def tell(assumed: tuple[Assumption, ...], stacklevel: int) -> None:
    """AccuracyWarning where the free surface has too few nodes: next to nothing may be right."""
    for one in assumed:
        if one.name == "Δx/l" and not one.holds:
            told = f"the nodes are too far apart: {one}"
            warnings.warn(told, AccuracyWarning, stacklevel=stacklevel + 1)
