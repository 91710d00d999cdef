"""What nodes do not resolve of the profile, looked for on the profile itself.

Nodes know of a profile its heights, and between them they assume it to be as smooth as these are.
Three things tell whether it is, wherever a state depends on it.

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
around the link tells,

    |f_i + (f_{i+1} - f_i) s - f(x)| <= c max(|f_{i-1} - 2 f_i + f_{i+1}|,
                                              |f_i - 2 f_{i+1} + f_{i+2}|),     s = (x - x_i)/Δx,

with c = 1/8 if it is a parabola there, and 1/2 if it has a corner, and its slope should not turn by
more than three times that difference over Δx, back and forth. A profile that does not may be in
contact, where its forces are not those of the nodes, or stick through a free surface. Nor should
its slope leave the range of those of the chords of this link and the next ones by a part of
√(2w/γ₁): a line would have stopped there. A convex profile has no such places.

Tips. A contact narrower than a link has no link, and so no adhesion: nodes lose it too early. It is
there as long as r < √(2w/γ₁) just beside the lowest point of the profile, on both sides.
"""

from __future__ import annotations

import math
import warnings
from collections.abc import Iterable
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import EPSILON, AccuracyWarning
from discretization.equilibrium import Equilibrium
from discretization.nodes.lattice import Lattice
from discretization.nodes.row import heights, numbers
from discretization.profile import resolve
from energy import Plane, Scene
from energy.arrays import Array, Mask

_SMOOTH, _CORNERED = 1 / 4, 1 / 2  # of a second difference: twice a parabola's, and a corner's
_WINDING = 12.0  # times that: three times as much as the slope of a parabola turns over a link
_OF_HEIGHTS = 64 * EPSILON  # their rounding
_MISSED = 1e-9  # of the depth and δ₀: a penetration that counts, as in the certificate
_STEEPER = 1 / 4  # of √(2w/γ₁), by which slopes may leave the range of those of the chords
_ASIDE = 1 / 4  # of a link: how well nodes know a line
_RAISED = 1 / 64  # of δ₀ and |u|: how well they know the height there
_PARTED = 1 / 16  # of √(2w/γ₁) and |u'|: how well they know r
_FEW = 4  # links between lines that are not between nodes
_BESIDE = 1e-3  # links: nearer to an axis no free surface is read
_SIDES = np.array([-1.0, 1.0])
_ACROSS = _SIDES[:, None, None]  # inside and outside of a contact
_READ = np.array([1.0, -1.0, -1.0, 1.0])  # sides on which slopes inside and outside are read
_PLACES = 33  # at which it is looked whether a narrow contact is held
_HALVINGS = 40  # of the spacing, in search of one that would do
_WITHIN = 16  # places in a link, looked at in this search
_LEVEL = 1 / 16  # of l: by how much a profile may rise over a link with finite slopes
_STEEP = 1 / 4  # of δ₀ and |u|: what rises by more over a link is steep for these nodes
_TINY = float(np.finfo(float).tiny)
_TIE = 1e-9  # of √(2w/γ₁): beyond rounding of r
_NARROWER = 1 / 8  # of what a disc of one link stores: narrower ones store less, as 1/ln r
_UPRIGHT = 0.86  # (2/3)(1 - c³)/(1 - c²), c = cos 45°: of k l u²/2, with finite slopes, at least


class Unseen(NamedTuple):
    """Places between the nodes (n,), f there, and how far that is from what the nodes see of it.

    steep: whether a line may stop there of which the nodes do not know; off is 0 if that is all.
    lowest: x of the lowest point of a profile that is not convex.
    """

    x: Array
    f: Array
    off: Array
    steep: Mask
    lowest: float | None = None


