# SPDX-License-Identifier: MIT
"""Configuration of the documentation site: `make docs`, which works without a network.

Doxygen writes XML of the C++ headers first, breathe shows it. MathJax is Debian's and is copied into the site.
"""

import inspect
import pathlib
import re
import shutil
import subprocess
import sys
import warnings

import jupytext

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parent))
import notebooks  # noqa: E402

warnings.filterwarnings("ignore", message="Sphinx 9 will drop support")  # of breathe, not of these pages

DOCS = pathlib.Path(__file__).resolve().parent
CHECKOUT = DOCS.parent
MATHJAX = pathlib.Path("/usr/share/javascript/mathjax")
# What pages load of it: TeX input, output by style sheets with web fonts.
MATHJAX_PARTS = (
    "MathJax.js",
    "config/TeX-AMS_CHTML-full.js",
    "extensions",
    "fonts/HTML-CSS/TeX/woff",
    "jax/element",
    "jax/input/TeX",
    "jax/output/CommonHTML",
)

project = "dolfinx_impact"
copyright = "the authors of dolfinx_impact, MIT licence"
version = release = re.search(r'^version = "([^"]+)"', (CHECKOUT / "pyproject.toml").read_text(), re.MULTILINE)[1]

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "sphinx.ext.mathjax",
    "sphinx_copybutton",
    "breathe",
]
exclude_patterns = ["figures"]
# Not nitpicky: breathe and napoleon take dimensions and namespaces for links. Links of pages are checked all the same.

myst_enable_extensions = ["dollarmath", "amsmath"]
myst_heading_anchors = 4
myst_dmath_double_inline = True
myst_update_mathjax = False  # that is for MathJax 3; Debian has 2

default_role = "code"  # of single back quotes in docstrings
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented"
napoleon_numpy_docstring = False
napoleon_use_ivar = True

breathe_show_include = False

mathjax_path = "mathjax/MathJax.js?config=TeX-AMS_CHTML-full"
mathjax2_config = {
    "tex2jax": {"processClass": "tex2jax_process|mathjax_process|math|output_area", "ignoreClass": "tex2jax_ignore"},
    "showMathMenu": False,
    "messageStyle": "none",
}

html_theme = "furo"
html_title = f"dolfinx_impact {version}"
html_static_path = ["_static"]
html_css_files = ["site.css"]
html_show_sourcelink = False
html_copy_source = False
copybutton_exclude = ".linenos, .gp, .go"


def run_doxygen(app, config):
    """XML of the public C++ headers, where breathe looks for it."""
    folder = pathlib.Path(app.doctreedir).parent / "doxygen"
    folder.mkdir(parents=True, exist_ok=True)
    options = {
        "PROJECT_NAME": "dolfinx_impact",
        "INPUT": CHECKOUT / "cpp" / "dolfinx_impact",
        "FILE_PATTERNS": "*.h",
        "RECURSIVE": "YES",
        "STRIP_FROM_PATH": CHECKOUT / "cpp",
        "OUTPUT_DIRECTORY": folder,
        "GENERATE_HTML": "NO",
        "GENERATE_LATEX": "NO",
        "GENERATE_XML": "YES",
        "XML_PROGRAMLISTING": "NO",
        "ENABLE_PREPROCESSING": "YES",
        "QUIET": "YES",
        "MACRO_EXPANSION": "YES",
        "EXPAND_ONLY_PREDEF": "YES",
        "PREDEFINED": '" "'.join(("__attribute__(x)=", "IMPACT_INLINED=inline", "IMPACT_CLONES=")),
        "AUTOLINK_SUPPORT": "NO",
        "WARN_IF_UNDOCUMENTED": "NO",
        "WARN_IF_INCOMPLETE_DOC": "NO",
    }
    text = "\n".join(f'{key} = "{value}"' for key, value in options.items())
    done = subprocess.run(["doxygen", "-"], input=text, text=True, capture_output=True)
    if done.returncode or done.stderr.strip():
        raise RuntimeError(f"doxygen: {done.stderr}")
    config.breathe_projects = {"dolfinx_impact": str(folder / "xml")}
    config.breathe_default_project = "dolfinx_impact"


