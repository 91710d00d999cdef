"""The figure of `contact_angle`: measured angles with both laws, and along loading paths."""

import math
from typing import Any

import numpy as np

from studies.contact_angle.record import Angle, Record
from studies.shared.figures import COLOURS, LINE, MARKERS, Figure, canvas


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
