"""What may import what, what is installed, and that every README shows what is so."""

import ast
import functools
import os
import re
import shlex
import shutil
import subprocess
import sys
import tomllib
from pathlib import Path

import pytest
from support.repository import ROOT

import discretization
from discretization import minimise
from studies import STUDIES

PACKAGES = ("energy", "discretization", "studies")
LAZY = {"cvxpy", "matplotlib"}


def modules(package):
    return sorted((ROOT / package).rglob("*.py"))


@functools.cache
def nodes_of(path):
    return list(ast.walk(ast.parse(path.read_text("utf-8"))))


@functools.cache
def imported(path):
    """(module, names, inside a function) of each import statement that is run."""
    blocks = nodes_of(path)
    found = []
    functions = ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda
    nested = {id(node) for f in blocks if isinstance(f, functions) for node in ast.walk(f)}
    typing = [b for b in blocks if getattr(getattr(b, "test", None), "id", "") == "TYPE_CHECKING"]
    never_run = {id(node) for block in typing for node in ast.walk(block)}
    for node in blocks:
        if id(node) in never_run:
            continue
        if isinstance(node, ast.Import):
            for alias in node.names:
                found.append((alias.name, (), id(node) in nested))
        elif isinstance(node, ast.ImportFrom):
            assert node.level == 0, f"{path}: relative import"
            found.append((node.module, tuple(a.name for a in node.names), id(node) in nested))
    return found


@pytest.mark.parametrize("package", PACKAGES)
def test_imports_run_down_only(package):
    above = set(PACKAGES[PACKAGES.index(package) + 1 :])
    for path in modules(package):
        for module, _, _ in imported(path):
            assert module.split(".")[0] not in above, f"{path} imports {module}"


