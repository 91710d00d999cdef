"""Any number of contacts on the fitted mesh: energy and force, certificate and error estimate.

In contact u = d - f is prescribed, so the free surfaces, two tails and the gaps between contacts,
do not feel each other, and energy and force are sums over the contacts and over them.

The conditions of ../certificate.py for lines that move continuously, depths over the largest of |d|
and δ₀, at lines with l |f'| added, a term of D. Of a path, on which depths are only told apart by
TIE of the largest, no less than makes that pass:

    penetration   max (g - u) between the contacts and beyond them, at the samples that resolve the
                  profile and at the extremes between them; and just ahead of every line the
                  surface does not pass through the indenter, D₀ >= d, D₀ that of no adhesion
    stationarity  residual of the free nodes, and of the energy's derivative by the gap
    opening       no corner in contact is torn open, -[f'] <= 2√(2w/γ₁) (or angles); a contact of
                  one point, which does not adhere, is not pulled; where w = 0, neither is
                  any part of a contact, kg + γ₁f'' >= 0; all as forces over kl
    neighbours    every line rests: D >= d just ahead of it with the adhesion of a contact that
                  closes, D <= d just behind with that of one that opens; where a line is free, D
                  grows outwards, of both lines of a gap together
    force         dU/dd against k∫u dx
"""

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np

from discretization.certificate import ROUNDING, Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium
from discretization.fitted.motion import Lines, Motion, free_parts
from discretization.fitted.rest_depths import margins
from discretization.quadrature import Interval, refined
from discretization.surfaces.protocol import Free
from energy import Scene
from energy.arrays import Array, Mask

