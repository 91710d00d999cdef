"""All states of the free line of a layer at once, against states and paths found one by one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from discretization import load_path, minimise
from discretization.layer.free_branch import applies, free_branch
from energy import Circle, ElasticLayer, Parabola, Scene, SurfaceEnergies, Wedge

RTOL = 1e-4
COUNT = 200
LINE = Scene(
    ElasticLayer(2.5e3, 0.3, 5e-6, response="layer"),
    SurfaceEnergies.from_work(0.07, 6e-5),
    Parabola(0.02),
)
SPHERE = Scene(
    ElasticLayer(30e3, 0.45, 0.3e-6, response="layer"),
    SurfaceEnergies.from_work(0.03, 1e-4),
    Parabola(5e-6),
    geometry="axisymmetric",
)
SCENES = {
    "line": (LINE, 1e-6),
    "line, thick": (replace(LINE, layer=replace(LINE.layer, h=5e-4, nu=0.49)), 2e-6),
    "sphere": (SPHERE, 4e-7),
    "sphere, thick": (replace(SPHERE, layer=replace(SPHERE.layer, h=20e-6, nu=0.49)), 1e-6),
    "circle, nearly incompressible": (
        replace(SPHERE, indenter=Circle(5e-6), layer=replace(SPHERE.layer, nu=0.49)),
        4e-7,
    ),
}


@pytest.mark.parametrize("name", SCENES)
def test_the_states_are_those_found_one_by_one(name):
    scene, deepest = SCENES[name]
    assert applies(scene)
    found = free_branch(scene, deepest, COUNT, RTOL)
    size = np.abs(found.force).max()
    assert abs(found.depth[-1] - deepest) <= 1e-6 * deepest
    for i in (60, 120, COUNT - 1):
        state = minimise(scene, float(found.depth[i]), rtol=1e-6)
        assert abs(state.force - found.force[i]) <= RTOL * size
        assert abs(state.half_width - found.half_width[i]) <= RTOL * found.half_width[-1]


@pytest.mark.parametrize("name", SCENES)
def test_the_first_state_is_the_last_of_a_path_that_pulls(name):
    scene, deepest = SCENES[name]
    found = free_branch(scene, deepest, COUNT, RTOL)
    path = load_path(scene, depths=[0.0, deepest, -deepest, -3 * deepest], rtol=RTOL)
    assert len(path.events) == 2
    last = path.events[-1].before
    assert abs(found.depth[0] - last.depth) <= RTOL * deepest
    assert abs(found.force[0] - last.force) <= 1e-2 * np.abs(found.force).max()  # on a fold


def test_it_says_where_it_does_not_apply():
    others = [
        replace(SPHERE, layer=replace(SPHERE.layer, response="springs")),
        replace(SPHERE, opening=SurfaceEnergies.from_work(0.03, 2e-4)),
        replace(SPHERE, indenter=Wedge(math.pi / 2.2)),
        replace(LINE, indenter=Parabola(0.02).tilted(1e-3)),
    ]
    assert not any(applies(scene) for scene in others)


def test_none_where_polynomials_do_not_tell():
    """The elastocapillary length is 1/40 of the thickness."""
    scene = replace(LINE, surfaces=SurfaceEnergies.from_work(1e-5, 6e-5))
    assert free_branch(scene, 2e-6, COUNT, RTOL) is None


def test_beyond_a_known_profile_there_is_none():
    scene = replace(SPHERE, indenter=Circle(0.5e-6))
    assert free_branch(scene, 2e-6, COUNT, RTOL) is None
