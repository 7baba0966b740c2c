# # Two bars collide
#
# An aluminium bar strikes a steel bar that is at rest. Both bars are deformable, so the contact pair has two surfaces:
# the nodes of the slave, the end of the striker, are projected on the master, the end of the target. With impedances
# $Z_i = \rho_i c_i$ and the velocity $V$ of the striker, the contact stress and the velocity of the interface are
#
# $$ \sigma = \frac{Z_1 Z_2}{Z_1 + Z_2} V, \qquad v_c = \frac{Z_1}{Z_1 + Z_2} V, $$
#
# until the wave in the striker has been reflected at its free end and is back (Johnson 1985, section 11.1). The steel
# bar is so long that its own reflection comes later.

import basix.ufl
import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## One mesh with two bodies
#
# All bodies are parts of one mesh and share no nodes. Here rank 0 makes the mesh from arrays, and DOLFINx distributes
# it: two rows of nodes, and square cells between neighbouring nodes, except between the bodies.

n1, n2, h, gap, V0 = 100, 250, 2e-3, 1e-6, 10.0  # cells of both bars; their size, the gap [m]; velocity [m/s]
comm = MPI.COMM_WORLD
x = np.concatenate([h * np.arange(-n1, 1) - gap, h * np.arange(n2 + 1)])
points = np.column_stack([np.repeat(x, 2), np.tile([0.0, h], len(x))])
cells = 2 * np.delete(np.arange(len(x) - 1), n1)[:, None] + np.array([0, 2, 1, 3])
if comm.rank > 0:
    points, cells = points[:0], cells[:0]
bars = mesh.create_mesh(comm, cells, x=points, e=basix.ufl.element("Lagrange", "quadrilateral", 1, shape=(2,)))

# Cell tags are for the materials, 1 for the striker and 2 for the target. Facet tags are for the contact, 3 for the
# slave and 4 for the master.


def tagged(dim, parts):
    """MeshTags of entities by their place; `parts` is a dictionary from tag to condition."""
    found = [mesh.locate_entities(bars, dim, condition) for condition in parts.values()]
    entities, tags = np.hstack(found), np.repeat(list(parts), [len(f) for f in found]).astype(np.int32)
    return mesh.meshtags(bars, dim, np.sort(entities), tags[np.argsort(entities)])


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
# The callback is called at the start and after every step. It stores the velocities of the nodes at the lower side, and
# the momentum. A sum over nodes counts those that the rank owns.

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
stress, times = -problem.force_history[0][:, 0] / h, np.array(times)  # stress: before each step
mean = stress[(times[:-1] > 0.1) & (times[:-1] < 0.9)].mean()
rear_velocity = V0 - np.sum(stress * np.diff(times)) * T / (2700.0 * n1 * h)  # of the striker, by the impulse
lost = np.ptp(momenta) / momenta[0]
parts = comm.gather((V.tabulate_dof_coordinates()[lower, 0], np.array(velocities)))
if comm.rank == 0:
    print(f"contact stress          {mean / 1e6:8.3f} MPa   exact {exact.stress / 1e6:8.3f} MPa")
    print(f"velocity of the striker {rear_velocity:8.3f} m/s   exact {exact.rear_velocity:8.3f} m/s")
    print(f"momentum changes by {lost:.1e}, energy by {abs(problem.energy['drift']):.1e}")
    x, v = (np.concatenate(part, axis=-1) for part in zip(*parts))
    figure, axes = plt.subplots(figsize=(7, 4.2), layout="constrained")
    image = axes.pcolormesh(np.sort(x), times, v[:, np.argsort(x)], cmap="RdBu_r", clim=(-V0, V0), rasterized=True)
    axes.axvline(0.0, color="k", lw=0.8)
    axes.set(xlabel="x [m]", ylabel="time after first touch / T", title="aluminium | steel: waves of velocity")
    figure.colorbar(image, label="velocity [m/s]")
    figure.savefig("two_bars.png", dpi=120)

# Stress and velocity must agree to 1 %, the limit of the benchmarks for such bars, and momentum to round-off.
assert abs(mean / exact.stress - 1) < 0.01 and abs(rear_velocity / exact.rear_velocity - 1) < 0.01 and lost < 1e-12
# SPDX-License-Identifier: MIT
