"""The engine: one measured number, refined, compared with its closed form and order.

A check measures something on a `Grid` and says what it should be, once or, as a generator, several
times. `refine` repeats it with the spacing halved again and again, and at every spacing with the
grid shifted sideways by fractions of it: the lattice error is a sawtooth in the position of the
contact line between two nodes, so the error of a level is the worst over the shifts. The check
passes if

    error on the finest grid <= bar    and    low <= order <= high,

order = -slope of log(error) over log(cells) by least squares. A quantity that the lattice gives
exactly has no order: then the error of every grid must stay below the limit, which is rounding,
and each spacing has one of the shifts, in turns.

The same measure is taken once more on the fitted mesh, which has no spacing to refine: its error
must stay below a limit of its own: rounding, unless the measure or the closed form is coarser.
"""

import itertools
import math
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

import numpy as np

from studies.verify.mesh import Fitted, Grid, Mesh
from studies.verify.scenes import Case

Band = tuple[float, float]
Numbers = Any  # a number, an array, or nested lists of them

# Bands of the observed order: over three halvings the next order changes it by some per cent.
SECOND: Band = (1.8, 2.2)
FIRST: Band = (0.85, 1.15)
EXACT = None  # in place of a band: a quantity that has no discretisation error
# Largest error of second order on the finest grid, 400 links in l: (1/400)² = 6e-6.
SECOND_BAR = 5e-6
ROUNDING = 1e-10  # of a quantity that a discretisation gives exactly: a million roundings
DIFFERENCED = 1e-9  # fitted_bar of a measure that takes differences of the field
_FEWEST_LEVELS = 4  # with fewer an order is not read


@dataclass(frozen=True)
class Comparison:
    """What was simulated beside what it should be; error = max |difference|/scale.

    Attributes
    ----------
    simulated, closed_form : number, array or nested lists of numbers
        Their shapes broadcast.
    scale : number or array, optional
        What differences are measured by; None: the closed form.
    """

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


Found = Iterator[Comparison]  # what a check finds that compares several times


def swept(
    mesh: Mesh, cases: Iterable[Case], name: str, card: Callable[..., Any], **options: Any
) -> Found:
    """An attribute of states at several depths against a closed form.

    Parameters
    ----------
    mesh : Mesh
    cases : iterable of Case
    name : str
        The attribute of `Equilibrium`.
    card : callable
        The closed form, of depths and the arguments of a case.
    options : optional
        Of `Mesh.solve`.

    Yields
    ------
    Comparison
        One for each case.
    """
    for scene, depths, given in cases:
        yield Comparison(mesh.sweep(scene, depths, name, **options), card(depths, **given))


@dataclass(frozen=True)
class Check:
    """One statement about a numbered equation of the paper, or beyond the paper.

    Attributes
    ----------
    equations : tuple of int
        Their numbers; empty beyond the paper.
    what : str
        What is measured.
    measure : callable
        Of a mesh, to one `Comparison` or several.
    order : tuple of two floats, or None
        Band of the order of convergence; None for a quantity that the lattice gives exactly.
    bar : float
        Largest relative error on the finest grid.
    unit : str
    anchored : bool
        Whether it is not repeated on shifted grids: for a quantity that is of second order only
        with the tip of the indenter on a node.
    fitted_bar : float
        Largest relative error on the fitted mesh.
    lattice_only : str
        Why the measure has no meaning on the fitted mesh; "" if it has one.
    """

    equations: tuple[int, ...]
    what: str
    measure: Callable[[Any], Comparison | Iterable[Comparison]]
    order: Band | None
    bar: float
    unit: str = ""
    anchored: bool = False
    fitted_bar: float = ROUNDING
    lattice_only: str = ""

    def __reduce__(self) -> tuple[Any, ...]:
        """Pickled by name: the decorated function's name in its module is this check."""
        return _named, (self.measure.__module__, self.measure.__qualname__)


def _named(module: str, name: str) -> Check:
    """The check of this name in a module, for a process that is given it by name."""
    found: Check = getattr(import_module(module), name)
    return found


def check(
    *equations: int,
    what: str,
    order: Band | None = SECOND,
    bar: float | None = None,
    **options: Any,
) -> Callable[[Callable[[Any], Comparison | Iterable[Comparison]]], Check]:
    """Decorator: turns a function Mesh -> Comparison, or a generator of several, into a Check.

    Parameters
    ----------
    equations : int
        Their numbers.
    what, order : as in `Check`
    bar : float, optional
        The usual one of the order if not given.
    options : optional
        The further fields of `Check`.

    Returns
    -------
    callable

    Raises
    ------
    ValueError
        For an order that has no usual limit, without `bar`.
    """
    if bar is None:
        if order not in (SECOND, EXACT):
            raise ValueError(f"order = {order!r} has no usual limit; give bar=...")
        bar = SECOND_BAR if order == SECOND else ROUNDING
    return lambda measure: Check(equations, what, measure, order, bar, **options)


