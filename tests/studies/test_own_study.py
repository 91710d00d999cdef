"""A study of one's own: the template, and one of at most 60 lines outside the package."""

import shutil
import sys
from pathlib import Path

import pytest

from studies import __main__ as command_line
from studies.shared.table import read

CUBIC = Path(__file__).with_name("cubic.py")


@pytest.fixture
def inside(tmp_path, monkeypatch):
    """A working directory of its own; what it imports is forgotten afterwards."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("sys.path", [*sys.path])
    before = set(sys.modules)
    yield tmp_path
    for name in set(sys.modules) - before:
        if name in ("mine", "cubic"):
            del sys.modules[name]


def test_the_template_runs_at_once_in_any_number_of_processes(inside, capsys):
    assert command_line.main(["new", "--study", "mine.py"]) == 0
    assert "python -m studies mine.py" in capsys.readouterr().out
    for jobs in ("1", "2"):
        given = ["mine.py", "--preset", "quick", "--jobs", jobs, "--out", jobs]
        assert command_line.main(given) == 0
        assert "2 scenes, largest relative error" in capsys.readouterr().out
        assert (inside / jobs / "half_width.png").read_bytes().startswith(b"\x89PNG")
    rows = [read(inside / jobs / "half_width.csv") for jobs in ("1", "2")]
    assert rows[0] == rows[1] and len(rows[0]) == 2
    head = (inside / "2" / "half_width.csv").read_text("utf-8").splitlines()[0]
    assert head == "# command: python -m studies mine.py --preset quick --jobs 2 --out 2"


def test_the_template_is_not_written_over_another_file(inside, capsys):
    (inside / "mine.py").write_text("mine", "utf-8")
    assert command_line.main(["new", "--study", "mine.py"]) == 2
    assert "exists; give another name" in capsys.readouterr().err
    assert command_line.main(["new", "--study", "mine.txt"]) == 2
    assert "must end in .py" in capsys.readouterr().err
    assert (inside / "mine.py").read_text("utf-8") == "mine"


def test_a_new_study_takes_at_most_60_lines(inside, capsys):
    assert len(CUBIC.read_text("utf-8").splitlines()) <= 60
    shutil.copy(CUBIC, inside)
    assert command_line.main(["cubic.py", "--quick", "--jobs", "1", "--out", "out"]) == 0
    assert capsys.readouterr().out.count("F_A = ") == 2
    low, high = (float(row["force"]) for row in read(inside / "out" / "cubic.csv"))
    assert high < low < 0  # more tension, more adhesion
    assert (inside / "out" / "cubic.png").stat().st_size > 1000


def test_a_study_that_fails_says_so_by_its_status(inside, capsys):
    text = CUBIC.read_text("utf-8").replace("miss = abs(f", "miss = abs(2 * f")
    (inside / "cubic.py").write_text(text, "utf-8")
    assert command_line.main(["cubic.py", "--quick", "--jobs", "1"]) == 1


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
    assert told in said and said.count("\n") == 1


def test_the_version_is_told(capsys):
    assert command_line.main(["--version"]) == 0
    name, version = capsys.readouterr().out.split(maxsplit=1)
    assert name == "elastocap" and version.strip()
