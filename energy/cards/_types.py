"""Types shared by the cards."""

from typing import NamedTuple, TypeAlias

import numpy as np
from numpy.typing import NDArray

Values: TypeAlias = float | NDArray[np.float64]
"""What a card returns: a float for numbers, an array for arrays."""


class PullOff(NamedTuple):
    """The state of most tensile force (compressive forces are positive, so `force` <= 0)."""

    force: Values
    depth: Values
    half_width: Values
