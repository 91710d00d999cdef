"""SI prefixes for axis labels: 3.2e-6 m is drawn as 3.2 µm."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from energy.units import PREFIXES


class Unit(NamedTuple):
    """A unit to draw in: value/size is the number, symbol what stands on the axis."""

    size: float
    symbol: str


def prefixed(values: ArrayLike, unit: str) -> Unit:
    """The prefix that puts the largest finite |value| into 1..1000; none if all are zero.

    `unit` is a plain SI unit ("m", "N/m"); the prefix applies to its first symbol.
    """
    sizes = np.abs(np.asarray(values, float))
    largest = float(sizes[np.isfinite(sizes)].max(initial=0.0))
    exponent = 3 * int(np.floor(np.log10(largest) / 3 + 1e-9)) if largest else 0
    exponent = min(max(exponent, min(PREFIXES)), max(PREFIXES))
    return Unit(10.0**exponent, PREFIXES[exponent] + unit)


def quantity(value: float, unit: str) -> str:
    """A value with its unit, prefixed: "20 mN/m"."""
    size, symbol = prefixed(value, unit)
    return f"{value / size:.4g} {symbol}"
