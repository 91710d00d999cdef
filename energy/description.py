"""A scene as plain data and back, so that a file can say what it belongs to."""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from energy.axis import Mirrored
from energy.indenter import Profile, Shifted, Sum, Tilted
from energy.indenters import Bowl
from energy.layer import ElasticLayer
from energy.pattern import Patches
from energy.sampled import Sampled
from energy.scene import Scene
from energy.surfaces import SurfaceEnergies

_SHAPES = (*Bowl.__subclasses__(), Sampled)
_BODIES = (*_SHAPES, Shifted, Tilted, Sum, Mirrored)
KINDS = {kind.__name__: kind for kind in (Scene, ElasticLayer, SurfaceEnergies, Patches, *_BODIES)}


def described(thing: Any) -> Any:
    """Nested dicts, lists, numbers and strings that say what a scene or a part of it is.

    Functions of a `Profile` are named only: `rebuilt` refuses it.
    """
    if isinstance(thing, np.ndarray):
        return thing.tolist()
    if isinstance(thing, (tuple, list)):
        return [described(part) for part in thing]
    if isinstance(thing, (np.number, float, int)) and not isinstance(thing, bool):
        return float(thing)
    if not is_dataclass(thing) or isinstance(thing, type):
        return thing if thing is None or isinstance(thing, (str, bool)) else repr(type(thing))
    if isinstance(thing, Profile):
        return {"type": "Profile", "extent": [float(end) for end in thing.extent]}
    if isinstance(thing, SurfaceEnergies):
        return {
            "type": "SurfaceEnergies",
            **{name: float(value) for name, value in thing.given.items()},
        }
    given = {f.name: described(getattr(thing, f.name)) for f in fields(thing) if f.init}
    return {"type": type(thing).__name__, **given}


def rebuilt(description: Any) -> Any:
    """What `described` described. ValueError for a profile given by functions."""
    if not isinstance(description, dict):
        return description
    kind = KINDS.get(description.get("type", ""))
    if kind is None:
        raise ValueError(
            f"type = {description.get('type')!r} cannot be rebuilt from its description; pass the "
            "scene that was used"
        )
    parts = {name: rebuilt(part) for name, part in description.items() if name != "type"}
    return SurfaceEnergies.from_work(**parts) if "w" in parts else kind(**parts)


def alike(one: Any, other: Any) -> bool:
    """Whether two descriptions are of equal things, however their surface energies were given."""
    return bool(_spelt_out(one) == _spelt_out(other))


def _spelt_out(description: Any) -> Any:
    """The description with γ₁, γ₂, γ₁₂ for surface energies given by γ₁ and w."""
    if not isinstance(description, dict):
        return description
    if description.get("type") == "SurfaceEnergies":
        made = rebuilt(description)
        return made.gamma1, made.gamma2, made.gamma12
    return {name: _spelt_out(part) for name, part in description.items()}
