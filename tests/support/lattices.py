"""Lattices with heights of their nodes, and the least energies on them by brute force."""

import math
from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np

from discretization.certificate import Proof
from discretization.lattice.certificate import on_row
from discretization.lattice.lowest import global_minimum
from discretization.lattice.walk import Walk
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.nodes.obstacle import pressed as held_by
from discretization.nodes.obstacle import surface
from discretization.nodes.row import Row, heights, region
from energy import ElasticLayer, Profile, Scene, SurfaceEnergies

from .example_scenes import roughness


def lattice(ell, *, k=37.0, spacing=0.03, w=0.0):
    """Lattice whose l/Δx is ell; no parameter is 1."""
    return Lattice(spacing, 0.0, k, k * (ell * spacing) ** 2, w)


def nodes_of(state):
    """The lattice of a state, and the first and last nodes of its contacts (m, 2)."""
    lattice = Lattice.of(state.scene, state.spacing)
    return lattice, np.rint((state.nodes - lattice.origin) / lattice.spacing).astype(int)


def rough_heights(rng, n, offset=-0.3):
    """Self-affine heights (n,), rms 0.07, their mean shifted by some rms."""
    z = roughness(n, n / 3, 2, int(rng.integers(2**31)))
    return 0.07 * (z - z.mean() + offset)


def of_heights(lattice, g, ends, depth=None, factor=None):
    """Contacts of nodes 0, 1, ... with these g, at a depth of their size; far off beyond the last.

    factor: of a pattern that is the same on all links.
    """
    depth = float(np.abs(g).max()) if depth is None else depth
    nothing = Profile(lambda x: 0 * x, lambda x: 0 * x)
    f = depth - np.append(g, [-1e3 * abs(depth)] * 3)
    return on_row(row_of(lattice, nothing, f, factor=factor), [*map(tuple, ends)], depth)


def row_of(lattice, indenter, f, first=0, factor=None):
    """Nodes of these heights."""
    lattice = lattice if factor is None else replace(lattice, w=factor * lattice.w)
    surfaces = SurfaceEnergies.from_work(lattice.gamma1, lattice.w)
    scene = Scene(ElasticLayer(lattice.k, 0.0, 1.0), surfaces, indenter)
    row = Row(lattice, scene, first, f.size, int(np.argmin(f)))
    vars(row)["f"] = f
    return row


def over(lattice, indenter, depth, *nodes):
    """Contacts between these first and last nodes under an indenter."""
    ends = np.array(nodes)
    lo, hi, _ = region(lattice, indenter, depth)
    start = max(lo, ends.min() - 5000)
    stop = min(hi, ends.max() + 5000)
    every = np.arange(start, stop + 1)
    f = heights(lattice, indenter, every.astype(float))
    own = [(int(one - every[0]), int(other - every[0])) for one, other in nodes]
    return on_row(row_of(lattice, indenter, f, int(every[0])), own, depth)


def pressed(lattice, scene, depth):
    """First and last contact node on the path that touches first, and then moves to this depth."""
    row = Row.of(scene, lattice, depth)
    walk = Walk(row)
    deepest = max(depth, row.lowest)
    ((first, last),) = walk.moved(walk.touched(deepest), deepest, depth)
    return first + row.first, last + row.first


def random_lattice(seed, most=14):
    """Lattice and nodal g of a random profile; decay length, w and depth over decades."""
    rng = np.random.default_rng(seed)
    n = int(rng.integers(2, most + 1))
    spacing, k = 10 ** rng.uniform(-3, 3, 2)
    ell = spacing * 10 ** rng.uniform(-1, 1.5)
    is_noise = rng.random() < 0.6
    steps = rng.normal(size=n)
    f = steps if is_noise else np.cumsum(steps) / 2
    f -= f.min()
    if rng.random() < 0.1:
        f = np.round(f)
    delta0 = rng.choice([0.0, 10 ** rng.uniform(-1, 1)], p=[0.15, 0.85])  # over the height
    height = 10 ** rng.uniform(-4, 4)
    depth = rng.normal() * max(1.0, delta0) * 0.7
    w = k * (height * delta0) ** 2 / 2
    return Lattice(spacing, 0.0, k, k * ell**2, w), height * (depth - f)


