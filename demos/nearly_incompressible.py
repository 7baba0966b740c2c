# # Rubber that locks: displacement alone, mean dilatation, displacement and pressure
#
# A thick ring of rubber is blown up from inside. Poisson's ratio $\nu$ goes towards 1/2, and cells that must keep their
# volume at every point of a full rule can hardly move: they lock. Two other forms do not. One takes the mean dilatation
# of each cell, $\bar\theta$ (B-bar), the other has the pressure $p$ as a second unknown:
#
# $$ \int 2 \mu \left(\varepsilon(u) : \varepsilon(v) - \tfrac13 \mathrm{div}\, u\, \mathrm{div}\, v\right)
#    + K\, \bar\theta(u)\, \bar\theta(v)\, dx, \qquad
#    \int 2 \mu\, \varepsilon(u) : \varepsilon(v) - p\, \mathrm{div}\, v
#    - \left(\mathrm{div}\, u + \frac{p}{\lambda}\right) q\, dx. $$
#
# Lamé's solution in plane strain is exact: $u_r = A r + B / r$.

import basix.ufl
import matplotlib.pyplot as plt
import numpy as np
import ufl
from mpi4py import MPI
from dolfinx import fem, mesh

import dolfinx_impact as di

# ## Mesh: a rectangle of radii and angles, bent to a quarter of the ring. The tag 1 marks the inner side.

a, b, inside, mu = 1.0, 2.0, 0.1e6, 1e6  # radii [m], pressure inside and shear modulus [Pa]
comm = MPI.COMM_WORLD


def ring(cell, n):
    made = mesh.create_rectangle(comm, [(a, 0.0), (b, np.pi / 2)], [n, 2 * n], cell)
    facets = np.sort(mesh.locate_entities_boundary(made, 1, lambda x: np.isclose(x[0], a)))
    tags = mesh.meshtags(made, 1, facets, np.ones(len(facets), dtype=np.int32))
    r, angle = made.geometry.x[:, :2].T.copy()
    made.geometry.x[:, :2] = np.transpose([r * np.cos(angle), r * np.sin(angle)])
    return made, ufl.ds(1, domain=made, subdomain_data=tags, degree=4)


def solved(w, form, V, u, v, ds):
    """Mean radial displacement u of the inner side, with conditions of symmetry on the two cuts; w is the unknown."""
    bcs = []
    for k in range(2):
        dofs = fem.locate_dofs_geometrical((V.sub(k), V.sub(k).collapse()[0]), lambda x, k=k: np.isclose(x[k], 0.0))
        bcs.append(fem.dirichletbc(fem.Function(V.sub(k).collapse()[0]), dofs, V.sub(k)))
    n = ufl.FacetNormal(V.mesh)
    di.StaticProblem(w, residual=form + inside * ufl.dot(n, v) * ds, bcs=bcs).solve()
    total, length = (fem.assemble_scalar(fem.form(f * ds)) for f in (-ufl.dot(u, n), fem.Constant(V.mesh, 1.0)))
    return comm.allreduce(total) / comm.allreduce(length)


# ## Three forms


def of_displacement(nu, n, mean=lambda value: value):
    made, ds = ring(mesh.CellType.quadrilateral, n)
    V = fem.functionspace(made, ("Lagrange", 1, (2,)))
    u, v = fem.Function(V), ufl.TestFunction(V)
    K = fem.Constant(made, 2 * mu * (1 + nu) / (3 * (1 - 2 * nu)))
    shear = ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) - ufl.div(u) * ufl.div(v) / 3
    form = (2 * mu * shear + K * mean(ufl.div(u)) * mean(ufl.div(v))) * ufl.dx(degree=2)
    return solved(u, form, V, u, v, ds)


def of_mean_dilatation(nu, n):
    return of_displacement(nu, n, ufl.cell_avg)


def of_two_fields(nu, n):
    made, ds = ring(mesh.CellType.triangle, n)
    parts = [basix.ufl.element("Lagrange", "triangle", 2, shape=(2,)), basix.ufl.element("Lagrange", "triangle", 1)]
    W = fem.functionspace(made, basix.ufl.mixed_element(parts))
    w, (v, q), softness = fem.Function(W), ufl.TestFunctions(W), fem.Constant(made, (1 - 2 * nu) / (2 * mu * nu))
    u, p = ufl.split(w)
    form = 2 * mu * ufl.inner(ufl.sym(ufl.grad(u)), ufl.sym(ufl.grad(v))) - p * ufl.div(v)
    return solved(w, (form - (ufl.div(u) + softness * p) * q) * ufl.dx(degree=4), W.sub(0), u, v, ds)


# ## Poisson's ratio towards 1/2, on six cells across the ring

forms = {"displacement": of_displacement, "mean dilatation": of_mean_dilatation, "two fields": of_two_fields}
ratios = 0.5 - np.array([0.2, 0.05, 1e-2, 1e-3, 1e-4, 1e-5, 1e-6])
exact = inside * a**2 / (b**2 - a**2) * ((1 - 2 * ratios) * a / (2 * mu) + b**2 / (2 * mu * a))
found = {name: np.array([form(nu, 6) for nu in ratios]) / exact for name, form in forms.items()}
if comm.rank == 0:
    figure, axes = plt.subplots(figsize=(7, 3.2), layout="constrained")
    for (name, values), style in zip(found.items(), ("C3o-", "C0s-", "C2^--")):
        print(f"{name:16s}" + "".join(f"{value:9.4f}" for value in values))
        axes.semilogx(0.5 - ratios, values, style, label=name)
    axes.axhline(1.0, color="0.7", lw=0.8)
    axes.set(xlabel="1/2 - Poisson's ratio", ylabel="displacement / exact one", ylim=(0, 1.1))
    axes.invert_xaxis()
    axes.legend()
    figure.savefig("nearly_incompressible.png", dpi=120)

# ## What must hold: one locks, the others keep the error of their mesh, whatever Poisson's ratio

assert found["displacement"][-1] < 0.01
assert np.all(abs(found["mean dilatation"] - 1) < 0.02) and np.all(abs(found["two fields"] - 1) < 0.02)
# SPDX-License-Identifier: MIT
