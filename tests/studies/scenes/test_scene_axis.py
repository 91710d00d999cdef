"""Scene files with rotational symmetry: units of whole contacts, sweeps, paths, fits."""

import numpy as np
import pytest

from discretization import load_path
from studies.scenes import run
from studies.scenes.file import load
from studies.scenes.fit import study as fit

SCENE = """
title = "A sphere"
source = "here"
{depth}
[layer]
E = 2.5e3
nu = 0.3
h = 5e-6
[surfaces]
gamma1 = 0.07
w = {work}
[indenter]
shape = "parabola"
R = 0.02
{path}
[options]
geometry = "axisymmetric"
"""


@pytest.fixture
def written(tmp_path):
    def write(depth="depth = [3e-7, 0.0]", work="6e-5", path=""):
        file = tmp_path / "sphere.toml"
        file.write_text(SCENE.format(depth=depth, work=work, path=path), "utf-8")
        return file

    return write


def test_states_are_told_and_written_in_newtons(written, tmp_path, capsys):
    assert run.main([str(written()), "--out", str(tmp_path)]) == 0
    said, table = capsys.readouterr().out, (tmp_path / "sphere.csv").read_text("utf-8")
    assert "force/N     energy/J " in said and "N/m" not in said
    assert "force in N, energy in J," in table and "N/m" not in table


def test_a_sweep_and_a_path_are_in_newtons(written, tmp_path, capsys):
    swept = written("depth = 1e-7", "[5e-5, 6e-5, 7e-5]")
    assert run.main([str(swept), "--out", str(tmp_path), "--jobs", "1"]) == 0
    assert "forces in N, energies in J" in (tmp_path / "sphere_sweep.csv").read_text("utf-8")
    capsys.readouterr()
    path = written("", path="[path]\ndepths = [0.0, 3e-7, -6e-7]\nsteps = 10\n")
    assert run.main([str(path), "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "force/N        lost/J" in said and " N at d = " in said and "N/m" not in said


def test_a_fit_finds_what_a_sphere_was_simulated_with(written, tmp_path, capsys):
    path = load_path(load(written()).scene, depths=np.linspace(0, 4e-7, 30))
    data = tmp_path / "data.csv"
    rows = np.column_stack([path.depth, 1e6 * path.force])
    np.savetxt(
        data, rows, delimiter=",", header="depth [m],force [µN]", comments="", encoding="utf-8"
    )
    start = written(work="5e-5")
    asked = [
        str(data),
        "--scene",
        str(start),
        "--parameters",
        "w",
        "--quick",
        "--out",
        str(tmp_path),
    ]
    assert fit.main(asked) == 0
    row = next(line for line in capsys.readouterr().out.splitlines() if line.startswith("w "))
    assert float(row.split()[1]) == pytest.approx(6e-5, rel=1e-4)
    with pytest.raises(ValueError, match=r"width = 0.01 with geometry = 'axisymmetric': leave it"):
        fit.main([*asked, "--width", "0.01"])
