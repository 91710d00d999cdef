"""Does every numbered result of the paper come out of minimising the energy?

The energy of a surface u(x) >= d - f(x) on a bed of springs,

    U[u] = ∫ k/2 u² dx + ∫ γ₁/2 u'² dx - w |{u = d - f}|,

holds neither a contact angle nor a contact width. For each of Eqs. (1)-(40) this study measures
what the equation states on simulated equilibria and compares it with the closed form, on both
discretisations: on nodes, where energies of contact sets are compared and nothing else, and on the
mesh, where a free contact line rests at ∂U/∂x = 0. On the lattice it halves the spacing of the
nodes several times, shifts the grid sideways, and demands a small error on the finest grid as well
as the right order of convergence. On the fitted mesh, the default of `minimise`, it demands
rounding, or what the measure itself leaves. Checks stand in studies/verify/checks.

Output: one line per check, report.md with all figures, verify.csv. Exit status 1 if any fails.
"""

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - A `Table` is the names of its columns, and its rows.
# - `Columns` writes tables on the screen: `head` is the first line, `line(*cells)` any other. Each
#   column is "name width format", between bars; a negative width begins at the left, and a name may
#   be empty.
# - `each(function, cases, jobs, say=..., together=...)` gives the results in the order of the
#   cases, with so many neighbours at once in a process; `say` gets each.
# - `figures.simulate(points)` are the curves of the figures, of so many states on each branch.
# - `command.answer` prints what the study has found; the fourth argument of `command.start` says in
#   the help what the quick preset does. `out.text` writes a text into the folder.
# - `lattice_only` of a check is why it needs nodes fixed in space, in words; "" if it does not.
# - CHECKS are all checks; `refine(check, cells, offsets)` takes one on ever finer lattices and on
#   the fitted mesh, and gives a `Result` with its errors, its observed order and whether it
#   `passed`.
# - Its `bar` and `fitted_bar` are the largest errors of each.

import math
import time
from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import Figure
from studies.shared.table import Columns, Table
from studies.verify import figures
from studies.verify.checks import CHECKS
from studies.verify.convergence import Check, Result, refine


@dataclass(frozen=True)
class Parameters:
    """How much is measured.

    Attributes
    ----------
    cells : tuple of int
        Links per l; each level halves the spacing. Errors of second order fall by 64 from the first
        to the last of four, those of first order by 8, such as a raw half-width's from 0.3 to
        0.03 %. All levels together take the checks half a minute in two processes.
    offsets : tuple of float
        Shifts in links. Two half a link apart, neither with a symmetric contact's middle on a node
        or halfway between two.
    exact : int
        Levels on which exact quantities are measured; of the full study all.
    cases : int or None
        Comparisons of each check; None: all.
    points : int
        Of each branch that is drawn, as marks on its closed form; 0: nothing is.
    """

    cells: tuple[int, ...] = (50, 100, 200, 400)
    offsets: tuple[float, ...] = (0.31, 0.81)
    exact: int = 4
    cases: int | None = None
    points: int = 15


# Checks that one process takes at once, as many look at the same states: all take 43 s in sum, and
# 48 s if processes take one at a time.
NEIGHBOURS = 8
FULL = Parameters()
# One case of each check and one shift, not a symmetric one either.
QUICK = Parameters(offsets=(0.43,), exact=1, cases=1, points=0)


@dataclass(frozen=True)
class Record:
    """Outcome of all checks.

    Attributes
    ----------
    parameters : Parameters
    results : tuple of Result
    curves : Curves or None
        For the figures.
    """

    parameters: Parameters
    results: tuple[Result, ...]
    curves: figures.Curves | None

    @property
    def failed(self) -> tuple[Result, ...]:
        """The results that missed their limit or their order band."""
        return tuple(r for r in self.results if not r.passed)


def run(
    parameters: Parameters = FULL,
    checks: Sequence[Check] | None = None,
    show: Show = silent,
    jobs: int = 1,
) -> Record:
    """Run the checks.

    Parameters
    ----------
    parameters : Parameters
    checks : sequence of Check, optional
        None: all.
    show : callable, optional
        Gets a line of text for each.
    jobs : int
        Number of processes.

    Returns
    -------
    Record
    """
    show(SCREEN.head)
    p = parameters
    work = partial(refine, cells=p.cells, offsets=p.offsets, exact=p.exact, cases=p.cases)
    chosen = CHECKS if checks is None else checks
    found = each(work, chosen, jobs, say=lambda result: show(line(result)), together=NEIGHBOURS)
    results = tuple(found)
    return Record(p, results, figures.simulate(p.points) if p.points else None)


def plot(record: Record) -> dict[str, Figure]:
    """The figures by file name."""
    if record.curves is None:
        return {}
    return {
        "fig2.png": figures.punch_and_meniscus(record.curves.meniscus),
        "case_studies.png": figures.case_studies(record.curves.branches),
    }


CAPTIONS = {
    "fig2.png": "Fig. 2 of the paper from the simulation: a flat punch about to detach.",
    "case_studies.png": "Half-width and force against depth, simulated and in closed form.",
}


def label(equations: Sequence[int]) -> str:
    """Equation numbers as printed; a dash for what goes beyond the paper."""
    return ", ".join(f"({n})" for n in equations) or "-"


SCREEN = Columns(
    "Eq. 6|what -57|simulated 13.6g|closed form 13.6g|unit -4|lattice 8.1e|order 6|fitted 8| 5|"
    "s 5.1f"
)


