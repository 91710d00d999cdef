"""How does a scene file begin? Writes a commented one, with the defaults shown, to edit and run.

    python -m studies new FILE.toml
    python -m studies run FILE.toml

What is commented out is optional. studies/scenes/file.py documents every key. Likewise for a study
of your own, in Python:

    python -m studies new --study FILE.py
    python -m studies FILE.py --preset quick
"""

from __future__ import annotations

import argparse
from collections.abc import Sequence
from pathlib import Path

STUDY = Path(__file__).parent.parent / "template.py"
TEMPLATE = """\
# A scene for `python -m studies run THIS_FILE`. SI units, without quotes; everything is per unit
# length of the line contact. Lines that are commented out are optional and show the default or an
# example. A list [1.0, 2.0] or a range { from = 1.0, to = 2.0, steps = 11 } for any number in the
# sections makes a sweep; spacing = "log" in a range spaces it evenly in its logarithm.

title = "Soft film under a glass cylinder"
source = "where the parameters come from"

# Depths d in m of the equilibria: a number, a list or a range. d > 0 is into the layer; contact
# begins at d = 0, and d < 0 is reached by touching first and pulling then.
depth = { from = 0.32e-6, to = -0.32e-6, steps = 33 }

[layer]
E = 2.5e3  # Young's modulus, Pa
nu = 0.3  # Poisson's ratio, below 0.5
h = 5e-6  # thickness, m; thin: d << h << a, and not above l = √(γ₁h/Ẽ), here 10e-6

[surfaces]  # J/m²
gamma1 = 0.07  # surface tension of the layer
w = 0.06e-3  # work of adhesion; or in its place gamma2 (indenter) and gamma12 (interface):
# gamma2 = 0.03
# gamma12 = 0.09994

# Surface energies of a contact that opens (adhesion hysteresis): as [surfaces], without gamma1, and
# no smaller w. The state then depends on the path: use [path] in place of depth.
# [opening]
# w = 0.12e-3

[indenter]
shape = "parabola"
R = 0.02  # m: f = x²/(2R)
# shape = "plane"
# shape = "flat_punch"  # half_width in m
# shape = "wedge"       # delta in rad, or delta_degrees
# shape = "power_law"   # f = c |x|^n: c, n
# shape = "sampled"     # x = [...], z = [...] in m, kind = "linear" or "smooth"; or in their place
# file = "scan.csv"     # text; columns = ["x [µm]", "z [nm]"] by name or number
# tilted = 0.0   # slope
# shifted = 0.0  # m

# A load path with its events and loop: turning points, joined by `steps` steps each. One of
# depths (m), forces (N/m), or drives (m): the far end of a spring of machine_stiffness (Pa).
# [path]
# depths = [-0.6e-6, 0.3e-6, -0.6e-6]
# forces = [0.0, 0.015, -0.07]
# drives = [-1.2e-6, 0.4e-6, -1.2e-6]
# machine_stiffness = 1e5
# steps = 50

# How `python -m studies fit DATA` reads its file, where that does not say it or cannot be found.
# [measured]
# columns = ["Depth [µm]", "3 [mN]"]  # depth and force: names or numbers, with units
# width = 0.01                        # m, length of the line contact, for a force in newtons

[options]
# slopes = "small"    # "small": the paper's energy; "finite": true lengths of the surfaces
# method = "auto"     # "auto", "fitted", "lattice"
# branch = "adhered"  # "adhered": reached by touching; "global": the lowest energy
# spacing = 1e-7      # m, distance of the nodes; method = "lattice" only
# rtol = 1e-8         # relative error asked for
"""


def write(path: Path, ending: str, text: str) -> None:
    """Write a file to begin from. ValueError if it exists or its name ends otherwise."""
    if path.suffix != ending:
        raise ValueError(f"FILE = {str(path)!r} must end in {ending}; give such a name")
    path.parent.mkdir(parents=True, exist_ok=True)
    try:
        with path.open("x", encoding="utf-8") as file:
            file.write(text)
    except FileExistsError:
        raise ValueError(f"FILE = {str(path)!r} exists; give another name") from None


def main(argv: Sequence[str] | None = None) -> int:
    """Write the file and say what comes next."""
    parser = argparse.ArgumentParser(prog="python -m studies new", description=__doc__)
    parser.formatter_class = argparse.RawDescriptionHelpFormatter
    which = parser.add_mutually_exclusive_group(required=True)
    which.add_argument("file", type=Path, nargs="?", metavar="FILE.toml", help="must not exist yet")
    about = "write a study to edit instead, which must not exist yet"
    which.add_argument("--study", type=Path, metavar="FILE.py", help=about)
    options = parser.parse_args(argv)
    if options.study is None:
        write(options.file, ".toml", TEMPLATE)
        print(f"written: {options.file}; edit it, then: python -m studies run {options.file}")
    else:
        write(options.study, ".py", STUDY.read_text("utf-8"))
        print(f"written: {options.study}; edit it, then: python -m studies {options.study}")
    return 0
