"""Tables on disk: CSV under a header of commented lines that says how to make them again.

A `Table` is the names of its columns and its rows, as `write` takes them and studies return them.
"""

import csv
import functools
import importlib.metadata
import json
import os
import platform
import re
import subprocess
from collections.abc import Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any

SOURCE = "from source"  # the version of what is not installed
Table = tuple[Sequence[str], Sequence[Sequence[object]]]  # columns and rows


@contextmanager
def naming(path: Path) -> Iterator[None]:
    """What the system refuses while this file is written, such as a full disk, names its path."""
    try:
        yield
    except OSError as error:
        raise OSError(error.errno, error.strerror, str(path)) from error


@contextmanager
def replacing(path: Path) -> Iterator[Path]:
    """A file beside this one, which takes its place once it is written: never half, nor empty."""
    beside = path.with_name(f"{path.name}.part")
    with naming(path):
        try:
            yield beside
            os.replace(beside, path)
        except BaseException:
            beside.unlink(missing_ok=True)
            raise


def versions(*more: str) -> dict[str, str]:
    """Versions of elastocap, Python, numpy, scipy and more packages, where they are installed."""
    found = {"elastocap": SOURCE, "python": platform.python_version()}
    for package in ("elastocap", "numpy", "scipy", *more):
        try:
            found[package] = importlib.metadata.version(package)
        except importlib.metadata.PackageNotFoundError:
            continue
    return found


@functools.cache
def commit() -> str:
    """The commit that this code is from.

    Returns
    -------
    str
        The first of these that is known:

        the commit of the repository that this file is in, with "-dirty" if it was changed since;
        "unknown" without a repository where elastocap is not installed;
        the commit that pip has recorded, as it does for the address of a repository;
        "not recorded, version ... as installed".
    """
    here = Path(__file__)
    try:
        _git(here.parent, "ls-files", "--error-unmatch", here.name)  # not in another's repository
        return _git(here.parent, "describe", "--always", "--dirty", "--abbrev=12", "--exclude=*")
    except (OSError, subprocess.CalledProcessError):
        version = versions()["elastocap"]
        if version == SOURCE:
            return "unknown"
        return recorded_commit() or f"not recorded, version {version} as installed"


def _git(folder: Path, *given: str) -> str:
    """What git prints in a folder."""
    command = ["git", "-C", str(folder), *given]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    return done.stdout.strip()


def recorded_commit() -> str:
    """The commit of the repository that pip has installed this package from; "" if it has not."""
    try:
        origin = importlib.metadata.distribution("elastocap").read_text("direct_url.json")
    except importlib.metadata.PackageNotFoundError:
        return ""
    found = json.loads(origin or "{}").get("vcs_info", {}).get("commit_id", "")
    return str(found)[:12]


def header(command: str, parameters: object) -> list[str]:
    """What reproduces a table: its command and parameters, and the versions and commit used.

    Parameters
    ----------
    command : str
    parameters : object

    Returns
    -------
    list of str
    """
    made = ", ".join(f"{name} {version}" for name, version in versions().items())
    lines = [f"command: {command}", f"parameters: {parameters}", f"versions: {made}"]
    return [*lines, f"commit: {commit()}"]


class Columns:
    """A table on the screen.

    Parameters
    ----------
    columns : str
        Name, width and digits of each column, as "indenter -10|l/b 8.3g"; a negative width begins
        at the left.
    """

    def __init__(self, columns: str) -> None:
        """Take the columns apart; `head` is the line of their names."""
        found = re.findall(r"([^|]*) (-?\d+)([^|]*)", columns)
        self.forms = [(int(width), digits) for _, width, digits in found]
        self.head = self.line(*(name for name, _, _ in found))

    def line(self, *cells: Any) -> str:
        """A line of the table: texts are taken as they are, None is blank, NaN a dash.

        Parameters
        ----------
        cells : str, float, int or None
            As many as there are columns.

        Returns
        -------
        str
        """
        texts = []
        for cell, (width, digits) in zip(cells, self.forms, strict=True):
            text = _shown(cell, digits)
            texts.append(text.rjust(width) if width > 0 else text.ljust(-width))
        return " ".join(texts).rstrip()


def _shown(cell: Any, digits: str) -> str:
    """A cell on the screen."""
    if cell is None:
        return ""
    if isinstance(cell, str):
        return cell
    return "—" if cell != cell else format(cell, digits)


def markdown(columns: Sequence[str], rows: Iterable[Sequence[str]]) -> str:
    """A table in Markdown.

    Parameters
    ----------
    columns : sequence of str
    rows : iterable of sequences of str

    Returns
    -------
    str
    """
    lines = (columns, ["---"] * len(columns), *rows)
    return "\n".join(f"| {' | '.join(cells)} |" for cells in lines)


def write(
    path: Path, head: Iterable[str], columns: Sequence[str], rows: Iterable[Iterable[Any]]
) -> None:
    """Write rows below the names of the columns below a commented header.

    Numbers are written to the last bit.

    Parameters
    ----------
    path : Path
    head : iterable of str
        Lines of the header.
    columns : sequence of str
    rows : iterable of rows
    """
    with replacing(path) as beside, beside.open("w", newline="", encoding="utf-8") as file:
        file.writelines(f"# {' '.join(line.split())}\n" for line in head)
        table = csv.writer(file, lineterminator="\n")
        table.writerow(columns)
        table.writerows(rows)


def read(path: Path) -> list[dict[str, str]]:
    """The rows of a file as `write` makes it.

    Parameters
    ----------
    path : Path

    Returns
    -------
    list of dict
        A dict from the names of the columns for each row.
    """
    with path.open(encoding="utf-8", newline="") as file:
        return list(csv.DictReader(line for line in file if not line.startswith("#")))
