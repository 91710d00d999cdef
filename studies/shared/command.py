"""The options that all studies share, and where what they find is written.

A study is run by its `main(argv)`: `parse` gives `options`, with `preset`, `out` (the folder),
`jobs`, `quiet` and `json` beside the study's own, and an `Output` that writes tables and figures
into that folder; `start` does so for a study without options of its own. `program()` is how the
command line was called. TIMED has the names of the studies that measure times: they get one
process.
`table.header(command, parameters)` are the lines that say how a table was made, `table.replacing`
gives a file to write that takes the place of another once it is whole. `--quiet` and `--json` are
read by `python -m studies`, which calls `main`.
"""

import argparse
import os
import shlex
import sys
import tempfile
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from pathlib import Path
from typing import Any, TypeVar

from studies import TIMED
from studies.shared import figures, table
from studies.shared.figures import Figure
from studies.shared.program import program

P = TypeVar("P")
Parser = argparse.ArgumentParser


def parser(name: str, doc: str | None, quick: str, jobs: int | None = None) -> Parser:
    """A parser with the options that all studies share.

    Parameters
    ----------
    name : str
        Of the study; or the path of its file, of a study of one's own that is run by its path. The
        usage shows that path from the working directory. It is never one of TIMED.
    doc : str or None
        The docstring of its module.
    quick : str
        What the quick preset does.
    jobs : int, optional
        The default of --jobs; None: all cores. Where times are measured there is one.

    Returns
    -------
    argparse.ArgumentParser
    """
    name = os.path.relpath(name) if name.endswith(".py") else name
    found = argparse.ArgumentParser(prog=f"{program()} {name}", description=doc)
    found.formatter_class = argparse.RawDescriptionHelpFormatter
    presets = ("quick", "full")
    about = f"quick: {quick}, figures as PNG alone; default: full"
    found.add_argument("--preset", choices=presets, default="full", help=about)
    same = "the same as --preset quick"
    found.add_argument("--quick", action="store_const", const="quick", dest="preset", help=same)
    where = "folder of tables and figures; default: results/"
    found.add_argument("--out", type=Path, default=Path("results"), metavar="DIR", help=where)
    timed = name in TIMED
    kind = partial(_jobs, timed=timed)
    default = 1 if timed else jobs or os.cpu_count() or 1
    about = "processes; " + ("1, for times are measured" if timed else f"default: {default}")
    found.add_argument("--jobs", type=kind, default=default, metavar="N", help=about)
    about = "print nothing but the answer; progress and failures go to stderr"
    found.add_argument("--quiet", action="store_true", help=about)
    about = "print one JSON object: status, answer, files, and what `run` finds as numbers"
    found.add_argument("--json", action="store_true", help=about)
    return found


def some_of(parser: Parser, option: str, names: Sequence[str]) -> None:
    """Add an option that takes some of these names; without it, all are taken.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    option : str
    names : sequence of str
    """
    about = f"some of {', '.join(names)}; default: all"
    given: dict[str, Any] = {"nargs": "+", "choices": names, "default": names, "metavar": "NAME"}
    parser.add_argument(option, help=about, **given)


def _jobs(text: str, timed: bool) -> int:
    """The number of processes; ArgumentTypeError for more than 1 where times are measured."""
    if not text.isdecimal() or int(text) < 1:
        raise argparse.ArgumentTypeError(f"{text!r} is not a number of processes; give at least 1")
    if timed and int(text) > 1:
        raise argparse.ArgumentTypeError(
            f"{text} processes would disturb the times that this study measures; give 1"
        )
    return int(text)


@dataclass(frozen=True)
class Output:
    """A folder for tables and figures, and the command that makes them again.

    Attributes
    ----------
    folder : Path
    command : str
    pdf : bool
        Whether figures are written as PDF, too.
    """

    folder: Path
    command: str
    pdf: bool = True

    def table(
        self,
        name: str,
        parameters: object,
        columns: Sequence[str],
        rows: Iterable[Iterable[Any]],
        notes: Sequence[str] = (),
    ) -> Path:
        """Write a CSV whose header says how it was made.

        Parameters
        ----------
        name : str
            Of the file, with its ending.
        parameters : object
            What the study was run with.
        columns : sequence of str
        rows : iterable of rows
        notes : sequence of str
            Further lines of the header.

        Returns
        -------
        Path
        """
        path = self.at(name)
        table.write(path, [*self.header(parameters), *notes], columns, rows)
        return path

    def at(self, name: str) -> Path:
        """Where a file of this name goes; the folder is made."""
        self.folder.mkdir(parents=True, exist_ok=True)
        return self.folder / name

    def text(self, name: str, text: str) -> Path:
        """Write a text."""
        path = self.at(name)
        with table.replacing(path) as beside:
            beside.write_text(text, encoding="utf-8")
        return path

    def figures(self, figures: Mapping[str, Figure]) -> list[Path]:
        """Write several figures, by name."""
        return [path for name, figure in figures.items() for path in self.figure(name, figure)]

    def header(self, parameters: object) -> list[str]:
        """What reproduces a table made with these parameters."""
        return table.header(self.command, parameters)

    def figure(self, name: str, figure: Figure) -> list[Path]:
        """Write a figure as PNG, and if `pdf` as PDF; the files written.

        The endings .png and .pdf take the place of one that `name` has. The figure stays open.
        """
        return figures.save(figure, self.at(name), self.pdf)


def parse(parser: Parser, argv: Sequence[str] | None) -> tuple[argparse.Namespace, Output]:
    """The options, and where to write; nothing is made before something is written.

    Parameters
    ----------
    parser : argparse.ArgumentParser
    argv : sequence of str or None
        None: the arguments of this process, behind the name of the study.

    Returns
    -------
    options : argparse.Namespace
    out : Output

    Raises
    ------
    ValueError
        Before any work, if --out can be neither written to nor made.
    """
    given = sys.argv[2:] if argv is None else list(argv)
    options = parser.parse_args(given)
    folders = (options.out, *options.out.absolute().parents)
    there = next(folder for folder in folders if folder.exists())
    try:
        tempfile.TemporaryFile(dir=there).close()
    except OSError:
        refusal = f"--out {options.out}: {there} is no folder to write to; give another"
        raise ValueError(refusal) from None
    command = shlex.join([*parser.prog.split(), *given])
    return options, Output(options.out, command, pdf=options.preset == "full")


def start(
    name: str, doc: str | None, argv: Sequence[str] | None, quick: str, full: P, small: P
) -> tuple[P, int, Output]:
    """The options of a study that has no others.

    Parameters
    ----------
    name : str
        Of the study, or the path of its file.
    doc : str or None
        The docstring of its module.
    argv : sequence of str or None
        As in `parse`.
    quick : str
        What the quick preset does.
    full, small : object
        The parameters of both presets.

    Returns
    -------
    parameters : object
        Of the preset that was chosen.
    jobs : int
        Number of processes.
    out : Output
    """
    options, out = parse(parser(name, doc, quick), argv)
    parameters = small if options.preset == "quick" else full
    return parameters, options.jobs, out


def answer(text: str) -> None:
    """The answer of a study in one sentence, from its numbers: the last words on the screen.

    The report shows it first.
    """
    say(f"answer: {text}")


def missed(text: str) -> None:
    """A limit that was not kept though the study did not fail: a time on a busy machine."""
    say(f"missed: {text}")


def say(line: object) -> None:
    """A line on the screen at once."""
    print(line, flush=True)
