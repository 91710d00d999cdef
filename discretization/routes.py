"""Which solver finds a state or a path of a scene, and which combinations are not supported.

Kinds of questions are the two branches of `minimise`, "adhered" and "global", the "search" for the
lowest contacts by a method of its own, and the load "path"; each is for the fitted mesh or nodes.

What is not supported stands in three lists of `Unsupported`: of scenes on springs, of layers with
their exact response (`scene.layer.exact`), and of `minimise_many`. The first of a list that applies
makes the error. Their conditions are functions of a `Question`, whose properties are said there.

`Scene.hookean` is whether the springs are linear; `mirror` is x about which the profile is its own
mirror image, None if there is none: without one the contact on a layer is not symmetric, and is not
supported. `opening` are the surface energies of contacts that open, where they are others. `option`
raises ValueError for a word that is not known, `positive` and `finite` for a number that is not. A
plane is endless; a `FlatPunch` is one with edges, a `Circle` an arc, and a `PowerLaw` c |x|ⁿ.
"""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from energy import Circle, FlatPunch, Parabola, Plane, PowerLaw, Scene, Wedge
from energy.checks import finite, option, positive

LOWEST = ("shortest_path", "oracle")  # methods that search for the lowest contacts
ON_NODES = ("lattice", *LOWEST)
# Indenters of which, turned about an axis, the line has one stable place at any depth
# (fitted/single_contact.py).
UNIMODAL = (Parabola, Wedge, PowerLaw, FlatPunch, Circle)


@dataclass(frozen=True)
class Question:
    """A state or a path that somebody wants of a scene.

    Attributes
    ----------
    scene : Scene
    kind : {"adhered", "global", "search", "path"}
        See the head of this module.
    nodes : bool
        Whether it is put to nodes, or else to the fitted mesh.
    """

    scene: Scene
    kind: str
    nodes: bool

    @property
    def axisymmetric(self) -> bool:
        """Whether the indenter is turned about an axis."""
        return self.scene.axisymmetric

    @property
    def tense(self) -> bool:
        """Whether there is surface tension."""
        return self.scene.gamma1 > 0

    @property
    def convex(self) -> bool:
        """Whether the indenter is convex."""
        return self.scene.indenter.convex

    @property
    def plane(self) -> bool:
        """Whether the indenter is a plane without end."""
        return isinstance(self.scene.indenter, Plane)

    @property
    def steep(self) -> bool:
        """Whether the surface has finite slopes; without tension they do not matter."""
        return self.scene.slopes == "finite" and self.tense

    @property
    def path_dependent(self) -> bool:
        """Whether where lines rest depends on the path: with two works of adhesion or a pattern."""
        return self.scene.path_dependent

    @property
    def searched(self) -> bool:
        """Whether it is the lowest state that may be another than that of the path, or none."""
        several = self.scene.work_of_adhesion > 0 and not one_contact(self.scene)
        return self.kind == "global" and self.tense and several


class Unsupported(NamedTuple):
    """A combination that is not supported; of several the first one counts.

    Attributes
    ----------
    applies : callable
        Whether a `Question` is of that kind.
    message : str
        What is not supported; fields in braces are attributes of the scene.
    remedy : str
        What to use instead.
    """

    applies: Callable[[Question], bool]
    message: str
    remedy: str

    def error(self, scene: Scene) -> ValueError:
        """The error for a scene."""
        return ValueError(self.message.format(scene=scene) + self.remedy)


# Ends of messages, after what the scene has that does not fit, and remedies.
_NODES = (
    ": nodes support states, searches over contact sets and load paths with slopes = 'small' and "
    "gamma1 > 0, but about an axis no searches, and only one contact around it, of a convex "
    "indenter without a pattern; else they support states of one contact alone, without tension "
    "of a convex indenter; "
)
_USE_MESH = "use method='fitted'"
_LAYER = (
    ": response = 'layer' supports one contact of a convex indenter, mirror-symmetric or turned "
    "about an axis, with small slopes, gamma1 > 0 and branch = 'adhered'; "
)
_USE_SPRINGS = "change that, or use response='springs'"
_MANY = (
    ": minimise_many finds states of one contact of a convex indenter on linear springs, about an "
    "axis of a punch, wedge, parabola, power law or circle, without opening and pattern; "
)
_USE_LOOP = "use minimise in a loop, or load_path"
_PATH_DEPENDENT = (
    "opening = {scene.opening!r}, pattern = {scene.pattern!r}: where the line rests depends on the "
    "path; "
)
_USE_PATH = (
    "use branch='adhered' with gamma1 > 0 (on the lattice with small slopes), load_path, or "
    "a Scene without it"
)


def _needs_path(question: Question) -> bool:
    """Whether it is a state that depends on the path, and is not followed from first touch on."""
    if not question.path_dependent or question.kind == "path":
        return False
    return question.kind != "adhered" or not question.tense or question.plane


