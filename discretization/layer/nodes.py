"""One contact of a layer on nodes: energies from the layer's own kernel, a line moved by links.

Forces on nodes (about an axis on rings) displace the surface of the layer with its tension by the
compliance C between them, an integral over wave numbers q of 1/(k(q) + γ₁q²); of that what springs
of stiffness γ₁m² under the same tension give is known in closed form, and the rest falls like q⁻³.
Held down by g on the nodes of a contact the surface has the energy gᵀC⁻¹g/2, and with the Cholesky
factor L of C = LLᵀ, nodes from the middle outwards, y = L⁻¹g,

    U_n = ½ Σ_{i≤n} y_i² - w A_n,    P_n = Σ_{i≤n} y_i ∂y_i/∂d,    u = L y of n nodes,

for all contacts of n nodes at once. So a line passes the link to node n where that lowers U, which
is once the node, above the surface until then (y_n < 0), is near enough:

    y_n(d) = -√(2w (A_n - A_{n-1})).

y_n is linear in d, so that D is known in the middle of every link. Neither poles nor the fields
under the indenter are used. Where the line is between the nodes is read from the polynomial through
D of four links, and force, energy and fields are those of nodes that are stretched to it: of second
order in the spacing.

Conventions
-----------
d, u and g = d - f, the displacement that the indenter prescribes, are positive downwards, forces on
nodes positive where they press; f is the height of the profile. Contacts are mirror-symmetric about
the lowest point of the profile, or lie around an axis, and a place is its distance x >= 0 from
there. One force belongs to the pair of nodes at -x and x, or to the whole ring of radius x; forces
and energies are per length of a line contact, or all around. A_n = 2x_n or πx_n² is the contact
area, w A_n is `Body.bound(x_n)`. `Body.power` is 1 about an axis, else 0; `Body.edge` is where the
known profile ends, and `Body.walled` whether the body does, too; `Body.touch` is the depth of first
touch, `Body.apex` the position of the lowest point, `Body.symmetry_factor` 2 or 2π, by which
integrals over x > 0 count. Node 0 is the innermost; link i lies between the nodes i and i + 1.

Of a layer, `shear_modulus` is G, `nu` ν, and `stiffness_at(q)` k(q) [stress/length].
`SurfaceEnergies.from_work(γ₁, w)` are surfaces of this tension and adhesion. `FreeSurface` gives
the shape of a free surface from `displaced`. `certified` makes the `Equilibrium` of what was found
and raises where its `Certificate` fails; `worst` is the largest violation, 0 if none is positive,
nan if one is nan. `bracketed` finds a zero between a place where a function is <= 0 and one where
it is > 0. `UNRESOLVED` are infinite errors by the names of `QUANTITIES`: half-width, force, energy.
"""

from __future__ import annotations

import functools
import math
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
import scipy
from numpy.polynomial import Polynomial
from scipy.linalg import cholesky, solve_triangular

from discretization.certificate import Certificate, worst
from discretization.equilibrium import QUANTITIES, Equilibrium
from discretization.lattice.accuracy import UNRESOLVED
from discretization.layer.body import Body
from discretization.layer.one_contact import FreeSurface, certified
from discretization.readings import with_surface
from discretization.roots import bracketed
from energy import Scene, SurfaceEnergies
from energy.arrays import Array


class NodeRules(NamedTuple):
    """How many nodes there are, and how a state on them estimates its errors.

    Errors are of second order in the spacing. So nodes t times further apart have an error t² times
    as large, and the difference over t² - 1 is the error, if the leading order rules. Halved or
    doubled, none of these changes 2 random states by 1e-9 (`python -m tests.sensitivity
    discretization.layer.nodes`); `safety`, `chance` and `coarse` decide about estimates alone.

    Attributes
    ----------
    first_power : int
        2⁵ nodes on each side are tried first,
    last_power : int
        and 2¹² at last: their compliance fills 128 MB.
    spare : int
        Links that must be known beyond the line, for the polynomial.
    no_ring : float
        Radius over the spacing of a ring that is none.
    fewest : int
        Nodes at least of a contact whose error coarser ones show.
    safety : float
        The estimated error over the difference of two spacings.
    chance : float
        Of the errors of force and energy: what the half-width is assumed to be off by, even if
        those of different spacings happen to agree.
    coarse : float
        Relative errors that are no small ones: nodes do not resolve the free surface.
    tension_step : float
        Relative step of γ₁ for ∂U/∂γ₁: a central difference is off by its square, 1e-4, as nodes
        are.
    """

    first_power: int = 5
    last_power: int = 12
    spare: int = 4
    no_ring: float = 1e-9
    fewest: int = 8
    safety: float = 4.0
    chance: float = 0.05
    coarse: float = 0.05
    tension_step: float = 1e-2


