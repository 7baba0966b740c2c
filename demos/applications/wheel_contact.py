# # A wheel pressed on a rail by 100 kN: contact finds the ellipse of Hertz
#
# An elastic wheel of radius 0.46 m stands on a rail whose head has a radius of 0.30 m across. 100 kN press it down,
# 25 kN on the quarter that symmetry leaves. Nothing but the rail holds the wheel up: where they touch, and how hard, is
# found by multipliers at the nodes of the wheel (mortar method, see `docs/contact.md`).
#
# Run it by `make demo DEMO=wheel_contact`, or `dolfinx-impact demo wheel_contact --ranks 2`.

import os
import time

import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.io import plots
from dolfinx_impact.io.gather import gather_rows
from dolfinx_impact.io.run_folder import RunFolder

comm, started = MPI.COMM_WORLD, time.perf_counter()
fast = os.environ.get("IMPACT_DEMO_FAST") == "1"  # a coarse mesh, for tests

# ## What Hertz says
#
# Lengths in m, forces in N. The half axes of the ellipse and the peak pressure follow from elliptic integrals
# (`di.theory`); seed (3.7), (3.8), corrected. x is the rolling direction.

E, nu, radius, crown, load = 207e9, 0.3, 0.46, 0.30, 100e3
hertz = di.theory.hertz_elliptic(load, radius, np.inf, np.inf, crown, E, nu, E, nu)
run = RunFolder(
    name="wheel_contact",
    parameters={"E": E, "nu": nu, "radius": radius, "crown": crown, "load": load, "fast": fast},
)
run.print(f"Hertz: half axes {hertz.a * 1e3:.4f} and {hertz.b * 1e3:.4f} mm, peak {hertz.peak_pressure / 1e6:.1f} MPa")

# ## Mesh and problem
#
# A quarter of wheel and rail, hexahedra of degree 1, refined where they will touch. The rail is held at its foot; the
# wheel is held by symmetry, sideways, and carries its load at the bore.

size = {"a": 9e-3, "coarse": 0.08, "h": 3e-3} if fast else {"a": 8e-3, "coarse": 0.1, "h": 1.8e-3}
made = meshes.make("wheel_on_rail_3d", comm, radius=radius, crown_radius=crown, symmetry="quarter", **size)
mesh, tags = made.mesh, made.tags
V = fem.functionspace(mesh, ("Lagrange", 1, (3,)))
u = fem.Function(V, name="displacement")
bottom = fem.locate_dofs_topological(V, 2, made.facet_tags.find(tags["bottom"]))
bcs = [fem.dirichletbc(np.zeros(3), bottom, V)]
for i, name in enumerate(("symmetry_x", "symmetry_y")):
    dofs = fem.locate_dofs_topological(V.sub(i), 2, made.facet_tags.find(tags[name]))
    bcs.append(fem.dirichletbc(0.0, dofs, V.sub(i)))
bore = ufl.Measure("ds", domain=mesh, subdomain_data=made.facet_tags)(tags["hub"])
area = comm.allreduce(fem.assemble_scalar(fem.form(fem.Constant(mesh, 1.0) * bore)), MPI.SUM)
steel = di.LinearElastic(E=E, nu=nu, density=7800.0)
press = di.Traction(made.facet_tags, tags["hub"], (0.0, 0.0, -load / 4 / area))

# The wheel's tread is the slave: it carries the contact points; the rail is the master.

pair = di.ContactPair(made.facet_tags, slave=tags["slave_surface"], master=tags["master_surface"])
problem = di.StaticProblem(u, steel, bcs=bcs, loads=[press], contact=[di.Lagrange(pair)])
unknowns = V.dofmap.index_map.size_global * 3
run.print(f"{mesh.topology.index_map(3).size_global} cells, {unknowns} unknowns; solving")
report = problem.solve(verbose=True)
contact = problem.contact[0]

# ## Against Hertz
#
# Wheel and rail are no half-spaces, and small strains are not infinitesimal; 3 % is what good codes reach.
# Each contact point has a pressure, a gap and a status; force and area are summed over all ranks.

rows = gather_rows(comm, np.column_stack([contact.points, contact.pressure, contact.gap, contact.status]))
summary = None
if comm.rank == 0:
    touching = rows[:, 5] > 0
    inside = (rows[:, 0] / hertz.a) ** 2 + (rows[:, 1] / hertz.b) ** 2 < 1
    difference = rows[inside, 3] - hertz.pressure(rows[inside, 0], rows[inside, 1])
    exact = hertz.pressure(rows[inside, 0], rows[inside, 1])
    summary = {
        "peak": rows[:, 3].max(),
        "points": int(touching.sum()),
        "misfit": np.linalg.norm(difference) / np.linalg.norm(exact),
        "open": rows[~touching, 4].min(),
    }
