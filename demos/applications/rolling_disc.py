# # A rolling disc on a mesh that stands still
#
# A wheel that rolls steadily is a body whose material flows through its shape. In the ALE description the mesh stands
# still and the material moves through it with $w = \Omega \times (X - X_0)$. Its inertia then appears in statics as a
# matrix $W$ and a load,
#
# $$ (K - W)\, u = \int \rho A^T w\, dV, \quad W = \int \rho A^T A\, dV, \quad A = \mathrm{Grad} N \cdot w, $$
#
# equations (3.54) and (3.57) of the theory. This demo takes them from `dolfinx_impact.forms.ale`, puts them into a
# residual of its own, and compares with the exact solution of a spinning disc in plane stress. Without $W$ that is the
# classical rotating disc, $u(R) = (1 - \nu) \rho \Omega^2 R^3 / 4E$; with $W$ the load acts on the *deformed* radius
# $r + u$ and the solution is a Bessel function, $u = C J_1(k r) - r$ with $k^2 = \rho \Omega^2 (1 - \nu^2) / E$.

import os

import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem
from scipy.special import j1, jvp

import dolfinx_impact as di
from dolfinx_impact.io import plots
from dolfinx_impact.forms import ale, elasticity, quadrature
from dolfinx_impact.io.gather import gather_field, together
from dolfinx_impact.io.run_folder import RunFolder, vertex_average

comm = MPI.COMM_WORLD
fast = os.environ.get("IMPACT_DEMO_FAST") == "1"
R, E, nu, density = 0.46, 207e9, 0.3, 7800.0  # radius of the wheel [m], steel
spins = (72.4638, 2000.0) if fast else (72.4638, 500.0, 1000.0, 1500.0, 2000.0)  # [rad/s]; the first is 120 km/h
size = R / (6 if fast else 12)
parameters = {"R": R, "E": E, "nu": nu, "density": density, "spins": spins, "h": size}
run = RunFolder(name="rolling_disc", parameters=parameters)

# ## The disc
#
# Curved triangles of degree 2 for the geometry and for the displacement. $W$ is right only where no material crosses
# the boundary, $w \cdot N = 0$: the boundary has to be as round as the mesh allows.


def disc_mesh():
    """gmsh model of a disc with a node at its centre; on rank 0."""
    import gmsh

    gmsh.initialize(interruptible=False)
    gmsh.option.setNumber("General.Terminal", 0)
    disc = gmsh.model.occ.addDisk(0, 0, 0, R, R)
    centre = gmsh.model.occ.addPoint(0, 0, 0)
    gmsh.model.occ.synchronize()
    gmsh.model.mesh.embed(0, [centre], 2, disc)
    gmsh.model.addPhysicalGroup(2, [disc], 1)
    gmsh.option.setNumber("Mesh.MeshSizeMin", size)
    gmsh.option.setNumber("Mesh.MeshSizeMax", size)
    gmsh.model.mesh.generate(2)
    gmsh.model.mesh.setOrder(2)


together(comm, disc_mesh)
model = None
if comm.rank == 0:
    import gmsh

    model = gmsh.model
disc = di.model_to_mesh(model, comm, gdim=2).mesh
if comm.rank == 0:
    gmsh.finalize()

# ## The residual

V = fem.functionspace(disc, ("Lagrange", 2, (2,)))
u, v = fem.Function(V, name="displacement"), ufl.TestFunction(V)
steel = di.LinearElastic(E=E, nu=nu, density=density, hypothesis="plane_stress")
spin = fem.Constant(disc, 0.0)
with_W = fem.Constant(disc, 0.0)  # 0 switches the matrix off
w = ale.convection(disc, spin, (0.0, 0.0))
dx = ufl.dx(domain=disc, metadata=quadrature.metadata(quadrature.mass_degree("triangle", 2, 2)))
residual = (
    elasticity.internal_force(u, v, steel.law(disc), dx)
    - with_W * ale.ale_inertia(u, v, density, w, dx)
    - ale.centrifugal_load(v, density, w, dx)
)

# Nothing holds a free disc; the load is in equilibrium with itself. The centre is held, and one point of the rim may
# move radially only: three supports in all, none of which carries anything.

middle = fem.locate_dofs_geometrical(V, lambda x: np.hypot(x[0], x[1]) < 1e-9)
rim_point = fem.locate_dofs_geometrical((V.sub(1), V.sub(1).collapse()[0]), lambda x: np.hypot(x[0] - R, x[1]) < 1e-9)
free = fem.Function(V.sub(1).collapse()[0])
bcs = [fem.dirichletbc(np.zeros(2), middle, V), fem.dirichletbc(free, rim_point, V.sub(1))]
problem = di.StaticProblem(u, residual=residual, bcs=bcs)


