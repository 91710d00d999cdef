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
from discretization.fitted.rest_depths import GROWING, MOVES, SIDES, solved, stable
from discretization.quadrature import Interval, refined
from discretization.surfaces.protocol import Free
from energy import Scene
from energy.arrays import Array, Mask

_ULPS = 4.0  # roundings of its position, within which a line is where it is
_PLACES = np.array(  # where D of a line judges it: on its outer or inner side, way, adhesion
    [[1, 1, -1, 0, 0, 0, 0], [1, 1, -1, 1, 1, 1, 1], [1, 0, 1, 1, 1, 1, 1]]
)[..., None, None]
_SIGNS = np.array([[[1, 1], [1, -1]]])  # of what D of both lines is off by
_FALLING = 1e-9  # of the steepest change of D: what may be rounding of one that does not change
_FLAT = 1e-7  # of the size of depths over l or a radius: the same next to where D is least
_POSITION = ROUNDING / 4  # of |x|, to which a line is found


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts with these lines, from left to right, at a depth."""

    motion: Motion
    lines: Lines
    depth: float

    @functools.cached_property
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
        return np.isin(self.x, held) if held.size else np.zeros(self.x.shape, bool)

    @functools.cached_property
    def surfaces(self) -> list[Free]:
        """The free surfaces. ValueError if one would turn over."""
        rests = self.motion.rests
        ends = [(rests.at(q), rests.at(p)) for q, p in free_parts(self.lines)]
        return [rests.surfaces.solve(*pair, self.depth) for pair in ends]

    @functools.cached_property
    def felt(self) -> tuple[Array, Mask, Array, Array]:
        """Lines (n, 2) of the free surfaces, which are free, D there (3, n, 2), its changes.

        D just ahead of a contact that closes, the same without adhesion, and behind one that opens,
        of free lines off by their rounding; changes (n, 2, 2) with both lines.
        """
        rests, lines = self.motion.rests, np.array(free_parts(self.lines))
        if rests.scene.axisymmetric and not self.lines[0]:
            lines[0, 1] = math.inf  # a contact around the axis has no line there
        held = np.concatenate([[True], self.pinned.ravel(), [True]]).reshape(-1, 2)
        loose = np.isfinite(lines) & ~held
        last = (5 if len(lines) > 2 else 3) if loose.any() else 1
        with np.errstate(invalid="ignore"):
            off = np.where(loose, _ULPS * np.spacing(np.abs(lines)), 0.0) * SIDES
            z = rests.moved(lines, rests.between_corners(lines, 1)) if last > 1 else lines[None]
        near = np.concatenate([[lines - off, lines + off], z])
        own, other = (near[[1, 1, 0, *(2 + k for k in part[1:last])]] for part in MOVES)
        depths = rests.beside(SIDES, own, other[..., ::-1], *_PLACES[:, : len(own)])
        rates = rests.changes(depths[2:], z) if last > 1 else np.zeros((*lines.shape, 2))
        return lines, loose, depths[:3], np.where(np.isfinite(rates), rates, 0.0)

    @property
    def neutral(self) -> bool:
        """Whether a line at an edge of the body costs nothing to move inwards."""
        walls = self.motion.profile.indenter.walls
        if not (self.motion.scene.work_of_adhesion and walls):
            return False
        off = np.abs(_of_contacts(self.felt[2][2]) - self.depth)[np.isin(self.x, walls) & self.wide]
        return bool((off <= 2 * ROUNDING * self.motion.rests.size).any())

    @property
    def wide(self) -> Mask:
        """Which contacts (m, 1) are more than a point."""
        return self.x[:, :1] < self.x[:, 1:]

    def totals(self) -> Interval:
        """Energy and force."""
        return refined(self.motion.scene, self.depth, self.x, self.surfaces)


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
    (energy, force), width = found.errors, (lines[:, 1] - lines[:, 0]).sum()
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
    beyond = 0.0 if contacts.alone else contacts.motion.penetration(contacts.lines, depth)
    return Certificate(
        penetration=max(0.0, through / size, beyond / scale),
        stationarity=max(each.residual for each in contacts.surfaces),
        opening=_tension(contacts, scale),
        neighbours=max(0.0, gain / size, _unstable(contacts)),
        force=abs(found.force - found.force_by_field) / (found.force_scale or 1.0),
    )


def _steepest(contacts: Contacts) -> float:
    """l |f'| at the lines, with finite slopes l |sin β| [length]."""
    scene = contacts.motion.scene
    _, slopes = contacts.motion.profile.beside(contacts.x[..., None], (-1, 1))
    if scene.slopes == "finite":
        slopes = slopes / np.hypot(1.0, slopes)
    return scene.elastocapillary_length * float(np.abs(slopes).max())


def _at_lines(contacts: Contacts) -> tuple[float, float]:
    """By how much the depth passes what the lines rest at: without and with adhesion [length]."""
    rests, depth, (lines, _, felt, _) = contacts.motion.rests, contacts.depth, contacts.felt
    noise = rests.noise(lines)[:, None]
    closing, bare = (depth - (felt[:2] + noise).min(axis=(1, 2))).tolist()
    through = bare if closing > ROUNDING * rests.size else closing  # no more than that
    behind = np.where(np.isfinite(lines), felt[2], -math.inf)
    opening = _of_contacts(behind - depth - noise)[contacts.wide[:, 0]]
    return through, max(closing, float(opening.max(initial=-math.inf)))


def _unstable(contacts: Contacts) -> float:
    """1 where D falls outwards of a free line, or of both of a gap together; else 0.

    Where D is least the line of a lone contact is found to the root of its rounding, where D
    changes by _FLAT.
    """
    scene, (lines, loose, _, rates) = contacts.motion.scene, contacts.felt
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
    aside = GROWING * slack[:, None, None]
    with np.errstate(over="ignore"):
        return 0.0 if stable((rates + aside)[:, None], loose).all() else 1.0


def _tension(contacts: Contacts, scale: float) -> float:
    """Largest force that would open a contact, over kδl."""
    motion, scene, x = contacts.motion, contacts.motion.scene, contacts.x
    unit, corners = scene.stiffness * scene.elastocapillary_length, motion.profile.corners
    forces = [unit * motion.search.pull(*part, contacts.depth).force for part in motion.bare(x)]
    if corners.size and not scene.indenter.convex:
        inside = np.searchsorted(x.ravel(), corners) & np.searchsorted(x.ravel(), corners, "right")
        over = motion.profile.falls(scene.slopes) - motion.holds(corners)
        forces += (scene.gamma1 * over[inside % 2 == 1]).tolist()
    if not contacts.wide.all():
        lone = ~contacts.wide[:, 0] & (scene.measure(x[:, 0]) > 0)
        pulls = _of_contacts(np.array([each.pulls for each in contacts.surfaces])).sum(axis=1)
        forces += (-pulls[lone] / scene.measure(x[lone, 0])).tolist()
    return max([0.0, *forces]) / (unit * scale)


def errors(contacts: Contacts, found: Interval) -> dict[str, float]:
    """Errors of rounding times the condition of the lines, and of the quadrature."""
    rests, scene = contacts.motion.rests, contacts.motion.scene
    lines, free, _, rates = contacts.felt
    off = ROUNDING * rests.size + found.rounding
    place = _POSITION * np.where(free, np.abs(lines), 0.0)
    moved = np.abs(solved(rates[:, None], off * _SIGNS, free)).max(axis=1)
    moves = _of_contacts(moved + place)
    return estimated(scene, contacts.depth, contacts.x, moves, found)
