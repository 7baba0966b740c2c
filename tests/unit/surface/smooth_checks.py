# SPDX-License-Identifier: MIT
"""Smooth surfaces through the nodes of linear facets. See on_ranks.py."""

import numpy as np
import pytest
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import _cpp

COMM = MPI.COMM_WORLD
CELLS = {
    "triangle": mesh.CellType.triangle,
    "quadrilateral": mesh.CellType.quadrilateral,
    "tetrahedron": mesh.CellType.tetrahedron,
    "hexahedron": mesh.CellType.hexahedron,
}
RADIUS, HEIGHT = 2.0, 0.5
ROUND_OFF = 1e-12  # of lengths of order one, through the root and the quotients of a few dozen numbers
# Points of a facet where the patch differs most from the surface: between its nodes.
PLACES = {2: [(0.25, 0.0), (0.5, 0.0), (0.75, 0.0)], 3: [(0.25, 0.25), (0.5, 0.0), (0.3, 0.6), (0.4, 0.2)]}


def graded(x):
    """Squeeze positions in [0, 1] so that neighbouring facets have different sizes."""
    return x + 0.1 * np.sin(2.0 * np.pi * x)


def slab(cell, n, bend, comm=COMM):
    """A slab of n cells in each direction of its surface, one in its height, with the space of its displacements.

    Args:
        bend: the slab's upper surface, positions (n, dim - 1) in [0, 1] -> positions (n, dim); below it lies the
            same surface, lower by HEIGHT.
    """
    dim = 2 if cell in ("triangle", "quadrilateral") else 3
    create = mesh.create_unit_square if dim == 2 else mesh.create_unit_cube
    domain = create(comm, *[n] * (dim - 1), 1, CELLS[cell])
    x = domain.geometry.x
    height = x[:, dim - 1].copy()
    x[:, :dim] = bend(graded(x[:, : dim - 1]))
    x[:, dim - 1] -= HEIGHT * (1.0 - height)
    for one in (dim - 1, dim):
        domain.topology.create_connectivity(one, dim)
        domain.topology.create_connectivity(dim, one)
    return domain, fem.functionspace(domain, ("Lagrange", 1, (dim,)))


def sphere(p):
    """A cap of a sphere (an arc of a circle) that is cut where it slopes, by 45 degrees at most."""
    p = (p - 0.3) * 0.8 * RADIUS
    return np.column_stack([p, np.sqrt(RADIUS**2 - np.sum(p**2, axis=1))])


def top_of(V):
    """Facets whose normal points up, as make_surface has them."""
    domain = V.mesh
    dim = domain.topology.dim
    exterior = mesh.exterior_facet_indices(domain.topology)
    flat = _cpp.surface.make_surface(V._cpp_object, exterior)
    middle = np.array([flat.evaluate(f, 0.3, 0.3 if dim == 3 else 0.0) for f in range(flat.size)]).reshape(-1, 7)
    chosen = exterior[middle[:, 2 + dim] > 0.3]
    return chosen, _cpp.surface.make_surface(V._cpp_object, chosen)


def deviations(facets, distance, normal):
    """Largest distance of a surface from another one, and largest difference of normals, on all ranks."""
    far = turned = 0.0
    for f in range(facets.size):
        for place in PLACES[facets.gdim]:
            p = facets.evaluate(f, *place)
            far = max(far, abs(distance(p[:3])))
            turned = max(turned, float(np.linalg.norm(p[3:6] - normal(p[:3]))))
    return COMM.allreduce(far, MPI.MAX), COMM.allreduce(turned, MPI.MAX)


def from_sphere(x):
    return np.linalg.norm(x) - RADIUS


def out_of_sphere(x):
    return x / np.linalg.norm(x)


CREASE = np.radians(30.0)


