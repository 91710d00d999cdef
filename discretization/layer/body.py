"""One contact of a scene with the exact response of its layer, and where its line rests.

A convex profile that is mirrored about its lowest point, or turned about an axis, has one contact
with one line, at the half-width or radius a. From first touch the line advances while D(a) < d;
withdrawn it recedes while D(a) > d, D as in contact.py. At a corner, and at the edge of the body,
D jumps, and the line may be pinned. A line is looked for outwards or inwards in steps of a constant
ratio, with few poles, and then found with many: as few poles tell how D changes, every step of
Newton's method leaves little more than their error. All lengths are in units of h, stresses in G.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import NotCertifiedError
from discretization.layer.contact import Condensed, Profile, condensed
from discretization.layer.geometry import Axis, Geometry, Line, lowest
from discretization.layer.poles import Poles, poles
from discretization.roots import bracketed, least
from energy import Scene

Array = NDArray[np.float64]
_ROUGHLY = 1e-3  # tolerance of the poles with which a line is looked for
_RATIO = 2.0  # of half-widths at which it is looked for
_NARROWEST, _WIDEST = 1e-9, 1e9  # half-widths, in h
TIP = 1e-12  # half-width of a contact at the lowest point alone, in h
_SMALL = 1 / 8  # of √(2w/γ₁), and of the depth: slopes and heights where adhesion rules
_NEWTON = 20
_STILL = 1e-15  # of the half-width
_NEAR = 1e-6  # places, in h, by which it is seen whether f' is a whole power beside 0
_SMOOTH = 1e-9  # by how much of a power it may differ
SPREADS = (
    "depth = {depth!r} spreads the contact over the whole known profile, to {x!r}; give a wider "
    "profile, or a smaller depth"
)


@dataclass(frozen=True, eq=False)
class Body:
    """A scene whose layer has its exact response, and the contacts it may have, by half-width."""

    scene: Scene

    @property
    def h(self) -> float:
        """Unit of lengths."""
        return self.scene.layer.h

    @property
    def unit(self) -> float:
        """Of forces: Gh per length of a line contact, Gh² about an axis; of energies h more."""
        return self.scene.layer.shear_modulus * self.h ** (2 if self.scene.axisymmetric else 1)

    @functools.cached_property
    def gamma(self) -> float:
        """Γ = γ₁/(Gh)."""
        return self.scene.gamma1 / (self.scene.layer.shear_modulus * self.h)

    def excess(self, scene: Scene) -> float:
        """√(2w/γ₁) of this scene or the one it is opened with."""
        return math.sqrt(2 * scene.work_of_adhesion / self.scene.gamma1)

    @functools.cached_property
    def geometry(self) -> Geometry:
        """Of its contact."""
        return Axis() if self.scene.axisymmetric else Line()

    @functools.cached_property
    def apex(self) -> float:
        """x of the lowest point, in units of the scene."""
        return lowest(self.scene)

    @functools.cached_property
    def profile(self) -> Profile:
        """In units of h, from its lowest point."""
        indenter, h, apex = self.scene.indenter, self.h, self.apex

        def height(x: Any) -> Any:
            return np.asarray(indenter.height(apex + np.asarray(x) * h), float) / h

        def slope(x: Any, side: int = 0) -> Any:
            return np.asarray(indenter.slope_beside(apex + np.asarray(x) * h, side), float)

        places = np.union1d(indenter.corners, indenter.knots).astype(float)
        near = slope(_NEAR * min(1.0, self.edge) * np.array([1.0, 2.0]))
        power = math.log2(near[1] / near[0]) if near[0] > 0 else 0.0
        rough = abs(power - round(power)) > _SMOOTH
        breaks, corners = (
            tuple(((x - apex) / h).tolist()) for x in (places, np.asarray(indenter.corners, float))
        )
        return Profile(height, slope, breaks, tuple(x for x in corners if x >= 0), rough)

    @functools.cached_property
    def touch(self) -> float:
        """Depth of first touch."""
        return float(self.profile.height(np.zeros(1))[0])

    @functools.cached_property
    def edge(self) -> float:
        """Where the profile ends."""
        return (self.scene.indenter.extent[1] - self.apex) / self.h

    @functools.cached_property
    def corners(self) -> list[float]:
        """Beside the lowest point, from there outwards, the edge of the body the last."""
        found = {(float(x) - self.apex) / self.h for x in self.scene.indenter.corners}
        if self.scene.indenter.extent[1] in self.scene.indenter.walls:
            found.add(self.edge)
        return sorted(x for x in found if x > 0)

    def poles(self, tolerance: float) -> Poles:
        """Of the layer."""
        return poles(self.scene.layer.nu, self.gamma, tolerance)

    def condensed(self, a: float, tolerance: float) -> Condensed:
        """The contact of this half-width."""
        return condensed(self.poles(tolerance), self.gamma, self.geometry, self.profile, a)

    def rest_depth(self, found: Condensed, excess: float, side: int = 0) -> float:
        """D; side: which slope of a corner counts, beyond the edge of the body none.

        What touches with its lowest point alone lets go at first touch.
        """
        if side < 0 and found.a <= TIP:
            return self.touch
        if side > 0 and found.a == self.edge:
            return math.inf
        slope = float(self.profile.slope(found.a, side)) if side else found.slope
        return found._replace(slope=slope).depth(excess)


class Search:
    """The line of a body at a depth, against a work of adhesion."""

    def __init__(self, body: Body, depth: float, excess: float) -> None:
        self.body, self.depth, self.excess = body, depth, excess

    def off(self, a: float, side: int = 0) -> float:
        """D - d, roughly; a line advances where it is negative."""
        return (
            self.body.rest_depth(self.body.condensed(a, _ROUGHLY), self.excess, side) - self.depth
        )

    def start(self) -> float:
        """A half-width so small that a line there advances, if there is any."""
        body = self.body
        found = [min(body.edge, 1.0)]
        deep = self.depth - body.touch
        for part, limit in ((body.profile.slope, self.excess), (self._rise, deep)):
            if limit > 0:
                found.append(_reached(part, _SMALL * limit, min(body.edge, _WIDEST)))
        a = min(found)
        while self.off(a) >= 0 and a > TIP:
            a = max(a / 8, TIP)
        return a

    def _rise(self, a: float) -> float:
        return float(self.body.profile.height(a)) - self.body.touch

    def looked_for(self, start: float, way: int) -> tuple[float, bool]:
        """The first place where a line rests that moves from here, and whether it is pinned.

        nan: nowhere. ValueError where the profile is not known so far.
        """
        corners = [x for x in self.body.corners if way * (x - start) > 0][::way]
        a, off, before = start, way * self.off(start, way), (math.nan, math.nan)
        if off >= 0:
            return start, start == TIP or start in self.body.corners
        most = min(self.body.edge, _WIDEST)
        while _NARROWEST <= a < most or (a == most and way < 0):
            far = min(a * _RATIO**way, most)
            corner = next((x for x in corners if way * (x - a) > 0), math.inf * way)
            beyond, there = (corner, -way) if way * (far - corner) >= 0 else (far, 0)
            value = way * self.off(beyond, there)
            if value < 0 and before[1] < off > value:  # there is a top between
                top = float(least(lambda x: -way * self.off(x), before[0], beyond, 0.0)[0])
                if way * self.off(top) >= 0:
                    beyond, value, a = top, 0.0, before[0]
            if value >= 0:
                return bracketed(lambda x: way * self.off(x), a, beyond), False
            if beyond == corner:
                value = way * self.off(corner, way)
                if value >= 0:
                    return corner, True
            before, a, off = (a, off), beyond, value
        if way > 0 and a >= most:
            h = self.body.h
            raise ValueError(SPREADS.format(depth=self.depth * h, x=most * h + self.body.apex))
        return math.nan, False

    def found(self, a: float, tolerance: float) -> tuple[float, float]:
        """The same with many poles, and dD/da there."""
        step = 1e-4 * a
        first = rate = (self.off(a + step) - self.off(a - step)) / (2 * step)
        off = move = math.inf
        for _ in range(_NEWTON):
            before, last = off, move
            off = self.body.condensed(a, tolerance).depth(self.excess) - self.depth
            if math.isfinite(before):
                rate = (before - off) / last
            move = off / rate if rate * first > 0 else off / first
            if abs(move) <= _STILL * a or abs(last) <= abs(move) <= math.sqrt(_STILL) * a:
                return a, first
            a = max(a - move, a / 2)
        raise NotCertifiedError(
            f"no contact line is found at depth = {self.depth * self.body.h!r}; try another depth"
        )


def _reached(part: Any, value: float, most: float) -> float:
    """Where a function that does not fall reaches a value, or the narrowest or widest place."""
    low, high = math.log(_NARROWEST), math.log(most)
    for _ in range(50):
        middle = (low + high) / 2
        low, high = (middle, high) if float(part(math.exp(middle))) < value else (low, middle)
    return math.exp(low)