def rough_row(seed):
    """Some wavelengths of roughness, with strong adhesion and weak."""
    rng = np.random.default_rng(seed)
    n = 80
    k = 1.3
    ell = 10 ** rng.uniform(-0.5, 2)
    delta0 = 10 ** rng.uniform(-1, 0.5)
    longest = n * rng.uniform(0.3, 1)
    shortest = 10 ** rng.uniform(0.3, 1.5)
    f = roughness(n, longest, shortest, seed)
    lattice = Lattice(1.0, 0.0, k, k * ell**2, k * delta0**2 / 2)
    depth = rng.uniform(-0.2, 0.5) * f.max()
    return lattice, depth - f


def plateaus(seed):
    """Pulled surfaces under plateaus of different depth: tails and spans blocked by tips."""
    rng = np.random.default_rng(seed)
    lattice = Lattice(1.0, 0.0, 1.3, 1.3 * rng.uniform(2, 8) ** 2, 0.65)
    widths = rng.choice([1, 2, 3, 8, 12], size=9)
    depths = rng.uniform(0.02, 0.9, size=9) + 3.0 * (np.arange(9) % 2)
    return lattice, -np.repeat(depths, widths)


def crowded(seed):
    """Lattice and heights of a profile with teeth, near which adhesion is strong."""
    rng = np.random.default_rng(seed + 10**6)
    n = int(rng.integers(4, 40))
    ell = 10 ** rng.uniform(-0.5, 1.5)
    f = np.abs(rng.normal(size=n)) ** rng.choice([0.5, 1, 2])
    delta0 = 10 ** rng.uniform(-0.7, 0.7)
    depth = rng.uniform(-0.5, 1) * max(1, delta0)
    return Lattice(1.0, 0.0, 2.0, 2.0 * ell**2, delta0**2), depth - f


def enumerated(lattice, g):
    """All contact sets, and their energies; inf where the relaxed surface penetrates.

    Parameters
    ----------
    lattice : Lattice
    g : ndarray (n,)
        Displacements that the indenter prescribes.

    Returns
    -------
    sets : ndarray (2ⁿ, n)
        Whether a node is in contact.
    energies : ndarray (2ⁿ,)
        Each from one dense solve of the stationarity of `NodalEnergy`.
    """
    n = g.size
    nodes = np.arange(n)
    numbers = np.arange(2**n)[:, None]
    sets = (numbers >> nodes & 1).astype(bool)  # the binary digits of the number of a set
    diagonal, off_diagonal = NodalEnergy(lattice, sets[0]).hessian()
    hessian = np.diag(diagonal)
    hessian += np.diag(off_diagonal[:-1], 1)
    hessian += np.diag(off_diagonal[:-1], -1)
    matrix = np.where(sets[:, :, None], np.eye(n), hessian / lattice.spring_stiffness)
    right_hand_side = np.where(sets, g, 0.0)
    u = np.linalg.solve(matrix, right_hand_side[:, :, None])[:, :, 0]

    adhesion_of_links = []
    for first in range(n - 1):
        pair = NodalEnergy(lattice, (nodes == first) | (nodes == first + 1))
        adhesion_of_links.append(pair.balance(np.zeros(n)).terms["adhesion"])
    links_in_contact = sets[:, 1:] & sets[:, :-1]
    energy = np.einsum("si,ij,sj->s", u, hessian, u) / 2
    energy += links_in_contact @ np.array(adhesion_of_links)
    rounding = 1e-12 * np.abs(g).max()
    feasible = (u >= g - rounding).all(axis=1)
    return sets, np.where(feasible, energy, math.inf)


