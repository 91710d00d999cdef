"""How numbers are compared."""

import numpy as np


def check(value, expected, rel, scale=0.0):
    """|value − expected| <= rel · max(|expected|, scale): no absolute tolerance, no unit."""
    value = np.asarray(value)
    expected = np.asarray(expected)
    assert value.shape == expected.shape
    assert (abs(value - expected) <= rel * np.maximum(abs(expected), scale)).all()
