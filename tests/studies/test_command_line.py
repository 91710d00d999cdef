"""The command line of the studies: the list, bad scenes in one line, no import too many."""

import importlib
import subprocess
import sys

import pytest
from project import ROOT
from scene_files import writer

from studies import MODULES
from studies import __main__ as command_line


@pytest.fixture
def written(tmp_path):
    return writer(tmp_path / "tiny.toml")


def studies(*arguments):
    command = [sys.executable, "-W", "error", "-m", "studies", *arguments]
    return subprocess.run(command, capture_output=True, text=True, cwd=ROOT, check=False)


def test_the_list_has_one_line_for_each_study():
    ran = studies()
    assert ran.returncode == 0
    assert ran.stderr == ""
    assert set(command_line.STUDIES) >= {"run", "verify", "speed"}
    for name in command_line.STUDIES:
        (line,) = [line for line in ran.stdout.splitlines() if line.split()[:1] == [name]]
        doc = importlib.import_module(MODULES[name]).__doc__
        assert line.endswith(doc.splitlines()[0])


def test_an_unknown_study_is_answered_with_the_known_ones():
    ran = studies("dance")
    assert (ran.returncode, ran.stdout) == (2, "")
    assert "'dance'" in ran.stderr
    assert all(name in ran.stderr for name in command_line.STUDIES)
    assert len(ran.stderr.splitlines()) == 1


def test_a_bad_scene_is_one_line_and_status_2(written, tmp_path):
    path = written(("h = 60e-6", 'h = "1 mm"'))
    ran = studies("run", str(path), "--out", str(tmp_path))
    assert (ran.returncode, ran.stdout) == (2, "")
    assert len(ran.stderr.splitlines()) == 1
    assert f"{path}: layer.h = '1 mm'" in ran.stderr
    assert not (tmp_path / "tiny.csv").exists()


def test_a_folder_that_cannot_be_made_is_one_line_and_status_2(written, tmp_path, capsys):
    (tmp_path / "taken").write_text("")
    arguments = ["run", str(written()), "--out", str(tmp_path / "taken")]
    assert command_line.main(arguments) == 2
    assert len(capsys.readouterr().err.splitlines()) == 1


def test_the_list_costs_no_matplotlib():
    code = "import sys; from studies.__main__ import main; main([]); print(*sys.modules)"
    ran = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, cwd=ROOT, check=True
    )
    assert "studies" in ran.stdout.split()
    assert "matplotlib" not in ran.stdout.split()
