"""Measurements on the simulated field and branch, by numerical means only: no closed form here.

Conventions:

- A scene has `stiffness` k = Ẽ/h, `elastocapillary_length` l = √(γ₁/k) and `critical_separation` δ₀
  = √(2w/k).
- `FlatPunch(half_width)` has f = 0 up to its edges.
- `state.displacement(x)` is u, positive into the layer.
- `contacts` has a row (left, right) for each contact.
- `mesh.solve(scene, depth)` is the equilibrium, and `mesh.sweep(scene, depths, name)` an attribute
  of several.
- A `Grid` has `cells` links in l, shifted by `offset` links.
- `NodalEnergy(lattice, contact)` is the energy of nodes of which some are in contact: `relaxed(g)`
  are the displacements of least energy with u = g in contact, and `gradient(u)` the forces on the
  nodes, negative where they pull.
- `bracketed(h, a, b, close)` is the zero of h between a, where h <= 0, and b, where h > 0.
"""

import math
from collections.abc import Callable, Sequence
from dataclasses import replace
from itertools import pairwise
from typing import NamedTuple

import numpy as np

from discretization import Equilibrium, Lattice, NodalEnergy
from discretization.roots import bracketed
from energy import ElasticLayer, FlatPunch, Scene, SurfaceEnergies
from studies.verify.mesh import Array, Grid, Mesh

_ONE_SIDED = np.array([-25.0, 48.0, -36.0, 16.0, -3.0]) / 12  # first derivative, fourth order
_CURVATURE = np.array([-1.0, 16.0, -30.0, 16.0, -1.0]) / 12  # second derivative, fourth order
_BESIDE = np.array([-2.0, -1.0, 1.0, 2.0])  # steps to the points of a first derivative
_CENTRAL = np.array([1.0, -8.0, 8.0, -1.0]) / 12  # and their weights, fourth order
# Gauss's rule on (-1, 1): 64 points are exact for polynomials of degree 127.
_POINTS, _WEIGHTS = np.polynomial.legendre.leggauss(64)
# Of l, between the points of a difference quotient: the fourth order then leaves 1e-10 of a slope,
# and rounding 1e-13.
_STEP = 1 / 250
_ROUGH = 50  # links per l, above which contact is looked for on rougher nodes first
_CLOSE = 1e-13  # of a depth that is looked for: some hundred roundings
# A least force is found when the next step is less than this share of the interval: its error is of
# the second order in the step, 1e-10.
_FLAT = 1e-5
_STEPS = 40  # parabolas; the checks take at most 8


class Tail(NamedTuple):
    """Free surface right of the contact, u = -C exp(-x/l), read from two points of the field.

    Attributes
    ----------
    decay_length : float
        l [m].
    amplitude : float
        C [m], positive where the surface is pulled up.
    """

    decay_length: float
    amplitude: float


class Punches(NamedTuple):
    """Differences between two flat punches at one depth, per added width 2(a₂ - a₁).

    Attributes
    ----------
    force : float
        [N/m²], kd.
    energy : float
        [J/m²], kd²/2 - w.
    """

    force: float
    energy: float


def slopes_at_line(state: Equilibrium) -> tuple[float, float]:
    """Slopes at the right contact line, by one-sided differences of the field.

    Parameters
    ----------
    state : Equilibrium

    Returns
    -------
    inside, outside : float
        u'(a-0) and u'(a+0).
    """
    line = float(state.contacts[-1, 1])
    step = _STEP * state.scene.elastocapillary_length
    points = step * np.arange(5)
    inside = float(-_ONE_SIDED @ state.displacement(line - points)) / step
    outside = float(_ONE_SIDED @ state.displacement(line + points)) / step
    return inside, outside


def curvature(state: Equilibrium, x: Array) -> Array:
    """u''(x) by central differences of the field."""
    step = _STEP * state.scene.elastocapillary_length
    points = x[:, None] + step * np.arange(-2, 3)
    return state.displacement(points) @ _CURVATURE / step**2


