# SPDX-License-Identifier: MIT
"""An exception on one rank in the middle of a solution ends all ranks: nothing that handles it communicates."""

import itertools

import pytest

FAST = {("implicit", "contact", "Lagrange"), ("explicit", "recorder", "Penalty")}
SCRIPT = """
import sys
import tempfile
import types

import numpy as np
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp, meshes
from dolfinx_impact.contact import in_cpp
from dolfinx_impact.statics.material_body import MaterialBody

kind, stage, method = sys.argv[1:]
m = meshes.make("two_blocks", MPI.COMM_WORLD, lower_cells=(3, 2), upper_cells=(2, 2), gap=0.0)
V = fem.functionspace(m.mesh, ("Lagrange", 1, (2,)))
foot = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 0.0))
bcs = [fem.dirichletbc(np.zeros(2), foot, V)]
law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain")
pair = di.ContactPair(m.facet_tags, m.tags["slave_surface"], m.tags["master_surface"])
if stage == "contact":  # is called in C++ otherwise
    in_cpp.contact_in_cpp = _cpp.solve.PythonContact
calls = types.SimpleNamespace()  # what bodies call, in C++ otherwise
def in_python(self):
    right = self._cpp_object
    calls.residual, calls.tangent, calls.fault = right.residual, right.tangent, right.fault
    return _cpp.solve.FunctionBody(
        residual=lambda: calls.residual(), tangent=lambda: calls.tangent(), fault=lambda: calls.fault(),
        accept_step=None, origin=None, stored_energy=None, properties=right.properties)
MaterialBody.in_cpp = in_python
contact = [getattr(di, method)(pair)]
u, load = fem.Function(V), di.BodyForce((0.0, -1.0))
if kind == "static":
    top = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 1.0))
    p = di.StaticProblem(u, law, bcs=[*bcs, fem.dirichletbc(np.array([0.0, -1e-3]), top, V)], contact=contact)
    run = lambda: p.solve()
elif kind == "explicit":
    p = di.ExplicitProblem(u, law, velocity=fem.Function(V), bcs=bcs, loads=[load], contact=contact)
    run = lambda: p.advance(p.time + 0.02, progress=False)
    recorder = p.record(V.mesh.comm.bcast(tempfile.mkdtemp()), every=1)
else:
    p = di.NewmarkProblem(u, law, velocity=fem.Function(V), bcs=bcs, loads=[load], contact=contact)
    run = lambda: p.advance(p.time + 0.02, dt=0.01, progress=False)
run()
owner, name = {
    "residual": lambda: (calls, "residual"),
    "tangent": lambda: (calls, "tangent"),
    "contact": lambda: (p.contact[0], "update_gap"),
    "fault": lambda: (calls, "fault"),
    "recorder": lambda: (recorder, "after"),
}[stage]()
if MPI.COMM_WORLD.rank == 1:
    def fail(*args, **kwargs):
        raise KeyError("found in " + stage)
    setattr(owner, name, fail)
if kind == "static":
    p.bcs[-1].g.value[1] = -2e-3
run()
print("no error")
"""

STAGES = ("residual", "tangent", "contact", "fault")
TABLE = [*itertools.product(("static", "implicit"), STAGES, ("Lagrange", "Penalty"))]
TABLE += [("explicit", "recorder", "Penalty"), ("explicit", "recorder", "Kinematic")]


@pytest.mark.mpi
@pytest.mark.long_rows(where=lambda kind, stage, method: (kind, stage, method) not in FAST)
@pytest.mark.parametrize("kind, stage, method", TABLE)
def test_all_ranks_end(mpirun, kind, stage, method):
    output = mpirun(2, SCRIPT, kind, stage, method, timeout=40, status=None)
    assert f"KeyError: 'found in {stage}'" in output and "no error" not in output, output
