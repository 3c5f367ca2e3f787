"""The site: Sphinx with the PyData theme, Markdown by MyST, commands by sphinx-click.

Chosen before MkDocs Material: docstrings are numpydoc, which Sphinx reads as the rest of the
scientific Python world writes it, and commands come from click by sphinx-click. Nothing is fetched
when the site is built or looked at.
"""

import sys
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "recon"
author = copyright = "The recon developers"
extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "numpydoc",
    "sphinx_click",
    "settings_table",
]
myst_enable_extensions = ["colon_fence", "deflist"]
myst_heading_anchors = 3
exclude_patterns = ["plugin/src", "**.egg-info"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
nitpicky = False
autosummary_generate = True
numpydoc_show_class_members = False
autodoc_typehints = "none"
autodoc_member_order = "bysource"
html_theme = "pydata_sphinx_theme"
html_title = "recon"
html_theme_options = {
    "navigation_with_keys": False,
    "show_prev_next": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
}
html_static_path: list[str] = []
html_show_sourcelink = False
