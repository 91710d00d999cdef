"""Where a check solves: on a lattice of chosen spacing and shift, or on the fitted mesh."""

import warnings
from abc import ABC, abstractmethod
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from discretization import AccuracyWarning, Equilibrium, minimise
from discretization.inside import on_lattice
from energy import Scene
from studies.shared.types import Array


class Mesh(ABC):
    """A discretisation, as the measure of a check sees it.

    cells: links per reference length; a limit that is taken in the scene itself divides by it.
    """

    cells: float

    @abstractmethod
    def solve(
        self, scene: Scene, depth: float, *, length: float | None = None, branch: str = "adhered"
    ) -> Equilibrium:
        """Equilibrium; a lattice has length/cells between nodes, `length` is l unless given."""

    def sweep(self, scene: Scene, depths: ArrayLike, name: str, **options: Any) -> Array:
        """The attribute `name` of the equilibria at the depths, (n,)."""
        depths = np.atleast_1d(np.asarray(depths, float))
        return np.array([getattr(self.solve(scene, d, **options), name) for d in depths])


@dataclass(frozen=True)
class Grid(Mesh):
    """A lattice: links per reference length, and its sideways shift in links."""

    cells: float
    offset: float = 0.0

    def solve(
        self, scene: Scene, depth: float, *, length: float | None = None, branch: str = "adhered"
    ) -> Equilibrium:
        """Equilibrium on the lattice; its tip or centre is `offset` links beside a node.

        A node stands on an axis of rotation; there the spacing shrinks a little instead.
        """
        turned, origin = scene.axisymmetric, None
        links = self.cells + self.offset if turned else self.cells
        spacing = (length or scene.elastocapillary_length) / links
        if self.offset and not turned:
            origin = (scene.indenter.apex or 0.0) + self.offset * spacing
        return on_lattice(scene, float(depth), spacing, branch=branch, origin=origin)


@dataclass(frozen=True)
class Fitted(Mesh):
    """The default of `minimise`: a mesh anchored at the contact lines, without a spacing.

    It has nothing to refine, so `cells` is large: a scene's own limit is taken at once.
    """

    cells: float = 1e12

    def solve(
        self, scene: Scene, depth: float, *, length: float | None = None, branch: str = "adhered"
    ) -> Equilibrium:
        """Equilibrium; `length` has no meaning. The check judges the error: no AccuracyWarning."""
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", AccuracyWarning)
            return minimise(scene, float(depth), branch=branch)
