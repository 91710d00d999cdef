"""Equilibria in words and as plain data: for the screen, notebooks and data frames."""

from __future__ import annotations

import math
from html import escape
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from discretization.equilibrium import Equilibrium

OBSERVABLES = ("depth", "half_width", "force", "energy", "contact_angle")


def to_dict(state: Equilibrium) -> dict[str, float | str]:
    """One row of a data frame: observables, their absolute errors, and which state it is.

    contact_angle [rad]: the mean over all contact lines; contacts: how many there are.
    """
    numbers = {name: float(getattr(state, name)) for name in OBSERVABLES}
    errors = {f"error_{name}": float(error) for name, error in state.uncertainty.items()}
    words = {"label": state.label, "branch": state.branch, "method": state.method}
    return {**numbers, **errors, "contacts": len(state.contacts), **words}


def line(state: Equilibrium) -> str:
    """One line with the observables."""
    numbers = ", ".join(f"{name}={getattr(state, name):.6g}" for name in OBSERVABLES[:4])
    return f"Equilibrium({numbers}, label={state.label!r}, method={state.method!r})"


def html(state: Equilibrium) -> str:
    """The same text for notebooks."""
    return f"<pre>{escape(text(state))}</pre>"


def text(state: Equilibrium) -> str:
    """The observables with their errors, and how far the assumptions of the model hold."""
    kind = f"{state.label}, {state.branch} branch, {state.method}"
    error = {
        name: f"± {size:.1e}" if math.isfinite(size) else "not resolved: use smaller spacing"
        for name, size in state.uncertainty.items()
    }
    width = "radius" if state.scene.axisymmetric else "half-width"
    lines = [
        f"depth        d = {state.depth:.10g}   ({kind})",
        f"{width:12s} a = {state.half_width:.10g}   ({error['half_width']})",
        f"force        P = {state.force:.10g}   ({error['force']})",
        f"energy       U = {state.energy:.10g}   ({error['energy']})",
        f"angle        θ = {state.contact_angle:.10g} rad   (π - θ = {state.angle_deficit:.6g})",
    ]
    return "\n".join(lines + [f"validity     {a}" for a in state.validity])
