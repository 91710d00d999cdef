"""A load path: what was recorded at every step, its events, and the ledger of its energy."""

from __future__ import annotations

import functools
import json
import math
import os
from dataclasses import dataclass, replace
from itertools import chain, pairwise
from pathlib import Path
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.branch import FittedBranch
from discretization.control import Control, Point, moved, point_of_fold
from energy import Scene
from energy.description import described, rebuilt

Array = NDArray[np.float64]
_ENOUGH = 33
_TITLE = "elastocap load path"
_NOTES = (
    "per unit length of the line contact, in the units of the scene: control [length or force],",
    "depth d [length] > 0 into the layer, force P [force] > 0 compressive, energy U [energy],",
    "lines left, right [length], nan: detached. event: kind, control, before, after (depth,",
    "force, energy, left, right), energy released, step",
)
_COLUMNS = ("control", "depth", "force", "energy", "left", "right")


class Snapshot(NamedTuple):
    """A state beside an event: depth, force P, energy U, contact lines (nan when detached)."""

    depth: float
    force: float
    energy: float
    left: float
    right: float

    @property
    def half_width(self) -> float:
        """a, 0 when detached."""
        return 0.0 if math.isnan(self.left) else (self.right - self.left) / 2


class Event(NamedTuple):
    """Something that happened at one value of the control, between two steps.

    kind: "touch" or "jump-in" (contact begins, without or with energy released), "tip depinning",
    "edge depinning" and their opposites "... pinning", "detachment" (the contact has closed up),
    "pull-off" (unstable under force or machine control) or "jump" (unstable, still in contact).
    control: the value at which it happens; before, after: the states; energy_released: the drop
    of U at fixed depth, of U - F d at fixed force, of U + K/2 (D - d)² at a fixed drive. Under
    force control a pull-off ends where the contact closes up under the dead load.
    """

    kind: str
    control: float
    before: Snapshot
    after: Snapshot
    energy_released: float
    step: int

    @property
    def depth(self) -> float:
        """d before the event."""
        return self.before.depth

    @property
    def force(self) -> float:
        """P before the event."""
        return self.before.force


class PullOff(NamedTuple):
    """The most tensile state of a path."""

    force: float
    depth: float
    half_width: float


