"""A task of `runtime_vs_error` and a method that takes part in it."""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from energy import Scene
from studies.benchmarks.rivals.problem import Answer, Array

Solve = Callable[[], Answer]
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)
FEW = 20  # steps of the loop given to slow methods


@dataclass(frozen=True)
class Method:
    """Name, how to prepare it for a size (number of nodes, or rtol), packages it needs.

    largest: size; only: sizes of a method that can do few; tolerances: it is given rtol, not nodes;
    few: it is given FEW steps of a loop.
    """

    name: str
    make: Callable[[Task, float], tuple[Solve, int]]
    largest: float = math.inf
    packages: tuple[str, ...] = ()
    only: tuple[int, ...] = ()
    tolerances: bool = False
    few: bool = False

    def sizes(self, given: Sequence[int]) -> Sequence[float]:
        """The sizes, or the tolerances of a method without nodes."""
        if self.tolerances:
            return TOLERANCES
        return self.only or [n for n in given if n <= self.largest]

    def steps(self, task: Task) -> int:
        """Steps of a loop over which its time is shared out."""
        return min(FEW, task.depths.size) if self.few else task.depths.size


@dataclass(frozen=True, eq=False)
class Task:
    """A scene, its depths and what is exact there: columns a, P, U, θ."""

    name: str
    scene: Scene
    depths: Array
    exact: Array
    methods: tuple[Method, ...] = field(repr=False)

    @property
    def depth(self) -> float:
        """The last depth."""
        return float(self.depths[-1])

    def errors(self, answer: Any) -> tuple[float, float, float, float]:
        """Largest relative errors of a, P, U and θ; for the rough profile of U alone."""
        found = np.array([np.asarray(part, float).T for part in answer[:4]]).reshape(4, -1)
        exact = self.exact if found.shape[1] == self.exact.shape[1] else self.few
        size = np.abs(exact).max(axis=1)
        a, force, energy, angle = np.abs(found - exact).max(axis=1) / size
        return float(a), float(force), float(energy), float(angle)

    @property
    def chosen(self) -> Array:
        """Indices of the few steps a slow method is given."""
        return np.linspace(0, self.depths.size - 1, min(FEW, self.depths.size)).astype(int)

    @property
    def few(self) -> Array:
        """What is exact at these."""
        return self.exact[:, self.chosen]