def _nonlinear_springs_unknown(question: Question) -> bool:
    """Whether springs are not linear, other than of one contact on nodes along the path."""
    if question.scene.hookean:
        return False
    simple = not (question.steep or question.axisymmetric or question.path_dependent)
    on_nodes = question.nodes and question.tense and question.kind == "adhered"
    return not (on_nodes and simple and question.convex and not question.plane)


def _rings_on_nodes(question: Question) -> bool:
    """Whether nodes about an axis would need other contacts than one around it."""
    if not (question.nodes and question.axisymmetric):
        return False
    one_disc = question.convex and question.scene.pattern is None
    followed = not (question.steep or question.searched or question.kind == "search")
    return not (one_disc and followed)


def _bent_global(question: Question) -> bool:
    """Whether the lowest state with finite slopes would have to be searched for."""
    known = not question.nodes and question.axisymmetric and question.convex
    return question.steep and question.searched and not known


def _several_over_a_pattern(question: Question) -> bool:
    """Whether a path of several contacts over a pattern is to be followed on the mesh."""
    if question.kind != "path" or question.nodes or question.scene.pattern is None:
        return False
    return question.tense and not (question.axisymmetric or question.convex)


SPRINGS_LIMITS = (
    Unsupported(
        _nonlinear_springs_unknown,
        "springs that are not linear, as energy.terms.spring has them, are known to nodes alone: ",
        "use method='lattice' with branch='adhered' for a line contact of a convex indenter with "
        "slopes='small' and gamma1 > 0, without opening and pattern",
    ),
    Unsupported(_needs_path, _PATH_DEPENDENT, _USE_PATH),
    Unsupported(_rings_on_nodes, "geometry = 'axisymmetric'" + _NODES, _USE_MESH),
    Unsupported(
        lambda q: q.nodes and q.steep and (q.kind in ("search", "path") or q.path_dependent),
        "slopes = 'finite'" + _NODES,
        _USE_MESH,
    ),
    Unsupported(
        lambda q: q.nodes and not q.tense and (q.kind in ("search", "path") or not q.convex),
        "gamma1 = 0" + _NODES,
        _USE_MESH,
    ),
    Unsupported(
        _bent_global,
        "branch = 'global' with slopes = {scene.slopes!r}: of an indenter that is not convex the "
        "lowest energy is only found for ",
        "slopes='small'",
    ),
    Unsupported(
        lambda q: q.plane and q.kind == "path",
        "indenter = {scene.indenter!r}: a load path needs a profile with a lowest point, ",
        "such as a punch, wedge, parabola, power law, or a sum of these",
    ),
    Unsupported(
        lambda q: q.kind == "path" and not q.tense and q.scene.pattern is not None,
        "pattern = {scene.pattern!r} with gamma1 = 0: springs that let go at different heights are "
        "not followed; ",
        "give gamma1 > 0, or leave the pattern out",
    ),
    Unsupported(
        _several_over_a_pattern,
        "pattern = {scene.pattern!r} under an indenter that is not convex: paths of several "
        "contacts over a pattern are followed on nodes; ",
        "use method='lattice'",
    ),
)

LAYER_LIMITS = (
    Unsupported(
        lambda q: q.scene.slopes != "small", "slopes = {scene.slopes!r}" + _LAYER, _USE_SPRINGS
    ),
    Unsupported(lambda q: not q.tense, "gamma1 = {scene.gamma1!r}" + _LAYER, _USE_SPRINGS),
    Unsupported(
        lambda q: q.scene.pattern is not None,
        "pattern = {scene.pattern!r}" + _LAYER,
        _USE_SPRINGS,
    ),
    Unsupported(
        lambda q: q.plane,
        "indenter = {scene.indenter!r} has no lowest point" + _LAYER,
        _USE_SPRINGS,
    ),
    Unsupported(
        lambda q: not q.convex, "indenter = {scene.indenter!r} is not convex" + _LAYER, _USE_SPRINGS
    ),
    Unsupported(
        lambda q: not q.axisymmetric and q.scene.mirror is None,
        "indenter = {scene.indenter!r} is not mirror-symmetric" + _LAYER,
        _USE_SPRINGS,
    ),
    Unsupported(
        lambda q: q.kind in ("global", "search"),
        "branch = 'global'" + _LAYER,
        "use that branch, or response='springs' for what has least energy",
    ),
    Unsupported(lambda q: q.kind == "adhered" and q.path_dependent, _PATH_DEPENDENT, _USE_PATH),
    Unsupported(
        lambda q: q.kind == "path" and q.nodes,
        "method = 'lattice': nodes support no load paths of a layer; ",
        _USE_MESH,
    ),
)

