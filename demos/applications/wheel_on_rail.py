# # A wheel pressed on a rail, solved twice
#
# An elastic wheel of radius 0.46 m stands on an elastic rail. Where they touch, Hertz tells how the pressure is
# distributed. Here that pressure is *given*: it acts on both bodies, equal and opposite, while the wheel is held at its
# bore and the rail at its foot. (In the demo `wheel_contact`, contact finds it.)
#
# The same mesh and the same load go to two programs that share no code:
#
# * DOLFINx with kernels generated from UFL (`dolfinx_impact.StaticProblem`),
# * the hand-written solver (`impact_reference.Model`: its own shape functions, B matrices and sparse solution).
#
# Discretised alike, they are two ways to compute the same numbers, so they must agree to round-off: machine precision
# (2e-16) times what a condition number that grows with the mesh makes of it. 1e-9 of the largest value is demanded
# below; 1e-12 is usual for displacements and 1e-11 for nodal forces, small differences of large numbers in the body.
#
# Run it by `make demo`, or `dolfinx-impact demo wheel_on_rail --ranks 2`.

import os
import time

import impact_reference
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem
from dolfinx.mesh import entities_to_geometry

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.assembly import operators
from dolfinx_impact.demos.applications.figures import wheel as figures
from dolfinx_impact.io.gather import gather_field, gather_mesh, gather_rows
from dolfinx_impact.io.run_folder import RunFolder, vertex_average
from impact_verify import nodes

comm, started = MPI.COMM_WORLD, time.perf_counter()
fast = os.environ.get("IMPACT_DEMO_FAST") == "1"  # coarse meshes, for tests

# ## Hertz
#
# Steel on steel; lengths in m, forces in N, stresses in Pa. In plane strain, a cylinder on a flat under the line load
# $P$ has the half-width $a = \sqrt{4 P R / (\pi E^*)}$ and pressure $p = p_0 \sqrt{1 - (x/a)^2}$, $p_0 = 2 P /
# (\pi a)$, with $1/E^* = 2 (1 - \nu^2) / E$ (Johnson, *Contact Mechanics*, 1985, ch. 4).

E, nu, radius = 207e9, 0.3, 0.46
E_star = E / (2 * (1 - nu**2))
line_load = 4e6  # [N/m], 4 kN per mm of width
a = np.sqrt(4 * line_load * radius / (np.pi * E_star))
p0 = 2 * line_load / (np.pi * a)
run = RunFolder(
    name="wheel_on_rail",
    parameters={"E": E, "nu": nu, "radius": radius, "line_load": line_load, "a": a, "p0": p0, "fast": fast},
)
run.print(f"Hertz, line contact: half-width a = {a * 1e3:.6f} mm, peak pressure p0 = {p0 / 1e6:.3f} MPa")

# In 3D the rail head is crowned with a radius of 0.30 m. The patch is an ellipse; its half axes and peak pressure under
# 80 kN come from the elliptic integrals of the theory, given here as numbers. 80 kN, because above 110 kN such a
# contact is not elastic.

load, crown, ax, by = 80e3, 0.30, 6.68027e-3, 5.02505e-3
p0_ellipse = 3 * load / (2 * np.pi * ax * by)

# ## The patch on a mesh
#
# Neither program integrates a square root exactly, and each has its own quadrature. Therefore the load is discretised
# *before* it is handed over: every facet gets one constant traction, such that its force is the exact integral of the
# Hertz pressure over it. Both integrate constants exactly, and the total force is the load itself, whatever the mesh.


def line_force(x0, x1):
    """Force per width between two abscissae [N/m]."""

    def primitive(x):
        s = np.clip(x / a, -1, 1)
        return line_load / np.pi * (np.arcsin(s) + s * np.sqrt(1 - s * s))

    return primitive(x1) - primitive(x0)


