"""The nodal problem every rival is given, how a, P, U and θ are read off its solution, and tasks.

n nodes over -L..L, lumped springs, linear elements, exact ends; u >= g = d - f:

    min  u·Ku/2,   K = tridiagonal(-t, kΔx + 2t, -t),   t = γ₁/Δx.

In units of the layer: only its k, γ₁ and w enter, and its thickness is arbitrary.

Conventions: x increases from left to right and has its origin at the apex. Heights f are positive
upwards, the depth d of f = 0 and displacements u downwards, so that the gap u - g is >= 0 and 0 in
contact; multipliers are the forces of the indenter on the nodes, >= 0, and P is their sum. Arrays
over nodes have the shape (n,), from left to right; `side` is -1 on the left of a contact, 1 on its
right. `Lattice.spring_stiffness` is kΔx, `link_stiffness` t, and `end_stiffness` the stiffness with
which the surface beyond the last node pulls at it.

- A scene has `gamma1` γ₁.
- `from_work(gamma1, w)` are surface energies of this tension and work of adhesion.
- `Sampled(x, z)` is a measured profile of heights z at x.
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

RADIUS = 10.0  # of the parabolas, in l
WAVES_SPACING = 1 / 25  # of the samples of wavy profiles, in l


class Answer(NamedTuple):
    """What a method gives for a task; NaN where it does not give a number.

    Attributes
    ----------
    half_width, force, energy : float or ndarray (depths,)
    angle : float or ndarray (depths,)
        Contact angle [rad].
    success : bool
        As the method claims.
    """

    half_width: Any
    force: Any
    energy: Any
    angle: Any
    success: bool = True


def elastic(w: float, radius: float, slopes: str = "small") -> Scene:
    """A parabola on a layer with k = γ₁ = 1.

    Parameters
    ----------
    w : float
        Work of adhesion.
    radius : float
        Of the parabola, over l.
    slopes : {"small", "finite"}

    Returns
    -------
    Scene
    """
    surfaces = SurfaceEnergies.from_work(1.0, w)
    return Scene(ElasticLayer(1.0, 0.0, 1.0), surfaces, Parabola(radius), slopes)


def rough(n: int) -> tuple[Scene, dict[str, Any]]:
    """A parabola with four waves of random phase over 16 l, and options for n nodes on it.

    The options are those of `minimise`: the lowest state of all, on nodes that are the samples. The
    waves have 1, 2, 3 and 5 periods in 4 l, and heights that fall as their lengths do.
    """
    rng = np.random.default_rng(5)
    odd = n // 2 * 2 + 1  # so that there is a node at x = 0
    x = np.linspace(-8, 8, odd)
    z = x * x / (2 * RADIUS)
    for waves_in_four in (1, 2, 3, 5):
        phase = rng.uniform(0, 6)
        height = 0.08 / waves_in_four
        z -= height * np.sin(2 * math.pi * waves_in_four * x / 4 + phase)
    scene = replace(elastic(0.05, RADIUS), indenter=Sampled(x, z))
    return scene, {"branch": "global", "spacing": float(x[1] - x[0])}


def waves(contacts: int) -> Scene:
    """A rough profile with l = 1 that touches about so many times, 25 nodes in each l.

    Waves between 3 l and 12 l long of random phases, in a trough whose walls end the profile.
    """
    half = 4.0 * contacts + 20
    last = round(half / WAVES_SPACING)
    x = np.arange(-last, last + 1) * WAVES_SPACING
    rng = np.random.default_rng(1)
    rough = np.zeros_like(x)
    for wave in np.linspace(3, 12, 30):
        phase = rng.uniform(0, 2 * math.pi)
        rough += wave * np.cos(2 * math.pi * x / wave + phase)
    walls = 0.3 * np.maximum(np.abs(x) - half + 15, 0) ** 2
    z = rough / rough.std() + walls
    return replace(elastic(0.3, RADIUS), indenter=Sampled(x, z - z.min(), kind="smooth"))


@dataclass(frozen=True, eq=False)
class Grid:
    """n nodes over -reach..reach under a scene's indenter at a depth.

    Attributes
    ----------
    scene : Scene
    depth : float
    nodes : int
    reach : float
        Half of the width they cover.
    """

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
        """Diagonal (n,) and off-diagonal (n-1,) of K, with the surface beyond both ends."""
        spring = self.lattice.spring_stiffness
        link = self.lattice.link_stiffness
        diagonal = np.full(self.nodes, spring + 2 * link)
        diagonal[[0, -1]] += self.lattice.end_stiffness - link
        off_diagonal = np.full(self.nodes - 1, -link)
        return diagonal, off_diagonal

    def pushed(self, u: Array) -> Array:
        """Ku (n,): the forces that hold the nodes."""
        diagonal, off = self.bands()
        force = diagonal * u
        force[:-1] += off * u[1:]
        force[1:] += off * u[:-1]
        return force

    def read(self, u: Array, multipliers: Array, success: bool = True) -> Answer:
        """a, P, U and θ of a solution with w = 0 and one contact.

        One of multiplier and gap of a node is 0, but for what the solver leaves; the node is in
        contact where the multiplier, over the stiffness of a spring, is the larger one.

        Parameters
        ----------
        u, multipliers : ndarray (n,)
            Displacements, and forces on the nodes.
        success : bool
            As the solver claims.

        Returns
        -------
        Answer
            The half-width is the mean of both lines', the angle that of the right one. NaN, and no
            success, with fewer than two contact nodes, without a free node on their left or without
            the three on their right from which the slope at the line is taken.
        """
        gap = np.maximum(u - self.g, 0)
        push = multipliers / self.lattice.spring_stiffness  # as a length, like the gap
        in_contact = np.flatnonzero(push > gap)
        unreadable = Answer(math.nan, math.nan, math.nan, math.nan, False)
        if in_contact.size < 2:
            return unreadable
        first = int(in_contact[0])
        last = int(in_contact[-1])
        free_on_left = first
        free_on_right = self.nodes - 1 - last
        if free_on_left < 1 or free_on_right < 3:
            return unreadable
        a = float(np.mean([self._line(u, first, -1), self._line(u, last, 1)]))
        deficit = self.deficit(u[last + 1 : last + 4], last + 1, a)
        energy = float(u @ self.pushed(u)) / 2
        force = float(multipliers.sum())
        return Answer(a, force, energy, math.pi - deficit, success)

    def _line(self, u: Array, m: int, side: int) -> float:
        """Distance from x = 0 of the line on a side of the outermost contact node m there.

        Near the line the gap v = u - g has v'' = c = u/l² + f'', on the lattice
        v_{m+j} = c(jΔx)²/2 + j(v_{m+1} - cΔx²/2), so that a = x_m + Δx/2 - v_{m+1}/(cΔx).
        """
        g = self.g
        dx = self.spacing
        bend_of_g = (g[m + 1] - 2 * g[m] + g[m - 1]) / dx**2  # -f''
        c = self.scene.stiffness / self.scene.gamma1 * u[m] - bend_of_g
        gap_beside = u[m + side] - g[m + side]  # v of the free node beside m
        return float(side * self.x[m] + dx / 2 - gap_beside / (c * dx))

    def deficit(self, u: Array, first: int, a: float) -> float:
        """π - θ [rad]: f'(a) plus the slope at a of the parabola through three free nodes.

        Parameters
        ----------
        u : ndarray (3,)
            Displacements of the free nodes next to a line on their left, outwards.
        first : int
            The index of the first of them.
        a : float
            Where the line is.

        Returns
        -------
        float
        """
        links_from_first = (a - self.x[first]) / self.spacing
        # Newton's interpolation: its slope in the midst of the first link, and the change from
        # there
        second_difference = u[2] - 2 * u[1] + u[0]
        rise_over_link = (u[1] - u[0]) + (links_from_first - 0.5) * second_difference
        slope_of_indenter = float(self.scene.indenter.slope(a))
        slope_of_surface = float(rise_over_link) / self.spacing
        if self.scene.slopes == "finite":
            return math.atan(slope_of_indenter) + math.atan(slope_of_surface)
        return slope_of_indenter + slope_of_surface


Solve = Callable[[], Answer]
# The rtol of a method without nodes, in place of numbers of nodes: two decades apart, down to where
# rounding of the sums is seen.
TOLERANCES = (1e-2, 1e-4, 1e-6, 1e-8, 1e-10, 1e-12)


@dataclass(frozen=True)
class Method:
    """A method that takes part.

    Attributes
    ----------
    name : str
    make : callable
        Prepares it for a task and a size, and gives what solves and the number of unknowns.
    largest : float
        Largest size.
    packages : tuple of str
        What has to be installed.
    only : tuple of int
        The sizes of a method that can do few; else empty.
    tolerances : bool
        Whether a size is an rtol, not a number of nodes.
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
    """A scene, its depths and what is exact there.

    Attributes
    ----------
    name : str
    scene : Scene
    depths : ndarray (depths,)
    exact : ndarray (4, depths)
        Rows of a, P, U and θ.
    methods : tuple of Method
        Who takes part.
    """

    name: str
    scene: Scene
    depths: Array
    exact: Array
    methods: tuple[Method, ...] = field(repr=False)

    @property
    def depth(self) -> float:
        """The last depth."""
        return float(self.depths[-1])

    @property
    def half_width(self) -> float:
        """That of the contact at the last depth."""
        return float(self.exact[0, -1])

    @property
    def largest_half_width(self) -> float:
        """That of the largest contact at any depth."""
        return float(self.exact[0].max())

    def errors(self, answer: Any) -> tuple[float, float, float, float]:
        """Largest relative errors of a, P, U and θ; for the rough profile of U alone."""
        parts = [np.asarray(part, float).T for part in answer[:4]]
        found = np.array(parts).reshape(4, -1)  # (4, depths), as `exact`
        size = np.abs(self.exact).max(axis=1)  # of each quantity over all depths
        a, force, energy, angle = np.abs(found - self.exact).max(axis=1) / size
        return float(a), float(force), float(energy), float(angle)


def installed(name: str) -> bool:
    """Whether an optional package is there."""
    return not name or importlib.util.find_spec(name) is not None
