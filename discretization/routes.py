"""Which question of which scene leads where, or why it is refused: the one table that decides.

Questions are the two branches of `minimise`, "adhered" and "global", the "search" for the lowest
contacts by a method of its own or by the "oracle", and the load "path"; they are asked of the
fitted mesh or of nodes.
The first row that applies decides.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from typing import NamedTuple

from energy import Circle, FlatPunch, Parabola, Plane, PowerLaw, Scene, Wedge
from energy.checks import finite, option

# turned about an axis, of these the line has one stable place (fitted/single_lines.py)
UNIMODAL = (Parabola, Wedge, PowerLaw, FlatPunch, Circle)
STATES, SEARCH = ("adhered", "global"), ("search", "oracle")
LOWEST, ANY = ("global", *SEARCH), (*STATES, "path")
MESH, NODES, BOTH = (False,), (True,), (False, True)


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


def _plane(scene: Scene) -> bool:
    return isinstance(scene.indenter, Plane)


def _disc(scene: Scene) -> bool:
    return scene.axisymmetric and scene.indenter.convex


def _one_disc(scene: Scene) -> bool:
    """Whether about an axis nodes answer: one contact, with one line."""
    return _disc(scene) and scene.pattern is None and not _steep(scene)


def _searched(scene: Scene) -> bool:
    """Whether another state than that of the path may have less energy, but for none."""
    return scene.gamma1 > 0 and scene.work_of_adhesion > 0 and not one_contact(scene)


def _layer(scene: Scene) -> bool:
    return scene.layer.exact


class Row(NamedTuple):
    """Of what and what is asked, of which scenes; what answers, or why nothing does."""

    where: tuple[bool, ...]
    questions: tuple[str, ...]
    applies: Callable[[Scene], bool]
    leads_to: str = ""
    refused: str = ""


_PATH = (
    "opening = {scene.opening!r}, pattern = {scene.pattern!r}: where the line rests depends on the "
    "path; use branch='adhered' with gamma1 > 0 (on the lattice with small slopes), load_path, or "
    "a Scene without it"
)
_ABOUT_AXIS = (
    "geometry = 'axisymmetric': nodes answer one contact around the axis there, of a convex "
    "indenter with slopes = 'small' and no pattern, and no search over contact sets (branch = "
    "'global' only where the line has one stable place, method = 'shortest_path' and 'oracle' "
    "never); use method='fitted'"
)
_NO_LINKS = "gamma1 = 0 leaves no links to search over: use method='fitted' or 'lattice'"
_BENT = (
    "branch = 'global' with slopes = {scene.slopes!r}: of an indenter that is not convex the "
    "lowest energy is only found for slopes='small'"
)
_STEEP_NODES = (
    "slopes = 'finite': nodes only answer states of one contact there, no load paths, and neither "
    "opening = {scene.opening!r} nor pattern = {scene.pattern!r}; use method='fitted'"
)
_SPRINGS_NODES = (
    "gamma1 = 0: nodes answer states of one contact of a convex indenter there, as every spring is "
    "by itself; use method='fitted' for indenter = {scene.indenter!r}"
)
_NODES_PATH = (
    "gamma1 = {scene.gamma1!r}: a load path on the lattice needs gamma1 > 0; without tension every "
    "spring is by itself, and nodes would only add their error: use method='fitted'"
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
_LAYER_GLOBAL = (
    "branch = 'global'"
    + _LAYER
    + "use that branch, or response='springs' for what has least energy"
)
_LAYER_NODES = (
    "method = 'lattice': with response = 'layer' nodes only answer states, no load paths; use "
    "method='fitted'"
)
_BEYOND_LAYER: dict[str, Callable[[Scene], bool]] = {
    "slopes = {scene.slopes!r}": lambda s: s.slopes != "small",
    "gamma1 = {scene.gamma1!r}": lambda s: not s.gamma1,
    "pattern = {scene.pattern!r}": lambda s: s.pattern is not None,
    "indenter = {scene.indenter!r} has no lowest point": _plane,
    "indenter = {scene.indenter!r} is not convex": lambda s: not s.indenter.convex,
    "indenter = {scene.indenter!r} is not mirror-symmetric": lambda s: (
        not s.axisymmetric and s.mirror is None
    ),
}


def _beyond(applies: Callable[[Scene], bool]) -> Callable[[Scene], bool]:
    return lambda scene: _layer(scene) and applies(scene)


TABLE = (
    *(
        Row(BOTH, (*ANY, *SEARCH), _beyond(applies), refused=what + _LAYER + _OTHERWISE)
        for what, applies in _BEYOND_LAYER.items()
    ),
    Row(BOTH, LOWEST, _layer, refused=_LAYER_GLOBAL),
    Row(BOTH, STATES, lambda s: _layer(s) and _held_twice(s), refused=_PATH),
    Row(MESH, ANY, _layer, "layer"),
    Row(NODES, ("path",), _layer, refused=_LAYER_NODES),
    Row(NODES, STATES, _layer, "layer"),
    Row(BOTH, LOWEST, _held_twice, refused=_PATH),
    Row(BOTH, STATES, lambda s: _held_twice(s) and (not s.gamma1 or _plane(s)), refused=_PATH),
    Row(MESH, STATES, _plane, "plane"),
    Row(MESH, ("path",), _plane, refused=_ENDLESS),
    Row(MESH, ANY, lambda s: not s.gamma1, "springs"),
    Row(MESH, STATES, lambda s: one_contact(s) and not _held_twice(s), "one contact"),
    Row(MESH, ("global",), lambda s: _steep(s) and _searched(s) and not _disc(s), refused=_BENT),
    Row(MESH, ANY, lambda s: True, "several contacts"),
    Row(NODES, SEARCH, lambda s: s.axisymmetric, refused=_ABOUT_AXIS),
    Row(NODES, ("global",), lambda s: s.axisymmetric and _searched(s), refused=_ABOUT_AXIS),
    Row(NODES, ANY, lambda s: s.axisymmetric and not _one_disc(s), refused=_ABOUT_AXIS),
    Row(NODES, SEARCH, _steep, refused=_BENT),
    Row(NODES, SEARCH, lambda s: not s.gamma1, refused=_NO_LINKS),
    Row(NODES, SEARCH, lambda s: True, "lowest"),
    Row(NODES, ("path",), lambda s: not s.gamma1, refused=_NODES_PATH),
    Row(NODES, ("path",), _steep, refused=_STEEP_NODES),
    Row(NODES, STATES, _plane, "plane"),
    Row(NODES, STATES, lambda s: _steep(s) and _held_twice(s), refused=_STEEP_NODES),
    Row(NODES, ("global",), lambda s: _steep(s) and _searched(s), refused=_BENT),
    Row(NODES, ANY, _held_twice, "path"),
    Row(NODES, STATES, lambda s: not (s.gamma1 or s.indenter.convex), refused=_SPRINGS_NODES),
    Row(NODES, STATES, lambda s: _steep(s) or not s.gamma1, "plain"),
    Row(NODES, ("global",), lambda s: not s.indenter.convex, "lowest"),
    Row(NODES, STATES, lambda s: not (s.work_of_adhesion or s.indenter.convex), "lowest"),
    Row(NODES, ANY, lambda s: True, "path"),
)


def usable(scene: Scene, rtol: float, method: str, methods: Sequence[str]) -> None:
    """ValueError unless this is a scene, a relative error, and one of the methods."""
    if not isinstance(scene, Scene):
        raise ValueError(f"scene = {scene!r} is not a Scene; build one with energy.Scene(...)")
    option("method", method, methods)
    if not 0 < finite("rtol", rtol) < 1:
        raise ValueError(f"rtol = {rtol!r} is outside (0, 1); give a relative error such as 1e-8")


def question_of(method: str, branch: str) -> str:
    """What is asked of nodes by a method of `minimise`."""
    return {"shortest_path": "search", "oracle": "oracle"}.get(method, branch)


def route(scene: Scene, question: str, *, nodes: bool) -> str:
    """What answers a question of a scene. ValueError where nothing does."""
    for row in TABLE:
        if nodes in row.where and question in row.questions and row.applies(scene):
            if row.refused:
                raise ValueError(row.refused.format(scene=scene))
            return row.leads_to
    raise AssertionError(f"no row for {question!r}")
