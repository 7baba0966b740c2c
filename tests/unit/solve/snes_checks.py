# SPDX-License-Identifier: MIT
"""Problems solved by PETSc's nonlinear methods against the package's own. See on_ranks.py."""

import functools

import numpy as np
import pytest
from contact_checks import pressed
from dolfinx import fem, mesh
from mpi4py import MPI
from petsc4py import PETSc

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
RTOL = 1e-12
SAME = 1e-9  # a thousandfold of Newton's tolerance: the condition of some hundred unknowns


@functools.cache
def block():
    """One mesh for all solutions that are compared: DOLFINx may partition a second one otherwise."""
    return mesh.create_unit_cube(COMM, 3, 3, 3, mesh.CellType.hexahedron)


def stretched(options=None, prefix="impact_static_", **arguments):
    """A block of rubber, stretched by 40 % and sheared; displacements and report."""
    V = fem.functionspace(block(), ("Lagrange", 1, (3,)))
    ends = [fem.locate_dofs_geometrical(V, lambda x, z=z: np.isclose(x[2], z)) for z in (0.0, 1.0)]
    values = np.zeros(3), np.array([0.2, 0.0, 0.4])
    bcs = [fem.dirichletbc(value, dofs, V) for value, dofs in zip(values, ends)]
    u = fem.Function(V)
    problem = di.StaticProblem(u, di.NeoHookean(1e5, 0.3, 1.0), bcs=bcs, options=options, prefix=prefix)
    return u.x.array, problem.solve(**arguments)


def check_methods_of_petsc_give_the_same():
    """Line search and trust region, without contact and with penalty contact and friction."""
    own, report = stretched(rtol=RTOL)
    for kind in ("newtonls", "newtontr"):
        other, others = stretched({"snes_type": kind}, rtol=RTOL)
        np.testing.assert_allclose(other, own, rtol=0, atol=SAME)
        assert others.iterations == report.iterations and others.residual_norms[0] != report.residual_norms[0]
    for friction in (0.0, 0.3):
        arguments = dict(contact=lambda pair: di.Penalty(pair, penalty=1e4), friction=friction, pull=0.009, rtol=RTOL)
        own = pressed(COMM, 2, **arguments)
        other = pressed(COMM, 2, **arguments, options={"snes_type": "newtonls"})
        np.testing.assert_allclose(other[1], own[1], rtol=0, atol=SAME * np.abs(own[1]).max())
        assert np.abs(other[3]).max() < 1e-12 * np.abs(own[1]).max()  # opposite forces


def check_augmented_penalty_by_petsc():
    """Uzawa's loop goes round PETSc's method as well: the penetration goes away."""
    contact = lambda pair: di.Penalty(pair, penalty=1e4, augmented=True)  # noqa: E731
    (_, pressure, *_, gap), force, *_ = pressed(COMM, 2, contact, 0.0, options={"snes_type": "newtonls"})
    plain, *_ = pressed(COMM, 2, lambda pair: di.Penalty(pair, penalty=1e4), 0.0)
    depth = [np.sum(p * np.minimum(g, 0.0)) / np.sum(p) for p, g in ((pressure, gap), (plain[1], plain[4]))]
    assert abs(depth[0]) < 0.05 * abs(depth[1]) and force[1] > 0


def check_tolerances_and_monitors_by_options():
    """-snes_rtol, -snes_max_it and monitors act on the package's own method; those of the command line go first."""
    loose, report = stretched({"snes_rtol": 1e-2})
    _, tight = stretched()
    assert report.iterations[0] < tight.iterations[0]
    with pytest.raises(RuntimeError, match="did not converge in 2 iterations"):
        stretched({"snes_max_it": 2})
    database = PETSc.Options()
    database["mine_snes_max_it"] = 1
    try:
        with pytest.raises(RuntimeError, match="did not converge in 1 iterations"):
            stretched({"snes_max_it": 50}, prefix="mine_")
    finally:
        database.delValue("mine_snes_max_it")


def check_multipliers_need_the_own_method():
    with pytest.raises(ValueError, match="snes_type is 'newtonls': Lagrange multipliers need"):
        pressed(COMM, 2, di.Lagrange, options={"snes_type": "newtonls"})


def check_failure_of_petsc_keeps_the_state():
    """A method that does not converge says so, with PETSc's reason; displacements stay those before."""
    with pytest.raises(RuntimeError, match="SNES of type newtonls did not converge: PETSc reason -5"):
        stretched({"snes_type": "newtonls", "snes_max_it": 1}, cut_backs=1)
