"""The documentation site: Sphinx with MyST; tutorials run while it is built, MathJax comes with the pages."""

from __future__ import annotations

import re
from importlib.resources import files
from typing import Any

import amble

project = "amble"
author = "The amble authors"
copyright = "The amble authors"
version = release = amble.__version__

extensions = ["myst_nb", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx.ext.mathjax"]
exclude_patterns = ["theory/README.md"]
html_theme = "furo"
html_title = f"amble {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False

# Pages are read from files without a network: MathJax as one program, which draws formulas as SVG and needs no fonts.
html_static_path.append(str(files("mathjax") / "static" / "mathjax" / "es5" / "tex-svg.js"))
mathjax_path = "tex-svg.js"
mathjax3_config = {"tex": {"tags": "none"}, "options": {"enableMenu": False}}

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3
myst_dmath_double_inline = True
suppress_warnings = ["misc.highlighting_failure"]

nb_execution_mode = "force"
nb_execution_in_temp = True
nb_execution_raise_on_error = True
nb_execution_timeout = 900
nb_merge_streams = True

autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True}
napoleon_google_docstring = True
napoleon_numpy_docstring = False
napoleon_use_ivar = True
napoleon_use_rtype = False


def escaped(text: str) -> str:
    """Keep what reads as markup in reStructuredText from being read: |A|, a * b and names that end in an underline."""
    parts = re.split(r"(``[^`]*``)", text)
    marks = re.compile(r"([|*\\])|(?<=\w)_(?!\w)")
    return "".join(
        part if part.startswith("``") else marks.sub(lambda found: f"\\{found.group()}", part) for part in parts
    )


def escape_docstring(_app: Any, _what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    """Docstrings are plain text with ``code``."""
    lines[:] = [escaped(line) for line in lines]


def whole_first_line(_app: Any, what: str, _name: str, _object: object, _options: object, lines: list[str]) -> None:
    """Of a property's first line napoleon takes what is before a colon for a type; it belongs to the sentence."""
    found = [number for number, line in enumerate(lines) if line.startswith(":type: ")]
    if what in ("attribute", "data", "property") and found:
        before = lines.pop(found[-1]).removeprefix(":type: ")
        lines[0] = f"{before}: {lines[0]}"


def internal_names(_app: Any, _environment: Any, node: Any, content: Any) -> Any:
    """A type that is no public name of amble stands as text; a public one has to resolve."""
    target = str(node.get("reftarget", ""))
    home = {f"{module}.{name}" for name, module in amble._HOME.items()}  # type: ignore[attr-defined]
    public = target in home or target in {f"amble.{name}" for name in amble.__all__}
    return None if public or node.get("refdomain") != "py" else content


def setup(app: Any) -> None:
    """Connect the hooks; docstrings are escaped before napoleon reads them, and mended after."""
    app.connect("autodoc-process-docstring", escape_docstring, priority=400)
    app.connect("autodoc-process-docstring", whole_first_line, priority=600)
    app.connect("missing-reference", internal_names)
