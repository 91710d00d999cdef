"""Where a check solves: on a lattice of chosen spacing and shift, or on the fitted mesh.

Conventions:

- `load_path(scene, depths=...)`, or forces, or drives with a machine_stiffness, follows the states
  at these values one after the other: a `History` with arrays `depth`, `force` (positive where it
  presses), `half_width`.
- A scene has `elastocapillary_length` l = √(γ₁/k).
- `Plane()` is f = 0 without end.
- `Lattice.of(scene, spacing, origin)` has a node at the origin, and `Row` what its nodes know of
  the profile up to a depth.
- `apex` is the x of the lowest point, None without one.
"""

import functools
import math
import warnings
from abc import ABC, abstractmethod
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from discretization import AccuracyWarning, Equilibrium, History, Lattice, load_path, minimise
from discretization.lattice.state import on_lattice as on_nodes
from discretization.nodes.row import Row
from energy import Plane, Scene
from energy.arrays import Array

_STEP = 1.25e-6  # m, between the depths up to which nodes are kept: most are above the first


class Mesh(ABC):
    """A discretisation, as the measure of a check sees it.

    Attributes
    ----------
    cells : float
        Links per reference length; a limit that is taken in the scene itself divides by it.
    short : float
        How far short of detachment, relatively, a state just before it is taken.
    """

    cells: float
    short: float

    @abstractmethod
    def solve(
        self, scene: Scene, depth: float, *, length: float | None = None, branch: str = "adhered"
    ) -> Equilibrium:
        """Equilibrium at a depth.

        Parameters
        ----------
        scene : Scene
        depth : float
        length : float, optional
            A lattice has length/cells between nodes; None: l.
        branch : {"adhered", "global"}

        Returns
        -------
        Equilibrium
        """

    @abstractmethod
    def path(self, scene: Scene, depths: ArrayLike) -> History:
        """The load path through some depths.

        Parameters
        ----------
        scene : Scene
        depths : array_like

        Returns
        -------
        History
        """

    def sweep(self, scene: Scene, depths: ArrayLike, name: str, **options: Any) -> Array:
        """An attribute of the equilibria at some depths.

        Parameters
        ----------
        scene : Scene
        depths : array_like (n,)
        name : str
            The attribute of `Equilibrium`.
        options : optional
            Of `solve`.

        Returns
        -------
        ndarray (n,)
        """
        depths = np.atleast_1d(np.asarray(depths, float))
        return np.array([getattr(self.solve(scene, d, **options), name) for d in depths])


@functools.lru_cache(maxsize=512)
def _solved(solve: Callable[..., Equilibrium], scene: Scene, *where: Any) -> Equilibrium:
    """A state on nodes, solved once for all checks that look at it one after the other."""
    depth, spacing, branch, origin = where
    return solve(scene, depth, spacing, branch=branch, origin=origin)


@functools.lru_cache(maxsize=512)
def _found(
    solve: Callable[..., Equilibrium], scene: Scene, depth: float, **options: Any
) -> Equilibrium:
    """A state of `minimise`, likewise. The check judges the error: no AccuracyWarning."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", AccuracyWarning)
        return solve(scene, depth, **options)


@functools.lru_cache(maxsize=64)
def _row(scene: Scene, lattice: Lattice, depth: float) -> Row:
    """Nodes that are kept for all depths up to this one."""
    return Row.of(lattice.scene_on_nodes(scene), lattice, depth)


def on_lattice(
    scene: Scene, depth: float, spacing: float, *, branch: str, origin: float | None
) -> Equilibrium:
    """The state of `discretization.lattice.state.on_lattice`, on nodes kept for other depths.

    Parameters
    ----------
    scene : Scene
    depth, spacing : float
    branch : str
    origin : float or None

    Returns
    -------
    Equilibrium
    """
    row = None
    most = _STEP * max(1, math.ceil(depth / _STEP))
    if not isinstance(scene.indenter, Plane):
        row = _row(scene, Lattice.of(scene, spacing, origin), most)
    return on_nodes(scene, depth, spacing, branch=branch, origin=origin, row=row)


@dataclass(frozen=True)
class Grid(Mesh):
    """A lattice.

    Attributes
    ----------
    cells : float
        Links per reference length.
    offset : float
        Sideways shift in links.
    short : float
        How far short of detachment, relatively, a state just before it is taken.
    """

    cells: float
    offset: float = 0.0
    short: float = 1e-8

    def solve(
        self, scene: Scene, depth: float, *, length: float | None = None, branch: str = "adhered"
    ) -> Equilibrium:
        """Equilibrium on the lattice; its tip or centre is `offset` links beside a node.

        A node stands on an axis of rotation, and at the tip on a layer with its exact response;
        there the spacing shrinks a little instead.
        """
        spacing = self._spacing(scene, length)
        origin = None
        if scene.layer.exact:
            options = {"branch": branch, "method": "lattice", "spacing": spacing}
            return _found(minimise, scene, float(depth), **options)
        if self.offset and not scene.axisymmetric:
            origin = (scene.indenter.apex or 0.0) + self.offset * spacing
        return _solved(on_lattice, scene, float(depth), spacing, branch, origin)

    def path(self, scene: Scene, depths: ArrayLike) -> History:
        """The load path. ValueError for a shifted line contact: a path has a node at the tip."""
        if self.offset and not scene.axisymmetric:
            raise ValueError(f"offset = {self.offset!r} must be 0 for a path along a line")
        return load_path(scene, depths=depths, method="lattice", spacing=self._spacing(scene))

    def _spacing(self, scene: Scene, length: float | None = None) -> float:
        """Δx, of which `cells` are in a length, l if none is given.

        Nodes about an axis, and of a layer, cannot be shifted: they are a little closer instead.
        """
        fixed = scene.axisymmetric or scene.layer.exact
        links = self.cells + self.offset if fixed else self.cells
        return (length or scene.elastocapillary_length) / links


@dataclass(frozen=True)
class Fitted(Mesh):
    """The default of `minimise`: a mesh anchored at the contact lines, without a spacing.

    It has nothing to refine, so `cells` is large: a scene's own limit is taken at once.
    """

    cells: float = 1e12
    short: float = 1e-10

    def solve(
        self, scene: Scene, depth: float, *, length: float | None = None, branch: str = "adhered"
    ) -> Equilibrium:
        """Equilibrium; `length` has no meaning."""
        return _found(minimise, scene, float(depth), branch=branch)

    def path(self, scene: Scene, depths: ArrayLike) -> History:
        """The load path."""
        return load_path(scene, depths=depths)
