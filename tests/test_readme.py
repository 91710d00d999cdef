"""Every README: its commands and recipes run and print what it shows, its links lead somewhere."""

import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from project import ROOT

import discretization
from discretization import minimise
from studies import STUDIES

READMES = [ROOT / "README.md", *sorted(ROOT.glob("*/README.md"))]
TEXT = {path: path.read_text("utf-8") for path in READMES}
RECIPES = [
    (words, code, shown)
    for text in TEXT.values()
    for words, code, shown in re.findall(
        r"\n\n((?:(?!\n\n)[\s\S])*?)\n\n```python\n(.*?)```(?:\n\n```text\n(.*?)```)?", text, re.S
    )
]
SHELL = {path: re.findall(r"```sh\n(.*?)```", text, re.S) for path, text in TEXT.items()}


@pytest.fixture
def seen(monkeypatch, tmp_path):
    """The states that `discretization.minimise` has given, in a working directory of its own."""
    states, original = [], discretization.minimise

    def recorded(*given, **options):
        states.append(original(*given, **options))
        return states[-1]

    monkeypatch.setattr(discretization, "minimise", recorded)
    monkeypatch.chdir(tmp_path)
    return states


def alike(printed, shown):
    """Whether two texts differ in the last digits of numbers at most; error estimates may."""
    rows = [re.sub(r"± \S+\)", "±", text).split() for text in (printed, shown)]
    if len(rows[0]) != len(rows[1]):
        return False
    for one, other in zip(*rows, strict=True):
        try:
            if float(one) != pytest.approx(float(other), rel=1e-4):
                return False
        except ValueError:
            if one != other:
                return False
    return True


def test_every_block_is_run():
    assert len(READMES) == 4 and len(RECIPES) == sum(t.count("```python") for t in TEXT.values())
    assert len(RECIPES) == 5 and sum(map(len, SHELL.values())) == 4


@pytest.mark.parametrize(("words", "code", "shown"), RECIPES)
def test_a_recipe_prints_what_is_shown_inside_the_model_or_says_so(
    words, code, shown, seen, capsys
):
    names = {}
    exec(compile(code, "README.md", "exec"), names)
    assert alike(capsys.readouterr().out, shown)
    assert seen or "path" in names
    for state in seen:
        assert not state.warnings or "state.warnings" in words
    if "path" in names:
        assert "state.warnings" in words
        assert minimise(names["scene"], names["path"].pull_off.depth).warnings == ()
        assert minimise(names["scene"], names["path"].events[-1].depth * 0.99).warnings
        assert Path("loop.csv").stat().st_size > 1000
        assert Path("loop.png").read_bytes().startswith(b"\x89PNG")


def test_the_commands_exist_and_ci_runs_the_second():
    main_job, tests = SHELL[ROOT / "README.md"][:2]
    assert "-m studies verify" in main_job
    assert "-m pytest" in tests
    for command in (main_job, tests):
        assert "venv" in command and "pip install" in command
    assert "README.md" in (ROOT / ".ci" / "run").read_text("utf-8")


@pytest.mark.parametrize("path", [ROOT / "README.md", ROOT / "studies" / "README.md"])
def test_the_shell_recipe_runs(path, tmp_path):
    recipe = SHELL[path][-1].replace(".venv/bin/python", shlex.quote(sys.executable))
    given = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(["sh", "-ec", recipe], cwd=tmp_path, env=given, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    names = {
        ROOT: ("my.csv", "my.png", "many_sweep_quick.csv", "many_sweep_quick.png"),
        ROOT / "studies": ("half_width.csv", "half_width.png"),
    }
    for name in names[path.parent]:
        assert (tmp_path / "results" / name).stat().st_size > 300


def test_every_link_and_every_file_named_exists():
    found = 0
    for path in [*READMES, ROOT / ".github" / "CONTRIBUTING.md"]:
        text = path.read_text("utf-8")
        for target in re.findall(r"\]\(([^)#:]+)\)", text):
            assert (path.parent / target).exists(), f"{path}: {target}"
            found += 1
        for name in re.findall(r"`([\w./]+\.(?:py|toml))`", text):
            places = (ROOT, path.parent, ROOT / "studies")
            ours = "/" in name or path.parent == ROOT / "energy"
            assert not ours or any((p / name).exists() for p in places), f"{path}: {name}"
            found += ours
    assert found > 30


def test_every_study_is_in_the_table_and_the_citation_has_the_version():
    listed = re.findall(r"^\| (`.*?) \|", TEXT[ROOT / "studies" / "README.md"], re.M)
    assert sorted(re.findall(r"`(\w+)`", " ".join(listed))) == sorted(STUDIES)
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    citation = (ROOT / ".github" / "CITATION.cff").read_text("utf-8")
    assert f"\nversion: {project['version']}\n" in citation


def test_the_first_page_is_read_in_five_minutes():
    assert len(TEXT[ROOT / "README.md"].split()) <= 1200


def test_what_is_shown_is_compared():
    assert alike("a 1.00000 (± 1e-9)", "a 1.00001 (± 3e-9)")
    assert not alike("a 1.000", "a 1.001") and not alike("a 1", "b 1") and not alike("a", "a 1")
