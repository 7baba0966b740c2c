# SPDX-License-Identifier: MIT
"""What residuals are relative to: forces of a state that counts, not those of an iterate far away."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

LAWS = {
    "linear": di.LinearElastic,
    "neo-hookean": di.NeoHookean,
    "saint venant-kirchhoff": di.StVenantKirchhoff,
}


def punch(law, cell, options=None, down=0.1):
    """A block with a rounded underside that is moved onto a plane of stiff springs: the step to the prescribed values,
    without contact, has forces far above those of the solution, which follow as points open and close."""
    domain = mesh.create_rectangle(MPI.COMM_SELF, [(-1.0, 0.0), (1.0, 1.0)], (12, 6), mesh.CellType[cell])
    x = domain.geometry.x
    x[:, 1] += 0.1 * x[:, 0] ** 2 * (1.0 - x[:, 1])
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    top = mesh.locate_entities_boundary(domain, 1, lambda x: np.isclose(x[1], 1.0))
    under = mesh.locate_entities_boundary(domain, 1, lambda x: np.abs(x[1] - 0.1 * x[0] ** 2) < 0.02)
    tags = mesh.meshtags(domain, 1, np.sort(under), np.ones(len(under), dtype=np.int32))
    bcs = [fem.dirichletbc(np.array([0.0, -down]), fem.locate_dofs_topological(V, 1, top), V)]
    pair = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0), (0.0, 1.0)))
    return di.StaticProblem(
        fem.Function(V), LAWS[law](1.0, 0.3, hypothesis="plane_strain"), bcs=bcs, options=options,
        contact=[di.Penalty(pair, penalty=1e5)],
    )  # fmt: skip


def forces(problem):
    """Norms of the residual at free nodes, and of all entries: supports and what the tangent and u balance."""
    residual = problem.reactions().x.array
    free = np.where(problem.fixed, 0.0, residual)
    tangent = problem.tangent.assemble()
    inner = (tangent * problem.u.x.petsc_vec).array
    return np.linalg.norm(free), max(np.linalg.norm(residual), np.linalg.norm(np.where(problem.fixed, 0.0, inner)))


@pytest.mark.parametrize("options", (None, {"snes_type": "newtonls", "snes_linesearch_type": "basic"}))
@pytest.mark.parametrize("rtol", (1e-2, 1e-4, 1e-6))
@pytest.mark.parametrize("cell", ("quadrilateral", "triangle"))
@pytest.mark.parametrize("law", LAWS)
def test_a_wild_first_iterate_does_not_set_the_scale(law, cell, rtol, options):
    """The first iterate has forces of ten thousand times those of the solution; what converged is in balance to the
    tolerance of its own forces."""
    problem = punch(law, cell, options)
    report = problem.solve(rtol=rtol, max_iterations=100)
    left, scale = forces(problem)
    seen = max(max(norms) for norms in report.residual_norms)
    assert report.cut_backs == 0 and seen > 1e4 * scale, (seen, scale)
    assert left <= rtol * scale, (left, scale, report.residual_norms)


def test_forces_of_the_start_count():
    """Of a body whose supports go back nothing is left to compare with but the forces that it had."""
    problem = punch("neo-hookean", "triangle")
    problem.solve(steps=4)
    _, loaded = forces(problem)
    problem.bcs[0].g.value[:] = 0.0
    assert problem.solve(steps=1).converged
    assert forces(problem)[0] <= 1e-10 * loaded
