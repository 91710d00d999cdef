"""Where the lines of many free surfaces rest, at once: D(x) and how it changes with the lines.

Free surfaces stand in rows (n, 2) of a left and a right line, the other line of a tail is infinite.
Narrow gaps feel the rounding of the profile: the tilt of a gap of length L is the rise of the
profile over L, and D of its lines varies by (l/L) times what the tilt does. Heights are rounded by
a part of themselves; so where the slope is smooth in a narrow gap, the rise is ∫f' dx instead.
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
SIDES = np.array([1, -1])  # of the left and the right line of a free surface


class DifferenceRules(NamedTuple):
    """Steps of the central differences of D by the lines.

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
FLAT = 1e-7
_FALLING = 1e-9  # of the steepest dD/dx of both lines: what may be rounding of one that is 0
_GROWING = np.diag([1.0, -1.0])  # dD/dx of two lines with both, if they grow outwards alone

# Narrow gaps.
_NARROW = 1e-2  # of l: gaps of which the rise of the profile is integrated
_ROUNDED = 64  # roundings of a slope: it may be a small sum of large terms
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
    surfaces : Surfaces
        Its free surfaces.
    size : float
        Of depths [length].
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
        """What rounding of heights makes of D, of surfaces with lines (.., 2).

        ε (l/L)² of the size of depths, or in narrow gaps (l/L) of l times the rounding of f'.

        Parameters
        ----------
        lines : ndarray (.., 2)
            The left and the right line of free surfaces [length].

        Returns
        -------
        ndarray (..)
            [length].
        """
        q = lines[..., 0]
        p = lines[..., 1]
        with np.errstate(divide="ignore", invalid="ignore"):
            length_ratio = self.length / np.maximum(p - q, 0.0)  # l/L
        found = np.asarray(self.size * length_ratio**2)
        near = self._narrow(q, p)
        if near.any():
            ends = lines[near]
            slope = np.asarray(self.profile.indenter.slope(ends.ravel()), float)
            slope = slope.reshape(ends.shape)
            bend = np.abs(np.diff(slope) / np.diff(ends))[..., 0]
            terms = np.abs(slope).sum(axis=-1) + np.abs(ends).max(axis=-1) * bend
            found[near] = _ROUNDED * self.length * terms * length_ratio[near]
        return np.asarray(EPSILON * found)

    def _narrow(self, q: Any, p: Any) -> Mask:
        """Whether lines are close to each other, with at most one sample between, and no corner."""
        low = np.minimum(q, p)
        high = np.maximum(q, p)
        found = np.asarray((high - low < _NARROW * self.length) & (low < high))
        if found.any():
            x = self.profile.x
            found &= np.searchsorted(x, high) - np.searchsorted(x, low, "right") <= 1
        return found

    def _rise(self, line: LinePosition, facing: LinePosition) -> Any:
        """By how much the profile is higher at the facing line; of narrow gaps as ∫f' dx."""
        if np.min(abs(facing.x - line.x)) >= _NARROW * self.length:
            return facing.f - line.f
        found = np.asarray(facing.f - line.f, float)
        near = self._narrow(line.x, facing.x)
        if near.any():
            start, end = (part[near] for part in np.broadcast_arrays(line.x, facing.x))
            found[near] = self._integrated(start, end)
        return found[()]

    def _integrated(self, start: Array, end: Array) -> Array:
        """∫f' dx (m,) between places with at most one sample in between, on both sides of that."""
        x = self.profile.x
        low = np.minimum(start, end)
        high = np.maximum(start, end)
        next_sample = x[np.searchsorted(x, low, "right") % x.size]
        knot = np.clip(next_sample, low, high)
        begin = np.array([start, knot])
        width = np.array([knot - start, end - knot])
        places = begin[..., None] + width[..., None] * (1 + _POINTS) / 2
        slope = np.asarray(self.profile.indenter.slope(places), float)
        integrals = width * (slope @ _WEIGHTS)
        return np.asarray(integrals.sum(axis=0) / 2)

    def rest_depth(
        self, side: Any, x: Any, f: Any, f1: Any, facing: LinePosition | None, w: Any
    ) -> Any:
        """Depth D at which lines rest; of a gap, heights count from that of the line.

        Parameters
        ----------
        side : {1, -1}, or ndarray (n,)
            1 for a line whose contact is on its left.
        x, f, f1 : float or ndarray (n,)
            Positions of the lines [length], and height and slope of the profile there.
        facing : LinePosition or None
            The lines on the other side of the free surfaces.
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
        beyond = LinePosition(facing.x, self._rise(LinePosition(x, f), facing))
        return f + self.surfaces.rest_depth(side, x, f - f, f1, beyond, w)

    def at(self, x: Any) -> LinePosition | None:
        """Lines with the heights of the profile there.

        Parameters
        ----------
        x : float or ndarray (n,)
            Positions [length].

        Returns
        -------
        LinePosition or None
            None at infinity.
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
        """Between which places lines (n, 2) move without passing a corner, (2, n, 2).

        A line at a corner is on that side of it to which it moves.

        Parameters
        ----------
        lines : ndarray (n, 2)
            Positions of the left and the right line [length].
        direction : {1, -1}
            1 where lines advance, -1 where they recede.

        Returns
        -------
        ndarray (2, n, 2)
            Least and largest positions [length].
        """
        known = self.profile.joints
        after = known.searchsorted(lines, "right")
        least = ULPS * self._spacing(known)
        at = np.where(SIDES * direction > 0, after, known.searchsorted(lines))
        at = np.minimum(np.maximum(at, 1), known.size - 1)
        found = np.array([(known + least)[at - 1], (known - least)[at]])
        return np.where(np.isfinite(lines), found, lines)

    def _spacing(self, x: Array) -> Array:
        """Rounding of positions, at 0 of a small part of l: an indenter may divide them by that."""
        return np.spacing(np.maximum(np.abs(x), DIFFERENCES.least_position * self.length))

    def _of(self, side: Any, x: Array, f: Array, f1: Array, facing: LinePosition, w: Any) -> Array:
        """D of lines with heights and slopes that face others, infinite if there is none.

        D of a line at infinity is ∞.
        """
        one = np.ones(x.shape)
        side = side * one
        w = w * one
        found = math.inf * one
        has_line = np.isfinite(x)
        faces_line = np.isfinite(facing.x)
        gaps = has_line & faces_line
        if gaps.any():
            beyond = LinePosition(facing.x[gaps], facing.f[gaps])
            found[gaps] = self.rest_depth(side[gaps], x[gaps], f[gaps], f1[gaps], beyond, w[gaps])
        tails = has_line & ~faces_line
        if tails.any():
            found[tails] = self.rest_depth(
                side[tails], x[tails], f[tails], f1[tails], None, w[tails]
            )
        return found

    def one_sided(
        self, side: Any, x: Array, facing: Array, aside: Any, direction: Any, adheres: Any = True
    ) -> Array:
        """Depths D of lines, read just beside them.

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
            [length]. Beyond the edge of the body nothing can be touched, D = ∞, or left, D = -∞;
            D = ∞ of a line at infinity.
        """
        side = np.asarray(side)
        indenter = self.profile.indenter
        towards = side * aside  # 1 to the right, -1 to the left
        z = np.array([x, facing])
        known, other = np.where(np.isfinite(z), z, self.profile.x[0])
        f, f1 = self.profile.one_sided(known, towards)
        beyond = LinePosition(facing, np.asarray(indenter.height(other), float))
        place = self.profile.past(x, towards)
        rest = self._of(side, place, f, f1, beyond, self.w(direction) * adheres)
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
        """D of both lines (n, 2), and its changes (n, 2, 2) with both.

        By central differences, at most half-way to a corner, at which the side is not known. The
        change of D of a line (row) with a line (column) is 0 where one of them is at infinity.

        Parameters
        ----------
        lines : ndarray (n, 2)
            Positions of the left and right line [length], infinite where there is none.
        room : ndarray (2, n, 2)
            The places between which they move without passing a corner [length].
        direction : {1, -1}
            1 where contacts close, -1 where they open.
        """
        inner = np.isfinite(lines)
        gaps = np.asarray(inner.all(axis=1))
        step = self.step(lines)[:, None]
        low, high = (lines + room) / 2
        above = np.clip(lines + step, low, high)
        below = np.clip(lines - step, low, high)
        moved = [lines, above, below]
        facing = [lines, lines, lines]
        if gaps.any():
            # Nothing moves beside the line of a tail.
            own = np.where(gaps[:, None], lines, math.inf)
            moved += [own, own]
            facing += [above, below]
        rest = self._facing(np.array(moved), np.array(facing), direction)
        rates = np.zeros((*lines.shape, 2))
        with np.errstate(divide="ignore", invalid="ignore"):  # between two corners, and at infinity
            width = above - below
            rates[:, [0, 1], [0, 1]] = (rest[1] - rest[2]) / width
            if gaps.any():
                rates[:, [0, 1], [1, 0]] = (rest[3] - rest[4]) / width[:, ::-1]
        paired = inner[:, :, None] & inner[:, None]
        return rest[0], np.where(paired, rates, 0.0)

    def _facing(self, lines: Array, facing: Array, direction: int) -> Array:
        """D of lines (.., 2) each of which faces the other one of these lines (.., 2)."""
        indenter = self.profile.indenter
        known = np.where(np.isfinite(lines), lines, self.profile.lowest)
        other = np.where(np.isfinite(facing), facing, self.profile.lowest)
        f = np.asarray(indenter.height(known), float)
        f1 = np.asarray(indenter.slope(known), float)
        other_f = np.asarray(indenter.height(other), float)
        beyond = LinePosition(facing[..., ::-1], other_f[..., ::-1])
        return self._of(SIDES, lines, f, f1, beyond, self.w(direction))

    def condition(self, rate: Array, free: Mask, *, single: bool) -> tuple[Array, Mask]:
        """How far lines move if D is off, and whether they are stable.

        D of both lines may be off alike or oppositely. Where D is least, the line of a single
        contact is found to the root of its rounding: there dD/dx may be 0 but for FLAT.

        Parameters
        ----------
        rate : ndarray (n, 2, 2)
            Changes of D of both lines (rows) with both.
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
        alike = np.abs(solved(rate, ones, free))
        oppositely = np.abs(solved(rate, ones * SIDES, free))
        steepest = np.abs(rate).max(axis=(1, 2), keepdims=True)
        slack = np.maximum(_FALLING * steepest, single * FLAT * self.size / self.length)
        return np.maximum(alike, oppositely), stable(rate + _GROWING * slack, free)

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
        # Where l is rounding beside x, a step of a part of l would move nothing.
        least = np.minimum(DIFFERENCES.least_ulps * np.spacing(furthest), width / 4)
        return np.asarray(np.maximum(part * np.minimum(width, self.length), least))


def solved(rate: Array, off: Array, free: Mask) -> Array:
    """The solution (n, 2) of rate · step = off for the free lines of each surface, 0 of others.

    Parameters
    ----------
    rate : ndarray (n, 2, 2)
        Changes of D of both lines (rows) with both.
    off : ndarray (n, 2)
        D - d [length].
    free : ndarray of bool (n, 2)
        Which lines move.
    """
    matrix = _of_free(rate, free)
    determinant = _determinant(matrix)
    one, other = off.T
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        first = (matrix[:, 1, 1] * one - matrix[:, 0, 1] * other) / determinant
        second = (matrix[:, 0, 0] * other - matrix[:, 1, 0] * one) / determinant
    return np.where(free, np.stack([first, second], axis=-1), 0.0)


def stable(rate: Array, free: Mask) -> Mask:
    """Whether free lines are stable (n,); parameters as of `solved`.

    D must grow outwards of every line, and with both lines free their matrix be definite.
    """
    matrix = _of_free(rate, free)
    grows = (matrix[:, 0, 0] > 0) & (matrix[:, 1, 1] < 0)
    return np.asarray(grows & (_determinant(matrix) < 0))


def _of_free(rate: Array, free: Mask) -> Array:
    """The matrices (n, 2, 2) of the free lines; the rows of others are those of ±1."""
    both = free[:, :, None] & free[:, None]
    return np.where(both, rate, _GROWING)


def _determinant(matrix: Array) -> Array:
    """The determinants (n,) of matrices (n, 2, 2)."""
    return np.asarray(matrix[:, 0, 0] * matrix[:, 1, 1] - matrix[:, 0, 1] * matrix[:, 1, 0])
