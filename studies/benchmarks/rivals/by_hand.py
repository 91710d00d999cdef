"""What a user would write by hand: an active set, one sought line, a boundary value problem.

The primal-dual active set (Hintermüller, Ito, Kunisch 2003), for w = 0: nodes with λ > 0 or u < g
are held at g, the others are free with λ = 0; repeat until nothing changes. From {g > 0} it peels
one node per iteration; the contact of a grid half as fine is a start from which a few suffice.

Conventions:

- A scene has `stiffness` k = Ẽ/h, `gamma1` γ₁, `work_of_adhesion` w and `elastocapillary_length` l
  = √(γ₁/k).
- `surfaces.small_slope_deficit` is π - θ = √(2w/γ₁) (15); `surfaces.angle_deficit` is that of
  Young's law (8).
- Of a `Grid` of n nodes `g` is d - f, `bands()` the diagonal and off-diagonal of K, `pushed(u)` is
  Ku, and `deficit(u, first, a)` π - θ from three free nodes beside the line; `read(u, multipliers)`
  is the `Answer`, a, P, U and θ.
- A `Solve` has no arguments and returns one.
- `NodalEnergy(lattice, held)` is the energy of the nodes with some held: `relaxed(g)` are the
  displacements of least energy, `value(u)` is their energy, `gradient(u)` the forces on the nodes.
"""

import math
from collections.abc import Callable
from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np
from scipy import integrate
from scipy.linalg import lapack

from discretization import NodalEnergy
from energy import Scene
from studies.benchmarks.rivals.problem import Answer, Array, Grid, Solve

COARSEST = 65  # nodes of the coarsest grid, on which peeling takes few iterations
FAR = 30.0  # elastocapillary lengths of free surface for solve_bvp: exp(-30) = 1e-13 is left
Mask = np.ndarray


