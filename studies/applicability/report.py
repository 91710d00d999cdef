"""What the study `applicability` found: the answer in words, and the table of borders.

Every number is read from the record of simulated states; none stands here.

Conventions:

- A `Table` is the names of its columns, and its rows.
"""

import math
from collections.abc import Iterator

import numpy as np

from energy.arrays import Array
from studies.applicability.figures import worst_on_path
from studies.applicability.record import TOLERANCES, Record
from studies.shared.table import Table, markdown


def within(steepness: Array, errors: Array, tolerance: float) -> float:
    """Steepness at which the errors reach the tolerance, between points by their power law.

    Parameters
    ----------
    steepness, errors : ndarray (n,)
        Growing steepness, and the errors there.
    tolerance : float

    Returns
    -------
    float
        NaN if they exceed it everywhere, inf if nowhere.
    """
    over = np.flatnonzero(errors > tolerance)
    if not over.size or over[0] == 0:
        return math.nan if over.size else math.inf
    i = slice(over[0] - 1, over[0] + 1)
    logs = np.interp(math.log(tolerance), np.log(errors[i]), np.log(steepness[i]))
    return float(np.exp(logs))


def power(x: Array, y: Array) -> float:
    """n of y ~ xⁿ by least squares."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])


def answer(record: Record) -> str:
    """applicability.md without its figures."""
    return "\n".join(
        [
            "# Where Eq. (16) serves\n",
            "Eq. (16) against simulated states with true surface lengths, at the same depth.\n",
            "## Is it exact anywhere?\n",
            *_exact(record),
            "\n## Up to which w/γ₁ is the error below 1 % and 10 %?\n",
            "Wedge and parabola, at the depth where (16) gives a = l; cone and sphere against "
            "states of small slopes, where a line of radius l is in balance with these.\n",
            _borders(record),
            "\n## Does it serve for all γ₁? (w, k, indenter and d = 0 fixed)\n",
            "The largest error over all γ₁, of a relative to a₀, of P to max(|P|, 2√(2wγ₁)).\n",
            *_conjecture(record),
        ]
    )


def _exact(record: Record) -> Iterator[str]:
    """Paragraphs on what holds exactly: (16), (18) with small slopes; flat faces; Young's law."""
    p = record.parameters
    tense, dry = record.small_slopes
    yield (
        f"- In the paper's own energy (small slopes): for γ₁/w from {min(p.tensions):g} to "
        f"{max(p.tensions):g} the simulated half-width differs from (16) by at most {tense:.0e}, "
        f"for γ₁ = 0 from (18) by {dry:.0e}. There (16) is exact for every γ₁."
    )
    for shape in dict.fromkeys(item[0] for item in record.flat):
        ratios = [ratio for name, ratio, _ in record.flat if name == shape]
        worst = max(abs(error) for name, _, error in record.flat if name == shape)
        yield (
            f"- With true lengths, where the face is flat at the line: the {shape} detaches at "
            f"d = -√(2w/k) within {worst:.0e} for w/γ₁ from {min(ratios):g} to {max(ratios):g}."
        )
    young = [abs(x.errors.young) for x in record.points if math.isfinite(x.errors.young)]
    gone = [x.ratio for x in record.points if not x.errors.exists]
    yield (
        f"- Control: in all {len(young)} simulated states with a free line π - θ obeys Young's law "
        f"(8) within {max(young):.0e} of itself. For {len(gone)} points there is no state: the "
        f"surface turns over, first at w/γ₁ = {min(gone, default=math.nan):.3g}."
    )


def _borders(record: Record) -> str:
    """One row for each shape, steepness and quantity."""
    largest = max(record.parameters.scan)
    rows = []
    for one, ten in zip(record.borders[::2], record.borders[1::2], strict=True):
        steepness = f"{one.steepness:g}" if math.isfinite(one.steepness) else "any"
        limits = (_limit(border.ratio or math.nan, f"{largest:g}, all") for border in (one, ten))
        rows.append([one.shape, steepness, one.quantity, *limits])
    columns = ("indenter", "f'(a)", "error of", "w/γ₁ within 1 %", "within 10 %")
    return markdown(columns, rows)


def _limit(value: float, every: str) -> str:
    """Up to where something holds: nan is nowhere, inf is everywhere."""
    if math.isnan(value):
        return "nowhere tried"
    return f"up to {every} tried" if math.isinf(value) else f"below {value:.2g}"


def _conjecture(record: Record) -> Iterator[str]:
    """How the worst error grows with the steepness, and whether it vanishes for blunt bodies."""
    rows = []
    orders = []
    for shape, points in record.paths.items():
        for name, what in (("half_width", "half-width"), ("force", "force")):
            steepness, errors = worst_on_path(points, name)
            orders.append(power(steepness, errors))
            ends = (f"{errors[i]:.1e} at {steepness[i]:g}" for i in (0, -1))
            limits = (within(steepness, errors, tolerance) for tolerance in TOLERANCES)
            told = (_limit(limit, f"{steepness[-1]:g}, all") for limit in limits)
            rows.append([shape, what, f"f'(a₀)^{orders[-1]:.2f}", *ends, *told])
    columns = ("indenter", "error of", "grows as", "from", "to", "f'(a₀) within 1 %", "within 10 %")
    yield markdown(columns, rows)
    if min(orders) > 0.5:
        yield (
            "\nThe conjecture holds in this sense: not π - θ has to be small but the slope of the "
            "indenter at the line. The angle enters through 2l sin((π - θ)/2), and Young's law "
            "makes that √(2w/k) at any angle. (Relative to a itself errors are larger where the "
            "contact is about to vanish, a ≪ a₀. For γ₁ < w/2 there is no angle: (18) is the limit "
            "γ₁ → 0 of the small-slope energy only.)"
        )
    else:
        yield "\nThe conjecture fails: the error does not vanish for blunt indenters."


def short(record: Record) -> str:
    """The largest errors over all γ₁, for the bluntest and the steepest indenters tried."""
    found: dict[float, float] = {}
    for points in record.paths.values():
        steepness, width = worst_on_path(points, "half_width")
        force = worst_on_path(points, "force")[1]
        for i in (0, -1):
            worst = max(width[i], force[i], found.get(steepness[i], 0.0))
            found[float(steepness[i])] = float(worst)
    told = " and ".join(f"{error:.1%} where f'(a₀) = {s:g}" for s, error in sorted(found.items()))
    return (
        "Exactly with small slopes, and with true lengths where the indenter is blunt: over all γ₁ "
        f"tried, half-width and force are off by at most {told}."
    )


def table(record: Record) -> Table:
    """Columns and a row per comparison."""
    names = [f"error_{name}" for name in ("half_width", "force", "angle", "young")]
    rows = [
        [part, shape, x.ratio, x.steepness, x.width, *x.errors]
        for part, found in (("map", record.maps), ("path", record.paths))
        for shape, points in found.items()
        for x in points
    ]
    return ["part", "shape", "w/gamma1", "steepness", "a/l", *names], rows
