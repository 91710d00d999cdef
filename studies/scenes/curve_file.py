"""Force–depth curves from files: text as instruments and spreadsheets write it, instrument files.

Text needs columns of a position and of a force, by default named so, with units in the header, in
a row below it or given with their names: "Weg [µm]", "2 [mN]". Two pairs of columns, of extending
and retracting, make one loop. A force in newtons is divided by the `width`, the length of the line
contact. What is measured is converted by these rules:

    position    depth, indentation    the depth d
                drive, piezo          towards the layer: d = drive - force / spring constant
                height                away from the layer: d = -(height + force / spring constant)
    force       newtons, N/m          the force P
                length                a deflection δ of the cantilever: P = spring constant · δ
                volts                 its signal V: P = spring constant · sensitivity · V

Instrument files (.jpk-force, .ibw, .h5, .tab and others) are read by the library afmformats, the
extra elastocap[afm]: forces in newtons, and the depth is that of the tip, from an arbitrary zero.
Spring constant and sensitivity of the file are replaced by those that are given: its forces change
in proportion. A plain .h5 file with one data set of the depth and one of the force, each with an
attribute "unit", is read as text is.

What a scene file says of measured data:

[measured]                               # optional: how `fit` reads DATA
columns = ["Weg [µm]", "Kraft [mN]"]     # depth and force: names or numbers, with missing units
width = 0.01                             # m: length of the line contact, for forces in newtons
spring_constant = 0.08                   # N/m, of the cantilever: its noise is in the depth, too
sensitivity = 50e-9                      # m/V, of its deflection, for signals in volts
curve = 3                                # of an instrument file with several
delimiter = ";"                          # and decimal, encoding, skip; else found from the file

[indenter]
shape = "sampled"
file = "scan.csv"                        # in place of x and z; beside the scene file
columns = ["x", "z [nm]"]                # and unit, delimiter, decimal, encoding, skip
flip = true                              # and level, line, cutoff: as those of read_profile

Conventions:

- `Sampled(x, z)` is a measured profile of heights z at x.
- A `Table` of the scene file reads its keys one by one, and its `refuse` names file, line and key.
- `read_table` gives a `TextTable`: names, units and rows of a text file.
- `in_own_process(function, case)` calls it in a process that then ends.
- `position_is_height`: positions are heights above the layer, and no depths.
"""

import importlib
import logging
import math
from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from energy import Sampled, read_profile, units
from energy.checks import positive
from energy.files.text_lines import Pattern, Row
from energy.files.text_table import Layout, TextTable, read_table
from studies.scenes.fit.force_curve import Array, Curve, position_is_height
from studies.scenes.table import Table
from studies.shared.batches import in_own_process

INSTRUMENT = (
    *(".jpk-force", ".jpk-force-map", ".jpk-qi-data", ".jpk-qi-series"),
    *(".ibw", ".h5", ".tab", ".zip"),
)
LAYOUT = ("delimiter", "decimal", "encoding", "skip")
SIZES = ("width", "spring_constant", "sensitivity")
MEASURED = ("columns", "curve", *SIZES, *LAYOUT)
PROFILE = ("file", "columns", "unit", "flip", "level", "line", "cutoff", *LAYOUT)
DRIVES = ("drive", "piezo", "piezo position", "piezoweg")
HEIGHTS = ("height", "height (measured)", "height (piezo)", "z height", "Höhe")
DEPTHS = ("depth", "indentation", "Weg", "Tiefe", "Eindringtiefe", *DRIVES, *HEIGHTS)
DEFLECTIONS = ("deflection", "vertical deflection", "Auslenkung", "Durchbiegung")
FORCES = ("force", "load", "Kraft", "Last", *DEFLECTIONS)
FORCE_UNITS = ("force", "force per length")
FORCE_KINDS = (*FORCE_UNITS, "length", "voltage")
INSTRUMENT_HEIGHTS = ("height (measured)", "height (piezo)")  # as afmformats calls them
RETRACTING = ("retract", "unload", "withdraw", "rückzug")  # in the names of columns
NO_LOAD_PATH = (
    "a creep or relaxation curve at constant force or height is no load path: give a file in which "
    "the tip moves in and out"
)


