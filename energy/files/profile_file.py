"""Measured profiles from the files people have.

Conventions: x are positions along the scan, z heights, positive upwards from the layer once a scan
is turned over; both in metres. A `TextTable` has the columns of a text file: `place` finds one by
name or number, `unit` is its unit, "" if the file states none, `numbers` its values as written, and
`description()` says in words which columns there are. `read_table(path, layout)` reads one.
`units.size(unit, kind)` is a unit of length in metres, None if it is none. `positive` and `option`
check an argument, whose name comes first.

The library SurfaceTopography, which reads the files of instruments, is imported where one is given.
Of its scans, `dim` is 1 for a line and 2 for an area, `unit` the unit of lengths or None, `to_unit`
the scan in another one, and `positions_and_heights()` x and z of a line, or x, y and z of an area.
"""

import importlib
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from energy import units
from energy.arrays import Array
from energy.checks import option, positive
from energy.files.text_table import Layout, TextTable, read_table
from energy.sampled import Sampled

TEXT = (".txt", ".csv", ".dat", ".tsv", ".xyz", ".asc", ".prn")
NAMES = ("x", "z")
LEVELS = {"tilt": 1, "curvature": 2}  # degrees of the polynomials that are removed
# Share of the length of a scan that counts as its end. A body is scanned with its lowest point near
# the middle; noise moves the lowest point of a scan that was turned over by a few samples.
NEAR_END = 0.02
# A unit given may differ from the file's own by this share, as 2.54e-2 and 0.0254 do by rounding.
_SAME_UNIT = 1e-9


def read_profile(
    path: str | Path,
    *,
    kind: str = "linear",
    unit: float | None = None,
    columns: Sequence[str | int] | None = None,
    line: int | str | None = None,
    flip: bool | None = None,
    level: str | None = None,
    cutoff: float | None = None,
    delimiter: str | None = None,
    decimal: str | None = None,
    encoding: str | None = None,
    skip: int = 0,
) -> Sampled:
    """A `Sampled` profile from a file of positions x and heights z, in metres.

    The file is read, turned over (`flip`), levelled (`level`) and filtered (`cutoff`), in this
    order.

    Parameters
    ----------
    path : str or Path
        Text (.txt, .csv, .dat, .tsv, .xyz, .asc, .prn), or .npz with arrays `x` and `z` in metres;
        anything else is a scan, read by the library SurfaceTopography where that is installed.
    kind : {"linear", "smooth"}
        As in `Sampled`.
    unit : float, optional
        Of x and z in metres, where the file does not state it.
    columns : two names or numbers from 1, optional
        Of x and of z in text, with a unit where the header has none ("height [nm]"); else those
        named x and z, or the two there are.
    line : int or "mean", optional
        Of an area scan: the number of one line along x, from 1; or the mean of all lines.
    flip : bool, optional
        Whether the scan is upside down, as that of an indenter that stands on a table: its lowest
        point has to be what touches first. Where the lowest point is at an end of the scan, True or
        False is needed.
    level : {"tilt", "curvature"}, optional
        Removes the straight line or the parabola nearest to the heights.
    cutoff : float, optional
        Removes waves shorter than this [m], as `Sampled.filtered`.
    delimiter, decimal, encoding, skip : optional
        How text is written, as in `text_table.Layout`; found from the file where not given.

    Raises
    ------
    ValueError
        Naming file, line and what was expected, for a file that holds no such columns or can be
        read in more than one way, a column without a unit, a `unit` beside one in the file, a scan
        that may be upside down, and what `Sampled` does not accept.

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
    path = Path(path)
    size = None if unit is None else positive("unit", unit)
    if level is not None:
        option("level", level, tuple(LEVELS))
    if flip is not None and not isinstance(flip, bool):
        raise ValueError(f"flip = {flip!r} must be True, False or None")
    if not path.is_file():
        raise ValueError(f"path = {str(path)!r} is no file; give the name of a measured profile")
    layout = Layout(delimiter, decimal, encoding, skip)
    suffix = path.suffix.lower()
    is_text = suffix in TEXT
    is_scan = not is_text and suffix != ".npz"
    if not is_text and (columns is not None or layout != Layout()):
        raise ValueError(
            f"path = {str(path)!r}: columns and layout are for text ({', '.join(TEXT)}); "
            "leave them out, or name the file so"
        )
    if line is not None and not is_scan:
        raise ValueError(f"line = {line!r} is for area scans, which {str(path)!r} is not")
    if is_text:
        x, z = _columns(read_table(path, layout), columns, size)
    elif is_scan:
        x, z = _topography(path, size, line)
    else:
        x, z = _arrays(path, size)
    try:
        return _treated(Sampled(x, z, kind), flip, level, cutoff)
    except ValueError as error:
        raise ValueError(f"path = {str(path)!r}: {error}") from None


def _treated(read: Sampled, flip: bool | None, level: str | None, cutoff: float | None) -> Sampled:
    """The profile turned over, levelled and filtered, in this order, each if it is given.

    ValueError if `flip` is not given and the profile may be upside down.
    """
    upright = -read.z if flip else read.z
    z = _levelled(read.x, upright, level)
    if flip is None:
        _check_lowest_point(read.x, z)
    body = Sampled(read.x, z, read.kind)
    return body if cutoff is None else body.filtered(cutoff)


def _levelled(x: Array, z: Array, level: str | None) -> Array:
    """The heights less the polynomial nearest to them, of the degree that LEVELS gives."""
    if level is None:
        return z
    trend = np.polynomial.Polynomial.fit(x, z, LEVELS[level])
    return z - trend(x)


def _check_lowest_point(x: Array, z: Array) -> None:
    """ValueError where contact would begin at an end of the scan."""
    lowest = float(x[int(np.argmin(z))])
    margin = NEAR_END * float(x[-1] - x[0])
    if x[0] + margin < lowest < x[-1] - margin:
        return
    raise ValueError(
        f"the lowest point of the profile, at x = {lowest!r}, is at an end of the scan, where "
        "contact would begin: the scan may be upside down (flip=True) or tilted (level='tilt'); "
        "if it is neither, give flip=False"
    )


def _arrays(path: Path, unit: float | None) -> tuple[Array, Array]:
    """The arrays x and z of a file of numpy's, in metres unless a unit is given."""
    size = unit or 1.0
    with np.load(path) as file:
        if not {"x", "z"} <= set(file):
            raise ValueError(
                f"path = {str(path)!r} holds the arrays {sorted(file)}; name them x and z"
            )
        x = np.asarray(file["x"], float)
        z = np.asarray(file["z"], float)
    return size * x, size * z


