"""The verdict on a state, whatever minimiser proposed it: how far is it from an equilibrium?

    penetration   of the free surface through the indenter
    stationarity  forces left on the free surface
    opening       pull on what is in contact, beyond what its adhesion holds
    neighbours    energy gained by moving a contact line
    force         dU/dd against k∫u dx over the whole line

Each is a dimensionless violation, judged against the state itself and not by how it was found: on
nodes by lattice/judgement.py (one contact), lattice/contact_set.py (any number) and
lattice/springs.py (γ₁ = 0), on the fitted mesh by fitted/state.py (one) and fitted/judgement.py.
"""

from __future__ import annotations

from typing import NamedTuple

TOLERANCE = 1e-9


class NotCertifiedError(RuntimeError):
    """The minimiser's state failed its certificate; nothing is returned in its place."""


class Certificate(NamedTuple):
    """Violations of the equilibrium conditions (dimensionless, 0 is perfect) and their verdict."""

    penetration: float
    stationarity: float
    opening: float
    neighbours: float
    force: float
    tolerance: float = TOLERANCE

    @classmethod
    def undeformed(cls, penetration: float = 0.0) -> Certificate:
        """Of a surface on which no force acts: it can only be in the indenter's way."""
        return cls(penetration, 0.0, 0.0, 0.0, 0.0)

    @property
    def ok(self) -> bool:
        """True if no violation exceeds the tolerance."""
        return not self.failures

    @property
    def failures(self) -> tuple[str, ...]:
        """Names of the violated conditions."""
        *violations, tolerance = self
        named = zip(self._fields, violations, strict=False)
        return tuple(name for name, violation in named if not violation <= tolerance)
