# SPDX-License-Identifier: MIT
"""Interfaces between problems and contacts: static contacts, with and without multipliers, and explicit ones.

A class that has the members of a protocol can be used in a problem; it need not derive from anything. Arrays are over
this rank's contact points or degrees of freedom; collective methods are called on all ranks at once. n is the number of
this rank's contact points, gdim the dimension of space. Forces act on the right-hand side: the residual of equilibrium
is internal minus external minus contact forces.

Newton's method in C++ sees these objects as the class StaticContact of cpp/dolfinx_impact/enforcement/StaticContact.h.

The order of the calls in one increment of Newton's method:

    begin_step
    per Newton iteration:  update_gap, add_residual or update_multipliers, update_active_set, violation,
                           update_nodal_stiffness, tangent, closing_forces
        per linear problem (multipliers): constraints, friction_springs, [solution], update_linearised_gap,
                                          update_multipliers or set_multipliers, update_active_set
    augment, then accept_step, or the copied state is assigned
"""

from typing import Protocol, runtime_checkable

from dolfinx.fem import Function, FunctionSpace
from petsc4py import PETSc

from .. import _cpp
from ..amplitude import Amplitude
from ..common.types import BoolArray, FloatArray, IntArray
from .pair import ContactPair


class ContactProblem(Protocol):
    """What a contact reads of any problem.

    Attributes:
        u: displacement function [L].
        space: displacement space.
        axisymmetric: whether x is the radius of an axisymmetric body.
    """

    u: Function
    space: FunctionSpace
    axisymmetric: bool


class BodyTangent(Protocol):
    """Derivative of the bodies' residual, in a matrix that is made once."""

    @property
    def matrix(self) -> PETSc.Mat:
        """The matrix [F/L]."""

    def assemble(self) -> PETSc.Mat:
        """Assemble the matrix at the present state [F/L]. Collective."""


class StaticContactProblem(ContactProblem, Protocol):
    """What a contact reads of a static problem.

    Attributes:
        fixed: mask of prescribed dofs, owned and ghosts.
        named_pairs: pairs of surfaces of its contacts, which general contact leaves alone.
    """

    fixed: BoolArray
    named_pairs: list[ContactPair]

    @property
    def tangent(self) -> BodyTangent:
        """Derivative of the bodies' residual."""


class ExplicitContactProblem(ContactProblem, Protocol):
    """What a contact reads of an explicit problem.

    Attributes:
        prescribed: mask of prescribed degrees of freedom, owned and ghosts.
        named_pairs: pairs of surfaces of its contacts, which general contact leaves alone.
    """

    prescribed: BoolArray
    named_pairs: list[ContactPair]
    _cpp_object: _cpp.problems.ExplicitProblem


