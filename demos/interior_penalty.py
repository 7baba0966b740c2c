# # A plate by interior penalties
#
# Kirchhoff's plate needs slopes that are continuous from cell to cell, and Lagrange elements have kinks there. An
# interior penalty takes the kinks for what they are: integrals over the facets between cells, `dS`, with jumps and
# averages of both sides. With curvatures $\kappa = \nabla \nabla w$, moments $M = D ((1 - \nu) \kappa + \nu\,
# \mathrm{tr} \kappa\, I)$ and $[\![\partial_n w]\!]$ for the kink,
#
# $$ \int M(w) : \kappa(v)\, dx - \int_{dS} \{M_{nn}(w)\} [\![\partial_n v]\!] + \{M_{nn}(v)\} [\![\partial_n w]\!]
#    - \frac{\alpha D}{h} [\![\partial_n w]\!] [\![\partial_n v]\!]\, ds = \int q\, v\, dx. $$
#
# On supports that hold the deflection alone, a square plate has Navier's series as its solution.

import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## Plate, and the form

a, h, E, nu, rho, q = 1.0, 0.01, 210e9, 0.3, 7800.0, 1e3  # side, thickness [m], steel, load [Pa]
D, alpha = E * h**3 / (12 * (1 - nu**2)), 8.0  # stiffness [N m], penalty
comm = MPI.COMM_WORLD


def plate(n):
    """Deflection, residual without load, test function and supports, on n by n squares of two triangles."""
    made = mesh.create_rectangle(comm, [(0.0, 0.0), (a, a)], [n, n], ghost_mode=mesh.GhostMode.shared_facet)
    V = fem.functionspace(made, ("Lagrange", 2))
    w, v = fem.Function(V, name="deflection"), ufl.TestFunction(V)
    normal, size = ufl.FacetNormal(made), ufl.CellDiameter(made)
    kappas = [ufl.grad(ufl.grad(f)) for f in (w, v)]
    moments = [D * ((1 - nu) * kappa + nu * ufl.tr(kappa) * ufl.Identity(2)) for kappa in kappas]
    dx, dS = ufl.dx(domain=made, degree=2), ufl.dS(domain=made, degree=3)
    kink, test = ufl.jump(ufl.grad(w), normal), ufl.jump(ufl.grad(v), normal)
    across, back = (ufl.avg(ufl.dot(normal, ufl.dot(moment, normal))) for moment in moments)
    form = ufl.inner(moments[0], kappas[1]) * dx - (across * test + back * kink) * dS
    form += alpha * D / ufl.avg(size) * kink * test * dS
    edge = fem.locate_dofs_geometrical(V, lambda x: np.any(np.isclose(x[:2], 0.0) | np.isclose(x[:2], a), axis=0))
    return w, form, v, [fem.dirichletbc(0.0, edge, V)], dx


# ## Deflection under a load, on finer and finer meshes

m, n = np.meshgrid(np.arange(1, 60, 2), np.arange(1, 60, 2))
series = np.sin(m * np.pi / 2) * np.sin(n * np.pi / 2) / (m * n * (m**2 + n**2) ** 2)
exact = 16 * q * a**4 / (np.pi**6 * D) * series.sum()


def middle(w):
    x = w.function_space.tabulate_dof_coordinates()[: w.function_space.dofmap.index_map.size_local]
    at = np.flatnonzero(np.linalg.norm(x[:, :2] - a / 2, axis=1) < 1e-9)
    return sum(comm.allgather([float(w.x.array[k]) for k in at]), [])[0]


meshes, errors = np.array([4, 8, 16, 32]), []
for n in meshes:
    w, form, v, bcs, dx = plate(n)
    di.StaticProblem(w, residual=form - fem.Constant(w.function_space.mesh, q) * v * dx, bcs=bcs).solve()
    errors.append(abs(middle(w) / exact - 1))

# ## The load goes: the plate swings in its lowest mode

period = a**2 / np.pi * np.sqrt(rho * h / D)
w, form, v, bcs, dx = plate(16)
w.interpolate(lambda x: np.sin(np.pi * x[0] / a) * np.sin(np.pi * x[1] / a))
problem, history = di.ExplicitProblem(w, residual=form, density=rho * h, bcs=bcs), []
problem.advance(2 * period, callback=lambda p: history.append((p.time, middle(w))), progress=False)
times, swing = np.array(history).T
down = np.flatnonzero((swing[:-1] > 0) & (swing[1:] <= 0))
zeros = times[down] + (times[down + 1] - times[down]) * swing[down] / (swing[down] - swing[down + 1])
found = zeros[1] - zeros[0]

# ## Picture and numbers

if comm.rank == 0:
    print(f"deflection of the middle by Navier's series: {1e3 * exact:.4f} mm")
    for count, error in zip(meshes, errors):
        print(f"  {count:2d} cells along each side: differs by {100 * error:.2f} %")
    print(f"period {1e3 * found:.2f} ms; of the lowest mode {1e3 * period:.2f} ms")
    figure, axes = plt.subplots(1, 2, figsize=(9, 3.2), layout="constrained")
    axes[0].loglog(meshes, errors, "C0o-", label="error of the middle")
    axes[0].loglog(meshes, errors[-1] * (meshes[-1] / meshes) ** 2, "0.6", label="order 2")
    axes[0].set(xlabel="cells along each side", ylabel="relative error [1]")
    axes[0].set_xticks(meshes, [str(count) for count in meshes])
    axes[0].set_xticks([], minor=True)
    axes[1].plot(times / period, np.cos(2 * np.pi * times / period), "0.6", lw=4, label="lowest mode")
    axes[1].plot(times / period, swing, "C3", lw=1.2, label="plate of 16 x 16 cells")
    axes[1].set(xlabel="time / period", ylabel="deflection / that of the start [1]", xlim=(0, 2), ylim=(-1.2, 1.9))
    for axis in axes:
        axis.legend(loc="upper right")
    figure.savefig("interior_penalty.png", dpi=120)

# ## What must hold: the order of the method, and a period whose error is half of that of the stiffness

assert errors[-1] < 0.01 and 3.0 < errors[-2] / errors[-1] < 5.0
assert abs(found / period - 1) < 0.02
# SPDX-License-Identifier: MIT
