"""How the documents are built: offline, every warning an error (`make docs`)."""

from __future__ import annotations

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path.insert(0, str(HERE / "_ext"))

from percuss import __version__

project = "percuss"
author = "percuss developers"
release = version = __version__
extensions = [
    "docstrings",
    "mathml",
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_gallery.gen_gallery",
]
exclude_patterns = ["_build", "gallery/**/*.py.md5", "gallery/**/sg_execution_times.rst"]
suppress_warnings = [
    "config.cache",  # the gallery's functions cannot be pickled
    "toc.multiple_toc_parents",  # the tutorial is the first of the gallery's scripts
]

myst_enable_extensions = ["dollarmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
html_math_renderer = "mathml"

# Signatures say types in full; docstrings say them in words.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_default_options = {"members": True}
autosummary_generate = False
napoleon_google_docstring = False
napoleon_attr_annotations = False
napoleon_use_ivar = True
napoleon_use_rtype = False
python_maximum_signature_line_length = 88
toc_object_entries_show_parents = "hide"

smartquotes = False  # x'' is a second derivative

html_theme = "pydata_sphinx_theme"
html_title = "percuss"
html_static_path = ["_static"]
html_css_files = ["percuss.css"]
html_show_sourcelink = False
html_copy_source = False
html_theme_options = {
    "header_links_before_dropdown": 6,
    "navbar_align": "left",
    "navigation_with_keys": False,
    "pygments_dark_style": "github-dark",
    "pygments_light_style": "tango",
    "secondary_sidebar_items": {"**": ["page-toc"], "comparison": [], "index": []},
    "show_prev_next": False,
    "show_toc_level": 2,
}
html_context = {"default_mode": "auto"}
html_sidebars = {"index": [], "gallery/plot_01_first_impacts": []}

sphinx_gallery_conf = {
    "examples_dirs": "../examples/gallery",
    "gallery_dirs": "gallery",
    "filename_pattern": r"/plot_",
    "within_subsection_order": "FileNameSortKey",
    "download_all_examples": False,
    "remove_config_comments": True,
    "show_signature": False,
    "write_computation_times": False,
    "min_reported_time": 1e9,
    "capture_repr": (),
    "abort_on_example_error": True,
}