def ellipse_force(x0, x1, y0, y1):
    """Force on rectangles, arrays of their sides [N]: exact along y, 60 Gauss points along x inside the ellipse."""
    t, weights = np.polynomial.legendre.leggauss(60)
    low, high = np.clip(x0, -ax, ax)[:, None], np.clip(x1, -ax, ax)[:, None]
    x = (low + high) / 2 + (high - low) / 2 * t
    width = by * np.sqrt(np.maximum(1 - (x / ax) ** 2, 1e-300))  # of the ellipse, at x
    sides = [np.clip(y[:, None] / width, -1, 1) for y in (y0, y1)]
    low_side, high_side = ((np.arcsin(s) + s * np.sqrt(1 - s * s)) / 2 for s in sides)
    strip = p0_ellipse * width**2 / by * (high_side - low_side)
    return (strip * weights).sum(axis=1) * (high - low)[:, 0] / 2


def patch_traction(made, force):
    """The patch: a vector per cell that pushes the rail down, the wheel up [Pa]; its facets with their tractions."""
    mesh, dim = made.mesh, made.mesh.geometry.dim
    traction = fem.Function(fem.functionspace(mesh, ("DG", 0, (dim,))), name="patch")
    mesh.topology.create_connectivity(dim - 1, dim)
    cell_of = mesh.topology.connectivity(dim - 1, dim)
    owned = mesh.topology.index_map(dim).size_local
    rows = []
    for surface, up in (("master_surface", -1.0), ("slave_surface", 1.0)):
        facets = made.facet_tags.find(made.tags[surface])
        facets = np.array([f for f in facets if cell_of.links(f)[0] < owned], dtype=np.int32)
        if len(facets) == 0:  # none on this rank
            continue
        corners = entities_to_geometry(mesh, dim - 1, facets)  # numbers of the facets' vertices
        x = mesh.geometry.x[corners]
        horizontal = [side(x[:, :, i], axis=1) for i in range(dim - 1) for side in (np.min, np.max)]
        # Facets are flat: straight lines, parallelograms.
        edges = [x[:, i] - x[:, 0] for i in range(1, corners.shape[1])]
        area = np.linalg.norm(edges[0] if dim == 2 else np.cross(edges[0], edges[1]), axis=1)
        near = x[:, :, dim - 1].max(axis=1) < 0.1 * radius  # the tread below, not the tread above
        pressure = np.where(near, force(*horizontal), 0.0) / area
        for facet, p, numbers in zip(facets, pressure, corners):
            traction.x.array[dim * cell_of.links(facet)[0] + dim - 1] += up * p
            if p > 0.0:
                rows.append((*mesh.geometry.index_map().local_to_global(numbers.astype(np.int32)), up * p))
    traction.x.scatter_forward()
    rows = gather_rows(comm, np.array(rows, dtype=float).reshape(len(rows), 2 ** (dim - 1) + 1))
    return traction, rows


# ## Both solutions
#
# DOLFINx's side first: material, supports, the patch as tractions on both surfaces, one solve. In 3D a quarter is
# enough; on its planes of symmetry the normal displacement vanishes.


def solve_dolfinx(made, material, degree, traction):
    """Displacement, internal forces by the generated kernels, marker of supports; force at the hub and at the foot."""
    mesh, dim = made.mesh, made.mesh.geometry.dim
    V = fem.functionspace(mesh, ("Lagrange", degree, (dim,)))
    u, fixed, bcs, held = fem.Function(V, name="displacement"), fem.Function(V, name="fixed"), [], {}
    mesh.topology.create_connectivity(dim - 1, dim)
    for name in ("hub", "bottom"):
        held[name] = fem.locate_dofs_topological(V, dim - 1, made.facet_tags.find(made.tags[name]))
        bcs.append(fem.dirichletbc(np.zeros(dim), held[name], V))
        fixed.x.array[(dim * held[name][:, None] + np.arange(dim)).ravel()] = 1.0
    for i, name in enumerate(("symmetry_x", "symmetry_y")):
        if name in made.tags:
            dofs = fem.locate_dofs_topological(V.sub(i), dim - 1, made.facet_tags.find(made.tags[name]))
            bcs.append(fem.dirichletbc(0.0, dofs, V.sub(i)))
            fixed.x.array[dofs] = 1.0
    surfaces = [made.tags["slave_surface"], made.tags["master_surface"]]
    loads = [di.Traction(made.facet_tags, tag, traction) for tag in surfaces]
    problem = di.StaticProblem(u, material, bcs=bcs, loads=loads)
    report = problem.solve()
    assert report.iterations == [1], "the problem is linear"
    reaction = problem.reactions().x.array.reshape(-1, dim)
    owned = V.dofmap.index_map.size_local
    totals = {name: comm.allreduce(reaction[dofs[dofs < owned], dim - 1].sum()) for name, dofs in held.items()}
    force = fem.Function(V)
    kernels = di.InternalForce(operators.internal_force_form(u, ufl.TestFunction(V), material))
    force.x.array[:] = kernels.apply().array
    return u, force, fixed, totals


