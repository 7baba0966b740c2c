# SPDX-License-Identifier: MIT
"""Bodies that are assembled in C++: by kernels of our own, FFCx's, or both."""

from __future__ import annotations

from collections.abc import Sequence

import ufl
from dolfinx import fem
from petsc4py import PETSc

from .. import _cpp
from ..assembly.operators import BilinearKernels, Energy, InternalForce
from ..common.described import Described
from .average_term import AverageTerm


class BodyMatrix(Described):
    """Derivative of the residual of bodies.

    Args:
        body: the bodies (C++).
        matrix: their matrix, made once [F/L].

    Attributes:
        matrix: as given.
    """

    def __init__(self, body: _cpp.solve.Body, matrix: PETSc.Mat) -> None:
        self._body, self.matrix = body, matrix

    def assemble(self) -> PETSc.Mat:
        """The next call overwrites the matrix."""
        return self._body.tangent()


def depends_on(form: ufl.Form | None, u: fem.Function) -> tuple[bool, bool]:
    """Whether a form contains u, and whether it still does when its derivatives have been taken.

    Args:
        form: UFL form; None: it is zero.
        u: displacement function.
    """
    if form is None or not any(c is u for c in form.coefficients()):
        return False, False
    return True, any(c is u for c in ufl.algorithms.expand_derivatives(form).coefficients())


class AssembledBody(Described):
    """A view of cpp/dolfinx_impact/problems/AssembledBody.h; see Body.

    Args:
        u: displacement function [L].
        forces: parts of the residual by kernels.
        kernels: their derivatives.
        loads: external forces by kernels.
        residual: the rest of the residual, of FFCx; None: there is none.
        tangent: its derivative; None: it is zero.
        properties: what is known of the bodies beforehand.
        averages: what the derivative by means at nodes adds to the tangent.

    Attributes:
        tangent: derivative of the residual.
        properties: as given.
    """

    def __init__(
        self,
        u: fem.Function,
        forces: Sequence[InternalForce],
        kernels: Sequence[BilinearKernels],
        loads: Sequence[InternalForce],
        residual: fem.Form | None,
        tangent: fem.Form | None,
        properties: _cpp.solve.BodyProperties,
        averages: Sequence[AverageTerm] = (),
    ) -> None:
        self.properties = properties
        V = u.function_space._cpp_object
        matrix = _cpp.operators.KernelTangent(
            V,
            V,
            [integral for k in kernels for integral in k.integrals],
            [source for k in kernels for source in k.sources],
            None if tangent is None else tangent._cpp_object,
        )
        for term in averages:
            matrix.add_average(*term.in_cpp())
        read = [f for k in kernels for f in k.functions] + [
            f for o in (*forces, *loads) for f in o.coefficients.values()
        ]
        self._cpp_object = _cpp.problems.AssembledBody(
            u._cpp_object,
            None if residual is None else residual._cpp_object,
            matrix,
            forces=[force.live() for force in forces],
            loads=[load.live() for load in loads],
            tangent_constants=[constants for k in kernels for constants in k.constants],
            functions=[f._cpp_object for f in {id(f): f for f in read if f is not u}.values()],
            properties=properties,
        )
        # FFCx's functions are Python's, which must live as long as the forms.
        self._keep = residual, tangent, averages
        self.tangent = BodyMatrix(self._cpp_object, matrix.matrix)

    def set_energies(self, energies: Sequence[Energy]) -> None:
        """Say what stores energy beside laws with internal variables: with these, all energy is known.

        Args:
            energies: energies of elastic materials, and of springs.
        """
        read = [f for energy in energies for f in energy.coefficients.values()]
        self._cpp_object.set_energies([energy.live() for energy in energies], [f._cpp_object for f in read])

    def in_cpp(self) -> _cpp.solve.Body:
        return self._cpp_object
