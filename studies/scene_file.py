"""Scene files (TOML, SI units): one scene, one or several depths.

    title = "..."                 # optional, as is source: where the parameters come from
    source = "..."
    depth = 1e-6                  # m; or a list, or { from = -1e-6, to = 2e-6, steps = 40 }

    [layer]
    E = 3e3                       # Pa
    nu = 0.45
    h = 50e-6                     # m

    [surfaces]                    # J/m²
    gamma1 = 0.07
    gamma2 = 0.03                 # gamma2 and gamma12, or w instead of both
    gamma12 = 0.0997

    [indenter]
    shape = "parabola"            # plane | flat_punch half_width | wedge delta (rad) or
    R = 0.1                       # delta_degrees | parabola R | power_law c, n | sampled x, z, kind
    tilted = 0.0                  # optional slope, applied first
    shifted = 0.0                 # optional distance in m

    [options]                     # optional, as in discretization.minimise and energy.Scene
    slopes = "small"
    method = "auto"
    branch = "adhered"
    spacing = 1e-6                # method = "lattice" only
    rtol = 1e-8

title, source and depth stand above the first [section], as TOML has it. Unknown keys, missing keys
and values of a wrong type are refused by file and key.
"""

from __future__ import annotations

import math
import sys
import tomllib
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import numpy as np
from numpy.typing import NDArray

from energy import (
    ElasticLayer,
    FlatPunch,
    Indenter,
    Parabola,
    Plane,
    PowerLaw,
    Sampled,
    Scene,
    SurfaceEnergies,
    Wedge,
)

T = TypeVar("T")
SHAPES: dict[str, tuple[Any, tuple[str, ...]]] = {
    "plane": (Plane, ()),
    "flat_punch": (FlatPunch, ("half_width",)),
    "wedge": (Wedge, ("delta", "delta_degrees")),
    "parabola": (Parabola, ("R",)),
    "power_law": (PowerLaw, ("c", "n")),
    "sampled": (Sampled, ("x", "z")),
}
OPTIONS = {"slopes": str, "method": str, "branch": str, "spacing": float, "rtol": float}
SECTIONS = ("title", "source", "depth", "layer", "surfaces", "indenter", "options")


@dataclass(frozen=True)
class SceneFile:
    """What a scene file says: the scene, the depths (n,) and the options of `minimise`."""

    path: Path
    title: str
    source: str
    scene: Scene
    depths: NDArray[np.float64]
    options: dict[str, Any]


class _Table:
    """One table of the file; every complaint names the file, the key and what is known."""

    def __init__(self, path: Path, name: str, table: Any, known: tuple[str, ...]) -> None:
        self.path, self.name, self.known = path, name, known
        if not isinstance(table, Mapping):
            self.refuse(name, table, f"must be a table: [{name}]")
        self.table = table
        for key in table:
            if key not in known:
                misplaced = self.name != "file" and key in SECTIONS
                hint = " here: write it above the first [section]" if misplaced else ""
                self.refuse(key, table[key], f"is unknown{hint}")

    def refuse(self, key: str, value: Any, why: str) -> NoReturn:
        raise self.error(f"{key} = {value!r} {why}")

    def error(self, problem: str) -> ValueError:
        name = "" if self.name == "file" or problem.startswith(f"{self.name} ") else f"{self.name}."
        known = f"; known keys: {', '.join(self.known)}" if self.known else ""
        return ValueError(f"{self.path}: {name}{problem}{known}")

    def number(self, key: str) -> float:
        return self._finite(key, self.get(key))

    def numbers(self, key: str) -> list[float]:
        values = self.get(key)
        if not isinstance(values, list) or not values:
            self.refuse(key, values, "must be a list of at least one number")
        return [self._finite(f"{key}[{i}]", value) for i, value in enumerate(values)]

    def _finite(self, key: str, value: Any) -> float:
        if isinstance(value, bool) or not isinstance(value, int | float):
            self.refuse(key, value, "must be a number in SI units, without quotes and unit")
        if not abs(value) <= sys.float_info.max:
            self.refuse(key, value, "must be finite")
        return float(value)

    def text(self, key: str, default: str | None = None) -> str:
        value = self.get(key) if default is None else self.table.get(key, default)
        if not isinstance(value, str):
            self.refuse(key, value, "must be a text in quotes")
        return str(value)

    def get(self, key: str) -> Any:
        if key not in self.table:
            raise self.error(f"{key} is missing")
        return self.table[key]

    def build(self, kind: Callable[..., T], *values: Any) -> T:
        """kind(*values); what it refuses is told with the name of this table."""
        try:
            return kind(*values)
        except ValueError as error:
            raise ValueError(f"{self.path}: {self.name}.{error}") from None


