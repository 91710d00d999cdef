"""All studies in one page: a self-contained HTML file with the verification table on top.

Every study is run with the preset into a folder of its own below --out; what it prints, the figures
it draws and the names of its tables go into OUT/report.html, which opens from disk without a
network. Exit status 1 if a study fails.
"""

from __future__ import annotations

import base64
import contextlib
import datetime
import html
import importlib
import importlib.metadata
import io
import math
import platform
import time
from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from studies import MODULES, REPORTED, TIMED
from studies.shared import command
from studies.shared.table import commit, read, versions

LONG = 2000  # characters that are folded away
PICTURES = {".png": "image/png", ".gif": "image/gif"}
STYLE = """
body { font: 16px/1.45 system-ui, sans-serif; max-width: 75rem; margin: 2rem auto; padding: 0 1rem }
pre { background: #f4f4f4; padding: .7rem; overflow-x: auto; font-size: .8rem }
img { max-width: 100%; margin: .5rem 0 }
table { border-collapse: collapse; font-size: .8rem }
td, th { border-bottom: 1px solid #ddd; padding: .15rem .5rem; text-align: right }
td:nth-child(2), th:nth-child(2) { text-align: left }
.bad { color: #b00020; font-weight: bold }
"""


class Section(NamedTuple):
    """One study: its question, what it printed, its exit status, its folder and its time."""

    name: str
    question: str
    printed: str
    status: int
    folder: Path
    seconds: float


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


def provenance() -> dict[str, str]:
    """Versions, commit, machine and time."""
    found = versions()
    for package in ("cvxpy", "matplotlib"):
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[package] = importlib.metadata.version(package)
    found["commit"] = commit()
    found["machine"] = f"{platform.machine()}, {platform.system()}"
    found["written"] = datetime.datetime.now(datetime.UTC).strftime("%Y-%m-%d %H:%M UTC")
    return found


def verification(table: Path) -> str:
    """The table of `verify`: equation, what, errors on both discretisations, order, verdict."""
    if not table.exists():
        return "<p>verify was not run.</p>"
    columns = ("equation", "what", "error", "order", "fitted_error", "passed")
    lines = ["<table><tr>" + "".join(f"<th>{name}</th>" for name in columns) + "</tr>"]
    for row in read(table):
        mark = "" if row["passed"] == "True" else " class=bad"
        cells = [row["equation"], row["what"], *(_short(row[name]) for name in columns[2:5])]
        cells.append("ok" if row["passed"] == "True" else "FAILED")
        own = "".join(f"<td>{html.escape(cell)}</td>" for cell in cells)
        lines.append(f"<tr{mark}>{own}</tr>")
    return "\n".join([*lines, "</table>"])


def _short(number: str) -> str:
    try:
        return "—" if math.isnan(float(number)) else f"{float(number):.2g}"
    except ValueError:
        return number


def page(sections: Sequence[Section], preset: str) -> str:
    """The whole page; figures are part of it."""
    facts = ", ".join(f"{name} {value}" for name, value in provenance().items())
    failed = [section.name for section in sections if section.status]
    verdict = f"failed: {', '.join(failed)}" if failed else "all studies passed"
    parts = [
        "<!doctype html><html lang=en><meta charset=utf-8><title>elastocap report</title>",
        f"<style>{STYLE}</style><h1>elastocap: all studies, preset {preset}</h1>",
        f"<p><b>{verdict}</b>. {html.escape(facts)}. Made by "
        f"<code>python -m studies report --preset {preset}</code>.</p><h2>Verification</h2>",
    ]
    folders = {section.name: section.folder for section in sections}
    parts.append(verification(folders.get("verify", Path()) / "verify.csv"))
    for section in sections:
        mark = " class=bad" if section.status else ""
        parts.append(f"<h2{mark}>{section.name}</h2><p>{html.escape(section.question)}</p>")
        for picture in sorted(section.folder.rglob("*")):
            if picture.suffix in PICTURES:
                data = base64.b64encode(picture.read_bytes()).decode()
                source = f"data:{PICTURES[picture.suffix]};base64,{data}"
                parts.append(f'<img alt="{html.escape(picture.stem)}" src="{source}">')
        tables = ", ".join(str(table) for table in sorted(section.folder.rglob("*.csv")))
        text = f"<pre>{html.escape(section.printed)}</pre>"
        if len(section.printed) > LONG:
            text = f"<details><summary>what it printed</summary>{text}</details>"
        parts.append(f"{text}<p>{section.seconds:.1f} s; tables: {html.escape(tables)}</p>")
    return "\n".join([*parts, "</html>"])


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
    path = out.text("report.html", page(sections, options.preset))
    print(f"written: {path}")
    return int(any(section.status for section in sections))
