"""What `contact_angle` measures: its parameters, the record, and the figures drawn of it.

θ is the contact angle in the outer medium, π where the surface is smooth; what is measured is the
deficit π - θ, the sum of the inclinations of indenter and free surface at the line. Its laws are
Young's (8), cos θ = w/γ₁ - 1, and (15), π - θ = √(2w/γ₁), for small slopes.

Conventions:

- `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
- `plain_ticks` labels a logarithmic axis with plain numbers.
"""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from energy.arrays import Array
from studies.shared.figures import COLOURS, LINE, MARKERS, Figure, canvas, plain_ticks

BAR = 1e-8  # relative error of π - θ on the mesh, at most
ORDERS = (1.7, 2.3)  # of the error of θ in the spacing of the nodes: second order
LEAST_DRAWN = 1e-17  # relative difference of π - θ; some are 0, which a logarithm has no place for


@dataclass(frozen=True)
class Parameters:
    """What is simulated.

    Attributes
    ----------
    ratios : tuple of float
        w/γ₁.
    widths : tuple of float
        a/l by Eq. (16).
    path : tuple of float
        w/γ₁ of the loading paths.
    steps : int
        Depths of a path each way.
    nodes : tuple of int
        Numbers of nodes in l.
    node_ratio : float
        w/γ₁ on nodes.
    """

    ratios: tuple[float, ...] = (
        *(1e-4, 1e-3, 0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.95, 1.0, 1.2, 1.4, 1.6),
    )
    widths: tuple[float, ...] = (0.2, 1.1, 5.0)
    path: tuple[float, ...] = (0.01, 0.1, 0.5)
    steps: int = 24
    nodes: tuple[int, ...] = (6, 12, 25, 50, 100, 200)
    node_ratio: float = 0.5


LARGEST_RATIO = 2.0  # w/γ₁ at which Young's angle is 0; there is none beyond
CURVE_POINTS = 400  # of a law that is drawn: no corner is seen

FULL = Parameters()
# Fewer of each, over the same ranges.
QUICK = Parameters(
    ratios=(1e-4, 0.01, 0.1, 0.4, 1.2),
    widths=(0.3, 2.0),
    path=(0.1, 0.5),
    steps=6,
    nodes=(6, 12, 25, 50),
)


class Angle(NamedTuple):
    """One measured angle.

    Attributes
    ----------
    kind : {"finite", "small"}
        Slopes of the energy.
    shape : str
    ratio : float
        w/γ₁.
    depth, half_width : float
        Of the state.
    deficit : float
        π - θ as measured [rad].
    law : float
        π - θ by (8) for finite slopes, by (15) for small ones [rad].
    indenter, layer : float
        Inclinations of both at the line [rad].
    """

    kind: str
    shape: str
    ratio: float
    depth: float
    half_width: float
    deficit: float
    law: float
    indenter: float
    layer: float

    @property
    def residual(self) -> float:
        """|deficit/law - 1|."""
        return abs(self.deficit / self.law - 1)


class Loop(NamedTuple):
    """Angles along touch -> press -> retract until just before the contact detaches.

    Attributes
    ----------
    shape : str
    ratio : float
        w/γ₁.
    advance, retract : tuple of Angle
    """

    shape: str
    ratio: float
    advance: tuple[Angle, ...]
    retract: tuple[Angle, ...]

    @property
    def angles(self) -> tuple[Angle, ...]:
        """All of them, in this order."""
        return (*self.advance, *self.retract)


class OnNodes(NamedTuple):
    """Angles on nodes, where nothing but energies of contact sets is compared.

    Attributes
    ----------
    kind : {"finite", "small"}
        Slopes of the energy.
    shape : str
    counts : tuple of int
        Nodes in l.
    errors : tuple of float
        The largest |θ - law| over several depths, and so over several places of the line between
        its nodes [degrees].
    """

    kind: str
    shape: str
    counts: tuple[int, ...]
    errors: tuple[float, ...]

    @property
    def order(self) -> float:
        """p of error ~ spacing^p, by least squares."""
        return -float(np.polyfit(np.log(self.counts), np.log(self.errors), 1)[0])

    @property
    def passed(self) -> bool:
        """Whether the angle converges to its law with second order."""
        return ORDERS[0] <= self.order <= ORDERS[1]


