"""Energies, forces, angles and certificates of many states of one contact, all at once.

As for one state (contacts.py), energy and force are sums over the contact and the free surfaces
beside it. The integrals over the contact are those of g = min f - f and of powers of it, which no
state's depth enters, so that one density serves all of them.

Conventions
-----------
The depth d, the rest depth D and the displacement u of the surface are positive down into the
layer, heights f of the profile upwards [length]. Forces P are positive where the indenter is
pressed. For a line contact energy and force count per length of it; about an axis x is the radius,
and integrals have the weight 2πx (`Scene.measure`).

Arrays (n,) have one entry a state. `side` is 1 for the right line of a contact and -1 for the left
one; outwards is the direction `side` along x. `ManyLines.rest_depth` is D at given places, with
`beside` 1 just outwards of the contact, -1 just inwards; `ManyLines.goal` is the depth at which a
line would rest, that of the state where there is tension; `ManyLines.off` is (D - goal)/size.
`energy_and_reaction(side, s, width, u, rise)` of free surfaces at lines at s, displaced by u, is
their energy F and what they pull at the line, S = ∂F/∂u, in units of l and γ₁; None if one would
turn over. Tails have an infinite width, and as they end at displacement 0 the rise from the line is
-u; a left line has its mirror image's.

`ManyLines.tense` and `ManyLines.slack` are the lines of states with and without surface tension,
`States` what differs between the states: the depth, w (`work`), γ₁ and k, with l and δ₀ (`length`,
`separation`). `densities` are integrands of ∫1, ∫g, ∫g², ∫γ₁ψ(f') and ∫s(f'), and `summed_each`
integrates them over panels, each to rounding of itself. Of the indenter, `breaks()` are the places
between which f is smooth, `complete` is whether these are all, `extent` are the ends of the known
profile, and `slope_beside(x, side)` is f' just on the right (1) or left (-1) of x, or at x (0).
`MeniscusSurfaces` are free surfaces about an axis with finite slopes, known outside of radii of at
least LEAST_RADIUS[1] times l. ROUNDING is 16 times 2⁻⁵²; UNDECIDED and FLAT say, over the size of
depths, how near to the loss of contact a surface may turn over, and what is rounding of l dD/dx.
DIFFERENCES has the steps of central differences: a part of the length over which D varies,
`least_radius` of l about an axis, `least_ulps` roundings at least.

`SurfaceEnergies.from_work(γ₁, w)` are surface energies with this tension and this work of adhesion.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from discretization.certificate import ROUNDING
from discretization.fitted.many_lines import ManyLines, States
from discretization.fitted.rest_depths import DIFFERENCES, FLAT
from discretization.fitted.single_contact import UNDECIDED, SingleContact
from discretization.quadrature import densities, summed_each
from discretization.surfaces import menisci
from discretization.surfaces.menisci import MeniscusSurfaces
from discretization.surfaces.protocol import Surfaces
from energy import Scene, SurfaceEnergies
from energy.arrays import Array, Indices, Mask

# Of the sizes of the terms that a result is summed from: of the integrals and their sum.
_SUMMED = 4 * ROUNDING  # 64 roundings of a double: it enters `uncertainty` alone


class ManyStates(NamedTuple):
    """Many states as arrays; without contact all is 0, and there is no angle.

    Attributes
    ----------
    half_width : ndarray (n,)
        Half of the width of the contact, or its radius [length].
    force, energy : ndarray (n,)
        P, positive where pressed, and U, 0 for the undeformed surface without contact [force and
        energy, or these per length of a line contact].
    contact_angle : ndarray (n,)
        θ [rad], of both lines the mean; nan without contact.
    in_contact : ndarray of bool (n,)
    stable : ndarray of bool (n,)
        Whether D grows outwards of the lines; True without contact.
    residual : ndarray (n,)
        The largest violation of D = d (of D >= d ahead and D <= d behind of pinned lines), or
        without contact the penetration, over the size of depths.
    off_half_width, off_force, off_energy : ndarray (n,)
        What half-width, force and energy may be off by, in their units.
    lost : ndarray of bool (n,)
        Whose contact leaves the known profile, or whose surface turns over.
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
    def detached(cls, count: int) -> ManyStates:
        """This many states of the flat surface without contact."""
        return cls(
            half_width=np.zeros(count),
            force=np.zeros(count),
            energy=np.zeros(count),
            contact_angle=np.full(count, math.nan),
            in_contact=np.zeros(count, bool),
            stable=np.ones(count, bool),
            residual=np.zeros(count),
            off_half_width=np.zeros(count),
            off_force=np.zeros(count),
            off_energy=np.zeros(count),
            lost=np.zeros(count, bool),
        )

    def put(self, own: Indices, other: ManyStates) -> None:
        """Set the states of these numbers."""
        for mine, values in zip(self, other, strict=True):
            mine[own] = values


