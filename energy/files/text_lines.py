"""The lines of a text file and their cells: encoding, delimiter, decimal mark.

What is not given is found: the encoding by `decoded`, delimiter and decimal mark by `rows_of`.
Delimiters go by their names in DELIMITERS ("tab", ";", "space", ...), a decimal mark is "." or ",".
Numbers of lines count from 1, as an editor does.
"""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, NoReturn

# Delimiters by their names, in the order in which they are tried: of two that fit as well the
# earlier one counts, and blanks, which stand in names, too, come last.
DELIMITERS = {"tab": "\t", ";": ";", "|": "|", ",": ",", "space": " "}
# What a number looks like with each decimal mark: "1.5e-3", "2.", ".5"; "1,5", ",5", but not "2,",
# which is a number before a comma.
NUMBER = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII),
    ",": re.compile(r"[+-]?(\d+(,\d+)?|,\d+)([eE][+-]?\d+)?", re.ASCII),
}
_MARKS = {  # byte-order marks at the beginning of a file, and Python's name of the encoding
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",  # before UTF-16, whose mark it begins with
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
# Cells that stand for a missing number: nan, n/a, null, "-", "?", and Excel's #N/A, #DIV/0!; "".
_MISSING = re.compile(r"[+-]?(nan|inf|infinity)|n/?a|null|none|-+|\?+|#[A-Z/0]+[!?]?|", re.I)
# Control characters but white space and 1a, with which text ends under DOS: no text holds them.
_BINARY = re.compile("[\x00-\x08\x0e-\x19\x1b-\x1f\x7f-\x9f]")
_TOKEN = re.compile(r"[^\s\[(]\S*(?:\s*[\[(][^\])]*[\])])?|\S+")  # a name keeps the unit behind it
_SHOWN = 60  # characters of a line in errors, which then fit on two lines of a terminal
# In UTF-16 every second byte of text in European languages is zero: a file with more than this
# share of zero bytes, all of them at even places or all at odd ones, is taken for UTF-16.
_ZERO_BYTES = 0.3
_LOOKED_AT = 4096  # bytes at the beginning of a file, in which that is counted
_NOT_IN_CP1252 = b"\x81\x8d\x8f\x90\x9d"  # bytes that are no character in Windows's code page


class Row(NamedTuple):
    """A line of a file that is not empty.

    Attributes
    ----------
    line : int
        Its number from 1.
    text : str
    cells : tuple of str
    comment : bool
        Whether it begins with # or %.
    """

    line: int
    text: str
    cells: tuple[str, ...]
    comment: bool


class Pattern(NamedTuple):
    """What the rows of data have in common.

    Attributes
    ----------
    decimal : str
        The decimal mark, "." or ",".
    numeric : tuple of bool
        Which cells are numbers.
    """

    decimal: str
    numeric: tuple[bool, ...]

    def fits(self, row: Row) -> bool:
        """Whether the row has as many cells, and numbers or missing ones where they should be."""
        if row.comment or len(row.cells) != len(self.numeric):
            return False
        cells = [cell for cell, wanted in zip(row.cells, self.numeric, strict=True) if wanted]
        if not any(self.is_number(cell) for cell in cells):
            return False
        return all(self.is_number(cell) or missing(cell) for cell in cells)

    def is_number(self, cell: str) -> bool:
        """Whether the whole cell is a number with this decimal mark."""
        return NUMBER[self.decimal].fullmatch(cell) is not None


def missing(cell: str) -> bool:
    """Whether a cell stands for a number that is not there: empty, nan, n/a, -, #N/A.

    Parameters
    ----------
    cell : str

    Returns
    -------
    bool
    """
    return _MISSING.fullmatch(cell) is not None


def refuse(path: Path, row: Row, why: str) -> NoReturn:
    """Raise a ValueError that names file and line.

    Parameters
    ----------
    path : Path
    row : Row
    why : str
        What is wrong with the line, and the remedy.
    """
    text = row.text.strip()
    shown = text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"
    raise ValueError(f"{path}: line {row.line}: {why}; the line is {shown!r}")


def decoded(path: Path, encoding: str | None) -> str:
    """The text of a file.

    Parameters
    ----------
    path : Path
    encoding : str or None
        As Python names it; None: by the byte-order mark, else UTF-16 by its zero bytes, else UTF-8,
        else Windows's code page.

    Returns
    -------
    str
        With "-" for a true minus sign.

    Raises
    ------
    ValueError
        For a file that cannot be read, is empty, or is no text.
    """
    try:
        data = path.read_bytes()
    except OSError as error:
        raise ValueError(f"{path}: {error.strerror}; give a text file") from None
    if not data.strip():
        raise ValueError(f"{path}: is empty; give a file with columns of numbers")
    found = encoding or _encoding(data)
    try:
        text = data.decode(found).removeprefix("\ufeff")
    except (UnicodeError, ValueError) as error:
        raise ValueError(f"{path}: is no text in {found}: {error}; give its encoding") from None
    bad = _BINARY.search(text)
    if bad:
        raise ValueError(
            f"{path}: is no text: it contains the character {bad[0]!r}; export it as text from the "
            "program that wrote it, or give the encoding if it is text"
        )
    return text.replace("\u2212", "-").replace("\x1a", "")  # a true minus; the end under DOS


def _encoding(data: bytes) -> str:
    """Python's name of the encoding of these bytes, as `decoded` finds it."""
    for mark, name in _MARKS.items():
        if data.startswith(mark):
            return name
    beginning = data[:_LOOKED_AT]
    even = beginning[0::2].count(0)
    odd = beginning[1::2].count(0)
    if max(even, odd) > _ZERO_BYTES * len(beginning) and min(even, odd) == 0:
        return "utf-16-le" if odd else "utf-16-be"  # little end first: "a" is 61 00
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        unknown_to_windows = any(byte in data for byte in _NOT_IN_CP1252)
        return "latin-1" if unknown_to_windows else "cp1252"  # latin-1 knows every byte
    return "utf-8"


def rows_of(
    path: Path, lines: Sequence[tuple[int, str]], delimiter: str | None, decimal: str | None
) -> tuple[list[Row], Pattern, str]:
    """The rows of a file, the pattern of the data among them, and their delimiter.

    Each pair of a delimiter and a decimal mark that is not given is tried. The pair taken is the
    one with the most rows of one pattern with at least two numbers; among these the one with the
    fewest cells that are no numbers.

    Parameters
    ----------
    path : Path
    lines : sequence of (int, str)
        The lines that are not empty, with their numbers from 1.
    delimiter : str or None
        One of `DELIMITERS`; None: found.
    decimal : str or None
        "." or ","; None: found.

    Returns
    -------
    rows : list of Row
    pattern : Pattern
    delimiter : str

    Raises
    ------
    ValueError
        If no pair gives a row with two numbers or more.
    """
    best: tuple[list[Row], Pattern, str] | None = None
    best_score = (0, 0)
    for key in [delimiter] if delimiter else DELIMITERS:
        if key != "space" and not any(DELIMITERS[key] in line for _, line in lines):
            continue
        rows = [row_of(number, line, key) for number, line in lines]
        for mark in [decimal] if decimal else NUMBER:
            count, numeric = _most_frequent(rows, mark)
            cells_without_number = len(numeric) - sum(numeric)
            score = (count, -cells_without_number)  # the first one decides, the second a tie
            if count and (best is None or score > best_score):
                best = (rows, Pattern(mark, numeric), key)
                best_score = score
    if best is None:
        raise ValueError(
            f"{path}: no line has two numbers or more with one decimal mark; give rows of numbers "
            f"in columns, or say how it is written: delimiter ({', '.join(DELIMITERS)}), decimal "
            "mark, encoding"
        )
    return best


def _most_frequent(rows: list[Row], mark: str) -> tuple[int, tuple[bool, ...]]:
    """How many rows have the most frequent pattern with at least two numbers, and that pattern.

    A pattern says which cells of a row are numbers with this decimal mark. (0, ()) if there is
    none; the first in the file of several that are as frequent.
    """
    counts = Counter(_numeric(row, mark) for row in rows if not row.comment)
    usable = {numeric: count for numeric, count in counts.items() if sum(numeric) > 1}
    if not usable:
        return 0, ()
    numeric = max(usable, key=lambda pattern: usable[pattern])
    return usable[numeric], numeric


def _numeric(row: Row, mark: str) -> tuple[bool, ...]:
    """Which cells are numbers with this decimal mark.

    () for a row that this delimiter does not take apart: one of its words holds another one.
    """
    numeric = tuple(NUMBER[mark].fullmatch(cell) is not None for cell in row.cells)
    words = (cell for cell, number in zip(row.cells, numeric, strict=True) if not number)
    other_delimiter = any(re.search("[;|\t]", cell) for cell in words)
    return () if other_delimiter else numeric


def row_of(number: int, line: str, delimiter: str) -> Row:
    """The cells of a line; those of a comment, too, since it may hold the names of columns.

    Parameters
    ----------
    number : int
        Of the line in the file, from 1.
    line : str
    delimiter : str
        One of `DELIMITERS`.

    Returns
    -------
    Row
    """
    comment = re.match(r"\s*[#%]+", line)
    without_remark = re.sub(r"\s#\s.*", "", line)  # a remark behind the data: " # ..."
    text = line[comment.end() :] if comment else without_remark
    if delimiter == "space":
        cells = _TOKEN.findall(text)
    else:
        reader = csv.reader([text], delimiter=DELIMITERS[delimiter], skipinitialspace=True)
        try:
            cells = next(reader, [])
        except csv.Error:  # a cell too long for any number
            cells = [text]
    stripped = tuple(cell.strip() for cell in cells)
    return Row(number, line, stripped, comment is not None)