def tail(state: Equilibrium) -> Tail:
    """l and C of Eq. (6) from the logarithm of the field, half an l and two l off the line."""
    ell = state.scene.elastocapillary_length
    x = float(state.contacts[-1, 1]) + np.array([0.5, 2.0]) * ell
    u = state.displacement(x)
    rate = -math.log(u[1] / u[0]) / (x[1] - x[0])
    return Tail(1 / rate, -float(u[0]) * math.exp(rate * x[0]))


def line_by_far_field(state: Equilibrium) -> float:
    """u(a) of Eq. (6) with l and C read from the field beyond the line."""
    far = tail(state)
    return float(-far.amplitude * np.exp(-state.half_width / far.decay_length))


def integral(function: Callable[[Array], Array], ends: Sequence[float]) -> float:
    """Gauss-Legendre quadrature over each interval between consecutive `ends`."""
    total = 0.0
    for lo, hi in pairwise(ends):
        half = (hi - lo) / 2
        x = (lo + hi) / 2 + half * _POINTS
        total += float(half * _WEIGHTS @ function(x))
    return total


def contact_pressure(state: Equilibrium) -> float:
    """∫ pressure dx over the contact; split at x = 0, where the profile may have a corner."""
    left, right = state.contacts[0]
    return integral(state.pressure, (left, 0.0, right))


def whole_line_force(state: Equilibrium) -> float:
    """k ∫ u dx over the whole line, 40 decay lengths to either side."""
    left, right = state.contacts[0]
    far = 40 * state.scene.elastocapillary_length
    springs = integral(state.displacement, (left - far, left, 0.0, right, right + far))
    return state.scene.stiffness * springs


def punch_difference(
    mesh: Mesh, layer: ElasticLayer, surfaces: SurfaceEnergies, depth: float
) -> Punches:
    """What a wider punch adds to force and energy: the tails are alike and drop out.

    Parameters
    ----------
    mesh : Mesh
    layer : ElasticLayer
    surfaces : SurfaceEnergies
    depth : float

    Returns
    -------
    Punches
        Per added width.
    """
    less = 1.37e-4  # both some l wide
    more = 2.11e-4
    narrow = mesh.solve(Scene(layer, surfaces, FlatPunch(less)), depth)
    wide = mesh.solve(Scene(layer, surfaces, FlatPunch(more)), depth)
    added = 2 * (more - less)
    return Punches((wide.force - narrow.force) / added, (wide.energy - narrow.energy) / added)


def last_contact(mesh: Mesh, scene: Scene, rtol: float = 1e-12) -> float:
    """Smallest depth that still holds, by bisection between 0 and -2 µm of the label."""
    lo = -2e-6
    hi = 0.0
    if mesh.solve(scene, lo).label != "detached" or mesh.solve(scene, hi).label == "detached":
        raise ValueError(f"the contact does not detach between the depths {lo!r} and {hi!r}")
    while hi - lo > -rtol * lo:
        middle = (lo + hi) / 2
        if mesh.solve(scene, middle).label == "detached":
            lo = middle
        else:
            hi = middle
    return hi


def brink(mesh: Mesh, scene: Scene) -> float:
    """A depth just short of detachment: at that point itself any width of a flat face holds.

    There a wider punch has the energy of a narrower one; what it has more is a straight line over
    d². The label says whether the contact holds on one side of this depth and not on the other.
    """
    raised = -5e-7
    at_zero = punch_difference(mesh, scene.layer, scene.surfaces, 0.0).energy
    at_raised = punch_difference(mesh, scene.layer, scene.surfaces, raised).energy
    depth = raised * math.sqrt(at_zero / (at_zero - at_raised))
    before = mesh.solve(scene, depth * (1 - mesh.short)).label
    beyond = mesh.solve(scene, depth * (1 + mesh.short)).label
    if before == "detached" or beyond != "detached":
        raise ValueError(f"no contact detaches at the depth {depth!r}, where its width is neutral")
    return depth * (1 - mesh.short)


