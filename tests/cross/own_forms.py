# SPDX-License-Identifier: MIT
"""Forms without a hand-written counterpart, right ones of several kinds and one with many ways to be wrong."""

import basix.ufl
import ufl
from dolfinx import fem

import dolfinx_impact as di
from impact_verify import OwnForm


def displacement(mesh, degree=1):
    """Displacement and test function."""
    V = fem.functionspace(mesh, ("Lagrange", degree, (mesh.geometry.dim,)))
    return fem.Function(V, name="u"), ufl.TestFunction(V)


def strain(u):
    return ufl.sym(ufl.grad(u))


def hooke(e, lmbda=1.0, mu=1.0):
    return lmbda * ufl.tr(e) * ufl.Identity(e.ufl_shape[0]) + 2 * mu * e


def mixed(mesh, *fields):
    """Unknown of a mixed space: (degree, number of components or None) of each field."""
    cell = mesh.topology.cell_name()
    elements = [
        basix.ufl.element("Lagrange", cell, degree, shape=None if size is None else (size,)) for degree, size in fields
    ]
    V = fem.functionspace(mesh, basix.ufl.mixed_element(elements))
    w = fem.Function(V, name="w")
    return w, ufl.split(w), ufl.TestFunctions(V)


# --- right ones ------------------------------------------------------------------------------------------------------


def mooney_rivlin(mesh):
    """Plane strain; the energy is given."""
    u, v = displacement(mesh)
    c1, c2, k = (fem.Constant(mesh, value) for value in (0.5, 0.2, 5.0))
    g = ufl.grad(u)
    F = ufl.Identity(3) + ufl.as_tensor([[g[0, 0], g[0, 1], 0], [g[1, 0], g[1, 1], 0], [0, 0, 0]])
    C, J = F.T * F, ufl.det(F)
    first, second = ufl.tr(C), (ufl.tr(C) ** 2 - ufl.tr(C * C)) / 2
    dx = ufl.dx(degree=3)
    energy = (c1 * (J ** (-2 / 3) * first - 3) + c2 * (J ** (-4 / 3) * second - 3) + k / 2 * (J - 1) ** 2) * dx
    return OwnForm(ufl.derivative(energy, u, v), u, energy, parameters={"c1": c1})


def viscoelastic(mesh):
    """A Maxwell element beside a spring; its viscous strain is a function at quadrature points."""
    u, v = displacement(mesh)
    dim = mesh.geometry.dim
    Q = fem.functionspace(mesh, basix.ufl.quadrature_element(mesh.topology.cell_name(), (dim, dim), degree=2))
    viscous = fem.Function(Q, name="viscous_strain")
    stress = hooke(strain(u)) + 0.5 * ufl.dev(strain(u) - viscous)
    return ufl.inner(stress, ufl.grad(v)) * ufl.dx(degree=2), u


def thermoelastic(mesh):
    w, (u, T), (v, q) = mixed(mesh, (1, mesh.geometry.dim), (1, None))
    stress = hooke(strain(u)) - 0.3 * T * ufl.Identity(len(u))
    return (ufl.inner(stress, strain(v)) + ufl.inner(ufl.grad(T), ufl.grad(q))) * ufl.dx(degree=2), w


def cosserat(mesh):
    """Displacement and micro-rotation in the plane."""
    w, (u, phi), (v, psi) = mixed(mesh, (2, 2), (1, None))
    turn = ufl.as_tensor([[0, 1], [-1, 0]])
    a, b = ufl.grad(u) + phi * turn, ufl.grad(v) + psi * turn
    work = ufl.inner(hooke(ufl.sym(a)), ufl.sym(b)) + 0.7 * ufl.inner(ufl.skew(a), ufl.skew(b))
    return OwnForm((work + 0.1 * ufl.inner(ufl.grad(phi), ufl.grad(psi))) * ufl.dx(degree=4), w, rotation=1)


def gradient(mesh):
    """The dilatation acts by its mean over a length: implicit gradient elasticity."""
    w, (u, e), (v, d) = mixed(mesh, (2, mesh.geometry.dim), (1, None))
    coupling = 0.2 * (ufl.tr(strain(u)) - e) * (ufl.tr(strain(v)) - d) + 0.01 * ufl.inner(ufl.grad(e), ufl.grad(d))
    return OwnForm((ufl.inner(hooke(strain(u)), strain(v)) + coupling) * ufl.dx(degree=4), w, conservative=True)


def taylor_hood(mesh):
    """Displacement and pressure, nearly incompressible."""
    w, (u, p), _ = mixed(mesh, (2, mesh.geometry.dim), (1, None))
    F = ufl.Identity(len(u)) + ufl.grad(u)
    J = ufl.det(F)
    energy = (0.5 * (ufl.tr(F.T * F) - len(u) - 2 * ufl.ln(J)) + p * (J - 1) - p**2 / 200) * ufl.dx(degree=4)
    return OwnForm(ufl.derivative(energy, w, ufl.TestFunction(w.function_space)), w, energy, conservative=True)


