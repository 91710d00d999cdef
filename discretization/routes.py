"""Which question of which scene leads where, or why it is refused: the one table that decides.

Questions are the two branches of `minimise`, "adhered" and "global", the "search" for the lowest
contacts by a method of its own or by the "oracle", and the load "path"; they are asked of the
fitted mesh or of nodes.
The first row that applies decides.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from energy import Circle, FlatPunch, Parabola, Plane, PowerLaw, Scene, Wedge

# turned about an axis, of these the line has one stable place (fitted/single_lines.py)
UNIMODAL = (Parabola, Wedge, PowerLaw, FlatPunch, Circle)
STATES, ANY = ("adhered", "global"), ("adhered", "global", "path")
SEARCH = ("search", "oracle")
LOWEST, ALL = ("global", *SEARCH), (*ANY, *SEARCH)


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


def _alone(scene: Scene) -> bool:
    return scene.indenter.convex and scene.pattern is None


def _discs(scene: Scene) -> bool:
    return scene.axisymmetric and scene.indenter.convex


def _searched(scene: Scene) -> bool:
    """Whether another state than that of the path may have less energy, but for none."""
    return scene.gamma1 > 0 and scene.work_of_adhesion > 0 and not one_contact(scene)


class Row(NamedTuple):
    """Where and what is asked, of which scenes; what answers, or why nothing does."""

    nodes: bool
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
    "geometry = 'axisymmetric': nodes do not know slopes = 'finite', gamma1 = 0 with a profile that"
    " is not convex or with method = 'shortest_path', or method = 'oracle'; use method='fitted'"
)
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

TABLE = (
    # on the fitted mesh
    Row(False, STATES, lambda s: _held_twice(s) and (not s.gamma1 or _plane(s)), refused=_PATH),
    Row(False, ("global",), _held_twice, refused=_PATH),
    Row(False, STATES, lambda s: _plane(s), "plane"),
    Row(False, ("path",), lambda s: _plane(s), refused=_ENDLESS),
    Row(False, ANY, lambda s: not s.gamma1, "springs"),
    Row(False, STATES, lambda s: one_contact(s) and not _held_twice(s), "one contact"),
    Row(False, ("adhered", "path"), lambda s: True, "several contacts"),
    Row(False, ("global",), lambda s: not s.work_of_adhesion, "several contacts"),
    Row(False, ("global",), lambda s: _steep(s) and not _discs(s), refused=_BENT),
    Row(False, ("global",), lambda s: True, "several contacts"),
    # on nodes
    Row(
        True,
        (*LOWEST, "adhered"),
        lambda s: _held_twice(s) and (not s.gamma1 or _plane(s)),
        refused=_PATH,
    ),
    Row(True, LOWEST, _held_twice, refused=_PATH),
    Row(True, ALL, lambda s: s.axisymmetric and _steep(s), refused=_ABOUT_AXIS),
    Row(True, SEARCH, lambda s: s.axisymmetric and not s.gamma1, refused=_ABOUT_AXIS),
    Row(True, ("oracle",), lambda s: s.axisymmetric, refused=_ABOUT_AXIS),
    Row(True, ANY, lambda s: s.axisymmetric and not (_alone(s) or s.gamma1), refused=_ABOUT_AXIS),
    Row(True, SEARCH, lambda s: True, "lowest"),
    Row(True, ("global",), lambda s: s.axisymmetric and _searched(s), "lowest"),
    Row(True, STATES, lambda s: s.axisymmetric and not s.indenter.convex, "path"),
    Row(True, ("path",), lambda s: not s.gamma1, refused=_NODES_PATH),
    Row(True, ("path",), _steep, refused=_STEEP_NODES),
    Row(True, ("path",), lambda s: True, "path"),
    Row(True, STATES, lambda s: _plane(s), "plane"),
    Row(True, STATES, lambda s: _steep(s) and _held_twice(s), refused=_STEEP_NODES),
    Row(True, ("global",), lambda s: _steep(s) and _searched(s), refused=_BENT),
    Row(True, STATES, _held_twice, "path"),
    Row(True, STATES, lambda s: not (s.gamma1 or s.indenter.convex), refused=_SPRINGS_NODES),
    Row(True, STATES, lambda s: _steep(s) or not s.gamma1, "plain"),
    Row(True, STATES, lambda s: s.indenter.convex, "path"),
    Row(True, ("global",), lambda s: s.work_of_adhesion > 0, "lowest"),
    Row(True, STATES, lambda s: not s.work_of_adhesion, "lowest"),
    Row(True, STATES, lambda s: True, "path"),
)


def _plane(scene: Scene) -> bool:
    return isinstance(scene.indenter, Plane)


def question_of(method: str, branch: str) -> str:
    """What is asked of nodes by a method of `minimise`."""
    return {"shortest_path": "search", "oracle": "oracle"}.get(method, branch)


def route(scene: Scene, question: str, *, nodes: bool) -> str:
    """What answers a question of a scene. ValueError where nothing does."""
    for row in TABLE:
        if row.nodes == nodes and question in row.questions and row.applies(scene):
            if row.refused:
                raise ValueError(row.refused.format(scene=scene))
            return row.leads_to
    raise AssertionError(f"no row for {question!r}")
