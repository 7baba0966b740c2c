# SPDX-License-Identifier: MIT
"""What problems ask of a contact: the interface of static contacts, with and without multipliers, and of explicit ones.

A class that has these members can be put into a problem; it need not derive from anything. Arrays are over this rank's
contact points or degrees of freedom; what is called collective is called on all ranks at once. n is the number of this
rank's contact points, gdim the dimension of space. Forces act on the right-hand side: the residual of equilibrium is
internal minus external minus contact forces.

Newton loops in C++ ask for the part of it that they call: the concepts RegularisedContact and MultiplierContact of
cpp/dolfinx_impact/enforcement/StaticContact.h.

The order of the calls in one increment of statics.newton.Newton:

    begin_step
    per Newton iteration:  update_gap, add_residual or update_multipliers, update_active_set, violation,
                           update_nodal_stiffness, tangent, closing_forces
        per linear problem (multipliers): constraints, friction_springs, [solution], update_linearised_gap,
                                          update_multipliers or set_multipliers, update_active_set
    augment, then accept_step or restore_state
"""

from typing import Any, Protocol, runtime_checkable

import numpy as np
from petsc4py import PETSc

from .pair import ContactPair


@runtime_checkable
class StaticContact(Protocol):
    """A contact of one pair in a static problem.

    Attributes:
        pair: what meets what, and the friction coefficient.
        has_multipliers: it is a MultiplierContact.
        displacement: of a rigid master in the present increment, (3) [L].
        fault: why a converged state is none; empty if it is one.
    """

    pair: ContactPair
    has_multipliers: bool
    displacement: np.ndarray
    fault: str

    @property
    def gap(self) -> np.ndarray:
        """Gaps, (n), positive open, infinite without master [L]."""

    @property
    def num_active(self) -> int:
        """Points in contact, of all ranks. Collective."""

    @property
    def symmetric(self) -> bool:
        """Is the tangent symmetric in the present state? Collective."""

    # --- load steps --------------------------------------------------------------------------------------------------

    def check_parameters(self) -> None:
        """Refuse parameters that do not fit the problem, before a solution. Collective.

        Raises:
            ValueError: on all ranks.
        """

    def begin_step(self, u: np.ndarray, displacement: np.ndarray | None, target: np.ndarray | None = None) -> None:
        """An increment starts. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
            displacement: of a rigid master at the end of the increment, (3); None for deformable masters [L].
            target: prescribed values at its end, over all dofs, prescribed entries count; None: they stay [L].
        """

    def save_state(self) -> dict:
        """Copies of what an increment starts from."""

    def restore_state(self, state: dict) -> None:
        """Back to a state of save_state."""

    def accept_step(self) -> None:
        """The increment has converged: slips, tractions and multipliers are history; totals are updated. Collective."""

    def augment(self) -> bool:
        """After convergence: start another round (augmentation of multipliers, new closest points)?

        Returns:
            whether the iteration must go on; `fault` is set where rounds do not help. Collective.
        """

    def prescribed_overlap(self) -> str:
        """A sentence about prescribed displacements that overlap in a converged state, or an empty text. Collective."""

    # --- Newton iterations -------------------------------------------------------------------------------------------

    def update_gap(self, u: np.ndarray) -> None:
        """Search, gaps and normals, and the tractions that follow from them alone. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """

    def update_multipliers(self, residual: np.ndarray) -> None:
        """Multipliers from equilibrium; contacts whose tractions follow from gaps do nothing.

        Args:
            residual: nodal, owned dofs, without contact forces [F].
        """

    def update_active_set(self, first: bool, last: int | None = None) -> int:
        """Change who is in contact and who sticks. Collective.

        Args:
            first: the increment has just begun: only gaps count.
            last: change no node but the one with this global number; None: all.

        Returns:
            number of points of all ranks whose state is wrong, or was.
        """

    def contact_forces(self) -> np.ndarray:
        """Nodal contact forces on both bodies, owned dofs [F]. Collective."""

    def add_residual(self, b: PETSc.Vec) -> None:
        """Subtract the nodal contact forces from the residual b [F]. Collective."""

    def update_nodal_stiffness(self, K: PETSc.Mat) -> None:
        """Take the scale of forces per displacement from the tangent of the bodies [F/L]. Collective."""

    def tangent(self) -> PETSc.Mat | None:
        """Derivative of minus the contact force at given multipliers [F/L]; None: it is zero.

        The matrix is the contact's, valid until the next call. Collective.
        """

    def violation(self) -> float:
        """Largest violation of the constraints, of all ranks, in sizes of the bodies [1]. Collective."""

    def largest_violation(self) -> str:
        """A sentence about the point that violates its constraint most, or an empty text. Collective."""

    def coarse_slave(self) -> str:
        """A sentence about a slave much coarser than its master, or an empty text. Collective."""

    # --- bodies that only contact holds ------------------------------------------------------------------------------

    def rigid_body_constraints(self, motions: Any) -> list:
        """Rows of the active constraints applied to the rigid body modes. Collective.

        Args:
            motions: rigid_body_modes.RigidBodyModes.

        Returns:
            list of arrays (points, motions.num_modes).
        """

    def close_nearest(self) -> bool:
        """Close the points nearest to the master if the bodies nearly touch; were there any? Collective."""

    def closing_forces(self) -> np.ndarray | None:
        """Forces that draw points of close_nearest together, owned dofs [F], subtracted from the right-hand side; None
        without any. Collective."""


