"""Does a fitted model describe the curve? Its residual against the noise of the data themselves."""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
TIMES = 2.0  # residual over noise: found between 0.5 and 1.4 where the model is right
RUNS = -3.5  # standard deviations below the mean number of runs: one in 4000 curves of pure noise
FELT = 0.5  # of the noise: below, runs of one sign are errors of the simulation
SIMULATED = 1e-6  # of the largest force: how far simulated forces are to be trusted
CHECK = "check sign, zero, hysteresis (loading and unloading apart: fit opening, too)"


class Quality(NamedTuple):
    """times: residual over noise, nan if the noise is unknown; runs: those of one sign against
    what independent noise has, in standard deviations (Wald and Wolfowitz 1940)."""

    times: float
    runs: float

    @property
    def fits(self) -> bool:
        """Whether the residual may be noise."""
        return not (self.times > TIMES or (self.times > FELT and self.runs < RUNS))

    @property
    def told(self) -> str:
        """What is wrong, in words; "" if nothing is."""
        if math.isnan(self.times):
            return (
                "the noise cannot be told from so few points: nothing says whether the model fits"
            )
        if self.fits:
            return ""
        size = f"residual is {self.times:.3g} times the noise"
        if self.times <= TIMES:
            size += " and keeps its sign over many points"
        return f"{size}: {CHECK}; or the data were smoothed. No intervals: the model does not fit"


def judged(residuals: Array, ends: Array, spare: int, noise: float, force: float) -> Quality:
    """Quality of residuals of the force (n,) and of the ends of contact (k,) [N/m].

    times² = Σr²/(spare noise²) over both, the latter in units of the noise already; the noise is
    taken as at least SIMULATED times the largest force. 0: it could not be found.
    """
    if not noise > 0:
        return Quality(math.nan, 0.0)
    size = math.sqrt(float(np.sum(residuals**2) + np.sum(ends**2)) / spare)
    return Quality(size / max(noise, SIMULATED * force), runs(residuals))


def runs(residuals: Array) -> float:
    """Number of runs of one sign, less its mean for independent signs, over its deviation.

    With n₊ and n₋ signs, n together: mean 1 + 2n₊n₋/n, variance (mean - 1)(mean - 2)/(n - 1).
    """
    signs = np.sign(residuals[residuals != 0])
    n, above = signs.size, int((signs > 0).sum())
    if above in (0, n):
        return -math.sqrt(n)  # one run: its limit for many points of both signs
    mean = 1 + 2 * above * (n - above) / n
    variance = max((mean - 1) * (mean - 2) / (n - 1), 1e-3)
    return float((1 + np.count_nonzero(np.diff(signs)) - mean) / math.sqrt(variance))
