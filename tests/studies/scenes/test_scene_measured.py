"""Scene files and options that say how a measured curve or profile is read."""

import re

import numpy as np
import pytest
from measured_curves import SCENE, measured

from studies import __main__ as command_line
from studies.scenes.file import load

SCENE_FILE = """
depth = 0
[layer]
E = 50.0
nu = 0.45
h = 5e-6
[surfaces]
gamma1 = 0.1
w = 1.5e-6
[indenter]
shape = "parabola"
R = 0.05
[measured]
columns = ["Weg [µm]", "2 [mN]"]
width = 0.01
skip = 1
"""


def test_scene_files_and_options_say_how_a_curve_is_read(tmp_path, capsys):
    scene, data = tmp_path / "scene.toml", tmp_path / "kurve.csv"
    scene.write_text(SCENE_FILE, "utf-8")
    curve = measured(SCENE, [-1.1, 1.1, -1.1], 0.01)
    rows = [f"{1e6 * d:.9f};{1e3 * 0.01 * p:.9f}" for d, p in zip(*curve, strict=True)]
    data.write_text("1;2\nWeg;Kraft\n" + "\n".join(rows).replace(".", ","), "utf-8")
    arguments = ["fit", str(data), "--scene", str(scene), "--out", str(tmp_path), "--quick"]
    assert command_line.main(arguments) == 0
    assert "not sought" in capsys.readouterr().out
    lines = (tmp_path / "kurve_fit.csv").read_text("utf-8").splitlines()
    table = np.array([row.split(",") for row in lines if not row.startswith(("#", "d"))], float)
    assert table[:, 0] == pytest.approx(curve.depth, abs=1e-15)
    assert table[:, 1] == pytest.approx(curve.force, abs=1e-10)
    for given, told in (
        (["--columns", "Zug [m]", "2 [mN]"], "no column 'Zug'"),
        (["--width", "-1"], "width = -1.0 must be positive"),
        (["--skip", "400"], "no line has two numbers"),
        (["--decimal", "."], "line 2: 1 cell|no line has two numbers|must be a finite number"),
        (["--encoding", "utf-16"], "is no text in utf-16|no line has two numbers"),
        (["--delimiter", "tab"], "no line has two numbers"),
        (["--curve", "2"], "curve = 2: text has one"),
    ):
        assert command_line.main([*arguments, *given]) == 2
        assert re.search(told, capsys.readouterr().err), given


def test_wrong_tables_of_measured_data_are_refused(tmp_path):
    path = tmp_path / "scene.toml"
    for old, new, told in (
        ("skip = 1", "skip = -1", "measured.skip = -1 must be a whole number"),
        ("skip = 1", 'decimal = "x"', "measured.decimal = 'x' is unknown"),
        ("width = 0.01", "width = 0", "measured.width = 0.0 must be positive"),
        ('"2 [mN]"', "", "measured.columns = .* must be a list of two"),
        ("skip = 1", "lines = 1", "measured.lines = 1 is unknown"),
    ):
        path.write_text(SCENE_FILE.replace(old, new), "utf-8")
        with pytest.raises(ValueError, match=f"{re.escape(str(path))}: {told}"):
            load(path)


def test_a_scene_file_takes_a_profile_from_a_file(tmp_path):
    path, body = tmp_path / "scene.toml", 'shape = "sampled"\nfile = "scan.csv"\nkind = "smooth"'
    x = np.linspace(-1, 1, 9)
    rows = "\n".join(f"{a:.4f};{500 * a * a:.4f}" for a in x).replace(".", ",")
    (tmp_path / "scan.csv").write_text(f"Profil\nlateral;up\n{rows}\n", "utf-8")
    text = SCENE_FILE[: SCENE_FILE.index("[measured]")]
    old = 'shape = "parabola"\nR = 0.05'
    path.write_text(text.replace(old, f'{body}\ncolumns = ["lateral [mm]", "2 [nm]"]'), "utf-8")
    indenter = load(path).scene.indenter
    assert indenter.kind == "smooth"
    assert indenter.x == pytest.approx(1e-3 * x, abs=1e-18)
    assert indenter.z == pytest.approx(500e-9 * x**2, abs=1e-20)
    for extra, told in (
        ("x = [1.0]", r"indenter.x = \[1.0\] stands beside file"),
        ("skip = 40", "indenter.*no line has two numbers"),
        ('columns = "x"', "indenter.columns = 'x' must be a list of two"),
    ):
        path.write_text(text.replace(old, f"{body}\n{extra}"), "utf-8")
        with pytest.raises(ValueError, match=told):
            load(path)
    path.write_text(text.replace(old, 'shape = "sampled"\nunit = 1e-3\nx = [0]\nz = [0]'), "utf-8")
    with pytest.raises(ValueError, match=r"indenter\.unit = 0\.001 needs file"):
        load(path)
