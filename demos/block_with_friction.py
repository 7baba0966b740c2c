# # A block is pulled along a rough plane
#
# A flat block is pressed on a rigid plane and pulled at its left end. It slips next to this end, as far as friction
# needs to balance the pull, and sticks beyond. With the friction per length $q$, which is the coefficient of friction
# times the load per length, and the axial stiffness $EA$, slip length and displacement of the end under the force $F$
# are
#
# $$ l = \frac{F}{q}, \qquad u = \frac{F^2}{2 E A q}. $$
#
# When the force is taken away, the end slips back over half of this length, and the displacement $u/2$ remains. A force
# that alternates between $F$ and $-F$ dissipates the work $2 F^3 / (3 E A q)$ in each cycle (Goodman and Klumpp 1956).
# The state depends on the history, so the load is applied in steps.

import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## Mesh, tags, support
#
# All forces are per metre of width. The tag 1 marks the end that is pulled, the tag 2 the surface that touches the
# plane. The top is guided: it is moved down by $p H / E$, which presses the block on the plane with the pressure $p$,
# and slides freely along x.

L, H, E, friction, p = 0.5, 0.005, 210e9, 0.3, 0.5e6  # length, height [m], [Pa], [1], pressure [Pa]
comm = MPI.COMM_WORLD
block = mesh.create_rectangle(comm, [(0.0, 0.0), (L, H)], [100, 2], mesh.CellType.quadrilateral)
end = mesh.locate_entities_boundary(block, 1, lambda x: np.isclose(x[0], 0.0))
bottom = mesh.locate_entities_boundary(block, 1, lambda x: np.isclose(x[1], 0.0))
facets, tags = np.append(end, bottom), np.repeat([1, 2], [len(end), len(bottom)]).astype(np.int32)
facet_tags = mesh.meshtags(block, 1, np.sort(facets), tags[np.argsort(facets)])

V = fem.functionspace(block, ("Lagrange", 1, (2,)))
u = fem.Function(V, name="displacement")
top = mesh.locate_entities_boundary(block, 1, lambda x: np.isclose(x[1], H))
press = fem.dirichletbc(-p * H / E, fem.locate_dofs_topological(V.sub(1), 1, top), V.sub(1))

# ## The problem
#
# The coefficient of friction belongs to the contact pair. Multipliers enforce the contact, so that stick means no
# motion at all.

steel = di.LinearElastic(E=E, nu=0.0, hypothesis="plane_strain")
pull = di.Traction(facet_tags, 1, (0.0, 0.0))
pair = di.ContactPair(facet_tags, slave=2, master=di.RigidPlane(point=(0.0, 0.0), normal=(0.0, 1.0)), friction=friction)
problem = di.StaticProblem(u, steel, bcs=[press], loads=[pull], contact=[di.Lagrange(pair)])
contact = problem.contact[0]

# ## Steps of load
#
# The value of a load may be changed before each call of `solve`, which starts from the last state. The force rises to
# 0.7 of what would make the whole block slide, and then passes through one cycle. `contact.dissipated` is the work of
# friction so far; the arrays of a contact hold the points of this rank.

q = friction * p
F = 0.7 * q * L
exact = di.theory.bar_pull(F, p, friction, E, H)
levels = np.concatenate([np.linspace(0, 1, 5), np.linspace(0.75, -1, 8), np.linspace(-0.75, 1, 8)])
corner = fem.locate_dofs_geometrical(V, lambda x: np.isclose(x[0], 0.0) & np.isclose(x[1], 0.0))
corner = corner[corner < V.dofmap.index_map.size_local]
rows, profiles = [], {}
for step, level in enumerate(levels):
    pull.constant.value[0] = -level * F / H
    problem.solve()
    rows.append((comm.allreduce(-np.sum(u.x.array[2 * corner])), contact.dissipated))
    if step in (4, 8, 12):
        parts = comm.gather(np.column_stack([contact.points[:, 0], contact.traction[:, 0]]))
        profiles[f"F = {round(level * F / 1e3, 1) + 0:.1f} kN/m"] = parts
moved, dissipated = np.array(rows).T
cycle, expected = dissipated[-1] - dissipated[4], 2 * F**3 / (3 * E * H * q)

if comm.rank == 0:
    print(f"displacement under F {moved[4] * 1e6:7.4f} um    closed form {exact.end_displacement * 1e6:7.4f} um")
    print(f"without force        {moved[8] * 1e6:7.4f} um    closed form {exact.residual_displacement * 1e6:7.4f} um")
    print(f"work in a cycle      {cycle * 1e3:7.3f} mJ/m  closed form {expected * 1e3:7.3f} mJ/m")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    s, top = np.linspace(-1, 1, 100), exact.end_displacement
    branch = top * (1 - (1 - s) ** 2 / 2) * 1e6  # unloading from F: the law of loading, twice as large
    left.plot(branch, s * F / 1e3, "k-", -branch, -s * F / 1e3, "k-", lw=0.8)
    left.plot(top * s[50:] ** 2 * 1e6, s[50:] * F / 1e3, "k-", lw=0.8, label="closed form")
    left.plot(moved * 1e6, levels * F / 1e3, "o", mfc="none", label="computed")
    left.set(xlabel="displacement of the end [um]", ylabel="force [kN/m]")
    left.legend()
    for label, parts in profiles.items():
        x, traction = np.concatenate(parts).T
        right.plot(np.sort(x), traction[np.argsort(x)] / 1e3, label=label)
    right.set(xlabel="x [m]", ylabel="friction [kPa]")
    right.legend()
    figure.savefig("block_with_friction.png", dpi=120)

# ## What must hold
#
# Friction acts at the bottom, half a height below the axis, which changes the displacements by 0.3 % for this height.

assert np.allclose(moved[[4, 8, 12]] / exact.end_displacement, [1.0, 0.5, -1.0], atol=0.01)
assert abs(cycle / expected - 1) < 0.01
# SPDX-License-Identifier: MIT
