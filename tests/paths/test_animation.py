"""Load paths that move: what is drawn is the surface of each state."""

import numpy as np
import pytest
from PIL import Image
from support.example_scenes import rippled

from discretization import animation, load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies, Wedge

LAYER = ElasticLayer(2.5e3, 0.3, 5e-6)
EXACT = ElasticLayer(2.5e3, 0.45, 5e-6, response="layer")
SURFACES = SurfaceEnergies.from_work(0.07, 6e-5)
CASES = {
    "line": Scene(LAYER, SURFACES, Parabola(0.02)),
    "tilted": Scene(LAYER, SURFACES, Wedge(0.02).tilted(0.005)),
    "axis": Scene(LAYER, SURFACES, Parabola(0.02), geometry="axisymmetric"),
    "true lengths": Scene(LAYER, SURFACES, Parabola(0.02), slopes="finite"),
    "springs": Scene(LAYER, SurfaceEnergies.from_work(0.0, 6e-5), Parabola(0.02)),
    "layer": Scene(EXACT, SURFACES, Parabola(0.02)),
}


@pytest.mark.parametrize("name", CASES)
def test_the_surface_drawn_is_that_of_the_state(name):
    scene = CASES[name]
    path = load_path(scene, depths=[0.0, 2e-7, 3e-7])
    x = np.linspace(-3e-4, 3e-4, 101)
    drawn = animation.displacement(path, path.at(2), x)
    exact = minimise(scene, 3e-7).displacement(x)
    assert np.abs(drawn - exact).max() < 1e-6 * np.abs(exact).max()


def test_gaps_between_contacts_are_drawn_too():
    little = SurfaceEnergies.from_work(0.07, 6e-6)
    scene = Scene(LAYER, little, rippled(0.02, 1e-4, 4e-7))
    path = load_path(scene, depths=[0.0, 5e-7])
    assert len(path.at(1).lines) > 2
    x = np.linspace(-8e-4, 8e-4, 301)
    exact = minimise(scene, 5e-7).displacement(x)
    drawn = animation.displacement(path, path.at(1), x)
    assert np.abs(drawn - exact).max() < 1e-6 * np.abs(exact).max()


def test_a_loop_is_written_with_its_jumps_drawn_slowly(tmp_path):
    depths = np.r_[np.linspace(-1e-7, 3e-7, 30), np.linspace(3e-7, -6e-7, 50)]
    path = load_path(CASES["line"], depths=depths)
    assert [event.kind for event in path.events] == ["jump-in", "detachment"]
    written = path.animate(tmp_path / "loop.gif", frames=10, rate=5)
    with Image.open(written) as image:
        assert (
            image.n_frames >= 10 + 2 * animation._FILM.jump_frames - 6
            and image.info["duration"] == 200
        )
    x = np.linspace(-2e-4, 2e-4, 41)
    frames = animation._frames(path, x, 10)
    slow = [frame for frame in frames if frame.jump]
    assert len(slow) == 2 * animation._FILM.jump_frames
    assert not slow[0].surface.any() and slow[animation._FILM.jump_frames - 1].surface.any()


def test_what_cannot_be_animated_is_refused(tmp_path):
    """Before anything is drawn."""
    path = load_path(CASES["line"], depths=[-2e-6, -1e-6])
    with pytest.raises(ValueError, match="no state in contact"):
        path.animate(tmp_path / "none.gif")
    pressed = load_path(CASES["line"], depths=[0.0, 1e-7])
    with pytest.raises(ValueError, match="frames = 1"):
        pressed.animate(tmp_path / "few.gif", frames=1)
    assert not list(tmp_path.iterdir())