@dataclass(frozen=True)
class Record:
    """All measured angles.

    Attributes
    ----------
    parameters : Parameters
    states, loops : tuple
        On the mesh, at free contact lines, twins in a mirror counted once.
    nodes : tuple of OnNodes
    edge : tuple of float
        π - θ over √(2w/γ₁) at the edge of a flat punch, where the line is pinned, over the depths
        from its detachment to as far below the surface.
    """

    parameters: Parameters
    states: tuple[Angle, ...]
    loops: tuple[Loop, ...]
    nodes: tuple[OnNodes, ...]
    edge: tuple[float, ...]

    def of(self, kind: str) -> list[Angle]:
        """The single states of a kind."""
        return [angle for angle in self.states if angle.kind == kind]

    def worst(self, kind: str) -> float:
        """Largest relative difference between measured π - θ and its law, loops included."""
        angles = self.of(kind)
        if kind == "finite":
            angles += [angle for loop in self.loops for angle in loop.angles]
        return max(angle.residual for angle in angles)

    @property
    def passed(self) -> bool:
        """Whether every law is obeyed on the mesh, and approached with second order on nodes."""
        on_mesh = max(self.worst("finite"), self.worst("small")) <= BAR
        return on_mesh and all(one.passed for one in self.nodes)

    @property
    def on_nodes(self) -> tuple[float, int]:
        """The largest error of θ [degrees] on the closest nodes, and how many of these are in l."""
        return max(one.errors[-1] for one in self.nodes), self.nodes[0].counts[-1]


def plot(record: Record) -> Figure:
    """Angles over w/γ₁ with both laws, and how far they are from these."""
    figure, (law, residuals) = canvas(12.5, 5, 1, 2)
    _draw_law(law, record)
    _draw_residuals(residuals, record)
    for axes in (law, residuals):
        axes.grid(alpha=0.25)
    worst = max(record.worst("finite"), record.worst("small"))
    verdict = "is a constant" if worst <= BAR else "is NOT the constant of theory"
    figure.suptitle(
        f"On the mesh the contact angle of a free line {verdict}: relative error of π − θ at most "
        f"{worst:.0e}"
    )
    return figure


def plot_nodes(record: Record) -> Figure:
    """The error of θ over the number of nodes in l."""
    figure, axes = canvas(7.5, 5)
    shapes = list(dict.fromkeys(one.shape for one in record.nodes))
    for one in record.nodes:
        i = shapes.index(one.shape)
        small = one.kind == "small"
        label = f"{one.shape}, {'small slopes (15)' if small else 'true lengths (8)'}"
        look: dict[str, Any] = {"color": COLOURS[i], "marker": MARKERS[i], "ms": 7}
        style = {"ls": "--", "mfc": "white"} if small else {"ls": "-"}
        axes.loglog(one.counts, one.errors, label=label, **look, **style)
    counts = np.array(record.nodes[0].counts, float)
    top = 2.5 * max(one.errors[0] for one in record.nodes)
    axes.loglog(counts, top * (counts[0] / counts) ** 2, ls=":", label="second order", **LINE)
    axes.set(xlabel="nodes in the elastocapillary length l", ylabel="|θ − its law| in degrees")
    plain_ticks(axes.xaxis)
    axes.legend(fontsize=9, ncols=2, loc="lower left")
    axes.set_ylim(bottom=min(min(one.errors) for one in record.nodes) / 60)
    axes.grid(alpha=0.25)
    axes.set_title(
        f"Energies of contact sets alone give the angle: w/γ₁ = {record.parameters.node_ratio:g}"
    )
    return figure


