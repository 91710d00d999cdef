"""Where the lines of many free surfaces rest, at once: D(x) and how it changes with the lines.

A contact line at x is in equilibrium at one depth, the rest depth D(x). At a depth d it advances
where D < d and recedes where D > d (surfaces/protocol.py has the derivation and the formulas).

Conventions
-----------
Depths d and D grow down into the layer, heights f of the profile upwards: first touch is at
d = min f. All are lengths; l is the elastocapillary length.

A free surface is a tail, with one line, or a gap between two contacts, with two. Surfaces stand in
the rows of arrays (n, 2), in whose columns are the left and the right line of each; the line that a
tail has not is at -inf in the left column or inf in the right one, and its D is inf.

`side` is 1 for a line whose contact is on its left and whose free surface is on its right: the left
line of a surface; it is -1 for the right one. Outwards of the contact, into the free surface, is
thus the direction `side` along x. `direction` is 1 where lines advance, outwards, and contacts
close; it is -1 where lines recede, inwards, and contacts open. The work of adhesion may differ
between these (`Scene.opened` is the scene with that of opening).

The line that is `facing` another one is at the other end of the same free surface.

Narrow gaps feel the rounding of the profile. The tilt of a gap of length L is the rise of the
profile over L, and D of its lines varies by l (l/L) times what the tilt does. Heights are rounded
by a part of themselves, so where the slope is smooth in a narrow gap, the rise is ∫f' dx instead.

`Surfaces.rest_depth` is D of lines at places with given height, slope and work of adhesion; it is
that of `SmallSurfaces` (small slopes), `FiniteSurfaces` (finite slopes) or `MeniscusSurfaces`
(finite slopes about an axis). `Scene.critical_separation` is δ₀ = √(2w/k). `Patches.factor(x)` is
what the pattern multiplies w by at x. `Resolved.past(x, side)` are places moved off the edge of a
pattern by one rounding, to the right (1) or left (-1); `walls` are the ends of the profile at which
the body itself ends, and `past_wall` is whether there is no body on the side of a line that is
meant. EPSILON is 2⁻⁵², TOLERANCE what certificates tolerate of the size of depths.
"""

import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from discretization.certificate import EPSILON, TOLERANCE
from discretization.profile import Resolved, past_wall
from discretization.surfaces.finite_line import FiniteSurfaces
from discretization.surfaces.menisci import MeniscusSurfaces
from discretization.surfaces.protocol import LinePosition, Surfaces
from discretization.surfaces.small import SmallSurfaces
from energy import Scene
from energy.arrays import Array, Mask

# Of the size of depths (δ₀ and the depth): differences of depths that are rounding.
TIE = 1e-13
# Of its position: a line is found to so many roundings, and is so near to a corner.
ULPS = 4.0
# `side` of the left and of the right line of a free surface, the columns of lines (n, 2).
SIDES = np.array([1, -1])


class DifferenceRules(NamedTuple):
    """Steps of the central differences of D by the lines.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves the 39 or more
    random states and paths that read it as they are to 1e-9: `python -m tests.sensitivity
    discretization.fitted.rest_depths`.

    Attributes
    ----------
    step : float
        Of the width of a gap, or of l: near the cube root of rounding, at which a central
        difference is best.
    widest : float
        The same for a gap that is so narrow that D is hardly known, at most.
    least_ulps : float
        Roundings of a position, at least: then the step itself is off by a thousandth at most.
    least_radius : float
        Of l: about an axis lines at smaller radii have the step of this one.
    least_position : float
        Of l: the rounding of positions beside 0 is that of this one.
    """

    step: float = 1e-6
    widest: float = 1e-2
    least_ulps: float = 2.0**10
    least_radius: float = 1e-9
    least_position: float = 1e-6


DIFFERENCES = DifferenceRules()


# When a line is stable.
# Of the size of depths over l, or over the radius of a single contact about an axis if that is less
# (single_contact.py): dD/dx that is rounding, where D is least.
# Above the root of rounding, 1.5e-8, to which the place of the least D is found: 1e-8 or 1e-6
# changes none of 139 random states and paths (`python -m tests.sensitivity
# discretization.fitted.rest_depths FLAT`).
FLAT = 1e-7
# Of the steepest dD/dx of both lines: what may be rounding of one that is 0. A difference over 1e-6
# of a gap leaves 2e-10. 1e-10 or 1e-8 changes none of 39.
_FALLING = 1e-9
# A matrix ∂D/∂x of both lines that is stable: D of each grows outwards, that is with x for the left
# line and against x for the right one, and does not feel the other line.
_GROWING = np.diag([1.0, -1.0])

