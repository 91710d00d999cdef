"""Is rtol honoured, and can error_estimate be trusted?

Random scenes of every built-in body over eight decades of length and stress, small and finite
slopes, each with a random rtol between 1e-2 and 1e-12: `minimise(scene, depth, rtol=rtol)` against
energy.cards. With e the true relative error of half-width, force or energy (force and energy
relative to the sums of their terms' absolute values),

    honoured: e <= max(rtol, 1e-12)        trusted: error_estimate >= e/10 (or e <= 1e-15).

Likewise for lattice states with 2 to 400 nodes per l, at any offset of the nodes from the body and
with contacts from a fraction of a link up. They have no rtol, and their estimate is trusted or
withheld: infinite, where the lattice does not resolve the state.

Output: a table, tolerance.csv with a row per scene and quantity, tolerance.png: true error and
estimate against rtol. Exit status 1 if fewer than 99 % of the scenes are honoured or one is not
trusted.
"""

import math
import warnings
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from discretization import AccuracyWarning, NotCertifiedError, minimise
from discretization.lattice.state import on_lattice
from studies.shared import QUANTITIES, command
from studies.shared.batches import Progress, each, tell
from studies.shared.figures import BLUE, ORANGE, Figure, canvas
from studies.shared.random_cases import Case, in_turn
from studies.shared.table import Columns, Table

