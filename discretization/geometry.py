"""Which geometries the minimisers and load paths know."""

from __future__ import annotations

from energy import Scene

NODES = ("lattice", "shortest_path", "oracle")


def check_geometry(scene: Scene, method: str, *, path: bool = False) -> None:
    """ValueError for rotational symmetry where nodes do not know it; path: on a load path."""
    if not scene.axisymmetric or method not in NODES:
        return
    alone = scene.indenter.convex and scene.pattern is None and (path or scene.opening is None)
    steep = scene.slopes == "finite" and scene.gamma1 > 0
    if method != "lattice" or steep or not alone:
        raise ValueError(
            f"geometry = {scene.geometry!r}: on nodes there are single states of one contact of a "
            "convex profile with slopes = 'small' only, without opening or pattern, and no load "
            "paths; use method='fitted'"
        )
