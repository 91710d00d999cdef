"""Free surfaces beside contact lines, on spectral meshes anchored at the lines.

They answer the questions of protocol.py: at which depth a line rests beside them, what they store
and pull, their shape. One module answers for each geometry and energy:

    small slopes   line, axisymmetric  small.py on network.py, rings.py and response.py
    finite         line                finite_surfaces.py on finite_range.py, finite_gap.py
                   axisymmetric        meniscus_surfaces.py on menisci.py

They are solved on spectral elements (spectral.py, mesh.py) and read as polynomials
(polynomials.py).
"""

from __future__ import annotations

from collections.abc import Callable

from discretization.surfaces.finite_surfaces import FiniteSurfaces
from discretization.surfaces.meniscus_surfaces import MeniscusSurfaces
from discretization.surfaces.protocol import Surfaces
from discretization.surfaces.response import Response, chosen, finer
from discretization.surfaces.small import SmallSurfaces
from energy import Scene

_EXACT = 1e-15  # of surfaces about an axis: there is one family of them, read from a table
_KINDS: dict[tuple[str, str], Callable[[Scene, Response], Surfaces]] = {
    ("line", "small"): SmallSurfaces,
    ("line", "finite"): FiniteSurfaces,
    ("axisymmetric", "small"): SmallSurfaces,
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
