"""Estimates of surface energies from a measured curve, their intervals, and what stays open."""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from energy import Assumption, Scene
from energy.arrays import Array
from studies.scenes.fit.force_curve import (
    BASELINE,
    Curve,
    Data,
    chosen_points,
    in_motion,
    noise,
)
from studies.scenes.fit.model import DEFAULT, Model
from studies.scenes.fit.search import SIMULATED, Best, conditioning, profiled, sought
from studies.scenes.fit.verdict import (
    Alternative,
    Quality,
    along,
    compared,
    drifting,
    judged,
    unsuited,
)
from studies.scenes.run import violations

UNITS = {"w": "J/m²", "gamma1": "J/m²", "stiffness": "Pa/m", "offset": "m", "opening": "J/m²"}
LOOSE, CONDITION = 1.0, 100.0
CLOSE = 0.02  # of its distance: how well the end of a profile interval is found
FARTHEST = 20.0  # half-widths of the linearised interval
ELSEWHERE = "start from other parameters, or leave it out of --parameters"
OPEN = (
    "its interval is wider than a factor e; set it in the scene and leave it out of --parameters, "
    "or measure up to the detachment"
)
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
    """A finished fit of a measured curve, as `fit` gives it; `str` tells all of it in words.

    Attributes
    ----------
    model : Model
        The simulator as a function of the coordinates `best.x`; `model.scene` is the start, and
        `model.data` the curve, which of its points are in contact and which are free of force.
    best : Best
        Coordinates, residuals and Jacobian at the minimum.
    estimates : tuple of Estimate
        Each parameter with its intervals at 95 %; level, slope and drift of the force out of
        contact among them where the curve has a free part.
    condition, combination : float, tuple of float
        Condition of the Jacobian with columns of unit length, and the coefficients of the
        coordinates that the data fix least.
    quality : Quality
        `quality.fits`: whether the residual may be noise. If not, there are no intervals.
    alternatives : tuple of Alternative
        The fits without tension, without adhesion, and with the layer's own response.
    strained : tuple of (Assumption, float)
        Each assumption of the model that does not hold along the fitted curve, at its worst, and
        the depth where that is.
    unsuited : str
        Why the model is wrong for this curve, whatever its residual; "" if nothing says so.
    left_out : tuple of str
        Segments of the curve that are not part of the fit, and why.
    """

    model: Model
    best: Best
    estimates: tuple[Estimate, ...]
    condition: float
    combination: tuple[float, ...]
    quality: Quality
    alternatives: tuple[Alternative, ...] = ()
    strained: tuple[tuple[Assumption, float], ...] = ()
    unsuited: str = ""
    left_out: tuple[str, ...] = ()

    def __getitem__(self, name: str) -> Estimate:
        """The estimate of a parameter by its name."""
        return next(one for one in self.estimates if one.name == name)

    @property
    def line(self) -> Array:
        """Fitted force out of contact at all points of the curve (n,)."""
        return np.asarray(self.model.data.columns @ self.model.line(self.best.x))

    @property
    def fitted(self) -> Array:
        """Fitted forces at all points of the curve (n,), those out of contact included."""
        return self.model.forces(self.best.x)[0] + self.line

    def inside_profile(self, i: int, value: float) -> bool:
        """Whether a value of parameter i lies in its profile interval."""
        at = self.model.coordinate(self.model.names[i], value)
        return profiled(self.model, self.best, i, at) <= self.best.limit

    @property
    def needless(self) -> tuple[str, ...]:
        """Parameters that the data do not need."""
        return tuple(one.name for one in self.alternatives if one.simpler and one.preferred)

    @property
    def doubts(self) -> tuple[str, ...]:
        """What speaks against the model as a whole, in plain words."""
        others = [one.told for one in self.alternatives if one.doubtful]
        return tuple(one for one in (self.quality.told, self.unsuited, *others) if one)

    @property
    def warnings(self) -> tuple[str, ...]:
        """The doubts, what the data do not fix, and assumptions that do not hold."""
        found = list(self.doubts)
        for e in self.estimates:
            if e.bound:
                value = f"{e.name} = {e.value:.3g} {self.unit(e.name)}"
                found.append(f"{value} is the bound of the search, no estimate: {ELSEWHERE}")
            elif not e.identifiable and e.name not in self.needless:
                found.append(f"{e.name} is not identifiable from this curve: {OPEN}")
        if self.condition > CONDITION:
            terms = zip(self.combination, self.model.names, strict=True)
            text = " ".join(f"{c:+.2f} log {name}" for c, name in terms)
            text = text.replace("log offset", "offset/range")
            found.append(f"ill-conditioned ({self.condition:.2g}): the curve hardly fixes {text}")
        found += [f"{one}; worst at d = {depth:.3g} m" for one, depth in self.strained]
        return tuple(found)

    def unit(self, name: str) -> str:
        """The unit of a parameter."""
        force = f"N{self.model.scene.per_length}"
        return UNITS.get(name) or {"slope": f"{force} per m"}.get(name, force)

    def __str__(self) -> str:
        rows = [f"{'parameter':12s}{'estimate':>13s}{'95 % linearised':>29s}{'95 % profile':>29s}"]
        for e in self.estimates:
            row = f"{e.name:12s}{e.value:>13.5g}{self._told(e, e.interval):>29s}"
            rows.append(f"{row}{self._told(e, e.profile):>29s} {self.unit(e.name)}")
        data, times = self.model.data, self.quality.times
        count = f"{data.used.sum()} of {data.used.size} points in contact, {data.free.sum()} free"
        ends = ", ".join(mark.kind for mark in data.ends) or "no end of contact"
        size = "" if math.isnan(times) else f", {times:.2g} × the noise"
        residual = f"residual {self.best.scatter:.3g} {self.unit('level')}{size}"
        rows.append(f"{count}; {ends} used; {residual}")
        rows += self.left_out
        rows += [one.told for one in self.alternatives if not one.doubtful]
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
    alternatives: bool = True,
    depth_range: tuple[float, float] | None = None,
    exclude: Sequence[tuple[float, float]] = (),
) -> Fit:
    """Find the surface energies with which the simulator comes nearest to a measured curve.

    Parameters
    ----------
    scene : Scene
        Layer, indenter and geometry; its surface energies are where the search begins.
    curve : Curve
        Depth of the tip and force as measured. With the stiffness of the machine that holds the
        indenter, the noise of the force is known to be in the depth, too.
    names : sequence of str
        What is fitted: some of w, gamma1, stiffness, offset, opening.
    profiles : bool
        Find the profile intervals, too.
    alternatives : bool
        Compare with simpler models and with the layer's own response.
    depth_range : (float, float), optional
        Depths of the curve [m] between which points are used.
    exclude : sequence of (float, float)
        Intervals of depth [m] in which they are not.

    Returns
    -------
    Fit
        Estimates with intervals, the verdict and the warnings; no intervals where the residual
        is more than noise.

    Raises
    ------
    ValueError
        For too few points in contact, unknown names, or a start at which there is no equilibrium.
    """
    curve, held = in_motion(curve)
    chosen = chosen_points(curve.depth, depth_range, exclude)
    model = Model.of(scene, names, Data.of(curve, chosen))
    left_out = [str(hold) for hold in held]
    if not chosen.all():
        left_out.append(f"{(~chosen).sum()} points outside of the chosen depths are left out")
    best = sought(model)
    condition, weakest, spread = conditioning(best.jac, len(names))
    reach, quality = math.sqrt((best.limit - 1) * best.squares) * spread, _quality(model, best)
    asked = quality.fits, profiles
    own = [_estimate(model, best, i, float(reach[i]), *asked) for i in range(best.x.size)]
    estimates = (*own, *_baseline(model, best, reach, quality.fits))
    others = compared(model, best, reach) if alternatives else ()
    combination = tuple(weakest.tolist())
    states = along(model, best)
    wrong = unsuited(states) or (drifting(model, best) if quality.fits else "")
    said = quality, others, violations(states), wrong, tuple(left_out)
    return Fit(model, best, estimates, condition, combination, *said)


