# SPDX-License-Identifier: MIT
"""What describes the package to others: pyproject.toml, CITATION.cff, recipes of conda and containers, workflows."""

import importlib.util
import re
import subprocess
import sys
import tomllib

import pytest
import yaml

# The keys that the Citation File Format 1.2.0 has for the file itself, and for an author that is a group.
CFF_REQUIRED = {"authors", "cff-version", "message", "title"}
CFF_KEYS = CFF_REQUIRED | {
    "abstract", "commit", "contact", "date-released", "doi", "identifiers", "keywords", "license", "license-url",
    "preferred-citation", "references", "repository", "repository-artifact", "repository-code", "type", "url",
    "version",
}  # fmt: skip
CFF_ENTITY = {
    "address", "alias", "city", "country", "date-end", "date-start", "email", "fax", "location", "name", "orcid",
    "post-code", "region", "tel", "website",
}  # fmt: skip
NOT_RUN = ("conda/recipe/recipe.yaml", "env/Containerfile.dolfinx", ".github/workflows/checks.yml",
           ".github/workflows/wheel.yml")  # fmt: skip


@pytest.fixture(scope="module")
def pyproject(checkout):
    return tomllib.loads((checkout / "pyproject.toml").read_text())


@pytest.fixture(scope="module")
def wheel_metadata(checkout):
    spec = importlib.util.spec_from_file_location("wheel_metadata", checkout / "env" / "wheel_metadata.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


def test_the_citation_file_is_of_its_format(checkout, pyproject):
    found = yaml.safe_load((checkout / "CITATION.cff").read_text())
    assert CFF_REQUIRED <= set(found) <= CFF_KEYS
    assert found["cff-version"] == "1.2.0" and found["type"] == "software"
    assert str(found["version"]) == pyproject["project"]["version"]
    licence = (checkout / "LICENSE").read_text()
    assert found["license"] == "MIT" and licence.startswith("MIT License")
    holder = re.search(r"Copyright \(c\) \d+ (.*)", licence)[1]
    assert [author["name"] for author in found["authors"]] == [holder]
    assert all(set(author) <= CFF_ENTITY for author in found["authors"])
    assert all(isinstance(text, str) and text for text in (found["title"], found["message"], *found["keywords"]))
    assert len(set(found["keywords"])) == len(found["keywords"])


def test_extras_have_what_they_are_for(pyproject):
    extras = pyproject["project"]["optional-dependencies"]
    names = {extra: {re.match(r"[\w-]+", one)[0] for one in wanted} for extra, wanted in extras.items()}
    assert names["viz"] == names["plot"] | names["mesh"] == {"pyvista", "gmsh"}
    assert {"pytest", "hypothesis"} <= names["test"] and {"sphinx", "myst-parser"} <= names["docs"]


def test_a_wheel_asks_for_one_dolfinx(checkout, wheel_metadata, pyproject, tmp_path):
    """The list of a wheel is that of the project with the solver's wheel in the place of what is inside it."""
    copy = tmp_path / "pyproject.toml"
    copy.write_text((checkout / "pyproject.toml").read_text())
    subprocess.run([sys.executable, checkout / "env" / "wheel_metadata.py", copy], check=True, timeout=100)
    changed, before = tomllib.loads(copy.read_text()), pyproject["project"]
    wanted = changed["project"]["dependencies"]
    assert wanted[0] == "dolfinx-solver-real==0.11.0.post0"
    assert not {wheel_metadata.name_of(one) for one in wanted} & {"fenics-dolfinx", "petsc4py", "slepc4py"}
    assert len(wanted) == len(before["dependencies"]) - 2 and set(wanted[1:]) < set(before["dependencies"])
    assert changed["project"]["requires-python"] == ">=3.12"
    for key in before.keys() - {"dependencies", "requires-python"}:
        assert changed["project"][key] == before[key]
    assert changed["tool"] == tomllib.loads((checkout / "pyproject.toml").read_text())["tool"]


@pytest.mark.parametrize(
    "text, message",
    (
        ('dependencies = ["numpy"]\n', "no list of dependencies over several lines"),
        ('dependencies = [\n  "numpy",\n]\nrequires-python = ">=3.10"\n', "are not all among the dependencies"),
        ('dependencies = [\n  "fenics-dolfinx", "petsc4py", "slepc4py",\n]\n', "no line requires-python"),
    ),
)
def test_another_list_is_refused(text, message, wheel_metadata):
    with pytest.raises(ValueError, match=message):
        wheel_metadata.for_wheel(text)


def test_names_are_compared_as_indexes_do(wheel_metadata):
    assert [wheel_metadata.name_of(n) for n in ("Fenics_DOLFINx>=0.9", "h5py", "a.b-c[x]")] == [
        "fenics-dolfinx",
        "h5py",
        "a-b-c",
    ]


@pytest.mark.parametrize("name", NOT_RUN)
def test_what_was_never_run_says_so(name, checkout):
    """In the file and in the guide, until somebody has run it."""
    assert "NOT YET RUN" in "\n".join((checkout / name).read_text().splitlines()[:4])
    guide = (checkout / "CONTRIBUTING.md").read_text()
    row = next(line for line in guide.splitlines() if line.startswith("|") and name in line)
    assert "not yet run" in row


def test_workflows_and_recipe_can_be_read(checkout, pyproject):
    for path in (checkout / ".github" / "workflows").glob("*.yml"):
        found = yaml.safe_load(path.read_text())
        assert found["jobs"] and all("steps" in job and "timeout-minutes" in job for job in found["jobs"].values())
        for script in re.findall(r"env/\w+(?:\.\w+)?", path.read_text()):
            assert (checkout / script).exists(), f"{path.name} names {script}"
    recipe = yaml.safe_load((checkout / "conda" / "recipe" / "recipe.yaml").read_text())
    assert str(recipe["context"]["version"]) == pyproject["project"]["version"]
    needed = {re.split(r"[ <>=]", one)[0] for one in recipe["requirements"]["run"]}
    renamed = {"matplotlib": "matplotlib-base"}
    for one in pyproject["project"]["dependencies"]:
        name = re.match(r"[\w-]+", one)[0]
        assert renamed.get(name, name) in needed, f"the recipe lacks {name}"


@pytest.mark.slow
def test_the_source_distribution_builds_by_itself(checkout, tmp_path):
    """A wheel of the archive alone, without the checkout, runs a demo: `make sdist`, some minutes."""
    command = [checkout / "env" / "try_sdist.sh", tmp_path]
    done = subprocess.run(command, capture_output=True, text=True, timeout=3000)
    assert done.returncode == 0, done.stdout + done.stderr
    assert "peak pressure" in done.stdout and len(list(tmp_path.glob("dolfinx_impact-*.tar.gz"))) == 1
