"""Free surfaces about an axis with finite slopes: a family with two parameters, solved on a mesh.

In units of l and γ₁ the surface beside a line of radius s minimises, per length of the line,

    ∫ [u²/2 + √(1+u'²) - 1] (1 ± x/s) dx - S u₀,    S = sin φ,

over its nodal displacements, x the distance from the line (a meniscus with k for ρg), + for a
surface outside the line and - for a disc inside. φ is the inclination at the line, u₀ the
displacement there. Displacement and energy are smooth in log s and sin²(φ/2),

    u₀ = sin(φ/2) g,    F = sin²(φ/2) e,

and are kept as Chebyshev polynomials of both on pieces of the family. Beyond 8 l the surface is so
flat that small slopes are exact to rounding.

A line rests where φ = β - 2 asin √(w/(2γ₁)), tan β = f'. ∂U/∂x = 2πx [2γ₁ sin²((β-φ)/2) - w]/cos β
as for a line contact, because on the mesh, to rounding,

    d(s F)/ds = ±s (1 - cos φ - u₀²/2)   at a given u₀, + outside.

Conventions
-----------
u is positive downwards. φ and β are inclinations away from the contact, positive upwards: tan φ =
-du/dx, so that φ, u₀ and the pull S = sin φ, the force downwards that holds the line, have the same
sign. `side` is 1 if the surface is outside its line, at larger radii, and -1 if inside, a disc
around the axis. F and S are per length of the line; s F and s S, per radian, are what `Surfaces`
wants. Surfaces on meshes are rows: nodes and elements from the line on, neighbouring elements share
a node. The family (`Family` of network.py) has a "kind" for each side and range of φ: `side` for
inclinations up to 60°, twice `side` for steeper ones.

Of rings.py: `leading_order(side, s)` is u₀/S of small slopes to leading order, `stiffness(side, s)`
S/u₀, and `far_stiffness(side, r)` the same by Bessel functions; `decayed(side, start, r)` are u and
its slope away from a line at `start` that is displaced by 1. `AXIS_RADIUS` = 2⁻⁴⁰ l is the radius
that a line at the axis is given. Of protocol.py: `ANY` stands for the displacement of a line that
rests at any depth, and `Free` is a surface with its energy, the pulls of its lines, ∫u and the
mismatch of its balance. Of network.py: `gauss_lobatto(degree)` has degree + 1 points on [-1, 1],
their weights, and the matrix that differentiates values there; `chebyshev(t, n)` are the first n
Chebyshev polynomials at t, a column each; `band` sums matrices of elements in a row into LAPACK's
lower banded form, which `dpbsv` solves; `on_elements(ends, u, x)` is a function and its slope at x
from nodal values, a `Shape`; `shipped` has the numbers of the pieces of a family that are in its
file. `crossings(f, low, high, guess, slope, ...)` are zeros of many functions that grow, one in
each interval. `scene.elastocapillary_length` is l.
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
from discretization.surfaces.rings import (
    AXIS_RADIUS,
    decayed,
    far_stiffness,
    leading_order,
    stiffness,
)
from energy.arrays import Array, Indices

# Of the polynomials on an element. With 6 of them 4 of 24 random states change by up to 7e-8 of
# their scale, with 24 none by 1e-9 (`python -m tests.sensitivity discretization.surfaces.menisci
# DEGREE`).
DEGREE = 12
STEEPEST = math.radians(86)  # steeper lines have no state: no mesh of this kind resolves them
# Up to here inclinations are in the first of two pieces, whose lengths in sin²(φ/2) are then about
# the same: 0.25 and 0.22. 30° or 120° changes no result (`python -m tests.sensitivity
# discretization.surfaces.menisci _MILD`).
_MILD = math.radians(60)
# Smallest radii of lines with a surface outside (1) and with a disc inside (-1) [l] of which the
# surface is known: with smaller ones digits are lost.
LEAST_RADIUS = {1: 2.0**-1000, -1: 2.0**-15}
# l: beside smaller radii springs do not matter next to the line: s² log² s = 2e-10, see `read`.
_SOLVED = 2.0**-20
# sin²(φ/2) from which the mild lines are, from which the steep ones, and up to which these
_SQUARES = np.sin(np.array([0.0, _MILD, STEEPEST]) / 2) ** 2


class FamilyPieces(NamedTuple):
    """Pieces of the family on which g and e are polynomials.

    At random places g is then off by 9e-12 of itself or less, a hundredth of what certificates
    tolerate.

    Attributes
    ----------
    octaves : float
        Length of a piece in log₂ s.
    radii : int
        Chebyshev points in log s: 10 leave 8e-7 of g, 20 leave 9e-12, and 40 rounding.
    inclinations : int
        Chebyshev points in sin²(φ/2): 7 leave 1e-9 of g, 14 and 28 rounding, 7e-15 and 5e-15.
    """

    octaves: float = 3.0
    radii: int = 20
    inclinations: int = 14


_PIECE = FamilyPieces()


class Meshing(NamedTuple):
    """Spectral elements beside a line; lengths in l.

    Of 12 random surfaces up to 59° on both sides of a line, `covered` = 4 changes u at the line and
    the energy by up to 5e-9 of themselves. 16, and half or twice of the others (`growth` = 1.25 or
    2), change them by 6e-15 or less, which is rounding.

    Attributes
    ----------
    covered : float
        Distance from the line up to which there are elements; beyond, slopes are so small that the
        exact decay of small slopes is right to rounding.
    longest : float
        Longest element.
    growth : float
        Length of an element over that of the one before, outwards from the line.
    """

    covered: float = 8.0
    longest: float = 3.0
    growth: float = 1.5


_MESH = Meshing()


# Of the first element, next to mild lines [0] and to steep ones [1]: half or twice as many change
# none of 24 random states (`python -m tests.sensitivity discretization.surfaces.menisci
# _HALVINGS`).
_HALVINGS = (2, 8)
# Lengths of the elements of a disc over its radius, or over 8 l, from the line on; their sum is 1.
_ON_DISC = np.array([0.08, 0.12, 0.2, 0.3, 0.3])


class NewtonRules(NamedTuple):
    """When Newton's method for the nodal displacements shortens a step, and when it stops.

    Halved or doubled (`still` and `rounding_decides` a tenth or ten times), none of these changes
    12 random surfaces up to 59° by more than 2e-15 of themselves.

    Attributes
    ----------
    most_steps : int
        Steps at most; one surface takes 6 at 30°, and 13 at 86°.
    still : float
        Of the energy: after a step that should lower it by less, which is half its rounding, one
        more is the last. As the method converges quadratically, that one is exact.
    sufficient : float
        Armijo's rule: a step is halved that lowers the energy by less than this part of what the
        slope of the energy predicts.
    rounding_decides : float
        Of the energy: of predictions below this the rounding of the energy would decide, and no
        step is halved.
    """

    most_steps: int = 60
    still: float = 1e-16
    sufficient: float = 1e-3
    rounding_decides: float = 1e-8


_NEWTON = NewtonRules()


# The difference quotient of fourth order that checks d(sF)/ds, of the form Σ weight f(place)/step:
# its step over the radius, with which it is good to 1e-11, its places in steps, and their weights.
_DIFFERENCE = 1e-3
_STENCIL = np.array([-2, -1, 1, 2])
_STENCIL_WEIGHTS = np.array([1 / 12, -2 / 3, 2 / 3, -1 / 12])
_UPRIGHT = 1e-12  # of the steepest inclination: a root finder leaves no more of it


def elements(side: int, s: Array, halvings: int) -> Array:
    """Lengths of the elements beside lines, from the line on.

    Outwards they grow from half the radius of the line, or half of l; on a disc they are parts of
    its radius, or of 8 l. The first one is halved again and again towards the line.

    Parameters
    ----------
    side : {1, -1}
        1 beyond the lines, -1 on the discs inside.
    s : ndarray (n,)
        Radii of the lines [l].
    halvings : int
        How often the first element is halved.

    Returns
    -------
    ndarray (n, m)
        [l].
    """
    if side < 0:
        lengths = np.minimum(s, _MESH.covered)[:, None] * _ON_DISC
    else:
        growing = [np.minimum(s, 1.0) * (_MESH.growth - 1)]
        while float(np.min(sum(growing))) < _MESH.covered:
            growing.append(np.minimum(growing[-1] * _MESH.growth, _MESH.longest))
        lengths = np.stack(growing, axis=1)
    parts = 0.5 ** np.array([halvings, *range(halvings, 0, -1)])
    return np.hstack([lengths[:, :1] * parts, lengths[:, 1:]])


class Meniscus(NamedTuple):
    """Surfaces on their meshes.

    Attributes
    ----------
    lengths : ndarray (n, m)
        Lengths of the elements, from the line on [l].
    u : ndarray (n, m * DEGREE + 1)
        Nodal displacements, from the line on [l].
    energy : ndarray (n,)
        F, per length of the line [γ₁ l].
    """

    lengths: Array
    u: Array
    energy: Array


def solve(side: int, s: Array, sines: Array, halvings: int) -> Meniscus:
    """Surfaces that are pulled at their lines, by Newton's method from flat ones on.

    What is least is F - S u₀, which is convex; steps that are too long are halved (Armijo's rule).
    A surface is done with the step after one that should lower this by at most 1e-16 of it.

    Parameters
    ----------
    side : {1, -1}
        1 beyond the lines, -1 on the discs inside.
    s : ndarray (n,)
        Radii of the lines [l].
    sines : ndarray (n,)
        S = sin φ, what pulls at each.
    halvings : int
        How often the first element beside the line is halved; see `elements`.

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
    energy, gradient, hessian = mesh.nodal(u)  # here the energy is F - S u₀
    unsettled = np.ones(s.size, bool)
    last_decrease = np.full(s.size, math.inf)  # what the last step should lower the energy by
    for _ in range(_NEWTON.most_steps):
        step = np.zeros_like(u)
        for i in np.flatnonzero(unsettled).tolist():
            _, solution, info = lapack.dpbsv(hessian[i], gradient[i], lower=1)
            if info != 0:
                raise _unsolved(s[i], sines[i])
            step[i] = -solution
        decrease = -(gradient * step).sum(axis=1)

        factor = np.ones(s.size)
        trial = mesh.nodal(u + step)
        searched = unsettled & (decrease > _NEWTON.rounding_decides * np.abs(energy))
        too_long = searched & (trial[0] > energy - _NEWTON.sufficient * factor * decrease)
        while too_long.any():
            factor[too_long] /= 2
            trial = mesh.nodal(u + factor[:, None] * step)
            too_long = searched & (trial[0] > energy - _NEWTON.sufficient * factor * decrease)
        u = u + factor[:, None] * step
        energy, gradient, hessian = trial

        unsettled &= ~(last_decrease <= _NEWTON.still * np.abs(energy))  # nan is not settled
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
    """The mesh of elements beside lines; on a disc that reaches the axis there is no far field.

    Parameters
    ----------
    side : {1, -1}
    s, sines : ndarray (n,)
        Radii of the lines [l], and what pulls at them [γ₁].
    lengths : ndarray (n, m)
        From `elements`.
    """
    points, weights, _ = gauss_lobatto(DEGREE)
    first_end = np.zeros((s.size, 1))
    ends = np.cumsum(np.hstack([first_end, lengths]), axis=1)  # distances from the line
    half = lengths[:, :, None] / 2
    distance = ends[:, :-1, None] + half * (points + 1)
    radius_ratio = 1 + side * distance / s[:, None, None]  # r over s
    measure = np.maximum(weights * half * radius_ratio, 0.0)  # at the axis 0 but for rounding
    last_radius = np.maximum(s + side * ends[:, -1], 0.0)
    far = last_radius / s * far_stiffness(side, last_radius)
    return _Mesh(half, measure, far, sines)


class _Mesh(NamedTuple):
    """Meshes of n surfaces with m elements each.

    Attributes
    ----------
    half : ndarray (n, m, 1)
        Half the lengths of the elements [l].
    measure : ndarray (n, m, DEGREE + 1)
        Weights of their nodes in integrals, times 1 ± x/s.
    far : ndarray (n,)
        Stiffness of the far field beyond the last node, per length of the line [γ₁/l].
    sines : ndarray (n,)
        S = sin φ, what pulls at the lines.
    """

    half: Array
    measure: Array
    far: Array
    sines: Array

    def nodal(self, u: Array) -> tuple[Array, Array, Array]:
        """Energy less the work of the pull at the line, with its derivatives.

        Parameters
        ----------
        u : ndarray (n, nodes)
            Nodal displacements [l].

        Returns
        -------
        energy : ndarray (n,)
            F - S u₀.
        gradient : ndarray (n, nodes)
            Its derivatives by the nodal displacements.
        hessian : ndarray (n, DEGREE + 1, nodes)
            Its second derivatives, in the lower banded form of LAPACK: row i is the i-th diagonal
            below the main one.
        """
        derivative = gauss_lobatto(DEGREE).derivative
        first_nodes = np.arange(self.half.shape[1])[:, None] * DEGREE
        own = u[:, first_nodes + np.arange(DEGREE + 1)]  # (n, m, DEGREE + 1), of each element
        slope = (own @ derivative.T) / self.half  # du/dx
        root = np.sqrt(1 + slope * slope)
        density = own * own / 2 + slope * slope / (1 + root)  # √(1+u'²) - 1 without cancellation
        energy = (self.measure * density).sum(axis=(1, 2)) + self.far * u[:, -1] ** 2 / 2

        tension = self.measure * slope / root / self.half
        forces = self.measure * own + tension @ derivative  # of each element
        gradient = np.zeros_like(u)
        gradient[:, :-1] = forces[:, :, :-1].reshape(u.shape[0], -1)
        gradient[:, DEGREE::DEGREE] += forces[:, :, -1]  # the last node is the next one's first
        gradient[:, -1] += self.far * u[:, -1]
        gradient[:, 0] -= self.sines

        bend = self.measure / root**3 / self.half**2
        blocks = np.matmul(derivative.T[None, None] * bend[:, :, None, :], derivative)
        blocks[:, :, np.arange(DEGREE + 1), np.arange(DEGREE + 1)] += self.measure
        hessian = band(blocks)
        hessian[:, 0, -1] += self.far
        return energy - self.sines * u[:, 0], gradient, hessian


def _solved(kind: int, s: Array) -> Array:
    """What the family holds of one kind at radii s (n,): g and e over `leading_order`.

    Returns an ndarray (n, 2 · inclinations): the Chebyshev coefficients, in sin²(φ/2) over the
    range of the kind, of g and then of e.
    """
    side = np.sign(kind)
    piece = int(abs(kind) > 1)  # 0 for mild lines, 1 for steep ones
    low = _SQUARES[piece]
    high = _SQUARES[piece + 1]
    places = chebpts1(_PIECE.inclinations)
    half_sines = np.sqrt(low + (high - low) * (places + 1) / 2)  # sin(φ/2)
    grid = np.meshgrid(s, half_sines, indexing="ij")
    radii, halves = (part.ravel() for part in grid)
    sines = 2 * halves * np.sqrt(1 - halves**2)  # sin φ
    found = solve(side, radii, sines, _HALVINGS[piece])
    values = np.array([found.u[:, 0] / halves, found.energy / halves**2])
    values = values / leading_order(side, radii)
    to_coefficients = np.linalg.inv(chebyshev(places, _PIECE.inclinations)).T
    return np.hstack(values.reshape(2, s.size, -1) @ to_coefficients)


_OUTSIDE = shipped(_SOLVED, _PIECE.octaves)
_ON_DISCS = shipped(LEAST_RADIUS[-1], _PIECE.octaves)
# Its kinds are the side, and twice the side for steep lines.
FAMILY = Family(
    "menisci",
    _solved,
    2 * _PIECE.inclinations,
    _PIECE.radii,
    _PIECE.octaves,
    {1: _OUTSIDE, 2: _OUTSIDE, -1: _ON_DISCS, -2: _ON_DISCS},
)


def read(side: Any, s: Array, phi: Array) -> tuple[Array, Array]:
    """Displacement and energy of surfaces whose inclination is known.

    They are read from the family for radii down to s₀ = 2⁻²⁰ l. Outside smaller ones springs do not
    matter next to the line, and a surface is a catenoid there: beside its own line u₀/s and F/s
    differ from those at s₀ with the same φ by -sin φ and -sin² φ/2 times log(s/s₀), but for
    s² log² s.

    Parameters
    ----------
    side : int or ndarray (n,)
        1 beyond the lines, -1 on the discs inside.
    s, phi : ndarray (n,)
        Radii [l], on discs at least LEAST_RADIUS[-1], and inclinations at the lines [rad]. Steeper
        ones than STEEPEST count as that.

    Returns
    -------
    u0, energy : ndarray (n,)
        u₀ [l] and F per length of the line [γ₁ l].
    """
    known = np.maximum(s, _SOLVED)
    half_sine = np.sin(np.minimum(np.abs(phi), STEEPEST) / 2)
    piece = (np.abs(phi) > _MILD).astype(int)
    low = _SQUARES[piece]
    high = _SQUARES[piece + 1]
    place = 2 * (half_sine * half_sine - low) / (high - low) - 1
    basis = chebyshev(place, _PIECE.inclinations)
    coefficients = FAMILY.at(side * (1 + piece), known).reshape(s.size, 2, _PIECE.inclinations)
    g, e = (coefficients * basis[:, None]).sum(axis=2).T * leading_order(side, known)

    ratio = np.minimum(s / _SOLVED, 1.0)  # s/s₀
    sine = np.sin(np.clip(phi, -STEEPEST, STEEPEST))
    logarithm = -ratio * _SOLVED * np.log(ratio) * sine
    u0 = ratio * np.copysign(half_sine * g, phi) + logarithm
    energy = ratio * half_sine**2 * e + logarithm * sine / 2
    return u0, energy


def inclination(side: int, s: Array, u0: Array) -> Array:
    """Inclination of surfaces whose displacement at the line is known, the zero of `read` in φ.

    Parameters
    ----------
    side : {1, -1}
        1 beyond the lines, -1 on the discs inside.
    s, u0 : ndarray (n,)
        Radii of the lines, and displacements there [l].

    Returns
    -------
    ndarray (n,)
        φ [rad], at most STEEPEST.
    """
    rise = 1 / stiffness(side, s)  # du₀/dφ of small slopes
    most = np.full_like(s, STEEPEST)
    of_small_slopes = u0 / rise
    # That of small slopes where it is small, and at most 2, so that steep ones begin nearby.
    guess = of_small_slopes / np.sqrt(1 + of_small_slopes * of_small_slopes / 4)
    guess = np.clip(guess, -most, most)

    def excess(phi: Array, own: Indices) -> Array:
        """u₀ at these inclinations, of the surfaces with these numbers, less what it should be."""
        return read(side, s[own], phi)[0] - u0[own]

    return crossings(excess, -most, most, guess, rise, 0.0)


# A drawing needs the same surface at other places; one holds some 3 kB, all less than 1 MB.
@functools.lru_cache(maxsize=256)
def surface(side: int, s: float, u0: float) -> tuple[Array, Array]:
    """The surface beside a line of this radius, displaced by u₀ there.

    Parameters
    ----------
    side : {1, -1}
        1 beyond the line, -1 on the disc inside.
    s, u0 : float
        [l].

    Returns
    -------
    ends : ndarray (m + 1,)
        Distances of the ends of its elements from the line [l].
    u : ndarray (m * DEGREE + 1,)
        Nodal displacements, from the line on [l].
    """
    radius = np.array([s])
    phi = inclination(side, radius, np.array([u0]))
    is_steep = abs(float(phi[0])) > _MILD
    found = solve(side, radius, np.sin(phi), _HALVINGS[is_steep])
    return np.append(0.0, np.cumsum(found.lengths[0])), found.u[0]


class MeniscusSurfaces(Surfaces):
    """Free surfaces about an axis with finite slopes; its methods are those of `Surfaces`."""

    lost = (
        "is inclined by more than 86°, which no mesh of this kind resolves (beyond 90° there is no "
        "state), or ends in a disc narrower than 3e-5 l"
    )

    def at_rest(self, side: Any, s: Any, width: Any, rise: Any, outward_slope: Any, w: Any) -> Any:
        """Displacement of a line at rest, read from its inclination φ, which is known.

        Where there is no such surface u only has to lead a root finder back to those that are:

        - beyond the steepest inclination of the family it grows on with sin(φ/2);
        - of a contact that is a point at the axis it is that of small slopes at the radius 2⁻⁴⁰ l,
          next to nothing and of the right sign;
        - on a disc narrower than any that is known it is the greater in size the narrower the disc;
        - a line at the axis whose surface were inside it is none, and rests at any depth.
        """
        self._raise_for_ring(s + side * width)
        is_number = not np.ndim(s)
        angle_at_line = np.arctan(outward_slope)  # β
        phi = angle_at_line - 2 * np.arcsin(np.sqrt(w / 2))
        side, s, phi = np.broadcast_arrays(*map(np.atleast_1d, (side, s, phi)))
        is_outside = side > 0
        is_off_axis = s > 0

        least_radius = np.where(is_outside, LEAST_RADIUS[1], LEAST_RADIUS[-1])
        known = np.maximum(s, least_radius)
        u = np.sin(phi) * leading_order(1, AXIS_RADIUS)  # of lines at the axis
        u_off_axis, _ = read(side[is_off_axis], known[is_off_axis], phi[is_off_axis])
        u[is_off_axis] = u_off_axis

        beyond_steepest = np.abs(np.sin(phi / 2)) / math.sin(STEEPEST / 2)
        within_narrowest_disc = known / np.maximum(s, AXIS_RADIUS)
        growth = np.maximum(beyond_steepest, 1.0)
        growth = growth * np.where(is_outside, 1.0, within_narrowest_disc)
        u = np.where(is_off_axis | is_outside, u * growth, ANY)
        return u[0] if is_number else u

    def _raise_for_ring(self, other: Any) -> None:
        """Raise ValueError if another line is at a finite radius `other` [l]."""
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
        """Those of the family, per radian.

        Lines closer to the axis than any that is known have F and sin φ of the closest one: a
        surface there is neither steep nor worth anything.
        """
        known = np.maximum(s, LEAST_RADIUS[side])
        phi = inclination(side, known, u)
        too_steep = np.abs(phi) >= STEEPEST * (1 - _UPRIGHT)
        if (too_steep & (s >= LEAST_RADIUS[side])).any():
            return None
        return s * read(side, known, phi)[1], s * np.sin(phi)

    def solved(self, side: int, s: float, width: float, u: float, rise: float) -> Free | None:
        """One surface; None if it is too steep, or a disc narrower than any that is known.

        As all nodes of the mesh are balanced, k∫u over the surface is what its line pulls.
        """
        found = self.energy_and_reaction(side, np.array([s]), width, np.array([u]), rise)
        if s < LEAST_RADIUS[side] or found is None:
            return None
        energy, pull = (part.item() for part in found)
        return Free(energy, (pull, 0.0), pull, self._imbalance(side, s, u, pull / s))

    def _imbalance(self, side: int, s: float, u: float, sine: float) -> float:
        """How far d(sF)/ds is from ±s (1 - cos φ - u₀²/2), over the terms of that.

        The derivative is taken at a given u₀. Next to 90° the inclination at a given u₀ changes
        ever faster with the radius. There φ is given in its place, and the work s sin φ du₀ of what
        u₀ changes by is subtracted. Both sides are divided by s.

        Parameters
        ----------
        side, s, u
            As of `Surfaces`.
        sine : float
            sin φ.

        Returns
        -------
        float
            Dimensionless.
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
        expected = side * (sine * sine / (1 + cosine) - u * u / 2)  # 1 - cos φ without cancellation
        return abs(rate - expected) / (sine * sine + u * u or 1.0)

    def profile(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """The elements' polynomials, then the far field, at distances x from the line."""
        self._raise_for_ring(s + side * width)
        if not s:  # at the axis there is no surface inside, and outside a point displaces none
            return np.zeros_like(x), np.zeros_like(x)
        ends, nodal = surface(side, s, u)
        end = ends[-1]
        near = on_elements(ends, nodal, np.minimum(x, end))
        far = nodal[-1] * decayed(side, s + side * end, s + side * x)
        values, slopes = np.where(x < end, near, far)
        return values, slopes
