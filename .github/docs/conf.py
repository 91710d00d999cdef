"""The reference site: READMEs, theory, tutorials as a gallery, and the API.

`.ci/docs` lays the pages out (pages.py) and builds them; warnings are errors there.
"""

import tomllib
import warnings
from pathlib import Path

HERE = Path(__file__).parent  # the pages as pages.py has laid them out
ROOT = Path((HERE / "root").read_text("utf-8"))

project = "elastocap"
author = "elastocap developers"
project_copyright = author
release = tomllib.loads((ROOT / "pyproject.toml").read_text("utf-8"))["project"]["version"]
extensions = [
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "myst_parser",
    "sphinx_gallery.gen_gallery",
]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
exclude_patterns = ["examples", "sg_execution_times.rst", "**/sg_execution_times.rst"]
myst_heading_anchors = 3

autosummary_generate = True
autodoc_member_order = "bysource"
autodoc_typehints = "none"  # numpydoc's parameters have the types
numpydoc_show_class_members = False
numpydoc_xref_param_type = False
default_role = "literal"
smartquotes = False  # u' is a derivative

sphinx_gallery_conf = {
    "examples_dirs": "examples",
    "gallery_dirs": "tutorials",
    "filename_pattern": r"/[a-z]\w*\.py$",
    "ignore_pattern": r"__init__\.py",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "show_memory": False,
    "show_signature": False,
    "abort_on_example_error": True,
    "reset_argv": "pages.figure_argument",
}
warnings.filterwarnings("ignore", message=".*Agg.*cannot show the figure")

html_theme = "alabaster"
html_theme_options = {
    "description": "A rigid indenter on a thin elastic layer with surface tension and adhesion",
    "fixed_sidebar": False,
    "page_width": "1120px",
    "sidebar_width": "230px",
}
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False


def escape_bars(app, what, name, obj, options, lines):
    """Bars in docstrings are absolute values, no substitutions of reStructuredText."""
    for i, line in enumerate(lines):
        if not line.lstrip().startswith((">>>", "...")):
            lines[i] = line.replace("|", "\\|")


def setup(app):
    app.connect("autodoc-process-docstring", escape_bars, priority=900)
