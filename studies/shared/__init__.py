"""What studies share; here the type of numbers (n,), and the quantities with an error estimate."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
QUANTITIES = ("half_width", "force", "energy")
