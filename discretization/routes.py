"""Which question of which scene leads where, or why it is refused: all that decides stands here.

Questions are the two branches of `minimise`, "adhered" and "global", the "search" for the lowest
contacts by a method of its own, and the load "path"; they are asked of the fitted mesh or of nodes.
"""

from collections.abc import Sequence
from typing import NoReturn

from energy import Circle, FlatPunch, Parabola, Plane, PowerLaw, Scene, Wedge
from energy.checks import finite, option, positive

LOWEST = ("shortest_path", "oracle")  # methods that search for the lowest contacts
ON_NODES = ("lattice", *LOWEST)
# turned about an axis, of these the line has one stable place (fitted/alone.py)
UNIMODAL = (Parabola, Wedge, PowerLaw, FlatPunch, Circle)

_PATH = (
    "opening = {scene.opening!r}, pattern = {scene.pattern!r}: where the line rests depends on the "
    "path; use branch='adhered' with gamma1 > 0 (on the lattice with small slopes), load_path, or "
    "a Scene without it"
)
_NODES = (
    ": nodes answer states, searches over contact sets and load paths with slopes = 'small' and "
    "gamma1 > 0, but about an axis no searches, and only one contact around it, of a convex "
    "indenter without a pattern; else they answer states of one contact alone, without tension "
    "of a convex indenter; use method='fitted'"
)
_BENT = (
    "branch = 'global' with slopes = {scene.slopes!r}: of an indenter that is not convex the "
    "lowest energy is only found for slopes='small'"
)
_ENDLESS = (
    "indenter = {scene.indenter!r}: a load path needs a profile with a lowest point, such as a "
    "punch, wedge, parabola, power law, or a sum of these"
)
_LAYER = (
    ": response = 'layer' answers one contact of a convex indenter, mirror-symmetric or turned "
    "about an axis, with small slopes, gamma1 > 0 and branch = 'adhered'; "
)
_OTHERWISE = "change that, or use response='springs'"
_LOWER = "use that branch, or response='springs' for what has least energy"
_LAYER_NODES = "method = 'lattice': nodes answer no load paths of a layer; use method='fitted'"


def usable(
    scene: Scene, rtol: float, method: str, methods: Sequence[str], spacing: float | None
) -> float | None:
    """The spacing, None on the fitted mesh.

    ValueError unless this is a scene, a relative error, one of the methods, and a spacing > 0 if
    that has nodes.
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene = {scene!r} is not a Scene; build one with energy.Scene(...)")
    option("method", method, methods)
    if not 0 < finite("rtol", rtol) < 1:
        raise ValueError(f"rtol = {rtol!r} is outside (0, 1); give a relative error such as 1e-8")
    if (method in ON_NODES) != (spacing is not None):
        raise ValueError(
            f"spacing = {spacing!r} with method = {method!r}: nodes, as of method='lattice', "
            "need their distance; the fitted mesh has no spacing"
        )
    return None if spacing is None else positive("spacing", spacing)


def one_contact(scene: Scene) -> bool:
    """Whether at any depth there is at most one stable contact, with one line on each side."""
    return scene.indenter.convex and (
        not scene.axisymmetric or isinstance(scene.indenter, UNIMODAL)
    )


def _held_twice(scene: Scene) -> bool:
    """Whether where a line rests depends on the way it came."""
    return scene.opening is not None or scene.pattern is not None


def _steep(scene: Scene) -> bool:
    return scene.slopes == "finite" and scene.gamma1 > 0


def _searched(scene: Scene, question: str) -> bool:
    """Whether the lowest state is asked for, and may be another than that of the path or none."""
    adheres = scene.gamma1 > 0 and scene.work_of_adhesion > 0
    return question == "global" and adheres and not one_contact(scene)


def question_of(method: str, branch: str) -> str:
    """What is asked by a method of `minimise`."""
    return "search" if method in LOWEST else branch


def route(scene: Scene, question: str, *, nodes: bool) -> str:
    """What answers a question of a scene. ValueError where nothing does."""
    if scene.layer.exact:
        return _of_layer(scene, question, nodes)
    no_path = not scene.gamma1 or isinstance(scene.indenter, Plane)
    path_asked = question == "path" or (question == "adhered" and not no_path)
    if _held_twice(scene) and not path_asked:
        _refuse(scene, _PATH)
    return _on_nodes(scene, question) if nodes else _on_mesh(scene, question)


def _of_layer(scene: Scene, question: str, nodes: bool) -> str:
    body, line = scene.indenter, not scene.axisymmetric
    beyond = {
        "slopes = {scene.slopes!r}": scene.slopes != "small",
        "gamma1 = {scene.gamma1!r}": not scene.gamma1,
        "pattern = {scene.pattern!r}": scene.pattern is not None,
        "indenter = {scene.indenter!r} has no lowest point": isinstance(body, Plane),
        "indenter = {scene.indenter!r} is not convex": not body.convex,
        "indenter = {scene.indenter!r} is not mirror-symmetric": line and scene.mirror is None,
    }
    _refuse_any(scene, beyond, _LAYER + _OTHERWISE)
    if question in ("global", "search"):
        _refuse(scene, "branch = 'global'" + _LAYER + _LOWER)
    if question == "adhered" and _held_twice(scene):
        _refuse(scene, _PATH)
    return _refuse(scene, _LAYER_NODES) if question == "path" and nodes else "layer"


def _on_mesh(scene: Scene, question: str) -> str:
    state, convex = question != "path", scene.indenter.convex
    if isinstance(scene.indenter, Plane):
        return "plane" if state else _refuse(scene, _ENDLESS)
    if not scene.gamma1:
        return "springs"
    if state and one_contact(scene) and not _held_twice(scene):
        return "one contact"
    if _steep(scene) and _searched(scene, question) and not (scene.axisymmetric and convex):
        _refuse(scene, _BENT)
    return "several contacts"


def _on_nodes(scene: Scene, question: str) -> str:
    convex, held, steep = scene.indenter.convex, _held_twice(scene), _steep(scene)
    searched, few = _searched(scene, question), question in ("search", "path")
    one_disc = convex and scene.pattern is None and not (steep or searched or question == "search")
    beyond = {
        "geometry = 'axisymmetric'": scene.axisymmetric and not one_disc,
        "slopes = 'finite'": steep and (few or held),
        "gamma1 = 0": not scene.gamma1 and (few or not convex),
    }
    _refuse_any(scene, beyond, _NODES)
    if steep and searched:
        _refuse(scene, _BENT)
    if question == "search":
        return "lowest"
    if isinstance(scene.indenter, Plane):
        return "plane" if question != "path" else _refuse(scene, _ENDLESS)
    if steep or not scene.gamma1:
        return "plain"
    if held or question == "path" or convex:
        return "path"
    return "lowest" if question == "global" or not scene.work_of_adhesion else "path"


def _refuse_any(scene: Scene, beyond: dict[str, bool], why: str) -> None:
    for what, too_much in beyond.items():
        if too_much:
            _refuse(scene, what + why)


def _refuse(scene: Scene, why: str) -> NoReturn:
    raise ValueError(why.format(scene=scene))
