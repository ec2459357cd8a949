"""How Sphinx builds these pages; `make docs` treats every warning as an error."""

from __future__ import annotations

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_ext"))

project = "bodyschema"
author = copyright = "The bodyschema developers"
release = version = version_of("bodyschema")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "plain_docstrings",
    "published_results",
    "reference_pages",
]
exclude_patterns = ["_build", "_ext"]
templates_path: list[str] = []

myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
smartquotes = False

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
# The names that the code uses; spelled out they fill lines.
autodoc_type_aliases = {name: name for name in ("Array", "ArrayLike", "Flags", "Ints")}
maximum_signature_line_length = 88

html_theme = "furo"
html_title = f"bodyschema {release}"
html_static_path = ["_static"]
html_copy_source = False
html_show_sphinx = False
