# SPDX-License-Identifier: MIT
"""Forms a user might write, on symbolic meshes: what the catalogue does not exercise."""

import basix.ufl
import numpy as np
import ufl

from dolfinx_impact import compat


def mesh_of(cell, degree=1):
    dim = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}[cell]
    return ufl.Mesh(basix.ufl.element("Lagrange", cell, degree, shape=(dim,)))


def space(mesh, family="Lagrange", degree=1, shape=()):
    return ufl.FunctionSpace(mesh, basix.ufl.element(family, compat.cell_name(mesh), degree, shape=shape))


def functions(cell):
    """Every function of one or two variables, of fields that lie between 1/2 and 3/2."""
    mesh = mesh_of(cell)
    V = space(mesh)
    f, g, v = ufl.Coefficient(V), ufl.Coefficient(V), ufl.TestFunction(V)
    c = ufl.Constant(mesh)
    terms = [ufl.sqrt(f), ufl.ln(f), ufl.exp(g), ufl.sin(f), ufl.cos(f * g), ufl.tan(f / 3), ufl.atan2(f, g)]
    terms += [ufl.asin(f / 2), ufl.acos(g / 2), ufl.atan(f), ufl.sinh(f), ufl.cosh(g), ufl.tanh(f), ufl.erf(f)]
    terms += [f**1.5, f**-2, f**-0.5, f**0.3, f**c, 2.0**g, c**g, f**g, ufl.sqrt(c) * f, ufl.exp(c)]
    return sum((k + 1) * t for k, t in enumerate(terms)) * v * ufl.dx(metadata={"quadrature_degree": 3})


def decisions(cell):
    """Conditionals, minima, absolute values and signs, on values, literals and constants alike."""
    mesh = mesh_of(cell)
    V = space(mesh)
    f, g, v = ufl.Coefficient(V), ufl.Coefficient(V), ufl.TestFunction(V)
    c = ufl.Constant(mesh)
    a = f - 1  # of both signs
    between = ufl.And(ufl.gt(a, -0.2), ufl.lt(a, 0.3))
    terms = [ufl.max_value(f, g), ufl.min_value(f, g), ufl.max_value(a, 0), ufl.min_value(c, f), abs(a), ufl.sign(a)]
    terms += [ufl.conditional(between, f * g, -g), ufl.conditional(ufl.Or(ufl.le(a, 0), ufl.ge(g, 1.2)), 1.0, f)]
    terms += [ufl.conditional(ufl.Not(ufl.gt(f, g)), 2.0, 3.0), ufl.conditional(ufl.lt(c, 1), f, g)]
    terms += [ufl.conditional(ufl.gt(f, 1), ufl.conditional(ufl.gt(g, 1), 1.0, c), f), ufl.max_value(c, 1.1)]
    terms += [ufl.conditional(ufl.And(ufl.lt(c, 1), ufl.gt(f, 1)), f, 7.0), ufl.conditional(ufl.ne(c, 0), 1.0, g)]
    return sum((k + 1) * t for k, t in enumerate(terms)) * v * ufl.dx(metadata={"quadrature_degree": 3})


def several_rules(cell):
    """Rules of several degrees, one of one point and one of several, over cells and facets, with one shared field.

    In parts: FFCx 0.9, given a rule of one point and another one, takes the Jacobian (and values) of the first for
    both.
    """
    mesh = mesh_of(cell)
    V = space(mesh, degree=2)
    f, v = ufl.Coefficient(V), ufl.TestFunction(V)
    rules = [ufl.dx(metadata={"quadrature_degree": d}) for d in (0, 2, 5)]
    facets = [ufl.ds(metadata={"quadrature_degree": d}) for d in (1, 4)]
    volume = f**2 * v * rules[0], ufl.inner(ufl.grad(f), ufl.grad(v)) * rules[1] + f * v * rules[2]
    return *volume, ufl.exp(f) * v * facets[0], f**3 * v * facets[1]


def one_point_rules(cell):
    """Two rules of one point each, at different places."""
    mesh = mesh_of(cell)
    V = space(mesh)
    f, v = ufl.Coefficient(V), ufl.TestFunction(V)
    dim = compat.geometric_dimension(mesh)

    def at(x):
        data = {
            "quadrature_rule": "custom",
            "quadrature_points": np.full((1, dim), x),
            "quadrature_weights": np.array([0.3]),
        }
        return ufl.dx(metadata=data)

    return ufl.exp(f) * v * at(0.2), f**2 * ufl.grad(v)[0] * at(0.25)


def rule_at_the_vertices(cell):
    """The table of a linear element at the vertices is the identity: for coordinates as well as for coefficients."""
    mesh = mesh_of(cell)
    V = space(mesh)
    f, v = ufl.Coefficient(V), ufl.TestFunction(V)
    x = ufl.SpatialCoordinate(mesh)
    return (2 + x[0]) * f * v * ufl.dx(metadata={"quadrature_rule": "vertex", "quadrature_degree": 1})


