"""Load paths in words and as plain data: for the screen, notebooks and data frames."""

from __future__ import annotations

from html import escape
from typing import TYPE_CHECKING

import numpy as np
from numpy.typing import NDArray

from discretization.paths.events import PullOff

if TYPE_CHECKING:
    from discretization.paths.history import History


def to_dict(history: History) -> dict[str, NDArray[np.float64]]:
    """Columns (n,) of a data frame: what is imposed, and the state at every step.

    left, right: the outermost contact lines, nan when detached; contacts: how many there are.
    """
    left, right = history.contacts.T
    inner = np.array([len(lines) // 2 + 1 for lines in history.inner], float)
    return {
        "control": history.values,
        "depth": history.depth,
        "half_width": history.half_width,
        "force": history.force,
        "energy": history.energy,
        "left": left,
        "right": right,
        "contacts": np.where(np.isnan(left), 0.0, inner),
    }


def line(history: History) -> str:
    """One line with the counts and the energy lost."""
    counts = f"{len(history)} steps of {history.control}, {len(history.events)} events"
    return f"History({counts}, dissipated={history.dissipated:.6g})"


def html(history: History) -> str:
    """The same text for notebooks."""
    return f"<pre>{escape(text(history))}</pre>"


def text(history: History, si: bool = False) -> str:
    """The events in their order, the most tensile state and the energy lost; si: with SI units."""
    control, count, per = history.control, len(history.events), history.scene.per_length
    units = {
        "depth": "m",
        "force": f"(N{per})" if per else "N",
        "lost": f"(J{per})" if per else "J",
    }
    names = [f"{name}/{unit}" if si else name for name, unit in units.items()]
    lines = [f"load path: {len(history)} steps of {control}, {count} events"]
    lines.append(f"{'event':18s}" + "".join(f"{name:>14s}" for name in (control, *names)))
    for event in history.events:
        values = (event.control, event.depth, event.force, event.energy_released)
        lines.append(f"{event.kind:18s}" + "".join(f"{value:>14.6g}" for value in values))
    metres, newtons, joules = (" m", f" N{per}", f" J{per}") if si else ("", "", "")
    if (pull := most_tensile(history)) is not None:
        at = f"d = {pull.depth:.6g}{metres}, a = {pull.half_width:.6g}{metres}"
        lines.append(f"most tensile: P = {pull.force:.6g}{newtons} at {at}")
    return "\n".join([*lines, f"energy lost on the way: {history.dissipated:.6g}{joules}"])


def most_tensile(history: History) -> PullOff | None:
    """`History.pull_off`; None for a path without tension."""
    try:
        return history.pull_off
    except ValueError:
        return None
