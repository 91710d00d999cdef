"""Columns of numbers in a text file as instruments and spreadsheets write it.

What is not given is found from the file: the encoding from its byte-order mark or its bytes; the
delimiter and the decimal mark as the pair under which most lines are rows of numbers; the beginning
of the data as the first line with the cells of most rows; the header as the line of words above,
with or without a row of units. A file that can be read in more than one way is refused.

Conventions: a `Row` is a line that is not empty, with its number in the file from 1, its cells, and
whether it is a comment; a `Pattern` says which cells of a row of data are numbers, and with which
decimal mark. Columns have places from 0 in the code, and numbers from 1 for the user. `refuse`
raises ValueError with file, line and reason; `missing` is whether a cell stands for no number;
`units.named` splits a header into name and unit, "" if there is none. `decoded(path, encoding)` is
the text of a file, and `rows_of` its rows, their pattern and delimiter. `DELIMITERS` has the known
delimiters by name, `NUMBER` the pattern of a number by decimal mark. Of a `Pattern`, `numeric` says
of each cell whether it is a number, `fits(row)` whether a row has this pattern, `is_number(cell)`
whether a cell is one with its mark. `units.any_kind(unit)` is whether it is a known unit.
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

# Numbers whose mark may be a decimal one or group thousands: "1.500", "12,000".
_THOUSANDS = {mark: re.compile(rf"[+-]?[1-9]\d{{0,2}}\{mark}\d{{3}}") for mark in NUMBER}
_WORD = re.compile(r"[^\W\d_]{2,}")  # two letters or more
# Names by which a line of words separated by blanks is taken for a header with too few cells.
_USUAL_NAMES = frozenset({"x", "z", "depth", "force"})
_LONGEST_UNIT = 8  # characters: more than any symbol has, fewer than most names of columns


@dataclass(frozen=True)
class Layout:
    """How a text file is written.

    Parameters
    ----------
    delimiter : str, optional
        One of `DELIMITERS`: "tab", ";", "|", ",", "space"; None: found from the file.
    decimal : str, optional
        "." or ","; None: found from the file.
    encoding : str, optional
        As Python names it; None: found from the file.
    skip : int
        Lines at the beginning that are no data.

    Raises
    ------
    ValueError
        For any other value.
    """

    delimiter: str | None = None
    decimal: str | None = None
    encoding: str | None = None
    skip: int = 0

    def __post_init__(self) -> None:
        """ValueError for a delimiter, mark, encoding or number of lines that does not exist."""
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
    """The columns of numbers of a text file.

    Attributes
    ----------
    path : Path
    pattern : Pattern
        Of the rows.
    header : Row or None
        The names of the columns; None if there are none.
    rows : tuple of Row
        The data, all rows with as many cells.
    """

    path: Path
    pattern: Pattern
    header: Row | None
    rows: tuple[Row, ...]

    @cached_property
    def columns(self) -> tuple[tuple[str, str], ...]:
        """Name and unit of every column; ("", "") without a header."""
        if self.header is None:
            return (("", ""),) * len(self.pattern.numeric)
        return tuple(units.named(cell) for cell in self.header.cells)

    def find(self, column: str) -> list[int]:
        """Places of the columns of a name, whatever its case, or of a number from 1.

        Parameters
        ----------
        column : str

        Returns
        -------
        list of int
            From 0; empty if there is none.
        """
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

        Returns
        -------
        list of int
            From 0; empty if there is none.
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
        """Place of the only column that a text names.

        Parameters
        ----------
        column : str
        kinds : sequence of str
            As in `places`.

        Returns
        -------
        int
            From 0.

        Raises
        ------
        ValueError
            If there is none, or more than one.
        """
        found = self.places(column, kinds)
        if len(found) != 1:
            count = "no column" if not found else f"{len(found)} columns"
            name, _ = units.named(column)
            raise ValueError(
                f"{self.path}: {count} {name!r}: {self.description()}; give columns by the names "
                "in the file or by their numbers from 1"
            )
        return found[0]

    def unit(self, place: int, column: str) -> str:
        """Unit of a column: the file's own, else the one in the text that names the column.

        Parameters
        ----------
        place : int
            Of the column, from 0.
        column : str
            The text that names it.

        Returns
        -------
        str
            "" if there is none.

        Raises
        ------
        ValueError
            Where the two contradict each other.
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

    def description(self) -> str:
        """The columns in words, for messages."""
        count = len(self.columns)
        if self.header is None:
            return f"it has {count} columns without names"
        listed = ", ".join(repr(cell) for cell in self.header.cells)
        return f"its line {self.header.line} names {count} columns: {listed}"

    def filled(self, places: Sequence[int]) -> int:
        """How many rows there are up to the last one in which one of some columns is filled.

        Parameters
        ----------
        places : sequence of int
            Of the columns, from 0.

        Returns
        -------
        int
        """
        count = len(self.rows)
        while count and all(missing(self.rows[count - 1].cells[place]) for place in places):
            count -= 1
        return count

    def numbers(self, place: int, count: int | None = None) -> Array:
        """The first numbers of a column.

        Parameters
        ----------
        place : int
            Of the column, from 0.
        count : int, optional
            How many; None: all.

        Returns
        -------
        ndarray (count,)

        Raises
        ------
        ValueError
            Naming file, line and cell of what is no finite number.
        """
        name = self.columns[place][0] or f"column {place + 1}"
        return np.array([self._number(row, place, name) for row in self.rows[:count]])

    def _number(self, row: Row, place: int, name: str) -> float:
        """One number of a column of this name; ValueError unless it is finite."""
        text = row.cells[place]
        if self.pattern.is_number(text):
            value = float(text.replace(",", "."))
            if np.isfinite(value):
                return value
        mark = self.pattern.decimal
        why = f"{name} = {text!r} must be a finite number with the decimal mark {mark!r}"
        refuse(self.path, row, f"{why}; mend or remove the line, or skip what is above the data")


