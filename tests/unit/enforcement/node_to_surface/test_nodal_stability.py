# SPDX-License-Identifier: MIT
"""What contact adds to the square of the highest frequency."""

import numpy as np
import pytest
from nodal_model import smooth, two_bodies

MATCH = dict(lower=(1.2, 1.2, 1.0), lower_cells=(4, 4, 1), upper=(0.6, 0.6, 0.9), upper_cells=(2, 2, 1))  # nodes match
CASES = [
    ("hexahedron", 1, MATCH),
    ("hexahedron", 1, dict(lower_cells=(2, 2, 1), upper_cells=(7, 7, 1))),  # many slaves on a master
    ("hexahedron", 1, dict(lower_cells=(7, 7, 1), upper_cells=(2, 2, 1))),
    ("tetrahedron", 1, dict(lower_cells=(3, 4, 1), upper_cells=(4, 3, 1))),
    ("quadrilateral", 2, dict(lower_cells=(3, 1), upper_cells=(8, 1))),
    ("hexahedron", 2, dict(lower_cells=(2, 2, 1), upper_cells=(3, 3, 1))),
]


@pytest.mark.parametrize("balanced", (False, True))
@pytest.mark.parametrize("cell,degree,cells", CASES)
def test_stiffness_is_bounded(cell, degree, cells, balanced):
    """Largest eigenvalue of M^-1 K_c dt^2 <= kappa, all nodes closed; K_c by differences with normals as they are."""
    model = two_bodies(cell, degree, gap=-0.06, balanced=balanced, **cells)
    area = np.ones(model.num)
    for contact in two_bodies(cell, degree, gap=-0.06, balanced=True, **cells).sides:
        area[contact.nodes] = contact.areas
    # Masses nearly in proportion to the nodes' areas, as in regular meshes.
    model.mass_owned = 0.3 * area * (1 + 0.3 * np.sin(5 * model.x[:, 0]))
    u = smooth(model.x, 0.002)
    reference = model.forces(u)
    assert np.all(model.contact.results()["status"] > 0)
    nodes = np.flatnonzero(np.any(reference != 0, axis=1))
    eps, dim = 1e-7, model.dim
    K = np.zeros((len(nodes) * dim,) * 2)
    for a, node in enumerate(nodes):
        for c in range(dim):
            sides = []
            for sign in (1, -1):
                moved = u.copy()
                moved[node, c] += sign * eps
                sides.append(model.forces(moved, search=False)[nodes].reshape(-1))
            K[:, a * dim + c] = -(sides[0] - sides[1]) / (2 * eps)
    root = np.repeat(model.mass_owned[nodes] ** -0.5, dim)
    matrix = root[:, None] * K * root
    largest = np.linalg.eigvalsh((matrix + matrix.T) / 2)[-1] * model.dt**2
    assert 0.1 < largest < 0.5 * 1.02, largest  # 2 %: turning normals, curved facets