def _draw_law(axes: Any, record: Record) -> None:
    """θ over w/γ₁: curves of both laws, and a mark for each single state of the record."""
    ratios = _ratios(record)
    by_young = np.degrees(np.arccos(ratios - 1))
    by_small_slopes = 180 - np.degrees(np.sqrt(2 * ratios))
    axes.semilogx(ratios, by_young, label="Young's law (8)", **LINE)
    axes.semilogx(ratios, by_small_slopes, ls=":", label="small slopes (15)", **LINE)
    labels = {"finite": "true lengths, simulated", "small": "small slopes, simulated"}
    for kind, marker, colour in zip(labels, MARKERS, COLOURS, strict=False):
        angles = record.of(kind)
        simulated_ratios = [angle.ratio for angle in angles]
        simulated = [180 - math.degrees(angle.deficit) for angle in angles]
        style: dict[str, Any] = {"ls": "", "marker": marker, "color": colour, "mfc": "none"}
        axes.plot(simulated_ratios, simulated, label=labels[kind], ms=6, **style)
    axes.set(xlabel="w/γ₁", ylabel="contact angle θ in degrees")
    axes.set_title("one angle for each w/γ₁, whatever the indenter and the depth")
    axes.legend()


def _draw_residuals(axes: Any, record: Record) -> None:
    """Relative differences of π - θ to the laws over w/γ₁, and of one law to the other."""
    ratios = _ratios(record)
    by_young = 2 * np.arcsin(np.sqrt(ratios / 2))  # π - θ by (8), without cancellation
    of_laws = 1 - np.sqrt(2 * ratios) / by_young
    axes.loglog(ratios, of_laws, ls=":", label="(15) against (8)", **LINE)
    parts = [
        ("true lengths against (8)", record.of("finite")),
        ("small slopes against (15)", record.of("small")),
        ("true lengths, loading paths", [a for loop in record.loops for a in loop.angles]),
    ]
    for i, (label, angles) in enumerate(parts):
        residuals = [max(angle.residual, LEAST_DRAWN) for angle in angles]
        style: dict[str, Any] = {"ls": "", "marker": MARKERS[i], "color": COLOURS[i], "ms": 4}
        axes.plot([angle.ratio for angle in angles], residuals, label=label, **style)
    axes.set_title(f"difference to the laws (less than {LEAST_DRAWN:g} is drawn there)")
    axes.set(xlabel="w/γ₁", ylabel="relative difference of π − θ", ylim=(LEAST_DRAWN / 3, 1e4))
    axes.legend(fontsize=9, ncols=2, loc="upper left")


def _ratios(record: Record) -> Array:
    """w/γ₁ at which laws are drawn, from the least simulated one to the largest with an angle."""
    return np.geomspace(min(record.parameters.ratios), LARGEST_RATIO, CURVE_POINTS)


def plot_path(record: Record) -> Figure:
    """Inclinations of indenter and free surface, and their sum, along a loading path."""
    chosen = min(record.loops, key=lambda one: (one.ratio, one.shape != "parabola"))
    figure, axes = canvas(7.5, 5)
    kinds = {"deficit": "π − θ, their sum", "indenter": "inclination of the indenter"}
    kinds["layer"] = "inclination of the free surface"
    for colour, marker, (kind, name) in zip(COLOURS, MARKERS, kinds.items(), strict=False):
        style: dict[str, Any] = {"ls": "", "color": colour, "marker": marker}
        for label, angles, look in (
            (name, chosen.advance, {"mfc": "none", "ms": 8}),
            (f"{name}, retracting", chosen.retract, {"ms": 4}),
        ):
            values = [math.degrees(getattr(angle, kind)) for angle in angles]
            axes.plot([_scaled(angle) for angle in angles], values, label=label, **style, **look)
    axes.axhline(math.degrees(chosen.angles[0].law), label="Young's law (8)", **LINE)
    axes.set(xlabel="depth d/δ₀", ylabel="angle in degrees")
    axes.set_title(f"On a loading path ({chosen.shape}, w/γ₁ = {chosen.ratio:g}) only π − θ stays")
    low, high = axes.get_ylim()
    axes.set_ylim(low, high + 0.35 * (high - low))  # for the legend
    axes.legend(loc="upper center", ncols=2, fontsize=9)
    axes.grid(alpha=0.25)
    return figure


def _scaled(angle: Angle) -> float:
    """d/δ₀, where angles are measured with l = 1."""
    return angle.depth / math.sqrt(2 * angle.ratio)