@dataclass(frozen=True)
class Result:
    """Outcome of a check.

    Attributes
    ----------
    check : Check
    simulated, closed_form : float
        Of the worst case on the finest grid.
    cells : tuple of int
        Links per reference length of each level.
    errors : tuple of float
        Largest relative error of each level.
    fitted_error : float
        On the fitted mesh; NaN for a check that only a lattice can do.
    seconds : float
        What it took.
    note : str
        What failed.
    """

    check: Check = field(repr=False)
    simulated: float
    closed_form: float
    cells: tuple[int, ...]
    errors: tuple[float, ...]
    fitted_error: float
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
    def lattice_passed(self) -> bool:
        """Whether the lattice's error stays below the limit and its order lies in the band."""
        band = self.check.order
        in_band = band is None or band[0] <= self.observed_order <= band[1]
        return self.error <= self.check.bar and in_band

    @property
    def fitted_passed(self) -> bool:
        """Whether the fitted mesh's error stays below its limit, where it is asked for."""
        return bool(self.check.lattice_only) or self.fitted_error <= self.check.fitted_bar

    @property
    def passed(self) -> bool:
        """Whether both discretisations passed."""
        return self.lattice_passed and self.fitted_passed


def observed_order(cells: Sequence[int], errors: Sequence[float]) -> float:
    """-slope of log(error) over log(cells); nan with fewer than four levels or a zero error."""
    if len(errors) < _FEWEST_LEVELS or not all(0 < e < math.inf for e in errors):
        return math.nan
    return -float(np.polyfit(np.log(cells), np.log(errors), 1)[0])


def refine(
    item: Check,
    cells: Sequence[int],
    offsets: Sequence[float],
    exact: int | None = None,
    cases: int | None = None,
) -> Result:
    """Run a check on every level and shift, and on the fitted mesh.

    An error raised by the simulator fails the check.

    Parameters
    ----------
    item : Check
    cells : sequence of int
        Links per reference length of each level, growing.
    offsets : sequence of float
        Shifts of the grid in links.
    exact : int, optional
        On how many levels, from the coarsest on, an exact quantity is measured; None: on all. In
        these the shifts take turns.
    cases : int, optional
        How many of the check's comparisons are made; None: all.

    Returns
    -------
    Result
    """
    start = time.perf_counter()
    shifts = (0.0,) if item.anchored else offsets
    grids: list[list[Mesh]] = [[Grid(n, shift) for shift in shifts] for n in cells]
    if not item.order:
        grids = [[own[i % len(own)]] for i, own in enumerate(grids[:exact])]
    levels, problem = _worst(item, grids, cases)
    simulated = math.nan
    closed_form = math.nan
    if levels:
        _, simulated, closed_form = levels[-1]
    fitted_error, fitted_problem = _on_fitted(item, cases)
    notes = [problem, fitted_problem and f"fitted: {fitted_problem}"]
    return Result(
        check=item,
        simulated=simulated,
        closed_form=closed_form,
        cells=tuple(cells),
        errors=tuple(error for error, _, _ in levels),
        fitted_error=fitted_error,
        seconds=time.perf_counter() - start,
        note="; ".join(note for note in notes if note),
    )


def _on_fitted(item: Check, cases: int | None) -> tuple[float, str]:
    """The error on the fitted mesh, inf and why if there is none; NaN where it has no meaning."""
    if item.lattice_only:
        return math.nan, ""
    found, problem = _worst(item, [[Fitted()]], cases)
    if not found:
        return math.inf, problem
    error, _, _ = found[0]
    return error, ""


def _worst(
    item: Check, levels: Sequence[Sequence[Mesh]], cases: int | None
) -> tuple[list[tuple[float, float, float]], str]:
    """Of each level, the largest error and its two values; none, and why, if one cannot be had."""

    def largest(mesh: Mesh) -> tuple[float, float, float]:
        """The largest error of the comparisons on a mesh, and the two values it belongs to."""
        found = item.measure(mesh)
        every = [found] if isinstance(found, Comparison) else found
        return max(one.worst() for one in itertools.islice(every, cases))

    try:
        return [max(map(largest, level)) for level in levels], ""
    except (ValueError, ArithmeticError, RuntimeError) as problem:
        return [], f"{type(problem).__name__}: {problem}"
