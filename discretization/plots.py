"""Figures of an equilibrium, and of a load path: P(d) and a(d) with its events.

Numbers are drawn in SI units with a prefix, or, with si = False or unit = "", as they are. Colours
distinguish the loading of a path from its unloading, or one path from another. An instability is
drawn dashed along the line that the control prescribes: fixed depth or load, or the spring's.

state: an `Equilibrium`; history: a `History`. Both are built on this module, not it on them.

Depths and displacements are positive downwards, and axes of displacements point down. A `Snapshot`
of a path has `depth`, `force`, `half_width` and `left`, its outermost line on the left, nan without
contact; `history.parts` are lists of them along which nothing happens, and between these events,
each with its `kind` and the snapshots `before` and `after`. A `Unit` has a `size`, by which numbers
are divided to be drawn in it, and a `symbol`, "" for plain numbers.

An `Assumption` of the model, of which `validity` has several, has a name, a `value` and the `limit`
that it must not exceed. `state.displacement(x)` is u, `angle_deficits` are π - θ [rad] of the left
and right lines (columns) of contacts (rows). `prefixed(values, unit)` is the `Unit` with the prefix
that suits the largest of them. What is drawn beside a contact is measured in l,
`elastocapillary_length`, or without tension in the thickness h. `per_length` is "/m" for a line
contact, "" about an axis.
"""

from __future__ import annotations

import math
import textwrap
from collections.abc import Iterable
from typing import TYPE_CHECKING, Any

import numpy as np
from numpy.typing import ArrayLike

from energy import Assumption
from energy.arrays import Array
from energy.units import Unit, prefixed
from energy.units import quantity as written

if TYPE_CHECKING:
    from matplotlib.figure import Figure

BLUE = "#0072B2"
ORANGE = "#D55E00"
GREEN = "#009E73"
GREY = "#7F7F7F"
SOFT = "#f3d9b1"
RIGID = "#b8c4cc"
# Kinds of events at which the state jumps, and the marks of all kinds.
JUMPS = ("touch", "jump-in", "jump", "detachment", "pull-off")
MARKS = {"touch": "o", "jump-in": "^", "jump": "D", "detachment": "v", "pull-off": "X"}
MARKS |= {"edge depinning": "s", "tip depinning": "<", "tip pinning": ">", "edge pinning": "p"}
# How the parts of a path are drawn, by the names of `legs`.
STYLES: dict[str, dict[str, Any]] = {
    "loading": {"color": BLUE, "lw": 3.5, "alpha": 0.55, "zorder": 2},
    "unloading": {"color": ORANGE, "lw": 1.4, "zorder": 3},
    "jump": {"color": "black", "lw": 1.1, "ls": "--", "zorder": 4},
    "free": {"color": GREY, "lw": 1.0, "zorder": 1},
}


def canvas(
    width: float, height: float, rows: int = 1, columns: int = 1, **options: Any
) -> tuple[Figure, Any]:
    """A figure that lays itself out, and its axes.

    Parameters
    ----------
    width, height : float
        [inches].
    rows, columns : int
        Of axes.
    **options : Any
        Those of `Figure.subplots`.

    Returns
    -------
    figure : Figure
    axes : Axes, or ndarray of Axes
    """
    from matplotlib.figure import Figure

    figure = Figure(figsize=(width, height), layout="constrained")
    return figure, figure.subplots(rows, columns, **options)


def axis(name: str, unit: Unit) -> str:
    """What stands at an axis: "depth d in µm", or the name alone for plain numbers."""
    return f"{name} in {unit.symbol}" if unit.symbol else name


def plot_state(state: Any, title: str = "", *, si: bool = True) -> Figure:
    """A matplotlib figure of the surface, and of the right contact line enlarged. Assumptions that
    do not hold are named below.

    Parameters
    ----------
    state : Equilibrium
    title : str
        Title of the figure.
    si : bool
        Whether the numbers have SI units, which are then written at the axes.

    Returns
    -------
    Figure
    """
    figure, axes = canvas(11, 5, 1, 2)
    draw_state(axes, state, "m" if si else "")
    figure.suptitle(title, fontsize=14)
    note(figure, [one for one in state.validity if not one.holds])
    return figure


