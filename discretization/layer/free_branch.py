"""All states of one contact of a layer with its exact response, from its loss to a depth.

As ../fitted/free_branch.py: half-widths are chosen, and D and P follow from what `Contact` takes.
That is computed at some of them and is a polynomial in between, of log a about an axis, and of ∛a
beside a contact line that closes up.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial.chebyshev import chebval

from discretization.certificate import TOLERANCE
from discretization.fitted.free_branch import FreeBranch, spread_evenly
from discretization.layer.body import Body
from discretization.layer.contact import Contact, at_depth
from discretization.layer.state import Layer
from energy import Scene
from energy.arrays import Array

_DEGREES = (8, 16, 32, 64)  # of the polynomials
_KNOWN = 1e-4  # of D and P: what those of half the degree may be off by; the last by much less
_POWER = 3  # of t in a beside a line that closes up, where D may change within l
_NARROWEST = 1e-6  # of the largest half-width, at which a contact line has closed up
_NEAREST = 1e-3  # of the half-width of a body: how near to its edge the ends are looked for
_OCTAVES = 40  # that are looked at on the way to the ends, at most
_LOOKED_AT = 256  # half-widths at which the polynomials are read to find the ends


def applies(scene: Scene) -> bool:
    """Whether the line of the only contact of a layer is free from its loss on."""
    body = scene.indenter
    known = scene.layer.exact and scene.gamma1 > 0 and scene.opening is None
    known = known and scene.pattern is None and scene.slopes == "small" and body.convex
    return bool(known and body.apex == 0 and not len(body.corners) and body.symmetric)


def free_branch(scene: Scene, deepest: float, count: int, rtol: float) -> FreeBranch | None:
    """So many states of a scene to which this `applies`, from the loss of contact to a depth.

    The poles are good to rtol. None where the profile is not known so far, where D turns more than
    once, or where the polynomials do not tell: follow a path there.

    NotCertifiedError if a state is no equilibrium, as where the layer touches the indenter again.
    """
    branch = _Polynomials.of(Body(scene), deepest, rtol)
    if branch is None:
        return None
    places = branch.half_width(np.linspace(-1.0, 1.0, _LOOKED_AT))
    rest = branch.rest_depth(places)
    least = int(np.argmin(rest))
    steps = np.diff(rest)
    if (steps[:least] > 0).any() or (steps[least:] < 0).any():
        return None
    lowest = None if scene.axisymmetric else float(places[0])
    spread = spread_evenly(branch.rest_depth, places, lowest, deepest, count)
    if spread is None:
        return None
    a, depth = spread
    touched = int(np.searchsorted(depth, branch.body.touch))
    for i in {min(touched, count - 1), count - 1}:
        _certify(branch.body, float(a[i]), rtol)
    force, _ = at_depth(branch.taken(a), depth - branch.body.height(a))
    return FreeBranch(a, depth, force)


@dataclass(frozen=True, eq=False)
class _Polynomials:
    """What contacts take as polynomials of t from -1 to 1; series: Chebyshev coefficients (n, 5).

    a = high (low/high)^((1 - t)/2), or where low is 0 high ((1 + t)/2)³.
    """

    body: Body
    low: float
    high: float
    series: Array

    @classmethod
    def of(cls, body: Body, deepest: float, rtol: float) -> _Polynomials | None:
        """For half-widths from where D falls to where it exceeds a depth; None if there are none,
        or the polynomials do not tell."""
        ends = _around(body, deepest, rtol)
        if ends is None:
            return None
        found, known = cls(body, *ends, np.empty((0, 5))), dict[float, Array]()
        for degree in _DEGREES:
            half = found
            t = np.cos(math.pi * np.arange(degree + 1) / degree)
            a = found.half_width(t)
            known |= {x: Contact(body, x, rtol).taken for x in a.tolist() if x not in known}
            found = cls(body, *ends, _series(np.array([known[x] for x in a.tolist()])))
            if len(half.series) and found.tells(half, a):
                return found
        return None

    def tells(self, half: _Polynomials, a: Array) -> bool:
        """Whether polynomials of half the degree differ by so little that these are right."""
        depth = self.rest_depth(a)
        heights = self.body.height(a)
        force, other = (at_depth(one.taken(a), depth - heights)[0] for one in (self, half))
        known = np.abs(force - other).max() <= _KNOWN * np.abs(force).max()
        off = np.abs(depth - half.rest_depth(a)).max()
        return bool(known and off <= _KNOWN * np.abs(depth).max())

    def half_width(self, t: Array) -> Array:
        """a at t."""
        if self.low:
            return np.asarray(self.high * (self.low / self.high) ** ((1 - t) / 2))
        return np.asarray(self.high * np.maximum(((1 + t) / 2) ** _POWER, _NARROWEST))

    def taken(self, a: Array) -> Array:
        """`Contact.taken` (5, n) at half-widths (n,)."""
        if self.low:
            t = 1 - 2 * np.log(a / self.high) / math.log(self.low / self.high)
        else:
            t = 2 * (a / self.high) ** (1 / _POWER) - 1
        return np.asarray(chebval(t, self.series))

    def rest_depth(self, a: Array) -> Array:
        """D at half-widths (n,)."""
        excess = self.body.scene.surfaces.small_slope_deficit
        return np.asarray(self.body.rest_depth(a, self.taken(a)[:2], excess, 1))


def _series(values: Array) -> Array:
    """Chebyshev coefficients (n, 5) of values at cos(πj/(n - 1))."""
    n = len(values) - 1
    mirrored = np.concatenate([values, values[-2:0:-1]])
    series = np.fft.rfft(mirrored, axis=0).real / n
    series[[0, -1]] /= 2
    return np.asarray(series)


def _around(body: Body, deepest: float, rtol: float) -> tuple[float, float] | None:
    """Half-widths between which D falls, if it does, and grows beyond a depth; 0: from none on.

    None if the profile ends before, or D still falls after many octaves.
    """
    excess = body.scene.surfaces.small_slope_deficit

    def rest_depth(a: float) -> float:
        return float(body.rest_depth(a, Contact(body, a, rtol).reaction, excess, 1))

    places = body.scene.layer.h * np.exp2(np.arange(-_OCTAVES / 2, _OCTAVES / 2))
    places = places[places < body.edge]
    rising = np.flatnonzero(body.height(places) - body.touch > deepest - body.touch)
    high = float(places[rising[0] if rising.size else -1])
    for _ in range(_OCTAVES):
        there = rest_depth(high)
        if there > deepest:
            break
        if high >= body.edge * (1 - _NEAREST):
            return None
        high = min(2 * high, (high + body.edge) / 2)
    if not body.power:
        return 0.0, high
    low = high
    for _ in range(_OCTAVES):
        low /= 2
        before, there = there, rest_depth(low)
        if there > before:
            return low, high
    return None


def _certify(body: Body, a: float, rtol: float) -> None:
    """NotCertifiedError unless the contact of this half-width is in equilibrium."""
    contact = Contact(body, a, rtol)
    excess = body.scene.surfaces.small_slope_deficit
    depth = float(body.rest_depth(a, contact.reaction, excess, 1))
    found = Layer(depth, contact).certificate
    found = found._replace(tolerance=max(TOLERANCE, rtol))
    found.demand(f"the state at depth = {depth!r}", "there is no branch")
