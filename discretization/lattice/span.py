"""Contacts as the first and last node of each, (m, 2), of a mask of all nodes, (n,)."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]
FAR = 60.0  # decay lengths after which the ends of a span are independent


def runs(contact: Mask) -> Nodes:
    """First and last node of each contact (m, 2)."""
    edges = np.diff(contact.astype(np.int8), prepend=0, append=0)
    return np.column_stack((np.flatnonzero(edges == 1), np.flatnonzero(edges == -1) - 1))