def read_table(path: Path, layout: Layout | None = None) -> TextTable:
    """The columns of numbers of a text file.

    Parameters
    ----------
    path : Path
    layout : Layout, optional
        How it is written; what is not given is found from the file.

    Returns
    -------
    TextTable

    Raises
    ------
    ValueError
        Naming file, line and what was expected, for a file that is no text or has no rows of
        numbers, for a layout that can be read in more than one way, and for rows whose number of
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
    """ValueError for a row with another number of cells than the first one."""
    found = len(row.cells)
    count = len(first.cells)
    why = f"{found} {'cell' if found == 1 else 'cells'} where line {first.line} has {count}"
    refuse(path, row, f"{why}; mend or remove the line, or skip what is above the data")


def _without_empty_columns(rows: list[Row], pattern: Pattern) -> tuple[list[Row], Pattern]:
    """Rows and pattern without the columns at the end that hold nothing: neither names nor data.

    They stand behind a delimiter that ends every line, or behind several of them where a
    spreadsheet had more columns.
    """
    width = len(pattern.numeric)
    first = next(i for i, row in enumerate(rows) if pattern.fits(row))
    data = [row.cells for row in rows if pattern.fits(row)]
    line_above = [row.cells for row in rows[:first] if not row.comment][-1:]  # one, or none
    names_of_data = [cells for cells in line_above if len(cells) == width]
    keep = max(_last_filled(cells) for cells in (*data, *names_of_data))
    wider_names = any(len(cells) > width for cells in line_above)
    if keep == width and not wider_names:
        return rows, pattern
    shortened = [row._replace(cells=_without_empty_end(row.cells, keep)) for row in rows]
    return shortened, pattern._replace(numeric=pattern.numeric[:keep])


def _without_empty_end(cells: tuple[str, ...], keep: int) -> tuple[str, ...]:
    """The cells without the empty ones at the end, but at least the first `keep` of them."""
    end = len(cells)
    while end > keep and not cells[end - 1]:
        end -= 1
    return cells[:end]


def _last_filled(cells: Sequence[str]) -> int:
    """How many cells there are up to the last one that is not empty."""
    return max((i for i, cell in enumerate(cells, 1) if cell), default=0)


def _header(
    path: Path, above: Sequence[Row], data: Sequence[Row], pattern: Pattern, delimiter: str
) -> Row | None:
    """The line of names above the data, plain or in a comment, joined with a row of units.

    None if there is none; ValueError if a plain line above the data may be one, but does not fit.
    """
    width = len(data[0].cells)
    plain = [row for row in above if not row.comment]
    found = _joined(_without_remarks(plain, width, pattern), width, pattern)
    if found is None and plain:
        _check_line_above(path, plain[-1], data[0], pattern, delimiter)
    return found or _joined([row for row in above if row.comment], width, pattern)


def _is_names(row: Row, width: int, pattern: Pattern) -> bool:
    """Whether a row holds as many cells as the data, and words in them."""
    if len(row.cells) != width or not any(row.cells):
        return False
    return not any(pattern.is_number(cell) for cell in row.cells)


def _without_remarks(above: Sequence[Row], width: int, pattern: Pattern) -> Sequence[Row]:
    """The lines up to the names, where nothing but words without a number stands below these.

    Such lines mark the end of a header ("eoh", "Data:"), and hold fewer cells than the data. All
    lines if there are no names above them.
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
    for units_at in (len(names) - 1, len(names) - 2):  # the last row, or the last but one
        if units_at > 0 and _are_units(names[units_at]):
            named = names[units_at - 1]
            pairs = zip(named.cells, names[units_at].cells, strict=True)
            return named._replace(cells=tuple(_with_unit(name, unit) for name, unit in pairs))
    return names[-1]


