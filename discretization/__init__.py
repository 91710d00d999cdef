"""The discrete energies and their minimisers.

| symbol | name                       | unit        | shape |
| ------ | -------------------------- | ----------- | ----- |
| Δx     | spacing of the nodes       | length      |       |
| u_i    | displacement of node i     | length      | (n,)  |
| g_i    | d - f(x_i); u_i >= g_i     | length      | (n,)  |
| κ      | kΔx²/γ₁                    | 1           |       |
| λ      | decay of a tail per node   | 1           |       |
| t      | γ₁/Δx, stiffness of a link | force/length² |     |

On the lattice: Scene -> Lattice (lattice.py, tails.py) -> contact set (fronts.py) -> sums and
certificate (certificate.py) -> line between nodes (line.py) -> Equilibrium, by lattice_state.py.
Several contacts, lowest energy: window -> contact set (obstacle.py; shortest_path.py with
bounds.py, recursion.py, starts.py; oracle.py; springs.py for γ₁ = 0) ->
free spans (span.py), sums and certificate (contact_set.py) -> lines -> Equilibrium, by lowest.py.
Fitted: free surface (spectral.py, free_surface.py) -> what a line feels of it (response.py) ->
contact lines (fitted.py) -> integrals (quadrature.py) -> certificate and error estimate ->
Equilibrium, by fitted_state.py. minimise.py picks; equilibrium.py is the result.
Several contacts, fitted: contact nodes of the lattice (lowest.py, path_state.py), without small
gaps (bubbles.py) -> surfaces between (gap.py) -> lines (gap_lines.py, fitted_contacts.py) ->
certificate and error estimate (fitted_judgement.py) -> Equilibrium, by fitted_several.py.
Load paths: states followed in depth (branch.py; fitted_branch.py, lattice_branch.py with
lattice_side.py, many_contacts.py with changes.py and rules.py; fitted_many.py with the depths at
which lines rest, line_levels.py and stops.py, fitted_moves.py, gap_moves.py, clearance.py) ->
equilibrium with a load or machine (control.py) -> events (path.py, events.py) -> History
(loading.py, history.py) -> its ledger (ledger.py).
A new minimiser returns a contact set or contact lines; the certificate judges it unchanged.

What a scene does not need is not done; `python -m studies skipping` measures what that saves and
that no digit changes:

| not needed           | skipped                             | by                                |
| -------------------- | ----------------------------------- | --------------------------------- |
| surface tension      | free surfaces, their solves         | fitted_state.on_fitted_mesh       |
| adhesion             | search over contact sets            | lowest.lowest_contacts            |
| second side, fitted  | line of a symmetric profile         | fitted_state._lines               |
| second side, lattice | half of a symmetric contact's sums  | certificate.measured              |
| line of a punch      | bracketing of a line at an edge     | fitted.find_line                  |
| contact              | everything but the touching point   | fronts.adhered                    |
| far field            | nodes beyond the contact            | lattice.Lattice.tail_energy       |
| other contacts       | topology of a convex profile        | fitted_state.on_fitted_mesh       |
| links in between     | a convex profile's heights          | bracket.first_positive            |
| true lengths         | nonlinear solves                    | response.Response.surface         |
| known surfaces       | solves of one seen before           | response.response                 |
| energy               | all but the force of a load step    | fitted_branch.FittedBranch.force  |
| fields               | u(x), p(x) until asked for          | equilibrium.Equilibrium           |
| error estimate       | coarser lattice until asked for     | lattice_state.estimated           |
| search for the line  | bracketing, from the last load step | fitted_branch.FittedBranch.follow |
| cvxpy, matplotlib    | their imports                       | oracle.Oracle                     |
"""

from discretization.certificate import NotCertifiedError
from discretization.equilibrium import Equilibrium
from discretization.events import Event, PullOff
from discretization.history import History
from discretization.lattice import Lattice
from discretization.lattice_state import on_lattice
from discretization.loading import load_path
from discretization.minimise import AccuracyWarning, minimise
from discretization.nodal_energy import NodalEnergy

__all__ = [
    "AccuracyWarning",
    "Equilibrium",
    "Event",
    "History",
    "Lattice",
    "NodalEnergy",
    "NotCertifiedError",
    "PullOff",
    "load_path",
    "minimise",
    "on_lattice",
]
