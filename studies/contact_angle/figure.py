"""The figure of `contact_angle`: measured angles with both laws, and along loading paths."""

from __future__ import annotations

import math
from typing import Any

import numpy as np

from studies.contact_angle.record import Record
from studies.shared.figures import COLOURS, LINE, MARKERS, Figure, canvas


def plot(record: Record) -> Figure:
    """Angles with both laws and residuals; angles along loading paths and their residuals."""
    figure, panels = canvas(13, 8, 2, 2, height_ratios=(1.5, 1))
    _draw_law(panels[0, 0], record)
    _draw_residuals(panels[1, 0], record)
    _draw_loops(panels[:, 1], record)
    for axes in panels.flat:
        axes.grid(alpha=0.25)
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
    axes.set_title("Contact angle, all indenters and depths")
    axes.legend()


def _draw_residuals(axes: Any, record: Record) -> None:
    x = np.geomspace(min(record.parameters.ratios), 2, 400)
    gap = 1 - np.sqrt(2 * x) / (2 * np.arcsin(np.sqrt(x / 2)))
    axes.loglog(x, gap, ls=":", label="(15) against (8)", **LINE)
    parts = [
        ("true lengths - (8)", record.of("finite")),
        ("small slopes - (15)", record.of("small")),
    ]
    for h in list(record.lattice_errors())[::3]:
        parts.append(
            (f"lattice Δx = {h:g} l - (15)", [x for x in record.lattice if x.spacing == h])
        )
    for i, (label, angles) in enumerate(parts):
        residuals = [max(angle.residual, 1e-17) for angle in angles]
        style: dict[str, Any] = {"ls": "", "marker": MARKERS[i], "color": COLOURS[i], "ms": 4}
        axes.plot([angle.ratio for angle in angles], residuals, label=label, **style)
    axes.set_title("Against the laws; below 1e-17: drawn there")
    axes.set(xlabel="w/γ₁", ylabel="relative difference of π - θ", ylim=(3e-18, 1e3))
    axes.legend(fontsize=8, ncols=2, loc="upper left")


def _draw_loops(panels: Any, record: Record) -> None:
    top, bottom = panels
    chosen = max(record.loops, key=lambda one: (one.ratio, one.shape == "parabola"))
    for i, (way, marker) in enumerate(((chosen.advance, "o"), (chosen.retract, "x"))):
        depths = [angle.depth for angle in way]
        colour: dict[str, Any] = {"ls": "", "marker": marker}
        kinds = ("deficit", "indenter", "layer")
        labels = ("π - θ", "inclination of the indenter", "inclination of the surface")
        for j, (kind, label) in enumerate(zip(kinds, labels, strict=True)):
            values = [math.degrees(getattr(a, kind)) for a in way]
            text = label if i == 0 else None
            top.plot(depths, values, color=COLOURS[j], label=text, mfc="none", **colour)
    top.axhline(math.degrees(chosen.angles[0].law), label="Young's law (8)", **LINE)
    top.set(
        ylabel="angle in degrees",
        title=f"Along a loading path: {chosen.shape}, w/γ₁ = {chosen.ratio:g}",
    )
    top.plot([], [], "ko", mfc="none", label="advance")
    top.plot([], [], "kx", label="retract")
    top.legend(loc="lower center", ncols=2, fontsize=8)
    for i, one in enumerate(record.loops):
        depths = [a.depth / max(b.depth for b in one.angles) * 2 for a in one.angles]
        residuals = [max(a.residual, 1e-17) for a in one.angles]
        label = f"{one.shape}, w/γ₁ = {one.ratio:g}"
        marks: dict[str, Any] = {"color": COLOURS[i % 8], "marker": MARKERS[i % 8], "ms": 4}
        bottom.semilogy(depths, residuals, ls="", label=label, **marks)
    bottom.set(xlabel="depth d/δ₀", ylabel="relative difference to (8)", ylim=(3e-18, 1e-6))
    bottom.legend(fontsize=8, ncols=2)
    top.set_xlabel("depth d/l")
