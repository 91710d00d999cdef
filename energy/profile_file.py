"""Measured profiles from the files people have."""

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from energy import units
from energy.arrays import Array
from energy.checks import positive
from energy.sampled import Sampled
from energy.text_table import Layout, TextTable, read_table

TEXT = (".txt", ".csv", ".dat", ".tsv", ".xyz", ".asc", ".prn")
NAMES = ("x", "z")


def read_profile(
    path: str | Path,
    *,
    kind: str = "linear",
    unit: float | None = None,
    columns: Sequence[str | int] | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    encoding: str | None = None,
    skip: int = 0,
) -> Sampled:
    """A `Sampled` profile from a file of positions x and heights z, in metres.

    Parameters
    ----------
    path : str or Path
        Text (.txt, .csv, .dat, .tsv, .xyz, .asc, .prn), or .npz with arrays `x` and `z`; anything
        else is a line scan, read by the library SurfaceTopography where that is installed.
    kind : {"linear", "smooth"}
        As in `Sampled`.
    unit : float, optional
        Of x and z in metres, where the file does not state it; 1 if it is not given either.
    columns : two names or numbers from 1, optional
        Of x and of z in text, with a unit where the header has none ("height [nm]"); else those
        named x and z, or the two there are.
    delimiter, decimal, encoding, skip : optional
        How text is written, as in `text_table.Layout`; found from the file where not given.

    Raises
    ------
    ValueError
        Naming file, line and what was expected, for a file that holds no such columns or can be
        read in more than one way, a `unit` beside one in the file, and what `Sampled` refuses.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from energy import read_profile
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder, "scan.csv")
    ...     _ = path.write_text("x [µm];z [nm]\\n-1;4\\n0;0\\n1;5\\n", encoding="utf-8")
    ...     print(read_profile(path).x)
    [-1.e-06  0.e+00  1.e-06]
    """
    path, given = Path(path), None if unit is None else positive("unit", unit)
    if not path.is_file():
        raise ValueError(f"path = {str(path)!r} is no file; give the name of a measured profile")
    layout, text = Layout(delimiter, decimal, encoding, skip), path.suffix.lower() in TEXT
    if not text and (columns is not None or layout != Layout()):
        raise ValueError(
            f"path = {str(path)!r}: columns and layout are for text ({', '.join(TEXT)}); "
            "leave them out, or name the file so"
        )
    if text:
        x, z = _columns(read_table(path, layout), columns, given)
    elif path.suffix.lower() == ".npz":
        x, z = ((given or 1.0) * column for column in _arrays(path))
    else:
        x, z = _topography(path, given or 1.0)
    try:
        return Sampled(x, z, kind)
    except ValueError as error:
        raise ValueError(f"path = {str(path)!r}: {error}") from None


def _arrays(path: Path) -> tuple[Array, Array]:
    with np.load(path) as file:
        if not {"x", "z"} <= set(file):
            raise ValueError(
                f"path = {str(path)!r} holds the arrays {sorted(file)}; name them x and z"
            )
        return np.asarray(file["x"], float), np.asarray(file["z"], float)


def _columns(
    table: TextTable, columns: Sequence[str | int] | None, given: float | None
) -> tuple[Array, Array]:
    """x and z in metres."""
    wanted = _wanted(table) if columns is None else tuple(columns)
    if len(wanted) != 2:
        raise ValueError(f"columns = {wanted!r} must be two: that of x and that of z")
    x, z = (_length(table, column, given) for column in wanted)
    return x, z


def _wanted(table: TextTable) -> tuple[str | int, ...]:
    """The columns named x and z, or the first and second of two, unless a name says otherwise."""
    if all(len(table.find(name)) == 1 for name in NAMES):
        return NAMES
    swapped = table.find("x") == [1] or table.find("z") == [0]
    if len(table.columns) != 2 or swapped:
        raise ValueError(
            f"{table.path}: {table.told()}; give a file with two columns, x and z, or their names "
            "or numbers with columns"
        )
    return 1, 2


def _length(table: TextTable, column: str | int, given: float | None) -> Array:
    place, unit = table.place(*units.named(str(column)))
    size = units.size(unit, "length") if unit else given or 1.0
    if size is None:
        raise ValueError(
            f"{table.path}: the unit {unit!r} of column {column!r} is no length; correct it to m, "
            "mm, µm or nm"
        )
    if unit and given is not None and abs(size / given - 1) > 1e-9:
        raise ValueError(
            f"{table.path}: unit = {given!r} contradicts the file's own {unit!r} of column "
            f"{column!r}; leave unit out or correct the file"
        )
    return size * table.numbers(place)


def _topography(path: Path, unit: float) -> tuple[Array, Array]:
    try:
        library: Any = importlib.import_module("SurfaceTopography")
    except ImportError:
        raise ValueError(
            f"path = {str(path)!r}: {path.suffix or 'this'} is no text and no .npz; install "
            "elastocap[topography] to read instrument files"
        ) from None
    scan = library.read_topography(str(path))
    if scan.dim != 1:
        raise ValueError(f"path = {str(path)!r} is an area scan; give a line scan")
    scan, unit = (scan, unit) if scan.unit is None else (scan.to_unit("m"), 1.0)
    x, z = scan.positions_and_heights()
    return unit * np.asarray(x, float), unit * np.asarray(z, float)