MANY_LIMITS = (
    Unsupported(
        lambda q: q.scene.layer.exact,
        "layer.response = {scene.layer.response!r}" + _MANY,
        _USE_LOOP,
    ),
    Unsupported(
        lambda q: q.scene.opening is not None, "opening = {scene.opening!r}" + _MANY, _USE_LOOP
    ),
    Unsupported(
        lambda q: q.scene.pattern is not None, "pattern = {scene.pattern!r}" + _MANY, _USE_LOOP
    ),
    Unsupported(
        lambda q: q.plane, "indenter = {scene.indenter!r} has no lowest point" + _MANY, _USE_LOOP
    ),
    Unsupported(
        lambda q: not q.convex, "indenter = {scene.indenter!r} is not convex" + _MANY, _USE_LOOP
    ),
    Unsupported(
        lambda q: q.axisymmetric and not isinstance(q.scene.indenter, UNIMODAL),
        "indenter = {scene.indenter!r} about an axis" + _MANY,
        _USE_LOOP,
    ),
    Unsupported(lambda q: not q.scene.hookean, "springs that are not linear" + _MANY, _USE_LOOP),
)


def usable(
    scene: Scene, rtol: float, method: str, methods: Sequence[str], spacing: float | None
) -> float | None:
    """Check the arguments that `minimise` and `load_path` share.

    Parameters
    ----------
    scene : Scene
    rtol : float
        In (0, 1).
    method : str
        One of `methods`.
    methods : sequence of str
    spacing : float or None
        > 0 [length] with a method on nodes, else None.

    Returns
    -------
    float or None
        The spacing.

    Raises
    ------
    ValueError
        Unless they are that.
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

    Parameters are those of `usable`, and so is the ValueError. With "auto" it is on nodes if a
    spacing is given, or if the mesh does not follow the scene and nodes do.
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
    """Whether load paths of a scene are supported: on nodes, or else on the fitted mesh."""
    try:
        route(scene, "path", nodes=nodes)
    except ValueError:
        return False
    return True


def one_contact(scene: Scene) -> bool:
    """Whether at any depth there is at most one stable contact, with one line on each side.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    bool
    """
    return scene.indenter.convex and (
        not scene.axisymmetric or isinstance(scene.indenter, UNIMODAL)
    )


def refined(scene: Scene) -> bool:
    """Whether states of several contacts are found on nodes and refined (refine/states.py).

    Else their lines move on the mesh from first touch on (fitted/contact_lines.py).
    """
    return not scene.axisymmetric and scene.slopes == "small" and scene.pattern is None


def refinable(scene: Scene) -> bool:
    """Whether paths of several contacts are found on nodes and refined.

    Parameters
    ----------
    scene : Scene

    Returns
    -------
    bool
    """
    return refined(scene) and scene.gamma1 > 0 and not one_contact(scene)


def vectorised(scene: Scene) -> None:
    """Raise an error unless many states of a scene can be found at once: those of one contact.

    Parameters
    ----------
    scene : Scene

    Raises
    ------
    ValueError
    """
    _check(Question(scene, "adhered", nodes=False), MANY_LIMITS)


def _check(question: Question, limits: Sequence[Unsupported]) -> None:
    """Raise the ValueError of the first limit that applies, if one does."""
    for limit in limits:
        if limit.applies(question):
            raise limit.error(question.scene)


def route(scene: Scene, kind: str, *, nodes: bool) -> str:
    """The solver for a state or a path of a scene.

    Parameters
    ----------
    scene : Scene
    kind : {"adhered", "global", "search", "path"}
        A branch of a state, a search over contact sets, or a load path.
    nodes : bool
        Whether it is for nodes, or else for the fitted mesh.

    Returns
    -------
    str
        "layer" for a layer with its exact response, "plane" for a plane without end; on the mesh
        "one contact", "refined contacts" (found on nodes), "several contacts" (on the mesh alone),
        or "springs" without tension; on nodes "path" along the path from first touch, "lowest" for
        the lowest contact set, or "plain" by plain minimisation, of one contact.

    Raises
    ------
    ValueError
        Where none does.
    """
    question = Question(scene, kind, nodes)
    _check(question, LAYER_LIMITS if scene.layer.exact else SPRINGS_LIMITS)
    if scene.layer.exact:
        return "layer"
    if kind == "search":
        return "lowest"
    if question.plane:
        return "plane"
    if question.tense and not nodes:
        if kind == "path":
            return "several contacts"
        if one_contact(scene) and not question.path_dependent:
            return "one contact"
        return "refined contacts" if refined(scene) else "several contacts"
    if question.steep or not (question.tense and scene.hookean):
        return "plain" if nodes else "springs"
    followed = question.path_dependent or kind == "path" or question.convex
    lowest = kind == "global" or not scene.work_of_adhesion
    return "lowest" if lowest and not followed else "path"
