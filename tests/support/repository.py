"""Where the repository is, and where a Python of its own finds the modules of the tests."""

import os
from pathlib import Path

ROOT = Path(__file__).parents[2]
MODULE_PATH = os.pathsep.join([str(ROOT), str(ROOT / "tests")])  # a value for PYTHONPATH
