"""Types that studies share: numbers (n,), a table's columns and rows, who is told a line."""

from collections.abc import Callable, Sequence

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Table = tuple[Sequence[str], Sequence[Sequence[object]]]
QUANTITIES = ("half_width", "force", "energy")  # those with an error estimate
Show = Callable[[str], object]