def unseen(scene: Scene, depth: float, lattice: Lattice, *, anywhere: bool = False) -> Unseen:
    """What the nodes do not see of the profile, where contact is possible at this depth.

    None of a convex profile; anywhere: its lowest point. Warns and refuses as `resolve`.
    """
    if scene.indenter.convex:
        nothing = np.empty(0)
        return Unseen(nothing, nothing, nothing, np.empty(0, bool))
    profile = resolve(scene, depth)
    low = profile.lowest
    if anywhere:
        x, f, off, steep = (np.array([part]) for part in (low, profile.touch, _TINY, False))
        return Unseen(x, f, off, steep, low)
    first, last = numbers(lattice, scene.indenter.extent)
    place = (profile.x - lattice.origin) / lattice.spacing
    link = np.floor(place)
    inside = (link > first) & (link + 1 < last)
    x, f, slope, place, link = (
        part[inside] for part in (profile.x, profile.f, profile.slope, place, link)
    )
    nodes = heights(lattice, scene.indenter, link + np.arange(-1.0, 3.0)[:, None])
    chords = np.diff(nodes, axis=0)
    bend = np.abs(np.diff(chords, axis=0)).max(axis=0)
    chord = nodes[1] + (place - link) * chords[1]
    cornered = np.isin(link, np.floor((profile.corners - lattice.origin) / lattice.spacing))
    known = np.where(cornered, _CORNERED, _SMOOTH) * bend
    off, own = np.abs(chord - f), (link - link[:1]).astype(int)
    steps = np.abs(np.diff(slope)) * (own[1:] == own[:-1])
    turned = lattice.spacing * np.bincount(own[1:], steps, own.max(initial=0) + 1)[own] / _WINDING
    rounding = _OF_HEIGHTS * np.abs(nodes).max(initial=0.0)
    hidden = np.maximum(off, turned) > known + rounding
    steep = np.zeros(x.size, bool)
    if scene.gamma1 and scene.work_of_adhesion:
        kink = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
        rise = lattice.spacing * slope
        beyond = np.maximum(rise - chords.max(axis=0), chords.min(axis=0) - rise)
        steep = beyond > lattice.spacing * _STEEPER * kink + rounding
    found = hidden | steep
    off = np.where(hidden, np.maximum(off, _TINY), 0.0)
    return Unseen(x[found], f[found], off[found], steep[found], low)


def looked_at(
    states: Iterable[Equilibrium], places: Unseen, lattice: Lattice, stacklevel: int
) -> None:
    """AccuracyWarning where the surfaces of a scene's states miss what the nodes do not see.

    The indenter is in the surface there, or in contact off it, or steeper than the nodes tell.
    """
    x, f, off, steep, _ = places
    states = [*states] if x.size else []
    if not states:
        return
    inside, hidden = np.array([state.inside(x) for state in states]), off > 0
    missed, scene = np.where(inside, off, 0.0).max(axis=0), states[0].scene
    if hidden.any():
        at, high = x[hidden], f[hidden]
        each = [state.depth - high - state.displacement(at) for state in states]
        through = np.where(inside[:, hidden], 0.0, each).max(axis=0)
        missed[hidden] = np.maximum(missed[hidden], through)
    worst = int(np.argmax(missed))
    size = max(scene.critical_separation, *(abs(state.depth) for state in states))
    passed = steep & inside.any(axis=0)
    if missed[worst] > _MISSED * size:
        place = float(x[worst])
        seen = f"the surface between them misses the indenter by {float(missed[worst])!r}"
    elif passed.any():
        place = float(x[np.argmax(passed)])
        seen = "the profile is steeper than these nodes tell, where a contact line has passed"
    else:
        return
    _warn(scene, lattice, place, seen, stacklevel + 1)


def lines_looked_at(
    scene: Scene, lattice: Lattice, depth: Array, lines: Array, stacklevel: int
) -> None:
    """AccuracyWarning where lines (n, 2m) of states at depths (n,) are not where they rest."""
    off = astray(scene, lattice, depth, lines)
    if off.any():
        state, column = np.argwhere(off)[0].tolist()
        place = float(lines[state, column + (lattice.axis == 0)])
        here = f"at depth = {float(depth[state])!r}"
        seen = f"{here} the profile does not let a contact line rest where they have it"
        _warn(scene, lattice, place, seen, stacklevel + 1)


