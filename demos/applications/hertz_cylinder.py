# # A cylinder pressed on a block: convergence to Hertz
#
# Nothing tells these two bodies where they touch. A steel cylinder as large as a railway wheel is pressed by its weight
# on a steel block; multipliers on a mortar find the contact and its pressure. Hertz (1881) knows both for half-planes
# (Johnson 1985, 4.2c): with $1/E^* = \sum (1 - \nu_i^2) / E_i$ and the load $P$ per length
#
# $$ a = \sqrt{\frac{4 P R}{\pi E^*}}, \qquad p(x) = \frac{2P}{\pi a} \sqrt{1 - x^2/a^2}. $$
#
# The block is 33 half-widths deep and as wide to either side: what differs from a half-plane then is below 0.1 %.

import os

import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.io import plots
from dolfinx_impact.io.gather import gather_field, gather_rows
from dolfinx_impact.io.run_folder import RunFolder, vertex_average

comm = MPI.COMM_WORLD
fast = os.environ.get("IMPACT_DEMO_FAST") == "1"
E, nu, R, P = 207e9, 0.3, 0.46, 4e6  # steel [Pa, 1], radius [m], load per length [N/m]
size, steps = 0.15, 4  # of the block [m], equal parts of the load
finest = {1: 8, 2: 4} if fast else {1: 32, 2: 16}  # degree -> facets across the half-width
run = RunFolder(name="hertz_cylinder", parameters={"E": E, "nu": nu, "R": R, "P": P, "size": size, "finest": finest})
full = di.theory.hertz_line(P, R, np.inf, E, nu, E, nu)
a, p0 = full.half_width, full.peak_pressure
run.print(f"Hertz: half-width {a * 1e3:.4f} mm, peak pressure {p0 / 1e6:.2f} MPa")

# ## Bodies, contact, load
#
# Half of the cylinder's lower half, half of the block: x = 0 is a plane of symmetry. The cylinder hangs on nothing but
# the contact; the load on its flat side presses it down. On elements of degree 2 the surface has to be as round as the
# displacement can follow: the geometry is of degree 2, too.


def pressed(degree, facets, own_form=None):
    """Problem, load, mesh with tags; `facets` across the half-width. A form of one's own is a function of u, the test
    function, the load and its measure, in place of the material."""
    h = a / facets
    m = meshes.make(
        "cylinder_on_half_plane", comm, degree=degree, radius=R, a=a, h=h, width=size, height=size, coarse=size / 4
    )
    V = fem.functionspace(m.mesh, ("Lagrange", degree, (2,)))

    def held(side, axis):
        dofs = fem.locate_dofs_topological(V.sub(axis), 1, m.facet_tags.find(m.tags[side]))
        return fem.dirichletbc(0.0, dofs, V.sub(axis))

    bcs = [held("bottom", 0), held("bottom", 1), held("symmetry_x", 0)]
    load = di.Traction(m.facet_tags, m.tags["top"], (0.0, -P / (2 * R)))
    pair = di.ContactPair(m.facet_tags, slave=m.tags["slave_surface"], master=m.tags["master_surface"])
    steel = di.LinearElastic(E=E, nu=nu, hypothesis="plane_strain")
    u = fem.Function(V, name="displacement")
    if own_form is None:
        return di.StaticProblem(u, steel, bcs=bcs, loads=[load], contact=[di.Lagrange(pair)]), load, m
    top = ufl.Measure("ds", m.mesh, subdomain_data=m.facet_tags)(m.tags["top"])
    residual = own_form(u, ufl.TestFunction(V), ufl.as_vector((0.0, -P / (2 * R))), top)
    return di.StaticProblem(u, residual=residual, bcs=bcs, contact=[di.Lagrange(pair)]), load, m


def error(contact, hertz):
    """L2 norm of the pressure's error over that of the pressure, from the nodes and the areas that belong to them."""
    x, p, w = contact.points[:, 0], contact.pressure, contact.weight
    exact = hertz.pressure(x)
    return np.sqrt(comm.allreduce(np.sum(w * (p - exact) ** 2)) / comm.allreduce(np.sum(w * exact**2)))


# ## Four steps of load
#
# At every load the edge of contact lies somewhere else in its facet, and the error with it. Their root mean square says
# more than one of them.

