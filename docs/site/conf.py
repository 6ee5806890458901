"""Sphinx settings of the documentation: ``make docs`` builds it into build/docs, readable without a network.

The source folder is the repository's root, so that links between pages mean the same in a viewer of Markdown; this
folder holds the settings and what writes pages at build time.
"""

import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT))

from docs.site.pages import at_build_time, with_site_links  # noqa: E402
from warehouse_sim.version import __version__  # noqa: E402

project = "warehouse_sim"
version = release = __version__
copyright = "the authors, Apache-2.0"
root_doc = "docs/index"
include_patterns = [
    "docs/*.md", "docs/tutorials/*.md", "docs/generated/*.md", "docs/generated/results/*.md", "models/README.md",
    "models/*/card.md", "scenes/*.md", "benchmarks/*.md",
    "CONTRIBUTING.md", "CHANGELOG.md",
]  # fmt: skip
exclude_patterns = [".*", "out", "build", "dist", "tests", "warehouse_sim", "assets"]

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
myst_enable_extensions = ["colon_fence"]
myst_heading_anchors = 4
autodoc_member_order = "bysource"
autodoc_typehints = "none"
autodoc_preserve_defaults = True
suppress_warnings = ["myst.header"]
toc_object_entries = False

html_theme = "pydata_sphinx_theme"
html_title = "warehouse_sim"
html_static_path = ["static"]
html_css_files = ["wide_tables.css"]
html_context = {"default_mode": "auto"}
html_show_sourcelink = False
html_copy_source = False
html_extra_path = ["root"]
html_theme_options = {
    "navbar_align": "left",
    "show_toc_level": 2,
    "navigation_depth": 2,
    "show_prev_next": True,
    "pygments_light_style": "a11y-high-contrast-light",
    "footer_start": ["copyright"],
    "footer_end": [],
}


def setup(app: object) -> None:
    """Write pages before the sources are read, and give links the site's places and titles."""
    app.connect("config-inited", at_build_time)  # type: ignore[attr-defined]
    app.connect("source-read", with_site_links)  # type: ignore[attr-defined]
