# SPDX-License-Identifier: MIT
"""Bodies with a residual whose stress a user's function computes, for example at quadrature points."""

from __future__ import annotations

from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..common.collective import agree, attempt
from ..common.types import FloatArray
from .body import BodyTangent
from .elastic_body import ElasticBody

Evaluate: TypeAlias = Callable[[fem.Function], object]
"""Function of the displacement, which sets other functions."""


class EvaluatedTangent:
    """Tangent whose functions are those of the present displacement.

    Args:
        tangent: the matrix of the form.
        evaluate: function that brings its functions up to date, where they are not.
    """

    def __init__(self, tangent: BodyTangent, evaluate: Callable[[], None]) -> None:
        self._tangent, self._evaluate = tangent, evaluate

    @property
    def matrix(self) -> PETSc.Mat:
        """The matrix [F/L]."""
        return self._tangent.matrix

    def assemble(self) -> PETSc.Mat:
        """Assemble the matrix at the present displacement. Collective."""
        self._evaluate()
        return self._tangent.assemble()


class EvaluatedBody(ElasticBody):
    """Bodies whose residual and tangent read functions that a user sets for every displacement; see Body.

    Args:
        u: displacement function [L].
        residual: UFL form of the internal minus the external forces, of rank 1.
        tangent: UFL form of its derivative, of rank 2.
        evaluate: function that is called before the residual is assembled.
        accept: function that is called when a step has converged, or None.

    Attributes:
        inelastic: True: what is evaluated may depend on a history.
    """

    inelastic = True

    def __init__(
        self, u: fem.Function, residual: ufl.Form, tangent: ufl.Form, evaluate: Evaluate, accept: Evaluate | None
    ) -> None:
        super().__init__(u, residual, tangent, has_springs=True)
        self._u, self._function, self._accept = u, evaluate, accept
        read = {*residual.coefficients(), *tangent.coefficients()}
        self._set = [f for f in sorted(read, key=lambda f: f.count()) if f is not u and hasattr(f, "x")]
        self._at: FloatArray | None = None  # displacement that the functions belong to; None: a step has ended since
        self.tangent = EvaluatedTangent(self.tangent, self._evaluate_if_changed)
        self.linear = self.keeps_tangent = False

    def add_residual(self, b: PETSc.Vec) -> None:
        """Evaluate, then add internal minus external forces, on owned and ghost entries [F]. Collective.

        Args:
            b: vector with ghosts.
        """
        self._evaluate()
        super().add_residual(b)

    def accept_step(self) -> None:
        """Tell the user that the present displacement is that of a converged step. Collective."""
        self._at = None
        if self._accept is not None:
            self._call(self._accept, "accept")

    def _evaluate(self) -> None:
        self._call(self._function, "evaluate")
        self._at = self._u.x.array.copy()
        for f in self._set:
            f.x.scatter_forward()

    def _evaluate_if_changed(self) -> None:
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
