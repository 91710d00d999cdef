"""Does a fitted model describe the curve? Its residual against the noise of the data themselves."""

import math
from typing import NamedTuple

import numpy as np

from studies.shared import Array

TIMES = 2.0  # residual over noise: found between 0.5 and 1.4 where the model is right
RUNS = -3.5  # standard deviations below the mean number of runs: one in 4000 curves of pure noise
ZERO = 4.5  # standard errors that the mean force out of contact may be off zero
FELT = 0.5  # of the noise: below, runs of one sign are errors of the simulation
CHECK = "check sign, zero, hysteresis (loading and unloading apart: fit opening, too)"


class Quality(NamedTuple):
    """times: residual over noise, nan if the noise is unknown; runs: those of one sign against
    what independent noise has, in standard deviations (Wald and Wolfowitz 1940); zero: the mean
    force where there is no contact, in standard errors."""

    times: float
    runs: float
    zero: float = 0.0

    @property
    def fits(self) -> bool:
        """Whether the residual may be noise, around a force whose zero is right."""
        systematic = self.times > FELT and self.runs < RUNS
        return not (self.times > TIMES or systematic or abs(self.zero) > ZERO)

    @property
    def told(self) -> str:
        """What is wrong, in words; "" if nothing is."""
        if math.isnan(self.times):
            return "the noise cannot be told from so few points: nothing says whether it fits"
        if self.fits:
            return ""
        size, why = f"residual is {self.times:.3g} times the noise", CHECK
        if self.times <= TIMES and abs(self.zero) > ZERO:
            why = f"check zero: the force out of contact is {self.zero:+.2g} standard errors off"
        elif self.times <= TIMES:
            size += " and keeps its sign over many points"
        return f"{size}: {why}; or the data were smoothed. No intervals: the model does not fit"


def judged(forces: Array, ends: Array, free: Array, spare: int, noise: float) -> Quality:
    """Quality of residuals of the force (n,) and of the ends of contact (k,), and of the forces
    measured where there is no contact (m,) [N/m].

    times² = Σr²/(spare noise²) over both kinds of residuals, the latter in units of the noise
    already; zero = mean √m/noise. noise 0: it could not be found.
    """
    if not noise > 0:
        return Quality(math.nan, 0.0)
    size = math.sqrt(float(np.sum(forces**2) + np.sum(ends**2)) / spare)
    zero = float(free.mean()) * math.sqrt(free.size) / noise if free.size else 0.0
    return Quality(size / noise, runs(forces), zero)


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
