"""Estimates of surface energies from a measured curve, their intervals, and what stays open."""

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import OptimizeResult, brentq
from scipy.special import stdtrit

from energy import Scene
from studies.scenes.fit.force_curve import Curve, in_contact, noise
from studies.scenes.fit.model import DEFAULT, Model, conditioning, minimum
from studies.scenes.fit.quality import Quality, judged
from studies.shared import Array
from studies.shared.batches import Progress, each

UNITS = {"w": "J/m²", "gamma1": "J/m²", "stiffness": "Pa/m", "offset": "m", "opening": "J/m²"}
CONFIDENCE = 0.95
LOOSE, CONDITION = 1.0, 100.0
SIMULATED = 1e-6  # of the largest force: smaller residuals are those of the simulation
STEPS = (1.25, 2.5, 5.0, 10.0, 20.0)  # outwards, in half-widths of the linearised interval
Interval = tuple[float, float]


class Estimate(NamedTuple):
    """A parameter, its linearised and profile intervals, and whether it is identifiable.

    bound: its value is the bound of the search; intervals are None where they are withheld (the
    model does not fit, or bound), a profile also where it was not asked for or is not identifiable.
    """

    name: str
    value: float
    interval: Interval | None
    profile: Interval | None
    identifiable: bool
    bound: bool


@dataclass(frozen=True)
class Fit:
    """A finished fit: the curve, which points are used (n,), the model, the estimates.

    best: what least_squares returned; condition: of the Jacobian with columns of unit length;
    combination: coefficients of the coordinates that the data fix least; quality: whether the
    residual may be noise.
    """

    curve: Curve
    used: NDArray[np.bool_]
    model: Model
    best: OptimizeResult
    estimates: tuple[Estimate, ...]
    condition: float
    combination: tuple[float, ...]
    quality: Quality

    @property
    def fitted(self) -> Array:
        """Fitted forces in contact."""
        return self.model.measured + np.asarray(self.best.fun)[: self.model.measured.size]

    @property
    def residual_noise(self) -> float:
        """s = √(Σr²/(n - m))."""
        return math.sqrt(2 * self.best.cost / _spare(self.best))

    def inside_profile(self, i: int, value: float) -> bool:
        """Whether a value of parameter i lies in its profile interval."""
        at = self.model.coordinate(self.model.names[i], value)
        return profiled(self.model, self.best, i, at) <= _limit(self.best)

    @property
    def warnings(self) -> tuple[str, ...]:
        """Whether the model does not fit, and what the data do not fix, in plain words."""
        found = [self.quality.told] if self.quality.told else []
        for e in self.estimates:
            if e.bound:
                found.append(
                    f"{e.name} = {e.value:.3g} {UNITS[e.name]} is the bound of the search, no "
                    "estimate: start from other parameters, or leave it out of --parameters"
                )
            elif not e.identifiable:
                found.append(
                    f"{e.name} is not identifiable from this curve: its interval is wider than a "
                    "factor e; set it in the scene and leave it out of --parameters, or measure "
                    "up to the detachment"
                )
        if self.condition > CONDITION:
            terms = zip(self.combination, self.model.names, strict=True)
            text = " ".join(f"{c:+.2f} log {name}" for c, name in terms)
            text = text.replace("log offset", "offset/range")
            found.append(f"ill-conditioned ({self.condition:.2g}): the curve hardly fixes {text}")
        return tuple(found)

    def __str__(self) -> str:
        rows = [f"{'parameter':12s}{'estimate':>13s}{'95 % linearised':>29s}{'95 % profile':>29s}"]
        for e in self.estimates:
            spans = (self._told(e, span) for span in (e.interval, e.profile))
            cells = "".join(f"{span:>29s}" for span in spans)
            rows.append(f"{e.name:12s}{e.value:>13.5g}{cells} {UNITS[e.name]}")
        count = f"{self.used.sum()} of {self.used.size} points in contact"
        ends = ", ".join(mark.kind for mark in self.model.ends) or "no end of contact"
        unit = f"N{self.model.scene.per_length}"
        size = "" if math.isnan(self.quality.times) else f", {self.quality.times:.2g} × the noise"
        rows.append(f"{count}, {ends} used; residual {self.residual_noise:.3g} {unit}{size}")
        return "\n".join([*rows, *(f"WARNING: {text}" for text in self.warnings)])

    def _told(self, estimate: Estimate, interval: Interval | None) -> str:
        if interval is not None:
            return f"[{interval[0]:.5g}, {interval[1]:.5g}]"
        if estimate.bound:
            return "bound of the search"
        if not self.quality.fits:
            return "withheld"
        return "not sought" if estimate.identifiable else "open"