_ULPS = 4.0  # roundings of its position, within which a line is where it is
_FALLING = 1e-9  # of the steepest change of D: what may be rounding of one that does not change
_FLAT = 1e-7  # of the size of depths over l or a radius: the same next to where D is least
_POSITION = ROUNDING / 4  # of |x|, to which a line is found


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts with these lines, from left to right, at a depth."""

    motion: Motion
    lines: Lines
    depth: float

    @property
    def x(self) -> Array:
        """Ends of each contact (m, 2)."""
        return np.array(self.lines).reshape(-1, 2)

    @property
    def alone(self) -> bool:
        """Whether this is one contact of a convex profile, about an axis around that.

        Beyond it u - g >= 0 if that is not negative at its lines, as u' + f' grows outwards.
        """
        scene, first = self.motion.scene, self.lines[0]
        around = first == 0 or not scene.axisymmetric
        return len(self.lines) == 2 and scene.indenter.convex and around

    @functools.cached_property
    def pinned(self) -> Mask:
        """Lines at corners, at edges of the body, and beside those of a pattern (m, 2)."""
        profile = self.motion.profile
        edges = profile.edges, np.nextafter(profile.edges, -math.inf)
        held = np.concatenate([profile.corners, profile.indenter.walls, *edges])
        return np.isin(self.x, held)

    @functools.cached_property
    def surfaces(self) -> list[Free]:
        """The free surfaces. ValueError if one would turn over."""
        rests = self.motion.rests
        ends = [(rests.at(q), rests.at(p)) for q, p in free_parts(self.lines)]
        return [rests.surfaces.solve(*pair, self.depth) for pair in ends]

    @functools.cached_property
    def rates(self) -> tuple[Array, Mask, Array]:
        """Lines (n, 2) of the free surfaces, which of them are free, the changes of D (n, 2, 2)."""
        rests, lines = self.motion.rests, np.array(free_parts(self.lines))
        held = np.concatenate([[True], self.pinned.ravel(), [True]]).reshape(-1, 2)
        _, rates = rests.with_rates(lines[:, None], rests.between_corners(lines, 1), 1, True)
        assert rates is not None
        return lines, np.isfinite(lines) & ~held, rates[:, 0]

    @functools.cached_property
    def behind(self) -> Array:
        """D just behind the lines of each contact (m, 2), where a contact that opens holds them."""
        rests, (lines, loose, _) = self.motion.rests, self.rates
        return _of_contacts(rests.ahead(lines - _rounding(lines, loose), -1))

    @property
    def neutral(self) -> bool:
        """Whether a line at an edge of the body costs nothing to move inwards."""
        walls = self.motion.profile.indenter.walls
        if not (self.motion.scene.work_of_adhesion and walls):
            return False
        off = np.abs(self.behind - self.depth)[np.isin(self.x, walls) & self.wide]
        return bool((off <= 2 * ROUNDING * self.motion.rests.size).any())

    @property
    def wide(self) -> Mask:
        """Which contacts (m, 1) are more than a point."""
        return self.x[:, :1] < self.x[:, 1:]

    @property
    def pulls(self) -> Array:
        """What the free surfaces pull at both lines of each contact, S (m, 2)."""
        return _of_contacts(np.array([each.pulls for each in self.surfaces]))

    def totals(self) -> Interval:
        """Energy and force."""
        energy, area = np.sum([(each.energy, each.area) for each in self.surfaces], axis=0).tolist()
        pulls = [pull for each in self.surfaces for pull in each.pulls]
        beside = energy, sum(pulls), area, sum(map(abs, pulls))
        return refined(self.motion.scene, self.depth, self.x, beside)


def _of_contacts(values: Array) -> Array:
    """Values at the lines of free surfaces (n, 2), for those of each contact (n - 1, 2)."""
    return values.ravel()[1:-1].reshape(-1, 2)


def equilibrium(lines: Array, found: Interval, **given: Any) -> Equilibrium:
    """The state of contacts with these lines (m, 2), energy and force; given: the rest of it."""
    return Equilibrium(
        contacts=lines,
        nodes=lines,
        force=found.force,
        energy=found.energy,
        scales={"force": found.force_scale, "energy": found.energy_scale},
        method="fitted",
        spacing=math.nan,
        **given,
    )


def estimated(
    scene: Scene, depth: float, lines: Array, moves: Array, found: Interval
) -> dict[str, float]:
    """Errors of half-width, force and energy: of the quadrature, the lines, and rounding.

    moves: how far lines (m, 2) may be off.
    """
    (energy, force), width = found.errors, np.diff(lines, axis=1).sum()
    off = moves > 0
    force += float(push(scene, depth, lines[off]) @ moves[off])
    parts = (
        moves.sum() / width + ROUNDING if width else 0.0,
        force / (found.force_scale or 1.0) + 4 * ROUNDING,
        energy / (found.energy_scale or 1.0) + 4 * ROUNDING,
    )
    return dict(zip(QUANTITIES, map(float, parts), strict=True))


def push(scene: Scene, depth: float, x: Array) -> Array:
    """A bound of |dP/dq| of lines: k|g| + k l |f'|."""
    g, slope = depth - scene.indenter.height(x), scene.indenter.slope(x)
    felt = np.abs(g) + scene.elastocapillary_length * np.abs(slope)
    return np.asarray(scene.stiffness * felt * scene.measure(x))


def certify(contacts: Contacts, found: Interval) -> Certificate:
    """Judge contacts with these totals."""
    scene, depth = contacts.motion.scene, contacts.depth
    scale = contacts.motion.rests.displacement_scale(depth)
    if scale * scene.elastocapillary_length == 0:
        return Certificate.undeformed()
    through, gain = _at_lines(contacts)
    size = scale + _steepest(contacts)  # of the terms that cancel in D
    beyond = 0.0
    if not contacts.alone:
        beyond = contacts.motion.penetration(contacts.lines, depth)
    return Certificate(
        penetration=max(0.0, through / size, beyond / scale),
        stationarity=max(each.residual for each in contacts.surfaces),
        opening=_tension(contacts, scale),
        neighbours=max(0.0, gain / size, _unstable(contacts)),
        force=abs(found.force - found.force_by_field) / (found.force_scale or 1.0),
    )


