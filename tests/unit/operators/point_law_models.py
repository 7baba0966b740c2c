# SPDX-License-Identifier: MIT
"""Elastic-plastic laws twice: as PointLaw in UFL, and as return mapping in NumPy that is written down here, not taken
from the UFL. Small strain, J2, isotropic hardening; strain tensors are 3 x 3."""

from dataclasses import dataclass

import basix.ufl
import numpy as np
import ufl
from dolfinx import fem

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


def symbols(mesh, degree=DEGREE):
    """Committed plastic strain and equivalent plastic strain, and the space of a scalar at the points."""
    cell = mesh.ufl_cell().cellname()
    scalar = basix.ufl.quadrature_element(cell, degree=degree)
    tensor = basix.ufl.quadrature_element(cell, degree=degree, value_shape=(3, 3), symmetry=True)
    Q, QT = (ufl.FunctionSpace(mesh.ufl_domain(), e) for e in (scalar, tensor))
    return ufl.Coefficient(QT), ufl.Coefficient(Q), Q


def measure(mesh, degree=DEGREE):
    return ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": degree})


def _trial(u, plastic):
    deviator = 2 * SHEAR * ufl.dev(strain(u) - plastic)
    return deviator, ufl.sqrt(1.5 * ufl.inner(deviator, deviator) + 1e-30)


def _model(u, plastic, p, increment, unknown=None, residual=None):
    mesh = u.function_space.mesh
    deviator, size = _trial(u, plastic)
    direction = 1.5 * deviator / size
    eps = strain(u)
    stress = deviator - 2 * SHEAR * increment * direction + BULK * ufl.tr(eps) * ufl.Identity(3)
    form = ufl.inner(stress, strain(ufl.TestFunction(u.function_space))) * measure(mesh)
    outputs = {"plastic_strain": plastic + increment * direction, "p": p + increment}
    history = {"plastic_strain": plastic, "p": p}
    if unknown is None:
        return Model(form, PointLaw(outputs, history))
    return Model(form, PointLaw(outputs, history, unknown, residual, 0 * p, YIELD))


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
}


class Reference:
    """The same body with return mapping in NumPy, and forces assembled by DOLFINx from the stress at the points."""

    def __init__(self, u, hardening):
        mesh = u.function_space.mesh
        cell = mesh.ufl_cell().cellname()
        self.hardening = hardening
        element = basix.ufl.quadrature_element(cell, degree=DEGREE, value_shape=(3, 3))
        self.stress = fem.Function(fem.functionspace(mesh, element))
        points = element.custom_quadrature()[0]
        self.expression = fem.Expression(strain(u), points)
        self.mesh, self.cells = mesh, np.arange(mesh.topology.index_map(mesh.topology.dim).size_local, dtype=np.int32)
        n = len(self.cells) * len(points)
        self.shape = (len(self.cells), len(points), -1)
        self.plastic, self.p = np.zeros((n, 3, 3)), np.zeros(n)
        v = ufl.TestFunction(u.function_space)
        self.form = fem.form(ufl.inner(self.stress, strain(v)) * measure(mesh))

    def evaluate(self):
        """Force, new plastic strain (six components, lower triangle) and equivalent plastic strain; nothing is kept."""
        eps = self.expression.eval(self.mesh, self.cells).reshape(-1, 3, 3)
        self.trial = radial_return(eps, self.plastic, self.p, self.hardening)
        plastic, p, stress = self.trial
        dofs = self.stress.function_space.dofmap.list[self.cells].reshape(-1)
        self.stress.x.array.reshape(-1, 9)[dofs] = stress.reshape(-1, 9)
        force = fem.assemble_vector(self.form).array.copy()
        lower = np.tril_indices(3)
        return force, plastic[:, *lower].reshape(self.shape), p.reshape(self.shape)

    def commit(self):
        self.plastic, self.p = self.trial[:2]
