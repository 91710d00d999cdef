"""A load path: what was recorded at every step, its events, and the balance of its energy.

Conventions
-----------
The depth d is positive down into the layer [length]; the force P is positive where the indenter is
pressed, so that the pull-off force is negative; U is 0 without contact and contains - w times what
is in contact. Of a line contact P and U count per length of it. The value of the control is the
depth, the load F, or the position D of a machine, positive down (control.py). Lines are positions x
[length] from left to right, radii about an axis, where the left one of a disc is 0; nan stands for
no contact.

A `Snapshot` is a state with its force and energy, an `Event` has the snapshots `before` and `after`
it, with the number of the `step` that follows and the energy lost, `energy_released`. A `Point` is
the contacts at a depth as the branch knows them, `lines` None without contact, and a `PathSegment`
the part of the path between two points without an event. `Branch.contact(depth, *lines)` is the
point with these lines, `segment(point, goal)` the path from there towards a depth, up to the first
event; of that, `external_work` is ∫P dd. `snapshot` is a point with its energy and force, and
`closes_at` whether it is known as well as states are at which depth a last contact closes.
`branch_of` chooses the branch of a scene. A `LoadPath` has followed values of the control (`go`)
and has `points`, one a step. `Curve.of(segment, Control(0.0))` are samples of P along a segment,
`value`; its `refined(i, -1)` is the point of the minimum at the sample i.

`monotone` cuts recorded states into `Stretch`es, along which the depth changes in one direction,
and `bounded` says what P is no less than on each; a stretch's `turn(known)` is the state inside it
at which P is least, None if it is not below `known`. They are for nodes alone, whose branch is a
`LatticeBranch`; `UnknownError` says that something happens on a stretch that is no event of the
path. NOISE is what is rounding of P over the largest force. A contact of fewer than LEAST links is
not resolved. `RefinedBranch.nodal` is the branch on nodes alone that stands in where contacts are
not refined, and `row.lattice.spacing` the distance of its nodes.

`described` makes plain data of a scene, `rebuilt` a scene of these, and `alike` compares two of
them. `estimated` compares a path with one on wider nodes, by the names in QUANTITIES. What is shown
of a path stands in other modules: `plots.plot_path`, `animation.animate`, and in `readings` the
assumptions (`of_path`, `violated`), the columns of a table (`path_columns`) and texts (`path_line`,
`path_text`, `html`).
"""

from __future__ import annotations

import functools
import itertools
import json
import math
import os
import warnings
from collections.abc import Iterable, Iterator, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

import numpy as np

from discretization import animation, plots, readings
from discretization.certificate import AccuracyWarning, NotCertifiedError
from discretization.lattice.accuracy import LEAST
from discretization.paths.branch import Branch, Event, PathSegment, Point, PullOff, Snapshot
from discretization.paths.choice import branch_of
from discretization.paths.control import Control, Curve
from discretization.paths.lattice_branch import LatticeBranch
from discretization.paths.least_force import NOISE, Stretch, UnknownError, bounded, monotone
from discretization.paths.load_path import LoadPath
from discretization.paths.path_accuracy import QUANTITIES, estimated
from discretization.paths.refined_branch import RefinedBranch
from energy import Scene
from energy.arrays import Array
from energy.description import alike, described, rebuilt

# Of the pull-off force: if its last links change it by more, it is not resolved. It only decides
# about a warning.
_CHANGED = 0.1
# Spacing of the nodes with which a path is compared, over its own: errors of second order are then
# a third of the difference, and the coarser path costs half of the finer one.
_COARSER = 2.0
_TITLE = "elastocap load path"
_NOTES = (
    "in the units of the scene, of a line contact per its unit length: control [length or force],",
    "depth d [length] > 0 into the layer, force P [force] > 0 compressive, energy U [energy],",
    "lines left, right [length], nan: detached. event: kind, control, before, after (depth,",
    "force, energy, left, right, inner lines), energy released, step",
)
_HEADER = ("control", "machine_stiffness", "rtol", "spacing", "friction", "on_nodes")
_COLUMNS = ("control", "depth", "force", "energy", "left", "right", "inner")


_DETACHED = Point(-math.inf, None)  # before any contact


def _column(index: Any) -> functools.cached_property[Array]:
    """A property that is a column, or a slice of columns, of the table of a path."""
    return functools.cached_property(lambda path: path.table[:, index])


