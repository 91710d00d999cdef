"""Free surfaces between two contacts of a line contact, tabulated by the number of their links.

What such a surface does to the nodes beside its lines depends on nothing but this number
(`Lattice.free_node_response`, `Lattice.surface_stiffnesses`), so that a walk along the nodes needs
no functions but roots.

A surface of T links is between two contact nodes T apart, and has T - 1 free nodes; these stand in
arrays from left to right. Its letters are those of nodes/lattice.py: a and b are the shares of the
left and the right end in the displacement of a free node, A and B those in that of the node beside
a line, A of this line and B of the other one, S the stiffness of that node. μ is
`Lattice.log_decay`: a tail decays by exp(-μ) per node.
"""

import functools
import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from discretization.nodes.lattice import Lattice
from energy.arrays import Array


class Tables(NamedTuple):
    """How much of free surfaces is tabulated.

    Halved or doubled, each leaves the 37 or more random states and paths that read it as they are
    to 1e-9: `python -m tests.sensitivity discretization.nodes.spans`.

    Attributes
    ----------
    independent : float
        Decay lengths after which the ends of a surface do not feel each other, exp(-45) of all.
    kept : int
        Links: shapes of surfaces up to this length are kept, some megabytes.
    """

    independent: float = 45.0
    kept: int = 512


_TABLES = Tables()


# Links: shapes of surfaces up to so long are read from the tables. Half or twice as many change no
# result (`python -m tests.sensitivity discretization.nodes.spans`).
LONGEST = 4096


@dataclass(frozen=True, eq=False)
class Spans:
    """Free surfaces between two contacts, by the number of their links, below `count`.

    Attributes
    ----------
    lattice : Lattice
        Of a line contact.
    most : int
        Links of the longest surface there is.
    count : int
        Length of the tables, whose entry T is that of surfaces of T links: T < count.
    far, remainder, stiffness : list of float
        B, 1 - A - B and S of the node beside a line, see `Lattice.free_node_response`; nan below 2
        links.
    tie, ground : list of float
        tB and t(1 - A - B); see `Lattice.surface_stiffnesses`. nan below 1 link.
    tail : tuple of float
        B, 1 - A - B and S outside.
    """

    lattice: Lattice
    most: int
    count: int
    far: list[float]
    remainder: list[float]
    stiffness: list[float]
    tie: list[float]
    ground: list[float]
    tail: tuple[float, float, float]

    @classmethod
    def of(cls, lattice: Lattice, most: int) -> "Spans":
        """The tables for surfaces of up to `most` links, or until their ends feel nothing."""
        count = max(int(min(most, _TABLES.independent / lattice.log_decay)), 2) + 1
        links = np.arange(count, dtype=float)
        far, remainder, stiffness = lattice.free_node_response(0, 1, links[2:])
        tie, ground = lattice.surface_stiffnesses(links[1:])
        tail_far, tail_remainder, tail_stiffness = lattice.free_node_response(0, 1)
        none = [math.nan]
        return cls(
            lattice,
            most,
            count,
            far=2 * none + far.tolist(),
            remainder=2 * none + remainder.tolist(),
            stiffness=2 * none + stiffness.tolist(),
            tie=none + tie.tolist(),
            ground=none + ground.tolist(),
            tail=(float(tail_far), float(tail_remainder), float(tail_stiffness)),
        )

    @functools.cached_property
    def decays(self) -> tuple[Array, Array]:
        """exp(-μp) and exp(-μp) - 1 at the nodes p = 1, 2, ... beside a contact: entry p - 1."""
        reach = max(self.count, min(self.most, LONGEST))
        exponents = -self.lattice.log_decay * np.arange(1, reach)
        return np.exp(exponents), np.expm1(exponents)

    def shares(self, links: int) -> tuple[Array, Array, Array]:
        """a, b and 1 - a - b of the free nodes, each (links - 1,), from left to right.

        links: of the surface, at most LONGEST.
        """
        return self._kept(links) if links <= _TABLES.kept else self._shares(links)

    @functools.lru_cache(maxsize=_TABLES.kept)  # noqa: B019
    def _kept(self, links: int) -> tuple[Array, Array, Array]:
        """`shares` of a short surface, kept as it is asked for again and again."""
        return self._shares(links)

    def _shares(self, links: int) -> tuple[Array, Array, Array]:
        """`shares` from the tables of decays, by the formula of `lattice.shares`.

        p and q = links - p are the distances of a node from both ends; b is a seen from the right.
        """
        decay, less = self.decays
        decay_p = decay[: links - 1]
        less_p = less[: links - 1]
        decay_q = decay_p[::-1]
        less_q = less_p[::-1]
        both = math.expm1(-2 * self.lattice.log_decay * links)
        a = decay_p * less_q * (2 + less_q) / both
        return a, a[::-1], less_p * less_q / (1 + decay_p * decay_q)
