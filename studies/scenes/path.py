"""The load path of a scene file: its response, and its table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from discretization import History, load_path
from studies.scenes.file import SceneFile
from studies.shared.table import naming


def follow(given: SceneFile) -> History:
    """`discretization.load_path` along the file's [path]. ValueError names the file."""
    programme, options = given.programme, given.options
    if programme is None:
        raise ValueError(f"{given.path}: path is missing; add a [path] with depths to the file")
    programmed: dict[str, Any] = {programme.control: programme.values}
    lattice = options.get("method") == "lattice"
    try:
        return load_path(
            given.scene,
            **programmed,
            machine_stiffness=programme.machine_stiffness,
            method="lattice" if lattice else "fitted",
            spacing=options.get("spacing"),
            rtol=options.get("rtol", 1e-8),
        )
    except ValueError as error:
        raise ValueError(f"{given.path}: [path]: {error}") from error


def write_csv(history: History, path: Path, notes: Sequence[str]) -> None:
    """`History.to_csv`, which `History.from_csv` reads back; the notes follow as comments."""
    with naming(path):
        history.to_csv(path)
        with path.open("a", encoding="utf-8") as file:
            file.writelines(f"# {' '.join(note.split())}\n" for note in notes)