_NODES = NodeRules()


class WaveIntegral(NamedTuple):
    """How the integral over wave numbers is cut into panels.

    tests/layer/test_independent.py compares its results with those of poles. A tenth or ten times
    of `remainder`, or half or twice of `at_rings`, changes random states by up to 1.2e-8 of their
    scale, a hundredth of `error`, and none of the others by 1e-9 (`python -m tests.sensitivity
    discretization.layer.nodes`).

    Attributes
    ----------
    error : float
        Relative error of results that it leaves at most.
    phase : float
        Width of a panel in q times the largest distance: 1.6 waves for 16 points.
    remainder : float
        Of the compliance: what may be left beyond the largest q after its leading term is
        integrated in closed form.
    at_rings : float
        Largest q times the distance of the innermost ring from the axis, at least: J₀ is a wave
        there.
    first_panel : float
        End of the first panel, over the wave numbers of layer and tension.
    widest : float
        Largest q times the largest distance that are computed: 10⁴ panels.
    coincident : float
        Phase between two places that count as one.
    """

    error: float = 1e-6
    phase: float = 10.0
    remainder: float = 1e-7
    at_rings: float = 20.0
    first_panel: float = 1e-3
    widest: float = 1e5
    coincident: float = 1e-8


_WAVES = WaveIntegral()


_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(16)  # of one panel, on [-1, 1]


