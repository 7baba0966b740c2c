# SPDX-License-Identifier: MIT
"""Every block of code of every page is run, or says why not: "<!-- not run: REASON -->" stands before it.

The Python blocks of a page are one script. A block whose first line names a file ("# my_form.py") is that file, bash
blocks are commands in the same folder, where env/run runs what it is given: the tests are in the environment already.
Commands that run a demo need no mark: tests/demos runs them all.
"""

import pathlib
import subprocess
import sys

import page_blocks
import pytest
from processes import mpi_environment

from dolfinx_impact import cli

ROOT = pathlib.Path(__file__).resolve().parents[2]
PAGES = {
    path.relative_to(ROOT).as_posix(): page_blocks.blocks(path.read_text())
    for path in (*sorted((ROOT / "docs").rglob("*.md")), ROOT / "README.md", ROOT / "CONTRIBUTING.md")
}
# tests/demos/test_readme.py runs the script of the README, which is that of the start page.
ELSEWHERE = ("README.md", "docs/index.md")
# Pages with a block that may run; where each says why not, nothing is left to do.
SCRIPTS = [
    name for name, blocks in PAGES.items() if any(b.language in ("python", "bash") and not b.reason for b in blocks)
]


@pytest.mark.parametrize("name", [name for name in SCRIPTS if name not in ELSEWHERE])
def test_the_blocks_of_a_page_run(name, tmp_path):
    """And the script of a page asserts something."""
    run = [block for block in PAGES[name] if block.is_run(cli.demos()) and not block.reason]
    script = "\n".join(block.text for block in run if block.language == "python" and not block.file)
    assert "assert " in script
    (tmp_path / "page.py").write_text(script)
    (tmp_path / "env").mkdir()
    (tmp_path / "env" / "run").write_text('#!/bin/sh\nexec "$@"\n')
    (tmp_path / "env" / "run").chmod(0o755)
    for block in run:
        if block.file:
            (tmp_path / block.file).write_text(block.text)
    commands = [[sys.executable, "page.py"]]
    commands += [["bash", "-e", "-c", block.text] for block in run if block.language == "bash"]
    for command in commands:
        done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True, timeout=300, env=mpi_environment())
        assert done.returncode == 0, done.stdout + done.stderr


def test_every_block_is_run_or_says_why_not():
    skipped = [
        f"{name}:{block.line}: {block.text.splitlines()[0]}"
        for name, blocks in PAGES.items()
        for block in blocks
        if not block.reason and not block.is_run(cli.demos())
    ]
    assert skipped == [], "blocks that no test runs: make them Python or bash, or mark them <!-- not run: REASON -->"


def test_marks_stand_before_blocks_that_cannot_be_run():
    """No mark is left over, and none is on a block that is run anyway."""
    marks = sum(path.read_text().count("<!-- not run: ") for path in (ROOT / page for page in PAGES))
    marked = [(name, block) for name, blocks in PAGES.items() for block in blocks if block.reason]
    assert len(marked) == marks > 5
    assert [f"{name}:{block.line}" for name, block in marked if not block.language and block.is_run(cli.demos())] == []


PAGE = """# Title

```python
x = 1
```

- a list

    goes on, no code

Text.

    dolfinx-impact demo hertz --ranks 2

    dolfinx-impact demo nothing_such

<!-- not run: a drawing -->

    a --> b

$$

    f(x)

$$

```bash
# job.sh
true
```

```{toctree}
page
```

    y = 2
"""


def test_blocks_are_found():
    """The gate sees what it should: fences, indents, marks; no lists, formulas and directives."""
    found = page_blocks.blocks(PAGE)
    assert [(b.language, b.text.splitlines()[0], b.reason) for b in found] == [
        ("python", "x = 1", None),
        ("", "dolfinx-impact demo hertz --ranks 2", None),
        ("", "a --> b", "a drawing"),
        ("bash", "# job.sh", None),
        ("", "y = 2", None),
    ]
    assert [b.is_run(("hertz",)) for b in found] == [True, False, False, True, False]
    assert found[3].file == "job.sh" and "nothing_such" in found[1].text
