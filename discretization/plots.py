"""Figures of an equilibrium: the layer and the indenter, and the surroundings of a contact line.

Lengths are drawn in metres with a prefix, or, with unit = "", as the plain numbers of the scene.
"""

from __future__ import annotations

import textwrap
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np

from energy import Assumption
from energy.units import Unit, prefixed

if TYPE_CHECKING:
    from matplotlib.figure import Figure

    from discretization.equilibrium import Equilibrium

BLUE, ORANGE, GREEN, GREY = "#0072B2", "#D55E00", "#009E73", "#7F7F7F"  # Okabe-Ito, and grey
SOFT, RIGID = "#f3d9b1", "#b8c4cc"


def canvas(
    width: float, height: float, rows: int = 1, columns: int = 1, **options: Any
) -> tuple[Figure, Any]:
    """A figure of this size in inches that lays itself out, and its axes; options of `subplots`."""
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, columns, **options)


def axis(name: str, unit: Unit) -> str:
    """What stands at an axis: "depth d in µm", or the name alone for plain numbers."""
    return f"{name} in {unit.symbol}" if unit.symbol else name


def plot(state: Equilibrium, title: str = "", *, si: bool = True) -> Figure:
    """A matplotlib figure of the surface, and of the right contact line enlarged.

    Lengths are drawn in metres with a prefix; si = False, for other units: as plain numbers.
    Assumptions of the model that do not hold are named below.
    """
    drawn, axes = canvas(11, 5, 1, 2)
    draw(axes, state, "m" if si else "")
    drawn.suptitle(title, fontsize=14)
    note(drawn, [one for one in state.validity if not one.holds])
    return drawn


def draw(axes: Any, state: Equilibrium, unit: str = "m", last: bool = False) -> None:
    """The whole surface on the first of two axes, the right contact line on the second.

    last: say that it is the last of several states in contact.
    """
    _surface(axes[0], state, *_window(state), unit=unit)
    depth = prefixed(state.depth, unit)
    at = f"d = {state.depth / depth.size:.4g} {depth.symbol}".replace("-", "−").rstrip()
    axes[0].set_title(f"surface at {at}{', last in contact' if last else ''} (not to scale)")
    _contact_line(axes[1], state, unit)


def note(figure: Figure, violated: Iterable[Assumption]) -> None:
    """The assumptions that do not hold, below a figure; nothing if all do."""
    terms = ", ".join(f"{a.name} up to {a.value:.2g} (limit {a.limit:g})" for a in violated)
    if terms:
        text = textwrap.wrap(f"Assumptions of the model violated: {terms}", 120)
        figure.supxlabel("\n".join(text), fontsize=10, color=ORANGE)


def _window(state: Equilibrium) -> tuple[float, float]:
    """Ends of the contact and some free surface beside them."""
    scene = state.scene
    ends = state.contacts if np.isfinite(state.contacts).all() else state.contacts[:0]
    middle = scene.indenter.apex or 0.0
    lo, hi = (float(ends.min()), float(ends.max())) if ends.size else (middle, middle)
    lo = -hi if scene.axisymmetric else lo
    margin = max(5 * scene.elastocapillary_length, 0.25 * (hi - lo)) or scene.layer.h
    return lo - margin, hi + margin


def _surface(
    axes: Any, state: Equilibrium, lo: float, hi: float, origin: float = 0.0, unit: str = "m"
) -> None:
    """The deformed layer and the indenter from x = lo to hi, x drawn from the origin."""
    x = np.linspace(lo, hi, 2001)
    u, body = state.displacement(x), state.depth - state.scene.indenter.height(x)
    lowest = np.sort(body[np.isfinite(body)])[-1:]  # of the indenter; u is positive downwards
    drawn = np.concatenate([u, [0.0], lowest])
    span = float(np.ptp(drawn)) or state.scene.layer.h
    top, bottom = float(drawn.min()) - 0.9 * span, float(drawn.max()) + 0.5 * span
    scale, height = prefixed([lo - origin, hi - origin], unit), prefixed([top, bottom], unit)
    s, top, bottom = (x - origin) / scale.size, top / height.size, bottom / height.size
    axes.fill_between(s, u / height.size, bottom, color=SOFT, lw=0, label="layer")
    axes.fill_between(s, body / height.size, top, color=RIGID, lw=0, label="indenter, d - f(x)")
    axes.plot(s, u / height.size, color=BLUE, lw=2, label="surface u(x)")
    axes.axhline(0, color=GREY, lw=0.8, ls="--", label="undeformed surface")
    axes.set(xlim=(s[0], s[-1]), ylim=(bottom, top), xlabel=axis("position x", scale))
    axes.set_ylabel(axis("displacement u, downwards,", height).rstrip(","))
    axes.ticklabel_format(scilimits=(-3, 4))  # of plain numbers
    axes.legend(loc="upper center", ncols=2, fontsize=9)


def _contact_line(axes: Any, state: Equilibrium, unit: str) -> None:
    """The surroundings of the right contact line, enlarged; nothing if there is none."""
    if not (state.contacts.size and np.isfinite(state.contacts).all()):
        axes.set_axis_off()
        return
    line = float(state.contacts[-1, 1])
    near = state.scene.elastocapillary_length or state.scene.layer.h
    _surface(axes, state, line - 3 * near, line + 5 * near, line, unit)
    axes.axvline(0, color=GREY, lw=0.8, ls=":")
    axes.set_xlabel(axes.get_xlabel().replace("position x", "distance from the contact line"))
    angle = np.degrees(state.angle_deficits[-1, 1])
    axes.set_title(f"right contact line: π − θ = {angle:.3g}° (not to scale)")
