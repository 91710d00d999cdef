"""Contact without surface tension, γ₁ = 0, of any profile: independent springs.

Each spring attaches when it is touched and detaches at u = -δ₀, so that the contact is what lies
below a level of the profile. Pressed, the level is the depth where that is higher; retracted, it is
d + δ₀ where that is lower. So from first touch, and with the least energy, it is

    adhered:  f <= min(max(d, min f), d + δ₀),        global:  f <= d + δ₀    (18).

Nothing jumps on a path: what attaches loses its work of adhesion, as it had to be touched, and no
energy is released at once.

Conventions
-----------
The depth d and the displacement u are positive down into the layer, heights f of the profile
upwards [length]; in contact u = d - f, so that a spring is stretched by f - d, at most
δ₀ = √(2w/k). A level is a height: in contact is what of the profile is not above it. The memory of
a `Point` is its level. Lines are a flat tuple, both ends of every contact from left to right; as
arrays (m, 2) they are the left and right ends of m contacts. P is positive where pressed; U counts
with w of what is in contact.

`Resolved` is the profile with samples, whose local extremes and corners are among them;
`SmallSurfaces` stands for the free surfaces, which do not exist without tension.

`Branch.holding_range` is δ₀ of opening, `critical_separation` that of the scene. `refined` are the
energy and the force of contacts with their errors (`Interval`, with what heights are off by in
`rounding`), its `of_state` the entries of an `Equilibrium`; `estimated` are relative errors, from
how far lines may be off. `Certificate` has five violations over their scales: penetration,
stationarity, opening, neighbours, force; `undeformed` is that of a surface without contact, and
`detached` its state. `walls` are the ends of the profile at which the body itself ends: lines there
are pinned. `crossings` finds zeros of many functions between brackets; `worst` is its argument, but
0 if that is negative. ROUNDING is 16 times 2⁻⁵².

A `Branch` has the states at imposed depths: `segment(point, goal)` is the path from a `Point`
(depth, lines, None without contact, and its memory) towards a depth, up to the next change. A
`PathSegment` has its points `start` and `end`, the point `after` an event, None if there is none,
and whether lines jump there, which they never do here. `resolve` samples the profile, as far as
contact is possible at a depth; `demand` raises NotCertifiedError if a certificate fails.
"""

from __future__ import annotations

import functools
import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from discretization.certificate import ROUNDING, Certificate, worst
from discretization.equilibrium import Equilibrium, detached
from discretization.fitted.contacts import estimated
from discretization.paths.branch import Branch, PathSegment, Point
from discretization.profile import Resolved, resolve
from discretization.quadrature import Integrals, Interval, refined
from discretization.roots import crossings
from discretization.surfaces.small import SmallSurfaces
from energy import Scene
from energy.arrays import Array, Indices, Mask

# Of the level and δ₀: how far above the level a lowest point may lie by rounding, some fifty of a
# double.
_TIE = 1e-14
# Of the depths: two places that close are one, five roundings of a double. Neither a tenth nor ten
# times of either changes a result (`python -m tests.sensitivity discretization.paths.springs`).
_APART = 1e-15


def on_springs(scene: Scene, depth: float, *, branch: str) -> Equilibrium:
    """The certified state of independent springs.

    Parameters
    ----------
    scene : Scene
    depth : float
        d [length].
    branch : {"adhered", "global"}
        "adhered": the end of the path from first touch; "global": the state of least energy.

    Returns
    -------
    Equilibrium

    Raises
    ------
    ValueError
        If the contact leaves the known profile.
    NotCertifiedError
        If it touches springs that are free.
    """
    springs = SpringsBranch(scene, resolve(scene, depth))
    highest = depth + scene.critical_separation  # where springs still stay in contact
    level = highest if branch == "global" else min(max(depth, springs.touch), highest)
    return springs.state(depth, level, branch)


