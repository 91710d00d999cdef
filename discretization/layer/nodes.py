"""One contact of a layer on nodes: energies from the layer's own kernel, a line moved by links.

Forces on nodes (about an axis on rings) displace the surface of the layer with its tension by the
compliance C between them, an integral over wave numbers q of 1/(k(q) + γ₁q²); of that what springs
of stiffness γ₁m² under the same tension give is known in closed form, and the rest falls like q⁻³.
Held down by g on the nodes of a contact the surface has the energy gᵀC⁻¹g/2, and with the Cholesky
factor of C, nodes from the middle outwards, y = L⁻¹g,

    U_n = ½ Σ_{i≤n} y_i² - w A_n,    P_n = Σ_{i≤n} y_i ∂y_i/∂d,    u = L y of n nodes,

for all contacts of n nodes at once. So a line passes the link to node n where that lowers U, at

    y_n(d)² = 2w (A_n - A_{n-1}),

and D is known in the middle of every link. Neither poles nor the fields under the indenter are
used. Where the line is between the nodes is read from a spline through D, and force, energy and
fields are those of nodes that are stretched to it: of second order in the spacing.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any

import numpy as np
import scipy
from numpy.polynomial import Polynomial
from scipy.linalg import cholesky, solve_triangular

from discretization.certificate import Certificate
from discretization.equilibrium import QUANTITIES, Equilibrium
from discretization.lattice.accuracy import UNRESOLVED
from discretization.layer.body import Body
from discretization.layer.state import Layer, certified
from discretization.readings import with_surface
from discretization.roots import bracketed
from energy import Scene, SurfaceEnergies
from energy.arrays import Array

_FIRST, _MOST = 5, 12  # powers of 2: nodes on each side that are tried
_SPARE = 4  # links beyond the line, for splines
_LEAST = 1e-9  # of the spacing: a ring that is none
_FEW = 8  # nodes of a contact whose error is not known, at most
_SAFE = 4.0  # times the difference of two spacings
_LUCKY = 0.05  # of the errors of force and energy: where half-widths happen to agree
_COARSE = 0.05  # relative errors that are no small ones: nodes do not resolve the free surface
_KNOWN = 1e-6  # of results: what the compliance is good for
_STEP = 1e-2  # of γ₁: a difference as good as the nodes
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(16)
_TURN = 10.0  # of q times the largest distance: panels
_SAME = 1e-8  # waves over which two places are one
_LEFT = 1e-7  # of the compliance: what is left beyond the largest q
_RINGS = 20.0  # of that times the spacing, beyond which all rings are far from the axis
_FLATTEST = 1e-3  # of the wave numbers that matter: the first panel
_WIDEST = 1e5  # the largest q times the largest distance


class Nodes:
    """The surface at a depth held down at nodes, on each side of a scene's lowest point.

    x (n,): their distances from there, in contact or not; lower: L; y, rate (n,): y and its change
    with the depth; whole: whether the body ends at the last one.
    """

    def __init__(self, body: Body, depth: float, spacing: float, x: Array) -> None:
        self.body, self.depth, self.spacing, self.x = body, depth, spacing, x
        self.whole = body.walled and bool(x[-1] + spacing / 2 > body.edge)
        self.lower = cholesky(compliance(body.scene, x, x, spacing), lower=True)
        both = np.array([depth - body.height(x), np.ones(x.size)])
        self.y, self.rate = solve_triangular(self.lower, both.T, lower=True).T

    @classmethod
    def of(cls, body: Body, depth: float, spacing: float, count: int) -> Nodes:
        """At most so many on each side; the outermost one at the edge of a body that ends."""
        first = body.edge % spacing if body.walled else 0.0
        if body.power and first < _LEAST * spacing:
            first += spacing
        known = math.floor(min(count, (body.edge - first) / spacing + 1 + _LEAST))
        return cls(body, depth, spacing, first + spacing * np.arange(known, dtype=float))

    @functools.cached_property
    def rest_depths(self) -> Array:
        """D of the links (n - 1,), in the middle between the nodes."""
        bound = np.sqrt(2 * np.diff(self.body.bound(self.x)))
        return np.asarray(self.depth - (self.y[1:] + bound) / self.rate[1:])

    @functools.cached_property
    def n(self) -> int:
        """The outermost node in contact on the way from first touch; -1: none."""
        last, touch = self.x.size - 1, self.body.touch
        n = int(np.argmax(np.append(self.rest_depths, math.inf) >= max(self.depth, touch)))
        if self.depth >= touch or (n == last and not self.whole):
            return n
        held = np.append(-math.inf, self.rest_depths[:n]) <= self.depth
        return int(np.flatnonzero(held)[-1]) or -1

    @functools.cached_property
    def a(self) -> float:
        """The line, between the nodes."""
        a = self.outermost
        lo, hi = max(a - self.spacing / 2, 0.0), a + self.spacing / 2
        if not self.pinned:
            first = min(max(self.n - 2, 0), max(self.rest_depths.size - 4, 0))
            near, depths = self.x[1:][first : first + 4], self.rest_depths[first : first + 4]
            rest = Polynomial.fit(near - self.spacing / 2, depths, near.size - 1)
            if rest(lo) <= self.depth < rest(hi):
                return bracketed(lambda at: float(rest(at)) - self.depth, lo, hi)
        return a

    @functools.cached_property
    def held(self) -> Nodes:
        """Those in contact, stretched so that the outermost one is at the line."""
        links = max(round(self.a / self.spacing), 1)
        step, nodes = self.a / links, np.arange(self.body.power, links + 1, dtype=float)
        fixed = self.pinned or not self.a
        return self if fixed else Nodes(self.body, self.depth, step, step * nodes)

    pinned = property(lambda self: self.n == self.x.size - 1)
    outermost = property(lambda self: float(self.x[self.n]))
    stored = property(lambda self: float(self.y @ self.y) / 2)
    force = property(lambda self: float(self.held.y @ self.held.rate))
    energy = property(lambda self: self.held.stored - self.body.bound(self.a))

    @functools.cached_property
    def acting(self) -> Array:
        """The forces on the nodes held down (n,)."""
        return np.asarray(solve_triangular(self.held.lower.T, self.held.y))

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """Sums of the sizes of the terms of force and energy."""
        force = float(np.abs(self.acting).sum())
        return {"force": force, "energy": self.held.stored + self.body.bound(self.a)}

    def displaced(self, beside: Array) -> Array:
        """u of the free surface beside the line, and its slope outwards by half links (2, k)."""
        step, x, scene = self.spacing / 2, self.held.x, self.body.scene
        places = (self.a + beside + i * step for i in range(3))
        u, next_, last = (compliance(scene, z, x, self.spacing) @ self.acting for z in places)
        return np.array([u, (4 * next_ - last - 3 * u) / (2 * step)])

    shape = Layer.shape

    def pressure(self, state: Any, x: Array) -> Array:
        """The force on nodes over what each one stands for, less the tension's share.

        Neither of the innermost ring, which stands for more, nor of the outermost node.
        """
        body, own = self.body, slice(self.body.power, -1)
        ends = np.maximum(self.held.x[own] + self.held.spacing / 2 * np.array([[-1], [1]]), 0.0)
        share = body.whole * np.diff(ends ** (body.power + 1), axis=0)[0] / (body.power + 1)
        bend = body.whole * np.diff(ends**body.power * body.slope(ends), axis=0)[0]
        pressed = (self.acting[own] - body.scene.gamma1 * bend) / share
        return np.interp(np.abs(x - body.apex), self.held.x[own], pressed)

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force in parts; the energy of the surface is γ₁ ∂U/∂γ₁, as U is the least."""
        scene, x, c = self.body.scene, self.held.x, []
        for part in (1 - _STEP, 1 + _STEP):
            tension = SurfaceEnergies.from_work(part * scene.gamma1, 0.0)
            c.append(compliance(replace(scene, surfaces=tension), x, x, self.spacing))
        return with_surface(state, float(self.acting @ (c[0] - c[1]) @ self.acting) / (4 * _STEP))

    @functools.cached_property
    def certificate(self) -> Certificate:
        """The conditions of ../certificate.py, judged by the displacements that the forces give.

        At the nodes: the line is anywhere in its link, and the surface of a state that is right to
        second order may be inside the indenter there. Too few nodes have an unknown error.
        """
        n, own, rests = self.n, slice(self.n + 1), self.rest_depths
        forces = solve_triangular(self.lower[own, own].T, self.y[own])
        g = self.depth - self.body.height(self.x)
        off = g - self.lower[:, own] @ (self.lower[own, own].T @ forces)
        pulled = 0.0 if self.body.scene.work_of_adhesion else -float(forces.min())
        links = np.append(self.depth - rests[n : n + 1], rests[max(n - 1, 0) : n] - self.depth)
        size, pressed = float(np.abs(g[own]).max()) or 1.0, float(np.abs(forces).sum())
        return Certificate(
            float(off[n + 1 :].max(initial=0.0)) / size,
            float(np.abs(off[own]).max()) / size,
            max(0.0, pulled) / pressed,
            float(links.max(initial=0.0)) / size,
            abs(float(self.y[own] @ self.rate[own] - forces.sum())) / pressed,
        )

    def errors(self, state: Any) -> dict[str, float]:
        """As the difference from nodes further apart says, of second order; not known of few."""
        worst, sizes = np.full(3, _KNOWN), np.array([self.a, *self.scales.values()])
        for times in (2, 3):
            coarse = Nodes.of(self.body, self.depth, times * self.spacing, 1 + self.x.size // times)
            if self.n < _FEW or coarse.n < 1:
                return UNRESOLVED
            off = [getattr(coarse, q) - getattr(self, q) for q in ("a", "force", "energy")]
            worst = np.maximum(worst, _SAFE * np.abs(off) / sizes / (times**2 - 1))
        worst[1:] = worst.max()  # by what a line moves they change as well
        worst[0] = max(worst[0], 0.0 if self.pinned else _LUCKY * worst[1])
        known = dict(zip(QUANTITIES, worst.tolist(), strict=True))
        return known if worst.max() <= _COARSE else UNRESOLVED


def on_layer_nodes(scene: Scene, depth: float, spacing: float, *, branch: str) -> Equilibrium:
    """Certified state on the way from first touch, with its error estimate.

    ValueError where the contact reaches the end of a known profile, or has too many nodes.
    """
    body = Body(scene)
    for power in range(_FIRST, _MOST + 1):
        nodes = Nodes.of(body, depth, spacing, 2**power)
        if nodes.whole or nodes.x.size < 2**power or 2 * nodes.n < nodes.x.size:
            break
    if nodes.n >= nodes.x.size - _SPARE and not nodes.whole:
        raise ValueError(
            f"depth = {depth!r} spreads the contact over the whole known profile, or more than "
            f"{2**_MOST} nodes; give a wider profile, a larger spacing, or a smaller depth"
        )
    return certified(scene, depth, nodes if nodes.n >= 0 else None, branch, spacing)


def compliance(scene: Scene, z: Array, x: Array, spacing: float) -> Array:
    """Displacement at places z (m,) over the total force on pairs of nodes, or rings, x (n,).

    Panels of q grow until waves turn on them. Beyond the largest q the rest of 1/(k + γ₁q²) is
    -H/(γ₁²q³), H of k = Hq on a half-space; what that leaves out falls like q⁻⁴.
    """
    layer, gamma, axis = scene.layer, scene.gamma1, scene.axisymmetric
    m, half = math.sqrt(layer.shear_modulus / layer.h / gamma), layer.shear_modulus / (1 - layer.nu)
    last = math.cbrt(m * (m * m + (half / gamma) ** 2) / (4 * _LEFT))
    last += 10 / layer.h + 10 * m + _RINGS / spacing
    far, first = float(max(x[-1], z.max(), spacing)), _FLATTEST * (1 / layer.h + m)
    if last * far > _WIDEST:
        raise ValueError(
            f"the surface {far!r} from the middle of the contact is {last * far:.0f} times as "
            "wide as what nodes have to resolve beside its line: use method='fitted', or a "
            "smaller depth"
        )
    grown = np.geomspace(first, last, math.ceil(math.log2(last / first)))
    ends = np.union1d(np.linspace(0.0, last, 1 + math.ceil(last * far / _TURN)), grown)
    middle, wide = (ends[1:, None] + ends[:-1, None]) / 2, np.diff(ends)[:, None] / 2
    q, weights = (middle + wide * _POINTS).ravel(), (wide * _WEIGHTS).ravel()
    k = layer.stiffness_at(q)
    rest = (gamma * m * m - k) / ((k + gamma * q * q) * gamma * (q * q + m * m)) * weights
    rest *= q / (2 * math.pi) if axis else 1 / math.pi
    found, wave = _springs(scene, z, x, m), scipy.special.j0 if axis else np.cos
    for part in np.array_split(np.arange(q.size), max(1, q.size * max(x.size, z.size) // 10**7)):
        there = wave(np.outer(z, q[part]))
        found += (there * rest[part]) @ (there if z is x else wave(np.outer(x, q[part]))).T
    apart = _beyond(last, np.abs(np.subtract.outer(z, x)))
    size = half / (2 * math.pi * gamma**2)
    if axis:  # for large arguments
        return found - size / math.pi / np.sqrt(np.outer(z, x)) * apart
    return found - size * (apart + _beyond(last, np.add.outer(z, x)))


def _beyond(last: float, apart: Array) -> Array:
    """∫ cos(qs)/q³ dq from the largest q on, of distances s."""
    y = np.maximum(last * apart, _SAME)
    cosine = scipy.special.sici(y)[1]  # the cosine integral
    return np.asarray((np.cos(y) - y * np.sin(y) + y * y * cosine) / (2 * last * last))


def _springs(scene: Scene, z: Array, x: Array, m: float) -> Array:
    near, far = np.minimum.outer(z, x), np.maximum.outer(z, x)
    apart = np.exp(-m * (far - near)) / (2 * scene.gamma1)
    if scene.axisymmetric:
        both = scipy.special.i0e(m * near) * scipy.special.k0e(m * far)
        return np.asarray(both * apart / math.pi)
    return np.asarray(apart * (1 + np.exp(-2 * m * near)) / (2 * m))
