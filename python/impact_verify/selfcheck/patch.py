# SPDX-License-Identifier: MIT
"""Patch test: a linear motion of the boundary of a distorted mesh makes the inside move linearly, too."""

from __future__ import annotations

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import exterior_facet_indices
from ufl.algorithms import extract_coefficients

from dolfinx_impact.common.types import FloatArray, IntArray
from . import newton
from .assembled import AssembledForm
from .fields import Field
from .subject import Subject

# Newton's method stops at corrections of 1e-11; the rest is the condition number of a mesh of a few cells.
TOLERANCE, REASON = 1e-7, "Newton's method and the condition number of a small mesh"


def boundary_dofs(f: Field) -> IntArray:
    """Degrees of freedom of a field, in the numbers of its own space, on the boundary of its mesh.

    Args:
        f: the field.
    """
    mesh = f.space.mesh
    tdim = mesh.topology.dim
    mesh.topology.create_connectivity(tdim - 1, tdim)
    blocks = fem.locate_dofs_topological(f.space, tdim - 1, exterior_facet_indices(mesh.topology))
    bs = f.space.dofmap.bs
    return (bs * blocks[:, None] + np.arange(bs)).ravel().astype(np.int64)


def _uniform(subject: Subject) -> str:
    """Why a linear motion is no solution, or an empty text."""
    form = subject.assembled
    if not isinstance(form, AssembledForm):
        return ""
    for c in extract_coefficients(form.internal):
        if c is not subject.u and np.ptp(c.x.array) > 0.0:
            return f"the form contains the function {c.name!r}, which varies"
    if not subject.axisymmetric and ufl.algorithms.analysis.has_type(form.internal, ufl.SpatialCoordinate):
        return "the form depends on the place"
    if any(i.integral_type() != "cell" for i in form.internal.integrals()):
        return "the form has integrals over facets"
    return ""


def patch(subject: Subject) -> None:
    """Does the inside follow a linear motion of the boundary?

    Args:
        subject: the form.
    """
    f = subject.displacement or (subject.fields[0] if len(subject.fields) == 1 else None)
    why = _uniform(subject)
    if subject.own.grounded:
        why = why or "grounded=True: a linear motion is no solution"
    if f is None or not f.nodal or not f.continuous:
        why = why or "there is no displacement, or no single field with nodes on the boundary"
    elif f is not subject.displacement and _depends_on_value(subject, f):
        why = why or "the form depends on the value of the unknown: a linear field is no solution"
    if why or f is None:
        subject.leave_out("patch test", why)
        return
    slope = _slope(subject, f)
    values = f.nodes @ slope.T
    if subject.axisymmetric:
        values = f.nodes * np.array([1.0, -2.0])
    size = 0.2 * subject.own.strain
    exact = subject.rest + subject.of(f, size * values)
    start = subject.rest.copy()
    fixed = f.dofs[boundary_dofs(f)]
    start[fixed] = exact[fixed]
    inner = np.setdiff1d(f.dofs, fixed)
    try:
        found = newton.solve(subject.assembled, start, fixed)
        difference = float(np.abs((found - exact)[inner]).max() / np.abs(exact[f.dofs]).max()) if len(inner) else 0.0
        text = f"nodes inside miss a linear motion of the boundary by {difference:.1e} of it"
    except RuntimeError as e:
        difference, text = np.inf, str(e)
    subject.add(
        "patch test", difference, TOLERANCE, REASON, "nodes inside follow a linear motion of the boundary",
        f"{text}: a uniform strain is no equilibrium of a distorted mesh, so that solutions need not converge. Is a "
        "weight or a measure wrong, or do terms depend on the cell?",
    )  # fmt: skip


def _slope(subject: Subject, f: Field) -> FloatArray:
    """Gradient of the motion: with pressures a simple shear, which keeps volumes; without, all components."""
    dim = subject.gdim
    if f is not subject.displacement:
        return np.linspace(1.0, -0.6, f.num_components * dim).reshape(f.num_components, dim)
    if subject.rotation is not None:  # without a mean rotation, so that there is no micro-rotation either
        slope = np.zeros((dim, dim))
        slope[0, 1] = slope[1, 0] = 1.0
        return slope
    if len(subject.fields) > 1:
        slope = np.zeros((dim, dim))
        slope[0, 1] = 1.0
        return slope
    return np.array([[1.0, 0.7, -0.4], [0.2, -0.6, 0.5], [-0.3, 0.1, 0.8]])[:dim, :dim]


def _depends_on_value(subject: Subject, f: Field) -> bool:
    shifted = subject.state + subject.of(f, np.ones((len(f.nodes), f.num_components)))
    return subject.size(subject.assembled.vector(shifted) - subject.forces) > 1e-9
