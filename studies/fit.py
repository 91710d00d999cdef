"""Which w and γ₁ does a measured force–depth curve have, and how well does it fix them?

    min over p of Σ (Pᵢ - P(dᵢ - d₀; p))²,   p from log w, log γ₁, log Ẽ/h and the depth offset d₀,

over the points in contact, P along discretization.load_path through the measured depths in their
order (loading, unloading). DATA.csv has two columns, their names with units above them, such as
`depth [µm], force [mN/m]`; lines that begin with # are passed over. The scene file gives the rest
and where the search begins; its depth and [path] do not matter. Points whose force is noise at
both ends of the curve are out of contact and take no part; where the simulated contact lets go
before the measured one, its force is continued along the tangent, so that residuals are smooth.

Intervals at 95 %: linearised, p ± t(n - m) s √((JᵀJ)⁻¹)ᵢᵢ, s² = Σr²/(n - m); and profile, to be
trusted where the two differ: all values of pᵢ at which the sum of squares, the others fitted anew,
is below min (1 + t²/(n - m)). Noise is taken as independent and of equal size. A parameter whose
interval spans more than a factor e to either side is reported as not identifiable, as is a
combination for which the Jacobian's condition exceeds 100: the curve does not fix it. (While a line
is pinned, as at the edge of a flat punch, the force does not feel w: only the letting go does.)

Where contact begins and is lost between a clearly pulled point and one without force, these two
depths count as measurements too, with the error of the interval between the points.

Output: DATA_fit.csv, DATA_fit.png. --self-test: synthetic noisy data (of a built-in scene, or of
--scene), fitted from a wrong start; fit_self_test.png; exit status 1 if fewer than 90 % of the
intervals of a parameter hold the truth.
"""

from __future__ import annotations

import argparse
import math
import shlex
import sys
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from studies import fit_figure, fit_trials
from studies.fit_estimate import Fit, fit
from studies.fit_model import NAMES
from studies.force_curve import read_curve, write_curve
from studies.scene_file import load


def write_csv(found: Fit, path: Path, header: Sequence[str]) -> None:
    """Depth, force, fitted force and residual; nan where the point took no part."""
    fitted = np.full(found.curve.force.shape, math.nan)
    fitted[found.used] = found.fitted
    columns = {
        "depth [m]": found.curve.depth,
        "force [N/m]": found.curve.force,
        "fitted [N/m]": fitted,
        "residual [N/m]": found.curve.force - fitted,
    }
    write_curve(path, columns, [*header, str(found)])


def main(argv: Sequence[str] | None = None) -> int:
    """Fit a file, or test the fit on synthetic data."""
    parser = argparse.ArgumentParser(prog="python -m studies fit", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    parser.add_argument("data", type=Path, nargs="?", metavar="DATA.csv", help="measured curve")
    parser.add_argument("--scene", type=Path, help="scene file to start from")
    known = f"default: w gamma1; known: {' '.join(NAMES)}"
    parser.add_argument("--parameters", nargs="+", default=["w", "gamma1"], help=known)
    parser.add_argument("--out", type=Path, default=Path("results"), help="default: results/")
    parser.add_argument("--self-test", action="store_true", help="synthetic data in place of DATA")
    parser.add_argument("--trials", type=int, default=100, help="of --self-test; default: 100")
    options = parser.parse_args(argv)
    if options.self_test:
        scene = load(options.scene).scene if options.scene else fit_trials.SCENE
        params = fit_trials.Parameters(scene, tuple(options.parameters), options.trials)
        return fit_trials.report(params, options.out)
    if options.data is None or options.scene is None:
        parser.error("DATA.csv and --scene are needed; or give --self-test")
    given = load(options.scene)
    found = fit(given.scene, read_curve(options.data), options.parameters)
    print(found)
    options.out.mkdir(parents=True, exist_ok=True)
    command = shlex.join(["python", "-m", "studies", "fit", *(argv or sys.argv[2:])])
    table, picture = (options.out / f"{options.data.stem}_fit.{end}" for end in ("csv", "png"))
    write_csv(found, table, [f"command: {command}", f"scene: {given.scene}"])
    fit_figure.plot(found, given.title).savefig(picture, dpi=130)
    print(f"written: {table}, {picture}")
    return 0
