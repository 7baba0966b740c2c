# # Rolling, three ways
#
# A driven wheel rolls on a rail with a constant creep. Carter found the tractions in 1926. `RollingProblem` finds them
# on a mesh that stands still while the material flows through it. An explicit run that starts from there follows the
# material: after two half-widths all of it that touched in the beginning has left the contact, and what is found then
# was made by the run, which has another friction law (springs at nodes), another mass matrix, and time.

import os

import numpy as np
from mpi4py import MPI
from dolfinx import fem

import dolfinx_impact as di
from dolfinx_impact import meshes, theory
from dolfinx_impact.io import plots
from dolfinx_impact.io.run_folder import RunFolder

comm = MPI.COMM_WORLD
fast = os.environ.get("IMPACT_DEMO_FAST") == "1"
R, a, friction, speed, creep = 500.0, 1.0, 0.3, 20000.0, 2.4e-4  # mm, mm/s; a: half-width that the mesh is made for
E, nu = 209.92e3, 0.28  # MPa
cells = 5 if fast else 10  # in the half-width
way = 0.6 if fast else 3.0  # rolled in time, over a
run = RunFolder(name="rolling_three_ways", parameters={"R": R, "friction": friction, "creep": creep, "cells": cells})

# ## Wheel and rail
#
# The mesh is fine where material will come through the contact. In time the wheel turns by finite angles, so that the
# law is one of finite strain.

made = meshes.make(
    "wheel_on_rail_2d", comm, radius=R, hub_radius=100.0, a=a, h=a / cells, core=(1.4 + way) * a, rail_length=400.0,
    rail_height=200.0,
)  # fmt: skip
tags = made.tags
V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
u, hub = fem.Function(V, name="displacement"), fem.Function(V)
axle, bottom = (fem.locate_dofs_topological(V, 1, made.facet_tags.find(tags[name])) for name in ("hub", "bottom"))
hub.x.array.reshape(-1, 2)[axle] = (0.0, -0.0055)
steel = di.StVenantKirchhoff(E, nu, density=7.85e-9, hypothesis="plane_strain")
wheel = di.Spin(point=(0.0, R), axis=(0.0, 0.0, 1.0), omega=-speed / R)
pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"], friction=friction)
rolling = di.RollingProblem(
    u, steel, made.cell_tags, {tags["slave_body"]: wheel, tags["master_body"]: di.Translation((-speed, 0.0))},
    contact=[di.Lagrange(pair)], bcs=[fem.dirichletbc(hub, axle), fem.dirichletbc(np.zeros(2), bottom, V)],
)  # fmt: skip
contact = rolling.contact[0]

# ## First way: the steady state itself

rolling.solve(torque=0.0)  # rolls freely: the creep counts from here
wheel.omega *= 1.0 + creep
rolling.solve()
P, Q = contact.force[1], contact.force[0]

# ## Second way: in time
#
# Displacements, velocities, pressures and tractions of the steady state are those of the beginning.

moving = di.ExplicitProblem.from_rolling(rolling)
moving.advance(way * a / speed, progress=False)

# ## Third way: Carter

exact = theory.carter(P, friction, R, np.inf, E, nu, E, nu, creep=creep)
half_width = exact.contact.half_width


def history(problem):
    """Way over the half-width, tangential over normal force over friction: means over a twentieth of the half-width, as
    nodes close and open one by one."""
    ways = problem.energy_history[:, 0] * speed / half_width
    ratio = problem.force_history[0] @ [1.0, 0.0] / (friction * problem.force_history[0] @ [0.0, 1.0])
    window = max(1, np.searchsorted(ways, 0.05))
    count = len(ways) // window * window
    return ways[:count].reshape(-1, window).mean(axis=1), ratio[:count].reshape(-1, window).mean(axis=1)


rolled, ratio = history(moving)
carter = exact.tangential_load_per_length / (friction * P)
run.print(f"half-width {half_width:.3f} mm under {P:.1f} N/mm; tangential force over friction times load:")
run.print(f"  Carter         {carter:.4f}")
run.print(f"  RollingProblem {Q / (friction * P):.4f}")
run.print(
    f"  in time        {ratio.min():.4f} to {ratio.max():.4f}, {rolled[-1]:.2f} half-widths in {moving.step} steps"
)
run.table("history", {"way": (rolled, "1"), "ratio": (ratio, "1")})


def tractions(c):
    """Places and tractions of the nodes in contact, on rank 0."""
    parts = comm.gather((c.points[:, 0], c.traction[:, 0], c.status))
    if parts is None:
        return None
    x, q, status = (np.concatenate(column) for column in zip(*parts))
    at = np.flatnonzero(status > 0)
    at = at[np.argsort(x[at])]
    return x[at] / half_width, q[at]


in_time, standing = tractions(moving.contact[0]), tractions(contact)
run.fields("rolling_three_ways", [u])


def draw():
    """Called on rank 0."""
    plt = plots.pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.2), layout="constrained")
    left.axhline(carter, color="k", label="Carter")
    left.axhline(Q / (friction * P), color="C0", linestyle="--", label="RollingProblem")
    left.plot(rolled, ratio, "C3-", label="explicit")
    left.set(xlabel="way over the half-width", ylabel="traction over friction times load", ylim=(0.0, 1.05))
    left.legend(loc="lower right")
    fine = np.linspace(-1.2, 1.2, 481)
    right.plot(fine, friction * exact.contact.pressure(fine * half_width), "0.6", label="friction times Hertz")
    right.plot(fine, exact.traction(fine * half_width), "k-", label="Carter")
    right.plot(*standing, "C0o", label="RollingProblem")
    right.plot(*in_time, "C3x", label=f"explicit, after {rolled[-1]:.1f} half-widths")
    right.set(xlabel="x over the half-width, the wheel travels to the right", ylabel="traction [MPa]")
    right.legend()
    plots.save(figure, run.file("rolling_three_ways.png"))


run.pictures(draw)
run.print(f"results in {run.path}")

# The derivative of the steady state is taken from upstream, and is of first order: 4 % with 10 cells. In time nodes
# close and open one by one, with a tenth of the contact each.
steady_error, time_error = abs(Q / (friction * P) / carter - 1.0), np.abs(ratio / carter - 1.0).max()
assert steady_error < (0.12 if fast else 0.05), f"the steady state differs from Carter's by {steady_error:.3f}"
assert time_error < (0.12 if fast else 0.05), f"the run differs from Carter's force by {time_error:.3f}"
# SPDX-License-Identifier: MIT
