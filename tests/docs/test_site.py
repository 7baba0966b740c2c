# SPDX-License-Identifier: MIT
"""The site: it builds without a warning, without a network, and shows what it should."""

import html.parser
import re
import subprocess
import sys

import pytest


def build(checkout, folder, builder):
    """Folder of what a builder of Sphinx makes. Warnings are errors."""
    command = [sys.executable, "-m", "sphinx", "-q", "-W", "--keep-going", "-b", builder, "-d", folder / "doctrees"]
    done = subprocess.run([*command, checkout / "docs", folder / "site"], capture_output=True, text=True, timeout=300)
    assert done.returncode == 0, done.stderr[-10_000:]
    assert "WARNING" not in done.stderr
    return folder / "site"


def test_every_page_is_read_without_a_warning(checkout, tmp_path):
    """All but the writing of HTML: pages, docstrings, links, the C++ headers."""
    build(checkout, tmp_path, "dummy")


@pytest.fixture(scope="module")
def site(checkout, tmp_path_factory):
    return build(checkout, tmp_path_factory.mktemp("docs"), "html")


class Sources(html.parser.HTMLParser):
    """Everything that a page loads: scripts, style sheets, pictures, frames."""

    def __init__(self, text):
        super().__init__()
        self.found = []
        self.feed(text)

    def handle_starttag(self, tag, attributes):
        attributes = dict(attributes)
        loads = tag in ("script", "img", "iframe", "source", "embed", "link")
        if loads and attributes.get("rel") not in ("canonical",):
            self.found += [attributes[name] for name in ("src", "href") if attributes.get(name)]


@pytest.mark.slow
def test_the_start_page_has_a_picture_a_script_and_two_commands(site):
    text = (site / "index.html").read_text()
    pictures = [name for name in Sources(text).found if name.endswith("demo_wheel_on_rail_2d.png")]
    assert pictures and (site / pictures[0]).stat().st_size > 10_000
    assert "ContactPair" in text and "make demo" in text and "make test" in text


@pytest.mark.slow
def test_pages_load_nothing_from_elsewhere(site):
    pages = sorted(site.rglob("*.html"))
    assert len(pages) > 40
    for page in pages:
        sources = Sources(page.read_text()).found
        assert sources
        outside = [name for name in sources if re.match(r"(\w+:)?//", name)]
        assert outside == [], page
        for name in sources:
            path = page.parent / re.sub(r"[?#].*", "", name)
            assert path.exists(), f"{page.relative_to(site)} loads {name}, which is not in the site"


@pytest.mark.slow
def test_style_sheets_load_nothing_from_elsewhere(site):
    for sheet in site.rglob("*.css"):
        assert not re.search(r"(url\(|@import)\s*[\"']?(https?:)?//", sheet.read_text()), sheet


@pytest.mark.slow
def test_mathematics_is_rendered_from_the_site(site):
    text = (site / "contact_theory.html").read_text()
    assert r"\mathcal L(u, \lambda)" in text and "mathjax/MathJax.js" in text
    assert (site / "_static" / "mathjax" / "MathJax.js").exists()
    assert list((site / "_static" / "mathjax" / "fonts").rglob("*.woff"))


@pytest.mark.slow
@pytest.mark.parametrize(
    "page, words",
    [
        ("api/problems.html", ("StaticProblem", "max_iterations", "ExplicitProblem", "advance")),
        ("api/contact.html", ("ContactPair", "search_distance", "RigidSphere")),
        ("api/reference.html", ("impact_reference.", "solve_static")),
        ("api/cpp_operators.html", ("InternalForce", "assemble", "Halo")),
        ("api/cpp_integrators.html", ("CentralDifference",)),
    ],
)
def test_the_api_is_there(site, page, words):
    text = re.sub(r"<[^>]+>", "", (site / page).read_text())
    for word in words:
        assert word in text, f"{page} does not mention {word}"


@pytest.mark.slow
def test_the_demos_are_pages(site):
    from dolfinx_impact import cli

    for name, (_, title) in cli.demos().items():
        text = re.sub(r"<[^>]+>", "", (site / "demos" / f"{name}.html").read_text())
        assert title.split("$")[0].split("'")[0] in text
        assert re.search("(import|from) dolfinx_impact", text) and "assert " in text and "What it prints" in text
        for ending in ("py", "ipynb"):
            assert f'href="../notebooks/{name}.{ending}"' in (site / "demos" / f"{name}.html").read_text()
            assert (site / "notebooks" / f"{name}.{ending}").stat().st_size > 1000
