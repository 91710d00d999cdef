"""All states of a free line at once, against states and paths that are found one by one."""

import math
from dataclasses import replace

import numpy as np
import pytest

from discretization import load_path, minimise
from discretization.fitted.free_branch import applies, free_branch
from energy import Circle, ElasticLayer, Parabola, PowerLaw, Scene, SurfaceEnergies, Wedge

LINE = Scene(ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(0.07, 6e-5), Parabola(0.02))
SPHERE = Scene(
    ElasticLayer(30e3, 0.45, 0.3e-6),
    SurfaceEnergies.from_work(0.03, 1e-4),
    Parabola(5e-6),
    geometry="axisymmetric",
)
SCENES = {
    "line": LINE,
    "line, finite slopes": replace(LINE, slopes="finite"),
    "sphere": SPHERE,
    "sphere, finite slopes": replace(SPHERE, slopes="finite"),
    "circle": replace(SPHERE, indenter=Circle(5e-6)),
    "power law": replace(SPHERE, indenter=PowerLaw(30.0, 1.5)),
    "weak adhesion": replace(SPHERE, surfaces=SurfaceEnergies.from_work(0.03, 1e-8)),
}
COUNT = 200
DEPTHS = 2.0  # states, and the deepest over δ₀


@pytest.mark.parametrize("name", SCENES)
def test_the_states_are_those_found_one_by_one(name):
    scene = SCENES[name]
    deepest = DEPTHS * scene.critical_separation
    assert applies(scene)
    found = free_branch(scene, deepest, COUNT)
    assert abs(found.depth[-1] - deepest) <= 1e-7 * deepest
    size = np.abs(found.force).max()
    for i in (1, 5, 50, 120, COUNT - 1):
        state = minimise(scene, float(found.depth[i]))
        close = 1e-8 if i == 1 else 1e-11  # beside the fold a depth tells the half-width less well
        assert abs(state.force - found.force[i]) <= close * size
        assert abs(state.half_width - found.half_width[i]) <= close * found.half_width[-1]


@pytest.mark.parametrize("name", SCENES)
def test_the_first_state_is_the_last_of_a_path_that_pulls(name):
    scene = SCENES[name]
    unit = scene.critical_separation
    found = free_branch(scene, DEPTHS * unit, COUNT)
    path = load_path(scene, depths=[0.0, DEPTHS * unit, -1.01 * unit])
    last = path.events[-1].before
    assert len(path.events) == 2
    assert abs(found.depth[0] - last.depth) <= 1e-11 * unit
    size = np.abs(found.force).max()
    assert abs(found.force[0] - last.force) <= 1e-5 * size  # a fold is known to a root


@pytest.mark.parametrize("scale", [1e-6, 1.0, 1e9])
def test_units_do_not_matter(scale):
    layer = ElasticLayer(30e3, 0.45, 0.3e-6 * scale)
    surfaces = SurfaceEnergies.from_work(0.03 * scale, 1e-4 * scale)
    scene = replace(SPHERE, layer=layer, surfaces=surfaces, indenter=Parabola(5e-6 * scale))
    found = free_branch(scene, DEPTHS * scene.critical_separation, COUNT)
    usual = free_branch(SPHERE, DEPTHS * SPHERE.critical_separation, COUNT)
    size = np.abs(usual.force).max()
    np.testing.assert_allclose(found.force / scale**2, usual.force, rtol=0, atol=1e-11 * size)


def test_it_says_where_it_does_not_apply():
    opening = SurfaceEnergies.from_work(0.03, 2e-4)
    others = [
        replace(SPHERE, surfaces=SurfaceEnergies.from_work(0.0, 1e-4)),
        replace(SPHERE, opening=opening),
        replace(SPHERE, indenter=Wedge(math.pi / 2.2)),
        replace(LINE, indenter=Parabola(0.02).tilted(1e-3)),
        replace(SPHERE, layer=replace(SPHERE.layer, response="layer")),
    ]
    assert not any(applies(scene) for scene in others)


def test_beyond_a_known_profile_there_is_none():
    scene = replace(SPHERE, indenter=Circle(0.5e-6))
    assert free_branch(scene, 2e-6, COUNT) is None


def test_free_branch_none_where_force_changes_fast():
    """None where the force changes too fast beside the lowest point."""
    scene = replace(LINE, indenter=PowerLaw(1.0, 1.5))
    assert free_branch(scene, 2e-6, COUNT) is None
