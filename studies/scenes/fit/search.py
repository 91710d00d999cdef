"""Least squares on the simulator: the nearest parameters, and how well they are conditioned.

Conventions:

- A `Model` has coordinates x (m,) with these `names`: logarithms of parameters over those of its
  scene, and for "offset" (offset - zero)/(range of the drives in contact). `coordinates` are arrays
  (m,): `limit` is the largest |x| of each, `step` the longest reach (inf for the offset), and
  `difference` the step of difference quotients.
- `residuals(x)` (n,) are forces less measured ones, times the roots of their weights, less the line
  out of contact (q coefficients) that is nearest to them at x; nan where there are no equilibria.
  `jacobian(x)` (n, m + q) are the derivatives without that line, and those by its coefficients.
  `near(x)` is the model whose branches follow their rates at x; `blunt` is the length of the
  straight ends of branches.
- `model.data`: residuals are in the order of the points in contact, those out of it, the ends of
  contact and what is known beside the curve, these last ones in units of the noise times `sigma`.
  `points` are the indices in the curve of the first two kinds, `used` is the mask of the points in
  contact among all. `roots` (n,) are roots of weights, NO_WEIGHT = 1e-6 and not 0 for what is left
  out, so that residuals over roots are those without weights. `lines` (n, q) has a row for each
  residual. `sigma` is the noise of a force, `size` the largest force in contact.
- `data.with_roots(roots)` is the data with other roots, `data.roots_without(out)` are 1 but for the
  points (mask of the curve) that are left out and for ends of contact beside these.
  `data.reweighted(r, out)` has these times the roots of the weights 1/√(1 + r²/c²), c = 2 σ, of the
  loss soft_l1 at unweighted residuals r of forces.
- WIDEST_SPIKE is in points, NORMAL_MEDIAN the median of |x| of a normal variable x of unit
  deviation, OUTLYING = 6 times the noise.
"""

import math
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from scipy import optimize
from scipy.special import stdtrit

from energy.arrays import Array, Mask
from studies.scenes.fit.disturbances import NORMAL_MEDIAN, OUTLYING, WIDEST_SPIKE
from studies.scenes.fit.model import Model

