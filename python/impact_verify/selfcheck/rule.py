# SPDX-License-Identifier: MIT
"""Check of the quadrature rule: forces with the declared one against those of finer ones."""

from __future__ import annotations

import numpy as np
from dolfinx import fem

from dolfinx_impact.common.types import FloatArray
from .assembled import AssembledForm, quick_form
from .findings import Curve, Picture
from .parts import estimated_degree, with_degree
from .subject import Subject

# Discretisation errors of a mesh that one calculates with are some per cent; that of the rule should not add to them.
TOLERANCE, REASON = 1e-2, "small beside discretisation errors of some per cent"
FINER = (2, 4)
EXPENSIVE = 6  # degree beyond which cheaper rules are looked for


def rule(subject: Subject) -> None:
    """Do forces change with a finer rule?

    Args:
        subject: the form.
    """
    form = subject.assembled
    if not isinstance(form, AssembledForm):
        subject.leave_out("quadrature rule", "a material takes the rule of its history")
        return
    degree = estimated_degree(form.internal)
    if degree is None:
        subject.leave_out("quadrature rule", "functions at quadrature points, or another kind of rule, fix the points")
        return

    def forces(q: int) -> FloatArray:
        return np.array(fem.assemble_vector(quick_form(with_degree(form.internal, q))).array)

    subject.u.x.array[:] = subject.state
    finer = [forces(degree + step) for step in FINER]
    found = subject.size(subject.forces - finer[-1])
    errors = {degree: found, degree + FINER[0]: subject.size(finer[0] - finer[-1])}
    hint = ""
    if degree > EXPENSIVE:
        for q in range(1, degree, 1 if degree < 9 else 2):
            errors[q] = subject.size(forces(q) - finer[-1])
            if errors[q] <= 1e-3:
                hint = f"; degree {q} gives the same to {errors[q]:.0e}, for less: write dx(degree={q})"
                break
    degrees = np.array(sorted(errors))
    curve = Curve(degrees, np.array([max(errors[int(q)], 1e-17) for q in degrees]), f"declared: {degree}")
    subject.picture(Picture("Forces with rules of several degrees", "degree of the rule", "change of forces [1]",
                            [curve, Curve(degrees, np.full(len(degrees), TOLERANCE), "tolerance")]))  # fmt: skip
    subject.add(
        "quadrature rule", found, TOLERANCE, REASON,
        f"degree {degree} is enough: forces change by {found:.1e} with degree {degree + FINER[-1]}{hint}",
        f"the rule of degree {degree} is too coarse: forces change by {found:.1e} of the largest with degree "
        f"{degree + FINER[-1]}, by {errors[degree + FINER[0]]:.1e} from degree {degree + FINER[0]} on",
    )  # fmt: skip
