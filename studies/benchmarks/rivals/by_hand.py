"""What a user would write by hand: an active set, one sought line, a boundary value problem.

The primal-dual active set (Hintermüller, Ito, Kunisch 2003), for w = 0: nodes with λ > 0 or u < g
are held at g, the others are free with λ = 0; repeat until nothing changes. From {g > 0} it peels
one node per iteration; the contact of a grid half as fine is a start from which a few suffice.
"""

import math
from dataclasses import replace

import numpy as np
from scipy import integrate
from scipy.linalg import lapack

from discretization import NodalEnergy
from energy import Scene
from studies.benchmarks.rivals.problem import Answer, Array, Grid, Solve

COARSEST = 65
FAR = 30.0  # elastocapillary lengths of free surface for solve_bvp
Mask = np.ndarray


def nested(grid: Grid) -> Solve:
    """From the contact on a grid half as fine, down from the coarsest; by LAPACK's `dptsv`."""
    sizes = [grid.nodes]
    while sizes[-1] > COARSEST:
        sizes.append((sizes[-1] + 1) // 2)

    def solve() -> Answer:
        held = np.empty(0, bool)
        for n in reversed(sizes):
            own = replace(grid, nodes=n)
            start = np.repeat(held, 2)[:n] if held.size else own.g > 0
            u, multipliers, held = solved(own, start)
        return grid.read(u, multipliers)

    return solve


def held_at(grid: Grid, held: Mask) -> tuple[Array, Array]:
    """u (n,) with u = g on the held nodes, the others free; and the forces on the nodes."""
    diagonal, off = grid.bands()
    heights = np.where(held, grid.g, 0.0)
    right = heights.copy()
    right[1:] -= np.where(held[1:], 0.0, off * heights[:-1])
    right[:-1] -= np.where(held[:-1], 0.0, off * heights[1:])
    diagonal[held] = 1
    off[held[1:] | held[:-1]] = 0
    u = np.asarray(lapack.dptsv(diagonal, off, right, 1, 1, 1)[2])
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


def bisection(grid: Grid) -> Solve:
    """Energy of the contact |x| <= mΔx by a solve of all nodes; bisection: where it grows with m.

    Where the surface would pass through the indenter the line advances as well. Then a, P and U
    from a parabola through the energies (forces) of m-1, m, m+1.
    """
    middle = grid.nodes // 2

    def state(m: int) -> tuple[float, float, Array]:
        held = np.zeros(grid.nodes, bool)
        held[middle - m : middle + m + 1] = True
        inside = NodalEnergy(grid.lattice, held)
        finite = grid.scene.slopes == "finite"
        u = inside.relaxed(grid.g) if finite else held_at(grid, held)[0]
        return inside.value(u), float(inside.gradient(u)[held].sum()), u

    def advances(m: int) -> bool:
        energy, _, u = state(m)
        beside = middle + m + 1
        return bool(u[beside] < grid.g[beside]) or state(m + 1)[0] < energy

    def solve() -> Answer:
        low = 1
        high = middle - 4
        while high - low > 1:
            m = (low + high) // 2
            low, high = (m, high) if advances(m) else (low, m)
        near = [state(high + i) for i in (-1, 0, 1)]
        energy, force = ([float(s[part]) for s in near] for part in (0, 1))
        bend = energy[0] - 2 * energy[1] + energy[2]
        at = (energy[0] - energy[2]) / (2 * bend)
        a = float(high + at) * grid.spacing
        m = middle + high + 2
        angle = math.pi - grid.deficit(near[1][2][m : m + 3], m, a)
        pull = float(force[1] + at * (force[2] - force[0]) / 2)
        return Answer(a, pull, float(energy[1] - at * at * bend / 2), angle)

    return solve


def boundary_value(scene: Scene, depth: float, rtol: float, guess: float) -> Solve:
    """scipy's solve_bvp for the free surface and a; Young's law has to be put in by hand."""
    k = scene.stiffness
    gamma1 = scene.gamma1
    w = scene.work_of_adhesion
    ell = scene.elastocapillary_length
    finite = scene.slopes == "finite"
    deficit = scene.surfaces.angle_deficit if finite else scene.surfaces.small_slope_deficit
    length = FAR * ell
    f = scene.indenter.height
    f1 = scene.indenter.slope

    def surface(s: Array, y: Array, a: Array) -> Array:
        bend = k / gamma1 * y[0]
        return length * np.stack((y[1], bend * (1 + y[1] ** 2) ** 1.5 if finite else bend))

    def ends(left: Array, right: Array, a: Array) -> Array:
        angle = np.arctan(f1(a[0])) + np.arctan(left[1]) if finite else f1(a[0]) + left[1]
        return np.array([left[0] - (depth - f(a[0])), angle - deficit, right[1] + right[0] / ell])

    def solve() -> Answer:
        s = np.linspace(0, 1, 200) ** 2
        u = (depth - f(guess)) * np.exp(-FAR * s)
        start = np.stack((u, -u / ell))
        found = integrate.solve_bvp(surface, ends, s, start, p=[guess], tol=rtol, max_nodes=10**5)
        a = float(found.p[0])
        slope = float(found.y[1, 0])
        sine = slope / math.hypot(1, slope) if finite else slope
        x, weights = np.polynomial.legendre.leggauss(40)
        x = a / 2 * (x + 1)
        weights = a / 2 * weights
        stretch = np.hypot(1, f1(x)) if finite else 1 + f1(x) ** 2 / 2
        adhesive = stretch if finite else 1.0
        inside = k / 2 * (depth - f(x)) ** 2 + gamma1 * (stretch - 1) - w * adhesive
        force = 2 * k * float(weights @ (depth - f(x))) - 2 * gamma1 * sine
        points, heights = np.polynomial.legendre.leggauss(8)
        y = found.sol(s[:-1, None] + np.diff(s)[:, None] * (points + 1) / 2)
        rise = np.hypot(1, y[1]) - 1 if finite else y[1] ** 2 / 2
        outside = (k / 2 * y[0] ** 2 + gamma1 * rise) @ heights
        outside = float(np.diff(s) @ outside) * length / 2
        energy = 2 * (float(weights @ inside) + outside)
        angle = math.atan(f1(a)) + math.atan(slope) if finite else float(f1(a)) + slope
        return Answer(a, force, energy, math.pi - angle, bool(found.success))

    return solve
