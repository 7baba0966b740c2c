# # Two bars collide
#
# An aluminium bar strikes a steel bar that is at rest. Both bars are deformable, so the contact pair has two surfaces:
# the nodes of the slave, the end of the striker, are projected on the master, the end of the target. With the impedances
# $Z_i = \rho_i c_i$ and the velocity $V$ of the striker, the contact stress and the velocity of the interface are
#
# $$ \sigma = \frac{Z_1 Z_2}{Z_1 + Z_2} V, \qquad v_c = \frac{Z_1}{Z_1 + Z_2} V, $$
#
# until the wave in the striker has been reflected at its free end and is back (Johnson 1985, section 11.1). The steel
# bar is so long that its own reflection comes later. Momentum is conserved throughout.

import basix.ufl
import matplotlib.pyplot as plt
import numpy as np
from dolfinx import fem, mesh
from mpi4py import MPI

import dolfinx_impact as di

# ## One mesh with two bodies
#
# All bodies are parts of one mesh and share no nodes. Here the mesh is made from arrays: two rows of nodes, and square
# cells between neighbouring nodes. There is no cell between the bodies. Rank 0 gives the arrays, and DOLFINx distributes
# the mesh.

n1, n2, h, gap, V0 = 100, 250, 2e-3, 1e-6, 10.0  # cells of both bars; their size, the gap [m]; velocity [m/s]
comm = MPI.COMM_WORLD
x = np.concatenate([h * np.arange(-n1, 1) - gap, h * np.arange(n2 + 1)])
points = np.column_stack([np.repeat(x, 2), np.tile([0.0, h], len(x))])
first = 2 * np.delete(np.arange(len(x) - 1), n1)[:, None]
cells = first + np.array([0, 2, 1, 3])
if comm.rank > 0:
    points, cells = points[:0], cells[:0]
bars = mesh.create_mesh(comm, cells, points, basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,)))

# Cell tags are for the materials, 1 for the striker and 2 for the target. Facet tags are for the contact, 3 for the
# slave and 4 for the master.


def tagged(dim, parts):
    """Tags of the entities on this rank whose vertices satisfy the conditions: a dictionary from tag to condition."""
    found = {tag: mesh.locate_entities(bars, dim, condition) for tag, condition in parts.items()}
    entities, values = np.hstack(list(found.values())), np.repeat(list(found), [len(e) for e in found.values()])
    order = np.argsort(entities)
    return mesh.meshtags(bars, dim, entities[order], values[order].astype(np.int32))


cell_tags = tagged(2, {1: lambda x: x[0] < -gap / 2, 2: lambda x: x[0] > -gap / 2})
facet_tags = tagged(1, {3: lambda x: np.abs(x[0] + gap) < gap / 4, 4: lambda x: np.abs(x[0]) < gap / 4})

# ## The problem
#
# A `MaterialMap` assigns a material to each cell tag. Poisson's ratio is zero, so that the bars obey the wave equation.
# Kinematic contact removes the penetration within each step and needs no spring.

V = fem.functionspace(bars, ("Lagrange", 1, (2,)))
u, velocity = fem.Function(V, name="displacement"), fem.Function(V)
velocity.interpolate(lambda x: np.array([np.where(x[0] < -gap / 2, V0, 0.0), 0.0 * x[0]]))
aluminium = di.LinearElastic(E=70e9, nu=0.0, density=2700.0, hypothesis="plane_strain")
steel = di.LinearElastic(E=207e9, nu=0.0, density=7800.0, hypothesis="plane_strain")
materials = di.MaterialMap(cell_tags, {1: aluminium, 2: steel})
pair = di.ContactPair(facet_tags, slave=3, master=4)
problem = di.ExplicitProblem(u, materials, velocity=velocity, contact=[di.Kinematic(pair)])

# ## Time stepping
#
# The callback is called at the start and after every step. It stores the time, the velocities of the nodes at the lower
# side, and the momentum. Sums over nodes count those that a rank owns.

exact = di.theory.bar_impact(V0, n1 * h, 2700.0, 70e9, 7800.0, 207e9)
T, owned = exact.release_time, V.dofmap.index_map.size_local
lower = np.flatnonzero(V.tabulate_dof_coordinates()[:owned, 1] < h / 2)
times, velocities, momenta = [], [], []


def record(problem):
    v = problem.velocity.x.array[: 2 * owned : 2]
    times.append((problem.time - gap / V0) / T)
    velocities.append(v[lower])
    momenta.append(comm.allreduce(problem.mass.array[: 2 * owned : 2] @ v))


problem.advance(until=gap / V0 + 1.8 * T, callback=record, progress=False)
history = (problem.energy_history[:, 0] - gap / V0) / T
stress = -problem.force_history[0][:, 0] / h

# ## Comparison
#
# The picture shows the velocities over place and time: two waves leave the contact, that of the striker is reflected.

mean = stress[(history > 0.1) & (history < 0.9)].mean()
impulse = np.sum(stress * np.diff(history, append=1.8)) * T
rear_velocity = V0 - impulse / (2700.0 * n1 * h)  # of the striker, on average
lost = np.ptp(momenta) / momenta[0]
parts = comm.gather((V.tabulate_dof_coordinates()[lower, 0], np.array(velocities)))
if comm.rank == 0:
    x, v = (np.concatenate(part, axis=-1) for part in zip(*parts))
    print(f"contact stress          {mean / 1e6:8.3f} MPa   exact {exact.stress / 1e6:8.3f} MPa")
    print(f"velocity of the striker {rear_velocity:8.3f} m/s   exact {exact.rear_velocity:8.3f} m/s")
    print(f"momentum changes by {lost:.1e}, energy by {abs(problem.energy['drift']):.1e}")
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.2), layout="constrained")
    image = left.pcolormesh(np.sort(x), times, v[:, np.argsort(x)], cmap="RdBu_r", clim=(-V0, V0), rasterized=True)
    left.axvline(0.0, color="k", lw=0.8)
    left.set(xlabel="x [m]", ylabel="time after first touch / T", title="aluminium | steel")
    figure.colorbar(image, label="velocity [m/s]")
    right.plot(history, stress / 1e6, label="computed")
    right.plot([-0.1, 0, 0, 1, 1, 1.8], np.array([0, 0, 1, 1, 0, 0]) * exact.stress / 1e6, "k--", label="exact")
    right.set(xlabel="time after first touch / T", ylabel="contact stress [MPa]")
    right.legend()
    figure.savefig("two_bars.png", dpi=120)

# ## What must hold
#
# Stress and velocity within 1 %, the limit of the benchmarks for such bars. Momentum to round-off, which some hundred
# steps add up.

assert abs(mean / exact.stress - 1) < 0.01 and abs(rear_velocity / exact.rear_velocity - 1) < 0.01 and lost < 1e-12
