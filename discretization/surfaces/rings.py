"""Free surfaces about an axis with small slopes as networks, in units of l and γ₁.

A ring between lines q < p is a network (network.py) for E/(2π): elements, inner nodes eliminated.

Beyond a line of radius s, and on the disc inside one, the reaction per length of the line is the
displacement times a stiffness S(s), a function of the radius alone. It is that of some elements
beside the line and of the far field, eliminated exactly, and is kept as a family (network.py).
"""

import functools
import math
from typing import Any

import numpy as np
import scipy
from scipy.linalg import solveh_banded

from discretization.surfaces.network import (
    FAR,
    Family,
    Network,
    Shape,
    band,
    on_elements,
    rounded,
    shipped,
)
from energy.arrays import Array

_DEGREE = 12  # the least whose errors are rounding
_POINTS, _OCTAVES = 28, 3.0  # of a piece of radii: the polynomial is then exact to rounding
_COVERED, _DISC = 4.0, 6  # l: beside a line, by elements; by how many inside it
_WIDER = 1.5  # ends of elements of a ring, over each other
_LONGEST = 1.0  # l: of an element, far from the axis
BESIDE = 2.0**-40  # l: a line at the axis is asked for at this radius


def stiffness(side: Any, s: Any) -> Any:
    """S(s) beyond lines of radii s (side +1), or on the disc inside them (-1).

    Within 2⁻⁴⁰ l of the axis that of a ring or a disc without springs; at the axis as just there.
    """
    if isinstance(s, float) and s >= BESIDE:
        return float(FAMILY.one(side, s)[0] / rough(side, s))
    near = np.maximum(s, BESIDE)
    found = FAMILY.at(side, np.ravel(near)).reshape(np.shape(near)) / rough(side, near)
    if (near == s).all():
        return found[()]
    part = np.where(np.greater(s, 0), np.minimum(s / BESIDE, 1.0), 1.0)
    ring = found / (part * (1 - near * found * np.log(part)))
    return np.where(np.greater(side, 0), ring, found * part)[()]


def rough(side: Any, s: Any) -> Any:
    """1/S(s), roughly: s log(1/s) beside small radii, 2/s inside them, 1 for great ones."""
    part = s / (1 + s)
    if isinstance(s, float):
        return part * (1 - math.log(part)) if side > 0 else 1 + 2 / s
    return np.where(np.greater(side, 0), part * (1 - np.log(part)), 1 + 2 / s)


def _solved(side: int, s: Array) -> Array:
    """S(s) over what it is roughly (n, 1), by elements and the exact far field beyond them."""
    if side > 0:
        end = s + _COVERED
        far = Network(end * far_stiffness(1, end), 0.0, 0.0)
        pull = ring(s, np.full_like(s, _COVERED)).then(far).left
    else:
        start = np.maximum(s - _COVERED, 0.0)
        found, width = Network(0.0, 0.0, start * far_stiffness(-1, start)), (s - start) / _DISC
        for i in range(_DISC):
            found = found.then(_element(start + i * width, width))
        pull = found.right
    return np.asarray(pull / s * rough(side, s))[:, None]


_PIECES = shipped(BESIDE, _OCTAVES)
FAMILY = Family("rings", _solved, 1, _POINTS, _OCTAVES, {1: _PIECES, -1: _PIECES})


def far_stiffness(side: int, r: Any) -> Any:
    """The exact reaction of all that is beyond a radius, per length and displacement there."""
    if side > 0:
        return scipy.special.k1e(r) / scipy.special.k0e(r)
    return scipy.special.i1e(r) / scipy.special.i0e(r)


def decayed(side: int, start: Any, r: Array) -> Array:
    """u at radii r beyond a line displaced by 1, and u' outwards (2, n): the exact decay."""
    bessel = scipy.special.k0e if side > 0 else scipy.special.i0e
    u = bessel(r) / bessel(start) * np.exp(side * (start - r))
    return np.array([u, -u * far_stiffness(side, r)])


def ring(q: Array, width: Array) -> Network:
    """Rings of these widths beyond lines of radii q (n,)."""
    first = np.minimum(width, _longest(q))
    found, lo, end = _element(q, first), q + first, q + width
    while (left := np.real(lo) < np.real(end)).any():
        more = np.minimum(end[left] - lo[left], _longest(lo[left]))
        longer = Network(*(part[left] for part in found)).then(_element(lo[left], more))
        for part, new in zip(found, longer, strict=True):
            part[left] = new
        lo[left] += more
    return found


