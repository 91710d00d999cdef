"""Which geometries the minimisers and load paths know."""

from __future__ import annotations

from energy import Circle, FlatPunch, Parabola, PowerLaw, Scene, Wedge

# turned about an axis, of these the line has one stable place (fitted/lines.py)
UNIMODAL = (Parabola, Wedge, PowerLaw, FlatPunch, Circle)

NODES = ("lattice", "shortest_path", "oracle")


def check_geometry(scene: Scene, method: str, branch: str = "adhered") -> None:
    """ValueError for rotational symmetry where nodes do not know it."""
    if not scene.axisymmetric or method not in NODES:
        return
    alone = scene.indenter.convex and scene.pattern is None
    steep = scene.slopes == "finite" and scene.gamma1 > 0
    several = not alone and (branch == "global" or not scene.gamma1)
    if method != "lattice" or steep or several:
        raise ValueError(
            f"geometry = {scene.geometry!r}: on nodes there are states and load paths with slopes "
            "= 'small' only, and of several contacts those with gamma1 > 0 that touch first and "
            "then move there, branch = 'adhered', by method = 'lattice'; use method='fitted'"
        )


def one_contact(scene: Scene) -> bool:
    """Whether at any depth there is at most one stable contact, with one line on each side."""
    return scene.indenter.convex and (
        not scene.axisymmetric or isinstance(scene.indenter, UNIMODAL)
    )
