# SPDX-License-Identifier: MIT
"""Forms that every law has beside its residual: a mass, and the stress at the points of a rule."""

from __future__ import annotations

from typing import Any

import ufl

from .. import compat
from ..forms.elasticity import STRESS
from ..forms.materials import stress_components
from ..forms import inertia, quadrature
from ..forms.materials import weight
from ..forms.point_law import PointLaw
from .case import Case
from .own_law import KernelForm


def mass_form(u: Any, case: Case) -> tuple[ufl.Form, ufl.Constant]:
    """Mass matrix of the unknown's space, and its constant of density: a vector of one for each field of mixed spaces.

    Args:
        u: the unknown.
        case: the cells.
    """
    V = u.ufl_function_space()
    mesh, element = V.ufl_domain(), V.ufl_element()
    dx = ufl.dx(domain=mesh, metadata=quadrature.metadata(case.mass_degree))
    fields = element.num_sub_elements if element.num_sub_elements > 1 and element.block_size == 1 else 1
    if fields == 1:
        density = ufl.Constant(mesh)
        return inertia.mass(ufl.TrialFunction(V), ufl.TestFunction(V), density, case.hypothesis, dx), density
    density = ufl.Constant(mesh, shape=(fields,))
    pairs = zip(ufl.TrialFunctions(V), ufl.TestFunctions(V))
    return sum(inertia.mass(a, b, density[i], case.hypothesis, dx) for i, (a, b) in enumerate(pairs)), density


def stress_form(u: Any, stress: Any, case: Case) -> KernelForm:
    """Virtual work of a Cauchy stress on the gradient, and the point law whose output "stress" is that stress.

    Args:
        u: the unknown.
        stress: UFL tensor of 3 x 3 [F/L^2].
        case: the cells.

    Raises:
        ValueError: the unknown is no displacement.
    """
    V = u.ufl_function_space()
    mesh = V.ufl_domain()
    dim = compat.geometric_dimension(mesh)
    if u.ufl_shape != (dim,):
        raise ValueError(f"a stress needs a displacement of {dim} components, the unknown has the shape {u.ufl_shape}")
    plane = ufl.as_tensor([[stress[i, j] for j in range(dim)] for i in range(dim)])
    dx = ufl.dx(domain=mesh, metadata=quadrature.metadata(case.stiffness_degree))
    work = ufl.inner(plane, ufl.grad(ufl.TestFunction(V))) * weight(mesh, case.hypothesis) * dx
    outputs = {STRESS: ufl.as_vector([stress[i, j] for i, j in stress_components(dim)])}
    return KernelForm(work, PointLaw(outputs=outputs))
