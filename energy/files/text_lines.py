"""The lines of a text file and their cells: encoding, delimiter, decimal mark."""

import codecs
import csv
import re
from collections import Counter
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple, NoReturn

DELIMITERS = {"tab": "\t", ";": ";", "|": "|", ",": ",", "space": " "}
NUMBER = {
    ".": re.compile(r"[+-]?(\d+\.?\d*|\.\d+)([eE][+-]?\d+)?", re.ASCII),
    ",": re.compile(r"[+-]?(\d+(,\d+)?|,\d+)([eE][+-]?\d+)?", re.ASCII),
}
_MARKS = {
    codecs.BOM_UTF8: "utf-8-sig",
    codecs.BOM_UTF32_LE: "utf-32",  # before UTF-16, whose mark it begins with
    codecs.BOM_UTF32_BE: "utf-32",
    codecs.BOM_UTF16_LE: "utf-16",
    codecs.BOM_UTF16_BE: "utf-16",
}
_MISSING = re.compile(r"[+-]?(nan|inf|infinity)|n/?a|null|none|-+|\?+|#[A-Z/0]+[!?]?|", re.I)
_BINARY = re.compile("[\x00-\x08\x0e-\x19\x1b-\x1f\x7f-\x9f]")
_TOKEN = re.compile(r"[^\s\[(]\S*(?:\s*[\[(][^\])]*[\])])?|\S+")  # a name keeps the unit behind it
_SHOWN = 60  # characters of a line in errors


class Row(NamedTuple):
    """A line that is not empty: its number from 1, its text, its cells, whether a comment."""

    line: int
    text: str
    cells: tuple[str, ...]
    comment: bool


class Pattern(NamedTuple):
    """What the rows of data have in common: the decimal mark, and which cells are numbers."""

    decimal: str
    numeric: tuple[bool, ...]

    def fits(self, row: Row) -> bool:
        """Whether the row has these cells, numbers or missing ones where numbers should be."""
        if row.comment or len(row.cells) != len(self.numeric):
            return False
        cells = [cell for cell, wanted in zip(row.cells, self.numeric, strict=True) if wanted]
        found = [self.is_number(cell) for cell in cells]
        return any(found) and all(map(lambda f, c: f or missing(c), found, cells))

    def is_number(self, cell: str) -> bool:
        """Whether the whole cell is a number with this decimal mark."""
        return NUMBER[self.decimal].fullmatch(cell) is not None


def missing(cell: str) -> bool:
    """Whether a cell stands for a number that is not there: empty, nan, n/a, -, #N/A."""
    return _MISSING.fullmatch(cell) is not None


def refuse(path: Path, row: Row, why: str) -> NoReturn:
    """ValueError naming file and line."""
    text = row.text.strip()
    shown = text if len(text) <= _SHOWN else f"{text[:_SHOWN]}…"
    raise ValueError(f"{path}: line {row.line}: {why}; the line is {shown!r}")


def decoded(path: Path, encoding: str | None) -> str:
    """The text of a file. ValueError for one that cannot be read, is empty or no text."""
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
    """From the byte-order mark, else UTF-16 by its zero bytes, else UTF-8 or Windows's own."""
    for mark, name in _MARKS.items():
        if data.startswith(mark):
            return name
    even = data[0:4096:2].count(0)
    odd = data[1:4096:2].count(0)
    if max(even, odd) > 0.3 * len(data[:4096]) and min(even, odd) == 0:
        return "utf-16-le" if odd else "utf-16-be"
    try:
        data.decode("utf-8")
    except UnicodeDecodeError:
        return "latin-1" if any(byte in data for byte in b"\x81\x8d\x8f\x90\x9d") else "cp1252"
    return "utf-8"


def rows_of(
    path: Path, lines: Sequence[tuple[int, str]], delimiter: str | None, decimal: str | None
) -> tuple[list[Row], Pattern, str]:
    """The rows of numbered lines, the pattern of the data among them, and their delimiter.

    Each pair of a delimiter and a decimal mark that is not given is tried. The pair taken is the
    one with the most rows of one pattern with at least two numbers; among these with the fewest
    cells that are none. ValueError if there is no such pair.
    """
    best: tuple[tuple[int, int], list[Row], Pattern, str] | None = None
    for key in [delimiter] if delimiter else DELIMITERS:
        if not any(DELIMITERS[key] in line or key == "space" for _, line in lines):
            continue
        rows = [row_of(number, line, key) for number, line in lines]
        for mark in [decimal] if decimal else NUMBER:
            found = Counter(_numeric(row, mark) for row in rows if not row.comment)
            usable = [(count, numeric) for numeric, count in found.items() if sum(numeric) > 1]
            if usable:
                count, numeric = max(usable, key=lambda pair: pair[0])
                score = count, sum(numeric) - len(numeric)
                if best is None or score > best[0]:
                    best = score, rows, Pattern(mark, numeric), key
    if best is None:
        raise ValueError(
            f"{path}: no line has two numbers or more with one decimal mark; give rows of numbers "
            f"in columns, or say how it is written: delimiter ({', '.join(DELIMITERS)}), decimal "
            "mark, encoding"
        )
    return best[1:]


def _numeric(row: Row, mark: str) -> tuple[bool, ...]:
    """Which cells are numbers; () for a row that this delimiter does not take apart."""
    numeric = tuple(NUMBER[mark].fullmatch(cell) is not None for cell in row.cells)
    words = (cell for cell, number in zip(row.cells, numeric, strict=True) if not number)
    return () if any(re.search("[;|\t]", cell) for cell in words) else numeric


def row_of(number: int, line: str, delimiter: str) -> Row:
    """The cells of a line; those of a comment, too, since it may hold the names of columns."""
    comment = re.match(r"\s*[#%]+", line)
    text = line[comment.end() :] if comment else re.sub(r"\s#\s.*", "", line)
    if delimiter == "space":
        cells = _TOKEN.findall(text)
    else:
        given = csv.reader([text], delimiter=DELIMITERS[delimiter], skipinitialspace=True)
        try:
            cells = next(given, [])
        except csv.Error:  # a cell too long for any number
            cells = [text]
    return Row(number, line, tuple(cell.strip() for cell in cells), comment is not None)