@dataclass(frozen=True)
class Reading:
    """How a file of a curve is written, as far as the file itself does not show it.

    Parameters
    ----------
    columns : tuple of 2 or 4 str, optional
        Of depth and force, by name or number, with a unit where the file has none; four where
        extending and retracting stand in columns of their own.
    width : float, optional
        Length of the line contact [m], for forces in newtons; 1 for a turned body, whose model
        has forces in newtons.
    layout : Layout
        Of text.
    number : int, optional
        Of the curve in an instrument file, from 1.
    spring_constant : float, optional
        Of a cantilever [N/m].
    sensitivity : float, optional
        Deflection of the cantilever over its signal [m/V].

    Raises
    ------
    ValueError
        For another number of columns, and for sizes that are not positive.

    Examples
    --------
    >>> from studies import Reading
    >>> cantilever = Reading(width=1.0, spring_constant=0.08, sensitivity=50e-9)
    """

    columns: tuple[str, ...] | None = None
    width: float | None = None
    layout: Layout = field(default_factory=Layout)
    number: int | None = None
    spring_constant: float | None = None
    sensitivity: float | None = None

    def __post_init__(self) -> None:
        """Refuse another number of columns, and sizes that are not positive."""
        if self.columns is not None and len(self.columns) not in (2, 4):
            raise ValueError(
                f"columns = {self.columns!r} must be two, of the depth and the force, or four: "
                "those of extending and those of retracting"
            )
        for name in SIZES:
            if getattr(self, name) is not None:
                positive(name, getattr(self, name))
        if self.number is not None and self.number < 1:
            raise ValueError(f"curve = {self.number!r} must be a number from 1")


def reading(path: Path, content: Any) -> Reading:
    """The table [measured]. ValueError naming file and key."""
    table = Table(path, "measured", content, MEASURED)
    sizes = {key: table.number(key) for key in SIZES if key in table.table}
    number = table.whole("curve", 1) if "curve" in table.table else None
    layout = table.build(lambda: Layout(**_layout(table)))
    columns = _named(table, (2, 4))
    return table.build(lambda: Reading(columns, layout=layout, number=number, **sizes))


def profile(table: Table) -> Sampled:
    """The sampled indenter whose samples stand in a file. ValueError naming file and key."""
    for key in ("x", "z"):
        if key in table.table:
            table.refuse(key, table.table[key], "stands beside file: give one of the two")
    file = table.path.parent / table.text("file")
    options: dict[str, Any] = _layout(table)
    for key in ("unit", "cutoff"):
        if key in table.table:
            options[key] = table.number(key)
    for key in ("flip", "level", "line"):
        if key in table.table:
            options[key] = table.table[key]
    columns = _named(table, (2,))
    kind = table.text("kind", "linear")
    return table.build(lambda: read_profile(file, kind=kind, columns=columns, **options))


def _named(table: Table, counts: Sequence[int]) -> tuple[str, ...] | None:
    """The columns that a table names, as many as one of these counts."""
    if "columns" not in table.table:
        return None
    given = table.table["columns"]
    kinds = isinstance(given, list) and all(type(c) in (str, int) for c in given)
    if not kinds or len(given) not in counts:
        words = " or ".join({2: "two", 4: "four"}[count] for count in counts)
        table.refuse("columns", given, f"must be a list of {words} names or numbers of columns")
    return tuple(map(str, given))


def _layout(table: Table) -> dict[str, Any]:
    """The arguments of `Layout` that a table of a scene file gives; others are not in it."""
    found: dict[str, Any] = {k: table.text(k) for k in LAYOUT[:3] if k in table.table}
    return found | ({"skip": table.whole("skip", 0)} if "skip" in table.table else {})


def read_curve(path: str | Path, reading: Reading | None = None) -> Curve:
    """The curve of a file.

    Parameters
    ----------
    path : str or Path
    reading : Reading, optional
        How the file is written, where that is not found from the file.

    Returns
    -------
    Curve
        Depth [m] and force [N/m, or N], with the stiffness of the cantilever.

    Raises
    ------
    ValueError
        Naming file, line, cell and what was expected.

    Examples
    --------
    A sphere on a cantilever of 0.08 N/m, depths in nm and forces in nN (simulated):

    >>> from pathlib import Path
    >>> import studies
    >>> path = Path(studies.__file__).parent / "scenes" / "sphere_curve.csv"
    >>> curve = studies.read_curve(path, studies.Reading(width=1.0, spring_constant=0.08))
    >>> curve.depth.size
    240
    """
    path = Path(path)
    reading = reading or Reading()
    plain = _of_hdf5(path) if path.suffix.lower() == ".h5" else None
    if plain is None and path.suffix.lower() in INSTRUMENT:
        return _of_instrument(path, reading)
    if reading.number is not None:
        raise ValueError(f"{path}: curve = {reading.number}: text has one; give columns instead")
    table = plain or read_table(path, reading.layout)
    branches = [_branch(table, reading, *pair) for pair in _pairs(table, reading.columns)]
    if len(branches) == 1:
        return branches[0]
    extending, retracting = branches
    return _loop(extending, retracting)


