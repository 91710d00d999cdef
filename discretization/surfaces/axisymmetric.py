"""What lines about an axis feel of free surfaces with small slopes, in units of l and γ₁.

Beyond a line of radius s, and on the disc inside one, the reaction per length of the line is the
displacement times a stiffness S(s), a function of the radius alone. It is solved on the mesh
(mesh.linear) at a few radii of every octave and read in between as a polynomial in log s.

A ring between two lines q < p is condensed to both: an element by elimination of its inner nodes,
with σ_q and σ_p the stiffness of each end and τ that of what ties them, so that

    E/(2π) = σ_q u_q²/2 + σ_p u_p²/2 + τ (u_q - u_p)²/2,

and elements in a row by sums of positive numbers. Lines more than 40 l apart do not feel each
other.
"""

from __future__ import annotations

import functools
import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded

from discretization.surfaces.mesh import ELEMENTS, far_stiffness, linear
from discretization.surfaces.polynomials import horner, powers
from discretization.surfaces.spectral import band, polynomials, rounded

Array = NDArray[np.float64]
_POINTS = {1: 12, -1: 16}  # of an octave of radii: the polynomial is then exact to rounding
_OUTER = 2  # octaves: from there on the elements beside a line end at the exact far field
_LEAST = -30  # octaves: inside of 2^-30 l the springs do nothing
FAR = 40.0  # l: the lines of a ring this wide do not feel each other, e^-40 = 4e-18
_WIDER = 1.5  # ends of elements of a ring, over each other
_LONGEST = 1.0  # l: of an element, far from the axis


def stiffness(degree: int, side: int, s: Any) -> Any:
    """S(s) beyond lines of radius s (side +1), or on the disc inside them (-1), number or array.

    Infinite beyond a line at the axis, 0 inside it.
    """
    if not np.ndim(s):
        octave = math.floor(math.log2(max(s, 2.0 ** (_LEAST - 1))))
        return _read(degree, side, s, octave)
    found = np.empty_like(s)
    octaves = np.floor(np.log2(np.maximum(s, 2.0 ** (_LEAST - 1))))
    for octave in set(octaves.tolist()):
        own = octaves == octave
        found[own] = _read(degree, side, s[own], int(octave))
    return found


def _read(degree: int, side: int, s: Any, octave: int) -> Any:
    """S of radii in an octave; below the last one that of a disc without springs, or a ring."""
    if octave >= _LEAST:
        log2 = np.log2 if np.ndim(s) else math.log2
        value = horner(_family(degree, side, octave), 2 * (log2(s) - octave) - 1)
        return value * (1 + s) / s if side > 0 else value * s / (2 + s)
    if side < 0:
        return s / 2
    least = 2.0**_LEAST
    inner = 1 / (least * _read(degree, side, least, _LEAST))
    with np.errstate(divide="ignore"):
        return np.divide(1.0, np.where(np.equal(s, 0), 0.0, s * (inner - np.log(s / least))))


@functools.lru_cache(maxsize=256)
def _family(degree: int, side: int, octave: int) -> tuple[float, ...]:
    """The polynomial of S s/(1+s) outside and S (2+s)/s inside, smooth at small and great s."""
    t = np.sort(np.cos(np.pi * (np.arange(_POINTS[side]) + 0.5) / _POINTS[side]))
    s = 2.0 ** (octave + (t + 1) / 2)
    if side < 0:
        solved = np.array([linear(degree, -one).reaction for one in s.tolist()])
        return tuple(powers(t, solved * (2 + s) / s).tolist())
    return tuple(powers(t, _outside(degree, s, octave) * s / (1 + s)).tolist())


def _outside(degree: int, s: Array, octave: int) -> Array:
    """S of a tail from that of another one further out, with elements in between."""
    if octave < _OUTER:
        end = 2 * s
        beyond = stiffness(degree, 1, end)
    else:
        end = s + sum(ELEMENTS)
        beyond = np.array([far_stiffness(r, 0.0) for r in end.tolist()])
    between = ring(degree, s, end)
    rest = between.outer + end * beyond
    return np.asarray((between.inner + between.tie * rest / (between.tie + rest)) / s)


class Ring(NamedTuple):
    """σ_q, τ and σ_p of rings, numbers or arrays."""

    inner: Any
    tie: Any
    outer: Any


def ring(degree: int, q: Any, p: Any) -> Ring:
    """Rings between lines of radii q < p, numbers or arrays."""
    q, p = np.broadcast_arrays(np.atleast_1d(np.asarray(q, float)), p)
    found = Ring(np.zeros(q.shape), np.full(q.shape, math.inf), np.zeros(q.shape))
    near = (p - q <= FAR) & (q > 0)
    lo = q[near]
    whole = [part[near] for part in found]
    while (left := lo < p[near]).any():
        hi = np.minimum(p[near][left], _end(lo[left]))
        both = _joined(Ring(*(part[left] for part in whole)), _element(degree, lo[left], hi))
        for part, new in zip(whole, both, strict=True):
            part[left] = new
        lo = lo.copy()
        lo[left] = hi
    for part, new in zip(found, whole, strict=True):
        part[near] = new
    far = ~near
    if far.any():
        wide = np.where(q[far] > 0, q[far], 1.0)
        found.inner[far], found.tie[far] = q[far] * stiffness(degree, 1, wide), 0.0
        found.outer[far] = p[far] * stiffness(degree, -1, p[far])
    return found