def nested(grid: Grid) -> Solve:
    """From the contact on a grid half as fine, down from the coarsest; by LAPACK's `dptsv`."""
    sizes = [grid.nodes]
    while sizes[-1] > COARSEST:
        sizes.append((sizes[-1] + 1) // 2)

    def solve() -> Answer:
        """The contact of each grid, from the coarsest on, begins the search on the next one."""
        held = np.empty(0, bool)
        for n in reversed(sizes):
            own = replace(grid, nodes=n)
            start = np.repeat(held, 2)[:n] if held.size else own.g > 0
            u, multipliers, held = solved(own, start)
        return grid.read(u, multipliers)

    return solve


def held_at(grid: Grid, held: Mask) -> tuple[Array, Array]:
    """u (n,) with u = g on the held nodes, the others free; and the forces on the nodes."""
    diagonal, off_diagonal = grid.bands()
    heights = np.where(held, grid.g, 0.0)
    right_hand_side = heights.copy()
    right_hand_side[1:] -= np.where(held[1:], 0.0, off_diagonal * heights[:-1])
    right_hand_side[:-1] -= np.where(held[:-1], 0.0, off_diagonal * heights[1:])
    diagonal[held] = 1
    off_diagonal[held[1:] | held[:-1]] = 0
    _, _, solution, _ = lapack.dptsv(diagonal, off_diagonal, right_hand_side, 1, 1, 1)
    u = np.asarray(solution)
    return u, grid.pushed(u)


def solved(grid: Grid, held: Mask) -> tuple[Array, Array, Mask]:
    """Displacements, multipliers (zero where free) and contact, from a first guess of it."""
    for _ in range(2 * grid.nodes):
        u, force = held_at(grid, held)
        multipliers = np.where(held, force, 0.0)
        changed = np.where(held, multipliers > 0, u < grid.g)
        if np.array_equal(changed, held):
            return u, multipliers, held
        held = changed
    raise RuntimeError(f"no active set after {2 * grid.nodes} iterations")


class Relaxed(NamedTuple):
    """A contact whose free surface is relaxed.

    Attributes
    ----------
    energy, force : float
    u : ndarray (n,)
        Displacements of the nodes.
    """

    energy: float
    force: float
    u: Array


def bisection(grid: Grid) -> Solve:
    """Energy of the contact |x| <= mΔx by a solve of all nodes; bisection: where it grows with m.

    Where the surface would pass through the indenter the line advances as well. Then a, P and U
    from a parabola through the energies (forces) of m-1, m, m+1.
    """
    middle = grid.nodes // 2

    def state(m: int) -> Relaxed:
        """Energy, force and displacements with the contact |x| <= mΔx."""
        held = np.zeros(grid.nodes, bool)
        held[middle - m : middle + m + 1] = True
        energy = NodalEnergy(grid.lattice, held)
        if grid.scene.slopes == "finite":
            u = energy.relaxed(grid.g)
        else:
            u, _ = held_at(grid, held)
        force = float(energy.gradient(u)[held].sum())
        return Relaxed(energy.value(u), force, u)

    def advances(m: int) -> bool:
        """Whether the contact -m..m grows: its surface penetrates, or one more node costs less."""
        here = state(m)
        beside = middle + m + 1
        penetrates = bool(here.u[beside] < grid.g[beside])
        return penetrates or state(m + 1).energy < here.energy

    def solve() -> Answer:
        """The state at which the energy of the contact no longer falls with m."""
        low = 1
        high = middle - 4
        while high - low > 1:
            m = (low + high) // 2
            if advances(m):
                low = m
            else:
                high = m
        before = state(high - 1)
        best = state(high)
        after = state(high + 1)
        # the lowest point of the parabola through three energies, in nodes from the middle one
        bend = before.energy - 2 * best.energy + after.energy
        offset = (before.energy - after.energy) / (2 * bend)
        a = float(high + offset) * grid.spacing
        force = float(best.force + offset * (after.force - before.force) / 2)
        energy = float(best.energy - offset * offset * bend / 2)
        first_free = middle + high + 2
        beside = best.u[first_free : first_free + 3]
        angle = math.pi - grid.deficit(beside, first_free, a)
        return Answer(a, force, energy, angle)

    return solve


def boundary_value(scene: Scene, depth: float, rtol: float, guess: float) -> Solve:
    """scipy's solve_bvp for the free surface and a; Young's law has to be put in by hand.

    The unknowns are y = (u, u') over s = (x - a)/(30 l) from 0 to 1, and the half-width a.

    Parameters
    ----------
    scene : Scene
    depth : float
    rtol : float
        Tolerance of solve_bvp.
    guess : float
        The half-width it starts from.

    Returns
    -------
    Solve
    """
    problem = _FreeSurface(scene, depth)

    def solve() -> Answer:
        """From a contact of the guessed width and an exponential surface."""
        s = np.linspace(0, 1, 200) ** 2
        u = (depth - scene.indenter.height(guess)) * np.exp(-FAR * s)
        start = np.stack((u, -u / scene.elastocapillary_length))
        found = integrate.solve_bvp(
            problem.rates, problem.ends, s, start, p=[guess], tol=rtol, max_nodes=10**5
        )
        a = float(found.p[0])
        slope = float(found.y[1, 0])
        force, inside = problem.of_contact(a, slope)
        energy = 2 * (inside + problem.energy_outside(s, found.sol))
        angle = math.pi - float(problem.deficit(a, slope))
        return Answer(a, force, energy, angle, bool(found.success))

    return solve


class _FreeSurface:
    """The boundary value problem of a free surface beside a contact, in small or finite slopes."""

    def __init__(self, scene: Scene, depth: float) -> None:
        """The scene at a depth, positive into the layer; `length` is that of the free surface."""
        self.scene = scene
        self.depth = depth
        self.finite = scene.slopes == "finite"
        self.length = FAR * scene.elastocapillary_length
        surfaces = scene.surfaces
        self.young = surfaces.angle_deficit if self.finite else surfaces.small_slope_deficit

    def rates(self, s: Array, y: Array, a: Array) -> Array:
        """dy/ds: the curvature of the surface is k u/γ₁.

        Parameters
        ----------
        s : ndarray (n,)
            Positions between 0 and 1.
        y : ndarray (2, n)
            u and u' there.
        a : ndarray (1,)
            Half-width, on which the curvature does not depend.

        Returns
        -------
        ndarray (2, n)
        """
        u, slope = y
        bend = self.scene.stiffness / self.scene.gamma1 * u
        if self.finite:
            bend = bend * (1 + slope**2) ** 1.5
        return self.length * np.stack((slope, bend))

    def ends(self, left: Array, right: Array, a: Array) -> Array:
        """At the line u = d - f and Young's angle; at the far end an exponential.

        Parameters
        ----------
        left, right : ndarray (2,)
            u and u' at the line and at the far end.
        a : ndarray (1,)
            Half-width.

        Returns
        -------
        ndarray (3,)
            All 0 for a solution.
        """
        height = self.depth - self.scene.indenter.height(a[0])
        angle = self.deficit(a[0], left[1])
        far = right[1] + right[0] / self.scene.elastocapillary_length
        return np.array([left[0] - height, angle - self.young, far])

    def deficit(self, a: float, slope: float) -> Any:
        """π - θ at a line at a, where the surface has this slope."""
        of_indenter = self.scene.indenter.slope(a)
        if self.finite:
            return np.arctan(of_indenter) + np.arctan(slope)
        return of_indenter + slope

    def of_contact(self, a: float, slope: float) -> tuple[float, float]:
        """The force, and the energy of half of the contact."""
        scene = self.scene
        points, weights = np.polynomial.legendre.leggauss(40)
        x = a / 2 * (points + 1)
        weights = a / 2 * weights
        displacement = self.depth - scene.indenter.height(x)
        steep = scene.indenter.slope(x)
        stretch = np.hypot(1, steep) if self.finite else 1 + steep**2 / 2
        adhering = stretch if self.finite else 1.0
        density = scene.stiffness / 2 * displacement**2 + scene.gamma1 * (stretch - 1)
        density = density - scene.work_of_adhesion * adhering
        sine = slope / math.hypot(1, slope) if self.finite else slope
        springs = 2 * scene.stiffness * float(weights @ displacement)
        return springs - 2 * scene.gamma1 * sine, float(weights @ density)

    def energy_outside(self, s: Array, solution: Callable[[Array], Array]) -> float:
        """The energy of one free surface, by Gauss-Legendre quadrature between these s."""
        points, weights = np.polynomial.legendre.leggauss(8)
        u, slope = solution(s[:-1, None] + np.diff(s)[:, None] * (points + 1) / 2)
        rise = np.hypot(1, slope) - 1 if self.finite else slope**2 / 2
        density = self.scene.stiffness / 2 * u**2 + self.scene.gamma1 * rise
        return float(np.diff(s) @ (density @ weights)) * self.length / 2
