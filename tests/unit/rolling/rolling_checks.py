# SPDX-License-Identifier: MIT
"""Rolling problems on any number of ranks: a ring of quadrilaterals about the origin, and blocks that flow straight."""

import basix.ufl
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
INNER, OUTER = 1.0, 2.0


def tagged(domain, tag=1):
    """All cells with one tag."""
    index_map = domain.topology.index_map(domain.topology.dim)
    count = index_map.size_local + index_map.num_ghosts
    return mesh.meshtags(domain, domain.topology.dim, np.arange(count, dtype=np.int32), np.full(count, tag, np.int32))


def quarter_ring():
    """A quarter of a ring, bent from a rectangle; the ends at x = 0 and y = 0 are not of revolution."""
    domain = mesh.create_rectangle(COMM, [(INNER, 0.0), (OUTER, 1.0)], (4, 16), mesh.CellType.quadrilateral)
    r, angle = domain.geometry.x[:, 0].copy(), domain.geometry.x[:, 1] * np.pi / 2
    domain.geometry.x[:, 0], domain.geometry.x[:, 1] = r * np.cos(angle), r * np.sin(angle)
    return domain


def ring(cells=32):
    """A whole ring with 4 cells across."""
    x, quads = np.zeros((0, 2)), np.zeros((0, 4), dtype=np.int64)
    if COMM.rank == 0:
        r, angle = np.linspace(INNER, OUTER, 5), 2 * np.pi * np.arange(cells) / cells
        x = np.array([[a * np.cos(t), a * np.sin(t)] for t in angle for a in r])
        node = 5 * np.arange(cells)
        after = np.roll(node, -1)
        quads = np.array([[n + i, n + i + 1, m + i, m + i + 1] for n, m in zip(node, after) for i in range(4)])
    element = basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,))
    return mesh.create_mesh(COMM, quads, x, element)


def bound(V):
    """Hold the inner surface."""
    return [fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: np.hypot(x[0], x[1]) < 1.001), V)]


def spinning(law=di.LinearElastic, omega=0.1, domain=None, **given):
    domain = domain or ring()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    material = law(1.0, 0.3, density=1.0, hypothesis="plane_strain")
    motions = {1: di.Spin((0.0, 0.0), (0.0, 0.0, 2.0), omega)}
    return di.RollingProblem(fem.Function(V), material, tagged(domain), motions, bcs=bound(V), **given)


def norm(problem):
    u = problem.u
    owned = u.x.array[: u.function_space.dofmap.index_map.size_local * 2]
    return np.sqrt(COMM.allreduce(float(owned @ owned)))


def check_solution_does_not_depend_on_ranks():
    found = {}
    for law in (di.LinearElastic, di.StVenantKirchhoff, di.NeoHookean):
        problem = spinning(law, omega=0.2)
        assert problem.solve(steps=2).converged
        found[law.__name__] = norm(problem)
        assert abs(problem.torque) < 1e-8  # nothing turns the ring; forces at its supports are of order 0.1
    # Finite strain differs by the order of the strain, 0.1; a wrong law would be off by more.
    assert all(0.5 < value / found["LinearElastic"] < 2.0 for value in found.values())
    alone = spinning(omega=0.2)
    alone.solve()
    assert norm(alone) == pytest.approx(found["LinearElastic"], rel=1e-9)  # two steps or one: linear


def check_torque_of_supports_balances_a_traction():
    domain = ring()
    facets = mesh.locate_entities_boundary(domain, 1, lambda x: np.hypot(x[0], x[1]) > 1.99)
    tags = mesh.meshtags(domain, 1, np.sort(facets), np.full(len(facets), 7, np.int32))
    x = ufl.SpatialCoordinate(domain)
    load = di.Traction(tags, 7, 1e-6 * ufl.as_vector([-x[1], x[0]]))  # its moment per area is 1e-6 r^2
    problem = spinning(omega=1e-3, domain=domain, loads=[load])
    problem.solve()
    moment = 1e-6 * fem.assemble_scalar(fem.form(ufl.inner(x, x) * ufl.ds(domain=domain, subdomain_data=tags)(7)))
    moment = COMM.allreduce(moment)
    assert problem.torque == pytest.approx(-moment, rel=1e-3)  # places move by less than 1e-4


