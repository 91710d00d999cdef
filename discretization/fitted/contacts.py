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

import numpy as np

from discretization.certificate import ROUNDING, Certificate
from discretization.equilibrium import QUANTITIES
from discretization.fitted.alone import Alone
from discretization.fitted.motion import Lines, Motion
from discretization.fitted.rest_depths import displacement_scale
from discretization.quadrature import Interval, refined
from discretization.surfaces.protocol import At, Felt, Free
from energy import Scene
from energy.arrays import Array, Mask

_POSITION = ROUNDING / 4  # of |x|, to which a line is found


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts with these lines, from left to right, at a depth; motion: what knows their lines.

    size: of the terms that cancel in D - d.
    """

    motion: Motion | Alone
    lines: Lines
    depth: float

    @functools.cached_property
    def x(self) -> Array:
        """Ends of each contact (m, 2)."""
        return np.array(self.lines).reshape(-1, 2)

    @functools.cached_property
    def pinned(self) -> Mask:
        """Which lines are held, as the end at an axis is (m, 2)."""
        held = [not line.free for line in self.felt]
        return np.array([True] * (self.x.size - len(held)) + held).reshape(-1, 2)

    @functools.cached_property
    def surfaces(self) -> list[Free]:
        """The free surfaces. ValueError if one would turn over."""
        f = np.asarray(self.motion.scene.indenter.height(self.x), float)
        lines = [None, *map(At, self.lines, f.ravel().tolist()), None]
        solve = self.motion.surfaces.solve
        return [solve(*pair, self.depth) for pair in zip(lines[::2], lines[1::2], strict=True)]

    @functools.cached_property
    def felt(self) -> list[Felt]:
        """What judges the lines."""
        return self.motion.felt(self.lines, self.depth)

    size = property(lambda self: max(line.size for line in self.felt))

    @property
    def neutral(self) -> bool:
        """Whether a line at an edge of the body costs nothing to move inwards."""
        walls = self.motion.scene.indenter.walls
        if not (self.motion.scene.work_of_adhesion and walls):
            return False
        off = (abs(line.opening - self.depth) for line in self.felt if line.x in walls)
        return min(off, default=math.inf) <= 2 * ROUNDING * self.size

    def totals(self) -> Interval:
        """Energy and force."""
        profile = self.motion.profile
        return refined(self.motion.scene, self.depth, self.x, self.surfaces, profile)


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
    scale = displacement_scale(scene, depth, contacts.size)
    if scale * scene.elastocapillary_length == 0:
        return Certificate.undeformed()
    off = np.array([line[2:5] for line in contacts.felt]) - depth
    (closing, bare), opening = -off[:, :2].min(axis=0), off[:, 2].max()
    through = bare if closing > ROUNDING * contacts.size else closing  # no more than that
    size = scale + _steepest(contacts)  # of the terms that cancel in D
    beyond = contacts.motion.penetration(contacts.lines, depth)
    # held by another work of adhesion than what moves them, or the energy is convex
    held = scene.hysteretic or not scene.work_of_adhesion
    firm = held or all(line.stable for line in contacts.felt)
    return Certificate(
        penetration=float(max(0.0, through / size, beyond / scale)),
        stationarity=max(each.residual for each in contacts.surfaces),
        opening=_tension(contacts, scale),
        neighbours=float(max(0.0, closing / size, opening / size, not firm)),
        force=abs(found.force - found.force_by_field) / (found.force_scale or 1.0),
    )


def _steepest(contacts: Contacts) -> float:
    """l |f'| at the lines, with finite slopes l |sin β| [length]."""
    scene = contacts.motion.scene
    beside = (-1, 1) if len(scene.indenter.corners) else 0
    slopes = scene.indenter.slope_beside(contacts.x[..., None], beside)
    if scene.slopes == "finite":
        slopes = slopes / np.hypot(1.0, slopes)
    return scene.elastocapillary_length * float(np.abs(slopes).max())


def _tension(contacts: Contacts, scale: float) -> float:
    """Largest force that would open a contact, over kδl."""
    scene, x = contacts.motion.scene, contacts.x
    forces = contacts.motion.opening(contacts.lines, contacts.depth)
    lone = (x[:, 0] == x[:, 1]) & (scene.measure(x[:, 0]) > 0)
    if lone.any():
        lone &= ~np.array([contacts.motion.pointed(left) for left in x[:, 0].tolist()])
    if lone.any():
        pulls = np.ravel([each.pulls for each in contacts.surfaces])[1:-1].reshape(-1, 2)
        forces += (-pulls.sum(axis=1)[lone] / scene.measure(x[lone, 0])).tolist()
    return max([0.0, *forces]) / (scene.stiffness * scene.elastocapillary_length * scale)


def errors(contacts: Contacts, found: Interval) -> dict[str, float]:
    """Errors of rounding times the condition of the lines, and of the quadrature."""
    off, x = ROUNDING * contacts.size + found.rounding, contacts.x
    moves = [line.free and off * line.moved + _POSITION * abs(line.x) for line in contacts.felt]
    moves = [0.0] * (x.size - len(moves)) + moves  # an end at an axis
    return estimated(contacts.motion.scene, contacts.depth, x, np.reshape(moves, x.shape), found)
