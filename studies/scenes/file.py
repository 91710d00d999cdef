"""Scene files (TOML, SI units): one scene, and what is asked of it: depths, a load path, or both.

    title = "..."                 # optional, as is source: where the parameters come from
    source = "..."
    depth = 1e-6                  # m; or a list, or { from = -1e-6, to = 2e-6, steps = 40 }

    [layer]
    E = 3e3                       # Pa
    nu = 0.45
    h = 50e-6                     # m
    response = "springs"          # optional; "layer": the exact response, nu up to 0.5

    [surfaces]                    # J/m²
    gamma1 = 0.07
    gamma2 = 0.03                 # gamma2 and gamma12, or w instead of both
    gamma12 = 0.0997

    [opening]                     # optional: of a contact that opens, with the same gamma1;
    w = 6e-4                      # gamma2 and gamma12, or w; needs [path] in place of depth

    [indenter]
    shape = "parabola"            # plane | flat_punch half_width | wedge delta (rad) or
    R = 0.1                       # delta_degrees | parabola, circle, sphere R | power_law c, n |
                                  # sampled x, z, kind or file (studies/scenes/curve_file.py)
    tilted = 0.0                  # optional slope, applied first
    shifted = 0.0                 # optional distance in m

    [path]                        # optional: a load path
    depths = [-1e-6, 2e-6, -1e-6] # m, turning points; or forces in N/m; or drives in m, the far end
    machine_stiffness = 1e4       # drives only, Pa: of the spring between drive and indenter
    steps = 50                    # between turning points; a range has its own

    [options]                     # optional, as in discretization.minimise and energy.Scene
    slopes = "small"
    geometry = "line"             # or "axisymmetric": x is the radius r, forces are in N
    method = "auto"
    branch = "adhered"
    spacing = 1e-6                # method = "lattice" only
    rtol = 1e-8

    [measured]                    # optional: how `fit` reads a curve (studies/scenes/curve_file.py)

title, source and depth stand above the first [section], as TOML has it. Unknown keys, missing keys
and values of a wrong type are refused by file and key. A list or a range for any other number
makes a sweep (studies/scenes/grid.py). `python -m studies new FILE` writes a commented file.

Conventions:

- A scene has `stiffness` k = Ẽ/h.
- `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
- A `Table` reads a table of the file key by key: `number`, `text`, `spread` (a number, list or
  range) return a checked value, `refuse` and `error` name file, line and key, and `build` passes
  their names to the errors of what it calls.
- TOP are the keys above the first section.
"""

import math
import tomllib
from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np

import energy
from energy import ElasticLayer, Indenter, Scene, SurfaceEnergies
from energy.arrays import Array
from energy.checks import nearest
from studies.scenes import curve_file
from studies.scenes.curve_file import Reading
from studies.scenes.table import TOP, Table

SHAPES: dict[str, tuple[Any, tuple[str, ...]]] = {
    "plane": (energy.Plane, ()),
    "flat_punch": (energy.FlatPunch, ("half_width",)),
    "wedge": (energy.Wedge, ("delta", "delta_degrees")),
    "parabola": (energy.Parabola, ("R",)),
    "circle": (energy.Circle, ("R",)),
    "sphere": (energy.Circle, ("R",)),
    "power_law": (energy.PowerLaw, ("c", "n")),
    "sampled": (energy.Sampled, ("x", "z")),
}
TEXTS = ("slopes", "geometry", "method", "branch")
NUMBERS = ("spacing", "rtol")  # [options]
ENERGIES = ("gamma2", "gamma12", "w")
CONTROLS = ("depths", "forces", "drives")
STEPS = 50  # between turning points of a path, unless the file says otherwise


@dataclass(frozen=True)
class Programme:
    """A load path as a file gives it.

    Attributes
    ----------
    control : {"depths", "forces", "drives"}
    values : ndarray (n,)
        Of the control [m] or [N/m].
    machine_stiffness : float or None
        For drives [Pa].
    """

    control: str
    values: Array
    machine_stiffness: float | None


