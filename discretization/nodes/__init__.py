"""A row of fixed nodes: the lattice, its energy, and what the nodes see of an indenter.

Springs, links and free surfaces (lattice.py, radial.py about an axis), U[u] of all nodes
(nodal_energy.py), the nodes under an indenter and what contacts take of them (row.py), the depths
at which something happens to contacts (rules.py), and the surface without adhesion (obstacle.py).
What is in contact at a depth is found and judged by ../lattice, which asks these.
"""

from discretization.nodes.lattice import Lattice, RadialLattice

__all__ = ["Lattice", "RadialLattice"]  # `Lattice.of` chooses one of them