class _Column(NamedTuple):
    """Place of a column, and the text that names it."""

    place: int
    name: str


def _pairs(table: TextTable, columns: tuple[str, ...] | None) -> list[tuple[_Column, _Column]]:
    """The columns of position and force; two pairs for extending and retracting."""
    if columns is None:
        columns = (_default(table, DEPTHS), _default(table, FORCES))
    if len(columns) == 2:
        position, force = columns
        positions = table.places(position, ("length",))
        forces = _force_places(table, force)
        if len(positions) == 2 and len(forces) == 2:
            both = zip(positions, forces, strict=True)
            return [(_Column(x, position), _Column(p, force)) for x, p in both]
        return [(_only(table, position), _only_force(table, force))]
    pairs = [
        (_only(table, position), _only_force(table, force))
        for position, force in (columns[:2], columns[2:])
    ]
    first_name = columns[1].casefold()
    retracts_first = any(word in first_name for word in RETRACTING)
    return pairs[::-1] if retracts_first else pairs


def _force_places(table: TextTable, name: str) -> list[int]:
    """Places of the columns of this name, those of a force before deflections and these before
    signals."""
    found = table.places(name, FORCE_KINDS)
    for kinds in (FORCE_UNITS, ("length",)):
        of_kind = [
            place
            for place in found
            if any(units.size(table.columns[place][1], kind) is not None for kind in kinds)
        ]
        if of_kind:
            return of_kind
    return found


def _only(table: TextTable, name: str) -> _Column:
    """The only column of a position of this name."""
    return _Column(table.place(name, ("length",)), name)


def _only_force(table: TextTable, name: str) -> _Column:
    """The only column of a force of this name."""
    found = _force_places(table, name)
    return _Column(found[0] if len(found) == 1 else table.place(name, FORCE_KINDS), name)


def _loop(extending: Curve, retracting: Curve) -> Curve:
    """Both branches in the order measured: the second one begins where the first one ends."""
    end = extending.drive[-1]
    drive = retracting.drive
    if abs(drive[-1] - end) < abs(drive[0] - end):
        retracting = retracting._replace(depth=retracting.depth[::-1], force=retracting.force[::-1])
    return extending._replace(
        depth=np.concatenate([extending.depth, retracting.depth]),
        force=np.concatenate([extending.force, retracting.force]),
    )


def _branch(table: TextTable, reading: Reading, position: _Column, force: _Column) -> Curve:
    """The curve of one pair of columns."""
    path = table.path
    count = table.filled((position.place, force.place))
    unit = _unit(table, position, "depth", ("length",), "in m, mm, µm or nm, such as: depth [µm]")
    measured = _size(unit, "length") * table.numbers(position.place, count)
    load = _load(table, reading, force, count)
    name = units.named(position.name)[0].casefold()
    if position.name.strip().isdecimal():
        name = table.columns[position.place][0].casefold()
    stiffness = math.inf
    if reading.spring_constant is not None:
        stiffness = reading.spring_constant / (reading.width or 1.0)
    is_height = name in map(str.casefold, HEIGHTS)
    measured, notes = _towards_layer(measured, load, position.name, is_height)
    if is_height or name in DRIVES:
        if math.isinf(stiffness):
            raise ValueError(
                f"{path}: {position.name!r} is the position of the piezo, from which the depth "
                "differs by force over spring constant; give that with --spring-constant"
            )
        measured = measured - load / stiffness
    return Curve(measured, load, stiffness, notes)


