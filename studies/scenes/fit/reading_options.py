"""The options of the command line that say how a measured curve is written."""

from __future__ import annotations

import argparse
from dataclasses import replace
from typing import Any

from energy.text_lines import DELIMITERS, NUMBER
from studies.scenes.curve_file import Reading
from studies.scenes.measured import LAYOUT


def add(parser: argparse.ArgumentParser) -> None:
    """How DATA is written, each in place of the same key of [measured] in the scene file."""
    group = parser.add_argument_group("how DATA is written, found from the file where not given")
    about = 'of depth and force: names or numbers from 1, with missing units, as "2 [mN]"'
    group.add_argument("--columns", nargs=2, metavar="NAME", help=about)
    about = "length of the line contact in m, for forces in newtons"
    group.add_argument("--width", type=float, metavar="M", help=about)
    about = "number of the curve in an instrument file with several"
    group.add_argument("--curve", type=int, metavar="N", help=about)
    group.add_argument("--delimiter", choices=DELIMITERS, help="between columns of text")
    group.add_argument("--decimal", choices=NUMBER, help="decimal mark of text")
    group.add_argument("--encoding", metavar="NAME", help="of text, such as utf-16 or cp1252")
    group.add_argument("--skip", type=int, metavar="LINES", help="of text, above the data")


def reading(options: argparse.Namespace, given: Reading) -> Reading:
    """The reading of the scene file with what the command line has in its place."""
    said = {key: value for key, value in vars(options).items() if value is not None}
    layout = replace(given.layout, **{key: said[key] for key in LAYOUT if key in said})
    own = {"columns": tuple, "width": float}
    changed: dict[str, Any] = {key: kind(said[key]) for key, kind in own.items() if key in said}
    return replace(given, layout=layout, number=said.get("curve", given.number), **changed)
