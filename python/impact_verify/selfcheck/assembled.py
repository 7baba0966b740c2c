# SPDX-License-Identifier: MIT
"""Residual and tangent of a form of one's own as arrays, at any state of its unknown, on one small mesh."""

from __future__ import annotations

from typing import Protocol

import numpy as np
import ufl
from dolfinx import fem
from scipy.sparse import csr_matrix

from dolfinx_impact.assembly.ffcx_form import ffcx_form
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.statics.static_problem import StaticProblem
from ..differences import petsc_to_scipy
from dolfinx_impact.own_forms.own_form import OwnForm
from .parts import split_dead_loads

# These kernels run for a moment only: with little optimisation they are compiled in less time.
QUICK = {"cffi_extra_compile_args": ["-O1"]}


def quick_form(form: ufl.Form) -> fem.Form:
    """A form compiled by FFCx, to be used for a moment.

    Args:
        form: UFL form.
    """
    return ffcx_form(form, jit_options=QUICK)


class Assembled(Protocol):
    """Residual and tangent as arrays; the values of the unknown are an argument."""

    def vector(self, values: FloatArray) -> FloatArray:
        """Internal part of the residual: without dead loads.

        Args:
            values: degrees of freedom of the unknown.
        """

    def matrix(self, values: FloatArray) -> csr_matrix:
        """Tangent.

        Args:
            values: degrees of freedom of the unknown.
        """


class AssembledForm:
    """A residual of UFL, assembled with the kernels of FFCx.

    Args:
        own: the form.

    Attributes:
        internal: residual without dead loads.
        dead: dead loads; None without any.
    """

    def __init__(self, own: OwnForm) -> None:
        assert own.residual is not None
        self.own, self.u = own, own.u
        self.internal, self.dead = split_dead_loads(own.residual, own.u)
        tangent = own.tangent if own.tangent is not None else ufl.derivative(self.internal, own.u)
        self._vector, self._matrix = quick_form(self.internal), quick_form(tangent)

    def vector(self, values: FloatArray) -> FloatArray:
        self.u.x.array[:] = values
        return np.array(fem.assemble_vector(self._vector).array)

    def matrix(self, values: FloatArray) -> csr_matrix:
        self.u.x.array[:] = values
        return csr_matrix(fem.assemble_matrix(self._matrix).to_scipy())


class AssembledMaterial:
    """A material with internal variables, in its virgin state, with the kernels of this package.

    Args:
        own: the material and its displacement.
    """

    def __init__(self, own: OwnForm) -> None:
        self.u = own.u
        self.problem = StaticProblem(own.u, own.material)

    def vector(self, values: FloatArray) -> FloatArray:
        self.u.x.array[:] = values
        out = np.array(self.problem.assemble_residual().array_r)
        fault = self.problem.body.in_cpp().fault()
        if fault:
            raise RuntimeError(fault)
        return out

    def matrix(self, values: FloatArray) -> csr_matrix:
        self.vector(values)
        return petsc_to_scipy(self.problem.tangent.assemble())


def assembled(own: OwnForm) -> AssembledForm | AssembledMaterial:
    """Residual and tangent of a form or a material.

    Args:
        own: what the user says.
    """
    return AssembledForm(own) if own.material is None else AssembledMaterial(own)
