"""What must vanish where contact lines rest: the equations of both lines of many free surfaces.

With small slopes the free surface between lines q < p, L = (p - q)/l, displaced by u = d - f there,
pulls at its left line with kl [σ u_q + τ (u_q - u_p)], σ = tanh(L/2), τ = 1/sinh L. A line rests
where the slopes of surface and indenter differ by √(2w/γ₁), which is ∂U/∂x = 0:

    F = f'_out - √(2w/γ₁) - [σ (d - f) + τ (f_facing - f)]/l = 0,

f'_out the slope outwards of the contact. F has the sign of D - d, D the depth at which the line
would rest: it advances where F < 0, recedes where F > 0. A tail has no facing line: σ = 1, τ = 0.

Conventions
-----------
Depths d and displacements u grow downwards, heights f of the profile upwards, positions to the
right. Arrays: lines (n, 2), a row for each free surface with its left line q in column 0 and its
right line p in column 1, -inf and inf where a tail has none; depths (n,); directions (n,): 1 where
the depth grows (adhesion of closing), -1 where it falls (of opening). The left line of a free
surface is the right end of a contact, so that outwards of the contact is to the right there, and to
the left at a right line: OUTWARDS.

Joints are the places where F may jump: corners, edges of a pattern, both ends of the profile. A
room is a piece of the profile between two neighbouring joints, numbered from 0 on the left.

Of the profile (`Resolved`), `touch` is the height of the lowest point, the depth of first touch,
and `lowest` its x; its indenter has f and f' at places (`height_and_slope`), and `walls` are the
ends of the profile at which the body itself ends. Of the scene, `elastocapillary_length` is
l = √(γ₁/k), and `opened` the scene with the work of adhesion of opening, whose
`critical_separation` is δ₀ = √(2w/k); `layer.h` is the thickness of the layer, which only stands
for a size where nothing else has one.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.profile import Resolved
from energy import Scene
from energy.arrays import Array, Indices, Mask, Nodes

OUTWARDS = np.array([1.0, -1.0])  # of the contact, at the left and at the right line of a surface


class EquationRules(NamedTuple):
    """How close to joints, and over which steps, the equations are read; lengths are of l.

    Halved or doubled (tolerances below 1e-4: a tenth or ten times), each leaves 23 random states
    and paths as they are to 1e-9: `python -m tests.sensitivity discretization.refine.equations`.

    Attributes
    ----------
    roundings : int
        Of a position: a line that is so near to a joint is read on one side of it.
    least : float
        Positions nearer to 0 are rounded as there.
    curvature : float
        The step over which f'' is taken from f': its error is the square, 1e-12, and rounding of f'
        over the step, 2e-10. It steers steps of Newton's method, and costs no digit.
    aside : float
        Of that step: so far from a joint slopes are those of their own side.
    narrowest : float
        Width of a gap that is about to close, below which 1/sinh L is kept finite.
    """

    roundings: int = 4
    least: float = 1e-6
    curvature: float = 1e-6
    aside: float = 0.1
    narrowest: float = 1e-12


_RULES = EquationRules()


class Ties(NamedTuple):
    """σ = tanh(L/2) and τ = 1/sinh L of free surfaces, L their widths over l.

    Attributes
    ----------
    ground, tie : ndarray (n,)
        σ and τ; 1 and 0 of a tail.
    ground_rate, tie_rate : ndarray (n,)
        Their derivatives by L.
    """

    ground: Array
    tie: Array
    ground_rate: Array
    tie_rate: Array


def ties(widths: Array) -> Ties:
    """σ and τ of free surfaces.

    Parameters
    ----------
    widths : ndarray (n,)
        Of the surfaces over l, infinite for tails.

    Returns
    -------
    Ties
    """
    wide = np.minimum(np.maximum(widths, _RULES.narrowest), 700.0)  # beyond, sinh overflows
    ground = np.tanh(wide / 2)
    tie = 1 / np.sinh(wide)
    ground_rate = 0.5 / np.cosh(wide / 2) ** 2
    tie_rate = -tie / np.tanh(wide)
    return Ties(ground, tie, ground_rate, tie_rate)


class OnProfile(NamedTuple):
    """Where lines are on the profile; the lowest point stands for no line.

    Attributes
    ----------
    x, f : ndarray (n, 2)
        Positions, and heights of the profile there [length].
    slope : ndarray (n, 2)
        f'.
    """

    x: Array
    f: Array
    slope: Array


@dataclass(frozen=True, eq=False)
class Equations:
    """The equations F = 0 of the lines of a scene's free surfaces.

    Attributes
    ----------
    scene : Scene
    profile : Resolved
    size : float
        Of the depths of a path [length], by which rounding is judged.
    """

    scene: Scene
    profile: Resolved
    size: float

    @classmethod
    def of(cls, scene: Scene, profile: Resolved, depth: float) -> Equations:
        """The equations for depths up to this one [length]."""
        size = scene.opened.critical_separation + max(abs(depth), abs(profile.touch))
        return cls(scene, profile, size or scene.layer.h)

    @functools.cached_property
    def length(self) -> float:
        """The elastocapillary length l."""
        return self.scene.elastocapillary_length

    @functools.cached_property
    def joints(self) -> Array:
        """Increasing positions at which D may jump, with both ends of the profile."""
        return self.profile.joints

    @functools.cached_property
    def rooms(self) -> tuple[Array, Array]:
        """Lower and upper ends (j - 1,) of the rooms between joints, a few roundings from them."""
        sizes = np.maximum(np.abs(self.joints), _RULES.least * self.length)
        aside = _RULES.roundings * np.spacing(sizes)
        return (self.joints + aside)[:-1], (self.joints - aside)[1:]

    @functools.cached_property
    def edges(self) -> Array:
        """The positions of edges at which the body ends, so that lines may stay there."""
        return np.asarray(self.scene.indenter.walls, float)

    def rooms_of(self, lines: Array) -> Nodes:
        """The room, a piece of the profile between two joints, in which each line is.

        Parameters
        ----------
        lines : ndarray (n, 2)
            [length].

        Returns
        -------
        ndarray of int (n, 2)
            Numbers of rooms; of a line at a joint that of the room outwards of its contact.
        """
        finite = np.where(np.isfinite(lines), lines, self.profile.lowest)
        on_its_right = np.searchsorted(self.joints, finite, "right") - 1
        on_its_left = np.searchsorted(self.joints, finite, "left") - 1
        room = np.where(OUTWARDS > 0, on_its_right, on_its_left)
        return np.clip(room, 0, self.joints.size - 2)

    def snapped(self, lines: Array) -> Array:
        """Lines (n, 2), those a few roundings from a joint put on it.

        Rooms end some roundings from their joints; twice these are still on it.
        """
        finite = np.where(np.isfinite(lines), lines, 0.0)
        middles = (self.joints[1:] + self.joints[:-1]) / 2
        near = self.joints[np.searchsorted(middles, finite)]
        close = (
            2 * _RULES.roundings * np.spacing(np.maximum(np.abs(near), _RULES.least * self.length))
        )
        return np.where(np.isfinite(lines) & (np.abs(finite - near) <= close), near, lines)

    def kink(self, lines: Array, directions: Array) -> Array:
        """√(2w/γ₁) at lines (n, 2): by how much slopes differ where a line rests.

        With the work of adhesion of closing or of opening, as directions (n,) say.
        """
        closing = math.sqrt(2 * self.scene.work_of_adhesion / self.scene.gamma1)
        opening = math.sqrt(2 * self.scene.opened.work_of_adhesion / self.scene.gamma1)
        kink = np.where(directions > 0, closing, opening)[:, None]
        return np.broadcast_to(kink, lines.shape)

    def on_profile(self, lines: Array) -> OnProfile:
        """Where lines (n, 2) are on the profile, which `values` and `rates` share."""
        x = np.where(np.isfinite(lines), lines, self.profile.lowest)
        height, slope = self.profile.indenter.height_and_slope(x)
        return OnProfile(x, np.asarray(height, float), np.asarray(slope, float))

    def values(
        self, lines: Array, depths: Array, directions: Array, known: OnProfile | None = None
    ) -> Array:
        """F of lines that are not exactly at a joint.

        Parameters
        ----------
        lines : ndarray (n, 2)
            [length].
        depths : ndarray (n,)
            [length].
        directions : ndarray (n,)
            1 where the depth grows, -1 where it falls.
        known : OnProfile, optional
            Where the lines are on the profile, if that has been found.

        Returns
        -------
        ndarray (n, 2)
            0 where there is no line.
        """
        there = self.on_profile(lines) if known is None else known
        steep = OUTWARDS * there.slope - self.kink(there.x, directions)
        pull = self._pull(lines, there.f, depths)
        return np.where(np.isfinite(lines), steep - pull / self.length, 0.0)

    def pulls(self, lines: Array, depths: Array) -> Array:
        """The pull σ u + τ (u - u_facing) of free surfaces at their lines, over kl.

        Positive where the surface pushes its contact up against the indenter.

        Parameters
        ----------
        lines : ndarray (n, 2)
            [length].
        depths : ndarray (n,)
            [length].

        Returns
        -------
        ndarray (n, 2)
            [length]; 0 where there is no line.
        """
        height = self._heights(lines)
        return np.where(np.isfinite(lines), self._pull(lines, height, depths), 0.0)

    def _pull(self, lines: Array, height: Array, depths: Array) -> Array:
        """The same (n, 2), given the heights (n, 2) of the profile at the lines.

        u - u_facing is f_facing - f, as the depth is the same at both lines.
        """
        found = ties(self._widths(lines))
        displaced = depths[:, None] - height
        rise = np.where(self._is_gap(lines)[:, None], height[:, ::-1] - height, 0.0)
        return np.asarray(found.ground[:, None] * displaced + found.tie[:, None] * rise)

    def shape(self, places: Array, lines: Array, depths: Array) -> tuple[Array, Array]:
        """Gap v = u - d + f between free surfaces and the profile, and its slope v'.

        Parameters
        ----------
        places : ndarray (n, j)
            On each surface [length].
        lines : ndarray (n, 2)
            [length].
        depths : ndarray (n,)
            [length].

        Returns
        -------
        gap, slope : ndarray (n, j)
            v [length] and v'.
        """
        own = np.repeat(np.arange(len(lines)), places.shape[1])
        u, slope = self.surface(places.ravel(), own, lines, depths)
        profile_height, profile_slope = self.profile.indenter.height_and_slope(places)
        gap = u.reshape(places.shape) - depths[:, None] + profile_height
        return gap, slope.reshape(places.shape) + profile_slope

    def surface(
        self, places: Array, own: Indices, lines: Array, depths: Array
    ) -> tuple[Array, Array]:
        """Displacement of free surfaces, and its slope, without overflow.

            u = [u_q sinh((p - y)/l) + u_p sinh((y - q)/l)]/sinh((p - q)/l)

        Parameters
        ----------
        places : ndarray (m,)
            y [length].
        own : ndarray of int (m,)
            Number of the surface on which each place is.
        lines : ndarray (n, 2)
            q and p of all surfaces [length].
        depths : ndarray (n,)
            [length].

        Returns
        -------
        u, slope : ndarray (m,)
            u [length] and u'.
        """
        at_left, at_right = self.displaced(lines, depths)[own].T
        from_left = (places - lines[own, 0]) / self.length  # infinite of a tail without that line
        from_right = (lines[own, 1] - places) / self.length
        # With numerator and denominator over exp((p - q)/l)/2 all exponents are negative.
        both = np.maximum(-np.expm1(-2 * (from_left + from_right)), _RULES.narrowest)
        left = np.exp(-from_left)
        right = np.exp(-from_right)
        near = left * -np.expm1(-2 * from_right) / both
        far = right * -np.expm1(-2 * from_left) / both
        falling = left * (1 + right**2) * at_left
        rising = right * (1 + left**2) * at_right
        return near * at_left + far * at_right, (rising - falling) / both / self.length

    def displaced(self, lines: Array, depths: Array) -> Array:
        """u = d - f at lines (n, 2), 0 where there is none."""
        return np.where(np.isfinite(lines), depths[:, None] - self._heights(lines), 0.0)

    def _heights(self, lines: Array) -> Array:
        """f at lines (n, 2); the lowest point stands for no line."""
        x = np.where(np.isfinite(lines), lines, self.profile.lowest)
        return np.asarray(self.profile.indenter.height(x), float)

    def rates(
        self, lines: Array, depths: Array, rooms: Nodes, known: OnProfile | None = None
    ) -> Array:
        """The derivatives ∂F_i/∂x_j of the equations, i and j 0 for the left, 1 for the right line.

        With s = 1 for the left and -1 for the right line, L = (p - q)/l, and σ', τ' by L,

            ∂F/∂x = s f'' + (σ + τ) f'/l + s [σ' (d - f) + τ' (f_facing - f)]/l²,
            ∂F/∂x_facing = -τ f'_facing/l - s [σ' (d - f) + τ' (f_facing - f)]/l².

        Parameters
        ----------
        lines : ndarray (n, 2)
            [length].
        depths : ndarray (n,)
            [length].
        rooms : ndarray of int (n, 2)
            In which the lines are; f'' is that on this side of a joint.
        known : OnProfile, optional
            Where the lines are on the profile, if that has been found.

        Returns
        -------
        ndarray (n, 2, 2)
            [1/length]; 0 where there is no line.
        """
        x, height, slope = self.on_profile(lines) if known is None else known
        found = ties(self._widths(lines))
        is_gap = self._is_gap(lines)[:, None]
        displaced = depths[:, None] - height
        rise = np.where(is_gap, height[:, ::-1] - height, 0.0)
        tie = np.where(is_gap, found.tie[:, None], 0.0)
        ground = found.ground[:, None]
        widening = found.ground_rate[:, None] * displaced + found.tie_rate[:, None] * rise
        widening = np.where(is_gap, widening, 0.0) / self.length**2
        bend = OUTWARDS * self._curvature(x, rooms)
        own = bend + (ground + tie) * slope / self.length + OUTWARDS * widening
        other = -OUTWARDS * widening - tie * slope[:, ::-1] / self.length
        rates = np.empty((len(lines), 2, 2))
        rates[:, [0, 1], [0, 1]] = np.where(np.isfinite(lines), own, 0.0)
        rates[:, [0, 1], [1, 0]] = np.where(is_gap, other, 0.0)
        return rates

    def _curvature(self, x: Array, rooms: Nodes) -> Array:
        """f'' at x (n, 2) by a central difference that stays in the rooms of the lines.

        0 where there is no room for it. Nor does it come next to a joint, where the slope of a
        profile that is put together may be that of the other side, by rounding.
        """
        step = _RULES.curvature * self.length
        lower, upper = self.rooms
        low = np.maximum(x - step, np.minimum(lower[rooms] + _RULES.aside * step, x))
        high = np.minimum(x + step, np.maximum(upper[rooms] - _RULES.aside * step, x))
        at_low, at_high = self.profile.indenter.slope(np.array([low, high]))
        change = at_high - at_low
        with np.errstate(divide="ignore", invalid="ignore"):
            return np.where(high > low, change / (high - low), 0.0)

    def _widths(self, lines: Array) -> Array:
        """Widths L of surfaces over l (n,), infinite for tails."""
        with np.errstate(invalid="ignore"):
            widths = (lines[:, 1] - lines[:, 0]) / self.length
        return np.where(self._is_gap(lines), widths, math.inf)

    def _is_gap(self, lines: Array) -> Mask:
        """Whether free surfaces have two lines (n,)."""
        return np.asarray(np.isfinite(lines).all(axis=1))


def free_surfaces(lines: tuple[float, ...]) -> Array:
    """The free surfaces outside and between m contacts.

    Parameters
    ----------
    lines : tuple of float
        The 2m lines of the contacts from left to right [length].

    Returns
    -------
    ndarray (m + 1, 2)
        Left and right line of every free surface, infinite where a tail has none.
    """
    return np.array([-math.inf, *lines, math.inf]).reshape(-1, 2)


def lines_of_surfaces(surfaces: Array) -> tuple[float, ...]:
    """The 2m lines of contacts from left to right, given their free surfaces (m + 1, 2)."""
    return tuple(surfaces.ravel()[1:-1].tolist())
