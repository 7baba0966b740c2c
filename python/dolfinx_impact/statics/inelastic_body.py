# SPDX-License-Identifier: MIT
"""Bodies with internal variables: force and history by our kernels in one pass, the tangent by DOLFINx."""

from __future__ import annotations

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..assembly.ffcx_form import ffcx_form
from ..common.described import Described
from ..assembly.history import MaterialHistory
from ..assembly.inelastic_part import InelasticParts, set_values
from ..assembly.inelastic_tangent import InelasticTangent
from ..assembly.operators import InternalForce
from ..common.types import FloatArray
from ..forms.inelastic import UNKNOWN


class InelasticBody(Described):
    """Bodies of which at least one has internal variables; see Body.

    Args:
        u: displacement function [L].
        parts: inelastic parts.
        residual: UFL form of the rest of the residual: elastic parts, minus external forces; None: there is none.
        tangent: UFL form of the derivative of that rest; None: it is zero.
        has_springs: whether springs to the ground may hold the bodies.

    Attributes:
        tangent: derivative of the residual.
        linear, keeps_tangent: False.
        symmetric: False: kinematic hardening with recovery and finite strain make it unsymmetric.
        inelastic: True.
        has_inertia: False.
        has_springs: as given.
        force: operator of the internal forces, which keeps the history.
        history: internal variables by name.
    """

    linear = False
    keeps_tangent = False
    symmetric = False
    inelastic = True
    has_inertia = False

    def __init__(
        self,
        u: fem.Function,
        parts: InelasticParts,
        residual: ufl.Form | None,
        tangent: ufl.Form | None,
        has_springs: bool = False,
    ) -> None:
        self.has_springs = has_springs
        self.u, self.space, self.parts = u, u.function_space, parts
        form, laws = parts.force(ufl.TestFunction(self.space))
        self.force = InternalForce(form, law=laws)
        # By itself: cells with a point law take one quadrature rule, loads may need another one.
        self._rest = None if residual is None else InternalForce(residual)
        self.history = MaterialHistory(parts, self.force.history)
        self._functions = self.history.functions()
        self.tangent = self
        self._tangent = InelasticTangent(u, list(parts), self._functions, tangent)
        self.matrix: PETSc.Mat = self._tangent.matrix
        self.matrix.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        self._values: FloatArray = self.force.vector().array
        self._vector_form = ffcx_form(ufl.inner(u, ufl.TestFunction(self.space)) * ufl.dx)

    @property
    def origin(self) -> None:
        """None: forces are measured from zero displacement."""
        return None

    def vector(self) -> PETSc.Vec:
        """Make a vector for the residual, with ghosts."""
        return petsc.create_vector(self._vector_form)

    def add_residual(self, b: PETSc.Vec) -> None:
        """Add internal minus external forces, on owned and ghost entries [F]. The new history is kept beside that of
        the last step. Collective.

        Args:
            b: vector with ghosts.
        """
        self._values[:] = 0.0
        self.force.assemble(self._values)
        if self._rest is not None:
            self._rest.assemble(self._values)
        with b.localForm() as local:
            local.array[:] += self._values

    def assemble(self) -> PETSc.Mat:
        """Assemble the tangent at the history of the last step and the local unknowns of the last residual. Collective.

        Returns:
            The matrix of this object; the next call overwrites it.
        """
        points = self.force.history
        for functions in self._functions:
            cells = np.arange(points.num_cells, dtype=np.int32)
            for name, f in functions.history.items():
                set_values(f, cells, points.values(name))
            if functions.unknown is not None:
                set_values(functions.unknown, cells, points.values(UNKNOWN, trial=True))
        return self._tangent.assemble()

    def fault(self) -> str:
        """Which local equations the last residual could not solve; an empty text if it could. Collective."""
        return self.force.fault()

    def accept_step(self) -> None:
        """Commit the history of the last residual."""
        self.force.history.commit()
