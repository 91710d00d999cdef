"""The fields of a layer's poles under the indenter, on elements that are graded towards the line.

v_j = u - φ_j of pole j obeys, with the measure m of the geometry and v_j known at the line,

    -(m v')' + τ_j m v = (m f')'    on 0 < x < a,    v'(0) + f'(0) = 0,

and the flow p₀ of an incompressible layer -(m p₀')' = k₁ m u, p₀'(0) = 0: a pole at τ = 0.
In each Gauss-Lobatto element the inner nodes are eliminated for all poles at once: with the modes
K φ = λ M φ of its stiffness and mass, by division by λ + τ_j. What is left of the elements is
tridiagonal. Interior elements need not resolve 1/√τ_j, as v is about f''/τ_j there.
"""

from __future__ import annotations

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
    ends = points_apart(a, 1 / float(np.abs(np.sqrt(tau)).max()), profile)
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
    outer = stiffness[:, [0, -1]][:, :, [0, -1]] - np.einsum("nem,emb,emc->nebc", share, ties, ties)
    outer = outer + np.einsum("n,eb,bc->nebc", tau, mass[:, [0, -1]], np.eye(2))
    given = load[..., [0, -1]] - np.einsum("nem,emb,nem->neb", share, ties, forced)
    joints = _joined(outer, given, at_line)
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


def _joined(outer: Complex, given: Complex, at_line: Complex) -> Complex:
    """Values at the ends of elements (n, e + 1)."""
    n, e = given.shape[:2]
    diagonal, right = outer[:, 0, 0, 0].copy(), given[:, 0, 0].copy()
    passed, rest = np.empty((n, e), complex), np.empty((n, e), complex)
    for i in range(e):
        passed[:, i], rest[:, i] = outer[:, i, 0, 1] / diagonal, right / diagonal
        if i + 1 < e:
            diagonal = outer[:, i, 1, 1] - outer[:, i, 1, 0] * passed[:, i] + outer[:, i + 1, 0, 0]
            right = given[:, i, 1] - outer[:, i, 1, 0] * rest[:, i] + given[:, i + 1, 0]
    values = np.empty((n, e + 1), complex)
    values[:, -1] = at_line
    for i in range(e - 1, -1, -1):
        values[:, i] = rest[:, i] - passed[:, i] * values[:, i + 1]
    return values