def lines_below(profile: Resolved, levels: Array) -> list[Array]:
    """The ends of the parts of the profile at or below each level, all at once.

    Parameters
    ----------
    profile : Resolved
    levels : ndarray (k,)
        Heights [length].

    Returns
    -------
    list of ndarray (2m,)
        For each level the ends of its m parts, increasing [length].

    Raises
    ------
    ValueError
        If a part goes on beyond the known profile.
    """
    # The profile is taken to rise at once beyond its ends: so a part that reaches one ends there.
    x = np.pad(profile.x, 1, mode="edge")
    f = np.pad(profile.f, 1, constant_values=math.inf)
    ends = [np.flatnonzero(np.diff(f <= z)) for z in levels]  # samples just before ends of parts
    counts = [z.size for z in ends]
    before = np.concatenate(ends)
    level = np.repeat(levels, counts)
    lo = x[before]
    hi = x[before + 1]
    # Ends are in turns left and right ones: the sample of the two that belongs to the part.
    inside = before + 1 - np.arange(before.size) % 2
    unknown = lo[(lo == hi) & ~np.isin(lo, profile.indenter.walls)]
    if unknown.size:
        raise ValueError(
            f"the contact spreads to x = {float(unknown[0])!r}, where the profile is not known any "
            "more; give a wider profile or a smaller depth"
        )
    with np.errstate(divide="ignore"):  # beyond a wall it rises at once
        rise = (f[before + 1] - f[before]) / (hi - lo)
    guess = x[inside] + (level - f[inside]) / rise  # of the straight line between both samples

    def above(z: Array, own: Indices) -> Array:
        """f - level at places, of the ends with these numbers."""
        return np.asarray(profile.indenter.height(z), float) - level[own]

    found = crossings(above, lo, hi, guess, rise, 0.0)
    return np.split(found, np.cumsum(counts)[:-1])


@dataclass(frozen=True, eq=False)
class SpringsBranch(Branch):
    """Independent springs under a prescribed depth; the memory of a point is its level.

    Attributes
    ----------
    scene : Scene
    profile : Resolved
        The profile as far as contacts reach at the largest depth of the programme.
    """

    scene: Scene
    profile: Resolved

    @classmethod
    def of(cls, scene: Scene, deepest: float) -> SpringsBranch:
        """The springs of a scene, for depths up to the deepest of the programme [length]."""
        return cls(scene, resolve(scene, deepest))

    @property
    def touch(self) -> float:
        """The depth of first touch, min f [length]."""
        return self.profile.touch

    @functools.cached_property
    def integrals(self) -> Integrals:
        """Integrals over the profile, by which U and P of contacts are differences."""
        return Integrals.of(self.scene, self.profile, float(self.profile.f.max()))

    @functools.cached_property
    def heights(self) -> Array:
        """Levels at which contacts begin, merge, or meet a corner or an end, increasing [length].

        These are the heights of local extremes, of corners and of the ends of the profile.
        """
        f = self.profile.f
        steps = np.diff(f)
        turns = (
            np.flatnonzero(steps[1:] * steps[:-1] <= 0) + 1
        )  # a corner has a step of 0 beside it
        return np.unique(np.concatenate([f[:1], f[turns], f[-1:]]))

    @property
    def first(self) -> Point:
        """The contacts at first touch."""
        before = Point(self.touch, None, self.touch)  # for its level, that of first touch
        return self.moved(before, np.array([self.touch]))[0]

    def contact(self, depth: float, *lines: float) -> Point:
        """The point with these lines: its level is the height of the profile there.

        A line at an edge of the body may be lower, so the highest one counts.
        """
        level = float(np.max(self.profile.indenter.height(np.array(lines))))
        return Point(depth, lines, level)

    def moved(self, before: Point, depths: Array) -> list[Point]:
        """The points at depths (n,) in one direction from a point.

        The level stays as long as it lies between the depth and δ₀ above it: then springs neither
        attach nor detach.
        """
        levels = np.clip(before.memory, depths, depths + self.holding_range)
        levels = np.maximum(levels, self.touch)  # where the last contact is lost by rounding
        found = lines_below(self.profile, levels)
        return [
            Point(d, tuple(lines.tolist()), level)
            for d, level, lines in zip(depths.tolist(), levels.tolist(), found, strict=True)
        ]

    def segment(self, point: Point, goal: float) -> PathSegment:
        """The path from a point towards another depth, up to the next change of the contact.

        It ends at the goal, at the depth from which on the level moves with it, at one at which the
        level passes one of `heights`, or where the last spring is lost.
        """
        here = point.depth
        level = point.memory
        direction = 1 if goal > here else -1
        if direction > 0:  # springs attach where the depth is their height,
            stretch = 0.0
            lost_at = -math.inf
        else:  # and detach where it is δ₀ less
            stretch = self.holding_range
            lost_at = self.touch - stretch
        size = abs(here) + abs(goal) + abs(self.touch) + self.holding_range
        least = _APART * size
        heights_ahead = self.heights[direction * (self.heights - level) > 0]
        changes = np.append(heights_ahead, level) - stretch  # depths
        changes = changes[direction * (changes - here) > least]
        nearest = float((direction * changes).min(initial=math.inf))
        end = direction * min(direction * goal, nearest)
        lost = end <= lost_at + least
        if lost:
            end = lost_at
        (there,) = self.moved(point, np.array([end]))
        return PathSegment(self, point, there, Point(end, None) if lost else None, False)

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points that all have the same number of lines."""
        lines = np.array([point.lines for point in points])
        depths = np.repeat([point.depth for point in points], lines.shape[1])
        parts = self.integrals.contact(lines.ravel(), depths, self.scene.work_of_adhesion)
        # Integrals from a fixed place to each line, as differences of which contacts come.
        energy_and_force = parts[::2].reshape(2, *lines.shape)
        each_contact = energy_and_force[..., 1::2] - energy_and_force[..., ::2]
        return np.asarray(each_contact.sum(axis=2))

    def opened(self, before: Point, after: Point) -> float:
        """The length that opens between two points; negative, minus what closes, where it closes.

        What closes had to be touched first and loses its work of adhesion (`Branch.friction`).
        """
        return self._length(before) - self._length(after)

    def _length(self, point: Point) -> float:
        """The length, about an axis the area, in contact at a point."""
        # ∫ of the pattern's factor from a fixed place to each line, the last of the five integrals.
        lengths = self.integrals.at(np.array(point.lines or ()))[4]
        return float((lengths[1::2] - lengths[::2]).sum())

    def state(self, depth: float, level: float, branch: str) -> Equilibrium:
        """The certified state in which what is not above a level is in contact.

        Parameters
        ----------
        depth, level : float
            d, and the level [length]. If the level is below the lowest point, without contact.
        branch : str
            Named in the state.

        Raises
        ------
        NotCertifiedError
            If it is no equilibrium.
        ValueError
            If the contact leaves the known profile.
        """
        scene = self.scene
        size = max(abs(depth), self.holding_range) or 1.0
        surfaces = SmallSurfaces(scene)
        if self.touch > level + _TIE * size:
            through = worst((depth - self.touch) / size)
            certificate = Certificate.undeformed(through)
            return detached(scene, depth, branch, surfaces, certificate)
        level = max(level, self.touch)
        lines = lines_below(self.profile, np.array([level]))[0].reshape(-1, 2)
        pinned = np.isin(lines, self.profile.indenter.walls)
        certificate = _certificate(self.profile, lines, pinned, depth, level, size)
        certificate.demand(f"the state at depth = {depth!r}", "try another depth")
        found = refined(scene, depth, lines, ())  # there are no free surfaces
        moves = _moves(scene, lines, pinned, depth, found)
        return Equilibrium(
            scene,
            depth,
            branch,
            "fitted",
            certificate,
            surfaces,
            contacts=lines,
            nodes=lines,
            pinned=pinned,
            errors=estimated(scene, depth, lines, moves, found),
            **found.of_state,
        )

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the springs are in equilibrium."""
        if point.lines is not None:
            self.state(point.depth, point.memory, "adhered")