def draw_state(axes: Any, state: Any, unit: str = "m", last: bool = False) -> None:
    """Draw the whole surface on the first of two axes, the right contact line on the second.

    Parameters
    ----------
    axes : sequence of two Axes
    state : Equilibrium
    unit : str
        Of lengths, "" for plain numbers.
    last : bool
        Whether the title says that it is the last of several states in contact.
    """
    _surface(axes[0], state, *_window(state), unit=unit)
    at = f"d = {written(state.depth, unit)}".replace("-", "−").rstrip()
    axes[0].set_title(f"surface at {at}{', last in contact' if last else ''} (not to scale)")
    _contact_line(axes[1], state, unit)


def note(figure: Figure, violated: Iterable[Assumption]) -> None:
    """Write the assumptions that do not hold below a figure; nothing if all do.

    Parameters
    ----------
    figure : Figure
    violated : iterable of Assumption
    """
    terms = ", ".join(f"{a.name} up to {a.value:.2g} (limit {a.limit:g})" for a in violated)
    if terms:
        text = textwrap.wrap(f"Assumptions of the model violated: {terms}", 120)
        figure.supxlabel("\n".join(text), fontsize=10, color=ORANGE)


def _window(state: Any) -> tuple[float, float]:
    """The x between which a state is shown: its contacts and some free surface beside them.

    About an axis it is a diameter.
    """
    scene = state.scene
    ends = state.contacts[np.isfinite(state.contacts)]
    ends = ends if ends.size else np.array([scene.indenter.apex or 0.0])
    lo = float(ends.min())
    hi = float(ends.max())
    lo = -hi if scene.axisymmetric else lo
    # At 5 l beside a line e⁻⁵ = 0.7 % of its displacement is left.
    margin = max(5 * scene.elastocapillary_length, 0.25 * (hi - lo)) or scene.layer.h
    return lo - margin, hi + margin


def _surface(
    axes: Any, state: Any, lo: float, hi: float, origin: float = 0.0, unit: str = "m"
) -> None:
    """Draw the deformed layer and the indenter from x = lo to hi, x counted from the origin.

    unit: of lengths, "" for plain numbers. The axis of u points down, so that the layer is below.
    """
    x = np.linspace(lo, hi, 2001)  # some four to a pixel of each half of the figure
    u = state.displacement(x)
    body = state.depth - state.scene.indenter.height(x)  # the indenter's surface, as u
    lowest = np.sort(body[np.isfinite(body)])[-1:]
    levels = np.concatenate([u, [0.0], lowest])
    span = float(np.ptp(levels)) or state.scene.layer.h
    # The least u that is shown is at the top, with room for the indenter and the legend above the
    # surface, and for some of the layer below it.
    top = float(levels.min()) - 0.9 * span
    bottom = float(levels.max()) + 0.5 * span
    scale = prefixed([lo - origin, hi - origin], unit)
    height = prefixed([top, bottom], unit)
    s = (x - origin) / scale.size
    top = top / height.size
    bottom = bottom / height.size
    axes.fill_between(s, u / height.size, bottom, color=SOFT, lw=0, label="layer")
    axes.fill_between(s, body / height.size, top, color=RIGID, lw=0, label="indenter, d − f")
    axes.plot(s, u / height.size, color=BLUE, lw=2, label="surface u")
    axes.axhline(0, color=GREY, lw=0.8, ls="--", label="undeformed surface")
    axes.set(
        xlim=(s[0], s[-1]),
        ylim=(bottom, top),
        xlabel=axis("radius r" if state.scene.axisymmetric else "position x", scale),
    )
    axes.set_ylabel(axis("displacement u, downwards,", height).rstrip(","))
    axes.ticklabel_format(scilimits=(-3, 4))  # of plain numbers
    axes.legend(loc="upper center", ncols=2, fontsize=9)


