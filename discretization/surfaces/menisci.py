"""Free surfaces about an axis with finite slopes: a family with two parameters, solved on a mesh.

In units of l and γ₁ the surface beside a line of radius s minimises, per length of the line,

    ∫ [u²/2 + √(1+u'²) - 1] (1 ± x/s) dx - S u₀,    S = sin φ,

over its nodal displacements, x the distance from the line (a meniscus with k for ρg). φ is the
inclination at the line. Displacement and energy are smooth in log s and sin²(φ/2),

    u₀ = sin(φ/2) g,    F = sin²(φ/2) e,

and are kept as Chebyshev polynomials of both on pieces of the family. Beyond 8 l the surface is so
flat that small slopes are exact to rounding.
"""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts1
from numpy.typing import NDArray
from scipy.linalg import lapack

from discretization.roots import crossings
from discretization.surfaces.network import Family, band, chebyshev, on_elements, rounded
from discretization.surfaces.rings import decayed, far_stiffness, rough, stiffness

Array = NDArray[np.float64]
DEGREE = 16  # of the polynomials on an element
STEEPEST = math.radians(86)  # steeper lines are refused: no mesh of this kind resolves them
LEAST = {1: 2.0**-40, -1: 2.0**-15}  # l: beside smaller radii, and inside them, none is known
_SOLVED = 2.0**-20  # l: beside smaller radii springs do not matter next to the line
_MILD = math.radians(60)
_SQUARES = {  # sin²(φ/2) at the ends of a piece of mild and of steep lines
    False: (0.0, math.sin(_MILD / 2) ** 2),
    True: (math.sin(_MILD / 2) ** 2, math.sin(STEEPEST / 2) ** 2),
}
_RANGE = 3.0  # octaves of radii in a piece
_RADII, _INCLINATIONS = 20, 14  # points of a piece
_FAR, _LONGEST, _WIDER = 8.0, 3.0, 1.5  # l: of the mesh, of an element; each over the one before
_HALVINGS = {False: 2, True: 7}  # of the first element, next to mild and to steep lines
_INSIDE = np.array([0.08, 0.12, 0.2, 0.3, 0.3])  # of a disc, or of 8 l of it
_ROUNDS = 60  # of Newton's method, for many surfaces or lines at once
_STILL = 1e-16  # of the energy: a decrease that is rounding, where it no longer falls either
_SHARPER = 4.0  # while a step lowers U by less than a quarter of the last: no rounding yet


def elements(side: int, s: Array, halvings: int) -> Array:
    """Lengths (n, m) of the elements beside lines of radii s (n,)."""
    if side < 0:
        lengths = np.minimum(s, _FAR)[:, None] * _INSIDE
    else:
        own = [np.minimum(s, 1.0) * (_WIDER - 1)]
        while float(np.min(sum(own))) < _FAR:
            own.append(np.minimum(own[-1] * _WIDER, _LONGEST))
        lengths = np.stack(own, axis=1)
    first = lengths[:, :1]
    parts = [first / 2**halvings, *(first / 2**i for i in range(halvings, 0, -1))]
    return np.hstack([*parts, lengths[:, 1:]]) if halvings else lengths


def solve(side: int, s: Array, sines: Array, halvings: int) -> tuple[Array, Array, Array]:
    """Surfaces that are pulled by S = sines (n,) at lines of radii s (n,), by Newton's method.

    The energy is convex, and the steps are halved while they are too long. Lengths of elements
    (n, m), nodal u (n, nodes), and energies (n,).
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
        rough &= (decrease > _STILL * np.abs(energy)) | (_SHARPER * decrease < before)
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
        count = self.half.shape[1]
        index = np.arange(count)[:, None] * DEGREE + np.arange(DEGREE + 1)
        own = u[:, index]
        slope = (own @ d.T) / self.half
        root = np.sqrt(1 + slope * slope)
        density = own * own / 2 + slope * slope / (1 + root)
        end = u[:, -1]
        energy = (self.measure * density).sum(axis=(1, 2)) + self.far * end * end / 2
        pull = self.measure * own + (self.measure * slope / root / self.half) @ d
        gradient = np.zeros_like(u)
        gradient[:, :-1] = pull[:, :, :-1].reshape(u.shape[0], -1)
        gradient[:, DEGREE::DEGREE] += pull[:, :, -1]
        gradient[:, -1] += self.far * end
        gradient[:, 0] -= self.sines
        bend = self.measure / root**3 / self.half**2
        blocks = np.matmul(d.T[None, None] * bend[:, :, None, :], d)
        blocks[:, :, np.arange(DEGREE + 1), np.arange(DEGREE + 1)] += self.measure
        hessian = band(blocks)
        hessian[:, 0, -1] += self.far
        return energy - self.sines * u[:, 0], gradient, hessian


def _solved(kind: int, s: Array) -> Array:
    """Coefficients of g and of e over what u₀ is roughly (n, 2·_INCLINATIONS), by inclination."""
    side, steep = np.sign(kind), abs(kind) > 1
    over, (low, high) = chebpts1(_INCLINATIONS), _SQUARES[steep]
    half = np.sqrt(low + (high - low) * (over + 1) / 2)  # sin(φ/2)
    radii, halves = (part.ravel() for part in np.meshgrid(s, half, indexing="ij"))
    _, u, energy = solve(side, radii, 2 * halves * np.sqrt(1 - halves**2), _HALVINGS[steep])
    values = np.array([u[:, 0] / halves, energy / halves**2]) / rough(side, radii)
    found = values.reshape(2, s.size, -1) @ np.linalg.inv(chebyshev(over, _INCLINATIONS)).T
    return np.hstack(found)


_FAMILY = Family(_solved, 2 * _INCLINATIONS, _RADII, _RANGE)


def read(side: Any, s: Array, phi: Array) -> tuple[Array, Array]:
    """u₀ and F beside lines of radii s (n,) at which the surface is inclined by φ (n,).

    Where springs do not matter next to the line, both over s change by the tension's logarithm,
    -sin φ and -sin² φ/2 times log s, but for s² log² s.
    """
    own, half = np.maximum(s, _SOLVED), np.sin(np.minimum(np.abs(phi), STEEPEST) / 2)
    steep = np.abs(phi) > _MILD
    low, high = np.where(steep[:, None], _SQUARES[True], _SQUARES[False]).T
    over = chebyshev(2 * (half * half - low) / (high - low) - 1, _INCLINATIONS)
    family = _FAMILY.at(side * (1 + steep), own).reshape(s.size, 2, _INCLINATIONS)
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


def shape(side: int, s: float, u0: float, x: Array) -> tuple[Array, Array]:
    """u and u' at distances from the line: the elements' polynomials, then the far field."""
    ends, u = surface(side, s, u0)
    end = ends[-1]
    near = on_elements(ends, u, np.minimum(x, end))
    far = u[-1] * decayed(side, s + side * end, s + side * x)
    u0, u1 = np.where(x < end, near, far)
    return u0, u1