@dataclass(frozen=True, eq=False)
class History:
    """A load path of n steps, per unit length of the line contact, as `load_path` follows it.

    Attributes
    ----------
    scene, control, machine_stiffness, rtol, spacing
        What was imposed, and how: control "depth", "force" or "drive"; spacing None on the fitted
        mesh.
    values, depth, force, energy, half_width : array (n,)
        The programme, d, P > 0 compressive, U and a. An indenter that a tensile dead load has
        pulled away is at depth -inf.
    table : array (n, 6)
        The first four of these, and x of the left and the right outermost line, in its columns.
    contacts, inner : array (n, 2), and a tuple for each step
        The outermost lines, nan when detached, and those between, of several contacts.
    events : tuple of Event
    on_nodes : tuple
        First and last depths of parts of a path on the mesh that are those of nodes alone, as
        contacts found there could not be refined.
    branch : Branch, optional
        What has followed the path and knows the work done between the states; found again from the
        scene where it is not known.
    dissipated, friction : float
        Energy lost on the path, and by lines that moved without a jump under adhesion hysteresis.
    validity, warnings : tuple
        How far those assumptions of the model hold that all states share (2w/γ₁, h/l, the noise of
        samples, the nodes), and those that do not, in words; each state has more.

    Notes
    -----
    With rotational symmetry force and energy are those of the whole contact, and lines are radii.
    The energy balance of a closed path is `work()` = ∮ P dd = `dissipated`.

    Examples
    --------
    Of the path of the example of `load_path`:

    >>> print(f"{path.dissipated:.4g} J/m lost; {path.force.round(4)}")
    1.254e-08 J/m lost; [-0.0244  0.0312  0.    ]
    """

    scene: Scene
    control: str
    machine_stiffness: float | None
    rtol: float
    spacing: float | None = None
    table: Array = field(default_factory=lambda: np.empty((0, 6)))
    inner: tuple[tuple[float, ...], ...] = ()
    events: tuple[Event, ...] = ()
    friction: float = 0.0
    on_nodes: tuple[tuple[float, float], ...] = ()
    branch: Branch | None = None

    values, depth, force, energy = map(_column, range(4))
    contacts = _column(slice(4, 6))

    def extended(self, path: LoadPath, values: Array) -> History:
        """This path and its continuation.

        Parameters
        ----------
        path : LoadPath
            What has followed the continuation.
        values : ndarray (n,)
            Of the control, one for each of its steps.
        """
        points = path.points
        rows = [(point.depth, 0.0, 0.0, *point.ends) for point in points]
        table = np.column_stack([values, np.reshape(rows, (-1, 5))])
        in_contact = [i for i, point in enumerate(points) if point.lines is not None]
        if in_contact:
            lines, force, energy = path.branch.recorded([points[i] for i in in_contact])
            table[in_contact, 2:] = np.column_stack([force, energy, lines])
        return replace(
            self,
            table=np.concatenate([self.table, table]),
            inner=(*self.inner, *(point.inner for point in points)),
            events=(*self.events, *path.events),
            friction=self.friction + path.friction,
            on_nodes=(*self.on_nodes, *merged(getattr(path.branch, "on_nodes", ()))),
            branch=path.branch,
        )

    def _without_steps(self, spacing: float | None) -> History:
        """A path of the same scene and control, on nodes so far apart, that has not begun."""
        return History(self.scene, self.control, self.machine_stiffness, self.rtol, spacing)

    @property
    def half_width(self) -> Array:
        """Half the total contact length a (n,), or the outermost radius; 0 when detached."""
        return np.array([self.at(step).half_width for step in range(len(self))])

    @property
    def dissipated(self) -> float:
        """Energy lost on the path: released in the events, and to adhesion hysteresis."""
        return sum(event.energy_released for event in self.events) + self.friction

    @property
    def hold(self) -> Control:
        """What holds the indenter."""
        return Control.of(self.control, self.machine_stiffness)

    @property
    def parts(self) -> list[list[Snapshot] | Event]:
        """The events, and between them runs of states in one direction, in their order.

        A run is a list of snapshots. It begins with the state after the event before it, or with
        the one at which the depth turned; the first one with none that is a state: at depth -inf,
        without contact.
        """
        run = [Snapshot(-math.inf, 0.0, 0.0, math.nan, math.nan)]
        events = list(self.events)
        parts: list[list[Snapshot] | Event] = [run]
        for step in range(len(self)):
            while events and events[0].step == step:
                event = events.pop(0)
                _with(parts, run, event.before)
                run = [event.after]
                parts += [event, run]
            run = _with(parts, run, self.at(step))
        return parts

    def at(self, step: int) -> Snapshot:
        """The state at a step."""
        depth, force, energy, left, right = self.table[step, 1:].tolist()
        axisymmetric = self.scene.axisymmetric
        return Snapshot(depth, force, energy, left, right, self.inner[step], axisymmetric)

    def work(self) -> float:
        """∫P dd of the path from the forces alone, where the state jumps that of the applied load.

        The energy balance of a path that starts and ends without contact: work = dissipated.
        """
        jumps = sum(self.hold.work(e.before.depth, e.after.depth, e.control) for e in self.events)
        return sum(segment.external_work() for segment in self._segments(self.parts)) + jumps

    def to_csv(self, path: str | Path) -> None:
        """Write everything, with units, signs and the scene in the header; exact to the last bit.

        The file is replaced at once: a reader finds the old one or the new one, never half.
        """
        header = {name: getattr(self, name) for name in _HEADER} | {"scene": described(self.scene)}
        lines = [f"# {note}" for note in (_TITLE, *_NOTES, json.dumps(header))]
        lines += [f"# event {json.dumps(event)}" for event in self.events]
        lines.append(",".join(_COLUMNS))
        for row, inner in zip(self.table.tolist(), self.inner, strict=True):
            lines.append(",".join([*map(repr, row), " ".join(map(repr, inner))]))
        unfinished = Path(f"{path}.part")
        try:
            unfinished.write_text("\n".join(lines) + "\n", encoding="utf-8")
            os.replace(unfinished, path)
        except OSError:
            unfinished.unlink(missing_ok=True)
            raise

    @classmethod
    def from_csv(cls, path: str | Path, scene: Scene | None = None) -> History:
        """Read what `to_csv` wrote. `scene`: for an indenter given by functions; else it is read.

        ValueError for another file, or if `scene` is not the one in the file.
        """
        lines = Path(path).read_text(encoding="utf-8").splitlines()
        if not lines or lines[0] != f"# {_TITLE}":
            raise ValueError(f"path = {str(path)!r} holds no load path; write one with to_csv")
        header = json.loads(lines[1 + len(_NOTES)].removeprefix("# "))
        if scene is not None and not alike(described(scene), header["scene"]):
            raise ValueError(f"scene = {scene!r} is not the scene of {str(path)!r}; pass that one")
        rows = [line.split(",") for line in lines if not line.startswith("#")][1:]
        events = (json.loads(line[8:]) for line in lines if line.startswith("# event "))
        return cls(
            rebuilt(header["scene"]) if scene is None else scene,
            **{name: header[name] for name in _HEADER if name != "on_nodes"},
            on_nodes=tuple((start, end) for start, end in header.get("on_nodes", ())),
            table=np.array([row[:6] for row in rows], float).reshape(-1, 6),
            inner=tuple(tuple(map(float, row[6].split())) for row in rows),
            events=tuple(map(_read_event, events)),
        )

    @functools.cached_property
    def pull_off(self) -> PullOff:
        """The most tensile state: at a step, before an event, or at a minimum between them.

        ValueError for a path without tension.
        """
        least = math.inf
        state = None
        for found in (self._least_recorded, *self._turns()):
            if found is not None and found.force < least:
                least = found.force
                state = found
        if state is None or least >= -NOISE * np.abs(self.force).max(initial=0.0):
            raise ValueError(
                f"least force = {least!r} of this path is not tensile; retract the indenter "
                "further, unless it is too steep for its adhesion to pull at all"
            )
        return PullOff(state.force, state.depth, state.half_width)

    def unresolved(self) -> str:
        """A sentence if the pull-off force is that of a contact of only a few links, else "".

        Where it is not known at which depth such a contact closes.
        """
        forces = [*self.force.tolist(), *(event.force for event in self.events)]
        least = min(forces, default=0.0)
        size = max(map(abs, forces), default=0.0)
        if -least <= NOISE * size:
            return ""
        for run, event in itertools.pairwise(self.parts):
            if not isinstance(event, Event) or event.force > least:
                continue
            if math.isnan(event.after.left) and self._closes_too_early(event.before):
                wider = self._force_with_more_links(run)
                if wider is not None and abs(wider - least) > -_CHANGED * least:
                    return (
                        f"the pull-off force = {least!r} is that of a contact of fewer than {LEAST}"
                        f" links; with more links it was {wider!r}, and it may be off by the "
                        "difference; give a smaller spacing, or method='fitted'"
                    )
        return ""

    def _closes_too_early(self, last: Snapshot) -> bool:
        """Whether the last contact has only a few links, and it is not known when it closes.

        last: the state before it was lost.
        """
        # Lines are at nodes: half a link keeps the rounding of widths from deciding.
        few = last.right - last.left < (LEAST - 0.5) * (self.spacing or 0)
        return few and not self._branch.closes_at(last)

    def _force_with_more_links(self, run: Any) -> float | None:
        """P just before the last link opened in a run of states; None if none did.

        Along a segment on nodes `trace` has the depths at which links are passed.
        """
        segments: list[Any] = [*self._segments([run])]
        if not segments or len(segments[-1].trace) < 2:
            return None
        depth, _ = segments[-1].trace[-2]
        return float(segments[-1].forces(np.array([depth]))[0])

    def _segments(self, parts: list[Any]) -> Iterator[PathSegment]:
        """The segments of a path, followed again along its runs of states, where in contact.

        parts: as of `parts`, of which the events are left out.
        """
        for part in parts:
            if not isinstance(part, list):  # an event
                continue
            run = [state for state in part if not math.isnan(state.left)]
            if not run:
                continue
            here = self._branch.contact(run[0].depth, *run[0].lines)
            while here.lines is not None and here.depth != run[-1].depth:
                segment = self._branch.segment(here, run[-1].depth)
                yield segment
                here = segment.after or segment.end

    @functools.cached_property
    def _least_recorded(self) -> Snapshot | None:
        """The recorded state in contact at which P is least, the first of those; None without."""
        found = list[tuple[float, float, Snapshot]]()
        for event in self.events:
            for state in (event.before, event.after):
                if not math.isnan(state.left):
                    found.append((state.force, event.step, state))
        forces = np.where(np.isnan(self.contacts[:, 0]), math.inf, self.force)
        step = int(forces.argmin()) if forces.size else 0
        if forces.size and forces[step] < math.inf:
            found.append((float(forces[step]), step + 0.5, self.at(step)))  # after its events
        return min(found, key=lambda one: one[:2])[2] if found else None

    def _stretches(self) -> Iterator[Stretch]:
        """The parts of the path between events that are in contact, each in one direction.

        ValueError if the states of one have not as many lines as each other.
        """
        for before, after in itertools.pairwise([None, *self.events, None]):
            if before is None or math.isnan(before.after.left):
                continue
            own = slice(before.step, after.step if after else len(self))
            first = before.after
            last = [after.before] if after else []  # a path may end before the next event
            count = self.depth[own].size
            inner = np.reshape(self.inner[own], (count, len(first.inner)))
            left, right = self.contacts[own].T
            lines_of_steps = np.column_stack([left, inner, right])
            lines = np.vstack([first.lines, lines_of_steps, *(state.lines for state in last)])
            depths = [first.depth, *self.depth[own], *(state.depth for state in last)]
            forces = [first.force, *self.force[own], *(state.force for state in last)]
            yield from monotone(np.array(depths), np.array(forces), lines)

    def _turns(self) -> Iterator[Snapshot]:
        """States between recorded ones at which P is less than at these, the least on its part.

        On nodes only those that may be the least of the whole path.
        """
        if isinstance(self._branch, LatticeBranch):
            try:
                yield from self._turns_on_nodes(self._branch)
                return
            except (ValueError, UnknownError):
                pass  # something happens that is no event of the path: follow all segments again
        yield from self._turns_of_segments()

    def _turns_of_segments(self) -> Iterator[Snapshot]:
        """Of every segment, followed again, its end, and the least P inside if that is less."""
        for segment in self._segments(self.parts):
            yield self._branch.snapshot(segment.end)
            curve = Curve.of(segment, Control(0.0))
            least = int(np.argmin(curve.value))
            ends = curve.value[[0, -1]]
            if curve.value[least] < ends.min() - NOISE * np.abs(curve.value).max():
                yield self._branch.snapshot(curve.refined(least, -1))

    def _turns_on_nodes(self, branch: LatticeBranch) -> list[Snapshot]:
        """Of stretches on nodes the least P inside, if it may be the least of the whole path.

        They are followed again in the order of their bounds, as long as these are less than the
        least P so far. In the order of the path.
        """
        recorded = self._least_recorded
        least = math.inf if recorded is None else recorded.force
        stretches = bounded(branch, [*self._stretches()])
        turns = dict[int, Snapshot]()
        for i in sorted(range(len(stretches)), key=lambda i: stretches[i].least):
            state = stretches[i].turn(least) if stretches[i].least < least else None
            if state is not None:
                turns[i] = state
                least = min(least, state.force)
        return [turns[i] for i in sorted(turns)]

    validity = property(readings.of_path)
    warnings = property(readings.violated)

    @functools.cached_property
    def error_estimate(self) -> dict[str, float]:
        """Relative errors of depth, half_width, force, energy and dissipated.

        Those of the first four are the largest over all steps, relative to the range of depths on
        the path and to the largest half-width, force and energy; that of the energy lost is
        relative to the sum of what the events release and friction. On nodes it is next to the
        same programme on half as many of them, which is followed when this is first read; see
        path_accuracy.py. On the fitted mesh it is `rtol`, which paths keep; where a part of the
        path is nodes' alone (`on_nodes`) that of the whole programme on the same nodes.

        AccuracyWarning, and infinite estimates where that programme cannot be followed.
        """
        if self.spacing is None and self.on_nodes:
            return self._estimate_on_nodes()
        if self.spacing is None:
            return dict.fromkeys(QUANTITIES, self.rtol)
        try:
            deepest = float(self.depth.max())
            branch = LatticeBranch.of(self.scene, _COARSER * self.spacing, deepest)
            path = LoadPath(branch, self.hold, _DETACHED)
            path.go(self.values)
            coarse = self._without_steps(self.spacing).extended(path, self.values)
        except (ValueError, NotCertifiedError) as problem:
            warnings.warn(
                f"no error estimate: on half as many nodes the path is not followed ({problem}); "
                "give a smaller spacing",
                AccuracyWarning,
                stacklevel=3,
            )
            return dict.fromkeys(QUANTITIES, math.inf)
        own = LatticeBranch.of(self.scene, self.spacing, deepest).row.lattice.spacing
        return estimated(self, coarse, branch.row.lattice.spacing / own, stacklevel=3)

    def _estimate_on_nodes(self) -> dict[str, float]:
        """The errors of the same programme on nodes alone, as of `error_estimate`.

        They are infinite, with a warning, where it cannot be followed on these.
        """
        deepest = float(self.depth.max())
        spacing = RefinedBranch.of(self.scene, deepest).nodal.row.lattice.spacing
        path = LoadPath(LatticeBranch.of(self.scene, spacing, deepest), self.hold, _DETACHED)
        try:
            path.go(self.values)
        except NotCertifiedError as problem:
            warnings.warn(
                f"no error estimate: on nodes alone the path is not followed ({problem})",
                AccuracyWarning,
                stacklevel=4,
            )
            return dict.fromkeys(QUANTITIES, math.inf)
        on_nodes = self._without_steps(spacing).extended(path, self.values)
        return on_nodes.error_estimate

    plot = plots.plot_path
    animate = animation.animate
    to_dict = readings.path_columns
    _repr_html_ = readings.html
    __repr__ = readings.path_line
    __str__ = readings.path_text

    def __len__(self) -> int:
        """The number of steps."""
        return self.depth.size

    def __bool__(self) -> bool:
        """True, also of a path without steps."""
        return True

    @functools.cached_property
    def _branch(self) -> Branch:
        """The branch, found again if it is not known, as for a path that was read from a file."""
        if self.branch is not None:
            return self.branch
        return branch_of(self.scene, self.rtol, self.spacing, lambda: float(self.depth.max()))


