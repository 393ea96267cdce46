"""Settings of the documentation site; `make docs` builds it with Sphinx."""

import re
from importlib.metadata import version as version_of
from pathlib import Path

from click import Context
from sphinx.application import Sphinx
from sphinx.ext.napoleon import NumpyDocstring
from sphinx.util.inspect import TypeAliasForwardRef

import hcsearch

HERE = Path(__file__).parent

project = "hcsearch"
author = "The hcsearch founders"
project_copyright = author
version = release = version_of("hcsearch")

extensions = [
    "myst_nb",
    "sphinx.ext.autodoc",
    "sphinx.ext.autosummary",
    "sphinx.ext.napoleon",
    "sphinx_click",
    "sphinx_copybutton",
    "sphinxext.opengraph",
]

# The project's folder is the source: links between README.md, db/README.md and docs/ are the same on a Git host.
root_doc = "docs/index"
include_patterns = ["*.md", "db/README.md", "docs/**"]
exclude_patterns = ["docs/_*", "**/.*", "build", "hcsearch*", "tests", "reports"]

myst_enable_extensions = ["colon_fence", "html_image"]
myst_heading_anchors = 4
myst_links_external_new_tab = False

# Notebooks have no stored outputs; those that did not change are taken from the cache.
nb_execution_mode = "cache"
nb_execution_cache_path = "docs/_build/notebooks"
nb_execution_in_temp = True  # they write files
nb_execution_raise_on_error = True
nb_execution_timeout = 900  # s for a cell: on a loaded machine without kernels the default of 30 s does not suffice

default_role = "py:obj"
highlight_language = "text"
templates_path = [str(HERE / "_templates")]
autosummary_generate = True
autodoc_typehints = "description"
autodoc_typehints_format = "short"
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
# kinds keep their names, and public names lead to their pages
KINDS = ("CaseSubject", "Formulation", "Keep", "Place", "ReplaySource", "Until", "Way")
autodoc_type_aliases = {name: name for name in KINDS} | {name: f"hcsearch.{name}" for name in hcsearch.__all__}
TypeAliasForwardRef.__repr__ = lambda alias: alias.name  # Sphinx writes kinds within unions so
python_use_unqualified_type_names = True
napoleon_google_docstring = False
# else words before a colon in the docstring of a property are taken for its type
NumpyDocstring._parse_attribute_docstring = NumpyDocstring._consume_to_end

html_theme = "pydata_sphinx_theme"
html_title = f"hcsearch {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_js_files = [("site.js", {"defer": "defer"})]
html_extra_path = ["_site"]
html_copy_source = False
html_show_sourcelink = False
html_sidebars = {
    page: [] for page in ("README", "C*", "S*", "docs/index", "docs/README", "docs/tutorial", "docs/gallery")
}
html_theme_options = {
    "logo": {"text": f"hcsearch {version}"},
    "navbar_align": "left",
    "header_links_before_dropdown": 6,
    "show_toc_level": 2,
    "secondary_sidebar_items": ["page-toc"],
    "footer_start": ["copyright"],
    "footer_end": ["theme-version"],
}
ogp_social_cards = {"enable": False}  # only the descriptions of pages for search engines
copybutton_prompt_text = r"\$ |>>> |\.\.\. "
copybutton_prompt_is_regexp = True


def setup(app: Sphinx) -> None:
    """Take part in how sphinx-click writes the help of commands."""
    for part in ("description", "options", "epilog"):
        app.connect(f"sphinx-click-process-{part}", _show_as_typed)


def _show_as_typed(app: Sphinx, context: Context, lines: list[str]) -> None:
    """Write options in sentences and aligned lines as code: else two dashes become one, and spaces are lost."""
    shown = []
    for before, line in zip(["", *lines], lines, strict=False):
        text = line.lstrip()
        space = line.removesuffix(text)
        if text.startswith("| "):
            if not before.lstrip().startswith("| "):
                shown += [f"{space}::", ""]
            shown.append(f"{space}    {text[2:]}")
        elif text.startswith(".. "):
            shown.append(line)
        else:
            shown.append(re.sub(r"`[^`]*`|(?<![\w-])--[a-z][\w-]*", _as_code, line))
    lines[:] = shown


def _as_code(found: re.Match[str]) -> str:
    return found[0] if found[0].startswith("`") else f"``{found[0]}``"
