"""The figures of `applicability`: maps of the error of Eq. (16), γ₁ alone varied, and regimes.

The regimes are: for which h against l, and w against γ₁, which energy is made.
Borders are the limits of energy.validity, with l = √(γ₁/k), δ₀ = √(2w/k) and "≪" as a tenth:

    the layer may be lifted by a tenth of its thickness    δ₀/h = 1/10,  w/γ₁ = (h/l)²/200
    small slopes                                           2w/γ₁ = 1/10
    springs                                                |c₂|(h/l)² = 1/10 and h <= l

Scene files of studies/scenes/ are drawn where they lie.

Conventions:

- `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
- `plain_ticks` labels a logarithmic axis with plain numbers.
- A scene has `gamma1` γ₁, `work_of_adhesion` w and `elastocapillary_length` l = √(γ₁/k).
"""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from energy import Scene
from energy.arrays import Array
from energy.layer import second_order
from energy.validity import MUCH_LESS
from studies import scenes
from studies.applicability.record import NODES, TOLERANCES, Point, Record
from studies.scenes.file import load
from studies.shared.figures import (
    COLOURS,
    GREY,
    MARKERS,
    ORANGE,
    SKY,
    Figure,
    canvas,
    plain_ticks,
    shades,
)

# Ranges of the map of regimes, around h = l and w = 2γ₁ where the model ends.
THIN = (0.02, 200.0)  # h/l
STICKY = (1e-6, 3.0)  # w/γ₁
RATIOS = {0.3: "-", 0.45: "--", 0.49: ":"}  # Poisson's ratios and their lines
FLOOR = 1e-4  # the darkest colour of the map
LEAST_DRAWN = 1e-16  # relative error; some are 0, which a logarithm has no place for
GONE: dict[str, Any] = {"facecolor": "white", "edgecolor": "#aaaaaa", "hatch": "///"}
LINES = (("a", "white", "-"), ("P", "black", "--"))


def grid(points: Sequence[Point], across: str) -> tuple[Array, Array, Array, Array]:
    """w/γ₁, the other coordinate, and |errors| of a and P as (other, w/γ₁) tables."""
    ratios = np.unique([point.ratio for point in points])
    other = np.unique([getattr(point, across) for point in points])
    tables = [
        np.reshape([abs(getattr(x.errors, name)) for x in points], (other.size, ratios.size))
        for name in ("half_width", "force")
    ]
    return ratios, other, tables[0], tables[1]


def worst_on_path(points: Sequence[Point], name: str) -> tuple[Array, Array]:
    """Steepness, and the largest |error| over all γ₁ at which the surface does not turn over."""
    steepness = np.unique([point.steepness for point in points])
    errors = [
        max(abs(getattr(x.errors, name)) for x in points if x.steepness == s and x.errors.exists)
        for s in steepness
    ]
    return steepness, np.array(errors)


def draw_maps(record: Record) -> Figure:
    """The larger of the errors of a and P in colour, lines of 1 % and 10 %; hatched: no state."""
    figure, panels = canvas(12.5, 5.2, 1, 3)
    for axes, (shape, points) in zip(panels, record.maps.items(), strict=True):
        across = "steepness" if shape in record.paths else "width"
        x, y, width, force = grid(points, across)
        worst = np.log10(np.maximum(np.maximum(width, force), FLOOR))
        levels = np.linspace(math.log10(FLOOR), 0, 17)
        colours = axes.contourf(x, y, worst, levels, cmap="cividis", extend="min")
        for table, (_, colour, style) in zip((width, force), LINES, strict=True):
            look = {"colors": colour, "linestyles": style, "linewidths": (1.0, 2.5)}
            if np.nanmax(table) > min(TOLERANCES):
                axes.contour(x, y, np.log10(table), np.log10(TOLERANCES), **look)
        axes.patch.set(**GONE)
        axes.set(xscale="log", yscale="log", xlim=(x[0], 2), ylim=(y[0], y[-1]), xlabel="w/γ₁")
        axes.set_title(shape + (" at a = l" if across == "steepness" else " about to detach"))
        axes.set_ylabel("steepness f'(a)" if across == "steepness" else "half-width a/l")
    for what, colour, style in LINES:
        for tolerance, size in zip(TOLERANCES, (1.0, 2.5), strict=True):
            label = f"{tolerance:.0%} error of {what}"
            panels[0].plot([], [], style, color=colour, lw=size, label=label)
    panels[0].fill_between([], [], label="turns over: no state", **GONE)
    figure.legend(loc="outside lower center", ncols=5, facecolor="#999999")
    bar = figure.colorbar(colours, ax=panels, label="larger relative error of a and P")
    bar.set_ticks([-4, -3, -2, -1, 0], labels=["$10^{-4}$", "$10^{-3}$", "1 %", "10 %", "100 %"])
    figure.suptitle("Eq. (16) against true surface lengths: good for blunt indenters and w ≪ γ₁")
    return figure


