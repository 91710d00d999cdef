"""The physics, without a grid: layer, surfaces, indenters, scene, energy densities, closed forms.

Per unit length of the line contact, any consistent units; arrays are float64 of any shape.

| symbol | name                                | unit            | sign                          |
| ------ | ----------------------------------- | --------------- | ----------------------------- |
| x      | position along the surface          | length          |                               |
| u      | surface displacement                | length          | positive downwards            |
| f      | indenter profile                    | length          | positive upwards              |
| d      | indentation depth (f = 0 level)     | length          | positive into the layer       |
| g      | d - f, the displacement in contact  | length          | u >= g: no penetration        |
| a      | contact half-width                  | length          | >= 0                          |
| θ      | contact angle, in the outer medium  | rad             | π: the surface is smooth      |
| P      | force on the indenter per length    | force/length    | positive compressive          |
| U      | energy per length                   | energy/length   | 0: flat, no contact           |
| E, ν, h| modulus, Poisson ratio, thickness   | stress, 1, length | > 0, (-1, ½], > 0         |
| Ẽ, k   | uniaxial modulus, stiffness Ẽ/h     | stress, stress/length | > 0                     |
| γ₁, γ₂, γ₁₂ | energies of layer, indenter, interface | energy/area | γ₁ >= 0                   |
| w      | work of adhesion γ₁ + γ₂ - γ₁₂      | energy/area     | >= 0                          |
| l      | elastocapillary length √(γ₁/k)      | length          |                               |
| k(q)   | of the exact response, wave number q | stress/length  | k(0) = k                      |
| ℓ      | its length in place of l, Eq. (16)  | length          | either; l for springs         |
| δ₀     | critical separation √(2w/k)         | length          |                               |
| α      | √(2w/γ₁) = δ₀/l, small-slope π - θ  | 1               |                               |
"""

import importlib
from typing import TYPE_CHECKING

from energy import indenters
from energy.files.profile_file import read_profile
from energy.indenter import Indenter, Profile
from energy.indenters import *  # noqa: F403
from energy.layer import ElasticLayer
from energy.pattern import Patches
from energy.sampled import Sampled
from energy.scene import Scene
from energy.surfaces import SurfaceEnergies
from energy.validity import Assumption

if TYPE_CHECKING:
    from energy import cards
else:

    def __getattr__(name):
        """The closed forms are imported when they are first used, since no minimiser uses them."""
        if name == "cards":
            return importlib.import_module("energy.cards")
        raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


__all__ = [
    "Assumption",
    "ElasticLayer",
    "Indenter",
    "Patches",
    "Profile",
    "Sampled",
    "Scene",
    "SurfaceEnergies",
    "cards",
    "read_profile",
]
__all__ += indenters.__all__
