"""All studies on one page: what each asks, its answer, figures and tables.

Every study is run with the preset into a folder of its own below --out. OUT/report.html opens from
disk without a network: its figures are part of it, its links lead to the files below OUT. Exit
status 1 if a study fails; limits of time that were missed are told and do not fail.
"""

import base64
import contextlib
import datetime
import html
import importlib
import io
import math
import platform
import re
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from PIL import Image, UnidentifiedImageError

from studies import MODULES, REPORTED, TIMED
from studies.shared import command
from studies.shared.table import commit, read, versions

DOCUMENTS = (".md", ".pdf")
LONGEST = 100  # rows of a table that are shown
STYLE = """
:root { color-scheme: light dark; --line: #ccc; --soft: #f4f4f4; --good: #00704f; --bad: #b00020 }
@media (prefers-color-scheme: dark) {
  :root { --line: #555; --soft: #222; --good: #4cc9a0; --bad: #ff8095 }
}
body { font: 16px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem;
  overflow-wrap: break-word }
h2 { margin-top: 3rem; border-top: 1px solid var(--line); padding-top: 1rem }
nav li { margin: .4rem 0 }
.good { color: var(--good) } .bad { color: var(--bad) } .good, .bad { font-weight: bold }
.answer { font-size: 1.1rem }
pre, .wide, figure { overflow-x: auto }
pre { background: var(--soft); padding: .7rem; font-size: .8rem }
figure { margin: 1.5rem 0 }
img { max-width: 100%; background: white; display: block }
figcaption { margin-top: .3rem }
table { border-collapse: collapse; font-size: .8rem }
td, th { border-bottom: 1px solid var(--line); padding: .15rem .5rem; text-align: right;
  overflow-wrap: normal }
td.text, th.text { text-align: left }
@media screen and (max-width: 600px) { img { min-width: 40rem; max-width: none } }
@media print {
  body { max-width: none; margin: 0; font-size: 10pt }
  figure, tr { break-inside: avoid } h2 { break-after: avoid } thead { display: table-header-group }
  td, th { padding: 0 .2rem; white-space: normal } table { font-size: 6pt }
  pre { white-space: pre-wrap }
}
"""


class Section(NamedTuple):
    """One study: its question, what it printed, its exit status, its folder and its time."""

    name: str
    question: str
    printed: str
    status: int
    folder: Path
    seconds: float

    def said(self, word: str) -> list[str]:
        """What stands behind a word at the beginning of printed lines: answer, missed."""
        return re.findall(rf"^{word}: (.*)$", self.printed, re.M)

    @property
    def verdict(self) -> str:
        """One of "failed", "passed", and "passed, but" for limits that were missed."""
        missed = f", but missed {len(self.said('missed'))} of its limits"
        return "failed" if self.status else "passed" + missed * bool(self.said("missed"))


def page(sections: Sequence[Section], command: str, facts: str) -> str:
    """The whole page. facts: versions and the like."""
    title = "elastocap: all studies"
    parts = [
        "<!doctype html><html lang=en><meta charset=utf-8>"
        "<meta name=viewport content='width=device-width, initial-scale=1'>"
        f"<title>{title}</title><style>{STYLE}</style><h1>{title}</h1>",
        f"<p>{verdict(sections)}</p><p>Made by <code>{_text(command)}</code>: {_text(facts)}.</p>",
        "<nav><h2>Contents</h2><ul>",
    ]
    for one in sections:
        answers = " ".join(map(_text, one.said("answer")))
        link = f'<a href="#{one.name}">{one.name}</a>'
        parts.append(f"<li>{link}: {_text(one.question)} {_marked(one)}. {answers}</li>")
    parts.append("</ul></nav>")
    for one in sections:
        parts += _section(one)
    return "\n".join([*parts, "</html>"])


def verdict(sections: Sequence[Section]) -> str:
    """One line that agrees with all that follow: what failed, which limits were missed."""
    failed = [one.name for one in sections if one.status]
    missed = [one.name for one in sections if not one.status and one.said("missed")]
    if failed:
        told = f"<span class=bad>{len(failed)} of {len(sections)} studies failed</span>"
        limits = f" Limits missed: {', '.join(missed)}." if missed else ""
        return f"{told}: {', '.join(failed)}.{limits}"
    if missed:
        told = f"All {len(sections)} studies passed, but not all their limits were kept"
        return f"<span class=bad>{told}</span>: {', '.join(missed)}."
    return f"<span class=good>All {len(sections)} studies passed.</span>"


def _marked(one: Section) -> str:
    return f"<span class={'good' if one.verdict == 'passed' else 'bad'}>{one.verdict}</span>"


def _section(one: Section) -> list[str]:
    """Heading, answer, limits missed, figures, tables, and what was printed."""
    parts = [f"<h2 id={one.name}>{one.name}</h2><p>{_text(one.question)} {_marked(one)}.</p>"]
    parts += [f"<p class=answer>{_text(answer)}</p>" for answer in one.said("answer")]
    parts += [f"<p class=bad>Missed: {_text(missed)}</p>" for missed in one.said("missed")]
    files = sorted(path for path in one.folder.rglob("*") if path.is_file())
    parts += [_figure(one, path) for path in files if path.suffix == ".png"]
    parts += [_table(one, path) for path in files if path.suffix == ".csv"]
    links = ", ".join(_link(one, path) for path in files if path.suffix in DOCUMENTS)
    parts.append(f"<p>{one.seconds:.1f} s{'; also: ' * bool(links)}{links}</p>")
    folded = f"<details{' open' * bool(one.status)}><summary>What it printed</summary>"
    return [*parts, f"{folded}{printed(one.printed)}</details>"]


