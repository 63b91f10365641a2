"""How Sphinx builds the pages: `make docs`. Nothing is fetched, neither while building nor while reading."""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

import diffdrive_mj

project = "diffdrive_mj"
version = release = diffdrive_mj.__version__
root_doc = "docs/index"
# The pages stay where they are, so that a link works on the code host and in the build alike.
include_patterns = ["*.md", "docs/**", "experiments/*.md", "models/*.md"]
exclude_patterns = ["**/.*", "node_modules", "results", "build", "dist", "docs/_*", "diffdrive_mj", "tests"]

extensions = [
    "myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon",
    "docstrings", "reference", "links", "mathml", "notebooks",
]  # fmt: skip
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_type_aliases = {name: name for name in ("ArrayLike", "Array", "Method", "Step")}
autodoc_typehints = "signature"
napoleon_use_ivar = True
napoleon_use_rtype = False
highlight_language = "none"
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 88
add_module_names = False

html_theme = "furo"
html_title = "diffdrive_mj"
html_static_path = ["_static"]
html_css_files = ["pages.css"]
html_copy_source = False
html_show_copyright = html_show_sphinx = False
