"""Is rtol honoured, and can error_estimate be trusted?

Random scenes of every built-in body over eight decades of length and stress, small and finite
slopes, each with a random rtol between 1e-2 and 1e-12: `minimise(scene, depth, rtol=rtol)` against
energy.cards. With e the true relative error of half-width, force or energy (force and energy
relative to the sums of their terms' absolute values),

    honoured: e <= max(rtol, 1e-12)        trusted: error_estimate >= e/10 (or e <= 1e-15).

Likewise for lattice states with 2 to 400 nodes per l (lattice_tolerance.py), whose estimate is
trusted or withheld: infinite, where the lattice does not resolve the state.

Output: a table, tolerance.csv and tolerance_lattice.csv with a row per scene and quantity,
tolerance.png: true error and estimate against rtol. Exit status 1 if fewer than 99 % of the scenes
are honoured or one is not trusted.
"""

import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization import AccuracyWarning, minimise
from studies.benchmarks import lattice_tolerance
from studies.shared import command
from studies.shared.batches import Progress, each, tell
from studies.shared.figures import BLUE, ORANGE, Figure, canvas
from studies.shared.random_cases import Case, in_turn
from studies.shared.table import Columns
from studies.shared.types import QUANTITIES

FLOOR, ROUNDING = 1e-12, 1e-15
SHARE = 0.99
COLUMNS = Columns(
    "slopes -6|scenes 7|honoured 9|trusted 8|worst e/max(rtol, 1e-12) 25.2g|worst e/estimate 17.2g"
)


@dataclass(frozen=True)
class Parameters:
    """Number of scenes and of lattice states, half of them with finite slopes; range of
    -log10(rtol); seed."""

    scenes: int = 500
    lattices: int = 2000
    loosest: float = 2.0
    tightest: float = 12.0
    seed: int = 3


class Trial(NamedTuple):
    """True errors and estimates of half-width, force and energy of one scene."""

    shape: str
    slopes: str
    rtol: float
    errors: tuple[float, ...]
    estimates: tuple[float, ...]

    @property
    def honoured(self) -> bool:
        """Whether every error is within rtol."""
        return max(self.errors) <= max(self.rtol, FLOOR)

    @property
    def trusted(self) -> bool:
        """Whether no estimate is below a tenth of the error."""
        pairs = zip(self.errors, self.estimates, strict=True)
        return all(estimate >= error / 10 or error <= ROUNDING for error, estimate in pairs)


def measure(given: tuple[Case, float]) -> Trial:
    """Solve one scene at its rtol and compare it with its cards."""
    case, rtol = given
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # it is judged here
        state = minimise(case.scene, case.depth, rtol=rtol)
    errors = case.errors(state, case.half_width)
    estimates = tuple(float(state.error_estimate[name]) for name in QUANTITIES)
    return Trial(case.shape, case.scene.slopes, rtol, errors, estimates)


def run(
    params: Parameters, show: Callable[[Progress], object] = tell, jobs: int = 1
) -> list[Trial]:
    """All trials, in `jobs` processes; `show` is told how many are done."""
    return list(each(measure, list(drawn(params)), jobs, show))


def drawn(params: Parameters) -> Iterator[tuple[Case, float]]:
    """The scenes, each with its rtol."""
    rng = np.random.default_rng(params.seed)
    for i in range(params.scenes):
        yield in_turn(rng, i), 10 ** -rng.uniform(params.loosest, params.tightest)


def passed(trials: Sequence[Trial]) -> bool:
    """Whether rtol was honoured often enough and every estimate could be trusted."""
    honoured = sum(trial.honoured for trial in trials)
    return honoured >= SHARE * len(trials) and all(trial.trusted for trial in trials)


def summary(trials: Sequence[Trial]) -> str:
    """A line for small and one for finite slopes."""
    lines = [COLUMNS.head]
    for slopes in ("small", "finite"):
        own = [trial for trial in trials if trial.slopes == slopes]
        excess = max(max(t.errors) / max(t.rtol, FLOOR) for t in own)
        pairs = [p for t in own for p in zip(t.errors, t.estimates, strict=True)]
        short = max(error / estimate for error, estimate in pairs if estimate)
        counts = (sum(getattr(t, name) for t in own) for name in ("honoured", "trusted"))
        lines.append(COLUMNS.line(slopes, len(own), *counts, excess, short))
    return "\n".join(lines)


def plot(trials: Sequence[Trial]) -> Figure:
    """True error and estimate of each quantity against rtol."""
    figure, panels = canvas(10, 4, 1, 2, sharey=True)
    for axes, slopes in zip(panels, ("small", "finite"), strict=True):
        own = [trial for trial in trials if trial.slopes == slopes]
        rtol = [trial.rtol for trial in own]
        for values, marker, colour, label in (
            ([max(trial.estimates) for trial in own], "^", ORANGE, "largest estimate"),
            ([max(*trial.errors, 1e-17) for trial in own], "o", BLUE, "largest true error"),
        ):
            axes.loglog(rtol, values, marker, color=colour, ms=4, alpha=0.6, label=label)
        limits = np.array([1e-13, FLOOR, 1e-1])
        axes.plot(limits, np.maximum(limits, FLOOR), "k--", lw=1, label="max(rtol, $10^{-12}$)")
        axes.set(xlabel="rtol", title=f"{slopes} slopes, {len(own)} scenes", ylim=(3e-18, 1))
        axes.grid(alpha=0.3)
    figure.axes[0].set_ylabel("relative error of a, P or U")
    figure.axes[0].legend(loc="upper left", fontsize=8)
    honoured = sum(trial.honoured and trial.trusted for trial in trials)
    figure.suptitle(
        f"rtol is honoured and the estimate covers the error in {honoured} of {len(trials)} scenes"
    )
    return figure


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    full, quick = Parameters(), Parameters(scenes=60, lattices=100)
    told = "60 scenes, 100 on nodes"
    params, jobs, out = command.start("tolerance", __doc__, argv, told, full, quick)
    trials = run(params, jobs=jobs)
    out.table("tolerance.csv", params, *lattice_tolerance.table(trials))
    out.figure("tolerance.png", plot(trials))
    states = lattice_tolerance.run(params.lattices, params.seed, tell, jobs)
    out.table("tolerance_lattice.csv", params, *lattice_tolerance.table(states))
    print(summary(trials), lattice_tolerance.summary(states), sep="\n\n")
    honoured, trusted = (sum(getattr(t, n) for t in trials) for n in ("honoured", "trusted"))
    command.answer(
        f"rtol is honoured in {honoured} of {len(trials)} scenes; error_estimate covers the true "
        f"error in {trusted} of them, and in {sum(s.trusted for s in states)} of {len(states)} "
        "lattice states."
    )
    return 0 if passed(trials) and all(state.trusted for state in states) else 1