def _longest(start: Array) -> Array:
    """How wide an element of a ring may be that starts there."""
    return np.maximum(np.minimum((_WIDER - 1) * start, _LONGEST), np.spacing(np.real(start)))


def _element(lo: Array, width: Array) -> Network:
    """One element of this width beyond lo (n,)."""
    stiff, mass = _matrices(lo, width)
    hessian = stiff + mass[:, :, None] * np.eye(_DEGREE + 1)
    loads = np.stack([mass, -stiff[:, :, -1]], axis=2)[:, 1:-1]
    taken = stiff[:, [0, -1], 1:-1] @ np.linalg.solve(hessian[:, 1:-1, 1:-1], loads)
    inner, outer = (mass[:, [0, -1]] - taken[:, :, 0]).T
    return Network(inner, -stiff[:, 0, -1] - taken[:, 0, 1], outer)


def _matrices(lo: Array, width: Array) -> tuple[Array, Array]:
    """Matrices of ∫u'² r dr and weights of ∫u² r dr of elements (n, degree+1, degree+1)."""
    points, weights, d = rounded(_DEGREE)
    half = width[:, None] / 2
    measure = weights * (lo[:, None] + half * (points + 1))
    return (d.T * (measure / half)[:, None, :]) @ d, measure * half


class Axis:
    """The networks about an axis: the questions of network.Line."""

    def between(self, side: Any, s: Any, width: Any) -> Network:
        """From lines of radii s to others, this much further to a side; ∞ where there is none."""
        if not isinstance(width, np.ndarray) and width == math.inf:
            return Network(s * stiffness(side, s), 0.0, 0.0)
        many = np.ndim(s) or np.ndim(width) or np.ndim(side)
        side, s, width = np.broadcast_arrays(*map(np.atleast_1d, (side, s, width)))
        out, other = side > 0, s + side * width
        q, p = np.where(out, s, other), np.where(out, other, s)
        near = (np.real(width) <= FAR) & (np.real(q) > 0)
        found = np.zeros((3, s.size), s.dtype)
        if near.any():
            found[:, near] = ring(q[near], width[near])
        for part, way, line in ((0, 1, q), (2, -1, p)):
            own = ~near & (np.real(line) > 0)
            if own.any():
                found[part, own] = line[own] * stiffness(way, line[own])
        found = np.where(out, found, found[::-1])
        return Network(*found if many else found[:, 0])

    def shape(self, x: Array, side: int, s: float, width: float, u: float, rise: float) -> Shape:
        """The same on a mesh of the whole ring, or what is left beyond lines far apart."""
        if width <= FAR and s > 0:
            ends, w = _mesh(s, width)
            bent, slope = on_elements(ends, u * w[0] + rise * w[1], x)
            return u + rise * x / width + bent, rise / width + slope
        found = np.zeros((2, x.size))
        for way, line, size in ((side, s, u), (-side, s + side * width, u + rise)):
            if 0 < line < math.inf:
                turn = np.array([[1], [way * side]])  # outwards of the first line
                found += size * turn * decayed(way, line, s + side * x)
        return found[0], found[1]


@functools.lru_cache(maxsize=256)
def _mesh(q: float, width: float) -> tuple[Array, Array]:
    """Ends of elements from the inner line on, and nodal w (2, nodes), which vanishes at the lines.

    The surface between two lines displaced by u and u + r is u (1 + w₀) + r (t + w₁), t from 0 to 1
    in between: by elimination, repeated on its residual.
    """
    parts = [0.0]
    while parts[-1] < width:
        parts.append(min(width, parts[-1] + float(_longest(np.array(q + parts[-1])))))
    ends, t = np.array(parts), (rounded(_DEGREE)[0] + 1) / 2
    stiff, mass = _matrices(q + ends[:-1], np.diff(ends))
    own = np.arange(len(mass))[:, None] * _DEGREE + np.arange(_DEGREE + 1)
    flat = np.ones((own[-1, -1] + 1, 2))
    flat[own, 1] = (ends[:-1, None] + np.diff(ends)[:, None] * t) / width
    loads = np.zeros_like(flat)
    np.add.at(loads, own, stiff @ (flat[own] - (1, 0)) + mass[:, :, None] * flat[own])
    w, hessian = np.zeros_like(flat), band(stiff + mass[:, :, None] * np.eye(_DEGREE + 1))
    w[1:-1] = -solveh_banded(hessian[:, 1:-1], loads[1:-1], lower=True, check_finite=False)
    return ends, w.T
