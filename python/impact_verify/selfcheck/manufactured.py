# SPDX-License-Identifier: MIT
"""Manufactured solution: the loads of a given motion follow from the form itself, and errors fall by their orders."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from ufl.algorithms import extract_coefficients

from dolfinx_impact import compat
from dolfinx_impact.common.types import FloatArray
from . import newton
from .assembled import AssembledForm, quick_form
from .fields import Field, displacement_of, fields_of
from .findings import Curve, Picture
from dolfinx_impact.own_forms.own_form import OwnForm, made
from .patch import boundary_dofs
from .strong import gradient_order, has_gradient, load_of
from .subject import Subject

TOLERANCE, REASON = 0.25, "orders between the last two of three meshes against theory"
SIZES = {2: {1: (6, 12, 24), 2: (5, 10, 20)}, 3: {1: (3, 6, 9), 2: (2, 3, 4)}}


def exact_solution(mesh: Any, fields: list[Field], shape: tuple[int, ...], rest: list[FloatArray], size: float) -> Any:
    """Smooth function of the place, in the shape of the whole unknown.

    Args:
        mesh: mesh.
        fields: fields of the unknown.
        shape: shape of the unknown.
        rest: mean value of each component of each field at rest.
        size: size of its strains [1].

    Returns:
        UFL expression.
    """
    x = ufl.SpatialCoordinate(mesh)
    gdim, components, k = mesh.geometry.dim, [], 0
    for f, mean in zip(fields, rest):
        for c in range(f.num_components):
            argument = sum(((0.9 + 0.3 * ((k + a) % 3)) * (-1) ** (a * k) * x[a] for a in range(gdim)), ufl.as_ufl(0.0))
            components.append(float(mean[c]) + size * ufl.sin(argument + 0.4 * k))
            k += 1
    if not shape:
        return components[0]
    if len(shape) == 1:
        return ufl.as_vector(components)
    return ufl.as_tensor([components[i * shape[1] : (i + 1) * shape[1]] for i in range(shape[0])])


def _part(expression: Any, fields: list[Field], number: int) -> Any:
    """Expression of one field."""
    if len(fields) == 1:
        return expression
    start = sum(f.num_components for f in fields[:number])
    f = fields[number]
    values = [expression[start + c] for c in range(f.num_components)]
    return values[0] if not f.shape else ufl.as_vector(values)


def _errors(subject: Subject, n: int, number: int) -> tuple[float, float]:
    """Errors of one field in L2 and of its gradient, on one mesh."""
    mesh = subject.mesh_of(n)
    own: OwnForm = made(subject.make, subject.name, mesh)
    assembled, V, u = AssembledForm(own), own.u.function_space, own.u
    fields = fields_of(V)
    rest_values = np.array(u.x.array)
    rest = [
        np.array([rest_values[f.dofs].reshape(-1, f.num_components)[:, c].mean() if f.nodal else 0.0
                  for c in range(f.num_components)]) for f in fields
    ]  # fmt: skip
    exact = exact_solution(mesh, fields, u.ufl_shape, rest, 0.6 * own.strain)
    # Functions with one value everywhere are constants of it: those at quadrature points have no derivative.
    uniform = {
        c: fem.Constant(mesh, np.full(c.ufl_shape, c.x.array[0])) if c.ufl_shape else fem.Constant(mesh, c.x.array[0])
        for c in extract_coefficients(assembled.internal)
        if c is not u and np.ptp(c.x.array) == 0.0
    }
    form = ufl.replace(assembled.internal, uniform)
    degree = max(f.degree for f in fields)
    held = all(f.continuous and f.nodal for f in fields)  # their test functions vanish on the boundary
    boundary = not held or gradient_order(ufl.algorithms.expand_derivatives(form)) > 1
    # Of a smooth load this rule makes an error of order 2p + 2 at least.
    b = np.array(fem.assemble_vector(quick_form(load_of(form, u, exact, 2 * degree + 2, boundary))).array)
    fixed, start = [], np.array(u.x.array)
    for f in fields:
        w = fem.Function(f.space)
        points = compat.interpolation_points(f.space)
        w.interpolate(fem.Expression(_part(exact, fields, f.number), points))
        start[f.dofs] = w.x.array
        if f.continuous and f.nodal:
            fixed.append(f.dofs[boundary_dofs(f)])
    prescribed = np.unique(np.concatenate(fixed)) if fixed else np.empty(0, dtype=np.int64)
    u.x.array[:] = newton.solve(assembled, start, prescribed, b)
    e = _part(u, fields, number) - _part(exact, fields, number)
    dx = ufl.Measure("dx", domain=mesh, metadata={"quadrature_degree": 2 * degree + 3})
    squares = [fem.assemble_scalar(quick_form(ufl.inner(a, a) * dx)) for a in (e, ufl.grad(e))]
    return float(np.sqrt(squares[0])), float(np.sqrt(squares[1]))


def manufactured(subject: Subject) -> None:
    """Do errors of a manufactured solution fall by the orders p+1 (L2) and p (H1)?

    Args:
        subject: the form.
    """
    check = "manufactured solution"
    form = subject.assembled
    if not isinstance(form, AssembledForm):
        subject.leave_out(check, "a material with internal variables: its response is not smooth")
        return
    fields = subject.fields
    f = displacement_of(subject.own, fields) or fields[0]
    if not subject.own.definite:
        subject.leave_out(check, "definite=False: the static problem may have several solutions")
        return
    order = gradient_order(ufl.algorithms.expand_derivatives(form.internal))
    if order > 2:
        subject.leave_out(check, "gradients of the test function of third and higher order")
        return
    for c in extract_coefficients(form.internal):
        if c is not subject.u and np.ptp(c.x.array) > 0.0 and not _differentiable(c):
            subject.leave_out(check, f"the function {c.name!r} varies and has no derivative in cells")
            return
    sizes = SIZES[subject.gdim][1 if f.degree < 2 else 2]
    try:
        errors = np.array([_errors(subject, n, fields.index(f)) for n in sizes])
    except RuntimeError as e:
        why = "the problem that belongs to the form has no unique solution that can be found"
        subject.add(check, np.inf, TOLERANCE, REASON, "", f"{e}: {why}")
        return
    rates = np.log(errors[:-1] / errors[1:]) / np.log(np.array(sizes[1:]) / np.array(sizes[:-1]))[:, None]
    expected = np.array([f.degree + 1.0, f.degree])
    if order > 1:  # equations of fourth order on elements with slopes that jump
        expected = np.minimum(expected, 2.0 * (f.degree - 1))
    component = 0
    for g in fields:
        # The error of a field that couples to others limits theirs: by its values if its gradient occurs (temperature,
        # micro-rotation), by duality one order later if not (pressure).
        later = 0.0 if has_gradient(form.internal, component) else 1.0
        component += g.num_components
        if g is not f:
            expected = np.minimum(expected, [g.degree + 1.0 + later, g.degree + 1.0])
    curves = [Curve(np.array(sizes, dtype=float), errors[:, k], f"{norm}, rate {rates[-1, k]:.2f}", -expected[k])
              for k, norm in enumerate(("L2", "H1"))]  # fmt: skip
    subject.picture(Picture("Manufactured solution", "cells per side", "error (block of side 1)", curves))
    below = float(np.max(expected - rates[-1]))
    found = ", ".join(f"{r:.2f} in {norm}" for r, norm in zip(rates[-1], ("L2", "H1")))
    wanted = f"{expected[0]:g} and {expected[1]:g}"
    whose = "" if len(fields) == 1 else f" of field {f.number}"
    subject.add(
        check, max(below, 0.0), TOLERANCE, REASON,
        f"errors{whose} fall by {found} on {len(sizes)} meshes, theory {wanted}",
        f"errors{whose} fall by {found}, theory {wanted}: solutions do not converge as they should. The rule is too "
        "coarse, terms between cells are missing or inconsistent, the element locks, or there are several solutions "
        "(definite=False)",
    )  # fmt: skip


def _differentiable(c: fem.Function) -> bool:
    element = c.function_space.ufl_element()
    return not getattr(element, "has_custom_quadrature", False) and int(element.embedded_superdegree) > 0