def draw_conjecture(record: Record) -> Figure:
    """Errors against γ₁/w for each steepness; the largest of them against the steepness."""
    figure, (*panels, last) = canvas(12.5, 4.8, 1, 3, sharey=True)
    for k, (axes, (shape, points)) in enumerate(zip(panels, record.paths.items(), strict=True)):
        steepness = sorted({point.steepness for point in points}, reverse=True)
        for s, colour in zip(steepness, shades(len(steepness), top=0.7), strict=True):
            row = [x for x in points if x.steepness == s and x.errors.exists]
            tensions = [1 / x.ratio for x in row]
            for name, style in (("half_width", "-"), ("force", "--")):
                errors = [abs(getattr(x.errors, name)) for x in row]
                label = f"f'(a₀) = {s:g}" if style == "-" else None
                look = {"color": colour, "marker": MARKERS[steepness.index(s) % 8], "ms": 4}
                axes.loglog(tensions, errors, style, label=label, **look)
        axes.set(title=f"{shape}, only γ₁ varies, d = 0", xlabel="γ₁/w")
        plain_ticks(axes.xaxis, steps=(1.0,) if max(tensions) > 100 else (1.0, 3.0))
        axes.legend(fontsize=9, title="a solid, P dashed")
        for j, (name, style) in enumerate((("half_width", "-"), ("force", "--"))):
            label = f"{shape}, {'a' if j == 0 else 'P'}"
            marks = {"color": COLOURS[k], "marker": MARKERS[k], "label": label}
            last.loglog(*worst_on_path(points, name), style, **marks)
    for tolerance in (0.01, 0.1):
        last.axhline(tolerance, color="black", lw=0.8, ls=":")
    panels[0].set_ylabel("relative error of Eq. (16)")
    last.set(title="largest over all γ₁", xlabel="steepness f'(a₀)")
    plain_ticks(last.xaxis)
    last.legend()
    for axes in (*panels, last):
        axes.grid(alpha=0.25)
    figure.suptitle(
        "The conjecture that Eq. (16) serves for any γ₁ (Section 6) is right where the indenter is "
        "blunt: f'(a₀) ≪ 1"
    )
    return figure