def _towards_layer(
    position: Array, force: Array, name: str, is_height: bool
) -> tuple[Array, tuple[str, ...]]:
    """A position that rises as the indenter comes nearer to the layer, and what is said of it.

    Whatever the name of its column promises, the force shows on which side the layer is.
    """
    rising = -position if is_height else position
    if not position_is_height(rising, force):
        return rising, ()
    side = "larger" if is_height else "smaller"
    note = (
        f"the layer is where {name!r} is {side}, against what its name says: its sign is reversed"
    )
    return -rising, (note,)


def _load(table: TextTable, reading: Reading, force: _Column, count: int) -> Array:
    """The force per length [N/m], or the force about an axis [N]."""
    path = table.path
    examples = "per length, such as: force [mN/m], or in mN with --width"
    unit = _unit(table, force, "force", FORCE_KINDS, examples)
    signal = table.numbers(force.place, count)
    if units.size(unit, "force per length") is not None:
        if reading.width is not None:
            raise ValueError(
                f"{path}: width = {reading.width!r} with a force in {unit}: it is per length "
                "already; leave the width out"
            )
        return _size(unit, "force per length") * signal
    if units.size(unit, "force") is not None:
        newtons = _size(unit, "force") * signal
        return newtons / _width(path, reading.width)
    if reading.spring_constant is None:
        raise ValueError(
            f"{path}: {force.name!r} in {unit} is a deflection; its force needs the spring "
            "constant of the cantilever: give that with --spring-constant"
        )
    if units.size(unit, "voltage") is None:
        deflection = _size(unit, "length") * signal
    elif reading.sensitivity is None:
        raise ValueError(
            f"{path}: {force.name!r} is a signal in {unit}; its deflection needs the sensitivity "
            "in m/V: give that with --sensitivity"
        )
    else:
        deflection = reading.sensitivity * _size(unit, "voltage") * signal
    return reading.spring_constant * deflection / _width(path, reading.width)


def _size(unit: str, kind: str) -> float:
    """A unit of this kind in SI."""
    size = units.size(unit, kind)
    assert size is not None
    return size


def _of_hdf5(path: Path) -> TextTable | None:
    """The data sets of equal length of a plain HDF5 file as a table; None for an instrument's."""
    try:
        library: Any = importlib.import_module("h5py")  # which afmformats needs, too
    except ImportError:
        return None
    columns: dict[str, Any] = {}

    def add(name: str, item: Any) -> None:
        """Add a data set with the last part of its name and its unit as the name of a column."""
        if getattr(item, "ndim", 0) != 1:
            return
        unit = item.attrs.get("unit", item.attrs.get("units", ""))
        if isinstance(unit, bytes):
            unit = unit.decode()
        header = f"{name.rpartition('/')[2]} [{unit}]" if unit else name
        columns[header] = item[:]

    try:
        with library.File(path, "r") as file:
            if "software" in file.attrs and "0" in file:
                return None  # as afmformats writes it
            file.visititems(add)
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


def _default(table: TextTable, known: Sequence[str]) -> str:
    """The first of some names that the table has; the first of all, to be missed, if none."""
    return next((name for name in known if table.find(name)), known[0])


def _unit(table: TextTable, column: _Column, what: str, kinds: Sequence[str], examples: str) -> str:
    """The unit of a column, which is one of some kinds. ValueError naming it and the file."""
    unit = table.unit(column.place, column.name)
    if not unit:
        raise ValueError(
            f"{table.path}: column {column.name!r} has no unit: {table.description()}; write it "
            'into the header, "depth [µm], force [mN/m]", or behind the name: '
            '--columns "depth [µm]" ...'
        )
    if all(units.size(unit, kind) is None for kind in kinds):
        raise ValueError(
            f"{table.path}: the unit {unit!r} of the {what} {column.name!r} is unknown; write it "
            f"{examples}"
        )
    return unit


def _width(path: Path, width: float | None) -> float:
    """The length [m] over which a force in N is spread, 1 about an axis; ValueError for None."""
    if width is None:
        raise ValueError(
            f"{path}: the force is in newtons: of a sphere or another turned body, set geometry = "
            '"axisymmetric" in [options] of the scene file; of a line contact, for which the '
            "model's force is per length, give that length in m with --width"
        )
    return width


