"""Free surfaces about an axis with small slopes as networks, in units of l and γ₁.

A ring between lines q < p is a network (network.py) for E/(2π): elements, inner nodes eliminated.

Beyond a line of radius s, and on the disc inside one, the reaction per length of the line is the
displacement times a stiffness S(s), a function of the radius alone. It is that of some elements
beside the line and of the far field, eliminated exactly, and is kept as a family (network.py).
S is the exact quotient of Bessel functions, `far_stiffness`, to 7e-15: so the elements, which rings
between two lines need, are compared with it. It is read from the family since importing
scipy.special takes 80 ms, many times as long as a state; nothing but the elements' far field and
the shape of a surface (`far_stiffness`, `decayed`) does so.

Conventions
-----------
Lengths are in l and displacements u positive downwards, into the layer. `side` is 1 if a surface is
outside its line, at larger radii, and -1 if inside. s is the radius of a line, or of the first of
two. A `Network` has σ and τ, the stiffnesses that ground two terminals and tie them, [γ₁], for the
energy over 2π: of a single line σ = s S(s), the stiffness per radian. Its `left` is the first line
(in `ring` and `_element`, where no line is the first, the inner one), `right` the other one.
`then` joins a network with one on its right, and frees the point between them. `DECAYED` = 40 is
the distance in l at which a decay e^-x is less than rounding.

Of network.py, too: `gauss_lobatto(degree)` has degree + 1 points on [-1, 1], their weights, and the
matrix that differentiates values there. `band` sums matrices of elements in a row into LAPACK's
lower banded form. `on_elements(ends, values, x)` is a function and its slope at x from its nodal
values, and a `Shape` that pair. A `Family` reads functions of log s from polynomials on pieces of
log₂ s, which it solves for where they are not in its file; `one` is its values for one side and
radius, `at` those for arrays, `shipped` the numbers of the pieces in the file.
"""

import functools
import math
from typing import Any, NamedTuple

import numpy as np
import scipy
from scipy.linalg import solveh_banded

from discretization.certificate import DECAYED
from discretization.surfaces.network import (
    Family,
    Network,
    Shape,
    band,
    gauss_lobatto,
    on_elements,
    shipped,
)
from energy.arrays import Array


class RingMesh(NamedTuple):
    """Spectral elements about an axis, and the pieces on which S(s) is kept.

    With these S is right to rounding: at 60 random radii from 2⁻²⁰ to 2⁸ l, `_solved` changes by
    2e-14 of itself or less if `covered`, `disc_elements` or `longest` is halved or doubled or
    `growth` is 1.25 or 2. (Put another `RingMesh` into `_MESH` and compare `_solved` with
    `leading_order` times `far_stiffness`.)

    Attributes
    ----------
    degree : int
        Degree of the polynomials on an element: the least whose errors are rounding
        (tests/surfaces/test_families.py). Degree 6 leaves 1e-11, 24 as much as 12.
    points : int
        Chebyshev points of a piece of the family; with these its error is rounding. 14 leave 3e-8,
        and 56 as much as 28, 8e-15.
    octaves : float
        Length of a piece in log₂ s. With as many points pieces of 6 leave 7e-10; pieces of 1.5 are
        no better, but twice as many.
    covered : float
        Distance from a line up to which there are elements [l]; what is beyond is eliminated
        exactly.
    disc_elements : int
        Number of elements over that distance inside a line.
    growth : float
        Largest ratio of the radii of both ends of an element.
    longest : float
        Longest element, far from the axis [l].
    """

    degree: int = 12
    points: int = 28
    octaves: float = 3.0
    covered: float = 4.0
    disc_elements: int = 6
    growth: float = 1.5
    longest: float = 1.0


_MESH = RingMesh()


# l: a line at the axis is taken to have this radius. Springs change S by s² log s relative to the
# tension's own there, which is less than rounding.
AXIS_RADIUS = 2.0**-40


