# SPDX-License-Identifier: MIT
"""What means at nodes add to the tangent of bodies: derivatives by the means times those of the means."""

from __future__ import annotations

from typing import Any

import ufl
from ufl.algorithms import expand_derivatives

from .. import _cpp
from ..assembly.ffcx_form import ffcx_form
from ..assembly.nodal_mean import NodalMean
from ..assembly.operators import nodal_average
from ..common.described import Described


class AverageTerm(Described):
    """The part of the tangent that goes through the means of one material, force by mean times mean by displacement.

    Args:
        form: internal virtual work, which reads the means.
        mean: the means.

    Attributes:
        force: UFL form of its derivative by the means.
        measure: UFL form of the derivative of what is averaged by the displacement.
    """

    def __init__(self, form: ufl.Form, mean: NodalMean) -> None:
        self._mean = mean
        of_mean, of_u = (ufl.TrialFunction(f.function_space) for f in (mean, mean.displacement))
        self.force = expand_derivatives(ufl.derivative(form, mean, of_mean))
        self.measure = expand_derivatives(ufl.derivative(mean.measure, mean.displacement, of_u))
        self._forms = ffcx_form(self.force), ffcx_form(self.measure)

    def in_cpp(self) -> tuple[Any, Any, Any]:
        """What computes the means, and both matrices (C++). Collective."""
        V, Q = self._mean.displacement.function_space._cpp_object, self._mean.function_space._cpp_object
        force, measure = (form._cpp_object for form in self._forms)
        return (
            nodal_average(self._mean),
            _cpp.operators.KernelTangent(V, Q, [], [], force),
            _cpp.operators.KernelTangent(Q, V, [], [], measure),
        )


def average_terms(form: ufl.Form) -> list[AverageTerm]:
    """Terms of all means that a form reads. Collective.

    Args:
        form: internal virtual work.
    """
    return [AverageTerm(form, f) for f in form.coefficients() if isinstance(f, NodalMean)]
