"""Scene files with rotational symmetry: run, sweep and fit, with forces in newtons."""

import numpy as np
import pytest

from discretization import load_path, minimise
from energy import ElasticLayer, Parabola, Scene, SurfaceEnergies
from studies.__main__ import main
from studies.shared.table import read

BALL = """title = "Ball"
depth = [2e-7, -1e-7, -4e-7]
[layer]
E = 2.5e3
nu = 0.3
h = 5e-6
[surfaces]
gamma1 = 0.07
w = 6e-5
[indenter]
shape = "parabola"
R = 0.02
[path]
depths = [-1e-7, 3e-7, -5e-7]
steps = 10
[options]
geometry = "axisymmetric"
"""


def scene_of(gamma1=0.07, w=6e-5):
    layer, surfaces = ElasticLayer(2.5e3, 0.3, 5e-6), SurfaceEnergies.from_work(gamma1, w)
    return Scene(layer, surfaces, Parabola(0.02), geometry="axisymmetric")


@pytest.fixture
def ball(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "ball.toml").write_text(BALL)
    return tmp_path


def test_states_and_path_of_a_ball_are_in_newtons(ball, capsys):
    assert main(["run", "ball.toml", "--out", ".", "--jobs", "1"]) == 0
    said = capsys.readouterr().out
    for text in (
        "radius/m      force/N     energy/J",
        "force/N        lost/J",
        " N at d = ",
        " J\n",
    ):
        assert text in said
    assert "N/m" not in said
    rows = read(ball / "ball.csv")
    assert float(rows[0]["force"]) == minimise(scene_of(), 2e-7).force
    assert rows[2]["label"] == "detached"
    head = (ball / "ball.csv").read_text("utf-8")
    assert "whole contact, half_width the radius" in head and "force in N, energy in J," in head


def test_a_sweep_of_a_ball(ball):
    text = BALL.replace("depth = [2e-7, -1e-7, -4e-7]\n", "").replace("6e-5", "[4e-5, 6e-5]")
    (ball / "many.toml").write_text(text)
    assert main(["sweep", "many.toml", "--out", ".", "--jobs", "1"]) == 0
    table = ball / "many_sweep.csv"
    assert "of the whole contact: lengths in m, forces in N, energies in J," in table.read_text(
        "utf-8"
    )
    path = load_path(scene_of(), depths=[-1e-7, 3e-7, -5e-7])
    pulls = [float(row["pull_off_force"]) for row in read(table)]
    assert pulls[1] == pytest.approx(path.pull_off.force, rel=1e-3)
    assert pulls[1] < pulls[0] < 0


def test_a_fit_finds_what_a_ball_was_pulled_off_with(ball, capsys):
    depths = np.r_[np.linspace(-1e-7, 4e-7, 40), np.linspace(4e-7, -5e-7, 60)]
    force = np.nan_to_num(load_path(scene_of(0.06, 7e-5), depths=depths).force)
    force += 3e-8 * np.random.default_rng(1).standard_normal(depths.size)
    rows = [f"{1e6 * d:.6f},{1e6 * p:.6f}" for d, p in zip(depths, force, strict=True)]
    (ball / "data.csv").write_text("\n".join(["depth [µm],force [µN]", *rows]), "utf-8")
    asked = ["fit", "data.csv", "--scene", "ball.toml", "--quick", "--out", "."]
    assert main(asked) == 0
    said = capsys.readouterr().out
    found = {line.split()[0]: float(line.split()[1]) for line in said.splitlines()[1:3]}
    assert found["w"] == pytest.approx(7e-5, rel=0.01)
    assert found["gamma1"] == pytest.approx(0.06, rel=0.1)
    assert "residual" in said and " N, " in said
    assert set(read(ball / "data_fit.csv")[0]) >= {"force [N]", "fitted [N]"}
    assert main([*asked, "--width", "0.1"]) == 2
    assert "width = 0.1 with geometry = 'axisymmetric'" in capsys.readouterr().err