@pytest.mark.parametrize(
    ("package", "never"),
    [
        ("nodes", {"lattice", "surfaces", "fitted", "paths", "minimise", "loading"}),
        ("lattice", {"surfaces", "fitted", "paths", "minimise", "loading"}),
        ("refine", {"paths", "minimise", "loading"}),
        ("fitted", {"paths", "minimise", "loading"}),
        ("surfaces", {"nodes", "lattice", "fitted", "paths", "minimise", "loading"}),
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
            assert "cards" not in (*module.split("."), *names), f"{path} imports cards"
        for node in nodes_of(path):
            assert getattr(node, "attr", "") != "cards", path


def test_the_studies_see_of_the_inside_what_is_documented():
    shown = {"", "lattice.state", "nodes.row", "plots", "readings", "roots"}
    shown |= {"fitted.free_branch", "layer.free_branch"}
    for path in modules("studies"):
        for module, names, _ in imported(path):
            package, _, rest = module.partition(".")
            inner = {*names} - {*discretization.__all__} if module == "discretization" else set()
            if package == "discretization":
                assert rest in shown and inner <= shown, f"{path}: {module} {inner}"


def test_only_cvxpy_and_matplotlib_are_imported_inside_functions():
    for package in PACKAGES:
        for path in modules(package):
            if path.parent.name == "tutorials":  # scripts of a user
                continue
            for module, _, nested in imported(path):
                top = module.split(".")[0]
                if top == "PIL" and nested:  # comes with matplotlib
                    continue
                assert nested == (top in LAZY), f"{path}: {module}"


def test_scipy_special_is_loaded_lazily():
    """Modules import scipy and write scipy.special.k0e: scipy loads a subpackage when it is used.

    That of special functions costs a sixth of numpy and scipy.linalg, and only free surfaces about
    an axis, nodes of a layer and some closed forms call them.
    """
    uses = 0
    for package in ("energy", "discretization"):
        for path in modules(package):
            for module, names, _ in imported(path):
                assert not module.startswith("scipy.special"), f"{path} imports {module}"
                assert module != "scipy" or "special" not in names, f"{path} imports special"
            uses += "scipy.special." in path.read_text("utf-8")
    assert uses >= 5


def test_what_most_states_do_not_need_is_not_imported():
    """Neither special functions, unless scipy.linalg needs them, nor the closed forms."""
    code = """
import sys, numpy, scipy.linalg
before = set(sys.modules)
import discretization, energy
for lazy in ("scipy.special", "scipy.optimize", "matplotlib", "cvxpy", "energy.cards"):
    assert lazy in before or lazy not in sys.modules, lazy
energy.cards.parabola
try:
    energy.card
except AttributeError as error:
    assert "'card'" in str(error)
else:
    raise AssertionError("energy.card")
"""
    done = subprocess.run([sys.executable, "-c", code], cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("package", PACKAGES)
def test_modules_import_each_other_without_circles(package):
    """Imports that only type checkers follow count, too."""
    paths = {".".join(p.relative_to(ROOT).with_suffix("").parts): p for p in modules(package)}
    paths = {name.removesuffix(".__init__"): path for name, path in paths.items()}
    uses = {}
    for name, path in paths.items():
        nodes = nodes_of(path)
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


def test_every_folder_of_code_is_a_package():
    for name in PACKAGES:
        for path in (ROOT / name).rglob("*.py"):
            assert (path.parent / "__init__.py").is_file(), path.parent


def test_oldest_versions_are_those_allowed():
    """The oldest versions that ci tests are the oldest allowed."""
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
CONTRIBUTING = (ROOT / ".github" / "CONTRIBUTING.md").read_text("utf-8")
SHELL_OF_CONTRIBUTING = re.findall(r"```sh\n(.*?)```", CONTRIBUTING, re.S)[0].splitlines()
SHELL = {path: re.findall(r"```sh\n(.*?)```", text, re.S) for path, text in TEXT.items()}


@pytest.fixture
def seen(monkeypatch, tmp_path):
    """The states that `discretization.minimise` has given, in a working directory of its own."""
    states = []
    original = discretization.minimise

    def recorded(*given, **options):
        states.append(original(*given, **options))
        return states[-1]

    monkeypatch.setattr(discretization, "minimise", recorded)
    monkeypatch.chdir(tmp_path)
    return states


def alike(printed, shown):
    """Whether two texts differ in the last digits of numbers at most; error estimates may."""
    rows = [re.sub(r"numerical error [^;)]+", "", text).split() for text in (printed, shown)]

    def same(one, other):
        try:
            return float(one) == pytest.approx(float(other), rel=1e-4)
        except ValueError:
            return one == other

    return len(rows[0]) == len(rows[1]) and all(map(same, *rows))


def test_every_block_is_run():
    assert len(READMES) == 4
    assert len(RECIPES) == sum(t.count("```python") for t in TEXT.values())
    assert len(RECIPES) == 6
    assert sum(map(len, SHELL.values())) == 5


@pytest.mark.parametrize(("words", "code", "shown"), RECIPES)
def test_recipes_print_what_is_shown(words, code, shown, seen, capsys):
    """A recipe prints what is shown inside the model or says so."""
    names = {}
    exec(compile(code, "README.md", "exec"), names)
    assert alike(capsys.readouterr().out, shown)
    assert seen or "path" in names or names["states"].in_contact.any()
    for state in seen:
        assert not state.warnings or "state.warnings" in words
    if "path" in names:
        assert "state.warnings" in words
        assert minimise(names["scene"], names["path"].pull_off.depth).warnings == ()
        assert minimise(names["scene"], names["path"].events[-1].depth * 0.99).warnings
        assert Path("loop.csv").stat().st_size > 1000
        assert Path("loop.png").read_bytes().startswith(b"\x89PNG")


def test_the_commands_exist_and_ci_runs_the_second():
    commands = SHELL[ROOT / "README.md"][:2]
    for command, job in zip(commands, ("-m studies verify", "-m pytest"), strict=True):
        assert all(part in command for part in (job, "venv", "pip install"))
    assert "README.md" in (ROOT / ".ci" / "run").read_text("utf-8")


SCENE_FILES = ("my.csv", "my.png", "many_sweep_quick.csv", "loop_fit.csv", "loop_fit.png")


@pytest.mark.parametrize(
    ("blocks", "names"),
    [
        pytest.param(slice(0, 2), SCENE_FILES, marks=pytest.mark.slow),
        (slice(2, 3), ("half_width.csv", "half_width.png")),
    ],
)
def test_the_shell_recipes_run(blocks, names, tmp_path, monkeypatch):
    """Those of studies/README.md, a fit of the loop that the recipe in Python has written."""
    monkeypatch.chdir(tmp_path)
    recipe = "".join(SHELL[ROOT / "studies" / "README.md"][blocks])
    fitted = "loop.csv" in recipe
    for _, code, _ in RECIPES:
        if fitted and "loop.csv" in code:
            exec(compile(code, "README.md", "exec"), {})
    recipe = recipe.replace(".venv/bin/python", shlex.quote(sys.executable))
    given = {**os.environ, "PYTHONPATH": str(ROOT)}
    done = subprocess.run(["sh", "-ec", recipe], cwd=tmp_path, env=given, capture_output=True)
    assert done.returncode == 0, done.stderr.decode()
    for name in names:
        assert (tmp_path / "results" / name).stat().st_size > 300
    if fitted:
        told = dict(re.findall(r"^(w|gamma1) +(\S+)", done.stdout.decode(), re.M))
        assert float(told["w"]) == pytest.approx(6e-5, rel=1e-3)
        assert float(told["gamma1"]) == pytest.approx(0.07, rel=1e-3)
        ends = re.findall(r"^(?:w|gamma1) +\S+ +\[(\S+), (\S+)\]", done.stdout.decode(), re.M)
        for true, (low, high) in zip((6e-5, 0.07), ends, strict=True):
            assert float(low) < true < float(high)


def test_every_link_and_every_file_named_exists():
    found = 0
    pages = sorted((ROOT / ".github").glob("*.md"))
    for path in [*READMES, ROOT / "energy" / "THEORY.md", *pages]:
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


def test_every_study_is_in_the_table():
    listed = re.findall(r"^\| (`.*?) \|", TEXT[ROOT / "studies" / "README.md"], re.M)
    assert sorted(re.findall(r"`(\w+)`", " ".join(listed))) == sorted(STUDIES)


def test_the_version_is_that_of_citation_and_changelog():
    version = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
    kinds = ("*.toml", "*.py", "*.md", *(f"{name}/**/*.py" for name in PACKAGES))
    files = [path for kind in kinds for path in ROOT.glob(kind)]
    stands = re.compile(rf"\b{re.escape(version)}\b")
    assert [p.name for p in files if stands.search(p.read_text("utf-8"))] == ["pyproject.toml"]
    changes = (ROOT / ".github" / "CHANGELOG.md").read_text("utf-8")
    (date,) = re.findall(rf"^## \[{re.escape(version)}\] - (\d{{4}}-\d\d-\d\d)$", changes, re.M)
    citation = (ROOT / ".github" / "CITATION.cff").read_text("utf-8")
    assert f"\nversion: {version}\ndate-released: {date}\n" in citation


def test_workflows_call_the_scripts_that_run_here():
    workflows = ROOT / ".github" / "workflows"
    called = {path.stem: path.read_text("utf-8") for path in workflows.glob("*.yml")}
    assert set(called) == {"tests", "docs"}
    assert "run: .ci/run\n" in called["tests"]
    assert "run: .ci/docs\n" in called["docs"]
    install = SHELL_OF_CONTRIBUTING[0]
    assert f"run: {install}\n" in called["docs"]


def test_the_page_of_a_package_index_needs_no_files_beside_it():
    hooks = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["tool"]["hatch"]["metadata"]
    page = TEXT[ROOT / "README.md"]
    for rule in hooks["hooks"]["fancy-pypi-readme"]["substitutions"]:
        page = re.sub(rule["pattern"], rule["replacement"], page)
    assert not re.findall(r"\]\((?!https?:)", page)
    assert "*(figure: A rough cylinder)*" in page
    assert "MIT\nlicence, LICENSE." in page


TOP_LEVEL = {*PACKAGES, "tests", "pyproject.toml", "README.md", "LICENSE"}


def git(root, *given):
    """What git prints in a folder, whatever repository a hook that runs the tests belongs to."""
    own = {name: value for name, value in os.environ.items() if not name.startswith("GIT_")}
    done = subprocess.run(
        ["git", *given], cwd=root, env=own, check=True, capture_output=True, text=True
    )
    return done.stdout


def tracked(root):
    """Names on the top level of what git tracks here; None where this is no clone."""
    if not (root / ".git").exists() or not shutil.which("git"):
        return None
    paths = git(root, "ls-files", "-z").split("\0")
    names = {path.split("/")[0] for path in paths if path}
    return {name for name in names if not name.startswith(".")}


def check_top_level(root):
    """AssertionError unless what is kept is what is agreed, whatever recipes have left there.

    Nothing tells the files of a source distribution from those of its user: all agreed are there.
    """
    kept = tracked(root)
    if kept is None:
        kept = {name for name in TOP_LEVEL if (root / name).exists()}
    assert kept == TOP_LEVEL


def test_the_top_level_is_the_one_agreed():
    check_top_level(ROOT)


@pytest.mark.parametrize("clone", [True, False])
def test_the_top_level_of_a_used_clone_is_the_one_agreed(clone, tmp_path):
    for name in TOP_LEVEL:
        folder = tmp_path if "." in name or name == "LICENSE" else tmp_path / name
        folder.mkdir(exist_ok=True)
        (folder / (name if folder == tmp_path else "__init__.py")).write_text("")
    if clone:
        git(tmp_path, "init", "-q")
        git(tmp_path, "add", ".")
    (tmp_path / "results").mkdir()
    for name in ("my.toml", "many.toml", "loop.csv", "loop.png", "results/my.csv"):
        (tmp_path / name).write_text("left by a recipe")
    check_top_level(tmp_path)
    if clone:
        git(tmp_path, "add", "my.toml")
    else:
        (tmp_path / "LICENSE").unlink()
    with pytest.raises(AssertionError):
        check_top_level(tmp_path)


def test_what_is_shown_is_compared():
    assert alike("a 1.00000 (numerical error 1e-9)", "a 1.00001 (numerical error 3e-9)")
    assert not alike("a 1.000", "a 1.001")
    assert not alike("a 1", "b 1")
    assert not alike("a", "a 1")
