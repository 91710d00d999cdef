"""The figure of a sweep of a scene: two observables along one or two axes.

Conventions:

- `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
- `plain_ticks` labels a logarithmic axis with plain numbers.
- `prefixed(values, unit)` is the unit with a prefix that suits the values: they are divided by its
  `size`, and its `symbol` is written.
- A `Record` has a result for every point of a grid: `column(name)` one number of each, NaN where
  there is none.
- `prefixed(values, unit)` is a `Unit` that suits values: they are divided by its `size`.
"""

import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from energy.arrays import Array, Mask
from energy.units import Unit, prefixed
from studies.scenes.grid import UNITS, Value
from studies.scenes.sweep.store import Record
from studies.shared.figures import BLUE, GREY, Figure, canvas, plain_ticks, shades

STATE = (("force", "force P", "N"), ("half_width", "half-width a", "m"))
PATH = (
    ("pull_off_force", "most tensile force P", "N"),
    ("dissipated", "energy lost on the path", "J"),
)
WORDS = {
    "depth": "depth d",
    "layer.E": "Young's modulus E",
    "layer.nu": "Poisson's ratio ν",
    "layer.h": "thickness h",
    "surfaces.gamma1": "surface tension γ₁",
    "surfaces.w": "work of adhesion w",
    "opening.w": "work of adhesion w of opening",
    "indenter.R": "radius R",
    "indenter.half_width": "half-width of the punch",
    "indenter.delta": "angle δ of the wedge",
    "indenter.delta_degrees": "angle δ of the wedge",
    "path.machine_stiffness": "stiffness K of the machine",
    "options.spacing": "distance of the nodes",
}
# Line styles of matplotlib, which are told apart in greyscale; the pairs have lengths of strokes
# and gaps in points.
STYLES = ("-", "--", ":", "-.", (0, (5, 1, 1, 1, 1, 1)), (0, (1, 4)))
LINES = len(STYLES)  # of the second axis; more become a map
DETACHED = {"marker": "x", "color": GREY, "ls": "", "label": "detached"}
UNRESOLVED = {
    "marker": "o",
    "color": GREY,
    "mfc": "white",
    "ls": "",
    "label": "not resolved by the lattice, error unknown",
}


def conventions(per_length: str) -> str:
    """The units of the table, `per_length` as of `Scene`."""
    what = "per unit length of the line contact" if per_length else "of the whole contact"
    return (
        f"units: SI, {what}: lengths in m, forces in N{per_length}, energies in J{per_length}, "
        "angles in rad; error_* are estimated errors in these units, nan where the lattice does "
        "not resolve the state; where the label is detached, half_width, force and energy are 0"
    )


def plot(record: Record, title: str, per_length: str = "/m") -> Figure:
    """Over the longest axis, a line per value of the second, or a map; other axes at the first.

    What that leaves out is said above; what a line or a mark means, below. A state that the lattice
    does not resolve has no error bar, but an open circle.
    """
    figure, panels = canvas(11, 5.2, 1, 2)
    shape = [len(axis.values) for axis in record.grid.axes]
    order = sorted(range(len(shape)), key=lambda i: -shape[i])
    first = order[0]
    second = order[1] if len(order) > 1 else None
    path = any("pull_off_force" in result.get("found", {}) for result in record.results)
    for axes, (name, label, plain_unit) in zip(panels, PATH if path else STATE, strict=True):
        table = _tabulated(record.column(name), shape, first, second)
        error = _tabulated(record.column(f"error_{name}"), shape, first, second)
        detached = _tabulated(record.detached, shape, first, second)
        unresolved = _tabulated(_unresolved(record, name), shape, first, second)
        unit = prefixed(table, plain_unit if plain_unit == "m" else plain_unit + per_length)
        values = Values(table / unit.size, error / unit.size, detached, unresolved)
        _draw(axes, record, (first, second), values, f"{label} in {unit.symbol}")
    left_out = [(i, record.grid.axes[i].values) for i in order[2:]]
    fixed = ", ".join(
        _named(record, i, v[0]) + f", one of {len(v)}" * (len(v) > 1) for i, v in left_out
    )
    if any(len(values) > 1 for _, values in left_out):
        fixed = f"shown at {fixed}; the others are in the table"
    named: dict[str, Any] = {}
    for axes in panels:
        handles, labels = axes.get_legend_handles_labels()
        named |= dict(zip(labels, handles, strict=True))
    if named:
        figure.legend(
            list(named.values()), list(named), loc="outside lower center", ncols=3, fontsize=9
        )
    failed = f"{record.failed} of {len(record.results)} points failed" if record.failed else ""
    figure.suptitle("\n".join(filter(None, (title, fixed, failed))), fontsize=13)
    return figure


class Values(NamedTuple):
    """An observable over one axis or two.

    Attributes
    ----------
    table, error : ndarray (n,) or (n, m)
        The error is nan where it is not known.
    detached, unresolved : ndarray of bool, likewise
        Which states are detached, and which ones in contact the lattice does not resolve.
    """

    table: Array
    error: Array
    detached: Mask
    unresolved: Mask

    @property
    def attached(self) -> Array:
        """The observable in contact, nan elsewhere: a line through it ends at detachment."""
        return np.where(self.detached, math.nan, self.table)


