# # Two materials in one form: a wave at an interface
#
# A pulse of pressure runs along a bar of aluminium that is welded to one of steel. The form has a term for each
# material, on the cells with its tag; the density is a function with a value for each cell. With the impedances
# $Z = \sqrt{E \rho}$ a stress $\sigma$ that meets the interface from the first bar gives
#
# $$ \sigma_\mathrm{through} = \frac{2 Z_2}{Z_1 + Z_2}\, \sigma, \qquad
#    \sigma_\mathrm{back} = \frac{Z_2 - Z_1}{Z_1 + Z_2}\, \sigma. $$

import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## Mesh, tags, and a density for each cell

L, H, cells = 1.0, 0.02, 400  # length of each bar and its height [m], cells along each
E, rho = {1: 70e9, 2: 210e9}, {1: 2700.0, 2: 7800.0}  # aluminium and steel [Pa], [kg/m^3]
c = {tag: np.sqrt(E[tag] / rho[tag]) for tag in E}
Z = {tag: np.sqrt(E[tag] * rho[tag]) for tag in E}
comm = MPI.COMM_WORLD
bars = mesh.create_rectangle(comm, [(-L, 0.0), (L, H)], [2 * cells, 2], mesh.CellType.quadrilateral)
W = fem.functionspace(bars, ("DG", 0))
density, tags = fem.Function(W), np.ones(len(W.dofmap.list), dtype=np.int32)
tags[mesh.locate_entities(bars, 2, lambda x: x[0] > -1e-9)] = 2
cell_tags = mesh.meshtags(bars, 2, np.arange(len(tags), dtype=np.int32), tags)
density.x.array[:] = np.where(tags == 2, rho[2], rho[1])

# ## The form: a term for each tag. Without contraction across the bar its waves are those of a rod.

V = fem.functionspace(bars, ("Lagrange", 1, (2,)))
u, velocity, v = fem.Function(V, name="displacement"), fem.Function(V, name="velocity"), ufl.TestFunction(V)
dx = ufl.Measure("dx", domain=bars, subdomain_data=cell_tags, metadata={"quadrature_degree": 2})
strain = ufl.sym(ufl.grad(u))
residual = sum(fem.Constant(bars, E[tag]) * ufl.inner(strain, ufl.sym(ufl.grad(v))) * dx(tag) for tag in E)

# ## The pulse
#
# A wave to the right has the velocity $-c$ times the strain. The pulse is a Gaussian bell of pressure; its integral is
# the displacement.

middle, width, pressure = -0.5, 0.05, 100e6  # place and width of the pulse [m], its pressure [Pa]


def bell(x):
    return np.exp(-(((x - middle) / width) ** 2))


grid = np.linspace(-L, L, 40_001)
slope = -pressure / E[1] * bell(grid)
moved = np.concatenate([[0.0], np.cumsum(0.5 * (slope[1:] + slope[:-1]) * np.diff(grid))])
u.interpolate(lambda x: np.array([np.interp(x[0], grid, moved) - moved[-1], 0.0 * x[0]]))
velocity.interpolate(lambda x: np.array([c[1] * pressure / E[1] * bell(x[0]), 0.0 * x[0]]))

# ## Run until the pulse has split; stress of each cell

problem = di.ExplicitProblem(u, residual=residual, density=density, velocity=velocity)
time = (0.3 - middle) / c[1]
problem.advance(time, progress=False)
modulus, stress = fem.Function(W), fem.Function(W)
modulus.x.array[:] = np.where(tags == 2, E[2], E[1])
stress.interpolate(fem.Expression(modulus * strain[0, 0], W.element.basix_element.points))
owned = bars.topology.index_map(2).size_local
centres = mesh.compute_midpoints(bars, 2, np.arange(owned, dtype=np.int32))[:, 0]
parts = comm.allgather((centres, stress.x.array[:owned]))
x, found = (np.concatenate(part) for part in zip(*parts))
x, found = x[np.argsort(x, kind="stable")], found[np.argsort(x, kind="stable")]

# ## Closed form and picture

through, back = 2 * Z[2] / (Z[1] + Z[2]), (Z[2] - Z[1]) / (Z[1] + Z[2])
behind, ahead = bell(x - c[1] * time) + back * bell(-x - c[1] * time), through * bell(c[1] / c[2] * x - c[1] * time)
exact = -pressure * np.where(x < 0, behind, ahead)
error = np.max(np.abs(found - exact)) / pressure
energy = problem.energy
if comm.rank == 0:
    print(f"stress that goes through: {found[x > 0].min() / -pressure:.4f} of the pulse, exact {through:.4f}")
    print(f"stress that comes back:   {found[x < 0].min() / -pressure:.4f} of the pulse, exact {back:.4f}")
    print(f"largest difference {100 * error:.2f} % of the pulse; {problem.step} steps, drift {energy['drift']:.1e}")
    figure, axes = plt.subplots(figsize=(8, 3.2), layout="constrained")
    axes.axvspan(0, L, color="0.93", zorder=0)
    axes.plot(grid, -pressure * bell(grid) / 1e6, "0.6", label="pulse at the start")
    axes.plot(x, exact / 1e6, "C0", lw=3, alpha=0.4, label="closed form")
    axes.plot(x, found / 1e6, "C3", lw=1, label="explicit problem")
    axes.text(-0.97, -140, "aluminium")
    axes.text(0.97, -140, "steel", ha="right")
    axes.set(xlabel="x [m]", ylabel="stress [MPa]", xlim=(-L, L))
    axes.legend(loc="lower right", bbox_to_anchor=(1.0, 0.12))
    figure.savefig("two_materials.png", dpi=120)

# ## What must hold
#
# Twenty cells carry the width of the pulse, so that it is late by less than a hundredth of its width. No force acts on
# the bars: their energy stays.

assert error < 0.02 and abs(energy["drift"]) < 1e-3
# SPDX-License-Identifier: MIT
