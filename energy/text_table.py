"""Columns of numbers in a text file as instruments and spreadsheets write it.

What is not given is found from the file: the encoding from its byte-order mark or its bytes; the
delimiter and the decimal mark as the pair under which most lines are rows of numbers; the beginning
of the data as the first line with the cells of most rows; the header as the line of words above,
with or without a row of units. A file that can be read in more than one way is refused.
"""

import codecs
import re
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path

import numpy as np

from energy import units
from energy.arrays import Array
from energy.text_lines import (
    DELIMITERS,
    NUMBER,
    Pattern,
    Row,
    decoded,
    missing,
    refuse,
    rows_of,
)

_THOUSANDS = {mark: re.compile(rf"[+-]?[1-9]\d{{0,2}}\{mark}\d{{3}}") for mark in NUMBER}
_WORD = re.compile(r"[^\W\d_]{2,}")


@dataclass(frozen=True)
class Layout:
    """How a text file is written; None: found from the file.

    delimiter: one of DELIMITERS; decimal: "." or ","; encoding: as Python names it; skip: lines
    at the beginning that are no data. ValueError for others.
    """

    delimiter: str | None = None
    decimal: str | None = None
    encoding: str | None = None
    skip: int = 0

    def __post_init__(self) -> None:
        known = {"delimiter": tuple(DELIMITERS), "decimal": tuple(NUMBER)}
        for name, options in known.items():
            value = getattr(self, name)
            if value is not None and value not in options:
                listed = ", ".join(map(repr, options))
                raise ValueError(f"{name} = {value!r} is unknown; choose one of {listed}")
        try:
            codecs.lookup("utf-8" if self.encoding is None else self.encoding)
        except (LookupError, TypeError, ValueError):
            raise ValueError(
                f"encoding = {self.encoding!r} is unknown; give a name such as 'utf-16' or 'cp1252'"
            ) from None
        if isinstance(self.skip, bool) or not isinstance(self.skip, int) or self.skip < 0:
            raise ValueError(f"skip = {self.skip!r} must be a whole number of lines, 0 or more")


