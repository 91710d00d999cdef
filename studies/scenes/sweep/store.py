"""The results of a sweep on disk: one JSON line for each point, appended as it comes.

The first line says which sweep the file belongs to. A line is {"at": i, "found": {...}} or
{"at": i, "error": "..."}, i the number of the point; not-a-number is null. A line that a kill cut
in two is no JSON object and is passed over; of several lines for one point the last one counts.
"""

from __future__ import annotations

import json
import math
import os
import time
from collections.abc import Iterable, Mapping
from pathlib import Path
from types import TracebackType
from typing import Any, TextIO

from studies.shared.table import naming

Found = dict[str, Any]
SYNC = 1.0  # s between two fsyncs


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
    """A file of results that is appended to and synced now and then; a context manager."""

    def __init__(self, path: Path, identity: Any) -> None:
        """Open or begin the file. ValueError if it holds another sweep."""
        self.path = path
        if path.exists():
            _refuse_another(path, identity)
        else:
            path.parent.mkdir(parents=True, exist_ok=True)
            beside = path.with_name(f"{path.name}.{os.getpid()}.part")
            beside.write_text(json.dumps(identity, ensure_ascii=False) + "\n", encoding="utf-8")
            os.replace(beside, path)

    def __enter__(self) -> Store:
        self.file: TextIO = self.path.open("a", encoding="utf-8")
        if not self.path.read_bytes().endswith(b"\n"):
            self.file.write("\n")  # after a line cut in two
            self.file.flush()
        self.synced = time.monotonic()
        return self

    def add(self, lines: Iterable[str]) -> None:
        """Append lines; they survive a kill of this process at once, a power cut after SYNC."""
        with naming(self.path):
            self.file.writelines(f"{line}\n" for line in lines)
            self.file.flush()
            if time.monotonic() - self.synced > SYNC:
                os.fsync(self.file.fileno())
                self.synced = time.monotonic()

    def __exit__(
        self,
        kind: type[BaseException] | None,
        value: BaseException | None,
        at: TracebackType | None,
    ) -> None:
        with naming(self.path), self.file:
            self.file.flush()
            os.fsync(self.file.fileno())

    def results(self) -> dict[int, Found]:
        """The line of each point so far, by its number."""
        with self.path.open(encoding="utf-8", errors="replace") as file:
            next(file)
            lines = filter(None, map(_whole, file))
            return {line["at"]: line for line in lines}


def _whole(line: str) -> Found | None:
    """The object on a line; None for one that was cut."""
    try:
        found = json.loads(line)
    except ValueError:
        return None
    return found if isinstance(found, dict) and "at" in found else None


def _refuse_another(path: Path, identity: Any) -> None:
    with path.open(encoding="utf-8", errors="replace") as file:
        saved = _json(file.readline())
    wanted = json.loads(json.dumps(identity))
    differing = [
        key for key in wanted if not isinstance(saved, dict) or saved.get(key) != wanted[key]
    ]
    if differing:
        raise ValueError(
            f"{path} holds another sweep (it differs in {', '.join(differing)}): give another "
            "folder with --out, or remove that file to begin anew"
        )


def _json(text: str) -> Any:
    try:
        return json.loads(text)
    except ValueError:
        return None
