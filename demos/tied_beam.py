# # Two meshes that do not match: a beam of two parts
#
# A cantilever beam is meshed in two parts, coarse at the wall and fine at the tip, whose nodes do not meet at the
# joint. `Tie` makes one beam of them. Beam theory knows what crosses the joint, at the distance $L - x$ from the load
# $P$ at the tip (per thickness, plane stress, height $h$):
#
# $$ \sigma_x = \frac{12\, P\,(L - x)\, y}{h^3}, \qquad
#    \tau = \frac{3 P}{2 h} \left(1 - \frac{4 y^2}{h^2}\right), \qquad
#    w = \frac{4 P L^3}{E h^3} + \frac{(12 + 11 \nu)\,P L}{5 E h} . $$

import basix.ufl
import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## One mesh of two parts, made on rank 0

L, h, joint = 2.0, 0.2, 1.0  # length, height and place of the joint [m]
E, nu, P = 70e9, 0.3, 1e4  # aluminium [Pa], load per thickness, downwards [N/m]
points, cells, first = [], [], 0
for start, end, nx, ny in ((0.0, joint, 10, 4), (joint, L, 14, 7)):
    x, y = np.meshgrid(np.linspace(start, end, nx + 1), np.linspace(-h / 2, h / 2, ny + 1))
    points.append(np.column_stack([x.ravel(), y.ravel()]))
    i = first + (np.arange(ny)[:, None] * (nx + 1) + np.arange(nx)).ravel()
    cells.append(np.column_stack([i, i + 1, i + nx + 1, i + nx + 2]))
    first += len(points[-1])
comm = MPI.COMM_WORLD
x, c = np.vstack(points), np.vstack(cells)
if comm.rank > 0:
    x, c = x[:0], c[:0]
beam = mesh.create_mesh(comm, c, x=x, e=basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,)))

# ## Tags: both sides of the joint lie at the same place; the cell beside a facet tells which part it belongs to

WALL, MASTER, SLAVE, TIP = 1, 2, 3, 4
beam.topology.create_connectivity(1, 2)
facets = mesh.exterior_facet_indices(beam.topology)
beside = [beam.topology.connectivity(1, 2).links(f)[0] for f in facets]
cell = mesh.compute_midpoints(beam, 2, np.array(beside, dtype=np.int32))[:, 0]
middle = mesh.compute_midpoints(beam, 1, facets)[:, 0]
value = np.zeros(len(facets), dtype=np.int32)
value[np.isclose(middle, 0.0)], value[np.isclose(middle, L)] = WALL, TIP
value[np.isclose(middle, joint)] = np.where(cell[np.isclose(middle, joint)] < joint, MASTER, SLAVE)
tags = mesh.meshtags(beam, 1, facets[value > 0], value[value > 0])

# ## The beam: the finer side is the slave

V = fem.functionspace(beam, ("Lagrange", 2, (2,)))
u = fem.Function(V, name="displacement")
wall = fem.dirichletbc(np.zeros(2), fem.locate_dofs_topological(V, 1, tags.find(WALL)), V)
aluminium = di.LinearElastic(E=E, nu=nu, hypothesis="plane_stress")
tie = di.Tie(di.ContactPair(tags, slave=SLAVE, master=MASTER))
problem = di.StaticProblem(u, aluminium, bcs=[wall], loads=[di.Traction(tags, TIP, (0.0, -P / h))], contact=[tie])
problem.solve()

# ## What crosses the joint
#
# `traction` acts on the slave, whose outer normal is $-x$: it is $-\sigma_x$ and $-\tau$ there.

result = problem.contact[0]
parts = comm.allgather((result.points[:, 1], result.traction))
y, t = (np.concatenate(part) for part in zip(*parts))
order = np.argsort(y)
y, t = y[order], t[order]
bending = 12 * P * (L - joint) * y / h**3
shear = 1.5 * P / h * (1 - 4 * y**2 / h**2)
at_tip = np.isclose(V.tabulate_dof_coordinates()[:, 0], L)[: V.dofmap.index_map.size_local]
lowest = comm.allreduce(u.x.array.reshape(-1, 2)[: len(at_tip)][at_tip, 1].min(initial=0.0), MPI.MIN)
deflection = 4 * P * L**3 / (E * h**3) + (12 + 11 * nu) * P * L / (5 * E * h)
if comm.rank == 0:
    print(f"deflection of the tip: {-lowest * 1e3:.4f} mm, beam theory {deflection * 1e3:.4f} mm")
    print(f"force on the part at the tip: {result.force[1]:.4f} N/m, load {-P:.4f} N/m")
    figure, axes = plt.subplots(1, 2, figsize=(8, 3), sharey=True, layout="constrained")
    for a, exact, found, name in ((axes[0], bending, -t[:, 0], "stress"), (axes[1], -shear, -t[:, 1], "shear stress")):
        a.plot(exact / 1e6, y, "C0", lw=3, alpha=0.4, label="beam theory")
        a.plot(found / 1e6, y, "C3o", ms=4, label="tie")
        a.set(xlabel=f"{name} [MPa]")
    axes[0].set(ylabel="y [m]")
    axes[0].legend()
    figure.savefig("tied_beam.png", dpi=120)

# ## What must hold
#
# The tie bears the load exactly; the stresses are those of 4 and 7 cells over the height, of degree 2.

assert np.allclose(result.force, (0.0, P), atol=1e-6 * P)
assert abs(-lowest / deflection - 1) < 5e-3
assert np.abs(-t[:, 0] - bending).max() < 0.05 * bending.max()
assert np.abs(-t[:, 1] + shear).max() < 0.15 * shear.max()
# SPDX-License-Identifier: MIT
