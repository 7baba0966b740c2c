# SPDX-License-Identifier: MIT
"""Forces that depend on the velocity, and their derivatives."""

from __future__ import annotations

from typing import Any

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc
from ufl.algorithms import expand_derivatives

from ... import _cpp, compat
from ...assembly.ffcx_form import ffcx_form
from ...common.described import Described
from ...assembly import operators
from ...assembly.jit import find_form
from ...common.types import FloatArray


class DampingForce(Described):
    """Nodal forces of a form in displacement and velocity.

    Args:
        form: UFL form of rank 1: virtual work of the forces, positive where they resist.
        u: displacement function [L].
        velocity: velocity function [L/T].
    """

    def __init__(self, form: ufl.Form, u: fem.Function, velocity: fem.Function) -> None:
        V = u.function_space
        self.space, self.velocity = V, velocity
        self._num_owned: int = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        self._kernels = operators.InternalForce(form) if find_form(form) is not None else None
        self._form = ffcx_form(form) if self._kernels is None else None
        self._vector = compat.create_vector(V)
        du = ufl.TrialFunction(V)
        by_velocity = expand_derivatives(ufl.derivative(form, velocity, du))
        by_displacement = expand_derivatives(ufl.derivative(form, u, du))
        self._by_velocity = operators.Tangent(by_velocity)
        self._by_displacement = None if by_displacement.empty() else operators.Tangent(by_displacement)
        # A derivative that contains neither function is the same in all steps.
        self.linear = not any(f is u or f is velocity for f in by_velocity.coefficients()) and by_displacement.empty()

    def forces(self) -> FloatArray:
        """Assemble the forces at the present displacement and velocity. Collective.

        Returns:
            Forces that resist, over owned degrees of freedom [F].
        """
        self.velocity.x.scatter_forward()
        if self._kernels is not None:
            return np.array(self._kernels.apply().array[: self._num_owned])
        with self._vector.localForm() as local:
            local.set(0.0)
        petsc.assemble_vector(self._vector, self._form)
        self._vector.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        return np.array(self._vector.array_r)

    def in_cpp(self) -> Any:
        """The force as MovingBody (C++) sees it, VelocityForce (C++)."""
        return _cpp.integrators.FunctionVelocityForce(self.forces, self.tangent, self.linear)

    def tangent(self, factors: PETSc.Vec) -> list[PETSc.Mat]:
        """Assemble the derivative with respect to the displacement of a step. Collective.

        Args:
            factors: derivative of the velocity by the displacement, by degree of freedom [1/T].

        Returns:
            Matrices whose sum is the derivative; the next call overwrites them [F/L].
        """
        matrix = self._by_velocity.assemble()
        matrix.diagonalScale(None, factors)
        return [matrix] if self._by_displacement is None else [matrix, self._by_displacement.assemble()]
