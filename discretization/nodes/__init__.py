"""A row of fixed nodes: the lattice, its energy, and the nodes under an indenter.

Springs, links and free surfaces (lattice.py, radial.py about an axis), U[u] of all nodes
(nodal_energy.py), the nodes under an indenter and the energy of contacts on them (row.py), the
depths at which contacts change (thresholds.py), and the surface without adhesion (obstacle.py).
What is in contact at a depth is found and judged by the package `lattice`, which uses these.
"""

from discretization.nodes.lattice import Lattice, RadialLattice

__all__ = ["Lattice", "RadialLattice"]  # `Lattice.of` chooses one of them
