"""The engine: one measured number, refined, held against a closed form and an order of convergence.

A check measures something on a `Grid` and says what it should be. `refine` repeats it with the
spacing halved again and again, and at every spacing with the grid shifted sideways by fractions of
it: the lattice error is a sawtooth in the position of the contact line between two nodes, so the
error of a level is the worst over the shifts. The check passes if

    error on the finest grid <= bar    and    low <= order <= high,

order = -slope of log(error) over log(cells) by least squares. A quantity that the lattice gives
exactly has no order: then the error of every grid must stay below the bar, which is rounding.
"""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization import Equilibrium, on_lattice
from energy import Scene

Array = NDArray[np.float64]
Band = tuple[float, float]
Numbers = Any  # a number, an array, or nested lists of them

SECOND: Band = (1.8, 2.2)
FIRST: Band = (0.85, 1.15)
EXACT = None
SECOND_BAR = 5e-6
ROUNDING = 1e-10


@dataclass(frozen=True)
class Grid:
    """A lattice: links per reference length, and its sideways shift in links."""

    cells: int
    offset: float = 0.0

    def solve(
        self, scene: Scene, depth: float, *, length: float | None = None, branch: str = "adhered"
    ) -> Equilibrium:
        """Equilibrium with length/cells between nodes; `length` is l unless given."""
        spacing = (length or scene.elastocapillary_length) / self.cells
        apex = scene.indenter.apex or 0.0
        origin = apex + self.offset * spacing if self.offset else None
        return on_lattice(scene, float(depth), spacing, branch=branch, origin=origin)

    def sweep(self, scene: Scene, depths: ArrayLike, name: str, **options: Any) -> Array:
        """The attribute `name` of the equilibria at the depths, (n,)."""
        depths = np.atleast_1d(np.asarray(depths, float))
        return np.array([getattr(self.solve(scene, d, **options), name) for d in depths])


@dataclass(frozen=True)
class Comparison:
    """Simulated values and closed forms (shapes broadcast); error = max |difference|/scale."""

    simulated: Numbers
    closed_form: Numbers
    scale: Numbers = None

    def worst(self) -> tuple[float, float, float]:
        """Largest relative error, and the two values it belongs to; inf if anything is NaN."""
        simulated, closed = np.broadcast_arrays(
            np.asarray(self.simulated, float), np.asarray(self.closed_form, float)
        )
        scale = np.abs(closed if self.scale is None else np.asarray(self.scale, float))
        with np.errstate(divide="ignore", invalid="ignore"):
            errors = np.abs(simulated - closed) / scale
        errors = np.where(np.isfinite(errors), errors, math.inf)
        if not errors.size:
            return math.inf, math.nan, math.nan
        at = np.unravel_index(int(np.argmax(errors)), errors.shape)
        return float(errors[at]), float(simulated[at]), float(closed[at])


def residual(values: Numbers, scale: Numbers) -> Comparison:
    """A residual that should vanish, relative to `scale`."""
    return Comparison(values, np.zeros_like(np.asarray(values, float)), scale)


@dataclass(frozen=True)
class Check:
    """One statement about a numbered equation of the paper; no number: beyond the paper."""

    equations: tuple[int, ...]
    what: str
    measure: Callable[[Grid], Comparison]
    order: Band | None
    bar: float
    unit: str
    anchored: bool

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled by name: the decorated function's name in its module is this check."""
        return _named, (self.measure.__module__, self.measure.__qualname__)


def _named(module: str, name: str) -> Check:
    found: Check = getattr(import_module(module), name)
    return found


def check(
    *equations: int,
    what: str,
    order: Band | None = SECOND,
    bar: float | None = None,
    unit: str = "",
    anchored: bool = False,
) -> Callable[[Callable[[Grid], Comparison]], Check]:
    """Decorator: turns a function Grid -> Comparison into a Check.

    bar: largest relative error on the finest grid. anchored: not repeated on shifted grids, for a
    quantity that is of second order only with the tip of the indenter on a node.
    """
    if bar is None:
        if order not in (SECOND, EXACT):
            raise ValueError(f"order = {order!r} has no usual bar; give bar=...")
        bar = SECOND_BAR if order == SECOND else ROUNDING
    limit = bar
    return lambda measure: Check(equations, what, measure, order, limit, unit, anchored)


@dataclass(frozen=True)
class Result:
    """Outcome of a check: worst case on the finest grid, error of each level, observed order."""

    check: Check = field(repr=False)
    simulated: float
    closed_form: float
    cells: tuple[int, ...]
    errors: tuple[float, ...]
    seconds: float
    note: str = ""

    @property
    def error(self) -> float:
        """Relative error on the finest grid; of an exact quantity, the worst of all grids."""
        if not self.errors:
            return math.inf
        return self.errors[-1] if self.check.order else max(self.errors)

    @property
    def observed_order(self) -> float:
        """Least-squares order of convergence; nan for an exact quantity."""
        return observed_order(self.cells, self.errors) if self.check.order else math.nan

    @property
    def passed(self) -> bool:
        """Whether the error stays below the bar and the order lies in its band."""
        band = self.check.order
        in_band = band is None or band[0] <= self.observed_order <= band[1]
        return self.error <= self.check.bar and in_band


def observed_order(cells: Sequence[int], errors: Sequence[float]) -> float:
    """-slope of log(error) over log(cells); nan with fewer than four levels or a zero error."""
    if len(errors) < 4 or not all(0 < e < math.inf for e in errors):
        return math.nan
    return -float(np.polyfit(np.log(cells), np.log(errors), 1)[0])


def refine(item: Check, cells: Sequence[int], offsets: Sequence[float]) -> Result:
    """Run a check on every level and shift. An error raised by the simulator fails the check."""
    start, errors = time.perf_counter(), []
    worst = (math.inf, math.nan, math.nan)
    note = ""
    try:
        for n in cells:
            shifts = (0.0,) if item.anchored else offsets
            worst = max(item.measure(Grid(n, shift)).worst() for shift in shifts)
            errors.append(worst[0])
    except (ValueError, ArithmeticError, RuntimeError) as problem:
        note, errors = f"{type(problem).__name__}: {problem}", []
    seconds = time.perf_counter() - start
    return Result(item, worst[1], worst[2], tuple(cells), tuple(errors), seconds, note)