# Narrow gaps.
# Of l: gaps of which the rise of the profile is integrated. The four points below leave the eighth
# power, 1e-16, and the difference of both heights would lose two digits or more. Half or twice as
# wide ones change none of 39 random states and paths.
_NARROW = 1e-2
# Roundings of f', which may be a small sum of large terms: six bits. Gaps so narrow are in none of
# 314 random scenes, so that nothing measures it.
_ROUNDED = 64
# Points and weights of Gauss-Legendre quadrature on (-1, 1).
_POINTS, _WEIGHTS = (np.asarray(part) for part in np.polynomial.legendre.leggauss(4))


def surfaces_of(scene: Scene) -> Surfaces:
    """The free surfaces of a scene, by its slopes and geometry.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    Surfaces
        Those of small slopes, of finite slopes, or of menisci about an axis.
    """
    if scene.slopes == "small":
        return SmallSurfaces(scene)
    return MeniscusSurfaces(scene) if scene.axisymmetric else FiniteSurfaces(scene)


def displacement_scale(scene: Scene, depth: float, size: float) -> float:
    """Size of the depths of a state, to which its violations are compared.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    size : float
        Of the terms that cancel in D - d, or of the largest depth of a path [length].

    Returns
    -------
    float
        |d| or δ₀, at least what makes TIE of `size` pass [length].
    """
    return max(abs(depth), scene.opened.critical_separation, TIE / TOLERANCE * size)