def losses_looked_at(
    scene: Scene,
    lattice: Lattice,
    depth: float,
    before: tuple[float, ...],
    lines: tuple[float, ...],
    stacklevel: int,
) -> None:
    """AccuracyWarning if a contact is lost that the profile holds at the next depth of a path.

    before, lines: those of all contacts at the depth before, and now.
    """
    now = list(zip(lines[::2], lines[1::2], strict=True))
    for left, right in zip(before[::2], before[1::2], strict=True):
        if any(first <= right and last >= left for first, last in now):
            continue
        every = sorted([*now, (left, right)])
        known = np.reshape(every, (1, -1))
        held = _held(scene, lattice, np.array([[depth]]), known, -_PARTED)
        if held[0, every.index((left, right))]:
            seen = f"at depth = {depth!r} they have lost a contact which the profile holds"
            _warn(scene, lattice, (left + right) / 2, seen, stacklevel + 1)


def lowest_within(scene: Scene, lattice: Lattice, left: float, right: float) -> float:
    """x of the lowest point of the profile within a link of a contact."""
    body, (lo, hi) = scene.indenter, scene.indenter.extent
    ends = max(left - lattice.spacing, lo), min(right + lattice.spacing, hi)
    breaks = body.breaks()
    inner = breaks[(breaks > ends[0]) & (breaks < ends[1])]
    x = np.append(inner, np.linspace(*ends, 8 * _PLACES))
    return float(x[np.argmin(body.height(x))])


def _warn(scene: Scene, lattice: Lattice, x: float, seen: str, stacklevel: int) -> None:
    """AccuracyWarning of what is seen at x, and the spacing that would do."""
    closer = enough(scene, lattice, x)
    warnings.warn(
        f"at x = {x!r}, between nodes {lattice.spacing!r} apart: {seen}; a feature or contact "
        f"narrower than the spacing may be missed; give a spacing of {closer!r}, or "
        "method='fitted'",
        AccuracyWarning,
        stacklevel=stacklevel + 1,
    )


class _End(NamedTuple):
    """Lines at x, where the profile has the height f."""

    x: Any
    f: Any


class Parting(NamedTuple):
    """How surface and indenter part at lines: r, what u' adds to it, and the displacement u."""

    r: Array
    falls: Array
    u: Array


def parting(
    scene: Scene, lattice: Lattice, depth: Any, x: Array, side: Any, read: Any, facing: Any = None
) -> Parting:
    """How surface and indenter part at lines at x (..., n, 2m).

    side: 1 if the free surface is on the right; read: the side on which f' is read; facing: all
    lines (n, 2m), where others face them.
    """
    f = scene.indenter.height(x)
    u = depth - f
    rise = side * scene.indenter.slope_beside(x, read)
    if lattice.axis == 0:
        falls = lattice.tail.shape(x, _End(x, f), None, depth)[1]
        return Parting(rise + falls, falls, u)
    if lattice.linear:
        falls = u * (-1 / scene.elastocapillary_length)
    else:
        stored = lattice.stored(u).value / lattice.gamma1
        falls = -np.copysign(np.sqrt(2 * stored), u)
    if lattice.slopes == "finite":
        inclination = np.copysign(np.arccos(np.maximum(1 - stored, 0.0)), u)
        return Parting(2 * np.sin((np.arctan(rise) - inclination) / 2), -inclination, u)
    if facing is not None:
        ends = _End(x, f)
        others = _End(facing, scene.indenter.height(facing))
        right, left = np.s_[..., 1:-1:2], np.s_[..., 2::2]  # lines beside a gap
        for own, other, sign in ((right, left, 1), (left, right, -1)):
            gap = [_End(ends.x[own], ends.f[own]), _End(others.x[other], others.f[other])]
            first, last = gap[::sign]
            falls[own] = sign * lattice.tail.shape(x[own], first, last, depth)[1]
    return Parting(rise + falls, falls, u)


