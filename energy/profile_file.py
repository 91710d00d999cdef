"""Measured profiles from the files people have."""

from __future__ import annotations

import importlib
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from energy.checks import positive
from energy.sampled import Sampled

Array = NDArray[np.float64]
TEXT = (".txt", ".csv", ".dat", ".tsv", ".xyz")
_SEPARATORS = str.maketrans(",;\t", "   ")


def read_profile(path: str | Path, *, kind: str = "linear", unit: float = 1.0) -> Sampled:
    """A `Sampled` profile from a file of positions x and heights z, both in `unit` metres.

    Text (.txt, .csv, .dat, .tsv, .xyz): two columns separated by blanks, tabs, commas or
    semicolons; lines that start with # and one line of column names are skipped. .npz: arrays `x`
    and `z`. Anything else is a line scan, read by the library SurfaceTopography where installed; a
    unit that the file states counts, not `unit`. Heights are upwards from the indenter's lowest
    level, as in `Sampled`.

    ValueError for a file that holds no such columns, and for what `Sampled` refuses.
    """
    path, unit = Path(path), positive("unit", unit)
    if not path.is_file():
        raise ValueError(f"path = {str(path)!r} is no file; give the name of a measured profile")
    if path.suffix.lower() == ".npz":
        x, z = (unit * column for column in _arrays(path))
    elif path.suffix.lower() in TEXT:
        x, z = (unit * column for column in _columns(path))
    else:
        x, z = _topography(path, unit)
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


def _columns(path: Path) -> tuple[Array, Array]:
    rows: list[list[float]] = []
    named = False
    for number, line in enumerate(path.read_text(encoding="utf-8-sig").splitlines(), 1):
        words = line.split("#")[0].translate(_SEPARATORS).split()
        if not words:
            continue
        try:
            rows.append([float(word) for word in words])
        except ValueError:
            if rows or named:
                raise ValueError(
                    f"path = {str(path)!r}, line {number}: {line!r} is not two numbers; "
                    "remove it or start it with #"
                ) from None
            named = True
            continue
        if len(words) != 2:
            raise ValueError(
                f"path = {str(path)!r}, line {number}: {len(words)} columns; give two, x and z"
            )
    table = np.array(rows, float).reshape(-1, 2)
    return table[:, 0], table[:, 1]


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
