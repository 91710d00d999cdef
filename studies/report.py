"""All studies on one page: what each asks, its answer, figures and tables.

Every study is run with the preset into a folder of its own below --out. OUT/report.html opens from
disk without a network: its figures are part of it, its links lead to the tables, documents and
printed lines below OUT. It is there from the first study on and grows; if it is stopped, the same
command goes on after the last study that passed. Exit status 1 if a study fails; limits of time
that were missed are told and do not fail.
"""

# Conventions:
# - `command.parser` has the options of all studies; `command.parse` gives them and the output
#   `out`.
# - MODULES are the modules of the studies by name, REPORTED those on the page, TIMED those whose
#   times are measured, one process at a time.
# - A `Store` is the file of what is done, a line each by `found_line`; `read` are the rows of a
#   CSV as dicts from column to text.

import base64
import contextlib
import datetime
import functools
import html
import importlib
import io
import math
import platform
import re
import time
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import NamedTuple

from PIL import Image, UnidentifiedImageError

from studies import MODULES, REPORTED, TIMED
from studies.scenes.sweep.store import Store, found_line
from studies.shared import command
from studies.shared.table import commit, read, versions

DOCUMENTS = (".csv", ".md", ".pdf", ".txt")
SHADES = 128  # colours of a figure on the page: 7 bits a pixel instead of 24
SCALE = 0.62  # of all figures on the page, so that 10 points are 12 pixels in each of them
LAST = 40  # lines of a study that failed
JUDGED = ("equation", "passed", "what", "error", "order", "fitted_error")  # of verify.csv
HEADS = {"error": "error on nodes", "order": "order on nodes", "fitted_error": "error on the mesh"}
TEXTS = ("what", "passed")
VERDICTS = {"True": "yes", "False": "NO"}
STYLE = """
:root { color-scheme: light dark; --line: #ccc; --soft: #f4f4f4; --good: #00704f; --bad: #b00020 }
@media (prefers-color-scheme: dark) {
  :root { --line: #555; --soft: #222; --good: #4cc9a0; --bad: #ff8095 }
}
body { font: 16px/1.5 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem;
  overflow-wrap: break-word }
h2 { margin-top: 3rem; border-top: 1px solid var(--line); padding-top: 1rem }
nav ul { list-style: none; padding: 0; display: flex; flex-wrap: wrap; gap: .2rem 1.5rem }
.good { color: var(--good) } .bad { color: var(--bad) } .good, .bad { font-weight: bold }
.answer { font-size: 1.1rem }
pre, .wide, figure { overflow-x: auto }
pre { background: var(--soft); padding: .7rem; font-size: .8rem }
figure { margin: 1.5rem 0 }
img { width: var(--width); max-width: 100%; background: white; display: block }
figcaption { margin-top: .3rem }
table { border-collapse: collapse; font-size: .8rem }
td, th { border-bottom: 1px solid var(--line); padding: .15rem .5rem; text-align: right;
  overflow-wrap: normal }
td.text, th.text { text-align: left }
summary { cursor: pointer; padding: .4rem 0 }
@media screen and (max-width: 600px) {
  body { margin: 1rem auto; padding: 0 .6rem }
  img { width: calc(.8 * var(--width)); max-width: none }
  td, th { padding: .1rem .25rem }
}
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


def page(sections: Sequence[Section], command: str, facts: str, waiting: int = 0) -> str:
    """The whole page. facts: versions and the like; waiting: how many studies are still to run."""
    title = "elastocap: all studies"
    more = f" {waiting} more are to come." if waiting else ""
    parts = [
        "<!doctype html><html lang=en><meta charset=utf-8>"
        "<meta name=viewport content='width=device-width, initial-scale=1'>"
        f"<title>{title}</title><style>{STYLE}</style><h1>{title}</h1>",
        f"<p>{verdict(sections)}{more}</p>",
        "<nav><ul>",
    ]
    for one in sections:
        parts.append(f'<li><a href="#{one.name}">{one.name}</a> {_marked(one)}</li>')
    parts.append("</ul></nav>")
    for one in sections:
        parts += _section(one)
    made = f"<footer><p>Made by <code>{_text(command)}</code>: {_text(facts)}.</p></footer>"
    return "\n".join([*parts, made, "</html>"])


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
    """The verdict of a study as HTML, in green if it passed with all its limits, else in red."""
    return f"<span class={'good' if one.verdict == 'passed' else 'bad'}>{one.verdict}</span>"


def _section(one: Section) -> list[str]:
    """Heading, figures, answers, limits missed; the rest as links, but for what has failed."""
    parts = [f"<h2 id={one.name}>{one.name}</h2><p>{_text(one.question)} {_marked(one)}.</p>"]
    files = sorted(path for path in one.folder.rglob("*") if path.is_file())
    parts += [_figure(one, path) for path in files if path.suffix == ".png"]
    parts += [f"<p class=answer>{_text(answer)}</p>" for answer in one.said("answer")]
    parts += [f"<p class=bad>Missed: {_text(missed)}</p>" for missed in one.said("missed")]
    parts += [_verified(path) for path in files if path.name == "verify.csv"]
    if one.status:
        last = "\n".join(one.printed.splitlines()[-LAST:])
        parts.append(f"<p>The end of what it printed:</p><pre>{_text(last)}</pre>")
    links = [_link(one, path) for path in files if path.suffix in DOCUMENTS]
    return [*parts, f"<p>{one.seconds:.1f} s{'; ' * bool(links)}{', '.join(links)}</p>"]


def _figure(one: Section, path: Path) -> str:
    """A picture of a study as HTML: embedded in the page, with its caption and a link to it."""
    content = path.read_bytes()
    told = _text(caption(content) or path.stem.replace("_", " "))
    source = f"data:image/png;base64,{base64.b64encode(smaller(content)).decode()}"
    shown = f'<img style="--width:{width(content)}px" alt="{told}" src="{source}">'
    return f"<figure>{shown}<figcaption>{told} ({_link(one, path)})</figcaption></figure>"


def caption(picture: bytes) -> str:
    """The title that a picture carries; empty if it has none."""
    with contextlib.suppress(UnidentifiedImageError), Image.open(io.BytesIO(picture)) as image:
        return str(image.info.get("Title", ""))
    return ""


def width(picture: bytes) -> int:
    """Of a picture on the page, in pixels; 0 if it is none."""
    with contextlib.suppress(UnidentifiedImageError), Image.open(io.BytesIO(picture)) as image:
        return round(SCALE * image.width)
    return 0


@functools.cache
def smaller(picture: bytes) -> bytes:
    """A picture in fewer colours; as it is if it is none. Kept: the page is written after each."""
    with contextlib.suppress(UnidentifiedImageError), Image.open(io.BytesIO(picture)) as image:
        drawn = io.BytesIO()
        few = image.convert("RGB").quantize(SHADES, dither=Image.Dither.NONE)
        few.save(drawn, "PNG", compress_level=8)
        return drawn.getvalue()
    return picture


def _verified(path: Path) -> str:
    """The table of `verify`, with the columns that judge: checks that failed, and the rest folded.

    A fold opens on a click; on paper, and without one, what failed is still there.
    """
    rows = read(path)
    failed = [row for row in rows if row["passed"] == "False"]
    passed = [row for row in rows if row["passed"] != "False"]
    parts = [_checks(failed)] if failed else []
    if passed:
        words = f"{len(passed)} of {len(rows)} checks passed: errors and orders"
        parts.append(f"<details><summary>{words}</summary>{_checks(passed)}</details>")
    return "".join(parts)


def _checks(rows: Sequence[Mapping[str, str]]) -> str:
    """A table of some checks."""
    head = "".join(f"<th{_class(name)}>{HEADS.get(name, name)}</th>" for name in JUDGED)
    lines = []
    for row in rows:
        cells = "".join(f"<td{_class(name)}>{_short(row[name])}</td>" for name in JUDGED)
        lines.append(f"<tr{' class=bad' * (row['passed'] == 'False')}>{cells}</tr>")
    body = "\n".join(lines)
    return f"<div class=wide><table><thead><tr>{head}</tr></thead>{body}</table></div>"


def _class(column: str) -> str:
    """The attribute of a cell of HTML that sets texts to the left; "" for a column of numbers."""
    return " class=text" * (column in TEXTS)


def _short(cell: str) -> str:
    """A cell, its number in four digits; a dash for a number that is none; a verdict as a word."""
    if cell in VERDICTS:
        return VERDICTS[cell]
    try:
        number = float(cell)
    except ValueError:
        return _text(cell)
    return "—" if math.isnan(number) else f"{number:.4g}"


def _text(text: str) -> str:
    """A text as HTML shows it, with & and < escaped."""
    return html.escape(" ".join(text.split(" ")))


def _link(one: Section, path: Path) -> str:
    """A file by its place beside the page."""
    return f'<a href="{path.relative_to(one.folder.parent).as_posix()}">{path.name}</a>'


def run(name: str, preset: str, out: Path, jobs: int) -> Section:
    """Run one study into its own folder and keep what it says, also there."""
    module = importlib.import_module(MODULES[name])
    own = [] if name in TIMED else ["--jobs", str(jobs)]
    arguments = ["--preset", preset, "--out", str(out / name), *own]
    text = io.StringIO()
    start = time.perf_counter()
    with contextlib.redirect_stdout(text):
        try:
            status = int(module.main(arguments))
        except (ValueError, RuntimeError, OSError) as error:
            print(f"{name}: {error}")
            status = 2
    seconds = time.perf_counter() - start
    command.Output(out / name, "").text("printed.txt", text.getvalue())
    question = (module.__doc__ or name).splitlines()[0]
    return Section(name, question, text.getvalue(), status, out / name, seconds)


def facts() -> dict[str, str]:
    """Versions, commit and machine."""
    machine = f"{platform.machine()}, {platform.system()}"
    return {**versions("cvxpy", "matplotlib"), "commit": commit(), "machine": machine}


def main(argv: Sequence[str] | None = None) -> int:
    """Command line of the study."""
    parser = command.parser("report", __doc__, "the quick presets of all")
    command.some_of(parser, "--only", REPORTED)
    options, out = command.parse(parser, argv)
    names = options.only
    made = facts()
    identity = {"report": options.preset, "studies": names, "made_with": made}
    sections: dict[int, Section] = {}
    with Store(out.at("report.jsonl"), identity) as store:
        for at, line in store.results().items():
            sections[at] = Section(folder=out.folder / names[at], **line["found"])
        for at, name in enumerate(names):
            print(
                f"{at + 1} of {len(names)}: {name} {'kept' if at in sections else '...'}",
                flush=True,
            )
            if at not in sections:
                one = sections[at] = run(name, options.preset, out.folder, options.jobs)
                print(
                    f"{name}: {one.seconds:.1f} s {'FAILED' * bool(one.status)}".rstrip(),
                    flush=True,
                )
                kept = {key: value for key, value in one._asdict().items() if key != "folder"}
                store.add([found_line(at, kept)] * (not one.status))
            path = _written(out, sections, names, made)
    store.path.unlink()
    print(f"written: {path}")
    return int(any(section.status for section in sections.values()))


def _written(
    out: command.Output, sections: Mapping[int, Section], names: Sequence[str], made: dict[str, str]
) -> Path:
    """The page as far as it is known."""
    now = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC")
    said = ", ".join(f"{name} {version}" for name, version in {**made, "written": now}.items())
    known = [sections[at] for at in sorted(sections)]
    return out.text("report.html", page(known, out.command, said, len(names) - len(known)))
