"""The figure of the regimes: for which h against l, and w against γ₁, which energy is made.

Borders are the limits of energy.validity, with l = √(γ₁/k), δ₀ = √(2w/k) and "≪" as a tenth:

    the layer may be lifted by a tenth of its thickness    δ₀/h = 1/10,  w/γ₁ = (h/l)²/200
    small slopes                                           2w/γ₁ = 1/10
    springs                                                |c₂|(h/l)² = 1/10 and h <= l

Scene files of studies/scenes/ are drawn where they lie.
"""

import math
from pathlib import Path
from typing import Any

import numpy as np

from energy import Scene
from energy.layer import second_order
from energy.validity import MUCH_LESS
from studies import scenes
from studies.scenes.file import load
from studies.shared.figures import COLOURS, GREY, MARKERS, ORANGE, SKY, Figure, canvas

THIN, STICKY = (0.02, 200.0), (1e-6, 3.0)  # h/l and w/γ₁ that are drawn
RATIOS = {0.3: "-", 0.45: "--", 0.49: ":"}  # Poisson's ratios and their lines


def thickest(nu: float) -> float:
    """h/l up to which springs stand for the layer."""
    return min(1.0, math.sqrt(MUCH_LESS / abs(second_order(nu))))


def place(scene: Scene) -> tuple[float, float]:
    """h/l and w/γ₁."""
    thickness = scene.layer.h / scene.elastocapillary_length
    return thickness, scene.work_of_adhesion / scene.gamma1


def draw_regimes() -> Figure:
    """The plane of h/l and w/γ₁, the borders in it, and the example scenes."""
    figure, axes = canvas(8.5, 6)
    x = np.union1d(np.geomspace(*THIN, 200), 1.0)
    strained, steep = MUCH_LESS**2 / 2 * x**2, MUCH_LESS / 2
    axes.fill_between(x, strained, STICKY[1], color=GREY, alpha=0.35, lw=0)
    for part, colour in ((x <= 1, SKY), (x >= 1, ORANGE)):
        axes.fill_between(x[part], STICKY[0], strained[part], color=colour, alpha=0.35, lw=0)
    for nu, style in RATIOS.items():
        at, name = thickest(nu), f"springs up to here for ν = {nu:g}"
        ends = STICKY[0], MUCH_LESS**2 / 2 * at**2
        axes.plot([at, at], ends, style, color="black", label=name)
    axes.axhline(steep, color=ORANGE, ls="-.", label="small slopes up to here")
    examples = sorted(Path(scenes.__path__[0]).glob("*.toml"))
    for path, colour, marker in zip(examples, COLOURS, MARKERS, strict=False):
        look = {"color": colour, "marker": marker, "ms": 8, "mec": "white", "ls": ""}
        axes.plot(*place(load(path).scene), **look, label=path.stem.replace("_", " "))
    words: dict[str, Any] = {"ha": "center", "va": "center", "fontsize": 11}
    axes.text(0.12, 0.004, "the layer is strained\nby more than a tenth", **words)
    axes.text(0.46, 4e-6, "springs", **words)
    axes.text(15, 1e-4, "the layer itself:\nresponse = 'layer'", **words)
    axes.text(28, 0.14, "steep: slopes = 'finite',\nfor springs", **words)
    axes.set(xscale="log", yscale="log", xlim=THIN, ylim=STICKY)
    axes.set(xlabel="thickness over elastocapillary length, h/l")
    axes.set(ylabel="work of adhesion over surface tension, w/γ₁")
    figure.legend(loc="outside lower center", ncols=2, fontsize=10)
    figure.suptitle("For whom the model is: little adhesion, and a layer that tension can bend")
    return figure
