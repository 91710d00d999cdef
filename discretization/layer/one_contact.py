"""What states of one contact of a layer have in common, on the mesh (state.py) and on nodes.

Displacements u and depths are positive downwards. The contact is mirror-symmetric or lies around an
axis; its half-width a and places on the free surface are distances. `Body.ends(a)` are the
positions of both ends of a contact, the first that of the axis if there is one; `Body.power` is 1
about an axis, which no line can pass, so that the first end counts as pinned. The members that an
`Equilibrium` takes for its `surfaces` are those of `OneContact` and `FreeSurface.shape`.

A `LinePosition` has the position x of a line and the height f of the profile there; `only_line` is
that one of the left and the right line of a surface that is not None. A `Certificate` has by how
much a state violates each condition of equilibrium, over sizes of the terms, and `tolerance`, up to
which it passes; `penetration` is how far the surface is inside the indenter, `undeformed()` the
certificate of a surface without forces, and `demand` raises where a condition fails. `detached` is
the `Equilibrium` without contact, whose flat surface is given as `SmallSurfaces`.
"""

import math
from abc import ABC, abstractmethod
from collections.abc import Callable
from typing import Any, Protocol

import numpy as np

from discretization.certificate import Certificate, NotCertifiedError
from discretization.equilibrium import Equilibrium, detached
from discretization.layer.body import Body
from discretization.surfaces.protocol import LinePosition, only_line
from discretization.surfaces.small import SmallSurfaces
from energy import Scene
from energy.arrays import Array


class FreeSurface(ABC):
    """A free surface known by its displacement at distances from the line, the same on both sides.

    As `surfaces` of an `Equilibrium` it has the method `shape` of `surfaces.protocol.Surfaces`.
    """

    @abstractmethod
    def displaced(self, distance: Array) -> Array:
        """u [length] and its slope by the distance (2, k), at distances from the line (k,)."""

    def shape(
        self, z: Array, left: LinePosition | None, right: LinePosition | None, depth: float
    ) -> tuple[Array, Array]:
        """The displacement and its slope on one side of the contact.

        Parameters
        ----------
        z : ndarray (k,)
            Positions [length].
        left, right : LinePosition or None
            The contact line; it is on the left of the surface, or on its right.
        depth : float
            That of the state.

        Returns
        -------
        u, slope : ndarray (k,)
            [length] and du/dz.
        """
        side = 1 if left is not None else -1
        u, slope = self.displaced(side * (z - only_line(left, right).x))
        return u, side * slope


class OneContact(Protocol):
    """A state of one contact, as `certified` reads it; it knows its free surface, too."""

    @property
    def body(self) -> Body:
        """The profile."""

    @property
    def a(self) -> float:
        """Half-width or radius [length]."""

    @property
    def outermost(self) -> float:
        """Distance of the outermost node in contact [length]."""

    @property
    def pinned(self) -> bool:
        """Whether the line is at a corner or the edge of a body."""

    @property
    def force(self) -> float:
        """P [force], positive if the indenter is pressed; per length of a line contact."""

    @property
    def energy(self) -> float:
        """U [energy], less the work of adhesion; per length of a line contact."""

    @property
    def scales(self) -> dict[str, float]:
        """Sums of the sizes of the terms of "force" and "energy", by these names."""

    @property
    def certificate(self) -> Certificate:
        """How far the conditions of certificate.py are violated."""

    @property
    def errors(self) -> Callable[[Any], dict[str, float]]:
        """A function of the Equilibrium: relative errors of "half_width", "force" and "energy"."""


def certified(
    scene: Scene, depth: float, found: OneContact | None, branch: str, spacing: float = math.nan
) -> Equilibrium:
    """The equilibrium with the contact that was found.

    Parameters
    ----------
    scene : Scene
    depth : float
        [length].
    found : OneContact or None
        None if the contact is lost.
    branch : str
        For the record.
    spacing : float
        Of the nodes [length]; nan on the mesh.

    Returns
    -------
    Equilibrium

    Raises
    ------
    NotCertifiedError
        If it violates a condition of its certificate.
    """
    if found is None:  # no force acts on the surface
        flat = Certificate.undeformed()
        return detached(scene, depth, branch, SmallSurfaces(scene), flat, spacing)
    body = found.body
    named = f"the state at depth = {depth!r}"
    if not found.certificate.penetration <= found.certificate.tolerance:
        raise NotCertifiedError(
            f"{named} touches the indenter again beside its contact: a layer that is nearly "
            "incompressible rises there; use another depth, or response='springs'"
        )
    found.certificate.demand(named, "try another depth or spacing")
    return Equilibrium(
        scene,
        depth,
        branch,
        method="fitted" if math.isnan(spacing) else "lattice",
        certificate=found.certificate,
        surfaces=found,
        spacing=spacing,
        contacts=np.array([body.ends(found.a)]),
        nodes=np.array([body.ends(found.outermost)]),
        pinned=np.array([[found.pinned or bool(body.power), found.pinned]]),
        force=found.force,
        energy=found.energy,
        scales=found.scales,
        errors=found.errors,
    )
