# SPDX-License-Identifier: MIT
"""Supports, loads and contacts of problems are one object or a list; anything else is refused in plain words."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

PROBLEMS = ("static", "explicit", "implicit", "rolling")


class Block:
    """A square above a rigid plane, held at its top."""

    def __init__(self):
        self.mesh = mesh.create_unit_square(MPI.COMM_SELF, 2, 2, mesh.CellType.quadrilateral)
        bottom = mesh.locate_entities_boundary(self.mesh, 1, lambda x: np.isclose(x[1], 0.0))
        self.tags = mesh.meshtags(self.mesh, 1, np.sort(bottom), np.full(len(bottom), 1, dtype=np.int32))
        self.cells = mesh.meshtags(self.mesh, 2, np.arange(4, dtype=np.int32), np.full(4, 7, dtype=np.int32))
        self.V = fem.functionspace(self.mesh, ("Lagrange", 1, (2,)))
        self.material = di.LinearElastic(1e4, 0.3, 1.0, "plane_strain")
        top = fem.locate_dofs_geometrical(self.V, lambda x: np.isclose(x[1], 1.0))
        self.bc = fem.dirichletbc(np.zeros(2), top, self.V)
        self.load = di.Traction(self.tags, 1, (3.0, 0.0))
        self.pair = di.ContactPair(self.tags, 1, di.RigidPlane((0.0, 0.01), (0.0, 1.0)))

    def problem(self, kind, **given):
        u, velocity = fem.Function(self.V), fem.Function(self.V)
        if kind == "static":
            return di.StaticProblem(u, self.material, **given)
        if kind == "rolling":
            motions = {7: di.Translation((1.0, 0.0))}
            return di.RollingProblem(u, self.material, self.cells, motions, **given)
        return {"explicit": di.ExplicitProblem, "implicit": di.NewmarkProblem}[kind](
            u, self.material, velocity=velocity, **given
        )


def solved(problem):
    if hasattr(problem, "solve"):
        problem.solve()
    else:
        problem.advance(1e-3, dt=5e-4, progress=False)
    return problem.u.x.array, problem.contact[0].force


@pytest.mark.parametrize("kind", PROBLEMS)
def test_one_object_is_a_list_of_one(kind):
    block = Block()
    given = {"bcs": block.bc, "loads": block.load, "contact": di.Penalty(block.pair, penalty=1e5)}
    one = solved(block.problem(kind, **given))
    listed = solved(block.problem(kind, **{name: [thing] for name, thing in given.items()}))
    assert np.any(one[1] != 0.0)
    for a, b in zip(one, listed):
        np.testing.assert_array_equal(a, b)


@pytest.mark.parametrize("kind", PROBLEMS)
def test_anything_else_is_refused(kind):
    block = Block()
    wrong = {
        "bcs": (block.load, "bcs must be a DirichletBC or a list of them, found Traction"),
        "loads": ((load for load in [block.load]), "loads must be a load or a list of them, found generator"),
        "contact": (di.Penalty, r"found the class Penalty: make an object of it, Penalty\(...\)"),
    }
    for name, (thing, words) in wrong.items():
        with pytest.raises(TypeError, match=words):
            block.problem(kind, **{name: thing})
        with pytest.raises(TypeError, match=f"{name} must be .* found NoneType: leave it out"):
            block.problem(kind, **{name: None})
    with pytest.raises(TypeError, match=r"say how it is enforced"):
        block.problem(kind, contact=block.pair)


def test_a_prescribed_motion_alone():
    block = Block()
    motion = di.PrescribedMotion(block.bc, lambda t: t)
    for kind in ("explicit", "implicit"):
        assert len(block.problem(kind, bcs=motion).supports) == 1


def test_an_explicit_run_from_an_equilibrium():
    block = Block()
    static = block.problem("static", bcs=block.bc, contact=di.Lagrange(block.pair))
    static.solve()
    run = di.ExplicitProblem.from_static(static, bcs=block.bc, contact=di.Penalty(block.pair))
    assert len(run.contact) == 1


def test_a_tangent_with_one_support():
    import ufl

    block = Block()
    u, v = ufl.TrialFunction(block.V), ufl.TestFunction(block.V)
    one, listed = (di.Tangent(ufl.inner(u, v) * ufl.dx, bcs).assemble() for bcs in (block.bc, [block.bc]))
    assert (one - listed).norm() == 0.0
