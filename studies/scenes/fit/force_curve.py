"""A measured force–depth curve: turning points, noise, the line without contact, the contact.

Conventions:

- `noise` is the standard deviation of the noise of a force, from third differences; `resolution`
  the step between its digits; `may_be_noise(residuals, fitted, sigma)` whether residuals are no
  larger.
- `without_spikes` marks points that stick out, up to WIDEST_SPIKE in a row; `first_waves` finds
  waves in the first forces, and `wave_columns` are their cosine and sine.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from energy.arrays import Array, Indices, Mask
from studies.scenes.fit.disturbances import (
    WIDEST_SPIKE,
    first_waves,
    may_be_noise,
    noise,
    resolution,
    wave_columns,
    without_spikes,
)

# What is noise. Halved, CLEAR fails test_turning_points_are_found_through_noise; with twice CLEAR,
# and with half of SOFT or twice, the tests of turning points and of soft_l1 pass.
CLEAR = 5.0  # times the noise: a force, or a reversal of the depth; by chance once in 2e6 points
DISTINCT = 2.0  # times CLEAR: a force that is far from none, and not only more than CLEAR by chance
ROUNDING = 1e-9  # of a reversal, relative to the range of depths
LEAST = 1e-10  # noise, relative to the largest force
NO_WEIGHT = 1e-6  # root of the weight of a point that is left out
SOFT = 2.0  # times the noise: 95 % of normal residuals are less, those beyond hardly pull

# The force out of contact. With half of FLAT, STEEP and GUARD and with twice as much the tests of
# free lines pass; half of WAVY, which takes any line for waves, fails that of interference.
BASELINE = ("level", "slope", "drift")  # of the force out of contact
FLAT = 8  # points at least of a line without contact, as for `noise`
STEEP = 0.2  # of the mean slope of what follows: a line so steep may be part of a contact
GUARD = 0.1  # of the free points, those next to the contact, may feel it already
WAVY = 1.5  # times as many points as on a line: then the force out of contact has waves
STILL = 1e-9  # of the range of depths: a depth that changes by less is constant

# Holds. With half of RESTING and of LEAST_HOLD and with twice as much the tests of holds pass.
RATE_POINTS = 9  # over which the rate of the depth is measured, an odd number
RESTING = 0.05  # of the typical rate: a slower depth is at rest
LEAST_HOLD = 16  # points at rest in a row; a turn at constant speed has fewer than RATE_POINTS


class Curve(NamedTuple):
    """A measured force–depth curve, its points in the order of time.

    Parameters
    ----------
    depth : ndarray (n,)
        Depth of the tip, from any zero [m]; that of a tip on a spring has the noise of the force
        in it.
    force : ndarray (n,)
        Positive where the layer is pressed [N/m, or N around an axis].
    machine_stiffness : float
        Of the spring that holds the indenter, such as a cantilever, in units of the force per
        depth; inf if it is rigid.
    notes : tuple of str
        What was done to read the curve, in sentences.

    Examples
    --------
    >>> import numpy as np
    >>> from studies import Curve
    >>> curve = Curve(np.array([0.0, 1e-8]), np.array([0.0, 2e-9]), machine_stiffness=0.2)
    >>> curve.drive.round(10).tolist()
    [0.0, 2e-08]
    """

    depth: Array
    force: Array
    machine_stiffness: float = math.inf
    notes: tuple[str, ...] = ()

    @property
    def drive(self) -> Array:
        """Where the far end of the spring is, which has no noise: depth + force/stiffness (n,)."""
        return self.depth + self.force / self.machine_stiffness


def checked(curve: Curve) -> Curve:
    """The curve with arrays of numbers. ValueError for what is no force–depth curve."""
    depth = np.asarray(curve.depth, float)
    force = np.asarray(curve.force, float)
    if depth.ndim != 1 or depth.shape != force.shape:
        raise ValueError(
            f"curve: depth and force have the shapes {depth.shape} and {force.shape}; give arrays "
            "(n,) of the same length"
        )
    bad = np.flatnonzero(~np.isfinite(depth + force))
    if bad.size:
        first = f"the first is point {bad[0] + 1}, depth = {depth[bad[0]]}, force = {force[bad[0]]}"
        raise ValueError(
            f"curve: {bad.size} of {depth.size} points are not finite ({first}); remove them"
        )
    for name, values in (("depth", depth), ("force", force)):
        if np.unique(values).size < 2:
            raise ValueError(
                f"curve: the {name} is the same at all {values.size} points; give a curve in which "
                "the indenter moves in and out"
            )
    if not curve.machine_stiffness > 0:
        raise ValueError(
            f"curve: machine_stiffness = {curve.machine_stiffness!r} must be positive; inf if the "
            "indenter is held rigidly"
        )
    return curve._replace(depth=depth, force=force)


class Hold(NamedTuple):
    """A segment in which the indenter is held.

    Attributes
    ----------
    first : int
        Its first point.
    points : int
        How many there are.
    depth : float
        Their median depth [m].
    """

    first: int
    points: int
    depth: float

    def __str__(self) -> str:
        """That it was left out, and where."""
        return f"left out: a hold of {self.points} points at d = {self.depth:.4g} m"


def holds(curve: Curve) -> tuple[Hold, ...]:
    """The segments of a curve in which the position of the machine rests.

    The rate of the position is that of the least-squares line through RATE_POINTS neighbours. Where
    it is less than RESTING of its median for LEAST_HOLD points or more, the layer creeps or
    relaxes, which is no part of a quasi-static load path. Points beside such a segment that
    are nearer to it than half a step belong to it, too.
    """
    drive = curve.drive
    if drive.size < 2 * LEAST_HOLD:
        return ()
    half = RATE_POINTS // 2
    places = np.arange(-half, half + 1)
    sum_of_squares = half * (half + 1) * (2 * half + 1) / 3  # of the places
    weights = places / sum_of_squares  # which make the slope of the least-squares line
    rate = np.abs(np.correlate(drive, weights, mode="valid"))  # per point
    rests = np.zeros(drive.size, bool)
    rests[half:-half] = rate <= RESTING * np.median(rate)
    # Where points begin to rest and where they move again, in turn: each pair is a segment.
    changes = np.flatnonzero(np.diff(np.concatenate([[False], rests, [False]]).astype(int)))
    found = []
    for first, end in changes.reshape(-1, 2).tolist():
        if end - first >= LEAST_HOLD:
            margin = np.median(rate) / 2
            low = drive[first:end].min() - margin
            high = drive[first:end].max() + margin
            while first > 0 and low <= drive[first - 1] <= high:
                first -= 1
            while end < drive.size and low <= drive[end] <= high:
                end += 1
            found.append(Hold(first, end - first, float(np.median(curve.depth[first:end]))))
    return tuple(found)


def in_motion(curve: Curve) -> tuple[Curve, tuple[Hold, ...]]:
    """The curve without the segments in which the indenter is held in contact, and these."""
    free = free_parts(curve)
    left_out = tuple(
        hold for hold in holds(curve) if not free[hold.first : hold.first + hold.points].any()
    )
    return _without(curve, left_out), left_out


def chosen_points(
    depth: Array,
    depth_range: tuple[float, float] | None,
    exclude: Sequence[tuple[float, float]],
) -> Mask:
    """Which points (n,) lie in a range of depths [m] and in none of those to be left out.

    ValueError for a range that is not increasing or holds no point.
    """
    chosen = np.ones(depth.size, bool)
    intervals = [("range", depth_range, True)] if depth_range is not None else []
    intervals += [("exclude", interval, False) for interval in exclude]
    for name, (low, high), keep in intervals:
        if not low < high:
            raise ValueError(
                f"{name} = {(low, high)!r} must be two increasing depths in m, as in the file"
            )
        inside = (depth >= low) & (depth <= high)
        chosen &= inside if keep else ~inside
    if not chosen.any():
        raise ValueError(
            f"range = {depth_range!r} and exclude = {tuple(exclude)!r} leave no point; the depths "
            f"of the curve are {float(depth.min())!r} to {float(depth.max())!r} m"
        )
    return chosen


def _without(curve: Curve, left_out: tuple[Hold, ...]) -> Curve:
    """The curve without these segments."""
    kept = np.ones(curve.depth.size, bool)
    for hold in left_out:
        kept[hold.first : hold.first + hold.points] = False
    return curve._replace(depth=curve.depth[kept], force=curve.force[kept])


def turning_points(depth: Array) -> tuple[int, ...]:
    """Indices at which loading turns into unloading or back, by more than the depth's own noise."""
    least = max(CLEAR * noise(depth), ROUNDING * float(np.ptp(depth)))
    values = depth.tolist()
    turns = list[int]()
    lowest = 0  # since the last turn, as highest
    highest = 0
    direction = 0  # 1: the depth grows, -1: it falls; 0: not known yet
    for i, value in enumerate(values):
        if value < values[lowest]:
            lowest = i
        if value > values[highest]:
            highest = i
        if direction >= 0 and values[highest] - value > least:
            if direction:
                turns.append(highest)
            lowest = i
            direction = -1
        elif direction <= 0 and value - values[lowest] > least:
            if direction:
                turns.append(lowest)
            highest = i
            direction = 1
    # of several points at the turning depth, the middle one
    rests = (int((depth[turn:] != depth[turn]).argmax()) for turn in turns)
    return tuple(turn + (rest - 1) // 2 for turn, rest in zip(turns, rests, strict=True))


def loading(depth: Array) -> Mask:
    """Which points are measured while the depth grows (n,); a turning point ends its branch."""
    ends = [0, *turning_points(depth), depth.size - 1]
    grows = np.zeros(depth.size, bool)
    for start, end in pairwise(ends):
        grows[start + (start > 0) : end + 1] = depth[end] > depth[start]
    return grows


def outer_legs(depth: Array) -> tuple[slice, slice]:
    """The points up to the first turning point, and those from the last one on.

    Without a turning point all are approach if the depth grows; if it falls all are retraction, and
    the first one alone is the approach.
    """
    turns = turning_points(depth)
    n = depth.size
    if turns:
        return slice(0, turns[0] + 1), slice(turns[-1], n)
    if loading(depth)[-1]:
        return slice(0, n), slice(n, n)
    return slice(0, 1), slice(0, n)


def free_parts(curve: Curve) -> Mask:
    """Points before and after all contact whose force is a line but for noise (n,).

    Of each such line, GUARD of its points are left out where it meets the contact.
    """
    n = curve.force.size
    free = np.zeros(n, bool)
    before, after = outer_legs(curve.depth)
    first = _flat(curve.depth[before], curve.force[before])
    last = _flat(curve.depth[after][::-1], curve.force[after][::-1])
    free[: round((1 - GUARD) * first)] = True
    free[n - round((1 - GUARD) * last) :] = True
    return free


def position_is_height(position: Array, force: Array) -> bool:
    """Whether a position (n,) is a height above the layer, and not a depth.

    It is if the indenter is pressed at a position smaller than all those out of contact, since no
    layer pushes what it does not touch.
    """
    smooth = without_spikes(force)[1]
    free = free_parts(Curve(position, smooth))
    if not free.any():
        return False
    pushed = int(np.argmax(smooth))
    push = float(smooth[pushed] - np.median(smooth[free]))
    is_pressed = push > DISTINCT * CLEAR * noise(smooth)
    return bool(is_pressed and position[pushed] < position[free].min())


def _flat(depth: Array, force: Array) -> int:
    """How many of the first points lie on a line that is no part of the contact; 0 if too few."""
    sigma = max(noise(force), ROUNDING * float(np.abs(force).max(initial=0.0)))
    count = 0
    line = np.zeros(2)
    n = FLAT
    while n <= force.size - 2:
        degree = int(not _is_constant(depth[:n], depth))
        own = np.polyfit(depth[:n] - depth[0], force[:n], degree)
        off = force[:n] - np.polyval(own, depth[:n] - depth[0])
        if not may_be_noise(off, 2, sigma):
            break
        count = n
        line = own
        n = max(n + 1, int(1.2 * n))
    if not count:
        return 0
    beyond = np.abs(force - np.polyval(line, depth - depth[0])) > CLEAR * sigma
    leaves = np.flatnonzero(beyond[:-1] & beyond[1:])
    if leaves.size:
        count = int(leaves[0])
    if not FLAT <= count < force.size:
        return 0
    slope = line[0] if line.size == 2 else 0.0  # at constant depth the line is a level alone
    flat = abs(slope) * np.ptp(depth[count:]) < STEEP * np.ptp(force[count:])
    return count if flat else 0


def waves(curve: Curve) -> tuple[float, Array]:
    """Waves per length of interference out of contact, and its force at all points (n,).

    It is there where a line with waves describes WAVY times as many points of the approach, or of
    the retraction in reverse, as a line alone; the leg where it describes more points determines
    it. 0 waves: there is none.
    """
    depth = curve.depth - curve.depth[0]
    before, after = outer_legs(curve.depth)
    legs = (depth[before], curve.force[before]), (depth[after][::-1], curve.force[after][::-1])
    found = []
    for position, force in legs:
        on_a_line = _flat(position, force)
        fewest = math.ceil(WAVY * max(on_a_line, FLAT))
        found.append(first_waves(position, force, fewest))  # points: how many the waves describe
    best = max(found, key=lambda waves_of_leg: waves_of_leg.points)
    return best.number, wave_columns(depth, best.number) @ best.coefficients


def _is_constant(depth: Array, of: Array) -> bool:
    """Whether these depths are the same, but for STILL of the range of all depths."""
    return float(np.ptp(depth)) <= STILL * float(np.ptp(of))


def baseline(curve: Curve, free: Mask, wave: float = 0.0) -> Array:
    """The forces that a free line may have, for level, slope and drift of 1 (n, q).

    The drift, over the number of the point, only where there are free points on both sides of the
    contact; neither slope nor drift where the depth is constant out of contact, as that of an
    instrument that measures it from first touch on. None (n, 0) without free points. Interference
    adds a cosine and a sine of the position with so many waves per length.
    """
    n = curve.depth.size
    if not free.any():
        return np.empty((n, 0))
    columns = [np.ones(n)]
    if not _is_constant(curve.depth[free], curve.depth):
        position = curve.depth - curve.depth[0]
        columns.append(position)
        if free[0] and free[-1]:
            columns.append(np.linspace(0.0, 1.0, n))
        if wave:
            columns += [*wave_columns(position, wave).T]
    return np.stack(columns, axis=1)


class Mark(NamedTuple):
    """A depth between two points at which contact begins ("touch") or is lost ("detachment").

    Attributes
    ----------
    kind : {"touch", "detachment"}
    depth : float
        Halfway between the points [m].
    error : float
        Standard deviation of a depth that may lie anywhere between them.
    between : tuple of int
        Indices of both points.
    """

    kind: str
    depth: float
    error: float
    between: tuple[int, int]


class Leg(NamedTuple):
    """Points in contact while the indenter moves in one direction.

    Attributes
    ----------
    points : ndarray (n,)
        Their indices.
    turn : float
        Position of the machine at which the motion in this direction begins [m].
    """

    points: Indices
    turn: float


class Contact(NamedTuple):
    """A contact from its beginning to its end.

    Attributes
    ----------
    legs : list of Leg
        Inwards and outwards in turn; the first one is inwards, and may be empty.
    ends : list of Mark
        Where contact is seen to begin and to be lost.
    """

    legs: list[Leg]
    ends: list[Mark]

    def of(self, chosen: Mask) -> Contact:
        """The same with these points (n,) alone, and the ends that lie between two of them."""
        legs = [leg._replace(points=leg.points[chosen[leg.points]]) for leg in self.legs]
        ends = [mark for mark in self.ends if chosen[list(mark.between)].all()]
        return Contact(legs, ends)


def contacts(curve: Curve) -> tuple[Contact, ...]:
    """All points from the first force to the last one, between turns without any.

    A force is there where two neighbours have it. An end is seen where the curve is pulled on one
    side and without force on the other.
    """
    clear = CLEAR * noise(curve.force)
    loaded = np.abs(curve.force) > clear
    neighbour = np.append(loaded[1:], False) | np.append(False, loaded[:-1])
    loaded &= neighbour
    turns = turning_points(curve.depth)
    grows = loading(curve.depth)
    cuts = [turn for turn in turns if not loaded[turn] and not grows[turn]]
    found = []
    for start, stop in pairwise([0, *cuts, curve.depth.size]):
        inside = np.flatnonzero(loaded[start:stop])
        if not inside.size:
            continue
        first = start + int(inside[0])
        last = start + int(inside[-1])
        ends = []
        if first > start:
            ends += _end(curve, "touch", first, first - 1, clear)
        if last + 1 < stop:
            ends += _end(curve, "detachment", last, last + 1, clear)
        inner = [turn for turn in turns if first < turn < last]
        found.append(Contact(_legs(curve.depth, first, inner, last, bool(grows[first])), ends))
    return tuple(found)


def _end(curve: Curve, kind: str, near: int, beside: int, clear: float) -> list[Mark]:
    """The end of contact between a point with a force and one beside it without; [] if not seen.

    It is seen where the force jumps to or from a pull that is DISTINCT. Less may have grown past
    `clear` without a jump, as a push does.
    """
    low, high = sorted((float(curve.depth[near]), float(curve.depth[beside])))
    is_pulled = curve.force[near] < -DISTINCT * clear
    if not (is_pulled and high > low):
        return []
    return [Mark(kind, (low + high) / 2, (high - low) / math.sqrt(12), (near, beside))]


def _legs(drive: Array, first: int, turns: list[int], last: int, inwards: bool) -> list[Leg]:
    """The legs of a contact, inwards and outwards in turn, the first of them inwards.

    Parameters
    ----------
    drive : ndarray (n,)
        Position of the machine [m], which grows inwards.
    first, last : int
        Indices of the first and the last point in contact.
    turns : list of int
        Indices of the turning points between them, increasing; a turning point ends its leg.
    inwards : bool
        Whether the machine moves inwards at the first point. If it does not, the contact was found
        on the way out, and a leg inwards without points comes first.

    Returns
    -------
    list of Leg
        A motion inwards from out of contact begins at -inf.
    """
    starts = [first, *(turn + 1 for turn in turns)]
    stops = [*starts[1:], last + 1]
    start_of_motion = -math.inf if inwards else float(drive[first])
    turn_positions = [start_of_motion, *drive[turns].tolist()]
    legs = []
    for start, stop, turn in zip(starts, stops, turn_positions, strict=True):
        legs.append(Leg(np.arange(start, stop), turn))
    if not inwards:
        no_points = np.arange(0)
        legs.insert(0, Leg(no_points, -math.inf))
    return legs


def _next_to(found: Sequence[Contact], count: int) -> Mask:
    """Which of `count` points are within a spike's width of an end of contact (n,)."""
    near = np.zeros(count, bool)
    for contact in found:
        points = np.concatenate([leg.points for leg in contact.legs])
        first = int(points[0])
        last = int(points[-1])
        near[max(first - WIDEST_SPIKE, 0) : first + WIDEST_SPIKE] = True
        near[max(last + 1 - WIDEST_SPIKE, 0) : last + 1 + WIDEST_SPIKE] = True
    return near


@dataclass(frozen=True)
class Data:
    """A curve of n points, of which some are in contact and some have no force.

    Attributes
    ----------
    curve : Curve
        As measured.
    flat : Curve
        Force over the position of the machine, less the line through its free parts.
    columns : ndarray (n, q)
        Forces that this line may have.
    used, free : ndarray of bool (n,)
        Which points are in contact, and which have no force.
    contacts : tuple of Contact
    sigma : float
        Noise of the force, or what rounding to digits makes of it.
    size : float
        Largest force in contact.
    known : tuple of (str, float)
        Quantities of the scene with relative standard uncertainties, which count as measurements.
    roots : ndarray (m,)
        Roots of the weights of the points in contact, the free ones, the ends of contacts and what
        is known, in this order.
    lines : ndarray (m, q)
        The weighted columns there.
    nearest : ndarray (q, m)
        The pseudo-inverse of the lines.
    wave : float
        Waves per length of the interference in the force; 0 without.
    spikes : ndarray of bool (n,)
        Points that stick out from their neighbours and are used for nothing.
    """

    curve: Curve
    flat: Curve
    columns: Array
    used: Mask
    free: Mask
    contacts: tuple[Contact, ...]
    sigma: float
    size: float
    known: tuple[tuple[str, float], ...]
    roots: Array
    lines: Array
    nearest: Array
    wave: float
    spikes: Mask

    @classmethod
    def of(
        cls,
        curve: Curve,
        chosen: Mask | None = None,
        known: Sequence[tuple[str, float]] = (),
    ) -> Data:
        """Find contacts, free parts and disturbances of a curve.

        chosen: which points (n,) may be used, by default all; where contact begins and ends is
        found from all of them.
        """
        chosen = np.ones(curve.force.size, bool) if chosen is None else chosen
        spikes, smooth = without_spikes(curve.force)
        wave, interference = waves(Curve(curve.drive, smooth))
        free = free_parts(Curve(curve.drive, smooth - interference))
        columns = baseline(Curve(curve.drive, smooth), free, wave)
        line = np.linalg.lstsq(columns[free], smooth[free], rcond=None)[0]
        flat = Curve(curve.drive, smooth - columns @ line)
        found = contacts(flat)
        # a spike beside an end of contact may be the end itself
        doubtful = spikes & _next_to(found, spikes.size)
        if doubtful.any():
            spikes = spikes & ~doubtful
            smooth = np.where(doubtful, curve.force, smooth)
            flat = flat._replace(force=smooth - columns @ line)
            found = contacts(flat)
        found = tuple(one.of(chosen & ~spikes) for one in found)
        used = np.zeros(curve.force.size, bool)
        for leg in (leg for one in found for leg in one.legs):
            used[leg.points] = True
        free &= chosen & ~spikes & ~used
        size = float(np.abs(curve.force[used]).max(initial=0))
        sigma = max(noise(smooth), resolution(curve.force) / math.sqrt(12), LEAST * size)
        others = sum(len(one.ends) for one in found) + len(known)
        lines = np.concatenate([columns[used], columns[free], np.zeros((others, columns.shape[1]))])
        return cls(
            curve=curve,
            flat=flat,
            columns=columns,
            used=used,
            free=free,
            contacts=found,
            sigma=sigma,
            size=size,
            known=tuple(known),
            roots=np.ones(len(lines)),
            lines=lines,
            nearest=np.linalg.pinv(lines),
            wave=wave,
            spikes=spikes,
        )

    def reweighted(self, residuals: Array, outliers: Mask) -> Data:
        """The data with the weights 1/√(1 + r²/c²) of the loss soft_l1, c = SOFT σ, at residuals r.

        residuals: (m,) in the order of `roots`, in units of the force, without weights. Only those
        of forces are weighted by them: ends of contact and known quantities have the weight 1.
        outliers: (n,), points that are left out.

        A minimum of the sum of weighted squares that has these weights itself is one of
        Σ 2c² (√(1 + r²/c²) - 1), which grows with |r| far out: single points hardly pull.
        """
        roots = (1 + (residuals / (SOFT * self.sigma)) ** 2) ** -0.25
        roots[self.points.size :] = 1.0
        return self.with_roots(roots * self.roots_without(outliers))

    def roots_without(self, outliers: Mask) -> Array:
        """Roots of weights (m,) that are 1, but for outliers (n,) and the ends of contact there."""
        ends = [any(outliers[list(mark.between)]) for mark in self.ends]
        known = [False] * len(self.known)
        return np.where([*outliers[self.points], *ends, *known], NO_WEIGHT, 1.0)

    @property
    def points(self) -> Indices:
        """Points in contact and free ones, in the order of the residuals of forces."""
        return np.concatenate([np.flatnonzero(self.used), np.flatnonzero(self.free)])

    @property
    def outliers(self) -> Mask:
        """Which points (n,) were left out because the fit showed them to be wrong."""
        found = np.zeros(self.used.size, bool)
        found[self.points] = self.roots[: self.points.size] <= NO_WEIGHT
        return found

    def with_roots(self, roots: Array) -> Data:
        """The data with other roots of weights > 0 (m,)."""
        lines = self.lines * (roots / self.roots)[:, None]
        nearest = np.asarray(np.linalg.pinv(lines), float)
        return replace(self, roots=roots, lines=lines, nearest=nearest)

    @property
    def ends(self) -> tuple[Mark, ...]:
        """Drives at which contact is seen to begin and to be lost."""
        return tuple(mark for one in self.contacts for mark in one.ends)

    @property
    def legs(self) -> tuple[Leg, ...]:
        """The legs of all contacts."""
        return tuple(leg for one in self.contacts for leg in one.legs)

    @property
    def span(self) -> float:
        """Range of the drives in contact."""
        return float(np.ptp(self.curve.drive[self.used]))
