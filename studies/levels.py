"""How do nodes and the mesh share the work on several contacts: who finds, and who has the digits?

A wavy cylinder, f = x²/(2R) + A (1 - cos(2πx/λ + φ)), is pressed and pulled off, twice:

- on nodes, energies of contact sets say which contacts there are and in which order events come;
- on the mesh, the lines of those contacts are taken to rest by Newton's method, and the depths of
  the events are roots: a gap, for example, is lost where its two lines have no place to rest any
  more, det ∂D/∂x = 0. Just before, its width goes like the square root of the depth that is left.

Compared on nodes of growing number in l = √(γ₁/k), next to the refined path: the largest
difference of a line, in l (lines on nodes stand on nodes, so that half a link is expected); that of
the depth of an event, in δ₀; and that of the energy released at an event, over all that is lost
(both of second order). Kinds and order of events must be the same.

Output: a line per number of nodes, levels.csv, levels.png. Exit status 1 if nodes find other events
than the mesh, the energy balance of the refined path is off, or a part of it is not refined.
"""

# Conventions:
# - `command.start` gives the parameters of the preset, the number of processes and the output
#   `out`.
# - `out.table(name, parameters, columns, rows)` and `out.figures` write into its folder.
# - `show` gets lines of text as they come; `silent` drops them, and `command.say` prints them.
# - A `Table` is the names of its columns, and its rows.
# - `Columns` writes tables on the screen: `head` is the first line, `line(*cells)` any other.
# - `canvas(width, height, rows, columns)` gives a new figure of this size in inches, and its axes.
# - `prefixed(values, unit)` is the unit with a prefix that suits the values: they are divided by
#   its `size`, and its `symbol` is written.
# - `quantity(value, unit)` is a text such as 20 mN/m.
# - `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the
#   states at these values one after the other: a `History` with arrays `depth`, `force` (positive
#   where it presses), `half_width`; `events`, the jumps and other events in their order, each with
#   a kind, the states `before` and `after` it and the `energy_released`; `dissipated`, the energy
#   that it loses; `work()`, the ∮ P dd.
# - `minimise(scene, depth)` is the equilibrium of the path that touches first and then moves to
#   this depth, d positive into the layer; with method="lattice" it is that on nodes of a spacing.
# - A scene has `gamma1` γ₁, `elastocapillary_length` l = √(γ₁/k) and `critical_separation` δ₀ =
#   √(2w/k).
# - `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
# - `Profile(height, slope)` is a profile given by two functions.
# - `state.displacement(x)` is u, positive into the layer.
# - `path.at(step)` is the state at a step; its `lines` are the ends of all contacts, left and right
#   in turn.

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from discretization import History, load_path, minimise
from energy import ElasticLayer, Profile, Scene, SurfaceEnergies
from energy.arrays import Array
from energy.units import prefixed, quantity
from studies.shared import command
from studies.shared.batches import Show, each, silent
from studies.shared.figures import (
    BLUE,
    COLOURS,
    GREY,
    MARKERS,
    ORANGE,
    RIGID,
    SOFT,
    Figure,
    canvas,
    shades,
)
from studies.shared.table import Columns, Table

BALANCE = 1e-9  # of the energy lost: how well work and released energies must agree
ENCLOSED = "coalescence"  # the kind of event that is enlarged
BEFORE = 0.03  # of δ₀: how much of the path before it
AFTER = 0.004  # of δ₀: how much of the path beyond it
CLOSE = 160  # depths there


@dataclass(frozen=True)
class WavyCylinder:
    """f = x²/(2R) + A (1 - cos(2πx/λ + φ))."""

    R: float
    amplitude: float
    wave: float
    phase: float

    def height(self, x: ArrayLike) -> Array:
        """f, vectorised."""
        at = np.asarray(x, float)
        q = 2 * np.pi / self.wave
        waves = 1 - np.cos(q * at + self.phase)
        return np.asarray(at**2 / (2 * self.R) + self.amplitude * waves)

    def slope(self, x: ArrayLike) -> Array:
        """f'."""
        at = np.asarray(x, float)
        q = 2 * np.pi / self.wave
        return np.asarray(at / self.R + self.amplitude * q * np.sin(q * at + self.phase))


