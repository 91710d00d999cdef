"""The links beside contact lines by which these are found, and polynomials through them.

Places ζ are in links outwards from a line's last contact node, ζ = 0; link j leads from ζ = j to
j + 1. Polynomials go through up to four links around the line, and not across a corner of the
profile, or an edge of a pattern, where what a link takes changes by a jump.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.nodes.row import Row
from discretization.rounding import EPSILON

Array = NDArray[np.float64]
Nodes = NDArray[np.int64]
Mask = NDArray[np.bool_]
INWARDS, OUTWARDS = 3, 4
LINKS = np.arange(-INWARDS, OUTWARDS)  # beside a line
_MIDDLE = LINKS[0] + 0.5  # ζ of the middle of the first of them
_SECANTS = 8  # steps to a zero


class Window(NamedTuple):
    """Links start..stop-1 of `LINKS` by their columns, of each of n lines."""

    start: Nodes
    stop: Nodes


class Polynomial(NamedTuple):
    """Polynomials in Newton's form, through values at unit distances from `first` (n,) on."""

    differences: Array  # Δᵏ/k! of the values (n, k)
    first: Array

    @classmethod
    def through(cls, values: Array, origin: float, window: Window) -> Polynomial:
        """Through those values (n, c) that are in a window, column i at origin + i."""
        count = window.stop - window.start
        k = np.arange(max(1, int(count.max(initial=1))))
        column = np.minimum(window.start[:, None] + k, values.shape[1] - 1)
        found = np.take_along_axis(values, column, axis=1)
        for order in k[1:].tolist():
            found[:, order:] = (found[:, order:] - found[:, order - 1 : -1]) / order
        found[k >= count[:, None]] = 0.0
        return cls(found, np.asarray(origin + window.start, float))

    def at(self, places: Array) -> Array:
        """Their values."""
        total = np.zeros(places.shape)
        for k in range(self.differences.shape[1] - 1, -1, -1):
            total = total * (places - self.first - k) + self.differences[:, k]
        return total


def _zero(excess: Array, window: Window) -> Array:
    """Zeros of these polynomials next to ζ = 0, by secants from a change of sign on."""
    curve, columns = Polynomial.through(excess, _MIDDLE, window), np.arange(LINKS.size)
    positive = (columns > window.start[:, None]) & (columns < window.stop[:, None]) & (excess > 0)
    last = np.where(positive.any(axis=1), positive.argmax(axis=1), window.stop - 1)
    x1 = _MIDDLE + np.maximum(last, window.start)
    x0 = np.where(last > window.start, x1 - 1, x1)
    y0, y1 = curve.at(x0), curve.at(x1)
    for _ in range(_SECANTS):
        moving = (np.abs(x1 - x0) > EPSILON) & (y1 != y0)
        if not moving.any():
            break
        rise = np.where(moving, y1 - y0, 1.0)
        x = np.clip(x1 - np.where(moving, y1 * (x1 - x0) / rise, 0.0), -1.0, 1.0)
        x0, y0, x1 = np.where(moving, x1, x0), np.where(moving, y1, y0), np.where(moving, x, x1)
        y1 = curve.at(x1)
    return np.asarray(x1)


@dataclass(frozen=True, eq=False)
class Stencil:
    """The links that n lines are found by, on both sides of a corner less than a link away.

    corner (n,): its place, nan if there is none, and all links are `inner`.
    """

    corner: Array
    inner: Window
    outer: Window

    @classmethod
    def of(cls, row: Row, node: Nodes, side: Any, known: Mask) -> Stencil:
        """Of lines at these nodes. Beside two corners only the links next to the node count."""
        corner, below, above, dense = _corners(row, node, side)
        zero, at = INWARDS, np.nan_to_num(corner)
        there = known.any(axis=1)
        start = np.maximum(known.argmax(axis=1), zero + below)
        stop = np.where(there, LINKS.size - known[:, ::-1].argmax(axis=1), start)
        stop, reach = np.minimum(stop, zero + above), np.where(dense, 1, 2)
        low, high = zero + np.floor(at).astype(int), zero + np.ceil(at).astype(int)
        free = np.isnan(corner)
        inner = Window(
            np.maximum(start, np.where(free, zero - reach, low - 3)),
            np.minimum(stop, np.where(free, zero + reach, low)),
        )
        return cls(corner, inner, Window(np.maximum(start, high), np.minimum(stop, high + 3)))

    def places(self, excess: Array) -> Array:
        """ζ where the excess vanishes, or of the corner that pins the line."""
        free, found = np.isnan(self.corner), self.corner.copy()
        at, curves = np.nan_to_num(self.corner), [(self.inner, free)]
        if not free.all():
            for window, sign in ((self.outer, -1), (self.inner, 1)):
                beside = Polynomial.through(excess, _MIDDLE, window).at(at)
                curves.append((window, ~free & (sign * beside > 0)))
        for window, own in curves:
            if own.any():
                found[own] = _zero(excess[own], Window(*(part[own] for part in window)))
        return found

    def added(self, steps: Array, places: Array) -> Array:
        """What contact sets that end there have more than those that end at ζ = 0.

        steps (n, 7): changes over the links.
        """
        whole = np.zeros((steps.shape[0], LINKS.size + 1))
        np.cumsum(steps, axis=1, out=whole[:, 1:])
        whole -= whole[:, INWARDS, None]
        beyond = places > self.corner
        start, stop = (np.where(beyond, a, b) for a, b in zip(self.outer, self.inner, strict=True))
        nodes = Window(start, np.where(stop > start, stop + 1, start))
        return Polynomial.through(whole, float(LINKS[0]), nodes).at(places)


def _corners(row: Row, node: Nodes, side: Any) -> tuple[Array, Nodes, Nodes, Mask]:
    """The corner less than a link from each line, nan if there is none; the first links beyond
    those that are further away, inwards and outwards; whether there are several so near.

    As places ζ; a corner on a node is exactly there.
    """
    lattice, far = row.lattice, LINKS.size
    corners = np.asarray(row.indenter.corners, float)
    if row.scene.pattern is not None:
        corners = np.union1d(corners, row.scene.pattern.edges)
    if not corners.size:
        none = np.full(node.size, far)
        return np.full(node.size, math.nan), -none, none, np.zeros(node.size, bool)
    place = (corners - lattice.x(row.first)) / lattice.spacing
    whole = np.round(place)
    place = np.where(np.abs(place - whole) < 1e-9, whole, place)
    first, last = np.searchsorted(place, node - 1, "right"), np.searchsorted(place, node + 1)
    padded = np.concatenate([[-math.inf], place, [math.inf]])
    ends = side * (padded[first] - node), side * (padded[last + 1] - node)
    below, above = np.clip(np.minimum(*ends), -far, far), np.clip(np.maximum(*ends), -far, far)
    near = np.where(
        last - first == 1, side * (padded[np.minimum(first + 1, place.size)] - node), math.nan
    )
    return near, np.ceil(below).astype(int), np.floor(above).astype(int), last - first > 1