def check_order_on_circles_and_spheres():
    """Facets leave a sphere by O(h^2) and their normals by O(h); patches by O(h^3) and O(h^2) at least."""
    for cell in CELLS:
        found = []
        for n in (16, 32):
            _, V = slab(cell, n, sphere)
            chosen, flat = top_of(V)
            smooth = _cpp.surface.make_smooth(V._cpp_object, flat, CREASE, np.zeros(0))
            assert smooth.smooth and not flat.smooth
            assert smooth.geometry.degree == 2 and smooth.displacement.degree == 1
            found.append(
                [*deviations(flat, from_sphere, out_of_sphere), *deviations(smooth, from_sphere, out_of_sphere)]
            )
        order = np.log2(np.array(found[0]) / found[1])
        # The meshes are not yet fine: within 0.3 of the theory for facets; for patches, which have a parabola for an
        # arc and normals from parabolas, at least one order more of both.
        assert abs(order[0] - 2.0) < 0.3 and abs(order[1] - 1.0) < 0.3, (cell, order)
        assert order[2] > 2.7 and order[3] > 1.7, (cell, order)
        assert found[1][2] < 0.05 * found[1][0] and found[1][3] < 0.2 * found[1][1], (cell, found)


def smooth_of(V, flat, normals=None, crease=CREASE):
    given = np.zeros(0) if normals is None else normals
    return _cpp.surface.make_smooth(V._cpp_object, flat, crease, np.ascontiguousarray(given).ravel())


def check_exact_normals_are_used():
    """With exact normals edges are arcs of the sphere; where they are not a number, mean normals are taken."""
    for cell in CELLS:
        _, V = slab(cell, 8, sphere)
        chosen, flat = top_of(V)
        exact = flat.X / np.linalg.norm(flat.X, axis=-1, keepdims=True)
        smooth = smooth_of(V, flat, 3.0 * exact)  # the length does not count
        # The middles of edges are those of arcs, hence on the sphere.
        edges = smooth.X[:, flat.X.shape[1] :][:, : {2: 1, 3: 3, 4: 4}[flat.X.shape[1]]]
        assert np.abs(np.linalg.norm(edges, axis=-1) - RADIUS).max(initial=0.0) < ROUND_OFF, cell
        off = np.linalg.norm(smooth_of(V, flat).X, axis=-1) - RADIUS
        assert COMM.allreduce(np.abs(off).max(initial=0.0), MPI.MAX) > 1e3 * ROUND_OFF, cell
        same = smooth_of(V, flat, np.full(flat.X.shape, np.nan)).X
        assert np.array_equal(same, smooth_of(V, flat).X)


def check_crease_stays_sharp():
    """The edge of a cube stays straight and its sides stay flat; with a larger crease they are rounded."""
    for cell in CELLS:
        _, V = slab(cell, 4, lambda p: np.column_stack([p, np.full(len(p), HEIGHT)]))
        all_sides = mesh.exterior_facet_indices(V.mesh.topology)
        flat = _cpp.surface.make_surface(V._cpp_object, all_sides)
        n, corners = flat.geometry, flat.X.shape[1]
        sharp, round_ = smooth_of(V, flat), smooth_of(V, flat, crease=np.pi)
        middle = (0.4, 0.3 if V.mesh.topology.dim == 3 else 0.0)
        moved = [
            max(
                (
                    np.linalg.norm(np.subtract(s.evaluate(f, *middle)[:3], flat.evaluate(f, *middle)[:3]))
                    for f in range(flat.size)
                ),
                default=0.0,
            )
            for s in (sharp, round_)
        ]
        assert moved[0] < ROUND_OFF, cell
        assert COMM.allreduce(moved[1], MPI.MAX) > 1e-3, cell
        assert np.array_equal(sharp.X[:, :corners], flat.X) and n.degree == 1


def check_sharp_edge_is_one_curve():
    """Where a curved side meets another one at a crease, both have the same edge: the surface has no slit."""

    def barrel(p):
        return np.column_stack([p[:, 0], p[:, 1], 1.0 - 0.5 * (p[:, 0] - 0.4) ** 2])

    _, V = slab("hexahedron", 4, barrel)
    flat = _cpp.surface.make_surface(V._cpp_object, mesh.exterior_facet_indices(V.mesh.topology))
    smooth = smooth_of(V, flat)
    corners = [(0, 1), (0, 2), (1, 3), (2, 3)]
    middles = {}
    V_map = V.dofmap.index_map
    for f, (nodes, X) in enumerate(zip(smooth.nodes, smooth.X)):
        for e, (a, b) in enumerate(corners):
            ends = tuple(sorted(V_map.local_to_global(nodes[[a, b]]).tolist()))
            middles.setdefault(ends, []).append((X[4 + e], np.linalg.norm(X[4 + e] - 0.5 * (X[a] + X[b]))))
    everywhere = {}
    for some in COMM.allgather(middles):
        for ends, found in some.items():
            everywhere.setdefault(ends, []).extend(found)
    assert all(len(found) == 2 for found in everywhere.values())
    assert max(np.linalg.norm(a[0] - b[0]) for a, b in everywhere.values()) < ROUND_OFF
    # The sagitta of an edge of length 1/4 and curvature about 1 is 1/128.
    assert max(a[1] for a, _ in everywhere.values()) > 0.005