# Numbers of searches were halved and doubled in fits of eight curves, number 1 of the kinds spike,
# offset, k_c = 0.03, drift, no tension, layer, hysteresis and interference of trials.py, without
# profiles (half of these fit), and of CHORDS, ENOUGH and AGAIN in four with profiles (number 1 of
# offset, k_c = 0.03 and spike, 2 of baseline). "By 0.01" is a change of a parameter by 0.01 of half
# its interval. At k_c = 0.03 searches end at several places whose sums of squares are less than 1 %
# apart.
# Straight ends of branches in the first searches, over those of the model: halved, the curve
# without tension ends at twice the sum of squares; doubled, parameters of two curves change by up
# to 1.8, for sums of squares up to 0.8 % larger.
BLUNT = 100.0, 10.0
FINE = 1e-6  # relative gain of the sum of squares at which a search ends: either way by 0.004
ROUGH = 1e-2  # the same with straight ends, and where the residual is HOPELESS: by 1e-5
# Residual over noise where small gains are of no use, as noise explains 1.5 at most (LOOSE in
# disturbances.py). Halved by 0.004, for 13 % more time; doubled by 0.3, for 13 % less, of a curve
# that the model does not fit.
HOPELESS = 4.0
# Logarithm of a parameter over its start, so a factor 7, beyond which the start is tried again;
# 1 or 4 by 0.
ASTRAY = 2.0
# Error of simulated forces, relative to the largest, with RTOL = 1e-4 of the paths in branches.py;
# halved or doubled, ends of profiles by 0.006.
SIMULATED = 1e-6
STEPS = 25  # at most, of a search with known branches
SOLVED = 1e-7  # relative gain at which it ends, a tenth of FINE: by 0.002
# Over the largest force: so small, residuals do not hold back scipy's first step (see `minimum`).
# The curve of k_c = 0.03 ends elsewhere either way, by 0.6 for 0.07 % of its sum of squares, the
# others by less than 0.01.
UNBOUND = 1e6
ROUNDS = 15  # places at most at which branches are followed
# The trust region of Nocedal and Wright 2006, algorithm 4.1: a quarter, three quarters, and twice.
# With SHORTER 0.125 or 0.5 one curve of eight, that of k_c = 0.03, changes by 0.007 and 0.2.
SHORTER = 0.25  # times the reach, after a step that gains nothing
FAIR = 0.75  # of the promised gain, above which the reach grows
SHORTEST = 1e-3  # reach below which a search does not go on: the stride of difference quotients
# Steps at most with the Jacobian of the fit. With 2 profiles take 27 % more time, as more of them
# need a search, with 8 17 % less; their ends move by 0.02 and 0.07.
CHORDS = 4
# Relative difference of the sums of squares of two such steps that have converged: by 0.004.
ENOUGH = 1e-3
DEAD = 1e-5  # length of a column that is numerical error, over that of the longest
CONFIDENCE = 0.95  # of all intervals: the one that most papers state
TURNS = 20  # of weights and minima in turn at most, and of outliers and minima: 10 or 40 by 0
SETTLED = 0.01  # deviations by which a last turn may change a coordinate: 0.005 of half an interval
ROUNDING = 1e-10  # of a force, relative to the largest, far below SIMULATED; half and twice by 0
# Of the way to the edge of the reach: scipy stops at 0.995 of it or later; 0.98 and 0.995 by 0.
AT_EDGE = 0.99
AGAIN = 1e-4  # relative gain at which a search for a profile ends, a tenth of ENOUGH: by 0.06
LOST = 1e-9  # length of a column beside the line that is rounding, over that of the column itself


class Best(NamedTuple):
    """A minimum of the sum of squares.

    Attributes
    ----------
    x : ndarray (m,)
        Coordinates.
    fun : ndarray (n,)
        Weighted residuals r.
    jac : ndarray (n, m + q)
        Their derivatives by the coordinates and by the line out of contact.
    squares : float
        Σ(r² + e²), e the error of simulated forces. Points that are left out count in n; their r
        is next to 0.
    widening : float
        Variances of a robust fit over those that its weighted squares suggest.
    """

    x: Array
    fun: Array
    jac: Array
    squares: float
    widening: float = 1.0

    @property
    def spare(self) -> int:
        """By how many the residuals exceed what is fitted."""
        return self.jac.shape[0] - self.jac.shape[1]

    @property
    def scatter(self) -> float:
        """s = √(Σ(r² + e²)/(n - m - q)); e keeps it from 0 for a simulated curve without noise."""
        return math.sqrt(self.squares / self.spare)

    @property
    def limit(self) -> float:
        """Sum of squares over the least at the ends of a profile interval: 1 + t²/(n - m - q).

        t² times the widening for a robust fit. t is of Student's distribution at CONFIDENCE.
        """
        t = float(stdtrit(self.spare, 0.5 + CONFIDENCE / 2))
        return 1 + self.widening * t**2 / self.spare


def sought(model: Model, ftol: float = FINE) -> Best:
    """The lowest minimum that searches from the start of the model find.

    At the end of a branch the force may vary as a root, along whose slope steps from far off lead
    nowhere. So the first searches have branches with straight ends. These may lead a parameter that
    they constrain poorly far away; then a search with its start value follows. The offset is no
    logarithm, and as a length within the range of the data it does not go far.
    """
    start = x = np.zeros(len(model.names))
    for times in BLUNT:
        x = followed(replace(model, blunt=times * model.blunt), x, ftol=ROUGH).x
    found = followed(model, x, ftol=ftol)
    if hopeless(model, found.squares):
        return min(found, followed(model, start, ftol=ftol), key=lambda one: one.squares)
    logarithms = np.array([name != "offset" for name in model.names])
    far = logarithms & (np.abs(found.x) > ASTRAY)
    back = np.where(far, start, found.x)
    if far.any() and np.isfinite(model.residuals(back)).all():
        return min(found, followed(model, back, ftol=ftol), key=lambda one: one.squares)
    return found


