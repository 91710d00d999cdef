"""Estimates of surface energies from a measured curve, their intervals, and what stays open.

Conventions:

- A scene has `work_of_adhesion` w.
- `Data` is a curve with masks (n,) of its points: `used` are in contact, `free` out of it.
- A `Model` turns coordinates x (m,), logarithms of parameters over those of its scene, into forces;
  `Best` is the minimum: `x`, weighted residuals `fun` (n,), their derivatives `jac`, `squares`, the
  sum Σr², `spare` = n - m, and the sum at the ends of a profile interval over the least, `limit`.
- `sought(model)` finds it, `profiled(model, best, i, at)` is the least sum with coordinate i at a
  value, over `squares`; `spreads` are standard deviations for a unit of noise, and `conditioning`
  the condition number with the weakest combination.
- `checked`, `in_motion` and `chosen_points` prepare the curve; those from verdict.py judge the fit,
  in words.
"""

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from typing import NamedTuple

import numpy as np
from scipy.optimize import brentq

from energy import Assumption, Scene
from energy.arrays import Array, Mask
from energy.checks import option, positive
from studies.scenes.fit.disturbances import OUTLYING, noise
from studies.scenes.fit.force_curve import (
    BASELINE,
    Curve,
    Data,
    checked,
    chosen_points,
    in_motion,
    position_is_height,
)
from studies.scenes.fit.model import DEFAULT, UNCERTAIN, Model, parameters_of, scene_with
from studies.scenes.fit.search import (
    SIMULATED,
    Best,
    conditioning,
    profiled,
    robust,
    sought,
    spreads,
)
from studies.scenes.fit.verdict import (
    Alternative,
    Quality,
    along,
    compared,
    depth_drift,
    hysteresis,
    outlier_dependence,
    outlier_remedy,
    quality_of,
    unsuited,
)
from studies.scenes.run import violations

UNITS = {
    **{"w": "J/m²", "gamma1": "J/m²", "opening": "J/m²", "offset": "m"},
    **{"stiffness": "Pa/m", "E": "Pa", "R": "m", "h": "m"},
}
OF_TENSION = ("2w/γ₁", "noise slope/√(2w/γ₁)", "slope")  # assumptions of the angle of a meniscus
NOT_FITTED = "gamma1 is not fitted, which takes a start from gamma1 > 0"
JKR_TENSION = 0.01  # of w, in place of no tension on a layer
LOSSES = ("linear", "soft_l1")
LOOSE = 1.0  # half-width of the interval of a logarithm above which nothing is identified
CONDITION = 100.0  # condition number from which the weakest combination is named
NEGLIGIBLE = 0.05  # coefficient of a combination that is not shown
CUT_OFF = 10.0  # times that at the end: a root of the gain that is only known to be larger
CLOSE = 0.02  # of its distance: how well the end of a profile interval is found
FARTHEST = 20.0  # half-widths of the linearised interval
ELSEWHERE = "start from other parameters, or leave it out of --parameters"
OPEN = (
    "its interval is wider than a factor e; set it in the scene and leave it out of --parameters, "
    "or measure up to the detachment"
)
Interval = tuple[float, float]


class Estimate(NamedTuple):
    """A parameter with its intervals.

    Attributes
    ----------
    name : str
    value : float
    interval : (float, float) or None
        Linearised, at 95 %; None where the model does not fit, and on a bound.
    profile : (float, float) or None
        From the profile of the sum of squares, at 95 %; None also where it was not computed, and
        for a parameter that is not identifiable.
    identifiable : bool
        Whether the interval spans at most a factor e to either side.
    bound : bool
        Whether the value is the bound of the search, and so no estimate.
    """

    name: str
    value: float
    interval: Interval | None
    profile: Interval | None
    identifiable: bool
    bound: bool


