"""Equilibria and load paths in words and as plain data: for screens, notebooks and data frames.

state: an `Equilibrium`; history: a `History`. Both are built on this module, not it on them.
"""

from __future__ import annotations

import math
from html import escape
from typing import Any

import numpy as np
from numpy.typing import NDArray

_UNRESOLVED = "not resolved: use smaller spacing"
OBSERVABLES = ("depth", "half_width", "force", "energy", "contact_angle")


def html(shown: Any) -> str:
    """The text of a state or of a path for notebooks."""
    return f"<pre>{escape(str(shown))}</pre>"


def state_row(state: Any) -> dict[str, float | str]:
    """One row of a data frame: observables, their absolute errors, and which state it is.

    contact_angle [rad]: the mean over all contact lines; contacts: how many there are.
    """
    numbers = {name: float(getattr(state, name)) for name in OBSERVABLES}
    errors = {f"error_{name}": float(error) for name, error in state.uncertainty.items()}
    words = {"label": state.label, "branch": state.branch, "method": state.method}
    return {**numbers, **errors, "contacts": len(state.contacts), **words}


def state_line(state: Any) -> str:
    """One line with the observables."""
    numbers = ", ".join(f"{name}={getattr(state, name):.6g}" for name in OBSERVABLES[:4])
    return f"Equilibrium({numbers}, label={state.label!r}, method={state.method!r})"


def state_text(state: Any) -> str:
    """The observables with their numerical errors, and how far the model's assumptions hold."""
    kind = f"{state.label}, {state.branch} branch, {state.method}"
    error = {
        name: f"numerical error {size:.1e}" if math.isfinite(size) else _UNRESOLVED
        for name, size in state.uncertainty.items()
    }
    theta = state.contact_angle
    angle = "none with small slopes" if theta < 0 else f"θ = {theta:.10g} rad"
    width = "radius" if state.scene.axisymmetric else "half-width"
    lines = [
        f"depth        d = {state.depth:.10g}   ({kind})",
        f"{width:12s} a = {state.half_width:.10g}   ({error['half_width']})",
        f"force        P = {state.force:.10g}   ({error['force']})",
        f"energy       U = {state.energy:.10g}   ({error['energy']})",
        f"angle        {angle}   (π - θ = {state.angle_deficit:.6g})",
    ]
    return "\n".join(lines + [f"validity     {a}" for a in state.validity])


def path_columns(history: Any) -> dict[str, NDArray[np.float64]]:
    """Columns (n,) of a data frame: what is imposed, and the state at every step.

    left, right: the outermost contact lines, nan when detached; contacts: how many there are.
    """
    left, right = history.contacts.T
    inner = np.array([len(lines) // 2 + 1 for lines in history.inner], float)
    names = ("depth", "half_width", "force", "energy")
    return {
        "control": history.values,
        **{name: getattr(history, name) for name in names},
        "left": left,
        "right": right,
        "contacts": np.where(np.isnan(left), 0.0, inner),
    }


def path_line(history: Any) -> str:
    """One line with the counts and the energy lost."""
    counts = f"{len(history)} steps of {history.control}, {len(history.events)} events"
    return f"History({counts}, dissipated={history.dissipated:.6g})"


def path_text(history: Any, si: bool = False) -> str:
    """The events in their order, the most tensile state and the energy lost; si: with SI units."""
    control, count, per = history.control, len(history.events), history.scene.per_length
    units = {
        "depth": "m",
        "force": f"(N{per})" if per else "N",
        "lost": f"(J{per})" if per else "J",
    }
    names = [f"{name}/{unit}" if si else name for name, unit in units.items()]
    lines = [f"load path: {len(history)} steps of {control}, {count} events"]
    imposed = () if control == "depth" else (control,)  # a depth has its column
    lines.append(f"{'event':18s}" + "".join(f"{name:>14s}" for name in (*imposed, *names)))
    for event in history.events:
        values = (event.control, event.depth, event.force, event.energy_released)[not imposed :]
        lines.append(f"{event.kind:18s}" + "".join(f"{value:>14.6g}" for value in values))
    metres, newtons, joules = (" m", f" N{per}", f" J{per}") if si else ("", "", "")
    if (pull := most_tensile(history)) is not None:
        at = f"d = {pull.depth:.6g}{metres}, a = {pull.half_width:.6g}{metres}"
        lines.append(f"most tensile: P = {pull.force:.6g}{newtons} at {at}")
    return "\n".join([*lines, f"energy lost on the way: {history.dissipated:.6g}{joules}"])


def most_tensile(history: Any) -> Any:
    """`History.pull_off`; None for a path without tension."""
    try:
        return history.pull_off
    except ValueError:
        return None
