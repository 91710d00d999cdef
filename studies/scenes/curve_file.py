"""Force–depth curves from files: text as instruments and spreadsheets write it, instrument files.

Text needs columns of the depth and of the force, by default named so, with units in the header, in
a row below it or given with their names: "Weg [µm]", "2 [mN]". A force in newtons is divided by the
`width`, the length of the line contact. Instrument files (.jpk-force, .ibw, .h5, .tab and others)
are read by the library afmformats, the extra elastocap[afm]: forces in newtons, and the depth is
that of the tip, - (height + force / spring constant of the cantilever), from an arbitrary zero. A
plain .h5 file with one data set of the depth and one of the force, each with an attribute "unit",
is read as text is. A column named drive or piezo is the position of the piezo, towards the layer.

What a scene file says of measured data:

[measured]                               # optional: how `fit` reads DATA
columns = ["Weg [µm]", "Kraft [mN]"]     # depth and force: names or numbers, with missing units
width = 0.01                             # m: length of the line contact, for forces in newtons
spring_constant = 0.08                   # N/m, of the cantilever: its noise is in the depth, too
curve = 3                                # of an instrument file with several
delimiter = ";"                          # and decimal, encoding, skip; else found from the file

[indenter]
shape = "sampled"
file = "scan.csv"                        # in place of x and z; beside the scene file
columns = ["x", "z [nm]"]                # and unit, delimiter, decimal, encoding, skip
"""

import importlib
import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

from energy import Sampled, read_profile, units
from energy.checks import positive
from energy.text_lines import Pattern, Row
from energy.text_table import Layout, TextTable, read_table
from studies.scenes.fit.force_curve import Array, Curve
from studies.scenes.table import Table

INSTRUMENT = (
    *(".jpk-force", ".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series"),
    *(".ibw", ".h5", ".tab", ".zip"),
)
LAYOUT = ("delimiter", "decimal", "encoding", "skip")
MEASURED = ("columns", "width", "curve", "spring_constant", *LAYOUT)
PROFILE = ("file", "columns", "unit", *LAYOUT)
DRIVES = ("drive", "piezo", "piezo position", "piezoweg")
DEPTHS = ("depth", "indentation", "Weg", "Tiefe", "Eindringtiefe", *DRIVES)
FORCES = ("force", "load", "Kraft", "Last")
HEIGHTS = ("height (measured)", "height (piezo)")


@dataclass(frozen=True)
class Reading:
    """How a file is read.

    columns: of depth and force, by name or number, with a unit where the file has none; width:
    length of the line contact [m], for forces in newtons; layout: of text; number: of the curve in
    an instrument file, from 1; spring_constant: of a cantilever [N/m]. None: not given.
    """

    columns: tuple[str, str] | None = None
    width: float | None = None
    layout: Layout = field(default_factory=Layout)
    number: int | None = None
    spring_constant: float | None = None

    def __post_init__(self) -> None:
        if self.columns is not None and len(self.columns) != 2:
            raise ValueError(f"columns = {self.columns!r} must be two: of the depth and the force")
        for name in ("width", "spring_constant"):
            if getattr(self, name) is not None:
                positive(name, getattr(self, name))
        if self.number is not None and self.number < 1:
            raise ValueError(f"curve = {self.number!r} must be a number from 1")


def reading(path: Path, content: Any) -> Reading:
    """The table [measured]. ValueError naming file and key."""
    table = Table(path, "measured", content, MEASURED)
    sizes = {key: table.number(key) for key in ("width", "spring_constant") if key in table.table}
    number = table.whole("curve", 1) if "curve" in table.table else None
    layout = table.build(lambda: Layout(**_layout(table)))
    return table.build(lambda: Reading(_named(table), layout=layout, number=number, **sizes))


