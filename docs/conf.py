"""Documentation site: sphinx-build -W -b html docs docs/_build/html.

The build writes the pages that are made from the program: constants, oil cards, nomenclature, units, Python reference.
"""

from __future__ import annotations

import inspect
import os
import sys
import warnings
from importlib import import_module
from pathlib import Path

import ehl

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE))
for _page in ("constants", "nomenclature", "oils", "references", "units"):
    import_module(f"make_{_page}").write()
project, author, version = "mixed-ehl", "the mixed-ehl developers", ehl.__version__
release = version
language = "en"

extensions = ["myst_parser", "sphinx.ext.autodoc", "numpydoc", "sphinx_gallery.gen_gallery", "executed", "mathml"]
exclude_patterns = ["_build", "examples", "**/*.ipynb", "gallery/GALLERY_HEADER.rst"]
source_suffix = {".md": "markdown", ".rst": "restructuredtext"}
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 4
templates_path: list[str] = []
nitpicky = False
toc_object_entries = False  # the headings name them already

autodoc_preserve_defaults = True
autodoc_typehints = "none"  # the docstrings state types and units
autodoc_member_order = "bysource"
numpydoc_show_class_members = False
numpydoc_class_members_toctree = False

sphinx_gallery_conf = {
    "examples_dirs": "../examples",
    "gallery_dirs": "gallery",
    "filename_pattern": r"\.py$",
    "min_reported_time": 10**6,
    "download_all_examples": False,
    "show_signature": False,
    "image_scrapers": ("own_figures", "matplotlib"),
    "remove_config_comments": True,
    "abort_on_example_error": True,
}

html_math_renderer = "mathml"
html_theme = "pydata_sphinx_theme"
html_title = "mixed-ehl"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_theme_options = {
    "navbar_align": "left",
    "navbar_end": ["theme-switcher"],
    "show_prev_next": False,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": [],
    "show_toc_level": 2,
    "navigation_with_keys": False,
    "header_links_before_dropdown": 7,
}
# pages without others on their level have no list of them
html_sidebars = {page: [] for page in ("index", "tour", "howto", "your_files", "theory", "performance", "nomenclature")}
copyright = "the mixed-ehl developers, BSD-3-Clause"
# outside addresses answer or not as they like: they are no part of the build
linkcheck_ignore = [r"https?://.*"]

os.environ.setdefault("MPLBACKEND", "Agg")
warnings.filterwarnings("ignore", category=DeprecationWarning)

_TITLES = {
    "ehl": "ehl: one lubricated contact",
    "regression": "regression: friction formulas",
    "efficiency": "efficiency: gear pairs",
}


def _write_reference() -> None:
    """Pages of the public names, from what the packages export."""
    folder = HERE / "api"
    folder.mkdir(exist_ok=True)
    for package, title in _TITLES.items():
        module = import_module(package)
        names = sorted(module.__all__, key=str.lower)
        lines = [title, "=" * len(title), "", f".. currentmodule:: {package}", ""]
        lines += [".. list-table::", "   :widths: auto", ""]
        for name in names:
            summary = (inspect.getdoc(getattr(module, name)) or "").partition("\n")[0]
            if callable(getattr(module, name)):
                lines += [f"   * - :py:obj:`{name} <{package}.{name}>`", f"     - {summary}"]
        lines += [""]
        for name in names:
            thing = getattr(module, name)
            if inspect.isclass(thing):
                lines += [name, "-" * len(name), "", f".. autoclass:: {name}", "   :members:", ""]
            elif callable(thing):
                lines += [name, "-" * len(name), "", f".. autofunction:: {name}", ""]
        text = "\n".join(lines)
        path = folder / f"{package}.rst"
        if not path.exists() or path.read_text(encoding="utf-8") != text:
            path.write_text(text, encoding="utf-8")


_write_reference()
