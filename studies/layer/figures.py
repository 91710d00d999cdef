"""The four figures of the study of the layer, each with its answer above it."""

from collections.abc import Sequence
from typing import Any

from energy import ElasticLayer
from energy.layer import effective_length
from studies.layer.cases import Angle, Length, Pull, Springs
from studies.shared.figures import COLOURS, GREY, MARKERS, Figure, canvas, plain_ticks

LEVELS = (
    (3.03, 0.022, "3: thin, incompressible"),
    (2.03, 0.022, "2: thin, compressible (springs)"),
    (1.53, 14.0, "3/2: half-space (JKR)"),
    (0.91, 14.0, "1: tension rules"),
)


def _draw(axes: Any, rows: Sequence[Any], x: str, y: str, label: str, **more: Any) -> None:
    """y over x of each ν, with its error if there is any."""
    for nu in sorted({row.nu for row in rows}):
        own, i = [row for row in rows if row.nu == nu], len(axes.containers)
        error = [row.error for row in own] if hasattr(own[0], "error") else None
        values = ([getattr(row, name) for row in own] for name in (x, y))
        look = {"color": COLOURS[i], "marker": MARKERS[i], "ms": 5, "capsize": 3, **more}
        axes.errorbar(*values, error, label=f"{label}ν = {nu:g}", **look)
    axes.legend(fontsize=9)


def angles(rows: Sequence[Angle], worst: float) -> Figure:
    """The measured angle over the thickness of the layer."""
    figure, axes = canvas(7.5, 4.8)
    axes.axhline(1, color="black", lw=1.2, label="√(2w/γ₁)")
    _draw(axes, rows, "thickness", "measured", "nodes, ", ls="", mfc="none")
    axes.set(xscale="log", xlabel="thickness of the layer  h / √(γ₁h/G)", ylim=(0.975, 1.025))
    axes.set_ylabel("measured angle  (π - θ) / √(2w/γ₁)")
    plain_ticks(axes.xaxis, steps=(1.0, 2.0, 3.0, 5.0))
    axes.set_title(f"The contact angle is a constant on any layer (within {100 * worst:.1f} %)")
    return figure


def lengths(rows: Sequence[Length], worst: float) -> Figure:
    """The length in Eq. (16) over l."""
    figure, axes = canvas(7.5, 4.8)
    most = max(row.ratio for row in rows)
    dense = [most * i / 60 for i in range(1, 61)]
    axes.plot([0, most], [0, most], color=GREY, ls="--", label="l, as on springs")
    for nu, colour in zip(sorted({row.nu for row in rows}), COLOURS, strict=False):
        layer = ElasticLayer(1.0, nu, 1.0, response="layer")
        ell = [effective_length(layer, layer.stiffness * ratio**2) for ratio in dense]
        axes.plot(dense, ell, color=colour, lw=1.2)
    _draw(axes, rows, "ratio", "measured", "measured, and ℓ as a line, ", ls="")
    axes.set(xlabel="elastocapillary length  l / h", ylabel="length in Eq. (16), over h")
    axes.set_title(f"Eq. (16) holds for a real layer, with ℓ in place of l (within {worst:.0e} h)")
    return figure


def pulls(rows: Sequence[Pull]) -> Figure:
    """The force that pulls a sphere off, over its radius of contact."""
    figure, axes = canvas(8.5, 5.2)
    for height, at, text in LEVELS:
        axes.axhline(round(2 * height) / 2, color=GREY, lw=0.8, ls=":")
        axes.text(at, height, text, fontsize=9)
    for tension, style in (("weak", "-"), ("strong", "--")):
        own = [row for row in rows if row.tension == tension]
        _draw(axes, own, "radius", "force", f"{tension} tension, ", ls=style)
    axes.set(xscale="log", xlim=(0.02, 150), ylim=(0.8, 3.25))
    axes.set(xlabel="radius of contact at pull-off  a / h", ylabel="pull-off force  F / πwR")
    plain_ticks(axes.xaxis)
    axes.legend(fontsize=9, loc="upper left", bbox_to_anchor=(0.0, 0.9))
    axes.set_title("A sphere sticks with 3/2 to 3 πwR, most to thin rubber; πwR if tension rules")
    return figure


def springs(rows: Sequence[Springs], told: str) -> Figure:
    """Errors of springs at pull-off, at the worst Λ, over l/h."""
    figure, panels = canvas(10.5, 4.8, 1, 2, sharey=True)
    for axes, name in zip(panels, ("force", "radius"), strict=True):
        _draw(axes, rows, "ratio", name, "")
        axes.axhline(0.05, color=GREY, lw=0.8, ls=":")
        axes.set(xscale="log", yscale="log", ylim=(1e-4, 1.0))
        axes.set(xlabel="elastocapillary length  l / h", title=f"{name} at pull-off of a sphere")
        plain_ticks(axes.xaxis)
    panels[0].set_ylabel("relative error of springs at the worst Λ")
    figure.suptitle(f"Springs serve within 5 % where l/h is at least {told}")
    return figure
