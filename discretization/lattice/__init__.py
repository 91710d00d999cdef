"""Fixed nodes: the energy of a set of contact nodes is known, its minimum is searched over sets.

A state is a tuple of contacts, the first and last node of each; one contact is no special case.
Whoever finds them, assembly.py makes an equilibrium of them: the nodes there are under an indenter
(ground.py, row.py) and contacts on these (contact_set.py) -> energy, force and certificate in one
pass over blocks of nodes (judge.py), lines between the nodes (line.py).

They are found by state.py, which asks one of
    plain.py         one contact with finite slopes, or γ₁ = 0, by Newton's method: read it first
    lowest.py        lowest energy of all contact sets, on a line and around an axis (obstacle.py
                     where w = 0; oracle.py)
    itself           one convex contact, whose lines are looked for among links further and further
                     apart (row.py)
    itself           the end of a path from first touch on: heights and their running sums (row.py),
                     the depths at which something happens (rules.py), the walk from one such change
                     to the next (walk.py), and lines between the nodes (between.py); load paths
                     (../paths/lattice_branch.py) too

Around an axis (radial.py) nodes and links have weights, and what a free surface does depends on
where it is held: outside, inside and between two contacts (radial_spans.py). The lattice has a form
of its own there; all else asks it what it asks of a line contact (nodes.py).
"""

from discretization.lattice.nodes import Lattice
from discretization.lattice.radial import RadialLattice

__all__ = ["Lattice", "RadialLattice"]  # `Lattice.of` chooses among them
