"""The simulated force of a scene as a function of where a machine is, read off depth paths.

A path of imposed depths is followed once. Held by a spring of stiffness K whose far end is at D,
the indenter is in equilibrium where D = d + P(d)/K: as D grows the depth is where the running
maximum of d + P(d)/K along the path first reaches it, as D falls, where the running minimum does.
The offset of the depth and the stiffness of the machine cost no further path.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from scipy.interpolate import CubicSpline, PchipInterpolator

from discretization import Event, History, load_path
from energy import Scene
from studies.shared import Array

RTOL = 1e-4  # asked of the paths, whose forces are then right to some 1e-6
BEYOND = 1.01  # times δ₀ below touching nothing holds
POINTS, DENSE = 300, 3000  # on a leg of a path, and where the machine is looked for


@dataclass(frozen=True)
class Branch:
    """Equilibria in contact along one way of the indenter (n,), in the order of the motion.

    smooth: no jumps on it.
    """

    depth: Array
    force: Array
    smooth: bool

    def read(self, drives: Array, stiffness: float, blunt: float = 0.0) -> tuple[Array, float]:
        """Forces at drives (n,), and the drive at which the branch ends.

        From `blunt` before its end, where dP/dD is often infinite, and beyond it the force goes on
        along its slope there; deeper than it is known, along the slope of its deepest points.
        """
        s, drive, spline = self._reached(stiffness)
        ahead, root = drives - drive[0], np.sqrt(drive - drive[0])
        at = np.interp(np.sqrt(np.maximum(ahead, blunt)), root, s)
        force = spline(at)
        first = float(np.interp(math.sqrt(blunt), root, s))
        rise = float(spline(first, 1))
        slope = rise / (2 * first + rise / stiffness) if blunt else 0.0
        force += slope * np.minimum(ahead - blunt, 0.0)
        deep = float((spline(s[-1]) - spline(s[-2])) / (drive[-1] - drive[-2]))
        return force + deep * np.maximum(drives - drive[-1], 0.0), float(drive[0])

    def _reached(self, stiffness: float) -> tuple[Array, Array, CubicSpline]:
        """Roots of the depths from the end that a machine reaches, its drives there, the force.

        Over the root of the distance the force is smooth where the contact is lost.
        """
        way = -1 if self.depth[-1] < self.depth[0] else 1
        end = self.depth[-1] if way < 0 else self.depth[0]
        root = np.sqrt(np.abs(self.depth - end))
        kind = CubicSpline if self.smooth else PchipInterpolator
        spline = kind(root[::way], self.force[::way])
        s = np.linspace(0.0, root.max(), DENSE)
        drive = end + s**2 + spline(s) / stiffness
        extreme = np.minimum.accumulate(drive[::-1])[::-1]
        if way > 0:
            extreme = np.maximum.accumulate(drive)
        return s[extreme == drive], drive[extreme == drive], spline

    def depth_at(self, drive: float, stiffness: float) -> float:
        """The depth where the machine is at that drive."""
        force, _ = self.read(np.array([drive]), stiffness)
        return drive - float(force[0]) / stiffness


def touching(scene: Scene) -> float:
    """The depth of first touch, where nothing adheres from afar: min f."""
    springs = replace(scene, layer=replace(scene.layer, response="springs"))
    return float(load_path(springs, forces=[0.0]).events[0].before.depth)


def retraction(scene: Scene, touch: float, reach: float) -> tuple[Branch, bool]:
    """From as deep as `reach` below the touch to the detachment; whether the way in is the same."""
    history, branch = _leg(scene, [touch, touch + reach], reach)
    return branch, reversible(scene) and len(history.events) == 2


def reversible(scene: Scene) -> bool:
    """Whether contacts can take the same way in and out: separate springs let go later."""
    return scene.opening is None and scene.gamma1 > 0


def one_way(
    scene: Scene, touch: float, reach: float, drives: Sequence[float], stiffness: float
) -> list[Branch]:
    """From the touch inwards, and on in turn from each of the turning drives; reach: as above."""
    found, depths = [_leg(scene, [touch], reach)[1]], [touch]
    for drive in drives:
        depths.append(found[-1].depth_at(drive, stiffness))
        found.append(_leg(scene, depths, reach)[1])
    return found


def _leg(scene: Scene, turns: list[float], reach: float) -> tuple[History, Branch]:
    """On from the last of these depths, outwards to the detachment after an even number of them.

    Depths are crowded where contact begins or is lost, over whose root the force is smooth.
    """
    touch, start, t = turns[0], turns[-1], np.linspace(0.0, 1.0, POINTS)
    if len(turns) % 2:  # inwards
        depth = start + (touch + reach - start) * t**2
        history = load_path(scene, depths=[*turns, *depth[1:].tolist()], rtol=RTOL)
        force, own = history.force[len(turns) - 1 :], _events(history, turns)
        return history, Branch(depth, force, len(own) <= 1)
    history = _through(scene, turns, reach)
    own = _events(history, turns)
    if not own:
        raise ValueError(f"depth = {start!r}: no contact to retract from")
    last = own[-1].before
    depth = (last.depth + (start - last.depth) * t**2)[:0:-1]
    path = load_path(scene, depths=[*turns, *depth[1:].tolist()], rtol=RTOL)
    held = depth > last.depth
    force = path.force[len(turns) - 1 :][held]
    ends = np.append(depth[held], last.depth), np.append(force, last.force)
    return history, Branch(*ends, len(own) <= 1)


def _events(history: History, turns: list[float]) -> list[Event]:
    """What happens beyond the last of the turns."""
    return [event for event in history.events if event.step >= len(turns)]


def _through(scene: Scene, turns: list[float], reach: float) -> History:
    """The path over these depths and on to where contact is lost."""
    below = BEYOND * scene.opened.critical_separation
    while True:
        history = load_path(scene, depths=[*turns, turns[0] - below], rtol=RTOL)
        if np.isnan(history.contacts[-1, 0]):
            return history
        below = 2 * below or reach
