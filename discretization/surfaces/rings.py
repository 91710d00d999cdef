"""Free surfaces about an axis with small slopes as networks, in units of l and γ₁.

Beyond a line of radius s, and on the disc inside one, the reaction per length of the line is the
displacement times a stiffness S(s), a function of the radius alone. It is solved on the mesh
(mesh.linear) at a few radii of every octave and read in between as a polynomial in log s.

A ring between two lines q < p is a network (network.py) for E/(2π): of an element, by elimination
of its inner nodes, and of elements in a row.
"""

from __future__ import annotations

import functools
import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.surfaces.mesh import ELEMENTS, decayed, far_stiffness, linear
from discretization.surfaces.network import FAR, Network
from discretization.surfaces.polynomials import horner, powers
from discretization.surfaces.spectral import rounded

Array = NDArray[np.float64]
_POINTS = {1: 12, -1: 16}  # of an octave of radii: the polynomial is then exact to rounding
_OUTER = 2  # octaves: from there on the elements beside a line end at the exact far field
_LEAST = -30  # octaves: inside of 2^-30 l the springs do nothing
_WIDER = 1.5  # ends of elements of a ring, over each other
_LONGEST = 1.0  # l: of an element, far from the axis
BESIDE = 2.0**-40  # l: a line at the axis is asked for at this radius


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
    return np.asarray(between.then(Network(end * beyond, 0.0, 0.0)).left / s)


def ring(degree: int, q: Array, p: Array) -> Network:
    """Rings between lines of radii q < p (n,)."""
    hi = np.minimum(p, _end(q))
    found = _element(degree, q, hi)
    while (left := hi < p).any():
        lo, hi = hi[left], hi.copy()
        hi[left] = np.minimum(p[left], _end(lo))
        longer = Network(*(part[left] for part in found)).then(_element(degree, lo, hi[left]))
        for part, new in zip(found, longer, strict=True):
            part[left] = new
    return found


def _end(start: Array) -> Array:
    """Where an element of a ring that starts here ends at the latest."""
    step = np.minimum((_WIDER - 1) * start, _LONGEST)
    return start + np.maximum(step, np.spacing(np.real(start)))


def _element(degree: int, lo: Array, hi: Array) -> Network:
    """One element from lo to hi (n,)."""
    hessian, mass = _matrices(degree, lo, hi)
    stiff = hessian.copy()
    hessian[:, np.arange(degree + 1), np.arange(degree + 1)] += mass
    loads = np.stack([mass, -hessian[:, :, -1]], axis=2)[:, 1:-1]
    less, tied = np.moveaxis(np.linalg.solve(hessian[:, 1:-1, 1:-1], loads), 2, 0)
    inner = mass[:, 0] - (stiff[:, 0, 1:-1] * less).sum(axis=1)
    outer = mass[:, -1] - (stiff[:, -1, 1:-1] * less).sum(axis=1)
    tie = -(hessian[:, 0, -1] + (hessian[:, 0, 1:-1] * tied).sum(axis=1))
    return Network(inner, tie, outer)


def _matrices(degree: int, lo: Array, hi: Array) -> tuple[Array, Array]:
    """Matrices of ∫u'² r dr and weights of ∫u² r dr of elements (n, degree+1, degree+1)."""
    points, weights, d = rounded(degree)
    half = (hi - lo)[:, None] / 2
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
        ends = (s, s + width) if side > 0 else (s - width, s)
        q, p = np.broadcast_arrays(*(np.atleast_1d(end) for end in ends))
        near = (np.real(p - q) <= FAR) & (np.real(q) > 0)
        found = ring(self.degree, q[near], p[near])
        if not near.all():
            known, found = found, Network(*np.zeros((3, q.size)))
            for part, new in zip(found, known, strict=True):
                part[near] = new
            found.left[~near] = self.alone(1, np.maximum(q[~near], 0.0))
            found.right[~near] = self.alone(-1, p[~near])
        return found if np.ndim(s) or np.ndim(width) else Network(*(part[0] for part in found))

    def beyond(self, side: int, s: float, distance: Array) -> tuple[Array, Array]:
        """u and u' outwards beyond a line, displaced by 1 there, with the exact decay."""
        left = decayed(side * s, 0.0, distance)
        return left, -left * stiffness(self.degree, side, s + side * distance)

    def mesh(self, q: float, p: float) -> tuple[Array, Array, Array]:
        """Elements of a ring: their ends, matrices of ∫u'² r dr and weights of ∫u² r dr."""
        ends = [q]
        while ends[-1] < p:
            ends.append(min(p, float(_end(np.array(ends[-1])))))
        edges = np.array(ends)
        return edges, *_matrices(self.degree, edges[:-1], edges[1:])
