"""The lattice programmes in cvxpy: an independent check, with solvers that share no code with ours.

With l = √(γ₁/k), s = Δx/l, displacements v = u/G in units of the scene's largest height G, and
energies in klG², the programmes on n nodes with exact tails beyond both ends are

    min over v   s/2 Σ v_i² + 1/(2s) [Σ (v_{i+1} - v_i)² + (1-λ)(v_1² + v_n²)]  - ω Σ y_i

    w = 0   s.t. v >= g/G                              convex: no y
    w > 0   s.t. v >= g/G,  v_i - g_i/G <= M_i (1 - z_i),  y_i <= z_i, z_{i+1},  z binary

with y_i = 1 on adhesive links and ω = wΔx/(klG²). M_i is the room above g_i below the highest g.
Heights too low to be reached are raised to where a contact costs more than it can ever gain:
K g²/2 > U(no contact) + wΔx(n-1), K the stiffness of the surface at one node.

Each programme is built once per lattice and size, and re-solved by changing cvxpy Parameters. That
of w > 0 fixes z; its displacements and multipliers are those of the convex programme with
v_i = g_i/G where z_i = 1. No other module may import cvxpy.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np
from numpy.typing import ArrayLike, NDArray

from discretization.lattice.nodal_energy import NodalEnergy
from discretization.lattice.nodes import Lattice

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
class _Programme:
    """A cvxpy problem, its variables and its parameters by name."""

    problem: Any
    variables: Mapping[str, Any]
    parameters: Mapping[str, Any]

    def solve(self, values: Mapping[str, Any], solver: str, **options: Any) -> dict[str, Array]:
        """Variables at these values of the parameters; RuntimeError if not solved."""
        for name, value in values.items():
            self.parameters[name].value = value
        self.problem.solve(solver=solver, **options)
        if self.problem.status != "optimal":
            raise RuntimeError(f"{solver} ended with status {self.problem.status!r}, not 'optimal'")
        return {name: variable.value for name, variable in self.variables.items()}


@dataclass(frozen=True)
class Oracle:
    """The programme on n nodes of a lattice: convex if w = 0, else with integers.

    ValueError for springs without tension (γ₁ = 0), too many nodes for integers or no solver for
    them.
    """

    lattice: Lattice
    nodes: int
    _programmes: Mapping[str, _Programme] = field(init=False, repr=False, compare=False)

    def __post_init__(self) -> None:
        lat, n = self.lattice, self.nodes
        _check(lat, n)
        programmes = {"convex": _convex(lat, n)}
        if lat.w:
            programmes["integer"] = _integer(lat, n)
        object.__setattr__(self, "_programmes", programmes)

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
        held = self._integers(floor, scale) if lat.w else np.zeros(shape, bool)
        u, force = self._pressed(held, floor, scale)
        held = held | (force > PRESSES * max(force.max(), lat.spring * scale))
        return OracleSolution(u, held, force, NodalEnergy(lat, held).value(u))

    def _pressed(self, held: Mask, g: Array, scale: float) -> tuple[Array, Array]:
        """Displacements over g, equal to it where held, and the multipliers of both."""
        values = {
            "floor": np.maximum(g / scale, -10.0),
            "held": held.astype(float),
            "height": np.where(held, g / scale, 0.0),
        }
        programme = self._programmes["convex"]
        v = programme.solve(values, "CLARABEL", **CLARABEL)["v"]
        above, equal = (c.dual_value for c in programme.problem.constraints)
        return v * scale, (above - held * equal) * math.sqrt(
            self.lattice.k * self.lattice.gamma1
        ) * scale

    def _integers(self, g: Array, scale: float) -> Mask:
        """The nodes in contact in the best of all contact sets."""
        lat = self.lattice
        floor = g / scale
        values = {
            "floor": floor,
            "room": max(0.0, floor.max()) - floor,
            "gain": lat.w * lat.spacing / (math.sqrt(lat.k * lat.gamma1) * scale**2),
        }
        z = self._programmes["integer"].solve(values, "SCIP", scip_params=SCIP)["z"]
        return np.asarray(z > 0.5)


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
    links = cp.sum_squares(cp.diff(v)) + lattice.loss * ends
    return s / 2 * cp.sum_squares(v) + links / (2 * s)


def _convex(lattice: Lattice, n: int) -> _Programme:
    """v above a floor and, where held = 1, at a height."""
    import cvxpy as cp

    v, floor, height = cp.Variable(n), cp.Parameter(n), cp.Parameter(n)
    held = cp.Parameter(n, nonneg=True)
    problem = cp.Problem(
        cp.Minimize(_elastic(lattice, v)), [v >= floor, cp.multiply(held, v) == height]
    )
    return _Programme(problem, {"v": v}, {"floor": floor, "held": held, "height": height})


def _integer(lattice: Lattice, n: int) -> _Programme:
    """v above a floor, at it where z = 1; a gain per link between two such nodes."""
    import cvxpy as cp

    v, z, y = cp.Variable(n), cp.Variable(n, boolean=True), cp.Variable(n - 1)
    floor, room, gain = cp.Parameter(n), cp.Parameter(n, nonneg=True), cp.Parameter(nonneg=True)
    problem = cp.Problem(
        cp.Minimize(_elastic(lattice, v) - gain * cp.sum(y)),
        [v >= floor, v <= floor + cp.multiply(room, 1 - z), y <= z[1:], y <= z[:-1]],
    )
    return _Programme(problem, {"z": z}, {"floor": floor, "room": room, "gain": gain})
