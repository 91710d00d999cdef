"""Which w and γ₁ does a measured force–depth curve have, and how well does it fix them?

    min over p of Σ (Pᵢ - P(dᵢ - d₀; p))²,   p from log w, log γ₁, log Ẽ/h and the depth offset d₀,

over the points in contact, P along discretization.load_path through the measured depths in their
order (loading, unloading; a contact that is lost and touches again begins anew). With `opening` the
work of adhesion of a contact that opens is fitted too, from a loop of loading and unloading. DATA
has columns named depth and force, with units above them, such as `depth [µm], force [mN/m]`; the
delimiter, decimal mark, encoding and preamble are found, other columns and forces in newtons need
the options below or a table [measured] in the scene file (studies/scenes/curve_file.py); around an
axis (geometry = "axisymmetric") newtons are what the model has. Instrument files are read with the
extra elastocap[afm]. The scene file gives the rest and where the search
begins; its depth and [path] do not matter. Points whose force is noise at both ends of a contact
take no part; where the simulated contact detaches before the measured one, its force is continued
along the tangent, so that residuals are smooth.

Intervals at 95 %: linearised, p ± t(n - m) s √((JᵀJ)⁻¹)ᵢᵢ, s² = Σr²/(n - m); and profile, to be
trusted where the two differ: all values of pᵢ at which the sum of squares, the others fitted anew,
is below min (1 + t²/(n - m)). Noise is taken as independent and of equal size. A parameter whose
interval spans more than a factor e to either side is reported as not identifiable, as is a
combination for which the Jacobian's condition exceeds 100: the curve does not fix it. (While a line
is pinned, as at the edge of a flat punch, the force does not feel w: only the detachment does.)

The model does not fit, and there are no intervals, where the residual s exceeds twice the noise
that the third differences of the data show, or keeps its sign over too many points (a runs test),
or where the force out of contact is not zero in the mean (quality.py beside this file). A value at
which the search ends is called a bound, not an estimate.

Where contact begins and is lost between a clearly pulled point and one without force, these two
depths count as measurements too, with the error of the interval between the points.

Output: DATA_fit.csv, DATA_fit.png. --self-test: synthetic noisy data (of a built-in scene, or of
--scene), fitted from a wrong start; exit status 1 if fewer than 90 % of the
intervals of a parameter hold the truth, or if of random curves with a reversed sign, a wrong zero
or hysteresis one is not called, or of good ones more than 5 % are (studies/scenes/fit/failures.py).
"""

import argparse
import math
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from energy.text_lines import DELIMITERS, NUMBER
from energy.units import prefixed
from studies.scenes.curve_file import LAYOUT, Reading, read_curve
from studies.scenes.file import SceneFile, load
from studies.scenes.fit import trials as fit_trials
from studies.scenes.fit.estimate import Fit, fit
from studies.scenes.fit.force_curve import loading
from studies.scenes.fit.model import DEFAULT, NAMES
from studies.shared import command
from studies.shared.batches import tell
from studies.shared.figures import BLUE, GREY, ORANGE, Figure, canvas
from studies.shared.table import Table


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


def table(found: Fit) -> Table:
    """Depth, force, fitted force and residual; nan where the point took no part."""
    fitted = np.full(found.curve.force.shape, math.nan)
    fitted[found.used] = found.fitted
    unit = f"N{found.model.scene.per_length}"
    columns = {
        "depth [m]": found.curve.depth,
        f"force [{unit}]": found.curve.force,
        f"fitted [{unit}]": fitted,
        f"residual [{unit}]": found.curve.force - fitted,
    }
    return list(columns), list(zip(*(c.tolist() for c in columns.values()), strict=True))


def _reading_options(parser: Any) -> None:
    """How DATA is written, each in place of the same key of [measured] in the scene file."""
    group = parser.add_argument_group("how DATA is written, found from the file where not given")
    about = 'of depth and force: names or numbers from 1, with missing units, as "2 [mN]"'
    group.add_argument("--columns", nargs=2, metavar="NAME", help=about)
    about = "length of the line contact in m, for forces in newtons"
    group.add_argument("--width", type=float, metavar="M", help=about)
    about = "number of the curve in an instrument file with several"
    group.add_argument("--curve", type=int, metavar="N", help=about)
    group.add_argument("--delimiter", choices=DELIMITERS, help="between columns of text")
    group.add_argument("--decimal", choices=NUMBER, help="decimal mark of text")
    group.add_argument("--encoding", metavar="NAME", help="of text, such as utf-16 or cp1252")
    group.add_argument("--skip", type=int, metavar="LINES", help="of text, above the data")


def _reading(options: argparse.Namespace, given: SceneFile) -> Reading:
    """The reading of the scene file with what the command line has in its place.

    Around an axis forces are those of the whole contact: ValueError for a length of the line.
    """
    said = {key: value for key, value in vars(options).items() if value is not None}
    known = given.measured
    layout = replace(known.layout, **{key: said[key] for key in LAYOUT if key in said})
    columns = tuple(options.columns) if options.columns else known.columns
    width, number = said.get("width", known.width), said.get("curve", known.number)
    if given.scene.axisymmetric:
        if width is not None:
            refusal = f"width = {width!r} with geometry = 'axisymmetric': leave it out"
            raise ValueError(refusal)
        width = 1.0
    return Reading(columns, width, layout, number)


def main(argv: Sequence[str] | None = None) -> int:
    """Fit a file, or test the fit on synthetic data."""
    quick_means = "linearised intervals only; 20 trials"
    parser = command.parser("fit", __doc__, quick_means, jobs=1)
    parser.add_argument("data", type=Path, nargs="?", metavar="DATA.csv", help="measured curve")
    parser.add_argument("--scene", type=Path, metavar="FILE.toml", help="scene file to start from")
    known = f"default: {' '.join(DEFAULT)}; known: {' '.join(NAMES)}"
    parser.add_argument(
        "--parameters", nargs="+", default=list(DEFAULT), metavar="NAME", help=known
    )
    parser.add_argument("--self-test", action="store_true", help="synthetic data in place of DATA")
    parser.add_argument(
        "--trials", type=int, metavar="N", help="of --self-test; default: 100, quick 20"
    )
    _reading_options(parser)
    options, out = command.parse(parser, argv)
    quick = options.preset == "quick"
    if options.self_test:
        scene = load(options.scene).scene if options.scene else fit_trials.SCENE
        trials = (20 if quick else 100) if options.trials is None else options.trials
        names = tuple(options.parameters)
        params = fit_trials.Parameters(scene, names, trials, profile=not quick)
        return fit_trials.report(params, out, options.jobs)
    if options.data is None or options.scene is None:
        parser.error("DATA.csv and --scene are needed; or give --self-test")
    if options.jobs > 1:
        parser.error(f"--jobs {options.jobs}: one curve is fitted in one process; give 1")
    given = load(options.scene)
    curve = read_curve(options.data, _reading(options, given))
    found = fit(given.scene, curve, options.parameters, profiles=not quick, show=tell)
    print(found)
    name, notes = f"{options.data.stem}_fit", [f"scene: {given.scene}", *str(found).splitlines()]
    written = [out.table(f"{name}.csv", options.parameters, *table(found), notes=notes)]
    written += out.figure(name, plot(found, given.title))
    print(f"written: {', '.join(map(str, written))}")
    return 0