# Then the hand-written solver. It wants plain arrays: points, cells in its own node order, facets and their tractions,
# the fixed degrees of freedom. They are gathered on rank 0, where it runs whatever the number of ranks, so the
# comparison also covers the distribution of DOLFINx's mesh.


def solve_by_hand(made, degree, rows, u, fixed):
    """On rank 0: displacement and internal forces at DOLFINx's (global) nodes; None on the other ranks."""
    mesh, field, marker = gather_mesh(made.mesh), gather_field(u), gather_field(fixed)
    if comm.rank > 0:
        return None
    dim, cell = mesh.points.shape[1], mesh.cell_type
    cells = np.empty_like(mesh.cells)
    cells[:, nodes.permutation(cell, 1)] = mesh.cells  # from DOLFINx's node order to its own
    hypothesis = "3d" if dim == 3 else "plane_strain"
    material = impact_reference.Material(law="linear_elastic", hypothesis=hypothesis, E=E, nu=nu)
    model = impact_reference.Model(mesh.points, cells, cell, material, degree=degree)
    theirs = np.empty(len(field.points), dtype=np.int64)  # its node that is DOLFINx's global node k
    theirs[field.cells.ravel()] = model.field_cells[:, nodes.permutation(cell, degree)].ravel()
    assert np.allclose(model.field_points[theirs], field.points, atol=1e-12)
    force = np.zeros(model.num_dofs)
    for row in rows:
        force += model.traction(row[None, :-1].astype(np.int64), [*[0.0] * (dim - 1), row[-1]])
    its_marker = np.zeros((len(theirs), dim))
    its_marker[theirs] = marker.values
    solution = model.solve_static(np.flatnonzero(its_marker.ravel()), 0.0, force)
    internal = model.internal_force(solution.u)
    return [values.reshape(-1, dim)[theirs] for values in (solution.u, internal)]


def compare(made, material, degree, force):
    """Solve twice; returns everything the report and the figures need."""
    clock = [time.perf_counter()]
    traction, rows = patch_traction(made, force)
    u, internal, fixed, totals = solve_dolfinx(made, material, degree, traction)
    clock.append(time.perf_counter())
    run.print(f"  DOLFINx side done in {clock[1] - clock[0]:.1f} s; the hand-written solver is at work")
    by_hand = solve_by_hand(made, degree, rows, u, fixed)
    clock.append(time.perf_counter())
    ours = [gather_field(u), gather_field(internal)]
    difference = None
    if comm.rank == 0:
        difference = [np.abs(f.values - h).max() / np.abs(h).max() for f, h in zip(ours, by_hand)]
    difference = comm.bcast(difference, root=0)
    count = made.mesh.topology.index_map(made.mesh.topology.dim).size_global
    unknowns = u.function_space.dofmap.index_map.size_global * u.function_space.dofmap.bs
    return {
        "u": u, "field": ours[0], "by_hand": by_hand and by_hand[0], "totals": totals, "seconds": np.diff(clock),
        "displacement": difference[0], "forces": difference[1], "cells": count, "unknowns": unknowns,
    }  # fmt: skip


# ## In the plane
#
# Quadrilaterals with a displacement of degree 2, eight cells across the half-width of the patch.

