"""Is a fitted model right? Its residual against the noise, other models, and its assumptions.

Conventions:

- `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to this
  depth, d positive into the layer.
- A scene has `gamma1` γ₁.
- `NotCertifiedError` is raised where no state passes its own checks.
- A `Model` has coordinates x (m,) and the data, of which `used` are in contact and `free` out of
  it, `sigma` is the noise, `legs` are the motions in one direction, `roots` the roots of weights.
- `Best` is the minimum: `x`, weighted residuals `fun`, derivatives `jac`, and their sum of
  `squares`.
- `sought` finds it and `followed` searches from given coordinates; `hopeless(model, squares)` says
  that a residual is far beyond the noise.
- `scene_with(scene, changes)` changes parameters by name.
"""

import contextlib
import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from discretization import Equilibrium, NotCertifiedError, minimise
from energy import Scene
from energy.arrays import Array
from studies.scenes.fit.disturbances import NORMAL_MEDIAN, OUTLYING
from studies.scenes.fit.force_curve import NO_WEIGHT
from studies.scenes.fit.model import Model, parameters_of, scene_with
from studies.scenes.fit.search import BLUNT, ROUGH, Best, followed, hopeless, sought

TIMES = 2.0  # residual over noise: found between 0.5 and 1.4 where the model is right
RUNS = -3.5  # standard deviations below the mean number of runs: one in 4000 curves of pure noise
ZERO = 4.5  # standard errors that the mean force out of contact may be off zero
NOTICEABLE = 0.5  # residual over noise: below, runs of one sign are numerical errors
CHECK = "check sign, zero and hysteresis"
STRONG = 6.0  # a difference of the information criterion that decides (Kass and Raftery 1995)
KNOWN = 0.3  # half-width of the interval of log w: adhesion that is known so well is needed
NONE = 1e-5  # of the work of adhesion stands for none
WITHIN = 0.1  # relative difference of a parameter between two models that is no doubt
ROUGHLY = 3e-3  # relative gain at which the search for another model ends
STATES = 5  # along the curve, whose assumptions are checked
DRIFTS = 5.0  # standard errors of a drift of the depth that are no chance
THICK = 2.0  # h/a where the layer is as thick as the contact is wide
FAR = 5.0  # times the noise: a point far from the model
FEW = 0.1  # share of points that may be, for the others to fit
FEWEST = 5  # points of unloading whose depths are those of loading, to compare both
APART = 1.0  # times the noise: a mean difference of loading and unloading that matters
SLOWER = "viscoelasticity, since a second work of adhesion is fitted already; measure more slowly"
TWO_WORKS = (
    "viscoelasticity or two works of adhesion. Measured ten times as slowly, a viscoelastic loop "
    "becomes narrower, and its force relaxes in a hold; with two works of adhesion the loop stays, "
    "and after the turn the force first falls along a straight line, while the contact line is "
    "pinned. For two works of adhesion fit opening, too"
)
WITHOUT = {"gamma1": "without surface tension", "w": "without adhesion"}
RESPONSES = {  # as the subject of a sentence, with its verb
    "springs": ("springs", "fit"),
    "layer": ("the layer's own response", "fits"),
}


class Quality(NamedTuple):
    """How the residual of a fit compares with the noise.

    Attributes
    ----------
    times : float
        Standard deviation of the residual over that of the noise; nan if the noise is unknown.
    runs : float
        Number of runs of one sign less what independent noise has, in standard deviations (Wald
        and Wolfowitz 1940).
    zero : float
        Mean force where there is no contact, in standard errors.
    """

    times: float
    runs: float
    zero: float = 0.0

    @property
    def fits(self) -> bool:
        """Whether the residual may be noise, and the force out of contact zero."""
        systematic = self.times > NOTICEABLE and self.runs < RUNS
        return not (self.times > TIMES or systematic or abs(self.zero) > ZERO)

    @property
    def size(self) -> str:
        """How large the residual is against the noise, in words; "" if that is unknown."""
        if math.isnan(self.times):
            return ""
        if self.times >= NOTICEABLE:
            return f", {self.times:#.2g} times the noise"
        return (
            ". These smooth data show no noise: the intervals are those of the numerical error of "
            "the simulated forces"
        )

    @property
    def message(self) -> str:
        """What is wrong, in words; "" if nothing is."""
        if math.isnan(self.times):
            return (
                "the noise cannot be estimated from so few points, and without it nobody can judge "
                "the fit"
            )
        if self.fits:
            return ""
        size = f"residual is {self.times:.3g} times the noise"
        why = CHECK
        if self.times <= TIMES and abs(self.zero) > ZERO:
            why = f"check zero: the force out of contact is {self.zero:+.2g} standard errors off"
        elif self.times <= TIMES:
            size += " and keeps its sign over many points"
        return f"{size}: {why}; or the data were smoothed. No intervals: the model does not fit"


