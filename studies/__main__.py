"""`python -m studies`, or `elastocap`, lists what there is; with NAME [options] it runs one."""

import os

# studies run in a process for each core: threads of one would wait for those of another; and times
# are compared on one thread of BLAS, whichever it is, that reads this when numpy is imported
os.environ.update(OPENBLAS_NUM_THREADS="1", MKL_NUM_THREADS="1", OMP_NUM_THREADS="1")

import ast
import contextlib
import importlib
import io
import json
import sys
from collections.abc import Sequence
from difflib import get_close_matches
from pathlib import Path
from types import ModuleType

from studies import GROUPS, MODULES, STUDIES
from studies.shared.program import program
from studies.shared.table import versions

# Statuses that a shell gives a command that a signal has ended: 128 + the signal's number.
PIPE = 128 + 13  # SIGPIPE, which not every system has
INTERRUPT = 128 + 2  # SIGINT


def question(name: str) -> str:
    """First line of a study's docstring, without importing it."""
    path = Path(__file__).parent.joinpath(*MODULES[name].split(".")[1:]).with_suffix(".py")
    return (ast.get_docstring(ast.parse(path.read_text("utf-8"))) or "").splitlines()[0]


def listing() -> str:
    """One line for each tool, study and benchmark."""
    called = program()
    lines = [f"usage: {called} NAME [options]    ({called} NAME -h for the options of one)"]
    for title, names in GROUPS.items():
        lines += ["", f"{title}:", *(f"  {name:17s} {question(name)}" for name in names)]
    own = "A study of your own; `new --study FILE.py` writes one to edit."
    everywhere = "Everywhere: --quiet prints the answer alone, --json one object."
    return "\n".join([*lines, "", f"  {'FILE.py':17s} {own}", "", everywhere])


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
    """The list, the version, or a study and its status; errors in one line."""
    if name in ("-h", "--help") and rest:
        name = rest[0]
        rest = ["-h", *rest[1:]]
    if name in ("", "-h", "--help"):
        print(listing())
        return 0
    if name == "--version":
        print("elastocap", versions()["elastocap"])
        return 0
    asked = {option for option in ("--quiet", "--json") if option in rest}
    if not asked or {"-h", "--help"} & {*rest}:
        status, error = _run(name, rest)
    else:
        shown = io.StringIO()
        with contextlib.redirect_stdout(shown):
            status, error = _run(name, rest)
        if "--json" in asked:
            print(as_json(name, status, error, shown.getvalue()))
        else:
            for line in (*said(shown.getvalue(), "answer"), *said(shown.getvalue(), "missed")):
                print(line)
    if status == 1 and not error:
        error = f"{name}: FAILED: a check of this study did not pass; see its answer and tables"
    if error:
        print(error, file=sys.stderr)
    return status


def said(printed: str, word: str) -> list[str]:
    """What follows a word at the beginning of printed lines, such as answer, missed, written."""
    return [line[len(word) + 2 :] for line in printed.splitlines() if line.startswith(f"{word}: ")]


def as_json(name: str, status: int, error: str, printed: str) -> str:
    """One object: what was called, whether it passed, its answers, files, and numbers."""
    found: dict[str, object] = {"name": name, "status": status, "passed": status == 0}
    if error:
        found["error"] = error
    for word in ("answer", "missed"):
        found[word] = said(printed, word)
    found["files"] = [file for line in said(printed, "written") for file in line.split(", ")]
    for text in said(printed, "json"):
        found.update(json.loads(text))
    return json.dumps(found, indent=1, ensure_ascii=False)


def _run(name: str, rest: Sequence[str]) -> tuple[int, str]:
    """The status of a study, and what went wrong in one line; "" if nothing did."""
    where = ""
    try:
        study = load(name)
        where = f"{name}: "
        return int(study.main(rest)), ""
    except BrokenPipeError:
        raise
    except OSError as error:
        file = f"{error.filename}: " if error.filename else ""
        return 2, f"{where}{file}{error.strerror or error}"
    except ImportError as error:
        if error.name != "energy":
            raise
        return 2, str(error)
    except (ValueError, RuntimeError) as error:
        return 2, f"{where}{error}"


if __name__ == "__main__":
    sys.exit(main())
