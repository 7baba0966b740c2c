# SPDX-License-Identifier: MIT
"""Bodies with inertia and damping over one step, as Newton's method sees them."""

from __future__ import annotations

import numpy as np
from dolfinx import fem
from petsc4py import PETSc

from ...common.described import Described
from ...common.types import FloatArray
from ...statics.body import Body
from .damping import DampingForce
from .inertia import Inertia
from .motion import State, StepMotion


class MovingBody(Described):
    """Equilibrium M a_1 + C v_1 + F(u_1) at the end of a step as a residual in u_1; see statics.body.Body.

    Args:
        body: bodies without inertia.
        displacement: the problem's displacement function [L].
        velocity: function that terms of the damping read [L/T].
        inertia: mass matrix.
        alpha: factor of mass-proportional damping [1/T].
        damping: other forces that depend on the velocity; None: there are none.

    Attributes:
        body: bodies without inertia.
        inertia: mass matrix.
        tangent: this object.
        origin: displacements at the start of the step, over owned degrees of freedom [L].
        matrix: the matrix [F/L].
        linear: whether the tangent is the same in all steps of one size.
        keeps_tangent: as linear.
        symmetric: whether the tangent is symmetric, as far as is known.
        inelastic: whether the bodies have internal variables.
        has_inertia: True: the bodies need no supports.
        has_springs: as of the bodies.
    """

    has_inertia = True

    def __init__(
        self,
        body: Body,
        displacement: fem.Function,
        velocity: fem.Function,
        inertia: Inertia,
        alpha: float,
        damping: DampingForce | None,
    ) -> None:
        self.body, self.inertia, self.alpha, self.damping = body, inertia, alpha, damping
        self.displacement, self.velocity = displacement, velocity
        self.linear = body.keeps_tangent and (damping is None or damping.linear)
        self.keeps_tangent = self.linear
        self.symmetric = body.symmetric and damping is None
        self.inelastic, self.has_springs = body.inelastic, body.has_springs
        self.tangent = self
        self._num_owned = len(inertia.massless)
        self._step: StepMotion | None = None
        self.origin: FloatArray | None = None
        self._mass: PETSc.Mat | None = None  # mass and its damping, scaled by the factors of the step
        self._factors: list[FloatArray] = []  # that `_mass` and the tangent of linear bodies were made with
        self._linear_tangent: PETSc.Mat | None = None

    def begin_step(self, step: StepMotion) -> None:
        """Begin a step; the displacement function must have its start value, ghosts included. Collective.

        Args:
            step: acceleration and velocity as functions of the new displacement.
        """
        self._step = step
        self.origin = self.displacement.x.array[: self._num_owned].copy()
        factors = [step.acceleration_factor + self.alpha * step.velocity_factor, step.velocity_factor]
        comm = self.inertia.matrix.comm.tompi4py()
        known = bool(self._factors) and all(np.array_equal(a, b) for a, b in zip(factors, self._factors))
        if comm.allreduce(int(known)) == comm.size:
            return
        self._factors = factors
        for matrix in (self._mass, self._linear_tangent):
            if matrix is not None:
                matrix.destroy()
        self._linear_tangent = None
        self._mass = self.inertia.matrix.copy()
        self._mass.diagonalScale(None, self._vector(factors[0]))

    def _vector(self, values: FloatArray) -> PETSc.Vec:
        vector = self.inertia.matrix.createVecRight()
        vector.array[:] = values
        return vector

    @property
    def step(self) -> StepMotion:
        """The present step."""
        assert self._step is not None  # begin_step has set it
        return self._step

    def end_of_step(self) -> State:
        """Motion at the end of the step, with the present displacement."""
        return self.step.end(self.displacement.x.array[: self._num_owned])

    def inertia_forces(self, state: State) -> FloatArray:
        """Forces of inertia and damping, M a + C v; the velocity function is set. Collective.

        Args:
            state: motion.

        Returns:
            Forces over owned degrees of freedom [F].
        """
        return self.inertia.times(state.acceleration) + self.damping_forces(state)

    def damping_forces(self, state: State) -> FloatArray:
        """Forces of damping, C v; the velocity function is set. Collective.

        Args:
            state: motion.

        Returns:
            Forces over owned degrees of freedom [F].
        """
        self.velocity.x.array[: self._num_owned] = state.velocity
        total = np.zeros(self._num_owned)
        if self.alpha > 0.0:
            total += self.alpha * self.inertia.times(state.velocity)
        if self.damping is not None:
            total += self.damping.forces()
        return total

    # --- what Newton's method asks for -------------------------------------------------------------------------------

    @property
    def matrix(self) -> PETSc.Mat:
        """The matrix of the last `assemble` [F/L]."""
        return self.body.tangent.matrix if self._linear_tangent is None else self._linear_tangent

    def vector(self) -> PETSc.Vec:
        """Make a vector for the residual, with ghosts."""
        return self.body.vector()

    def add_residual(self, b: PETSc.Vec) -> None:
        """Add inertia, damping and internal minus external forces, on owned and ghost entries [F]. Collective.

        Args:
            b: vector with ghosts.
        """
        forces = self.inertia_forces(self.end_of_step())
        self.body.add_residual(b)
        with b.localForm() as local:
            local.array[: self._num_owned] += forces

    def assemble(self) -> PETSc.Mat:
        """Assemble the derivative of the residual with respect to the displacement at the end of the step. Collective.

        Returns:
            The matrix of this object; the next call overwrites it [F/L].
        """
        assert self._mass is not None  # begin_step has made it
        if self._linear_tangent is not None:
            return self._linear_tangent
        total = self.body.tangent.assemble()
        if self.linear:
            total = total.copy()
        total.axpy(1.0, self._mass, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
        if self.damping is not None:
            factors = self._vector(self._factors[1])
            for matrix in self.damping.tangent(factors):
                total.axpy(1.0, matrix, PETSc.Mat.Structure.SUBSET_NONZERO_PATTERN)
            factors.destroy()
        if self.linear:
            self._linear_tangent = total
        return total

    def fault(self) -> str:
        """Why the last residual could not be computed; an empty text if it could. Collective."""
        return self.body.fault()

    def accept_step(self) -> None:
        """Take the state of the last residual as the one that the next step begins from."""
        self.body.accept_step()