def line(result: Result) -> str:
    """One line of the table on the screen."""
    item = result.check
    word = "ok" if result.passed else "FAIL"
    values = result.simulated, result.closed_form, item.unit, result.error
    judged = order(result), fitted(result), word, result.seconds
    told = SCREEN.line(label(item.equations), item.what, *values, *judged)
    note = "; ".join(filter(None, (result.note, item.lattice_only)))
    return told + f"\n       {note}" * bool(note)


def order(result: Result) -> str:
    """Observed order, or that the lattice is exact."""
    return f"{result.observed_order:.2f}" if result.check.order else "exact"


def fitted(result: Result) -> str:
    """Error on the fitted mesh; a dash where the measure needs a lattice."""
    return "—" if result.check.lattice_only else f"{result.fitted_error:.1e}"


def summary(record: Record, seconds: float) -> str:
    """The last line."""
    total = len(record.results)
    failed = len(record.failed)
    both = sum(not result.check.lattice_only for result in record.results)
    counts = f"{total - failed} passed, {failed} failed"
    return f"{total} checks, {both} on both discretisations: {counts}; {seconds:.1f} s"


def report(record: Record, closing: str, drawn: Sequence[str] = ()) -> str:
    """report.md: what was asked, the table and the figures.

    Parameters
    ----------
    record : Record
    closing : str
        The last line.
    drawn : sequence of str
        Names of figures.

    Returns
    -------
    str
    """
    levels = ", ".join(map(str, record.parameters.cells))
    shifts = ", ".join(map(str, record.parameters.offsets))
    few = record.parameters.cases is not None
    images = [
        f"## {text}\n\n![{text}]({name})\n" for name, text in CAPTIONS.items() if name in drawn
    ]
    return "\n".join(
        [
            "# The numbered results of the paper, from the energy",
            f"\n**{closing}**\n",
            f"Each quantity was measured on lattices with {levels} links per elastocapillary "
            f"length, each shifted sideways by {shifts} links"
            + (", in the first case of each check, if exact on the coarsest. " if few else ". ")
            + "Lattice: relative error, worst over depths, parameters and shifts, on the finest; "
            "the two values are those of that worst case. Residuals have the closed form 0 and are "
            "relative to their largest term. Order: of convergence, by least squares. Exact: the "
            "lattice has no error beyond rounding, on any grid, each with one of the shifts. "
            "Fitted: worst error of the same measure with the default method, a mesh anchored at "
            "the contact lines; a dash where the measure needs nodes fixed in space. (An endless "
            "plane has no line: one state serves both.) A check passes if the order lies in the "
            "band and both errors below their limits, which verify.csv has. A dash in the first "
            "column: beyond the paper.\n",
            "Two limits of the model show: the small-slope energy has the angle of Eq. (15), which "
            "is below Young's angle (8) by w/(12γ₁) of its value, and sin β = tan β in Eq. (10); "
            "both are measured where that is less than 1e-7. Other fitted limits "
            "above 1e-10 are those of difference quotients, of a closed form by quadrature, and of "
            "states just short of detachment. Checks of a wedge's energy and of a line at a tip "
            "keep the tip on a node; off it they are of first order. Checks of a layer with its "
            "exact response towards a limit go further with every level, on the fitted mesh: their "
            "error is how far the limit still is.\n",
            *("```text", SCREEN.head, *map(line, record.results), "```\n"),
            *images,
        ]
    )


def answer(record: Record) -> str:
    """Whether every result comes out."""
    count = len(record.results)
    failed = record.failed
    own = sum(bool(result.check.equations) for result in record.results)
    if not failed:
        own_and_more = f"{own} of the paper's equations and {count - own} beyond"
        return f"Yes: all {count} checks pass, {own_and_more}."
    named = ", ".join(f"{label(r.check.equations)} {r.check.what}" for r in failed)
    return f"Not every one: {len(failed)} of {count} checks fail: {named}."


def table(record: Record) -> Table:
    """Columns and a row per check, with the error of every level."""
    names = "equation what unit simulated closed_form error bar order order_low order_high"
    names += " fitted_error fitted_bar lattice_only passed seconds note"
    rows = []
    for r in record.results:
        item = r.check
        band = r.check.order or ("", "")
        given = " ".join(map(str, item.equations)), item.what, item.unit
        lattice = r.simulated, r.closed_form, r.error, item.bar
        order = r.observed_order if item.order else "exact", *band
        fitted = r.fitted_error, item.fitted_bar, item.lattice_only
        judged = r.passed, round(r.seconds, 3), r.note
        not_measured = [math.nan] * (len(record.parameters.cells) - len(r.errors))
        rows.append([*given, *lattice, *order, *fitted, *judged, *r.errors, *not_measured])
    return [*names.split(), *(f"error_{n}" for n in record.parameters.cells)], rows


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if any check failed."""
    start = time.perf_counter()
    quick = "one case and one shift of the nodes, in one process; nothing drawn"
    preset, jobs, out = command.start("verify", __doc__, argv, quick, FULL, QUICK)
    record = run(preset, show=command.say, jobs=jobs if preset is FULL else 1)
    drawn = plot(record)
    out.figures(drawn)
    out.table("verify.csv", preset, *table(record))
    closing = summary(record, time.perf_counter() - start)
    out.text("report.md", report(record, closing, list(drawn)))
    print(f"report: {out.folder / 'report.md'}")
    print(closing)
    command.answer(answer(record))
    return 1 if record.failed else 0
