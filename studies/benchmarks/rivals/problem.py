"""The nodal problem every rival is given, how a, P, U and θ are read off its solution, and tasks.

n nodes over -L..L, lumped springs, linear elements, exact ends; u >= g = d - f:

    min  u·Ku/2,   K = tridiagonal(-t, kΔx + 2t, -t),   t = γ₁/Δx.

In units of the layer: only its k, γ₁ and w enter, and its thickness is arbitrary.
"""

from __future__ import annotations

import functools
import importlib.util
import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass, field, replace
from typing import Any, NamedTuple

import numpy as np

from discretization import Lattice
from energy import ElasticLayer, Parabola, Sampled, Scene, SurfaceEnergies
from energy.arrays import Array

RADIUS = 10.0
WAVES_SPACING = 1 / 25  # in l


class Answer(NamedTuple):
    """Half-width, force, energy, contact angle [rad], arrays on a path; success as claimed."""

    half_width: Any
    force: Any
    energy: Any
    angle: Any
    success: bool = True


def elastic(w: float, radius: float, slopes: str = "small") -> Scene:
    """A parabola on a layer with k = γ₁ = 1."""
    surfaces = SurfaceEnergies.from_work(1.0, w)
    return Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, Parabola(radius), slopes)


def rough(n: int) -> tuple[Scene, dict[str, Any]]:
    """A parabola with four waves of random phase over 16 l, and options for n nodes on it."""
    scene = elastic(0.05, RADIUS)
    rng = np.random.default_rng(5)
    x = np.linspace(-8, 8, n // 2 * 2 + 1)
    z = x * x / (2 * RADIUS)
    for j in (1, 2, 3, 5):
        z -= 0.08 / j * np.sin(2 * math.pi * j * x / 4 + rng.uniform(0, 6))
    options = {"branch": "global", "spacing": float(x[1] - x[0])}
    return replace(scene, indenter=Sampled(x, z)), options


def waves(contacts: int) -> Scene:
    """A rough profile with l = 1 that touches about so many times, 25 nodes in each l.

    Waves between 3 l and 12 l long of random phases, in a trough whose walls end the profile.
    """
    half = 4.0 * contacts + 20
    rng = np.random.default_rng(1)
    x = np.arange(-round(half / WAVES_SPACING), round(half / WAVES_SPACING) + 1) * WAVES_SPACING
    z = np.zeros_like(x)
    for wave in np.linspace(3, 12, 30):
        z += wave * np.cos(2 * math.pi * x / wave + rng.uniform(0, 2 * math.pi))
    z = z / z.std() + 0.3 * np.maximum(np.abs(x) - half + 15, 0) ** 2
    return replace(elastic(0.3, RADIUS), indenter=Sampled(x, z - z.min(), kind="smooth"))


@dataclass(frozen=True, eq=False)
class Grid:
    """n nodes over -reach..reach under a scene's indenter at a depth."""

    scene: Scene
    depth: float
    nodes: int
    reach: float

    @functools.cached_property
    def x(self) -> Array:
        """Positions (n,)."""
        return np.linspace(-self.reach, self.reach, self.nodes)

    @property
    def spacing(self) -> float:
        """Δx."""
        return 2 * self.reach / (self.nodes - 1)

    @functools.cached_property
    def lattice(self) -> Lattice:
        """Springs, links and exact ends."""
        return Lattice.of(self.scene, self.spacing, 0.0)

    @functools.cached_property
    def g(self) -> Array:
        """d - f (n,)."""
        return self.depth - self.scene.indenter.height(self.x)

    def bands(self) -> tuple[Array, Array]:
        """Diagonal (n,) and off-diagonal (n-1,) of K."""
        lat = self.lattice
        diagonal = np.full(self.nodes, lat.spring_stiffness + 2 * lat.link_stiffness)
        diagonal[[0, -1]] += lat.end_stiffness - lat.link_stiffness
        return diagonal, np.full(self.nodes - 1, -lat.link_stiffness)

    def pushed(self, u: Array) -> Array:
        """Ku (n,): the forces that hold the nodes."""
        diagonal, off = self.bands()
        force = diagonal * u
        force[:-1] += off * u[1:]
        force[1:] += off * u[:-1]
        return force

    def read(self, u: Array, multipliers: Array, success: bool = True) -> Answer:
        """w = 0: a between the nodes from the first gap v beyond the last contact node m.

        Near the line v'' = c = u/l² + f'', on the lattice v_{m+j} = c(jΔx)²/2 + j(v_{m+1} -
        cΔx²/2), so a = x_m + Δx/2 - v_{m+1}/(cΔx). Contact: multiplier in springs above the gap.
        """
        g = self.g
        dx = self.spacing
        n = self.nodes
        held = np.flatnonzero(multipliers / self.lattice.spring_stiffness > np.maximum(u - g, 0))
        if held.size < 2 or held[0] < 1 or held[-1] > n - 4:
            return Answer(math.nan, math.nan, math.nan, math.nan, False)
        ends = []
        for m, side in ((int(held[0]), -1), (int(held[-1]), 1)):
            bend = (g[m + 1] - 2 * g[m] + g[m - 1]) / dx**2
            c = self.scene.stiffness / self.scene.gamma1 * u[m] - bend
            ends.append(side * self.x[m] + dx / 2 - (u[m + side] - g[m + side]) / (c * dx))
        a = float(np.mean(ends))
        m = int(held[-1])
        angle = math.pi - self.deficit(u[m + 1 : m + 4], m + 1, a)
        return Answer(a, float(multipliers.sum()), float(u @ self.pushed(u)) / 2, angle, success)

    def deficit(self, u: Array, first: int, a: float) -> float:
        """π - θ [rad]: f'(a) plus the slope at a of the parabola through three free nodes."""
        at = (a - self.x[first]) / self.spacing
        rise = (u[1] - u[0]) + (at - 0.5) * (u[2] - 2 * u[1] + u[0])
        f1 = float(self.scene.indenter.slope(a))
        slope = float(rise) / self.spacing
        if self.scene.slopes == "finite":
            return math.atan(f1) + math.atan(slope)
        return f1 + slope


Solve = Callable[[], Answer]
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


@dataclass(frozen=True)
class Method:
    """Name, how to prepare it for a size (number of nodes, or rtol), packages it needs.

    largest: size; only: sizes of a method that can do few; tolerances: it is given rtol, not nodes.
    """

    name: str
    make: Callable[[Task, float], tuple[Solve, int]]
    largest: float = math.inf
    packages: tuple[str, ...] = ()
    only: tuple[int, ...] = ()
    tolerances: bool = False

    def sizes(self, given: Sequence[int]) -> Sequence[float]:
        """The sizes, or the tolerances of a method without nodes."""
        if self.tolerances:
            return TOLERANCES
        return self.only or [n for n in given if n <= self.largest]


@dataclass(frozen=True, eq=False)
class Task:
    """A scene, its depths and what is exact there: columns a, P, U, θ."""

    name: str
    scene: Scene
    depths: Array
    exact: Array
    methods: tuple[Method, ...] = field(repr=False)

    @property
    def depth(self) -> float:
        """The last depth."""
        return float(self.depths[-1])

    def errors(self, answer: Any) -> tuple[float, float, float, float]:
        """Largest relative errors of a, P, U and θ; for the rough profile of U alone."""
        found = np.array([np.asarray(part, float).T for part in answer[:4]]).reshape(4, -1)
        size = np.abs(self.exact).max(axis=1)
        a, force, energy, angle = np.abs(found - self.exact).max(axis=1) / size
        return float(a), float(force), float(energy), float(angle)


def installed(name: str) -> bool:
    """Whether an optional package is there."""
    return not name or importlib.util.find_spec(name) is not None
