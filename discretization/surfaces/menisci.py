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

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebpts1
from scipy.linalg import lapack

from discretization.certificate import NotCertifiedError
from discretization.roots import crossings
from discretization.surfaces.network import (
    Family,
    Shape,
    band,
    chebyshev,
    gauss_lobatto,
    on_elements,
    shipped,
)
from discretization.surfaces.protocol import ANY, Free, Surfaces
from discretization.surfaces.rings import BESIDE, decayed, far_stiffness, leading_order, stiffness
from energy.arrays import Array, Indices

DEGREE = 12  # of the polynomials on an element
STEEPEST = math.radians(86)  # steeper lines have no state: no mesh of this kind resolves them
# l: radii beside which (1), and inside which (-1), surfaces are known; smaller ones round.
LEAST = {1: 2.0**-1000, -1: 2.0**-15}
# l: beside smaller radii springs do not matter next to the line: s² log² s = 2e-10, see `read`.
_SOLVED = 2.0**-20
_MILD = math.radians(60)  # up to which inclinations are in the first piece
# sin²(φ/2) at the ends of a piece of mild lines, and of the one of steep lines beyond
_SQUARES = np.sin(np.array([0.0, _MILD, STEEPEST]) / 2) ** 2
_OCTAVES = 3.0  # of radii in a piece
_RADII = 20  # Chebyshev points of a piece in log s,
_INCLINATIONS = 14  # and in sin²(φ/2)

_FAR = 8.0  # l: of the mesh, beyond which small slopes are exact to rounding
_LONGEST = 3.0  # l: of an element
_GROWTH = 1.5  # lengths of elements, each over the one before
_HALVINGS = (2, 8)  # of the first element, next to mild and to steep lines
_ON_DISC = np.array([0.08, 0.12, 0.2, 0.3, 0.3])  # lengths of elements of a disc, or of 8 l of it

_NEWTON_STEPS = 60  # for many surfaces or lines at once
_STILL = 1e-16  # of the energy: after a step that lowers it by less, one more is the last
# Armijo's rule: a step is halved that lowers the energy by less than this part of what its slope
# says, unless that is less than the second part of the energy, where rounding decides.
_SUFFICIENT = 1e-3
_ROUNDING_DECIDES = 1e-8

_DIFFERENCE = 1e-3  # of a radius: differences of fourth order are then good to 1e-11
_STENCIL = np.array([-2, -1, 1, 2])  # places of such a difference, in steps,
_STENCIL_WEIGHTS = np.array([1 / 12, -2 / 3, 2 / 3, -1 / 12])
_UPRIGHT = 1e-12  # of the steepest inclination: it is found no better


def elements(side: int, s: Array, halvings: int) -> Array:
    """Lengths (n, m) of the elements beside lines of radii s (n,), the first halved so often."""
    if side < 0:
        lengths = np.minimum(s, _FAR)[:, None] * _ON_DISC
    else:
        growing = [np.minimum(s, 1.0) * (_GROWTH - 1)]
        while float(np.min(sum(growing))) < _FAR:
            growing.append(np.minimum(growing[-1] * _GROWTH, _LONGEST))
        lengths = np.stack(growing, axis=1)
    parts = 0.5 ** np.array([halvings, *range(halvings, 0, -1)])
    return np.hstack([lengths[:, :1] * parts, lengths[:, 1:]])


class Meniscus(NamedTuple):
    """Surfaces on their meshes.

    Attributes
    ----------
    lengths : ndarray (n, m)
        Of the elements, from the line on.
    u : ndarray (n, m * DEGREE + 1)
        Nodal displacements.
    energy : ndarray (n,)
        F.
    """

    lengths: Array
    u: Array
    energy: Array


