"""How does a scene file begin? Writes a commented one, with the defaults shown, to edit and run.

    python -m studies new FILE.toml
    python -m studies run FILE.toml

What is commented out is optional. studies/scenes/file.py documents every key. Likewise for a study
of your own, in Python:

    python -m studies new --study FILE.py
    python -m studies FILE.py --preset quick
"""

# `program()` is how the command line was called, and `replacing(path)` gives a file to write that
# takes the place of `path` once it is whole.

import argparse
from collections.abc import Sequence
from pathlib import Path

from studies.shared.program import program
from studies.shared.table import replacing

TEMPLATES = Path(__file__).parent.parent  # template.toml and template.py


def write(path: Path, ending: str) -> None:
    """Write the template of this ending. ValueError if the file exists or is named otherwise."""
    if path.suffix != ending:
        raise ValueError(f"FILE = {str(path)!r} must end in {ending}; give such a name")
    path.parent.mkdir(parents=True, exist_ok=True)
    if path.exists():
        raise ValueError(f"FILE = {str(path)!r} exists; give another name")
    with replacing(path) as beside:
        beside.write_text((TEMPLATES / f"template{ending}").read_text("utf-8"), "utf-8")


def main(argv: Sequence[str] | None = None) -> int:
    """Write the file and say what comes next."""
    parser = argparse.ArgumentParser(prog=f"{program()} new", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("file", type=Path, nargs="?", metavar="FILE.toml", help="must not exist yet")
    about = "write a study to edit instead, which must not exist yet"
    which.add_argument("--study", type=Path, metavar="FILE.py", help=about)
    options = parser.parse_args(argv)
    path = options.study or options.file
    write(path, ".py" if options.study else ".toml")
    command = "" if options.study else "run "
    print(f"written: {path}; edit it, then: {program()} {command}{path}")
    return 0