@dataclass(frozen=True, eq=False)
class RestDepths:
    """Depths D at which the lines of a profile with its free surfaces rest.

    Attributes
    ----------
    scene : Scene
    profile : Resolved
        The profile with the samples that resolve it.
    surfaces : Surfaces
        The free surfaces of the scene, which give D of lines at given heights and slopes.
    size : float
        The largest of the depths and displacements that occur, of which rounding is a part
        [length].
    """

    scene: Scene
    profile: Resolved
    surfaces: Surfaces
    size: float

    @functools.cached_property
    def length(self) -> float:
        """The elastocapillary length l."""
        return self.scene.elastocapillary_length

    def noise(self, lines: Array) -> Array:
        """By how much D of the lines of gaps may be off, since the profile is rounded.

        Heights are rounded by ε of the size of depths, the tilt by that over L, so D by
        ε (l/L)² of the size. In narrow gaps, in which the rise is integrated, the tilt is off by
        the rounding of f', and D by l (l/L) times that.

        Parameters
        ----------
        lines : ndarray (.., 2)
            The left and the right line of free surfaces [length].

        Returns
        -------
        ndarray (..)
            One for both lines of each surface [length]; 0 of tails, inf where lines coincide.
        """
        q = lines[..., 0]
        p = lines[..., 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            length_ratio = self.length / np.maximum(p - q, 0.0)  # l/L
        noise_over_epsilon = np.asarray(self.size * length_ratio**2)
        narrow = self._narrow(q, p)
        if narrow.any():
            ends = lines[narrow]
            slope = np.asarray(self.profile.indenter.slope(ends.ravel()), float)
            slope = slope.reshape(ends.shape)
            curvature = np.abs(np.diff(slope) / np.diff(ends))[..., 0]
            # f' is rounded by a part of itself, and read at positions that are rounded, too.
            terms = np.abs(slope).sum(axis=-1) + np.abs(ends).max(axis=-1) * curvature
            noise_over_epsilon[narrow] = _ROUNDED * self.length * terms * length_ratio[narrow]
        return np.asarray(EPSILON * noise_over_epsilon)

    def _narrow(self, q: Any, p: Any) -> Mask:
        """Whether the rise of the profile between lines q and p, in either order, is integrated.

        It is where they are closer than `_NARROW`, apart, and have at most one sample strictly
        between them. Corners stand twice among the samples, so none is between.
        """
        low = np.minimum(q, p)
        high = np.maximum(q, p)
        narrow = np.asarray((high - low < _NARROW * self.length) & (low < high))
        if narrow.any():
            x = self.profile.x
            samples_between = np.searchsorted(x, high) - np.searchsorted(x, low, "right")
            narrow &= samples_between <= 1
        return narrow

    def _rise(self, line: LinePosition, facing: LinePosition) -> Any:
        """By how much the profile is higher at the facing line [length]; of narrow gaps ∫f' dx."""
        if np.min(abs(facing.x - line.x)) >= _NARROW * self.length:
            return facing.f - line.f
        rise = np.asarray(facing.f - line.f, float)
        narrow = self._narrow(line.x, facing.x)
        if narrow.any():
            start, end = (part[narrow] for part in np.broadcast_arrays(line.x, facing.x))
            rise[narrow] = self._integrated(start, end)
        return rise[()]

    def _integrated(self, start: Array, end: Array) -> Array:
        """∫f' dx (m,) from `start` to `end`, with at most one sample of the profile in between.

        The interval is cut at that sample, since f'' may jump there, and each of the two parts is
        integrated by Gauss quadrature. Without a sample in between one part has no width.
        """
        x = self.profile.x
        low = np.minimum(start, end)
        high = np.maximum(start, end)
        # Beyond the last sample the index wraps around; any place is good, as it is clipped.
        next_sample = x[np.searchsorted(x, low, "right") % x.size]
        cut = np.clip(next_sample, low, high)
        begin = np.array([start, cut])
        width = np.array([cut - start, end - cut])
        places = begin[..., None] + width[..., None] * (1 + _POINTS) / 2
        slope = np.asarray(self.profile.indenter.slope(places), float)
        integrals = width / 2 * (slope @ _WEIGHTS)
        return np.asarray(integrals.sum(axis=0))

    def rest_depth(
        self, side: Any, x: Any, f: Any, f1: Any, facing: LinePosition | None, w: Any
    ) -> Any:
        """Depth D at which lines rest.

        In gaps heights are counted from that of the line, so that the rise to the facing line,
        which may be known better than both heights, is not lost in these.

        Parameters
        ----------
        side : {1, -1}, or ndarray (n,)
            1 for a line whose contact is on its left.
        x, f, f1 : float or ndarray (n,)
            Positions of the lines [length], and height and slope f' of the profile there.
        facing : LinePosition or None
            The lines at the other end of the free surfaces, None for tails.
        w : float or ndarray (n,)
            Work of adhesion, where a pattern does not change it [energy/area].

        Returns
        -------
        float or ndarray (n,)
            [length].
        """
        if self.scene.pattern is not None:
            w = w * self.scene.pattern.factor(x)
        if facing is None:
            return self.surfaces.rest_depth(side, x, f, f1, None, w)
        zero = f - f  # the height of the line itself, in the shape of f
        facing_from_line = LinePosition(facing.x, self._rise(LinePosition(x, f), facing))
        return f + self.surfaces.rest_depth(side, x, zero, f1, facing_from_line, w)

    def at(self, x: Any) -> LinePosition | None:
        """Lines at positions, with the heights of the profile there.

        Parameters
        ----------
        x : float or ndarray (n,)
            Positions [length].

        Returns
        -------
        LinePosition or None
            None if one of the positions is infinite: there is no line.
        """
        return LinePosition(x, self.profile.indenter.height(x)) if np.isfinite(x).all() else None

    def w(self, direction: Any) -> Any:
        """The work of adhesion of contacts that close, or of those that open.

        Parameters
        ----------
        direction : {1, -1}, or ndarray
            1 where they close, -1 where they open.

        Returns
        -------
        float or ndarray
            [energy/area].
        """
        closing = self.scene.work_of_adhesion
        opening = self.scene.opened.work_of_adhesion
        if closing == opening:
            return closing
        return np.where(np.greater(direction, 0), closing, opening)[()]

    def between_corners(self, lines: Array, direction: int) -> Array:
        """Between which places lines may move without passing a corner, where D may jump.

        That is between the neighbouring joints of the profile: corners, edges of a pattern and
        ends of the window. Four roundings are kept from them. A line at a joint itself is on that
        side of it to which it moves.

        Parameters
        ----------
        lines : ndarray (n, 2)
            Positions of the left and the right line [length].
        direction : {1, -1}
            1 where lines advance, -1 where they recede.

        Returns
        -------
        ndarray (2, n, 2)
            Least and largest positions [length]; lines at infinity stay there.
        """
        joints = self.profile.joints
        margin = ULPS * self._spacing(joints)
        moves_right = SIDES * direction > 0
        # The number of the joint that ends the interval: of a line at a joint the next one if it
        # moves to the right, and that joint itself if it moves to the left.
        end = np.where(moves_right, joints.searchsorted(lines, "right"), joints.searchsorted(lines))
        end = np.minimum(np.maximum(end, 1), joints.size - 1)
        found = np.array([(joints + margin)[end - 1], (joints - margin)[end]])
        return np.where(np.isfinite(lines), found, lines)

    def _spacing(self, x: Array) -> Array:
        """Rounding of positions [length]; next to 0 that of a small part of l.

        An indenter may divide x by a length of the size of l, so its rounding does not vanish at 0.
        """
        return np.spacing(np.maximum(np.abs(x), DIFFERENCES.least_position * self.length))

    def _of(self, side: Any, x: Array, f: Array, f1: Array, facing: LinePosition, w: Any) -> Array:
        """D of lines of gaps and of tails, in the shape of x.

        `side` and `w` broadcast with x. A facing line at infinity stands for none: the surface is a
        tail. D of a line that is itself at infinity is inf; f and f1 are not used there.
        """
        one = np.ones(x.shape)
        side = side * one
        w = w * one
        found = math.inf * one
        has_line = np.isfinite(x)
        faces_line = np.isfinite(facing.x)
        gaps = has_line & faces_line
        if gaps.any():
            other = LinePosition(facing.x[gaps], facing.f[gaps])
            found[gaps] = self.rest_depth(side[gaps], x[gaps], f[gaps], f1[gaps], other, w[gaps])
        tails = has_line & ~faces_line
        if tails.any():
            found[tails] = self.rest_depth(
                side[tails], x[tails], f[tails], f1[tails], None, w[tails]
            )
        return found

    def one_sided(
        self, side: Any, x: Array, facing: Array, aside: Any, direction: Any, adheres: Any = True
    ) -> Array:
        """Depths D of lines, read just outwards or just inwards of them.

        The two differ at corners, where the slope jumps, at edges of a pattern, where the work of
        adhesion does, and at edges of the body.

        Parameters
        ----------
        side : {1, -1}, or ndarray
            1 for lines whose contacts are on their left.
        x : ndarray
            Their positions [length].
        facing : ndarray
            Those of the lines beyond their free surfaces, infinite where there is none [length].
        aside : {1, -1}
            Whether D is read just outwards (1) or inwards (-1) of the contact.
        direction : {1, -1}
            1 with the adhesion of a contact that closes, -1 of one that opens.
        adheres : bool
            False for D without adhesion.

        Returns
        -------
        ndarray
            [length], in the shape of x. Just outwards of an edge of the body D is inf, since there
            is nothing to touch: the line never advances. Where the line is at the edge behind its
            own contact D just inwards is -inf: it never recedes. D of a line at infinity is inf.
        """
        side = np.asarray(side)
        indenter = self.profile.indenter
        towards = side * aside  # 1 to the right, -1 to the left
        # Lines at infinity are read at the first sample, as f(inf) may be nan; `_of` drops that.
        both = np.array([x, facing])
        own_place, facing_place = np.where(np.isfinite(both), both, self.profile.x[0])
        f, f1 = self.profile.one_sided(own_place, towards)
        other = LinePosition(facing, np.asarray(indenter.height(facing_place), float))
        beside_edge = self.profile.past(x, towards)
        rest = self._of(side, beside_edge, f, f1, other, self.w(direction) * adheres)
        if indenter.walls:
            past = past_wall(indenter, x, side, aside)
            rest = np.where(past, np.copysign(math.inf, aside), rest)
        return rest

    def ahead(self, lines: Array, direction: int) -> Array:
        """D just ahead of lines: outwards if they advance, inwards if they recede.

        Parameters
        ----------
        lines : ndarray (.., 2)
            Positions of the left and the right line [length].
        direction : {1, -1}
            1 where lines advance, -1 where they recede.

        Returns
        -------
        ndarray (.., 2)
            [length].
        """
        return self.one_sided(SIDES, lines, lines[..., ::-1], direction, direction)

    def depths(self, lines: Array, direction: int) -> Array:
        """D of both lines of free surfaces, at places that are no corners.

        Parameters
        ----------
        lines : ndarray (n, 2)
            Positions of the left and the right line [length].
        direction : {1, -1}
            1 with the adhesion of a contact that closes, -1 of one that opens.

        Returns
        -------
        ndarray (n, 2)
            [length]; infinite of a line at infinity.
        """
        return self._facing(lines, lines, direction)

    def with_rates(self, lines: Array, room: Array, direction: int) -> tuple[Array, Array]:
        """D of both lines of free surfaces, and its derivatives by both.

        The derivatives are central differences, at most half-way to a corner, at which it is not
        known on which side to read the slope.

        Parameters
        ----------
        lines : ndarray (n, 2)
            Positions of the left and right line [length], infinite where there is none.
        room : ndarray (2, n, 2)
            The places between which they move without passing a corner, as of `between_corners`
            [length].
        direction : {1, -1}
            1 with the adhesion of a contact that closes, -1 of one that opens.

        Returns
        -------
        depths : ndarray (n, 2)
            D [length]; infinite of a line at infinity.
        rates : ndarray (n, 2, 2)
            ∂D of a line (row) by the position of a line (column), towards +x for both lines; 0
            where one of them is at infinity, nan between two corners that leave no room.
        """
        has_line = np.isfinite(lines)
        gaps = np.asarray(has_line.all(axis=1))
        step = self.step(lines)[:, None]
        low, high = (lines + room) / 2
        above = np.clip(lines + step, low, high)
        below = np.clip(lines - step, low, high)
        # Five readings of D, each with lines and with lines that face those: where they are, each
        # line moved by its step up and down, and of gaps the line that it faces moved so.
        moved = [lines, above, below]
        facing = [lines, lines, lines]
        if gaps.any():
            lines_of_gaps = np.where(gaps[:, None], lines, math.inf)
            moved += [lines_of_gaps, lines_of_gaps]
            facing += [above, below]
        rest = self._facing(np.array(moved), np.array(facing), direction)
        rates = np.zeros((*lines.shape, 2))
        with np.errstate(divide="ignore", invalid="ignore"):  # between two corners, and at infinity
            width = above - below
            rates[:, [0, 1], [0, 1]] = (rest[1] - rest[2]) / width
            if gaps.any():
                rates[:, [0, 1], [1, 0]] = (rest[3] - rest[4]) / width[:, ::-1]
        both_exist = has_line[:, :, None] & has_line[:, None]
        return rest[0], np.where(both_exist, rates, 0.0)

    def _facing(self, lines: Array, facing: Array, direction: int) -> Array:
        """D of both lines of surfaces (.., 2), in each of which the facing line may have moved.

        The left line of `lines` faces the right one of `facing`, and the right line the left one.
        Both have the shape (.., 2), columns left and right. Places at infinity are read at the
        lowest point, as f(inf) may be nan; `_of` drops what is read there.
        """
        indenter = self.profile.indenter
        own_place = np.where(np.isfinite(lines), lines, self.profile.lowest)
        facing_place = np.where(np.isfinite(facing), facing, self.profile.lowest)
        f = np.asarray(indenter.height(own_place), float)
        f1 = np.asarray(indenter.slope(own_place), float)
        facing_f = np.asarray(indenter.height(facing_place), float)
        other = LinePosition(facing[..., ::-1], facing_f[..., ::-1])
        return self._of(SIDES, lines, f, f1, other, self.w(direction))

    def condition(self, rate: Array, free: Mask, *, single: bool) -> tuple[Array, Mask]:
        """How far lines move if D is off, and whether they are stable.

        How far they move is linear in what D of both lines is off by; it is largest where both are
        off by as much, with equal or opposite signs. Where D is least, the line of a single contact
        is found to the square root of its rounding: there dD/dx may be 0 but for FLAT.

        Parameters
        ----------
        rate : ndarray (n, 2, 2)
            Derivatives of D of both lines (rows) by both positions (columns).
        free : ndarray of bool (n, 2)
            Which lines are not pinned.
        single : bool
            Whether they are the lines of the only contact.

        Returns
        -------
        moved : ndarray (n, 2)
            How far lines move over what D is off by.
        stable : ndarray of bool (n,)
            Whether both lines together are stable.
        """
        ones = np.ones(free.shape)
        off_alike = np.abs(solved(rate, ones, free))
        off_oppositely = np.abs(solved(rate, ones * SIDES, free))
        # dD/dx that is 0 or negative by no more than rounding counts as stable.
        steepest = np.abs(rate).max(axis=(1, 2), keepdims=True)
        rounding = np.maximum(_FALLING * steepest, single * FLAT * self.size / self.length)
        return np.maximum(off_alike, off_oppositely), stable(rate + _GROWING * rounding, free)

    def step(self, lines: Array) -> Array:
        """Steps of the central differences of D by the lines of surfaces.

        They are parts of l, of the width of a gap, or about an axis of the radius. In a narrow gap
        of width L, D varies by (L/l)² of the size of depths and is known to ε (l/L)² of it: the
        part is the cube root of the ratio ε (l/L)⁴.

        Parameters
        ----------
        lines : ndarray (.., 2)
            Positions [length].

        Returns
        -------
        ndarray (..)
            One step for both lines [length].
        """
        width = lines[..., 1] - lines[..., 0]
        with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
            length_ratio = np.maximum(self.length / width, 0.0)  # l/L
            best = np.cbrt(EPSILON * length_ratio**4)
        part = np.clip(best, DIFFERENCES.step, DIFFERENCES.widest)
        furthest = np.where(np.isfinite(lines), np.abs(lines), 0.0).max(axis=-1)
        if self.scene.axisymmetric:
            width = np.minimum(width, np.maximum(furthest, DIFFERENCES.least_radius * self.length))
        # Where l is rounding beside x, a step of a part of l would move nothing. A step of a
        # quarter of a gap leaves three quarters of it.
        least = np.minimum(DIFFERENCES.least_ulps * np.spacing(furthest), width / 4)
        return np.asarray(np.maximum(part * np.minimum(width, self.length), least))


def solved(rate: Array, off: Array, free: Mask) -> Array:
    """The solution of rate · step = off for the free lines of each surface, by Cramer's rule.

    Parameters
    ----------
    rate : ndarray (n, 2, 2)
        Derivatives of D of both lines (rows) by both positions (columns).
    off : ndarray (n, 2)
        By how much D of the left and of the right line is off, D - d [length].
    free : ndarray of bool (n, 2)
        Which lines move.

    Returns
    -------
    ndarray (n, 2)
        Steps of both lines towards +x [length], 0 of those that are not free; inf or nan where
        the matrix is singular.
    """
    matrix = _of_free(rate, free)
    determinant = _determinant(matrix)
    off_left, off_right = off.T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        left = (matrix[:, 1, 1] * off_left - matrix[:, 0, 1] * off_right) / determinant
        right = (matrix[:, 0, 0] * off_right - matrix[:, 1, 0] * off_left) / determinant
    return np.where(free, np.stack([left, right], axis=-1), 0.0)


def stable(rate: Array, free: Mask) -> Mask:
    """Whether the free lines of each surface are stable (n,); parameters as of `solved`.

    D must grow outwards of every line: with x of the left one, against x of the right one. With
    both lines free the matrix of growth outwards, diag(1, -1) · rate, must be definite: it has the
    determinant of `rate` with the other sign, so that one must be negative.
    """
    matrix = _of_free(rate, free)
    grows = (matrix[:, 0, 0] > 0) & (matrix[:, 1, 1] < 0)
    return np.asarray(grows & (_determinant(matrix) < 0))


def _of_free(rate: Array, free: Mask) -> Array:
    """The matrices (n, 2, 2) of the free lines; of a line that is not, row and column of _GROWING.

    So it does not move the others, and does not make them unstable.
    """
    both = free[:, :, None] & free[:, None]
    return np.where(both, rate, _GROWING)


def _determinant(matrix: Array) -> Array:
    """The determinants (n,) of matrices (n, 2, 2)."""
    return np.asarray(matrix[:, 0, 0] * matrix[:, 1, 1] - matrix[:, 0, 1] * matrix[:, 1, 0])
