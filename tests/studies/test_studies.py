"""What all studies share: options, figures, tables that say how they were made."""

import importlib
import json
import math
import shlex
import sys
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from support.scene_files import DEPTH, SURFACES, writer

from energy.units import prefixed
from studies import GROUPS, MODULES, TIMED, rough, sphere
from studies import __main__ as command_line
from studies.shared import table
from studies.shared.table import read

WINDOWS = ("new", "explore")  # the first writes a scene to edit, the second opens a window
STUDIES = [name for name in command_line.STUDIES if name not in WINDOWS]
FAST = {  # its words, and the rows of its tables; two more are in the test of the report
    "stress": (["stress", "--grids", "fitted", "lattice", "nodes"], 167),
    "rough": (["rough"], 60),
    "sweep": (["sweep", "scene.toml"], 4),
    "run": (["run", "one.toml"], 2),
}


@pytest.mark.parametrize("name", STUDIES)
def test_every_study_has_the_common_options(name, capsys):
    with pytest.raises(SystemExit) as caught:
        command_line.main([name, "-h"])
    assert caught.value.code == 0
    told = capsys.readouterr().out
    assert "--preset {quick,full}" in told
    assert "--out DIR" in told
    assert "--jobs N" in told
    with pytest.raises(SystemExit):
        command_line.main([name, "--preset", "tiny"])
    assert "choose from" in capsys.readouterr().err


@pytest.mark.parametrize("name", STUDIES)
def test_no_study_writes_tables_and_figures_by_itself(name):
    text = Path(importlib.import_module(MODULES[name]).__file__).read_text("utf-8")
    for own in ("csv.writer", "savefig", "ArgumentParser", "ProcessPoolExecutor", "sys.argv"):
        assert own not in text, own


@pytest.mark.parametrize("name", TIMED)
def test_studies_that_measure_times_refuse_company(name, capsys):
    with pytest.raises(SystemExit):
        command_line.main([name, "--jobs", "2"])
    assert "would disturb the times" in capsys.readouterr().err


def test_folder_that_cannot_be_written_raises(tmp_path, capsys):
    """A folder that cannot be written is refused before any work."""
    (tmp_path / "file").write_text("", "utf-8")
    for where in ("file", "file/below"):
        given = ["stress", "--quick", "--out", str(tmp_path / where)]
        assert command_line.main(given) == 2
        said = capsys.readouterr()
        assert said.err.count("\n") == 1
        assert "no folder to write to; give another" in said.err


def test_no_jobs_are_refused(capsys):
    for text in ("0", "-1", "two"):
        with pytest.raises(SystemExit):
            command_line.main(["pull_off", f"--jobs={text}"])
        assert f"{text!r} is not a number of processes" in capsys.readouterr().err


@pytest.mark.slow
@pytest.mark.parametrize("name", FAST)
def test_quick_study_leaves_figure_and_table(name, tmp_path, monkeypatch):
    """A quick study leaves a picture and a table that says how."""
    monkeypatch.chdir(tmp_path)
    depths = (DEPTH, "depth = [1e-6, 0.0]")
    writer(tmp_path / "scene.toml")(depths, (SURFACES, "w = [1e-4, 2e-4]"))
    writer(tmp_path / "one.toml")(depths)
    words, *rows = FAST[name]
    short = lambda p, *how, run=rough.run: run(replace(p, tensions=(0.25,)), *how)  # noqa: E731
    monkeypatch.setattr(rough, "run", short)
    arguments = [*words, "--preset", "quick", "--jobs", "1", "--out", "out"]
    assert command_line.main(arguments) == 0
    pictures = sorted((tmp_path / "out").glob("*.png"))
    assert pictures
    assert not any((tmp_path / "out").glob("*.pdf"))
    assert all(picture.read_bytes().startswith(b"\x89PNG") for picture in pictures)
    tables = sorted((tmp_path / "out").glob("*.csv"))
    for one, count in zip(tables, rows, strict=True):
        head = [line[2:] for line in one.read_text("utf-8").splitlines() if line[0] == "#"]
        said = dict(line.split(": ", 1) for line in head if ": " in line)
        assert said["command"] == shlex.join(["python", "-m", "studies", *arguments])
        assert said["commit"] == table.commit()
        assert "numpy" in said["versions"]
        assert "elastocap" in said["versions"]
        assert len(said["parameters"]) > 1
        assert len(table.read(one)) == count