def robust(model: Model) -> tuple[Model, Best]:
    """The minimum with the loss soft_l1, and the model with its weights.

    Spikes that this minimum shows are left out, and a minimum without them is sought, if that is
    the better one by a loss that no point raises by more than OUTLYING² noise².
    """
    none = np.zeros(model.data.used.size, bool)
    first, best = _reweighted(model, sought(model), none)
    outliers = _outliers(first, best)
    if not outliers.any():
        return first, best
    bare, start, outliers = _without_outliers(model, outliers)
    within_window = np.convolve(outliers, np.ones(WIDEST_SPIKE + 1), mode="valid")
    if within_window.max() > WIDEST_SPIKE:  # so many in a row are no spike
        return first, best
    second, other = _reweighted(bare, start, outliers)
    if _bounded_loss(second, other) < _bounded_loss(first, best):
        return second, other
    return first, best


def _reweighted(model: Model, best: Best, outliers: Mask) -> tuple[Model, Best]:
    """The minimum with the loss soft_l1 without outliers (n,), from a minimum without this loss.

    Weights at the residuals of a minimum, and a minimum with these weights, in turn until no
    coordinate changes by more than SETTLED of its standard deviation. The second search begins
    anew: without weights, what is spoilt may have led the first one astray. Coordinates that no
    residual depends on have no deviation, and are not waited for.
    """
    for turn in range(TURNS):
        before = best
        data = model.data.reweighted(best.fun / model.data.roots, outliers)
        model = replace(model, data=data)
        best = followed(model, best.x) if turn else sought(model)
        spread = spreads(best.jac, best.x.size)[: best.x.size]
        known = np.isfinite(spread)
        moved = np.abs(best.x - before.x)[known] > SETTLED * best.scatter * spread[known]
        if turn and not moved.any():
            break
    return model, best._replace(widening=widening(best.fun, model.data.roots))


def _outliers(model: Model, best: Best) -> Mask:
    """Which points of the curve are farther than OUTLYING times the noise from the fit.

    A mask of all points, false for those that are not fitted; residuals are without weights, so
    that points that were left out are judged as the others. The noise is what the curve or the
    residuals have, whichever is more.
    """
    data = model.data
    off = np.abs(best.fun / data.roots)[: data.points.size]
    scale = max(data.sigma, float(np.median(off)) / NORMAL_MEDIAN)
    found = np.zeros(data.used.size, bool)
    found[data.points] = off > OUTLYING * scale
    return found


def _without_outliers(model: Model, outliers: Mask) -> tuple[Model, Best, Mask]:
    """The minimum without outliers (n,), and which they are: a forward search.

    A fit may have followed a spike, and then its neighbours seem to be the outliers: they are left
    out at first, too. Points that turn out to be near the fit come back, until none changes
    (Atkinson and Riani 2000); without weights their residuals are known all the time. The data get
    the weight 1 for all other points.
    """
    spread = np.ones(2 * WIDEST_SPIKE + 1)
    out = np.convolve(outliers, spread, mode="same") > 0
    model = replace(model, data=model.data.with_roots(model.data.roots_without(out)))
    best = sought(model)
    for _ in range(TURNS):
        kept = _outliers(model, best)
        if np.array_equal(kept, out):
            break
        out = kept
        model = replace(model, data=model.data.with_roots(model.data.roots_without(out)))
        best = followed(model, best.x)
    return model, best, out


def _bounded_loss(model: Model, best: Best) -> float:
    """Σ min(r², (OUTLYING σ)²) over all residuals r without weights.

    Those of ends of contact are in units of their own error times σ, so that the bound is theirs,
    too.
    """
    off = best.fun / model.data.roots
    return float(np.sum(np.minimum(off**2, (OUTLYING * model.data.sigma) ** 2)))