@dataclass(frozen=True)
class TextTable:
    """The rows of a file, all with as many cells, below a header (None: there is none)."""

    path: Path
    pattern: Pattern
    header: Row | None
    rows: tuple[Row, ...]

    @cached_property
    def columns(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of every column; ("", "") without a header."""
        cells = self.header.cells if self.header else ("",) * len(self.pattern.numeric)
        return tuple(units.named(cell) for cell in cells)

    def find(self, column: str) -> list[int]:
        """Places of the columns of this name, whatever its case, or of this number from 1."""
        if column.strip().isdecimal():
            place = int(column) - 1
            return [place] if 0 <= place < len(self.columns) else []
        wanted = " ".join(column.split()).casefold()
        return [i for i, (name, _) in enumerate(self.columns) if name.casefold() == wanted]

    def place(self, column: str, unit: str = "") -> tuple[int, str]:
        """Place and unit of a column by its name or number; ValueError unless there is one.

        unit: what it is measured in, where the file does not say so; it must not contradict it.
        """
        found = self.find(column)
        if len(found) != 1:
            count = "no column" if not found else f"{len(found)} columns"
            raise ValueError(
                f"{self.path}: {count} {column!r}: {self.told()}; give columns by the names in the "
                "file or by their numbers from 1"
            )
        stated = self.columns[found[0]][1]
        if unit and stated and unit != stated:
            raise ValueError(
                f"{self.path}: unit {unit!r} of column {column!r} contradicts the file's own, "
                f"{stated!r}; leave it out or correct the file"
            )
        return found[0], unit or stated

    def told(self) -> str:
        """The columns in words, for errors."""
        count = len(self.columns)
        if self.header is None:
            return f"it has {count} columns without names"
        listed = ", ".join(repr(cell) for cell in self.header.cells)
        return f"its line {self.header.line} names {count} columns: {listed}"

    def numbers(self, place: int) -> Array:
        """A column (n,). ValueError naming file, line and cell of what is no finite number."""
        name = self.columns[place][0] or f"column {place + 1}"
        return np.array([self._number(row, place, name) for row in self.rows])

    def _number(self, row: Row, place: int, name: str) -> float:
        text, mark = row.cells[place], self.pattern.decimal
        value = float(text.replace(",", ".")) if self.pattern.is_number(text) else np.nan
        if not np.isfinite(value):
            why = f"{name} = {text!r} must be a finite number with the decimal mark {mark!r}"
            refuse(
                self.path, row, f"{why}; mend or remove the line, or skip what is above the data"
            )
        return value


def read_table(path: Path, layout: Layout | None = None) -> TextTable:
    """The columns of numbers of a text file, in the layout given or found.

    ValueError naming file, line and what was expected for a file that is no text or has no rows
    of numbers, for a layout that can be read in more than one way, and for rows whose number of
    cells differs from the header's.
    """
    layout = layout or Layout()
    lines = re.split(r"\r\n|\r|\n", decoded(path, layout.encoding))
    numbered = list(enumerate(lines, 1))[layout.skip :]
    kept = [(number, line) for number, line in numbered if line.strip(' \t;,|"')]
    rows, pattern, key = rows_of(path, kept, layout.delimiter, layout.decimal)
    rows, pattern = _without_last_delimiter(rows, pattern)
    begin = next(i for i, row in enumerate(rows) if pattern.fits(row))
    data = [row for row in rows[begin:] if not row.comment]
    header = _header(path, rows[:begin], data, pattern, key)
    first = header or data[0]
    for row in data:
        if len(row.cells) != len(first.cells):
            _refuse_width(path, row, first)
    _check_marks(path, data, pattern, key, layout, header)
    return TextTable(path, pattern, header, tuple(data))


def _refuse_width(path: Path, row: Row, first: Row) -> None:
    found, count = len(row.cells), len(first.cells)
    why = f"{found} {'cell' if found == 1 else 'cells'} where line {first.line} has {count}"
    refuse(path, row, f"{why}; mend or remove the line, or skip what is above the data")


def _without_last_delimiter(rows: list[Row], pattern: Pattern) -> tuple[list[Row], Pattern]:
    """Without the empty cell behind a delimiter that ends every row of data."""
    data = [row for row in rows if pattern.fits(row)]
    above = [row for row in rows if row.line < data[0].line and not row.comment]
    names_it = above and len(above[-1].cells) == len(pattern.numeric) and above[-1].cells[-1]
    if names_it or any(row.cells[-1] for row in data):
        return rows, pattern
    width = len(pattern.numeric)
    cut = [
        row._replace(cells=row.cells[:-1]) if len(row.cells) == width and not row.cells[-1] else row
        for row in rows
    ]
    return cut, pattern._replace(numeric=pattern.numeric[:-1])


def _header(
    path: Path, above: Sequence[Row], data: Sequence[Row], pattern: Pattern, delimiter: str
) -> Row | None:
    """The line of names above the data, plain or in a comment, joined with a row of units."""
    width = len(data[0].cells)
    plain = [row for row in above if not row.comment]
    found = _joined(plain, width, pattern)
    if found is None and plain:
        _check_line_above(path, plain[-1], data[0], pattern, delimiter)
    return found or _joined([row for row in above if row.comment], width, pattern)


def _joined(above: Sequence[Row], width: int, pattern: Pattern) -> Row | None:
    """The last row if it holds as many names, with that of units below it; else None."""

    def names(row: Row) -> bool:
        words = any(row.cells) and not any(map(pattern.is_number, row.cells))
        return words and len(row.cells) == width

    if not above or not names(above[-1]):
        return None
    if len(above) == 1 or not names(above[-2]) or not _are_units(above[-1]):
        return above[-1]
    joined = zip(above[-2].cells, above[-1].cells, strict=True)
    return above[-2]._replace(cells=tuple(_with_unit(name, unit) for name, unit in joined))


def _are_units(row: Row) -> bool:
    """Whether the cells are units rather than names: at least half of them known, all short."""
    cells = [cell.strip("[]() ") for cell in row.cells if cell]
    known = sum(map(units.any_kind, cells))
    return 2 * known >= len(cells) and max(map(len, cells)) <= 8


def _with_unit(name: str, unit: str) -> str:
    unit = unit.strip("[]() ")
    return f"{name} [{unit}]" if unit and not units.named(name)[1] else name


def _check_line_above(path: Path, row: Row, first: Row, pattern: Pattern, delimiter: str) -> None:
    """ValueError if the line above the data, no header, may be one or a row of data gone wrong."""
    numbers = any(pattern.is_number(cell) or (cell and missing(cell)) for cell in row.cells)
    if numbers and _WORD.match(row.cells[0]):
        return  # a setting of the instrument: its name and its value
    if numbers and len(row.cells) == len(first.cells):
        bad = next(cell for cell in row.cells if not pattern.is_number(cell))
        why = f"{bad!r} must be a number with the decimal mark {pattern.decimal!r}"
        refuse(path, row, f"{why}; mend the line, or skip what is above the data")
    others = any(DELIMITERS[key] in row.text for key in ("tab", ";", "|"))
    if delimiter == "space":
        words = {cell.casefold() for cell in row.cells}
        others, several = False, bool(words & {"x", "z", "depth", "force"})
    else:
        several = len(row.cells) > 1
    if numbers or several or others:
        _refuse_width(path, row, first)


def _check_marks(
    path: Path,
    data: Sequence[Row],
    pattern: Pattern,
    delimiter: str,
    layout: Layout,
    header: Row | None,
) -> None:
    """ValueError where the decimal mark is in doubt: two marks, or one that may group thousands."""
    if layout.decimal is not None:
        return
    mark, other = pattern.decimal, "," if pattern.decimal == "." else "."
    for row in data:
        for cell in row.cells:
            if other in cell and NUMBER[other].fullmatch(cell):
                why = f"{cell!r} has the mark {other!r}, other cells have {mark!r}"
                refuse(path, row, f"{why}; write one decimal mark, or give decimal")
    marked = [
        cell for row in data for cell in row.cells if pattern.is_number(cell) and mark in cell
    ]
    doubtful = mark == "," or delimiter == ";"
    if doubtful and marked and all(map(_THOUSANDS[mark].fullmatch, marked)):
        why = f"{marked[0]!r} may be a number with three decimals or one in thousands"
        refuse(path, data[0], f"{why}; give decimal, without marks between thousands")
    whole = header is None and delimiter == "," and not marked and layout.delimiter is None
    width = len(data[0].cells)
    if whole and width > 2 and width % 2 == 0:
        why = "the commas may separate columns or decimals"
        refuse(path, data[0], f"{why}; give delimiter and decimal, or a header")
