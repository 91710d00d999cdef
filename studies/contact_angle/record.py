"""What `contact_angle` measures: its parameters, the record, and the figure drawn of it."""

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from studies.shared.figures import COLOURS, LINE, MARKERS, Figure, canvas

BAR = 1e-8  # of π - θ


@dataclass(frozen=True)
class Parameters:
    """ratios: w/γ₁; widths: a/l by Eq. (16); path: w/γ₁ of the loading paths, with `steps` depths
    each way."""

    ratios: tuple[float, ...] = (
        *(1e-4, 1e-3, 0.01, 0.03, 0.1, 0.25, 0.5, 0.75, 0.95, 1.0, 1.2, 1.4, 1.6),
    )
    widths: tuple[float, ...] = (0.2, 1.1, 5.0)
    path: tuple[float, ...] = (0.01, 0.1, 0.5)
    steps: int = 24


FULL = Parameters()
QUICK = Parameters(
    ratios=(1e-4, 0.01, 0.1, 0.4, 1.2),
    widths=(0.3, 2.0),
    path=(0.1, 0.5),
    steps=6,
)


class Angle(NamedTuple):
    """One measured angle: kind is "finite" or "small", that of the slopes.

    deficit: π - θ; law: by (8) for "finite", (15) else; half_width: simulated a; indenter, layer:
    inclinations of both at the line [rad].
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
    """Angles along touch -> press -> retract until just before the contact detaches."""

    shape: str
    ratio: float
    advance: tuple[Angle, ...]
    retract: tuple[Angle, ...]

    @property
    def angles(self) -> tuple[Angle, ...]:
        """The whole way."""
        return (*self.advance, *self.retract)


@dataclass(frozen=True)
class Record:
    """All measured angles."""

    parameters: Parameters
    states: tuple[Angle, ...]
    loops: tuple[Loop, ...]

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
        """Whether every law is obeyed."""
        return max(self.worst("finite"), self.worst("small")) <= BAR


def plot(record: Record) -> Figure:
    """Angles with both laws and residuals; angles along loading paths and their residuals."""
    figure, panels = canvas(12.5, 8, 2, 2, height_ratios=(1.5, 1))
    _draw_law(panels[0, 0], record)
    _draw_residuals(panels[1, 0], record)
    _draw_loops(panels[:, 1], record)
    for axes in panels.flat:
        axes.grid(alpha=0.25)
    worst = max(record.worst("finite"), record.worst("small"))
    law = "is a constant" if record.passed else "is NOT the constant of theory"
    told = f"its laws hold within {worst:.0e} for every indenter, depth and direction"
    figure.suptitle(f"The contact angle {law}: {told}")
    return figure


def _draw_law(axes: Any, record: Record) -> None:
    x = np.geomspace(min(record.parameters.ratios), 2, 400)
    axes.semilogx(x, np.degrees(np.arccos(x - 1)), label="Young's law (8)", **LINE)
    axes.semilogx(x, 180 - np.degrees(np.sqrt(2 * x)), ls=":", **LINE, label="small slopes (15)")
    groups = [("finite", "true lengths, simulated"), ("small", "small slopes, simulated")]
    for i, (kind, label) in enumerate(groups):
        angles = record.of(kind)
        theta = [180 - math.degrees(angle.deficit) for angle in angles]
        style: dict[str, Any] = {"ls": "", "marker": MARKERS[i], "color": COLOURS[i]}
        axes.plot([a.ratio for a in angles], theta, label=label, ms=6, mfc="none", **style)
    axes.set(xlabel="w/γ₁", ylabel="contact angle θ in degrees")
    axes.set_title("one angle for each w/γ₁, whatever the indenter and the depth")
    axes.legend()


def _draw_residuals(axes: Any, record: Record) -> None:
    x = np.geomspace(min(record.parameters.ratios), 2, 400)
    gap = 1 - np.sqrt(2 * x) / (2 * np.arcsin(np.sqrt(x / 2)))
    axes.loglog(x, gap, ls=":", label="(15) against (8)", **LINE)
    parts = [
        ("true lengths - (8)", record.of("finite")),
        ("small slopes - (15)", record.of("small")),
    ]
    for i, (label, angles) in enumerate(parts):
        residuals = [max(angle.residual, 1e-17) for angle in angles]
        style: dict[str, Any] = {"ls": "", "marker": MARKERS[i], "color": COLOURS[i], "ms": 4}
        axes.plot([angle.ratio for angle in angles], residuals, label=label, **style)
    axes.set_title("difference to the laws (below 1e-17: drawn there)")
    axes.set(xlabel="w/γ₁", ylabel="relative difference of π - θ", ylim=(3e-18, 1e3))
    axes.legend(fontsize=9, ncols=2, loc="upper left")


def _draw_loops(panels: Any, record: Record) -> None:
    """One loading path in full above, the differences to Young's law on all of them below."""
    top, bottom = panels
    chosen = max(record.loops, key=lambda one: (one.ratio, one.shape == "parabola"))
    kinds = {"deficit": "π - θ", "indenter": "indenter's inclination"}
    kinds["layer"] = "surface's inclination"
    for colour, marker, (kind, name) in zip(COLOURS, MARKERS, kinds.items(), strict=False):
        style: dict[str, Any] = {"ls": "", "color": colour, "marker": marker}
        for label, angles, look in (
            (name, chosen.advance, {"mfc": "none", "ms": 8}),
            (f"{name}, retracting", chosen.retract, {"ms": 4}),
        ):
            values = [math.degrees(getattr(angle, kind)) for angle in angles]
            top.plot([_scaled(angle) for angle in angles], values, label=label, **style, **look)
    top.axhline(math.degrees(chosen.angles[0].law), label="Young's law (8)", **LINE)
    top.set(xlabel="depth d/δ₀", ylabel="angle in degrees")
    top.set_title(f"on a loading path ({chosen.shape}, w/γ₁ = {chosen.ratio:g}) only π - θ stays")
    top.set_ylim(top=1.45 * math.degrees(chosen.angles[0].law))
    top.legend(loc="upper center", ncols=2, fontsize=9)
    for i, one in enumerate(record.loops):
        residuals = [max(angle.residual, 1e-17) for angle in one.angles]
        label = f"{one.shape}, w/γ₁ = {one.ratio:g}"
        marks: dict[str, Any] = {"color": COLOURS[i % 8], "marker": MARKERS[i % 8], "ms": 4}
        bottom.semilogy([_scaled(a) for a in one.angles], residuals, ls="", label=label, **marks)
    bottom.set(xlabel="depth d/δ₀", ylabel="relative difference to (8)", ylim=(3e-18, 1e-6))
    bottom.set_title("difference to Young's law on all loading paths")
    bottom.legend(fontsize=9, ncols=2)


def _scaled(angle: Angle) -> float:
    """d/δ₀, where angles are measured with l = 1."""
    return angle.depth / math.sqrt(2 * angle.ratio)