@dataclass(frozen=True)
class Parameters:
    """Layer, energies and wavy cylinder [SI]; top, bottom: of the depth, the latter in δ₀.

    nodes: in l; drawn: of these, for contacts; steps: of the loading.
    """

    E: float = 2.5e3
    nu: float = 0.3
    h: float = 5e-6
    gamma1: float = 0.07
    w: float = 4e-6
    R: float = 0.3
    amplitude: float = 0.2e-6
    wave: float = 180e-6
    phase: float = 0.5
    top: float = 5e-7
    bottom: float = -0.9
    steps: int = 101
    nodes: tuple[int, ...] = (6, 12, 25, 50, 100)
    drawn: int = 6

    @property
    def scene(self) -> Scene:
        """The cylinder on its layer."""
        surfaces = SurfaceEnergies.from_work(self.gamma1, self.w)
        cylinder = WavyCylinder(self.R, self.amplitude, self.wave, self.phase)
        profile = Profile(cylinder.height, cylinder.slope)
        return Scene(ElasticLayer(self.E, self.nu, self.h), surfaces, profile)

    @property
    def depths(self) -> Array:
        """Pressed to the top, and pulled."""
        last = self.bottom * self.scene.critical_separation
        return np.r_[np.linspace(0, self.top, self.steps), np.linspace(self.top, last, self.steps)]


QUICK = Parameters(steps=31, nodes=(6, 12, 25, 50))  # fewer depths, and without the finest nodes


class Errors(NamedTuple):
    """Largest differences of a path on nodes to the refined path; NaN if events differ in kind.

    Attributes
    ----------
    nodes : int
        In l.
    line : float
        Of a contact line at any step, over l.
    depth : float
        Of the depth of an event, over δ₀.
    energy : float
        Of the energy that an event releases, over all that the refined path loses.
    same : bool
        Whether kinds and order of events are those of the refined path.
    """

    nodes: int
    line: float
    depth: float
    energy: float
    same: bool


class Enlarged(NamedTuple):
    """The width of the gap that an event closes, near the depth of that event.

    Attributes
    ----------
    depth, width : ndarray (CLOSE,)
        Depths, and widths there [m]; 0 where the gap is closed.
    event : float
        Depth at which it closes [m].
    """

    depth: Array
    width: Array
    event: float


@dataclass(frozen=True, eq=False)
class Record:
    """The path, refined and on nodes, and all of them once more near one event.

    Attributes
    ----------
    parameters : Parameters
    refined : History
    on_nodes : dict
        Paths by their number of nodes in l.
    enlarged : dict
        By the number of nodes in l; 0: refined.
    """

    parameters: Parameters
    refined: History
    on_nodes: dict[int, History]
    enlarged: dict[int, Enlarged]

    @property
    def errors(self) -> list[Errors]:
        """For each number of nodes."""
        return [errors(self.refined, path, nodes) for nodes, path in self.on_nodes.items()]

    @property
    def balance(self) -> float:
        """Work over the energy that is lost, from the refined path, less 1."""
        closed = self.refined.work() - self.refined.at(-1).energy
        return abs(closed / self.refined.dissipated - 1)

    @property
    def passed(self) -> bool:
        """Whether all events agree, the balance holds, and all is refined."""
        alike = all(one.same for one in self.errors)
        return alike and self.balance <= BALANCE and not self.refined.on_nodes


def followed(params: Parameters, depths: Array, nodes: int) -> History:
    """The path on so many nodes in l, refined if 0."""
    scene = params.scene
    if not nodes:
        return load_path(scene, depths=depths)
    spacing = scene.elastocapillary_length / nodes
    return load_path(scene, depths=depths, method="lattice", spacing=spacing)