def check_beyond_the_critical_speed():
    problem = spinning(omega=0.1)
    problem.solve()
    before = problem.u.x.array.copy()
    problem.motions[1].omega = 3.0  # the ring's shear waves travel at 0.62
    with pytest.raises(RuntimeError, match="critical"):
        problem.solve()
    assert np.array_equal(problem.u.x.array, before)
    problem.motions[1].omega = 0.1
    assert problem.solve().converged
    assert np.allclose(problem.u.x.array, before, atol=1e-10)


def check_frequencies_come_in_waves():
    still, turning = (spinning(omega=omega).frequencies(5) for omega in (0.0, 0.02))
    assert np.all(still > 0)
    assert np.all(np.diff(np.abs(turning)) >= -1e-9)
    assert np.any(turning < 0) and np.any(turning > 0)
    other = spinning(omega=-0.02).frequencies(5)
    assert np.allclose(turning, other, rtol=1e-6)  # signs count along the spin


def check_contact_with_a_plane():
    domain = ring()
    facets = mesh.locate_entities_boundary(domain, 1, lambda x: np.hypot(x[0], x[1]) > 1.99)
    tags = mesh.meshtags(domain, 1, np.sort(facets), np.full(len(facets), 7, np.int32))
    forces = []
    for kind in (di.Lagrange, di.Penalty):
        pair = di.ContactPair(tags, 7, di.RigidPlane((0.0, -1.97), (0.0, 1.0)))
        problem = spinning(omega=0.01, domain=domain, contact=[kind(pair)])
        assert problem.solve().converged
        force = problem.contact[0].force
        assert force[1] > 1e-3 and abs(force[0]) < 1e-8 * force[1]
        assert abs(problem.torque) < 1e-7 * force[1] * OUTER
        forces.append(force[1])
    assert forces[1] == pytest.approx(forces[0], rel=0.2)  # penalty lets the ring in


def check_straight_flow():
    domain = mesh.create_rectangle(COMM, [(0.0, 0.0), (4.0, 1.0)], (16, 4))
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    bcs = [fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 0.0)), V)]
    material = di.LinearElastic(1.0, 0.3, density=1.0, hypothesis="plane_strain")
    sizes = []
    for load, speed in ((0.0, 0.3), (1e-3, 0.0), (1e-3, 0.3)):
        motions = {1: di.Translation((speed, 0.0))}
        given = {"bcs": bcs, "loads": [di.BodyForce((0.0, load))]}
        problem = di.RollingProblem(fem.Function(V), material, tagged(domain), motions, **given)
        problem.solve()
        sizes.append(norm(problem))
    assert sizes[0] < 1e-14  # a straight flow has no acceleration
    assert sizes[2] > sizes[1] * (1 + 1e-4)  # W softens


def check_bad_bodies():
    with pytest.raises(ValueError, match=r"not one of revolution.*cell \d+ .* at \("):
        spinning(domain=quarter_ring())
    domain = ring()
    V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
    material = di.LinearElastic(1.0, 0.3, density=1.0, hypothesis="plane_strain")
    turn = di.Spin((0.0, 0.0), (0.0, 0.0, 1.0), 0.1)

    def make(motions):
        return di.RollingProblem(fem.Function(V), material, tagged(domain), motions, bcs=bound(V))

    with pytest.raises(ValueError, match=r"not one of revolution"):
        make({1: di.Spin((0.5, 0.0), (0.0, 0.0, 1.0), 0.1)})
    with pytest.raises(ValueError, match=r"tags \[1\], which have no motion"):
        make({2: turn})
    with pytest.raises(ValueError, match=r"tags \[2\], which no cell carries"):
        make({1: turn, 2: turn})
    with pytest.raises(ValueError, match="along z"):
        make({1: di.Spin((0.0, 0.0), (1.0, 0.0, 0.0), 0.1)})
    with pytest.raises(ValueError, match="components"):
        make({1: di.Translation((1.0, 0.0, 0.0))})
    with pytest.raises(TypeError, match="Spin or a Translation"):
        make({1: 3.0})
