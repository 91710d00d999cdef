"""One contact of a layer on nodes: energies from the layer's own kernel, a line moved by links.

Forces on nodes (about an axis on rings) displace the surface of the layer with its tension by the
compliance C between them, an integral over wave numbers q of 1/(k(q) + γ₁q²); of that what springs
of stiffness γ₁m² under the same tension give is known in closed form, and the rest falls like q⁻³.
Held down by g on the nodes of a contact the surface has the energy gᵀC⁻¹g/2, and with the Cholesky
factor of C, nodes from the middle outwards, y = L⁻¹g,

    U_n = ½ Σ_{i≤n} y_i² - w A_n,    P_n = Σ_{i≤n} y_i ∂y_i/∂d,

for all contacts of n nodes at once. So a line passes the link to node n where that lowers U, at

    y_n(d)² = 2w (A_n - A_{n-1}),

and D is known in the middle of every link. Neither poles nor the fields under the indenter are
used. Places, force and energy between the nodes are those of polynomials through the four nearest;
they are of second order in the spacing.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass

import numpy as np
from numpy.polynomial import Polynomial
from scipy.linalg import cholesky, solve_triangular
from scipy.special import i0e, j0, k0e, sici

from discretization.layer.body import Body
from discretization.roots import bracketed
from energy import Scene
from energy.arrays import Array

_ORDER = 8  # Gauss points of a panel
_TURN = 2.0  # of q times the largest distance: panels
_SAME = 1e-8  # waves over which two places are one
_LEFT = 1e-7  # of the compliance: what is left beyond the largest q
_RINGS = 20.0  # of that times the spacing, beyond which all rings are far from the axis
_FLATTEST = 1e-3  # of the wave numbers that matter: the first panel
_GROWN = 0.4  # of q: the next panels
_MOST = 50_000  # panels of wave numbers
KNOWN = 1e-6  # of results: what the compliance is good for
_LEAST = 1e-9  # of the spacing: a ring that is none
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(_ORDER)


@dataclass(frozen=True, eq=False)
class Nodes:
    """Contacts of 1, 2, ... nodes on each side of a scene's lowest point.

    x (n,): their distances from there; lower: L; start, rate (n,): y at d = 0 and its change.
    """

    body: Body
    spacing: float
    x: Array
    lower: Array
    start: Array
    rate: Array

    @classmethod
    def of(cls, body: Body, spacing: float, count: int) -> Nodes:
        """At most so many nodes on each side; the outermost one at the edge of a body that ends."""
        first = body.edge % spacing if body.walled else 0.0
        if body.power and first < _LEAST * spacing:
            first += spacing
        known = min(count, (body.edge - first) / spacing + 1 + _LEAST)
        x = np.asarray(first + spacing * np.arange(math.floor(known)), float)
        lower = cholesky(compliance(body.scene, x, x), lower=True)
        both = np.array([-body.height(x), np.ones(x.size)]).T
        return cls(body, spacing, x, lower, *solve_triangular(lower, both, lower=True).T)

    @property
    def whole(self) -> bool:
        """Whether the body ends at the last one."""
        return self.body.walled and bool(self.x[-1] + self.spacing / 2 > self.body.edge)

    @functools.cached_property
    def rest_depths(self) -> Array:
        """D of the links (n - 1,), in the middle between the nodes."""
        bound = self.body.scene.work_of_adhesion * np.diff(self.body.area(self.x))
        return -(self.start[1:] + np.sqrt(2 * bound)) / self.rate[1:]

    def last(self, depth: float) -> int | None:
        """The outermost node in contact on the way from first touch; None: none, -1: beyond all."""
        ahead = np.flatnonzero(self.rest_depths >= max(depth, self.body.touch))
        if not ahead.size:
            return self.x.size - 1 if self.whole else -1
        n = int(ahead[0])
        if depth < self.body.touch:
            back = np.flatnonzero(self.rest_depths[:n] <= depth)
            return int(back[-1]) + 1 if back.size else None
        return n

    def line(self, depth: float, n: int) -> float:
        """a between the nodes, where node n is the outermost in contact."""
        a = float(self.x[n])
        if n < self.x.size - 1:
            middle = (self.x[1:] + self.x[:-1]) / 2
            links = self._through(middle, self.rest_depths - depth, n - 1)
            lo, hi = a - self.spacing / 2, a + self.spacing / 2
            if links(lo) <= 0 < links(hi):
                return bracketed(lambda at: float(links(at)), lo, hi)
        return a

    def between(self, depth: float, a: float) -> tuple[float, float]:
        """P and U of a contact that ends between the nodes."""
        y = self.start + depth * self.rate
        bound = self.body.scene.work_of_adhesion * self.body.area(self.x)
        both = np.cumsum(y * self.rate), np.cumsum(y * y) / 2 - bound
        n = int(np.searchsorted(self.x, a)) - 1
        force, energy = (float(self._through(self.x, part, n)(a)) for part in both)
        return force, energy

    def _through(self, x: Array, y: Array, i: int) -> Polynomial:
        """The polynomial through the four points around that one and the next."""
        start = min(max(i - 1, 0), max(x.size - 4, 0))
        own = slice(start, start + 4)
        domain = [x[start], x[start] + 3 * self.spacing]
        return Polynomial.fit(x[own], y[own], x[own].size - 1, domain=domain)

    def forces(self, depth: float, n: int) -> Array:
        """On the nodes (n + 1,) of that contact."""
        y = (self.start + depth * self.rate)[: n + 1]
        return np.asarray(solve_triangular(self.lower[: n + 1, : n + 1], y, lower=True, trans=1))


def compliance(scene: Scene, z: Array, x: Array) -> Array:
    """Displacement at places z (m,) over the total force on pairs of nodes, or rings, x (n,).

    Beyond the largest q the rest of 1/(k + γ₁q²) is -H/(γ₁²q³), H of k = Hq on a half-space; what
    that leaves out falls like q⁻⁴.
    """
    layer, gamma = scene.layer, scene.gamma1
    still = layer.stiffness if layer.nu < 0.5 else layer.shear_modulus / layer.h
    m, half = math.sqrt(still / gamma), layer.shear_modulus / (1 - layer.nu)
    last = math.cbrt(m * (m * m + (half / gamma) ** 2) / (4 * _LEFT))
    last += 10 / layer.h + 10 * m + _RINGS * x.size / float(x[-1])
    q, weights = _wave_numbers(last, float(max(x[-1], z[-1])), 1 / layer.h + m)
    k = layer.stiffness_at(q)
    rest = (gamma * m * m - k) / ((k + gamma * q * q) * gamma * (q * q + m * m)) * weights
    rest *= q / (2 * math.pi) if scene.axisymmetric else 1 / math.pi
    found, wave = _springs(scene, z, x, m), j0 if scene.axisymmetric else np.cos
    for part in np.array_split(np.arange(q.size), max(1, q.size * max(x.size, z.size) // 10**7)):
        there = wave(np.outer(z, q[part]))
        found += (there * rest[part]) @ (there if z is x else wave(np.outer(x, q[part]))).T
    apart = _beyond(last, np.abs(np.subtract.outer(z, x)))
    size = half / (2 * math.pi * gamma**2)
    if scene.axisymmetric:  # for large arguments
        return found - size / math.pi / np.sqrt(np.outer(z, x)) * apart
    return found - size * (apart + _beyond(last, np.add.outer(z, x)))


def _beyond(last: float, apart: Array) -> Array:
    """∫ cos(qs)/q³ dq from the largest q on, of distances s."""
    y = np.maximum(last * apart, _SAME)
    return np.asarray((np.cos(y) - y * np.sin(y) + y * y * sici(y)[1]) / (2 * last * last))


def _wave_numbers(last: float, far: float, near: float) -> tuple[Array, Array]:
    """q and weights up to the last: panels that grow until waves turn within a length `far`."""
    wide, ends = _TURN / far, [0.0, _FLATTEST * near]
    if last > _MOST * wide:
        raise ValueError(
            f"the surface {far!r} from the middle of the contact is {last / wide:.0f} times as "
            "wide as what nodes have to resolve beside its line: use method='fitted', or a "
            "smaller depth"
        )
    while ends[-1] < last:
        ends.append(min(ends[-1] + min(_GROWN * ends[-1], wide), last))
    middle, half = np.add(ends[1:], ends[:-1]) / 2, np.diff(ends) / 2
    q, weights = middle[:, None] + half[:, None] * _POINTS, half[:, None] * _WEIGHTS
    return q.ravel(), weights.ravel()


def _springs(scene: Scene, z: Array, x: Array, m: float) -> Array:
    near, far = np.minimum.outer(z, x), np.maximum.outer(z, x)
    if scene.axisymmetric:
        apart = np.exp(-m * (far - near))
        return np.asarray(i0e(m * near) * k0e(m * far) * apart / (2 * math.pi * scene.gamma1))
    both = np.exp(-m * (far - near)) + np.exp(-m * (far + near))
    return np.asarray(both / (4 * m * scene.gamma1))