@dataclass(frozen=True, eq=False)
class Found:
    """The state of lowest energy that `global_minimum` finds."""

    lattice: Lattice
    g: np.ndarray
    contacts: np.ndarray
    proof: Proof

    @classmethod
    def of(cls, lattice, g):
        return cls(lattice, np.asarray(g), *global_minimum(lattice, g))

    @property
    def energy(self):
        return self.proof.attained

    @property
    def in_contact(self):
        return mask_of(self.g.size, self.contacts)

    def u(self):
        return displacement(self.lattice, self.g, self.in_contact)


def mask_of(n, contacts):
    """(n,) whether a node is in one of the contacts, first and last node of each."""
    held = np.zeros(n, bool)
    for first, last in contacts:
        held[first : last + 1] = True
    return held


def displacement(lattice, g, contact):
    """u (n,): g on the contact nodes, the surface they hold elsewhere."""
    held = np.flatnonzero(contact)
    return np.where(contact, g, surface(lattice, held, np.asarray(g)[held], np.arange(len(g))))


def lowest(lattice, g):
    """Energy, contact nodes and displacements of the best of all contact sets."""
    sets, energy = enumerated(lattice, g)
    held = sets[np.argmin(energy)]
    model = NodalEnergy(lattice, held)
    u = model.relaxed(g)
    return model.value(u), held, u


def unpruned(lattice, g):
    """The same minimum over all admissible pairs (i, j) in u itself: O(n²), nothing left out."""
    mu = lattice.log_decay
    t = lattice.link_stiffness
    n = g.size
    x = np.concatenate([[-60 / mu], np.arange(n), [n + 60 / mu]])
    y = np.concatenate([[0.0], g, [0.0]])
    least = np.concatenate([[0.0], np.full(n + 1, math.inf)])
    for j in range(1, n + 2):
        T = x[j] - x[:j]
        coupling = t * math.sinh(mu) / np.sinh(mu * T)
        drop = coupling / 2 * (y[j] - y[:j]) ** 2
        drop += t * math.sinh(mu) * np.tanh(mu * T / 2) / 2 * (y[j] ** 2 + y[:j] ** 2)
        drop[T == 1] -= lattice.w * lattice.spacing
        for i in range(j):
            at = x[i + 1 : j] - x[i]
            line = np.sinh(mu * (T[i] - at)) * y[i] + np.sinh(mu * at) * y[j]
            if (line >= y[i + 1 : j] * np.sinh(mu * T[i]) * (1 - 1e-13)).all():
                least[j] = min(least[j], least[i] + drop[i])
    return least[-1]


class Obstacle(NamedTuple):
    """u (n,) over an obstacle, the contact nodes, and forces on nodes >= 0, zero where free."""

    u: np.ndarray
    contact: np.ndarray
    multipliers: np.ndarray

    @property
    def energy(self):
        """U = Σ p_i u_i / 2: the work of the multipliers p."""
        return float(self.multipliers @ self.u) / 2

    @property
    def force(self):
        return float(self.multipliers.sum())


def obstacle(lattice, g):
    """Global minimum of the lattice energy for w = 0 with u_i >= g_i, -inf for no obstacle."""
    g = np.asarray(g, float)
    nodes = np.arange(g.size)
    u = np.maximum(g, 0.0)
    if not lattice.gamma1 or g.max() <= 0:
        return Obstacle(u, g > 0, lattice.spring_stiffness * u * lattice.weight(nodes))
    held, force = held_by(lattice, g)
    contact = np.zeros(g.size, bool)
    multipliers = np.zeros(g.size)
    contact[held] = True
    multipliers[held] = force
    free = np.flatnonzero(~contact)
    u[free] = np.maximum(surface(lattice, held, g[held], free), g[free])
    return Obstacle(u, contact, multipliers)
