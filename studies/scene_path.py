"""The load path of a scene file: its response, what is told of it, and its table."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import Any

from discretization import History, PullOff, load_path
from studies.scene_file import SceneFile


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


def most_tensile(history: History) -> PullOff | None:
    """`History.pull_off`; None for a path without tension."""
    try:
        return history.pull_off
    except ValueError:
        return None


def told(history: History) -> str:
    """The events in their order, the most tensile state and the energy lost."""
    control = history.control
    lines = [f"load path: {history.values.size} steps of {control}, {len(history.events)} events"]
    lines.append(
        f"{'event':18s}{control:>14s}{'depth/m':>14s}{'force/(N/m)':>14s}{'lost/(J/m)':>14s}"
    )
    for event in history.events:
        values = (event.control, event.depth, event.force, event.energy_released)
        lines.append(f"{event.kind:18s}" + "".join(f"{value:>14.6g}" for value in values))
    pull = most_tensile(history)
    if pull is not None:
        force, depth, half_width = pull
        at = f"P = {force:.6g} N/m at d = {depth:.6g} m, a = {half_width:.6g} m"
        lines.append(f"most tensile: {at}")
    return "\n".join([*lines, f"energy lost on the way: {history.dissipated:.6g} J/m"])


def write_csv(history: History, path: Path, notes: Sequence[str]) -> None:
    """`History.to_csv`, which `History.from_csv` reads back; the notes follow as comments."""
    history.to_csv(path)
    with path.open("a", encoding="utf-8") as file:
        file.writelines(f"# {' '.join(note.split())}\n" for note in notes)