def demo_page(app, docname, source):
    """A line `<!-- demo: PATH -->` of a page becomes the text and the code of that demo, and links to its files."""

    def text_of(match):
        path = CHECKOUT / match[1]
        app.env.note_dependency(str(path))
        cells = jupytext.read(path, fmt="py:light").cells
        # The title is that of the page.
        cells[0].source = re.sub(r"\A# .*\n*", "", cells[0].source)
        files = {"Python": "py", "notebook": "ipynb"}
        links = [f'<a href="../notebooks/{path.stem}.{end}" download>{kind}</a>' for kind, end in files.items()]
        text = [f"To download: {', '.join(links)}."]
        text += [cell.source if cell.cell_type == "markdown" else f"```python\n{cell.source}\n```" for cell in cells]
        return "\n\n".join(text).replace("\n```\n\n```python\n", "\n\n")  # neighbouring blocks of code are one

    source[0] = re.sub(r"^<!-- demo: (\S+) -->$", text_of, source[0], flags=re.MULTILINE)


def write_notebooks(app, error):
    """The demos as files to download, as Python and as notebooks."""
    if error is None and app.builder.format == "html":
        folder = pathlib.Path(app.outdir) / "notebooks"
        for path in notebooks.write(folder, outputs=False):
            shutil.copy(path, folder)


def copy_mathjax(app, error):
    """The parts of MathJax that the pages load."""
    if error is None and app.builder.format == "html":
        target = pathlib.Path(app.outdir) / "_static" / "mathjax"
        if not target.exists():
            for part in MATHJAX_PARTS:
                (target / part).parent.mkdir(parents=True, exist_ok=True)
                copy = shutil.copytree if (MATHJAX / part).is_dir() else shutil.copy
                copy(MATHJAX / part, target / part)


def entry_of(section, obj):
    """Pattern of how an entry of a docstring's section begins: an exception, a parameter, or an attribute."""
    if section in ("Raises", "Warns"):
        name = r"[A-Z]\w*(?:Error|Warning|Interrupt)"
    elif section == "Attributes":
        name = r"[a-z_]\w*"
    else:
        try:
            name = "(?:" + "|".join(map(re.escape, inspect.signature(obj).parameters)) + ")"
        except (TypeError, ValueError):
            name = r"[a-z_]\w*"
    return rf"(?:{name}, )*{name}: "


def plain_docstring(app, what, name, obj, options, lines):
    """Docstrings of this project are plain text: bars and stars in them are formulas, no markup.

    In their sections an entry may begin in the middle of a line and go on without an indent; napoleon wants one a line.
    """
    text = re.sub(r"([|*])", r"\\\1", "\n".join(lines))

    def one_a_line(match):
        begin = entry_of(match[1], obj)
        body = ""
        for line in match[2].splitlines():
            body += ("\n" if re.match(rf" {{4}}{begin}", line) else " ") + line.strip()
        body = re.sub(rf"(?<=[.\]]) (?={begin})", "\n", body.strip())
        return f"{match[1]}:\n" + "".join(f"    {entry}\n" for entry in body.split("\n"))

    sections = r"^(Args|Attributes|Raises|Warns):\n((?: +\S.*\n?)+)"
    lines[:] = re.sub(sections, one_a_line, text + "\n", flags=re.MULTILINE).split("\n")


def setup(app):
    app.connect("config-inited", run_doxygen)
    app.connect("source-read", demo_page)
    app.connect("autodoc-process-docstring", plain_docstring, priority=100)
    app.connect("build-finished", copy_mathjax)
    app.connect("build-finished", write_notebooks)
