"""What the study `applicability` found: the answer in words, and the table of borders.

Every number is read from the record of simulated states; none stands here.
"""

import math
from collections.abc import Iterator

import numpy as np

from studies.applicability.figures import draw_conjecture, draw_maps, grid, worst_on_path
from studies.applicability.record import PUNCH, Record
from studies.applicability.regimes import draw_regimes
from studies.shared import Array
from studies.shared.command import Output
from studies.shared.table import Table, markdown


def within(steepness: Array, errors: Array, tolerance: float) -> float:
    """Steepness at which the errors reach the tolerance, between points by their power law.

    nan if they exceed it everywhere, inf if nowhere.
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
            *_table(record),
            "",
            *_punch(record),
            "\n## Does it serve for all γ₁? (w, k, indenter and d = 0 fixed)\n",
            *_conjecture(record),
            "\n## Where nothing can be said\n",
            *_overhang(record),
        ]
    )


def _exact(record: Record) -> Iterator[str]:
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
    points = [x for part in (record.maps, record.paths) for row in part.values() for x in row]
    young = [abs(x.errors.young) for x in points if math.isfinite(x.errors.young)]
    yield (
        f"- Control: in all {len(young)} simulated states with a free line π - θ obeys Young's law "
        f"(8) within {max(young):.0e} of itself."
    )


def _ratio(value: float, largest: float) -> str:
    if value == 0:
        return "nowhere"
    return f"up to {largest:g}, all tried" if math.isinf(value) else f"below {value:.2g}"


def _table(record: Record) -> Iterator[str]:
    """One row for each shape, steepness and quantity."""
    yield "Wedge and parabola, at the depth where (16) gives a = l; cone and sphere against states"
    yield "of small slopes, where a line of radius l is in balance with these; w/γ₁:\n"
    largest, rows = max(record.parameters.scan), []
    for one, ten in zip(record.borders[::2], record.borders[1::2], strict=True):
        steepness = f"{one.steepness:g}" if math.isfinite(one.steepness) else "any"
        limits = (_ratio(border.ratio, largest) for border in (one, ten))
        rows.append([one.shape, steepness, one.quantity, *limits])
    columns = ("indenter", "f'(a)", "error of", "within 1 %", "within 10 %")
    yield markdown(columns, rows, "--- --: --- --- ---")


def _punch(record: Record) -> Iterator[str]:
    points = [x for shape in record.paths for x in (*record.maps[shape], *record.paths[shape])]
    known = [x.errors.half_width for x in points if x.errors.exists]
    below = sum(error < 0 for error in known)
    yield f"- In {below} of {len(known)} states the contact is wider than (16) says."
    ratios, widths, _, force = grid(record.maps[PUNCH], "width")
    largest, worst = ratios[~np.isnan(force).any(axis=0)][-1], np.nanmax(force, axis=1)
    yield (
        f"- flat punch about to detach: with the tension term 2√(2wγ₁) of (22) its force is off, "
        f"for w/γ₁ up to {largest:g}, by at most {worst[0]:.1%} for a = {widths[0]:g} l and "
        f"{worst[-1]:.1%} for a = {widths[-1]:g} l."
    )


def _conjecture(record: Record) -> Iterator[str]:
    orders = []
    for shape, points in record.paths.items():
        for name, what, scale in (
            ("half_width", "half-width", "a₀"),
            ("force", "force", "max(|P|, 2√(2wγ₁))"),
        ):
            steepness, errors = worst_on_path(points, name)
            one, ten = (within(steepness, errors, tolerance) for tolerance in (0.01, 0.1))
            yield (
                f"- {shape}, {what}: the largest error over all γ₁ tried grows as f'(a₀)^"
                f"{power(steepness, errors):.2f}, from {errors[0]:.1e} {scale} at f'(a₀) = "
                f"{steepness[0]:g} to {errors[-1]:.1e} at {steepness[-1]:g}: within 1 % for all γ₁ "
                f"if f'(a₀) {_bound(one)}, within 10 % if it {_bound(ten)}."
            )
            orders.append(power(steepness, errors))
    if min(orders) > 0.5:
        yield (
            "\nThe conjecture holds in this sense: not π - θ has to be small but the slope of the "
            "indenter at the line. The angle enters through 2l sin((π - θ)/2), and Young's law "
            "makes that √(2w/k) at any angle. (Relative to a itself errors are larger where the "
            "contact is about to vanish, a ≪ a₀.)"
        )
    else:
        yield "\nThe conjecture fails: the error does not vanish for blunt indenters."


def _bound(steepness: float) -> str:
    if math.isnan(steepness):
        return "is below all tried"
    return "is any of those tried" if math.isinf(steepness) else f"is <= {steepness:.2g}"


def _overhang(record: Record) -> Iterator[str]:
    for shape, steepness, ratio in record.turning:
        if math.isfinite(ratio):
            where = f" with f'(a) = {steepness:g}" if steepness else ""
            yield (
                f"- {shape}{where}: beyond w/γ₁ = {ratio:.2f} the surface turns over (inclination "
                "beyond π/2) and is no graph u(x)."
            )
    yield (
        "- For γ₁ < w/2 Young's law has no angle: with w fixed the limit γ₁ → 0 of (18) cannot be "
        "reached with true lengths; (18) is the limit of the small-slope energy only."
    )


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


def write(record: Record, out: Output) -> str:
    """Write figures, CSV and report; return the answer."""
    text = answer(record)
    images = {"applicability.png": draw_maps(record), "conjecture.png": draw_conjecture(record)}
    images["regimes.png"] = draw_regimes()
    out.figures(images)
    out.table("applicability.csv", record.parameters, *table(record))
    links = "\n".join(f"\n![{name}]({name})" for name in images)
    out.text("applicability.md", f"{text}\n{links}\n")
    return text
