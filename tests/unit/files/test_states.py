# SPDX-License-Identifier: MIT
"""States of all kinds through files, what may stand beside them, and what is refused."""

import h5py
import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

from dolfinx_impact import _cpp, compat

files, Place, State = _cpp.files, _cpp.state.Place, _cpp.state.State
NOTHING = State("identity")


@pytest.fixture(scope="module")
def V():
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    return fem.functionspace(domain, ("Lagrange", 1, (2,)))._cpp_object


def tree(rng):
    """Fields at every place, of every type, in parts at several depths."""
    out, inner, side = State("all"), State("inner3"), State("side")
    out.add("u", Place.node, rng.normal(size=(9, 2)))
    out.add("stress", Place.cell, rng.normal(size=(8, 5)))
    out.add("step", Place.all, np.array([7], dtype=np.int64))
    out.add("time", Place.all, np.array([0.1]))
    inner.add("force", Place.node, rng.normal(size=(9, 3)))
    inner.add("work", Place.rank, rng.normal(size=2))
    inner.add("count", Place.rank, np.array([3], dtype=np.int32))
    inner.add("numbers", Place.all, rng.normal(size=20000))  # more than 64 KiB
    side.at(Place.node, np.array([5, 2, 8]))
    side.at(Place.facet, np.array([400, 3]))
    side.add("closed", Place.node, np.array([1, 0, -1], dtype=np.int8))
    side.add("slip", Place.node, rng.normal(size=(3, 2)))
    side.add("multiplier", Place.facet, rng.normal(size=(2, 4)))
    inner.add(side)
    out.add(inner)
    return out


def write(path, V, state, identity=None, supports=NOTHING, more=None):
    files.write(str(path), V, state, identity or {}, supports, more or {})


def read(path, V, like, identity=None, supports=NOTHING, more=(), infinite=()):
    return files.read(str(path), V, like, identity or {}, supports, {}, list(more), [], list(infinite))


def test_a_state_comes_back_bit_for_bit(V, rng, tmp_path):
    state = tree(rng)
    more = {"text": "größer\n'x'", "empty": "", "whole": -(2**62), "real": np.nextafter(1.0, 2.0), "none": np.zeros(0),
            "table": rng.normal(size=(2, 3))}  # fmt: skip
    write(tmp_path / "a.h5", V, state, {"material": "steel", "sums of masses": np.array([1.0, 2.0])}, more=more)
    almost = {"material": "steel", "sums of masses": np.array([1.0, 2.0 + 1e-11])}
    found, attributes = read(tmp_path / "a.h5", V, tree(np.random.default_rng(1)), almost, more=more)
    assert found.difference_of_values(state) == ""
    for name, value in more.items():
        assert type(attributes[name]) is type(value) or isinstance(value, float)
        np.testing.assert_array_equal(attributes[name], value)
    with h5py.File(tmp_path / "a.h5") as file:  # as other programs see it
        assert file.attrs["text"] == more["text"] and file.attrs["format"] == files.FORMAT
        np.testing.assert_array_equal(file["nodes/u"], state.array("u"))
        np.testing.assert_array_equal(file["nodes/force3"], state.part("inner3").array("force"))
        np.testing.assert_array_equal(file["some/side/nodes"], [5, 2, 8])
        np.testing.assert_array_equal(file["ranks/inner3"], [[*state.part("inner3").array("work"), 3.0]])


def test_tables_that_earlier_versions_did_not_write(V, rng, tmp_path):
    """Springs that a node did not have are read as zeros; other tables that lack are errors."""

    def with_part(name):
        out, part = tree(rng), State(name)
        part.at(Place.node, np.array([1, 4]))
        part.add("spring_force", Place.node, rng.normal(size=2))
        out.add(part)
        return out

    path = tmp_path / "a.h5"
    state = tree(rng)
    write(path, V, state)
    found = read(path, V, with_part("other_spring2"))[0]
    assert not np.any(found.part("other_spring2").array("spring_force"))
    np.testing.assert_array_equal(found.array("u"), state.array("u"))
    with pytest.raises(RuntimeError, match="some/spring/nodes is missing"):
        read(path, V, with_part("spring"))


@pytest.mark.parametrize("value", (np.nan, np.inf))
def test_values_that_are_no_numbers(V, value, tmp_path):
    """Infinite ones are numbers where it is said."""
    state, rows = State("s"), np.ones((9, 1))
    rows[3] = value
    state.add("r1", Place.node, rows)
    write(tmp_path / "a.h5", V, state)
    with pytest.raises(RuntimeError, match="nodes/r1 has values that are no numbers"):
        read(tmp_path / "a.h5", V, state)
    if value == np.inf:
        assert read(tmp_path / "a.h5", V, state, infinite=["r"])[0].array("r1")[3] == np.inf
    else:
        with pytest.raises(RuntimeError, match="no numbers"):
            read(tmp_path / "a.h5", V, state, infinite=["r"])


