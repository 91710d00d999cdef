"""What pyproject.toml cannot say: README.md as a package index shows it, without files beside it.

Its figures are left out there, and links to files of the source are plain words, unless
pyproject.toml gives the address of the repository as [project.urls] Source.
"""

import re
import tomllib
from pathlib import Path

from setuptools import setup

HERE = Path(__file__).parent
FIGURE, LINK = re.compile(r"!\[([^]]*)\]\(([^):]+)\)"), re.compile(r"\[([^]]+)\]\(([^):]+)\)")


def page(readme: str, source: str | None) -> str:
    """The text of README.md for readers elsewhere."""
    if source:
        shown = FIGURE.sub(rf"![\1]({source}/raw/HEAD/\2)", readme)
        return LINK.sub(
            lambda m: m[0] if "://" in m[2] else f"[{m[1]}]({source}/blob/HEAD/{m[2]})", shown
        )
    return LINK.sub(r"\1", FIGURE.sub(r"*(figure: \1)*", readme))


if __name__ == "__main__":
    project = tomllib.loads((HERE / "pyproject.toml").read_text("utf-8"))["project"]
    text = page((HERE / "README.md").read_text("utf-8"), project.get("urls", {}).get("Source"))
    setup(long_description=text, long_description_content_type="text/markdown")
