"""Free surfaces about an axis with finite slopes: a family with two parameters, solved on a mesh.

In units of l and γ₁ the surface beside a line of radius s minimises, per length of the line,

    ∫ [u²/2 + √(1+u'²) - 1] (1 ± x/s) dx - S u₀,    S = sin φ,

over its nodal displacements, x the distance from the line (a meniscus with k for ρg). φ is the
inclination at the line. Displacement and energy are smooth in log s and sin²(φ/2),

    u₀ = sin(φ/2) g,    F = sin²(φ/2) e,

and are kept as Chebyshev polynomials of both on pieces of the family. Beyond 8 l the surface is so
flat that small slopes are exact to rounding.

A line rests where φ = β - 2 asin √(w/(2γ₁)), tan β = f'. ∂U/∂x = 2πx [2γ₁ sin²((β-φ)/2) - w]/cos β
as for a line contact, because on the mesh, to rounding,

    d(s F)/ds = ±s (1 - cos φ - u₀²/2)   at a given u₀.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts1
from scipy.linalg import lapack

from discretization.roots import crossings
from discretization.surfaces.network import (
    Family,
    Shape,
    band,
    chebyshev,
    on_elements,
    rounded,
    shipped,
)
from discretization.surfaces.protocol import ANY, Free, Surfaces
from discretization.surfaces.rings import BESIDE, decayed, far_stiffness, rough, stiffness
from energy.arrays import Array

DEGREE = 12  # of the polynomials on an element
STEEPEST = math.radians(86)  # steeper lines are refused: no mesh of this kind resolves them
# l: radii beside which, and inside which, surfaces are known; smaller ones round
LEAST = {1: 2.0**-1000, -1: 2.0**-15}
_SOLVED = 2.0**-20  # l: beside smaller radii springs do not matter next to the line
_MILD = math.radians(60)
# sin²(φ/2) at the ends of a piece of mild lines, and of the one of steep lines beyond
_SQUARES = np.sin(np.array([0.0, _MILD, STEEPEST]) / 2) ** 2
_RANGE = 3.0  # octaves of radii in a piece
_RADII, _INCLINATIONS = 20, 14  # points of a piece
_FAR, _LONGEST, _WIDER = 8.0, 3.0, 1.5  # l: of the mesh, of an element; each over the one before
_HALVINGS = (2, 8)  # of the first element, next to mild and to steep lines
_INSIDE = np.array([0.08, 0.12, 0.2, 0.3, 0.3])  # of a disc, or of 8 l of it
_ROUNDS = 60  # of Newton's method, for many surfaces or lines at once
_STILL = 1e-16  # of the energy: after a step that lowers it by less, one more is the last
_DIFFERENCE = 1e-3  # of a radius: differences of fourth order are then good to 1e-11
_RULE = np.array([(-2, 1 / 12), (-1, -2 / 3), (1, 2 / 3), (2, -1 / 12)]).T
_UPRIGHT = 1e-12  # of the steepest inclination: it is found no better


def elements(side: int, s: Array, halvings: int) -> Array:
    """Lengths (n, m) of the elements beside lines of radii s (n,)."""
    if side < 0:
        lengths = np.minimum(s, _FAR)[:, None] * _INSIDE
    else:
        own = [np.minimum(s, 1.0) * (_WIDER - 1)]
        while float(np.min(sum(own))) < _FAR:
            own.append(np.minimum(own[-1] * _WIDER, _LONGEST))
        lengths = np.stack(own, axis=1)
    parts = 0.5 ** np.array([halvings, *range(halvings, 0, -1)])
    return np.hstack([lengths[:, :1] * parts, lengths[:, 1:]])


def solve(side: int, s: Array, sines: Array, halvings: int) -> tuple[Array, Array, Array]:
    """Surfaces that are pulled by S = sines (n,) at lines of radii s (n,), by Newton's method.

    Too long steps are halved, as U is convex. Elements' lengths (n, m), nodal u, and energies (n,).
    """
    lengths = elements(side, s, halvings)
    ends = np.cumsum(np.hstack([np.zeros((s.size, 1)), lengths]), axis=1)
    points, weights, _ = rounded(DEGREE)
    half = lengths[:, :, None] / 2
    x = ends[:, :-1, None] + half * (points + 1)
    measure = weights * half * (1 + side * x / s[:, None, None])
    last = np.maximum(s + side * ends[:, -1], 0.0)  # beyond which at the axis there is nothing
    mesh = _Mesh(half, np.maximum(measure, 0.0), last / s * far_stiffness(side, last), sines)
    u = np.zeros((s.size, lengths.shape[1] * DEGREE + 1))
    (energy, gradient, hessian), rough = mesh.nodal(u), np.ones(s.size, bool)
    before = np.full(s.size, math.inf)
    for _ in range(_ROUNDS):
        step = np.zeros_like(u)
        for i in np.flatnonzero(rough).tolist():
            _, solution, info = lapack.dpbsv(hessian[i], gradient[i], lower=1)
            step[i] = -solution if info == 0 else 0.0
        decrease = -(gradient * step).sum(axis=1)
        trial, factor = mesh.nodal(u + step), np.ones(s.size)
        long = rough & (decrease > 1e-8 * np.abs(energy))
        while (over := long & (trial[0] > energy - 1e-3 * factor * decrease)).any():
            factor[over] /= 2
            trial = mesh.nodal(u + factor[:, None] * step)
        u, (energy, gradient, hessian) = u + factor[:, None] * step, trial
        rough &= before > _STILL * np.abs(energy)
        if not rough.any():
            break
        before = decrease
    return lengths, u, energy + sines * u[:, 0]


class _Mesh(NamedTuple):
    half: Array
    measure: Array
    far: Array
    sines: Array

    def nodal(self, u: Array) -> tuple[Array, Array, Array]:
        """At nodal displacements (n, nodes): the energy less what the pull does (n,), its gradient.

        And its Hessians in lower banded form.
        """
        d = rounded(DEGREE)[2]
        own = u[:, np.arange(self.half.shape[1])[:, None] * DEGREE + np.arange(DEGREE + 1)]
        slope = (own @ d.T) / self.half
        root = np.sqrt(1 + slope * slope)
        density = own * own / 2 + slope * slope / (1 + root)
        energy = (self.measure * density).sum(axis=(1, 2)) + self.far * u[:, -1] ** 2 / 2
        pull = self.measure * own + (self.measure * slope / root / self.half) @ d
        gradient = np.zeros_like(u)
        gradient[:, :-1] = pull[:, :, :-1].reshape(u.shape[0], -1)
        gradient[:, DEGREE::DEGREE] += pull[:, :, -1]
        gradient[:, -1] += self.far * u[:, -1]
        gradient[:, 0] -= self.sines
        bend = self.measure / root**3 / self.half**2
        blocks = np.matmul(d.T[None, None] * bend[:, :, None, :], d)
        blocks[:, :, np.arange(DEGREE + 1), np.arange(DEGREE + 1)] += self.measure
        hessian = band(blocks)
        hessian[:, 0, -1] += self.far
        return energy - self.sines * u[:, 0], gradient, hessian


def _solved(kind: int, s: Array) -> Array:
    """Coefficients of g and of e over what u₀ is roughly (n, 2·_INCLINATIONS), by inclination."""
    side, steep = np.sign(kind), int(abs(kind) > 1)
    over, (low, high) = chebpts1(_INCLINATIONS), _SQUARES[steep : steep + 2]
    half = np.sqrt(low + (high - low) * (over + 1) / 2)  # sin(φ/2)
    radii, halves = (part.ravel() for part in np.meshgrid(s, half, indexing="ij"))
    _, u, energy = solve(side, radii, 2 * halves * np.sqrt(1 - halves**2), _HALVINGS[steep])
    values = np.array([u[:, 0] / halves, energy / halves**2]) / rough(side, radii)
    found = values.reshape(2, s.size, -1) @ np.linalg.inv(chebyshev(over, _INCLINATIONS)).T
    return np.hstack(found)


_OUTSIDE, _ON_DISCS = shipped(_SOLVED, _RANGE), shipped(LEAST[-1], _RANGE)
FAMILY = Family(
    "menisci",
    _solved,
    2 * _INCLINATIONS,
    _RADII,
    _RANGE,
    {1: _OUTSIDE, 2: _OUTSIDE, -1: _ON_DISCS, -2: _ON_DISCS},
)


def read(side: Any, s: Array, phi: Array) -> tuple[Array, Array]:
    """u₀ and F beside lines of radii s (n,) at which the surface is inclined by φ (n,).

    Where springs do not matter next to the line, both over s change by the tension's logarithm,
    -sin φ and -sin² φ/2 times log s, but for s² log² s.
    """
    own, half = np.maximum(s, _SOLVED), np.sin(np.minimum(np.abs(phi), STEEPEST) / 2)
    steep = (np.abs(phi) > _MILD).astype(int)
    low, high = _SQUARES[steep], _SQUARES[steep + 1]
    over = chebyshev(2 * (half * half - low) / (high - low) - 1, _INCLINATIONS)
    family = FAMILY.at(side * (1 + steep), own).reshape(s.size, 2, _INCLINATIONS)
    g, e = (family * over[:, None]).sum(axis=2).T * rough(side, own)
    part, sine = np.minimum(s / _SOLVED, 1.0), np.sin(np.clip(phi, -STEEPEST, STEEPEST))
    more = -part * _SOLVED * np.log(part) * sine
    return part * np.copysign(half * g, phi) + more, part * half**2 * e + more * sine / 2


def inclination(side: int, s: Array, u0: Array) -> Array:
    """φ at lines of radii s (n,) displaced by u₀ (n,); at most STEEPEST."""
    rise, most = 1 / stiffness(side, s), np.full_like(s, STEEPEST)
    flat = u0 / rise
    guess = np.clip(flat / np.sqrt(1 + flat * flat / 4), -most, most)
    return crossings(
        lambda phi, own: read(side, s[own], phi)[0] - u0[own], -most, most, guess, rise, 0.0
    )


@functools.lru_cache(maxsize=256)
def surface(side: int, s: float, u0: float) -> tuple[Array, Array]:
    """The surface beside a line of this radius: ends of its elements, and u at their nodes."""
    radius = np.array([s])
    phi = inclination(side, radius, np.array([u0]))
    lengths, u, _ = solve(side, radius, np.sin(phi), _HALVINGS[abs(float(phi[0])) > _MILD])
    return np.append(0.0, np.cumsum(lengths[0])), u[0]


class MeniscusSurfaces(Surfaces):
    """Free surfaces of a scene."""

    lost = (
        "is inclined by more than 86°, which no mesh of this kind resolves (beyond 90° there is no "
        "state), or ends in a disc narrower than 3e-5 l"
    )

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, steep: Any, w: Any) -> Any:
        """The inclination at rest is known, and the displacement that has it is read.

        Beyond the steepest of the family it only has to grow: a line that rests there is refused.
        At the axis it is next to nothing, of the right sign.
        """
        self._alone(s + side * width)
        one, phi = not np.ndim(s), np.arctan(steep) - 2 * np.arcsin(np.sqrt(w / 2))
        side, s, phi = np.broadcast_arrays(*map(np.atleast_1d, (side, s, phi)))
        least = np.maximum(s, np.where(side > 0, LEAST[1], LEAST[-1]))
        off, u = s > 0, np.sin(phi) * rough(1, BESIDE)
        u[off] = read(side[off], least[off], phi[off])[0]
        beyond = np.maximum(np.abs(np.sin(phi / 2)) / math.sin(STEEPEST / 2), 1.0)
        # what is on a tiny disc does not count
        beyond = beyond * np.where(side > 0, 1.0, least / np.maximum(s, BESIDE))
        u = np.where(off | (side > 0), u * beyond, ANY)
        return u[0] if one else u

    def _alone(self, other: Any) -> None:
        """ValueError where there is another line."""
        if np.isfinite(other).any():
            r = self.scene.elastocapillary_length * float(np.ravel(other)[0])
            raise ValueError(
                f"slopes = 'finite' with geometry = 'axisymmetric': there is another contact at r "
                f"= {r!r}, and the ring of free surface between two is not implemented with finite "
                "slopes; use slopes='small', or a profile with one contact"
            )

    def held(self, side: int, s: Any, width: Any, u: Any, rise: Any) -> tuple[Any, Any] | None:
        """Read from the family."""
        phi = inclination(side, np.maximum(s, LEAST[side]), u)
        if ((np.abs(phi) >= STEEPEST * (1 - _UPRIGHT)) & (s >= LEAST[side])).any():
            return None
        energy = s * read(side, np.maximum(s, LEAST[side]), phi)[1]
        return energy, s * np.sin(phi)

    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free | None:
        """Read from the family. As all its nodes are balanced, k∫u over it is what it pulls."""
        found = self.held(side, np.array([s]), width, np.array([u]), rise)
        if s < LEAST[side] or found is None:
            return None
        energy, pull = (part.item() for part in found)
        return Free(energy, (pull, 0.0), pull, self._imbalance(side, s, u, pull / s))

    def _imbalance(self, side: int, s: float, u: float, pull: float) -> float:
        """How far d(sF)/ds is from side s (1 - cos φ - u₀²/2), over its terms.

        Next to 90° a radius changes φ at a given u₀ ever more. There φ is given in its place: what
        u₀ changes by then takes the work s sin φ du₀.
        """
        steps, rule = _RULE
        radii, scaled = s * (1 + _DIFFERENCE * steps), 1 + _DIFFERENCE * steps
        phi, work = inclination(side, np.array([s]), np.array([u])), 0.0
        if abs(float(phi[0])) > _MILD:
            phi = np.full_like(radii, phi[0])
            work = pull * float(rule @ read(side, radii, phi)[0]) / (_DIFFERENCE * s)
        else:
            phi = inclination(side, radii, np.full_like(radii, u))
        rate = float(rule @ (scaled * read(side, radii, phi)[1])) / (_DIFFERENCE * s) - work
        cos = math.sqrt(1 - pull * pull)
        off = abs(rate - side * (pull * pull / (1 + cos) - u * u / 2))
        return off / (pull * pull + u * u or 1.0)

    def form(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """The elements' polynomials, then the far field."""
        self._alone(s + side * width)
        if not s:
            return np.zeros_like(x), np.zeros_like(x)
        ends, nodal = surface(side, s, u)
        end = ends[-1]
        near = on_elements(ends, nodal, np.minimum(x, end))
        far = nodal[-1] * decayed(side, s + side * end, s + side * x)
        u0, u1 = np.where(x < end, near, far)
        return u0, u1
