"""Which w and γ₁ does a measured force–depth curve have, and how well does it determine them?

    min over p of Σ (Pᵢ - P(Dᵢ - D₀; p) - line)²,   p from log w, log γ₁, log Ẽ/h and the offset D₀,

over the points in contact, the simulated P along the measured positions in their order (loading,
unloading; a contact that is lost and touches again begins anew), and over those without force. With
`opening` the work of adhesion of a contact that opens is fitted too, from a loop. DATA has columns
of depth and force with units, such as `depth [µm], force [mN/m]` or `Weg [nm];Kraft [nN]`; the
delimiter, decimal mark, encoding and preamble are found, the rest is given by the options below or
a table [measured] in the scene file (studies/scenes/curve_file.py). The scene file gives the layer,
the indenter and where the search begins; its depth and [path] do not matter. DATA may be a folder,
or an instrument file with several curves: then all are fitted, a row each, DATA_fits.csv.

On a cantilever the depth, piezo position less force over spring constant, has the noise of the
force in it: with --spring-constant the curve is simulated over the piezo position, which has none.

Segments in which the indenter is held in contact and single points that stick out are named and
left out. --range and --exclude choose the points that are used, by their depths. With --loss
soft_l1 points far off hardly count: Σ 2c² (√(1 + r²/c²) - 1) is minimised, c twice the noise; up to
three points in a row that are then farther off than six times the noise are named and left out.
Waves in the force out of contact, as laser interference makes them, are fitted with its line.

In place of the stiffness Ẽ/h Young's modulus E may be fitted, with ν and h of the scene. R and h
themselves may be uncertain: with --uncertainty they are fitted, too, the value of the scene counts
as a measurement with that standard deviation, and all intervals contain it.

Where the scene has gamma1 = 0 there is none to be fitted: springs detach one by one, and a layer
(response = "layer") is that of Johnson, Kendall and Roberts.

Any zero of the depth is found: contact is where the force first leaves the line without contact.
Level, slope and drift (over time) of that line are fitted with the rest. Where contact begins and
is lost between a clearly pulled point and one without force, these two positions count as
measurements too, with the error of the interval between the points.

Intervals at 95 %: linearised, p ± t(n - m) s √((JᵀJ)⁻¹)ᵢᵢ, s² = Σr²/(n - m); and profile, to be
trusted where the two differ: all values of pᵢ at which the sum of squares, the others fitted anew,
is below min (1 + t²/(n - m)). Noise is taken as independent and of equal size. A parameter whose
interval spans more than a factor e to either side is reported as not identifiable. Where the
condition number of the Jacobian exceeds 100, the combination that the curve constrains least is
named. (While a line is pinned, as at the edge of a flat punch, the force does not depend on w: only
the detachment does.)

The model does not fit, and there are no intervals, where the residual s exceeds twice the noise
that the third differences of the data show, or keeps its sign over too many points (a runs test),
or where the force out of contact is not zero in the mean (verdict.py beside this file). The fit is
compared with those without tension, without adhesion (where w is not well known) and with the
layer's own response by Schwarz's criterion BIC = n log(Σr²/n) + m log n: the lowest one describes
the data best, and ΔBIC is that of the other model less that of the fit. The assumptions of the
model that do not hold along the fitted curve are warned of; a layer thicker than every contact is
wide speaks against springs, however small the residual.

Output: DATA_fit.csv, DATA_fit.png. Exit status 1 if the model does not fit. --self-test: simulated
curves of many kinds in place of DATA (studies/scenes/fit/trials.py); exit status 1 if too few are
judged rightly or too few intervals contain the truth.
"""

