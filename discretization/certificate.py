"""The verdict on a state, whatever minimiser proposed it: how far is it from an equilibrium?

    penetration   of the free surface through the indenter
    stationarity  forces left on the free surface
    opening       pull on what is in contact, beyond what its adhesion holds
    neighbours    energy gained by moving a contact line
    force         dU/dd against k∫u dx over the whole line

Each is a dimensionless violation, judged against the state itself and not by how it was found: on
nodes by lattice/certificate.py, on the fitted mesh by fitted/contacts.py, of a layer with its exact
response by layer/state.py and layer/nodes.py, which say what each is relative to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

EPSILON = 2.0**-52  # what double precision leaves of a number
ROUNDING = 16 * EPSILON  # of the sizes of the terms that a result is summed from, a dozen or so
DECAYED = 40.0  # decay lengths after which a tail is less than rounding, e⁻⁴⁰ = 4e-18
TOLERANCE = 1e-9  # of the scales of the terms: far above rounding, below the default rtol, 1e-8


class NotCertifiedError(RuntimeError):
    """The minimiser's state failed its certificate; nothing is returned in its place."""


class AccuracyWarning(UserWarning):
    """The requested rtol was not reached, or a profile is not resolved; the message says more."""


class Certificate(NamedTuple):
    """Violations of the equilibrium conditions, and the verdict.

    Attributes
    ----------
    penetration, stationarity, opening, neighbours, force : float
        By how much each condition of the module is violated, dimensionless; 0 is perfect, nan
        fails.
    tolerance : float
        The largest violation that passes.
    """

    penetration: float
    stationarity: float
    opening: float
    neighbours: float
    force: float
    tolerance: float = TOLERANCE

    @classmethod
    def undeformed(cls, penetration: float = 0.0) -> Certificate:
        """The certificate of a surface on which no force acts: only penetration is possible.

        Parameters
        ----------
        penetration : float
            Its violation, dimensionless.

        Returns
        -------
        Certificate
        """
        return cls(penetration, 0.0, 0.0, 0.0, 0.0)

    @property
    def ok(self) -> bool:
        """True if no violation exceeds the tolerance."""
        return not self.failures

    def demand(self, state: str, remedy: str) -> None:
        """Raise NotCertifiedError if a condition is violated.

        Parameters
        ----------
        state : str
            What the message calls the state.
        remedy : str
            What it says to try.

        Raises
        ------
        NotCertifiedError
        """
        if self.failures:
            raise NotCertifiedError(
                f"{state} violates {', '.join(self.failures)} ({self}); {remedy}"
            )

    @property
    def failures(self) -> tuple[str, ...]:
        """Names of the violated conditions."""
        named = zip(self._fields, self[:-1], strict=False)  # the last field is the tolerance
        return tuple(name for name, violation in named if not violation <= self.tolerance)


def worst(*violations: float) -> float:
    """The largest of these violations, or 0 if none is positive; nan if one is not a number.

    `max(0.0, nan)` is 0: a condition whose violation is unknown would pass.
    """
    if any(map(math.isnan, violations)):
        return math.nan
    return max((0.0, *violations))


@dataclass(frozen=True)
class Proof:
    """Why no state on the nodes has a lower energy.

    Attributes
    ----------
    bound : float
        Least energy of all contact sets, from the recursion of lattice/lowest.py [energy/length].
    attained : float
        `NodalEnergy`, the energy of all nodes, of the displacements that are returned
        [energy/length].
    scale : float
        Sum of the absolute values of its terms [energy/length].
    """

    bound: float
    attained: float
    scale: float

    @property
    def violation(self) -> float:
        """|attained - bound|/scale: rounding, if the minimum is proven."""
        return abs(self.attained - self.bound) / (self.scale or 1.0)
