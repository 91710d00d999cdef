"""A scene as plain data and back, so that a file can say what it belongs to.

A description names a class and what it was made with. `Profile` is a profile of two functions;
`Shifted`, `Tilted`, `Sum` and `Mirrored` (f(|x|), about an axis) are composed of others; `Circle`,
`FlatPunch`, `Parabola`, `Plane`, `PowerLaw`, `Wedge` and `Sampled` (measured heights) are shapes;
`Patches` is a factor on adhesion along the surface. `SurfaceEnergies` are given by three energies,
or by γ₁ and w (`from_work`), and `given` are those numbers by name.
"""

from dataclasses import fields, is_dataclass
from typing import Any

import numpy as np

from energy.axis import Mirrored
from energy.indenter import Profile, Shifted, Sum, Tilted
from energy.indenters import Circle, FlatPunch, Parabola, Plane, PowerLaw, Wedge
from energy.layer import ElasticLayer
from energy.pattern import Patches
from energy.sampled import Sampled
from energy.scene import Scene
from energy.surfaces import SurfaceEnergies

_SHAPES = (Circle, FlatPunch, Parabola, Plane, PowerLaw, Wedge, Sampled)
_COMPOSED = (Shifted, Tilted, Sum, Mirrored)
_PARTS = (ElasticLayer, SurfaceEnergies, Patches)
KINDS = {kind.__name__: kind for kind in (Scene, *_PARTS, *_SHAPES, *_COMPOSED)}


def described(thing: Any) -> Any:
    """Plain data that say what a scene or a part of it is.

    Parameters
    ----------
    thing : Scene, or anything that a scene is made of
        The functions of a `Profile` are not described, and `rebuilt` refuses it.

    Returns
    -------
    dict, list, float, str, bool or None
        Of a scene, a layer or an indenter a dict with its class as "type" and what it was made
        with, as JSON can hold it.
    """
    if isinstance(thing, np.ndarray):
        return thing.tolist()
    if isinstance(thing, (tuple, list)):
        return [described(part) for part in thing]
    if thing is None or isinstance(thing, (str, bool)):
        return thing
    if isinstance(thing, (np.number, float, int)):
        return float(thing)
    if not is_dataclass(thing) or isinstance(thing, type):
        return repr(type(thing))
    if isinstance(thing, Profile):
        return {"type": "Profile", "extent": [float(end) for end in thing.extent]}
    if isinstance(thing, SurfaceEnergies):
        energies = {name: float(value) for name, value in thing.given.items()}
        return {"type": "SurfaceEnergies", **energies}
    given = {f.name: described(getattr(thing, f.name)) for f in fields(thing) if f.init}
    return {"type": type(thing).__name__, **given}


def rebuilt(description: Any) -> Any:
    """The scene, or part of one, that a description is of.

    Parameters
    ----------
    description : dict, list, float, str, bool or None
        As `described` gives it.

    Returns
    -------
    Scene, or anything that a scene is made of

    Raises
    ------
    ValueError
        For a profile given by functions, and for an indenter that is not one of `energy`.
    """
    if not isinstance(description, dict):
        return description
    kind = KINDS.get(description.get("type", ""))
    if kind is None:
        raise ValueError(
            f"type = {description.get('type')!r} cannot be rebuilt from its description; pass the "
            "scene that was used"
        )
    parts = {name: rebuilt(part) for name, part in description.items() if name != "type"}
    if kind is SurfaceEnergies and "w" in parts:
        return SurfaceEnergies.from_work(**parts)
    return kind(**parts)


def alike(one: Any, other: Any) -> bool:
    """Whether two descriptions are of equal things, however their surface energies were given.

    Parameters
    ----------
    one, other : dict, list, float, str, bool or None
        As `described` gives them.

    Returns
    -------
    bool
    """
    return bool(_with_three_energies(one) == _with_three_energies(other))


def _with_three_energies(description: Any) -> Any:
    """The description with γ₁, γ₂, γ₁₂ for surface energies given by γ₁ and w."""
    if not isinstance(description, dict):
        return description
    if description.get("type") == "SurfaceEnergies":
        made = rebuilt(description)
        return made.gamma1, made.gamma2, made.gamma12
    return {name: _with_three_energies(part) for name, part in description.items()}
