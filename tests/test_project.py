"""What may import what, what is installed, and that every README shows what is so."""

import ast
import os
import re
import shlex
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from scenes import ROOT

import discretization
from discretization import minimise
from studies import STUDIES

PACKAGES = ("energy", "discretization", "studies")
LAZY = {"cvxpy", "matplotlib"}


def modules(package):
    return sorted((ROOT / package).rglob("*.py"))


def imported(path):
    """(module, names, inside a function) of each import statement."""
    tree = ast.parse(path.read_text("utf-8"))
    nested = {
        id(node)
        for function in ast.walk(tree)
        if isinstance(function, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda)
        for node in ast.walk(function)
    }
    never_run = {
        id(node)
        for block in ast.walk(tree)
        if isinstance(block, ast.If) and getattr(block.test, "id", "") == "TYPE_CHECKING"
        for node in ast.walk(block)
    }
    for node in ast.walk(tree):
        if id(node) in never_run:
            continue
        if isinstance(node, ast.Import):
            for alias in node.names:
                yield alias.name, (), id(node) in nested
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            yield node.module, tuple(a.name for a in node.names), id(node) in nested


@pytest.mark.parametrize(
    ("package", "may_use"),
    [
        ("energy", {"energy"}),
        ("discretization", {"energy", "discretization"}),
        ("studies", set(PACKAGES)),
    ],
)
def test_imports_run_down_only(package, may_use):
    paths = modules(package)
    assert paths
    for path in paths:
        for module, _, _ in imported(path):
            top = module.split(".")[0]
            assert top not in set(PACKAGES) - may_use, f"{path} imports {module}"


@pytest.mark.parametrize(
    ("package", "never"),
    [
        ("nodes", {"lattice", "surfaces", "fitted", "following", "paths", "minimise", "loading"}),
        ("lattice", {"surfaces", "fitted", "following", "paths", "minimise", "loading"}),
        ("following", {"lattice", "paths", "minimise", "loading"}),
        ("fitted", {"following", "paths", "minimise", "loading"}),
        ("surfaces", {"nodes", "lattice", "fitted", "following", "paths", "minimise", "loading"}),
        ("paths", {"minimise", "loading"}),
    ],
)
def test_imports_run_down_inside_discretization(package, never):
    for path in modules(f"discretization/{package}"):
        for module, names, _ in imported(path):
            inner = set(module.split(".")[1:2]) | (
                set(names) if module == "discretization" else set()
            )
            assert not (module.startswith("discretization") and inner & never), f"{path}: {module}"


def test_the_minimisers_never_see_the_closed_forms():
    for path in modules("discretization"):
        for module, names, _ in imported(path):
            assert "cards" not in module.split("."), f"{path} imports {module}"
            assert "cards" not in names, f"{path} imports cards"
        for node in ast.walk(ast.parse(path.read_text("utf-8"))):
            assert not (isinstance(node, ast.Attribute) and node.attr == "cards"), path


def test_the_studies_see_of_the_inside_what_is_documented():
    shown = {"", "display", "lattice.state", "plots"}
    for path in modules("studies"):
        for module, names, _ in imported(path):
            package, _, rest = module.partition(".")
            inner = {*names} - {*discretization.__all__} if module == "discretization" else set()
            if package == "discretization":
                assert rest in shown and inner <= shown, f"{path}: {module} {inner}"


def test_only_cvxpy_and_matplotlib_are_imported_inside_functions():
    for package in PACKAGES:
        for path in modules(package):
            for module, _, nested in imported(path):
                top = module.split(".")[0]
                assert nested == (top in LAZY), f"{path}: {module}"


@pytest.mark.parametrize("package", PACKAGES)
def test_modules_import_each_other_without_circles(package):
    """Imports that only type checkers follow count, too."""
    paths = {".".join(p.relative_to(ROOT).with_suffix("").parts): p for p in modules(package)}
    paths = {name.removesuffix(".__init__"): path for name, path in paths.items()}
    uses = {}
    for name, path in paths.items():
        nodes = list(ast.walk(ast.parse(path.read_text("utf-8"))))
        froms = [n for n in nodes if isinstance(n, ast.ImportFrom)]
        found = {f"{n.module}.{a.name}" for n in froms for a in n.names}
        found |= {n.module for n in froms for a in n.names if f"{n.module}.{a.name}" not in paths}
        found |= {a.name for n in nodes if isinstance(n, ast.Import) for a in n.names}
        uses[name] = found & set(paths) - {name}
    assert sum(map(len, uses.values())) > 30
    while lowest := [name for name, below in uses.items() if not below & set(uses)]:
        for name in lowest:
            del uses[name]
    assert not uses, f"these stand on a circle of imports, or above one: {sorted(uses)}"


def test_no_folder_of_studies_has_more_than_a_dozen_modules():
    folders = {path.parent for path in modules("studies")}
    assert len(folders) > 5
    for folder in folders:
        assert len(list(folder.glob("*.py"))) <= 12, folder


def test_every_package_is_listed_for_installation():
    listed = (ROOT / "pyproject.toml").read_text("utf-8")
    for package in PACKAGES:
        for path in {p.parent for p in modules(package)}:
            name = ".".join(path.relative_to(ROOT).parts)
            assert f'"{name}"' in listed, f"{name} is missing in pyproject.toml"


def test_the_oldest_versions_that_ci_tests_are_the_oldest_allowed():
    project = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]
    lines = (ROOT / ".ci" / "oldest.txt").read_text("utf-8").split()
    tested = dict(line.split("==") for line in lines)
    for dependency in project["dependencies"]:
        name, bound = dependency.split(">=")
        assert tested[name].startswith(f"{bound}."), dependency


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