def _certificate(
    profile: Resolved, lines: Array, pinned: Mask, depth: float, level: float, size: float
) -> Certificate:
    """The certificate of springs that are in contact up to a level.

    penetration: of the profile into springs that are free; opening: by what the profile over
    springs in contact is higher than the level, which is at most d + δ₀, or than the depth;
    neighbours: how far lines are off the level. All are over `size`. The force is that of the
    pressure alone, the same by both routes.

    Parameters
    ----------
    profile : Resolved
    lines : ndarray (m, 2)
        Left and right ends of the contacts [length].
    pinned : ndarray of bool (m, 2)
        Which of them are at edges of the body, below the level.
    depth, level, size : float
        d, the level, and the size of depths [length].
    """
    x = profile.x
    f = profile.f
    # Free are samples with even numbers of lines to their left, if they are no lines themselves.
    free = (np.searchsorted(lines.ravel(), x) % 2 == 0) & ~np.isin(x, lines)
    penetration = float((depth - f[free]).max(initial=0.0))
    heights = np.asarray(profile.indenter.height(lines))
    off = float(np.abs(heights - level)[~pinned].max(initial=0.0))
    stretched = float((f[~free] - max(level, depth)).max(initial=0.0))
    return Certificate(penetration / size, 0.0, stretched / size, off / size, 0.0)


def _moves(scene: Scene, lines: Array, pinned: Mask, depth: float, found: Interval) -> Array:
    """How far lines (m, 2) may be off [length]: what heights are off by, over the slope there.

    No further than the sum of all widths, where the slope is 0; pinned lines not at all.
    """
    height = scene.indenter.height(lines)
    slope = np.abs(scene.indenter.slope(lines))
    with np.errstate(divide="ignore", invalid="ignore"):
        moves = (ROUNDING * (np.abs(height) + abs(depth)) + found.rounding) / slope
    return np.where(pinned, 0.0, np.fmin(moves, np.diff(lines, axis=1).sum()))
