"""Types that studies share: numbers (n,), and who is told a line."""

from collections.abc import Callable

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
QUANTITIES = ("half_width", "force", "energy")  # those with an error estimate
Show = Callable[[str], object]