def test_what_is_refused(V, rng, tmp_path):
    state, path = tree(rng), tmp_path / "a.h5"
    supports, part = State("identity"), State("supports")
    part.at(Place.node, np.array([1, 4]))
    part.add("values", Place.node, np.array([1.0, 0.0]))
    supports.add(part)
    write(path, V, state, {"material": "steel", "layers": 3, "size": 0.5}, supports, {"moment": 1.0})
    good = {"material": "steel", "layers": 3, "size": 0.5}
    before = path.read_bytes()
    for wrong, text in (
        ({"material": "rubber"}, "material is 'steel', here 'rubber'"),
        ({"layers": 4}, "layers is 3, here 4"),
        ({"layers": 3.0}, "layers"),
        ({"size": 0.25}, "size is 0.5, here 0.25"),
        ({"more": 1}, "more is none, here 1"),
        ({"size": np.array([0.5])}, "size differ"),
    ):
        with pytest.raises(ValueError, match=f"another problem: {text}"):
            read(path, V, state, {**good, **wrong}, supports)
    with pytest.raises(ValueError, match="lacks moments"):
        read(path, V, state, good, supports, more=["moments"])
    for nodes, values, text in (([1, 4], [1.0, 1.0], "supports differ, the first at"), ([1, 5], [1.0, 0.0], "1 are"),
                                ([1], [1.0], "supports has 2 nodes, here 1")):  # fmt: skip
        other, part = State("identity"), State("supports")
        part.at(Place.node, np.array(nodes))
        part.add("values", Place.node, np.array(values))
        other.add(part)
        with pytest.raises(ValueError, match=text):
            read(path, V, state, good, other)
    with pytest.raises(RuntimeError, match="tables that the problem does not know: some/supports/nodes"):
        read(path, V, state, good)
    other = State("other")
    other.add("u", Place.node, np.zeros((9, 3)))
    with pytest.raises(RuntimeError, match=r"nodes/u has shape \(9, 2\)"):
        read(path, V, other, good, supports)
    # What cannot be written leaves the file as it was.
    twice, facets = State("twice"), State("facets")
    twice.add("u", Place.all, np.zeros(1))
    with pytest.raises(ValueError, match="two attributes of the name u"):
        write(path, V, twice, {"u": 1.0})
    facets.add("pressure", Place.facet, np.zeros(2))
    with pytest.raises(ValueError, match="does not say which facets"):
        write(path, V, facets)
    same = State("same")
    for name in ("x1", "y1"):
        inner = State(name)
        inner.add("u", Place.node, np.zeros((9, 1)))
        same.add(inner)
    with pytest.raises(RuntimeError, match="are the table nodes/u1"):
        write(path, V, same)
    assert path.read_bytes() == before


def test_places_of_mixed_spaces():
    """Each degree of freedom lies where the point of its field does."""
    import basix.ufl

    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    P2 = basix.ufl.element("Lagrange", "triangle", 2, shape=(2,))
    W = fem.functionspace(domain, basix.ufl.mixed_element([P2, basix.ufl.element("Lagrange", "triangle", 1)]))
    x, f = files.places(W._cpp_object), fem.Function(W)
    f.sub(0).interpolate(lambda p: (p[0], p[1]))
    f.sub(1).interpolate(lambda p: p[0])
    of_x, of_y = (compat.collapse(W.sub(0).sub(k))[1] for k in range(2))
    np.testing.assert_allclose(f.x.array[of_x], x[of_x, 0], atol=1e-14)
    np.testing.assert_allclose(f.x.array[of_y], x[of_y, 1], atol=1e-14)
    pressure = compat.collapse(W.sub(1))[1]
    np.testing.assert_allclose(f.x.array[pressure], x[pressure, 0], atol=1e-14)


def test_submeshes_have_no_files(tmp_path):
    """Their cells cannot be told on other ranks."""
    domain = mesh.create_unit_square(MPI.COMM_SELF, 2, 2)
    part = mesh.create_submesh(domain, 2, np.arange(4, dtype=np.int32))[0]
    with pytest.raises(RuntimeError, match="which a submesh does not have"):
        write(tmp_path / "a.h5", fem.functionspace(part, ("Lagrange", 1, (2,)))._cpp_object, State("s"))
    assert not any(tmp_path.iterdir())
