"""Energies, forces, angles and certificates of many states of one contact, all at once.

As for one state (contacts.py), energy and force are sums over the contact and the free surfaces
beside it. The integrals over the contact are those of g = min f - f and of powers of it, which no
state's depth enters, so that one density serves all of them.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from discretization.certificate import ROUNDING
from discretization.fitted.alone import Alone
from discretization.fitted.many_lines import ManyLines, States
from discretization.fitted.rest_depths import DIFFERENCE, FELT, FLAT, LEAST
from discretization.quadrature import densities, summed_each
from discretization.surfaces import menisci
from discretization.surfaces.menisci import MeniscusSurfaces
from discretization.surfaces.protocol import Surfaces
from energy import Scene, SurfaceEnergies
from energy.arrays import Array, Indices, Mask

_SUMMED = 4 * ROUNDING  # of the sizes of the terms that a result is summed from
_UNDECIDED = 1e-7  # of the size of depths: letting go and turning over at once, as for one state


class ManyFound(NamedTuple):
    """What is known of states (n,); lost: which contact leaves the profile, or surface turns over.

    off_..: what half-width, force and energy may be off by. Without contact all is 0, and there is
    no angle.
    """

    half_width: Array
    force: Array
    energy: Array
    contact_angle: Array
    in_contact: Mask
    stable: Mask
    residual: Array
    off_half_width: Array
    off_force: Array
    off_energy: Array
    lost: Mask

    @classmethod
    def detached(cls, count: int) -> ManyFound:
        """The flat surface without contact."""
        angle, stable = np.full(count, math.nan), np.ones(count, bool)
        width, force, energy, residual, off_width, off_force, off_energy = np.zeros((7, count))
        touching, lost = np.zeros((2, count), bool)
        off = off_width, off_force, off_energy
        return cls(width, force, energy, angle, touching, stable, residual, *off, lost)

    def put(self, own: Indices, other: ManyFound) -> None:
        """Set the states of these numbers."""
        for mine, values in zip(self, other, strict=True):
            mine[own] = values


def solved(alone: Alone, states: States) -> ManyFound:
    """States at all depths, those with surface tension and those without each by themselves."""
    found = ManyFound.detached(states.depth.size)
    tense = states.gamma1 > 0
    for which, lines_of in ((tense, ManyLines.tense), (~tense, ManyLines.slack)):
        own = np.flatnonzero(which)
        if own.size:
            part = states.of(own)
            found.put(own, _of_lines(lines_of(alone, part), part))
    return found


def _of_lines(lines: ManyLines, states: States) -> ManyFound:
    """States with their contact lines brought to rest."""
    alone = lines.alone
    left, right, lost = _both(lines)
    touches = (left < right) | ((left == right) & (lines.goal >= alone.touch))
    touches &= ~lost
    found = ManyFound.detached(states.depth.size)
    own = np.flatnonzero(touches)
    if own.size:
        contacts = ManyContacts(lines.of(own), states.of(own), left[own], right[own])
        found.put(own, contacts.found)
    found.lost[lost] = True

    # Without contact: is the depth beyond that of touching, or the surface about to turn over?
    apart = np.flatnonzero(~(touches | lost))
    size = np.maximum(np.abs(states.depth[apart]), states.separation[apart])
    through = np.maximum(states.depth[apart] - alone.touch, 0.0)
    found.residual[apart] = np.divide(through, size, out=np.zeros_like(size), where=size > 0)
    if alone.scene.slopes == "finite" and not alone.scene.axisymmetric and lines.length.any():
        apex = np.full(apart.size, alone.apex)
        near = apart[np.abs(lines.off(1, apex, apart)) <= _UNDECIDED]
        u = (states.depth[near] - alone.touch) / lines.length[near]
        found.lost[near] = _turned(alone.surfaces, np.zeros(near.size), u)
    return found


def _both(lines: ManyLines) -> tuple[Array, Array, Mask]:
    """Both ends of the contacts, 0 at the axis; and which leave the known profile."""
    right, lost = lines.find(1)
    scene, apex = lines.alone.scene, lines.alone.apex
    if scene.axisymmetric:
        return np.zeros_like(right), right, lost
    if scene.indenter.symmetric and apex == 0:
        return -right, right, lost
    left, gone = lines.find(-1)
    return left, right, lost | gone


def _turned(surfaces: Surfaces, s: Array, u: Array) -> Mask:
    """Which of these surfaces beside lines at s, displaced by u, would turn over."""
    if not u.size or surfaces.energy_and_reaction(1, s, math.inf, u, -u) is not None:
        return np.zeros(u.size, bool)
    if u.size == 1:
        return np.ones(1, bool)
    half = u.size // 2
    parts = (_turned(surfaces, s[own], u[own]) for own in (slice(half), slice(half, None)))
    return np.concatenate(list(parts))


class Beside(NamedTuple):
    """What one line and its free surface contribute to a state (n,), and what judges the line.

    moves: how far the line may be off; off_..: what force and energy are.
    """

    energy: Array
    force: Array
    deficit: Array
    stable: Mask
    residual: Array
    moves: Array
    off_force: Array
    off_energy: Array
    lost: Mask


@dataclass(frozen=True, eq=False)
class ManyContacts:
    """Contacts with lines (n,) at both ends, which rest."""

    lines: ManyLines
    states: States
    left: Array
    right: Array

    @functools.cached_property
    def lone(self) -> Mask:
        """Which contacts are of one point."""
        return self.left == self.right

    @property
    def found(self) -> ManyFound:
        """Energies, forces, angles and what judges the lines."""
        scene = self.lines.alone.scene
        sides = [self._beside(1, self.right)]
        if not scene.axisymmetric:
            mirrored = scene.indenter.symmetric and self.lines.alone.apex == 0
            sides.append(sides[0] if mirrored else self._beside(-1, self.left))
        deficit = np.mean([side.deficit for side in sides], axis=0)
        width = self.right - self.left
        return ManyFound(
            half_width=self.right if scene.axisymmetric else width / 2,
            force=np.sum([side.force for side in sides], axis=0),
            energy=np.sum([side.energy for side in sides], axis=0),
            contact_angle=math.pi - deficit,
            in_contact=np.ones(width.size, bool),
            stable=np.all([side.stable for side in sides], axis=0),
            residual=np.max([side.residual for side in sides], axis=0),
            off_half_width=np.mean([side.moves for side in sides], axis=0) + ROUNDING * width,
            off_force=np.sum([side.off_force for side in sides], axis=0),
            off_energy=np.sum([side.off_energy for side in sides], axis=0),
            lost=np.any([side.lost for side in sides], axis=0),
        )

    def _beside(self, side: int, x: Array) -> Beside:
        """The contact from the apex to a line, and the free surface beyond it."""
        scene, states = self.lines.alone.scene, self.states
        pinned = np.isin(x, scene.indenter.corners)
        if scene.axisymmetric:
            pinned |= x == 0
        rate, stable = self._rate(side, x, pinned)
        residual = self._residual(side, x, pinned)
        energy, force, sizes = self._of_contact(side, x)
        angle, lost = np.full(x.size, math.nan), np.zeros(x.size, bool)
        length = states.length
        g = states.depth - np.asarray(scene.indenter.height(x), float)
        if length.any():
            s, u = x / length, g / length
            stored, pull, lost = self._free_surface(s, u)
            unit = states.gamma1 * scene.measure(length)  # of forces: γ₁, or 2πγ₁l about an axis
            angle = self._deficit(side, x, pinned, s, pull)
            energy, force = energy + unit * length * stored, force + unit * pull
            sizes = sizes + np.array([unit * length * stored, unit * np.abs(pull)])

        # Rounding times the condition of the line, and of the terms of the sums, as for one state.
        with np.errstate(divide="ignore"):
            moves = ROUNDING * self.lines.size / np.abs(rate) + ROUNDING * np.abs(x)
        moves = np.where(pinned, 0.0, moves)
        steep = length * np.abs(np.nan_to_num(np.asarray(scene.indenter.slope(x), float)))
        push = states.stiffness * (np.abs(g) + steep) * scene.measure(np.abs(x))
        moved = np.where(pinned, 0.0, push * np.where(np.isfinite(moves), moves, np.abs(x)))
        off_energy, off_force = _SUMMED * sizes
        return Beside(
            energy, force, angle, stable, residual, moves, off_force + moved, off_energy, lost
        )

    def _of_contact(self, side: int, x: Array) -> tuple[Array, Array, Array]:
        """∫ [k/2 (d - f)² + γ₁ψ(f') - w s(f')] dx and ∫ k (d - f) dx from the apex to x.

        And the sizes of the terms of both (2, n).
        """
        alone, states = self.lines.alone, self.states
        width, g, square, stored, bound = integrals(alone, side, x)
        d, k = states.depth - alone.touch, states.stiffness
        springs = np.array([k / 2 * d * d * width, k * d * g, k / 2 * square])
        surface, adhesion = states.gamma1 * stored, states.work * bound
        energy = springs.sum(axis=0) + surface - adhesion
        size = np.abs(springs).sum(axis=0) + surface + adhesion
        return energy, k * (d * width + g), np.array([size, k * (np.abs(d) * width - g)])

    def _free_surface(self, s: Array, u: Array) -> tuple[Array, Array, Mask]:
        """F and S in units of l and γ₁, and which surfaces turn over or are not resolved."""
        surfaces = self.lines.alone.surfaces
        lost = np.zeros(s.size, bool)
        if isinstance(surfaces, MeniscusSurfaces):
            lost = (s > 0) & (s < menisci.LEAST[1])
        found = surfaces.energy_and_reaction(1, s, math.inf, u, -u)
        if found is None:
            lost |= _turned(surfaces, s, u)
            found = np.full(s.size, math.nan), np.full(s.size, math.nan)
        stored, pull = found
        return stored, pull, lost

    def _deficit(self, side: int, x: Array, pinned: Mask, s: Array, pull: Array) -> Array:
        """π - θ: f'(a-0) + u'(a+0), Eq. (12), or with the angles of these slopes.

        At a corner f' is taken on the contact's side; at a lone tip on the outer side. S is γ₁u',
        or with finite slopes the sine of the inclination, per length of the line.
        """
        scene = self.lines.alone.scene
        own = np.where(pinned, np.where(self.lone, side, -side), 0)
        steep = side * np.asarray(scene.indenter.slope_beside(x, own), float)
        if scene.axisymmetric:
            pull = np.divide(pull, s, out=np.zeros_like(s), where=s > 0)
        if scene.slopes == "small":
            return steep - pull
        return np.asarray(np.arctan(steep) - np.arcsin(np.clip(pull, -1.0, 1.0)))

    def _residual(self, side: int, x: Array, pinned: Mask) -> Array:
        """By how much a depth violates D >= d ahead of a line and D <= d behind, over D's terms.

        Where a line is free both are D.
        """
        lines = self.lines
        own = np.arange(x.size)
        rest = lines.rest_depth(side, x, own)
        off = np.abs(rest - lines.goal)
        held = np.flatnonzero(pinned)
        if held.size:
            ahead = lines.goal[held] - lines.rest_depth(side, x[held], held, 1)
            behind = lines.rest_depth(side, x[held], held, -1) - lines.goal[held]
            behind = np.where(self.lone[held], 0.0, behind)
            off[held] = np.maximum(np.maximum(ahead, behind), 0.0)
        size = lines.size + lines.length * self._steepest(x)
        return np.asarray(off / size)

    def _steepest(self, x: Array) -> Array:
        """|f'| at lines, at corners on either side; with finite slopes the sine of its angle."""
        scene = self.lines.alone.scene
        beside = [-1, 1] if len(scene.indenter.corners) else [0]
        slopes = np.abs([scene.indenter.slope_beside(x, np.full(x.size, b)) for b in beside])
        if scene.slopes == "finite":
            slopes = slopes / np.hypot(1.0, slopes)
        return np.asarray(np.fmax.reduce(slopes))

    def _rate(self, side: int, x: Array, pinned: Mask) -> tuple[Array, Mask]:
        """How D grows outwards of lines, and whether they are stable.

        By a central difference that crosses no corner; without tension D is the height.
        """
        lines, states, scene = self.lines, self.states, self.lines.alone.scene
        if not lines.length.any():
            rate = side * np.asarray(scene.indenter.slope_beside(x, np.zeros(x.size)), float)
            return np.nan_to_num(rate), np.ones(x.size, bool)
        length = states.length
        span = length
        if scene.axisymmetric:
            span = np.minimum(np.maximum(x, LEAST * length), length)
        step = np.maximum(DIFFERENCE * span, FELT * np.spacing(np.abs(x)))
        low, high = x - step, x + step
        corners = np.asarray(scene.indenter.corners, float)
        if corners.size:
            known = np.array([-math.inf, *corners, math.inf])
            before, after = known.searchsorted(x) - 1, known.searchsorted(x, "right")
            low = np.maximum(low, (x + known[before]) / 2)
            high = np.minimum(high, (x + known[after]) / 2)
        low, high = np.clip([low, high], *scene.indenter.extent)
        own = np.arange(x.size)
        rise = lines.rest_depth(side, high, own) - lines.rest_depth(side, low, own)
        rate = side * rise / np.where(high > low, high - low, math.inf)
        height = np.asarray(scene.indenter.height(x), float)
        size = np.abs(states.depth) + np.abs(height) + lines.size
        return rate, np.asarray(pinned | (rate + FLAT * size / span > 0))


