"""The fields of a layer's poles under the indenter, on elements that are graded towards the line.

In units of the half-width a, for many half-widths and poles at once: -(m v')' + τ m v = load, with
v'(0) = 0 and v known at the line. In each Gauss-Lobatto element the inner nodes are eliminated for
all poles at once: with the modes K φ = λ M φ of its stiffness and mass, by division by λ + τ. What
is left of the elements is tridiagonal. Interior elements need not resolve 1/√τ, as v is smooth
there and about f''/τ.
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

    values (e, 11), modes (e, 11, 11): λ and φ, φᵀ M φ = 1; ties (e, 11, 2), flat (e, 11), bridge
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


class Swept(NamedTuple):
    """What fields take: own v - given at the line (m, n), (m, n, 2), and what it is found with."""

    own: Complex
    given: Complex
    inner: list[tuple[Complex, Array]]
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
    ties = modes.transpose(0, 2, 1) @ stiffness[:, 1:-1][:, :, [0, -1]]
    flat = (modes * mass[:, 1:-1, None]).sum(axis=1)
    return Elements(beside, x, mass, values, modes, ties, flat, stiffness[:, 0, -1])


def risen(own: Elements, slope: Array) -> Array:
    """The load (m f')' of slopes (..., e, 13) over the elements."""
    half = (own.beside[:, :1] - own.beside[:, -1:]) / 2
    return np.asarray(-(slope * own.mass / half) @ rounded(DEGREE)[2])


def sweep(own: Elements, *loads: tuple[Any, Array]) -> Swept:
    """From 0 to the line, for poles τ (m, n) with two loads (m, 2, e, 13), one after the other."""
    inner, condensed = [], []
    for tau, nodal in loads:
        share, forced, *ends = _condensed(own, tau[:, None, :, None], np.moveaxis(nodal, 1, -1))
        inner.append((share, forced))
        condensed.append(ends)
    tie, first, second = (np.concatenate(part, axis=2) for part in zip(*condensed, strict=True))
    held, now = np.empty_like(first), np.zeros_like(first[:, 0])
    for i in range(own.bridge.size):
        held[:, i] = now + first[:, i]
        kept = held[:, i, :, :1] / (held[:, i, :, :1] + tie[:, i])
        now = now + second[:, i] - kept * held[:, i]
    size = held[..., :1] + tie
    return Swept(now[..., 0], now[..., 1:], inner, tie / size, held[..., 1:] / size)


def _condensed(own: Elements, tau: Any, nodal: Array) -> tuple[Any, ...]:
    """1/(λ + τ), the load of the modes, and of the ends of elements the tie and what each takes.

    What an element takes of a displacement that is 1 everywhere, and of its load as a whole, is
    found without the large numbers that cancel where τ is small.
    """
    share = 1 / (own.values[:, None, :] + tau)  # (m, e, n, 11)
    forced = own.modes.transpose(0, 2, 1) @ nodal[:, :, 1:-1]  # (m, e, 11, 2)
    left, right, flat = own.ties[..., :1], own.ties[..., 1:], own.flat[..., None]
    tied = share @ np.concatenate([left * right, own.ties * flat], axis=-1)
    loaded = share @ np.concatenate([left * forced, flat * forced], axis=-1)
    takes = (own.mass[:, None, [0, -1]] - tied[..., 1:]) * tau
    given = nodal[:, :, None, 0] - loaded[..., :2]
    first = np.concatenate([takes[..., :1], given], axis=-1)
    whole = nodal.sum(axis=2)[:, :, None] - tau * loaded[..., 2:]
    second = np.concatenate([takes.sum(-1, keepdims=True), whole], axis=-1)
    return share, forced, tied[..., :1] - own.bridge[:, None, None], first, second


def total(own: Elements, found: Swept, at_line: Complex, c: Complex) -> Array:
    """Σ c v (m, 2, e, 13), real, of fields that are known at the line (m, n, 2)."""
    m, e, n, _ = found.passed.shape
    joints = np.empty((m, e + 1, n, 2), complex)
    joints[:, -1] = at_line
    for i in range(e)[::-1]:
        joints[:, i] = found.rest[:, i] + found.passed[:, i] * joints[:, i + 1]
    joints *= c[:, None]
    ones = np.broadcast_to(c[:, None], (m, e, n, 1))
    parts = np.concatenate([ones, joints[:, :-1], joints[:, 1:]], axis=-1)
    inner, start = np.zeros((m, *own.flat.shape, 2)), 0
    for share, forced in found.inner:
        some = parts[:, :, start : start + share.shape[2]]
        some = some if np.iscomplexobj(share) else some.real
        sums = (share.swapaxes(-1, -2) @ some).real  # (m, e, 11, 5)
        inner += forced * sums[..., :1]
        inner -= own.ties[..., :1] * sums[..., 1:3] + own.ties[..., 1:] * sums[..., 3:]
        start += share.shape[2]
    ends = joints.sum(axis=2).real[:, :, None]  # (m, e + 1, 1, 2)
    v = np.concatenate([ends[:, :-1], own.modes @ inner, ends[:, 1:]], axis=2)
    return np.moveaxis(v, -1, 1)
