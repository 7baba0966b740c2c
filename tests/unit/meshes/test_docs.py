# SPDX-License-Identifier: MIT
"""docs/meshes.md says what the code does: tag numbers, recipes, default numbers of cells."""

import re

import pytest
from mesh_modules import CHECKOUT, meshes
from mpi4py import MPI

PAGE = CHECKOUT / "docs" / "meshes.md"


def rows(heading):
    """First and second (and third) cell of the table rows under a header cell."""
    part = PAGE.read_text().split(f"| {heading} |", 1)[1].split("\n\n", 1)[0]
    return [[cell.strip(" `") for cell in line.split("|")[1:-1]] for line in part.split("\n")[2:]]


@pytest.mark.parametrize("heading, table", [("body (cell tag)", "BODIES"), ("surface (facet tag)", "FACETS")])
def test_tag_tables(heading, table):
    assert {row[0]: int(row[1]) for row in rows(heading)} == getattr(meshes, table)


def test_recipes_and_counts():
    found = rows("recipe")
    assert [row[0] for row in found] == list(meshes.names())
    for name, _, count, _ in found:
        m = meshes.make(name, MPI.COMM_SELF)
        assert m.mesh.topology.index_map(m.mesh.topology.dim).size_global == int(count), name


def test_figures_are_there_and_small():
    for name in re.findall(r"\]\((figures/[^)]*)\)", PAGE.read_text()):
        assert (PAGE.parent / name).stat().st_size < 100_000, name