def _contact_line(axes: Any, state: Any, unit: str) -> None:
    """Draw the surroundings of the right contact line, enlarged; nothing if there is none.

    unit: of lengths, "" for plain numbers. Distances count from the line.
    """
    if not (state.contacts.size and np.isfinite(state.contacts).all()):
        axes.set_axis_off()
        return
    line = float(state.contacts[-1, 1])
    near = state.scene.elastocapillary_length or state.scene.layer.h
    # More of the free side, over which the surface decays to e⁻⁵ = 0.7 %.
    _surface(axes, state, line - 3 * near, line + 5 * near, line, unit)
    axes.axvline(0, color=GREY, lw=0.8, ls=":")
    place = "radius r" if state.scene.axisymmetric else "position x"
    axes.set_xlabel(axes.get_xlabel().replace(place, "distance from the contact line"))
    angle = np.degrees(state.angle_deficits[-1, 1])
    axes.set_title(f"right contact line: π − θ = {angle:.3g}° (not to scale)")


def legs(history: Any) -> list[tuple[str, list[Any]]]:
    """The parts of a path along which the depth rises or falls, and the jumps between them.

    Neighbouring parts of one kind are one. Infinite depths are left out.

    Parameters
    ----------
    history : History

    Returns
    -------
    list of (str, list of Snapshot)
        What each part is, "loading", "unloading", "jump" or "free" (no contact), and its states.
    """
    found: list[tuple[str, list[Any]]] = []
    for part in history.parts:
        if not isinstance(part, list):  # an event
            found += [("jump", _under_control(history, part))] if part.kind in JUMPS else []
            continue
        free = all(math.isnan(state.left) for state in part)
        kind = "free" if free else "loading" if part[-1].depth > part[0].depth else "unloading"
        if not found or found[-1][0] != kind:
            found.append((kind, []))
        found[-1][1].extend(state for state in part if math.isfinite(state.depth))
    return [(kind, states) for kind, states in found if len(states) > 1]


def _under_control(history: Any, event: Any) -> list[Any]:
    """States of a jump along the line of the control: before, under the load at its end, after.

    Under imposed depth the force jumps. Else the depth does, while what holds the indenter pulls
    with a load, and only then, at the depth after the jump, the force becomes that of the state.
    """
    before = event.before
    after = event.after
    if history.control == "depth":
        return [before, after]
    load = history.hold.load(after.depth, event.control)
    return [before, after._replace(force=load), after]


def _columns(states: list[Any], quantity: str) -> Array:
    """Depths and the quantity (2, n)."""
    return np.array([(state.depth, getattr(state, quantity)) for state in states]).T


def units(history: Any, quantity: str, si: bool = True) -> tuple[Unit, Unit]:
    """Units of depth and of a quantity in which a path is drawn.

    Parameters
    ----------
    history : History
    quantity : {"force", "half_width"}
    si : bool
        Whether the numbers have SI units.

    Returns
    -------
    depth, quantity : Unit
    """
    in_contact = [state for kind, states in legs(history) if kind != "free" for state in states]
    depth, values = _columns(in_contact, quantity)
    other = f"N{history.scene.per_length}" if quantity == "force" else "m"
    return prefixed(depth, "m" if si else ""), prefixed(values, other if si else "")


def draw_path(
    axes: Any, history: Any, quantity: str, scale: tuple[Unit, Unit], colour: str | None = None
) -> None:
    """Draw one path over the depth.

    Parameters
    ----------
    axes : Axes
    history : History
    quantity : {"force", "half_width"}
    scale : tuple of Unit
        Units of depth and of the quantity; see `units`.
    colour : str, optional
        One for the whole path; by default one each for loading and unloading.
    """
    x, y = scale
    for kind, states in legs(history):
        style = dict(STYLES[kind])
        if colour is not None and kind != "free":
            style |= {"color": colour, "lw": 1.3 if kind == "jump" else 1.8, "alpha": 1.0}
        depth, values = _columns(states, quantity) / [[x.size], [y.size]]
        axes.plot(depth, values, **style)
        if kind != "free" and np.ptp(depth) + np.ptp(values) > 0:
            _arrow(axes, depth, values, style["color"], 0.35 if kind == "loading" else 0.6)
    width = "radius a" if history.scene.axisymmetric else "half-width a"
    axes.set(xlabel=axis("depth d", x), ylabel=axis("force P" if quantity == "force" else width, y))
    axes.ticklabel_format(scilimits=(-3, 4))  # of plain numbers


