"""Every tutorial runs as a user runs it, and draws its figure."""

import ast
import os
import re
import subprocess
import sys

import pytest
from support.repository import ROOT

FOLDER = ROOT / "studies" / "tutorials"
SCRIPTS = sorted(path.stem for path in FOLDER.glob("*.py") if path.stem != "__init__")
QUICK = {"loop_and_pull_off"}  # the others take more than 3 s of processor time


def test_every_tutorial_says_what_it_shows():
    assert len(SCRIPTS) >= 6
    assert set(SCRIPTS) >= QUICK
    for name in SCRIPTS:
        words = ast.get_docstring(ast.parse((FOLDER / f"{name}.py").read_text("utf-8")))
        assert words and len(words.splitlines()) > 2, name


@pytest.mark.parametrize(
    "name", [pytest.param(s, marks=[] if s in QUICK else [pytest.mark.slow]) for s in SCRIPTS]
)
def test_a_tutorial_draws_its_figure(name, tmp_path):
    given = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    target = tmp_path / "figure.png"
    command = [sys.executable, str(FOLDER / f"{name}.py"), str(target)]
    done = subprocess.run(command, cwd=tmp_path, env=given, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    assert "Warning" not in done.stderr
    assert target.read_bytes().startswith(b"\x89PNG")
    assert target.stat().st_size > 5000
    assert not [path for path in tmp_path.iterdir() if path != target]


def test_the_figure_has_the_name_of_the_script(tmp_path):
    """Without an argument."""
    given = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    script = FOLDER / "loop_and_pull_off.py"
    done = subprocess.run(
        [sys.executable, str(script)], cwd=tmp_path, env=given, capture_output=True
    )
    assert done.returncode == 0, done.stderr
    assert [path.name for path in tmp_path.iterdir()] == ["loop_and_pull_off.png"]


@pytest.mark.slow
def test_a_raw_deflection_ends_in_a_sentence(tmp_path):
    """From volts to energies that hold what the file was simulated with: 0.1 and 30 mJ/m²."""
    given = {**os.environ, "PYTHONPATH": str(ROOT), "MPLBACKEND": "Agg"}
    command = [sys.executable, str(FOLDER / "fit_raw_deflection.py"), str(tmp_path / "a.png")]
    done = subprocess.run(command, cwd=tmp_path, env=given, capture_output=True, text=True)
    assert "left out: 1 point, off their neighbours" in done.stdout
    sentence = done.stdout.splitlines()[-1]
    form = r"w = (\S+) ± (\S+) mJ/m² and γ₁ = (\S+) ± (\S+) mJ/m², both at 95 %"
    w, w_half, gamma1, gamma1_half = map(float, re.fullmatch(form, sentence).groups())
    assert abs(w - 0.1) < w_half < 0.02
    assert abs(gamma1 - 30) < gamma1_half < 10
