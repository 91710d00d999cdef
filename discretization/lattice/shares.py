"""How far the two ends of a free surface displace it in between, and what it does to them.

Small slopes, of a line contact and around an axis; on the nodes, and as a line through them.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

Array = NDArray[Any]
Nodes = NDArray[np.int64]
_KEPT = 1 << 16  # powers that are kept: more would be held in memory for good


class Pair(NamedTuple):
    """Stiffness by which a free surface ties its two ends to each other, and to the ground.

    It pulls at an end displaced by u, the other one by u', with tie·(u - u') + left·u (or right).
    """

    tie: Any
    left: Any
    right: Any


def shares(rate: float, p: Array, q: Array) -> tuple[Array, Array, Array]:
    """a, b and 1 - a - b of the free surface u = a left + b right, p from left and q from right.

    a = sinh(rate·q)/sinh(rate·(p+q)), b = sinh(rate·p)/sinh(rate·(p+q)),
    1 - a - b = 2 sinh(rate·p/2) sinh(rate·q/2)/cosh(rate·(p+q)/2);

    p and q may be inf. A tail decays by exp(-rate): μ per link, μ/Δx per length on the lattice.
    """
    ep, eq, both = np.exp(-rate * p), np.exp(-rate * q), np.expm1(-2 * rate * (p + q))
    near, far = ep * np.expm1(-2 * rate * q) / both, eq * np.expm1(-2 * rate * p) / both
    return near, far, np.expm1(-rate * p) * np.expm1(-rate * q) / (1 + ep * eq)


def looked_up(
    rate: float, left: int | None, right: int | None, start: int, stop: int
) -> tuple[Array, Array, Array]:
    """`shares` of the nodes start..stop-1 between two nodes (None: none there), powers of λ."""
    if left is None and right is None:
        return np.zeros(stop - start), np.zeros(stop - start), np.ones(stop - start)
    if left is not None and right is not None:
        own = slice(start - left - 1, stop - left - 1)
        near, rest = _of_gap(rate, right - left)
        return near[own], near[::-1][own], rest[own]
    if left is not None:
        links, far = stop - left, slice(start - left, stop - left)
    else:
        assert right is not None
        links, far = right - start, slice(right - start, right - stop, -1)
    power, once, _ = _powers(rate, 1 << links.bit_length())
    return power[far], power[far], -once[far]


@functools.lru_cache(maxsize=256)
def _of_gap(rate: float, links: int) -> tuple[Array, Array]:
    """a and 1 - a - b of all free nodes of a gap; b is a from its other end."""
    power, once, twice = _powers(rate, 1 << links.bit_length())
    p, q = slice(1, links), slice(links - 1, 0, -1)
    return power[p] * twice[q] / twice[links], once[p] * once[q] / (1 + power[links])


def displaced(rate: float, p: Nodes, q: Nodes, u_left: Array, u_right: Array) -> Array:
    """u (n,) at nodes p links from left and q links from right ends displaced so."""
    count = 1 << int(np.max(p + q, initial=1)).bit_length()
    power, _, twice = (_powers if count <= _KEPT else _powers.__wrapped__)(rate, count)
    whole = power[p] * twice[q] * u_left + power[q] * twice[p] * u_right
    return np.asarray(whole / twice[p + q])


@functools.lru_cache(maxsize=4)
def _powers(rate: float, count: int) -> tuple[Array, Array, Array]:
    """λⁿ, λⁿ - 1 and λ²ⁿ - 1 for n = 0, ..., count."""
    n = np.append(0.0, -rate * np.arange(1.0, count + 1))  # an infinite rate without tension
    return np.exp(n), np.expm1(n), np.expm1(2 * n)


def first_free(spring: Any, link: Any, tie: Any, ground: Any) -> tuple[Any, Any, Any]:
    """B, 1 - A - B and S of the first free node beside a contact line: A u + B u' displaces it.

    spring, link: its own, and the one to the line at u; tie, ground: what the rest of the free
    surface, to a line at u', does to it (`Pair`); S: its stiffness with both lines at rest.
    """
    whole = spring + link + tie + ground
    return tie / whole, (spring + ground) / whole, whole


@dataclass(frozen=True)
class LatticeTail:
    """Free nodes beyond a contact: u decays by exp(-rate) per length, Eq. (6) on the lattice."""

    rate: float

    def displacement(self, distance: Array, u_line: float, radius: float = math.inf) -> Array:
        """u_line exp(-rate·distance)."""
        return u_line * np.exp(-self.rate * distance)

    def slope(self, u_line: Array, radius: Any = math.inf) -> Array:
        """-rate·u_line."""
        return -self.rate * u_line

    def between(
        self, p: Array, q: Array, width: float, left: float, right: float, radius: float = math.inf
    ) -> Array:
        """[left sinh(rate·q) + right sinh(rate·p)]/sinh(rate·width), small slopes only."""
        near, far, _ = shares(self.rate, p, q)
        return near * left + far * right

    def slope_between(
        self, width: Array, own: Array, other: Array, radius: Any = math.inf
    ) -> Array:
        """Slope of `between` at a line with u = own towards the next one, `width` away."""
        once, twice = np.exp(-self.rate * width), np.expm1(-2 * self.rate * width)
        return self.rate * ((2 + twice) * own - 2 * once * other) / twice