def profile(table: Table) -> Sampled:
    """The sampled indenter whose samples stand in a file. ValueError naming file and key."""
    for key in ("x", "z"):
        if key in table.table:
            table.refuse(key, table.table[key], "stands beside file: give one of the two")
    file, kind = table.path.parent / table.text("file"), table.text("kind", "linear")
    unit = table.number("unit") if "unit" in table.table else None
    columns, layout = _named(table), _layout(table)
    return table.build(lambda: read_profile(file, kind=kind, unit=unit, columns=columns, **layout))


def _named(table: Table) -> tuple[str, str] | None:
    if "columns" not in table.table:
        return None
    given = table.table["columns"]
    kinds = isinstance(given, list) and all(type(c) in (str, int) for c in given)
    if not kinds or len(given) != 2:
        table.refuse("columns", given, "must be a list of two names or numbers of columns")
    first, second = map(str, given)
    return first, second


def _layout(table: Table) -> dict[str, Any]:
    found: dict[str, Any] = {k: table.text(k) for k in LAYOUT[:3] if k in table.table}
    return found | ({"skip": table.whole("skip", 0)} if "skip" in table.table else {})


def read_curve(path: Path, reading: Reading | None = None) -> Curve:
    """The curve of a file. ValueError naming file, line, cell and what was expected."""
    reading = reading or Reading()
    plain = _of_hdf5(path) if path.suffix.lower() == ".h5" else None
    if plain is None and path.suffix.lower() in INSTRUMENT:
        return _of_instrument(path, reading)
    if reading.number is not None:
        raise ValueError(f"{path}: curve = {reading.number}: text has one; give columns instead")
    table = plain or read_table(path, reading.layout)
    depth, force = reading.columns or (_default(table, DEPTHS), _default(table, FORCES))
    examples = "in m, mm, µm or nm, such as: depth [µm]"
    measured, _ = _column(table, "depth", depth, ("length",), examples)
    examples = "per length, such as: force [mN/m], or in mN with --width"
    load, unit = _column(table, "force", force, ("force", "force per length"), examples)
    if units.size(unit, "force") is not None:
        load = load / _width(path, reading.width)
    elif reading.width is not None:
        raise ValueError(
            f"{path}: width = {reading.width!r} with a force in {unit}: it is per length already; "
            "leave the width out"
        )
    stiffness = math.inf
    if reading.spring_constant is not None:
        stiffness = reading.spring_constant / (reading.width or 1.0)
    if units.named(depth)[0].casefold() in DRIVES:
        if math.isinf(stiffness):
            raise ValueError(
                f"{path}: {depth!r} is the position of the piezo, from which the depth differs by "
                "force over spring constant; give that with --spring-constant"
            )
        measured = measured - load / stiffness
    return Curve(measured, load, stiffness)


def _of_hdf5(path: Path) -> TextTable | None:
    """The data sets of equal length of a plain HDF5 file as a table; None for an instrument's."""
    try:
        library: Any = importlib.import_module("h5py")  # which afmformats needs, too
    except ImportError:
        return None
    columns: dict[str, Any] = {}

    def seen(name: str, item: Any) -> None:
        if getattr(item, "ndim", 0) == 1:
            unit = item.attrs.get("unit", item.attrs.get("units", ""))
            unit = unit.decode() if isinstance(unit, bytes) else unit
            columns[f"{name.rpartition('/')[2]} [{unit}]" if unit else name] = item[:]

    try:
        with library.File(path, "r") as file:
            if "software" in file.attrs and "0" in file:
                return None  # as afmformats writes it
            file.visititems(seen)
    except OSError:
        return None
    if len({column.size for column in columns.values()}) != 1:
        raise ValueError(
            f"{path}: must hold data sets of one length, a depth and a force; has {list(columns)}"
        )
    values = np.stack([np.asarray(column, float) for column in columns.values()], axis=1)
    rows = [Row(i, "", tuple(map(repr, row)), False) for i, row in enumerate(values.tolist(), 1)]
    names = Row(0, "", tuple(columns), False)
    return TextTable(path, Pattern(".", (True,) * len(columns)), names, tuple(rows))


