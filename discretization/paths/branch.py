"""What a load path is made of, states and events, and what it needs to know of a discretisation.

A branch is the family of states that are met as an imposed depth changes. `Branch` is what each
discretisation provides of it; load paths under any control are read off that (load_path.py).

Conventions
-----------
The depth d is positive down into the layer [length]. The force P is positive where the indenter is
pressed (compressive) and negative where it is pulled; for a line contact P and the energy U count
per length of it, about an axis they are those of the whole contact. U includes - w times what is in
contact, with w of closing, and is 0 without contact.

Contact lines are a flat tuple: both ends of every contact from left to right, (left, right, left,
right, ...). About an axis they are radii, and the left end of a contact on the axis is 0.

Of a control, "force" and "drive" are loads whose energy counts: F is a dead load, K the stiffness
of a machine and D the position of its far end (control.py). Per-point arrays (2, n) hold U in their
first row and P in the second one.

δ₀ = √(2w/k) is `Scene.critical_separation`, l = √(γ₁/k) `elastocapillary_length`, and
`Scene.opened` is the scene with the work of adhesion of contacts that open. `walls` are the ends of
the profile at which the body itself ends. `summed` integrates a function over panels, which are
halved until that changes nothing; the integrals of each panel are its `sums`. `moved`, of branches
that have it, is the list of points at depths in one direction from a point.
"""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple, Protocol

import numpy as np

from discretization.quadrature import summed
from energy import Scene
from energy.arrays import Array

# Where the left and the right outermost line is pinned: "edge" of the body, "tip", or "" if free.
Pinned = tuple[str, str]
_ROUNDING = 2e-16  # of the sum of what P is made of: one rounding of a double
_KNOWN = 1e-14  # of ∫|P dd|: as well as it is known, some fifty roundings of a double


class Snapshot(NamedTuple):
    """A state just before or after an event.

    Attributes
    ----------
    depth : float
        d [length].
    force, energy : float
        P [force/length], compressive if positive, and U [energy/length]; of the whole contact with
        rotational symmetry.
    left, right : float
        The outermost contact lines [length], nan when detached. With rotational symmetry they are
        radii, and `left` of a contact on the axis is 0.
    inner : tuple of float
        Those in between, where there are several contacts [length].
    axisymmetric : bool
        Whether there is rotational symmetry.
    """

    depth: float
    force: float
    energy: float
    left: float
    right: float
    inner: tuple[float, ...] = ()
    axisymmetric: bool = False

    @property
    def lines(self) -> tuple[float, ...]:
        """All contact lines from left to right."""
        return self.left, *self.inner, self.right

    @property
    def half_width(self) -> float:
        """Half the total contact length a, or the radius of the outermost line; 0 if detached."""
        if math.isnan(self.left):
            return 0.0
        widths = np.subtract(self.lines[1::2], self.lines[::2])
        return self.right if self.axisymmetric else float(widths.sum()) / 2