def rim_displacement():
    """Radial displacement of the rim: mean over the nodes on it, and their spread [m]."""
    field = gather_field(u)
    if comm.rank > 0:
        return comm.bcast(None)
    r = np.linalg.norm(field.points, axis=1)
    rim = np.abs(r - R) < 1e-9
    radial = (field.values[rim] * field.points[rim]).sum(axis=1) / r[rim]
    return comm.bcast((radial.mean(), np.ptp(radial)))


def exact(r, spin, with_W):
    """Radial displacement of the exact solutions at the radius r [m]."""
    if not with_W:
        c = density * spin**2 * (1 - nu**2) / (8 * E)
        return c * r * ((3 + nu) / (1 + nu) * R**2 - r**2)
    k = spin * np.sqrt(density * (1 - nu**2) / E)
    C = (1 + nu) / (k * jvp(1, k * R) + nu * j1(k * R) / R)
    return C * j1(k * r) - r


# ## Spinning up

run.print(f"{'spin':>10s} {'W':>4s} {'u(R) [um]':>12s} {'exact [um]':>12s} {'error':>9s} {'unround':>9s}")
rows = []
for omega in spins:
    for on in (0.0, 1.0):
        spin.value, with_W.value = omega, on
        problem.solve()
        mean, spread = rim_displacement()
        theory = exact(R, omega, on)
        rows.append((omega, on, mean, theory, spread))
        error, unround = mean / theory - 1, spread / theory
        numbers = f"{mean * 1e6:12.6f} {theory * 1e6:12.6f} {error:9.1e} {unround:9.1e}"
        run.print(f"{omega:10.4f} {'on' if on else 'off':>4s} {numbers}")
rows = np.array(rows)
mises = vertex_average(steel.von_mises(u), disc, "von_mises")
run.fields("rolling_disc", [u, mises])
run.table(
    "rim",
    {"spin": (rows[:, 0], "rad/s"), "with_W": (rows[:, 1], "1"), "u": (rows[:, 2], "m"), "exact": (rows[:, 3], "m")},
)

# ## Picture

fields = gather_field(u), gather_field(mises)


def draw():
    """Called on rank 0."""
    plt = plots.pyplot()
    figure, (left, right) = plt.subplots(1, 2, figsize=(10.5, 4.4), layout="constrained")
    grid = plots.deformed_grid(fields[1], fields[0], scale=30, factor=1e-6)
    clim = (0.0, float(np.ceil(grid.point_data["value"].max() / 100) * 100))
    box = (-0.56, 0.56, -0.56, 0.56)
    title = f"spin {spins[-1]:.0f} rad/s, displacement × 30"
    plots.show_grids(figure, left, [grid], clim, "von Mises stress [MPa]", title, box=box, size=(720, 720))
    omega = np.linspace(20.0, 2000.0, 200)
    for on, colour, label in zip((0.0, 1.0), plots.COLOURS, ("without W", "with W: load on the deformed disc")):
        curve = [exact(R, s, on) / (s**2) for s in omega]
        right.plot(omega, np.array(curve) * 1e12, color=colour, label=f"exact, {label}")
        mine = rows[rows[:, 1] == on]
        right.plot(
            mine[:, 0], mine[:, 2] / mine[:, 0] ** 2 * 1e12, "o", mfc="none", color=colour, label="finite elements"
        )
    right.set(xlabel="spin [rad/s]", ylabel="u(R) / spin² [µm / (10³ rad/s)²]")
    right.set_title("radial displacement of the rim", fontsize=10)
    right.legend(fontsize=9)
    plots.save(figure, run.file("rolling_disc.png"))


run.pictures(draw)
run.print(f"results in {run.path}")

# ## What must hold
#
# Two numbers computed beforehand for 2000 rad/s, 2567.413 um without and 2584.969 um with $W$, within the accuracy of
# the mesh, which is far better than what tells them apart.

accuracy = 2e-4 if fast else 1e-5
assert abs(exact(R, 2000.0, False) - 2567.413e-6) < 1e-9 and abs(exact(R, 2000.0, True) - 2584.969e-6) < 1e-9
assert np.abs(rows[:, 2] / rows[:, 3] - 1).max() < accuracy
assert np.abs(rows[-2:, 2] / [2567.413e-6, 2584.969e-6] - 1).max() < accuracy
# SPDX-License-Identifier: MIT