def stiffness(side: Any, s: Any) -> Any:
    """Reaction S of a free surface about an axis, per length and displacement of its line.

    It is 1/`leading_order` times the family, a function near 1. Of a line within s₀ = 2⁻⁴⁰ l of the
    axis, springs between it and s₀ do not matter. Outside the line u then falls by F log(r/s) if F
    is the force per radian, so that the compliance -log(s/s₀) is in series with that of s₀. The
    disc inside a line moves as a whole, and s S, the stiffness of its springs, is as s². At the
    axis S is taken to be that of the radius s₀.

    Parameters
    ----------
    side : int or ndarray
        1 beyond the line, -1 on the disc inside it; of an array s a number, or as many numbers.
    s : float or ndarray
        Radius of the line [l], real and finite.

    Returns
    -------
    float or ndarray
        [γ₁/l], of the shape of s.
    """
    if isinstance(s, float) and s >= AXIS_RADIUS:
        return float(FAMILY.one(side, s)[0] / leading_order(side, s))
    known = np.maximum(s, AXIS_RADIUS)
    values = FAMILY.at(side, np.ravel(known)).reshape(np.shape(known))
    found = values / leading_order(side, known)  # S at the radius, or at s₀
    if (known == s).all():
        return found[()]
    ratio = np.where(np.greater(s, 0), np.minimum(s / AXIS_RADIUS, 1.0), 1.0)  # s/s₀
    outside = found / (ratio * (1 - known * found * np.log(ratio)))
    inside = found * ratio
    return np.where(np.greater(side, 0), outside, inside)[()]


def leading_order(side: Any, s: Any) -> Any:
    """1/S(s) to leading order, by which the family is scaled.

    That is s log(1/s) outside lines of small radii s, 2/s inside them, and 1 for great radii.

    Parameters
    ----------
    side : int or ndarray
        1 beyond the line, -1 on the disc inside it.
    s : float or ndarray
        Radius of the line [l], > 0.

    Returns
    -------
    float or ndarray
        [l/γ₁].
    """
    part = s / (1 + s)  # s for small radii, 1 for great ones
    if isinstance(s, float):
        return part * (1 - math.log(part)) if side > 0 else 1 + 2 / s
    return np.where(np.greater(side, 0), part * (1 - np.log(part)), 1 + 2 / s)


def _solved(side: int, s: Array) -> Array:
    """S(s) times `leading_order` (n, 1), by elements and the exact far field beyond them.

    side: 1 beyond lines of the radii s (n,), -1 on the discs inside.

    A disc narrower than `covered` is all elements: at the axis its far field is 0. The quotient
    `far_stiffness(side, s)` itself would do here; see the head of the module.
    """
    if side > 0:
        end = s + _MESH.covered
        far = Network(end * far_stiffness(1, end), 0.0, 0.0)
        per_radian = ring(s, np.full_like(s, _MESH.covered)).then(far).left
    else:
        start = np.maximum(s - _MESH.covered, 0.0)
        width = (s - start) / _MESH.disc_elements
        disc = Network(0.0, 0.0, start * far_stiffness(-1, start))
        for i in range(_MESH.disc_elements):
            disc = disc.then(_element(start + i * width, width))
        per_radian = disc.right
    return np.asarray(per_radian / s * leading_order(side, s))[:, None]


_PIECES = shipped(AXIS_RADIUS, _MESH.octaves)
FAMILY = Family("rings", _solved, 1, _MESH.points, _MESH.octaves, {1: _PIECES, -1: _PIECES})


def far_stiffness(side: int, r: Any) -> Any:
    """The exact reaction of a surface that has no other line, per length and displacement.

    The solutions of u'' + u'/r = u that decay: K₁(r)/K₀(r) outside, I₁(r)/I₀(r) inside.

    Parameters
    ----------
    side : {1, -1}
        1 for all that is outside the radius, -1 for the disc inside.
    r : float or ndarray
        [l], > 0; inside also 0, where the result is 0.

    Returns
    -------
    float or ndarray
        [γ₁/l].
    """
    if side > 0:
        return scipy.special.k1e(r) / scipy.special.k0e(r)
    return scipy.special.i1e(r) / scipy.special.i0e(r)


def decayed(side: int, start: Any, r: Array) -> Array:
    """The exact surface beside a line that is displaced by 1 and has no other line.

    Parameters
    ----------
    side : {1, -1}
        1 outside the line, -1 inside.
    start : float
        Radius of the line [l].
    r : ndarray (n,)
        Radii on that side of the line [l].

    Returns
    -------
    ndarray (2, n)
        u, and its derivative in the direction away from the line, which is negative.
    """
    bessel = scipy.special.k0e if side > 0 else scipy.special.i0e
    u = bessel(r) / bessel(start) * np.exp(side * (start - r))
    return np.array([u, -u * far_stiffness(side, r)])