@dataclass(frozen=True)
class SceneFile:
    """What a scene file says.

    Attributes
    ----------
    path : Path
    title, source : str
    scene : Scene
    depths : ndarray (n,)
        Empty for a file that has a load path alone.
    options : dict
        Of `minimise`.
    programme : Programme or None
        The load path.
    measured : Reading
        How a curve to fit is read.
    """

    path: Path
    title: str
    source: str
    scene: Scene
    depths: Array
    options: dict[str, Any]
    programme: Programme | None = None
    measured: Reading = field(default_factory=Reading)


def load(path: str | Path) -> SceneFile:
    """Read and check a scene file.

    Parameters
    ----------
    path : str or Path

    Returns
    -------
    SceneFile

    Raises
    ------
    ValueError
        Naming file, key, value and the known keys.
    """
    path = Path(path)
    return built(path, read(path))


def read(path: Path) -> dict[str, Any]:
    """The tables of a file, unchecked.

    Parameters
    ----------
    path : Path

    Returns
    -------
    dict

    Raises
    ------
    ValueError
        For a file that cannot be read as TOML.
    """
    try:
        return tomllib.loads(path.read_text("utf-8-sig"))
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}; give the path of a scene file") from None
    except ValueError as error:
        raise ValueError(f"{path}: cannot be read as TOML: {error}") from None


def built(path: Path, content: Mapping[str, Any]) -> SceneFile:
    """What the tables of a scene file describe.

    Parameters
    ----------
    path : Path
        Named in errors.
    content : mapping
        As `read` gives it.

    Returns
    -------
    SceneFile

    Raises
    ------
    ValueError
        Naming file, key, value and the known keys.
    """
    file = Table(path, "file", content, TOP)
    chosen = Table(path, "options", content.get("options", {}), (*TEXTS, *NUMBERS))
    options: dict[str, Any] = {}
    for key in chosen.table:
        options[key] = chosen.text(key) if key in TEXTS else chosen.number(key)
    slopes = options.pop("slopes", "small")
    geometry = options.pop("geometry", "line")
    film = Table(path, "layer", file.get("layer"), ("E", "nu", "h", "response"))
    E = film.number("E")
    nu = film.number("nu")
    h = film.number("h")
    layer = film.build(ElasticLayer, E, nu, h, film.text("response", "springs"))
    energies = Table(path, "surfaces", file.get("surfaces"), ("gamma1", *ENERGIES))
    surfaces = _energies(energies, energies.number("gamma1"))
    opening = None
    if "opening" in content:
        own = Table(path, "opening", content["opening"], ENERGIES)
        opening = _energies(own, surfaces.gamma1)
    indenter = _indenter(path, file.get("indenter"))
    try:
        if content["indenter"]["shape"] == "sphere" and geometry != "axisymmetric":
            raise ValueError(
                'indenter.shape = "sphere" is a turned body: set geometry = "axisymmetric" in '
                "[options], or take the line contact of a parabola or circle"
            )
        scene = Scene(layer, surfaces, indenter, slopes, opening, geometry=geometry)
    except ValueError as error:
        raise ValueError(f"{path}: {error}") from None
    programme = _programme(path, content["path"], options) if "path" in content else None
    title = file.text("title", path.stem)
    source = file.text("source", "not stated")
    measured = curve_file.reading(path, content.get("measured", {}))
    if scene.axisymmetric:
        if measured.width is not None:
            refusal = f"width = {measured.width!r} with geometry = 'axisymmetric': leave it out"
            raise ValueError(f"{path}: measured.{refusal}")
        measured = replace(measured, width=1.0)  # forces are those of the whole contact
    return SceneFile(path, title, source, scene, _depths(file), options, programme, measured)


def _energies(table: Table, gamma1: float) -> SurfaceEnergies:
    """Surface energies with this γ₁ and γ₂ and γ₁₂, or w."""
    if "w" not in table.table:
        gamma2 = table.number("gamma2")
        gamma12 = table.number("gamma12")
        return table.build(SurfaceEnergies, gamma1, gamma2, gamma12)
    for key in ("gamma2", "gamma12"):
        if key in table.table:
            table.refuse(key, table.table[key], "contradicts w: give w, or gamma2 and gamma12")
    return table.build(SurfaceEnergies.from_work, gamma1, table.number("w"))


