"""Studies, tools and benchmarks; the only place with figures and files.

From Python, `studies.fit(scene, studies.read_curve(path))` fits a measured curve.

A study is a module: a docstring with the question and the formula, a block of parameters,
`run(...)` that returns numbers, functions that draw and tabulate them, and `main(argv)` that
returns an exit status. Tests call `run` on a small preset. `python -m studies new --study FILE.py`
writes one to start from, and `python -m studies FILE.py` runs it wherever it lies; a study of this
package also stands in the table below.

shared/       command line, tables, figures, timing, processes, scenes that several studies use
scenes/       scene files and what is done with them: new, run, sweep, fit, plan
benchmarks/   time against error, and how far tolerances and digits can be trusted
verify/, contact_angle/, applicability/   each larger study
"""

import importlib
from typing import Any

TIMED = ("skipping", "runtime_vs_error")  # one job
MODULES = {
    **{name: f"studies.{name}.study" for name in ("verify", "contact_angle", "applicability")},
    **{
        name: f"studies.{name}"
        for name in ("hysteresis", "pull_off", "sphere", "layer", "rough", "levels")
    },
    "stress": "studies.benchmarks.stress.study",
    **{name: f"studies.benchmarks.{name}" for name in TIMED},
    "run": "studies.scenes.run",
    "new": "studies.scenes.new",
    "explore": "studies.scenes.explore",
    "sweep": "studies.scenes.sweep.study",
    "fit": "studies.scenes.fit.study",
    "plan": "studies.scenes.fit.plan",
    "report": "studies.report",
}
STUDIES = tuple(MODULES)
TOOLS = ("new", "run", "explore", "sweep", "fit", "plan", "report")
BENCHMARKS = ("stress", *TIMED)
GROUPS = {
    "Tools, for scenes and data of your own": TOOLS,
    "Studies, each a question with figures": tuple(
        name for name in STUDIES if name not in (*TOOLS, *BENCHMARKS)
    ),
    "Benchmarks": BENCHMARKS,
}
REPORTED = STUDIES[: STUDIES.index("run")]
PUBLIC = {
    "fit": "studies.scenes.fit.estimate",
    "Curve": "studies.scenes.fit.force_curve",
    "Reading": "studies.scenes.curve_file",
    "read_curve": "studies.scenes.curve_file",
}


def __getattr__(name: str) -> Any:
    """The functions for use from Python, imported when they are needed."""
    if name in PUBLIC:
        return getattr(importlib.import_module(PUBLIC[name]), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