class Event(NamedTuple):
    """Something that happened at one value of the control, between two steps of a path.

    Attributes
    ----------
    kind : str
        "touch" or "jump-in" (contact begins, without or with energy released), "tip depinning",
        "edge depinning" and their opposites "... pinning", "detachment" (the contact has closed),
        "pull-off" (unstable under force or machine control), "jump" (unstable, still in contact),
        "nucleation", "splitting" (another contact), "coalescence" or "closing" (one contact less).
    control, before, after, step
        The value at which it happens, the states, and the number of the step that follows. Under
        force control a pull-off ends where the contact closes up under the dead load.
    energy_released : float
        The drop of U at fixed depth, of U - F d at fixed force, of U + K/2 (D - d)² at fixed drive.

    Examples
    --------
    Of the path of the example of `load_path`:

    >>> event = path.events[0]
    >>> print(event.kind, f"{event.energy_released:.3g} J/m", f"{event.after.half_width:.3g} m")
    jump-in 1.13e-08 J/m 0.00012 m
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
    """The most tensile state of a path.

    Attributes
    ----------
    force : float
        P < 0 [force/length].
    depth, half_width : float
        d and a there [length].
    """

    force: float
    depth: float
    half_width: float


class Point(NamedTuple):
    """Contacts at a depth: a place on a path, of which energy and force are not yet computed.

    Attributes
    ----------
    depth : float
        d [length].
    lines : tuple of float or None
        All contact lines from left to right [length], () where only touching, None if detached.
    memory : object
        What else its branch has to know to go on from here, such as contacts on nodes. Only that
        branch reads it.
    """

    depth: float
    lines: tuple[float, ...] | None
    memory: Any = None

    @property
    def ends(self) -> tuple[float, float]:
        """x of the outermost lines; nan where there are none."""
        return (self.lines[0], self.lines[-1]) if self.lines else (math.nan, math.nan)

    @property
    def inner(self) -> tuple[float, ...]:
        """The lines between the outermost ones, where there are several contacts."""
        return (self.lines or ())[1:-1]


@dataclass(eq=False)
class PathSegment:
    """A part of a path at imposed depths, with nothing but smooth motion between its ends.

    Depths on it are start + (end - start) t²(3 - 2t), 0 <= t <= 1: at both ends P may vary like a
    root of the distance in depth, which is smooth in t, as the distance is like t² there.

    Attributes
    ----------
    branch : Branch
        What has followed it.
    start, end : Point
        In the order of the path, so that the depth may fall from one to the other.
    after : Point or None
        The contacts beyond an event at the end, at the same depth; None where nothing happens.
    jumps : bool
        Whether lines jump at that event.
    """

    branch: Any
    start: Point
    end: Point
    after: Point | None
    jumps: bool

    @property
    def smooth(self) -> bool:
        """Whether P is a smooth function of d on it."""
        return bool(self.branch.smooth)

    @property
    def pinned(self) -> Pinned:
        """Where the outermost lines are pinned on it, as in `Branch.pinned`.

        If they are not pinned alike at both ends, the middle of the segment decides: at an end a
        line may have just come to a corner, or be about to leave it.
        """
        if self.branch.pinned(self.start) == self.branch.pinned(self.end):
            return self.branch.pinned(self.start)
        (between,) = self.points(np.array([(self.start.depth + self.end.depth) / 2]))
        return self.branch.pinned(between)

    def points(self, depths: Array) -> list[Point]:
        """The contacts at depths (n,) on the segment [length]."""
        known = {point.depth: point for point in (self.end, self.start)}
        new = np.array([depth for depth in depths.tolist() if depth not in known])
        if new.size:
            known |= zip(new.tolist(), self.between(new), strict=True)
        return [known[depth] for depth in depths.tolist()]

    def between(self, depths: Array) -> list[Point]:
        """The contacts at depths (n,) strictly between its ends, by moving on from the start."""
        return list(self.branch.moved(self.start, depths))

    def forces(self, depths: Array, *, roughly: bool = False) -> Array:
        """P (n,) at depths (n,) on the segment.

        roughly: whether P need only be as good as the polynomials that represent it (`Curve`).
        """
        return np.asarray(self.branch.totals(self.points(depths))[1])

    def depths(self, t: Array) -> Array:
        """d at parameters t (n,) [length]; the depth of the end itself at t = 1."""
        start = self.start.depth
        end = self.end.depth
        depths = start + (end - start) * (t * t * (3 - 2 * t))
        return np.where(t == 1.0, end, np.clip(depths, min(start, end), max(start, end)))

    @property
    def rounding(self) -> float:
        """What rounding leaves of P on the segment.

        It is a part of the size of what P is a sum of: the pressure k (d - f) over the contact and
        over l beside it, where |d - f| is at most about |d| + 2 |min f| + δ₀.
        """
        branch = self.branch
        scene = branch.scene
        widths = np.fmax(0.0, np.diff([self.start.ends, self.end.ends]))
        width = float(widths.max()) + scene.elastocapillary_length
        size = max(abs(self.start.depth), abs(self.end.depth)) + 2 * abs(branch.touch)
        pushed = scene.stiffness * (size + branch.holding_range)
        return _ROUNDING * pushed * (width**2 if scene.axisymmetric else width)

    def external_work(self) -> float:
        """∫P dd from the start to the end, on parts halved until that changes it no more.

        The error is at most 1e-14 ∫|P dd|, or what rounding leaves. It is positive where the load
        does work on the layer [energy/length].
        """
        span = self.end.depth - self.start.depth

        def density(t: Array) -> Array:
            """P dd/dt."""
            force = self.forces(self.depths(t.ravel())).reshape(t.shape)
            return np.array([span * 6 * t * (1 - t) * force])

        whole = np.array([[0.0], [1.0]])
        found = summed(density, whole, _KNOWN, np.zeros((1, 1)), smooth=True)
        return float(found.sums.sum())


class Branch(Protocol):
    """The states under a prescribed depth, which a load path is made of.

    A subclass provides `touch`, `first`, `segment` and `opened`, and `many` or `totals`; the rest
    has defaults.

    Attributes
    ----------
    scene : Scene
    smooth : bool
        Whether P is a smooth function of d between events.
    """

    scene: Scene
    smooth: bool = True

    @property
    def resolution(self) -> float:
        """The length by which lines may be off [length]."""
        return 0.0

    @property
    def touch(self) -> float:
        """Depth at which contact begins [length]."""

    @property
    def holding_range(self) -> float:
        """How far below the depth of touching a contact can stay: δ₀ of opening [length]."""
        return self.scene.opened.critical_separation

    @property
    def first(self) -> Point:
        """The contacts at first touch."""

    def contact(self, depth: float, *lines: float) -> Point:
        """The point at a depth with these lines, two for every contact [length]."""
        return Point(depth, lines)

    def segment(self, point: Point, goal: float) -> PathSegment:
        """The path from a point in contact towards another depth, up to the first event.

        Parameters
        ----------
        point : Point
        goal : float
            [length].

        Returns
        -------
        PathSegment
            At least up to a change of what pins lines, at most to the goal.

        Raises
        ------
        ValueError
            If a contact leaves the known profile.
        NotCertifiedError
            If something happens that the branch cannot follow.
        """

    def points_of(self, parts: Sequence[tuple[PathSegment, Array]]) -> list[list[Point]]:
        """Points on segments, all at once where that is faster.

        Parameters
        ----------
        parts : sequence of (PathSegment, ndarray (n,))
            Segments of this branch, and depths on them [length].

        Returns
        -------
        list of list of Point
            The points at the depths of each part.
        """
        return [segment.points(depths) for segment, depths in parts]

    def pinned(self, point: Point) -> Pinned:
        """Where each of the outermost lines is pinned: "edge", "tip" or "" where it is free."""
        walls = self.scene.indenter.walls
        first, last = ("edge" if x in walls else "" for x in point.ends)
        return first, last

    def totals(self, points: Sequence[Point]) -> Array:
        """Energies and forces of points in contact.

        Parameters
        ----------
        points : sequence of Point
            n of them.

        Returns
        -------
        ndarray (2, n)
            U, with the work of adhesion of closing [energy/length], and P [force/length].
        """
        found = np.empty((2, len(points)))
        for own in alike(points):
            found[:, own] = self.many([points[i] for i in own])
        return found

    def many(self, points: Sequence[Point]) -> Array:
        """U and P (2, n) of points in contact that all have the same number of lines."""

    def total(self, point: Point) -> Array:
        """U and P (2,) of one point; both 0 when detached."""
        return np.zeros(2) if point.lines is None else self.totals([point])[:, 0]

    def recorded(self, points: Sequence[Point]) -> tuple[Array, Array, Array]:
        """What is reported of points in contact.

        Parameters
        ----------
        points : sequence of Point
            n of them, along which lines move in one direction.

        Returns
        -------
        lines : ndarray (n, 2)
            The outermost ones [length].
        force, energy : ndarray (n,)
            P [force/length] and U [energy/length].
        """
        energy, force = self.totals(points)
        return np.array([point.ends for point in points]), force, energy

    def snapshot(self, point: Point) -> Snapshot:
        """A point just before or after an event, with its energy and force."""
        energy, force = self.total(point).tolist()
        return snapshot_of(point, energy, force, self.scene.axisymmetric)

    def snapshots(self, points: Sequence[Point]) -> list[Snapshot]:
        """Points just before or after events, all at once where that is faster."""
        return [self.snapshot(point) for point in points]

    def friction(self, before: Point, after: Point) -> float:
        """Energy lost where lines move without a jump [energy/length].

        U counts with w of closing. Where the contact opens, w_opening is spent, of which only w is
        in U: so w_opening - w is lost per length. What `opened` says closes with a loss loses w.
        """
        opened = self.opened(before, after)
        closing = self.scene.work_of_adhesion
        if opened > 0:
            return opened * (self.scene.opened.work_of_adhesion - closing)
        return opened * -closing

    def opened(self, before: Point, after: Point) -> float:
        """The length that opens between two points, weighted with the pattern's factor [length].

        About an axis it is an area. It is negative, minus what closes, on branches on which springs
        have to be touched before they adhere, and so lose w as they do (springs.py); on others it
        is 0 where contacts close.
        """

    def closes_at(self, state: Snapshot) -> bool:
        """Whether the depth at which this last contact closes is known as well as states are.

        It is not where nodes are too coarse for the contact just before.
        """
        return True

    def released(self, depth: float, left: float, right: float) -> None:
        """Warn if the state after the loss of a contact may be one with a very narrow contact.

        depth: of the state; left, right: the outermost lines before the contact was lost [length].
        """
        return None

    def certify(self, point: Point) -> None:
        """NotCertifiedError unless the contacts are in equilibrium."""

    def certify_all(self, points: Sequence[Point]) -> None:
        """The same of many points."""
        for point in points:
            self.certify(point)


def snapshot_of(point: Point, energy: float, force: float, axisymmetric: bool) -> Snapshot:
    """The snapshot of a point with this energy and force."""
    return Snapshot(point.depth, force, energy, *point.ends, point.inner, axisymmetric)


def alike(points: Sequence[Point]) -> Iterator[list[int]]:
    """Numbers of the points that have the same number of lines, one list for every number."""
    counts = np.array([len(point.lines or ()) for point in points])
    for count in np.unique(counts).tolist():
        yield np.flatnonzero(counts == count).tolist()
