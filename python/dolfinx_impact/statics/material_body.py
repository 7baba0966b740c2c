# SPDX-License-Identifier: MIT
"""Bodies of materials: internal forces, tangent, history and constant loads by our kernels, other loads by FFCx's."""

from __future__ import annotations

from typing import Any

import ufl
from dolfinx import fem

from .. import _cpp
from ..assembly import operators
from ..assembly.averaged_form import compile_matrices
from ..assembly.ffcx_form import ffcx_form
from ..assembly.material_history import MaterialHistory
from ..assembly.inelastic_part import InelasticParts
from ..assembly.jit import compile_form
from ..assembly.operators import BilinearKernels, InternalForce
from ..materials import Material
from .assembled_body import AssembledBody, depends_on
from .average_term import average_terms
from .body import Body
from .load_forms import LoadForms


class MaterialBody(AssembledBody):
    """Bodies of materials, with internal variables or without; see Body.

    Args:
        u: displacement function [L].
        material: material of the bodies.
        loads: virtual work of the loads; None: there are none.

    Attributes:
        force: operator of the internal forces of materials with internal variables, which keeps them; None: there are
            none.
        history: internal variables by name, or None.
        parts: parts of materials with internal variables.
    """

    def __init__(
        self,
        u: fem.Function,
        material: Material,
        loads: LoadForms | None = None,
    ) -> None:
        loads = LoadForms() if loads is None else loads
        V = u.function_space
        v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
        forces, kernels, contains, varies = [], [], False, False
        elastic: Any = operators.internal_force_form(u, v, material)
        if isinstance(elastic, ufl.Form):  # not of inelastic materials alone
            tangent = operators.partial_tangent_form(u, du, v, material)
            contains, varies = depends_on(tangent, u)
            forces.append(InternalForce(elastic))
            kernels.append(BilinearKernels(tangent, compile_matrices(tangent, V)))
        self.parts = parts = InelasticParts(u, material)
        self.force: InternalForce | None = None
        self.history: MaterialHistory | None = None
        if len(parts) > 0:
            # By itself: cells with a point law take one quadrature rule, loads may need another one.
            form, laws = parts.force(v)
            self.force = InternalForce(form, law=laws)
            self.history = MaterialHistory(parts, self.force.history)
            forces.append(self.force)
            kernels += [part.tangent(self.force.history) for part in parts]
        forces += [InternalForce(form) for form in loads.springs]
        kernels += [BilinearKernels(form, compile_form(form)) for form in loads.spring_tangents]
        other, stiffness = loads.other, None
        if other is not None and u in other.coefficients():
            stiffness = ufl.derivative(other, u, du)
        of_loads = depends_on(stiffness, u)
        inelastic = self.force is not None
        averaged = [elastic] if isinstance(elastic, ufl.Form) else []
        averaged += [part.force(v)[0] for part in parts if part.mean is not None]
        terms = [term for form in averaged for term in average_terms(form)]
        linear_measures = all(not depends_on(term.measure, u)[1] for term in terms)
        super().__init__(
            u,
            forces,
            kernels,
            [InternalForce(form) for form in loads.dead],
            None if other is None else ffcx_form(-other),
            None if stiffness is None else ffcx_form(-stiffness),
            _cpp.solve.BodyProperties(
                linear=not inelastic and not varies and not of_loads[1] and linear_measures,
                keeps_tangent=not inelastic and not contains and stiffness is None and not loads.springs,
                # Kinematic hardening with recovery and finite strain make the tangent of plastic flow unsymmetric.
                symmetric=not inelastic,
                inelastic=inelastic,
                has_springs=loads.has_springs,
                rounds_positions=True,
            ),
            terms,
        )


def history_of(body: Body) -> MaterialHistory | None:
    """Internal variables of bodies; None: no material has any.

    Args:
        body: the bodies.
    """
    return body.history if isinstance(body, MaterialBody) else None
