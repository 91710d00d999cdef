"""Types shared by the cards."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from energy.arrays import Array

Values: TypeAlias = float | Array
"""What a card returns: a float for numbers, an array for arrays."""


class PullOff(NamedTuple):
    """The state of most tensile force (compressive forces are positive, so `force` <= 0)."""

    force: Values
    depth: Values
    half_width: Values


class Jump(NamedTuple):
    """An instability at fixed control and what it releases.

    force, depth and half_width are those of the contact: just after a jump-in (before it they
    are 0), just before a detachment (after it there is no contact).
    """

    force: Values
    depth: Values
    half_width: Values
    energy_released: Values

    @classmethod
    def of(cls, force: ArrayLike, depth: ArrayLike, a: ArrayLike, released: ArrayLike) -> Jump:
        """All four broadcast to one shape."""
        return cls(*np.array(np.broadcast_arrays(force, depth, a, released), dtype=np.float64))
