"""Questions asked of the simulator, one module each; the only place with figures and files.

A study is a docstring with the question and the formula, a block of parameters, `run(...)` that
returns numbers, functions that draw them, and `main(argv)` that returns an exit status. Tests call
`run` on a small preset. A new study is such a module, and its name below.
"""

TIMED = ("lattice_speed", "fitted_speed", "path_speed", "skipping", "runtime_vs_error")  # one job
REPORTED = (
    *("verify", "contact_angle", "applicability", "hysteresis", "pull_off", "rough", "tolerance"),
    *("stress", *TIMED),
)
STUDIES = (*REPORTED, "run", "new", "sweep", "fit", "report")