def run(params: Parameters = Parameters(), show: Show = silent, jobs: int = 1) -> Record:
    """All paths, in `jobs` processes; `show` gets a line per number of nodes."""
    counts = [0, *params.nodes]
    paths = list(each(partial(followed, params, params.depths), counts, jobs))
    on_nodes = dict(zip(params.nodes, paths[1:], strict=True))
    record = Record(params, paths[0], on_nodes, enlarged(params, paths[0], jobs))
    show(COLUMNS.head)
    for one in record.errors:
        show(COLUMNS.line(*one[:4], "yes" if one.same else "NO"))
    return record


def enlarged(params: Parameters, refined: History, jobs: int) -> dict[int, Enlarged]:
    """The neighbourhood of one event, refined (0) and on nodes of each number."""
    chosen = next(event for event in refined.events if event.kind == ENCLOSED)
    gap = gap_that_closes(chosen.before.lines, chosen.after.lines)
    depths = close_to(chosen.before.depth, params.scene.critical_separation)
    counts = [0, *params.nodes]
    paths = each(partial(followed, params, depths), counts, jobs)
    return {count: beside(path, gap) for count, path in zip(counts, paths, strict=True)}


def close_to(depth: float, size: float) -> Array:
    """From first touch to just beyond the depth of an event, with many steps beside it."""
    start = depth - BEFORE * size
    fine = np.linspace(start, depth + AFTER * size, CLOSE)
    return np.r_[np.linspace(0, start, CLOSE // 4, endpoint=False), fine]


def gaps(lines: Sequence[float]) -> list[tuple[float, float]]:
    """The ends of the free surfaces between contacts, from left to right.

    lines: the ends of all contacts, left and right in turn; a gap is between the right end of one
    contact and the left one of the next.
    """
    return list(zip(lines[1:-1:2], lines[2::2], strict=True))


def gap_that_closes(before: Sequence[float], after: Sequence[float]) -> float:
    """The middle of the gap that is there before an event and not after it."""
    middles = [(left + right) / 2 for left, right in gaps(before)]
    return next(middle for middle in middles if not width_at(after, middle))


def beside(path: History, gap: float) -> Enlarged:
    """The width of the gap around a place over the depth, and the depth at which it is closed.

    path: through the depths of `close_to`, of which the last CLOSE are near the event.
    """
    depth = path.depth[-CLOSE:]
    width = np.array([width_at(path.at(len(path) - CLOSE + i).lines, gap) for i in range(CLOSE)])
    events = [event for event in path.events if event.kind == ENCLOSED]
    closing = [event for event in events if width_at(event.after.lines, gap) == 0]
    return Enlarged(depth, width, closing[0].before.depth)


def width_at(lines: Sequence[float], x: float) -> float:
    """Width of the gap in which x lies, between these lines; 0 if x is in contact."""
    return sum(right - left for left, right in gaps(lines) if left < x < right)


def errors(refined: History, path: History, nodes: int) -> Errors:
    """Largest differences of a path on nodes to the refined one."""
    scene = refined.scene
    kinds = [[event.kind for event in one.events] for one in (refined, path)]
    if kinds[0] != kinds[1]:
        return Errors(nodes, np.nan, np.nan, np.nan, False)
    pairs = list(zip(refined.events, path.events, strict=True))
    depth = max(abs(one.before.depth - other.before.depth) for one, other in pairs)
    energy = max(abs(one.energy_released - other.energy_released) for one, other in pairs)
    line = max(apart(refined, path, step) for step in range(len(refined)))
    return Errors(
        nodes,
        line / scene.elastocapillary_length,
        depth / scene.critical_separation,
        energy / refined.dissipated,
        True,
    )


def apart(refined: History, path: History, step: int) -> float:
    """The largest distance of lines that correspond; 0 at a step between their events."""
    one = refined.at(step).lines
    other = path.at(step).lines
    if len(one) != len(other) or np.isnan([*one, *other]).any():
        return 0.0
    at_event = {event.step for path in (refined, path) for event in path.events}
    return 0.0 if step in at_event else float(np.abs(np.subtract(one, other)).max())


COLUMNS = Columns("nodes in l 11|line/l 9.1e|event/δ₀ 9.1e|energy 9.1e|same events 12")


def plot(record: Record) -> Figure:
    """Contacts on nodes; lines refined; an event enclosed; and how fast nodes converge."""
    figure, ((contacts, closing), (lines, convergence)) = canvas(11, 8.2, 2, 2)
    _contacts(contacts, record)
    _lines(lines, record)
    _enclosed(closing, record)
    _convergence(convergence, record)
    figure.suptitle(
        "Nodes find contacts and the order of events, the mesh refines lines and depths"
    )
    return figure


def _contacts(axes: Any, record: Record) -> None:
    """Indenter, surface, contact nodes and refined lines at the step with most contacts."""
    params = record.parameters
    path = record.refined
    step = int(np.argmax([len(path.at(i).lines) for i in range(params.steps)]))
    lines = path.at(step).lines
    nodes = nodes_in_contact(params, record.on_nodes[params.drawn].at(step).lines)
    state = minimise(params.scene, float(path.depth[step]))
    x = np.linspace(1.15 * lines[0], 1.15 * lines[-1], 2001)
    across = prefixed(x, "m")
    up = prefixed(state.displacement(x), "m")

    def indenter(at: Array) -> Array:
        """The profile as it is drawn over the axis of u: d - f, in its unit."""
        return np.asarray((state.depth - params.scene.indenter.height(at)) / up.size)

    surface = state.displacement(x) / up.size
    margin = 0.4 * np.ptp(surface)
    top = surface.min() - margin
    bottom = surface.max() + margin
    axes.fill_between(x / across.size, indenter(x), top, color=RIGID, lw=0, label="indenter")
    axes.fill_between(x / across.size, surface, bottom, color=SOFT, lw=0, label="layer")
    label = f"contact nodes, {params.drawn} in l"
    axes.plot(nodes / across.size, indenter(nodes), ".", color=BLUE, ms=4, label=label)
    for line in lines:
        axes.axvline(line / across.size, color=ORANGE, lw=1)
    axes.plot([], [], color=ORANGE, lw=1, label="refined lines")
    axes.set(xlim=(x[0] / across.size, x[-1] / across.size), ylim=(bottom, top))
    axes.set(xlabel=f"x in {across.symbol}", ylabel=f"displacement in {up.symbol}")
    axes.set_title(f"{len(lines) // 2} contacts at d = {quantity(state.depth, 'm')} (not to scale)")
    axes.legend(fontsize=9, loc="lower center", ncols=2)


def nodes_in_contact(params: Parameters, lines: Sequence[float]) -> Array:
    """Positions of all contact nodes between these lines, which stand on nodes."""
    spacing = params.scene.elastocapillary_length / params.drawn
    pairs = zip(lines[::2], lines[1::2], strict=True)
    return np.concatenate([np.arange(left, right + spacing / 2, spacing) for left, right in pairs])


def _lines(axes: Any, record: Record) -> None:
    """Contact lines over the depth while the cylinder is pressed: on nodes, and refined."""
    params = record.parameters
    across = prefixed(record.refined.contacts, "m")
    down = prefixed(record.refined.depth, "m")
    for path, style in (
        (record.on_nodes[params.drawn], {"color": BLUE, "ms": 5, "marker": "."}),
        (record.refined, {"color": ORANGE, "ms": 1.5, "marker": "."}),
    ):
        found = [
            (path.depth[step] / down.size, line / across.size)
            for step in range(params.steps)
            for line in path.at(step).lines
        ]
        axes.plot(*np.transpose(found), ls="", **style)
    for event in record.refined.events:
        if event.step < params.steps:
            axes.axvline(event.before.depth / down.size, color=GREY, lw=0.8, ls="--")
    axes.plot([], [], ".", color=BLUE, label=f"lines on {params.drawn} nodes in l")
    axes.plot([], [], ".", color=ORANGE, ms=3, label="refined")
    axes.plot([], [], "--", color=GREY, lw=0.8, label="events")
    axes.set(xlabel=f"depth d in {down.symbol}", ylabel=f"contact lines x in {across.symbol}")
    axes.set_title("while the cylinder is pressed")
    axes.legend(fontsize=9, loc="upper left")


def _enclosed(axes: Any, record: Record) -> None:
    """The width of the gap that an event closes."""
    params = record.parameters
    length = params.scene.elastocapillary_length
    size = params.scene.critical_separation
    refined = record.enlarged[0]
    counts = params.nodes[:3]
    for count, marker, colour in zip(counts, MARKERS, shades(len(counts), top=0.7), strict=False):
        one = record.enlarged[count]
        x = (one.depth - refined.event) / size
        held = one.width > 0
        label = f"{count} nodes in l"
        axes.plot(
            x[held][::4], one.width[held][::4] / length, marker, color=colour, ms=4, label=label
        )
        axes.axvline((one.event - refined.event) / size, color=colour, ls=":", lw=1.2)
    held = refined.width > 0
    x = (refined.depth - refined.event) / size
    axes.plot(x[held], refined.width[held] / length, color=ORANGE, lw=1.8, label="refined")
    axes.axvline(0, color=ORANGE, lw=1)
    axes.set(xlabel="depth from that of the event, over δ₀", ylabel="width of the gap over l")
    axes.set_title("an event enclosed: a gap is lost at the vertical lines")
    axes.legend(fontsize=9, loc="lower left")
    axes.grid(alpha=0.25)


def _convergence(axes: Any, record: Record) -> None:
    """Differences to the refined path over the number of nodes."""
    found = [one for one in record.errors if one.same]
    counts = np.array([one.nodes for one in found])
    names = {"line": "a line, over l", "depth": "depth of an event, over δ₀"}
    names["energy"] = "energy released, over all that is lost"
    for (name, label), marker, colour in zip(names.items(), MARKERS, COLOURS, strict=False):
        values = [getattr(one, name) for one in found]
        axes.loglog(counts, values, marker=marker, ms=5, color=colour, label=label)
    axes.loglog(counts, 0.5 / counts, ":", color="black", lw=1, label="half a link; second order")
    first = found[0].energy
    axes.loglog(counts, 0.5 * first * (counts[0] / counts) ** 2, ":", color="black", lw=1)
    axes.set(
        xlabel="nodes in the elastocapillary length l", ylabel="difference to the refined path"
    )
    axes.set_xticks(counts, [f"{count}" for count in counts])
    axes.minorticks_off()
    axes.set_ylim(top=20)  # room for the legend
    axes.set_title(f"refined, the energy balance closes to {record.balance:.0e}")
    axes.legend(fontsize=9, loc="upper right")
    axes.grid(alpha=0.25)


def table(record: Record) -> Table:
    """Columns and a row per number of nodes."""
    return list(Errors._fields), [list(one) for one in record.errors]


def answer(record: Record) -> str:
    """Who finds, and who has the digits."""
    finest = record.errors[-1]
    count = len(record.refined.events)
    if not record.passed:
        return (
            "They do not agree here: nodes find other events, or the refined path is not balanced."
        )
    return (
        f"Nodes find the same {count} events in the same order, on {finest.nodes} nodes in l with "
        f"depths within {finest.depth:.0e} δ₀ and lines within {finest.line:.0e} l; refined, the "
        f"energy balance of the path closes to {record.balance:.0e}."
    )


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    given = "levels", __doc__, argv, "fewer steps and nodes", Parameters(), QUICK
    params, jobs, out = command.start(*given)
    record = run(params, command.say, jobs)
    out.table("levels.csv", params, *table(record))
    out.figure("levels.png", plot(record))
    command.answer(answer(record))
    return int(not record.passed)
