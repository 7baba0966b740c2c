# SPDX-License-Identifier: MIT
"""What is written in series of frames: functions by component, set from fields and contacts."""

import types

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact.assembly.history_field import HistoryField
from dolfinx_impact.recording.body_fields import BodyFields
from dolfinx_impact.recording.contact_fields import ContactFields
from dolfinx_impact.recording.field_source import MotionFields
from dolfinx_impact.recording.field_writer import FieldWriter
from dolfinx_impact.recording.output_options import OutputOptions, output_options

SQUARE = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
V = fem.functionspace(SQUARE, ("Lagrange", 1, (2,)))


def test_components_of_fields_of_bodies():
    values = {"stress": np.broadcast_to((1.0, 2.0, 3.0, 4.0), (4, 4, 4)), "alpha": np.full((4, 4, 1), 5.0)}
    fields = [
        HistoryField(name, shape, 2, SQUARE, lambda name=name: values[name])
        for name, shape in (("stress", (4,)), ("alpha", ()))
    ]
    source = BodyFields(SQUARE, fields, ["F/L^2", "1"])
    assert [f.name for f in source.functions] == ["stress_xx", "stress_yy", "stress_zz", "stress_xy", "alpha"]
    assert source.dimensions == ["F/L^2"] * 4 + ["1"]
    source.update()
    for f, value in zip(source.functions, (1.0, 2.0, 3.0, 4.0, 5.0)):
        np.testing.assert_allclose(f.x.array, value, rtol=1e-13)


class Contact:
    """Stands for a contact with two slave nodes, one of them without a master."""

    def __init__(self, nodes):
        self.nodes, self.gap, self.traction = nodes, np.array([0.5, np.inf]), np.array([[1.0, 2.0], [3.0, 4.0]])
        self.refreshed = 0

    def refresh(self):
        self.refreshed += 1

    def at_nodes(self, values):
        return self.nodes, values


@pytest.mark.parametrize("num_contacts", [1, 2])
def test_results_of_contacts_at_nodes(num_contacts):
    contacts = [Contact(np.array([3 + k, 7])) for k in range(num_contacts)]
    source = ContactFields(V, contacts, ["gap", "traction"])
    ends = [""] if num_contacts == 1 else ["_0", "_1"]
    names = [name for end in ends for name in (f"gap{end}", f"traction{end}_x", f"traction{end}_y")]
    assert [f.name for f in source.functions] == names and len(source.dimensions) == len(names)
    source.update()
    for k, contact in enumerate(contacts):
        gap, tx, ty = (f.x.array for f in source.functions[3 * k : 3 * k + 3])
        assert gap[3 + k] == 0.5 and np.isnan(np.delete(gap, 3 + k)).all() and contact.refreshed == 1
        assert tx[3 + k] == 1.0 and ty[7] == 4.0 and np.count_nonzero(tx) == np.count_nonzero(ty) == 2


def test_a_writer_updates_its_sources_and_closes_all_series(tmp_path, monkeypatch):
    u = fem.Function(V, name="displacement")
    motion = MotionFields([u], ["L"])
    motion.update()  # nothing: the values are the problem's
    assert not u.x.array.any() and motion.series == "fields"
    seen = []

    class Series:
        def __init__(self, folder, name, functions, *units):
            self.name, self.functions = name, functions

        def write(self, now):
            seen.append((self.name, now, self.functions[0].name, self.functions[0].x.array[0]))

        def close(self):
            seen.append(self.name)
            raise RuntimeError(self.name)

    monkeypatch.setattr("dolfinx_impact.recording.field_writer.Frames", Series)
    values = types.SimpleNamespace(series="own", functions=[fem.Function(V, name="own")], dimensions=[""])
    values.update = lambda: values.functions[0].x.array.fill(9.0)
    writer = FieldWriter(None, [motion, values], units=di.SI)
    u.x.array[:] = 2.0
    writer.write(0.5)
    assert seen == [("fields.bp", 0.5, "displacement [m]", 2.0), ("own.bp", 0.5, "own", 9.0)]
    assert writer.dimensions == {"displacement": "L", "own": ""} and u.name == "displacement"
    with pytest.raises(RuntimeError):
        writer.close()
    assert set(seen[2:]) == {"fields.bp", "own.bp"} and len(seen) == 4
    writer.close()
    assert len(seen) == 4


def test_options_of_output():
    options = output_options(None, ".xdmf", di.SI)
    assert options == OutputOptions({}, ".xdmf", di.SI) and options.same_on_all_ranks() == [[], ".xdmf", di.SI]
    with pytest.raises(ValueError, match="use one of '.bp', '.xdmf'"):
        output_options(None, ".vtu", None)
    with pytest.raises(TypeError, match="units must be Units, found str"):
        output_options(None, ".bp", "mm")