def coefficients_of_all_kinds(cell):
    """Values at nodes of two degrees, per cell (scalar and vector), and at the points of the rule."""
    mesh = mesh_of(cell)
    dim = compat.geometric_dimension(mesh)
    V = space(mesh, degree=2, shape=(dim,))
    u, v = ufl.Coefficient(V), ufl.TestFunction(V)
    p = ufl.Coefficient(space(mesh, degree=1))
    d, b = ufl.Coefficient(space(mesh, "DG", 0)), ufl.Coefficient(space(mesh, "DG", 0, (dim,)))
    j = ufl.Coefficient(space(mesh, "DG", 1))
    q = ufl.Coefficient(ufl.FunctionSpace(mesh, basix.ufl.quadrature_element(cell, degree=3)))
    s = ufl.Coefficient(ufl.FunctionSpace(mesh, basix.ufl.quadrature_element(cell, (3,), degree=3)))
    form = (
        d * q * ufl.inner(ufl.grad(u), ufl.grad(v)) + p * ufl.inner(b, v) + (s[0] * s[2] - s[1]) * j * ufl.inner(u, v)
    )
    return form * ufl.dx(metadata={"quadrature_degree": 3})


def facet_geometry(cell):
    """Normals, coordinates and coefficients on facets, against values and gradients of the test function."""
    mesh = mesh_of(cell, 2)
    dim = compat.geometric_dimension(mesh)
    V = space(mesh, degree=2, shape=(dim,))
    u, v = ufl.Coefficient(V), ufl.TestFunction(V)
    n, x = ufl.FacetNormal(mesh), ufl.SpatialCoordinate(mesh)
    d = ufl.Coefficient(space(mesh, "DG", 0))
    form = d * ufl.inner(ufl.grad(u) * n, v) - ufl.dot(x, n) * ufl.inner(u, ufl.grad(v) * n)
    return form * ufl.ds(metadata={"quadrature_degree": 4})


def facet_matrix(cell):
    """Matrix over facets (Nitsche's consistency terms)."""
    mesh = mesh_of(cell)
    dim = compat.geometric_dimension(mesh)
    V = space(mesh, degree=2, shape=(dim,))
    u, v, n = ufl.TrialFunction(V), ufl.TestFunction(V), ufl.FacetNormal(mesh)
    k = ufl.Coefficient(space(mesh))
    return (k * ufl.inner(u, v) - ufl.inner(ufl.grad(u) * n, v)) * ufl.ds(metadata={"quadrature_degree": 3})


def energy_of_two_rules(cell):
    """Rank 0 over cells and facets; value, norm and geometry."""
    mesh = mesh_of(cell, 2)
    f, x = ufl.Coefficient(space(mesh, degree=2)), ufl.SpatialCoordinate(mesh)
    volume = ufl.sqrt(1 + ufl.inner(ufl.grad(f), ufl.grad(f))) * ufl.dx(metadata={"quadrature_degree": 4})
    middle = f**2 * ufl.dx(metadata={"quadrature_degree": 0})
    return volume, middle, x[0] ** 2 * f * ufl.ds(metadata={"quadrature_degree": 3})


def energy_of_one_point(cell):
    """Rank 0 with one point and piecewise constant integrand."""
    mesh = mesh_of(cell)
    f, c = ufl.Coefficient(space(mesh, "DG", 0)), ufl.Constant(mesh)
    return (c * f + 2.0) * ufl.dx(metadata={"quadrature_degree": 0})


def degree_three(cell):
    """Elements and geometry that the catalogue does not hold."""
    mesh = mesh_of(cell)
    V = space(mesh, degree=3)
    f, v = ufl.Coefficient(V), ufl.TestFunction(V)
    return (ufl.inner(ufl.grad(f), ufl.grad(v)) + f**2 * v) * ufl.dx(metadata={"quadrature_degree": 4})


def rectangular(cell):
    """A matrix whose test and trial spaces differ in degree and shape."""
    mesh = mesh_of(cell)
    V, Q = space(mesh, degree=2, shape=(compat.geometric_dimension(mesh),)), space(mesh)
    u, q = ufl.TrialFunction(V), ufl.TestFunction(Q)
    return q * ufl.div(u) * ufl.dx(metadata={"quadrature_degree": 3})


def second_derivatives(cell):
    """Second derivatives of a field, mapped on affine cells."""
    mesh = mesh_of(cell)
    V = space(mesh, degree=2)
    f, v = ufl.Coefficient(V), ufl.TestFunction(V)
    return ufl.div(ufl.grad(f)) * v * ufl.dx(metadata={"quadrature_degree": 2})


