"""The figures of `fit`: measured and fitted force with residuals; estimates of the self-test."""

from __future__ import annotations

import numpy as np

from energy.units import prefixed
from studies.scenes.fit.estimate import Fit
from studies.scenes.fit.force_curve import loading
from studies.scenes.fit.trial_record import Record
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


def plot_trials(record: Record) -> Figure:
    """Each estimate over the truth with its linearised interval, a panel per parameter."""
    names = record.parameters.names
    count = len(names)
    figure, grid = canvas(10, 2.6 * count + 0.5, count, 1, sharex=True, squeeze=False)
    panels = grid[:, 0]
    for i, (axes, name) in enumerate(zip(panels, names, strict=True)):
        truth = record.truth[name]
        for holds, colour, marker in ((True, BLUE, "o"), (False, ORANGE, "s")):
            rows = [(k, t[i]) for k, t in enumerate(record.trials, 1) if t[i].holds == holds]
            if not rows:
                continue
            scale = truth or 1.0
            middle = np.array([trial.value for _, trial in rows]) / scale
            ends = np.array([trial.interval or (trial.value,) * 2 for _, trial in rows]).T / scale
            number = [k for k, _ in rows]
            label = f"intervals {'with' if holds else 'without'} the truth: {len(rows)}"
            style = {"ls": "", "color": colour, "marker": marker, "ms": 3, "lw": 1}
            axes.errorbar(number, middle, np.abs(ends - middle), label=label, **style)
        axes.axhline(1.0 if truth else 0.0, color="black", lw=0.8)
        axes.set_ylabel(f"{name} / truth" if truth else f"{name} in m")
        axes.margins(y=0.25)
        axes.legend(fontsize=8, ncols=2, loc="upper right")
    panels[-1].set_xlabel("trial")
    panels[-1].xaxis.get_major_locator().set_params(integer=True)
    noise = record.parameters.noise
    held = min(min(record.share(i)) for i in range(count))
    figure.suptitle(
        f"With {noise:.1%} noise at least {held:.0%} of the 95 % intervals hold the truth"
    )
    return figure
