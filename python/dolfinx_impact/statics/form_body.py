# SPDX-License-Identifier: MIT
"""Bodies with a residual of a user's own: assembled by FFCx's kernels."""

from __future__ import annotations

import ufl
from dolfinx import fem

from .. import _cpp
from ..assembly.averaged_form import compile_columns, has_averages, split_averages
from ..assembly.ffcx_form import ffcx_form
from ..assembly.operators import BilinearKernels, InternalForce
from .assembled_body import AssembledBody, depends_on


class FormBody(AssembledBody):
    """Bodies whose forces follow from the present displacement alone; see Body.

    FFCx does not know averages over a cell: integrals with them have kernels of our own.

    Args:
        u: displacement function [L].
        residual: UFL form of the internal minus the external forces, of rank 1.
        tangent: UFL form of its derivative, of rank 2.
        exact: whether the tangent is known to be the derivative of the residual: with one that a user gives, the
            problem is taken as nonlinear.
    """

    def __init__(self, u: fem.Function, residual: ufl.Form, tangent: ufl.Form, exact: bool = True) -> None:
        averaged_residual = has_averages(residual)
        plain, averaged = split_averages(tangent)
        contains, varies = depends_on(tangent, u)
        super().__init__(
            u,
            [InternalForce(residual)] if averaged_residual else [],
            [] if averaged is None else [BilinearKernels(averaged, compile_columns(averaged, u.function_space))],
            [],
            None if averaged_residual else ffcx_form(residual),
            None if plain is None else ffcx_form(plain),
            _cpp.solve.BodyProperties(
                linear=exact and not varies,
                keeps_tangent=exact and not contains,
                has_springs=True,  # there may be some in it
            ),
        )