def _columns(
    table: TextTable, columns: Sequence[str | int] | None, given: float | None
) -> tuple[Array, Array]:
    """x and z in metres from two columns; given: the unit in metres where the file states none."""
    wanted = _wanted(table) if columns is None else tuple(columns)
    if len(wanted) != 2:
        raise ValueError(f"columns = {wanted!r} must be two: that of x and that of z")
    x = _length(table, wanted[0], given)
    z = _length(table, wanted[1], given)
    return x, z


def _wanted(table: TextTable) -> tuple[str | int, ...]:
    """The columns named x and z, or the numbers 1 and 2 of two, unless a name says otherwise."""
    if all(len(table.find(name)) == 1 for name in NAMES):
        return NAMES
    swapped = table.find("x") == [1] or table.find("z") == [0]
    if len(table.columns) != 2 or swapped:
        raise ValueError(
            f"{table.path}: {table.description()}; give a file with two columns, x and z, or their "
            "names or numbers with columns"
        )
    return 1, 2


def _length(table: TextTable, column: str | int, given: float | None) -> Array:
    """A column in metres, by its own unit or the one given; ValueError for none, or another."""
    name = str(column)
    place = table.place(name, ("length",))
    unit = table.unit(place, name)
    if not unit and given is None:
        raise ValueError(
            f"{table.path}: column {column!r} has no unit: {table.description()}; write it into "
            'the header, "x [µm]", or behind the name, columns=("x [µm]", "z [nm]"), or give '
            "unit=1e-6 for micrometres"
        )
    size = units.size(unit, "length") if unit else given
    if size is None:
        raise ValueError(
            f"{table.path}: the unit {unit!r} of column {column!r} is no length; correct it to m, "
            "mm, µm or nm"
        )
    if unit and given is not None and abs(size / given - 1) > _SAME_UNIT:
        raise ValueError(
            f"{table.path}: unit = {given!r} contradicts the file's own {unit!r} of column "
            f"{column!r}; leave unit out or correct the file"
        )
    return size * table.numbers(place)


def _topography(path: Path, given: float | None, line: int | str | None) -> tuple[Array, Array]:
    """Positions and heights of a scan in metres; of an area scan those of one line, or the mean."""
    try:
        library: Any = importlib.import_module("SurfaceTopography")
    except ImportError:
        raise ValueError(
            f"path = {str(path)!r}: {path.suffix or 'this'} is no text and no .npz; install "
            "elastocap[topography] to read instrument files"
        ) from None
    scan = library.read_topography(str(path))
    if scan.unit is not None:
        scan = scan.to_unit("m")
        size = 1.0
    elif given is not None:
        size = given
    else:
        raise ValueError(
            f"path = {str(path)!r} states no unit; give unit=1e-6 if its lengths are micrometres"
        )
    if scan.dim == 1:
        if line is not None:
            raise ValueError(f"line = {line!r}: {str(path)!r} is a line scan; leave it out")
        x, z = scan.positions_and_heights()
    else:
        x, z = _line_of_area(path, scan, line)
    return size * np.asarray(x, float), size * np.asarray(z, float)


def _line_of_area(path: Path, scan: Any, line: int | str | None) -> tuple[Array, Array]:
    """One line of an area scan along x, or the mean of all lines that have no missing heights."""
    x, _, z = scan.positions_and_heights()  # of the shape (points of a line, lines)
    x = np.ma.filled(x, np.nan)  # NaN where a height is missing
    heights = np.ma.filled(z, np.nan)
    count = heights.shape[1]
    if line == "mean":
        return x[:, 0], heights.mean(axis=1)
    if isinstance(line, bool) or not isinstance(line, int) or not 1 <= line <= count:
        raise ValueError(
            f"line = {line!r}: {str(path)!r} is an area scan; give the number of one of its "
            f"{count} lines along x, or line='mean'"
        )
    return x[:, line - 1], heights[:, line - 1]
