"""The site: `make docs`, from the Markdown pages of this folder, generated references and docstrings."""

from __future__ import annotations

import os
import re
import shutil
import sys
from pathlib import Path

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("NUMBA_DISABLE_JIT", "1")  # docstrings are read, nothing is computed

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
sys.path.insert(0, str(ROOT))

import wroll_fem  # noqa: E402

project = "wroll_fem"
author = "wroll_fem contributors"
project_copyright = author
version = release = wroll_fem.__version__

extensions = [
    "myst_parser", "sphinx.ext.mathjax", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "sphinx_copybutton",
]  # fmt: skip
exclude_patterns = ["_build"]
nitpicky = False
suppress_warnings = ["ref.python"]  # several classes have an attribute of the same name
default_role = "code"

# -- Markdown
myst_enable_extensions = ["dollarmath", "amsmath", "deflist", "colon_fence"]
myst_heading_anchors = 3
myst_dmath_double_inline = True
myst_update_mathjax = False
copybutton_prompt_text = r"\$ "
copybutton_prompt_is_regexp = True
math_eqref_format = "({number})"

# -- docstrings (numpydoc style; types of the text, such as "(n,) m", stay text)
napoleon_google_docstring = False
napoleon_use_rtype = False
napoleon_use_param = False
napoleon_use_ivar = True
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_typehints_format = "short"
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 100
toc_object_entries_show_parents = "hide"

# -- pages
html_theme = "furo"
html_title = f"wroll_fem {release}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_copy_source = False
html_show_sphinx = False
html_last_updated_fmt = None

# -- mathematics without a network: Debian's libjs-mathjax, or else the library's own server
MATHJAX = Path("/usr/share/javascript/mathjax")
MATHJAX_PARTS = (
    "MathJax.js", "extensions/TeX", "extensions/tex2jax.js", "extensions/MathEvents.js", "extensions/MathMenu.js",
    "extensions/MathZoom.js", "jax/element", "jax/input/TeX", "jax/output/SVG", "images",
)  # fmt: skip
if (MATHJAX / "MathJax.js").is_file():
    mathjax_path = "mathjax/MathJax.js"
    mathjax2_config = {
        "jax": ["input/TeX", "output/SVG"],
        "extensions": ["tex2jax.js"],
        "TeX": {"extensions": ["AMSmath.js", "AMSsymbols.js", "noErrors.js"]},
        "SVG": {"font": "TeX", "scale": 92, "linebreaks": {"automatic": True}},
        "showMathMenu": False,
        "messageStyle": "none",
    }


def copy_mathjax(app) -> None:
    """Put the parts of MathJax that the pages need beside them (9 MB, SVG output: no web fonts)."""
    if not (MATHJAX / "MathJax.js").is_file():
        return
    for part in MATHJAX_PARTS:
        source, target = MATHJAX / part, Path(app.outdir) / "_static" / "mathjax" / part
        if target.exists() or not source.exists():
            continue
        target.parent.mkdir(parents=True, exist_ok=True)
        if source.is_dir():
            skip = shutil.ignore_patterns("STIX-Web", "Asana-Math", "Gyre-*", "Latin-Modern", "Neo-Euler")
            shutil.copytree(source, target, ignore=skip)
        else:
            shutil.copy(source, target)


def plain_links(app, docname: str, source: list[str]) -> None:
    """Links to folders and to pages outside this one are names on the site; on a code host they stay links."""
    page = Path(app.env.doc2path(docname))

    def link(match: re.Match[str]) -> str:
        text, target = match[1], match[2]
        if "://" in target or target.startswith("#"):
            return match[0]
        path = (page.parent / target.partition("#")[0]).resolve()
        if not path.is_relative_to(HERE) and path.exists() and (path.is_dir() or path.suffix in (".md", ".py")):
            return INSIDE.get(str(path.relative_to(ROOT)), "").format(text) or f"`{path.relative_to(ROOT)}`"
        return match[0]

    title = TITLES.get(docname)
    if title and not source[0].startswith("# "):
        source[0] = f"# {title}\n\n{source[0]}"
    source[0] = re.sub(r"(?<!!)\[([^\]\[]+)\]\(([^)\s]+)\)", link, source[0])


def literal_bars(app, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Bars of |T| are bars, not substitutions of reStructuredText; mathematics stays as it is.

    A property's "Time step, s: so many per cycle" is a sentence; napoleon would take its start for a type.
    """
    if what in ("property", "attribute") and lines:
        lines[0] = lines[0].replace(": ", "; ", 1)
    inside = False
    for number, line in enumerate(lines):
        if inside:
            inside = not line.strip() or line.startswith((" ", "\t"))
        if line.lstrip().startswith(".. math::"):
            inside = True
        if not inside:
            parts = re.split(r"(:math:`[^`]*`|``[^`]*``)", line)
            lines[number] = "".join(part if part[:1] in (":", "`") else part.replace("|", "\\|") for part in parts)


def no_signature(app, what: str, name: str, obj: object, *_: object) -> tuple[str, None] | None:
    """Sections of the case file are told by their reference, not by pages of annotated types."""
    return ("", None) if isinstance(obj, type) and hasattr(obj, "model_fields") else None


#: Tables that tools write without a heading.
TITLES = {
    "tables/base": "Lab roll: base of the layer",
    "tables/benchmark": "Benchmark of the methods",
    "tables/coil_mesh": "Solid coil: mesh",
    "tables/coiled_stiff": "Claims of the roll without slip",
    "tables/harmonic": "Harmonic balance against slow chirps",
    "tables/low_pressure": "Reduced against exact at low pressure",
    "tables/opening_error": "Error of reduced where points open",
    "tables/random_rolls": "Random rolls through every analysis",
    "tables/mesh": "Lab roll: mesh",
    "tables/reduced": "Reduced against exact",
}

#: Pages outside this folder that the site includes: how they are linked.
INSIDE = {
    "CHANGELOG.md": "[{}](/changelog.md)",
    "meshes/README.md": "[{}](/meshes.md)",
}


def setup(app) -> None:
    """Connect the hooks above."""
    app.connect("builder-inited", copy_mathjax)
    app.connect("source-read", plain_links)
    app.connect("autodoc-process-signature", no_signature)
    app.connect("autodoc-process-docstring", literal_bars, priority=400)  # before napoleon
