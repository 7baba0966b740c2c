# SPDX-License-Identifier: MIT
"""What static contacts in C++ have in common, as Python sees it."""

import logging

import numpy as np
from petsc4py import PETSc

from .. import _cpp
from ..common.types import FloatArray, IntArray
from .output import ContactOutput


INITIAL_PENETRATION = logging.getLogger("dolfinx_impact.initial_penetration")


class StaticContactView(ContactOutput):
    """A static contact whose state and algorithms are an object of C++; docs of the members: protocol.StaticContact.

    A derived class has the attributes `pair`, `comm`, `gdim` and `_cpp_object`.
    """

    _cpp_object: _cpp.multipliers.MortarContact | _cpp.penalty.QuadraturePenalty

    @property
    def fault(self) -> str:
        """Why a converged state is not a solution; empty if it is one."""
        return str(self._cpp_object.fault)

    @property
    def initial(self) -> _cpp.gap.InitialPenetration:
        """Penetrations in the reference configuration."""
        return self._cpp_object.initial

    def _tell_of_penetration(self) -> None:
        """Log penetrations in the reference configuration, on rank 0."""
        if self.initial.warning and self.comm.rank == 0:
            INITIAL_PENETRATION.warning(self.initial.warning)

    # --- load steps --------------------------------------------------------------------------------------------------

    def check_parameters(self) -> None:
        """Refuse parameters that do not fit the problem, before a solution. Collective.

        Raises:
            ValueError: on all ranks.
        """
        self._cpp_object.check_parameters()

    def begin_step(self, u: FloatArray, displacement: FloatArray | None, target: FloatArray | None = None) -> None:
        """Begin an increment. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
            displacement: displacement of a rigid master at the end of the increment, (3); None for deformable masters
                [L].
            target: prescribed displacements at the end of the increment, over all dofs, of which the prescribed ones
                are read; None: they do not change [L].
        """
        self._cpp_object.begin_step(u, None if displacement is None else list(map(float, displacement)), target)

    def state(self) -> _cpp.state.State:
        """State from which an increment starts, as named arrays, views of this contact's memory: copy it before, assign
        the copy to go back."""
        return self._cpp_object.state()

    def accept_step(self) -> None:
        """Accept a converged increment: tractions and slips become history, totals are updated. Collective."""
        self._cpp_object.accept_step()

    def augment(self) -> bool:
        """Begin another round after convergence if it is needed. Collective.

        Returns:
            Whether the iteration must continue.
        """
        return bool(self._cpp_object.augment())

    def prescribed_overlap(self) -> str:
        """Describe prescribed displacements that cause penetration in a converged state. Collective.

        Returns:
            A sentence, or an empty text.
        """
        return str(self._cpp_object.prescribed_overlap())

    def passed_through(self) -> str:
        """Describe points that have passed through the master since the last converged state. Collective.

        Returns:
            A sentence, or an empty text.
        """
        return str(self._cpp_object.passed_through())

    def saved_state(self) -> _cpp.state.State:
        """What a checkpoint holds of the last converged state, values of its own."""
        return self._cpp_object.saved_state()

    def resume(self, saved: _cpp.state.State, u: FloatArray) -> None:
        """Continue from what `saved_state` has returned, on these ranks or others. Collective.

        Args:
            saved: the state.
            u: displacements of the checkpoint, owned and ghost dofs [L].
        """
        self._cpp_object.resume(saved, np.ascontiguousarray(u))

    def forget(self) -> None:
        """Forget candidates and the places of the tangent; see ContactOutput."""
        self._cpp_object.forget()

    def stored_energy(self) -> float:
        """Energy of the springs of a penalty, of all ranks; zero with multipliers [F L]. Collective."""
        return float(self._cpp_object.stored_energy())

    # --- Newton iterations -------------------------------------------------------------------------------------------

    def update_gap(self, u: FloatArray) -> None:
        """Update candidates, gaps, normals, and tractions that follow from gaps. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """
        self._cpp_object.update_gap(np.ascontiguousarray(u))

    def update_active_set(self, first: bool, last: int | None = None) -> int:
        """Update which points are active and which of them stick. Collective.

        Args:
            first: whether the increment has just begun.
            last: global number of the only node that may change; None: all nodes.

        Returns:
            Number of points of all ranks whose state has changed or was wrong.
        """
        return int(self._cpp_object.update_active_set(first, last))

    def contact_forces(self) -> FloatArray:
        """Assemble the nodal contact forces on both bodies. Collective.

        Returns:
            Forces, owned dofs [F].
        """
        return np.asarray(self._cpp_object.contact_forces())

    def add_residual(self, b: PETSc.Vec) -> None:
        """Subtract the nodal contact forces from a residual. Collective.

        Args:
            b: residual [F].
        """
        self._cpp_object.add_residual(b)

    def update_nodal_stiffness(self, K: PETSc.Mat) -> None:
        """Update the scale of force per displacement. Collective.

        Args:
            K: tangent of the bodies [F/L].
        """
        self._cpp_object.update_nodal_stiffness(K)

    def tangent(self) -> PETSc.Mat | None:
        """Derivative of minus the contact force. Collective.

        Returns:
            Matrix of this contact, valid until the next call; None: the derivative is zero [F/L].
        """
        return self._cpp_object.tangent()

    @property
    def symmetric(self) -> bool:
        """Whether the tangent is symmetric in the present state. Collective."""
        return bool(self._cpp_object.symmetric)

    @property
    def num_active(self) -> int:
        """Number of closed points of all ranks. Collective."""
        return int(self._cpp_object.num_active)

    def violation(self) -> float:
        """Largest violation of the constraints on all ranks, relative to the size of the bodies. Collective.

        Returns:
            The violation [1].
        """
        return float(self._cpp_object.violation())

    def round_off(self) -> float:
        """Norm of the round-off in the contact forces. Collective.

        Returns:
            The norm [F].
        """
        return float(self._cpp_object.round_off())

    def largest_violation(self) -> str:
        """Describe the point with the largest violation of the constraints. Collective.

        Returns:
            A sentence, or an empty text.
        """
        return str(self._cpp_object.largest_violation())

    def mesh_advice(self) -> str:
        """Describe what in the surfaces may keep a solve from converging. Collective.

        Returns:
            A sentence, or an empty text.
        """
        return str(self._cpp_object.mesh_advice())

    def rigid_body_products(self, modes: _cpp.solve.RigidBodyModes) -> FloatArray:
        """Active constraints applied to the rigid body modes: their products. Collective.

        Args:
            modes: rigid body modes of the bodies.

        Returns:
            Sums over this rank's rows, (modes.num_modes, modes.num_modes).
        """
        return np.asarray(self._cpp_object.rigid_body_products(modes))

    def close_nearest(self) -> bool:
        """Activate the points nearest to the master if the bodies nearly touch. Collective.

        Bodies that are supported by contact alone need this: the forces of `closing_forces` bring them into contact.

        Returns:
            Whether there are any.
        """
        return bool(self._cpp_object.close_nearest())

    # --- results -----------------------------------------------------------------------------------------------------

    @property
    def points(self) -> FloatArray:
        """Present positions, (n, gdim) [L]."""
        return self._rows(self._cpp_object.points)

    @property
    def gap(self) -> FloatArray:
        """Gaps, (n), positive if open, infinite without master [L]."""
        return np.asarray(self._cpp_object.gap)

    @property
    def normal(self) -> FloatArray:
        """Unit normals out of the master, (n, gdim) [1]."""
        return self._rows(self._cpp_object.normal)

    @property
    def pressure(self) -> FloatArray:
        """Contact pressure per reference area, (n) [F/L^2]; at_nodes(contact.pressure) is smoother in plots."""
        return np.asarray(self._cpp_object.pressure)

    @property
    def traction(self) -> FloatArray:
        """Contact traction on the slave per reference area, (n, gdim) [F/L^2]."""
        return self._rows(self._cpp_object.traction)

    @property
    def slip(self) -> FloatArray:
        """Tangential displacement of slave relative to master, accumulated in contact, (n, gdim) [L]."""
        return self._rows(self._cpp_object.slip)

    @property
    def status(self) -> IntArray:
        """ContactStatus numbers, (n)."""
        return np.asarray(self._cpp_object.status)

    @property
    def weight(self) -> FloatArray:
        """Area of each point, a length in 2D, (n) [L^2]."""
        return np.asarray(self._cpp_object.weight)

    def covered(self) -> FloatArray:
        """Part of each point's area that is in contact. Collective.

        Returns:
            Fractions, (n) [1].
        """
        return np.asarray(self._cpp_object.covered())

    def _rows(self, values: FloatArray) -> FloatArray:
        """A flat array as vectors, (n, gdim)."""
        return values.reshape(-1, self.gdim)
