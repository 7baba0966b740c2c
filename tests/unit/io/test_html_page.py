# SPDX-License-Identifier: MIT
"""Pages from templates: texts are escaped, and a page that cannot be made leaves the former one."""

import jinja2
import pytest

from dolfinx_impact.io.html_page import write_page


@pytest.fixture
def package(tmp_path, monkeypatch):
    """Name of a package with one template."""
    folder = tmp_path / "package_with_page" / "templates"
    folder.mkdir(parents=True)
    (folder.parent / "__init__.py").write_text("")
    (folder / "page.html").write_text(
        '<p title="{{ title }}">\n{% for row in rows %}\n{{ row }};\n{% endfor %}\n</p>\n'
    )
    monkeypatch.syspath_prepend(tmp_path)
    return "package_with_page"


def test_texts_are_escaped(package, tmp_path):
    page = tmp_path / "page.html"
    write_page(page, package, "page.html", title='a "b"', rows=["x < y", "&"])
    assert page.read_text() == '<p title="a &#34;b&#34;">\nx &lt; y;\n&amp;;\n</p>\n'


@pytest.mark.parametrize("values", [{"title": "a"}, {"rows": []}])
def test_names_that_are_not_given_are_refused_and_the_former_page_stays(package, tmp_path, values):
    page = tmp_path / "page.html"
    page.write_text("former")
    with pytest.raises(jinja2.UndefinedError):
        write_page(page, package, "page.html", **values)
    assert page.read_text() == "former"
