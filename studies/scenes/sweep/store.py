"""The results of a sweep on disk: one JSON line for each point, appended as it comes.

The first line says which sweep the file belongs to. While a sweep writes it, another one with the
same file is refused; this lock ends with the process, however that ends (there is none on Windows).
A line is {"at": i, "found": {...}} or {"at": i, "error": "..."}, i the number of the point;
not-a-number is null. A line that a kill cut in two is no JSON object and is passed over; of several
lines for one point the last one counts.

A `Grid` numbers all combinations of the values of its axes, the last axis fastest, and `point(i)`
is one of them by key. `naming(path)` has errors of the system name the file.
"""

from __future__ import annotations

import contextlib
import json
import math
import os
import sys
import time
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TextIO

import numpy as np

from studies.scenes.grid import Grid
from studies.shared.table import naming

if sys.platform != "win32":
    import fcntl

Found = dict[str, Any]
SYNC = 1.0  # s between two fsyncs: a power cut loses no more, and the disk is not waited for


def found_line(at: int, found: Mapping[str, Any]) -> str:
    """The line of a point that was found."""
    plain = {
        name: None if isinstance(value, float) and not math.isfinite(value) else value
        for name, value in found.items()
    }
    return json.dumps({"at": at, "found": plain}, ensure_ascii=False, allow_nan=False)


def failed_line(at: int, error: BaseException) -> str:
    """The line of a point that failed."""
    message = " ".join(f"{type(error).__name__}: {error}".split())
    return json.dumps({"at": at, "error": message}, ensure_ascii=False)


class Store:
    """A file of results that is appended to and synced now and then; a context manager.

    Parameters
    ----------
    path : Path
    identity : dict
        Plain data that say which sweep it belongs to.
    """

    def __init__(self, path: Path, identity: Any) -> None:
        """Nothing is opened before the `with`."""
        self.path = path
        self.identity = identity

    def __enter__(self) -> Store:
        """Open or begin the file. ValueError if it holds another sweep, or one is writing it."""
        self.path.parent.mkdir(parents=True, exist_ok=True)
        self.file: TextIO = self.path.open("a+", encoding="utf-8", errors="replace")
        try:
            self._lock()
            self.file.seek(0)
            text = self.file.read()
            self._check(text)
        except BaseException:
            self.file.close()
            raise
        self.synced = time.monotonic()
        if not text:
            self._begin()
        elif not text.endswith("\n"):
            self.add([""])  # after a line cut in two
        return self

    def _lock(self) -> None:
        """A lock of this process, not kept by those that it starts; where files have locks."""
        if sys.platform == "win32":
            return
        try:
            fcntl.lockf(self.file, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except (BlockingIOError, PermissionError):
            raise ValueError(
                f"{self.path}: another command is writing this file; wait for its end, or give "
                "another folder with --out"
            ) from None
        except OSError:
            return

    def _check(self, text: str) -> None:
        """ValueError where the file holds results of another command."""
        saved = _object(text.partition("\n")[0])
        wanted = json.loads(json.dumps(self.identity))
        differing = [key for key in wanted if key not in saved or saved[key] != wanted[key]]
        if text and differing:
            raise ValueError(
                f"{self.path} holds results of another command (it differs in "
                f"{', '.join(differing)}): give another folder with --out, or remove that file to "
                "begin anew"
            )

    def _begin(self) -> None:
        """Say which sweep it is; a disk that is full even for that keeps no empty file."""
        try:
            self.add([json.dumps(self.identity, ensure_ascii=False)])
        except OSError:
            with contextlib.suppress(OSError):
                self.file.close()
            self.path.unlink()
            raise

    def add(self, lines: Iterable[str]) -> None:
        """Append lines; they survive a kill of this process at once, a power cut after SYNC."""
        with naming(self.path):
            self.file.writelines(f"{line}\n" for line in lines)
            self.file.flush()
            if time.monotonic() - self.synced > SYNC:
                os.fsync(self.file.fileno())
                self.synced = time.monotonic()

    def __exit__(self, *exception: object) -> None:
        """Write what is left to the disk, and close the file, which ends its lock."""
        with naming(self.path), self.file:
            self.file.flush()
            os.fsync(self.file.fileno())

    def results(self) -> dict[int, Found]:
        """The line of each point so far, by its number; read from the file that is locked, if so.

        A lock ends where its process closes the file, even when it has opened it twice.
        """
        if "file" not in vars(self) or self.file.closed:
            text = self.path.read_text("utf-8", errors="replace") if self.path.exists() else ""
        else:
            self.file.seek(0)
            text = self.file.read()
        found = map(_object, text.split("\n")[1:])
        return {line["at"]: line for line in found if "at" in line}


def _object(line: str) -> Found:
    """The object on a line; an empty one for a line that was cut."""
    try:
        found = json.loads(line)
    except ValueError:
        return {}
    return found if isinstance(found, dict) else {}


@dataclass(frozen=True)
class Record:
    """A finished sweep: its grid, and what was found or the error at each point."""

    grid: Grid
    results: tuple[Found, ...]

    @property
    def failed(self) -> int:
        """How many points failed."""
        return sum("error" in result for result in self.results)

    @property
    def detached(self) -> np.ndarray:
        """Whether the state at each point is detached (n,)."""
        labels = [result.get("found", {}).get("label") for result in self.results]
        return np.array([label == "detached" for label in labels])

    def column(self, name: str) -> np.ndarray:
        """A number at every point (n,); nan where the point failed or has none."""
        values = [result.get("found", {}).get(name) for result in self.results]
        return np.array([math.nan if value is None else value for value in values], float)