@dataclass(frozen=True)
class Fit:
    """A finished fit of a measured curve, as `fit` gives it; `str` is its report.

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
    def scatter(self) -> float:
        """Standard deviation of the residual [N/m, or N around an axis]."""
        return math.sqrt(float(self.best.fun @ self.best.fun) / self.best.spare)

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
        others = [one.message for one in self.alternatives if one.doubtful]
        return tuple(one for one in (self.quality.message, self.unsuited, *others) if one)

    @property
    def warnings(self) -> tuple[str, ...]:
        """The doubts, what the data do not determine, and assumptions that do not hold."""
        found = list(self.doubts)
        for e in self.estimates:
            if e.bound:
                value = f"{e.name} = {e.value:.3g} {self.unit(e.name)}"
                found.append(f"{value} is the bound of the search, no estimate: {ELSEWHERE}")
            elif not e.identifiable and e.name not in self.needless:
                found.append(f"{e.name} is not identifiable from this curve: {OPEN}")
        if self.condition > CONDITION:
            condition = f"(condition number {self.condition:.2g})"
            found.append(f"{self.weakest} is poorly constrained by this curve {condition}")
        found += [f"{one}; worst at d = {depth:.3g} m" for one, depth in self.strained]
        return tuple(found)

    @property
    def weakest(self) -> str:
        """The combination of parameters that the data constrain least, in words."""
        terms = zip(self.combination, self.model.fitted, strict=True)
        shown = [(share, name) for share, name in terms if abs(share) > NEGLIGIBLE]
        if len(shown) == 1:
            return shown[0][1]
        text = " ".join(f"{share:+.2f} log {name}" for share, name in shown)
        return "the combination " + text.replace("log offset", "offset/range")

    def unit(self, name: str) -> str:
        """The unit of a parameter."""
        force = f"N{self.model.scene.per_length}"
        return UNITS.get(name) or {"slope": f"{force} per m"}.get(name, force)

    def __str__(self) -> str:
        """The report: a table of the parameters, what was used, and the warnings."""
        rows = [f"{'parameter':12s}{'estimate':>13s}{'95 % linearised':>29s}{'95 % profile':>29s}"]
        for e in self.estimates:
            digits = _digits(e.interval)
            row = f"{e.name:12s}{e.value:>13.{digits}g} {self._interval_text(e, e.interval):>28s}"
            rows.append(f"{row} {self._interval_text(e, e.profile):>28s} {self.unit(e.name)}")
        data = self.model.data
        count = f"{data.used.sum()} of {data.used.size} points in contact, {data.free.sum()} free"
        ends = ", ".join(mark.kind for mark in data.ends) or "no end of contact"
        residual = f"residual {self.scatter:.3g} {self.unit('level')}{self.quality.size}"
        rows.append(f"{count}; {ends} used; {residual}")
        rows += self.left_out
        rows += [one.message for one in self.alternatives if not one.doubtful]
        return "\n".join([*rows, *(f"WARNING: {text}" for text in self.warnings)])

    def _interval_text(self, estimate: Estimate, interval: Interval | None) -> str:
        """An interval in the table, or in words why there is none."""
        if interval is not None:
            low, high = interval
            return f"[{low:.{_digits(interval)}g}, {high:.{_digits(interval)}g}]"
        if estimate.bound:
            return "bound of the search"
        if not self.quality.fits:
            return "withheld"
        return "not computed" if estimate.identifiable else "unbounded"


def _digits(interval: Interval | None) -> int:
    """Digits that distinguish the ends of an interval, 5 to 9."""
    if interval is None or not 0 < interval[1] - interval[0] < math.inf:
        return 5
    size = max(map(abs, interval)) / (interval[1] - interval[0])
    return min(max(math.ceil(math.log10(size)) + 2, 5), 9)


def fit(
    scene: Scene,
    curve: Curve,
    names: Sequence[str] = DEFAULT,
    *,
    profiles: bool = True,
    alternatives: bool = True,
    depth_range: tuple[float, float] | None = None,
    exclude: Sequence[tuple[float, float]] = (),
    loss: str = "linear",
    uncertainties: Mapping[str, float] | None = None,
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
        What is fitted: some of w, gamma1, stiffness or E, offset, opening. gamma1 is left out, and
        that is said, where the scene has none.
    profiles : bool
        Find the profile intervals, too.
    alternatives : bool
        Compare with simpler models and with the layer's own response.
    depth_range : (float, float), optional
        Depths of the curve [m] between which points are used.
    exclude : sequence of (float, float)
        Intervals of depth [m] in which they are not.
    loss : {"linear", "soft_l1"}
        What is minimised of the residuals r: Σr², or the loss soft_l1 of scipy.optimize,
        Σ 2c² (√(1 + r²/c²) - 1) with c twice the noise, which single points hardly move; up to
        three in a row that are then farther off than six times the noise are left out.
    uncertainties : mapping of str to float, optional
        Relative standard uncertainties of R or h of the scene. They are fitted with the rest, with
        the value of the scene as one more measurement, so that all intervals have them in them.

    Returns
    -------
    Fit
        Estimates with intervals, the verdict and the warnings; no intervals where the residual
        is more than noise.

    Raises
    ------
    ValueError
        For numbers that are no curve, too few points in contact, unknown names, or a start at
        which there is no equilibrium.

    Examples
    --------
    A sphere on a film, simulated with w = 1e-4 and γ₁ = 0.03 J/m²:

    >>> from pathlib import Path
    >>> import studies
    >>> from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
    >>> film = ElasticLayer(E=30e3, nu=0.45, h=0.3e-6)
    >>> start = SurfaceEnergies.from_work(gamma1=0.02, w=5e-5)
    >>> scene = Scene(film, start, Parabola(R=5e-6), geometry="axisymmetric")
    >>> path = Path(studies.__file__).parent / "scenes" / "sphere_curve.csv"
    >>> curve = studies.read_curve(path, studies.Reading(width=1.0, spring_constant=0.08))
    >>> found = studies.fit(scene, curve, profiles=False, alternatives=False)
    >>> low, high = found["gamma1"].interval
    >>> low < 0.03 < high
    True
    """
    option("loss", loss, LOSSES)
    curve = checked(curve)
    without_tension = scene.gamma1 == 0
    scene, names, notes = _without_tension(scene, tuple(names))
    known = _known(scene, uncertainties or {})
    if position_is_height(curve.drive, curve.force):
        raise ValueError(
            "curve: the depth falls where the indenter is pressed, so that it is a height above "
            "the layer; give its negative"
        )
    curve, held = in_motion(curve)
    chosen = chosen_points(curve.depth, depth_range, exclude)
    model = Model.of(scene, names, Data.of(curve, chosen, known))
    if loss == "soft_l1":
        model, best = robust(model)
    else:
        best = sought(model)
    notes += (*curve.notes, *map(str, held), *_disturbances(model.data))
    if not chosen.all():
        notes += (f"left out: {(~chosen).sum()} points outside of the chosen depths",)
    condition, weakest = conditioning(best.jac, len(names))
    reach = math.sqrt((best.limit - 1) * best.squares) * spreads(best.jac, len(names))
    quality = _quality(model, best)
    own = [
        _estimate(model, best, i, float(reach[i]), quality.fits, profiles)
        for i in range(best.x.size)
    ]
    estimates = (*own, *_baseline(model, best, reach, quality.fits))
    others = compared(model, best, reach) if alternatives else ()
    combination = tuple(weakest.tolist())
    states = along(model, best)
    wrong = unsuited(states)
    if quality.fits:
        wrong = wrong or outlier_dependence(model, best, reach) or depth_drift(model, best)
    else:
        wrong = wrong or hysteresis(model, best) or outlier_remedy(model, best)
    strained = violations(states)
    if without_tension:
        strained = tuple(one for one in strained if one[0].name not in OF_TENSION)
    return Fit(
        model=model,
        best=best,
        estimates=estimates,
        condition=condition,
        combination=combination,
        quality=quality,
        alternatives=others,
        strained=strained,
        unsuited=wrong,
        left_out=notes,
    )