def check_ranks():
    """Patches are those of one rank."""
    for cell in CELLS:
        found = []
        for comm in (COMM, MPI.COMM_SELF):
            _, V = slab(cell, 6, sphere, comm)
            _, flat = top_of(V)
            found.append(np.concatenate(comm.allgather(smooth_of(V, flat).X)))
        points = [x.reshape(-1, x.shape[-1]) for x in found]
        assert points[0].shape == points[1].shape
        # Facets come in another order, and each has its own first corner: the sets of nodes are compared.
        rows = [x[np.lexsort(np.round(x, 9).T)] for x in points]
        assert np.allclose(rows[0], rows[1], atol=ROUND_OFF, rtol=0.0), cell


def check_turned_surface_is_rigid():
    """Turned by any angle, the surface is the turned surface; with X + N u (`move`) it is not."""
    for cell in CELLS:
        _, V = slab(cell, 4, sphere)
        _, flat = top_of(V)
        smooth = smooth_of(V, flat)
        dim, X = smooth.gdim, smooth.X
        c, s = np.cos(2.0), np.sin(2.0)
        turn = (
            np.array([[c, -s], [s, c]])
            if dim == 2
            else np.array([[c, 0, -s], [0.6 * s, 0.8, 0.6 * c], [0.8 * s, -0.6, 0.8 * c]])
        )
        assert np.allclose(turn @ turn.T, np.eye(dim), atol=ROUND_OFF)
        position = V.tabulate_dof_coordinates()[:, :dim]
        u = np.ascontiguousarray(position @ turn.T + 3.0 - position).ravel()
        smooth.move_and_turn(u)
        assert np.allclose(smooth.x, X @ turn.T + 3.0, atol=10 * ROUND_OFF), cell
        smooth.move(u)
        off = np.abs(smooth.x - X @ turn.T - 3.0).max(initial=0.0)
        assert COMM.allreduce(off, MPI.MAX) > 1e-3, cell


def check_bad_input():
    """Wrong input is refused with a clear message, on all ranks."""
    domain, V = slab("hexahedron", 3, sphere)
    chosen, flat = top_of(V)
    tags = mesh.meshtags(domain, 2, np.sort(chosen), np.full(len(chosen), 7, dtype=np.int32))
    rigid = di.RigidPlane([0.0, 0.0, 3.0], [0.0, 0.0, -1.0])
    for wrong, error, words in (
        ("yes", TypeError, "smooth is 'yes'"),
        ((True, 1), TypeError, "smooth is 1"),
    ):
        with pytest.raises(error, match=words):
            di.ContactPair(tags, 7, rigid, smooth=wrong)
    for wrong, error in ((0.0, ValueError), (181.0, ValueError), (np.nan, ValueError), ("30", TypeError)):
        with pytest.raises(error, match="crease"):
            di.ContactPair(tags, 7, rigid, smooth=True, crease=wrong)

    def fails(x):
        raise KeyError("radius")

    for normals, words in (
        (lambda x: -x, "points into the body"),
        (lambda x: x[:1], "have shape"),
        (lambda x: x[:, :-1], "have shape"),
        (fails, "raised KeyError"),
    ):
        with pytest.raises(ValueError, match=words):
            di.ContactPair(tags, 7, rigid, smooth=normals).surfaces(V)
    quadratic = fem.functionspace(domain, ("Lagrange", 2, (3,)))
    with pytest.raises(ValueError, match="degree 1"):
        di.ContactPair(tags, 7, rigid, smooth=True).surfaces(quadratic)
    # A rigid master stays as it is, and each side can have its own.
    slave, master = di.ContactPair(tags, 7, rigid, smooth=True).surfaces(V)
    assert slave.smooth and master is None
    assert not di.ContactPair(tags, 7, rigid, smooth=(False, True)).surfaces(V)[0].smooth
    assert di.ContactPair(tags, 7, rigid, smooth=(lambda x: x, False)).surfaces(V)[0].smooth