@runtime_checkable
class StaticContact(Protocol):
    """A contact of one pair in a static problem.

    Attributes:
        pair: surfaces and friction coefficient.
        has_multipliers: whether it is a MultiplierContact.
    """

    pair: ContactPair
    has_multipliers: bool

    @property
    def displacement(self) -> FloatArray:
        """Displacement of a rigid master in the present increment, (3) [L]."""

    @property
    def fault(self) -> str:
        """Why a converged state is not a solution; empty if it is one."""

    @property
    def gap(self) -> FloatArray:
        """Gaps, (n), positive if open, infinite without master [L]."""

    @property
    def num_active(self) -> int:
        """Number of active points of all ranks. Collective."""

    @property
    def symmetric(self) -> bool:
        """Whether the tangent is symmetric in the present state. Collective."""

    # --- load steps --------------------------------------------------------------------------------------------------

    def check_parameters(self) -> None:
        """Refuse parameters that do not fit the problem, before a solution. Collective.

        Raises:
            ValueError: on all ranks.
        """

    def begin_step(self, u: FloatArray, displacement: FloatArray | None, target: FloatArray | None = None) -> None:
        """Begin an increment. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
            displacement: displacement of a rigid master at the end of the increment, (3); None for deformable masters
                [L].
            target: prescribed displacements at the end of the increment, over all dofs, of which the prescribed ones
                are read; None: they do not change [L].
        """

    def state(self) -> _cpp.state.State:
        """State from which an increment starts, as named arrays, views of this contact's memory: copy it before, assign
        the copy to go back."""

    def accept_step(self) -> None:
        """Accept a converged increment: slips, tractions and multipliers become history, totals are updated.
        Collective."""

    def augment(self) -> bool:
        """Begin another round after convergence if it is needed: augmented multipliers or new closest points.
        Collective; `fault` is set if further rounds do not help.

        Returns:
            Whether the iteration must continue.
        """

    def prescribed_overlap(self) -> str:
        """Describe prescribed displacements that cause penetration in a converged state. Collective.

        Returns:
            A sentence, or an empty text.
        """

    def passed_through(self) -> str:
        """Describe points that have passed through the master since the last converged state, and are open on its far
        side. Collective.

        Returns:
            A sentence, or an empty text.
        """

    # --- checkpoints -------------------------------------------------------------------------------------------------

    def saved_state(self) -> _cpp.state.State:
        """What a checkpoint holds of the last converged state, values of its own."""

    def resume(self, saved: _cpp.state.State, u: FloatArray) -> None:
        """Continue from what `saved_state` has returned, on these ranks or others. Collective.

        Args:
            saved: the state.
            u: displacements of the checkpoint, owned and ghost dofs [L].
        """

    # --- Newton iterations -------------------------------------------------------------------------------------------

    def update_gap(self, u: FloatArray) -> None:
        """Update candidates, gaps, normals, and tractions that follow from gaps. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """

    def update_multipliers(self, residual: FloatArray) -> None:
        """Update multipliers from equilibrium; contacts without multipliers do nothing.

        Args:
            residual: nodal residual without contact forces, owned dofs [F].
        """

    def update_active_set(self, first: bool, last: int | None = None) -> int:
        """Update which points are active and which of them stick. Collective.

        Args:
            first: whether the increment has just begun; then the gaps alone decide.
            last: global number of the only node that may change; None: all nodes.

        Returns:
            Number of points of all ranks whose state has changed or was wrong.
        """

    def contact_forces(self) -> FloatArray:
        """Assemble the nodal contact forces on both bodies. Collective.

        Returns:
            Forces, owned dofs [F].
        """

    def add_residual(self, b: PETSc.Vec) -> None:
        """Subtract the nodal contact forces from a residual. Collective.

        Args:
            b: residual [F].
        """

    def update_nodal_stiffness(self, K: PETSc.Mat) -> None:
        """Update the scale of force per displacement. Collective.

        Args:
            K: tangent of the bodies [F/L].
        """

    def tangent(self) -> PETSc.Mat | None:
        """Derivative of minus the contact force at given multipliers. Collective.

        Returns:
            Matrix of this contact, valid until the next call; None: the derivative is zero [F/L].
        """

    def violation(self) -> float:
        """Largest violation of the constraints on all ranks, relative to the size of the bodies. Collective.

        Returns:
            The violation [1].
        """

    def round_off(self) -> float:
        """Norm of the round-off in the contact forces. Collective.

        Returns:
            The norm; zero if the forces are unknowns [F].
        """

    def largest_violation(self) -> str:
        """Describe the point with the largest violation. Collective.

        Returns:
            A sentence, or an empty text.
        """

    def mesh_advice(self) -> str:
        """Describe what in the surfaces may keep a solve from converging. Collective.

        Returns:
            A sentence, or an empty text.
        """

    # --- bodies that are supported by contact alone ------------------------------------------------------------------

    def rigid_body_products(self, modes: _cpp.solve.RigidBodyModes) -> FloatArray:
        """Products of the active constraints applied to the rigid body modes. Collective.

        Args:
            modes: rigid body modes of the bodies.

        Returns:
            Sums over this rank's constraints, (num_modes, num_modes).
        """

    def close_nearest(self) -> bool:
        """Activate the points nearest to the master if the bodies nearly touch. Collective.

        Returns:
            Whether there are any.
        """

    def closing_forces(self) -> FloatArray | None:
        """Forces that close the gaps of the points of close_nearest. Collective.

        Returns:
            Forces to be subtracted from the right-hand side, owned dofs; None without such points [F].
        """


