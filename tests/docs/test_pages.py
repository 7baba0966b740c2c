# SPDX-License-Identifier: MIT
"""What pages say is true: the places they name exist, every stage and every demo has its page."""

import pathlib
import re
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "architecture"))
import theory_map  # noqa: E402


def blocks(page):
    return re.findall(r"^```python\n(.*?)^```", page.read_text(), re.DOTALL | re.MULTILINE)


def test_the_start_page_and_the_readme_show_the_same_script(checkout):
    (start,) = blocks(checkout / "docs" / "index.md")
    assert blocks(checkout / "README.md") == [start]
    assert len([line for line in start.splitlines() if line.strip()]) < 30


def test_places_of_the_walks_exist(checkout):
    text = (checkout / "docs" / "developer_guide.md").read_text()
    places = [p for p in re.findall(r"`([\w/]+\.\w+(?:::\w+)?)`", text) if "/" in p]
    assert len(places) > 20
    assert [problem for p in places if (problem := theory_map._check(p, "code", checkout, ()))] == []


def test_every_stage_has_its_page(checkout):
    """Apart from `common`, which is for the library's own use."""
    headers = (checkout / "cpp" / "dolfinx_impact").glob("*/*.h")
    for stage in {header.parent.name for header in headers} - {"common"}:
        page = (checkout / "docs" / "api" / f"cpp_{stage}.md").read_text()
        assert re.search(rf"{{doxygennamespace}} \w+::{stage}\n", page), f"{stage} has no entry"


def test_every_demo_has_its_page_and_printed_output(checkout):
    from dolfinx_impact import cli

    for name in cli.demos():
        page = (checkout / "docs" / "demos" / f"{name}.md").read_text()
        assert f"dolfinx-impact demo {name}\n" in page and "](../figures/demo_" in page
        assert len((checkout / "docs" / "figures" / f"demo_{name}.txt").read_text()) > 100


def test_the_page_on_programs_in_cpp_shows_lines_of_the_demos(checkout):
    """Which tests/cpp builds and runs: of a block all lines are in one file, in their order."""
    found = re.findall(r"^```(cpp|cmake)\n(.*?)^```", (checkout / "docs/howto/cpp.md").read_text(), re.DOTALL | re.M)
    assert len(found) > 3
    files = {"cpp": "*.cpp", "cmake": "CMakeLists.txt"}
    for language, block in found:
        texts = [
            p.read_text().replace("${demo}", "own_law") for p in (checkout / "demos" / "cpp").glob(files[language])
        ]
        lines = [re.escape(line.strip()) for line in block.splitlines()]
        assert any(re.search(r".*".join(lines), text, re.DOTALL) for text in texts), block


def test_every_page_is_in_a_table_of_contents(checkout):
    docs = checkout / "docs"
    listed = {"index.md"}
    for page in docs.rglob("*.md"):
        for body in re.findall(r"```\{toctree\}\n(.*?)```", page.read_text(), re.DOTALL):
            names = [line for line in body.splitlines() if line and not line.startswith(":")]
            listed |= {(page.parent / f"{name}.md").relative_to(docs).as_posix() for name in names}
    assert {page.relative_to(docs).as_posix() for page in docs.rglob("*.md")} == listed