def _read_event(record: Sequence[Any]) -> Event:
    """An event from its fields in their order, of which those of its states are lists, too."""
    kind, control, before, after, released, step = record
    return Event(kind, control, _read_snapshot(before), _read_snapshot(after), released, step)


def _read_snapshot(record: Sequence[Any]) -> Snapshot:
    """A state from its fields in their order."""
    state = Snapshot(*record)
    return state._replace(inner=tuple(state.inner))


def _with(parts: list[Any], run: list[Snapshot], there: Snapshot) -> list[Snapshot]:
    """The last run with a further state, or a new one, appended to parts, where the path turns."""
    if (run[-1].depth - run[0].depth) * (there.depth - run[-1].depth) < 0:
        run = [run[-1]]
        parts.append(run)
    run.append(there)
    return run


def merged(ranges: Iterable[tuple[float, float]]) -> list[tuple[float, float]]:
    """Ranges of depths (start, end), those joined that follow each other in one direction.

    They stay in their order; a range that is there already is left out.
    """
    found = list[tuple[float, float]]()
    for start, end in ranges:
        if found and found[-1][1] == start and (end - start) * (start - found[-1][0]) >= 0:
            found[-1] = found[-1][0], end
        elif (start, end) not in found:
            found.append((start, end))
    return found
