"""Where the project is, and the path of modules for a Python of its own."""

import os
from pathlib import Path

ROOT = Path(__file__).parents[1]
PLACES = os.pathsep.join(
    str(ROOT / place) for place in ("", "tests", "tests/paths", "tests/studies/scenes")
)
