# SPDX-License-Identifier: MIT
"""Degrees of the quadrature rules the forms use by default; one place, so that both routes of a kernel agree."""

import numpy as np
import ufl
from ufl.algorithms.apply_integral_scaling import compute_integrand_scaling_factor
from ufl.algorithms.compute_form_data import attach_estimated_degrees, preprocess_form
from ufl.algorithms.domain_analysis import group_form_integrals

SIMPLICES = ("triangle", "tetrahedron")


def _dimension(cell):
    return 2 if cell in ("triangle", "quadrilateral") else 3


def stiffness_degree(cell, degree, geometry_degree=1, hypothesis="3d"):
    """Degree for internal virtual work: exact for linear elasticity on affine cells.

    Simplices: gradients have degree p - 1 (geometry of degree 2 adds two). Quadrilaterals and hexahedra: p + 1 points
    per direction, full integration. Axisymmetric: the radius adds one, and the hoop strain keeps the full degree p.
    """
    p, g = degree, geometry_degree
    if cell in SIMPLICES:
        return 2 * p + 2 * (g - 1) if hypothesis == "axisymmetric" else 2 * (p - 1) + 2 * (g - 1)
    return 2 * max(p, g)


def one_point_degree(cell="hexahedron", degree=1, geometry_degree=1, hypothesis="3d"):
    """Degree of the rule of one point at the centre, whatever the cell."""
    return 1


def mass_degree(cell, degree, geometry_degree=1, hypothesis="3d"):
    """Degree that integrates density times two shape functions exactly, det J of the cell included."""
    p, g, dim = degree, geometry_degree, _dimension(cell)
    jacobian = dim * (g - 1) if cell in SIMPLICES else g * dim - 1
    return 2 * p + jacobian + (g if hypothesis == "axisymmetric" else 0)


def facet_degree(cell, degree, geometry_degree=1, hypothesis="3d"):
    """Degree that integrates a constant or linear traction against a shape function over straight facets exactly."""
    p, g = degree, geometry_degree
    return p + 1 + _dimension(cell) * (g - 1) + (g if hypothesis == "axisymmetric" else 0)


def follower_degree(cell, degree, geometry_degree=1, hypothesis="3d"):
    """Degree for a pressure on the deformed surface, whose normal holds the gradient of the displacement."""
    more = (degree - 1) * (_dimension(cell) - 1) + degree - 1
    return facet_degree(cell, degree, geometry_degree, hypothesis) + more


def foundation_degree(cell, degree, geometry_degree=1, hypothesis="3d"):
    """Degree that integrates a constant stiffness against two shape functions over straight facets exactly."""
    return facet_degree(cell, degree, geometry_degree, hypothesis) + degree - 1


def nodal_degree(cell, degree, geometry_degree=1, hypothesis="3d"):
    """Degree of the Gauss-Lobatto rule whose points are the nodes of a quadrilateral or hexahedron."""
    return 2 * degree - 1


def metadata(degree, rule=None):
    """Metadata of a UFL measure. rule: None (Basix's default) or a name such as "Gauss-Jacobi" or "GLL"."""
    data = {"quadrature_degree": int(degree)}
    if rule is not None:
        data["quadrature_rule"] = rule
    return data


def with_rules(form):
    """A form with the degrees of its quadrature rules stated, as UFL estimates them where they are not.

    What is made of its integrands afterwards keeps the rules: the derivative of a residual of degree 13 would be
    estimated at 22, and be the tangent of another residual.

    Args:
        form: UFL form.

    Returns:
        UFL form of the same value, in which derivatives have been taken.
    """
    prepared = preprocess_form(form, False)
    grouped = group_form_integrals(prepared, form.ufl_domains(), do_append_everywhere_integrals=False)
    integrals = []
    for integral in attach_estimated_degrees(grouped).integrals():
        data = dict(integral.metadata())
        # The size of a point's part of the cell or facet counts as well, on cells that are not affine.
        estimated = np.add(data.pop("estimated_polynomial_degree"), compute_integrand_scaling_factor(integral)[1])
        if data.get("quadrature_degree", -1) < 0:
            data["quadrature_degree"] = int(np.max(estimated))
        # UFL's grouping drops the tags' data: an integral over ds(2) would be over nothing.
        tags = form.subdomain_data()[integral.ufl_domain()].get(integral.integral_type(), [])
        tags = next((t for t in tags if t is not None), None)
        for tag in integral.subdomain_id():  # a tuple, in which what is everywhere has another name
            tag = "everywhere" if tag == "otherwise" else tag
            integrals.append(integral.reconstruct(metadata=data, subdomain_id=tag, subdomain_data=tags))
    return ufl.Form(integrals)