# Conventions of what the functions below read:
#
# `Fit` is a finished fit; `fitted` (n,) are its forces at all n points of the curve: the simulated
# one in contact, 0 out of it, plus `line` (n,), the force out of contact there. `best.x` are
# the coordinates of the minimum, and `model.parameters` makes parameters by name of them.
# `model.data` is the curve with masks (n,): `used` is in contact and fitted, `free` out of contact
# and fitted; what is in neither took no part. Each of its `legs` has the indices `points` of the
# points in contact while the indenter moves in one direction. `curve.depth` and `curve.force` are
# as measured, `curve.drive` is the position of the machine, d + P/K [m], K its stiffness.
# `prefixed(values, unit)` is a `Unit` that suits these values: by its `size` they are divided for a
# figure, and its `symbol` is written with them.
# `canvas` is a new figure with its axes, of a width and a height in inches, rows and columns.

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from energy.arrays import Array, Mask
from energy.files.text_lines import DELIMITERS, NUMBER
from energy.units import prefixed
from studies.scenes.curve_file import MEASURED, read_curve
from studies.scenes.file import built, read
from studies.scenes.fit import many, trials
from studies.scenes.fit.estimate import LOSSES, Estimate, Fit, fit
from studies.scenes.fit.force_curve import loading
from studies.scenes.fit.model import DEFAULT, NAMES
from studies.shared import command
from studies.shared.figures import BLUE, GREY, ORANGE, Figure, canvas
from studies.shared.table import Table

SYMBOLS = {"gamma1": "γ₁", "offset": "D₀"}  # of parameters, in figures
# Most decimals of a value. In its unit it is in 1..1000, where these are ten digits or more, beyond
# what a measured curve determines; a value of 0, in the plain unit, has a nanometre as its last.
_DECIMALS = 9


def plot(found: Fit, title: str) -> Figure:
    """P over the position of the machine with the fit above, residuals with ± 2s below.

    The position is 0 at d = 0, which the fitted offset D₀ finds; s is the scatter of the residuals.
    """
    figure, (top, bottom) = canvas(9, 7.5, 2, 1, sharex=True, height_ratios=(2, 1))
    data = found.model.data
    curve = found.model.data.curve
    unit = found.unit("level")
    offset = found.model.parameters(found.best.x)["offset"]
    position = curve.drive - offset
    residual = curve.force - found.fitted
    of_position = prefixed(position, "m")
    of_force = prefixed(curve.force, unit)
    of_residual = prefixed(residual[data.used], unit)
    position = position / of_position.size
    took_part = data.used | data.free
    _points(top, found, position, curve.force / of_force.size, ~took_part)
    # what took no part has no residual to show
    _points(bottom, found, position, residual / of_residual.size, np.zeros_like(took_part))
    for number, leg in enumerate(data.legs):
        style = {"color": "black", "lw": 1.2, "zorder": 3, "label": "_" if number else "fit"}
        top.plot(position[leg.points], found.fitted[leg.points] / of_force.size, **style)
    if data.free.any():
        # everywhere out of the contact, so that it shows where points that took no part lie, too
        outside = np.flatnonzero(~data.used)
        outside = outside[np.argsort(position[outside])]
        style = {"ls": "--", "color": "black", "lw": 1, "label": "line without contact"}
        top.plot(position[outside], found.line[outside] / of_force.size, **style)
    two_s = 2 * found.best.scatter / of_residual.size
    bottom.axhspan(-two_s, two_s, color=GREY, alpha=0.25, lw=0, label="± 2 s")
    rigid = math.isinf(curve.machine_stiffness)
    where = "depth d" if rigid else "position of the machine, d + P/K,"
    bottom.set(
        xlabel=f"{where} in {of_position.symbol}", ylabel=f"residual in {of_residual.symbol}"
    )
    bottom.margins(y=0.25)
    top.set_ylabel(f"force P in {of_force.symbol}")
    top.legend(ncols=2)
    figure.suptitle(f"{title}\n{result(found)}", fontsize=11, wrap=True)
    return figure


def result(found: Fit) -> str:
    """Whether the model fits, and the parameters, in a sentence."""
    values = ", ".join(_value(found, e) for e in found.estimates if e.name in NAMES)
    if found.quality.fits:
        return f"the model fits with {values} (95 %)"
    return f"the model does not fit; nearest are {values}"


