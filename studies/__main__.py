"""`python -m studies` lists the studies; `python -m studies NAME [options]` runs one."""

from __future__ import annotations

import ast
import importlib
import sys
from collections.abc import Sequence
from pathlib import Path

from studies import STUDIES


def question(name: str) -> str:
    """First line of a study's docstring, without importing it."""
    source = (Path(__file__).parent / f"{name}.py").read_text("utf-8")
    return (ast.get_docstring(ast.parse(source)) or "").splitlines()[0]


def listing() -> str:
    """One line for each study."""
    lines = [f"  {name:16s} {question(name)}" for name in STUDIES]
    return "\n".join(["python -m studies NAME [options]    (NAME -h for the options)", *lines])


def main(argv: Sequence[str] | None = None) -> int:
    """Run a study; 2 for an unknown name or unusable input, else the study's own status."""
    name, *rest = (sys.argv[1:] if argv is None else list(argv)) or [""]
    if name in ("", "-h", "--help"):
        print(listing())
        return 0
    if name not in STUDIES:
        print(f"study {name!r} is unknown; the studies are: {', '.join(STUDIES)}", file=sys.stderr)
        return 2
    try:
        return int(importlib.import_module(f"studies.{name}").main(rest))
    except (ValueError, RuntimeError, OSError) as error:
        print(f"{name}: {error}", file=sys.stderr)
        return 2


if __name__ == "__main__":
    sys.exit(main())
