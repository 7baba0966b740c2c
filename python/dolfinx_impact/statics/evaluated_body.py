# SPDX-License-Identifier: MIT
"""Bodies with a residual whose stress a user's function computes, for example at quadrature points."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from .. import _cpp
from ..common.collective import agree, attempt
from ..common.described import Described
from ..common.types import FloatArray
from .form_body import FormBody

Evaluate: TypeAlias = Callable[[fem.Function], object]
"""Function of the displacement, which sets other functions."""


class EvaluatedTangent(Described):
    """Tangent whose functions are those of the present displacement.

    Args:
        body: the bodies.
    """

    def __init__(self, body: EvaluatedBody) -> None:
        self._body = body

    @property
    def matrix(self) -> PETSc.Mat:
        return self._body.forms.tangent.matrix

    def assemble(self) -> PETSc.Mat:
        self._body.evaluate_if_changed()
        return self._body.forms.tangent.assemble()


class EvaluatedBody(Described):
    """Bodies whose residual and tangent read functions that a user sets for every displacement; see Body.

    Args:
        u: displacement function [L].
        residual: UFL form of the internal minus the external forces, of rank 1.
        tangent: UFL form of its derivative, of rank 2.
        evaluate: function that is called before the residual is assembled.
        accept: function that is called when a step has converged, or None.

    Attributes:
        forms: bodies of the forms, at the present values of their functions.
        properties: what is known of the bodies beforehand.
    """

    def __init__(
        self, u: fem.Function, residual: ufl.Form, tangent: ufl.Form, evaluate: Evaluate, accept: Evaluate | None
    ) -> None:
        # What is evaluated may depend on a history, and there may be springs in the residual.
        self.properties = _cpp.solve.BodyProperties(inelastic=True, has_springs=True)
        self.forms = FormBody(u, residual, tangent)
        self._u, self._function, self._accept = u, evaluate, accept
        read = {*residual.coefficients(), *tangent.coefficients()}
        self._set = [f for f in sorted(read, key=lambda f: f.count()) if f is not u and hasattr(f, "x")]
        self._at: FloatArray | None = None  # displacement that the functions belong to; None: a step has ended since

    @property
    def tangent(self) -> EvaluatedTangent:
        return EvaluatedTangent(self)

    def in_cpp(self) -> _cpp.solve.Body:
        """C++ calls Python for what is evaluated."""
        return _cpp.solve.FunctionBody(
            residual=self._residual,
            tangent=self.tangent.assemble,
            fault=None,
            accept_step=self._accept_step,
            origin=None,
            stored_energy=None,
            properties=self.properties,
        )

    def _residual(self) -> PETSc.Vec:
        """Evaluate, then assemble internal minus external forces [F]. Collective."""
        self._u.x.scatter_forward()
        self._evaluate()
        return self.forms.in_cpp().residual()

    def _accept_step(self) -> None:
        """Tell the user that the present displacement is that of a converged step. Collective."""
        self._at = None
        if self._accept is not None:
            self._call(self._accept, "accept")

    def _evaluate(self) -> None:
        self._call(self._function, "evaluate")
        self._at = self._u.x.array.copy()
        for f in self._set:
            f.x.scatter_forward()

    def evaluate_if_changed(self) -> None:
        """Evaluate where the functions belong to another displacement. Collective."""
        here = self._at is not None and np.array_equal(self._at, self._u.x.array)
        comm = self._u.function_space.mesh.comm
        if comm.allreduce(int(here)) < comm.size:
            self._u.x.scatter_forward()
            self._evaluate()

    def _call(self, function: Evaluate, name: str) -> None:
        before = self._u.x.array.copy()
        error = attempt(function, self._u)[1]
        if error is None and not np.array_equal(before, self._u.x.array):
            error = ValueError(f"{name} has written to the displacement u, which it may only read")
        agree(self._u.function_space.mesh.comm, error, name)
