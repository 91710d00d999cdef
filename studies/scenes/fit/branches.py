"""The simulated force of a scene as a function of where a machine is, read off depth paths.

Where the line is free its states are known without a path (free_branch.py of the fitted mesh and of
the layer); else a path of imposed depths is followed once. Held by a spring of stiffness K whose
far end is at D, the indenter is in equilibrium where D = d + P(d)/K: as D grows the depth is where
the running maximum of d + P(d)/K along the path first reaches it, as D falls, where the running
minimum does.
The offset of the depth and the stiffness of the machine cost no further path.

Conventions:

- `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the states
  at these values one after the other: a `History` with arrays `depth`, `force` (positive where it
  presses), `half_width`; `events`, the jumps and other events in their order, each with a kind, the
  states `before` and `after` it.
- A scene has `gamma1` γ₁ and `critical_separation` δ₀ = √(2w/k).
- `free_branch` of the fitted mesh, `on_springs`, and of the layer, `on_layer`, give the states with
  a free line where `free_on_springs` or `free_on_layer` applies.
- Depths are positive into the layer, forces where it is pressed.
- `scene.opened` is the scene of a contact that opens.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from discretization import load_path, minimise_many
from discretization.fitted.free_branch import applies as free_on_springs
from discretization.fitted.free_branch import free_branch as on_springs
from discretization.layer.free_branch import applies as free_on_layer
from discretization.layer.free_branch import free_branch as on_layer
from energy import Scene
from energy.arrays import Array

RTOL = 1e-4  # of the paths, whose forces are then right to some 1e-6
BEYOND = 1.01  # times δ₀ below touching nothing holds
POINTS = 300  # on a leg
PULLED = 600  # on a leg, below touching
DENSE = 3000  # at which a machine is tried
KEPT = 64  # paths that are remembered


@dataclass(frozen=True, eq=False)
class Branch:
    """Equilibria in contact while the indenter moves in one direction, in the order of the motion.

    Attributes
    ----------
    depth : ndarray (n,)
        Roots of their distances from the end at which contact begins or is lost are evenly spaced.
    force : ndarray (n,)
    smooth : bool
        Whether there are no jumps.
    """

    depth: Array
    force: Array
    smooth: bool

    def read(self, drives: Array, stiffness: float, blunt: float = 0.0) -> tuple[Array, float]:
        """Forces at positions of a machine, and the position at which the branch ends.

        From `blunt` before its end, where dP/dD is often infinite, and beyond it the force goes on
        along its slope there; deeper than it is known, along the slope of its deepest points.

        Parameters
        ----------
        drives : ndarray (n,)
            Positions of the machine [m].
        stiffness : float
            Of the machine.
        blunt : float
            Length of the straight end [m].

        Returns
        -------
        force : ndarray (n,)
        end : float
        """
        reached = _reached(self, stiffness)
        beyond_end = drives - reached.end
        root = np.sqrt(np.maximum(beyond_end, blunt))
        force = reached.force(np.interp(root, reached.root_of_drive, reached.root_of_depth))
        if blunt:
            start = float(np.interp(math.sqrt(blunt), reached.root_of_drive, reached.root_of_depth))
            rise = float(reached.force(start, 1))
            slope = rise / (2 * start + rise / stiffness)
            force += slope * np.minimum(beyond_end - blunt, 0.0)
        risen = np.diff(reached.force(reached.root_of_depth[-2:])).sum()
        moved = np.diff(reached.drive[-2:]).sum()
        deep_slope = risen / moved if moved else 0.0  # a machine this soft passes over every state
        return force + deep_slope * np.maximum(drives - reached.drive[-1], 0.0), reached.end


class _Reached(NamedTuple):
    """The states of a branch that a machine reaches, from the end of the branch on (n,).

    Over the root of the distance from the end the force is smooth where the contact is lost.

    Attributes
    ----------
    root_of_depth, root_of_drive : ndarray (n,)
        Roots of the distances of depth and position of the machine from those of the end.
    drive : ndarray (n,)
        Positions of the machine.
    force : CubicSpline
        Over the root of the distance of the depth.
    """

    root_of_depth: Array
    root_of_drive: Array
    drive: Array
    force: CubicSpline

    @property
    def end(self) -> float:
        """Position of the machine at the end of the branch."""
        return float(self.drive[0])


@lru_cache(8)
def _reached(branch: Branch, stiffness: float) -> _Reached:
    """The branch as a machine of this stiffness [N/m² or N/m] follows it, over its position.

    The position D = d + P/K may turn back along a branch; a machine jumps over these points. Kept
    are those at which D is farther than at all before, in the direction in which the branch is run.
    """
    depth = branch.depth
    force = branch.force
    inwards = depth[-1] >= depth[0]
    if not inwards:
        depth = depth[::-1]
        force = force[::-1]
    kind = CubicSpline if branch.smooth else PchipInterpolator
    spline = kind(np.sqrt(depth - depth[0]), force)
    root = np.linspace(0.0, spline.x[-1], DENSE)
    drive = depth[0] + root**2 + spline(root) / stiffness
    # The farthest position so far: a branch outwards is run from its deep end, the last point.
    farthest = np.minimum.accumulate(drive[::-1])[::-1]
    if inwards:
        farthest = np.maximum.accumulate(drive)
    reached = farthest == drive
    drive = drive[reached]
    return _Reached(root[reached], np.sqrt(drive - drive[0]), drive, spline)


def touching(scene: Scene) -> float:
    """The depth of first touch, which is min f since nothing attracts across a gap."""
    springs = replace(scene, layer=replace(scene.layer, response="springs"))
    return float(load_path(springs, forces=[0.0]).events[0].before.depth)


@lru_cache(KEPT)
def retraction(scene: Scene, touch: float, reach: float) -> tuple[Branch, bool]:
    """The branch from a depth `reach` below first touch to the detachment, and whether loading and
    unloading coincide on it."""
    found = None
    if free_on_springs(scene):
        found = on_springs(scene, touch + reach, POINTS)
    elif free_on_layer(scene):
        found = on_layer(scene, touch + reach, POINTS, RTOL)
    if found:
        return Branch(found.depth[::-1], found.force[::-1], True), True
    branch, events = _leg(scene, [touch, touch + reach], reach)
    return branch, events == 2


def leg_branches(
    scene: Scene, touch: float, reach: float, drives: tuple[float, ...], stiffness: float
) -> list[Branch]:
    """A branch inwards from the touch, and one from each turning position of the machine in turn.

    All are one where loading and unloading coincide; separate springs detach later.
    """
    if scene.opening is None and scene.gamma1 > 0:
        both, same = retraction(scene, touch, reach)
        if same:
            return [both] * (1 + len(drives))
    return _followed_legs(scene, touch, reach, drives, stiffness)


@lru_cache(KEPT)
def _followed_legs(
    scene: Scene, touch: float, reach: float, drives: tuple[float, ...], stiffness: float
) -> list[Branch]:
    """As `leg_branches`, each from the depth that the one before has reached."""

    def leg(turns: list[float]) -> Branch:
        """The branch along depths between these turns; of springs alone it may need no path."""
        known = _slack_leg(scene, turns, reach) if scene.gamma1 == 0 else None
        return known or _leg(scene, turns, reach)[0]

    found = [leg([touch])]
    depths = [touch]
    for drive in drives:
        (force,), _ = found[-1].read(np.array([drive]), stiffness)
        depths.append(drive - float(force) / stiffness)
        found.append(leg(depths))
    return found


def _slack_leg(scene: Scene, turns: list[float], reach: float) -> Branch | None:
    """As `_leg`, for springs without tension below a convex profile; None for anything else.

    In contact is what lies below a level L of the profile, which the depth lifts as it exceeds it,
    and lowers as it falls below L - δ₀, δ₀ that of opening. With A(L) the length or area in contact
    and P₀ the force at the depth L, P = P₀(L) + k A(L) (d - L).
    """
    body = scene.indenter
    separation = scene.opened.critical_separation
    if not body.convex or len(body.corners):
        return None
    touch = turns[0]
    start = turns[-1]
    share = np.linspace(0.0, 1.0, POINTS)
    level = touch
    lost = touch - separation
    for turn in turns:
        level = float(np.clip(level, turn, turn + separation))
    if len(turns) % 2 == 1:
        depth = start + (touch + reach - start) * share**2
    else:
        if start <= lost:
            raise ValueError(f"depth = {start!r}: no contact to retract from")
        depth = start - (start - lost) * (1 - (1 - share) ** 2)
    levels = np.clip(level, depth, depth + separation)
    try:
        pressed = minimise_many(replace(scene, opening=None), np.maximum(levels, touch))
    except ValueError:  # the profile is not known so far, or such states are not found together
        return None
    area = scene.measure(pressed.half_width) * pressed.half_width
    area *= 0.5 if scene.axisymmetric else 2.0
    return Branch(depth, pressed.force + scene.stiffness * area * (depth - levels), True)


def _leg(scene: Scene, turns: list[float], reach: float) -> tuple[Branch, int]:
    """The branch from the last of the turning depths, and the number of events on the path so far.

    It leads inwards after an odd number of turns, and outwards to the detachment after an even one.
    Depths are crowded where contact begins or is lost, over whose root the force is smooth.
    """
    touch = turns[0]
    start = turns[-1]
    share = np.linspace(0.0, 1.0, POINTS)
    if len(turns) % 2 == 1:
        depth = start + (touch + reach - start) * share**2
        history = load_path(scene, depths=[*turns, *depth[1:].tolist()], rtol=RTOL)
        own = [event for event in history.events if event.step >= len(turns)]
        force = history.force[len(turns) - 1 :]
        return Branch(depth, force, len(own) <= 1), len(history.events)

    deepest = min(start, touch)
    pressed = deepest + (start - deepest) * (1 - share[::2]) ** 2
    below = BEYOND * scene.opened.critical_separation
    attached = True
    while attached:
        pulled = np.linspace(deepest, touch - below, PULLED)  # it detaches somewhere here
        depth = np.append(pressed, pulled[1:])
        history = load_path(scene, depths=[*turns, *depth[1:].tolist()], rtol=RTOL)
        attached = not np.isnan(history.contacts[-1, 0])
        below = 2 * below or reach
    own = [event for event in history.events if event.step >= len(turns)]
    if not own:
        raise ValueError(f"depth = {start!r}: no contact to retract from")
    last = own[-1].before
    in_contact = depth > last.depth
    force = history.force[len(turns) - 1 :]
    force = np.append(force[in_contact], last.force)
    depth, chosen = np.unique(np.append(depth[in_contact], last.depth), return_index=True)
    smooth = len(own) <= 1
    kind = CubicSpline if smooth else PchipInterpolator
    root = share * math.sqrt(start - last.depth)
    force = kind(np.sqrt(depth - last.depth), force[chosen])(root)
    return Branch((last.depth + root**2)[::-1], force[::-1], smooth), len(history.events)
