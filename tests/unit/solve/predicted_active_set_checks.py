# SPDX-License-Identifier: MIT
"""Predicted active sets, and hierarchies that serve other ones, on the ranks of COMM_WORLD. See on_ranks.py."""

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp

COMM = MPI.COMM_WORLD
MULTIGRID = {"ksp_type": "cg", "pc_type": "gamg"}
FIRST, SECOND = 0.05, 0.03  # depths; the lower side of the block is 0.1 higher at its corners than in its middle


def block(comm, options, friction=0.0):
    """A block with a round lower side above a plane: the problem, and the displacement of its upper side."""
    domain = mesh.create_unit_cube(comm, 6, 6, 4, mesh.CellType.hexahedron)
    x = domain.geometry.x
    x[:, 2] += 0.2 * (1 - x[:, 2]) * ((x[:, 0] - 0.5) ** 2 + (x[:, 1] - 0.5) ** 2)
    V = fem.functionspace(domain, ("Lagrange", 1, (3,)))
    above = mesh.locate_entities_boundary(domain, 2, lambda x: np.isclose(x[2], 1.0))
    below = mesh.exterior_facet_indices(domain.topology)
    low = mesh.locate_entities(domain, 2, lambda x: x[2] < 0.15)
    below = np.intersect1d(below, low).astype(np.int32)
    tags = mesh.meshtags(domain, 2, below, np.ones(len(below), dtype=np.int32))
    down = fem.Constant(domain, (0.0, 0.0, -FIRST))
    bcs = [fem.dirichletbc(down, fem.locate_dofs_topological(V, 2, above), V)]
    pair = di.ContactPair(tags, 1, di.RigidPlane((0.0, 0.0, 0.0), (0.0, 0.0, 1.0)), friction=friction)
    law = di.LinearElastic(1000.0, 0.3)
    problem = di.StaticProblem(fem.Function(V), law, bcs=bcs, contact=[di.Lagrange(pair)], options=options)
    return problem, down


def pressed(comm, options, friction=0.0):
    """The block is moved onto the plane, then back a part of the way: reports and force."""
    problem, down = block(comm, options, friction)
    found = []
    for depth in (FIRST, SECOND):
        down.value[2] = -depth
        report = problem.solve(progress=False)
        sizes = [list(s) for s in report.active_set_sizes], [list(c) for c in report.contact_changes]
        found.append((*sizes, np.array(problem.contact[0].force)))
    return found, problem.linear_solver.num_set_ups


def check_prediction_is_that_of_one_rank():
    for options in (None, MULTIGRID):
        (here, _), (alone, set_ups) = pressed(COMM, options), pressed(MPI.COMM_SELF, options)
        for (sizes, changes, force), (expected_sizes, expected_changes, expected) in zip(here, alone, strict=True):
            assert COMM.allgather((sizes, changes)) == [(sizes, changes)] * COMM.size
            assert (sizes, changes) == (expected_sizes, expected_changes)
            # Both are solved to 1e-8 of the force.
            np.testing.assert_allclose(force, expected, rtol=0, atol=1e-6 * np.abs(expected).max())
        (first, changes, _), (second, _, _) = alone
        assert first[0][-1] > second[0][-1] > 0  # fewer nodes in the end
        assert sum(changes[0]) < 0.5 * first[0][-1]  # most were predicted
        assert set_ups == (1 if options else 2)  # a hierarchy serves other active sets


def check_columns_of_a_condensed_system():
    problem, down = block(COMM, None, friction=0.02)  # nodes slip
    down.value[2] = -FIRST
    problem.solve(progress=False)
    contact, num = problem.contact[0], problem.num_owned
    K, first = problem.tangent.assemble(), 3 * problem.space.dofmap.index_map.local_range[0]
    condensation = _cpp.multipliers.Condensation(COMM, num, first, 3, [contact.constraints()])
    pinned = problem.fixed[:num].astype(bool) | condensation.pinned
    system = _cpp.solve.CondensedSystem(K, [K], True, condensation, pinned, 1.0)
    dofs = np.arange(num)
    chosen = dofs[~pinned & np.isin(dofs // 3, contact.nodes)].astype(np.int32)
    columns = system.columns(chosen)
    assert columns.getSize()[1] == COMM.allreduce(len(chosen)) > 10 and not system.symmetric
    weights, product = columns.createVecs()
    x, y = system.create_vector(), system.create_vector()
    weights.array[:] = 1.0 + np.arange(len(chosen))
    x.set(0.0)
    x.array[chosen] = weights.array
    columns.mult(weights, product)
    system.mult(x, y)
    assert y.norm() > 0.0
    # Sums of the same few products in another order.
    np.testing.assert_allclose(product.array, y.array, rtol=0, atol=1e-12 * y.norm())
