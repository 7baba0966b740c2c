# # A cylinder pressed on a block: Hertz
#
# A steel cylinder is pressed on a steel block. Where they touch is not given: multipliers find the contact and its
# pressure. For half-planes Hertz (1881) gives half the width $a$ of the contact and the pressure $p$ under the load $P$
# per length, with $1/E^* = \sum (1 - \nu_i^2) / E_i$:
#
# $$ a = \sqrt{\frac{4 P R}{\pi E^*}}, \qquad p(x) = \frac{2P}{\pi a} \sqrt{1 - x^2/a^2}. $$

import gmsh
import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

comm = MPI.COMM_WORLD
E, nu, R, size, P = 207e9, 0.3, 0.46, 0.15, 4e6  # [Pa], [1], radius, size of the block [m], load per length [N/m]
hertz = di.theory.hertz_line(P, R, np.inf, E, nu, E, nu)
a, p0 = hertz.half_width, hertz.peak_pressure

# ## Mesh and tags
#
# By symmetry a quarter of the cylinder and half of the block are enough. gmsh makes one mesh of both bodies, which
# share no nodes. The triangles are small in a ball around the contact. The block is 33 half-widths deep, like a
# half-plane.

gmsh.initialize(["", "-v", "0"], interruptible=False)
if comm.rank == 0:
    disc, square = gmsh.model.occ.addDisk(0, R, 0, R, R), gmsh.model.occ.addRectangle(0, 0, 0, R, R)
    cylinder = gmsh.model.occ.intersect([(2, disc)], [(2, square)])[0][0][1]
    block = gmsh.model.occ.addRectangle(0, -size, 0, size, size)
    gmsh.model.occ.synchronize()
    gmsh.model.addPhysicalGroup(2, [cylinder, block], 1)
    ball = gmsh.model.mesh.field.add("Ball")
    for name, value in ("Radius", 1.5 * a), ("Thickness", R), ("VIn", a / 16), ("VOut", R / 5):
        gmsh.model.mesh.field.setNumber(ball, name, value)
    gmsh.model.mesh.field.setAsBackgroundMesh(ball)
    gmsh.model.mesh.generate(2)
domain = di.model_to_mesh(gmsh.model, comm, gdim=2).mesh
gmsh.finalize()
surfaces = {
    1: lambda x: np.abs(np.hypot(x[0], x[1] - R) - R) < 1e-9,  # slave
    2: lambda x: np.abs(x[1]) < 1e-9,  # master
    3: lambda x: np.isclose(x[1], R),  # where the load acts
}
found = [mesh.locate_entities_boundary(domain, 1, where) for where in surfaces.values()]
facets, tags = np.concatenate(found), np.repeat(list(surfaces), [len(f) for f in found]).astype(np.int32)
facet_tags = mesh.meshtags(domain, 1, np.sort(facets), tags[np.argsort(facets)])

# ## The problem
#
# Rollers hold the plane of symmetry and the lower side of the block. Only the contact holds the cylinder up.

V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
u, bcs = fem.Function(V, name="displacement"), []
for axis, where in ((0, lambda x: np.isclose(x[0], 0.0)), (1, lambda x: np.isclose(x[1], -size))):
    dofs = fem.locate_dofs_topological(V.sub(axis), 1, mesh.locate_entities_boundary(domain, 1, where))
    bcs.append(fem.dirichletbc(0.0, dofs, V.sub(axis)))
steel = di.LinearElastic(E=E, nu=nu, hypothesis="plane_strain")
load = di.Traction(facet_tags, 3, (0.0, -P / (2 * R)))
pair = di.ContactPair(facet_tags, slave=1, master=2)
problem = di.StaticProblem(u, steel, bcs=bcs, loads=[load], contact=[di.Lagrange(pair)])
problem.solve()

contact = problem.contact[0]

# ## Comparison and picture
#
# Arrays of the contact hold the points of this rank; `area` and `force` are totals, here of half of the contact.

peak = comm.allreduce(np.max(contact.pressure, initial=0.0), MPI.MAX)
picture = di.DeformedBody(u, problem.von_mises)  # gathers the field on rank 0
rows = comm.gather(np.column_stack([contact.points[:, 0], contact.pressure]))
if comm.rank == 0:
    print(f"peak pressure {peak / 1e6:8.3f} MPa   Hertz {p0 / 1e6:8.3f} MPa")
    print(f"half-width    {contact.area * 1e3:8.3f} mm    Hertz {a * 1e3:8.3f} mm")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained", gridspec_kw={"wspace": 0.1})
    picture.draw(left, "von Mises stress [MPa]", factor=1e-6, lengths=1e3, unit="mm", edges=False)
    left.set(xlim=(0, 2.5e3 * a), ylim=(-1.6e3 * a, 0.9e3 * a))
    s, (x, p) = np.linspace(0, a, 200), np.concatenate(rows).T
    right.plot(s * 1e3, hertz.pressure(s) / 1e6, "k-", label="Hertz")
    right.plot(x * 1e3, p / 1e6, "o", mfc="none", label="multipliers")
    right.set(xlabel="x [mm]", ylabel="pressure [MPa]", xlim=(-30 * a, 1.3e3 * a))
    right.legend()
    figure.savefig("hertz.png", dpi=120)

# The load is that of equilibrium, to round-off. The peak must agree to 1 %, the half-width to a facet, a/16.
assert abs(2 * contact.force[1] / P - 1) < 1e-9 and abs(peak / p0 - 1) < 0.01 and abs(contact.area / a - 1) < 1 / 16
# SPDX-License-Identifier: MIT
