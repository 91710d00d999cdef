"""What may import what, and what is installed."""

import ast
import tomllib

import pytest
from project import ROOT

import discretization

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