def ring(q: Array, width: Array) -> Network:
    """Rings outside lines of radii q (n,), element after element from the inner line on.

    Parameters
    ----------
    q, width : ndarray (n,)
        Inner radii > 0, and widths [l]; complex for derivatives by them (small.py).

    Returns
    -------
    Network
        Of arrays (n,), the inner line on the left.
    """
    first = np.minimum(width, _longest(q))
    found = _element(q, first)
    reached = q + first
    end = q + width
    unfinished = np.real(reached) < np.real(end)
    while unfinished.any():
        start = reached[unfinished]
        more = np.minimum(end[unfinished] - start, _longest(start))
        longer = Network(*(part[unfinished] for part in found)).then(_element(start, more))
        for part, new in zip(found, longer, strict=True):
            part[unfinished] = new
        reached[unfinished] += more
        unfinished = np.real(reached) < np.real(end)
    return found


def _longest(start: Array) -> Array:
    """Largest width of an element of a ring that begins at these radii, at least one rounding.

    Without that the sum of the widths would not grow, and the loop in `ring` not end.
    """
    by_growth = (_MESH.growth - 1) * start
    rounding = np.spacing(np.real(start))
    return np.maximum(np.minimum(by_growth, _MESH.longest), rounding)


def _element(start: Array, width: Array) -> Network:
    """Elements of these widths outside radii (n,), whose inner nodes are eliminated.

    With H = K + M, K of the tension and M of the springs, the inner nodes are at 1 - H_ii⁻¹ M_i if
    both ends are displaced by 1. As K has no forces on a displacement that is the same everywhere,
    the ends then take M_e - K_ei H_ii⁻¹ M_i, which is what grounds them. If the outer end alone is
    displaced by 1, the inner nodes are at -H_ii⁻¹ K_io, and -τ is what the inner end takes. So no
    large numbers are subtracted that would cancel.
    """
    stiffness, mass = _matrices(start, width)
    of_springs = mass[:, :, None] * np.eye(_MESH.degree + 1)
    hessian = stiffness + of_springs
    inner = slice(1, -1)
    ends = [0, -1]

    loads = np.stack([mass, -stiffness[:, :, -1]], axis=2)  # M_i, and -K_io
    solved = np.linalg.solve(hessian[:, inner, inner], loads[:, inner])
    from_inner = stiffness[:, ends, inner] @ solved
    left, right = (mass[:, ends] - from_inner[:, :, 0]).T
    tie = -stiffness[:, 0, -1] - from_inner[:, 0, 1]
    return Network(left, tie, right)


def _matrices(start: Array, width: Array) -> tuple[Array, Array]:
    """Tension and springs of elements of these widths outside radii (n,).

    Returns the matrices K (n, degree + 1, degree + 1) of ∫u'² r dr, and the diagonals M
    (n, degree + 1) of ∫u² r dr, which the Gauss-Lobatto rule makes diagonal.
    """
    points, weights, derivative = gauss_lobatto(_MESH.degree)
    half = width[:, None] / 2
    measure = weights * (start[:, None] + half * (points + 1))
    return (derivative.T * (measure / half)[:, None, :]) @ derivative, measure * half