def widening(fun: Array, roots: Array) -> float:
    """Variance of an estimate with the loss soft_l1 over what weighted squares say of it.

    With weights W, residuals r, ψ = W r and ψ' = W³ (Huber and Ronchetti 2009, section 7.6):
    mean ψ²/(mean ψ')² over mean W r²/mean W.
    """
    weights = roots**2
    robust_variance = np.mean((roots * fun) ** 2) / np.mean(weights**3) ** 2
    return float(robust_variance * np.mean(weights) / np.mean(fun**2))


def hopeless(model: Model, squares: float) -> bool:
    """Whether Σr² is so much more than the noise that the model cannot be right there.

    squares: with or without the errors e of simulated forces: these are at most `least`, and change
    the square of the right side by a sixteenth at most.
    """
    least = max(model.data.sigma, SIMULATED * model.data.size)
    return math.sqrt(squares / len(model.data.lines)) > HOPELESS * least


def followed(model: Model, start: Array, fixed: int | None = None, ftol: float = FINE) -> Best:
    """The minimum of the sum of squares near `start`; coordinate `fixed` stays.

    Branches and their rates of change are computed at one place. The next place is the minimum for
    branches that change at these rates, within a reach: a trust region, which becomes shorter
    where the step gains nothing. The search ends where the promised gain is less than ftol, but not
    with a step that ends at the edge of the reach, beyond which there may be more to gain. A limit
    of the coordinates counts as such an edge, too: from there on no step leads to it, so that it
    costs one round.

    Parameters
    ----------
    model : Model
    start : ndarray (m,)
        Coordinates.
    fixed : int, optional
        Coordinate that keeps its value.
    ftol : float
        Relative gain of the sum of squares at which the search ends.

    Raises
    ------
    ValueError
        If there are no equilibria at the start.
    """
    x = start.copy()
    fun = model.residuals(start)
    if not np.isfinite(fun).all():
        raise ValueError(
            f"scene = {model.scene!r} has no equilibria along the measured depths to start from; "
            "start from other parameters"
        )
    limits = model.coordinates.limit
    reach = model.coordinates.step
    rounding = ROUNDING * model.data.size
    for _ in range(ROUNDS):
        box = np.maximum(x - reach, -limits), np.minimum(x + reach, limits)
        best, squares = minimum(model.near(x), x, box, fixed)
        before = float(fun @ fun)
        promised = before - squares
        enough = max(ROUGH, ftol) if hopeless(model, squares) else ftol
        small = promised <= enough * before + rounding**2
        moves = best - x
        edge = np.where(best > x, box[1], box[0]) - x
        at_edge = (moves != 0) & (np.abs(moves) > AT_EDGE * np.abs(edge))
        would_go_farther = at_edge.any() and reach.min() > SHORTEST
        if not moves.any() or (small and not would_go_farther):
            break
        trial = model.residuals(best)
        gained = before - float(trial @ trial)  # nan: there is no state
        if gained > FAIR * promised:
            reach = np.minimum(2 * reach, model.coordinates.step)
        if gained > 0:
            x = best
            fun = trial
        else:
            reach = SHORTER * np.minimum(reach, np.abs(moves).max())
    jac = model.near(x).jacobian(x)
    error = SIMULATED * model.data.size
    return Best(x, fun, jac, float(fun @ fun) + fun.size * error**2)


