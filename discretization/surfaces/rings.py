"""Free surfaces about an axis with small slopes as networks, in units of l and γ₁.

A ring between two lines q < p is a network (network.py) for E/(2π): of an element, by elimination
of its inner nodes, and of elements in a row.

Beyond a line of radius s, and on the disc inside one, the reaction per length of the line is the
displacement times a stiffness S(s), a function of the radius alone. It is that of some elements
beside the line and of the far field beyond them, which is eliminated exactly. It is solved for at
a few radii of every octave and read in between as a polynomial in log s.
"""

from __future__ import annotations

import functools
from typing import Any

import numpy as np
from numpy.typing import NDArray
from scipy.linalg import solveh_banded
from scipy.special import i0e, i1e, k0e, k1e

from discretization.surfaces.network import FAR, Network, band, on_elements, rounded

Array = NDArray[np.float64]
_POINTS = {1: 12, -1: 16}  # of an octave of radii: the polynomial is then exact to rounding
_COVERED, _DISC = 4.0, 6  # l: beside a line, by elements; by how many inside it
_LEAST = -30  # octaves: inside of 2^-30 l the springs do nothing
_WIDER = 1.5  # ends of elements of a ring, over each other
_LONGEST = 1.0  # l: of an element, far from the axis
BESIDE = 2.0**-40  # l: a line at the axis is asked for at this radius


def stiffness(degree: int, side: int, s: Any) -> Any:
    """S(s) beyond lines of radius s (side +1), or on the disc inside them (-1), number or array.

    Infinite beyond a line at the axis, 0 inside it.
    """
    s, found = np.asarray(s, float), np.empty(np.shape(s))
    octaves = np.floor(np.log2(np.maximum(s, 2.0 ** (_LEAST - 1))))
    for octave in set(octaves.ravel().tolist()):
        own = octaves == octave
        found[own] = _read(degree, side, s[own], int(octave))
    return found[()]


def _read(degree: int, side: int, s: Any, octave: int) -> Any:
    """S of radii in an octave; below the last one that of a disc without springs, or a ring."""
    if octave >= _LEAST:
        value = np.polyval(_family(degree, side, octave), 2 * (np.log2(s) - octave) - 1)
        return value * (1 + s) / s if side > 0 else value * s / (2 + s)
    if side < 0:
        return s / 2
    least = 2.0**_LEAST
    inner = 1 / (least * _read(degree, side, least, _LEAST))
    with np.errstate(divide="ignore"):
        return np.divide(1.0, np.where(np.equal(s, 0), 0.0, s * (inner - np.log(s / least))))


@functools.lru_cache(maxsize=256)
def _family(degree: int, side: int, octave: int) -> Array:
    """The polynomial of S s/(1+s) outside and S (2+s)/s inside, smooth at small and great s."""
    t = np.sort(np.cos(np.pi * (np.arange(_POINTS[side]) + 0.5) / _POINTS[side]))
    s = 2.0 ** (octave + (t + 1) / 2)
    scale = s / (1 + s) if side > 0 else (2 + s) / s
    return np.asarray(np.linalg.solve(np.vander(t), _solved(degree, side, s) * scale))


def _solved(degree: int, side: int, s: Array) -> Array:
    """S(s), by elements and the exact far field beyond them."""
    if side > 0:
        end = s + _COVERED
        far = Network(end * far_stiffness(1, end), 0.0, 0.0)
        return np.asarray(ring(degree, s, np.full_like(s, _COVERED)).then(far).left / s)
    start = np.maximum(s - _COVERED, 0.0)
    found, width = Network(0.0, 0.0, start * far_stiffness(-1, start)), (s - start) / _DISC
    for i in range(_DISC):
        found = found.then(_element(degree, start + i * width, width))
    return np.asarray(found.right / s)


def far_stiffness(side: int, r: Any) -> Any:
    """The exact reaction of all that is beyond a radius, per length and displacement there."""
    return k1e(r) / k0e(r) if side > 0 else i1e(r) / i0e(r)


def decayed(side: int, start: Any, r: Array) -> Array:
    """How much of the displacement at a radius is left at others beyond it."""
    bessel = k0e if side > 0 else i0e
    return np.asarray(bessel(r) / bessel(start) * np.exp(side * (start - r)))


def ring(degree: int, q: Array, width: Array) -> Network:
    """Rings of these widths beyond lines of radii q (n,)."""
    first = np.minimum(width, _longest(q))
    found, lo, end = _element(degree, q, first), q + first, q + width
    while (left := np.real(lo) < np.real(end)).any():
        more = np.minimum(end[left] - lo[left], _longest(lo[left]))
        longer = Network(*(part[left] for part in found)).then(_element(degree, lo[left], more))
        for part, new in zip(found, longer, strict=True):
            part[left] = new
        lo[left] += more
    return found