def _indenter(path: Path, content: Any) -> Indenter:
    """The indenter of the table [indenter], tilted and shifted."""
    keys_given = tuple(content) if isinstance(content, Mapping) else ()
    shape = Table(path, "indenter", content, keys_given).text("shape")
    if shape not in SHAPES:
        raise ValueError(
            f"{path}: indenter.shape = {shape!r} is unknown{nearest(shape, SHAPES)}; known shapes: "
            f"{', '.join(SHAPES)}"
        )
    kind, keys = SHAPES[shape]
    extra = ("kind", *curve_file.PROFILE) if shape == "sampled" else ()
    known = ("shape", *keys, *extra, "shifted", "tilted")
    table = Table(path, "indenter", content, known)
    indenter: Indenter
    if "file" in table.table:
        indenter = curve_file.profile(table)
    elif shape == "sampled":
        for key in curve_file.PROFILE[1:]:
            if key in table.table:
                table.refuse(key, table.table[key], "needs file: x and z in this file are in m")
        samples = map(table.numbers, keys)
        indenter = table.build(kind, *samples, table.text("kind", "linear"))
    else:
        numbers = [_wedge_angle(table)] if shape == "wedge" else map(table.number, keys)
        indenter = table.build(kind, *numbers)
    if "tilted" in table.table:
        indenter = indenter.tilted(table.number("tilted"))
    return indenter.shifted(table.number("shifted")) if "shifted" in table.table else indenter


def _wedge_angle(table: Table) -> float:
    """δ in rad from delta or delta_degrees, one of the two."""
    if {"delta", "delta_degrees"} <= set(table.table):
        raise table.error("delta_degrees stands beside delta: give one of the two")
    if "delta_degrees" not in table.table:
        return table.number("delta")
    if not 0 < table.number("delta_degrees") < 90:
        table.refuse("delta_degrees", table.table["delta_degrees"], "is outside (0, 90)")
    return math.radians(table.number("delta_degrees"))


def _depths(file: Table) -> Array:
    """The depths of a file; none where it has a load path alone."""
    if "depth" not in file.table and "path" in file.table:
        return np.empty(0)
    if "opening" in file.table:
        depth = file.get("depth")
        why = "cannot stand beside [opening]: the state depends on the path; write a [path] instead"
        file.refuse("depth", depth, why)
    return np.array(file.spread("depth"))


def _programme(path: Path, content: Any, options: Mapping[str, Any]) -> Programme:
    """The load path of the table [path]."""
    table = Table(path, "path", content, (*CONTROLS, "machine_stiffness", "steps"))
    given = [name for name in CONTROLS if name in table.table]
    if len(given) != 1:
        found = " and ".join(given) or "none"
        raise table.error(f"path needs exactly one of {', '.join(CONTROLS)}; got {found}")
    (control,) = given
    stiffness = table.number("machine_stiffness") if "machine_stiffness" in table.table else None
    if (control == "drives") != (stiffness is not None):
        why = "does not fit: drives need machine_stiffness > 0, other controls have none"
        table.refuse("machine_stiffness", stiffness, f"with {control} {why}")
    for key, known in (("method", ("auto", "fitted", "lattice")), ("branch", ("adhered",))):
        if options.get(key, known[0]) not in known:
            why = f"cannot be honoured on a [path]; it takes {', '.join(known)}"
            raise ValueError(f"{path}: options.{key} = {options[key]!r} {why}")
    return Programme(control, _legs(table, control), stiffness)


def _legs(table: Table, control: str) -> Array:
    """The turning points joined by `steps` steps each; a range as it is."""
    values = table.spread(control)
    if isinstance(table.table[control], Mapping):
        if "steps" in table.table:
            table.refuse("steps", table.table["steps"], f"stands beside the steps of {control}")
        return np.array(values)
    steps = table.whole("steps", 1) if "steps" in table.table else STEPS
    legs = [np.linspace(start, end, steps + 1)[1:] for start, end in pairwise(values)]
    return np.concatenate([values[:1], *legs])
