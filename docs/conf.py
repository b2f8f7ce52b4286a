"""How Sphinx builds the documentation; nothing is fetched, so it builds offline."""

from __future__ import annotations

from sphinx.ext.napoleon import Config, GoogleDocstring

from surefoot.version import VERSION

project = "Surefoot"
author = "The Surefoot authors"
project_copyright = author
version = release = VERSION

extensions = ["myst_parser", "sphinx.ext.autodoc"]
exclude_patterns = ["_build"]
html_theme = "furo"
html_title = f"Surefoot {VERSION}"
myst_heading_anchors = 3

autodoc_member_order = "bysource"
# The docstrings give shapes and units, which say more than NDArray[float64].
autodoc_typehints = "none"
maximum_signature_line_length = 90

_SECTIONS = ("Args:", "Attributes:", "Raises:", "Returns:")
_WITH_SECTIONS = ("module", "class", "exception", "function", "method")


def escaped(lines):
    """Plain text as reStructuredText: |x| is a modulus, and an indented line is an equation."""
    result, in_section, in_equation = [], False, False
    for line in lines:
        in_section = in_section or line in _SECTIONS
        indented = line.startswith("    ") and not in_section
        if indented and not in_equation:
            result += ["::", ""]
        if line:
            in_equation = indented
        result.append(line if in_equation else line.replace("|", r"\|"))
    return result


def read_docstring(app, what, name, obj, options, lines):
    """Give autodoc a docstring of this project: plain text, then sections."""
    lines[:] = escaped(lines)
    if what in _WITH_SECTIONS:
        reader = Config(napoleon_use_ivar=True, napoleon_attr_annotations=False)
        lines[:] = GoogleDocstring(lines, reader, app, what, name, obj, options).lines()


def setup(app):
    """Called by Sphinx."""
    app.connect("autodoc-process-docstring", read_docstring)
