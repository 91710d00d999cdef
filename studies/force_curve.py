"""A measured force–depth curve: read from a file with units, its noise, its points in contact."""

from __future__ import annotations

import math
import re
from pathlib import Path
from typing import NamedTuple, NoReturn

import numpy as np
from numpy.typing import NDArray

from studies.units import PREFIXES

Array = NDArray[np.float64]
_SIZES = {symbol: 10.0**power for power, symbol in PREFIXES.items()} | {"u": 1e-6, "μ": 1e-6}
_P = "([" + "".join(_SIZES) + "]?)"
KINDS = {"depth": re.compile(f"{_P}m"), "force": re.compile(f"{_P}N/{_P}m")}
CLEAR = 5.0  # times the noise: a force that is there


class Curve(NamedTuple):
    """Depth [m] and force per length [N/m] in the order measured, (n,) each."""

    depth: Array
    force: Array


def read_curve(path: Path) -> Curve:
    """Read two columns named depth and force with units. ValueError naming file and line."""
    try:
        text = path.read_text("utf-8-sig")
    except (OSError, ValueError) as error:
        why = getattr(error, "strerror", None) or error
        raise ValueError(f"{path}: {why}; give a text file") from None
    lines = [
        (number, [cell.strip() for cell in re.split("[,;\t]", line)])
        for number, line in enumerate(text.splitlines(), 1)
        if line.strip() and not line.startswith("#")
    ]
    if len(lines) < 2:
        raise ValueError(f"{path}: has no data; give a header and rows of depth and force")
    header, *rows = lines
    places = {kind: _column(path, header[1], kind) for kind in KINDS}
    columns = []
    for kind, (place, size) in places.items():
        columns.append([size * _number(path, number, kind, row, place) for number, row in rows])
    return Curve(*map(np.array, columns))


def _column(path: Path, header: list[str], kind: str) -> tuple[int, float]:
    """Place and unit of the column whose name is `kind`."""

    def refuse(problem: str) -> NoReturn:
        example = "depth [µm], force [mN/m]"
        raise ValueError(f"{path}: header {header!r} {problem}; write it like: {example}")

    named = [re.fullmatch(r"(\w+)\s*[\[(](.+)[\])]", cell) for cell in header]
    found = [i for i, name in enumerate(named) if name and name[1].lower() == kind]
    if len(found) != 1:
        refuse(f"must have one column {kind} with its unit")
    (place,) = found
    match = named[place]
    unit = KINDS[kind].fullmatch(match[2].strip()) if match else None
    if unit is None:
        refuse(f"has an unknown unit of {kind}")
    first, *below = unit.groups()
    return place, _SIZES[first or ""] / math.prod(_SIZES[part or ""] for part in below)


def _number(path: Path, line: int, kind: str, row: list[str], place: int) -> float:
    text = row[place] if place < len(row) else ""
    try:
        value = float(text)
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise ValueError(f"{path}: line {line}: {kind} = {text!r} must be a finite number")
    return value


def noise(force: Array) -> float:
    """Standard deviation of the noise on a smooth curve with few jumps, from third differences."""
    if force.size < 8:
        return 0.0
    return float(np.median(np.abs(np.diff(force, 3)))) / (0.6745 * math.sqrt(20))


def in_contact(curve: Curve) -> NDArray[np.bool_]:
    """All points but those without force at the beginning and at the end (n,)."""
    clear = np.flatnonzero(np.abs(curve.force) > CLEAR * noise(curve.force))
    used = np.zeros(curve.force.size, bool)
    if clear.size:
        used[clear[0] : clear[-1] + 1] = True
    return used


class Mark(NamedTuple):
    """A depth between two points at which contact begins ("touch") or is lost ("letting go").

    error: standard deviation of a depth that may lie anywhere between them.
    """

    kind: str
    depth: float
    error: float


def marks(curve: Curve) -> tuple[Mark, ...]:
    """The ends of contact that the curve shows: pulled on one side, without force on the other."""
    used, clear = np.flatnonzero(in_contact(curve)), 2 * CLEAR * noise(curve.force)
    found = []
    for kind, inside, outside in (("touch", 0, -1), ("letting go", -1, 1)):
        near = int(used[inside]) if used.size else 0
        if used.size and 0 <= near + outside < curve.depth.size and curve.force[near] < -clear:
            a, b = sorted((curve.depth[near], curve.depth[near + outside]))
            if b > a:
                found.append(Mark(kind, float(a + b) / 2, float(b - a) / math.sqrt(12)))
    return tuple(found)
