# SPDX-License-Identifier: MIT
"""What a problem is recognised by: tables of arguments that tell each change, and nothing but changes."""

import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.io.checkpoint import Subject
from dolfinx_impact.io.given_arguments import LONG, SUMS, GivenArguments, short

SQUARE = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
V = fem.functionspace(SQUARE, ("Lagrange", 1, (2,)))


def table(method, *arguments, state=(), **options):
    given = GivenArguments(SQUARE, state)
    getattr(given, method)(*arguments, **options)
    return given.table


def test_long_texts_keep_their_beginning_and_a_checksum():
    text = "x" * LONG
    assert short(text) == text
    longer, other = short(text + "a"), short(text + "b")
    assert len(longer) < LONG and longer != other and longer.startswith("xxx")


@pytest.mark.parametrize(
    "value, same, other", [(3, 3.0, 4), (0.1, np.float64(0.1), 0.1 + 1e-16), ([1, 2], (1, 2), [2, 1])]
)
def test_numbers_are_texts_with_all_digits(value, same, other):
    first = table("add", "x", value)
    assert first == table("add", "x", same)
    assert (first == table("add", "x", other)) == (value == other)


def test_functions_in_expressions_by_their_sums():
    f = fem.Function(V)
    f.x.array[:] = 1.0
    found = table("add", "x", ufl.inner(f, f))
    (sums,) = [v for k, v in found.items() if k.startswith(SUMS)]
    # Of sizes, values, and values times places, both components: 9 nodes at mean places 1/2.
    assert sums == pytest.approx([9, 9, 9, 9, 4.5, 4.5, 4.5, 4.5])
    assert not any(k.startswith(SUMS) for k in table("add", "x", ufl.inner(f, f), state=[f]))
    assert set(table("add", "x", ufl.inner(f, f), numbers=False)) == {"x"}
    assert table("add", "x", ufl.inner(f, f) ** 2)["x"] != found["x"]


def test_a_mesh_by_numbers_and_places():
    found = table("add_mesh", V)
    assert (found["mesh.num_cells"], found["mesh.num_nodes"], found["mesh.degree"]) == (4, 9, 1)
    # Corners of 4 cells with middles at 1/4 and 3/4: sums of x and y over 16 corners.
    assert found[f"{SUMS}mesh"][:2] == pytest.approx([8.0, 8.0])


def test_prescribed_values_and_their_places():
    fixed = np.array([0, 5])
    found = table("add_prescribed", "bcs", V, fixed, np.array([0.0, 0.25]))[f"{SUMS}bcs"]
    assert found[:4].sum() == pytest.approx(2 + 0.25)  # two marks, and the values' sizes
    assert not np.array_equal(
        found, table("add_prescribed", "bcs", V, np.array([0, 3]), np.array([0.0, 0.25]))[f"{SUMS}bcs"]
    )


def test_materials_and_loads_by_their_arguments():
    law = table("add_material", "material", di.LinearElastic(1.0, 0.3, 2.0, "plane_strain"))
    assert law["material"] == "LinearElastic" and law["material.E"] == "1.0" and law["material.density"] == "2.0"
    load = di.BodyForce((0, -1))
    before = table("add_load", "load", load)
    assert before["load"] == "BodyForce" and before["load.amplitude"] == "without"
    assert set(table("add_load", "load", load, numbers=False)) == set(before) - {"load.vector"}


def test_a_subject_is_its_signature_and_supports():
    rows = np.array([[1.0, 0.0, 0.0]])
    subject = Subject(V, lambda x: {"nodes": int(len(x))}, lambda: (np.array([4]), rows))
    attributes, state = subject.identity()
    assert attributes["nodes"] == 9
    assert state.parts == ["supports"] and np.array_equal(state.part("supports").array("values"), rows)
