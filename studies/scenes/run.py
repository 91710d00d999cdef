"""What are the equilibria of the scene in this file, what is its response along a load path?

At each depth the energy U[u] is minimised (discretization.minimise); the table, SCENE.csv and
SCENE.png tell the half-width a, the force P (11), the energy U, the contact angle θ (12) and the
surface u(x) with the error estimate of each state, and how far the model's assumptions hold there.
Every depth is the end of a path of its own: touch first, then move to this depth. A [path] in the
file is followed by discretization.load_path: its events, SCENE_path.csv (exact, History.from_csv
reads it) and SCENE_path.png. A file with a list or range for any other number is a sweep: see
`python -m studies sweep -h`. `python -m studies new FILE` writes a scene file to start from.
"""

# Conventions:
# - `command.parser` has the options of all studies; `command.parse` gives them and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - A `Table` is the names of its columns, and its rows.
# - `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
# - `prefixed(values, unit)` is the unit with a prefix that suits the values: they are divided by
#   its `size`, and its `symbol` is written.
# - A `SceneFile` has scene, depths and load path; `axes` are its lists and ranges.
# - An `Assumption` has a `value` that holds up to its `limit`.
# - `validity` of a state are all of its assumptions, `error_estimate` its relative errors,
#   `uncertainty` the absolute ones.
# - `described` says a scene in words.
# - `built(path, content)` makes a `SceneFile` of the tables that `read` gives; `coarser` thins the
#   lists and ranges of these for a first look. `follow` is the load path of the file.
# - `plots.draw_state` draws one state; `readings.OBSERVABLES` are the names of the numbers of a
#   state, in the order of the columns. QUANTITIES are those with an error.
# - `Progress.remaining` are the seconds to go.

import itertools
import json
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any

import numpy as np

from discretization import Equilibrium, minimise, plots, readings
from energy import Assumption, Scene
from energy.description import described
from energy.units import prefixed
from studies.scenes.file import SceneFile, built, read
from studies.scenes.grid import axes, coarser, follow
from studies.scenes.sweep import study as sweep
from studies.shared import QUANTITIES, command
from studies.shared.batches import Progress, each, tell
from studies.shared.figures import BLUE, GREY, ORANGE, canvas
from studies.shared.table import Table, naming

SIGNS = (
    "signs: depth > 0 into the layer, force > 0 compressive, energy 0 for the flat surface "
    "without contact"
)
_LONG = 3.0  # s to go from which progress is shown: less is over before it is read
LINE = "per unit length of the line contact"
MARKERS = {"global": "o", "metastable": "s", "adhered": "D", "neutral": "^", "detached": "x"}


@dataclass(frozen=True)
class Record:
    """A scene file and its equilibrium at each depth."""

    given: SceneFile
    states: tuple[Equilibrium, ...]

    @property
    def attached(self) -> tuple[Equilibrium, ...]:
        """The states in contact."""
        return tuple(state for state in self.states if state.label != "detached")

    @property
    def worst(self) -> Equilibrium:
        """The state in contact that strains the assumptions most."""
        return max(self.attached, key=strains)


def violations(states: Sequence[Equilibrium]) -> tuple[tuple[Assumption, float], ...]:
    """Each assumption that a state violates, at its worst, and the depth where that is."""
    found: dict[str, list[tuple[Assumption, float]]] = {}
    for state in states:
        for one in broken(state):
            found.setdefault(one.name, []).append((one, state.depth))
    return tuple(max(same, key=lambda pair: pair[0].value) for same in found.values())


def strains(state: Equilibrium) -> list[float]:
    """Measures of the assumptions over their limits, largest first; all hold up to 1."""
    return sorted((one.value / one.limit for one in state.validity), reverse=True)


def broken(state: Equilibrium) -> list[Assumption]:
    """The assumptions that do not hold."""
    return [one for one in state.validity if not one.holds]


def run(
    given: SceneFile, show: Callable[[Equilibrium], object] = lambda state: None, jobs: int = 1
) -> Record:
    """The equilibrium at each depth of the file.

    Parameters
    ----------
    given : SceneFile
    show : callable, optional
        Gets each state as soon as it is found.
    jobs : int
        Number of processes.

    Returns
    -------
    Record
    """
    depths = given.depths.tolist()
    return Record(given, tuple(each(partial(solved, given), depths, jobs, _long, show)))