def minimum(
    model: Model, start: Array, box: tuple[Array, Array], fixed: int | None = None
) -> tuple[Array, float]:
    """The minimum in a box for known branches, and its sum of squares; coordinate `fixed` stays.

    From x = 0 the first step of scipy's trust region is at most 1, in coordinates times the lengths
    of the columns of the Jacobian, and it stays off a bound by up to a share |gradient|, at most
    0.005 (trf in 1.17). Residuals over `unit` make the first no bound, and the second next to 0.
    """
    free = [i for i in range(start.size) if i != fixed]
    x = start.copy()
    unit = UNBOUND * model.data.size

    def residuals(values: Array) -> Array:
        """Weighted residuals with these values of the free coordinates, over `unit`."""
        x[free] = values
        return model.residuals(x) / unit

    found = optimize.least_squares(
        residuals,
        start[free],
        lambda values: optimize.approx_fprime(
            values, residuals, model.coordinates.difference[free]
        ),
        bounds=[edge[free] for edge in box],
        x_scale="jac",
        ftol=SOLVED,
        gtol=None,  # it has units
        max_nfev=STEPS,
    )
    x[free] = found.x
    return x, 2 * float(found.cost) * unit**2


def profiled(model: Model, best: Best, i: int, at: float) -> float:
    """The least sum of squares with coordinate i at a value, over that of the fit.

    The others follow by Gauss and Newton's steps with the Jacobian of the fit, from whose
    pseudo-inverse the rows of the line are left out: residuals are beside the nearest line already.
    Where these do not converge, to within a share ENOUGH of the sum of squares, they are sought
    from those of the fit. It is inf where there are no equilibria with the others as in the fit:
    there is then nowhere to search from, and the value counts as outside of the interval.
    """
    error = best.fun.size * (SIMULATED * model.data.size) ** 2
    others = [j for j in range(best.x.size) if j != i]
    start = best.x.copy()
    start[i] = at
    x = start.copy()
    reach = model.coordinates.limit[others]
    before = math.inf
    step = np.linalg.pinv(np.delete(best.jac, i, axis=1))[: len(others)]
    moves = step @ best.jac[:, i] * (at - best.x[i])
    for _ in range(CHORDS):
        x[others] = np.clip(x[others] - moves, -reach, reach)
        residuals = model.residuals(x)
        squares = float(residuals @ residuals) + error
        if abs(before - squares) <= ENOUGH * squares:
            return min(before, squares) / best.squares
        if not squares < before:  # or there is no state
            break
        before = squares
        moves = step @ residuals
    if not np.isfinite(model.residuals(start)).all():
        return math.inf
    return min(before, followed(model, start, i, AGAIN).squares) / best.squares


def spreads(jacobian: Array, count: int) -> Array:
    """Deviations √((JᵀJ)⁻¹)ᵢᵢ of all parameters for residuals of deviation 1 (m + q,).

    They are inf for those of the first `count` that the residuals do not depend on.
    """
    sizes = np.linalg.norm(jacobian, axis=0)
    dead = sizes <= DEAD * sizes[:count].max()
    dead[count:] = False
    found = np.full(sizes.size, math.inf)
    _, singular, right = np.linalg.svd(jacobian[:, ~dead] / sizes[~dead], full_matrices=False)
    found[~dead] = np.linalg.norm(right.T / singular, axis=1) / sizes[~dead]
    return found


def conditioning(jacobian: Array, count: int) -> tuple[float, Array]:
    """Condition number of the first `count` columns at unit length, and their weakest direction.

    The direction (m,) has unit length. Columns are taken without what the line out of contact can
    do, which is fitted for every x. Where a column is 0, or nothing is left of it, the condition
    is inf, and these columns are the direction.
    """
    own = jacobian[:, :count]
    line = jacobian[:, count:]
    sizes = np.linalg.norm(own, axis=0)
    own = own - line @ np.linalg.lstsq(line, own, rcond=None)[0]
    lengths = np.linalg.norm(own, axis=0)
    lost = (sizes <= DEAD * sizes.max()) | (lengths <= LOST * sizes)
    if lost.any():
        return math.inf, lost / np.linalg.norm(lost)
    _, singular, right = np.linalg.svd(own / lengths, full_matrices=False)
    weakest = right[-1] / lengths
    return float(singular[0] / singular[-1]), weakest / np.linalg.norm(weakest)