def _end(start: Array) -> Array:
    """Where an element of a ring that starts here ends at the latest."""
    return start + np.minimum((_WIDER - 1) * start, _LONGEST)


def _joined(one: Ring, other: Ring) -> Ring:
    """Two rings in a row: the line between them is eliminated. A tie that is infinite: no ring."""
    middle = one.outer + other.inner
    with np.errstate(invalid="ignore"):
        whole = one.tie + other.tie + middle
        first = np.isinf(one.tie)
        share, rest = one.tie / whole, other.tie / whole
    share, rest = np.where(first, 1.0, share), np.where(first, 0.0, rest)
    return Ring(
        one.inner + share * middle,
        np.where(first, other.tie, rest * np.where(first, 0.0, one.tie)),
        np.where(first, other.outer, other.outer + rest * middle),
    )


def _element(degree: int, lo: Array, hi: Array) -> Ring:
    """One element from lo to hi (n,)."""
    hessian, mass = _matrices(degree, lo, hi)
    stiff = hessian.copy()
    hessian[:, np.arange(degree + 1), np.arange(degree + 1)] += mass
    loads = np.stack([mass, -hessian[:, :, -1]], axis=2)[:, 1:-1]
    less, tied = np.moveaxis(np.linalg.solve(hessian[:, 1:-1, 1:-1], loads), 2, 0)
    inner = mass[:, 0] - (stiff[:, 0, 1:-1] * less).sum(axis=1)
    outer = mass[:, -1] - (stiff[:, -1, 1:-1] * less).sum(axis=1)
    tie = -(hessian[:, 0, -1] + (hessian[:, 0, 1:-1] * tied).sum(axis=1))
    return Ring(inner, tie, outer)


def _matrices(degree: int, lo: Array, hi: Array) -> tuple[Array, Array]:
    """Matrices of ∫u'² r dr and weights of ∫u² r dr of elements (n, degree+1, degree+1)."""
    points, weights, d = rounded(degree)
    half = (hi - lo)[:, None] / 2
    measure = weights * (lo[:, None] + half * (points + 1))
    return (d.T * (measure / half)[:, None, :]) @ d, measure * half


class RingSurface(NamedTuple):
    """A ring's two surfaces, with u = 1 at its inner line and at its outer one: u (2, n).

    ends (m + 1,): of the elements; slopes (2, 2): outwards of the inner line, and of the outer one.
    """

    ends: Array
    u: Array
    slopes: Array
    areas: Array
    residual: float

    def at(self, r: Array) -> tuple[Array, Array]:
        """Both surfaces (2, n) at radii between the lines, and their derivatives."""
        degree = (self.u.shape[1] - 1) // (self.ends.size - 1)
        e = np.clip(np.searchsorted(self.ends, r, side="right") - 1, 0, self.ends.size - 2)
        width = np.diff(self.ends)[e]
        at = 2 * (r - self.ends[e]) / width - 1
        d, own = rounded(degree)[2], e[:, None] * degree + np.arange(degree + 1)
        found = [polynomials(degree, at, u[own]) for u in self.u]
        rates = [polynomials(degree, at, u[own] @ d.T) * 2 / width for u in self.u]
        return np.array(found), np.array(rates)


@functools.lru_cache(maxsize=256)
def ring_surface(degree: int, q: float, p: float) -> RingSurface:
    """The surfaces of a ring, solved once."""
    ends = [q]
    while ends[-1] < p:
        ends.append(min(p, float(_end(np.array(ends[-1])))))
    edges = np.array(ends)
    stiff, mass = _matrices(degree, edges[:-1], edges[1:])
    stiff[:, np.arange(degree + 1), np.arange(degree + 1)] += mass
    rows = band(stiff)
    u = np.zeros((rows.shape[1], 2))
    u[0, 0] = u[-1, 1] = 1
    loads = -_times(stiff, u)[1:-1]
    u[1:-1] = solveh_banded(rows[:, 1:-1], loads, lower=True, check_finite=False)
    u[1:-1] -= solveh_banded(rows[:, 1:-1], _times(stiff, u)[1:-1], lower=True, check_finite=False)
    d = rounded(degree)[2]
    slopes = np.array(
        [u[: degree + 1].T @ d[0] * 2 / (edges[1] - edges[0]),
         -(u[-degree - 1 :].T @ d[-1]) * 2 / (edges[-1] - edges[-2])]
    )  # fmt: skip
    left = _times(stiff, u)[1:-1]
    size = np.abs(np.diagonal(stiff, axis1=1, axis2=2)).max()
    own = np.arange(len(mass))[:, None] * degree + np.arange(degree + 1)
    areas = (mass[..., None] * u[own]).sum(axis=(0, 1))
    return RingSurface(edges, u.T.copy(), slopes, areas, float(np.abs(left).max() / size))


def _times(blocks: Array, u: Array) -> Array:
    """The product of the matrix of all elements with nodal values (n, 2)."""
    degree, found = blocks.shape[1] - 1, np.zeros_like(u)
    for e, block in enumerate(blocks):
        own = slice(e * degree, (e + 1) * degree + 1)
        found[own] += block @ u[own]
    return found