@pytest.mark.slow
def test_the_command_of_a_table_makes_it_again(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(sphere, "QUICK", sphere.Parameters((0.1, 1.0), (1.0,), (0.1,)))
    path = tmp_path / "out" / "sphere.csv"
    command_line.main(["sphere", "--quick", "--jobs", "1", "--out", "out"])
    first = path.read_bytes()
    words = shlex.split(first.decode("utf-8").splitlines()[0].removeprefix("# command: "))
    assert words[:3] == ["python", "-m", "studies"]
    path.unlink()
    assert command_line.main(words[3:]) == 0
    assert path.read_bytes() == first  # to the last bit, header and all


def test_a_table_is_read_as_it_was_written(tmp_path):
    path = tmp_path / "a.csv"
    table.write(path, ["note: two\nlines"], ["x", "text"], [[0.1 + 0.2, "a, b"], [math.inf, ""]])
    assert path.read_text("utf-8").startswith("# note: two lines\nx,text\n")
    first, second = table.read(path)
    assert float(first["x"]) == 0.1 + 0.2
    assert first["text"] == "a, b"
    assert float(second["x"]) == math.inf


def test_another_repository_around_the_package_is_not_ours(tmp_path, monkeypatch):
    monkeypatch.setattr(table, "__file__", str(tmp_path / "table.py"))
    for version, told in (
        (table.SOURCE, "unknown"),
        ("0.1.0", "not recorded, version 0.1.0 as installed"),
    ):
        monkeypatch.setattr(table, "versions", lambda version=version: {"elastocap": version})
        table.commit.cache_clear()
        assert table.commit() == told
    table.commit.cache_clear()


def test_the_commit_that_pip_has_installed_is_known(monkeypatch):
    class Installed:
        def read_text(self, name):
            assert name == "direct_url.json"
            return '{"url": "https://x.org/e.git", "vcs_info": {"commit_id": "0123456789abcdef"}}'

    monkeypatch.setattr(table.importlib.metadata, "distribution", lambda name: Installed())
    assert table.recorded_commit() == "0123456789ab"


@pytest.mark.parametrize(
    ("values", "unit", "size", "symbol"),
    [
        (3.2e-6, "m", 1e-6, "µm"),
        ([1e-3, -2.0], "N/m", 1.0, "N/m"),
        ([-0.4, 0.1], "N/m", 1e-3, "mN/m"),
        (1e-3, "m", 1e-3, "mm"),
        (999.0, "Pa", 1.0, "Pa"),
        (1e3, "Pa", 1e3, "kPa"),
        ([0.0, np.nan, np.inf], "m", 1.0, "m"),
        (1e-30, "m", 1e-12, "pm"),
    ],
)
def test_prefix_puts_the_largest_number_between_1_and_1000(values, unit, size, symbol):
    chosen = prefixed(values, unit)
    assert chosen.symbol == symbol
    assert chosen.size == pytest.approx(size, rel=1e-13, abs=0)


@pytest.fixture
def inside(tmp_path, monkeypatch):
    """A working directory of its own; what it imports is forgotten afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])
    yield tmp_path
    sys.modules.pop("mine", None)


@pytest.mark.slow
def test_the_template_runs_at_once_in_any_number_of_processes(inside, capsys):
    assert command_line.main(["new", "--study", "mine.py"]) == 0
    assert "python -m studies mine.py" in capsys.readouterr().out
    for jobs in ("1", "2"):
        given = ["mine.py", "--preset", "quick", "--jobs", jobs, "--out", jobs]
        assert command_line.main(given) == 0
        assert "2 scenes, largest relative error" in capsys.readouterr().out
        assert (inside / jobs / "half_width.png").read_bytes().startswith(b"\x89PNG")
    rows = [read(inside / jobs / "half_width.csv") for jobs in ("1", "2")]
    assert rows[0] == rows[1]
    assert len(rows[0]) == 2
    head = (inside / "2" / "half_width.csv").read_text("utf-8").splitlines()[0]
    assert head == "# command: python -m studies mine.py --preset quick --jobs 2 --out 2"


def test_the_template_is_not_written_over_another_file(inside, capsys):
    (inside / "mine.py").write_text("mine", "utf-8")
    for name, told in (("mine.py", "exists; give another name"), ("mine.txt", "must end in .py")):
        assert command_line.main(["new", "--study", name]) == 2
        assert told in capsys.readouterr().err
    assert (inside / "mine.py").read_text("utf-8") == "mine"


def test_a_study_that_fails_says_so_by_its_status(inside, capsys):
    assert command_line.main(["new", "--study", "mine.py"]) == 0
    text = (inside / "mine.py").read_text("utf-8").replace("abs(a / ", "abs(2 * a / ")
    (inside / "mine.py").write_text(text, "utf-8")
    capsys.readouterr()
    assert command_line.main(["mine.py", "--quick", "--jobs", "1", "--quiet"]) == 1
    assert capsys.readouterr().out.startswith("2 scenes, largest relative error")


@pytest.mark.parametrize(
    ("name", "text", "told"),
    [
        ("none.py", None, "no such file; `python -m studies new --study none.py` writes it"),
        ("json.py", "main = print", "another module is named json; rename the file"),
        ("mine.py", "x = 1", "has no function main"),
    ],
)
def test_what_is_no_study_is_refused_in_one_line(inside, capsys, name, text, told):
    if text is not None:
        (inside / name).write_text(text, "utf-8")
    assert command_line.main([name]) == 2
    said = capsys.readouterr().err
    assert told in said
    assert said.count("\n") == 1


def test_the_version_is_told(capsys):
    assert command_line.main(["--version"]) == 0
    name, version = capsys.readouterr().out.split(maxsplit=1)
    assert name == "elastocap"
    assert version.strip()


def test_everything_is_listed_once_in_its_group(capsys, monkeypatch):
    named = [name for names in GROUPS.values() for name in names]
    assert sorted(named) == sorted(MODULES)
    monkeypatch.setattr(sys, "argv", ["/somewhere/bin/elastocap"])
    assert command_line.main([]) == 0
    said = capsys.readouterr().out
    assert said.startswith("usage: elastocap NAME")
    assert "Benchmarks:" in said
    with pytest.raises(SystemExit):
        command_line.main(["-h", "run"])
    assert "usage: elastocap run [-h]" in capsys.readouterr().out


def test_failures_say_so_in_one_object_or_alone(capsys, monkeypatch):
    """So do answers: alone or in one object."""

    class Study:
        @staticmethod
        def main(argv):
            print("much", "answer: 42 of it", "written: a.csv, b.png", sep="\n")
            print('json: {"numbers": [1, null]}')
            return 1

    monkeypatch.setattr(command_line, "load", lambda name: Study)
    assert command_line.main(["mine"]) == 1
    shown = capsys.readouterr()
    assert "much" in shown.out
    assert shown.err.startswith("mine: FAILED")
    assert command_line.main(["mine", "--quiet"]) == 1
    shown = capsys.readouterr()
    assert shown.out == "42 of it\n"
    assert shown.err.startswith("mine: FAILED")
    assert command_line.main(["mine", "--json"]) == 1
    found = json.loads(capsys.readouterr().out)
    assert found["status"] == 1
    assert not found["passed"]
    assert found["answer"] == ["42 of it"]
    assert found["files"] == ["a.csv", "b.png"]
    assert found["numbers"] == [1, None]


def test_a_run_gives_its_numbers_as_json(tmp_path, capsys, monkeypatch):
    monkeypatch.chdir(tmp_path)
    assert command_line.main(["new", "my.toml"]) == 0
    capsys.readouterr()
    assert command_line.main(["run", "my.toml", "--quick", "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert [state["label"] for state in found["states"]].count("global") >= 1
    assert all(Path(file).exists() for file in found["files"])
    assert command_line.main(["run", "none.toml", "--json"]) == 2
    shown = capsys.readouterr()
    assert "none.toml" in json.loads(shown.out)["error"]
    assert "none.toml" in shown.err