def fit(
    scene: Scene,
    curve: Curve,
    names: Sequence[str] = DEFAULT,
    *,
    profiles: bool = True,
    show: Callable[[Progress], object] = lambda progress: None,
) -> Fit:
    """Least squares on the simulator, starting from the scene; names out of model.NAMES.

    profiles: find the profile intervals too, which costs ten times as much. show gets the progress
    over the parameters. Without a fit in the sense of quality.py there are no intervals.
    ValueError for too few points in contact or a start at which there is no equilibrium.
    """
    model = Model.of(scene, names, curve)
    best = minimum(model, np.zeros(len(names)))
    condition, weakest, spread = conditioning(best.jac)
    reach = _quantile(best) * math.sqrt(2 * best.cost / _spare(best)) * spread
    forces, ends = np.split(best.fun, [model.measured.size])
    free, sigma = curve.force[model.detached(curve, best.x)], noise(curve.force)
    # no noise is less than what simulated forces are to be trusted to
    least = SIMULATED * float(np.abs(model.measured).max()) if sigma else 0.0
    quality = judged(forces, ends, free, _spare(best), max(sigma, least))
    estimate = partial(_estimate, model, best, reach, profiles, quality.fits)
    estimates = tuple(each(estimate, range(len(names)), 1, show))
    combination = tuple(weakest.tolist())
    return Fit(curve, in_contact(curve), model, best, estimates, condition, combination, quality)


def _spare(best: OptimizeResult) -> int:
    return int(best.fun.size - best.x.size)


def _quantile(best: OptimizeResult) -> float:
    """t of Student's distribution."""
    return float(stdtrit(_spare(best), 0.5 + CONFIDENCE / 2))


def _limit(best: OptimizeResult) -> float:
    """Sum of squares over the least at the ends of a profile interval."""
    return 1 + _quantile(best) ** 2 / _spare(best)


def profiled(model: Model, best: OptimizeResult, i: int, at: float) -> float:
    """The least sum of squares with coordinate i at a value, over that of the fit."""
    direction = np.zeros(best.x.size)
    direction[i] = 1.0
    others = [j for j in range(best.x.size) if j != i]
    slope = np.linalg.lstsq(best.jac[:, others], -best.jac[:, i], rcond=None)[0]
    direction[others] = slope
    start = best.x + (at - best.x[i]) * direction
    reach = model.limits[others]
    start[others] = np.clip(start[others], -reach, reach)
    residuals = model.residuals(start)
    if not np.isfinite(residuals).all():
        return math.inf
    if not others:
        return float(np.sum(residuals**2) / (2 * best.cost))
    return float(minimum(model, start, fixed=i, ftol=1e-4).cost / best.cost)


def _estimate(
    model: Model, best: OptimizeResult, reaches: Array, profiles: bool, fits: bool, i: int
) -> Estimate:
    """Estimate and intervals of parameter i; reaches: half-widths of the linearised intervals."""
    x, name, reach = float(best.x[i]), model.names[i], float(reaches[i])
    value, bound = model.value(name, x), model.on_bound(best.x, i)
    identifiable = math.isfinite(reach) and (name == "offset" or reach <= LOOSE) and not bound
    if bound or not fits:
        return Estimate(name, value, None, None, identifiable, bound)
    ends = (-math.inf, math.inf) if name == "offset" else (0.0, math.inf)
    if math.isfinite(reach):
        ends = model.value(name, x - reach), model.value(name, x + reach)
    profile = None
    if identifiable and profiles:
        low, high = (_profile_end(model, best, i, side * reach) for side in (-1, 1))
        identifiable = math.isfinite(high - low) and (name == "offset" or high - low <= 2 * LOOSE)
        profile = model.value(name, x + low), model.value(name, x + high)
    return Estimate(name, value, ends, profile, identifiable, bound)


def _profile_end(model: Model, best: OptimizeResult, i: int, reach: float) -> float:
    """Distance from the fit at which the profile crosses min (1 + t²/(n - m)), to 2 %."""
    limit = math.sqrt(_limit(best) - 1)

    def excess(times: float) -> float:
        ratio = profiled(model, best, i, float(best.x[i]) + times * reach) if times else 1.0
        return min(math.sqrt(max(ratio - 1, 0)), 10 * limit) - limit  # nearly linear

    near = 0.0
    for far in STEPS:
        if excess(far) > 0:
            return float(brentq(excess, near, far, xtol=0.02)) * reach
        near = far
    return math.copysign(math.inf, reach)
