# SPDX-License-Identifier: MIT
"""Elastic-plastic laws twice: as PointLaw in UFL, and as return mapping in NumPy that is written down here, not taken
from the UFL. Small strain, J2, isotropic hardening; strain tensors are 3 x 3."""

from dataclasses import dataclass

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem

from dolfinx_impact import compat
from dolfinx_impact.forms.point_law import PointLaw

E, NU, YIELD, LINEAR = 210e3, 0.3, 300.0, 1500.0
SATURATION, RATE = 200.0, 15.0  # Voce: yield stress = YIELD + SATURATION (1 - exp(-RATE p)) + LINEAR p
SHEAR, BULK = E / (2 * (1 + NU)), E / (3 * (1 - 2 * NU))
DEGREE = 2


def strain(u):
    """Strain as a 3 x 3 tensor; plane strain in the plane."""
    g = ufl.grad(u)
    if g.ufl_shape == (2, 2):
        g = ufl.as_tensor([[g[0, 0], g[0, 1], 0], [g[1, 0], g[1, 1], 0], [0, 0, 0]])
    return ufl.sym(g)


@dataclass
class Model:
    """A law on a mesh: the form of its internal forces, and the PointLaw."""

    form: ufl.Form
    law: PointLaw
    deviatoric: object  # part of the stress


def symbols(mesh, degree=DEGREE):
    """Committed plastic strain and equivalent plastic strain, and the space of a scalar at the points."""
    cell = compat.cell_name(mesh)
    scalar = basix.ufl.quadrature_element(cell, degree=degree)
    tensor = basix.ufl.quadrature_element(cell, degree=degree, value_shape=(3, 3), symmetry=True)
    Q, QT = (ufl.FunctionSpace(mesh.ufl_domain(), e) for e in (scalar, tensor))
    return ufl.Coefficient(QT), ufl.Coefficient(Q), Q


def measure(mesh, degree=DEGREE):
    return ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": degree})


def _trial(u, plastic):
    deviator = 2 * SHEAR * ufl.dev(strain(u) - plastic)
    return deviator, ufl.sqrt(1.5 * ufl.inner(deviator, deviator) + 1e-30)


def _model(u, plastic, p, increment, unknown=None, residual=None, start=None):
    mesh = u.function_space.mesh
    deviator, size = _trial(u, plastic)
    direction = 1.5 * deviator / size
    eps = strain(u)
    deviatoric = deviator - 2 * SHEAR * increment * direction
    stress = deviatoric + BULK * ufl.tr(eps) * ufl.Identity(3)
    form = ufl.inner(stress, strain(ufl.TestFunction(u.function_space))) * measure(mesh)
    outputs = {"plastic_strain": plastic + increment * direction, "p": p + increment}
    history = {"plastic_strain": plastic, "p": p}
    sums = {"elastic": ufl.inner(stress, eps - plastic - increment * direction) / 2}
    if unknown is None:
        return Model(form, PointLaw(outputs, history, sums=sums), deviatoric)
    start = 0 * p if start is None else start
    return Model(form, PointLaw(outputs, history, unknown, residual, start, YIELD, sums), deviatoric)


def closed_form(u):
    """Linear hardening, solved for the increment by hand."""
    plastic, p, _ = symbols(u.function_space.mesh)
    _, size = _trial(u, plastic)
    return _model(u, plastic, p, ufl.max_value(size - YIELD - LINEAR * p, 0) / (3 * SHEAR + LINEAR))


def _flow_stress(p, exp):
    return YIELD + SATURATION * (1 - exp(-RATE * p)) + LINEAR * p


def voce(u):
    """Voce's hardening: one local unknown, the increment of the equivalent plastic strain."""
    plastic, p, Q = symbols(u.function_space.mesh)
    x = ufl.Coefficient(Q)
    _, size = _trial(u, plastic)
    yields = ufl.gt(size, _flow_stress(p, ufl.exp))
    residual = ufl.conditional(yields, size - 3 * SHEAR * x - _flow_stress(p + x, ufl.exp), 3 * SHEAR * x)
    return _model(u, plastic, p, x, x, residual)


def two_unknowns(u):
    """Voce's hardening with the flow stress as a second unknown."""
    mesh = u.function_space.mesh
    plastic, p, _ = symbols(mesh)
    x = unknowns(mesh, 2)
    _, size = _trial(u, plastic)
    yields = ufl.gt(size, _flow_stress(p, ufl.exp))
    first = ufl.conditional(yields, size - 3 * SHEAR * x[0] - x[1], 3 * SHEAR * x[0])
    residual = ufl.as_vector([first, x[1] - _flow_stress(p + x[0], ufl.exp)])
    return _model(u, plastic, p, x[0], x, residual, ufl.as_vector([0 * p, _flow_stress(p, ufl.exp)]))


