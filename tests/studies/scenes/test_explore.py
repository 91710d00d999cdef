"""The window with sliders shows the state that they say."""

import math

import numpy as np
import pytest
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from support.repository import ROOT

from discretization import minimise
from studies.__main__ import main
from studies.scenes.explore import Explorer
from studies.scenes.file import load

SCENES = ROOT / "studies" / "scenes"


@pytest.mark.parametrize("name", ["hydrogel_cylinder", "silicone_sphere"])
def test_sliders_move_the_state(name):
    given = load(SCENES / f"{name}.toml")
    figure = Figure(figsize=(8, 6))
    canvas = FigureCanvasAgg(figure)
    explorer = Explorer(given.scene, float(given.depths[0]), given.title, figure)
    canvas.draw()
    explorer.sliders["depth"].set_val(0.4 * explorer.sliders["depth"].valmax)
    w = math.log10(given.scene.work_of_adhesion) - 0.3
    explorer.sliders["log₁₀ w"].set_val(w)
    scene, depth = explorer.chosen()
    assert scene.work_of_adhesion == pytest.approx(10**w, rel=1e-12)
    state = minimise(scene, depth)
    drawn = explorer.surface.get_ydata()
    assert np.allclose(drawn, 1e9 * state.displacement(explorer.x), rtol=1e-9, atol=1e-9)
    assert f"{math.degrees(state.contact_angle):.2f}°" in explorer.words.get_text()
    explorer.sliders["depth"].set_val(explorer.sliders["depth"].valmax)
    assert "outside the model" in explorer.words.get_text().replace("\n", " ")
    place = explorer.words.get_window_extent(canvas.get_renderer())
    assert place.x0 > 0 and place.x1 < figure.bbox.x1 and place.y1 < figure.bbox.y1


def test_the_window_can_be_drawn_into_a_file(tmp_path, capsys, monkeypatch):
    """Without a file it needs a display."""
    monkeypatch.setenv("MPLBACKEND", "Agg")
    scene = str(SCENES / "gelatin_wedge.toml")
    picture = tmp_path / "window.png"
    assert main(["explore", scene, "--picture", str(picture)]) == 0
    assert picture.read_bytes().startswith(b"\x89PNG")
    assert main(["explore", scene]) == 2
    assert "--picture" in capsys.readouterr().err
