# # A bar strikes a wall
#
# A steel bar flies against a rigid wall. This is the one impact whose solution is known exactly, because it consists of
# one-dimensional waves. With the wave speed $c = \sqrt{E/\rho}$ and the velocity $v$ of the bar,
#
# $$ \sigma = \rho c v, \qquad T = 2 L / c, $$
#
# where $\sigma$ is the contact stress. It stays constant until the wave has been reflected at the free end and returns
# to the wall at the time $T$. Then the bar leaves the wall with the velocity $-v$. The demo shows the four steps of an
# explicit problem: mesh with tagged facets, obstacle and contact pair, problem, time stepping.

import matplotlib.pyplot as plt
import numpy as np
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## Mesh and tags
#
# The bar has a hundred cells along its length and one across. DOLFINx makes the mesh, and the facets at the right end
# get the tag 1: they are the slave surface, whose nodes may touch the wall.

L, H, v, start = 0.5, 0.005, 10.0, 1e-5  # length and height [m], velocity [m/s], distance from the wall [m]
E, density = 207e9, 7800.0  # steel [Pa, kg/m^3]
comm = MPI.COMM_WORLD
bar = mesh.create_rectangle(comm, [(0.0, 0.0), (L, H)], [100, 1], mesh.CellType.quadrilateral)
right = mesh.locate_entities_boundary(bar, 1, lambda x: np.isclose(x[0], L))
facet_tags = mesh.meshtags(bar, 1, np.sort(right), np.full(len(right), 1, dtype=np.int32))

# ## The problem
#
# Poisson's ratio is zero, so that the bar in plane strain obeys the wave equation exactly. The normal of the wall
# points to the side where the bar is. The penalty stiffness follows from the masses and the time step;
# `di.Kinematic(pair)` in the place of `di.Penalty(pair)` enforces the contact without a spring.

V = fem.functionspace(bar, ("Lagrange", 1, (2,)))
u, velocity = fem.Function(V, name="displacement"), fem.Function(V)
velocity.interpolate(lambda x: np.array([v + 0.0 * x[0], 0.0 * x[0]]))
steel = di.LinearElastic(E=E, nu=0.0, density=density, hypothesis="plane_strain")
wall = di.RigidPlane(point=(L + start, 0.0), normal=(-1.0, 0.0))
pair = di.ContactPair(facet_tags, slave=1, master=wall)
problem = di.ExplicitProblem(u, steel, velocity=velocity, contact=[di.Penalty(pair)])

# ## Time stepping
#
# `advance` chooses a stable step. The problem keeps two histories with a row per step: the energies, with the time in
# the first column, and the force on the slave of each contact. Both are the same on all ranks.

exact = di.theory.bar_impact(v, L, density, E)
T = exact.release_time
problem.advance(until=start / v + 1.3 * T, progress=False)
time = problem.energy_history[:, 0] - start / v  # since first touch
kinetic, internal = problem.energy_history[:, 1], problem.energy_history[:, 2]
stress = -problem.force_history[0][:, 0] / H

# ## Comparison
#
# The force jumps in the exact solution. A computed jump is some cells wide, so the mean stress is taken over the middle
# of the contact, and the duration between the times of half the stress.

middle = (time > 0.1 * T) & (time < 0.9 * T)
mean = stress[middle].mean()
loaded = time[stress > 0.5 * exact.stress]
duration = loaded[-1] - loaded[0]
velocity_after = v - np.sum(stress * np.diff(time, append=1.3 * T)) / (density * L)  # by the impulse of the contact
if comm.rank == 0:
    print(f"{problem.step} steps of {problem.time / problem.step * 1e9:.0f} ns")
    print(f"contact stress {mean / 1e6:8.3f} MPa   exact {exact.stress / 1e6:8.3f} MPa")
    print(f"duration       {duration * 1e6:8.3f} us    exact {T * 1e6:8.3f} us")
    print(f"velocity after {velocity_after:8.3f} m/s   exact {exact.rear_velocity:8.3f} m/s")
    print(f"energy balance: error {problem.energy['drift']:.1e}")
    figure, (left, right) = plt.subplots(1, 2, figsize=(10, 4), layout="constrained")
    left.plot(time / T, stress / 1e6, label="computed")
    left.plot([-0.1, 0, 0, 1, 1, 1.3], np.array([0, 0, 1, 1, 0, 0]) * exact.stress / 1e6, "k--", label="exact")
    left.set(xlabel="time after first touch / T", ylabel="contact stress [MPa]", xlim=(-0.1, 1.3))
    left.legend()
    right.plot(time / T, kinetic, label="kinetic")
    right.plot(time / T, internal, label="internal")
    right.plot(time / T, problem.energy_history[:, 3], label="contact springs")
    right.set(xlabel="time after first touch / T", ylabel="energy [J/m]", xlim=(-0.1, 1.3), ylim=(0, 1.2 * kinetic[0]))
    right.legend(ncols=3, loc="upper center")
    figure.savefig("bar_on_wall.png", dpi=120)

# ## What must hold
#
# Stress and duration within 1 %, which is the limit of the benchmarks for such bars; energy to round-off.

assert abs(mean / exact.stress - 1) < 0.01 and abs(duration / T - 1) < 0.01 and abs(problem.energy["drift"]) < 1e-12
# SPDX-License-Identifier: MIT