def load(path: str | Path) -> SceneFile:
    """Read and check a scene file. ValueError naming file, key, value and the known keys."""
    path = Path(path)
    try:
        content = tomllib.loads(path.read_text("utf-8"))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}; give the path of a scene file") from None
    except ValueError as error:
        raise ValueError(f"{path}: cannot be read as TOML: {error}") from None
    file = _Table(path, "file", content, SECTIONS)
    options = _options(path, content.get("options", {}))
    slopes = options.pop("slopes", "small")
    layer = _layer(path, file.get("layer"))
    surfaces = _surfaces(path, file.get("surfaces"))
    indenter = _indenter(path, file.get("indenter"))
    try:
        scene = Scene(layer, surfaces, indenter, slopes)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    return SceneFile(
        path,
        file.text("title", path.stem),
        file.text("source", "not stated"),
        scene,
        _depths(file),
        options,
    )


def _layer(path: Path, content: Any) -> ElasticLayer:
    table = _Table(path, "layer", content, ("E", "nu", "h"))
    return table.build(ElasticLayer, *(table.number(key) for key in table.known))


def _surfaces(path: Path, content: Any) -> SurfaceEnergies:
    table = _Table(path, "surfaces", content, ("gamma1", "gamma2", "gamma12", "w"))
    if "w" not in table.table:
        return table.build(SurfaceEnergies, *(table.number(key) for key in table.known[:3]))
    for key in ("gamma2", "gamma12"):
        if key in table.table:
            table.refuse(key, table.table[key], "contradicts w: give w, or gamma2 and gamma12")
    return table.build(SurfaceEnergies.from_work, table.number("gamma1"), table.number("w"))


def _indenter(path: Path, content: Any) -> Indenter:
    shape = _Table(path, "indenter", content, tuple(content)).text("shape")
    if shape not in SHAPES:
        raise ValueError(
            f"{path}: indenter.shape = {shape!r} is unknown; known shapes: {', '.join(SHAPES)}"
        )
    kind, keys = SHAPES[shape]
    extra = ("kind",) if shape == "sampled" else ()
    known = ("shape", *keys, *extra, "shifted", "tilted")
    table = _Table(path, "indenter", content, known)
    arguments: list[Any]
    if shape == "wedge":
        arguments = [_wedge_angle(table)]
    elif shape == "sampled":
        arguments = [*map(table.numbers, keys), table.text("kind", "linear")]
    else:
        arguments = [*map(table.number, keys)]
    indenter: Indenter = table.build(kind, *arguments)
    if "tilted" in table.table:
        indenter = indenter.tilted(table.number("tilted"))
    return indenter.shifted(table.number("shifted")) if "shifted" in table.table else indenter


def _wedge_angle(table: _Table) -> float:
    """δ in rad from delta or delta_degrees, one of the two."""
    if {"delta", "delta_degrees"} <= set(table.table):
        raise table.error("delta_degrees stands beside delta: give one of the two")
    if "delta_degrees" not in table.table:
        return table.number("delta")
    if not 0 < table.number("delta_degrees") < 90:
        table.refuse("delta_degrees", table.table["delta_degrees"], "is outside (0, 90)")
    return math.radians(table.number("delta_degrees"))


def _options(path: Path, content: Any) -> dict[str, Any]:
    table = _Table(path, "options", content, tuple(OPTIONS))
    return {
        key: table.text(key) if OPTIONS[key] is str else table.number(key) for key in table.table
    }


def _depths(file: _Table) -> NDArray[np.float64]:
    depth = file.get("depth")
    if isinstance(depth, Mapping):
        steps = _Table(file.path, "depth", depth, ("from", "to", "steps"))
        count = steps.get("steps")
        if isinstance(count, bool) or not isinstance(count, int) or count < 2:
            steps.refuse("steps", count, "must be a whole number of at least 2")
        depths = np.linspace(steps.number("from"), steps.number("to"), count)
    elif isinstance(depth, list):
        depths = np.array(file.numbers("depth"))
    else:
        depths = np.array([file.number("depth")])
    depths.flags.writeable = False
    return depths
