"""Random lattice states, coarse ones among them, next to closed forms: material for `tolerance`.

Every built-in body, small and finite slopes, 2 to 400 nodes per elastocapillary length, at any
offset of the nodes from the body; contacts from a fraction of a link up.
"""

import math
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import Any, NamedTuple

import numpy as np

from discretization import NotCertifiedError
from discretization.inside import on_lattice
from studies.shared.batches import Progress, each
from studies.shared.random_cases import Case, in_turn
from studies.shared.table import Columns, Table
from studies.shared.types import QUANTITIES

FEWEST, MOST = 2.0, 400.0  # nodes per l
UNKNOWN = (math.nan,) * 3
COLUMNS = Columns("nodes per l -11|states 7|refused 8|withheld 9|trusted 8|worst e/estimate 17.2g")
ROUNDING = 1e-14  # of errors relative to the sums of their terms


class Sparse(NamedTuple):
    """True errors and estimates of half-width, force and energy of one state on nodes.

    nodes: per l; links: in contact; word: "estimated", "withheld" or why it was "refused".
    """

    shape: str
    slopes: str
    nodes: float
    links: float
    word: str
    errors: tuple[float, ...]
    estimates: tuple[float, ...]

    @property
    def worst(self) -> float:
        """Largest error over its estimate; 0 where the estimates are withheld."""
        if self.word != "estimated":
            return 0.0
        pairs = zip(self.errors, self.estimates, strict=True)
        return max(e / max(estimate, ROUNDING) for e, estimate in pairs)

    @property
    def trusted(self) -> bool:
        """Whether no estimate is below a tenth of its error."""
        return self.worst <= 10


def drawn(count: int, seed: int) -> Iterator[tuple[Case, float, float]]:
    """So many scenes, each with its nodes per l and the offset of a node in links."""
    rng = np.random.default_rng(seed)
    for i in range(count):
        case = in_turn(rng, i)
        nodes = math.exp(rng.uniform(math.log(FEWEST), math.log(MOST)))
        yield case, nodes, float(rng.choice([0.0, rng.uniform(-0.5, 0.5)]))


def measure(given: tuple[Case, float, float]) -> Sparse:
    """Solve one scene on its nodes and compare it with its cards."""
    case, nodes, offset = given
    dx = case.scene.elastocapillary_length / nodes
    scene = replace(case.scene, indenter=case.scene.indenter.shifted(offset * dx))
    kind = case.shape, scene.slopes, nodes
    try:
        state = on_lattice(scene, case.depth, dx, origin=None if not offset else 0.0)
    except (ValueError, NotCertifiedError):
        return Sparse(*kind, math.nan, "refused", UNKNOWN, UNKNOWN)
    estimates = tuple(float(state.error_estimate[name]) for name in QUANTITIES)
    links = float(np.diff(state.nodes).sum()) / dx
    word = "estimated" if max(estimates) < math.inf else "withheld"
    width = state.half_width or state.spacing
    errors = case.errors(state, width) if state.contacts.size else (math.inf,) * 3
    return Sparse(*kind, links, word, errors, estimates)


def run(count: int, seed: int, show: Callable[[Progress], object], jobs: int = 1) -> list[Sparse]:
    """So many states, in `jobs` processes."""
    return list(each(measure, list(drawn(count, seed)), jobs, show))


def summary(states: Sequence[Sparse]) -> str:
    """A line for few, some and many nodes per l."""
    lines = [COLUMNS.head]
    for low, high in pairwise((FEWEST, 8.0, 50.0, MOST)):
        own = [state for state in states if low <= state.nodes <= high]
        counts = [sum(s.word == word for s in own) for word in ("refused", "withheld")]
        judged = sum(s.trusted for s in own), max((s.worst for s in own), default=0.0)
        lines.append(COLUMNS.line(f"{low:5.0f}-{high:<5.0f}", len(own), *counts, *judged))
    return "\n".join(lines)


def table(trials: Sequence[Any]) -> Table:
    """Columns and a row per trial and quantity, of trials that end with errors and estimates."""
    rows = [
        [*trial[:-2], *row]
        for trial in trials
        for row in zip(QUANTITIES, trial.errors, trial.estimates, strict=True)
    ]
    return [*trials[0]._fields[:-2], "quantity", "error", "estimate"], rows