def _are_units(row: Row) -> bool:
    """Whether the cells are units rather than names: at least half of them known, all short."""
    cells = [cell.strip("[]() ") for cell in row.cells if cell]
    known = sum(units.any_kind(cell) for cell in cells)
    longest = max(len(cell) for cell in cells)
    return 2 * known >= len(cells) and longest <= _LONGEST_UNIT


def _with_unit(name: str, unit: str) -> str:
    """A name with the unit that stands below it, unless it has one already."""
    unit = unit.strip("[]() ")
    _, own = units.named(name)
    return f"{name} [{unit}]" if unit and not own else name


def _check_line_above(path: Path, row: Row, first: Row, pattern: Pattern, delimiter: str) -> None:
    """ValueError if the line above the data, no header, may be one or a row of data gone wrong.

    row: that line; first: the first row of data, whose number of cells a header would have.
    """
    numbers = any(pattern.is_number(cell) or (cell and missing(cell)) for cell in row.cells)
    if numbers and _WORD.match(row.cells[0]):
        return  # a setting of the instrument: its name and its value
    if numbers and len(row.cells) == len(first.cells):
        bad = next(cell for cell in row.cells if not pattern.is_number(cell))
        why = f"{bad!r} must be a number with the decimal mark {pattern.decimal!r}"
        refuse(path, row, f"{why}; mend the line, or skip what is above the data")
    if delimiter == "space":  # between the words of a sentence, too: only known names count
        words = {cell.casefold() for cell in row.cells}
        looks_like_names = not words.isdisjoint(_USUAL_NAMES)
    else:
        other_delimiter = any(DELIMITERS[key] in row.text for key in ("tab", ";", "|"))
        looks_like_names = len(row.cells) > 1 or other_delimiter
    if numbers or looks_like_names:
        _refuse_width(path, row, first)


def _check_marks(
    path: Path,
    data: Sequence[Row],
    pattern: Pattern,
    delimiter: str,
    layout: Layout,
    header: Row | None,
) -> None:
    """ValueError where the decimal mark is in doubt and was not given with the layout.

    There are both marks; or all numbers with a mark have three digits behind it, as thousands have;
    or commas separate whole numbers that may be halves of numbers, "1,5" read as 1 and 5.
    """
    if layout.decimal is not None:
        return
    mark = pattern.decimal
    other = "," if mark == "." else "."
    for row in data:
        for cell in row.cells:
            if other in cell and NUMBER[other].fullmatch(cell):
                why = f"{cell!r} has the mark {other!r}, other cells have {mark!r}"
                refuse(path, row, f"{why}; write one decimal mark, or give decimal")
    cells = [cell for row in data for cell in row.cells]
    marked = [cell for cell in cells if pattern.is_number(cell) and mark in cell]
    may_group = mark == "," or delimiter == ";"  # written where a comma is the decimal mark
    if may_group and marked and all(_THOUSANDS[mark].fullmatch(cell) for cell in marked):
        why = f"{marked[0]!r} may be a number with three decimals or one in thousands"
        refuse(path, data[0], f"{why}; give decimal, without marks between thousands")
    only_commas = delimiter == "," and not marked
    width = len(data[0].cells)
    may_be_pairs = width > 2 and width % 2 == 0  # as 1,5,2,5 may be 1.5 and 2.5
    if only_commas and may_be_pairs and header is None and layout.delimiter is None:
        why = "the commas may separate columns or decimals"
        refuse(path, data[0], f"{why}; give delimiter and decimal, or a header")
