"""The fields of a layer's poles under the indenter, on elements that are graded towards the line.

In units of the half-width a, for all poles at once: -(m v')' + τ m v = load, with v'(0) = 0 and v
known at the line. In each Gauss-Lobatto element the inner nodes are eliminated with the modes
K φ = λ M φ of its stiffness and mass, by division by λ + τ. What is left of the elements is
tridiagonal. Interior elements need not resolve 1/√τ, as v is smooth there and about f''/τ.
"""

import functools
import itertools
import math
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from discretization.surfaces.network import rounded
from energy.arrays import Array, Complex

DEGREE = 12
_RATIO = 1 / 3  # of elements to the next ones outwards
_NEAREST = 2.0  # of the shortest length on which a pole acts: the element beside the line
_CLEAR = 1e-3  # of the elements there: how far from a break others end


class Elements(NamedTuple):
    """Of e elements: distances from the line and from 0 (e, 13), weights times the measure.

    values (e, 11), modes (e, 11, 11): λ and φ, φᵀ M φ = 1; ties (2, e, 11), flat (e, 11), bridge
    (e,): stiffness between modes and ends, mass of modes, stiffness between the two ends.
    """

    beside: Array
    x: Array
    mass: Array
    values: Array
    modes: Array
    ties: Array
    flat: Array
    bridge: Array


class Fields(NamedTuple):
    """What fields v of poles (n,) take: own v - given at the line (n,), (n, 2), and how they go on.

    share (e, 11, n): 1/(λ + τ); forced (e, 11, n, 2): loads of modes. On the left of every element
    v is rest (e, n, 2) and passed (e, n, 1) of v on its right.
    """

    own: Complex
    given: Complex
    share: Complex
    forced: Array
    passed: Complex
    rest: Complex


def grid(
    a: float, shortest: float, breaks: Sequence[float], kinks: Sequence[float], first: float
) -> tuple[float, ...]:
    """Distances from the line, over the half-width a, of the ends of elements, from 1 to 0.

    Elements end at breaks. Each is a third of the next one towards the line, and towards kinks of
    the profile, beside which the fields change likewise, until they resolve the shortest length of
    a pole; first: the share of the way at which that begins.
    """
    own = [0.0, 1.0, *(1 - x / a for x in breaks if 0 < x < a)]
    graded = [np.empty((2, 0))]
    for left, right in itertools.pairwise([0.0, *(x for x in kinks if 0 < x < a), a]):
        times = -math.log(max(1.0, (right - left) / (_NEAREST * shortest)), _RATIO)
        steps = (right - left) / a * first * _RATIO ** np.arange(math.ceil(times))
        graded.append(np.array([1 - right / a + steps, steps]))
        if left in kinks:
            graded.append(np.array([1 - left / a - steps[1:], steps[1:]]))
    places, steps = np.concatenate(graded, axis=1)
    clear = np.abs(places[:, None] - own).min(axis=1) > _CLEAR * steps
    return tuple(np.unique(np.append(own, places[clear]))[::-1].tolist())


@functools.lru_cache(maxsize=128)
def elements(power: int, ends: tuple[float, ...]) -> Elements:
    """Between these distances from the line; power: of x in the measure."""
    z, w, d = rounded(DEGREE)
    far, near = np.array(ends[:-1])[:, None], np.array(ends[1:])[:, None]
    half = (far - near) / 2
    beside = (far + near) / 2 - half * z
    beside[:, [0, -1]] = np.hstack([far, near])
    x = 1 - beside
    mass = half * w * x**power
    stiffness = (d.T * (mass / half**2)[:, None]) @ d
    root = np.sqrt(mass[:, 1:-1])
    scaled = stiffness[:, 1:-1, 1:-1] / (root[:, :, None] * root[:, None])
    values, vectors = np.linalg.eigh(scaled)
    modes = vectors / root[:, :, None]
    ties = np.moveaxis(modes.swapaxes(1, 2) @ stiffness[:, 1:-1, [0, -1]], -1, 0)
    flat = (modes * mass[:, 1:-1, None]).sum(axis=1)
    return Elements(beside, x, mass, values, modes, ties, flat, stiffness[:, 0, -1])


def risen(own: Elements, slope: Array) -> Array:
    """The load (m f')' of slopes (..., e, 13) over the elements."""
    half = (own.beside[:, :1] - own.beside[:, -1:]) / 2
    return np.asarray(-(slope * own.mass / half) @ rounded(DEGREE)[2])


def fields(own: Elements, tau: Any, loads: Array) -> Fields:
    """From 0 to the line, for poles τ (n,) with two loads each (e, 13, n, 2).

    What an element takes of a displacement that is 1 everywhere, and of its load as a whole, is
    found without the large numbers that cancel where τ is small.
    """
    (e, _, n, _), (left, right), flat = loads.shape, own.ties, own.flat
    share = 1 / (own.values[:, :, None] + tau)
    forced = (own.modes.swapaxes(1, 2) @ loads[:, 1:-1].reshape(e, -1, 2 * n)).reshape(e, -1, n, 2)
    tied = np.stack([left * right, left * flat, right * flat], axis=1) @ share
    loaded = np.stack([left, flat], axis=1) @ (share[..., None] * forced).reshape(e, -1, 2 * n)
    loaded = loaded.reshape(e, 2, n, 2)
    takes = tau * (own.mass[:, [0, -1], None] - tied[:, 1:])  # (e, 2, n)
    given = loads[:, 0] - loaded[:, 0], loads.sum(axis=1) - tau[:, None] * loaded[:, 1]
    first = np.concatenate([takes[:, 0, :, None], given[0]], axis=2)  # of the left end
    second = np.concatenate([takes.sum(axis=1)[..., None], given[1]], axis=2)  # of both
    tie, held, now = tied[:, 0] - own.bridge[:, None], np.empty_like(first), np.zeros_like(first[0])
    for i in range(e):
        held[i] = now + first[i]
        kept = held[i, :, 0] / (held[i, :, 0] + tie[i])
        now = now + second[i] - kept[:, None] * held[i]
    size = (held[..., 0] + tie)[..., None]
    return Fields(now[:, 0], now[:, 1:], share, forced, tie[..., None] / size, held[..., 1:] / size)


def total(own: Elements, found: Fields, at_line: Complex, c: Complex) -> Array:
    """Σ c v (2, e, 13), real, of fields that are known at the line (n, 2)."""
    e, n, _ = found.rest.shape
    v = np.empty((e + 1, n, 2), complex)
    v[-1] = at_line
    for i in range(e)[::-1]:
        v[i] = found.rest[i] + found.passed[i] * v[i + 1]
    left, right = own.ties[..., None, None]
    moved = found.forced - left * v[:-1, None] - right * v[1:, None]  # (e, 11, n, 2)
    inner = own.modes @ ((found.share * c)[..., None] * moved).sum(axis=2).real
    ends = (v * c[:, None]).sum(axis=1).real[:, None]
    return np.moveaxis(np.concatenate([ends[:-1], inner, ends[1:]], axis=1), -1, 0)