cell_size = a / (4 if fast else 8)
run.print("plane strain: meshing and solving")
plane = meshes.make("wheel_on_rail_2d", comm, radius=radius, a=a, h=cell_size)
steel = di.LinearElastic(E=E, nu=nu, density=7800.0, hypothesis="plane_strain")
flat = compare(plane, steel, 2, line_force)

# The stress is evaluated by compiled expressions (`PointValues`) at the vertices of each cell and averaged there.

stress = steel.stress(flat["u"])
shear = ufl.sqrt((stress[0, 0] - stress[1, 1]) ** 2 / 4 + stress[0, 1] ** 2)
flat["mises"] = vertex_average(steel.von_mises(flat["u"]), plane.mesh, "von_mises")
flat["shear"] = vertex_average(shear, plane.mesh, "largest_shear")
run.fields("wheel_on_rail_2d", [flat["u"], flat["mises"], flat["shear"]])

# Two consequences of Hertz's theory, which nobody has put into the computation:
#
# * on the axis the largest shear stress is $p_0 (z - z^2 / \sqrt{1 + z^2})$ at the depth $z a$, at most 0.30028 p0 at
#   0.7862 a. That holds in half-planes. The rail is 38 a deep on a rigid bed, which adds a nearly constant 0.008 p0
#   (measured: 0.0086 with this rail, 0.0033 with one of 0.5 m, 0.0012 with 1.5 m: as one over the height);
# * the pressed surfaces fit: the distance of the deformed surfaces is constant inside the patch.


def axis_profile(gathered, component):
    """Depth below the rail's surface and a nodal value, on the rail's part of the axis, sorted."""
    on_axis = (np.abs(gathered.points[:, 0]) < 1e-9) & (gathered.points[:, -1] < -1e-9)
    order = np.argsort(-gathered.points[on_axis, -1])
    return -gathered.points[on_axis, -1][order], gathered.values[on_axis, component][order]


def surface_profiles(made, u, limit):
    """Per surface: x, height and vertical displacement of its nodes near the contact, sorted; on rank 0."""
    V, out = u.function_space, []
    for name in ("slave_surface", "master_surface"):
        marker = fem.Function(V)
        facets = made.facet_tags.find(made.tags[name])
        marker.x.array[V.dofmap.bs * fem.locate_dofs_topological(V, made.mesh.topology.dim - 1, facets)] = 1.0
        marker.x.scatter_forward()
        mark, field = gather_field(marker), gather_field(u)
        if comm.rank == 0:
            x = field.points
            near = (mark.values[:, 0] > 0) & (np.abs(x[:, 0]) < limit) & (x[:, -1] < limit)
            profile = np.column_stack([x[near, 0], x[near, -1], field.values[near, -1]])
            out.append(profile[np.argsort(profile[:, 0])])
    return out


gathered = {key: gather_field(flat[key]) for key in ("u", "mises", "shear")}
profiles = surface_profiles(plane, flat["u"], 3 * a)
measured, run_lines = None, None
if comm.rank == 0:
    depth, tau = axis_profile(gathered["shear"], 0)
    tau_hertz = p0 * (depth / a - (depth / a) ** 2 / np.sqrt(1 + (depth / a) ** 2))
    wheel, rail = profiles
    x = wheel[:, 0]
    gap = wheel[:, 1] + wheel[:, 2] - np.interp(x, rail[:, 0], rail[:, 1] + rail[:, 2])
    inside = np.abs(x) < 0.8 * a
    measured = {"tau": tau.max() / p0, "depth": depth[tau.argmax()] / a, "approach": gap[inside].mean()}
    measured["misfit"] = np.ptp(gap[inside]) / (a**2 / (2 * radius))
    run_lines = {"depth": depth, "tau": tau, "tau_hertz": tau_hertz, "x": x, "gap": gap - measured["approach"]}
measured = comm.bcast(measured, root=0)

# ## In space
#
# A quarter of wheel and rail in hexahedra of degree 1, three cells along the half axis. That is enough to compare the
# solvers and to check equilibrium; it is too coarse to resolve the stress below the patch, and no such claim is made.

