"""How the command line is called; without any other module, so that this can always be said."""

import sys
from pathlib import Path


def program() -> str:
    """How the command is called: "elastocap" where that is installed and used."""
    called = Path(sys.argv[0]).stem if sys.argv else ""
    return "elastocap" if called == "elastocap" else "python -m studies"
