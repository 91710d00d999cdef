"""A row of fixed nodes: the lattice, its energy, and what the nodes see of an indenter.

lattice.py        nodes Δx apart, springs and links, and what is exact there: free surfaces decay by
                  a constant factor per node, so that the far field takes no nodes
radial.py         the same about an axis, of one contact: nodes and links have weights, and what
                  the free surface does depends on where it is held
nodal_energy.py   U[u] as a function of the displacements of all nodes, with its gradient
row.py            the nodes under an indenter, their heights, running sums of what contacts take
rules.py          the depths at which something happens to contacts on a row
obstacle.py       the surface over heights that it must not be below, without adhesion

What is in contact at a depth is found and judged by ../lattice, which asks these.
"""

from discretization.nodes.lattice import Lattice
from discretization.nodes.radial import RadialLattice

__all__ = ["Lattice", "RadialLattice"]  # `Lattice.of` chooses among them