class Axis:
    """The networks of free surfaces about an axis, with the methods of `network.Line`."""

    def between(self, side: Any, s: Any, width: Any) -> Network:
        """The surface from one line to another.

        Parameters
        ----------
        side : int or ndarray
            1 if the other line is outside the first one, -1 if inside.
        s, width : float, complex or ndarray
            Radius of the first line, and distance of the other one [l], which is infinite if there
            is none. Where `width` is s inwards there is none either: the surface is a disc. Both
            are complex if one of them is. Outwards an infinite width is a number, for all s alike:
            in an array there would be another line, of infinite radius.

        Returns
        -------
        Network
            For E/(2π), the first line on its left.
        """
        if not isinstance(width, np.ndarray) and width == math.inf:
            return Network(s * stiffness(side, s), 0.0, 0.0)
        many = np.ndim(s) or np.ndim(width) or np.ndim(side)
        side, s, width = np.broadcast_arrays(*map(np.atleast_1d, (side, s, width)))
        outwards = side > 0
        other = s + side * width
        inner = np.where(outwards, s, other)
        outer = np.where(outwards, other, s)
        found = np.zeros((3, s.size), s.dtype)  # σ of the inner line, τ, σ of the outer one
        near = (np.real(width) <= DECAYED) & (np.real(inner) > 0)
        if near.any():
            found[:, near] = ring(inner[near], width[near])
        # Lines that do not feel each other are grounded as if they were alone, and not tied.
        beyond_inner = ~near & (np.real(inner) > 0)
        if beyond_inner.any():
            found[0, beyond_inner] = inner[beyond_inner] * stiffness(1, inner[beyond_inner])
        inside_outer = ~near & (np.real(outer) > 0)
        if inside_outer.any():
            found[2, inside_outer] = outer[inside_outer] * stiffness(-1, outer[inside_outer])
        found = np.where(outwards, found, found[::-1])
        return Network(*found if many else found[:, 0])

    def shape(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """Displacement and slope of a surface between two lines, or beside one.

        They are those of a mesh of the ring, or, if its lines are far apart or one is the axis, of
        the exact decays from each line.

        Parameters
        ----------
        x : ndarray (n,)
            Distances from the first line, towards the other one [l].
        side : {1, -1}
            1 if the surface is outside the first line; so it is if there are two lines.
        s, width : float
            Radius of the first line, and distance of the other one [l], infinite if there is none:
            so it is of a disc, too, whose `side` is -1.
        u, rise : float
            Displacement of the first line, and how much more the other one is displaced [l].

        Returns
        -------
        u, slope : ndarray (n,)
            [l], and du/dx.
        """
        if width <= DECAYED and s > 0:
            ends, nodal = _mesh(s, width)
            bend, bend_slope = on_elements(ends, u * nodal[0] + rise * nodal[1], x)
            return u + rise * x / width + bend, rise / width + bend_slope
        radii = s + side * x
        other = s + side * width
        values = np.zeros(x.size)
        slopes = np.zeros(x.size)
        for direction, line, displacement in ((side, s, u), (-side, other, u + rise)):
            if 0 < line < math.inf:
                value, slope_away = decayed(direction, line, radii)
                values += displacement * value
                # `slope_away` is by the distance from `line`, du/dx by that from the first line.
                slopes += displacement * (direction * side * slope_away)
        return values, slopes


# A drawing needs the same surface at other places. A mesh costs 0.2 to 1.2 ms and less than 7 kB,
# so that 256 of them, as many gaps as rough scenes have, take no more than 2 MB.
@functools.lru_cache(maxsize=256)
def _mesh(q: float, width: float) -> tuple[Array, Array]:
    """Elements of a ring of this width outside the radius q, and the surface over them.

    Returns the distances of their ends from the inner line (e + 1,), and nodal w (2, nodes): the
    surface between lines displaced by u and u + r is u (1 + w₀) + r (t + w₁), t growing from 0 to 1
    in proportion to the distance, and w = 0 at both lines. They balance the loads that the
    displacements 1 and t leave.
    """
    parts = [0.0]
    while parts[-1] < width:
        longest = float(_longest(np.array(q + parts[-1])))
        parts.append(min(width, parts[-1] + longest))
    ends = np.array(parts)
    lengths = np.diff(ends)
    stiffness, mass = _matrices(q + ends[:-1], lengths)
    first_nodes = np.arange(len(mass))[:, None] * _MESH.degree
    nodes = first_nodes + np.arange(_MESH.degree + 1)  # of each element

    # The fields 1 and t at all nodes, and what tension and springs load them with.
    place_on_element = (gauss_lobatto(_MESH.degree).points + 1) / 2
    fields = np.ones((nodes[-1, -1] + 1, 2))
    fields[nodes, 1] = (ends[:-1, None] + lengths[:, None] * place_on_element) / width
    of_tension = stiffness @ (fields[nodes] - (1, 0))  # a field that is 1 everywhere has none
    of_springs = mass[:, :, None] * fields[nodes]
    loads = np.zeros_like(fields)
    np.add.at(loads, nodes, of_tension + of_springs)

    hessian = band(stiffness + mass[:, :, None] * np.eye(_MESH.degree + 1))
    w = np.zeros_like(fields)
    w[1:-1] = -solveh_banded(hessian[:, 1:-1], loads[1:-1], lower=True, check_finite=False)
    return ends, w.T