def astray(scene: Scene, lattice: Lattice, depth: Array, lines: Array) -> Mask:
    """Which lines (n, 2m) of states at depths (n,) do not rest where they are; see the module.

    About an axis (n, 1): the only line. A line at the end of a body is looked at on its inner side
    alone, that of a contact of one node on its outer side, and only if the profile is steep there:
    else P is next to that of a point.
    """
    side = _SIDES if lines.shape[1] == 2 else np.resize(_SIDES, lines.shape[1])
    room, facing = _room(lines), lines if lines.shape[1] > 2 else None
    (lo, hi), depth = scene.indenter.extent, depth[:, None]
    if lattice.axis == 0:  # where a contact around it has no line
        lines, side, room = lines[:, 1:], side[1:], room[..., 1:]
        lo = _BESIDE * lattice.spacing
    away = _ACROSS * side
    share = _ASIDE if scene.work_of_adhesion else 1.0  # without adhesion lines hardly change P
    aside = np.minimum(room, share * lattice.spacing)
    x = np.minimum(np.maximum(lines + away * aside, lo), hi)
    found = parting(scene, lattice, depth, x, side, away, facing)
    rise = np.abs(found.u[1] - found.u[0])
    known = _RAISED * (scene.opened.critical_separation + np.abs(found.u[1]))
    if (rise > known).any():
        aside = aside * np.minimum(1.0, known / np.maximum(rise, known))
        x = np.minimum(np.maximum(lines + away * aside, lo), hi)
        found = parting(scene, lattice, depth, x, side, away, facing)
    part = _PARTED + lattice.k * lattice.spacing**2 / lattice.gamma1 / 8
    works = scene.opened.work_of_adhesion, scene.work_of_adhesion
    kinks = np.sqrt([2 / scene.gamma1 * work for work in works])[:, None, None]
    if scene.pattern is not None:
        kinks = kinks * np.sqrt(scene.pattern.factor(x))
    off = _ACROSS * (kinks - found.r) > part * (kinks + np.abs(found.falls))
    few = None
    if facing is not None and scene.work_of_adhesion:
        few = np.diff(lines)[:, ::2] < (_FEW - 0.5) * lattice.spacing
        for end in scene.indenter.walls:  # there a point is pinned, however narrow
            few &= (lines[:, ::2] != end) & (lines[:, 1::2] != end)
    narrow = few is not None and bool(few.any())
    if not off.any() and lattice.slopes == "small" and not narrow:
        return np.zeros(lines.shape, bool)
    slope = np.abs(scene.indenter.slope_beside(lines, side))
    height = scene.opened.critical_separation + np.abs(found.u[0])
    steep = slope * lattice.spacing > _STEEP * height
    off[0] &= room[0] > 0
    off[1] &= steep | (room[0] > 0)
    if facing is not None:  # those of a few links are known to stand on nodes
        off &= room.min(axis=0) >= _FEW / 2 * lattice.spacing
    for end in scene.indenter.walls:
        off[1] &= x[1] != end
    found_off = np.asarray(off.any(axis=0))
    if lattice.slopes == "finite":
        found_off |= steep & ~np.isin(lines, scene.indenter.corners)
    if few is not None and narrow:
        found_off |= np.repeat(few & ~_held(scene, lattice, depth, lines, part), 2, axis=1)
    return found_off


def _held(scene: Scene, lattice: Lattice, depth: Array, lines: Array, part: float) -> Mask:
    """Whether each contact (n, m) of lines (n, 2m) is held by the profile within a link of it.

    There the left line does not recede at one place, and the right one at the same or further on.
    """
    link, body = lattice.spacing, scene.indenter
    share = np.linspace(0, 1, _PLACES)[:, None, None]
    first, last = lines[:, ::2] - link, lines[:, 1::2] + link
    at = np.clip(first + share * (last - first), *body.extent)
    x, side = np.repeat(at, 2, axis=2), np.resize(_SIDES, lines.shape[1])
    found = parting(scene, lattice, depth, x, side, side, lines)
    kink: Any = math.sqrt(2 * scene.opened.work_of_adhesion / scene.gamma1)
    if scene.pattern is not None:
        kink = kink * np.sqrt(scene.pattern.factor(x))
    holds = found.r < kink + part * (kink + np.abs(found.falls))
    left = np.maximum.accumulate(holds[:, :, ::2], axis=0)
    left[:-1] |= left[1:]  # a tip between two of these places
    return np.asarray((left & holds[:, :, 1::2]).any(axis=0))