def draw_question(record: Record, shape: str = "parabola") -> Figure:
    """Error of a by (16) over γ₁/w: small slopes on nodes and on the mesh, and true lengths."""
    figure, axes = canvas(7.5, 5)
    points = record.paths[shape]
    steepness = sorted({point.steepness for point in points})
    chosen = [steepness[i] for i in sorted({0, len(steepness) // 2, -1 % len(steepness)})]
    shown = shades(len(chosen), top=0.7)[::-1]
    for s, colour, marker in zip(chosen, shown, MARKERS, strict=False):
        row = [x for x in points if x.steepness == s and x.errors.exists]
        errors = [abs(x.errors.half_width) for x in row]
        look = {"color": colour, "marker": marker, "ms": 5}
        label = f"true lengths, f'(a₀) = {s:g}"
        axes.loglog([1 / x.ratio for x in row], errors, label=label, **look)
    small = [one for one in record.small if one.shape == shape and one.tension]
    tensions = sorted({one.tension for one in small})
    for name, label, style in (
        ("nodes", f"small slopes, energies on {NODES} nodes", "^"),
        ("mesh", "small slopes, ∂U/∂x = 0 on the mesh", "v"),
    ):
        worst = [max(getattr(x, name) for x in small if x.tension == t) for t in tensions]
        drawn = np.maximum(worst, LEAST_DRAWN)
        axes.loglog(tensions, drawn, style, color="black", mfc="none", ms=5, label=label)
    axes.axvline(2.0, color=GREY, ls=":", lw=1.2)
    axes.annotate("2w = γ₁", (2.0, 1e-9), (2.6, 1e-9), color="#555555", va="center")
    axes.set(xlabel="surface tension over work of adhesion, γ₁/w", ylim=(LEAST_DRAWN / 4, 30))
    axes.set(ylabel="relative error of the half-width by Eq. (16)")
    axes.set_title(f"Eq. (16) for any γ₁: {shape}, d = 0 and w fixed")
    axes.legend(fontsize=9, ncols=2, loc="upper right")
    axes.grid(alpha=0.25)
    return figure


def thickest(nu: float) -> float:
    """h/l up to which springs stand for the layer."""
    return min(1.0, math.sqrt(MUCH_LESS / abs(second_order(nu))))


def place(scene: Scene) -> tuple[float, float]:
    """h/l and w/γ₁."""
    thickness = scene.layer.h / scene.elastocapillary_length
    return thickness, scene.work_of_adhesion / scene.gamma1


def draw_regimes() -> Figure:
    """The plane of h/l and w/γ₁, the borders of validity in it, and the example scenes.

    True lengths are needed above the line of small slopes, where springs always lift the layer by
    more than a tenth: that region is not valid for any film, and not drawn as one.
    """
    figure, axes = canvas(8.5, 6)
    x = np.union1d(np.geomspace(*THIN, 200), 1.0)
    strained = MUCH_LESS**2 / 2 * x**2
    steep = MUCH_LESS / 2
    top = np.minimum(strained, steep)
    for part, colour in ((x <= 1, SKY), (x >= 1, ORANGE)):
        axes.fill_between(x[part], STICKY[0], top[part], color=colour, alpha=0.35, lw=0)
    for nu, style in RATIOS.items():
        at = thickest(nu)
        name = f"springs: h/l at most this for ν = {nu:g}"
        ends = STICKY[0], MUCH_LESS**2 / 2 * at**2
        axes.plot([at, at], ends, style, color="black", label=name)
    examples = sorted(Path(scenes.__path__[0]).glob("*.toml"))
    for path, colour, marker in zip(examples, COLOURS, MARKERS, strict=False):
        scene = load(path).scene
        look = {"color": colour, "marker": marker, "ms": 8, "mec": "white", "ls": ""}
        name = f"{path.stem.replace('_', ' ')}, ν = {scene.layer.nu:g}"
        axes.plot(*place(scene), **look, label=name)
    words: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 11}
    lifted = "outside: adhesion lifts the layer\nby more than h/10 (w > Ẽh/200)"
    axes.text(0.2, 0.006, lifted, **words)
    axes.text(2.0, 0.35, "outside: slopes are not small (2w > γ₁/10)", **words)
    axes.text(0.47, 3e-6, "springs", **words)
    axes.text(15, 1e-4, "exact layer:\nresponse = 'layer'", **words)
    axes.set(xscale="log", yscale="log", xlim=THIN, ylim=STICKY)
    axes.set(xlabel="thickness over elastocapillary length, h/l")
    axes.set(ylabel="work of adhesion over surface tension, w/γ₁")
    figure.legend(loc="outside lower center", ncols=2, fontsize=10)
    figure.suptitle("Range of validity: little adhesion, and a layer no thicker than l for springs")
    return figure