def _without_tension(
    scene: Scene, names: tuple[str, ...]
) -> tuple[Scene, tuple[str, ...], tuple[str, ...]]:
    """Scene and parameters to fit where there may be no surface tension, and what to say of that.

    Springs do without. The response of a layer needs some tension: JKR_TENSION is that of JKR but
    for 0.03 % of the pull-off force.
    """
    if scene.gamma1 > 0:
        return scene, names, ()
    others = tuple(name for name in names if name != "gamma1")
    if not scene.layer.exact:
        text = "independent springs without surface tension, which detach one by one"
        return scene, others, (f"gamma1 = 0 in the scene: {text}; {NOT_FITTED}",)
    gamma1 = JKR_TENSION * scene.work_of_adhesion
    text = (
        f"gamma1 = 0 in the scene: a bonded layer without surface tension, the theory of Johnson, "
        f"Kendall and Roberts (JKR) where it is thick, computed with gamma1 = {gamma1:.3g} J/m², "
        f"which is too small to be felt; {NOT_FITTED}"
    )
    return scene_with(scene, {"gamma1": gamma1}), others, (text,)


def _known(scene: Scene, uncertainties: Mapping[str, float]) -> tuple[tuple[str, float], ...]:
    """What is known with a relative standard uncertainty. ValueError for what cannot be."""
    for name, relative in uncertainties.items():
        option("uncertainties", name, UNCERTAIN)
        positive(f"uncertainties[{name!r}]", relative)
        if name not in parameters_of(scene):
            raise ValueError(
                f"uncertainties = {dict(uncertainties)!r}: {type(scene.indenter).__name__} has no "
                f"{name}; leave it out"
            )
    return tuple(uncertainties.items())


