"""`python -m studies`, or `elastocap`, lists the studies; with NAME [options] it runs one."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Sequence
from pathlib import Path
from types import ModuleType

from studies import MODULES, STUDIES
from studies.shared.table import versions


def question(name: str) -> str:
    """First line of a study's docstring, without importing it."""
    path = Path(__file__).parent.joinpath(*MODULES[name].split(".")[1:]).with_suffix(".py")
    return (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").splitlines()[0]


def listing() -> str:
    """One line for each study."""
    lines = [f"  {name:16s} {question(name)}" for name in STUDIES]
    lines.append(
        "  FILE.py          A study of your own; `new --study FILE.py` writes one to edit."
    )
    return "\n".join(["python -m studies NAME [options]    (NAME -h for the options)", *lines])


def load(name: str) -> ModuleType:
    """The module of a study by its name, or by the path of its file, which ends in .py.

    ValueError for an unknown name, no such file, and one whose name another module has.
    """
    if name in MODULES:
        return importlib.import_module(MODULES[name])
    path = Path(name).resolve()
    if path.suffix != ".py":
        raise ValueError(f"study {name!r} is unknown; the studies are: {', '.join(STUDIES)}")
    if not path.is_file():
        raise ValueError(f"{name}: no such file; `python -m studies new --study {name}` writes it")
    sys.path.insert(0, str(path.parent))  # found by processes that are started afresh, too
    found = importlib.import_module(path.stem)
    if Path(found.__file__ or "").resolve() != path:
        raise ValueError(f"{name}: another module is named {path.stem}; rename the file")
    if not hasattr(found, "main"):
        raise ValueError(f"{name}: has no function main(argv) that returns an exit status")
    return found


def main(argv: Sequence[str] | None = None) -> int:
    """Run a study; 2 for an unknown name or unusable input, else the study's own status."""
    name, *rest = (sys.argv[1:] if argv is None else list(argv)) or [""]
    if name in ("", "-h", "--help"):
        print(listing())
        return 0
    if name == "--version":
        print("elastocap", versions()["elastocap"])
        return 0
    try:
        study = load(name)
    except ValueError as error:
        print(error, file=sys.stderr)
        return 2
    try:
        return int(study.main(rest))
    except (ValueError, RuntimeError, OSError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