def _arrow(axes: Any, x: Array, y: Array, colour: str, at: float) -> None:
    """Draw an arrow head on the line through x, y (n,), at this part of its length, 0 to 1.

    Lengths are those with both axes scaled to the line's range.
    """
    steps = np.hypot(np.diff(x) / (np.ptp(x) or 1.0), np.diff(y) / (np.ptp(y) or 1.0))
    length = np.append(0.0, np.cumsum(steps))
    # The arrow stands along a twentieth of the line: so short that it is straight.
    ends = np.array([at - 0.025, at + 0.025]) * length[-1]
    tail, head = zip(np.interp(ends, length, x), np.interp(ends, length, y), strict=True)
    style = {"arrowstyle": "-|>", "color": colour, "mutation_scale": 14, "shrinkA": 0, "shrinkB": 0}
    axes.annotate("", head, tail, arrowprops=style, zorder=5)


def mark(axes: Any, history: Any, quantity: str, scale: tuple[Unit, Unit]) -> None:
    """Mark the events of a path by kind, where contact has begun or from where the state jumps.

    The parameters are those of `draw_path`.
    """
    x, y = scale
    for event in history.events:
        contact_begins = event.kind in ("touch", "jump-in")
        state = event.after if contact_begins else event.before
        place = (state.depth / x.size, getattr(state, quantity) / y.size)
        _, labels = axes.get_legend_handles_labels()
        label = None if event.kind in labels else event.kind
        style = {"marker": MARKS.get(event.kind, "h"), "mec": "black", "zorder": 6}
        if "pinning" in event.kind:
            style |= {"ms": 12, "mfc": "none"}
        else:
            style |= {"ms": 8, "mfc": GREEN}
        axes.plot(*place, ls="", label=label, **style)


def plot_path(
    history: Any,
    title: str = "",
    closed_form: tuple[ArrayLike, ArrayLike, ArrayLike] | None = None,
    *,
    si: bool = True,
) -> Figure:
    """A matplotlib figure of P(d) and a(d) with the events, under a load also of d over the load.

    Parameters
    ----------
    history : History
    title : str
        Title of the figure.
    closed_form : tuple of array_like (n,), optional
        Depths, forces and half-widths to draw besides.
    si : bool
        Whether the numbers have SI units, which are then written at the axes.

    Returns
    -------
    Figure
    """
    driven = history.control != "depth"
    figure, row = canvas(12.5, 5 - 0.7 * driven, 1, 2 + driven)
    for axes, quantity, column in zip(row, ("force", "half_width"), (1, 2), strict=False):
        scale = units(history, quantity, si)
        draw_path(axes, history, quantity, scale)
        if closed_form is not None:
            x = np.asarray(closed_form[0])
            y = np.asarray(closed_form[column])
            thick = {"color": "black", "lw": 6, "alpha": 0.15, "zorder": 0}
            axes.plot(x / scale[0].size, y / scale[1].size, label="closed form", **thick)
        for kind in ("loading", "unloading", "jump", "free"):
            name = {"jump": "instability", "free": "no contact"}.get(kind, kind)
            axes.plot([], [], label=name, **STYLES[kind])
        mark(axes, history, quantity, scale)
        axes.axhline(0, color=GREY, lw=0.6, ls=":")
        axes.grid(alpha=0.25)
    row[0].legend(fontsize=9)
    if driven:
        _programme(row[2], history, si)
    note(figure, [one for one in history.validity if not one.holds])
    figure.suptitle(title, fontsize=14)
    return figure


def _programme(axes: Any, history: Any, si: bool) -> None:
    """Draw the depth of every step over the imposed force or drive.

    si: whether the numbers have SI units. Steps at which a dead load has pulled the indenter away,
    to the depth -inf, are left out.
    """
    if history.control == "force":
        label = "imposed force"
        unit = f"N{history.scene.per_length}"
    else:
        label = "drive D"
        unit = "m"
    depth = np.where(np.isfinite(history.depth), history.depth, math.nan)
    imposed_unit = prefixed(history.values, unit if si else "")
    depth_unit = prefixed(depth, "m" if si else "")
    imposed = history.values / imposed_unit.size
    axes.plot(imposed, depth / depth_unit.size, ".-", color=BLUE, lw=1, ms=4)
    axes.set(xlabel=axis(label, imposed_unit), ylabel=axis("depth d", depth_unit))
    axes.grid(alpha=0.25)
