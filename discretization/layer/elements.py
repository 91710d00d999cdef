"""The fields of a layer's poles under the indenter, on elements that are graded towards the line.

In units of the half-width a, for all poles at once: -(m v')' + τ m v = load, with v'(0) = 0 and v
known at the line. In each Gauss-Lobatto element the inner nodes are eliminated with the modes
K φ = λ M φ of its stiffness and mass, by division by λ + τ. What is left of the elements is
tridiagonal. Interior elements need not resolve 1/√τ, as v is smooth there and about f''/τ.
"""

import functools
import itertools
import math

import numpy as np

from discretization.layer.body import Body
from discretization.surfaces.network import rounded
from energy.arrays import Array, Complex

DEGREE = 12
_GROWTH = 4.0  # of elements from one to the next away from the line
_NEAREST = 8.0  # of the shortest length on which a pole acts: the element beside the line
_SHARP = 8  # elements, at least, that become smaller towards kinks
_RESOLVED = 1 - 1e-12  # so far from the line others end at most: next to 0 rounding would count
_CLEAR = 1e-3  # of the elements there: how far from a break others end


def grid(body: Body, a: float, shortest: float, first: float) -> tuple[float, ...]:
    """Distances from the line, over the half-width a, of the ends of elements, from 1 to 0.

    Elements end at breaks. Each is a fourth of the next one towards the line, and towards kinks of
    the profile, beside which the fields change likewise, until they resolve the shortest length of
    a pole, and f' beside kinks; first: the share of the way at which that begins.
    """
    ends = [0.0, 1.0, *(1 - x / a for x in body.breaks if 0 < x < a)]
    for left, right in itertools.pairwise([0.0, *(x for x in body.kinks if 0 < x < a), a]):
        times = math.log(max(1.0, (right - left) / (_NEAREST * shortest)), _GROWTH)
        count = max(math.ceil(times), _SHARP * (left in body.kinks))
        steps = [(right - left) / a * first / _GROWTH**i for i in range(count)]
        for corner, side in ((right, 1), (left, -1))[: 1 + (left in body.kinks)]:
            places = [(1 - corner / a + side * step, _CLEAR * step) for step in steps]
            ends += [z for z, clear in places if min(abs(z - x) for x in ends) > clear]
    return tuple(sorted({z for z in ends if z == 1 or z < _RESOLVED}, reverse=True))


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


elements = functools.lru_cache(maxsize=128)(Elements)


class Fields:
    """Fields v of poles τ (n,), each with two loads, from 0 to the line.

    loads (e, 3, 13): two of the first pole, and the second of the others, which have no first. They
    take own v - given there, (n,) and (2, n). share (e, 11, n): 1/(λ + τ); forced (e, 3, 11): loads
    of modes. On the left of every element v is rest (e, 2, n) and passed (e, n) of v on its right.
    What an element takes of a displacement that is 1 everywhere, and of its load as a whole, is
    found without the large numbers that cancel where τ is small.
    """

    def __init__(self, elements: Elements, tau: Complex, loads: Array) -> None:
        self.elements, (left, _), flat = elements, elements.ties, elements.flat[:, None]
        self.share = 1 / (elements.values[:, :, None] + tau)
        self.forced = own = loads[..., 1:-1] @ elements.modes
        rows = np.concatenate([elements.tied, own * left[:, None], own * flat], axis=1)
        tied = (rows @ self.share.view(float)).view(complex)  # (e, 9, n)
        takes = tau * (elements.mass[:, [0, -1], None] - tied[:, 1:3])  # (e, 2, n)
        given = loads[..., :1] - tied[:, 3:6], loads.sum(axis=2)[..., None] - tau * tied[:, 6:]
        for part in given:
            part[:, 0, 1:], part[:, 1, 1:] = 0, part[:, 2, 1:]
        first = np.concatenate([takes[:, :1], given[0][:, :2]], axis=1)  # of the left end
        both = np.concatenate([takes.sum(axis=1, keepdims=True), given[1][:, :2]], axis=1)
        ties, held, passed, now = tied[:, 0] - elements.bridge, [], [], np.zeros_like(first[0])
        for one, more, tie in zip(first, both - first, ties, strict=True):
            held.append(now + one)
            passed.append(tie / (held[-1][0] + tie))
            now = more + passed[-1] * held[-1]
        self.own, self.given, self.passed = now[0], now[1:], np.array(passed)
        self.rest = (self.passed / ties)[:, None] * np.array(held)[:, 1:]

    def total(self, at_line: Complex, c: Complex) -> Array:
        """Σ c v (2, e, 13), real, of fields that are known at the line (2, n)."""
        v = [at_line]
        for passed, rest in zip(self.passed[::-1], self.rest[::-1], strict=True):
            v.append(rest + passed * v[-1])
        joints, (left, right) = c * np.array(v[::-1]), self.elements.ties[:, :, None]
        share, first = self.share.swapaxes(1, 2), self.forced[:, :2] * self.share[:, None, :, 0]
        own = c[0] * first - left * (joints[:-1] @ share) - right * (joints[1:] @ share)
        own[:, 1] += self.forced[:, 2] * (c[1:] @ share[:, 1:])
        inner = own.real @ self.elements.modes.swapaxes(1, 2)
        ends = joints.sum(axis=2, keepdims=True).real
        return np.concatenate([ends[:-1], inner, ends[1:]], axis=2).swapaxes(0, 1)