def solve(side: int, s: Array, sines: Array, halvings: int) -> Meniscus:
    """Surfaces that are pulled at their lines, by Newton's method.

    As U is convex, steps that are too long are halved. A surface is done with the step after one
    that should lower U by at most 1e-16 of it.

    Parameters
    ----------
    side : {1, -1}
        1 beyond the lines, -1 on the discs inside.
    s : ndarray (n,)
        Radii of the lines [l].
    sines : ndarray (n,)
        S = sin φ.
    halvings : int
        Of the first element.

    Returns
    -------
    Meniscus

    Raises
    ------
    NotCertifiedError
        If a Hessian is not positive definite, or 60 steps are not enough.
    """
    mesh = _mesh(side, s, sines, elements(side, s, halvings))
    u = np.zeros((s.size, mesh.half.shape[1] * DEGREE + 1))
    energy, gradient, hessian = mesh.nodal(u)
    unsettled = np.ones(s.size, bool)
    last_decrease = np.full(s.size, math.inf)
    for _ in range(_NEWTON_STEPS):
        step = np.zeros_like(u)
        for i in np.flatnonzero(unsettled).tolist():
            _, solution, info = lapack.dpbsv(hessian[i], gradient[i], lower=1)
            if info != 0:
                raise _unsolved(s[i], sines[i])
            step[i] = -solution
        decrease = -(gradient * step).sum(axis=1)

        factor = np.ones(s.size)
        trial = mesh.nodal(u + step)
        searched = unsettled & (decrease > _ROUNDING_DECIDES * np.abs(energy))
        too_long = searched & (trial[0] > energy - _SUFFICIENT * factor * decrease)
        while too_long.any():
            factor[too_long] /= 2
            trial = mesh.nodal(u + factor[:, None] * step)
            too_long = searched & (trial[0] > energy - _SUFFICIENT * factor * decrease)
        u = u + factor[:, None] * step
        energy, gradient, hessian = trial

        unsettled &= ~(last_decrease <= _STILL * np.abs(energy))  # nan is not settled
        if not unsettled.any():
            break
        last_decrease = decrease
    else:
        worst = int(np.argmax(unsettled))
        raise _unsolved(s[worst], sines[worst])
    return Meniscus(2 * mesh.half[:, :, 0], u, energy + sines * u[:, 0])


def _unsolved(s: float, sine: float) -> NotCertifiedError:
    """The error where Newton's method finds no surface."""
    return NotCertifiedError(
        f"no free surface was found beside a line of radius {float(s)!r} l that pulls with sin φ = "
        f"{float(sine)!r}; use slopes='small', or another depth"
    )


def _mesh(side: int, s: Array, sines: Array, lengths: Array) -> _Mesh:
    """The mesh of elements beside lines; at the axis there is no far field."""
    ends = np.cumsum(np.hstack([np.zeros((s.size, 1)), lengths]), axis=1)
    points, weights, _ = gauss_lobatto(DEGREE)
    half = lengths[:, :, None] / 2
    x = ends[:, :-1, None] + half * (points + 1)
    measure = weights * half * (1 + side * x / s[:, None, None])
    last = np.maximum(s + side * ends[:, -1], 0.0)
    return _Mesh(half, np.maximum(measure, 0.0), last / s * far_stiffness(side, last), sines)


class _Mesh(NamedTuple):
    """Meshes of n surfaces with m elements each.

    half (n, m, 1): half lengths; measure (n, m, DEGREE + 1): weights times 1 ± x/s; far (n,):
    stiffness beyond the last node; sines (n,): what pulls at the lines.
    """

    half: Array
    measure: Array
    far: Array
    sines: Array

    def nodal(self, u: Array) -> tuple[Array, Array, Array]:
        """The energy at nodal displacements (n, nodes) less what the pull does (n,), its gradient.

        And its Hessians in lower banded form (n, DEGREE + 1, nodes).
        """
        derivative = gauss_lobatto(DEGREE).derivative
        first_nodes = np.arange(self.half.shape[1])[:, None] * DEGREE
        own = u[:, first_nodes + np.arange(DEGREE + 1)]
        slope = (own @ derivative.T) / self.half
        root = np.sqrt(1 + slope * slope)
        density = own * own / 2 + slope * slope / (1 + root)
        energy = (self.measure * density).sum(axis=(1, 2)) + self.far * u[:, -1] ** 2 / 2

        tension = self.measure * slope / root / self.half
        pull = self.measure * own + tension @ derivative
        gradient = np.zeros_like(u)
        gradient[:, :-1] = pull[:, :, :-1].reshape(u.shape[0], -1)
        gradient[:, DEGREE::DEGREE] += pull[:, :, -1]
        gradient[:, -1] += self.far * u[:, -1]
        gradient[:, 0] -= self.sines

        bend = self.measure / root**3 / self.half**2
        blocks = np.matmul(derivative.T[None, None] * bend[:, :, None, :], derivative)
        blocks[:, :, np.arange(DEGREE + 1), np.arange(DEGREE + 1)] += self.measure
        hessian = band(blocks)
        hessian[:, 0, -1] += self.far
        return energy - self.sines * u[:, 0], gradient, hessian


