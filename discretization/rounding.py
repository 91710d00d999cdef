"""What double precision leaves, in one place."""

import numpy as np

EPSILON = float(np.finfo(float).eps)
ROUNDING = 16 * EPSILON  # of the sizes of the terms that a result is summed from, a dozen or so