def _value(found: Fit, estimate: Estimate) -> str:
    """A parameter as a sentence shows it: its symbol, value and half the interval, with a unit.

    Half the interval has two digits. Without an interval that is narrow enough to identify the
    parameter its value stands alone.
    """
    name = SYMBOLS.get(estimate.name, estimate.name)
    size, unit = prefixed(estimate.value, found.unit(estimate.name))
    value = estimate.value / size
    if estimate.interval is None or not estimate.identifiable:
        return f"{name} = {value:.3g} {unit}"
    half = np.ptp(estimate.interval) / (2 * size)
    decimals = min(max(1 - math.floor(math.log10(half)), 0), _DECIMALS)
    return f"{name} = {value:.{decimals}f} ± {half:.{decimals}f} {unit}"


def _points(axes: Any, found: Fit, x: Array, y: Array, aside: Mask) -> None:
    """What was measured on the way in and out, out of contact, and what was not used.

    Parameters
    ----------
    axes : Axes
    found : Fit
    x, y : ndarray (n,)
        Of all points of the curve, in the units of the axes.
    aside : ndarray of bool (n,)
        Points to show as not used.
    """
    data = found.model.data
    grows = loading(found.model.data.curve.drive)
    for chosen, colour, marker, name in (
        (data.used & grows, BLUE, "o", "loading"),
        (data.used & ~grows, ORANGE, "s", "unloading"),
        (data.free, GREY, ".", "out of contact"),
        (aside, GREY, "x", "not used"),
    ):
        if chosen.any():
            axes.plot(x[chosen], y[chosen], marker, ms=4, color=colour, label=name)
    axes.axhline(0, color=GREY, lw=0.8)
    axes.grid(alpha=0.25)


def table(found: Fit) -> Table:
    """Depth, force, fitted force and residual: names of the columns, and a row per point.

    Depth and force are as measured; the fitted force has the line out of contact in it. Both it
    and the residual are nan where the point took no part.
    """
    data = found.model.data
    unit = found.unit("level")
    force = found.model.data.curve.force
    fitted = np.where(data.used | data.free, found.fitted, math.nan)
    columns = {
        "depth [m]": data.curve.depth,
        f"force [{unit}]": force,
        f"fitted [{unit}]": fitted,
        f"residual [{unit}]": force - fitted,
    }
    return list(columns), np.stack(list(columns.values()), axis=1).tolist()


def _reading_options(parser: command.Parser) -> None:
    """How DATA is written, each in place of the same key of [measured] in the scene file."""
    group = parser.add_argument_group("how DATA is written, found from the file where not given")
    about = 'of depth and force: names or numbers from 1, with missing units, as "2 [mN]"'
    about += "; four where extending and retracting stand in columns of their own"
    group.add_argument("--columns", nargs="+", metavar="NAME", help=about)
    about = "length of the line contact in m, for forces in newtons"
    group.add_argument("--width", type=float, metavar="LENGTH", help=about)
    about = "of the cantilever in N/m: the noise of the force is in the depth, too"
    group.add_argument("--spring-constant", type=float, metavar="N/m", help=about)
    about = "of its deflection in m/V, for a signal in volts"
    group.add_argument("--sensitivity", type=float, metavar="m/V", help=about)
    about = "number of the curve in an instrument file with several"
    group.add_argument("--curve", type=int, metavar="NUMBER", help=about)
    about = "between columns of text: tab, space, or one of ; | ,"
    group.add_argument("--delimiter", choices=DELIMITERS, metavar="MARK", help=about)
    about = "decimal mark of text: . or ,"
    group.add_argument("--decimal", choices=NUMBER, metavar="MARK", help=about)
    group.add_argument("--encoding", metavar="NAME", help="of text, such as utf-16 or cp1252")
    group.add_argument("--skip", type=int, metavar="LINES", help="of text, above the data")


def _uncertainty(text: str) -> tuple[str, float]:
    """A name and its relative uncertainty, from a text such as R=2% or R=0.02."""
    name, _, share = text.partition("=")
    try:
        return name, float(share.removesuffix("%")) * (0.01 if share.endswith("%") else 1.0)
    except ValueError:
        raise ValueError(
            f"uncertainty = {text!r} must be a name and a share, such as R=2% or R=0.02"
        ) from None


