# SPDX-License-Identifier: MIT
"""Results of contacts as functions on the mesh, of problems of every kind, on any number of ranks. See on_ranks.py."""

import numpy as np
import pytest
import ufl
from dolfinx import fem
from mpi4py import MPI
from recorded_fields_checks import CONTACTS, COMM, Blocks, E, law, read
from rolling_checks import wheel_on_plane
from shared_folder import shared_folder

import dolfinx_impact as di
from dolfinx_impact.rolling.recorded_states import RecordedStates


def solved(kind, method, two):
    blocks = Blocks(two, friction=0.2 if kind != "static" else 0.0)
    u = fem.Function(blocks.V)
    options = {"penalty": 10 * E} if method is di.Penalty and kind != "explicit" else {}
    contact = method(blocks.pair, **options)
    if kind == "static":
        problem = di.StaticProblem(u, law(), bcs=blocks.held(), contact=contact)
        problem.solve(progress=False)
    else:
        make = di.ExplicitProblem if kind == "explicit" else di.NewmarkProblem
        problem = make(u, law(), velocity=blocks.falling(), contact=contact)
        problem.advance(6e-3, dt=1e-3, progress=False)
    return blocks, problem


KINDS = [("static", di.Lagrange), ("static", di.Penalty), ("implicit", di.Lagrange), ("implicit", di.Penalty)]
KINDS += [("explicit", di.Penalty), ("explicit", di.Kinematic)]


def check_functions_have_the_values_of_the_nodes():
    for k, (kind, method) in enumerate(KINDS):
        blocks, problem = solved(kind, method, two=bool(k % 2))
        contact, gdim = problem.contact[0], 2
        for name in CONTACTS:
            f = contact.function(name)
            nodes, values = contact.at_nodes(getattr(contact, name))
            found = f.x.array.reshape(-1, *values.shape[1:])
            assert f.name == name and f.function_space.mesh is blocks.mesh, name
            assert f.ufl_shape == (() if values.ndim == 1 else (gdim,)), name
            np.testing.assert_array_equal(found[nodes], np.where(np.isfinite(values), values, np.nan))
            other = contact.function(name, elsewhere=-7.0)
            others = np.setdiff1d(np.arange(len(found)), nodes)
            owned = others[others < blocks.V.dofmap.index_map.size_local]
            rest = other.x.array.reshape(found.shape)[owned]
            # Ghosts have what their owner has: a slave node that another rank owns is one of the others here.
            assert np.all(rest == -7.0), name
            out = contact.function(name, out=f)
            assert out is f


def check_the_integral_of_pressure_is_the_force():
    """Of a uniform pressure of a static problem: nu = 0, no friction; as far as Newton's method has converged."""
    for method in (di.Lagrange, di.Penalty):
        blocks, problem = solved("static", method, True)
        ds = ufl.Measure("ds", domain=blocks.mesh, subdomain_data=blocks.tags)(1)
        total = COMM.allreduce(fem.assemble_scalar(fem.form(problem.contact[0].function("pressure") * ds)), MPI.SUM)
        assert total == pytest.approx(problem.contact[0].force[1], rel=1e-8) and total > 1.0


def check_a_gap_is_no_number_elsewhere():
    blocks, problem = solved("explicit", di.Penalty, True)
    gap = problem.contact[0].function("gap")
    nodes = problem.contact[0].nodes
    others = np.setdiff1d(np.arange(blocks.V.dofmap.index_map.size_local), nodes)
    assert np.all(np.isnan(gap.x.array[others])) and np.all(np.isfinite(gap.x.array[nodes]))


def check_what_is_refused():
    blocks, problem = solved("static", di.Lagrange, False)
    contact = problem.contact[0]
    with pytest.raises(ValueError, match="1 on RigidPlane has no field 'weight': use one of pressure, gap"):
        contact.function("weight")
    with pytest.raises(ValueError, match="has no field 'slip_velocity'"):
        contact.function("slip_velocity")
    with pytest.raises(ValueError, match="out is no function"):
        contact.function("traction", out=contact.function("pressure"))


def check_steady_rolling_records_its_states():
    """A frame for each steady state, of a sweep, too; slip velocity is a field of contacts with friction."""
    problem = wheel_on_plane()
    with shared_folder() as path:
        with pytest.raises(ValueError, match="are unknown"):
            problem.record(path / "no", ["velocity"])
        recorder = problem.record(path / "run", ["displacement", "pressure", "slip_velocity"], ending=".xdmf")
        assert isinstance(recorder.problem, RecordedStates) and recorder.problem.recorders == [recorder]
        problem.solve(steps=2)
        contact = problem.contact[0]
        first = contact.pressure.max(initial=0.0), contact.force[1]
        problem.sweep(creep=[2e-3, 8e-3], progress=False)
        recorder.close()
        slip = contact.function("slip_velocity")
        own = slip.function_space.dofmap.index_map.size_local
        largest = np.abs(slip.x.array.reshape(-1, 3)[:own, 0]).max(initial=0.0)
        points, found = read(path / "run", "contact")
        assert {*found} == {"pressure", "slip_velocity_x", "slip_velocity_y", "slip_velocity_z"}
        assert np.abs(found["slip_velocity_x"]).max() == COMM.allreduce(largest, MPI.MAX) > 0.0
        _, before = read(path / "run", "contact", 0)
        assert before["pressure"].max() == COMM.allreduce(first[0], MPI.MAX)
        import h5py

        COMM.barrier()
        with h5py.File(path / "run" / "history.h5", "r") as file:
            assert file["load_step"][:].tolist() == [1.0, 2.0, 3.0]
            assert file["force_0"][0, 1] == first[1]
            assert file["force_0"].attrs["contact"] == "7 on RigidPlane"
        COMM.barrier()