summary = comm.bcast(summary, root=0)
peak, contact_area = summary["peak"] / hertz.peak_pressure - 1, 4 * contact.area / (np.pi * hertz.a * hertz.b) - 1
balance = abs(4 * contact.force[2] / load - 1)
forces = contact.contact_forces().reshape(-1, 3).sum(axis=0)
opposite = np.abs(comm.allreduce(forces, MPI.SUM)).max() / load
run.print(
    f"""
  load carried by the contact   {4 * contact.force[2] / 1e3:.6f} kN (applied 100 kN)
  peak pressure                 {summary["peak"] / 1e6:.1f} MPa, {peak:+.2%} against Hertz
  contact area                  {4 * contact.area * 1e6:.2f} mm2, {contact_area:+.2%}
  pressure at the points        {summary["misfit"]:.2%} off (root mean square), {summary["points"]} points in contact
  slave and master forces       opposite to {opposite:.1e} of the load
  iterations                    {report.iterations}, in contact {report.active_set_sizes[-1]}
"""
)


# ## Figure and fields


def draw():
    """Pressure along both axes and seen from above, mirrored to the whole ellipse."""
    plt = plots.pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(11, 4.4), layout="constrained")
    for axis, half, colour, name in (
        (0, hertz.a, plots.COLOURS[0], "rolling"),
        (1, hertz.b, plots.COLOURS[1], "across"),
    ):
        on = np.abs(rows[:, 1 - axis]) < 1e-6
        near = on & (rows[:, axis] < 1.6 * hertz.a)
        s = np.linspace(0, half, 200)
        curve = hertz.pressure(s, 0.0) if axis == 0 else hertz.pressure(0.0, s)
        left.plot(s * 1e3, curve / 1e6, color=colour, lw=1.2, label=f"Hertz, {name}")
        left.plot(rows[near, axis] * 1e3, rows[near, 3] / 1e6, "o", color=colour, ms=5, label=f"contact, {name}")
    left.set(xlabel="distance from the centre [mm]", ylabel="contact pressure [MPa]")
    left.legend()
    near = np.abs(rows[:, :2]).max(axis=1) < 1.6 * hertz.a
    near &= rows[:, 2] < 0.1 * radius
    x, y, p = (np.concatenate([v] * 4) for v in (rows[near, 0], rows[near, 1], rows[near, 3]))
    n = near.sum()
    x[n : 2 * n], x[3 * n :], y[2 * n :] = -x[n : 2 * n], -x[3 * n :], -y[2 * n :]
    image = right.tricontourf(x * 1e3, y * 1e3, p / 1e6, levels=14, cmap="viridis")
    angle = np.linspace(0, 2 * np.pi, 200)
    right.plot(hertz.a * 1e3 * np.cos(angle), hertz.b * 1e3 * np.sin(angle), color="white", lw=1.2, ls="--")
    right.set(xlabel="rolling direction [mm]", ylabel="across [mm]", aspect="equal", title="dashed: Hertz's ellipse")
    right.set(xlim=np.array((-1.3, 1.3)) * hertz.a * 1e3, ylim=np.array((-1.3, 1.3)) * hertz.a * 1e3)
    right.grid(False)
    figure.colorbar(image, ax=right, label="contact pressure [MPa]")
    plots.save(figure, run.file("wheel_contact.png"))


run.pictures(draw)
run.fields("wheel_contact", [u, contact.field(problem, contact.pressure, "contact_pressure")])
columns = {"x": "m", "y": "m", "z": "m", "pressure": "Pa", "gap": "m", "status": "1"}
run.table("points", {k: (rows[:, i], unit) for i, (k, unit) in enumerate(columns.items())} if comm.rank == 0 else {})
run.print(f"results in {run.path}, {time.perf_counter() - started:.1f} s in all on {comm.size} rank(s)")

# ## What must hold
#
# Equilibrium and the conditions of contact to round-off; the peak pressure within 3 % and the area within one facet
# around the ellipse (coarse mesh of the tests: 6 %, two facets per half axis).

facets = size["h"] / hertz.b
assert report.converged and balance < 1e-9 and opposite < 1e-12
assert summary["open"] > -1e-10 and comm.allreduce(float(np.min(contact.pressure, initial=0.0)), MPI.MIN) >= 0.0
assert abs(hertz.peak_pressure - 1225.744e6) < 1e3
assert abs(peak) < (0.06 if fast else 0.03) and abs(contact_area) < facets
# SPDX-License-Identifier: MIT
