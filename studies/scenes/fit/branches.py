"""The simulated force of a scene as a function of where a machine is, read off depth paths.

Where the line is free its states are known without a path (free_branch.py of the fitted mesh and of
the layer); else a path of imposed depths is followed once. Held by a spring of stiffness K whose
far end is at D, the indenter is in equilibrium where D = d + P(d)/K: as D grows the depth is where
the running maximum of d + P(d)/K along the path first reaches it, as D falls, where the running
minimum does.
The offset of the depth and the stiffness of the machine cost no further path.
"""

import math
from dataclasses import dataclass, replace
from functools import lru_cache

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
POINTS = 300
PULLED = 600
DENSE = 3000  # on a leg, below touching, and for the machine
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
        """Forces at drives (n,), and the drive at which the branch ends.

        From `blunt` before its end, where dP/dD is often infinite, and beyond it the force goes on
        along its slope there; deeper than it is known, along the slope of its deepest points.
        """
        s, drive, root, spline = _reached(self, stiffness)
        ahead = drives - drive[0]
        at = np.interp(np.sqrt(np.maximum(ahead, blunt)), root, s)
        force = spline(at)
        first = float(np.interp(math.sqrt(blunt), root, s))
        rise = float(spline(first, 1))
        slope = rise / (2 * first + rise / stiffness) if blunt else 0.0
        force += slope * np.minimum(ahead - blunt, 0.0)
        risen = np.diff(spline(s[-2:])).sum()
        moved = np.diff(drive[-2:]).sum()
        deep = risen / moved if moved else 0.0  # a machine this soft passes over every state
        return force + deep * np.maximum(drives - drive[-1], 0.0), float(drive[0])


@lru_cache(8)
def _reached(branch: Branch, stiffness: float) -> tuple[Array, Array, Array, CubicSpline]:
    """Roots of the depths from the end that a machine reaches, its drives there, the roots of
    their distances from the first one, the force.

    Over the root of the distance the force is smooth where the contact is lost.
    """
    way = -1 if branch.depth[-1] < branch.depth[0] else 1
    end = branch.depth[-1] if way < 0 else branch.depth[0]
    kind = CubicSpline if branch.smooth else PchipInterpolator
    spline = kind(np.sqrt(np.abs(branch.depth - end))[::way], branch.force[::way])
    s = np.linspace(0.0, spline.x[-1], DENSE)
    drive = end + s**2 + spline(s) / stiffness
    extreme = np.minimum.accumulate(drive[::-1])[::-1]
    if way > 0:
        extreme = np.maximum.accumulate(drive)
    s = s[extreme == drive]
    drive = drive[extreme == drive]
    return s, drive, np.sqrt(drive - drive[0]), spline


def touching(scene: Scene) -> float:
    """The depth of first touch, where nothing adheres from afar: min f."""
    springs = replace(scene, layer=replace(scene.layer, response="springs"))
    return float(load_path(springs, forces=[0.0]).events[0].before.depth)


@lru_cache(KEPT)
def retraction(scene: Scene, touch: float, reach: float) -> tuple[Branch, bool]:
    """From as deep as `reach` below the touch to the detachment; whether nothing else happens."""
    found = None
    if free_on_springs(scene):
        found = on_springs(scene, touch + reach, POINTS)
    elif free_on_layer(scene):
        found = on_layer(scene, touch + reach, POINTS, RTOL)
    if found:
        return Branch(found.depth[::-1], found.force[::-1], True), True
    branch, events = _leg(scene, [touch, touch + reach], reach)
    return branch, events == 2


def ways(
    scene: Scene, touch: float, reach: float, drives: tuple[float, ...], stiffness: float
) -> list[Branch]:
    """A branch for the way in from the touch, and for that from each of the turning drives in turn.

    They are one where a contact takes the same way in and out: separate springs let go later.
    """
    if scene.opening is None and scene.gamma1 > 0:
        both, same = retraction(scene, touch, reach)
        if same:
            return [both] * (1 + len(drives))
    return _one_way(scene, touch, reach, drives, stiffness)


@lru_cache(KEPT)
def _one_way(
    scene: Scene, touch: float, reach: float, drives: tuple[float, ...], stiffness: float
) -> list[Branch]:
    def leg(turns: list[float]) -> Branch:
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
    """As `_leg`, of springs without tension below a convex profile; None if that is not so.

    In contact is what lies below a level L of the profile, which the depth lifts as it exceeds it,
    and lowers as it falls below L - δ₀, δ₀ that of opening. With A(L) the length or area in contact
    and P₀ the force at the depth L, P = P₀(L) + k A(L) (d - L).
    """
    body = scene.indenter
    holds = scene.opened.critical_separation
    if not body.convex or len(body.corners):
        return None
    touch = turns[0]
    start = turns[-1]
    t = np.linspace(0.0, 1.0, POINTS)
    level = touch
    lost = touch - holds
    for turn in turns:
        level = float(np.clip(level, turn, turn + holds))
    if len(turns) % 2 == 1:
        depth = start + (touch + reach - start) * t**2
    else:
        if start <= lost:
            raise ValueError(f"depth = {start!r}: no contact to retract from")
        depth = start - (start - lost) * (1 - (1 - t) ** 2)
    levels = np.clip(level, depth, depth + holds)
    try:
        pressed = minimise_many(replace(scene, opening=None), np.maximum(levels, touch))
    except ValueError:  # the profile is not known so far, or such states are not found together
        return None
    area = scene.measure(pressed.half_width) * pressed.half_width
    area *= 0.5 if scene.axisymmetric else 2.0
    return Branch(depth, pressed.force + scene.stiffness * area * (depth - levels), True)


def _leg(scene: Scene, turns: list[float], reach: float) -> tuple[Branch, int]:
    """On from the last of these depths, outwards to the detachment after an even number of them;
    how many events there were up to its end.

    Depths are crowded where contact begins or is lost, over whose root the force is smooth.
    """
    touch = turns[0]
    start = turns[-1]
    t = np.linspace(0.0, 1.0, POINTS)
    below = BEYOND * scene.opened.critical_separation
    inwards = len(turns) % 2 == 1
    while True:
        depth = start + (touch + reach - start) * t**2
        if not inwards:
            low = min(start, touch)
            pressed = low + (start - low) * (1 - t[::2]) ** 2
            pulled = np.linspace(low, touch - below, PULLED)  # it lets go somewhere here
            depth = np.append(pressed, pulled[1:])
        history = load_path(scene, depths=[*turns, *depth[1:].tolist()], rtol=RTOL)
        own = [event for event in history.events if event.step >= len(turns)]
        force = history.force[len(turns) - 1 :]
        if inwards:
            return Branch(depth, force, len(own) <= 1), len(history.events)
        if np.isnan(history.contacts[-1, 0]):
            break
        below = 2 * below or reach
    if not own:
        raise ValueError(f"depth = {start!r}: no contact to retract from")
    last = own[-1].before
    smooth = len(own) <= 1
    held = depth > last.depth
    depth = np.append(depth[held], last.depth)
    force = np.append(force[held], last.force)
    depth, chosen = np.unique(depth, return_index=True)
    kind = CubicSpline if smooth else PchipInterpolator
    even = t * math.sqrt(start - last.depth)
    force = kind(np.sqrt(depth - last.depth), force[chosen])(even)
    return Branch((last.depth + even**2)[::-1], force[::-1], smooth), len(history.events)