def integrals(alone: Alone, side: int, x: Array) -> Array:
    """∫1, ∫g, ∫g², ∫ψ(f') and ∫s(f') (5, n) from the apex to x (n,), of g = min f - f.

    Up to the last corner or knot before x they are sums over the panels between those, which all
    states share.
    """
    unit = _of_unit_tension(alone.scene)
    density = functools.partial(densities, unit, alone.touch)
    smooth = unit.indenter.complete
    breaks = np.unique(unit.indenter.breaks())[::side]
    places = np.append(alone.apex, breaks[side * breaks > side * alone.apex])
    number = np.maximum(np.searchsorted(side * places, side * x) - 1, 0)
    found = summed_each(density, np.sort([places[number], x], axis=0), smooth=smooth)
    last = int(number.max())
    if last:
        panels = np.sort([places[:last], places[1 : last + 1]], axis=0)
        inner = np.cumsum(summed_each(density, panels, smooth=smooth), axis=1)
        found += np.hstack([np.zeros((len(inner), 1)), inner])[:, number]
    return found


def _of_unit_tension(scene: Scene) -> Scene:
    """The scene with γ₁ = 1 and w = 0, whose integrals are multiplied by those of the states."""
    return replace(scene, surfaces=SurfaceEnergies.from_work(1.0, 0.0))
