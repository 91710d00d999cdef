"""Where an indenter touches first: on flat faces between corners, or at its lowest points."""

from __future__ import annotations

import numpy as np

from discretization.nodes.row import Contacts
from discretization.refine.equations import Equations
from discretization.refine.nodes import FoundNodes
from energy.arrays import Array

# Of the size of depths, some thousand roundings of a height: corners that differ by less are
# equally low. 1e-13 or 1e-11 changes none of 8 random paths (`python -m tests.sensitivity
# discretization.refine.first_touch`).
_ROUNDING = 1e-12


def faces_at_touch(equations: Equations, nodes: FoundNodes, contacts: Contacts) -> Array:
    """The ends of what touches first: flat faces, or points.

    Parameters
    ----------
    equations : Equations
    nodes : FoundNodes
    contacts : Contacts
        m contacts on nodes at first touch.

    Returns
    -------
    ndarray (m, 2)
        Left and right end [length]. Both are the same at a point, which is a corner or the only
        lowest point of the profile; they are nan for one of several smooth points, which are not
        known as precisely.
    """
    profile = equations.profile
    corners = profile.corners
    heights = equations.scene.indenter.height(corners)
    lowest = corners[heights <= profile.touch + _ROUNDING * equations.size]
    found = np.full((len(contacts), 2), np.nan)
    for i, (first, last) in enumerate(contacts):
        left = nodes.positions[first] - nodes.spacing
        right = nodes.positions[last] + nodes.spacing
        face = lowest[(lowest >= left) & (lowest <= right)]
        if face.size:
            found[i] = face[[0, -1]]
        elif len(contacts) == 1:
            found[i] = profile.lowest
    return found
