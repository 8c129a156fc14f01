"""Settings of the documentation site; docs/build.py lays out the sources and calls Sphinx with this folder."""

from __future__ import annotations

from importlib.metadata import version as version_of

project = "musclewire"
author = "the authors of musclewire"
project_copyright = author
release = version = version_of("musclewire")

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton"]
root_doc = "index"
exclude_patterns = ["**.ipynb_checkpoints", "jupyter_execute", "_build"]
language = "en"

# Markdown as GitHub renders it, and no more: what is written there shows the same here.
myst_enable_extensions: list[str] = []
myst_heading_anchors = 4
suppress_warnings = [
    "myst.header",  # a page may go from its title to a third level
]

# Notebooks run in every build, and an error in one fails it.
nb_execution_mode = "force"
nb_execution_raise_on_error = True
nb_execution_timeout = 600  # seconds a cell; generous, for a busy machine
nb_merge_streams = True

# The API: types are in the signatures, meanings and units in numpydoc's sections.
autodoc_typehints = "none"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
napoleon_google_docstring = False
napoleon_use_ivar = True
napoleon_attr_annotations = False
napoleon_use_rtype = False
python_use_unqualified_type_names = True
python_maximum_signature_line_length = 80

# Nothing is fetched from a network: furo takes the reader's own fonts, and its scripts are in the site.
html_theme = "furo"
html_title = f"musclewire {release}"
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
# A page opened as a file may not fetch others, which the excerpts below a result would need.
html_show_search_summary = False
html_theme_options = {"navigation_with_keys": True}
copybutton_exclude = ".linenos, .gp, .go"
copybutton_prompt_text = "$ "