def solved(contact: SingleContact, states: States) -> ManyStates:
    """States at all depths, those with surface tension and those without each by themselves.

    Parameters
    ----------
    contact : SingleContact
        The contact of the scene that they share.
    states : States

    Returns
    -------
    ManyStates
    """
    found = ManyStates.detached(states.depth.size)
    tense = states.gamma1 > 0
    for which, lines_of in ((tense, ManyLines.tense), (~tense, ManyLines.slack)):
        own = np.flatnonzero(which)
        if own.size:
            part = states.of(own)
            found.put(own, _of_lines(lines_of(contact, part), part))
    return found


def _of_lines(lines: ManyLines, states: States) -> ManyStates:
    """The states to which these lines belong, once the lines have been brought to rest.

    Lines that have crossed, or are nowhere (nan), mean no contact. So do lines that meet below the
    depth of touching; at or above it they are a contact of one point.
    """
    contact = lines.contact
    left, right, lost = _both(lines)
    touches = (left < right) | ((left == right) & (lines.goal >= contact.touch))
    touches &= ~lost
    found = ManyStates.detached(states.depth.size)
    own = np.flatnonzero(touches)
    if own.size:
        contacts = ManyContacts(lines.of(own), states.of(own), left[own], right[own])
        found.put(own, contacts.found)
    found.lost[lost] = True

    detached_states = np.flatnonzero(~(touches | lost))
    found.residual[detached_states] = _penetration(contact, states, detached_states)
    if contact.scene.slopes == "finite" and not contact.scene.axisymmetric and lines.length.any():
        # So near to the depth at which contact is lost a state without it is only known to be the
        # state if the surface beside a contact there would not turn over.
        apex = np.full(detached_states.size, contact.apex)
        at_loss = detached_states[np.abs(lines.off(1, apex, detached_states)) <= UNDECIDED]
        u = (states.depth[at_loss] - contact.touch) / lines.length[at_loss]
        found.lost[at_loss] = _turned(contact.surfaces, np.zeros(at_loss.size), u)
    return found


def _penetration(contact: SingleContact, states: States, detached_states: Indices) -> Array:
    """How far the profile sticks through the flat surface, over max(|d|, δ₀) of each state."""
    size = np.maximum(np.abs(states.depth[detached_states]), states.separation[detached_states])
    through = np.maximum(states.depth[detached_states] - contact.touch, 0.0)
    return np.divide(through, size, out=np.zeros_like(size), where=size > 0)


def _both(lines: ManyLines) -> tuple[Array, Array, Mask]:
    """Both ends of the contacts [length], and which leave the known profile.

    A left end about an axis is 0; ends where no line rests are nan.
    """
    right, lost = lines.find(1)
    scene = lines.contact.scene
    apex = lines.contact.apex
    if scene.axisymmetric:
        return np.zeros_like(right), right, lost
    if scene.indenter.symmetric and apex == 0:
        return -right, right, lost
    left, gone = lines.find(-1)
    return left, right, lost | gone


def _turned(surfaces: Surfaces, s: Array, u: Array) -> Mask:
    """Which of these surfaces beside lines at s, displaced by u, would turn over; in units of l.

    The solver only says whether one of several does, so they are halved until that is clear.
    """
    if not u.size or surfaces.energy_and_reaction(1, s, math.inf, u, -u) is not None:
        return np.zeros(u.size, bool)
    if u.size == 1:
        return np.ones(1, bool)
    half = u.size // 2
    first = _turned(surfaces, s[:half], u[:half])
    second = _turned(surfaces, s[half:], u[half:])
    return np.concatenate([first, second])