@dataclass(frozen=True, eq=False)
class History:
    """A load path of n steps, per unit length of the line contact.

    control: "depth", "force" or "drive"; values (n,): the programme; machine_stiffness K of a
    drive. depth, force (P > 0 compressive), half_width, energy U (n,); contacts (n, 2): lines, nan
    when detached. friction: lost by lines that moved without a jump under adhesion hysteresis. A
    detached indenter under a tensile dead load is at depth -inf.
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

    @classmethod
    def empty(
        cls, scene: Scene, control: str, machine_stiffness: float | None, rtol: float
    ) -> History:
        """A path without steps."""
        none = np.empty(0)
        lines = np.empty((0, 2))
        return cls(scene, control, machine_stiffness, none, none, none, none, lines, (), 0.0, rtol)

    def extended(
        self, values: Array, depths: Array, lines: Array, events: list[Event], friction: float
    ) -> History:
        """This path and further steps."""
        force, energy = np.zeros((2, depths.size))
        held = ~np.isnan(lines[:, 0])
        if held.any():
            force[held], energy[held], _ = self._branch.observed(depths[held], lines[held])
        return replace(
            self,
            values=np.concatenate([self.values, values]),
            depth=np.concatenate([self.depth, depths]),
            force=np.concatenate([self.force, force]),
            energy=np.concatenate([self.energy, energy]),
            contacts=np.concatenate([self.contacts, lines]),
            events=(*self.events, *events),
            friction=self.friction + friction,
        )

    @property
    def half_width(self) -> Array:
        """a (n,), 0 when detached."""
        width = self.contacts[:, 1] - self.contacts[:, 0]
        return np.where(np.isnan(width), 0.0, width / 2)

    @property
    def dissipated(self) -> float:
        """Energy lost on the way: released in the events, and to adhesion hysteresis."""
        return sum(event.energy_released for event in self.events) + self.friction

    @property
    def segments(self) -> list[tuple[Snapshot, Snapshot]]:
        """Start and end of every part of the path without a jump, while in contact."""
        parts, here = [], Snapshot(-math.inf, 0.0, 0.0, math.nan, math.nan)
        events = iter((*self.events, None))
        event = next(events)
        for step in range(len(self.depth)):
            while event is not None and event.step == step:
                parts.append((here, event.before))
                here, event = event.after, next(events)
            there = self.at(step)
            parts.append((here, there))
            here = there
        return [(a, b) for a, b in parts if not math.isnan(a.left + b.left)]

    def at(self, step: int) -> Snapshot:
        """The state at a step."""
        columns = (self.depth, self.force, self.energy, *self.contacts.T)
        return Snapshot(*(float(column[step]) for column in columns))

    def work(self) -> float:
        """∫P dd of the path from the forces alone, where the state jumps that of the applied load.

        The ledger of a path that starts and ends without contact: work = dissipated.
        """
        branch, total = self._branch, 0.0
        for start, end in self.segments:
            total += branch.work(branch.contact(start.left, start.right), start.depth, end.depth)
        hold = Control(None if self.control == "depth" else self.machine_stiffness or 0.0)
        for event in self.events:
            depths = event.before.depth, event.after.depth
            before, after = (hold.potential(depth, event.control) for depth in depths)
            total += before - after
        return total

    def to_csv(self, path: str | Path) -> None:
        """Write everything, with units, signs and the scene in the header; exact to the last bit.

        The file is replaced at once: a reader finds the old one or the new one, never half.
        """
        path = Path(path)
        header = {
            "control": self.control,
            "machine_stiffness": self.machine_stiffness,
            "rtol": self.rtol,
            "friction": self.friction,
            "scene": described(self.scene),
        }
        lines = [f"# {_TITLE}", *(f"# {note}" for note in _NOTES), f"# {json.dumps(header)}"]
        for event in self.events:
            lines.append(f"# event {json.dumps(event)}")
        lines.append(",".join(_COLUMNS))
        columns = (self.values, self.depth, self.force, self.energy, *self.contacts.T)
        lines += [
            ",".join(map(repr, row)) for row in zip(*(c.tolist() for c in columns), strict=True)
        ]
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
        if scene is not None and described(scene) != header["scene"]:
            raise ValueError(f"scene = {scene!r} is not the scene of {str(path)!r}; pass that one")
        rows = [line.split(",") for line in lines if not line.startswith("#")][1:]
        values, depth, force, energy, left, right = np.array(rows, float).reshape(-1, 6).T
        events = [json.loads(note[6:]) for note in notes if note.startswith("event ")]
        return cls(
            scene=rebuilt(header["scene"]) if scene is None else scene,
            control=header["control"],
            machine_stiffness=header["machine_stiffness"],
            values=values,
            depth=depth,
            force=force,
            energy=energy,
            contacts=np.stack([left, right], axis=1),
            events=tuple(
                Event(kind, value, Snapshot(*before), Snapshot(*after), *rest)
                for kind, value, before, after, *rest in events
            ),
            friction=header["friction"],
            rtol=header["rtol"],
        )

    @functools.cached_property
    def pull_off(self) -> PullOff:
        """The most tensile state: at a step, before an event, or at a minimum between them.

        ValueError for a path without tension.
        """
        states = [self._least(run) for run in self._runs()]
        if not states or min(state.force for state in states) >= 0:
            raise ValueError("this path has no tensile state; retract the indenter further")
        found = min(states, key=lambda state: state.force)
        return PullOff(found.force, found.depth, found.half_width)

    def _runs(self) -> list[list[Snapshot]]:
        """The segments joined where the path goes straight on."""
        runs: list[list[Snapshot]] = []
        for start, end in self.segments:
            on = runs and runs[-1][-1] == start and len(runs[-1]) > 1
            if on and (runs[-1][-1].depth - runs[-1][-2].depth) * (end.depth - start.depth) >= 0:
                runs[-1].append(end)
            else:
                runs.append([start, end])
        return runs

    def _least(self, run: list[Snapshot]) -> Snapshot:
        """The least force of a run that goes one way, between the states recorded as well."""
        while len(run) < _ENOUGH and run[0].depth != run[-1].depth:
            run = [*chain(*((a, self._middle(a, b)) for a, b in pairwise(run))), run[-1]]
        least = min(range(len(run)), key=lambda i: run[i].force)
        beside = sorted(run[max(least - 1, 0) : least + 2], key=lambda state: state.depth)
        low, high = (self._point(state) for state in (beside[0], beside[-1]))
        fold = point_of_fold(self._branch, Control(0.0), high, low)
        return min(run[least], self._snapshot(fold), key=lambda state: state.force)

    def _middle(self, a: Snapshot, b: Snapshot) -> Snapshot:
        return self._snapshot(moved(self._branch, self._point(a), (a.depth + b.depth) / 2))

    def _point(self, state: Snapshot) -> Point:
        return Point(state.depth, self._branch.contact(state.left, state.right))

    def _snapshot(self, point: Point) -> Snapshot:
        """A state between the steps; its energy is not asked for."""
        depth, state = point
        lines = (math.nan, math.nan) if state is None else state.ends
        return Snapshot(depth, self._branch.force(state, depth), math.nan, *lines)

    @functools.cached_property
    def _branch(self) -> FittedBranch:
        return FittedBranch.of(self.scene, self.rtol)