def quality_of(forces: Array, ends: Array, free: Array, spare: int, noise: float) -> Quality:
    """Quality of a fit from its residuals.

    times² = Σr²/(spare noise²) over residuals of both kinds; zero = mean of `free` √m/noise.

    Parameters
    ----------
    forces : ndarray (n,)
        Residuals of the force in contact [N/m, or N around an axis].
    ends : ndarray (k,)
        Residuals of the ends of contact, as forces: standard deviations times the noise.
    free : ndarray (m,)
        Forces where there is no contact.
    spare : int
        Number of residuals less that of fitted parameters.
    noise : float
        Standard deviation of the force; 0: it is unknown.

    Returns
    -------
    Quality
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
    n = signs.size
    above = int((signs > 0).sum())
    if above in (0, n):
        return -math.sqrt(n)  # one run: its limit for many points of both signs
    mean = 1 + 2 * above * (n - above) / n
    variance = max((mean - 1) * (mean - 2) / (n - 1), 1e-3)
    return float((1 + np.count_nonzero(np.diff(signs)) - mean) / math.sqrt(variance))


def criterion(best: Best) -> float:
    """Schwarz's criterion n log(Σr²/n) + m log n of a fit of m parameters to n residuals."""
    n, m = best.jac.shape
    return float(n * math.log(best.squares / n) + m * math.log(n))


@dataclass(frozen=True)
class Alternative:
    """Another model of the same curve.

    Attributes
    ----------
    name : str
        Of the parameter left out, or the response of the layer.
    better : float
        By how much its criterion (BIC) is lower than that of the fit.
    values : dict of str to float
        The energies that it finds.
    off : dict of str to float
        Relative difference of those of the fit from these.
    """

    name: str
    better: float
    values: dict[str, float]
    off: dict[str, float]

    @property
    def simpler(self) -> bool:
        """Whether it lacks a parameter."""
        return self.name in WITHOUT

    @property
    def preferred(self) -> bool:
        """Whether it describes the data better."""
        return self.better > (0 if self.simpler else STRONG)

    @property
    def doubtful(self) -> bool:
        """Whether it makes the fit doubtful."""
        differs = max(map(abs, self.off.values()), default=0.0) > WITHIN
        return self.preferred or (not self.simpler and self.better > -STRONG and differs)

    @property
    def message(self) -> str:
        """What the comparison says, in a sentence; ΔBIC is that of this model less the fit's."""
        found = ", ".join(f"{name} = {value:.4g}" for name, value in self.values.items())
        difference = f"ΔBIC = {-self.better:.3g}"
        if self.simpler:
            if not self.preferred:
                without = WITHOUT[self.name]
                return f"{self.name} is needed: {without} the fit is worse ({difference})"
            text = f"{self.name} is not needed: {WITHOUT[self.name]} the fit is at least as good"
            return f"{text} ({difference})" + (f", with {found}" if found else "")
        own, fits = RESPONSES["springs" if self.name == "layer" else "layer"]
        other, other_fits = RESPONSES[self.name]
        if not self.doubtful:
            return f"{own} {fits} at least as well as {other} ({difference})"
        off = " and ".join(f"{value:+.0%} in {name}" for name, value in self.off.items())
        result = f"({difference}), with {found}; this fit differs from that by {off}"
        if self.preferred:
            remedy = f'set response = "{self.name}" in the scene'
            return f"{other} {other_fits} better {result}: {remedy}"
        return f"{other} {other_fits} as well {result}: these data do not decide between them"


