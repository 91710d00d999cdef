"""The discrete energies and their minimisers.

| symbol | name                       | unit        | shape |
| ------ | -------------------------- | ----------- | ----- |
| Δx     | spacing of the nodes       | length      |       |
| u_i    | displacement of node i     | length      | (n,)  |
| g_i    | d - f(x_i); u_i >= g_i     | length      | (n,)  |
| κ      | kΔx²/γ₁                    | 1           |       |
| λ      | decay of a tail per node   | 1           |       |
| t      | γ₁/Δx, stiffness of a link | force/length² |     |

minimise.py finds one state, many.py arrays of states of one contact, loading.py a path of states;
routes.py says which solver serves a scene, or why none does. Seven packages do the work, each
importing only those above it in this list:

nodes/      fixed nodes in a row: the lattice, its energy, what they see of the indenter
lattice/    contacts on these nodes: their states, certificates, the lowest of all
surfaces/   free surfaces on spectral meshes anchored at contact lines, which the lattice never sees
fitted/     contact lines as unknowns beside these surfaces
refine/     several contacts found on nodes, their lines refined by Newton's method
layer/      one contact of a layer with its exact response, on the mesh and on nodes
paths/      states followed in depth, load or the position of a machine

The certificate (certificate.py) and the result (equilibrium.py) are the same for all of them. A new
minimiser returns a contact set or contact lines; what judges those judges it unchanged.

`load_path` gives a `History` of states and of each `Event`, with a `Snapshot` before and after it
and the `PullOff`; `minimise` gives an `Equilibrium`, `minimise_many` `Equilibria`, which are
arrays. A `Lattice` is a row of nodes, `NodalEnergy` the energy of their displacements. A state that
fails its certificate raises NotCertifiedError, and an accuracy that is not reached is an
AccuracyWarning.
"""

from importlib.util import find_spec
from pathlib import Path

try:
    from discretization.certificate import AccuracyWarning, NotCertifiedError
    from discretization.equilibrium import Equilibrium
    from discretization.loading import load_path
    from discretization.many import Equilibria, minimise_many
    from discretization.minimise import minimise
    from discretization.nodes.lattice import Lattice
    from discretization.nodes.nodal_energy import NodalEnergy
    from discretization.paths.branch import Event, PullOff, Snapshot
    from discretization.paths.history import History
except ImportError as error:
    energy = find_spec("energy")
    if energy and energy.origin and Path(energy.origin).name != "__init__.py":
        raise ImportError(
            f"{energy.origin} hides the package energy of elastocap, since Python looks beside the "
            "script, or in the current folder, first: rename that file",
            name="energy",
        ) from error
    raise

__all__ = [
    "AccuracyWarning",
    "Equilibria",
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
    "minimise_many",
]
