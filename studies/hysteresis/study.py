"""What does a closed loop of touching, pressing and pulling off cost, and where is it lost?

Flat punch, wedge and parabola go through closed load paths, for several surface tensions γ₁ and
works of adhesion w, under imposed depth, a dead load, and machines of finite stiffness K:

    ∮P dd = Σ energy released in the instabilities.

The left side comes from the forces along the path, the right side from the energies beside the
events. Jump-in, pull-off, end of the contact and loop area stand beside the closed forms
(energy.cards); where a closed form is 0 the error is in units of kδ₀(b + l), δ₀ and b, see
shared/loops.py. A loop depends (small slopes) on two groups: l/b, which is √(γ₁/k)/b, or
√(γ₁/2w) tan δ for the wedge, and K/(kb).

Output: a line per loop and its worst error, hysteresis.csv with all numbers, figures. Exit status 1
if an error exceeds 1e-8 or the energy balance does not close within 1e-9.
"""

from collections.abc import Sequence
from functools import partial
from itertools import product

from discretization import History
from studies.hysteresis import figures as hysteresis_figures
from studies.hysteresis.record import BAR, FULL, LEDGER, QUICK, Loop, Parameters, Record
from studies.shared import command, loops
from studies.shared.batches import Show, each, silent
from studies.shared.loops import INDENTERS, LAYER, SIZE, WORK
from studies.shared.table import Columns, Table

_NIL = 1e-8  # of the scale, printed as 0
LENGTHS = ("jump-in half-width", "pull-off depth", "pull-off half-width")
SHOWN = dict.fromkeys(LENGTHS, 1e6) | {"pull-off force": 1.0, "loop area": 1.0}


def run(parameters: Parameters = FULL, show: Show = silent, jobs: int = 1) -> Record:
    """Follow all loops in `jobs` processes; `show` gets a line for each."""
    show(COLUMNS.head)
    found: list[Loop] = []
    scenes = list(product(INDENTERS, parameters.tensions, parameters.works))
    for own in each(partial(_controls, parameters), scenes, jobs):
        found += own
        show("\n".join(map(line, own)))
    return Record(parameters, tuple(found))


def _controls(parameters: Parameters, case: tuple[str, float, float]) -> list[Loop]:
    """The same scene under all controls."""
    shape, gamma1, w = case
    path = loops.depth_loop(loops.scene_of(shape, gamma1, w), parameters.steps)
    stiffness = LAYER.stiffness * SIZE
    held = [loops.driven_loop(path, K * stiffness) for K in (0.0, *parameters.machines)]
    return [Loop(shape, one, tuple(loops.compared(one)), one.work()) for one in (path, *held)]


COLUMNS = Columns(
    "indenter -10|γ₁ N/m 6.3g|w N/m 6.3g|control -12|jump-in a µm 12.6g|pull-off N/m 14.6g|"
    "d µm 9.6g|a µm 9.6g|area J/m 12.6g|error 6.0e|balance 7.0e"
)


def line(loop: Loop) -> str:
    """One line of the table."""
    scene = loop.history.scene
    numbers = [
        f.simulated * SHOWN[f.name] if abs(f.simulated) > _NIL * f.scale else 0.0
        for f in loop.forms
        if f.name in SHOWN
    ]
    given = loop.shape, scene.gamma1, scene.work_of_adhesion, loop.control
    told = COLUMNS.line(*given, *numbers, loop.error, loop.imbalance)
    return told + ("" if loop.passed else "  FAIL")


def summary(record: Record) -> str:
    """The last lines: errors, and what the loops say."""
    failed = sum(not loop.passed for loop in record.loops)
    return (
        f"{len(record.loops)} loops: worst error {record.error:.1e} "
        f"(limit {BAR:.0e}), energy balances off by {record.imbalance:.1e} at most "
        f"(limit {LEDGER:.0e}); {failed} failed"
    )


def featured(record: Record) -> History:
    """The loop to look at closely: the parabola at moderate tension, under imposed depth."""
    held = [loop for loop in record.loops if (loop.shape, loop.control) == ("parabola", "depth")]
    found = [loop.history for loop in held if loop.history.scene.work_of_adhesion == WORK]
    return next(history for history in found if history.scene.gamma1 >= 0.02)


def table(record: Record) -> Table:
    """A row per loop: every number simulated, in closed form, and its relative error. SI."""
    names = [form.name.replace(" ", "_") for form in record.loops[0].forms]
    columns = [f"{name}{end}" for name in names for end in ("", "_closed_form", "_error")]
    given = ["indenter", "gamma1", "w", "control", "machine_stiffness"]
    rows = []
    for loop in record.loops:
        history, scene = loop.history, loop.history.scene
        forms = [v for f in loop.forms for v in (f.simulated, f.closed_form, f.error)]
        stiffness = history.machine_stiffness or ""
        at = (scene.gamma1, scene.work_of_adhesion, history.control, stiffness)
        rows.append([loop.shape, *at, *forms, loop.work, history.dissipated, loop.imbalance])
    return [*given, *columns, "work", "dissipated", "imbalance"], rows


def main(argv: Sequence[str] | None = None) -> int:
    """Run, draw, write; 1 if a loop misses a bar."""
    quick = "fewer loops"
    preset, jobs, out = command.start("hysteresis", __doc__, argv, quick, FULL, QUICK)
    record = run(preset, command.say, jobs)
    out.table("hysteresis.csv", preset, *table(record))
    out.figures(hysteresis_figures.plot(record, featured(record)))
    print(summary(record))
    command.answer(
        f"The energy released in its jumps and nothing else: in {len(record.loops)} loops the area "
        f"agrees with that within {record.imbalance:.0e}, and with the closed forms within "
        f"{record.error:.0e}."
    )
    return 0 if record.passed else 1