def _default(table: TextTable, known: tuple[str, ...]) -> str:
    """The first of some names that the table has; the first of all, to be missed, if none."""
    return next((name for name in known if table.find(name)), known[0])


def _column(
    table: TextTable, what: str, column: str, quantities: Sequence[str], examples: str
) -> tuple[Array, str]:
    """The numbers of a column in SI, and the unit, which is one of some quantities, in the file."""
    place, unit = table.place(*units.named(column))
    if not unit:
        raise ValueError(
            f"{table.path}: column {column!r} has no unit: {table.told()}; write it into the "
            'header, "depth [µm], force [mN/m]", or behind the name: --columns "depth [µm]" ...'
        )
    for size in (units.size(unit, quantity) for quantity in quantities):
        if size is not None:
            return size * table.numbers(place), unit
    unknown = f"the unit {unit!r} of the {what} {column!r} is unknown"
    raise ValueError(f"{table.path}: {unknown}; write it {examples}")


def _width(path: Path, width: float | None) -> float:
    if width is None:
        raise ValueError(
            f"{path}: the force is in newtons: of a sphere or another turned body, set geometry = "
            '"axisymmetric" in [options] of the scene file; of a line contact, for which the '
            "model's force is per length, give that length in m with --width"
        )
    return width


def _of_instrument(path: Path, reading: Reading) -> Curve:
    if reading.columns is not None or reading.layout != Layout():
        raise ValueError(f"{path}: columns and layout are for text; leave them out")
    width = _width(path, reading.width)
    curves = _loaded(path)
    number, count = reading.number or 1, len(curves)
    if (count > 1 and reading.number is None) or number > count:
        remedy = f"give one of 1 to {count} with --curve" if count else "give another file"
        raise ValueError(
            f"{path}: curve = {reading.number!r}, but it holds {count} force-distance curves; "
            f"{remedy}"
        )
    data = curves[number - 1]
    force = np.asarray(data["force"], float)
    depth = -_tip(path, data, force)
    bad = np.flatnonzero(~np.isfinite(depth + force))
    if bad.size:
        raise ValueError(f"{path}: point {bad[0] + 1} of curve {number} is not finite; remove it")
    own = data.metadata.get("spring constant", None) or math.inf
    stiffness = own if reading.spring_constant is None else reading.spring_constant
    return Curve(depth, force / width, float(stiffness) / width)


def count(path: Path) -> int:
    """How many curves an instrument file holds."""
    plain = path.suffix.lower() == ".h5" and _of_hdf5(path) is not None
    return 1 if plain else len(_loaded(path))


def _loaded(path: Path) -> list[Any]:
    """The force-distance curves of an instrument file."""
    if not path.is_file():
        raise ValueError(f"{path}: is no file; give the name of a measured curve")
    try:
        library: Any = importlib.import_module("afmformats")
    except ImportError:
        raise ValueError(
            f"{path}: an instrument file; install elastocap[afm] to read it, or export it as text"
        ) from None
    log = logging.getLogger("afmformats")
    if not log.hasHandlers():  # else it prints the traceback of what is told below
        log.addHandler(logging.NullHandler())
    try:
        return list(library.load_data(path, modality="force-distance"))
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # some of the library's own are no Exception
        raise ValueError(
            f"{path}: afmformats cannot read it: {type(error).__name__}: {error}; export it as text"
        ) from None


def _tip(path: Path, data: Any, force: Array) -> Array:
    """Height of the tip above an arbitrary level [m]."""
    if "tip position" in data.columns:
        return np.asarray(data["tip position"], float)
    height = next((name for name in HEIGHTS if name in data.columns), None)
    stiffness = data.metadata.get("spring constant", None)
    if height is None or stiffness is None or not stiffness > 0:
        lacks = "heights" if height is None else "spring constant of the cantilever"
        raise ValueError(f"{path}: states no {lacks}, which the depth needs; export it as text")
    return np.asarray(data[height], float) + force / float(stiffness)
