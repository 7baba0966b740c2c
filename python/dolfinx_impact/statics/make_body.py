# SPDX-License-Identifier: MIT
"""The bodies of a static problem, from materials and loads or from a residual of a user's own."""

from __future__ import annotations

from collections.abc import Sequence

import ufl
from dolfinx import fem

from ..assembly import operators
from ..assembly.measures import check_measures
from ..assembly.residual import differentiable
from ..assembly.residual_bodies import ResidualBodies
from ..forms.quadrature import with_rules
from ..loads import Load
from ..materials import Material
from .body import Body
from .evaluated_body import Evaluate, EvaluatedBody
from .form_body import FormBody
from .load_forms import load_forms
from .material_body import MaterialBody


def make_body(
    u: fem.Function,
    material: Material | None,
    residual: ufl.Form | None,
    loads: Sequence[Load],
    bodies: ResidualBodies | None = None,
    tangent: ufl.Form | None = None,
    evaluate: Evaluate | None = None,
    accept: Evaluate | None = None,
) -> Body:
    """Compose residual and tangent of the bodies.

    Args:
        u: displacement function [L].
        material: material of the bodies; None with a residual.
        residual: UFL residual of a user's own; None with a material.
        loads: loads.
        bodies: what loads ask of the bodies, with a residual; None with a material.
        tangent: derivative of the residual, given with it; None: found by UFL.
        evaluate: function that sets what residual and tangent read, of the displacement; None: there is none.
        accept: function that is called when a step has converged, or None.

    Returns:
        The bodies.

    Raises:
        ValueError: integrals over one kind of entity have different tags.
    """
    du = ufl.TrialFunction(u.function_space)
    forms = load_forms(u, material or bodies, loads)
    external = forms.work()
    follows = external is not None and u in external.coefficients()
    if residual is not None:
        given = tangent - ufl.derivative(with_rules(external), u, du) if tangent is not None and follows else tangent
        residual = residual if external is None else residual - external
        check_measures(residual)
        if evaluate is not None:
            assert given is not None  # checked by the problem
            return EvaluatedBody(u, residual, given, evaluate, accept)
        if given is not None:
            return FormBody(u, residual, given, exact=False)
        with differentiable():
            return FormBody(u, residual, ufl.derivative(with_rules(residual), u, du))
    assert material is not None  # checked by the problem
    if external is not None:
        check_measures(operators.internal_force_form(u, ufl.TestFunction(u.function_space), material) - external)
    return MaterialBody(u, material, forms)
