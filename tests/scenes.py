"""Scenes that several tests share; random ones with closed forms are those of the studies."""

from __future__ import annotations

from energy import ElasticLayer, Scene, SurfaceEnergies
from studies.random_cases import SHAPES, Case, random_case

__all__ = ["SHAPES", "Case", "adhesive", "random_case"]


def adhesive(indenter, *, k=130.0, gamma1=0.07, w=0.002) -> Scene:
    """A scene in which no parameter is 1."""
    return Scene(ElasticLayer(k * 0.03, 0.0, 0.03), SurfaceEnergies.from_work(gamma1, w), indenter)