class Nodes(FreeSurface):
    """All contacts of the innermost nodes at a depth, and the one that is in equilibrium.

    Parameters
    ----------
    body : Body
    depth, spacing : float
        [length].
    x : ndarray (n,)
        Distances of the nodes from the lowest point, in contact or not, increasing [length].

    Attributes
    ----------
    ends_body : bool
        Whether the body ends at the last node.
    lower : ndarray (n, n)
        L, the Cholesky factor of the compliance.
    y, rate : ndarray (n,)
        y = L⁻¹g, g = d - f at the nodes, and ∂y/∂d.
    """

    def __init__(self, body: Body, depth: float, spacing: float, x: Array) -> None:
        """Compute and factorise the compliance between the nodes, in contact or not."""
        self.body = body
        self.depth = depth
        self.spacing = spacing
        self.x = x
        self.ends_body = body.walled and bool(x[-1] + spacing / 2 > body.edge)
        self.lower = cholesky(compliance(body.scene, x, x, spacing), lower=True)
        gap_and_rate = np.array([depth - body.height(x), np.ones(x.size)])
        self.y, self.rate = solve_triangular(self.lower, gap_and_rate.T, lower=True).T

    @classmethod
    def of(cls, body: Body, depth: float, spacing: float, most: int) -> Nodes:
        """Nodes a spacing apart, at most so many on each side.

        The innermost one is at the lowest point; about an axis, where that would be no ring, at one
        spacing; if the body ends, where it has to be so that the outermost one is at the edge.
        """
        first = body.edge % spacing if body.walled else 0.0
        if body.power and first < _NODES.no_ring * spacing:
            first += spacing
        count = math.floor(min(most, (body.edge - first) / spacing + 1 + _NODES.no_ring))
        return cls(body, depth, spacing, first + spacing * np.arange(count, dtype=float))

    @functools.cached_property
    def rest_depths(self) -> Array:
        """D of the links (n - 1,): the depths at which the node outside each joins the contact."""
        threshold = np.sqrt(2 * np.diff(self.body.bound(self.x)))
        return np.asarray(self.depth - (self.y[1:] + threshold) / self.rate[1:])

    @functools.cached_property
    def n(self) -> int:
        """The outermost node in contact on the path from first touch; -1 if contact is lost.

        At first touch, or the depth if that is more, the line has passed all links up to the first
        whose D is no less. A line that is then withdrawn to a smaller depth comes back to the first
        link, from outside, whose D is no more; a contact of node 0 alone is lost. A contact of all
        nodes of a profile that goes on is not withdrawn: `on_layer_nodes` takes more nodes.
        """
        last = self.x.size - 1
        touch = self.body.touch
        stops = np.append(self.rest_depths, math.inf) >= max(self.depth, touch)
        n = int(np.argmax(stops))
        if self.depth >= touch or (n == last and not self.ends_body):
            return n
        # Node i stays while the D of the link inside it is no more than the depth. Node 0, without
        # such a link, is always found; if no other is, the contact is lost.
        stays = np.append(-math.inf, self.rest_depths[:n]) <= self.depth
        return int(np.flatnonzero(stays)[-1]) or -1

    @property
    def pinned(self) -> bool:
        """Whether the line is at the last node: if `ends_body`, at the edge of the body."""
        return self.n == self.x.size - 1

    @property
    def outermost(self) -> float:
        """Distance of the outermost node in contact [length]."""
        return float(self.x[self.n])

    @functools.cached_property
    def a(self) -> float:
        """Half-width of the contact: where D is the depth, within half a link of its last node.

        D belongs to the middles of links and is the polynomial through those of four of them, two
        on either side of the last node where there are so many. Where that does not have the depth
        next to the node, as beside a corner, the line is taken to be at the node.
        """
        low = max(self.outermost - self.spacing / 2, 0.0)
        high = self.outermost + self.spacing / 2
        if self.pinned:
            return self.outermost
        first = min(max(self.n - 2, 0), max(self.rest_depths.size - 4, 0))  # of the four links
        middles = self.x[1:][first : first + 4] - self.spacing / 2
        depths = self.rest_depths[first : first + 4]
        rest = Polynomial.fit(middles, depths, middles.size - 1)
        if rest(low) <= self.depth < rest(high):
            return bracketed(lambda a: float(rest(a)) - self.depth, low, high)
        return self.outermost

    @functools.cached_property
    def in_contact(self) -> Nodes:
        """The nodes in contact, stretched so that the outermost one is at the line.

        They are this object itself if all its nodes are in contact, and node 0 if a is 0.
        """
        if self.pinned:
            return self
        if not self.a:
            return Nodes(self.body, self.depth, self.spacing, self.x[:1])
        links = max(round(self.a / self.spacing), 1)
        step = self.a / links
        nodes = np.arange(self.body.power, links + 1, dtype=float)
        return Nodes(self.body, self.depth, step, step * nodes)

    @property
    def stored(self) -> float:
        """Energy of the surface whose displacement is prescribed at all nodes, gᵀC⁻¹g/2."""
        return float(self.y @ self.y) / 2

    @property
    def force(self) -> float:
        """P = ∂U/∂d of the stretched nodes, positive where the indenter is pressed."""
        return float(self.in_contact.y @ self.in_contact.rate)

    @property
    def energy(self) -> float:
        """U of the stretched nodes: what they store, less w·area."""
        return self.in_contact.stored - self.body.bound(self.a)

    @functools.cached_property
    def forces(self) -> Array:
        """The forces C⁻¹g on the stretched nodes in contact, positive where they press."""
        return np.asarray(solve_triangular(self.in_contact.lower.T, self.in_contact.y))

    @functools.cached_property
    def scales(self) -> dict[str, float]:
        """Sums of the sizes of the terms of force and energy."""
        force = float(np.abs(self.forces).sum())
        return {"force": force, "energy": self.in_contact.stored + self.body.bound(self.a)}

    def displaced(self, distance: Array) -> Array:
        """u of the free surface and du/dx (2, k) at distances from the line (k,), x outwards.

        The slope is a difference of second order over two half links, from the place outwards.
        """
        step = self.spacing / 2
        nodes = self.in_contact.x
        u, first, second = (
            compliance(self.body.scene, self.a + distance + i * step, nodes, self.spacing)
            @ self.forces
            for i in range(3)
        )
        return np.array([u, (4 * first - second - 3 * u) / (2 * step)])

    def pressure(self, state: Any, x: Array) -> Array:
        """Pressure of the layer in contact, between the nodes by straight lines.

        A node or ring stands for the area from half a link inside to half a link outside. Its force
        less what the tension of the bent surface takes, γ₁ times the change of m f' over that area
        (m = 1, or x about an axis), over the area is the pressure. Neither the innermost ring,
        which stands for more, nor the outermost node, which has the force of the line, counts.

        Parameters
        ----------
        state : Equilibrium
            Not needed.
        x : ndarray (k,)
            Positions in contact [length].

        Returns
        -------
        ndarray (k,)
            [stress].

        Raises
        ------
        ValueError
            If there are no other nodes.
        """
        body = self.body
        inner = slice(body.power, -1)
        nodes = self.in_contact.x[inner]
        if not nodes.size:
            raise ValueError(
                f"spacing = {self.spacing!r} leaves no node inside the contact, whose half-width "
                f"is {self.a!r}: its pressure is not known; give a smaller spacing"
            )
        half = self.in_contact.spacing / 2
        ends = np.maximum(nodes + half * np.array([[-1], [1]]), 0.0)  # inside (0), outside (1)
        power = body.power + 1
        area = body.symmetry_factor * np.diff(ends**power, axis=0)[0] / power
        bend = body.symmetry_factor * np.diff(ends**body.power * body.slope(ends), axis=0)[0]
        pressure = (self.forces[inner] - body.scene.gamma1 * bend) / area
        return np.interp(np.abs(x - body.apex), nodes, pressure)

    def parts(self, state: Any) -> dict[str, float]:
        """Energy and force of a state in parts, under the names of `readings.with_surface`.

        As U is least, the energy of the surface is γ₁ ∂U/∂γ₁ = -FᵀC'F/2, F the forces and C' the
        derivative of the compliance by ln γ₁, here a difference.

        Parameters
        ----------
        state : Equilibrium
            That which these nodes are a part of.

        Returns
        -------
        dict of float
        """
        scene = self.body.scene
        nodes = self.in_contact.x

        def compliance_at(factor: float) -> Array:
            """Compliance between the nodes if γ₁ were that many times as large."""
            surfaces = SurfaceEnergies.from_work(factor * scene.gamma1, 0.0)
            return compliance(replace(scene, surfaces=surfaces), nodes, nodes, self.spacing)

        difference = compliance_at(1 - _NODES.tension_step) - compliance_at(1 + _NODES.tension_step)
        # -FᵀC'F/2 with C' = -difference/(2 step): the compliance of the smaller γ₁ comes first.
        surface = float(self.forces @ difference @ self.forces) / (4 * _NODES.tension_step)
        return with_surface(state, surface)

    @functools.cached_property
    def certificate(self) -> Certificate:
        """The conditions of certificate.py, by the displacements that the forces give.

        They are those at the nodes, before these are stretched: the line is anywhere in its link,
        and the surface of a state that is right to second order may be inside the indenter there.
        A contact of few nodes passes, too, with an error that is not known.

        Penetration, stationarity and what neighbours gain are over the largest displacement that is
        prescribed, the rest over the sum of the sizes of all forces.
        """
        n = self.n
        in_contact = slice(n + 1)
        lower = self.lower[in_contact, in_contact]
        forces = solve_triangular(lower.T, self.y[in_contact])
        prescribed = self.depth - self.body.height(self.x)  # g of all nodes
        displaced = self.lower[:, in_contact] @ (lower.T @ forces)  # u of all nodes
        inside = prescribed - displaced
        size = float(np.abs(prescribed[in_contact]).max()) or 1.0
        pressed = float(np.abs(forces).sum())
        pulled = 0.0 if self.body.scene.work_of_adhesion else -float(forces.min())
        # The line must not pass the link outside, nor come back over the one inside.
        advances = self.depth - self.rest_depths[n : n + 1]
        recedes = self.rest_depths[max(n - 1, 0) : n] - self.depth
        gains = np.append(advances, recedes)
        of_energy = self.y[in_contact] @ self.rate[in_contact]  # the force dU/dd
        return Certificate(
            penetration=float(inside[n + 1 :].max(initial=0.0)) / size,
            stationarity=float(np.abs(inside[in_contact]).max()) / size,
            opening=worst(pulled) / (pressed or 1.0),
            neighbours=float(gains.max(initial=0.0)) / size,
            force=abs(float(of_energy - forces.sum())) / (pressed or 1.0),
        )

    def errors(self, state: Any) -> dict[str, float]:
        """Relative errors of half-width, force and energy, from nodes 2 and 3 times further apart.

        Of second order in the spacing: a difference is divided by 2² - 1 or 3² - 1, and multiplied
        by 4 for safety. Infinite (`UNRESOLVED`) for a contact of few nodes, or if an error is above
        5 %.

        Parameters
        ----------
        state : Equilibrium
            Not needed.

        Returns
        -------
        dict of float
            By the names of `QUANTITIES`: of the half-width over itself, of force and energy over
            `scales`.
        """
        largest = np.full(3, _WAVES.error)
        sizes = np.array([self.a, *self.scales.values()])
        for times in (2, 3):
            most = 1 + self.x.size // times
            coarse = Nodes.of(self.body, self.depth, times * self.spacing, most)
            if self.n < _NODES.fewest or coarse.n < 1:
                return UNRESOLVED
            changes = [coarse.a - self.a, coarse.force - self.force, coarse.energy - self.energy]
            largest = np.maximum(largest, _NODES.safety * np.abs(changes) / sizes / (times**2 - 1))
        largest[1:] = largest.max()  # what moves a line changes force and energy as well
        of_half_width = 0.0 if self.pinned else _NODES.chance * largest[1]
        largest[0] = max(largest[0], of_half_width)
        if largest.max() > _NODES.coarse:
            return UNRESOLVED
        return dict(zip(QUANTITIES, largest.tolist(), strict=True))