def _long(progress: Progress) -> None:
    """Tell the progress of long work only: the rows of short work say as much."""
    if progress.remaining > _LONG:
        tell(progress)


def solved(given: SceneFile, depth: float) -> Equilibrium:
    """The equilibrium at a depth. ValueError names file and depth."""
    try:
        return minimise(given.scene, depth, **given.options)
    except ValueError as error:
        raise ValueError(f"{given.path}: depth = {depth!r}: {error}") from error


def row(state: Equilibrium) -> str:
    """One line of the table on the screen, in SI units."""
    values = [f"{getattr(state, name):>13.6g}" for name in readings.OBSERVABLES]
    error = max(state.error_estimate.values())
    violated = ", ".join(one.name for one in broken(state))
    verdict = f"  violated: {violated}" if violated else ""
    told = f"{error:>9.0e}" if math.isfinite(error) else "  not res."
    return "".join(values) + f"{told}  {state.label}{verdict}"


def heading(scene: Scene) -> str:
    """The line above the rows."""
    width = "radius/m" if scene.axisymmetric else "half-width/m"
    force, energy = ("N", "J") if scene.axisymmetric else ("(N/m)", "(J/m)")
    names = ("depth/m", width, f"force/{force}", f"energy/{energy}", "angle/rad")
    return "".join(f"{name:>13}" for name in names) + f"{'rel. err':>9}  state"


def summary(record: Record) -> str:
    """In how many states all assumptions hold, and the report on the worst."""
    if not record.attached:
        return "\nno state is in contact"
    count = sum(not state.warnings for state in record.attached)
    total = len(record.attached)
    text = f"all assumptions hold in {count} of {total} states in contact; the worst of them:"
    return f"\n{text}\n{record.worst}"


def table(record: Record) -> Table:
    """Columns and a row per depth."""
    columns = [*readings.OBSERVABLES, *(f"error_{name}" for name in QUANTITIES)]
    rows = [[*(repr(s.to_dict()[name]) for name in columns), s.label] for s in record.states]
    return [*columns, "label"], rows


def notes(given: SceneFile) -> list[str]:
    """Title, source, the scene in words and exactly, and the units of the table."""
    scene: Scene = given.scene
    what = "of the whole contact, half_width the radius" if scene.axisymmetric else LINE
    return [
        *(f"title: {given.title}", f"source: {given.source}"),
        *(str(scene.layer), str(scene.surfaces), str(scene.indenter)),
        f"scene: {json.dumps(described(scene))}",
        f"units: SI, {what}: depth and half_width in m, force in N{scene.per_length}, energy in "
        f"J{scene.per_length}, contact_angle in rad; error_* are estimated errors in these units; "
        "inf: the lattice does not resolve the state",
        SIGNS,
    ]


def plot(record: Record) -> Any:
    """Surface and contact line of the last state in contact; above them P(d) and a(d)."""
    several = len(record.states) > 1
    state = (record.attached or record.states)[-1]
    figure, axes = canvas(11, 9 if several else 5, 1 + several, 2, squeeze=False)
    if several:
        _curve(axes[0, 0], record, "force", "force P", f"N{state.scene.per_length}")
        width = "radius a" if state.scene.axisymmetric else "half-width a"
        _curve(axes[0, 1], record, "half_width", width, "m")
    plots.draw_state(axes[-1], state, last=several and bool(record.attached))
    figure.suptitle(record.given.title, fontsize=14)
    plots.note(figure, [one for one, _ in violations(record.attached)])
    return figure