size = {"a": ax, "coarse": 0.1, "rail_length": 0.3, "wheel_width": 0.05}
if fast:
    size = {"a": 9e-3, "h": 4.5e-3, "coarse": 0.08}
run.print("3D: meshing and solving")
space = meshes.make("wheel_on_rail_3d", comm, radius=radius, crown_radius=crown, symmetry="quarter", **size)
steel_3d = di.LinearElastic(E=E, nu=nu, density=7800.0)
solid = compare(space, steel_3d, 1, ellipse_force)
solid["mises"] = vertex_average(steel_3d.von_mises(solid["u"]), space.mesh, "von_mises")
run.fields("wheel_on_rail_3d", [solid["u"], solid["mises"]])
gathered_3d = {key: gather_field(solid[key]) for key in ("u", "mises")}

# ## Report

run.print(f"\n{'':34s}{'plane strain':>16s}{'3D, a quarter':>16s}")


def line(text, key, style):
    """One row of the summary for both cases; `key` is a name, or a function of the case."""
    values = [key(case) if callable(key) else case[key] for case in (flat, solid)]
    run.print(f"  {text:32s}" + "".join(f"{format(v, style):>16s}" for v in values))


applied = {"plane": line_load, "space": load / 4}
for case, total in ((flat, applied["plane"]), (solid, applied["space"])):
    case["balance"] = max(abs(case["totals"]["hub"] + total), abs(case["totals"]["bottom"] - total)) / total
line("cells", "cells", "d")
line("unknowns", "unknowns", "d")
line("largest displacement [um]", lambda c: comm.allreduce(np.abs(c["u"].x.array).max(), MPI.MAX) * 1e6, ".3f")
line("two solvers: displacement [1]", "displacement", ".1e")
line("two solvers: nodal forces [1]", "forces", ".1e")
line("reactions against the load [1]", "balance", ".1e")
line("DOLFINx side [s]", lambda c: c["seconds"][0], ".1f")
line("hand-written side [s]", lambda c: c["seconds"][1], ".1f")
run.print(
    f"""
Hertz below the patch (plane strain, {a / cell_size:.0f} cells per half-width)
  largest shear stress / p0         {measured["tau"]:.4f}   theory 0.3003 in a half-plane; rail 38 a deep: + 0.008
  its depth / a                     {measured["depth"]:.3f}    theory 0.786 (vertices in steps of {cell_size / a:.3f})
  misfit of the deformed surfaces   {measured["misfit"]:.4f}   of a^2/2R, inside 0.8 a; theory 0
"""
)

# Fields are in the folder for ParaView; figures and the curves' numbers too.

run.print("drawing")
run.pictures(figures.plane, run, gathered, a, p0, measured["approach"])
run.pictures(figures.lines, run, flat, solid, run_lines, a, p0, radius)
run.pictures(figures.space, run, gathered_3d, p0_ellipse)
axis = {"depth": "m", "tau": "Pa", "tau_hertz": "Pa"}
run.table("axis", {key: (run_lines[key], unit) for key, unit in axis.items()} if comm.rank == 0 else {})
run.print(f"results in {run.path}, {time.perf_counter() - started:.1f} s in all on {comm.size} rank(s)")

# ## What must hold
#
# The numbers of the theory (half-width and peak pressures were computed beforehand, by another program), the agreement
# of the two solvers, equilibrium, and the two consequences above as far as the mesh resolves them.

assert abs(a - 4.538523e-3) < 1e-9 and abs(p0 - 561.081e6) < 1e3
assert abs(p0_ellipse - 1137.880e6) < 2e3
assert max(flat["displacement"], solid["displacement"], flat["forces"], solid["forces"]) < 1e-9
assert max(flat["balance"], solid["balance"]) < 1e-9
assert measured["misfit"] < (0.1 if fast else 0.03)
assert abs(measured["depth"] - 0.786) < 1.5 * cell_size / a
assert abs(measured["tau"] - 0.30028) < (0.02 if fast else 0.01)
# SPDX-License-Identifier: MIT