last, table = {}, []
run.print(f"{'degree':>6s} {'h/a':>6s} {'unknowns':>8s} {'pressure L2':>11s} {'peak':>7s} {'width':>7s}  iterations")
for degree, most in finest.items():
    for facets in (most // 4, most // 2, most):
        problem, load, m = pressed(degree, facets)
        contact, states, found, iterations = problem.contact[0], [], [], []
        for step in range(1, steps + 1):
            load.constant.value = (0.0, -P / (2 * R) * step / steps)
            iterations += problem.solve().iterations
            hertz = di.theory.hertz_line(P * step / steps, R, np.inf, E, nu, E, nu)
            peak = comm.allreduce(float(np.max(contact.pressure, initial=0.0)), MPI.MAX)
            # contact.area is the length of half the contact
            found.append((error(contact, hertz), peak / hertz.peak_pressure - 1, contact.area / hertz.half_width - 1))
            states.append(gather_rows(comm, np.column_stack([contact.points[:, 0], contact.pressure])))
        unknowns = 2 * problem.u.function_space.dofmap.index_map.size_global
        rms = np.sqrt(np.mean(np.square(found), axis=0))
        table.append((degree, 1 / facets, unknowns, *rms, sum(iterations)))
        percent = " ".join(f"{100 * v:{w}.2f}%" for v, w in zip(rms, (10, 6, 6)))
        run.print(f"{degree:6d} {1 / facets:6.3f} {unknowns:8d} {percent}  {iterations}")
    last[degree] = states, found, problem, m
table = np.array(table)

# ## The weak form by hand
#
# Contact does not ask where the residual comes from. Written in UFL, linear elasticity in plane strain gives the same
# pressures, and any other form would do. (With the same rule, 2 x 2 points: on these cells, which are no
# parallelograms, that of UFL's choice changes them by 2e-6.)


def virtual_work(u, v, traction, top):
    """Internal less external virtual work: Hooke's law with Lame's constants."""
    mu, lam = E / (2 * (1 + nu)), E * nu / ((1 + nu) * (1 - 2 * nu))
    strain = ufl.sym(ufl.grad(u))
    stress = lam * ufl.tr(strain) * ufl.Identity(2) + 2 * mu * strain
    return ufl.inner(stress, ufl.sym(ufl.grad(v))) * ufl.dx(degree=2) - ufl.inner(traction, v) * top


pressures = []
for form in (None, virtual_work):
    problem, load, m = pressed(1, finest[1] // 4, form)
    report = problem.solve()
    pressures.append(problem.contact[0].pressure)
differ = comm.allreduce(float(np.max(np.abs(pressures[1] - pressures[0]), initial=0.0)), MPI.MAX)
run.print(f"weak form by hand: iterations {report.iterations}, pressures differ by {differ / p0:.0e} of the peak")
if differ > 1e-8 * p0:  # Newton's tolerance of 1e-10 of the forces, at one node of some ten
    raise RuntimeError("the weak form written by hand is not that of the material")

# ## Equilibrium and the conditions of contact

states, found, problem, m = last[1]
contact = problem.contact[0]
force = 2 * contact.force[1]
nodal = contact.contact_forces().reshape(-1, 2)
unbalanced = np.abs(comm.allreduce(nodal.sum(axis=0))).max() / force
tension = comm.allreduce(float(np.min(contact.pressure, initial=0.0)), MPI.MIN)
penetration = -comm.allreduce(float(np.min(contact.gap, initial=0.0)), MPI.MIN)
run.print(
    f"force {force / 1e6:.9f} MN/m of {P / 1e6:g}; forces on the two bodies add up to {unbalanced:.0e} of that; "
    f"penetration {penetration:.0e} m"
)

# ## Files and picture


u = problem.u
von_mises = vertex_average(problem.material.von_mises(u), m.mesh, "von_mises")
run.fields("hertz_cylinder", [u, von_mises])
columns = ("degree", "h", "unknowns", "pressure_error", "peak_error", "width_error", "iterations")
run.table("convergence", {c: (v, "a" if c == "h" else "1") for c, v in zip(columns, table.T)})
field, displacement = gather_field(von_mises), gather_field(u)


def draw():
    """Called on rank 0."""
    plt = plots.pyplot()
    figure, (left, middle, right) = plt.subplots(
        1, 3, figsize=(13.5, 4.3), layout="constrained", width_ratios=(1.1, 1, 0.8)
    )
    figure.get_layout_engine().set(w_pad=0.12)
    half = displacement.values[np.argmax(displacement.points[:, 1])] / 2
    # Both bodies have come half way towards each other.
    grid = plots.deformed_grid(field, displacement, factor=1e-6, shift=-half)
    mirrored = grid.copy()
    mirrored.points = grid.points * [-1, 1, 1]
    r, clim = 2.6 * a, (0.0, round(0.56 * p0 / 1e6, -1))
    box = (-r, r, -r, r)
    centre = grid.points[np.argmin(np.abs(field.points).sum(axis=1))][1]
    for part in (grid, mirrored):
        part.points = part.points - [0, centre, 0]
    both = [grid, mirrored]
    plots.show_grids(figure, left, both, clim, "von Mises stress [MPa]", "true scale", box=box, size=(720, 720))
    x = np.linspace(0, 1.25 * a, 600)
    for step, state in enumerate(states, 1):
        hertz = di.theory.hertz_line(P * step / steps, R, np.inf, E, nu, E, nu)
        middle.plot(x * 1e3, hertz.pressure(x) / 1e6, color="#6b6b6b", lw=1, label="Hertz" if step == 1 else None)
        for degree, marker in ((1, "o"), (2, "s")):
            at, p = last[degree][0][step - 1].T
            near = (at < 1.25 * a) & ((p > 0) | (at < 1.1 * hertz.half_width))
            middle.plot(
                at[near] * 1e3, p[near] / 1e6, marker, ms=3.5, mfc="none", color=plots.COLOURS[degree - 1],
                label=f"degree {degree}" if step == steps else None,
            )  # fmt: skip
    middle.set(xlabel="x [mm]", ylabel="pressure [MPa]", xlim=(0, 1.25 * a * 1e3), ylim=(0, 1.08 * p0 / 1e6))
    middle.set_title(f"pressure at the nodes, {steps} loads up to {P / 1e6:g} MN/m", fontsize=10)
    middle.legend(fontsize=9)
    for degree, marker in ((1, "o-"), (2, "s-")):
        rows = table[table[:, 0] == degree]
        colour = plots.COLOURS[degree - 1]
        right.loglog(rows[:, 2], rows[:, 3], marker, mfc="none", color=colour, label=f"pressure (L2), degree {degree}")
        right.loglog(rows[:, 2], rows[:, 4], marker, ls=":", mfc="none", color=colour, label=f"peak, degree {degree}")
    right.set(xlabel="unknowns", ylabel="relative error (root mean square)", ylim=(1e-4, 0.3))
    right.set_title("convergence", fontsize=10)
    right.legend(fontsize=8)
    plots.save(figure, run.file("hertz_cylinder.png"))


if comm.rank == 0:
    x, p = states[-1][np.argsort(states[-1][:, 0])].T
else:
    x, p = np.empty(0), np.empty(0)
x, p = comm.bcast((x, p))
run.table("pressure", {"x": (x, "m"), "pressure": (p, "Pa"), "hertz": (full.pressure(x), "Pa")})
run.pictures(draw)
run.print(f"results in {run.path}")

# ## What must hold
#
# Numbers for R = 0.46 m and 4 kN per mm, computed beforehand: half-width 4.538523 mm, peak pressure 561.081 MPa.

width, peak = contact.area, p.max()
assert abs(a / 4.538523e-3 - 1) < 1e-6 and abs(p0 / 561.081e6 - 1) < 1e-5
assert abs(peak / 561.081e6 - 1) < 0.02 and abs(width - 4.538523e-3) < a / finest[1]
assert np.all(table[table[:, 1] == table[:, 1].min()][:, 3] < (0.1 if fast else 0.03))
assert np.all(table[[2, 5], 3] < table[[0, 3], 3]), "the error falls with the cells"
assert abs(force / P - 1) < 1e-9 and unbalanced < 1e-12 and tension >= 0 and penetration < 1e-10 * size
# SPDX-License-Identifier: MIT