def tensor_valued(cell):
    """A symmetric tensor space, and indices, determinants and inverses of tensors."""
    mesh = mesh_of(cell)
    dim = compat.geometric_dimension(mesh)
    T = space(mesh, "DG", 1, (dim, dim))
    s, t = ufl.Coefficient(T), ufl.TestFunction(T)
    F = 3 * ufl.Identity(dim) + s
    return ufl.inner(ufl.inv(F) * ufl.det(F) + ufl.dev(s), t) * ufl.dx(metadata={"quadrature_degree": 2})


def taylor_hood(cell):
    """A mixed element."""
    mesh = mesh_of(cell)
    dim = compat.geometric_dimension(mesh)
    P2, P1 = basix.ufl.element("Lagrange", cell, 2, shape=(dim,)), basix.ufl.element("Lagrange", cell, 1)
    W = ufl.FunctionSpace(mesh, basix.ufl.mixed_element([P2, P1]))
    w = ufl.Coefficient(W)
    (u, p), (v, q) = ufl.split(w), ufl.TestFunctions(W)
    form = ufl.inner(ufl.grad(u), ufl.grad(v)) - p * ufl.div(v) - q * ufl.div(u) + p * q
    return form * ufl.dx(metadata={"quadrature_degree": 3})


def powers(cell):
    """Powers that share roots, powers of scaled and of negative values, and large ones."""
    mesh = mesh_of(cell)
    V = space(mesh)
    f, g, v = ufl.Coefficient(V), ufl.Coefficient(V), ufl.TestFunction(V)
    exponents = [1 / 3, -1 / 3, -2 / 3, -5 / 3, 7 / 3, 0.25, -0.75, 1 / 6, -5 / 6, 1.7, -0.3, -1.3]
    exponents += [5, -4, 7, 20, 21, 18.5]
    terms = [f**p for p in exponents] + [(2 * f) ** (-2 / 3), (f * g) ** 0.4, (-f) ** 3, (g - 3) ** 18, (f - 4) ** 19]
    return sum((k + 1) * t for k, t in enumerate(terms)) * v * ufl.dx(metadata={"quadrature_degree": 3})


def derivative_of_energies(cell):
    """Derivative of energies of invariants, with fibres that bear tension only, beside a load in the same integral."""
    mesh = mesh_of(cell)
    dim = compat.geometric_dimension(mesh)
    V = space(mesh, shape=(dim,))
    u, v, c = ufl.Coefficient(V), ufl.TestFunction(V), ufl.Constant(mesh)
    dx = ufl.dx(metadata={"quadrature_degree": 2})
    F = 9 * ufl.Identity(dim) + ufl.grad(u)
    C, J = F.T * F, ufl.det(F)
    first, second = J ** (-2 / 3) * ufl.tr(C), J ** (-4 / 3) * (ufl.tr(C) ** 2 - ufl.tr(C * C)) / 2
    energy = c * first + 0.3 * second + ufl.ln(J) ** 2 + 0.1 * ufl.exp(first / 9) + J**c
    for k in range(dim):
        stretch = F[k, 0] ** 2 / 81 - 1
        # Where a fibre is compressed, the logarithm is of a negative number.
        energy += ufl.conditional(ufl.gt(stretch, 0), ufl.ln(stretch), 0) * stretch**3
        energy += ufl.conditional(ufl.le(stretch, 0), 0, ufl.exp(stretch) - 1)
    return ufl.derivative(energy * dx, u, v) - ufl.dot(u, v) * dx


def sizes_of_cells(cell):
    """Lengths of edges, diameter, of simplices radius and volume; on facets edges of facets and areas."""
    mesh = mesh_of(cell)
    dim = compat.geometric_dimension(mesh)
    V = space(mesh)
    f, v = ufl.Coefficient(V), ufl.TestFunction(V)
    h = ufl.CellDiameter(mesh) + 2 * ufl.MinCellEdgeLength(mesh) * ufl.MaxCellEdgeLength(mesh)
    on_facets = ufl.CellDiameter(mesh)
    if dim == 3:
        on_facets = on_facets / ufl.MinFacetEdgeLength(mesh) + ufl.MaxFacetEdgeLength(mesh)
    if cell in ("triangle", "tetrahedron"):
        h = h * ufl.Circumradius(mesh) + ufl.CellVolume(mesh)
        on_facets = on_facets * ufl.Circumradius(mesh) + ufl.FacetArea(mesh) / ufl.CellVolume(mesh)
    rule = {"quadrature_degree": 2}
    return h * f * v * ufl.dx(metadata=rule), on_facets * f * v * ufl.ds(metadata=rule)


FORMS = (
    functions, decisions, several_rules, one_point_rules, rule_at_the_vertices, coefficients_of_all_kinds,
    facet_geometry, facet_matrix, energy_of_two_rules, energy_of_one_point, degree_three, rectangular,
    second_derivatives, tensor_valued, taylor_hood, powers, derivative_of_energies, sizes_of_cells,
)  # fmt: skip