def _at_rest(scene: Scene, lattice: Lattice, depth: float, left: float, right: float) -> bool:
    """Whether both lines of one contact surely rest, as `astray` says, in numbers: faster.

    Without pattern, with small slopes, and if the profile is not steep there.
    """
    (lo, hi), length = scene.indenter.extent, scene.elastocapillary_length
    share = _ASIDE if scene.work_of_adhesion else 1.0
    out, half = share * lattice.spacing, (right - left) / 2
    inner = min(out, half)
    x = np.array([left + inner, right - inner, max(left - out, lo), min(right + out, hi)])
    slopes = scene.indenter.slope_beside(x, _READ).tolist()
    depths = (depth - scene.indenter.height(x)).tolist()
    part = _PARTED + (lattice.spacing / length) ** 2 / 8
    most = math.sqrt(2 * scene.opened.work_of_adhesion / scene.gamma1)
    least = math.sqrt(2 * scene.work_of_adhesion / scene.gamma1)
    size = scene.opened.critical_separation
    for line, side in ((0, -1), (1, 1)):
        u_in, u_out = depths[line], depths[line + 2]
        r_in = side * slopes[line] - u_in / length
        r_out = side * slopes[line + 2] - u_out / length
        if not abs(u_in - u_out) <= _RAISED * (size + abs(u_out)):
            return False
        if not r_in <= most + part * (most + abs(u_in) / length):
            return False
        if not r_out >= least - part * (least + abs(u_out) / length):
            return False
    return True


def _room(lines: Array) -> Array:
    """How far lines (n, 2m) may be moved inwards and outwards (2, n, 2m): half way to the next."""
    half = np.repeat(lines[:, 1::2] - lines[:, ::2], 2, axis=1) / 2
    room = np.array([half, np.full(half.shape, math.inf)])
    if lines.shape[1] > 2:
        gaps = (lines[:, 2::2] - lines[:, 1:-1:2]) / 2
        room[1, :, 1:-1:2], room[1, :, 2::2] = gaps, gaps
    return room


def lost_too_early(
    scene: Scene,
    lattice: Lattice,
    depth: float,
    branch: str = "adhered",
    lowest: float | None = None,
) -> float:
    """Half the width [length] of a contact narrower than the nodes hold at a depth, or 0.

    It is the last of a contact that is being opened. It can only have the lowest energy if it gains
    more by adhesion, over a link on each side, than its free surfaces store at least.
    lowest: x of the lowest point, where it is known.
    """
    body, work = scene.indenter, scene.opened.work_of_adhesion
    if not (work and scene.gamma1):
        return 0.0
    turned = lattice.axis == 0
    tip = 0.0 if turned else body.apex if body.convex else lowest
    if tip is None:
        tip = resolve(scene, depth).lowest
    height = float(body.height(tip))
    if height <= depth or depth < height - scene.opened.critical_separation:
        return 0.0
    at_end = tip in body.extent
    u = depth - height
    if branch == "global" and _gained(lattice, u, at_end) < _stored(lattice, u):
        return 0.0
    away = lattice.spacing * 0.5 ** np.arange(_HALVINGS)
    sides = np.array([1.0]) if turned else np.array([[-1.0], [1.0]])
    x = tip + sides * away
    x = np.where((x < body.extent[0]) | (x > body.extent[1]), tip, x)
    found = parting(scene, lattice, depth, x, sides, sides)
    kink = math.sqrt(2 * work / scene.gamma1)
    holds = np.atleast_2d(found.r < kink * (1 - _TIE))
    widest = np.where(holds, away, 0.0).max(axis=1)
    if branch == "global" and (widest == away[0]).all():
        return 0.0  # it is wider than a link on each side, and the nodes have compared it
    return float(widest.mean()) if (widest > 0).all() else 0.0


