"""Lay out the pages of the site in a folder: `python pages.py FOLDER`, before sphinx-build.

READMEs link each other and files of the repository by relative paths. Those that are pages are
linked as pages, figures are copied, and other files are named without a link.
"""

import re
import shutil
import sys
from pathlib import Path

HERE = Path(__file__).resolve().parent
PAGES = {
    "README.md": "index.md",
    "energy/THEORY.md": "theory.md",
    "energy/README.md": "physics.md",
    "discretization/README.md": "methods.md",
    "studies/README.md": "studies.md",
    ".github/ALTERNATIVES.md": "alternatives.md",
    ".github/CONTRIBUTING.md": "contributing.md",
    ".github/CHANGELOG.md": "changes.md",
}
CONTENTS = """
```{toctree}
:hidden:

theory
physics
methods
studies
tutorials/index
api
alternatives
contributing
changes
```
"""
API = {
    "energy": ("The physics: layer, surfaces, indenters and their scene.", ("cards",)),
    "discretization": ("States and paths of a scene, and what they are found with.", ()),
    "studies": ("Fits of measured curves from Python.", ()),
}
HEADER = """
Tutorials
=========

Plain scripts, each with its figure. Start from the one that is nearest to your case.
"""
STUDIES = ("fit", "read_curve", "Curve")


def main(target: Path, root: Path) -> None:
    """Write all pages into `target`."""
    target.mkdir(parents=True, exist_ok=True)
    for name in ("conf.py", "pages.py"):
        shutil.copy(HERE / name, target / name)
    shutil.copytree(HERE / "_static", target / "_static", dirs_exist_ok=True)
    (target / "root").write_text(str(root), "utf-8")
    for source, page in PAGES.items():
        text = linked((root / source).read_text("utf-8"), root / source, root, target)
        (target / page).write_text(text + CONTENTS * (page == "index.md"), "utf-8")
    examples = target / "examples"
    shutil.copytree(root / "studies" / "tutorials", examples, dirs_exist_ok=True)
    (examples / "GALLERY_HEADER.rst").write_text(HEADER, "utf-8")
    (target / "api.rst").write_text(api(root), "utf-8")


def linked(text: str, source: Path, root: Path, target: Path) -> str:
    """The text with its links and figures as they are on the site."""

    def link(found: re.Match[str]) -> str:
        mark, words, where = found.groups()
        path = (source.parent / where).resolve()
        if mark:
            place = target / "figures" / path.name
            place.parent.mkdir(exist_ok=True)
            shutil.copy(path, place)
            return f"![{words}](figures/{path.name})"
        page = PAGES.get(path.relative_to(root).as_posix())
        return f"[{words}]({page})" if page else words

    return re.sub(r"(!?)\[([^\]]+)\]\(([^):#]+)\)", link, text)


def api(root: Path) -> str:
    """The page of the API: a table for each package, with a page for each name."""
    sys.path.insert(0, str(root))
    import discretization
    import energy

    names = {"energy": energy.__all__, "discretization": discretization.__all__, "studies": STUDIES}
    parts = ["API\n===\n"]
    for package, (words, left_out) in API.items():
        own = [f"   {name}" for name in sorted(names[package]) if name not in left_out]
        parts += [
            f"{package}\n{'-' * len(package)}\n",
            f"{words}\n",
            f".. currentmodule:: {package}\n",
        ]
        parts += [".. autosummary::\n   :toctree: api\n\n" + "\n".join(own) + "\n"]
    return "\n".join(parts)


def figure_argument(gallery_conf: object, script_vars: object) -> list[str]:
    """The argument of a tutorial in the gallery: where its own copy of the figure goes."""
    return [str(HERE / "drawn.png")]


if __name__ == "__main__":
    main(Path(sys.argv[1]), HERE.parents[1])
