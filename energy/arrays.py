"""The kinds of arrays that signatures name, once for all."""

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
Mask = NDArray[np.bool_]
Indices = NDArray[np.int64]  # places in a row
Nodes = Indices  # numbers of nodes
