"""What nodes do not resolve of the profile, looked for on the profile itself.

Nodes know of a profile its heights, and between them they assume it to be as smooth as these are.
Three conditions show whether it is, wherever a state depends on it.

Lines. The surface and the indenter part at a contact line with the slope

    r(x) = f'(x) + u'(x)     (finite slopes: 2 sin(ψ/2), ψ the angle between them),

both outwards of the contact, u' that of a free surface which begins at x. The energy changes by
∂U/∂x = γ₁/2 r² - w, times the cosine of the inclination with finite slopes, as the contact grows:
the first integral of a free surface, γ₁u'²/2 = ku²/2, leaves this square. So where a line rests

    r <= √(2w/γ₁) on its inner side,   r >= √(2w/γ₁) on its outer side,

which is looked at on the profile a part of a link inwards and outwards, less where it is steep, and
but for a part of the slopes. A line of which it is not true stands where the nodes have it because
they see less of the profile than there is.

Between the nodes the profile should keep to its chord, but for what the largest second difference
around the link allows,

    |f_i + (f_{i+1} - f_i) s - f(x)| <= c max(|f_{i-1} - 2 f_i + f_{i+1}|,
                                              |f_i - 2 f_{i+1} + f_{i+2}|),     s = (x - x_i)/Δx,

with c = 1/4, twice what a parabola needs, or c = 1/2 in a link with a corner, which needs it where
the corner is in the middle. Nor should its slope turn, back and forth, by more than 12 c times that
difference over Δx: three times as much as that of the parabola or at the corner. Else it may be in
contact, where its forces are not those of the nodes, or stick through a free surface. Nor should
its slope leave the range of those of the chords of this link and the next ones by a part of
√(2w/γ₁): a line would have stopped there. A convex profile has no such places.

Tips. A contact narrower than a link has no link, and so no adhesion: nodes lose it too early. It is
there as long as r < √(2w/γ₁) just beside the lowest point of the profile, on both sides.

Conventions
-----------
x and all lengths are those of the scene, not counted in links; only "of a link" and `place` are in
units of the spacing. Depths d and displacements u are positive down into the layer, heights f and
slopes f' upwards, u = d - f in contact.

Lines of n states with m contacts are an array (n, 2m) of x, from left to right: even columns are
the left lines of contacts, odd ones the right lines. `side` is -1.0 for left lines and 1.0 for
right ones. Outwards of a contact is towards the free surface of the line: to the left at a left
line. f' and u' of `Parting` are derivatives outwards, so that f' > 0 where the profile rises away
from the contact, and u' < 0 where the surface comes up to its level from below. An axis of length 2
that comes first is (inwards, outwards) of the line.

A line recedes where r > √(2w/γ₁) on its inner side, with w of opening (`Scene.opened`), and
advances where r < √(2w/γ₁) on its outer side, with w of closing. With rotational symmetry a contact
around the axis has an inner end at 0, which is no line: only the outer one is judged.

`Resolved` has samples of the profile as close as its own features ask for (profile.py), with each
corner twice; `Lattice.tail.shape(x, left, right, depth)` gives u and du/dx of the free surface
between two lines, None for one infinitely far away; `Lattice.stored(u).value` is the energy of the
springs per area. Of a lattice, `origin` is x of node 0, `weight(i)` that of node i or, at i + ½, of
link i: 1, or about an axis the radius over Δr; `cell` is the length or area of a link of weight 1,
`tail_stiffness(node, side)` what the tail beyond a contact node pulls with over u, and `axis` 0
about an axis, else nan. `numbers(lattice, (low, high))` are the numbers of the first and the last
node between two places.

Of a scene, `elastocapillary_length` is l = √(γ₁/k), `critical_separation` δ₀ = √(2w/k) and
`work_of_adhesion` w, both of closing; `opened` is the scene with w of opening for that; `pattern`
multiplies w by `factor(x)`, or is None. Of an indenter, `extent` is (low, high), where its profile
is known; `walls` are those of its ends at which the body ends, where lines are pinned; `apex` is x
of the lowest point if it falls nowhere on the way outwards, else None; `slope_beside(x, side)` is
f' on one side of x; `breaks()` are x of all corners, jumps of higher derivatives, and the apex.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import EPSILON, AccuracyWarning
from discretization.equilibrium import Equilibrium
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import heights, numbers
from discretization.profile import Resolved, resolve
from energy import Plane, Scene
from energy.arrays import Array, Mask


class BetweenNodes(NamedTuple):
    """What the profile may do between nodes.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each but `smooth` leaves the 6
    or more random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.lattice.unresolved`.

    Attributes
    ----------
    smooth : float
        Off the chord, over the largest second difference of heights around the link: twice the 1/8
        of a parabola. With 1/8 one of 12 random states on sufficient nodes warns.
    cornered : float
        The same in a link with a corner, which is off by this if it is in the middle.
    turning : float
        How much the slope may turn, over the same and Δx and one of the above: three times as much
        as that of a parabola or at a corner.
    rounding : float
        Of the heights: their rounding.
    steeper : float
        Of √(2w/γ₁): by how much slopes may leave the range of those of the chords.
    samples : int
        Samples in a link in search of a spacing that would do.
    """

    smooth: float = 1 / 4
    cornered: float = 1 / 2
    turning: float = 12.0
    rounding: float = 64 * EPSILON
    steeper: float = 1 / 4
    samples: int = 16


_BETWEEN = BetweenNodes()


_TINY = float(np.finfo(float).tiny)  # off the chord where only the slope shows it


@dataclass(frozen=True)
class LinesOnNodes:
    """How well nodes know where a line rests.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 3 or more
    random states and paths that read it as they are to 1e-9 (`near_axis` is not read there):
    `python -m tests.sensitivity discretization.lattice.unresolved`.

    Attributes
    ----------
    slopes : float
        Of √(2w/γ₁) and of |u'|: how well r is known.
    place : float
        Of a link: how well the place of a line that adheres is known.
    height : float
        Of δ₀ and |u|: how well the height beside a line is known.
    steep : float
        Of δ₀ and |u|: a profile that rises by more over a link is steep for its nodes.
    level : float
        Of l: by how much a profile may rise over a link with finite slopes.
    missed : float
        Of the depth and δ₀: a penetration that counts, as in the certificate.
    near_axis : float
        Links: nearer to an axis no free surface is read.
    few_links : int
        Links of a contact, with fewer of which its lines stand on nodes.
    """

    slopes: float = 1 / 16
    place: float = 1 / 4
    height: float = 1 / 64
    steep: float = 1 / 4
    level: float = 1 / 16
    missed: float = 1e-9
    near_axis: float = 1e-3
    few_links: int = 4


_ON_NODES = LinesOnNodes()


class NarrowContacts(NamedTuple):
    """How contacts narrower than a link are looked for.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 1 or more
    random states and paths that read it as they are to 1e-9 (`stored_about_axis` and
    `stored_finite` are not read there): `python -m tests.sensitivity
    discretization.lattice.unresolved`.

    Attributes
    ----------
    samples : int
        Samples about such a contact: 16 in each link next to a lone node.
    halvings : int
        Halvings of the spacing: down to 1e-12 of it.
    tie : float
        Of √(2w/γ₁): beyond the rounding of r.
    stored_about_axis : float
        What free surfaces beside a narrow contact store at least, over what those beside one of a
        link would. About an axis this falls as 1/ln(l/r): to 1/8 for a disc of e⁻⁸ links where l is
        3 links.
    stored_finite : float
        The same with finite slopes, up to 45°: (2/3)(1 - c³)/(1 - c²), c = cos 45°.
    """

    samples: int = 33
    halvings: int = 40
    tie: float = 1e-9
    stored_about_axis: float = 1 / 8
    stored_finite: float = 0.86


_NARROW = NarrowContacts()


_SIDES = np.array([-1.0, 1.0])  # of left and right lines
_INWARDS_OUTWARDS = np.array([-1.0, 1.0])[:, None, None]  # times `side`: both directions in x


class Unseen(NamedTuple):
    """Places between the nodes that these do not describe.

    Attributes
    ----------
    x, f : ndarray (n,)
        Places, and the profile there [length].
    off : ndarray (n,)
        How far f is from the chord between the nodes, at least the smallest positive number, as its
        slope may be all that differs; 0 where the profile is only steep [length].
    steep : ndarray of bool (n,)
        Whether a line may stop there at a slope that the nodes do not have.
    lowest : float, optional
        x of the lowest point of a profile that is not convex [length].
    """

    x: Array
    f: Array
    off: Array
    steep: Mask
    lowest: float | None = None


class _Samples(NamedTuple):
    """Samples of the profile between nodes, and the nodes around their links.

    Attributes
    ----------
    x, f, slope : ndarray (n,)
        Places, heights [length] and f' there.
    link : ndarray (n,)
        The lattice's number of the node before each: its link goes from there to the next node.
    cornered : ndarray of bool (n,)
        Whether its link has a corner.
    nodes : ndarray (4, n)
        Heights of the node before the link, of both its ends, and of the node after it [length].
    """

    x: Array
    f: Array
    slope: Array
    link: Array
    cornered: Mask
    nodes: Array

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, lattice: Lattice) -> _Samples:
        """The samples in links that have a next one on both sides."""
        first, last = numbers(lattice, scene.indenter.extent)
        link = np.floor((profile.x - lattice.origin) / lattice.spacing)
        inside = (link > first) & (link + 1 < last)
        link = link[inside]
        corners = np.floor((profile.corners - lattice.origin) / lattice.spacing)
        return cls(
            profile.x[inside],
            profile.f[inside],
            profile.slope[inside],
            link,
            np.isin(link, corners),
            heights(lattice, scene.indenter, link + np.arange(-1.0, 3.0)[:, None]),
        )

    def off_chord(self, lattice: Lattice) -> Array:
        """How far the profile is from the chord of its link (n,)."""
        place = (self.x - lattice.origin) / lattice.spacing
        chord = self.nodes[1] + (place - self.link) * (self.nodes[2] - self.nodes[1])
        return np.asarray(np.abs(chord - self.f))

    def turned(self) -> Array:
        """By how much the slope turns within the link of each sample, back and forth (n,).

        The sum of |f' of a sample less f' of the one before| over the samples of one link: at a
        corner, which stands twice, that is the jump.
        """
        number = (self.link - self.link[:1]).astype(int)
        same_link = number[1:] == number[:-1]
        turns = np.abs(np.diff(self.slope)) * same_link
        count = number.max(initial=0) + 1
        return np.asarray(np.bincount(number[1:], turns, count)[number])

    def allowed(self) -> Array:
        """How far from the chord the second differences of the nodes allow it to be (n,)."""
        bend = np.abs(np.diff(self.nodes, 2, axis=0)).max(axis=0)
        return np.asarray(np.where(self.cornered, _BETWEEN.cornered, _BETWEEN.smooth) * bend)

    def beyond_chords(self, lattice: Lattice) -> Array:
        """By how much f' Δx leaves the range of the rises of three links (n,) [length].

        These are the link of the sample and the ones before and after it. Negative inside.
        """
        rise = lattice.spacing * self.slope
        rises_of_links = np.diff(self.nodes, axis=0)
        above = rise - rises_of_links.max(axis=0)
        below = rises_of_links.min(axis=0) - rise
        return np.asarray(np.maximum(above, below))


def unseen(scene: Scene, depth: float, lattice: Lattice, *, anywhere: bool = False) -> Unseen:
    """Places between the nodes that these do not describe, where contact is possible.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    lattice : Lattice
    anywhere : bool
        Whether the surface is free everywhere: then the lowest point is enough.

    Returns
    -------
    Unseen
        Empty for a convex profile.

    Raises
    ------
    ValueError
        As `resolve`.

    Warns
    -----
    AccuracyWarning
        As `resolve`.
    """
    if scene.indenter.convex:
        nothing = np.empty(0)
        return Unseen(nothing, nothing, nothing, np.empty(0, bool))
    profile = resolve(scene, depth)
    low = profile.lowest
    if anywhere:
        touch = np.array([profile.touch])  # the height of the lowest point
        return Unseen(np.array([low]), touch, np.array([_TINY]), np.array([False]), low)
    samples = _Samples.of(scene, profile, lattice)
    rounding = _BETWEEN.rounding * np.abs(samples.nodes).max(initial=0.0)
    off = samples.off_chord(lattice)
    turned = lattice.spacing * samples.turned() / _BETWEEN.turning
    hidden = np.maximum(off, turned) > samples.allowed() + rounding
    steep = np.zeros(samples.x.size, bool)
    if scene.gamma1 and scene.work_of_adhesion:
        kink = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
        beyond = samples.beyond_chords(lattice)
        steep = beyond > lattice.spacing * _BETWEEN.steeper * kink + rounding
    found = hidden | steep
    off = np.where(hidden, np.maximum(off, _TINY), 0.0)
    return Unseen(samples.x[found], samples.f[found], off[found], steep[found], low)


def warn_unresolved(
    states: Iterable[Equilibrium], places: Unseen, lattice: Lattice, stacklevel: int
) -> None:
    """Warn where surfaces of states miss the profile at places that the nodes do not describe.

    Parameters
    ----------
    states : iterable of Equilibrium
        Of one scene.
    places : Unseen
    lattice : Lattice
    stacklevel : int
        Of the warning, counted from the caller.

    Warns
    -----
    AccuracyWarning
        Where the indenter is in the surface, in contact off it, or steeper than its nodes.
    """
    states = [*states] if places.x.size else []
    if not states:
        return
    scene = states[0].scene
    inside = np.array([state.inside(places.x) for state in states])
    missed = _missed(states, places, inside)
    worst = int(np.argmax(missed))
    size = max(scene.critical_separation, *(abs(state.depth) for state in states))
    passed = places.steep & inside.any(axis=0)
    if missed[worst] > _ON_NODES.missed * size:
        x = float(places.x[worst])
        problem = f"the surface between them misses the indenter by {float(missed[worst])!r}"
    elif passed.any():
        x = float(places.x[np.argmax(passed)])
        problem = "a contact line has passed where the profile is steeper than on these nodes"
    else:
        return
    _warn(scene, lattice, x, problem, stacklevel + 1)


def _missed(states: Sequence[Equilibrium], places: Unseen, inside: Mask) -> Array:
    """The most by which surfaces of states miss the indenter at n places (n,) [length].

    In contact that is how far the profile is off the nodes' chord; elsewhere how deep it is in the
    free surface. inside (s, n): whether each state has each place in contact.
    """
    missed = np.where(inside, places.off, 0.0).max(axis=0)
    hidden = places.off > 0  # not only steeper
    if hidden.any():
        x = places.x[hidden]
        f = places.f[hidden]
        penetration = [state.depth - f - state.displacement(x) for state in states]
        through = np.where(inside[:, hidden], 0.0, penetration).max(axis=0)
        missed[hidden] = np.maximum(missed[hidden], through)
    return np.asarray(missed)


def warn_lines(scene: Scene, lattice: Lattice, depth: Array, lines: Array, stacklevel: int) -> None:
    """Warn where contact lines are not where the profile lets them rest.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    depth : ndarray (n,)
        [length].
    lines : ndarray (n, 2m)
        Positions of all lines of each state [length].
    stacklevel : int
        Of the warning, counted from the caller.

    Warns
    -----
    AccuracyWarning
    """
    off = astray(scene, lattice, depth, lines)
    if off.any():
        state, column = np.argwhere(off)[0].tolist()
        skipped = int(lattice.axis == 0)  # `astray` has no column for the end at the axis
        x = float(lines[state, column + skipped])
        problem = (
            f"at depth = {float(depth[state])!r} the profile does not let a contact line rest "
            "where they have it"
        )
        _warn(scene, lattice, x, problem, stacklevel + 1)


def warn_losses(
    scene: Scene,
    lattice: Lattice,
    depth: float,
    before: tuple[float, ...],
    lines: tuple[float, ...],
    stacklevel: int,
) -> None:
    """Warn if nodes lose a contact that the profile holds at the next depth of a path.

    A contact is lost if none of this depth overlaps it. It is put back among the others and judged
    as if it were there; it has to hold by more than slopes are known.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    depth : float
        [length].
    before : tuple of float
        Both ends of all contacts at the depth before [length].
    lines : tuple of float
        Both ends of all contacts at this depth [length].
    stacklevel : int
        Of the warning, counted from the caller.

    Warns
    -----
    AccuracyWarning
    """
    now = list(zip(lines[::2], lines[1::2], strict=True))
    for left, right in zip(before[::2], before[1::2], strict=True):
        if any(first <= right and last >= left for first, last in now):
            continue
        contacts = sorted([*now, (left, right)])
        all_lines = np.reshape(contacts, (1, -1))
        tolerance = -_ON_NODES.slopes
        held = _held_by_profile(scene, lattice, np.array([[depth]]), all_lines, tolerance)
        if held[0, contacts.index((left, right))]:
            problem = f"at depth = {depth!r} they have lost a contact which the profile holds"
            _warn(scene, lattice, (left + right) / 2, problem, stacklevel + 1)


def lowest_within(scene: Scene, lattice: Lattice, left: float, right: float) -> float:
    """Position of the lowest point of the profile within a link of a contact.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    left, right : float
        Ends of the contact [length].

    Returns
    -------
    float
        [length].
    """
    low, high = scene.indenter.extent
    start = max(left - lattice.spacing, low)
    end = min(right + lattice.spacing, high)
    breaks = scene.indenter.breaks()
    inner = breaks[(breaks > start) & (breaks < end)]
    # 264 samples, besides where f' jumps: 66 in each link about a contact of two links.
    x = np.append(inner, np.linspace(start, end, 8 * _NARROW.samples))
    return float(x[np.argmin(scene.indenter.height(x))])


def _warn(scene: Scene, lattice: Lattice, x: float, problem: str, stacklevel: int) -> None:
    """AccuracyWarning of a problem at x, with the spacing that would do."""
    closer = resolving_spacing(scene, lattice, x)  # [length]
    warnings.warn(
        f"at x = {x!r}, between nodes {lattice.spacing!r} apart: {problem}; a feature or contact "
        f"narrower than the spacing may be missed; give a spacing of {closer!r}, or "
        "method='fitted'",
        AccuracyWarning,
        stacklevel=stacklevel + 1,
    )


class _Line(NamedTuple):
    """Lines at x, where the profile has the height f: what `LatticeTail.shape` needs of them."""

    x: Any
    f: Any


class Parting(NamedTuple):
    """How surface and indenter part at lines; arrays of the shape of their positions.

    Attributes
    ----------
    r : ndarray
        f' + u' outwards; with finite slopes 2 sin(ψ/2).
    u_slope : ndarray
        u' outwards, negative where u > 0; with finite slopes the inclination of the surface [rad].
    u : ndarray
        The displacement d - f of the line [length].
    """

    r: Array
    u_slope: Array
    u: Array


def parting(
    scene: Scene, lattice: Lattice, depth: Any, x: Array, side: Any, read: Any, facing: Any = None
) -> Parting:
    """How surface and indenter part at lines, each alone at its x while the others stay.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    depth : float or ndarray
        That broadcasts with x [length].
    x : ndarray (..., n, 2m)
        Positions [length].
    side : ndarray
        1 if the free surface is on the right, -1 if it is on the left.
    read : ndarray
        The side of x, 1 or -1, on which f' is read where it jumps.
    facing : ndarray (n, 2m), optional
        Positions of all lines as the lines that they face feel them [length]. Without it free
        surfaces are tails, as those of one contact are.

    Returns
    -------
    Parting
    """
    f = scene.indenter.height(x)
    u = depth - f
    rise = side * scene.indenter.slope_beside(x, read)
    if lattice.axis == 0:
        _, u_slope = lattice.tail.shape(x, _Line(x, f), None, depth)
        return Parting(rise + u_slope, u_slope, u)
    # Of tails the first integral: the surface stores what the springs below it do.
    if lattice.linear:
        u_slope = u * (-1 / scene.elastocapillary_length)
    else:
        stored = lattice.stored(u).value / lattice.gamma1
        u_slope = -np.copysign(np.sqrt(2 * stored), u)
    if lattice.slopes == "finite":
        inclination = -np.copysign(np.arccos(np.maximum(1 - stored, 0.0)), u)
        return Parting(2 * np.sin((np.arctan(rise) + inclination) / 2), inclination, u)
    if facing is not None:
        left_of_gap = np.s_[..., 1:-1:2]  # right lines of contacts, with a gap on their right
        right_of_gap = np.s_[..., 2::2]  # left lines of contacts, with a gap on their left
        own_left = _Line(x[left_of_gap], f[left_of_gap])
        own_right = _Line(x[right_of_gap], f[right_of_gap])
        facing_f = scene.indenter.height(facing)
        faced_on_right = _Line(facing[right_of_gap], facing_f[right_of_gap])
        faced_on_left = _Line(facing[left_of_gap], facing_f[left_of_gap])
        shape = lattice.tail.shape
        _, u_slope[left_of_gap] = shape(own_left.x, own_left, faced_on_right, depth)
        _, towards_right = shape(own_right.x, faced_on_left, own_right, depth)
        u_slope[right_of_gap] = -towards_right  # outwards is to the left there
    return Parting(rise + u_slope, u_slope, u)


class _Rows(NamedTuple):
    """Lines that are judged: c of each of n states. c is 2m, or 1 about an axis.

    Attributes
    ----------
    x : ndarray (n, c)
        Positions [length].
    side : ndarray (c,)
        On which their free surfaces are, -1 or 1.
    depth : ndarray (n, 1)
        [length].
    room : ndarray (2, n, c)
        How far each may be moved inwards and outwards so that it meets no other [length].
    facing : ndarray (n, 2m) or None
        All lines, if there are several contacts: `parting` needs them [length].
    limits : tuple of float
        Between which the profile is read [length].
    """

    x: Array
    side: Array
    depth: Array
    room: Array
    facing: Array | None
    limits: tuple[float, float]

    @classmethod
    def of(cls, scene: Scene, lattice: Lattice, depth: Array, lines: Array) -> _Rows:
        """All lines (n, 2m), but for the inner end of a contact around an axis, which is none."""
        side = np.resize(_SIDES, lines.shape[1])
        facing = lines if lines.shape[1] > 2 else None
        low, high = scene.indenter.extent
        skipped = 0
        if lattice.axis == 0:
            skipped = 1
            low = _ON_NODES.near_axis * lattice.spacing
        room = _room(lines)[..., skipped:]
        return cls(lines[:, skipped:], side[skipped:], depth[:, None], room, facing, (low, high))

    def beside(self, scene: Scene, lattice: Lattice) -> tuple[Array, Parting]:
        """x inwards and outwards of the lines (2, n, c), and how surface and indenter part there.

        A part of a link away, in which the nodes do not know where the line is; less where the
        profile is so steep that f changes there by more than the nodes know of it.
        """
        away = _INWARDS_OUTWARDS * self.side  # directions in x
        distance = np.minimum(self.room, _aside(scene) * lattice.spacing)
        x = self._moved(away * distance)
        found = parting(scene, lattice, self.depth, x, self.side, away, self.facing)
        rise = np.abs(found.u[1] - found.u[0])
        allowed = _ON_NODES.height * (scene.opened.critical_separation + np.abs(found.u[1]))
        if (rise > allowed).any():
            distance = distance * np.minimum(1.0, allowed / np.maximum(rise, allowed))
            x = self._moved(away * distance)
            found = parting(scene, lattice, self.depth, x, self.side, away, self.facing)
        return x, found

    def _moved(self, offset: Array) -> Array:
        """x of all lines moved by an offset (2, n, c), inwards and outwards, within the limits."""
        low, high = self.limits
        return np.asarray(np.minimum(np.maximum(self.x + offset, low), high))


def _aside(scene: Scene) -> float:
    """How well nodes place a line, in links.

    A quarter of one; a whole link without adhesion: there r is zero at the line, and so is ∂P/∂x,
    which is γ₁ r times a derivative of r, so that P hardly depends on the place.
    """
    return _ON_NODES.place if scene.work_of_adhesion else 1.0


def astray(scene: Scene, lattice: Lattice, depth: Array, lines: Array) -> Mask:
    """Which lines of states do not rest where they are; see the module.

    A line at the end of a body is judged on its inner side alone, that of a contact of one node on
    its outer side, and only if the profile is steep there: else P is next to that of a point.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    depth : ndarray (n,)
        [length].
    lines : ndarray (n, 2m)
        x of all lines [length].

    Returns
    -------
    ndarray of bool (n, 2m)
        About an axis (n, 1): of the only line.
    """
    rows = _Rows.of(scene, lattice, depth, lines)
    x, found = rows.beside(scene, lattice)
    kinks = _kinks(scene, x)
    tolerance = _slope_tolerance(lattice)
    # Inwards r exceeds the kink: the line would recede. Outwards it is less: it would advance.
    excess = _INWARDS_OUTWARDS * (kinks - found.r)
    off = excess > tolerance * (kinks + np.abs(found.u_slope))
    few = None  # contacts of few links (n, m)
    if rows.facing is not None and scene.work_of_adhesion:
        few = _few_links(scene, lattice, rows.x)
    narrow = few is not None and bool(few.any())
    if not off.any() and lattice.slopes == "small" and not narrow:
        return np.zeros(rows.x.shape, bool)

    slope = np.abs(scene.indenter.slope_beside(rows.x, rows.side))
    height = scene.opened.critical_separation + np.abs(found.u[0])
    steep = slope * lattice.spacing > _ON_NODES.steep * height
    wider_than_a_point = rows.room[0] > 0
    off[0] &= wider_than_a_point
    off[1] &= steep | wider_than_a_point
    if rows.facing is not None:  # those of a few links are known to stand on nodes
        off &= rows.room.min(axis=0) >= _ON_NODES.few_links / 2 * lattice.spacing
    for end in scene.indenter.walls:
        off[1] &= x[1] != end
    found_off = np.asarray(off.any(axis=0))
    if lattice.slopes == "finite":
        found_off |= steep & ~np.isin(rows.x, scene.indenter.corners)
    if few is not None and narrow:
        held = _held_by_profile(scene, lattice, rows.depth, rows.x, tolerance)
        found_off |= np.repeat(few & ~held, 2, axis=1)
    return found_off


def _slope_tolerance(lattice: Lattice) -> float:
    """How well r is known, over √(2w/γ₁) + |u'|.

    Half way between two nodes of a tail the lattice has u' = -u/(l √(1 + κ/4)), κ = (Δx/l)², by κ/8
    less than u/l, which `parting` takes.
    """
    kappa = lattice.k * lattice.spacing**2 / lattice.gamma1
    return _ON_NODES.slopes + kappa / 8


def _kinks(scene: Scene, x: Array) -> Array:
    """√(2w/γ₁) beside lines (2, n, c), at x[0] inwards of opening, at x[1] outwards of closing."""
    works = [scene.opened.work_of_adhesion, scene.work_of_adhesion]
    kinks = np.sqrt([2 / scene.gamma1 * work for work in works])[:, None, None]
    if scene.pattern is not None:
        kinks = kinks * np.sqrt(scene.pattern.factor(x))
    return np.asarray(kinks)


def _few_links(scene: Scene, lattice: Lattice, lines: Array) -> Mask:
    """Which contacts (n, m) have fewer than four links, and are not pinned at the end of a body.

    lines (n, 2m). The limit is half way between the widths of three and of four links.
    """
    few = np.diff(lines)[:, ::2] < (_ON_NODES.few_links - 0.5) * lattice.spacing
    for end in scene.indenter.walls:
        few &= (lines[:, ::2] != end) & (lines[:, 1::2] != end)
    return np.asarray(few)


def _held_by_profile(
    scene: Scene, lattice: Lattice, depth: Array, lines: Array, tolerance: float
) -> Mask:
    """Whether each contact is kept by the profile itself, if not just where nodes have its lines.

    So it is if, within a link of the contact, there is a place at which its left line does not
    recede, and the same place or one further to the right at which its right line does not.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    depth : ndarray (n, 1)
        [length].
    lines : ndarray (n, 2m)
        x of all lines [length].
    tolerance : float
        Over √(2w/γ₁) + |u'|: by how much r may exceed √(2w/γ₁), or has to be less, if negative.

    Returns
    -------
    ndarray of bool (n, m)
    """
    share = np.linspace(0, 1, _NARROW.samples)[:, None, None]
    first = lines[:, ::2] - lattice.spacing
    last = lines[:, 1::2] + lattice.spacing
    places = np.clip(first + share * (last - first), *scene.indenter.extent)
    x = np.repeat(places, 2, axis=2)
    side = np.resize(_SIDES, lines.shape[1])
    found = parting(scene, lattice, depth, x, side, side, lines)
    kink: Any = math.sqrt(2 * scene.opened.work_of_adhesion / scene.gamma1)
    if scene.pattern is not None:
        kink = kink * np.sqrt(scene.pattern.factor(x))
    holds = found.r < kink + tolerance * (kink + np.abs(found.u_slope))
    left_holds_before = np.maximum.accumulate(holds[:, :, ::2], axis=0)  # here or further left
    # At a tip between two of these places the left line holds after it and the right one before it.
    left_holds_before[:-1] |= left_holds_before[1:]
    return np.asarray((left_holds_before & holds[:, :, 1::2]).any(axis=0))


def _one_contact_rests(
    scene: Scene, lattice: Lattice, depth: float, left: float, right: float
) -> bool:
    """Whether both lines of one contact surely rest, as `astray` finds more slowly.

    For line contacts on linear springs, without pattern, with small slopes. False where it is not
    sure: also where the profile is steep. left, right: x of the lines.
    """
    low, high = scene.indenter.extent
    length = scene.elastocapillary_length
    outer = _aside(scene) * lattice.spacing
    inner = min(outer, (right - left) / 2)
    inside = [left + inner, right - inner]
    outside = [max(left - outer, low), min(right + outer, high)]
    u_in = depth - scene.indenter.height(np.array(inside))
    u_out = depth - scene.indenter.height(np.array(outside))
    r_in = _SIDES * scene.indenter.slope_beside(np.array(inside), -_SIDES) - u_in / length
    r_out = _SIDES * scene.indenter.slope_beside(np.array(outside), _SIDES) - u_out / length
    opening = math.sqrt(2 * scene.opened.work_of_adhesion / scene.gamma1)
    closing = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
    tolerance = _slope_tolerance(lattice)
    height = scene.opened.critical_separation + np.abs(u_out)
    level = np.abs(u_in - u_out) <= _ON_NODES.height * height
    stays = r_in <= opening + tolerance * (opening + np.abs(u_in) / length)
    stops = r_out >= closing - tolerance * (closing + np.abs(u_out) / length)
    return bool((level & stays & stops).all())


def _room(lines: Array) -> Array:
    """How far lines (n, 2m) may be moved inwards and outwards (2, n, 2m) [length].

    That is half way to the next line: inwards to the other one of the contact, outwards to the one
    beyond the gap. ∞ outwards of the outermost lines.
    """
    half = np.repeat(lines[:, 1::2] - lines[:, ::2], 2, axis=1) / 2
    room = np.array([half, np.full(half.shape, math.inf)])
    if lines.shape[1] > 2:
        gaps = (lines[:, 2::2] - lines[:, 1:-1:2]) / 2
        room[1, :, 1:-1:2] = gaps
        room[1, :, 2::2] = gaps
    return room


def lost_too_early(
    scene: Scene,
    lattice: Lattice,
    depth: float,
    branch: str = "adhered",
    lowest: float | None = None,
) -> float:
    """Half the width of a contact narrower than the nodes hold at a depth.

    It is the last of a contact that is being opened: about the lowest point of the profile, as wide
    as the farthest of the distances Δx, Δx/2, Δx/4, ... at which r < √(2w/γ₁), on each side. It can
    only have the lowest energy if it gains more by adhesion, over a link on each side, than its
    free surfaces store at least.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    depth : float
        At which the nodes have no contact [length].
    branch : {"adhered", "global"}
    lowest : float, optional
        x of the lowest point of the profile, where it is known [length].

    Returns
    -------
    float
        [length]; 0 if there is none.
    """
    work = scene.opened.work_of_adhesion
    if not (work and scene.gamma1):
        return 0.0
    tip = _lowest_point(scene, lattice, depth, lowest)
    height = float(scene.indenter.height(tip))
    # If it is pressed it is not lost; further than δ₀ above the surface nothing holds it.
    if height <= depth or depth < height - scene.opened.critical_separation:
        return 0.0
    low, high = scene.indenter.extent
    u = depth - height
    if branch == "global":
        gained = _gained(lattice, u, at_end=tip in (low, high))
        if gained < _stored(lattice, u):
            return 0.0
    distances = lattice.spacing * 0.5 ** np.arange(_NARROW.halvings)
    sides = np.array([1.0]) if lattice.axis == 0 else _SIDES[:, None]
    x = tip + sides * distances
    x = np.where((x < low) | (x > high), tip, x)
    found = parting(scene, lattice, depth, x, sides, sides)
    kink = math.sqrt(2 * work / scene.gamma1)
    holds = np.atleast_2d(found.r < kink * (1 - _NARROW.tie))
    widest = np.where(holds, distances, 0.0).max(axis=1)
    if branch == "global" and (widest == lattice.spacing).all():
        return 0.0  # it is wider than a link on each side, and the nodes have compared it
    return float(widest.mean()) if (widest > 0).all() else 0.0


def _lowest_point(scene: Scene, lattice: Lattice, depth: float, known: float | None) -> float:
    """x of the lowest point of the profile [length]: the axis, the apex, or `known`.

    Where neither is known, None, the profile is sampled down to its features (`resolve`).
    """
    if lattice.axis == 0:
        return 0.0
    point = scene.indenter.apex if scene.indenter.convex else known
    return resolve(scene, depth).lowest if point is None else point


def _gained(lattice: Lattice, u: float, *, at_end: bool) -> float:
    """The most that adhesion, less the springs, gains with a link on each side of the lowest point.

    There the surface is lifted by -u, u < 0, and beside it by more. [energy/length], or [energy]
    about an axis. at_end: the lowest point is an end of the profile, with one link.
    """
    sides = 1 if lattice.axis == 0 or at_end else 2
    net = lattice.w - float(lattice.stored(u).value)
    return sides * net * lattice.cell * float(lattice.weight(0.5))


def _stored(lattice: Lattice, u: float) -> float:
    """What the free surfaces of such a contact store at least where they are lifted by -u.

    That is what tails beyond node 1 do, beside a contact of one link on each side; about an axis,
    and with finite slopes, only a part of it. In the units of `_gained`.
    """
    tail = float(lattice.tail_stiffness(1, 1)) * u**2 / 2
    if lattice.axis == 0:
        return _NARROW.stored_about_axis * tail
    return 2 * tail * (1.0 if lattice.linear else _NARROW.stored_finite)


def resolving_spacing(scene: Scene, lattice: Lattice, x: float) -> float:
    """A spacing of nodes that resolve the profile at x: half of one that does there.

    The slopes stay in the range of those of the chords but for a part of √(2w/γ₁), and with finite
    slopes the profile rises by no more than a part of l over a link.
    """
    indenter = scene.indenter
    kink = math.sqrt(2 * scene.opened.work_of_adhesion / scene.gamma1) if scene.gamma1 else 0.0
    links = np.linspace(-1, 1, 2 * _BETWEEN.samples + 1)
    # Two rows of nodes about x, in links, as x may be anywhere in its own: 0.4 and 0.6 of a link
    # from its left end. That makes three chords, of its link and of both next ones.
    rows = np.array([[-1.4, -0.4, 0.6, 1.6], [-1.6, -0.6, 0.4, 1.4]])
    spacing = lattice.spacing / 2
    for _ in range(_NARROW.halvings):
        slope = indenter.slope(np.clip(x + spacing * links, *indenter.extent))
        nodes = np.clip(x + spacing * rows, *indenter.extent)
        width = np.maximum(np.diff(nodes, axis=1), _TINY)
        chords = np.diff(indenter.height(nodes), axis=1) / width
        beyond = np.maximum(slope.max() - chords.max(axis=1), chords.min(axis=1) - slope.min())
        is_flat = np.abs(slope).max() * spacing <= _ON_NODES.level * scene.elastocapillary_length
        if beyond.max() <= _BETWEEN.steeper * kink and (scene.slopes == "small" or is_flat):
            break
        spacing /= 2
    return spacing / 2


def warn_state(state: Equilibrium, lattice: Lattice, lowest: float | None, stacklevel: int) -> None:
    """AccuracyWarning where a lattice state depends on what the nodes do not resolve.

    Parameters
    ----------
    state : Equilibrium
        On nodes of this lattice.
    lattice : Lattice
    lowest : float or None
        x of the lowest point of the profile, where it is known [length].
    stacklevel : int
        Of the warning, counted from the caller.

    Warns
    -----
    AccuracyWarning
    """
    scene = state.scene
    if not scene.gamma1 or isinstance(scene.indenter, Plane):
        return
    if not state.contacts.size:
        warn_narrow(scene, lattice, state.depth, state.branch, lowest, stacklevel + 1)
        return
    lines = state.contacts.reshape(1, -1)
    may_be_quick = lattice.linear and lattice.axis != 0 and scene.pattern is None
    if may_be_quick and lines.size == 2:
        left, right = lines[0].tolist()
        if _one_contact_rests(scene, lattice, state.depth, left, right):
            return
    warn_lines(scene, lattice, np.array([state.depth]), lines, stacklevel + 1)


def warn_narrow(
    scene: Scene,
    lattice: Lattice,
    depth: float,
    branch: str,
    lowest: float | None,
    stacklevel: int,
) -> None:
    """Warn if nodes have no contact at a depth where there is a narrow one.

    Parameters
    ----------
    scene : Scene
    lattice : Lattice
    depth : float
        [length].
    branch : {"adhered", "global"}
    lowest : float or None
        Position of the lowest point of the profile, where it is known [length].
    stacklevel : int
        Of the warning, counted from the caller.

    Warns
    -----
    AccuracyWarning
    """
    width = lost_too_early(scene, lattice, depth, branch, lowest)  # half of it
    if width:
        warnings.warn(
            f"depth = {depth!r}: the nodes have no contact, but one of a half-width of about "
            f"{width!r} holds at the lowest point of the profile; give a spacing of {width / 8!r}, "
            "or method='fitted'",
            AccuracyWarning,
            stacklevel=stacklevel + 1,
        )
