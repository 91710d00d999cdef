"""Which question of which scene leads where, or why it is refused: all that decides stands here.

Questions are the two branches of `minimise`, "adhered" and "global", the "search" for the lowest
contacts by a method of its own, and the load "path"; they are asked of the fitted mesh or of nodes.
"""

from collections.abc import Sequence

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
_UNEVEN = (
    "pattern = {scene.pattern!r} with gamma1 = 0: springs that let go at different heights are not "
    "followed; give gamma1 > 0, or leave the pattern out"
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
_HOOKE = (
    "springs that are not linear, as energy.terms.spring has them, are known to nodes alone: use "
    "method='lattice' with branch='adhered' for a line contact of a convex indenter with "
    "slopes='small' and gamma1 > 0, without opening and pattern"
)
_ENDLESS = (
    "indenter = {scene.indenter!r}: a load path needs a profile with a lowest point, such as a "
    "punch, wedge, parabola, power law, or a sum of these"
)
_MANY_PATCHES = (
    "pattern = {scene.pattern!r} under an indenter that is not convex: paths of several contacts "
    "over a pattern are followed on nodes; use method='lattice'"
)
_LAYER = (
    ": response = 'layer' answers one contact of a convex indenter, mirror-symmetric or turned "
    "about an axis, with small slopes, gamma1 > 0 and branch = 'adhered'; "
)
_OTHERWISE = "change that, or use response='springs'"
_LOWER = "use that branch, or response='springs' for what has least energy"
_MANY = (
    ": minimise_many finds states of one contact of a convex indenter on linear springs, about an "
    "axis of a punch, wedge, parabola, power law or circle, without opening and pattern; use "
    "minimise in a loop, or load_path"
)
_LAYER_NODES = "method = 'lattice': nodes answer no load paths of a layer; use method='fitted'"


def usable(
    scene: Scene, rtol: float, method: str, methods: Sequence[str], spacing: float | None
) -> float | None:
    """The spacing, None on the fitted mesh.

    ValueError unless this is a scene, a relative error, a method, and a spacing > 0 with nodes.
    """
    if not isinstance(scene, Scene):
        raise ValueError(f"scene = {scene!r} is not a Scene; build one with energy.Scene(...)")
    option("method", method, methods)
    if not 0 < finite("rtol", rtol) < 1:
        raise ValueError(f"rtol = {rtol!r} is outside (0, 1); give a relative error such as 1e-8")
    if (method in ON_NODES) != (spacing is not None):
        raise ValueError(
            f"spacing = {spacing!r} with method = {method!r}: method='lattice' requires "
            "spacing; the fitted mesh has no spacing"
        )
    return None if spacing is None else positive("spacing", spacing)


def usable_on_path(
    scene: Scene, rtol: float, method: str, methods: Sequence[str], spacing: float | None
) -> bool:
    """Whether a load path is followed on nodes; their spacing may be left open.

    ValueError unless this is a scene, a relative error, a method, and a spacing > 0 or None.
    """
    option("method", method, methods)
    if method == "lattice" and spacing is None:
        usable(scene, rtol, "auto", methods, None)
        return True
    if method == "auto" and spacing is not None:
        method = "lattice"
    usable(scene, rtol, method, methods, spacing)
    if method == "auto" and not _followed(scene, nodes=False):
        return _followed(scene, nodes=True)
    return method == "lattice"


def _followed(scene: Scene, *, nodes: bool) -> bool:
    """Whether load paths of a scene are followed on nodes, or on the fitted mesh."""
    try:
        route(scene, "path", nodes=nodes)
    except ValueError:
        return False
    return True


def one_contact(scene: Scene) -> bool:
    """Whether at any depth there is at most one stable contact, with one line on each side."""
    return scene.indenter.convex and (
        not scene.axisymmetric or isinstance(scene.indenter, UNIMODAL)
    )


def refined(scene: Scene) -> bool:
    """Whether states of several contacts are found on nodes and refined (refine/states.py)."""
    return not scene.axisymmetric and scene.slopes == "small" and scene.pattern is None


def refinable(scene: Scene) -> bool:
    """Whether paths of several contacts are found on nodes and refined."""
    return refined(scene) and scene.gamma1 > 0 and not one_contact(scene)


def vectorised(scene: Scene) -> None:
    """ValueError unless many states of a scene can be found at once: those of one contact."""
    turned, body = scene.axisymmetric, scene.indenter
    beyond = {
        f"layer.response = {scene.layer.response!r}": scene.layer.exact,
        f"opening = {scene.opening!r}": scene.opening is not None,
        f"pattern = {scene.pattern!r}": scene.pattern is not None,
        f"indenter = {body!r} has no lowest point": isinstance(body, Plane),
        f"indenter = {body!r} is not convex": not body.convex,
        f"indenter = {body!r} about an axis": turned and not isinstance(body, UNIMODAL),
        "springs that are not linear": not scene.hookean,
    }
    for what, so in beyond.items():
        if so:
            raise ValueError(what + _MANY)


def route(scene: Scene, question: str, *, nodes: bool) -> str:
    """What answers a question of a scene. ValueError where nothing does."""
    exact, held = scene.layer.exact, scene.path_dependent
    for why, beyond in (_of_layer if exact else _of_springs)(scene, question, nodes).items():
        if beyond:
            raise ValueError(why.format(scene=scene))
    if exact:
        return "layer"
    if question == "search":
        return "lowest"
    if isinstance(scene.indenter, Plane):
        return "plane"
    if not nodes and scene.gamma1:
        if question == "path":
            return "several contacts"
        if one_contact(scene) and not held:
            return "one contact"
        return "refined contacts" if refined(scene) else "several contacts"
    if not (scene.gamma1 and scene.hookean) or scene.slopes == "finite":
        return "plain" if nodes else "springs"
    lowest = question == "global" or not scene.work_of_adhesion
    followed = held or question == "path" or scene.indenter.convex
    return "lowest" if lowest and not followed else "path"


def _of_layer(scene: Scene, question: str, nodes: bool) -> dict[str, bool]:
    """Why a layer with its exact response is refused, and whether that is so."""
    body, line = scene.indenter, not scene.axisymmetric
    beyond = {
        "slopes = {scene.slopes!r}": scene.slopes != "small",
        "gamma1 = {scene.gamma1!r}": not scene.gamma1,
        "pattern = {scene.pattern!r}": scene.pattern is not None,
        "indenter = {scene.indenter!r} has no lowest point": isinstance(body, Plane),
        "indenter = {scene.indenter!r} is not convex": not body.convex,
        "indenter = {scene.indenter!r} is not mirror-symmetric": line and scene.mirror is None,
    }
    return {
        **{what + _LAYER + _OTHERWISE: so for what, so in beyond.items()},
        "branch = 'global'" + _LAYER + _LOWER: question in ("global", "search"),
        _PATH: question == "adhered" and scene.path_dependent,
        _LAYER_NODES: question == "path" and nodes,
    }


def _of_springs(scene: Scene, question: str, nodes: bool) -> dict[str, bool]:
    """The same of springs.

    The lowest state is searched for where it may be another than that of the path, or none.
    """
    turned, convex, held = scene.axisymmetric, scene.indenter.convex, scene.path_dependent
    tense, plane = scene.gamma1 > 0, isinstance(scene.indenter, Plane)
    steep, few = scene.slopes == "finite" and tense, question in ("search", "path")
    unsure = tense and scene.work_of_adhesion > 0 and not one_contact(scene)
    searched, path = question == "global" and unsure, question == "path"
    patched = tense and scene.pattern is not None
    simple = nodes and tense and not (steep or turned or held or plane) and question == "adhered"
    one_disc = convex and scene.pattern is None and not (steep or searched or question == "search")
    return {
        _HOOKE: not (scene.hookean or (simple and convex)),
        _PATH: held and not (path or (question == "adhered" and tense and not plane)),
        "geometry = 'axisymmetric'" + _NODES: nodes and turned and not one_disc,
        "slopes = 'finite'" + _NODES: nodes and steep and (few or held),
        "gamma1 = 0" + _NODES: nodes and not tense and (few or not convex),
        _BENT: steep and searched and (nodes or not (turned and convex)),
        _ENDLESS: plane and path,
        _UNEVEN: path and not tense and scene.pattern is not None,
        _MANY_PATCHES: path and patched and not (nodes or turned or convex),
    }