@runtime_checkable
class MultiplierContact(StaticContact, Protocol):
    """A static contact whose normal tractions are unknowns: an active set on the linearised problem.

    Attributes:
        nodes: (n) owned nodes that may carry a multiplier. gdim: components of a node's displacement.
        last_change: largest global number of the nodes that the last update_active_set found wrong, -1 without any.
    """

    nodes: np.ndarray
    gdim: int
    last_change: int

    def constraints(self) -> Any:
        """Constrained directions of the active nodes: Constraints (C++)."""

    def friction_springs(self) -> tuple[PETSc.Mat, np.ndarray] | None:
        """What Newton's method sees of tractions that change with the slip: a matrix [F/L], and forces over owned dofs
        that are subtracted from the right-hand side [F]; None without any. Collective."""

    def imposed_friction_forces(self) -> np.ndarray | None:
        """Forces of friction along prescribed directions, owned dofs [F]; None without any. Collective."""

    def update_linearised_gap(self, increments: np.ndarray) -> None:
        """Gaps and slips of the linearised problem. Collective.

        Args:
            increments: of displacement since update_gap, owned dofs [L].
        """

    def linearised_response(self, increments: np.ndarray, forces: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        """What gaps and multipliers gain by increments of displacement and the forces they cause, without friction.

        Returns:
            gaps (n) [L], multipliers (n) [F/L^2]. Collective.
        """

    def correct_linearisation(self, u: np.ndarray) -> None:
        """Second-order correction: add what gaps and slips at u differ from the linearised ones. Collective."""

    def set_multipliers(self, forces: np.ndarray) -> None:
        """Multipliers from the solution of a saddle point.

        Args:
            forces: (n, gdim) along the constrained directions, zero elsewhere [F].
        """

    def rotate_friction_traction(self) -> None:
        """Friction tractions of the last iteration follow the surface to the present state."""


@runtime_checkable
class ExplicitContact(Protocol):
    """A contact of one pair in an explicit problem: forces are added by its C++ object inside the time step.

    Attributes:
        pair: what meets what. nodes: (n) owned slave nodes. weight: (n) their areas [L^2].
        motion: displacement of a rigid master, a function of time; None without one.
    """

    pair: ContactPair
    nodes: np.ndarray
    weight: np.ndarray
    motion: Any

    def check_start(self) -> None:
        """Refuse bodies that overlap by more than half a facet. Collective.

        Raises:
            ValueError: on all ranks.
        """

    def spring_frequency(self) -> float:
        """Upper bound of the angular frequency that given contact stiffness adds, 0 without [1/T]. Collective."""

    def sides(self) -> list:
        """C++ contacts: one, or for balanced contact one per direction."""

    def reset_history(self) -> None:
        """Friction and energies begin anew, all nodes open."""

    def update_results(self) -> None:
        """Copy pressures, tractions and totals of the last step. Collective."""

    def save_results(self) -> tuple[np.ndarray, np.ndarray]:
        """Results for a checkpoint: rows by node, and totals."""

    def restore_results(self, rows: np.ndarray, totals: np.ndarray) -> None:
        """Results as save_results gave them."""
