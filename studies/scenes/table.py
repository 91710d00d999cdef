"""A table of a scene file, read key by key; complaints name the file, the key and a remedy.

`nearest(key, known)` is a hint at the known key that an unknown one resembles, "" if none does.
"""

import contextlib
import re
import sys
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NoReturn, TypeVar

import numpy as np

from energy.checks import nearest

T = TypeVar("T")
TOP = (
    *("title", "source", "depth", "layer", "surfaces", "opening", "indenter"),
    *("path", "measured", "options"),
)
RANGE = ("from", "to", "steps", "spacing")


class Table:
    """One table of the file; every complaint names the file, the key and what is known.

    Parameters
    ----------
    path : Path
        Of the file.
    name : str
        Of the table; "file" for what stands above the first section.
    table : mapping
        What the file holds there.
    known : tuple of str
        The keys it may have.

    Raises
    ------
    ValueError
        For an unknown key, and what is no table.
    """

    def __init__(self, path: Path, name: str, table: Any, known: tuple[str, ...]) -> None:
        """Refuse what is no table, and keys that are not known."""
        self.path = path
        self.name = name
        self.known = known
        if not isinstance(table, Mapping):
            self.refuse(name, table, f"must be a table: [{name}]")
        self.table = table
        for key in table:
            if key not in known:
                misplaced = self.name != "file" and key in TOP
                above = " here: write it above the first [section]"
                hint = above if misplaced else nearest(key, known)
                self.refuse(key, table[key], f"is unknown{hint}")

    def refuse(self, key: str, value: Any, why: str) -> NoReturn:
        """Raise a ValueError for a key and its value."""
        raise self.error(f"{key} = {value!r} {why}")

    def error(self, problem: str) -> ValueError:
        """The error of a problem, which begins with a key, with file, line and known keys."""
        named = self.name == "file" or problem.startswith(f"{self.name} ")
        name = "" if named else f"{self.name}."
        known = f"; known keys: {', '.join(self.known)}" if self.known else ""
        return ValueError(f"{self.path}: {name}{problem}{self.line(problem)}{known}")

    def line(self, problem: str) -> str:
        """The line of the key that a problem begins with, or of its section; "" if not found."""
        *outer, inner = self.name.split(".")
        key = re.split(r"\W", problem)[0]
        of_key = (self.name, key)
        of_section = (".".join(outer) or "file", inner)
        with contextlib.suppress(OSError, ValueError):
            at = lines_of_keys(self.path.read_text("utf-8-sig"))
            for place in (of_key, of_section):
                if place in at:
                    return f" (at line {at[place]})"
        return ""

    def number(self, key: str) -> float:
        """A finite number; ValueError for anything else, and where it is missing."""
        return self._finite(key, self.get(key))

    def whole(self, key: str, least: int) -> int:
        """A whole number of at least this; ValueError for anything else."""
        value = self.get(key)
        if isinstance(value, bool) or not isinstance(value, int) or value < least:
            self.refuse(key, value, f"must be a whole number of at least {least}")
        return int(value)

    def numbers(self, key: str) -> list[float]:
        """A list of at least one finite number; ValueError for anything else."""
        values = self.get(key)
        if not isinstance(values, list) or not values:
            self.refuse(key, values, "must be a list of at least one number")
        return [self._finite(f"{key}[{i}]", value) for i, value in enumerate(values)]

    def spread(self, key: str) -> list[float]:
        """The number, the numbers of a list, or those of a range."""
        value = self.get(key)
        if isinstance(value, Mapping):
            name = key if self.name == "file" else f"{self.name}.{key}"
            return Table(self.path, name, value, RANGE).range()
        return self.numbers(key) if isinstance(value, list) else [self.number(key)]

    def range(self) -> list[float]:
        """{ from, to, steps, spacing }: `steps` values, evenly spaced, or so in their logarithm."""
        first = self.number("from")
        last = self.number("to")
        count = self.whole("steps", 2)
        spacing = self.text("spacing", "linear")
        if spacing not in ("linear", "log"):
            self.refuse("spacing", spacing, 'must be "linear" or "log"')
        if spacing == "linear":
            return [float(value) for value in np.linspace(first, last, count)]
        if not first * last > 0:
            self.refuse("from", first, f"to {last!r} crosses zero: a log range needs one sign")
        return [float(value) for value in np.geomspace(first, last, count)]

    def _finite(self, key: str, value: Any) -> float:
        """The value as a float; ValueError unless it is a finite number."""
        if isinstance(value, bool) or not isinstance(value, int | float):
            swept = isinstance(value, list | Mapping)
            hint = "; a list or a range makes a sweep: python -m studies sweep" if swept else ""
            self.refuse(key, value, f"must be a number in SI units, without quotes and unit{hint}")
        if not abs(value) <= sys.float_info.max:
            self.refuse(key, value, "must be finite")
        return float(value)

    def text(self, key: str, default: str | None = None) -> str:
        """A text; ValueError for anything else, and where it is missing without a default."""
        value = self.get(key) if default is None else self.table.get(key, default)
        if not isinstance(value, str):
            self.refuse(key, value, "must be a text in quotes")
        return str(value)

    def get(self, key: str) -> Any:
        """The value of a key; ValueError where it is missing."""
        if key not in self.table:
            raise self.error(f"{key} is missing")
        return self.table[key]

    def build(self, kind: Callable[..., T], *values: Any) -> T:
        """kind(*values); its errors are raised with the name of this table."""
        try:
            return kind(*values)
        except ValueError as error:
            where = self.line(str(error))
            raise ValueError(f"{self.path}: {self.name}.{error}{where}") from None


def lines_of_keys(text: str) -> dict[tuple[str, str], int]:
    """The first line of each (section, key) of a TOML file, and of each section ("file", name)."""
    found: dict[tuple[str, str], int] = {}
    section = "file"
    for number, line in enumerate(text.splitlines(), 1):
        header = re.match(r"\s*\[+\s*([^\]]+?)\s*\]", line)
        key = re.match(r"""\s*["']?([\w-]+)["']?\s*[=.]""", line)
        if header:
            section = header[1]
            found.setdefault(("file", section), number)
        elif key:
            found.setdefault((section, key[1]), number)
    return found
