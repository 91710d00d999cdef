"""Where an indenter touches first: on flat faces between corners, or at its lowest points.

Nodes know which contacts there are at first touch, but where a face ends only to a link. It ends at
corners, which are known exactly: those next to a contact on nodes that are as low as the profile
gets. Heights of the profile are positive upwards, positions to the right. Of the profile, `corners`
are x at which its slope jumps, `touch` is its least height and `lowest` x of that; of the nodes,
`positions` are x of all of them and `spacing` is how far apart they are. The size of the equations
is that of depths: δ₀ and the larger of |d| and |f| at first touch together.
"""

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
        With the profile and the size of depths.
    nodes : FoundNodes
    contacts : Contacts
        First and last nodes of the m contacts at first touch, from left to right.

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
        # The face may reach up to a link beyond the nodes of the contact.
        left = nodes.positions[first] - nodes.spacing
        right = nodes.positions[last] + nodes.spacing
        face = lowest[(lowest >= left) & (lowest <= right)]
        if face.size:
            found[i] = face[[0, -1]]  # corners increase; one alone is a point
        elif len(contacts) == 1:
            found[i] = profile.lowest
    return found
