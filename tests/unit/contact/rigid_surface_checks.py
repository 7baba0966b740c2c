# SPDX-License-Identifier: MIT
"""Rigid surfaces of any form as masters: the same results as with the closed forms they equal. See on_ranks.py."""

import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

COMM = MPI.COMM_WORLD
BOUNDS = (-2.0, 3.0)


def block(comm=COMM, n=6, dim=2):
    """Unit square or cube; displacement space and facet tags: 1 below, 2 above."""
    if dim == 2:
        domain = mesh.create_unit_square(comm, n, n, mesh.CellType.quadrilateral)
    else:
        domain = mesh.create_unit_cube(comm, n, n, n, mesh.CellType.hexahedron)
    places = [mesh.locate_entities_boundary(domain, dim - 1, lambda x, h=h: np.isclose(x[dim - 1], h)) for h in (0, 1)]
    facets, tags = np.concatenate(places), np.repeat(np.arange(1, 3, dtype=np.int32), [len(p) for p in places])
    order = np.argsort(facets)
    V = fem.functionspace(domain, ("Lagrange", 1, (dim,)))
    return V, mesh.meshtags(domain, dim - 1, facets[order], tags[order])


def flat(dim=2):
    """Planes z = -0.01 in all forms."""
    low = np.append(np.zeros(dim - 1), -0.01)
    up = np.eye(dim)[-1]
    yield "plane", di.RigidPlane(low, up)
    yield "heights", di.RigidSurface.from_function(lambda *x: 0.0 * x[0], [BOUNDS] * (dim - 1), low, up)
    if dim == 2:
        points, facets = [[3.0, -0.01], [0.4, -0.01], [-2.0, -0.01]], [[0, 1], [1, 2]]
    else:
        points = [[x, y, -0.01] for x, y in ((-2.0, -2.0), (3.0, -2.0), (3.0, 3.0), (-2.0, 3.0))]
        facets = [[0, 1, 2], [0, 2, 3]]
    yield "facets", di.RigidSurface.from_facets(np.array(points), np.array(facets))


def check_a_bounce():
    """A block thrown obliquely on a plane that moves, by penalty and kinematic contact: the same in all forms."""
    for dim in (2, 3):
        for method in (di.Penalty, di.Kinematic)[: 1 if COMM.size > 1 else 2]:
            found = {}
            for name, plane in flat(dim):
                V, tags = block(n=4 if dim == 2 else 2, dim=dim)
                plane.motion = lambda t: (0.1 * t, 0.0, 0.0) if dim == 2 else (0.1 * t, 0.0, 0.05 * t)  # noqa: B023
                v = fem.Function(V)
                v.interpolate(lambda x: np.array([0.3 + 0 * x[0], *[0 * x[0]] * (dim - 2), -1.0 + 0 * x[0]]))
                law = di.LinearElastic(1e3, 0.3, 1.0, "plane_strain" if dim == 2 else "3d")
                pair = di.ContactPair(tags, 1, plane, friction=0.2)
                problem = di.ExplicitProblem(fem.Function(V), law, velocity=v, contact=[method(pair)])
                problem.advance(0.05, progress=False)
                found[name] = problem.force_history[0], problem.energy["friction"], problem.energy["kinetic"]
            force, friction, kinetic = found["plane"]
            assert np.abs(force).max() > 1.0 and friction > 0.0, (dim, method)
            for name in ("heights", "facets"):
                # Round-off of some hundred steps.
                np.testing.assert_allclose(found[name][0], force, rtol=0, atol=1e-9 * np.abs(force).max(), err_msg=name)
                assert abs(found[name][1] - friction) + abs(found[name][2] - kinetic) < 1e-9 * kinetic, name


def check_a_press():
    """A block pressed on a bump: heights and the cylinder that they are; multipliers and penalty, with friction."""
    radius = 2.0

    def height(x):
        return np.sqrt(radius**2 - x**2) - radius

    top = (0.45, -0.001)
    for method in (di.Lagrange, lambda pair: di.Penalty(pair, 1e5)):
        found = []
        for obstacle in (
            di.RigidCylinder((top[0], top[1] - radius), radius),
            di.RigidSurface.from_function(height, (-1.0, 1.0), top, (0.0, 1.0), tolerance=1e-11),
        ):
            V, tags = block(n=4)
            bcs = [fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, tags.find(2)), V)]
            pair = di.ContactPair(tags, 1, obstacle, friction=0.3)
            law = di.LinearElastic(1e3, 0.3, hypothesis="plane_strain")
            problem = di.StaticProblem(fem.Function(V), law, bcs=bcs, contact=[method(pair)])
            obstacle.displacement = (0.01, 0.02)
            report = problem.solve()
            assert report.converged
            found.append((problem.contact[0].force, problem.contact[0].area, max(report.iterations)))
        (force, area, iterations), (ours, our_area, our_iterations) = found
        assert force[1] > 1.0 and abs(force[0]) > 0.01 * force[1] and area > 0.1
        # Slopes of the spline err by 1e-8.
        np.testing.assert_allclose(ours, force, rtol=0, atol=1e-6 * force[1])
        assert abs(our_area - area) < 1e-6 and our_iterations <= iterations + 1


def check_a_mesh_on_several_ranks():
    """The boundary of an obstacle's mesh is gathered: gaps are the same on all ranks, and those of the cube."""
    domain = mesh.create_unit_cube(COMM, 3, 3, 3, mesh.CellType.tetrahedron)
    domain.topology.create_connectivity(2, 3)
    facets = np.sort(mesh.locate_entities_boundary(domain, 2, lambda x: np.isclose(x[2], 1.0)))
    tags = mesh.meshtags(domain, 2, facets, np.full(len(facets), 7, dtype=np.int32))
    obstacle = di.RigidSurface.from_mesh(domain, tags, 7).obstacle(3)
    x = np.random.default_rng(3).uniform(0.0, 1.0, (20, 3)) + [0.0, 0.0, 0.5]
    np.testing.assert_allclose(obstacle.evaluate(x.ravel())[0], x[:, 2] - 1.0, atol=1e-14)