def ring(mesh):
    u, v = displacement(mesh)
    r = ufl.SpatialCoordinate(mesh)[0]

    def hoops(u):
        e = strain(u)
        return ufl.as_tensor([[e[0, 0], e[0, 1], 0], [e[1, 0], e[1, 1], 0], [0, 0, u[0] / r]])

    residual = ufl.inner(hooke(hoops(u)), hoops(v)) * 2 * ufl.pi * r * ufl.dx(degree=3)
    return OwnForm(residual, u, hypothesis="axisymmetric")


def conduction(mesh):
    """Nonlinear: the conductivity depends on the temperature, so that there is no energy."""
    V = fem.functionspace(mesh, ("Lagrange", 1))
    T, q = fem.Function(V, name="T"), ufl.TestFunction(V)
    return ((1 + T**2) * ufl.inner(ufl.grad(T), ufl.grad(q)) - q) * ufl.dx(degree=4), T


def interior_penalty(mesh, consistent=True):
    """Linear elasticity on discontinuous elements, by the symmetric interior penalty method."""
    V = fem.functionspace(mesh, ("DG", 1, (mesh.geometry.dim,)))
    u, v, n, h = fem.Function(V, name="u"), ufl.TestFunction(V), ufl.FacetNormal(mesh), ufl.CellDiameter(mesh)

    def jump(u):
        return ufl.outer(u("+"), n("+")) + ufl.outer(u("-"), n("-"))

    def stress(u):
        return hooke(strain(u))

    inside = ufl.inner(stress(u), strain(v)) * ufl.dx(degree=2) + 30 / ufl.avg(h) * ufl.inner(jump(u), jump(v)) * ufl.dS
    if consistent:
        inside -= (ufl.inner(ufl.avg(stress(u)), jump(v)) + ufl.inner(ufl.avg(stress(v)), jump(u))) * ufl.dS
    edge = 30 / h * ufl.inner(u, v) - ufl.inner(stress(u) * n, v) - ufl.inner(stress(v) * n, u)
    return OwnForm(inside + edge * ufl.ds, u, grounded=True)


def mixed_conduction(mesh):
    """Flux on Raviart-Thomas elements and temperature, on triangles and quadrilaterals."""
    cell = mesh.topology.cell_name()
    elements = [basix.ufl.element("RT" if cell == "triangle" else "RTCF", cell, 1), basix.ufl.element("DG", cell, 0)]
    w = fem.Function(fem.functionspace(mesh, basix.ufl.mixed_element(elements)), name="w")
    (flux, T), (f, q) = ufl.split(w), ufl.TestFunctions(w.function_space)
    return (ufl.inner(flux, f) + T * ufl.div(f) + q * ufl.div(flux)) * ufl.dx(degree=4), w


plastic = di.J2Plasticity(1000.0, 0.3, 1.0, yield_stress=20.0, hardening=50.0, hypothesis="plane_strain")
RIGHT = (
    mooney_rivlin, viscoelastic, thermoelastic, cosserat, gradient, taylor_hood, ring, conduction, interior_penalty,
    mixed_conduction, plastic,
)  # fmt: skip


# --- wrong ones ------------------------------------------------------------------------------------------------------

DEFECTS = ("sign", "stress_at_rest", "skew", "ground", "not_conservative", "not_objective", "moment", "force")


def neo_hooke(**sizes):
    """Function of a mesh: a neo-Hookean solid with defects of some sizes; all are one compiled form."""

    def neo_hooke_with_defects(mesh):
        u, v = displacement(mesh)
        c = {name: fem.Constant(mesh, float(sizes.get(name, 0.0))) for name in DEFECTS}
        F = ufl.Identity(2) + ufl.grad(u)
        J, C = ufl.det(F), F.T * F
        stress = F - ufl.inv(F).T + ufl.ln(J) * ufl.inv(F).T
        stress *= (1 - c["sign"]) * (1 + c["not_conservative"] * (1 / J - 1))
        stress += c["stress_at_rest"] * F
        stress += c["skew"] * ufl.skew(ufl.grad(u)) + c["not_objective"] * strain(u)
        stress += c["moment"] * (ufl.tr(C) - 2) * F * ufl.as_tensor([[0, 1], [-1, 0]])
        work = ufl.inner(stress, ufl.grad(v)) + c["ground"] * ufl.inner(u, v) + c["force"] * (ufl.tr(C) - 2) * v[0]
        return OwnForm(work * ufl.dx(degree=2), u)

    return neo_hooke_with_defects
