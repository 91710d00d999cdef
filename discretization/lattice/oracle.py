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

u and g = d - f are positive down into the layer, g = -∞ where there is no obstacle. Link i is
between the nodes i and i + 1. Multipliers are forces with which the indenter presses on nodes,
negative where adhesion pulls them up, in units of √(kγ₁) G in the programmes. Of a lattice,
`spacing` is Δx, `spring_stiffness` kΔx, `link_stiffness` t = γ₁/Δx and `end_stiffness` t(1 - λ),
what a tail pulls with at a node over its u. `NodalEnergy(lattice, contact).value(u)` is U[u].
"""

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from energy.arrays import Array, Mask

MOST_INTEGERS = 100  # nodes: a search among 2ⁿ contact sets
# Of the largest multiplier, at least kΔxG: less is a solver's noise, whose tolerances stand below.
PRESSES = 1e-6
_CERTAINLY_FREE = 1.01  # of the height whose contact costs what it can gain: more than rounding
CLARABEL = {"tol_gap_abs": 1e-10, "tol_gap_rel": 1e-10, "tol_feas": 1e-10}
SCIP = {"numerics/feastol": 1e-7, "limits/gap": 0.0, "limits/absgap": 0.0}


@dataclass(frozen=True)
class OracleSolution:
    """A solver's minimum, per unit length of the line contact.

    Attributes
    ----------
    u : ndarray (n,)
        Displacements [length].
    contact : ndarray of bool (n,)
        Nodes in contact.
    multipliers : ndarray (n,)
        Forces of the indenter on the nodes, positive if it presses [force/length].
    energy : float
        U[u] with the adhesion of that contact [energy/length].
    """

    u: Array
    contact: Mask
    multipliers: Array
    energy: float


def oracle(lattice: Lattice, g: ArrayLike) -> OracleSolution:
    """The minimum of U over all surfaces above these heights, and over all contact sets.

    Parameters
    ----------
    lattice : Lattice
    g : array_like (n,)
        d - f at the nodes, -inf where there is no obstacle [length].

    Returns
    -------
    OracleSolution

    Raises
    ------
    ValueError
        If g does not fit, for springs without tension (γ₁ = 0), for too many nodes for integers,
        or without a solver for these.
    RuntimeError
        If the solver did not reach its tolerance.
    """
    g = np.asarray(g, float)
    _refuse(lattice, g)
    # U without adhesion of some surface above all heights, and all that adhesion can gain: a node
    # whose contact costs more is in none of lowest energy.
    free = NodalEnergy(lattice, np.zeros(g.size, bool)).value(np.maximum(g, 0.0))
    gain = free + lattice.w * lattice.spacing * (g.size - 1)
    stiffness = lattice.spring_stiffness + 2 * lattice.end_stiffness
    deepest = _CERTAINLY_FREE * math.sqrt(2 * gain / stiffness)
    floor = np.maximum(g, -deepest)
    scale = float(np.abs(floor).max()) or lattice.spacing
    adhering = np.zeros(g.size, bool)
    if lattice.w:
        adhering = _integers(lattice, floor / scale, scale)
    v, multipliers = _pressed(lattice, adhering, floor / scale)
    u = v * scale
    force = multipliers * math.sqrt(lattice.k * lattice.gamma1) * scale
    contact = adhering | (force > PRESSES * max(force.max(), lattice.spring_stiffness * scale))
    return OracleSolution(u, contact, force, NodalEnergy(lattice, contact).value(u))


def _refuse(lattice: Lattice, g: Array) -> None:
    """ValueError for what the programmes cannot express, or no solver is installed for."""
    if g.ndim != 1 or g.size < 2 or not g.max() < math.inf:
        raise ValueError(f"g of shape {g.shape} must be two numbers or more, -inf for no obstacle")
    if not lattice.gamma1:
        raise ValueError("gamma1 = 0 leaves independent springs, no programme: use u = max(g, 0)")
    if lattice.w and g.size > MOST_INTEGERS:
        raise ValueError(f"nodes = {g.size!r} is too many for integers: at most {MOST_INTEGERS}")
    import cvxpy

    if lattice.w and "SCIP" not in cvxpy.installed_solvers():
        raise ValueError("w > 0 needs the solver SCIP: pip install elastocap[test]")


def _solve(
    lattice: Lattice, v: Any, gain: Any, constraints: list[Any], solver: str, **options: Any
) -> None:
    """min elastic energy - gain, in units of klG²; RuntimeError if it is not solved."""
    import cvxpy as cp

    s = math.sqrt(lattice.spring_stiffness / lattice.link_stiffness)
    ends = cp.square(v[0]) + cp.square(v[-1])
    links = cp.sum_squares(cp.diff(v)) + lattice.end_stiffness / lattice.link_stiffness * ends
    elastic = s / 2 * cp.sum_squares(v) + links / (2 * s)
    problem = cp.Problem(cp.Minimize(elastic - gain), constraints)
    problem.solve(solver=solver, **options)
    if problem.status != "optimal":
        raise RuntimeError(f"{solver} ended with status {problem.status!r}, not 'optimal'")


def _pressed(lattice: Lattice, adhering: Mask, floor: Array) -> tuple[Array, Array]:
    """Displacements (n,) above a floor, on it where nodes adhere, and the multipliers (n,) of both.

    adhering, floor (n,): which nodes adhere, and g in units of G. `dual_value` is what cvxpy calls
    the multiplier of a constraint.
    """
    import cvxpy as cp

    v = cp.Variable(floor.size)
    above = v >= floor
    on_floor = cp.multiply(adhering.astype(float), v) == np.where(adhering, floor, 0.0)
    _solve(lattice, v, 0.0, [above, on_floor], "CLARABEL", **CLARABEL)
    return np.asarray(v.value), above.dual_value - adhering * on_floor.dual_value


def _integers(lattice: Lattice, floor: Array, scale: float) -> Mask:
    """The nodes in contact (n,) in the best of all contact sets.

    What adhesion gains is counted per link between two of them.
    floor (n,): g in units of `scale`, which is G [length].
    """
    import cvxpy as cp

    room = max(0.0, floor.max()) - floor
    gain = lattice.w * lattice.spacing / (math.sqrt(lattice.k * lattice.gamma1) * scale**2)
    v = cp.Variable(floor.size)
    contact = cp.Variable(floor.size, boolean=True)
    adhesive = cp.Variable(floor.size - 1)  # links
    constraints = [
        v >= floor,
        v <= floor + cp.multiply(room, 1 - contact),
        adhesive <= contact[1:],
        adhesive <= contact[:-1],
    ]
    _solve(lattice, v, gain * cp.sum(adhesive), constraints, "SCIP", scip_params=SCIP)
    return np.asarray(contact.value) > 0.5
