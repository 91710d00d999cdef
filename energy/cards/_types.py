"""Types shared by the cards."""

from __future__ import annotations

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import ArrayLike

from energy.arrays import Array

Values: TypeAlias = float | Array
"""What a card returns: a float for numbers, an array for arrays."""


class PullOff(NamedTuple):
    """The state of most tensile force.

    Attributes
    ----------
    force : float or ndarray
        P, compressive forces positive, so that it is <= 0.
    depth : float or ndarray
    half_width : float or ndarray
        The radius with rotational symmetry.
    """

    force: Values
    depth: Values
    half_width: Values


class Jump(NamedTuple):
    """An instability at fixed control and what it releases.

    Force, depth and half-width are those of the contact: just after a jump-in (before it they
    are 0), just before a detachment (after it there is no contact).

    Attributes
    ----------
    force : float or ndarray
        P, compressive forces positive.
    depth : float or ndarray
    half_width : float or ndarray
        The radius with rotational symmetry.
    energy_released : float or ndarray
        >= 0.
    """

    force: Values
    depth: Values
    half_width: Values
    energy_released: Values

    @classmethod
    def of(cls, force: ArrayLike, depth: ArrayLike, a: ArrayLike, released: ArrayLike) -> Jump:
        """All four broadcast to one shape."""
        same_shape = np.broadcast_arrays(force, depth, a, released)
        return cls(*np.array(same_shape, dtype=np.float64))
