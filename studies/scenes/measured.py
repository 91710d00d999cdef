"""What a scene file says of measured data: how the curve of `fit` is written, a profile's file.

[measured]                               # optional: how `fit` reads DATA
columns = ["Weg [µm]", "Kraft [mN]"]     # depth and force: names or numbers, with missing units
width = 0.01                             # m: length of the line contact, for forces in newtons
curve = 3                                # of an instrument file with several
delimiter = ";"                          # and decimal, encoding, skip; else found from the file

[indenter]
shape = "sampled"
file = "scan.csv"                        # in place of x and z; beside the scene file
columns = ["x", "z [nm]"]                # and unit, delimiter, decimal, encoding, skip
"""

from __future__ import annotations

from pathlib import Path
from typing import Any

from energy import Sampled, read_profile
from energy.text_table import Layout
from studies.scenes.curve_file import Reading
from studies.scenes.table import Table

LAYOUT = ("delimiter", "decimal", "encoding", "skip")
PROFILE = ("file", "columns", "unit", *LAYOUT)


def reading(path: Path, content: Any) -> Reading:
    """The table [measured]. ValueError naming file and key."""
    table = Table(path, "measured", content, ("columns", "width", "curve", *LAYOUT))
    given = table.table
    return table.build(
        Reading,
        _columns(table),
        table.number("width") if "width" in given else None,
        table.build(lambda: Layout(**_layout(table))),
        table.whole("curve", 1) if "curve" in given else None,
    )


def profile(table: Table) -> Sampled:
    """The sampled indenter whose samples stand in a file. ValueError naming file and key."""
    for key in ("x", "z"):
        if key in table.table:
            table.refuse(key, table.table[key], "stands beside file: give one of the two")
    file, kind = table.path.parent / table.text("file"), table.text("kind", "linear")
    unit = table.number("unit") if "unit" in table.table else None
    columns, layout = _columns(table), _layout(table)
    return table.build(lambda: read_profile(file, kind=kind, unit=unit, columns=columns, **layout))


def _columns(table: Table) -> tuple[str, str] | None:
    if "columns" not in table.table:
        return None
    given = table.table["columns"]
    kinds = isinstance(given, list) and all(type(c) in (str, int) for c in given)
    if not kinds or len(given) != 2:
        table.refuse("columns", given, "must be a list of two names or numbers of columns")
    first, second = map(str, given)
    return first, second


def _layout(table: Table) -> dict[str, Any]:
    found: dict[str, Any] = {k: table.text(k) for k in LAYOUT[:3] if k in table.table}
    return found | ({"skip": table.whole("skip", 0)} if "skip" in table.table else {})