def compared(model: Model, best: Best, reaches: Array) -> tuple[Alternative, ...]:
    """The models without tension, without adhesion and with the layer's own response.

    Parameters
    ----------
    model : Model
    best : Best
        Its minimum.
    reaches : ndarray (m,)
        Half-widths of the intervals. Adhesion that is well known is needed, and not left out.

    Returns
    -------
    tuple of Alternative
    """
    lost = hopeless(model, best.squares)
    at = parameters_of(model.scene) if lost else model.parameters(best.x)
    known_adhesion = "w" in model.fitted and reaches[model.fitted.index("w")] < KNOWN
    found = []
    for name, (scene, free) in _other_models(model, at, known_adhesion).items():
        with contextlib.suppress(ValueError, NotCertifiedError):  # this scene has no such model
            other = Model.of(scene, free, model.data, None if lost else at["offset"])
            nearest = sought(other, ROUGHLY) if lost else _beside(other)
            found.append(_alternative(name, model, best, other, nearest))
    return tuple(found)


def _other_models(
    model: Model, at: dict[str, float], known_adhesion: bool
) -> dict[str, tuple[Scene, list[str]]]:
    """Scenes of other models near the parameters `at`, and what is fitted of each."""
    names = list(model.fitted)
    uncertain = [name for name, _ in model.data.known]  # known at the value of the scene
    at = {name: value for name, value in at.items() if name not in uncertain}
    scene = scene_with(model.scene, at)
    found = {}
    if "gamma1" in names and not scene.layer.exact:
        without_tension = scene_with(scene, at | {"gamma1": 0.0})
        found["gamma1"] = without_tension, [name for name in names if name != "gamma1"]
    if "w" in names and not known_adhesion:
        without_adhesion = scene_with(scene, at | {"w": NONE * at["w"], "opening": 0.0})
        found["w"] = without_adhesion, [name for name in names if name not in ("w", "opening")]
    response = "springs" if scene.layer.exact else "layer"
    found[response] = replace(scene, layer=replace(scene.layer, response=response)), names
    return found


def _beside(model: Model) -> Best:
    """The minimum beside the start."""
    rough = replace(model, blunt=BLUNT[-1] * model.blunt)
    x = followed(rough, np.zeros(len(model.names)), ftol=ROUGH).x
    return followed(model, x, ftol=ROUGHLY)


def _alternative(name: str, model: Model, best: Best, other: Model, found: Best) -> Alternative:
    """What another model, with its own minimum `found`, says beside the fitted one with `best`.

    Its gain is the difference of the criteria; energies are compared with those of the fit.
    """
    at = model.parameters(best.x)
    own = other.parameters(found.x)
    values = {one: own[one] for one in other.names if one in ("w", "gamma1")}
    off = {one: at[one] / value - 1 for one, value in values.items()}
    return Alternative(name, criterion(best) - criterion(found), values, off)


def along(model: Model, best: Best) -> list[Equilibrium]:
    """Some states of the fitted curve, from its shallowest points to its deepest one."""
    p = model.parameters(best.x)
    data = model.data
    scene = replace(scene_with(model.scene, p), opening=None)
    force, _ = model.forces(best.x)
    own = data.curve.drive - p["offset"] - force / data.curve.machine_stiffness
    shallow, deep = np.quantile(own[data.used], (0.02, 1.0)).tolist()
    states = []
    for depth in np.linspace(shallow, deep, STATES).tolist():
        # where the path has let go, or where it needs more than one contact, there is none
        with contextlib.suppress(ValueError, NotCertifiedError):
            states.append(minimise(scene, depth, rtol=1e-5))
    return states


def unsuited(states: Sequence[Equilibrium]) -> str:
    """Why springs are no model of this curve, however well they fit it; "" if nothing says so.

    They need h ≪ a; where the layer is thicker than every contact is wide, the reverse is true.
    """
    ratios = [one.value for state in states for one in state.validity if one.name == "h/a"]
    least = min(ratios, default=0.0)
    if least <= THICK:
        return ""
    text = f"h/a is {least:.3g} or more along the whole curve, and springs need h much less than a"
    return f'{text}: whatever the residual, fit with response = "layer" in the scene'


