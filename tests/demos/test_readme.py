# SPDX-License-Identifier: MIT
"""What README.md shows: its script runs, its pictures, links and folders are there, its commands exist."""

import re

import pytest


@pytest.fixture
def readme(checkout):
    return (checkout / "README.md").read_text()


@pytest.mark.long_rows(where=lambda ranks: ranks == 1)
@pytest.mark.parametrize("ranks", (1, 2))
def test_the_script_runs(ranks, readme, script_on_ranks, tmp_path):
    (source,) = re.findall(r"```python\n(.*?)```", readme, re.DOTALL)
    script = tmp_path / "first.py"
    script.write_text(source)
    output = script_on_ranks(ranks, script)
    assert re.search(r"peak pressure \d+ MPa, Hertz \d+ MPa", output)


def test_contact_comes_first_and_the_environment_after(readme):
    assert readme.index("di.ContactPair") < readme.index("## The environment") < readme.index("## The command")


def test_links_and_pictures_are_there(readme, checkout):
    for target in re.findall(r"\]\((?!https?:)([^)#]+)\)", readme):
        assert (checkout / target).exists(), target
    for picture in re.findall(r"!\[[^\]]*\]\(([^)]+)\)", readme):
        assert (checkout / picture).stat().st_size < (1_500_000 if picture.endswith(".gif") else 200_000)


def test_folders_are_there(readme, checkout):
    table = readme.partition("## Folders")[2]
    folders = [
        name for row in re.findall(r"^\| (`.*?) \|", table, re.MULTILINE) for name in re.findall(r"`([^`]+/)`", row)
    ]
    assert len(folders) > 8
    for folder in folders:
        assert (checkout / folder).is_dir(), folder


def test_make_targets_exist(readme, checkout):
    targets = re.findall(r"^([a-z-]+):.*##", (checkout / "Makefile").read_text(), re.MULTILINE)
    named = set(re.findall(r"\bmake (demo|test|verify|bench|docs|notebooks|shell)\b", readme))
    assert {"demo", "test"} <= named <= set(targets)


def test_what_is_promised_for_later_is_not_there_yet(readme):
    """The day one of these exists, the table has to move it to the left."""
    import dolfinx_impact as di

    later = {"ContactPair": "contact", "ExplicitProblem": "explicit impact", "NewmarkProblem": "Newmark"}
    later |= {"J2Plasticity": "plasticity", "RollingProblem": "steady rolling"}
    for name, words in later.items():
        right = any(
            words in row.split("|")[2] for row in readme.splitlines() if row.startswith("|") and row.count("|") == 3
        )
        assert right != hasattr(di, name), f"README.md: {words!r} is in the wrong column, or on neither side"
