# SPDX-License-Identifier: MIT
"""The bodies of a static problem, from materials and loads or from a residual of a user's own."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..assembly import operators
from ..assembly.inelastic_part import InelasticParts
from ..assembly.measures import check_measures
from ..assembly.residual import differentiable
from ..assembly.residual_bodies import ResidualBodies
from ..added_mass import AddedMass
from ..forms.quadrature import with_rules
from ..foundation import foundations
from ..inelastic import InelasticMaterial
from ..loads import Load
from ..materials import Material
from .body import Body
from .elastic_body import ElasticBody
from .evaluated_body import Evaluate, EvaluatedBody
from .inelastic_body import InelasticBody


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
        Elastic or inelastic bodies.

    Raises:
        ValueError: integrals over one kind of entity have different tags.
    """
    V = u.function_space
    v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
    external, springs = external_work(u, material or bodies, loads), bool(foundations(loads))
    if residual is not None:
        follows = external is not None and u in external.coefficients()
        given = tangent - ufl.derivative(with_rules(external), u, du) if tangent is not None and follows else tangent
        residual = residual if external is None else residual - external
        check_measures(residual)
        if evaluate is not None:
            assert given is not None  # checked by the problem
            return EvaluatedBody(u, residual, given, evaluate, accept)
        # There may be springs in it.
        if given is None:
            with differentiable():
                return ElasticBody(u, residual, ufl.derivative(with_rules(residual), u, du), has_springs=True)
        body = ElasticBody(u, residual, given, has_springs=True)
        body.linear = body.keeps_tangent = False  # nothing says that it is exact
        return body
    assert material is not None  # checked by the problem
    follows = external is not None and u in external.coefficients()
    stiffness = ufl.derivative(external, u, du) if follows else None
    inelastic = any(isinstance(m, InelasticMaterial) for _, m in material.parts())
    if not inelastic:
        internal, elastic = operators.internal_force_form(u, v, material), operators.tangent_form(u, du, v, material)
        whole = internal if external is None else internal - external
        check_measures(whole)
        return ElasticBody(u, whole, elastic if stiffness is None else elastic - stiffness, springs)
    rest = _sum(operators.internal_force_form(u, v, material), None if external is None else -external)
    if rest is not None:
        check_measures(rest)
    elastic = _sum(operators.tangent_form(u, du, v, material), None if stiffness is None else -stiffness)
    return InelasticBody(u, InelasticParts(u, material), rest, elastic, springs)


def assemble_residual(u: fem.Function, body: Body, b: PETSc.Vec) -> PETSc.Vec:
    """Assemble the residual of bodies at the present displacement. Collective.

    Args:
        u: displacement function; its ghosts are updated [L].
        body: bodies.
        b: vector of `body.vector()`, which is overwritten; its owned entries are complete [F].

    Returns:
        `b`.
    """
    u.x.scatter_forward()
    with b.localForm() as local:
        local.set(0.0)
    body.add_residual(b)
    b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
    return b


def external_work(u: fem.Function, bodies: Material | ResidualBodies | None, loads: Sequence[Load]) -> Any:
    """Virtual work of the loads.

    Args:
        u: displacement function [L].
        bodies: material of the bodies, or those of a residual; None without loads.
        loads: loads.

    Returns:
        UFL form of rank 1; None without loads.
    """
    v, external = ufl.TestFunction(u.function_space), None
    for load in loads:
        if isinstance(load, AddedMass):
            continue  # inertia
        form = load.form(u, v, bodies)
        external = form if external is None else external + form
    return external


def _sum(*forms: Any) -> Any:
    """Sum of the forms that are not None or zero; None if there are none."""
    found = [f for f in forms if f is not None and isinstance(f, ufl.Form) and not f.empty()]
    return sum(found[1:], found[0]) if found else None
