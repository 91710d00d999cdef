"""One contact of a layer, condensed to its line: where it rests, and what it takes.

In units h = G = 1. Outside, the layer and the surface are balanced by u = Σ A exp(-λ(x-a)) of the
decays of `Poles` (about an axis K₀(λr)), in which φ_j is τ_j/(τ_j - λ²) of u. What the fields φ_j
are at the line follows from inside and outside alike (geometry.py); with u = d - f(a) there that
are as many linear equations as decays. So the reaction of all that is free or pressed beside a
line is linear in u(a),

    S = Γ (σ u(a) + s₀),

and of ∂U/∂a = m [Γ/2 (f' - S/Γ)² - w] the line rests where that vanishes, m the length of the line:

    D(a) = f(a) + (f'(a) - s₀ - √(2w/Γ))/σ,    P = whole ∫₀ᵃ p dm + whole m S,

with the layer's pressure p = k₀u + Σ c_j (u - φ_j) + p₀ (p₀ the flow of an incompressible one), of
which ∫₀ᵃ (u - φ_j) dm = -m φ_j'(a)/τ_j. The square is left because f' Γ - S is the force on the
line and a line that advances takes the surface along; state.py checks it by differences of U.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.geometry import Geometry
from discretization.layer.poles import Poles

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
_ORDER = 16  # Gauss points of a panel
_NEAREST = 0.5  # of the shortest length on which a pole acts: the panel beside the line
_TOWARDS, _ROUGH = 0.25, 5  # of panels towards 0, and their number
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(_ORDER)


class Profile(NamedTuple):
    """Heights and slopes of a profile in units of h; places where it is not smooth.

    corners: where the slope jumps; rough: whether it is not smooth on the way to 0 either, as a
    power of the distance.
    """

    height: Callable[[Any], Any]
    slope: Callable[..., Any]
    breaks: tuple[float, ...] = ()
    corners: tuple[float, ...] = ()
    rough: bool = False


class Points(NamedTuple):
    """Places from 0 to a line, graded towards it, their weights, and how far from it they are."""

    x: Array
    weights: Array
    beside: Array


class Condensed(NamedTuple):
    """σ, s₀; P = stiffness u(a) + force; amplitudes of u outside over u(a), and at u(a) = 0."""

    a: float
    f: float
    slope: float
    sigma: float
    rest: float
    stiffness: float
    force: float
    amplitudes: Complex

    def depth(self, excess: float) -> float:
        """D for √(2w/Γ)."""
        return self.f + (self.slope - self.rest - excess) / self.sigma

    def load(self, depth: float) -> float:
        """P."""
        return self.stiffness * (depth - self.f) + self.force


def points_apart(a: float, shortest: float, profile: Profile) -> Array:
    """Distances from the line of the ends of panels, from a to 0.

    Panels are halved towards the line until they resolve the shortest length there, and shrink
    towards 0 where the profile is not smooth.
    """
    halvings = max(0, math.ceil(math.log2(max(a / (_NEAREST * shortest), 1.0))))
    inner = [a - x for x in profile.breaks if 0 < x < a]
    if profile.rough:
        inner += (a - a * _TOWARDS ** np.arange(1, _ROUGH + 1)).tolist()
    return np.unique([*a * 0.5 ** np.arange(halvings + 1), 0.0, *inner])[::-1]


def points(a: float, shortest: float, profile: Profile) -> Points:
    """Gauss points on these panels."""
    ends = points_apart(a, shortest, profile)
    middle, half = (ends[:-1] + ends[1:]) / 2, (ends[:-1] - ends[1:]) / 2
    beside = (middle[:, None] - half[:, None] * _POINTS).ravel()
    return Points(a - beside, (half[:, None] * _WEIGHTS).ravel(), beside)


def condensed(
    poles: Poles, gamma: float, geometry: Geometry, profile: Profile, a: float
) -> Condensed:
    """The contact of this half-width or radius."""
    r, decays = np.sqrt(poles.tau), poles.decays
    x, weights, beside = points(a, 1 / float(np.abs(r).max()), profile)
    f, slope = float(profile.height(np.array(a))), float(profile.slope(np.array(a), -1))
    t = geometry.inside(r, np.array([a]), np.zeros(1), a)[:, 0]
    pressed = geometry.inside(r, x, beside, a) @ (weights * profile.slope(x))
    share = poles.share
    out = geometry.outside(decays, a)
    line, weights = float(geometry.measure(np.array(a))), weights * geometry.measure(x)
    above = f - profile.height(x)
    rows = [np.ones((1, decays.size)), (out + (r * t)[:, None]) * share / r[:, None]]
    wanted = [np.array([[1.0, 0.0]]), np.array([t, pressed]).T]
    if poles.flow:
        rows.append((-poles.flow / decays**2 * out)[None])
        wanted.append(poles.flow / line * np.array([[weights.sum(), weights @ above]]))
    matrix, size = np.concatenate(rows), np.abs(np.concatenate(rows)).max(axis=0)
    found = np.linalg.solve(matrix / size, np.concatenate(wanted)) / size[:, None]
    sigma, rest = (out @ found).real
    inner = poles.still * np.array([weights.sum(), weights @ above])
    inner = inner + (poles.c / poles.tau) @ ((out * share) @ found) * line
    if poles.flow:
        moment = poles.flow * geometry.moment(x, a) * weights
        whole = float(geometry.moment(np.zeros(1), a)[0]) * 2 / a * (1 if line == 1 else a)
        inner = inner + whole * (-poles.flow / decays**2) @ found
        inner = inner + np.array([moment.sum(), moment @ above])
    stiffness, force = geometry.whole * (inner.real + line * gamma * np.array([sigma, rest]))
    return Condensed(a, f, slope, float(sigma), float(rest), float(stiffness), float(force), found)