def _figure(one: Section, path: Path) -> str:
    content = path.read_bytes()
    told = _text(caption(content) or path.stem.replace("_", " "))
    source = f"data:image/png;base64,{base64.b64encode(content).decode()}"
    shown = f'<img alt="{told}" src="{source}">'
    return f"<figure>{shown}<figcaption>{told} ({_link(one, path)})</figcaption></figure>"


def caption(picture: bytes) -> str:
    """The title that a picture carries; empty if it has none."""
    with contextlib.suppress(UnidentifiedImageError), Image.open(io.BytesIO(picture)) as image:
        return str(image.info.get("Title", ""))
    return ""


def _table(one: Section, path: Path) -> str:
    """A CSV file, folded; that of `verify` is shown with the columns that judge."""
    rows = read(path)
    columns = list(rows[0]) if rows else []
    if path.name == "verify.csv":
        columns = ["equation", "what", "error", "order", "fitted_error", "passed"]
    cells = [[row[name] or "" for name in columns] for row in rows[:LONGEST]]
    more = f", the first {LONGEST} of them" if len(rows) > LONGEST else ""
    folded = f"<details{' open' * (path.name == 'verify.csv')}><summary>{path.name}"
    summary = f"{folded}: {len(rows)} rows{more}</summary>"
    return f"{summary}{grid(columns, cells)}<p>All of it: {_link(one, path)}</p></details>"


def grid(columns: Sequence[str], rows: Sequence[Sequence[str]]) -> str:
    """A table; numbers to the right, rows with a "False" marked."""
    kinds = [
        " class=text" * any(_number(row[i]) is None for row in rows) for i in range(len(columns))
    ]
    head = "".join(f"<th{k}>{_text(c)}</th>" for k, c in zip(kinds, columns, strict=True))
    lines = []
    for row in rows:
        cells = "".join(f"<td{k}>{_short(cell)}</td>" for k, cell in zip(kinds, row, strict=True))
        lines.append(f"<tr{' class=bad' * ('False' in row)}>{cells}</tr>")
    body = "\n".join(lines)
    return f"<div class=wide><table><thead><tr>{head}</tr></thead>{body}</table></div>"


def printed(text: str) -> str:
    """Printed lines; tables in Markdown among them as tables."""
    parts = []
    for block in re.split(r"((?:^\|.*\n)+)", text, flags=re.M):
        rows = [[c.strip() for c in line.strip("| ").split("|")] for line in block.splitlines()]
        if block.startswith("|") and len({len(row) for row in rows}) == 1 and len(rows) > 2:
            parts.append(grid(rows[0], rows[2:]))
        elif block.strip():
            parts.append(f"<pre>{_text(block)}</pre>")
    return "".join(parts)


def _number(cell: str) -> float | None:
    try:
        return float(cell)
    except ValueError:
        return None if cell else math.nan


def _short(cell: str) -> str:
    number = _number(cell)
    if number is None or not cell or number.is_integer():
        return _text(cell)
    return "—" if math.isnan(number) else f"{number:.4g}"


def _text(text: str) -> str:
    return html.escape(" ".join(text.split(" ")))


def _link(one: Section, path: Path) -> str:
    """A file by its place beside the page."""
    return f'<a href="{path.relative_to(one.folder.parent).as_posix()}">{path.name}</a>'


def run(name: str, preset: str, out: Path, jobs: int) -> Section:
    """Run one study into its own folder and keep what it says."""
    module = importlib.import_module(MODULES[name])
    own = [] if name in TIMED else ["--jobs", str(jobs)]
    arguments = ["--preset", preset, "--out", str(out / name), *own]
    text, start = io.StringIO(), time.perf_counter()
    with contextlib.redirect_stdout(text):
        try:
            status = int(module.main(arguments))
        except (ValueError, RuntimeError, OSError) as error:
            print(f"{name}: {error}")
            status = 2
    question = (module.__doc__ or name).splitlines()[0]
    seconds = time.perf_counter() - start
    return Section(name, question, text.getvalue(), status, out / name, seconds)


def facts() -> str:
    """Versions, commit, machine and time."""
    found = versions("cvxpy", "matplotlib")
    found["commit"] = commit()
    found["machine"] = f"{platform.machine()}, {platform.system()}"
    found["written"] = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC")
    return ", ".join(f"{name} {version}" for name, version in found.items())


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    parser = command.parser("report", __doc__, "the quick presets of all")
    command.some_of(parser, "--only", REPORTED)
    options, out = command.parse(parser, argv)
    sections = []
    for i, name in enumerate(options.only, 1):
        print(f"{i} of {len(options.only)}: {name} ...", flush=True)
        sections.append(run(name, options.preset, out.folder, options.jobs))
        verdict = "FAILED" if sections[-1].status else ""
        print(f"{name}: {sections[-1].seconds:.1f} s {verdict}".rstrip(), flush=True)
    path = out.text("report.html", page(sections, out.command, facts()))
    print(f"written: {path}")
    return int(any(section.status for section in sections))
