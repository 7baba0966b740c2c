# # A form of one's own
#
# Contact does not ask where the residual comes from. This demo writes the stored energy of a rubber in UFL, has its
# derivative compiled, checks the compiled form twice, and presses a rigid cylinder into the rubber. The energy is that
# of a compressible neo-Hookean solid; another one takes its place in one line. With $F = I + \nabla u$ and
# $J = \det F$,
#
# $$ W = \frac{\mu}{2} (\mathrm{tr}\, F^T F - 2) - \mu \ln J + \frac{\lambda}{2} (\ln J)^2 $$
#
# in plane strain.

import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, la, mesh

import dolfinx_impact as di

# ## Mesh and support
#
# A pad of rubber, glued to a rigid plate at its bottom. The tag 1 marks its top, which the cylinder touches.

comm = MPI.COMM_WORLD
L, H, R, depth = 0.2, 0.05, 0.04, 0.02  # length and height of the pad, radius of the cylinder and its way down [m]
pad = mesh.create_rectangle(comm, [(-L / 2, 0.0), (L / 2, H)], [80, 20], mesh.CellType.quadrilateral)
top = mesh.locate_entities_boundary(pad, 1, lambda x: np.isclose(x[1], H))
facet_tags = mesh.meshtags(pad, 1, np.sort(top), np.full(len(top), 1, dtype=np.int32))
V = fem.functionspace(pad, ("Lagrange", 1, (2,)))
glued = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[1], 0.0))
bcs = [fem.dirichletbc(np.zeros(2), glued, V)]

# ## The form
#
# The measure states the degree of quadrature, because UFL's own estimate is far too high for such energies.

u, v = fem.Function(V, name="displacement"), ufl.TestFunction(V)
mu, lmbda = fem.Constant(pad, 1e6), fem.Constant(pad, 4e6)  # Lame's constants [Pa]
F = ufl.Identity(2) + ufl.grad(u)
J = ufl.det(F)
W = mu / 2 * (ufl.tr(F.T * F) - 2) - mu * ufl.ln(J) + lmbda / 2 * ufl.ln(J) ** 2
residual = ufl.derivative(W * ufl.dx(degree=2), u, v)

# ## Two checks
#
# The hand-written solver knows this material, too. `cross_check` compares the compiled form with it, on random cells
# and assembled. For a material that it does not know the second check remains: the force vector of the compiled form
# against DOLFINx's assembly, at any displacement.

check = di.verify.cross_check(residual, operator="neo_hookean", constants={"mu": mu, "lmbda": lmbda})
u.interpolate(lambda x: np.array([np.sin(20 * x[0]) * x[1], x[0] * x[1]]))
compiled = di.InternalForce(residual).apply()
assembled = fem.assemble_vector(fem.form(residual))
assembled.scatter_reverse(la.InsertMode.add)
assembled.scatter_forward()
differs = comm.allreduce(np.abs(compiled.array - assembled.array).max(), MPI.MAX)
differs /= comm.allreduce(np.abs(assembled.array).max(), MPI.MAX)

# ## Contact
#
# A problem takes the residual in the place of a material. The cylinder is a rigid obstacle, which moves down in four
# steps.

u.x.array[:] = 0.0
cylinder = di.RigidCylinder(center=(0.0, H + R), radius=R)
pair = di.ContactPair(facet_tags, slave=1, master=cylinder)
problem = di.StaticProblem(u, residual=residual, bcs=bcs, contact=[di.Lagrange(pair)])
cylinder.displacement = (0.0, -depth)
report = problem.solve(steps=4)
force = problem.contact[0].force[1]
owned_nodes = glued[glued < V.dofmap.index_map.size_local]
support = comm.allreduce(np.sum(problem.reactions().x.array[2 * owned_nodes + 1]))

# ## Picture: the deformed cells and their energy

picture = di.DeformedBody(u, W)
if comm.rank == 0:
    for row in check.rows:
        print(f"hand-written solver, {row.level:8s} differs by {row.difference:.1e} (tolerance {row.tolerance:.0e})")
    print(f"DOLFINx's assembly            differs by {differs:.1e}\nNewton iterations {report.iterations}")
    print(f"force on the pad from above {force / 1e3:.6f} kN/m, from below {support / 1e3:.6f} kN/m")
    figure, axes = plt.subplots(figsize=(9, 3.2), layout="constrained")
    picture.draw(axes, "energy per volume [MPa]", factor=1e-6, lengths=1e3, unit="mm", edges=False)
    axes.add_patch(plt.Circle((0, 1e3 * (H + R - depth)), 1e3 * R, color="lightgrey", zorder=0))
    axes.set(xlim=(-110, 110), ylim=(-2, 72))
    figure.savefig("own_form.png", dpi=120)

# ## What must hold
# Round-off for the vectors, the tolerance of Newton's method for the balance of forces.

assert check.passed and differs < 1e-13 and abs(support / force + 1) < 1e-8
# SPDX-License-Identifier: MIT