FLOOR, ROUNDING = 1e-12, {"mesh": 1e-15, "nodes": 1e-13}  # of errors over the sums of their terms
SHARE = 0.99
FEWEST, MOST = 2.0, 400.0  # nodes per l
UNKNOWN = (math.nan,) * 3
COLUMNS = Columns(
    "states -26|number 6|refused 7|withheld 8|honoured 8|trusted 7|worst e/max(rtol, 1e-12) 25.2g|"
    "worst e/estimate 17.2g"
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
    """True errors and estimates of half-width, force and energy of one scene.

    rtol: nan on nodes; nodes: per l, nan on the mesh; links: in contact; word: "estimated",
    "withheld" or why it was "refused".
    """

    shape: str
    slopes: str
    rtol: float
    nodes: float
    links: float
    word: str
    errors: tuple[float, ...]
    estimates: tuple[float, ...]

    @property
    def excess(self) -> float:
        """Largest error over what was asked for; nan on nodes."""
        return max(self.errors) / max(self.rtol, FLOOR) if self.rtol == self.rtol else math.nan

    @property
    def honoured(self) -> bool:
        """Whether every error is within rtol, if there is one."""
        return not self.excess > 1

    @property
    def worst(self) -> float:
        """Largest error over its estimate, or over a tenth of rounding; 0 without an estimate."""
        if self.word != "estimated":
            return 0.0
        least = ROUNDING["mesh" if math.isnan(self.nodes) else "nodes"] / 10
        pairs = zip(self.errors, self.estimates, strict=True)
        return max(error / max(estimate, least) for error, estimate in pairs)

    @property
    def trusted(self) -> bool:
        """Whether no estimate is below a tenth of its error."""
        return self.worst <= 10


def on_mesh(case: Case, rtol: float) -> Trial:
    """Solve one scene at its rtol and compare it with its cards."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)  # it is judged here
        state = minimise(case.scene, case.depth, rtol=rtol)
    errors = case.errors(state, case.half_width)
    estimates = tuple(float(state.error_estimate[name]) for name in QUANTITIES)
    where = rtol, math.nan, math.nan, "estimated"
    return Trial(case.shape, case.scene.slopes, *where, errors, estimates)


def on_nodes(case: Case, nodes: float, offset: float) -> Trial:
    """Solve one scene on so many nodes per l, at this offset in links, and compare it likewise."""
    dx = case.scene.elastocapillary_length / nodes
    scene = replace(case.scene, indenter=case.scene.indenter.shifted(offset * dx))
    where = case.shape, scene.slopes, math.nan, nodes
    try:
        state = on_lattice(scene, case.depth, dx, origin=None if not offset else 0.0)
    except (ValueError, NotCertifiedError):
        return Trial(*where, math.nan, "refused", UNKNOWN, UNKNOWN)
    estimates = tuple(float(state.error_estimate[name]) for name in QUANTITIES)
    links = float(np.diff(state.nodes).sum()) / dx
    word = "estimated" if max(estimates) < math.inf else "withheld"
    width = state.half_width or state.spacing
    errors = case.errors(state, width) if state.contacts.size else (math.inf,) * 3
    return Trial(*where, links, word, errors, estimates)


Drawn = tuple[Case, tuple[float, ...]]


def measure(drawn: Drawn) -> Trial:
    """A scene with its rtol, or with its nodes and their offset."""
    case, given = drawn
    return on_mesh(case, *given) if len(given) == 1 else on_nodes(case, *given)


def drawn(p: Parameters) -> Iterator[Drawn]:
    """The scenes with what is random of each, those on the mesh first."""
    rng = np.random.default_rng(p.seed)
    for i in range(p.scenes):
        yield in_turn(rng, i), (10 ** -rng.uniform(p.loosest, p.tightest),)
    rng = np.random.default_rng(p.seed)
    for i in range(p.lattices):
        case, nodes = in_turn(rng, i), math.exp(rng.uniform(math.log(FEWEST), math.log(MOST)))
        yield case, (nodes, float(rng.choice([0.0, rng.uniform(-0.5, 0.5)])))


def run(p: Parameters, show: Callable[[Progress], object] = tell, jobs: int = 1) -> list[Trial]:
    """All trials, in `jobs` processes; `show` is told how many are done."""
    return list(each(measure, list(drawn(p)), jobs, show))


def passed(trials: Sequence[Trial]) -> bool:
    """Whether rtol was honoured often enough and every estimate could be trusted."""
    asked = [trial.honoured for trial in trials if trial.rtol == trial.rtol]
    return sum(asked) >= SHARE * len(asked) and all(trial.trusted for trial in trials)


def summary(trials: Sequence[Trial]) -> str:
    """A line for small and finite slopes on the mesh, and for few, some and many nodes per l."""
    groups = {
        f"mesh, {slopes} slopes": [t for t in trials if t.slopes == slopes and t.rtol == t.rtol]
        for slopes in ("small", "finite")
    }
    for low, high in pairwise((FEWEST, 8.0, 50.0, MOST)):
        own = [trial for trial in trials if low <= trial.nodes <= high]
        groups[f"{low:.0f} to {high:.0f} nodes per l"] = own
    lines = [COLUMNS.head]
    for name, own in groups.items():
        counts = [sum(t.word == word for t in own) for word in ("refused", "withheld")]
        kept = [sum(getattr(t, word) for t in own) for word in ("honoured", "trusted")]
        worst = (max((getattr(t, n) for t in own), default=math.nan) for n in ("excess", "worst"))
        lines.append(COLUMNS.line(name, len(own), *counts, *kept, *worst))
    return "\n".join(lines)


def table(trials: Sequence[Trial]) -> Table:
    """Columns and a row per trial and quantity."""
    rows = [
        [*trial[:-2], *row]
        for trial in trials
        for row in zip(QUANTITIES, trial.errors, trial.estimates, strict=True)
    ]
    return [*Trial._fields[:-2], "quantity", "error", "estimate"], rows


def plot(trials: Sequence[Trial]) -> Figure:
    """Largest true error and estimate against rtol, and on nodes against their number."""
    figure, panels = canvas(12.5, 4.4, 1, 3, sharey=True)
    for axes, slopes in zip(panels, ("small", "finite", "nodes"), strict=True):
        nodes = slopes == "nodes"
        own = [t for t in trials if (t.nodes == t.nodes if nodes else t.slopes == slopes)]
        own = [t for t in own if t.word == "estimated" and (nodes or t.rtol == t.rtol)]
        x = [t.nodes if nodes else t.rtol for t in own]
        for values, marker, colour, label in (
            ([max(t.estimates) for t in own], "^", ORANGE, "largest estimate"),
            ([max(*t.errors, 1e-17) for t in own], "o", BLUE, "largest true error"),
        ):
            axes.loglog(x, values, marker, color=colour, ms=4, alpha=0.6, label=label)
        axes.set(xlabel="nodes per l" if nodes else "rtol", ylim=(3e-18, 10))
        axes.set_title(f"{'on nodes' if nodes else f'{slopes} slopes'}, {len(own)} scenes")
        axes.grid(alpha=0.3)
        if not nodes:
            limits = np.array([1e-13, FLOOR, 1e-1])
            axes.plot(limits, np.maximum(limits, FLOOR), "k--", lw=1, label="max(rtol, $10^{-12}$)")
    figure.axes[0].set_ylabel("relative error of a, P or U")
    figure.axes[0].legend(loc="upper left", fontsize=9)
    kept = sum(trial.honoured and trial.trusted for trial in trials)
    figure.suptitle(
        f"rtol is honoured and the estimate covers the error in {kept} of {len(trials)} scenes"
    )
    return figure


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    full, quick = Parameters(), Parameters(scenes=60, lattices=100)
    told = "60 scenes, 100 on nodes"
    p, jobs, out = command.start("tolerance", __doc__, argv, told, full, quick)
    trials = run(p, jobs=jobs)
    out.table("tolerance.csv", p, *table(trials))
    out.figure("tolerance.png", plot(trials))
    print(summary(trials))
    asked = [trial for trial in trials if trial.rtol == trial.rtol]
    command.answer(
        f"rtol is honoured in {sum(t.honoured for t in asked)} of {len(asked)} scenes; "
        f"error_estimate covers the true error in {sum(t.trusted for t in trials)} of all "
        f"{len(trials)}, {len(trials) - len(asked)} of them on nodes."
    )
    return 0 if passed(trials) else 1
