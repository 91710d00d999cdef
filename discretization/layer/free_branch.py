"""All states of one contact of a layer with its exact response, from its loss to a depth.

As in fitted/free_branch.py half-widths are chosen, and D and P follow from the coefficients of a
`Contact`. These are computed at some half-widths and are polynomials in between: of log a about an
axis, and of ∛a for a line contact, which closes up.

Depths are positive downwards; a is the half-width or radius [length]. The coefficients (5, n) of n
contacts are σ, s₀, P', P₀, U₀: the line is pulled by γ₁ (σ u(a) + s₀), so that it rests at
D = f + (f' - s₀ - √(2w/γ₁))/σ, with f and f' the height and slope of the profile there
(`Body.rest_depth`), and P = P₀ + P'u(a), u(a) = D - f (`at_depth`). √(2w/γ₁) is
`small_slope_deficit`. The branch goes from where D is least, where a contact about an axis is lost
as it opens, or from a = 0, to the depth that is given.

`spread_evenly` chooses so many half-widths that √(D - D₀) is about evenly spaced, D₀ the least D,
and returns them with D, or None where it cannot. A `FreeBranch` has a, D and P (n,), all by
increasing a. `Layer(depth, contact)` is the state whose `certificate` says by how much it violates
the conditions of equilibrium, over sizes of the terms; its `demand` raises where that is more than
its tolerance, `TOLERANCE` = 1e-9, or the tolerance of the poles if that is more. Of a scene,
`opening` are surface energies of a contact that opens, and `pattern` a factor on adhesion along the
surface, both None if there are none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from numpy.polynomial.chebyshev import chebval

from discretization.certificate import TOLERANCE
from discretization.fitted.free_branch import FreeBranch, spread_evenly
from discretization.layer.body import Body
from discretization.layer.contact import Contact, at_depth
from discretization.layer.state import Layer
from energy import Scene
from energy.arrays import Array

# Of the polynomials, one after the other: each is compared with half of it, and doubled until both
# agree.
_DEGREES = (8, 16, 32, 64)


class BranchRules(NamedTuple):
    """How the polynomials over all half-widths are made.

    Where the states of a branch lie depends on the polynomials, and not only how exact they are:
    half or twice of `agreement` or `power`, or a tenth or ten times of `narrowest`, moves those of
    a random branch by 2e-5 of their scale or less. None of the others changes it by 1e-9 (`python
    -m tests.sensitivity discretization.layer.free_branch`).

    Attributes
    ----------
    agreement : float
        Relative difference of D and P from those of half the degree, at which a degree is enough:
        its own error is about the square of that.
    power : int
        a grows with this power of t beside a line that closes up, where D changes within l.
    narrowest : float
        Least half-width over the largest one, at which a line contact has closed up.
    nearest : float
        How near to the edge of a body, over its half-width, an end of the branch may be.
    octaves : int
        Octaves of half-widths around h: more than D can need to turn.
    samples : int
        Half-widths at which D is read to find its least value.
    """

    agreement: float = 1e-4
    power: int = 3
    narrowest: float = 1e-6
    nearest: float = 1e-3
    octaves: int = 40
    samples: int = 256


_BRANCH = BranchRules()


def applies(scene: Scene) -> bool:
    """Whether the only contact of a layer has a line that is free from its loss to any depth.

    So it is with small slopes, one work of adhesion, and a convex indenter without corners that is
    symmetric about 0.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    bool
    """
    body = scene.indenter
    one_law = scene.opening is None and scene.pattern is None
    small = scene.layer.exact and scene.gamma1 > 0 and scene.slopes == "small"
    smooth = body.convex and body.symmetric and body.apex == 0 and not len(body.corners)
    return bool(small and one_law and smooth)


def free_branch(scene: Scene, deepest: float, count: int, rtol: float) -> FreeBranch | None:
    """States of one contact from its loss to a depth.

    Parameters
    ----------
    scene : Scene
        One to which this `applies`.
    deepest : float
        That depth [length].
    count : int
        How many states.
    rtol : float
        Tolerance of the poles.

    Returns
    -------
    FreeBranch or None
        None where the profile is not known so far, where D turns more than once, or where no
        polynomial is good enough: follow a path there.

    Raises
    ------
    NotCertifiedError
        If a state is no equilibrium, as where the layer touches the indenter again.
    """
    branch = _Polynomials.of(Body(scene), deepest, rtol)
    if branch is None:
        return None
    places = branch.half_width(np.linspace(-1.0, 1.0, _BRANCH.samples))  # increasing
    rest = branch.rest_depth(places)
    least = int(np.argmin(rest))
    steps = np.diff(rest)
    if (steps[:least] > 0).any() or (steps[least:] < 0).any():
        return None
    # About an axis the branch begins where D is least, else at the narrowest contact.
    lowest = None if scene.axisymmetric else float(places[0])
    spread = spread_evenly(branch.rest_depth, places, lowest, deepest, count)
    if spread is None:
        return None
    a, depth = spread
    touched = int(np.searchsorted(depth, branch.body.touch))
    # Two states are judged for all: the first one above the depth of first touch, and the deepest.
    for i in {min(touched, count - 1), count - 1}:
        _certify(branch.body, float(a[i]), rtol)
    force = at_depth(branch.coefficients(a), depth - branch.body.height(a)).force
    return FreeBranch(a, depth, force)


@dataclass(frozen=True, eq=False)
class _Polynomials:
    """`Contact.coefficients` as polynomials of t from -1 to 1.

    a = high (low/high)^((1 - t)/2), or where low is 0 high ((1 + t)/2)³.

    Attributes
    ----------
    body : Body
    low, high : float
        Half-widths at t = -1 and t = 1 [length].
    series : ndarray (n, 5)
        Chebyshev coefficients, of increasing degree down a column.
    """

    body: Body
    low: float
    high: float
    series: Array

    @classmethod
    def of(cls, body: Body, deepest: float, rtol: float) -> _Polynomials | None:
        """For half-widths from where D falls to where it exceeds a depth.

        The degree is doubled until that changes D and P by less than `BranchRules.agreement`. None
        if there are no such half-widths, or no degree is enough.
        """
        ends = _around(body, deepest, rtol)
        if ends is None:
            return None
        low, high = ends
        found = cls(body, low, high, np.empty((0, 5)))  # no polynomials yet
        known: dict[float, Array] = {}
        for degree in _DEGREES:
            half = found
            t = np.cos(math.pi * np.arange(degree + 1) / degree)
            a = found.half_width(t)
            for x in a.tolist():
                if x not in known:  # every second one is
                    known[x] = Contact(body, x, rtol).coefficients
            found = cls(body, low, high, _series(np.array([known[x] for x in a.tolist()])))
            if len(half.series) and found.agrees_with(half, a):
                return found
        return None

    def agrees_with(self, half: _Polynomials, a: Array) -> bool:
        """Whether D and P at half-widths a (n,) differ little from those of half the degree."""
        depth = self.rest_depth(a)
        u = depth - self.body.height(a)
        force = at_depth(self.coefficients(a), u).force
        other_force = at_depth(half.coefficients(a), u).force
        if np.abs(force - other_force).max() > _BRANCH.agreement * np.abs(force).max():
            return False
        off = np.abs(depth - half.rest_depth(a)).max()
        return bool(off <= _BRANCH.agreement * np.abs(depth).max())

    def half_width(self, t: Array) -> Array:
        """a (n,) at t (n,), not quite 0 where that would be."""
        if self.low:
            return np.asarray(self.high * (self.low / self.high) ** ((1 - t) / 2))
        return np.asarray(self.high * np.maximum(((1 + t) / 2) ** _BRANCH.power, _BRANCH.narrowest))

    def coefficients(self, a: Array) -> Array:
        """`Contact.coefficients` (5, n) at half-widths (n,)."""
        if self.low:
            t = 1 - 2 * np.log(a / self.high) / math.log(self.low / self.high)
        else:
            t = 2 * (a / self.high) ** (1 / _BRANCH.power) - 1
        return np.asarray(chebval(t, self.series))

    def rest_depth(self, a: Array) -> Array:
        """D at half-widths (n,)."""
        excess = self.body.scene.surfaces.small_slope_deficit
        return np.asarray(self.body.rest_depth(a, self.coefficients(a)[:2], excess, 1))


def _series(values: Array) -> Array:
    """Chebyshev coefficients (n, 5) of values (n, 5) at cos(πj/(n - 1)), j from 0 on.

    As T_k is cos kθ with θ = πj/(n - 1), they are the Fourier coefficients of the values continued
    evenly beyond θ = π; the first and the last one stand for one wave instead of two.
    """
    degree = len(values) - 1
    mirrored = np.concatenate([values, values[-2:0:-1]])
    series = np.fft.rfft(mirrored, axis=0).real / degree
    series[[0, -1]] /= 2
    return np.asarray(series)


def _around(body: Body, deepest: float, rtol: float) -> tuple[float, float] | None:
    """Half-widths between which D first falls, if it does, and then grows beyond a depth.

    The first is 0 for a line contact, which has states of any half-width. None if the profile ends
    before, or D still falls after many octaves.

    The second is looked for outwards from where the indenter is as high as the depth of
    indentation, the first from there inwards until D grows again.
    """
    excess = body.scene.surfaces.small_slope_deficit

    def rest_depth(a: float) -> float:
        """D at a half-width [length]."""
        return float(body.rest_depth(a, Contact(body, a, rtol).reaction, excess, 1))

    places = body.scene.layer.h * np.exp2(np.arange(-_BRANCH.octaves / 2, _BRANCH.octaves / 2))
    places = places[places < body.edge]
    rising = np.flatnonzero(body.height(places) - body.touch > deepest - body.touch)
    high = float(places[rising[0] if rising.size else -1])
    for _ in range(_BRANCH.octaves):
        depth = rest_depth(high)
        if depth > deepest:
            break
        if high >= body.edge * (1 - _BRANCH.nearest):
            return None
        high = min(2 * high, (high + body.edge) / 2)
    if not body.power:
        return 0.0, high
    low = high
    for _ in range(_BRANCH.octaves):
        low /= 2
        wider = depth
        depth = rest_depth(low)
        if depth > wider:
            return low, high
    return None


def _certify(body: Body, a: float, rtol: float) -> None:
    """Raise NotCertifiedError unless the contact of this half-width is in equilibrium."""
    contact = Contact(body, a, rtol)
    excess = body.scene.surfaces.small_slope_deficit
    depth = float(body.rest_depth(a, contact.reaction, excess, 1))
    found = Layer(depth, contact).certificate
    found = found._replace(tolerance=max(TOLERANCE, rtol))
    found.demand(f"the state at depth = {depth!r}", "there is no branch")