def _curve(axes: Any, record: Record, name: str, quantity: str, unit: str) -> None:
    """An observable over the depth: a line through the states in contact; markers by label."""
    states = record.states
    depths = np.array([state.depth for state in states])
    values = np.array([getattr(state, name) for state in states])
    values[~np.isfinite(values)] = np.nan
    error = np.array([state.uncertainty[name] for state in states])
    error[~np.isfinite(error)] = 0.0
    x = prefixed(depths, "m")
    y = prefixed(values, unit)
    labels = np.array([state.label for state in states])
    free = labels == "detached"
    bad = np.array([bool(state.warnings) for state in states]) & ~free
    axes.plot(depths / x.size, np.where(free, np.nan, values) / y.size, color=BLUE, lw=1)
    for (label, marker), violated in itertools.product(MARKERS.items(), (False, True)):
        chosen = (labels == label) & (bad == violated)
        if chosen.any():
            at = depths[chosen] / x.size
            height = values[chosen] / y.size
            colour = GREY if label == "detached" else ORANGE if violated else BLUE
            text = f"{label}, an assumption violated" if violated else label
            fill = "white" if violated else colour
            style = {"color": colour, "marker": marker, "mfc": fill, "label": text}
            spread = error[chosen] / y.size
            axes.errorbar(at, height, yerr=spread, ls="", ms=4, capsize=2, **style)
    axes.axhline(0, color=GREY, lw=0.8)
    axes.set(xlabel=f"depth d in {x.symbol}", ylabel=f"{quantity} in {y.symbol}")
    axes.set_title("force (P > 0: compressive)" if name == "force" else f"contact {quantity[:-2]}")
    axes.legend()


def main(argv: Sequence[str] | None = None) -> int:
    """Solve the scene file, print and write; errors of the file are ValueErrors."""
    quick = "at most 5 depths, and 10 steps between turning points"
    parser = command.parser("run", __doc__, quick, jobs=1)
    parser.add_argument("scene", type=Path, help="scene file, for instance studies/scenes/*.toml")
    options, out = command.parse(parser, argv)
    content = read(options.scene)
    if any(axis.key != "depth" for axis in axes(options.scene, content)):
        return sweep.main(argv)
    if options.preset == "quick":
        content = coarser(content)
    given = built(options.scene, content)
    print(given.title)
    written = equilibria(given, out, options.jobs, options.json) if given.depths.size else []
    if given.programme is not None:
        written += response(given, out, options.json)
    print(f"written: {', '.join(map(str, written))}")
    return 0


def as_json(name: str, value: Any) -> str:
    """A line with numbers that --json shows; what is not finite, and no number in JSON, is null."""

    def plain(item: Any) -> Any:
        """The same with null for numbers that are not finite, which JSON does not have."""
        if isinstance(item, dict):
            return {key: plain(part) for key, part in item.items()}
        if isinstance(item, list):
            return [plain(part) for part in item]
        return item if not isinstance(item, float) or math.isfinite(item) else None

    return f"json: {json.dumps({name: plain(value)})}"


def equilibria(
    given: SceneFile, out: command.Output, jobs: int, show_json: bool = False
) -> list[Path]:
    """Solve, print and write the states at the depths of the file.

    Parameters
    ----------
    given : SceneFile
    out : Output
    jobs : int
        Number of processes.
    show_json : bool
        Whether to print the states as JSON, too.

    Returns
    -------
    list of Path
        The files written.
    """
    if given.depths.size == 1:
        record = run(given, show=print)
    else:
        print(heading(given.scene))
        record = run(given, lambda state: command.say(row(state)), jobs)
        print(summary(record))
    if show_json:
        print(as_json("states", [state.to_dict() for state in record.states]))
    name = given.path.stem
    chosen = {"slopes": given.scene.slopes, "options": given.options}
    written = out.table(f"{name}.csv", chosen, *table(record), notes=notes(given))
    return [written, *out.figure(name, plot(record))]


def response(given: SceneFile, out: command.Output, show_json: bool = False) -> list[Path]:
    """Follow, print and write the load path of the file.

    Parameters
    ----------
    given : SceneFile
    out : Output
    show_json : bool
        Whether to print the path as JSON, too.

    Returns
    -------
    list of Path
        The files written.
    """
    history = follow(given)
    print(readings.path_text(history, si=True))
    if show_json:
        events = [
            {
                "kind": event.kind,
                "depth": event.depth,
                "force": event.force,
                "lost": event.energy_released,
            }
            for event in history.events
        ]
        steps = {name: column.tolist() for name, column in history.to_dict().items()}
        print(as_json("path", {"events": events, "steps": steps}))
    name = f"{given.path.stem}_path"
    written = out.at(f"{name}.csv")
    about = [f"title: {given.title}", f"source: {given.source}", *out.header(given.options)]
    with naming(written):
        history.to_csv(written)  # which History.from_csv reads back; the notes follow as comments
        with written.open("a", encoding="utf-8") as file:
            file.writelines(f"# {' '.join(note.split())}\n" for note in about)
    return [written, *out.figure(name, history.plot(given.title))]
