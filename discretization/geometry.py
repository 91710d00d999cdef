"""Which geometries the minimisers and load paths know."""

from __future__ import annotations

from energy import Scene


def check_geometry(scene: Scene, nodes: bool) -> None:
    """ValueError for rotational symmetry where nothing minimises it; nodes: on the lattice."""
    if scene.axisymmetric and nodes:
        raise ValueError(
            f"geometry = {scene.geometry!r} is not implemented on the lattice yet; use "
            "method='fitted', or geometry='line'"
        )