def _longest(start: Array) -> Array:
    """How wide an element of a ring may be that starts there."""
    return np.maximum(np.minimum((_WIDER - 1) * start, _LONGEST), np.spacing(np.real(start)))


def _element(degree: int, lo: Array, width: Array) -> Network:
    """One element of this width beyond lo (n,)."""
    hessian, mass = _matrices(degree, lo, width)
    stiff = hessian.copy()
    hessian[:, np.arange(degree + 1), np.arange(degree + 1)] += mass
    loads = np.stack([mass, -hessian[:, :, -1]], axis=2)[:, 1:-1]
    less, tied = np.moveaxis(np.linalg.solve(hessian[:, 1:-1, 1:-1], loads), 2, 0)
    inner = mass[:, 0] - (stiff[:, 0, 1:-1] * less).sum(axis=1)
    outer = mass[:, -1] - (stiff[:, -1, 1:-1] * less).sum(axis=1)
    tie = -(hessian[:, 0, -1] + (hessian[:, 0, 1:-1] * tied).sum(axis=1))
    return Network(inner, tie, outer)


def _matrices(degree: int, lo: Array, width: Array) -> tuple[Array, Array]:
    """Matrices of ∫u'² r dr and weights of ∫u² r dr of elements (n, degree+1, degree+1)."""
    points, weights, d = rounded(degree)
    half = width[:, None] / 2
    measure = weights * (lo[:, None] + half * (points + 1))
    return (d.T * (measure / half)[:, None, :]) @ d, measure * half


class Axis:
    """The networks about an axis, on elements of one degree: the questions of network.Line."""

    def __init__(self, degree: int) -> None:
        self.degree = degree

    def measure(self, s: Any) -> Any:
        """Length of a line of radius s, over 2π."""
        return s

    def alone(self, side: int, s: Any) -> Any:
        """s S(s) of the surface outside a line or of the disc inside it; 0 at the axis."""
        return s * stiffness(self.degree, side, np.where(np.equal(s, 0), BESIDE, s)[()])

    def between(self, side: int, s: Any, width: Any) -> Network:
        """Of a ring from a line of radius s, this much further to a side; the inner end first."""
        q, wide = np.broadcast_arrays(*map(np.atleast_1d, (s if side > 0 else s - width, width)))
        near = (np.real(wide) <= FAR) & (np.real(q) > 0)
        found = ring(self.degree, q[near], wide[near])
        if not near.all():
            known, found, far = found, Network(*np.zeros((3, q.size))), ~near
            for part, new in zip(found, known, strict=True):
                part[near] = new
            found.left[far] = self.alone(1, np.maximum(q[far], 0.0))
            found.right[far] = self.alone(-1, (q + wide)[far])
        return found if np.ndim(s) or np.ndim(width) else Network(*(part[0] for part in found))

    def beyond(self, side: int, s: float, distance: Array) -> tuple[Array, Array]:
        """u and u' outwards beyond a line, displaced by 1 there, with the exact decay."""
        left = decayed(side, s, s + side * distance)
        return left, -left * stiffness(self.degree, side, s + side * distance)

    def shape(self, q: float, width: float, x: Array, u: float, rise: float) -> tuple[Array, Array]:
        """u and u' between lines displaced by u and u + rise, on a mesh of the whole ring."""
        ends, w = _mesh(self.degree, q, width)
        bent, slope = on_elements(ends, u * w[0] + rise * w[1], x)
        return u + rise * x / width + bent, rise / width + slope


@functools.lru_cache(maxsize=256)
def _mesh(degree: int, q: float, width: float) -> tuple[Array, Array]:
    """Ends of elements from the inner line on, and nodal w (2, nodes), which vanishes at the lines.

    The surface between two lines displaced by u and u + r is u (1 + w₀) + r (t + w₁), t from 0 to 1
    in between: by elimination, repeated on its residual.
    """
    parts = [0.0]
    while parts[-1] < width:
        parts.append(min(width, parts[-1] + float(_longest(np.array(q + parts[-1])))))
    ends, t = np.array(parts), (rounded(degree)[0] + 1) / 2
    stiff, mass = _matrices(degree, q + ends[:-1], np.diff(ends))
    own = np.arange(len(mass))[:, None] * degree + np.arange(degree + 1)
    flat = np.ones((own[-1, -1] + 1, 2))
    flat[own, 1] = (ends[:-1, None] + np.diff(ends)[:, None] * t) / width
    loads = np.zeros_like(flat)
    np.add.at(loads, own, stiff @ (flat[own] - (1, 0)) + mass[:, :, None] * flat[own])
    stiff[:, np.arange(degree + 1), np.arange(degree + 1)] += mass
    w = np.zeros_like(flat)
    w[1:-1] = -solveh_banded(band(stiff)[:, 1:-1], loads[1:-1], lower=True, check_finite=False)
    return ends, w.T
