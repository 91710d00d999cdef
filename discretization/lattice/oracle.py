"""The lattice programmes in cvxpy: an independent check, with solvers that share no code with ours.

With l = √(γ₁/k), s = Δx/l, displacements v = u/G in units of the scene's largest height G, and
energies in klG², the programmes on n nodes with exact tails beyond both ends are

    min over v   s/2 Σ v_i² + 1/(2s) [Σ (v_{i+1} - v_i)² + (1-λ)(v_1² + v_n²)]  - ω Σ y_i

    w = 0   s.t. v >= g/G                              convex: no y
    w > 0   s.t. v >= g/G,  v_i - g_i/G <= M_i (1 - z_i),  y_i <= z_i, z_{i+1},  z binary

with y_i = 1 on adhesive links and ω = wΔx/(klG²). M_i is the room above g_i below the highest g.
Heights too low to be reached are raised to where a contact costs more than it can ever gain:
K g²/2 > U(no contact) + wΔx(n-1), K the stiffness of the surface at one node.

That of w > 0 fixes z; its displacements and multipliers are those of the convex programme with
v_i = g_i/G where z_i = 1. No other module may import cvxpy.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
MOST_INTEGERS = 100
PRESSES = 1e-6  # of the largest multiplier, at least kΔxG: less is a solver's noise
CLARABEL = {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10}
SCIP = {"numerics/feastol": 1e-7, "limits/gap": 0.0, "limits/absgap": 0.0}


@dataclass(frozen=True)
class OracleSolution:
    """A solver's answer, per unit length of the line contact.

    u: displacements (n,). contact: (n,) bool. multipliers: forces [force/length] of the indenter
    on the nodes (n,). energy: U[u] with the adhesion of that contact [energy/length].
    """

    u: Array
    contact: Mask
    multipliers: Array
    energy: float


@dataclass(frozen=True)
class Oracle:
    """The programme on n nodes of a lattice: convex if w = 0, else with integers.

    ValueError for springs without tension (γ₁ = 0), too many nodes for integers or no solver for
    them.
    """

    lattice: Lattice
    nodes: int

    def __post_init__(self) -> None:
        _check(self.lattice, self.nodes)

    def solve(self, g: ArrayLike) -> OracleSolution:
        """Minimum for heights g (n,), -inf where there is no obstacle.

        ValueError if g does not fit, RuntimeError if the solver did not reach its tolerance.
        """
        heights, shape = np.asarray(g, float), (self.nodes,)
        if heights.shape != shape or not heights.max() < math.inf:
            raise ValueError(f"g must be {shape} numbers, -inf for no obstacle; has {np.shape(g)}")
        lat = self.lattice
        floor = np.maximum(heights, -_deepest(lat, heights))
        scale = float(np.abs(floor).max()) or lat.spacing
        held = _integers(lat, floor / scale, scale) if lat.w else np.zeros(shape, bool)
        v, pull = _pressed(lat, held, floor / scale)
        u, force = v * scale, pull * math.sqrt(lat.k * lat.gamma1) * scale
        held = held | (force > PRESSES * max(force.max(), lat.spring * scale))
        return OracleSolution(u, held, force, NodalEnergy(lat, held).value(u))


def _check(lattice: Lattice, n: int) -> None:
    if n < 2:
        raise ValueError(f"nodes = {n!r} must be at least 2")
    if not lattice.gamma1:
        raise ValueError("gamma1 = 0 leaves independent springs, no programme: use u = max(g, 0)")
    if not lattice.w:
        return
    import cvxpy

    if n > MOST_INTEGERS:
        raise ValueError(f"nodes = {n!r} is too many for integers: use at most {MOST_INTEGERS}")
    if "SCIP" not in cvxpy.installed_solvers():
        raise ValueError("w > 0 needs the solver SCIP: pip install elastocap[test]")


def _deepest(lattice: Lattice, g: Array) -> float:
    """Depth below the surface beyond which no node can be in contact at the minimum."""
    free = NodalEnergy(lattice, np.zeros(g.size, bool)).value(np.maximum(g, 0.0))
    gain = free + lattice.w * lattice.spacing * (g.size - 1)
    return 1.01 * math.sqrt(2 * gain / (lattice.spring + 2 * lattice.end_stiffness))


def _elastic(lattice: Lattice, v: Any) -> Any:
    """The elastic energy in units of klG²."""
    import cvxpy as cp

    s = math.sqrt(lattice.spring / lattice.link)
    ends = cp.square(v[0]) + cp.square(v[-1])
    links = cp.sum_squares(cp.diff(v)) + lattice.end_stiffness / lattice.link * ends
    return s / 2 * cp.sum_squares(v) + links / (2 * s)


def _solved(problem: Any, solver: str, **options: Any) -> None:
    """RuntimeError if it is not solved."""
    problem.solve(solver=solver, **options)
    if problem.status != "optimal":
        raise RuntimeError(f"{solver} ended with status {problem.status!r}, not 'optimal'")


def _pressed(lattice: Lattice, held: Mask, floor: Array) -> tuple[Array, Array]:
    """Displacements above a floor and equal to it where held, and the multipliers of both."""
    import cvxpy as cp

    v, least = cp.Variable(floor.size), np.maximum(floor, -10.0)
    above, equal = v >= least, cp.multiply(held.astype(float), v) == np.where(held, floor, 0.0)
    problem = cp.Problem(cp.Minimize(_elastic(lattice, v)), [above, equal])
    _solved(problem, "CLARABEL", **CLARABEL)
    return np.asarray(v.value), above.dual_value - held * equal.dual_value


def _integers(lattice: Lattice, floor: Array, scale: float) -> Mask:
    """The nodes in contact in the best of all contact sets: a gain per link between two of them."""
    import cvxpy as cp

    n, room = floor.size, max(0.0, floor.max()) - floor
    gain = lattice.w * lattice.spacing / (math.sqrt(lattice.k * lattice.gamma1) * scale**2)
    v, z, y = cp.Variable(n), cp.Variable(n, boolean=True), cp.Variable(n - 1)
    problem = cp.Problem(
        cp.Minimize(_elastic(lattice, v) - gain * cp.sum(y)),
        [v >= floor, v <= floor + cp.multiply(room, 1 - z), y <= z[1:], y <= z[:-1]],
    )
    _solved(problem, "SCIP", scip_params=SCIP)
    return np.asarray(z.value) > 0.5
