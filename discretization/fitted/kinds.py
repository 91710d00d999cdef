"""Which free surfaces a scene has: one row for each geometry and energy."""

from __future__ import annotations

from collections.abc import Callable

from discretization.fitted.axisymmetric_surfaces import AxisymmetricSurfaces
from discretization.fitted.finite_surfaces import FiniteSurfaces
from discretization.fitted.meniscus_surfaces import MeniscusSurfaces
from discretization.fitted.response import Response, chosen, finer
from discretization.fitted.small_surfaces import SmallSurfaces
from discretization.fitted.surfaces import Surfaces
from energy import Scene

_EXACT = 1e-15  # of surfaces about an axis: there is one family of them, read from a table
_KINDS: dict[tuple[str, str], Callable[[Scene, Response], Surfaces]] = {
    ("line", "small"): SmallSurfaces,
    ("line", "finite"): FiniteSurfaces,
    ("axisymmetric", "small"): AxisymmetricSurfaces,
    ("axisymmetric", "finite"): MeniscusSurfaces,
}


def surfaces_of(scene: Scene, rtol: float) -> Surfaces:
    """The free surfaces of a scene on the least elements that meet rtol."""
    response = chosen(scene.slopes, _EXACT if scene.axisymmetric else rtol)
    return _KINDS[scene.geometry, scene.slopes](scene, response)


def finer_surfaces(surfaces: Surfaces) -> Surfaces | None:
    """The same surfaces on elements of the next degree; None if there is none."""
    better = finer(surfaces.response)
    if better is None:
        return None
    return _KINDS[surfaces.scene.geometry, surfaces.scene.slopes](surfaces.scene, better)