def _solved(kind: int, s: Array) -> Array:
    """Coefficients (n, 2·_INCLINATIONS) by inclination, of g and e over 1/S to leading order."""
    side = np.sign(kind)
    steep = int(abs(kind) > 1)
    low = _SQUARES[steep]
    high = _SQUARES[steep + 1]
    over = chebpts1(_INCLINATIONS)
    half_sines = np.sqrt(low + (high - low) * (over + 1) / 2)  # sin(φ/2)
    grid = np.meshgrid(s, half_sines, indexing="ij")
    radii, halves = (part.ravel() for part in grid)
    found = solve(side, radii, 2 * halves * np.sqrt(1 - halves**2), _HALVINGS[steep])
    values = np.array([found.u[:, 0] / halves, found.energy / halves**2])
    values = values / leading_order(side, radii)
    to_coefficients = np.linalg.inv(chebyshev(over, _INCLINATIONS)).T
    return np.hstack(values.reshape(2, s.size, -1) @ to_coefficients)


_OUTSIDE = shipped(_SOLVED, _OCTAVES)
_ON_DISCS = shipped(LEAST[-1], _OCTAVES)
# Kinds: the side, twice as large for steep lines.
FAMILY = Family(
    "menisci",
    _solved,
    2 * _INCLINATIONS,
    _RADII,
    _OCTAVES,
    {1: _OUTSIDE, 2: _OUTSIDE, -1: _ON_DISCS, -2: _ON_DISCS},
)


def read(side: Any, s: Array, phi: Array) -> tuple[Array, Array]:
    """Displacement and energy of surfaces whose inclination is known.

    Where springs do not matter next to the line, both over s change by the tension's logarithm,
    -sin φ and -sin² φ/2 times log s, but for s² log² s.

    Parameters
    ----------
    side : int or ndarray (n,)
        1 beyond the lines, -1 on the discs inside.
    s, phi : ndarray (n,)
        Radii [l] and inclinations at the lines [rad].

    Returns
    -------
    u0, energy : ndarray (n,)
        u₀ [l] and F per length of the line [γ₁ l].
    """
    known = np.maximum(s, _SOLVED)
    half_sine = np.sin(np.minimum(np.abs(phi), STEEPEST) / 2)
    steep = (np.abs(phi) > _MILD).astype(int)
    low = _SQUARES[steep]
    high = _SQUARES[steep + 1]
    basis = chebyshev(2 * (half_sine * half_sine - low) / (high - low) - 1, _INCLINATIONS)
    coefficients = FAMILY.at(side * (1 + steep), known).reshape(s.size, 2, _INCLINATIONS)
    g, e = (coefficients * basis[:, None]).sum(axis=2).T * leading_order(side, known)

    ratio = np.minimum(s / _SOLVED, 1.0)
    sine = np.sin(np.clip(phi, -STEEPEST, STEEPEST))
    logarithm = -ratio * _SOLVED * np.log(ratio) * sine
    u0 = ratio * np.copysign(half_sine * g, phi) + logarithm
    energy = ratio * half_sine**2 * e + logarithm * sine / 2
    return u0, energy


def inclination(side: int, s: Array, u0: Array) -> Array:
    """φ at lines of radii s (n,) displaced by u₀ (n,); at most STEEPEST."""
    rise = 1 / stiffness(side, s)  # du₀/dφ of small slopes
    most = np.full_like(s, STEEPEST)
    flat = u0 / rise
    guess = np.clip(flat / np.sqrt(1 + flat * flat / 4), -most, most)

    def excess(phi: Array, own: Indices) -> Array:
        return read(side, s[own], phi)[0] - u0[own]

    return crossings(excess, -most, most, guess, rise, 0.0)


@functools.lru_cache(maxsize=256)
def surface(side: int, s: float, u0: float) -> tuple[Array, Array]:
    """The surface beside a line of this radius: ends of its elements, and u at their nodes."""
    radius = np.array([s])
    phi = inclination(side, radius, np.array([u0]))
    steep = abs(float(phi[0])) > _MILD
    found = solve(side, radius, np.sin(phi), _HALVINGS[steep])
    return np.append(0.0, np.cumsum(found.lengths[0])), found.u[0]


