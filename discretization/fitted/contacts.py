"""Any number of contacts on the fitted mesh: their energy and force.

In contact u = d - f is prescribed, so the free surfaces, two tails and the gaps between contacts,
do not feel each other, and energy and force are sums over the contacts and over them.
"""

from __future__ import annotations

import functools
import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from discretization.certificate import ROUNDING
from discretization.equilibrium import QUANTITIES, Equilibrium
from discretization.fitted.motion import Lines, Motion, free
from discretization.quadrature import Interval, refined
from discretization.surfaces.protocol import Free
from energy import Scene

Array = NDArray[np.float64]


@dataclass(frozen=True, eq=False)
class Contacts:
    """Contacts with these lines, from left to right, at a depth."""

    motion: Motion
    lines: Lines
    depth: float

    @property
    def x(self) -> Array:
        """Ends of each contact (m, 2)."""
        return np.array(self.lines).reshape(-1, 2)

    @property
    def pinned(self) -> NDArray[np.bool_]:
        """Lines at corners, at edges of the body, and beside those of a pattern (m, 2)."""
        profile = self.motion.profile
        edges = profile.edges, np.nextafter(profile.edges, -math.inf)
        held = np.concatenate([profile.corners, profile.indenter.walls, *edges])
        return np.isin(self.x, held)

    @functools.cached_property
    def free(self) -> list[Free]:
        """The free surfaces. ValueError if one would turn over."""
        rests = self.motion.rests
        ends = [(rests.at(q), rests.at(p)) for q, p in free(self.lines)]
        return [rests.surfaces.free(*pair, self.depth) for pair in ends]

    @functools.cached_property
    def rates(self) -> tuple[Array, NDArray[np.bool_], Array]:
        """Lines (n, 2) of the free surfaces, which of them are free, the changes of D (n, 2, 2)."""
        rests, lines = self.motion.rests, np.array(free(self.lines))
        held = np.concatenate([[True], self.pinned.ravel(), [True]]).reshape(-1, 2)
        _, rates = rests.rest_depths(lines[:, None], rests.rooms(lines, 1), 1, True)
        assert rates is not None
        return lines, np.isfinite(lines) & ~held, rates[:, 0]

    @property
    def pulls(self) -> Array:
        """What the free surfaces pull at both lines of each contact, S (m, 2)."""
        return np.array([pull for each in self.free for pull in each.pulls][1:-1]).reshape(-1, 2)


def totals(contacts: Contacts, rtol: float) -> Interval:
    """Energy and force."""
    pulls = contacts.pulls
    energy, area = sum(each.energy for each in contacts.free), sum(e.area for e in contacts.free)
    free = energy, float(pulls.sum()), area, float(np.abs(pulls).sum())
    return refined(contacts.motion.scene, contacts.depth, contacts.x, free)


def equilibrium(lines: Array, found: Interval, **given: Any) -> Equilibrium:
    """The state of contacts with these lines (m, 2), energy and force; given: the rest of it."""
    return Equilibrium(
        contacts=lines,
        nodes=lines,
        force=found.force,
        energy=found.energy,
        scales={"force": found.force_scale, "energy": found.energy_scale},
        method="fitted",
        spacing=math.nan,
        **given,
    )


def estimated(found: Interval, width: float, move: float, push: float) -> dict[str, float]:
    """Errors of half-width, force and energy: of the quadrature, the lines, and rounding.

    move: how far lines may be off, all together; push: what that adds to the force.
    """
    energy, force = found.errors
    parts = (
        move / width + ROUNDING if width else 0.0,
        (force + push) / (found.force_scale or 1.0) + 4 * ROUNDING,
        energy / (found.energy_scale or 1.0) + 4 * ROUNDING,
    )
    return dict(zip(QUANTITIES, map(float, parts), strict=True))


def push(scene: Scene, depth: float, x: Array) -> Array:
    """A bound of |dP/dq| of lines: k|g| + k l |f'|."""
    g, slope = depth - scene.indenter.height(x), scene.indenter.slope(x)
    felt = np.abs(g) + scene.elastocapillary_length * np.abs(slope)
    return np.asarray(scene.stiffness * felt * scene.measure(x))
