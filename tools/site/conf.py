"""How Sphinx makes the site of the pages that `tools/build_site.py` has laid out. Nothing is fetched for it.

Sphinx, as NumPy, SciPy and librosa have it, and not Material for MkDocs, whose makers mend it until May 2027 only.
"""

import inspect
import os
import sys
import tomllib
from pathlib import Path
from typing import Any

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))
from make_api import signature_of

project = "retime"
author = "retime contributors"
copyright = "retime contributors, MIT licence"
with (Path(__file__).resolve().parents[2] / "pyproject.toml").open("rb") as file:
    release = version = tomllib.load(file)["project"]["version"]
language = "en"
# Two dashes begin an option.
smartquotes = False

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon"]
source_suffix = {".md": "markdown"}
root_doc = "index"

myst_heading_anchors = 4
myst_enable_extensions = ["colon_fence"]
# Of several members with one name, `n_frames` say, the first is linked to.
suppress_warnings = ["ref.python"]

# Signatures as they are written, and one backtick as a link where there is something to link to.
default_role = "py:obj"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_preserve_defaults = True
maximum_signature_line_length = 80
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_ivar = True
add_module_names = False
toc_object_entries_show_parents = "hide"

html_theme = "furo"
html_title = f"retime {release}"
# Where it is put up; .github/workflows/docs.yml says it.
html_baseurl = os.environ.get("SITE_URL", "")
html_static_path = ["static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sourcelink = False
html_show_sphinx = False
html_theme_options = {
    "light_css_variables": {"color-brand-primary": "#0f766e", "color-brand-content": "#0f766e"},
    "dark_css_variables": {"color-brand-primary": "#2dd4bf", "color-brand-content": "#2dd4bf"},
}


def as_written(app: Any, what: str, name: str, value: Any, options: Any, signature: Any, returned: Any) -> Any:
    """Show a signature as it is written: `ArrayLike` says more than all that it stands for."""
    if what not in ("function", "method", "class") or (isinstance(value, type) and issubclass(value, BaseException)):
        return None
    try:
        whole = signature_of(value, is_bound=what == "method" and not inspect.ismethod(value))
    except (TypeError, ValueError):
        return None
    arguments, _, result = whole.rpartition(" -> ")
    return (arguments, result) if arguments else (whole, None)


def setup(app: Any) -> None:
    """Have Sphinx ask for each signature."""
    app.connect("autodoc-process-signature", as_written)