class MeniscusSurfaces(Surfaces):
    """Free surfaces about an axis of a scene with finite slopes."""

    lost = (
        "is inclined by more than 86°, which no mesh of this kind resolves (beyond 90° there is no "
        "state), or ends in a disc narrower than 3e-5 l"
    )

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, steep: Any, w: Any) -> Any:
        """Displacement of a line at rest, read from its inclination, which is known.

        Beyond the steepest of the family it only has to grow: a line that rests there has no state.
        At the axis it is next to nothing, of the right sign. On a disc narrower than any that is
        known it falls with the radius, so that what is there does not count.
        """
        self._raise_for_ring(s + side * width)
        one = not np.ndim(s)
        phi = np.arctan(steep) - 2 * np.arcsin(np.sqrt(w / 2))
        side, s, phi = np.broadcast_arrays(*map(np.atleast_1d, (side, s, phi)))
        known = np.maximum(s, np.where(side > 0, LEAST[1], LEAST[-1]))
        off_axis = s > 0
        u = np.sin(phi) * leading_order(1, BESIDE)
        u[off_axis] = read(side[off_axis], known[off_axis], phi[off_axis])[0]

        growth = np.maximum(np.abs(np.sin(phi / 2)) / math.sin(STEEPEST / 2), 1.0)
        growth = growth * np.where(side > 0, 1.0, known / np.maximum(s, BESIDE))
        u = np.where(off_axis | (side > 0), u * growth, ANY)
        return u[0] if one else u

    def _raise_for_ring(self, other: Any) -> None:
        """ValueError where there is another line."""
        if np.isfinite(other).any():
            r = self.scene.elastocapillary_length * float(np.ravel(other)[0])
            raise ValueError(
                f"slopes = 'finite' with geometry = 'axisymmetric': there is another contact at r "
                f"= {r!r}, and the ring of free surface between two is not implemented with finite "
                "slopes; use slopes='small', or a profile with one contact"
            )

    def energy_and_reaction(
        self, side: int, s: Any, width: Any, u: Any, rise: Any
    ) -> tuple[Any, Any] | None:
        """Those of the family."""
        known = np.maximum(s, LEAST[side])
        phi = inclination(side, known, u)
        upright = np.abs(phi) >= STEEPEST * (1 - _UPRIGHT)
        if (upright & (s >= LEAST[side])).any():
            return None
        return s * read(side, known, phi)[1], s * np.sin(phi)

    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free | None:
        """As all nodes of the mesh are balanced, k∫u over the surface is what its line pulls."""
        found = self.energy_and_reaction(side, np.array([s]), width, np.array([u]), rise)
        if s < LEAST[side] or found is None:
            return None
        energy, pull = (part.item() for part in found)
        return Free(energy, (pull, 0.0), pull, self._imbalance(side, s, u, pull / s))

    def _imbalance(self, side: int, s: float, u: float, sine: float) -> float:
        """How far d(sF)/ds is from side s (1 - cos φ - u₀²/2), over its terms.

        Next to 90° a radius changes φ at a given u₀ ever more. There φ is given in its place: what
        u₀ changes by then takes the work s sin φ du₀.
        """
        scaled = 1 + _DIFFERENCE * _STENCIL
        radii = s * scaled
        phi = inclination(side, np.array([s]), np.array([u]))
        work = 0.0
        if abs(float(phi[0])) > _MILD:
            phi = np.full_like(radii, phi[0])
            u_change = float(_STENCIL_WEIGHTS @ read(side, radii, phi)[0])
            work = sine * u_change / (_DIFFERENCE * s)
        else:
            phi = inclination(side, radii, np.full_like(radii, u))
        energy_change = float(_STENCIL_WEIGHTS @ (scaled * read(side, radii, phi)[1]))
        rate = energy_change / (_DIFFERENCE * s) - work
        cosine = math.sqrt(1 - sine * sine)
        expected = side * (sine * sine / (1 + cosine) - u * u / 2)
        return abs(rate - expected) / (sine * sine + u * u or 1.0)

    def profile(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """The elements' polynomials, then the far field."""
        self._raise_for_ring(s + side * width)
        if not s:
            return np.zeros_like(x), np.zeros_like(x)
        ends, nodal = surface(side, s, u)
        end = ends[-1]
        near = on_elements(ends, nodal, np.minimum(x, end))
        far = nodal[-1] * decayed(side, s + side * end, s + side * x)
        values, slopes = np.where(x < end, near, far)
        return values, slopes
