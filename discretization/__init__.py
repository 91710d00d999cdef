"""The discrete energies and their minimisers.

| symbol | name                       | unit        | shape |
| ------ | -------------------------- | ----------- | ----- |
| Δx     | spacing of the nodes       | length      |       |
| u_i    | displacement of node i     | length      | (n,)  |
| g_i    | d - f(x_i); u_i >= g_i     | length      | (n,)  |
| κ      | kΔx²/γ₁                    | 1           |       |
| λ      | decay of a tail per node   | 1           |       |
| t      | γ₁/Δx, stiffness of a link | force/length² |     |

minimise.py answers with one state, loading.py with a path of states; routes.py says what does, or
why nothing does. Six packages do the work, each importing only those above it in this list:

nodes/      fixed nodes in a row: the lattice, its energy, what they see of the indenter
lattice/    contacts on these nodes: their states, certificates, the lowest of all
surfaces/   free surfaces on spectral meshes anchored at contact lines, which the lattice never sees
fitted/     contact lines as unknowns beside these surfaces
following/  these lines on their way from one depth to another
paths/      states followed in depth, load or the position of a machine

The certificate (certificate.py) and the result (equilibrium.py) are the same for all of them. A new
minimiser returns a contact set or contact lines; what judges those judges it unchanged.

What a scene does not need is not done; `python -m studies skipping` measures what most of that
saves and that no digit changes:

| not needed           | skipped                         | by                                      |
| -------------------- | ------------------------------- | --------------------------------------- |
| surface tension      | free surfaces, their solves     | fitted.springs.on_springs               |
| adhesion             | search over contact sets        | lattice.lowest.lowest_contacts          |
| second side, fitted  | line of a symmetric profile     | fitted.state._lines                     |
| second side, lattice | half of the sums, if symmetric  | lattice.contact_set.ContactSet          |
| line of a punch      | bracketing of a line at an edge | fitted.lines.find_line                  |
| far field            | nodes beyond the contact        | nodes.lattice.Lattice                   |
| other contacts       | resolving a convex profile      | fitted.state.on_one_contact             |
| nodes far out        | heights a convex profile has    | nodes.row.Row                           |
| true lengths         | nonlinear solves                | surfaces.finite_gap.solved              |
| known surfaces       | solves of one seen before       | surfaces.rings.stiffness                |
| fields               | u(x), p(x) until asked for      | equilibrium.Equilibrium                 |
| error estimate       | coarser lattice until asked for | lattice.accuracy.estimated              |
| search for the line  | states of their own of steps    | following.track.Track.lines             |
| cvxpy, matplotlib    | their imports                   | lattice.oracle.Oracle                   |
"""

from discretization.certificate import AccuracyWarning, NotCertifiedError
from discretization.equilibrium import Equilibrium
from discretization.loading import load_path
from discretization.minimise import minimise
from discretization.nodes.lattice import Lattice
from discretization.nodes.nodal_energy import NodalEnergy
from discretization.paths.events import Event, PullOff, Snapshot
from discretization.paths.history import History

__all__ = [
    "AccuracyWarning",
    "Equilibrium",
    "Event",
    "History",
    "Lattice",
    "NodalEnergy",
    "NotCertifiedError",
    "PullOff",
    "Snapshot",
    "load_path",
    "minimise",
]
