# SPDX-License-Identifier: MIT
"""Small structured meshes for the tests of the hand-written solver, in its own node order."""

import itertools

import impact_reference as ir
import numpy as np

CELLS = ["triangle", "quadrilateral", "tetrahedron", "hexahedron"]


def _corner_cells(cell_type, counts):
    """Vertex grid on the unit box and its cells."""
    axes = [np.linspace(0, 1, n + 1) for n in counts]
    grid = np.stack(np.meshgrid(*axes, indexing="ij"), axis=-1).reshape(-1, len(counts))
    number = np.arange(len(grid)).reshape([n + 1 for n in counts])
    cells = []
    for start in itertools.product(*[range(n) for n in counts]):

        def at(*offset):
            return number[tuple(np.add(start, offset))]

        if len(counts) == 2:
            quad = [at(0, 0), at(1, 0), at(1, 1), at(0, 1)]
            if cell_type == "quadrilateral":
                cells.append(quad)
            elif sum(start) % 2:
                cells += [[quad[0], quad[1], quad[2]], [quad[0], quad[2], quad[3]]]
            else:
                cells += [[quad[0], quad[1], quad[3]], [quad[1], quad[2], quad[3]]]
        elif cell_type == "hexahedron":
            cells.append([at(*o) for o in [(0, 0, 0), (1, 0, 0), (1, 1, 0), (0, 1, 0)]])
            cells[-1] += [at(*o) for o in [(0, 0, 1), (1, 0, 1), (1, 1, 1), (0, 1, 1)]]
        else:  # Kuhn's six tetrahedra around the diagonal
            for order in itertools.permutations(range(3)):
                steps = np.cumsum([np.eye(3, dtype=int)[k] for k in order], axis=0)
                tet = [at(0, 0, 0)] + [at(*s) for s in steps]
                even = np.linalg.det(np.eye(3)[list(order)]) > 0
                cells.append(tet if even else [tet[1], tet[0], tet[2], tet[3]])
    return grid, np.array(cells)


def merge(points, cells):
    """Merges points at the same place (to 1e-9)."""
    _, first, inverse = np.unique(np.round(points, 9) + 0.0, axis=0, return_index=True, return_inverse=True)
    return points[first], inverse.reshape(-1)[cells]


def box(cell_type, counts, geometry_degree=1, mapping=None, distort=0.0, seed=1):
    """Unit box cut into cells, inner vertices moved by `distort` cells at random, then all nodes mapped."""
    grid, cells = _corner_cells(cell_type, counts)
    inner = np.all((grid > 1e-12) & (grid < 1 - 1e-12), axis=1)
    moves = np.random.default_rng(seed).uniform(-1, 1, grid.shape) * distort / np.array(counts)
    grid = grid + np.where(inner[:, None], moves, 0)
    N, _ = ir.shape_functions(cell_type, 1, ir.reference_nodes(cell_type, geometry_degree))
    points = np.einsum("nv,cvd->cnd", N, grid[cells]).reshape(-1, grid.shape[1])
    points, cells = merge(points, np.arange(len(points)).reshape(len(cells), -1))
    return (points if mapping is None else np.array([mapping(x) for x in points])), cells


def join(*meshes):
    """One mesh of several that touch node to node."""
    offsets = np.cumsum([0] + [len(points) for points, _ in meshes])
    cells = np.vstack([c + offset for (_, c), offset in zip(meshes, offsets)])
    return merge(np.vstack([points for points, _ in meshes]), cells)


def boundary(cells, cell_type):
    """Boundary facets as vertex ids."""
    found = {}
    for cell in cells:
        for facet in ir.facets(cell_type):
            nodes = [int(cell[v]) for v in facet]
            found.setdefault(tuple(sorted(nodes)), []).append(nodes)
    return np.array([nodes[0] for nodes in found.values() if len(nodes) == 1])


def facets_where(points, cells, cell_type, where):
    """Boundary facets all of whose vertices satisfy `where(x)`."""
    all_facets = boundary(cells, cell_type)
    keep = [all(where(points[node]) for node in facet) for facet in all_facets]
    return all_facets[np.array(keep, dtype=bool)]


def nodes_where(points, where):
    return np.flatnonzero([bool(where(x)) for x in points])


def boundary_nodes(model):
    """Field nodes on the boundary of a model."""
    cell_type, degree = model.cell_type, model.degree
    tally = {}
    for cell in model.field_cells:
        for f, facet in enumerate(ir.facets(cell_type)):
            local = ir.facet_nodes(cell_type, degree, f)
            tally.setdefault(tuple(sorted(cell[facet])), []).append(cell[local])
    return np.unique(np.concatenate([nodes[0] for nodes in tally.values() if len(nodes) == 1]))


def dofs(nodes, components, gdim):
    """Degrees of freedom of components (an int or several) at nodes."""
    return (gdim * np.asarray(nodes)[:, None] + np.atleast_1d(components)).reshape(-1)


def edge_traction(model, facets, stress, order=6):
    """Load of the traction stress(x) . n on edges of a plane model, integrated here and not by the solver."""
    load = np.zeros(model.num_dofs)
    s, w = ir.quadrature("interval", f"table:{2 * order - 1}")
    N, dN = ir.shape_functions("interval", model.degree, s)
    local = [ir.facet_nodes(model.cell_type, model.degree, f) for f in range(len(ir.facets(model.cell_type)))]
    edges = {tuple(sorted(c[nodes[:2]])): c[nodes] for c in model.field_cells for nodes in local}
    for facet in facets:
        nodes = edges[tuple(sorted(facet))]
        X = model.field_points[nodes]
        for q in range(len(w)):
            x, tangent = N[q] @ X, dN[q, :, 0] @ X
            t = stress(x) @ np.array([tangent[1], -tangent[0]])
            for i, node in enumerate(nodes):
                load[2 * node : 2 * node + 2] += w[q] * N[q, i] * t
    return load
