"""Fixed nodes: the energy of a set of contact nodes is known, its minimum is searched over sets.

One contact: nodes (nodes.py, tails.py, nodal_energy.py) -> contact nodes (fronts.py, bracket.py)
-> sums (sums.py) -> certificate (judgement.py), lines between nodes (line.py) -> Equilibrium, by
state.py.

Lowest energy of any number of contacts: window -> contact set (obstacle.py where w = 0;
shortest_path.py with bounds.py, recursion.py, starts.py; oracle.py; springs.py where γ₁ = 0) ->
free spans (span.py), sums and certificate (contact_set.py) -> Equilibrium, by lowest.py.

Metastable, any number of contacts: heights and their running sums (row.py), the depths at which
something happens (rules.py, waiting.py), how free parts and contacts change with the depth
(ways.py, changes.py, stretch.py), and lines between the nodes (between.py); of these stand the
states of several contacts on the path from first touch on (path_state.py) and all load paths
(../paths/lattice_branch.py).

With finite slopes (finite_nodes.py) tails are known from a functional equation (tails.py), and
surfaces between two contacts are solved (finite_spans.py), so that depths of changes are roots
(finite_rules.py).

Around an axis (radial.py) nodes and links have weights, and what a free surface does depends on
where it is held: outside and inside (rings.py), between two contacts (radial_spans.py). The
lattice, the depths of changes (radial_rules.py) and the search for the lowest contacts
(radial_lowest.py) have forms of their own there; all else asks them what it asks of a line contact.
"""

from discretization.lattice.finite_nodes import FiniteLattice
from discretization.lattice.nodes import Lattice
from discretization.lattice.radial import RadialLattice

__all__ = ["FiniteLattice", "Lattice", "RadialLattice"]  # `Lattice.of` chooses among them