def on_layer_nodes(scene: Scene, depth: float, spacing: float, *, branch: str) -> Equilibrium:
    """Equilibrium of one contact on nodes, on the path from first touch.

    Parameters
    ----------
    scene : Scene
        With response "layer", and what routes.py demands of it.
    depth, spacing : float
        [length].
    branch : str
        For the record.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotCertifiedError
        If the state fails its certificate.
    ValueError
        If the contact reaches the end of a known profile, or has too many nodes.
    """
    body = Body(scene)
    # More and more nodes, until the contact has no more than half of them or the profile ends.
    for power in range(_NODES.first_power, _NODES.last_power + 1):
        nodes = Nodes.of(body, depth, spacing, 2**power)
        if nodes.ends_body or nodes.x.size < 2**power or 2 * nodes.n < nodes.x.size:
            break
    if nodes.n >= nodes.x.size - _NODES.spare and not nodes.ends_body:
        raise ValueError(
            f"depth = {depth!r} spreads the contact over the whole known profile, or more than "
            f"{2**_NODES.last_power} nodes; give a wider profile, a larger spacing, or a smaller "
            "depth"
        )
    return certified(scene, depth, nodes if nodes.n >= 0 else None, branch, spacing)


def compliance(scene: Scene, z: Array, x: Array, spacing: float) -> Array:
    """Displacement of the surface at places over the total force on pairs of nodes, or on rings.

        C = 1/π ∫ cos(qz) cos(qx)/(k + γ₁q²) dq,  or  1/(2π) ∫ J₀(qz) J₀(qx) q/(k + γ₁q²) dq

    is that of springs of stiffness γ₁m² in closed form, and by Gauss's rule the integral of the
    difference, 1/(k + γ₁q²) - 1/(γ₁m² + γ₁q²). Beyond the largest q that is -H/(γ₁²q³), k = Hq on
    a half-space, which is integrated in closed form. What that leaves out begins with
    (m² + H²/γ₁²)/(γ₁q⁴); its integral beyond Q over the compliance 1/(2γ₁m) of the springs is about

        m (m² + H²/γ₁²)/(4 Q³),

    from which the largest q follows. There qh > 10, too, so that k = Hq but for e⁻²⁰.

    Parameters
    ----------
    scene : Scene
    z : ndarray (m,)
        Places [length].
    x : ndarray (n,)
        Nodes, or radii of rings [length].
    spacing : float
        Of the nodes [length].

    Returns
    -------
    ndarray (m, n)
        [length² per force], or [length per force] about an axis.

    Raises
    ------
    ValueError
        If waves as short as the nodes are apart cannot be followed that far.
    """
    layer = scene.layer
    gamma1 = scene.gamma1
    m = math.sqrt(layer.shear_modulus / layer.h / gamma1)  # any would do; γ₁m² = G/h is like k
    half_space = layer.shear_modulus / (1 - layer.nu)  # H
    largest = math.cbrt(m * (m * m + (half_space / gamma1) ** 2) / (4 * _WAVES.remainder))
    # From 10/h on k is Hq, and from 10 m on what the leading term leaves out is (m/q)² = 1 % of it.
    largest += 10 / layer.h + 10 * m + _WAVES.at_rings / spacing
    first = _WAVES.first_panel * (1 / layer.h + m)
    furthest = float(max(x[-1], z.max(), spacing))
    q, weights = _wave_numbers(first, largest, furthest)

    k = layer.stiffness_at(q)
    difference = (gamma1 * m * m - k) / ((k + gamma1 * q * q) * gamma1 * (q * q + m * m))
    density = difference * weights
    density *= q / (2 * math.pi) if scene.axisymmetric else 1 / math.pi
    wave = scipy.special.j0 if scene.axisymmetric else np.cos
    found = _springs(scene, z, x, m)
    blocks = max(1, q.size * max(x.size, z.size) // 10**7)  # 10⁷ numbers are 80 MB
    for block in np.array_split(np.arange(q.size), blocks):
        waves_z = wave(np.outer(z, q[block]))
        waves_x = waves_z if z is x else wave(np.outer(x, q[block]))
        found += (waves_z * density[block]) @ waves_x.T

    # cos(qz) cos(qx) is half of cos(q(z-x)) + cos(q(z+x)). J₀(qz) J₀(qx) is, for large arguments,
    # cos(q(z-x))/(πq√(zx)), but for a wave of z + x whose integral is next to nothing.
    beyond = _beyond(largest, np.abs(np.subtract.outer(z, x)))
    size = half_space / (2 * math.pi * gamma1**2)
    if scene.axisymmetric:
        return found - size / math.pi / np.sqrt(np.outer(z, x)) * beyond
    return found - size * (beyond + _beyond(largest, np.add.outer(z, x)))


def _wave_numbers(first: float, largest: float, furthest: float) -> tuple[Array, Array]:
    """Gauss points and weights of the integral over wave numbers from 0 to the largest.

    Panels grow twofold from the first on, until they are as wide as waves over the largest distance
    allow (`WaveIntegral.phase`).

    Parameters
    ----------
    first, largest : float
        End of the first panel, and the largest wave number [1/length].
    furthest : float
        The largest distance from the middle [length].

    Returns
    -------
    q, weights : ndarray (k,)
        [1/length].

    Raises
    ------
    ValueError
        If that would be too many panels.
    """
    if largest * furthest > _WAVES.widest:
        raise ValueError(
            f"the surface {furthest!r} from the middle of the contact is "
            f"{largest * furthest:.0f} times as "
            "wide as what nodes have to resolve beside its line: use method='fitted', or a "
            "smaller depth"
        )
    growing = np.geomspace(first, largest, math.ceil(math.log2(largest / first)))
    even = np.linspace(0.0, largest, 1 + math.ceil(largest * furthest / _WAVES.phase))
    ends = np.union1d(even, growing)
    middle = (ends[1:, None] + ends[:-1, None]) / 2
    half = np.diff(ends)[:, None] / 2
    return (middle + half * _POINTS).ravel(), (half * _WEIGHTS).ravel()


def _beyond(largest: float, distance: Array) -> Array:
    """∫ cos(qs)/q³ dq from the largest q on, of distances s, an array [length²].

    With y = qs at the largest q it is (cos y - y sin y + y² Ci(y))/(2q²), Ci the cosine integral.
    """
    y = np.maximum(largest * distance, _WAVES.coincident)
    cosine_integral = scipy.special.sici(y)[1]
    integral = np.cos(y) - y * np.sin(y) + y * y * cosine_integral
    return np.asarray(integral / (2 * largest * largest))


def _springs(scene: Scene, z: Array, x: Array, m: float) -> Array:
    """The compliance of springs of stiffness γ₁m² under the tension γ₁, as of `compliance`.

    It is (e^(-m|z-x|) + e^(-m(z+x)))/(4γ₁m), or I₀ of the nearer and K₀ of the further place times
    m, over 2πγ₁.
    """
    near = np.minimum.outer(z, x)
    far = np.maximum.outer(z, x)
    decay = np.exp(-m * (far - near)) / (2 * scene.gamma1)
    if scene.axisymmetric:
        bessel = scipy.special.i0e(m * near) * scipy.special.k0e(m * far)
        return np.asarray(bessel * decay / math.pi)
    return np.asarray(decay * (1 + np.exp(-2 * m * near)) / (2 * m))
