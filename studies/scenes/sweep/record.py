"""A finished sweep: its grid, and what was found at each point."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from studies.scenes.grid import Axis, Value
from studies.scenes.sweep.store import Found


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some axes, numbered with the last axis fastest."""

    axes: tuple[Axis, ...]

    def __len__(self) -> int:
        return math.prod(len(axis.values) for axis in self.axes)

    def point(self, number: int) -> dict[str, Value]:
        """The values at a point, by key."""
        at: list[Value] = []
        for axis in reversed(self.axes):
            number, i = divmod(number, len(axis.values))
            at.append(axis.values[i])
        return dict(zip((axis.key for axis in self.axes), reversed(at), strict=True))


@dataclass(frozen=True)
class Record:
    """A finished sweep: its grid, and what was found or the error at each point."""

    grid: Grid
    results: tuple[Found, ...]

    @property
    def failed(self) -> int:
        """How many points failed."""
        return sum("error" in result for result in self.results)

    @property
    def detached(self) -> np.ndarray:
        """Whether the state at each point is detached (n,)."""
        labels = [result.get("found", {}).get("label") for result in self.results]
        return np.array([label == "detached" for label in labels])

    def column(self, name: str) -> np.ndarray:
        """A number at every point (n,); nan where the point failed or has none."""
        values = [result.get("found", {}).get(name) for result in self.results]
        return np.array([math.nan if value is None else value for value in values], float)
