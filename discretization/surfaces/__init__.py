"""Free surfaces beside contact lines, on spectral meshes anchored at the lines.

They answer the questions of protocol.py: at which depth a line rests beside them, what they store
and pull, their shape. One class answers for each geometry and energy, in units of l and γ₁:

    small slopes   line, axisymmetric  small.py on network.py and rings.py
    finite         line                finite_line.py on finite_range.py
                   axisymmetric        menisci.py

They are solved on spectral elements (network.py) whose errors are rounding.
"""

from discretization.surfaces.finite_line import FiniteSurfaces
from discretization.surfaces.menisci import MeniscusSurfaces
from discretization.surfaces.protocol import Surfaces
from discretization.surfaces.small import SmallSurfaces
from energy import Scene


def surfaces_of(scene: Scene) -> Surfaces:
    """The free surfaces of a scene."""
    if scene.slopes == "small":
        return SmallSurfaces(scene)
    return MeniscusSurfaces(scene) if scene.axisymmetric else FiniteSurfaces(scene)