def _gained(lattice: Lattice, u: float, at_end: bool) -> float:
    """The most that adhesion, less the springs, gains with a link on each side of the lowest point.

    There the surface is lifted to u, and beside it to more.
    """
    sides = 1 if lattice.axis == 0 or at_end else 2
    net = lattice.w - float(lattice.stored(u).value)
    return sides * net * lattice.cell * float(lattice.weight(0.5))


def _stored(lattice: Lattice, u: float) -> float:
    """What the free surfaces of such a contact store at least where they are lifted to u."""
    tail = float(lattice.pull(1, 1)) * u**2 / 2
    if lattice.axis == 0:
        return _NARROWER * tail
    return 2 * tail * (1.0 if lattice.linear else _UPRIGHT)


def enough(scene: Scene, lattice: Lattice, x: float) -> float:
    """A spacing of nodes that resolve the profile at x: half of one that does there.

    Its slopes stay in the range of those of the chords but for a part of √(2w/γ₁), and with finite
    slopes it rises by no more than a part of l over a link.
    """
    body, (lo, hi) = scene.indenter, scene.indenter.extent
    kink = math.sqrt(2 * scene.opened.work_of_adhesion / scene.gamma1) if scene.gamma1 else 0.0
    spacing = lattice.spacing / 2
    for _ in range(_HALVINGS):
        between = np.clip(x + spacing * np.linspace(-1, 1, 2 * _WITHIN + 1), lo, hi)
        nodes = x + spacing * np.array([[-1.4, -0.4, 0.6, 1.6], [-1.6, -0.6, 0.4, 1.4]])
        nodes = np.clip(nodes, lo, hi)
        slope = body.slope(between)
        width = np.maximum(np.diff(nodes, axis=1), np.finfo(float).tiny)
        chords = np.diff(body.height(nodes), axis=1) / width
        beyond = np.maximum(slope.max() - chords.max(axis=1), chords.min(axis=1) - slope.min())
        level = np.abs(slope).max() * spacing <= _LEVEL * scene.elastocapillary_length
        if beyond.max() <= _STEEPER * kink and (scene.slopes == "small" or level):
            break
        spacing /= 2
    return spacing / 2


def look_at_state(
    state: Equilibrium, lattice: Lattice, lowest: float | None, stacklevel: int
) -> None:
    """AccuracyWarning where a lattice state depends on what the nodes do not resolve."""
    scene, depth = state.scene, state.depth
    if not scene.gamma1 or isinstance(scene.indenter, Plane):
        return
    if state.contacts.size:
        lines = state.contacts.reshape(1, -1)
        simple = lattice.linear and lattice.axis != 0 and scene.pattern is None
        if simple and lines.size == 2 and _at_rest(scene, lattice, depth, *lines[0].tolist()):
            return
        lines_looked_at(scene, lattice, np.array([depth]), lines, stacklevel + 1)
    else:
        narrow_looked_at(scene, lattice, depth, state.branch, lowest, stacklevel + 1)


def narrow_looked_at(
    scene: Scene,
    lattice: Lattice,
    depth: float,
    branch: str,
    lowest: float | None,
    stacklevel: int,
) -> None:
    """AccuracyWarning if nodes have no contact at a depth where there is a narrow one."""
    width = lost_too_early(scene, lattice, depth, branch, lowest)
    if width:
        warnings.warn(
            f"depth = {depth!r}: the nodes have no contact, but one of a half-width of about "
            f"{width!r} holds at the lowest point of the profile; give a spacing of {width / 8!r}, "
            "or method='fitted'",
            AccuracyWarning,
            stacklevel=stacklevel + 1,
        )
