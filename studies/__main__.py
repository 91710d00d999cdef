"""`python -m studies`, or `elastocap`, lists the studies; with NAME [options] it runs one."""

import os

# studies run in a process for each core: threads of one would wait for those of another; and times
# are compared on one thread of BLAS, whichever it is, that reads this when numpy is imported
os.environ.update(OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1", OMP_NUM_THREADS="1")

import ast
import importlib
import io
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType

from studies import MODULES, STUDIES
from studies.shared.table import versions

PIPE, INTERRUPT = 141, 130  # statuses as of a shell: 128 + SIGPIPE, 128 + SIGINT


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
        meant = "".join(f": did you mean {near!r}?" for near in get_close_matches(name, STUDIES, 1))
        raise ValueError(f"study {name!r} is unknown{meant}; the studies are: {', '.join(STUDIES)}")
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
    """Run a study; 2 for an unknown name or unusable input, else the study's own status.

    What the encoding of the output lacks is written as "?". A pipe that is closed before all is
    written ends the study quietly, as it ends other commands; Ctrl-C with a line.
    """
    for stream in (sys.stdout, sys.stderr):
        if isinstance(stream, io.TextIOWrapper):
            stream.reconfigure(errors="replace")
    name, *rest = (sys.argv[1:] if argv is None else list(argv)) or [""]
    try:
        status = answered(name, rest)
        sys.stdout.flush()
        return status
    except BrokenPipeError:
        nowhere = os.open(os.devnull, os.O_WRONLY)  # for what Python writes on its way out
        for number in (1, 2):
            os.dup2(nowhere, number)
        return PIPE
    except KeyboardInterrupt as stop:
        print(f"\n{name}: stopped; {stop}".rstrip("; "), file=sys.stderr)
        return INTERRUPT


def answered(name: str, rest: Sequence[str]) -> int:
    """The list, the version, or a study and its status; refusals in one line."""
    if name in ("", "-h", "--help"):
        print(listing())
        return 0
    if name == "--version":
        print("elastocap", versions()["elastocap"])
        return 0
    told = ""
    try:
        study = load(name)
        told = f"{name}: "
        return int(study.main(rest))
    except BrokenPipeError:
        raise
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        print(f"{told}{where}{error.strerror or error}", file=sys.stderr)
    except ImportError as error:
        if error.name != "energy":
            raise
        print(error, file=sys.stderr)
    except (ValueError, RuntimeError) as error:
        print(f"{told}{error}", file=sys.stderr)
    return 2


if __name__ == "__main__":
    sys.exit(main())
