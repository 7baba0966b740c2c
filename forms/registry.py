# SPDX-License-Identifier: MIT
"""The forms by name, and the one table of what is compiled ahead of time.

`build` gives any form of the catalogue for any cell, degree, geometry degree and hypothesis, with the names of its
coefficients and constants. TABLE lists the rows that are compiled with the package: what the demos and C++ users need.
Everything else takes the run-time route.
"""

from dataclasses import dataclass

import basix.ufl
import ufl

from . import ale, damping, elasticity, galerkin, inertia, loads, quadrature
from .materials import LAWS, check_hypothesis

CELLS = {"triangle": 2, "quadrilateral": 2, "tetrahedron": 3, "hexahedron": 3}
DEGREES = (1, 2)
LAW_FORMS = tuple(f"{law}.{kind}" for law in LAWS for kind in ("force", "tangent", "energy"))
OTHER_FORMS = (
    "mass",
    "mass_action",
    "row_sum",
    "nodal_mass",
    "body_force",
    "traction",
    "follower_pressure",
    "follower_pressure_tangent",
    "rayleigh",
    "gyroscopic",
    "ale_inertia",
    "centrifugal_load",
    "momentum_balance",
    "poisson",
    "poisson_residual",
)
NAMES = LAW_FORMS + OTHER_FORMS


@dataclass
class Built:
    """A form of the catalogue: UFL form, names of its coefficients and constants by object, rule and degree used."""

    form: ufl.Form
    names: dict
    degree: int
    rule: str | None


def default_hypothesis(cell):
    return "3d" if CELLS[cell] == 3 else "plane_strain"


def check(name, cell, degree, geometry_degree, hypothesis):
    """Raise ValueError for what the catalogue does not hold, saying what it holds."""
    if cell not in CELLS:
        raise ValueError(f"cell {cell!r} is unknown: the catalogue holds {', '.join(CELLS)}")
    for what, value in (("degree", degree), ("geometry degree", geometry_degree)):
        if value not in DEGREES:
            raise ValueError(f"{what} {value!r} is not in the catalogue: use 1 or 2, or compile a form of your own")
    if name not in NAMES:
        raise ValueError(f"form {name!r} is unknown: the catalogue holds {', '.join(NAMES)}")
    check_hypothesis(hypothesis, CELLS[cell])
    if hypothesis == "axisymmetric" and name in ("gyroscopic", "ale_inertia", "centrifugal_load", "momentum_balance"):
        raise ValueError(f"{name}: a body that spins about z is not axisymmetric in the (r, z) plane")