def _tabulated(column: Any, shape: Sequence[int], first: int, second: int | None) -> Any:
    """One number for each result (points,) as a table over the axes that are drawn.

    shape: numbers of values of all axes of the grid, the last of which varies fastest. Without a
    second axis the table is (n,), else (n, m): rows along the first. Other axes are taken at their
    first value.
    """
    drawn = (first, second)
    keep = tuple(slice(None) if i in drawn else 0 for i in range(len(shape)))
    table = column.reshape(shape)[keep]
    in_other_order = second is not None and first > second
    return table.T if in_other_order else table


def _unresolved(record: Record, name: str) -> Mask:
    """Which states in contact have an estimate of the error that is no number (n,)."""
    key = f"error_{name}"
    estimated = np.array([key in result.get("found", {}) for result in record.results])
    return np.asarray(estimated & np.isnan(record.column(key)) & ~record.detached)


def _draw(
    axes: Any, record: Record, chosen: tuple[int, int | None], values: Values, quantity: str
) -> None:
    """The values over the axes chosen: lines through the states in contact, or a map of them.

    Crosses are detached states, open circles those that the lattice does not resolve.
    """
    x = _coordinates(axes, "x", record, chosen[0])
    if chosen[1] is None:
        axes.errorbar(x, values.attached, yerr=values.error, fmt="o-", color=BLUE, ms=3, capsize=2)
        _marks(axes, x, values)
    elif values.table.shape[1] <= LINES:
        _lines(axes, x, values, record, chosen[1])
    else:
        y = _coordinates(axes, "y", record, chosen[1])
        shown = {"cmap": "cividis", "shading": "nearest", "rasterized": True}
        colours = axes.pcolormesh(x, y, values.attached.T, **shown)
        axes.figure.colorbar(colours, ax=axes, label=quantity)
        for which, mark in ((values.unresolved, UNRESOLVED), (values.detached, DETACHED)):
            i, j = np.nonzero(which)
            if i.size:
                axes.plot(x[i], y[j], ms=4, **mark)
        return
    axes.set_ylabel(quantity)
    axes.grid(alpha=0.25)


def _marks(axes: Any, x: Array, values: Values) -> None:
    """The states that are detached or that the lattice does not resolve, if there are any."""
    for which, mark in ((values.unresolved, UNRESOLVED), (values.detached, DETACHED)):
        if which.any():
            i = np.nonzero(which)[0]
            axes.plot(x[i], values.table[which], ms=5, zorder=3, **mark)


def _lines(axes: Any, x: Array, values: Values, record: Record, second: int) -> None:
    """A line over x (n,) for each value of the second axis, a column of the values (n, m).

    It ends where the contact detaches; errors are bars. There are at most LINES of them.
    """
    axis = record.grid.axes[second]
    colours = shades(len(axis.values), "cividis")
    columns = values.attached.T
    errors = values.error.T
    for value, colour, line_style, column, error in zip(
        axis.values, colours, STYLES, columns, errors, strict=False
    ):
        line = {"color": colour, "ls": line_style, "lw": 1.8}
        points = {"marker": "o", "ms": 3, "capsize": 2}
        name = _named(record, second, value)
        axes.errorbar(x, column, yerr=error, label=name, **line, **points)
    _marks(axes, x, values)


def _named(record: Record, i: int, value: Value) -> str:
    """What an axis is and one of its values with its unit."""
    unit = _unit(record, i)
    if isinstance(value, str):
        return f"{_words(record, i)} = {value}"
    number = f"{value / unit.size:.4g}".replace("-", "−")
    return f"{_words(record, i)} = {number} {unit.symbol}".rstrip()


def _words(record: Record, i: int) -> str:
    """What an axis is, in words; its key where there are none."""
    key = record.grid.axes[i].key
    return WORDS.get(key, key)


def _unit(record: Record, i: int) -> Unit:
    """The unit in which an axis is labelled, with a prefix that suits its values."""
    axis = record.grid.axes[i]
    unit = UNITS.get(axis.key, "")
    if not unit or unit in ("°", "rad") or isinstance(axis.values[0], str):
        return Unit(1.0, unit)
    return prefixed(axis.values, unit)


def _coordinates(axes: Any, which: str, record: Record, i: int) -> Array:
    """Positions along x or y, whose label and scale are set; texts stand at their numbers."""
    axis = record.grid.axes[i]
    unit = _unit(record, i)
    if isinstance(axis.values[0], str):
        axes.set(**{f"{which}label": f"{_words(record, i)}: {', '.join(map(str, axis.values))}"})
        return np.arange(len(axis.values), dtype=float)
    values = np.array(axis.values, float)
    label = _words(record, i) + (f" in {unit.symbol}" if unit.symbol else "")
    log = _by_ratios(values)
    axes.set(**{f"{which}scale": "log" if log else "linear", f"{which}label": label})
    if log:
        plain_ticks(axes.xaxis if which == "x" else axes.yaxis)
    return values / unit.size


def _by_ratios(values: Array) -> bool:
    """Whether values are spaced by ratios rather than by differences, as a logarithmic range is."""
    if values.size < 3 or not (values > 0).all():
        return False
    ratios = np.abs(np.diff(np.log(values)))
    steps = np.abs(np.diff(values))
    # max/min of the ratios against max/min of the steps, without a division by 0
    return bool(ratios.max() * steps.min() < steps.max() * ratios.min())
