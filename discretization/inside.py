"""The parts that states are made of, for studies of the method itself.

Everything else in the package may change without notice; these names are kept.

| name | what it is |
| --- | --- |
| `Ground` | the nodes that can be reached at a depth, and the heights of the profile there |
| `adhered`, `region`, `heights` | of one contact: its first and last node, where these may be, f |
| `ContactSet`, `totals` | contacts on nodes at a depth; their energy and force, with scales |
| `obstacle` | the convex problem without adhesion, w = 0, on a row of g = d - f |
| `global_minimum`, `window` | the lowest of all contact sets of a row, with proof; a scene's row |
| `Oracle` | the same by a solver of cvxpy |
| `on_lattice` | `minimise` on nodes, one of which is at a given place |
| `FittedMany` | contacts on the fitted mesh, followed from depth to depth |
| `integrals` | energy and force between two lines |
| `forget` | what has been solved of free surfaces is forgotten, as in a new process |
"""

from types import ModuleType

from discretization.fitted.quadrature import totals as integrals
from discretization.lattice.contact_set import ContactSet
from discretization.lattice.fronts import adhered, heights, region
from discretization.lattice.ground import Ground
from discretization.lattice.lowest import global_minimum, window
from discretization.lattice.obstacle import obstacle
from discretization.lattice.oracle import Oracle
from discretization.lattice.state import on_lattice
from discretization.lattice.totals import totals
from discretization.paths.fitted_many import FittedMany
from discretization.surfaces import mesh, response

__all__ = [
    "ContactSet",
    "FittedMany",
    "Ground",
    "Oracle",
    "adhered",
    "forget",
    "global_minimum",
    "heights",
    "integrals",
    "obstacle",
    "on_lattice",
    "region",
    "totals",
    "window",
]


def forget() -> None:
    """Forget the free surfaces that have been solved."""
    known: tuple[ModuleType, ...] = mesh, response
    for module in known:
        for value in vars(module).values():
            if hasattr(value, "cache_clear"):
                value.cache_clear()
