"""What the energy of a contact line asks of the lattice where the line is."""

from __future__ import annotations

from typing import Any, Protocol

from numpy.typing import NDArray

Array = NDArray[Any]


class Place(Protocol):
    """What contact lines at some nodes, all facing the same way, need to know of a lattice.

    loss: 1 - λ there.
    """

    @property
    def loss(self) -> Any: ...

    def gap(self, f: Any, f_next: Any, depth: Any) -> Any: ...

    def rest_depth(self, f: Any, f_next: Any, work: Any) -> Any: ...

    def stored(self, gap: Any) -> Any: ...

    def advance(self, f: Any, f_next: Any, depth: float) -> tuple[Any, Any, Any]: ...

    def tail_energy(self, u: Any) -> Any: ...

    def tail_reaction(self, u: Any) -> Any: ...

    def tail_force(self, u: Any) -> Any: ...

    def tail_stiffness(self, u: Any) -> Any: ...
