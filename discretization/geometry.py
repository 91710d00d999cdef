"""Which geometries the minimisers and load paths know."""

from __future__ import annotations

from energy import Scene


def check_geometry(scene: Scene) -> None:
    """ValueError for rotational symmetry, which nothing here minimises yet."""
    if scene.axisymmetric:
        raise ValueError(
            f"geometry = {scene.geometry!r} is not implemented by the minimisers yet; use "
            "geometry='line', or the closed forms for rotational symmetry in energy.cards"
        )
