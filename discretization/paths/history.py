"""A load path: what was recorded at every step, its events, and the balance of its energy."""

from __future__ import annotations

import functools
import json
import math
import os
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization import display, plots
from discretization.paths import balance
from discretization.paths.branch import Branch, Point
from discretization.paths.branches import branch_of
from discretization.paths.control import Control
from discretization.paths.events import Event, PullOff, Snapshot, half_length
from energy import Scene
from energy.description import alike, described, rebuilt

Array = NDArray[np.float64]
_TITLE = "elastocap load path"
_NOTES = (
    "in the units of the scene, of a line contact per its unit length: control [length or force],",
    "depth d [length] > 0 into the layer, force P [force] > 0 compressive, energy U [energy],",
    "lines left, right [length], nan: detached. event: kind, control, before, after (depth,",
    "force, energy, left, right, inner lines), energy released, step",
)
_HEADER = ("control", "machine_stiffness", "rtol", "spacing", "friction")
_COLUMNS = ("control", "depth", "force", "energy", "left", "right", "inner")


@dataclass(frozen=True, eq=False)
class History:
    """A load path of n steps, per unit length of the line contact.

    With rotational symmetry force and energy are those of the whole contact, and lines are radii.

    control: "depth", "force" or "drive"; values (n,): the programme; machine_stiffness K of a
    drive. depth, force (P > 0 compressive), half_width, energy U (n,); contacts (n, 2): lines, nan
    when detached. friction: lost by lines that moved without a jump under adhesion hysteresis.
    spacing: of the nodes, None on the fitted mesh. inner (n,): the lines between the outermost
    ones, where there are several contacts. A detached indenter under a tensile dead load is at
    depth -inf.
    """

    scene: Scene
    control: str
    machine_stiffness: float | None
    values: Array
    depth: Array
    force: Array
    energy: Array
    contacts: Array
    events: tuple[Event, ...]
    friction: float
    rtol: float
    spacing: float | None = None
    inner: tuple[tuple[float, ...], ...] = ()

    @classmethod
    def empty(cls, scene: Scene, *held: Any) -> History:
        """A path without steps; held: its control, machine_stiffness, rtol and spacing."""
        none, (control, stiffness, rtol, spacing) = np.empty(0), held
        return cls(
            *(scene, control, stiffness, *4 * (none,), np.empty((0, 2)), (), 0.0, rtol, spacing)
        )

    def extended(
        self,
        branch: Branch,
        values: Array,
        points: list[Point],
        events: list[Event],
        friction: float,
    ) -> History:
        """This path and further steps along the branch."""
        lines, (force, energy) = np.full((len(points), 2), math.nan), np.zeros((2, len(points)))
        held = np.array([point.lines is not None for point in points])
        if held.any():
            found = branch.recorded([point for point in points if point.lines is not None])
            lines[held], force[held], energy[held] = found
        whole = replace(
            self,
            values=np.concatenate([self.values, values]),
            depth=np.append(self.depth, [point.depth for point in points]),
            force=np.concatenate([self.force, force]),
            energy=np.concatenate([self.energy, energy]),
            contacts=np.concatenate([self.contacts, lines]),
            events=(*self.events, *events),
            friction=self.friction + friction,
            inner=(*self.inner, *(point.inner for point in points)),
        )
        vars(whole)["_branch"] = branch  # knows the work done between the states
        return whole

    @property
    def half_width(self) -> Array:
        """Half the total contact length a (n,), or the outermost radius; 0 when detached."""
        if self.scene.axisymmetric:
            return np.nan_to_num(self.contacts[:, 1])
        width = self.contacts[:, 1] - self.contacts[:, 0]
        gaps = [-half_length(lines) if lines else 0.0 for lines in self.inner]
        return np.where(np.isnan(width), 0.0, width / 2 + np.array(gaps))

    @property
    def dissipated(self) -> float:
        """Energy lost on the way: released in the events, and to adhesion hysteresis."""
        return sum(event.energy_released for event in self.events) + self.friction

    @property
    def parts(self) -> list[list[Snapshot] | Event]:
        """The events, and between them the states of parts that go one way, in their order."""
        run, events = [Snapshot(-math.inf, 0.0, 0.0, math.nan, math.nan)], list(self.events)
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
        columns = (self.depth, self.force, self.energy, *self.contacts.T)
        depth, force, energy, left, right = (float(column[step]) for column in columns)
        turned = self.scene.axisymmetric
        return Snapshot(depth, force, energy, left, right, self.inner[step], turned)

    def work(self) -> float:
        """∫P dd of the path from the forces alone, where the state jumps that of the applied load.

        The energy balance of a path that starts and ends without contact: work = dissipated.
        """
        hold = Control(None if self.control == "depth" else self.machine_stiffness or 0.0)
        return balance.work(self._branch, hold, self.parts)

    def to_csv(self, path: str | Path) -> None:
        """Write everything, with units, signs and the scene in the header; exact to the last bit.

        The file is replaced at once: a reader finds the old one or the new one, never half.
        """
        path = Path(path)
        header = {name: getattr(self, name) for name in _HEADER}
        header["scene"] = described(self.scene)
        lines = [f"# {_TITLE}", *(f"# {note}" for note in _NOTES), f"# {json.dumps(header)}"]
        for event in self.events:
            lines.append(f"# event {json.dumps(event)}")
        lines.append(",".join(_COLUMNS))
        columns = (self.values, self.depth, self.force, self.energy, *self.contacts.T)
        for *row, inner in zip(*(column.tolist() for column in columns), self.inner, strict=True):
            lines.append(",".join([*map(repr, row), " ".join(map(repr, inner))]))
        beside = path.with_name(path.name + ".part")
        beside.write_text("\n".join(lines) + "\n", encoding="utf-8")
        os.replace(beside, path)

    @classmethod
    def from_csv(cls, path: str | Path, scene: Scene | None = None) -> History:
        """Read what `to_csv` wrote. `scene`: for an indenter given by functions; else it is read.

        ValueError for another file, or if `scene` is not the one in the file.
        """
        lines = Path(path).read_text(encoding="utf-8").splitlines()
        if not lines or lines[0] != f"# {_TITLE}":
            raise ValueError(f"path = {str(path)!r} holds no load path; write one with to_csv")
        notes = [line[2:] for line in lines if line.startswith("# ")]
        header = json.loads(notes[1 + len(_NOTES)])
        if scene is not None and not alike(described(scene), header["scene"]):
            raise ValueError(f"scene = {scene!r} is not the scene of {str(path)!r}; pass that one")
        rows = [line.split(",") for line in lines if not line.startswith("#")][1:]
        numbers = np.array([row[:6] for row in rows], float).reshape(-1, 6)
        values, depth, force, energy, left, right = numbers.T
        events = [json.loads(note[6:]) for note in notes if note.startswith("event ")]
        return cls(
            scene=rebuilt(header["scene"]) if scene is None else scene,
            values=values,
            depth=depth,
            force=force,
            energy=energy,
            contacts=np.stack([left, right], axis=1),
            events=tuple(
                Event(kind, value, _snapshot(before), _snapshot(after), *rest)
                for kind, value, before, after, *rest in events
            ),
            inner=tuple(tuple(map(float, row[6].split())) for row in rows),
            **{name: header[name] for name in _HEADER},
        )

    @functools.cached_property
    def pull_off(self) -> PullOff:
        """The most tensile state: at a step, before an event, or at a minimum between them.

        ValueError for a path without tension.
        """
        return balance.most_tensile(self._branch, self.parts)

    plot = plots.plot_path
    to_dict = display.path_columns
    _repr_html_ = display.html
    __repr__ = display.path_line
    __str__ = display.path_text

    def __len__(self) -> int:
        return self.depth.size

    def __bool__(self) -> bool:
        return True  # also a path without steps

    @functools.cached_property
    def _branch(self) -> Branch:
        return branch_of(self.scene, self.rtol, self.spacing, float(self.depth.max()))


def _snapshot(parts: list[Any]) -> Snapshot:
    depth, force, energy, left, right, inner, *turned = parts
    return Snapshot(depth, force, energy, left, right, tuple(inner), *turned)


def _with(parts: list[Any], run: list[Snapshot], there: Snapshot) -> list[Snapshot]:
    """The last run with a further state, or a new one where the path turns."""
    if (run[-1].depth - run[0].depth) * (there.depth - run[-1].depth) < 0:
        run = [run[-1]]
        parts.append(run)
    run.append(there)
    return run
