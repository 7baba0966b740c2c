# SPDX-License-Identifier: MIT
"""Degree of the rule for forms of a user's own, and a warning where UFL's estimate is far beyond it."""

from __future__ import annotations

import warnings
from typing import Any

import basix
import numpy as np
import ufl
from dolfinx.fem import Function, FunctionSpace
from ufl.algorithms import compute_form_data

from .. import compat
from ..common import arguments
from ..common.collective import comm_of, guard
from ..forms import quadrature
from ..forms.compiler.averages import has_averages
from .fields import fields_of, is_mixed

TOO_MANY = 3.0  # times as many points as even a mass needs: beyond this a plain dx is no matter of taste


def quadrature_degree(u: Function | FunctionSpace, hypothesis: str | None = None, values: bool = False) -> int:
    """Degree for the integrals of a form of your own, `ufl.dx(degree=quadrature_degree(u))`: that of the package's own
    materials.

    It integrates the strains of linear elasticity exactly on affine cells, and finite strain with as many points as the
    package's laws of finite strain. UFL's own estimate for a plain `dx` adds two degrees for each power and function.

    Args:
        u: displacement, or its space; of a mixed space the field of the highest degree counts.
        hypothesis: "axisymmetric" if the integrals contain 2 pi r; otherwise None or another hypothesis.
        values: whether the form has products of values, u v, beside those of gradients: springs, masses, pressures.

    Returns:
        Degree [1].

    Raises:
        TypeError: `u` is neither a function nor a space.
    """
    with guard(comm_of(u), "quadrature_degree", hypothesis=hypothesis, values=values):
        V = u.function_space if isinstance(u, Function) else u
        arguments.function_space("u", V)
    return _degree(V, hypothesis, values)


def _degree(V: FunctionSpace, hypothesis: str | None, values: bool) -> int:
    mesh = V.mesh
    p = max(f.degree for f in fields_of(V)) if is_mixed(V) else V.element.basix_element.degree
    cell, g, weight = mesh.topology.cell_name(), compat.coordinate_element(mesh).degree, hypothesis or "plane_strain"
    find = quadrature.mass_degree if values else quadrature.stiffness_degree
    return int(find("triangle" if cell == "interval" else cell, p, g, weight))


def warn_of_degree(form: ufl.Form, u: Function, hypothesis: str | None = None) -> None:
    """Warn on rank 0 of integrals over cells, without a degree of their own, for which UFL estimates far more points
    than their elements need.

    Args:
        form: residual of a user's own.
        u: displacement function.
        hypothesis: hypothesis of the residual.
    """
    plain = [i for i in form.integrals() if i.integral_type() == "cell" and not _has_rule(i)]
    if not plain or u.function_space.mesh.comm.rank != 0:
        return
    V = u.function_space
    cell = getattr(basix.CellType, V.mesh.topology.cell_name())
    needed, own = _degree(V, hypothesis, True), _degree(V, hypothesis, False)
    degree = max(_estimates(ufl.Form(plain)), default=0)
    if degree > arguments.LARGEST_DEGREE:
        return  # refused by compilers, with the degree
    count, enough, few = (np.shape(basix.make_quadrature(cell, d)[1])[0] for d in (degree, needed, own))
    if count <= TOO_MANY * enough:
        return
    warnings.warn(
        f"the residual has a dx without a degree, for which UFL estimates {degree}: {count} points in a cell, where "
        f"the package's own laws take {few} (degree {own}); set-up and steps take some {count / few:.0f} times as "
        "long. Give the degree, ufl.dx(degree=di.quadrature_degree(u)), or a higher one if you want the estimate's "
        "accuracy",
        stacklevel=4,
    )


def _has_rule(integral: Any) -> bool:
    """Whether the user has chosen the points of an integral."""
    metadata = integral.metadata()
    return metadata.get("quadrature_degree") not in (None, -1, "auto", "default") or "quadrature_points" in metadata


def _estimates(form: ufl.Form) -> list[int]:
    """Degrees that UFL estimates for the integrals of a form, as form compilers ask for them."""
    if any(has_averages(i.integrand()) for i in form.integrals()):
        return []
    data = compute_form_data(
        form,
        do_apply_function_pullbacks=True,
        do_apply_integral_scaling=True,
        do_apply_geometry_lowering=True,
        preserve_geometry_types=(ufl.classes.Jacobian,),
        do_apply_restrictions=True,
        do_append_everywhere_integrals=False,
    )
    found = [i.metadata().get("estimated_polynomial_degree", 0) for d in data.integral_data for i in d.integrals]
    return [max(d) if isinstance(d, tuple) else int(d) for d in found]