def seven_unknowns(u):
    """Voce's hardening with the deviator of the stress and the increment as unknowns: the general closest-point
    projection, before its reduction to one equation."""
    mesh = u.function_space.mesh
    plastic, p, _ = symbols(mesh)
    x = unknowns(mesh, 7)
    trial, size = _trial(u, plastic)
    yields = ufl.gt(size, _flow_stress(p, ufl.exp))
    s = ufl.as_tensor([[x[0], x[1], x[3]], [x[1], x[2], x[4]], [x[3], x[4], x[5]]])
    equivalent = ufl.sqrt(1.5 * ufl.inner(s, s) + 1e-30)
    lower = [(i, j) for i in range(3) for j in range(i + 1)]
    flow = s - trial + 3 * SHEAR * x[6] * s / equivalent
    yield_condition = ufl.conditional(yields, equivalent - _flow_stress(p + x[6], ufl.exp), 3 * SHEAR * x[6])
    residual = ufl.as_vector([*(flow[i, j] for i, j in lower), yield_condition])
    start = ufl.as_vector([*(trial[i, j] for i, j in lower), 0 * p])
    return _model(u, plastic, p, x[6], x, residual, start)


def unknowns(mesh, size, degree=DEGREE):
    """A vector of local unknowns."""
    element = basix.ufl.quadrature_element(compat.cell_name(mesh), degree=degree, value_shape=(size,))
    return ufl.Coefficient(ufl.FunctionSpace(mesh.ufl_domain(), element))


def radial_return(eps, plastic, p, hardening):
    """New plastic strain, equivalent plastic strain and stress of many points (Simo & Hughes 1998, box 3.1; the
    consistency condition by bisection, which knows no derivative).

    Args:
        eps, plastic: (n, 3, 3). p: (n,). hardening: flow stress as a function of p.
    """
    identity = np.eye(3)
    elastic = eps - plastic
    volume = np.trace(eps, axis1=1, axis2=2)
    mean = np.trace(elastic, axis1=1, axis2=2) / 3
    trial = 2 * SHEAR * (elastic - mean[:, None, None] * identity)
    size = np.sqrt(1.5 * np.sum(trial**2, axis=(1, 2)))
    low, high = np.zeros_like(p), np.maximum(size - hardening(p), 0) / (3 * SHEAR)
    for _ in range(200):
        middle = (low + high) / 2
        above = size - 3 * SHEAR * middle - hardening(p + middle) > 0
        low, high = np.where(above, middle, low), np.where(above, high, middle)
    increment = np.where(size > hardening(p), (low + high) / 2, 0.0)
    direction = 1.5 * trial / np.where(size > 0, size, 1)[:, None, None]
    flow = increment[:, None, None] * direction
    stress = trial - 2 * SHEAR * flow + BULK * volume[:, None, None] * identity
    return plastic + flow, p + increment, stress


HARDENING = {
    closed_form: lambda p: YIELD + LINEAR * p,
    voce: lambda p: _flow_stress(p, np.exp),
    two_unknowns: lambda p: _flow_stress(p, np.exp),
    seven_unknowns: lambda p: _flow_stress(p, np.exp),
}


class Reference:
    """The same body with return mapping in NumPy, and forces assembled by DOLFINx from the stress at the points."""

    def __init__(self, u, hardening):
        mesh = u.function_space.mesh
        cell = compat.cell_name(mesh)
        self.hardening = hardening
        element = basix.ufl.quadrature_element(cell, degree=DEGREE, value_shape=(3, 3))
        self.stress, self.elastic = (fem.Function(fem.functionspace(mesh, element)) for _ in range(2))
        points = element.custom_quadrature()[0]
        self.expression = fem.Expression(strain(u), points)
        self.mesh, self.cells = mesh, np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)
        n = len(self.cells) * len(points)
        self.shape = (len(self.cells), len(points), -1)
        self.plastic, self.p = np.zeros((n, 3, 3)), np.zeros(n)
        v = ufl.TestFunction(u.function_space)
        self.form = fem.form(ufl.inner(self.stress, strain(v)) * measure(mesh))
        self.energy = fem.form(ufl.inner(self.stress, self.elastic) / 2 * measure(mesh))

    def evaluate(self):
        """Force, new plastic strain (six components, lower triangle) and equivalent plastic strain; nothing is kept."""
        eps = self.expression.eval(self.mesh, self.cells).reshape(-1, 3, 3)
        self.trial = radial_return(eps, self.plastic, self.p, self.hardening)
        plastic, p, stress = self.trial
        dofs = self.stress.function_space.dofmap.list[self.cells].reshape(-1)
        self.stress.x.array.reshape(-1, 9)[dofs] = stress.reshape(-1, 9)
        self.elastic.x.array.reshape(-1, 9)[dofs] = (eps - plastic).reshape(-1, 9)
        force = fem.assemble_vector(self.form).array.copy()
        lower = np.tril_indices(3)
        return force, plastic[:, *lower].reshape(self.shape), p.reshape(self.shape)

    def elastic_energy(self):
        """Elastic energy of the last evaluation."""
        return fem.assemble_scalar(self.energy)

    def commit(self):
        self.plastic, self.p = self.trial[:2]
