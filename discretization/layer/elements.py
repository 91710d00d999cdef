"""The fields of a layer's poles under the indenter, on elements that are graded towards the line.

In units of the half-width a, for all poles at once: -(m v')' + τ m v = load, with v'(0) = 0 and v
known at the line. In each Gauss-Lobatto element the inner nodes are eliminated with the modes
K φ = λ M φ of its stiffness and mass, by division by λ + τ. What is left of the elements is
tridiagonal. Interior elements need not resolve 1/√τ, as v is smooth there and about f''/τ.
"""

import functools
import itertools
import math
from typing import Any

import numpy as np

from discretization.layer.body import Body
from discretization.surfaces.network import rounded
from energy.arrays import Array, Complex

DEGREE = 12
_RATIO = 1 / 3  # of elements to the next ones outwards
_NEAREST = 2.0  # of the shortest length on which a pole acts: the element beside the line
_CLEAR = 1e-3  # of the elements there: how far from a break others end


def grid(body: Body, a: float, shortest: float, first: float) -> tuple[float, ...]:
    """Distances from the line, over the half-width a, of the ends of elements, from 1 to 0.

    Elements end at breaks. Each is a third of the next one towards the line, and towards kinks of
    the profile, beside which the fields change likewise, until they resolve the shortest length of
    a pole; first: the share of the way at which that begins.
    """
    ends = np.array([0.0, 1.0, *(1 - x / a for x in body.breaks if 0 < x < a)])
    for left, right in itertools.pairwise([0.0, *(x for x in body.kinks if 0 < x < a), a]):
        times = -math.log(max(1.0, (right - left) / (_NEAREST * shortest)), _RATIO)
        steps = (right - left) / a * first * _RATIO ** np.arange(math.ceil(times))
        for corner, side in ((right, 1), (left, -1))[: 1 + (left in body.kinks)]:
            places = 1 - corner / a + side * steps
            clear = np.abs(places[:, None] - ends).min(axis=1) > _CLEAR * steps
            ends = np.append(ends, places[clear])
    return tuple(np.unique(ends)[::-1].tolist())


class Elements:
    """Elements e between distances from the line; power: of x in the measure.

    x, mass (e, 13): distances from 0, and weights times the measure; values (e, 11), modes
    (e, 11, 11): λ and φ, φᵀ M φ = 1; ties (2, e, 11), flat (e, 11), bridge (e, 1): stiffness
    between modes and ends, mass of modes, stiffness between the two ends.
    """

    def __init__(self, power: int, ends: tuple[float, ...]) -> None:
        z, w, d = rounded(DEGREE)
        far, near = np.array(ends[:-1])[:, None], np.array(ends[1:])[:, None]
        self.half = half = (far - near) / 2
        beside = (far + near) / 2 - half * z
        beside[:, [0, -1]] = np.hstack([far, near])
        self.x = 1 - beside
        self.mass = half * w * self.x**power
        stiffness = (d.T * (self.mass / half**2)[:, None]) @ d
        root = np.sqrt(self.mass[:, 1:-1, None])
        scaled = stiffness[:, 1:-1, 1:-1] / (root * root.swapaxes(1, 2))
        self.values, vectors = np.linalg.eigh(scaled)
        self.modes = vectors / root
        inner = self.modes.swapaxes(1, 2) @ stiffness[:, 1:-1, [0, -1]]
        self.ties = left, right = np.moveaxis(inner, -1, 0)
        self.flat = (self.modes * self.mass[:, 1:-1, None]).sum(axis=1)
        self.bridge = stiffness[:, 0, -1:]
        self.tied = np.stack([left * right, left * self.flat, right * self.flat], axis=1)

    def risen(self, slope: Array) -> Array:
        """The load (m f')' of slopes (e, 13)."""
        return np.asarray(-(slope * self.mass / self.half) @ rounded(DEGREE)[2])


elements = functools.lru_cache(maxsize=128)(Elements)


class Fields:
    """Fields v of poles τ (n,) with two loads each (e, 13, n, 2), from 0 to the line.

    They take own v - given there, (n,) and (n, 2). share (e, 11, n): 1/(λ + τ); forced
    (e, 11, n, 2): loads of modes. On the left of every element v is rest (e, n, 2) and passed
    (e, n, 1) of v on its right. What an element takes of a displacement that is 1 everywhere, and
    of its load as a whole, is found without the large numbers that cancel where τ is small.
    """

    def __init__(self, elements: Elements, tau: Any, loads: Array) -> None:
        self.elements, (e, _, n, _), (left, _) = elements, loads.shape, elements.ties
        self.share = 1 / (elements.values[:, :, None] + tau)
        inner = elements.modes.swapaxes(1, 2) @ loads[:, 1:-1].reshape(e, -1, 2 * n)
        self.forced = inner.reshape(e, -1, n, 2)
        moved = (self.share[..., None] * self.forced).reshape(e, -1, 2 * n)
        loaded = (np.stack([left, elements.flat], axis=1) @ moved).reshape(e, 2, n, 2)
        tied = elements.tied @ self.share
        takes = tau * (elements.mass[:, [0, -1], None] - tied[:, 1:])  # (e, 2, n)
        given = loads[:, 0] - loaded[:, 0], loads.sum(axis=1) - tau[:, None] * loaded[:, 1]
        first = np.concatenate([takes[:, 0, :, None], given[0]], axis=2)  # of the left end
        both = np.concatenate([takes.sum(axis=1)[..., None], given[1]], axis=2)
        tie, held, now = tied[:, 0] - elements.bridge, np.empty_like(first), np.zeros_like(first[0])
        for i in range(e):
            held[i] = now + first[i]
            kept = held[i, :, 0] / (held[i, :, 0] + tie[i])
            now = now + both[i] - kept[:, None] * held[i]
        size = (held[..., 0] + tie)[..., None]
        self.own, self.given = now[:, 0], now[:, 1:]
        self.passed, self.rest = tie[..., None] / size, held[..., 1:] / size

    def total(self, at_line: Complex, c: Complex) -> Array:
        """Σ c v (2, e, 13), real, of fields that are known at the line (n, 2)."""
        v = [at_line]
        for passed, rest in zip(self.passed[::-1], self.rest[::-1], strict=True):
            v.append(rest + passed * v[-1])
        joints, (left, right) = np.array(v[::-1]), self.elements.ties[..., None, None]
        moved = self.forced - left * joints[:-1, None] - right * joints[1:, None]
        inner = self.elements.modes @ ((self.share * c)[..., None] * moved).sum(axis=2).real
        ends = (joints * c[:, None]).sum(axis=1).real[:, None]
        return np.moveaxis(np.concatenate([ends[:-1], inner, ends[1:]], axis=1), -1, 0)