class Contribution(NamedTuple):
    """What one line of every state contributes to it, with the contact and the surface beside it.

    Attributes
    ----------
    energy, force : ndarray (n,)
        U and P of the contact from the apex to the line, and of the surface beyond it.
    deficit : ndarray (n,)
        π - θ [rad]; nan without tension.
    stable : ndarray of bool (n,)
        Whether D grows outwards of the line, or it is pinned.
    residual : ndarray (n,)
        By how much D violates the condition of the line, over the size of depths.
    moves : ndarray (n,)
        How far the line may be off [length].
    off_force, off_energy : ndarray (n,)
        What force and energy may be off by, in their units.
    lost : ndarray of bool (n,)
        Whose surface turns over or is not resolved.
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


class _ContactSums(NamedTuple):
    """Sums over one half of each contact, from the apex to a line; arrays (n,).

    Attributes
    ----------
    energy, force : ndarray (n,)
        ∫ [k/2 (d - f)² + γ₁ψ(f') - w s(f')] dx and ∫ k (d - f) dx.
    energy_size, force_size : ndarray (n,)
        Sums of the absolute values of the terms of both, of which rounding is a part.
    """

    energy: Array
    force: Array
    energy_size: Array
    force_size: Array


@dataclass(frozen=True, eq=False)
class ManyContacts:
    """Contacts of many states, whose lines rest.

    Attributes
    ----------
    lines : ManyLines
        What gives D of the lines of the states.
    states : States
        Depths and materials.
    left, right : ndarray (n,)
        Both ends of the contacts; about an axis 0 and the radius [length].
    """

    lines: ManyLines
    states: States
    left: Array
    right: Array

    @functools.cached_property
    def pointed(self) -> Mask:
        """Which contacts are of one point."""
        return self.left == self.right

    @property
    def found(self) -> ManyStates:
        """The states: sums of what both lines contribute, or of twice that of the right one."""
        scene = self.lines.contact.scene
        sides = [self._contribution(1, self.right)]
        if not scene.axisymmetric:
            mirrored = scene.indenter.symmetric and self.lines.contact.apex == 0
            sides.append(sides[0] if mirrored else self._contribution(-1, self.left))
        deficit = np.mean([side.deficit for side in sides], axis=0)
        width = self.right - self.left
        return ManyStates(
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

    def _contribution(self, side: int, x: Array) -> Contribution:
        """The contact from the apex to the line at x on this side, and the surface beyond it."""
        scene = self.lines.contact.scene
        states = self.states
        length = states.length
        pinned = np.isin(x, scene.indenter.corners)
        if scene.axisymmetric:
            pinned |= x == 0
        rate, stable = self._rate(side, x, pinned)
        energy, force, energy_size, force_size = self._of_contact(side, x)  # of _ContactSums
        deficit = np.full(x.size, math.nan)
        lost = np.zeros(x.size, bool)
        if length.any():
            s = x / length
            u = self._displacement(x) / length
            stored, pull, lost = self._free_surface(s, u)
            deficit = self._deficit(side, x, pinned, s, pull)
            unit = states.gamma1 * scene.measure(length)  # of forces: γ₁, or 2πγ₁l about an axis
            surface_energy = unit * length * stored
            energy = energy + surface_energy
            force = force + unit * pull
            energy_size = energy_size + surface_energy
            force_size = force_size + unit * np.abs(pull)
        moves = self._moves(x, pinned, rate)
        return Contribution(
            energy,
            force,
            deficit,
            stable,
            self._residual(side, x, pinned),
            moves,
            off_force=_SUMMED * force_size + self._force_error(x, pinned, moves),
            off_energy=_SUMMED * energy_size,
            lost=lost,
        )

    def _displacement(self, x: Array) -> Array:
        """d - f at lines at x: the displacement u of the surface there [length]."""
        return self.states.depth - np.asarray(self.lines.contact.scene.indenter.height(x), float)

    def _moves(self, x: Array, pinned: Mask, rate: Array) -> Array:
        """How far lines at x may be off: rounding times their condition, as for one state.

        rate: dD/dx outwards. Pinned lines are where they are.
        """
        with np.errstate(divide="ignore"):
            moves = ROUNDING * self.lines.size / np.abs(rate) + ROUNDING * np.abs(x)
        return np.where(pinned, 0.0, moves)

    def _force_error(self, x: Array, pinned: Mask, moves: Array) -> Array:
        """What forces may be off by because lines at x may be off by `moves`.

        That is |dP/dx| times it, at most (k|g| + k l |f'|) with g = d - f, times 2πx about an axis.
        A line without a condition, whose `moves` is inf, may be as far off as it is from the apex
        at 0.
        """
        scene = self.lines.contact.scene
        slope = np.nan_to_num(np.asarray(scene.indenter.slope(x), float))
        slope_term = self.states.length * np.abs(slope)
        displacement = np.abs(self._displacement(x)) + slope_term
        push = self.states.stiffness * displacement * scene.measure(np.abs(x))
        return np.where(pinned, 0.0, push * np.where(np.isfinite(moves), moves, np.abs(x)))

    def _of_contact(self, side: int, x: Array) -> _ContactSums:
        """Sums over the contacts from the apex to lines at x.

        With d - f = (d - min f) + g, g = min f - f <= 0, they are combinations of integrals of g
        and g² that do not depend on the state.
        """
        states = self.states
        k = states.stiffness
        width, g, square, stretched, area = integrals(self.lines.contact, side, x)
        d = states.depth - self.lines.contact.touch  # counted from first touch
        springs = np.array([k / 2 * d * d * width, k * d * g, k / 2 * square])
        surface = states.gamma1 * stretched
        adhesion = states.work * area
        energy = springs.sum(axis=0) + surface - adhesion
        energy_size = np.abs(springs).sum(axis=0) + surface + adhesion
        force = k * (d * width + g)
        force_size = k * (np.abs(d) * width - g)
        return _ContactSums(energy, force, energy_size, force_size)

    def _free_surface(self, s: Array, u: Array) -> tuple[Array, Array, Mask]:
        """F and S in units of l and γ₁, and which surfaces turn over or are not resolved.

        s, u: positions of lines and displacements there, over l. A meniscus about a radius too
        small for its mesh is not resolved. Where one surface turns over, all F and S are nan.
        """
        surfaces = self.lines.contact.surfaces
        lost = np.zeros(s.size, bool)
        if isinstance(surfaces, MeniscusSurfaces):
            lost = (s > 0) & (s < menisci.LEAST_RADIUS[1])
        found = surfaces.energy_and_reaction(1, s, math.inf, u, -u)
        if found is None:
            lost |= _turned(surfaces, s, u)
            found = (np.full(s.size, math.nan), np.full(s.size, math.nan))
        stored, pull = found
        return stored, pull, lost

    def _deficit(self, side: int, x: Array, pinned: Mask, s: Array, pull: Array) -> Array:
        """π - θ: f'(a-0) + u'(a+0), Eq. (12), or with the angles of these slopes.

        At a corner f' is taken on the contact's side, at a contact of one point on the outer side.
        `pull` is S: -γ₁u', or with finite slopes -γ₁ times the sine of the inclination, per length
        of the line, in units of γ₁; about an axis it is that times s, the radius over l.
        """
        scene = self.lines.contact.scene
        read_on = np.where(pinned, np.where(self.pointed, side, -side), 0)  # 1 right, -1 left of x
        outward_slope = side * np.asarray(scene.indenter.slope_beside(x, read_on), float)
        if scene.axisymmetric:
            pull = np.divide(pull, s, out=np.zeros_like(s), where=s > 0)
        if scene.slopes == "small":
            return outward_slope - pull
        return np.asarray(np.arctan(outward_slope) - np.arcsin(np.clip(pull, -1.0, 1.0)))

    def _residual(self, side: int, x: Array, pinned: Mask) -> Array:
        """By how much a depth violates D >= d ahead of a line and D <= d behind, over D's terms.

        Of a free line both are D, so it is |D - d|. A contact of one point cannot recede further.

        side: 1 for right lines; x: their positions (n,) [length]; pinned: which are at a corner, or
        at the axis.
        """
        lines = self.lines
        own = np.arange(x.size)
        rest = lines.rest_depth(side, x, own)
        off = np.abs(rest - lines.goal)
        pinned_lines = np.flatnonzero(pinned)
        if pinned_lines.size:
            at = x[pinned_lines]
            goal = lines.goal[pinned_lines]
            ahead = goal - lines.rest_depth(side, at, pinned_lines, 1)
            behind = lines.rest_depth(side, at, pinned_lines, -1) - goal
            behind = np.where(self.pointed[pinned_lines], 0.0, behind)
            off[pinned_lines] = np.maximum(np.maximum(ahead, behind), 0.0)
        size = lines.size + lines.length * self._steepest(x)  # with l |f'|, a term of D
        return np.asarray(off / size)

    def _steepest(self, x: Array) -> Array:
        """|f'| at lines, at corners on either side; with finite slopes the sine of its angle."""
        scene = self.lines.contact.scene
        sides = [-1, 1] if len(scene.indenter.corners) else [0]
        beside = [scene.indenter.slope_beside(x, np.full(x.size, side)) for side in sides]
        slopes = np.abs(beside)
        if scene.slopes == "finite":
            slopes = slopes / np.hypot(1.0, slopes)
        return np.asarray(np.fmax.reduce(slopes))

    def _rate(self, side: int, x: Array, pinned: Mask) -> tuple[Array, Mask]:
        """dD/dx outwards of lines at x, and whether they are stable.

        It is a central difference that crosses no corner; without tension D is the height of the
        profile. It may be negative by what rounding makes of it where D is least.

        side: 1 for right lines; pinned: which are at a corner, or at the axis: these count as
        stable.
        """
        lines = self.lines
        scene = lines.contact.scene
        if not lines.length.any():
            rate = side * np.asarray(scene.indenter.slope_beside(x, np.zeros(x.size)), float)
            return np.nan_to_num(rate), np.ones(x.size, bool)
        span = self.states.length
        if scene.axisymmetric:
            span = np.minimum(np.maximum(x, DIFFERENCES.least_radius * span), span)
        low, high = self._difference(x, span)
        own = np.arange(x.size)
        rise = lines.rest_depth(side, high, own) - lines.rest_depth(side, low, own)
        rate = side * rise / np.where(high > low, high - low, math.inf)
        height = np.asarray(scene.indenter.height(x), float)
        size = np.abs(self.states.depth) + np.abs(height) + lines.size
        return rate, np.asarray(pinned | (rate + FLAT * size / span > 0))

    def _difference(self, x: Array, span: Array) -> tuple[Array, Array]:
        """Places on the left and on the right of lines at x, for a central difference of D.

        They are a step away, but at most half of the distance to a corner, and inside the known
        profile. span: the length over which D varies [length].
        """
        indenter = self.lines.contact.scene.indenter
        step = np.maximum(DIFFERENCES.step * span, DIFFERENCES.least_ulps * np.spacing(np.abs(x)))
        low = x - step
        high = x + step
        corners = np.asarray(indenter.corners, float)
        if corners.size:
            known = np.array([-math.inf, *corners, math.inf])
            before = known[known.searchsorted(x) - 1]
            after = known[known.searchsorted(x, "right")]
            low = np.maximum(low, (x + before) / 2)
            high = np.minimum(high, (x + after) / 2)
        return np.clip(low, *indenter.extent), np.clip(high, *indenter.extent)


def integrals(contact: SingleContact, side: int, x: Array) -> Array:
    """∫1, ∫g, ∫g², ∫ψ(f') and ∫s(f') from the apex to lines, of g = min f - f.

    Up to the last corner or knot before x they are sums over the panels between those, which all
    states share. About an axis the integrals have the weight 2πx.

    Parameters
    ----------
    contact : SingleContact
    side : {1, -1}
        1 for right lines.
    x : ndarray (n,)
        [length].

    Returns
    -------
    ndarray (5, n)
        One row for each integral, in the order above. ψ(f') = f'²/2 is by how much the surface is
        stretched and s = 1 the part of it that adheres, with finite slopes √(1+f'²) - 1 and
        √(1+f'²), both per dx.
    """
    unit = _of_unit_tension(contact.scene)
    density = functools.partial(densities, unit, contact.touch)
    smooth = unit.indenter.complete
    breaks = np.unique(unit.indenter.breaks())[::side]
    places = np.append(contact.apex, breaks[side * breaks > side * contact.apex])
    number = np.maximum(np.searchsorted(side * places, side * x) - 1, 0)
    # From the last break before each line to the line; then all panels before that break.
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
