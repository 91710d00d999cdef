"""Tables on disk: CSV under a header of commented lines that says how to make them again."""

from __future__ import annotations

import csv
import functools
import importlib.metadata
import platform
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """What the system refuses while this file is written, such as a full disk, names its path."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


def versions() -> dict[str, str]:
    """Versions of elastocap, Python, numpy and scipy."""
    found = {"elastocap": "from source", "python": platform.python_version()}
    for package in ("elastocap", "numpy", "scipy"):
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


@functools.cache
def commit() -> str:
    """The commit this code is from, "-dirty" if it was changed since; else "unknown"."""
    here = ["git", "-C", str(Path(__file__).parent)]
    own = [*here, "ls-files", "--error-unmatch", Path(__file__).name]  # not in another's repository
    asked = [own, [*here, "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*"]]
    try:
        done = [subprocess.run(a, capture_output=True, text=True, check=True) for a in asked]
    except (OSError, subprocess.CalledProcessError):
        return "unknown"
    return done[-1].stdout.strip()


def header(command: str, parameters: object) -> list[str]:
    """What reproduces a table: its command and parameters, and the versions and commit used."""
    made = ", ".join(f"{name} {version}" for name, version in versions().items())
    lines = [f"command: {command}", f"parameters: {parameters}", f"versions: {made}"]
    return [*lines, f"commit: {commit()}"]


def aligned(widths: Sequence[int], cells: Iterable[str]) -> str:
    """A line of the table on the screen; a cell of negative width begins at its left."""
    texts = (c.ljust(-w) if w < 0 else c.rjust(w) for c, w in zip(cells, widths, strict=True))
    return " ".join(texts).rstrip()


def write(
    path: Path, head: Iterable[str], columns: Sequence[str], rows: Iterable[Iterable[Any]]
) -> None:
    """Rows below the names of the columns below the commented header; numbers to the last bit."""
    with naming(path), path.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"# {' '.join(line.split())}\n" for line in head)
        table = csv.writer(file, lineterminator="\n")
        table.writerow(columns)
        table.writerows(rows)


def read(path: Path) -> list[dict[str, str]]:
    """The rows of such a file, by the names of the columns."""
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))
