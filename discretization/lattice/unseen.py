"""What a lattice cannot see: features of the profile that are narrower than its spacing.

Between two nodes the profile should keep to its chord, but for what curvature does within a link,
of which the nodes know by the largest second difference of the heights around the link,

    |f_i + (f_{i+1} - f_i) s - f(x)| <= c max(|f_{i-1} - 2 f_i + f_{i+1}|,
                                              |f_i - 2 f_{i+1} + f_{i+2}|),     s = (x - x_i)/Δx,

with c = 1/8 if the profile is a parabola there, and 1/2 if it has a corner. A profile that does not
may stick through the free surface of a state, which has missed a contact then, or be in contact,
where its forces are not those of the nodes. So has a state without contact, wherever between the
nodes the indenter is in its surface.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import AccuracyWarning
from discretization.equilibrium import Equilibrium
from discretization.lattice.fronts import heights
from discretization.lattice.nodes import Lattice
from discretization.profile import resolve
from discretization.rounding import EPSILON
from energy import Scene

Array = NDArray[np.float64]
_SMOOTH, _CORNERED = 1 / 4, 1 / 2  # of a second difference: twice a parabola's, and a corner's
_ROUNDING = 64 * EPSILON  # of the heights
_MISSED = 1e-9  # of the depth and δ₀: a penetration that counts, as in the certificate


class Unseen(NamedTuple):
    """Places between the nodes (n,), f there, and how far that is from what the nodes see of it.

    lowest: x where the profile is lowest, at the height `touch`.
    """

    x: Array
    f: Array
    off: Array
    lowest: float = math.nan
    touch: float = math.inf


def unseen(scene: Scene, depth: float, lattice: Lattice) -> Unseen:
    """What the nodes do not see of the profile, where contact is possible at this depth.

    None of a convex profile. AccuracyWarning and ValueError as `resolve`.
    """
    if scene.indenter.convex:
        return Unseen(*np.empty((3, 0)))
    profile = resolve(scene, depth)
    lo, hi = scene.indenter.extent
    x, f = profile.x, profile.f
    place = (x - lattice.origin) / lattice.spacing
    link = np.floor(place).astype(int)
    inside = (lattice.x(link - 1) >= lo) & (lattice.x(link + 2) <= hi)
    x, f, place, link = x[inside], f[inside], place[inside], link[inside]
    if not x.size:
        none = np.empty(0)
        return Unseen(none, none, none, profile.lowest, profile.touch)
    nodes = heights(lattice, scene.indenter, np.arange(link.min() - 1, link.max() + 3, dtype=float))
    at = link - link.min() + 1
    bend = np.abs(np.diff(nodes, 2))
    chord = nodes[at] + (place - link) * (nodes[at + 1] - nodes[at])
    cornered = np.isin(link, np.floor((profile.corners - lattice.origin) / lattice.spacing))
    share = np.where(cornered, _CORNERED, _SMOOTH)
    known = share * np.maximum(bend[at - 1], bend[at]) + _ROUNDING * np.abs(nodes).max()
    off = np.abs(chord - f)
    hidden = off > known
    return Unseen(x[hidden], f[hidden], off[hidden], profile.lowest, profile.touch)


def looked_at(
    states: Sequence[Equilibrium], hidden: Unseen, lattice: Lattice, stacklevel: int
) -> None:
    """AccuracyWarning where the surfaces of a scene's states miss what the nodes do not see."""
    if not (hidden.x.size and states):
        return
    missed = np.max([_missed(state, hidden) for state in states], axis=0)
    worst, scene = int(np.argmax(missed)), states[0].scene
    size = max(scene.critical_separation, *(abs(state.depth) for state in states))
    if missed[worst] > _MISSED * size:
        warnings.warn(
            f"at x = {float(hidden.x[worst])!r} the surface between nodes {lattice.spacing!r} "
            f"apart misses the indenter by {float(missed[worst])!r}: a feature or contact "
            "narrower than the spacing may be missed; give a smaller spacing, or method='fitted'",
            AccuracyWarning,
            stacklevel=stacklevel + 1,
        )


def _missed(state: Equilibrium, hidden: Unseen) -> Array:
    """How far the surface of a state is from the indenter: through it, or in contact off it."""
    through = state.depth - hidden.f - state.displacement(hidden.x)
    inside = np.searchsorted(state.contacts.ravel(), hidden.x) % 2 == 1
    return np.where(inside, hidden.off, through)