def hysteresis(model: Model, best: Best) -> str:
    """What a difference of unloading from loading may be; "" if jumps explain it.

    At the same position of the machine the residuals of both are compared, those of the first
    loading and unloading that have positions in common.
    """
    data = model.data
    if model.scene.gamma1 == 0:  # whose springs make a loop themselves
        return ""
    residuals = np.zeros(data.used.size)
    residuals[data.used] = -(best.fun / data.roots)[: data.used.sum()]
    for contact in data.contacts:
        for into, out in pairwise(leg.points for leg in contact.legs):
            if into.size < FEWEST or out.size < FEWEST:
                continue
            order = into[np.argsort(data.curve.drive[into])]
            known = data.curve.drive[order]
            common = out[(data.curve.drive[out] >= known[0]) & (data.curve.drive[out] <= known[-1])]
            if common.size < FEWEST:
                continue
            before = np.interp(data.curve.drive[common], known, residuals[order])
            off = float(np.median(residuals[common] - before))
            if abs(off) > max(APART, DRIFTS * math.sqrt(2 / common.size)) * data.sigma:
                times = abs(off) / data.sigma
                return (
                    f"unloading differs from loading by {off:.2g} N{model.scene.per_length}, the "
                    f"median at the same positions, which is {times:.2g} times the noise and more "
                    f"than jumps explain: {TWO_WORKS if 'opening' not in model.names else SLOWER}"
                )
    return ""


def outlier_dependence(model: Model, best: Best, reaches: Array) -> str:
    """What to say if the result depends on points far from the fit; "" if it does not.

    Without them the parameters are sought anew. reaches: half-widths of the
    linearised intervals, by which none of them may move.
    """
    residuals = np.abs(best.fun / model.data.roots)
    far = (residuals > OUTLYING * model.data.sigma) & (model.data.roots > NO_WEIGHT)
    far[model.data.points.size :] = False
    if not far.any():
        return ""
    roots = np.where(far | (model.data.roots <= NO_WEIGHT), NO_WEIGHT, 1.0)
    without = replace(model, data=model.data.with_roots(roots))
    moved = np.abs(sought(without, ftol=ROUGHLY).x - best.x) > reaches[: best.x.size]
    if not moved.any():
        return ""
    names = " and ".join(name for name, one in zip(model.names, moved, strict=True) if one)
    return (
        f"the result depends on {far.sum()} points far from the fit: without them {names} would "
        "lie outside of the intervals; look at these points and exclude the wrong ones (--exclude)"
    )


def outlier_remedy(model: Model, best: Best) -> str:
    """What to do where few points are far from the model; "" if that is not so."""
    if (model.data.roots != 1).any():  # a robust loss already
        return ""
    off = np.abs(best.fun) / model.data.sigma
    usual = float(np.median(off)) / NORMAL_MEDIAN
    far = int(np.count_nonzero(off > FAR * max(usual, 1.0)))
    if usual > TIMES or not 0 < far <= FEW * off.size:
        return ""
    return (
        f"{far} points are far from the model and the others are not: try the robust loss "
        "(--loss soft_l1), or exclude these points (--exclude)"
    )


def depth_drift(model: Model, best: Best) -> str:
    """What to check if the zero of the depth moved during the measurement; "" if it did not.

    To first order the residual then is a multiple of the offset's column of the Jacobian times the
    share of the points measured before, as far as that is not fitted by something else.
    """
    if "offset" not in model.names:
        return ""
    data = model.data
    order = np.linspace(0.0, 1.0, model.data.used.size)
    used = order[data.used]
    ends = [used[0 if mark.kind == "touch" else -1] for mark in data.ends]
    shares = [*used, *order[data.free], *ends, *(0.0 for _ in data.known)]
    moved = best.jac[:, model.names.index("offset")] * shares
    beside = moved - best.jac @ np.linalg.lstsq(best.jac, moved, rcond=None)[0]
    size = float(beside @ beside)
    drift = abs(float(beside @ best.fun))
    if drift <= DRIFTS * best.scatter * math.sqrt(size):
        return ""
    return (
        f"the zero of the depth seems to move by {drift / size * data.span:.2g} m during the "
        "measurement: check drift and hysteresis (fit opening where loading and unloading differ)"
    )
