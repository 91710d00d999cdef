"""The grid of a scene file: every key whose value is a list or a range is an axis of a sweep.

    [layer]
    h = [10e-6, 20e-6]                                          # a list
    [surfaces]
    w = { from = 1e-5, to = 1e-3, steps = 40, spacing = "log" } # a range; spacing: or "linear"

Any number in a section can be an axis, and so can the texts of [options]. A list or range for
`depth` is the last axis; the turning points of [path] and the samples of a profile are no axes.
Points are numbered with the last axis running fastest.

Conventions:

- `AccuracyWarning` says that the estimated error of a state exceeds its rtol.
- `Table` is a table of a file; its methods check a key and refuse its value by name.
- `built` makes a `SceneFile` of tables, with a `scene`, `depths` and a `programme`, the load path.
- CONTROLS, ENERGIES and TOP are keys.
- `of_states` finds many states at once where they are `vectorised`.
"""

import math
import warnings
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from discretization import AccuracyWarning, History, load_path, minimise
from discretization.readings import most_tensile
from energy import Scene
from studies.scenes.file import CONTROLS, ENERGIES, STEPS, SceneFile, built
from studies.scenes.table import TOP, Table
from studies.scenes.together import of_states, vectorised

Value = float | str
# Of a first look: values of an axis, enough to see a trend and its bend, and steps between turns.
_FIRST_LOOK = 5
_FIRST_STEPS = 10
# keys that states which are found together may differ in
_TOGETHER = (
    *("depth", "layer.E", "layer.nu", "layer.h"),
    *("surfaces.gamma1", "surfaces.gamma2", "surfaces.gamma12", "surfaces.w"),
)
NO_AXES = {f"path.{name}" for name in CONTROLS} | {
    *("indenter.x", "indenter.z", "indenter.columns", "measured.columns")
}
UNITS = {
    **dict.fromkeys(("depth", "layer.h", "options.spacing", "indenter.shifted"), "m"),
    **dict.fromkeys(("indenter.R", "indenter.half_width"), "m"),
    **dict.fromkeys(("layer.E", "path.machine_stiffness"), "Pa"),
    **{"indenter.delta": "rad", "indenter.delta_degrees": "°", "surfaces.gamma1": "J/m²"},
    **{f"{name}.{key}": "J/m²" for name in ("surfaces", "opening") for key in ENERGIES},
}


class Axis(NamedTuple):
    """A key of the file ("layer.h") and the values it takes."""

    key: str
    values: tuple[Value, ...]


@dataclass(frozen=True)
class Grid:
    """All combinations of the values of some axes, numbered with the last axis fastest."""

    axes: tuple[Axis, ...]

    def __post_init__(self) -> None:
        """Refuse an axis without values."""
        for axis in self.axes:
            if not axis.values:
                raise ValueError(f"{axis.key} = () has no values; give at least one")

    def __len__(self) -> int:
        """Number of its points."""
        return math.prod(len(axis.values) for axis in self.axes)

    def point(self, number: int) -> dict[str, Value]:
        """The values at a point, by key.

        Parameters
        ----------
        number : int
            Of the point, from 0.

        Returns
        -------
        dict
        """
        at: list[Value] = []
        for axis in reversed(self.axes):
            number, i = divmod(number, len(axis.values))
            at.append(axis.values[i])
        return dict(zip((axis.key for axis in self.axes), reversed(at), strict=True))


def axes(path: Path, content: Mapping[str, Any]) -> tuple[Axis, ...]:
    """The axes of the tables of a scene file, in their order, depth last.

    Parameters
    ----------
    path : Path
        Named in errors.
    content : mapping
        As `file.read` gives it.

    Returns
    -------
    tuple of Axis

    Raises
    ------
    ValueError
        For a list or a range that cannot be an axis.
    """
    found = []
    for name, table in content.items():
        if name in TOP and isinstance(table, Mapping) and name != "depth":
            known = Table(path, name, table, tuple(table))
            swept = [key for key in table if f"{name}.{key}" not in NO_AXES]
            found += [_axis(known, key) for key in swept if isinstance(table[key], list | Mapping)]
    if isinstance(content.get("depth"), list | Mapping):
        found.append(_axis(Table(path, "file", content, TOP), "depth"))
    return tuple(found)


def _axis(table: Table, key: str) -> Axis:
    """The axis of a key whose value is a list or a range."""
    name = key if table.name == "file" else f"{table.name}.{key}"
    raw = table.table[key]
    if isinstance(raw, list) and raw and all(isinstance(value, str) for value in raw):
        return Axis(name, tuple(raw))
    values = tuple(table.spread(key))
    if len(set(values)) < len(values):
        table.refuse(key, raw, "has a value twice; give each once")
    return Axis(name, values)


def placed(content: Mapping[str, Any], point: Mapping[str, Value]) -> dict[str, Any]:
    """The tables of one point of the grid."""
    tables = {name: dict(t) if isinstance(t, Mapping) else t for name, t in content.items()}
    for key, value in point.items():
        section, _, name = key.rpartition(".")
        (tables[section] if section else tables)[name] = value
    return tables


