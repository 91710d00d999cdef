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
from energy.files.text_lines import (
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


def _plain(text: str) -> str:
    """A name without what readers do not see: its case, and how many blanks stand in it."""
    return " ".join(text.split()).casefold()


def _is_of_kind(unit: str, kinds: Sequence[str]) -> bool:
    """Whether the unit is one of these kinds."""
    return any(units.size(unit, kind) is not None for kind in kinds)


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
        wanted = _plain(column)
        return [i for i, (name, _) in enumerate(self.columns) if _plain(name) == wanted]

    def places(self, column: str, kinds: Sequence[str] = ()) -> list[int]:
        """Places of all columns that this text names.

        Parameters
        ----------
        column : str
            The cell of the header as it is written, "Depth (nm)"; or a name with or without a unit,
            "depth [nm]"; or a number from 1. The first of these that is in the file counts.
        kinds : sequence of str
            Kinds of units (`units.KINDS`). They choose among several columns of one name.
        """
        header = self.header.cells if self.header else ()
        exact = [i for i, cell in enumerate(header) if _plain(cell) == _plain(column)]
        if exact:
            return exact
        name, unit = units.named(column)
        found = self.find(name)
        if len(found) < 2:
            return found
        if unit:
            of_this_unit = [i for i in found if self.columns[i][1] == unit]
            return of_this_unit or found
        of_these_kinds = [i for i in found if _is_of_kind(self.columns[i][1], kinds)]
        return of_these_kinds or found

    def place(self, column: str, kinds: Sequence[str] = ()) -> int:
        """Place of the only column that this text names; ValueError unless there is one."""
        found = self.places(column, kinds)
        if len(found) != 1:
            count = "no column" if not found else f"{len(found)} columns"
            name, _ = units.named(column)
            raise ValueError(
                f"{self.path}: {count} {name!r}: {self.told()}; give columns by the names in the "
                "file or by their numbers from 1"
            )
        return found[0]

    def unit(self, place: int, column: str) -> str:
        """Unit of a column: the file's own, else the one in the text that names it.

        ValueError where the two contradict each other.
        """
        stated = self.columns[place][1]
        header = self.header.cells[place] if self.header else ""
        name, given = units.named(column)
        if given and stated and given != stated and _plain(header) != _plain(column):
            raise ValueError(
                f"{self.path}: unit {given!r} of column {name!r} contradicts the file's own, "
                f"{stated!r}; leave it out or correct the file"
            )
        return stated or given

    def told(self) -> str:
        """The columns in words, for errors."""
        count = len(self.columns)
        if self.header is None:
            return f"it has {count} columns without names"
        listed = ", ".join(repr(cell) for cell in self.header.cells)
        return f"its line {self.header.line} names {count} columns: {listed}"

    def filled(self, places: Sequence[int]) -> int:
        """How many rows there are up to the last one in which one of these columns is filled."""
        count = len(self.rows)
        while count and all(missing(self.rows[count - 1].cells[place]) for place in places):
            count -= 1
        return count

    def numbers(self, place: int, count: int | None = None) -> Array:
        """The first numbers of a column (count,), by default all.

        ValueError naming file, line and cell of what is no finite number.
        """
        name = self.columns[place][0] or f"column {place + 1}"
        return np.array([self._number(row, place, name) for row in self.rows[:count]])

    def _number(self, row: Row, place: int, name: str) -> float:
        text = row.cells[place]
        mark = self.pattern.decimal
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
    rows, pattern = _without_empty_columns(rows, pattern)
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
    found = len(row.cells)
    count = len(first.cells)
    why = f"{found} {'cell' if found == 1 else 'cells'} where line {first.line} has {count}"
    refuse(path, row, f"{why}; mend or remove the line, or skip what is above the data")


def _without_empty_columns(rows: list[Row], pattern: Pattern) -> tuple[list[Row], Pattern]:
    """Without the columns at the end that hold nothing: neither names nor data.

    They stand behind a delimiter that ends every line, or behind several of them where a
    spreadsheet had more columns.
    """
    width = len(pattern.numeric)
    first = next(i for i, row in enumerate(rows) if pattern.fits(row))
    data = [row.cells for row in rows if pattern.fits(row)]
    names = [row.cells for row in rows[:first] if not row.comment][-1:]
    filled = [_last_filled(cells) for cells in data]
    filled += [_last_filled(cells) for cells in names if len(cells) == width]
    keep = max(filled)
    if keep == width and not any(len(cells) > width for cells in names):
        return rows, pattern
    shortened = []
    for row in rows:
        end = len(row.cells)
        while end > keep and not row.cells[end - 1]:
            end -= 1
        shortened.append(row._replace(cells=row.cells[:end]))
    return shortened, pattern._replace(numeric=pattern.numeric[:keep])


def _last_filled(cells: Sequence[str]) -> int:
    """How many cells there are up to the last one that is not empty."""
    return max((i for i, cell in enumerate(cells, 1) if cell), default=0)


def _header(
    path: Path, above: Sequence[Row], data: Sequence[Row], pattern: Pattern, delimiter: str
) -> Row | None:
    """The line of names above the data, plain or in a comment, joined with a row of units."""
    width = len(data[0].cells)
    plain = [row for row in above if not row.comment]
    found = _joined(_without_remarks(plain, width, pattern), width, pattern)
    if found is None and plain:
        _check_line_above(path, plain[-1], data[0], pattern, delimiter)
    return found or _joined([row for row in above if row.comment], width, pattern)


def _is_names(row: Row, width: int, pattern: Pattern) -> bool:
    """Whether a row holds as many cells as the data, and words in them."""
    words = any(row.cells) and not any(map(pattern.is_number, row.cells))
    return words and len(row.cells) == width


def _without_remarks(above: Sequence[Row], width: int, pattern: Pattern) -> Sequence[Row]:
    """The lines up to the names, where nothing but words without a number stands below these.

    Such lines mark the end of a header ("eoh", "Data:"), and hold fewer cells than the data.
    """
    end = len(above)
    while end and len(above[end - 1].cells) < width and not re.search(r"\d", above[end - 1].text):
        end -= 1
    if end and _is_names(above[end - 1], width, pattern):
        return above[:end]
    return above


def _joined(above: Sequence[Row], width: int, pattern: Pattern) -> Row | None:
    """The names in the last rows, with the units below them; None if there are no names.

    Below the units there may be one more row of words, as of a program that writes comments there.
    """
    names: list[Row] = []
    for row in reversed(above):
        if not _is_names(row, width, pattern):
            break
        names.insert(0, row)
    if not names:
        return None
    for units_at in (len(names) - 1, len(names) - 2):
        if units_at > 0 and _are_units(names[units_at]):
            named = names[units_at - 1]
            pairs = zip(named.cells, names[units_at].cells, strict=True)
            return named._replace(cells=tuple(_with_unit(name, unit) for name, unit in pairs))
    return names[-1]


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
        others = False
        several = bool(words & {"x", "z", "depth", "force"})
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
    mark = pattern.decimal
    other = "," if pattern.decimal == "." else "."
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