def _steepest(contacts: Contacts) -> float:
    """l |f'| at the lines, with finite slopes l |sin β| [length]."""
    scene, profile = contacts.motion.scene, contacts.motion.profile
    slopes = np.array([profile.beside(contacts.x.ravel(), side)[1] for side in (-1, 1)])
    if scene.slopes == "finite":
        slopes = slopes / np.hypot(1.0, slopes)
    return scene.elastocapillary_length * float(np.abs(slopes).max())


def _at_lines(contacts: Contacts) -> tuple[float, float]:
    """By how much the depth passes what the lines rest at: without and with adhesion [length]."""
    rests, depth = contacts.motion.rests, contacts.depth
    lines, loose, _ = contacts.rates
    beyond, noise = lines + _rounding(lines, loose), rests.noise(lines)
    closing = depth - float((rests.ahead(beyond, 1) + noise[:, None]).min())
    through = closing  # no more than that
    if closing > ROUNDING * rests.size:
        through = depth - float((rests.ahead(beyond, 1, adhesive=False) + noise[:, None]).min())
    opening = contacts.behind - depth - _of_contacts(np.repeat(noise, 2))
    return through, max(closing, float(opening[contacts.wide[:, 0]].max(initial=-math.inf)))


def _rounding(lines: Array, loose: Mask) -> Array:
    """How far outwards of contacts a free line (n, 2) may be off by rounding."""
    with np.errstate(invalid="ignore"):
        return np.where(loose, _ULPS * np.spacing(np.abs(lines)), 0.0) * (1, -1)


def _unstable(contacts: Contacts) -> float:
    """1 where D falls outwards of a free line, or of both of a gap together; else 0.

    Where D is least the line of a lone contact is found to the root of its rounding, where D
    changes by _FLAT.
    """
    scene, (lines, loose, rates) = contacts.motion.scene, contacts.rates
    if scene.hysteretic or not scene.work_of_adhesion:
        return 0.0  # held by another work of adhesion than what moves it; or the energy is convex
    steepest = np.abs(rates).max(axis=(1, 2))
    span = np.full(steepest.shape, scene.elastocapillary_length)
    if scene.axisymmetric:
        radius = np.where(loose, lines, 0.0).max(axis=1)
        span = np.where(radius > 0, np.minimum(radius, span), span)
    slack = _FALLING * steepest
    if contacts.alone:
        slack = np.maximum(slack, _FLAT * contacts.motion.rests.size / span)
    aside = np.diag([1, -1]) * slack[:, None, None]
    with np.errstate(over="ignore"):
        stable = margins(rates[:, None], loose)[0] | margins((rates + aside)[:, None], loose)[0]
    return 0.0 if stable.all() else 1.0


def _tension(contacts: Contacts, scale: float) -> float:
    """Largest force that would open a contact, over kδl."""
    motion, scene, x = contacts.motion, contacts.motion.scene, contacts.x
    unit, corners = scene.stiffness * scene.elastocapillary_length, motion.profile.corners
    inside = np.searchsorted(x.ravel(), corners) & np.searchsorted(x.ravel(), corners, "right")
    over = (motion.profile.falls(scene.slopes) - motion.holds(corners))[inside % 2 == 1]
    lone = ~contacts.wide[:, 0] & (scene.measure(x[:, 0]) > 0)
    pulls = contacts.pulls.sum(axis=1)[lone] / scene.measure(x[lone, 0])
    bare = (motion.search.pull(*part, contacts.depth).force for part in motion.bare(x))
    worst = max([0.0, *(scene.gamma1 * over), *-pulls, *(unit * force for force in bare)])
    return float(worst) / (unit * scale)


def errors(contacts: Contacts, found: Interval) -> dict[str, float]:
    """Errors of rounding times the condition of the lines, and of the quadrature."""
    rests, scene = contacts.motion.rests, contacts.motion.scene
    lines, free, rates = contacts.rates
    own = np.where(free[:, :, None] & free[:, None], rates, 0.0)
    off = ROUNDING * rests.size + found.rounding
    place = _POSITION * np.where(free, np.abs(lines), 0.0)
    moves = _of_contacts(np.abs(np.linalg.pinv(own)).sum(axis=2) * off + place)
    return estimated(scene, contacts.depth, contacts.x, moves, found)