def coarser(content: Mapping[str, Any]) -> dict[str, Any]:
    """The tables for a first look: at most 5 values of an axis, and 10 steps of a leg."""
    tables = placed(content, {})
    for name, table in tables.items():
        if name == "depth":
            tables[name] = _thinned(table)
        elif isinstance(table, dict):
            for key in table:
                if f"{name}.{key}" not in NO_AXES:
                    table[key] = _thinned(table[key])
    path = tables.get("path")
    if isinstance(path, dict) and any(isinstance(path.get(name), list) for name in CONTROLS):
        given = path.get("steps", STEPS)
        path["steps"] = min(given, _FIRST_STEPS) if isinstance(given, int) else given
    return tables


def _thinned(value: Any, most: int = _FIRST_LOOK) -> Any:
    """A list or range of at most so many values, its ends among them."""
    if isinstance(value, list) and len(value) > most:
        return [value[round(i * (len(value) - 1) / (most - 1))] for i in range(most)]
    if isinstance(value, Mapping) and isinstance(value.get("steps"), int):
        return {**value, "steps": min(value["steps"], most)}
    return value


@dataclass(frozen=True)
class SolvedScene:
    """What the file says at one point of the grid, as a function of the swept keys."""

    path: Path
    content: Mapping[str, Any]

    def __call__(self, point: Mapping[str, Value]) -> dict[str, Value]:
        """Observables of the equilibrium, or of the load path where the file has one."""
        given = built(self.path, placed(self.content, point))
        if given.programme is not None:
            return of_path(follow(given))
        (depth,) = given.depths.tolist()
        return of_state(given.scene, depth, given.options)

    def many(self, points: Sequence[Mapping[str, Value]]) -> list[dict[str, Value] | None]:
        """Observables at many points, found together where `discretization.minimise_many` does.

        None where it does not: elsewhere, and where a point is wrong, which then says so itself.
        """
        found: list[dict[str, Value] | None] = [None] * len(points)
        if "path" in self.content:
            return found
        groups: dict[Any, list[int]] = {}
        for i, point in enumerate(points):
            others = tuple((key, value) for key, value in point.items() if key not in _TOGETHER)
            groups.setdefault(others, []).append(i)
        for own in groups.values():
            for i, values in zip(own, self._group([points[i] for i in own]), strict=True):
                found[i] = values
        return found

    def _group(self, points: Sequence[Mapping[str, Value]]) -> list[dict[str, Value] | None]:
        """The same of points that differ in depth, surface energies and layer alone."""
        scenes = list[Scene]()
        made = dict[Any, SceneFile]()
        try:
            for point in points:
                own = tuple(value for key, value in point.items() if key != "depth")
                if own not in made:
                    made[own] = built(self.path, placed(self.content, point))
                scenes.append(made[own].scene)
        except ValueError:
            return [None] * len(points)
        given = next(iter(made.values()))
        if not vectorised(given):
            return [None] * len(points)
        depth = self.content.get("depth")
        depths = [point.get("depth", depth) for point in points]
        return of_states(scenes, np.array(depths, float))

    def identity(self, keys: Sequence[str]) -> Any:
        """What besides the axes determines the numbers, as plain data."""
        blank = placed(self.content, dict.fromkeys(keys, "swept"))
        return {name: table for name, table in blank.items() if name not in ("title", "source")}


def follow(given: SceneFile) -> History:
    """The load path of a scene file.

    Parameters
    ----------
    given : SceneFile

    Returns
    -------
    History

    Raises
    ------
    ValueError
        Naming the file, without a [path] and for what `load_path` refuses.
    """
    programme = given.programme
    options = given.options
    if programme is None:
        raise ValueError(f"{given.path}: path is missing; add a [path] with depths to the file")
    programmed: dict[str, Any] = {programme.control: programme.values}
    lattice = options.get("method") == "lattice"
    try:
        return load_path(
            given.scene,
            **programmed,
            machine_stiffness=programme.machine_stiffness,
            method="lattice" if lattice else "fitted",
            spacing=options.get("spacing"),
            rtol=options.get("rtol", 1e-8),
        )
    except ValueError as error:
        raise ValueError(f"{given.path}: [path]: {error}") from error


def of_state(scene: Scene, depth: float, options: Mapping[str, Any]) -> dict[str, Value]:
    """Half-width, force, energy with their errors, angle [rad], label, violated assumptions.

    Parameters
    ----------
    scene : Scene
    depth : float
    options : mapping
        Of `minimise`.

    Returns
    -------
    dict
    """
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # the errors are among the results
        state = minimise(scene, depth, **options)
    broken = "; ".join(one.name for one in state.validity if not one.holds)
    dropped = ("depth", "contacts", "branch", "method")
    found = {name: value for name, value in state.to_dict().items() if name not in dropped}
    return {**found, "violated": broken}


def of_path(history: History) -> dict[str, Value]:
    """The most tensile state, energy dissipated, and the kinds of events in their order.

    Parameters
    ----------
    history : History

    Returns
    -------
    dict
    """
    force, depth, half_width = most_tensile(history) or (math.nan,) * 3
    return {
        "pull_off_force": float(force),
        "pull_off_depth": float(depth),
        "pull_off_half_width": float(half_width),
        "dissipated": float(history.dissipated),
        "events": "; ".join(event.kind for event in history.events),
    }