def _disturbances(data: Data) -> tuple[str, ...]:
    """Spikes, points far from the fit and interference, in words."""
    found = [
        *_left_out(data, data.spikes, "off their neighbours"),
        *_left_out(data, data.outliers, f"more than {OUTLYING:.0f} times the noise from the fit"),
    ]
    if data.wave:
        period = f"a period of {1 / data.wave:.3g} m"
        found.append(f"the force out of contact has waves, as interference has, with {period}")
    return tuple(found)


def _left_out(data: Data, points: Mask, reason: str) -> list[str]:
    """How many points (n,) are left out, and where; nothing if there are none."""
    if not points.any():
        return []
    first = float(data.curve.depth[int(np.argmax(points))])
    count = "1 point" if points.sum() == 1 else f"{points.sum()} points"
    return [f"left out: {count}, {reason}, the first at d = {first:.4g} m"]


def _quality(model: Model, best: Best) -> Quality:
    """The quality of a fit, from residuals whose points far out count as in the robust loss."""
    data = model.data
    residuals = best.fun * data.roots
    in_contact, others = np.split(residuals, [int(data.used.sum())])
    sigma = 0.0
    if noise(data.curve.force):
        sigma = max(data.sigma, SIMULATED * data.size)  # simulated forces are no better
    out_of_contact = np.empty(0)
    if not data.free.any():  # no line there is fitted, and the force should be zero
        out_of_contact = data.curve.force[model.without_contact(best.x)]
    return quality_of(in_contact, others, out_of_contact, best.spare, sigma)


def _baseline(model: Model, best: Best, reaches: Array, fits: bool) -> list[Estimate]:
    """Estimates of the line out of contact; reaches: half-widths of all linearised intervals."""
    found = []
    line = model.line(best.x).tolist()
    for name, value, reach in zip(BASELINE, line, reaches[best.x.size :].tolist(), strict=False):
        ends = (value - reach, value + reach) if fits else None
        found.append(Estimate(name, value, ends, None, True, False))
    return found


def _estimate(
    model: Model, best: Best, i: int, reach: float, fits: bool, profiles: bool
) -> Estimate:
    """Estimate and intervals of parameter i; reach: half-width of the linearised interval."""
    x = float(best.x[i])
    name = model.names[i]
    bound = model.on_bound(best.x, i)
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
        """Root of the gain of the sum of squares less that at the end: negative inside.

        times: half-widths of the linearised interval from the value, to either side. The profile is
        parabolic near the value, so that its root is nearly straight. It is cut off where it is far
        outside, and 0 where it is CLOSE enough.
        """
        if not times:
            return -limit
        ratio = profiled(model, best, i, float(best.x[i]) + times * reach)
        root = min(math.sqrt(max(ratio - 1, 0.0)), CUT_OFF * limit)
        return 0.0 if abs(root - limit) <= CLOSE * limit else root - limit

    far = 1.0
    while beyond(far) < 0:
        if far == FARTHEST:
            return math.copysign(math.inf, reach)
        grown = 1.1 * limit / max(limit + beyond(far), 0.4 * limit)
        far = min(grown * far, FARTHEST)
    return reach * float(brentq(beyond, 0.0, far))