@runtime_checkable
class MultiplierContact(StaticContact, Protocol):
    """A static contact whose normal tractions are unknowns: an active set on the linearised problem.

    Attributes:
        nodes: owned nodes that may have a multiplier, (n).
        gdim: dimension of space.
        active: mask of nodes in contact, (n).
        sliding: mask of those that slip, (n).
        multiplier: multipliers of the nodes, (n) [F/L^2].
        last_change: largest global number of the nodes that the last update_active_set changed, -1 without any.
    """

    nodes: IntArray
    gdim: int
    active: BoolArray
    sliding: BoolArray
    multiplier: FloatArray
    last_change: int

    def gap_round_off(self) -> float:
        """Norm of the forces that close gaps of the size of their round-off. Collective.

        Returns:
            The norm [F].
        """

    def constraints(self) -> _cpp.multipliers.Constraints:
        """Constrained directions of the active nodes.

        Returns:
            C++ object.
        """

    def friction_springs(self) -> tuple[PETSc.Mat, FloatArray] | None:
        """Linearised tractions that change with the slip. Collective.

        Returns:
            Matrix [F/L] and forces to be subtracted from the right-hand side, owned dofs [F]; None without any.
        """

    def imposed_friction_forces(self) -> FloatArray | None:
        """Friction forces along prescribed directions. Collective.

        Returns:
            Forces, owned dofs; None without any [F].
        """

    def update_linearised_gap(self, increments: FloatArray) -> None:
        """Update gaps and slips of the linearised problem. Collective.

        Args:
            increments: increments of displacement since update_gap, owned dofs [L].
        """

    def linearised_response(self, increments: FloatArray, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
        """Linearised changes of gaps and multipliers without friction. Collective.

        Args:
            increments: increments of displacement, owned dofs [L].
            forces: forces that the increments cause, owned dofs [F].

        Returns:
            Changes of gaps, (n) [L], and of multipliers, (n) [F/L^2].
        """

    def correct_linearisation(self, u: FloatArray) -> None:
        """Second-order correction: add the differences of gaps and slips from the linearised ones. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """

    def set_multipliers(self, forces: FloatArray) -> None:
        """Set multipliers from the solution of a saddle point.

        Args:
            forces: forces along the constrained directions, zero elsewhere, (n, gdim) [F].
        """

    def num_turning(self) -> int:
        """Number of nodes of all ranks whose friction traction is not yet that of the law. Collective."""

    def set_redundant(self, nodes: IntArray) -> None:
        """Set the nodes whose normal condition a linear problem has left out, as others of the same nodes imply it.

        Args:
            nodes: index of the nodes.
        """

    def over_constrained(self) -> IntArray:
        """Owned nodes whose normal condition was left out in this increment, as others contradict it."""

    def rotate_friction_traction(self) -> None:
        """Rotate the friction tractions of the last iteration to the present tangent planes."""


@runtime_checkable
class ExplicitContact(Protocol):
    """A contact of one pair in an explicit problem: its C++ object adds forces inside the time step.

    Attributes:
        pair: surfaces and friction coefficient.
        nodes: owned slave nodes, (n).
        weight: areas of the nodes, (n) [L^2].
        motion: displacement of a rigid master as a function of time; None without one [L].
        stored: energy stored in the springs, of all ranks [F L].
        penetration_share: part of the deformation that is penetration; set by the problem [1].
    """

    pair: ContactPair
    nodes: IntArray
    weight: FloatArray
    motion: Amplitude | None
    stored: float
    penetration_share: float

    @property
    def kinematic(self) -> bool:
        """Whether the contact has no springs."""

    @property
    def is_penalty(self) -> bool:
        """Whether the contact acts by springs, which approximate surfaces that do not penetrate."""

    def sides(self) -> list[_cpp.nodal.NodeToSurface]:
        """C++ contacts of this pair.

        Returns:
            One contact, or for balanced contact one per direction.
        """

    def update_results(self) -> None:
        """Copy pressures, tractions and totals of the last step. Collective."""

    def results_state(self) -> tuple[_cpp.state.State, _cpp.state.State]:
        """Results for a checkpoint.

        Returns:
            Results by node, and totals.
        """

    def resume_results(self, rows: _cpp.state.State, totals: _cpp.state.State) -> None:
        """Set results from a checkpoint.

        Args:
            rows: results by node, as results_state returned them.
            totals: totals, as results_state returned them.
        """