def _of_instrument(path: Path, reading: Reading) -> Curve:
    """The curve of a file of an instrument, which holds units and often the calibration.

    ValueError for more than one curve without a number, and for a force that cannot be had in N.
    """
    if reading.columns is not None or reading.layout != Layout():
        raise ValueError(f"{path}: columns and layout are for text; leave them out")
    width = _width(path, reading.width)
    curves = _loaded(path)
    number = reading.number or 1
    count = len(curves)
    if (count > 1 and reading.number is None) or number > count:
        remedy = f"give one of 1 to {count} with --curve" if count else NO_LOAD_PATH
        raise ValueError(
            f"{path}: curve = {reading.number!r}, but it holds {count} force-distance curves; "
            f"{remedy}"
        )
    data = curves[number - 1]
    if "force" not in data.columns:
        raise ValueError(
            f"{path}: curve {number} has no force; export it as text with its deflection, and give "
            "--spring-constant and --sensitivity"
        )
    stiffness = reading.spring_constant or _stated(data, "spring constant")
    force = _instrument_column(path, data, "force", number) * _calibration(path, data, reading)
    depth, notes = _instrument_depth(path, data, force, stiffness, number)
    return Curve(depth, force / width, (stiffness or math.inf) / width, notes)


def _instrument_column(path: Path, data: Any, name: str, number: int) -> Array:
    """The numbers of a column of an instrument file. ValueError for one that is not finite."""
    values = np.asarray(data[name], float)
    bad = np.flatnonzero(~np.isfinite(values))
    if bad.size:
        raise ValueError(
            f"{path}: {name!r} of point {bad[0] + 1} of curve {number} is not finite; remove it"
        )
    return values


def _stated(data: Any, name: str) -> float | None:
    """A positive number that an instrument file states; None if it states none."""
    value = data.metadata.get(name, None)
    return float(value) if value is not None and value > 0 else None


def _calibration(path: Path, data: Any, reading: Reading) -> float:
    """Factor of the file's forces where another spring constant or sensitivity is given."""
    factor = 1.0
    names = {"spring constant": reading.spring_constant, "sensitivity": reading.sensitivity}
    for name, given in names.items():
        own = _stated(data, name)
        if given is not None and own is not None:
            factor *= given / own
        if given is not None and own is None and name == "sensitivity":
            raise ValueError(
                f"{path}: sensitivity = {given!r}: the file states none that it could replace; "
                "leave it out, or export the signal in volts as text"
            )
    return factor


def count(path: Path) -> int:
    """How many curves an instrument file holds.

    The file is opened in a process of its own: the library keeps an archive open, and processes
    that inherited it would read it at one common position.
    """
    if path.suffix.lower() == ".h5" and _of_hdf5(path) is not None:
        return 1
    return in_own_process(_number_of_curves, path)


def _number_of_curves(path: Path) -> int:
    """How many curves an instrument file holds; of module level, for a process of its own."""
    return len(_loaded(path))


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
    if not log.hasHandlers():  # else it prints the traceback of the error that is raised below
        log.addHandler(logging.NullHandler())
    try:
        return list(library.load_data(path, modality="force-distance"))
    except (KeyboardInterrupt, SystemExit):
        raise
    except BaseException as error:  # some of the library's own are no Exception
        raise ValueError(
            f"{path}: afmformats cannot read it: {type(error).__name__}: {error}; export it as text"
        ) from None


def _instrument_depth(
    path: Path, data: Any, force: Array, stiffness: float | None, number: int
) -> tuple[Array, tuple[str, ...]]:
    """Depth of the tip from an arbitrary level [m], and what is said of it.

    The file's own position of the tip is taken if it has the spring constant in use and the layer
    is on the side of small positions; else the tip is below the height of the piezo by the force
    over the spring constant.
    """
    name = next((one for one in INSTRUMENT_HEIGHTS if one in data.columns), None)
    own = _stated(data, "spring constant")
    if "tip position" in data.columns and stiffness == own:
        depth = -_instrument_column(path, data, "tip position", number)
        if name is None or not position_is_height(depth, force):
            return depth, ()
    if name is None:
        raise ValueError(f"{path}: states no heights, which the depth needs; export it as text")
    if stiffness is None:
        raise ValueError(
            f"{path}: states no spring constant of the cantilever, which the depth needs; give it "
            "with --spring-constant"
        )
    height = _instrument_column(path, data, name, number)
    position, notes = _towards_layer(height, force, name, True)
    return position - force / stiffness, notes
