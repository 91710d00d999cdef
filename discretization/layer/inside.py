"""The fields of a layer's poles under the indenter, on elements that are graded towards the line.

v_j = u - φ_j of pole j obeys, with the measure m of the geometry and v_j known at the line,

    -(m v')' + τ_j m v = (m f')'    on 0 < x < a,    v'(0) + f'(0) = 0,

and the flow p₀ of an incompressible layer -(m p₀')' = k₁ m u, p₀'(0) = 0: a pole at τ = 0.
In each Gauss-Lobatto element the inner nodes are eliminated for all poles at once: with the modes
K φ = λ M φ of its stiffness and mass, by division by λ + τ_j. What is left of the elements is
tridiagonal. Interior elements need not resolve 1/√τ_j, as v is about f''/τ_j there.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from discretization.layer.contact import Profile, points_apart
from discretization.layer.geometry import Geometry
from discretization.layer.poles import Poles
from discretization.surfaces.spectral import polynomial, rounded

Array = NDArray[np.float64]
Complex = NDArray[np.complex128]
_DEGREE = 12
_INTO = np.array([1] + [0] * (_DEGREE - 1) + [-1])  # of a corner the slope inside the element


class Fields(NamedTuple):
    """v (n, e, 13) of n poles at nodes x (e, 13) of e elements; weights with the measure.

    slope, pressure (e, 13): f', of corners inside the element, and k₀u + Σ c_j v_j + p₀.
    """

    x: Array
    weights: Array
    v: Complex
    slope: Array
    pressure: Array

    def pulls(self, tau: Complex) -> Complex:
        """m (v' + f') at the line (n,): τ ∫v dm, by the equation with 1 for the other function."""
        return np.asarray(tau * (self.weights * self.v[: tau.size]).sum(axis=(1, 2)))

    def at(self, x: Array) -> Array:
        """The pressure at positions under the indenter (k,)."""
        own = np.clip(np.searchsorted(self.x[:, 0], x, side="right") - 1, 0, len(self.x) - 1)
        found = np.empty(x.size)
        for element in np.unique(own).tolist():
            here, (lo, hi) = own == element, self.x[element, [0, -1]]
            at = (2 * x[here] - lo - hi) / (hi - lo)
            found[here] = polynomial(_DEGREE, at, self.pressure[element])
        return found


def fields(
    geometry: Geometry, profile: Profile, poles: Poles, at_line: Complex, a: float, depth: float
) -> Fields:
    """The fields of poles, and of the flow if there is one, known at the line (n,), at a depth."""
    z, w, d = rounded(_DEGREE)
    tau = poles.tau if not poles.flow else np.append(poles.tau, 0.0)
    ends = _elements(a, 1 / float(np.abs(np.sqrt(tau)).max()), profile)
    half = (ends[:-1] - ends[1:])[:, None] / 2  # of elements; ends are distances from the line
    x = a - ((ends[:-1] + ends[1:])[:, None] / 2 - half * z)
    x[0, 0], x[-1, -1] = 0.0, a
    mass = half * w * geometry.measure(x)
    slopes = w * geometry.measure(x) / half
    stiffness = np.einsum("ki,ek,kj->eij", d, slopes, d)
    load = np.empty((tau.size, *x.shape))
    slope = np.asarray(profile.slope(x, _INTO))
    load[:] = -np.einsum("ki,ek->ei", d, slopes * half * slope)
    u = depth - profile.height(x)
    load[poles.tau.size :] = poles.flow * mass * u
    values, modes = _modes(stiffness[:, 1:-1, 1:-1], mass[:, 1:-1])
    share = 1 / (values + tau[:, None, None])  # (n, e, 11)
    ties = np.einsum("eim,eib->emb", modes, stiffness[:, 1:-1][:, :, [0, -1]])
    forced = np.einsum("eim,nei->nem", modes, load[..., 1:-1])
    tie = stiffness[:, 0, -1] - np.einsum("nem,em,em->ne", share, ties[..., 0], ties[..., 1])
    # what a displacement that is 1 everywhere takes, without the large numbers that cancel
    flat = tau[:, None, None] * np.einsum("eim,ei->em", modes, mass[:, 1:-1])
    own = tau[:, None, None] * mass[:, [0, -1]] - np.einsum("nem,emb,nem->neb", share, ties, flat)
    given = load[..., [0, -1]] - np.einsum("nem,emb,nem->neb", share, ties, forced)
    joints = _joined(-tie, own, given, at_line)
    both = np.stack([joints[:, :-1], joints[:, 1:]], axis=2)
    inner = share * (forced - np.einsum("emb,neb->nem", ties, both))
    v = np.empty((tau.size, *x.shape), complex)
    v[..., [0, -1]], v[..., 1:-1] = both, np.einsum("eim,nem->nei", modes, inner)
    c = poles.c if not poles.flow else np.append(poles.c, 1.0)
    return Fields(x, mass, v, slope, poles.still * u + np.tensordot(c, v, 1).real)


def _modes(stiffness: Array, mass: Array) -> tuple[Array, Array]:
    """λ (e, i) and φ (e, i, i) of inner nodes, φᵀ M φ = 1."""
    root = np.sqrt(mass)
    values, vectors = np.linalg.eigh(stiffness / (root[:, :, None] * root[:, None, :]))
    return values, vectors / root[:, :, None]


def _joined(tie: Complex, own: Complex, given: Complex, at_line: Complex) -> Complex:
    """Values at the ends of elements (n, e + 1).

    An element takes own v at its ends (n, e, 2), and tie (n, e) times the difference of these two.
    """
    n, e = tie.shape
    passed, rest = np.empty((n, e), complex), np.empty((n, e), complex)
    before, right = np.zeros(n, complex), np.zeros(n, complex)
    for i in range(e):
        held, right = before + own[:, i, 0], right + given[:, i, 0]
        passed[:, i], rest[:, i] = tie[:, i] / (held + tie[:, i]), right / (held + tie[:, i])
        before = own[:, i, 1] + passed[:, i] * held
        right = given[:, i, 1] + passed[:, i] * right
    values = np.empty((n, e + 1), complex)
    values[:, -1] = at_line
    for i in range(e - 1, -1, -1):
        values[:, i] = rest[:, i] + passed[:, i] * values[:, i + 1]
    return values


def _elements(a: float, shortest: float, profile: Profile) -> Array:
    """As points_apart, and towards corners, beside which the fields change as near the line."""
    ends = points_apart(a, shortest, profile)
    for corner in profile.corners:
        if corner < a:
            beside = a * 0.5 ** np.arange(1, 2 + math.ceil(math.log2(max(a / shortest, 1.0))))
            places = np.concatenate([corner - beside, corner + beside])
            near = np.abs(ends[:, None] - (a - places)).min(axis=0) > beside.min() / 2
            ends = np.concatenate([ends, a - places[(places > 0) & (places < a) & near]])
    return np.unique(ends)[::-1]
