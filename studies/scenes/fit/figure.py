"""The figure of `fit`: measured and fitted force with residuals."""

from __future__ import annotations

from energy.units import prefixed
from studies.scenes.fit.estimate import Fit
from studies.scenes.fit.force_curve import loading
from studies.shared.figures import BLUE, GREY, ORANGE, Figure, canvas


def plot(found: Fit, title: str) -> Figure:
    """P(d) above, residuals with ± 2s below, both branches."""
    figure, (top, bottom) = canvas(9, 7.5, 2, 1, sharex=True, height_ratios=(2, 1))
    depth, force = found.curve
    unit = f"N{found.model.scene.per_length}"
    x, y = prefixed(depth, "m"), prefixed(force, unit)
    z = prefixed(force[found.used] - found.fitted, unit)
    free = ~found.used
    top.plot(depth[free] / x.size, force[free] / y.size, "x", color=GREY, label="out of contact")
    grows = loading(depth)[found.used]
    d, p = depth[found.used], force[found.used]
    for number, piece in enumerate(found.model.pieces):
        style = {"color": "black", "lw": 1.2, "zorder": 3, "label": "_" if number else "fit"}
        top.plot(d[piece] / x.size, found.fitted[piece] / y.size, **style)
    for chosen, colour, marker, name in (
        (grows, BLUE, "o", "loading"),
        (~grows, ORANGE, "s", "unloading"),
    ):
        style = {"ls": "", "color": colour, "marker": marker, "ms": 4, "label": name}
        top.plot(d[chosen] / x.size, p[chosen] / y.size, **style)
        residual = (p - found.fitted)[chosen] / z.size
        bottom.plot(d[chosen] / x.size, residual, **style)
    s = 2 * found.residual_noise / z.size
    bottom.axhspan(-s, s, color=GREY, alpha=0.25, lw=0, label="± 2 s")
    for axes in (top, bottom):
        axes.axhline(0, color=GREY, lw=0.8)
        axes.grid(alpha=0.25)
    top.set_ylabel(f"force P in {y.symbol}")
    bottom.set(xlabel=f"depth d in {x.symbol}", ylabel=f"residual in {z.symbol}")
    bottom.margins(y=0.25)
    top.legend()
    bottom.legend(loc="upper left", ncols=3, fontsize=8)
    values = ", ".join(f"{one.name} = {one.value:.4g}" for one in found.estimates)
    verdict = "the model fits with" if found.quality.fits else "the model does NOT fit, nearest at"
    figure.suptitle(f"{title}: {verdict} {values} (SI)", fontsize=11, wrap=True)
    return figure