def _parser() -> command.Parser:
    """All options of the command."""
    few = trials.QUICK.curves
    quick_means = f"linearised intervals and no alternatives; {few} trials of each kind"
    parser = command.parser("fit", __doc__, quick_means)
    about = "measured curve, or a folder of curves"
    parser.add_argument("data", type=Path, nargs="?", metavar="DATA", help=about)
    parser.add_argument("--scene", type=Path, metavar="FILE.toml", help="scene file to start from")
    known = f"default: {' '.join(DEFAULT)}; known: {' '.join(NAMES)}"
    parser.add_argument("--parameters", nargs="+", default=DEFAULT, metavar="NAME", help=known)
    about = "depths in m, as in the file, between which points are used"
    parser.add_argument("--range", nargs=2, type=float, metavar=("LOW", "HIGH"), help=about)
    about = "depths in m between which points are not used; may be given several times"
    parser.add_argument(
        "--exclude",
        nargs=2,
        type=float,
        metavar=("LOW", "HIGH"),
        action="append",
        default=[],
        help=about,
    )
    about = "of the residuals: their squares, or soft_l1, which single points hardly move"
    parser.add_argument("--loss", choices=LOSSES, default=LOSSES[0], help=about)
    about = "relative standard uncertainties of R and h, such as R=2%% h=5%%"
    parser.add_argument("--uncertainty", nargs="+", metavar="NAME=SHARE", default=[], help=about)
    about = "parameter that all curves of a folder have in common"
    parser.add_argument("--shared", metavar="NAME", help=about)
    parser.add_argument("--self-test", action="store_true", help="simulated data in place of DATA")
    about = f"of each kind in --self-test; default {trials.FULL.curves}, quick {few}"
    parser.add_argument("--trials", type=int, metavar="COUNT", help=about)
    _reading_options(parser)
    return parser


def main(argv: Sequence[str] | None = None) -> int:
    """Fit a file or a folder of them, or test the fit on simulated data.

    Returns
    -------
    int
        The exit status: 1 if a curve does not fit, or too many trials fail. That is what
        `many.report`, for several curves, and `trials.report` return, too.
    """
    parser = _parser()
    options, out = command.parse(parser, argv)
    quick = options.preset == "quick"
    if options.self_test:
        usual = (trials.QUICK if quick else trials.FULL).curves
        return trials.report(usual if options.trials is None else options.trials, options.jobs, out)
    if options.data is None or options.scene is None:
        parser.error("DATA and --scene are needed; or give --self-test")
    content = read(options.scene)
    # an option in place of the same key of [measured]
    said = {key: value for key in MEASURED if (value := getattr(options, key)) is not None}
    given = built(options.scene, content | {"measured": content.get("measured", {}) | said})
    choices = {
        "alternatives": not quick,
        "depth_range": options.range,
        "exclude": options.exclude,
        "loss": options.loss,
        "uncertainties": dict(map(_uncertainty, options.uncertainty)),
    }
    # A name for each curve: of a file, or "file#number" in an instrument file with several. Fits of
    # several curves have no profile intervals: their table has a row each of linearised ones.
    files = many.curves(options.data, given.measured)
    if len(files) != 1 or options.data.is_dir():
        job = many.FittedFile(options.scene, given.measured, tuple(options.parameters), choices)
        name = f"{options.data.stem}_fits"
        return many.report(job, files, options.shared, given.title, name, out, options.jobs)
    if options.shared is not None:
        parser.error(f"--shared {options.shared}: one curve shares nothing; give a folder")
    curve = read_curve(options.data, given.measured)
    found = fit(given.scene, curve, options.parameters, profiles=not quick, **choices)
    print(found)
    name = f"{options.data.stem}_fit"
    notes = [f"scene: {given.scene}", *str(found).splitlines()]
    # the header of the CSV says which parameters were fitted
    written = [out.table(f"{name}.csv", options.parameters, *table(found), notes=notes)]
    written += out.figure(f"{name}.png", plot(found, given.title))
    print(f"written: {', '.join(map(str, written))}")
    command.answer(result(found))  # as the last line on the screen
    return 0 if found.quality.fits else 1
