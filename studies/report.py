"""All studies on one page: what each asks, its answer, figures and tables.

Every study is run with the preset into a folder of its own below --out. OUT/report.html opens from
disk without a network: its figures are part of it, its links lead to the files below OUT. Exit
status 1 if a study fails; limits of time that were missed are told and do not fail.
"""

from __future__ import annotations

import contextlib
import datetime
import importlib
import importlib.metadata
import io
import platform
import time
from collections.abc import Sequence
from pathlib import Path

from studies import MODULES, REPORTED, TIMED
from studies.page import Section, page
from studies.shared import command
from studies.shared.table import commit, versions


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
    found = versions()
    for package in ("cvxpy", "matplotlib"):
        with contextlib.suppress(importlib.metadata.PackageNotFoundError):
            found[package] = importlib.metadata.version(package)
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