def build(name, cell, degree, geometry_degree=1, hypothesis=None, rule=None, quadrature_degree=None):
    """UFL form of the catalogue.

    Args:
        name: one of NAMES. cell: one of CELLS. degree, geometry_degree: 1 or 2.
        hypothesis: one of materials.HYPOTHESES; None: "3d" or "plane_strain".
        rule, quadrature_degree: to override the default rule of forms/quadrature.py.

    Raises:
        ValueError: for anything outside the catalogue.
    """
    hypothesis = hypothesis or (default_hypothesis(cell) if cell in CELLS else None)
    check(name, cell, degree, geometry_degree, hypothesis)
    dim = CELLS[cell]
    mesh = ufl.Mesh(basix.ufl.element("Lagrange", cell, geometry_degree, shape=(dim,)))
    shape = () if name.startswith("poisson") else (dim,)
    V = ufl.FunctionSpace(mesh, basix.ufl.element("Lagrange", cell, degree, shape=shape))
    names = {}

    def constant(label, *value_shape):
        c = ufl.Constant(mesh, shape=value_shape)
        names[c] = label
        return c

    def field(label):
        f = ufl.Coefficient(V)
        names[f] = label
        return f

    arguments = (cell, degree, geometry_degree, hypothesis)
    if name in ("mass", "mass_action", "row_sum", "gyroscopic", "ale_inertia", "centrifugal_load", "momentum_balance"):
        default = quadrature.mass_degree(*arguments)
    elif name == "rayleigh":
        default = quadrature.mass_degree(*arguments)
    elif name == "nodal_mass":
        if cell in quadrature.SIMPLICES:
            raise ValueError("nodal_mass: simplices have no positive rule at the nodes of degree 2; use HRZ lumping")
        default, rule = 2 * degree - 1, "GLL"
    elif name in ("body_force", "poisson_residual"):
        default = quadrature.mass_degree(*arguments)
    elif name in ("traction", "follower_pressure", "follower_pressure_tangent"):
        default = quadrature.facet_degree(*arguments)
        if name != "traction":
            default += (degree - 1) * (dim - 1) + degree - 1
    else:
        default = quadrature.stiffness_degree(*arguments)
    used = default if quadrature_degree is None else quadrature_degree
    dx = ufl.dx(domain=mesh, metadata=quadrature.metadata(used, rule))
    ds = ufl.ds(domain=mesh, metadata=quadrature.metadata(used, rule))
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)

    if name in LAW_FORMS:
        law_name, kind = name.split(".")
        law = LAWS[law_name](constant("E"), constant("nu"), hypothesis)
        if kind == "tangent":
            form = elasticity.tangent(None if law.linear else field("u"), du, v, law, dx)
        else:
            u = field("u")
            if kind == "energy":
                form = elasticity.internal_energy(u, law, dx)
            else:
                form = elasticity.internal_force(u, v, law, dx)
    elif name in ("mass", "mass_action"):
        form = inertia.mass(du if name == "mass" else field("u"), v, constant("density"), hypothesis, dx)
    elif name in ("row_sum", "nodal_mass"):
        form = inertia.row_sum(v, constant("density"), hypothesis, dx)
    elif name == "body_force":
        form = loads.body_force(constant("f", dim), v, hypothesis, dx)
    elif name == "traction":
        form = loads.traction(constant("t", dim), v, hypothesis, ds)
    elif name == "follower_pressure":
        form = loads.follower_pressure(constant("p"), field("u"), v, hypothesis, ds)
    elif name == "follower_pressure_tangent":
        form = loads.follower_pressure_tangent(constant("p"), field("u"), du, v, hypothesis, ds)
    elif name == "rayleigh":
        law = LAWS["linear_elastic"](constant("E"), constant("nu"), hypothesis)
        stiffness = quadrature.stiffness_degree(*arguments) if quadrature_degree is None else quadrature_degree
        stiffness_dx = ufl.dx(domain=mesh, metadata=quadrature.metadata(stiffness, rule))
        density, alpha, beta = constant("density"), constant("alpha"), constant("beta")
        form = damping.rayleigh(du, v, law, density, alpha, beta, dx, stiffness_dx)
    elif name in ("gyroscopic", "ale_inertia", "centrifugal_load", "momentum_balance"):
        spin = constant("spin") if dim == 2 else constant("spin", 3)
        w = ale.convection(mesh, spin, constant("centre", dim))
        density = constant("density")
        if name == "gyroscopic":
            form = ale.gyroscopic(du, v, density, w, dx)
        elif name == "ale_inertia":
            form = ale.ale_inertia(du, v, density, w, dx)
        elif name == "centrifugal_load":
            form = ale.centrifugal_load(v, density, w, dx)
        else:
            law = LAWS["linear_elastic"](constant("E"), constant("nu"), hypothesis)
            u, velocity, acceleration = field("u"), field("velocity"), field("acceleration")
            form = ale.momentum_balance(u, velocity, acceleration, v, law, density, w, constant("f", dim), dx)
    elif name == "poisson":
        form = galerkin.flux(du, v, constant("k"), dx)
    else:
        u, k, f, q = field("u"), constant("k"), constant("f"), constant("q")
        form = galerkin.weighted_residual(u, v, k, f, q, dx, ds)
    return Built(form, names, used, rule)


@dataclass(frozen=True)
class Row:
    """A row of the table: one form compiled ahead of time."""

    name: str
    cell: str
    degree: int
    geometry_degree: int
    hypothesis: str

    @property
    def symbol(self):
        """Name of the row's file and prefix of its C symbols."""
        text = f"{self.name}_{self.cell}_{self.degree}_{self.geometry_degree}_{self.hypothesis}"
        return "impact_" + text.replace(".", "_")

    def build(self):
        return build(self.name, self.cell, self.degree, self.geometry_degree, self.hypothesis)


def _table():
    rows = []
    for cell in CELLS:
        main = default_hypothesis(cell)
        for degree in DEGREES:
            names = ["linear_elastic.force", "linear_elastic.tangent", "linear_elastic.energy", "neo_hookean.force"]
            names += ["st_venant_kirchhoff.force", "mass", "row_sum", "body_force", "traction"]
            if cell not in quadrature.SIMPLICES and degree == 2:
                names.append("nodal_mass")
            if degree == 1:
                names += ["neo_hookean.tangent", "neo_hookean.energy"]
            rows += [Row(name, cell, degree, 1, main) for name in names]
        if CELLS[cell] == 2:
            for hypothesis in ("plane_stress", "axisymmetric"):
                rows += [Row(n, cell, 1, 1, hypothesis) for n in ("linear_elastic.force", "linear_elastic.tangent")]
    return tuple(rows)


TABLE = _table()
