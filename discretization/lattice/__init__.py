"""Fixed nodes: the energy of a set of contact nodes is known, its minimum is searched over sets.

A state is a tuple of contacts, the first and last node of each; one contact is no special case.
Whoever finds them, assembly.py makes an equilibrium of them: the profile over the nodes
(ground.py), contacts on it (contact_set.py) -> totals (totals.py) -> certificate (judge.py), lines
between the nodes (line.py).

They are found by state.py, which asks one of
    fronts.py        the contact of a convex profile, by bracketing (bracket.py)
    springs.py       γ₁ = 0
    lowest.py        lowest energy of all contact sets, on a line and around an axis (obstacle.py
                     where w = 0; oracle.py)
    path_state.py    the end of a path from first touch on: heights and their running sums (row.py),
                     the depths at which something happens (rules.py, waiting.py), how free parts
                     and contacts change with the depth (ways.py, changes.py, stretch.py), and lines
                     between the nodes (between.py); load paths (../paths/lattice_branch.py) too

With finite slopes (finite_nodes.py) tails are known from a functional equation (tails.py), and
surfaces between two contacts are solved (finite_spans.py), so that depths of changes are roots
(finite_rules.py).

Around an axis (radial.py) nodes and links have weights, and what a free surface does depends on
where it is held: outside and inside (rings.py), between two contacts (radial_spans.py). The lattice
has a form of its own there; all else asks it what it asks of a line contact (shares.py).
"""

from discretization.lattice.finite_nodes import FiniteLattice
from discretization.lattice.nodes import Lattice
from discretization.lattice.radial import RadialLattice

__all__ = ["FiniteLattice", "Lattice", "RadialLattice"]  # `Lattice.of` chooses among them
