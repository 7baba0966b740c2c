# SPDX-License-Identifier: MIT
"""Double cantilever beam: two arms that a cohesive zone holds together are opened at their ends, plane strain.

Beam theory: with the compliance C = 2 a^3/(3 E' I) of both arms of length a, the crack grows where P^2 dC/da/2 = G_c b,
so that P = sqrt(G_c E' I b)/a and the opening of the ends is 2 P a^3/(3 E' I). Shear and the rotation at the crack's
front make arms longer by chi h, chi = 0.67 for isotropic arms (Williams 1989, corrected beam theory).
"""

import basix.ufl
import dolfinx_impact as di
import numpy as np
import pytest
import ufl
from dolfinx import fem, mesh
from dolfinx_impact import compat, interface
from mpi4py import MPI

E, NU, HEIGHT, LENGTH, CRACK = 70e3, 0.3, 1.5, 60.0, 25.0  # [N/mm^2, 1, mm]
ENERGY, STRENGTH, STIFFNESS = 0.3, 20.0, 1e5  # [N/mm, N/mm^2, N/mm^3]
CHI = 0.67


def arms(cell):
    """Two arms, from y = -HEIGHT to 0 and from 0 to HEIGHT, that share no nodes."""
    n = [int(LENGTH / cell), 2]
    points, cells = [], []
    for low in (-HEIGHT, 0.0):
        arm = mesh.create_rectangle(MPI.COMM_SELF, [[0.0, low], [LENGTH, low + HEIGHT]], n, mesh.CellType.quadrilateral)
        cells.append(np.array(compat.geometry_dofmap(arm), dtype=np.int64) + sum(map(len, points)))
        points.append(arm.geometry.x[:, :2].copy() + [0.0, np.sign(low + 0.5) * 1e-3])
    element = ufl.Mesh(basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,)))
    made = mesh.create_mesh(MPI.COMM_SELF, np.vstack(cells), x=np.vstack(points), e=element)
    sides = [(3, 1e-3), (4, -1e-3)]
    found = [mesh.locate_entities_boundary(made, 1, lambda x, y=y: np.isclose(x[1], y) & (x[0] > CRACK - 1e-6))
             for _, y in sides]  # fmt: skip
    facets, values = np.concatenate(found), np.repeat([3, 4], [len(f) for f in found]).astype(np.int32)
    order = np.argsort(facets)
    tags = mesh.meshtags(made, 1, facets[order], values[order])
    x = made.geometry.x
    x[:, 1] -= np.sign(x[:, 1]) * 1e-3
    return made, tags


@pytest.mark.slow
def test_force_and_opening_of_a_growing_crack():
    body, tags = arms(0.5)
    V = fem.functionspace(body, ("Lagrange", 2, (2,)))
    u, pull = fem.Function(V), fem.Function(V)
    at = V.tabulate_dof_coordinates()
    ends = np.flatnonzero(np.isclose(at[:, 0], 0.0) & np.isclose(np.abs(at[:, 1]), HEIGHT / 2)).astype(np.int32)
    upper = at[ends, 1] > 0.0
    held = fem.dirichletbc(np.zeros(2), fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], LENGTH)), V)
    law = interface.cohesive_zone(STIFFNESS, STRENGTH, ENERGY)
    pair = di.ContactPair(tags, slave=3, master=4)
    bc = fem.dirichletbc(pull, ends)
    problem = di.StaticProblem(
        u, di.LinearElastic(E=E, nu=NU, hypothesis="plane_strain"), bcs=[held, bc],
        contact=[di.Penalty(pair, law=law)],
    )  # fmt: skip
    contact = problem.contact[0]
    bending = E / (1 - NU**2) * HEIGHT**3 / 12
    rows = []
    for opening in np.linspace(0.0, 9.0, 61)[1:]:
        pull.x.array.reshape(-1, 2)[ends[upper], 1] = opening / 2
        pull.x.array.reshape(-1, 2)[ends[~upper], 1] = -opening / 2
        problem.solve(steps=1)
        bonded = contact.points[:, 0][contact.status == di.ContactStatus.stick]
        rows.append((opening, bonded.min(initial=LENGTH), contact.dissipated))
    opening, front, dissipated = np.array(rows).T
    # The crack of beam theory has no zone that softens: its length is that of the energy spent.
    crack = CRACK + dissipated / ENERGY
    growing = (front > CRACK + 4.0) & (crack < LENGTH - 8.0)  # and far from the clamped end
    assert growing.sum() > 10
    # The opening at which a crack of this length grows, 2 P a^3/(3 E' I) with P = sqrt(G E' I)/a.
    exact = 2.0 / 3.0 * (crack + CHI * HEIGHT) ** 2 * np.sqrt(ENERGY / bending)
    # What is left of theory is the softening zone, of about 3 mm: a part of the arms' length.
    assert np.abs(opening / exact - 1.0)[growing].max() < 0.08
    # What is dissipated while the front moves on is the energy of fracture of the new surface.
    assert np.polyfit(front[growing], dissipated[growing], 1)[0] == pytest.approx(ENERGY, rel=0.03)