def membrane(grid: Grid, scene: Scene, depth: float, width: float) -> tuple[Array, Array]:
    """Nodes and displacements of min U[u] over all u >= d - f, w = 0, on |x| <= width.

    No contact set is given: starting from every node below the indenter, or from what is in contact
    on nodes twice as far apart, nodes that pull are released and nodes that penetrate are added
    until none does (a quadratic programme).

    Parameters
    ----------
    grid : Grid
    scene : Scene
    depth : float
    width : float
        Half of that of the membrane.

    Returns
    -------
    x, u : ndarray (n,)
    """
    spacing = scene.elastocapillary_length / grid.cells
    lattice = Lattice.of(scene, spacing, grid.offset * spacing)
    last = math.ceil(width / spacing)
    x = lattice.x(np.arange(-last, last + 1))
    g = depth - scene.indenter.height(x)
    contact = g > 0
    if grid.cells > _ROUGH:
        rough = replace(grid, cells=grid.cells / 2, offset=grid.offset / 2)
        places, u = membrane(rough, scene, depth, width)
        touching = places[u == depth - scene.indenter.height(places)]
        contact = (x >= touching[0]) & (x <= touching[-1])
    while True:
        energy = NodalEnergy(lattice, contact)
        u = energy.relaxed(g)
        pulls = contact & (energy.gradient(u) < 0)
        wrong = pulls | (~contact & (u < g))
        if not wrong.any():
            return x, u
        contact = contact ^ wrong


def depth_at_width(mesh: Mesh, scene: Scene, half_width: float, lo: float, hi: float) -> float:
    """Depth at which the simulated half-width takes a value, by root finding.

    Parameters
    ----------
    mesh : Mesh
    scene : Scene
    half_width : float
    lo, hi : float
        Depths with less and with more.

    Returns
    -------
    float
    """
    return bracketed(lambda d: mesh.solve(scene, d).half_width - half_width, lo, hi, _CLOSE)


def even_energy(mesh: Mesh, scene: Scene, lo: float) -> float:
    """Depth between lo and 0 at which the simulated energy is that of the detached surface."""
    return bracketed(lambda d: mesh.solve(scene, d).energy, 0.0, lo, _CLOSE)


def least_force(mesh: Mesh, scene: Scene, lo: float, hi: float) -> float:
    """Most tensile force between two depths, by parabolas through the three least ones known.

    It is found when |step to the lowest point of the parabola| <= 1e-5 (hi - lo).

    Parameters
    ----------
    mesh : Mesh
    scene : Scene
    lo, hi : float
        The depths, with a force that falls and then rises between them.

    Returns
    -------
    float

    Raises
    ------
    ValueError
        If 40 parabolas do not find it.
    """
    depth = (lo + hi) / 2
    known = {lo: mesh.solve(scene, lo).force, hi: mesh.solve(scene, hi).force}
    for _ in range(_STEPS):
        known[depth] = mesh.solve(scene, depth).force
        best, second, third = sorted(known, key=known.__getitem__)[:3]
        # the parabola bend (d - best)² + ... through these three, whose lowest point is at step
        p = second - best
        q = third - best
        secant_p = (known[second] - known[best]) / p
        secant_q = (known[third] - known[best]) / q
        bend = (secant_p - secant_q) / (p - q)
        step = (p - secant_p / bend) / 2
        if abs(step) <= _FLAT * (hi - lo):
            return known[best] - bend * step**2
        depth = min(max(best + step, (lo + best) / 2), (best + hi) / 2)
    raise ValueError(f"no least force was found between the depths {lo!r} and {hi!r}")


def energy_derivative(mesh: Mesh, scene: Scene, depth: float) -> float:
    """dU/dd by a central difference of fourth order of the simulated energy."""
    step = 0.002 * scene.critical_separation
    energies = mesh.sweep(scene, depth + step * _BESIDE, "energy")
    return float(_CENTRAL @ energies) / step