def _quality(model: Model, best: Best) -> Quality:
    data = model.data
    count, free = int(data.used.sum()), int(data.free.sum())
    contact, out, ends = np.split(best.fun, [count, count + free])
    sigma = noise(data.curve.force)
    # no noise is less than what simulated forces are to be trusted to
    least = SIMULATED * data.size if sigma else 0.0
    lone = np.empty(0) if free else data.curve.force[model.apart(best.x)]
    return judged(contact, np.append(out, ends), lone, best.spare, max(sigma, least))


def _baseline(model: Model, best: Best, reaches: Array, fits: bool) -> list[Estimate]:
    """Estimates of the line out of contact; reaches: half-widths of all linearised intervals."""
    found, line = [], model.line(best.x).tolist()
    for name, value, reach in zip(BASELINE, line, reaches[best.x.size :].tolist(), strict=False):
        ends = (value - reach, value + reach) if fits else None
        found.append(Estimate(name, value, ends, None, True, False))
    return found


def _estimate(
    model: Model, best: Best, i: int, reach: float, fits: bool, profiles: bool
) -> Estimate:
    """Estimate and intervals of parameter i; reach: half-width of the linearised interval."""
    x, name, bound = float(best.x[i]), model.names[i], model.on_bound(best.x, i)
    loose = math.inf if name == "offset" else LOOSE  # an offset may have any size
    identifiable = math.isfinite(reach) and reach <= loose and not bound
    interval = profile = None
    if fits and not bound:
        interval = model.value(name, x - reach), model.value(name, x + reach)
        if identifiable and profiles:
            low, high = (_profile_end(model, best, i, side * reach) for side in (-1, 1))
            identifiable = math.isfinite(high - low) and high - low <= 2 * loose
            profile = model.value(name, x + low), model.value(name, x + high)
    return Estimate(name, model.value(name, x), interval, profile, identifiable, bound)


def _profile_end(model: Model, best: Best, i: int, reach: float) -> float:
    """Distance from the fit at which the profile crosses min (1 + t²/(n - m)).

    It is where the root of what the profile exceeds its minimum by, nearly linear, has a value.
    """
    limit = math.sqrt(best.limit - 1)

    @cache
    def beyond(times: float) -> float:
        if not times:
            return -limit
        ratio = profiled(model, best, i, float(best.x[i]) + times * reach)
        root = min(math.sqrt(max(ratio - 1, 0.0)), 10 * limit)
        return 0.0 if abs(root - limit) <= CLOSE * limit else root - limit

    far = 1.0
    while beyond(far) < 0:
        if far == FARTHEST:
            return math.copysign(math.inf, reach)
        grown = 1.1 * limit / max(limit + beyond(far), 0.4 * limit)
        far = min(grown * far, FARTHEST)
    return reach * float(brentq(beyond, 0.0, far))
