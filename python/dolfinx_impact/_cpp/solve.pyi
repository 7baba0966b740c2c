# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Callable, Mapping, Sequence
from typing import Any

import dolfinx.cpp
import mpi4py.MPI
import numpy
from numpy.typing import NDArray
import petsc4py.PETSc

import dolfinx_impact._cpp

class ActiveSetIteration:
    """Updates active sets without cycling"""

    def __init__(self) -> None: ...
    def change(self, contacts: Sequence[dolfinx_impact._cpp.enforcement.MultiplierContact]) -> int:
        """Update the active sets; returns how many nodes were wrong. Collective"""

class Body:
    """Bodies of a problem: residual and tangent"""

    def residual(self) -> petsc4py.PETSc.Vec:
        """Borrowed until the next call. Collective"""

    def tangent(self) -> petsc4py.PETSc.Mat:
        """Borrowed until the next call. Collective"""

    def fault(self) -> str:
        """Why the last residual could not be computed. Collective"""

    def accept_step(self) -> None:
        """The state of the last residual is what the next step begins from"""

    def stored_energy(self) -> float | None:
        """None: it is not known. Collective"""

    @property
    def properties(self) -> BodyProperties:
        """What is known of them"""

class BodyProperties:
    """What is known of bodies beforehand"""

    def __init__(
        self,
        *,
        linear: bool = False,
        keeps_tangent: bool = False,
        symmetric: bool = True,
        inelastic: bool = False,
        has_inertia: bool = False,
        has_springs: bool = False,
        rounds_positions: bool = False,
    ) -> None: ...
    @property
    def linear(self) -> bool:
        """The tangent does not change with the displacement"""

    @property
    def keeps_tangent(self) -> bool:
        """It does not change with time either"""

    @property
    def symmetric(self) -> bool:
        """The tangent is symmetric"""

    @property
    def inelastic(self) -> bool:
        """There are internal variables"""

    @property
    def has_springs(self) -> bool:
        """Springs to the ground may hold the bodies"""

    @property
    def rounds_positions(self) -> bool:
        """Round-off of positions enters the forces"""

class CondensedSystem(LinearSystem):
    """Multipliers condensed, or no multipliers"""

    def __init__(
        self,
        K: petsc4py.PETSc.Mat,
        extra: list[petsc4py.PETSc.Mat],
        symmetric: bool,
        condensation: dolfinx_impact._cpp.multipliers.Condensation | None,
        pinned: NDArray[numpy.bool_],
        diagonal: float,
    ) -> None: ...
    def columns(self, unknowns: NDArray[numpy.integer[Any]]) -> petsc4py.PETSc.Mat:
        """Columns of the matrix. Collective"""

class EquilibriumProblem:
    """Bodies and contacts in equilibrium"""

    def __repr__(self) -> str: ...
    @property
    def body(self) -> Body: ...
    @property
    def linear_solver(self) -> LinearSolver: ...

class FunctionBody(Body):
    """Bodies whose residual and tangent are functions"""

    def __init__(
        self,
        residual: Callable[[], petsc4py.PETSc.Vec],
        tangent: Callable[[], petsc4py.PETSc.Mat],
        fault: Callable[[], str] | None,
        accept_step: Callable[[], None] | None,
        origin: Callable[[], NDArray[numpy.floating[Any]]] | None,
        stored_energy: Callable[[], float | None] | None,
        properties: BodyProperties,
    ) -> None: ...

class Increment:
    """Iterations of one attempt at an increment; lists are copies"""

    def __init__(self, unsettled_in_succession: int = 0) -> None: ...
    def add(self, norm: float, size: int, changes: int) -> None:
        """Add an iteration"""

    def converged(self) -> Increment:
        """Mark the increment as converged"""

    def failed(self, fault: str, hopeless: bool = False, advice: str | None = None) -> Increment:
        """Mark the increment as failed"""

    def cycle(self) -> int:
        """Period of a cycle in the last iterations; 0: no cycle"""

    def stalled(self) -> bool:
        """Whether active sets did not converge, and the residual does not fall"""

    @property
    def fault(self) -> str: ...
    @fault.setter
    def fault(self, arg: str, /) -> None: ...
    @property
    def advice(self) -> str: ...
    @advice.setter
    def advice(self, arg: str, /) -> None: ...
    @property
    def iterations(self) -> int: ...
    @iterations.setter
    def iterations(self, arg: int, /) -> None: ...
    @property
    def unsettled(self) -> int: ...
    @unsettled.setter
    def unsettled(self, arg: int, /) -> None: ...
    @property
    def unsettled_in_succession(self) -> int: ...
    @unsettled_in_succession.setter
    def unsettled_in_succession(self, arg: int, /) -> None: ...
    @property
    def residual_norms(self) -> list[float]: ...
    @property
    def active_set_sizes(self) -> list[int]: ...
    @property
    def changes(self) -> list[int]: ...
    @property
    def closed(self) -> list[bool]: ...
    @closed.setter
    def closed(self, arg: Sequence[bool], /) -> None: ...

class IncrementSolver:
    """Solves increments by the SNES that PETSc's options choose"""

    def __init__(
        self,
        problem: EquilibriumProblem,
        rtol: float,
        atol: float,
        max_iterations: int,
        log: Callable[[str], None] | None,
        progress: Callable[[str], None] | None,
        iteration: Callable[[int, float, float, int, int], None] | None,
    ) -> None:
        """Collective"""

    def run(self, target: NDArray[numpy.floating[Any]]) -> Increment:
        """Solve from the present displacements to prescribed values. Collective"""

    def forget(self) -> None:
        """Forget what was kept from earlier increments. Collective"""

    def free(self) -> None:
        """Give back the memory of PETSc's objects. Collective"""

class LinearSolver:
    """A KSP with options of its own; every solution is checked"""

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        options: Mapping[str, str],
        prefix: str,
        indefinite: bool,
        limits: LinearSolverLimits,
        warn: Callable[[str], None],
    ) -> None:
        """Collective"""

    def solve(self, system: LinearSystem, b: petsc4py.PETSc.Vec, x: petsc4py.PETSc.Vec, rtol: float = 1e-10) -> str:
        """Solve; returns what is wrong, or an empty text. Collective"""

    @property
    def factors(self) -> petsc4py.PETSc.Mat | None:
        """Factors of the system that was factorised last; None if there are none"""

    def set_up(self, system: LinearSystem) -> None:
        """Make the preconditioner of a system now. Collective"""

    @property
    def null_pivots(self) -> int: ...
    def reset(self) -> None:
        """Forget the preconditioner. Collective"""

    def warn_of_unused(self) -> None: ...
    def set_near_nullspace(self, A: petsc4py.PETSc.Mat) -> None: ...
    @property
    def direct(self) -> bool: ...
    @property
    def ksp(self) -> petsc4py.PETSc.KSP: ...
    @property
    def prefix(self) -> str: ...
    @property
    def num_set_ups(self) -> int: ...
    @property
    def num_iterations(self) -> int: ...

class LinearSolverLimits:
    """Which systems are factorised, by dimension of the mesh"""

    def __init__(self) -> None: ...
    @property
    def largest_direct(self) -> list[int]: ...
    @largest_direct.setter
    def largest_direct(self, arg: Sequence[int], /) -> None: ...
    @property
    def largest_last_resort(self) -> list[int]: ...
    @largest_last_resort.setter
    def largest_last_resort(self, arg: Sequence[int], /) -> None: ...
    @property
    def keep_preconditioner(self) -> bool: ...
    @keep_preconditioner.setter
    def keep_preconditioner(self, arg: bool, /) -> None: ...
    @property
    def patience(self) -> int: ...
    @patience.setter
    def patience(self, arg: int, /) -> None: ...

class LinearSystem:
    """A linear system whose unknowns stand for increments of displacement"""

    def mult(self, x: petsc4py.PETSc.Vec, y: petsc4py.PETSc.Vec) -> None:
        """y = A x. Collective"""

    def assemble(self) -> petsc4py.PETSc.Mat:
        """A as a matrix of its own. Collective"""

    def load(self, residual: NDArray[numpy.floating[Any]], values: petsc4py.PETSc.Vec, b: petsc4py.PETSc.Vec) -> None:
        """Right-hand side. Collective"""

    def displacements(self, y: petsc4py.PETSc.Vec) -> NDArray[numpy.float64]:
        """Increments of displacement that unknowns stand for. Collective"""

    def create_vector(self) -> petsc4py.PETSc.Vec:
        """A vector of the unknowns"""

    @property
    def pinned(self) -> NDArray[numpy.bool_]: ...
    @property
    def symmetric(self) -> bool: ...

class LoadStepReport:
    """Course of a solve; lists are copies"""

    @property
    def converged(self) -> bool: ...
    @property
    def iterations(self) -> list[int]: ...
    @property
    def residual_norms(self) -> list[list[float]]: ...
    @property
    def active_set_sizes(self) -> list[list[int]]: ...
    @property
    def contact_changes(self) -> list[list[int]]: ...
    @property
    def fractions(self) -> list[float]: ...
    @property
    def cut_backs(self) -> int: ...
    @property
    def rejected_iterations(self) -> list[int]: ...
    @property
    def unsettled(self) -> list[int]: ...
    @property
    def brought_together(self) -> list[str]: ...
    @property
    def lost(self) -> list[str]: ...
    @property
    def seconds(self) -> dict[str, float]: ...

class Newton:
    """Newton's method for equilibrium and contact"""

    def __init__(self, problem: EquilibriumProblem, options: NewtonOptions) -> None:
        """Collective"""

    def run(
        self,
        target: NDArray[numpy.floating[Any]],
        log: Callable[[str], None],
        progress: Callable[[str], None],
        iteration: Callable[[int, float, float, int, int], None],
    ) -> Increment:
        """Solve from the present displacements to prescribed values. Collective"""

    @property
    def seconds(self) -> dict[str, float]: ...

class NewtonOptions:
    """Tolerances and limits of Newton's method"""

    def __init__(self) -> None: ...
    @property
    def rtol(self) -> float: ...
    @rtol.setter
    def rtol(self, arg: float, /) -> None: ...
    @property
    def atol(self) -> float: ...
    @atol.setter
    def atol(self, arg: float, /) -> None: ...
    @property
    def max_iterations(self) -> int: ...
    @max_iterations.setter
    def max_iterations(self, arg: int, /) -> None: ...
    @property
    def violation(self) -> float: ...
    @violation.setter
    def violation(self, arg: float, /) -> None: ...
    @property
    def max_changes(self) -> int: ...
    @max_changes.setter
    def max_changes(self, arg: int, /) -> None: ...
    @property
    def responses(self) -> bool: ...
    @responses.setter
    def responses(self, arg: bool, /) -> None: ...
    def with_database(self, prefix: str) -> NewtonOptions: ...

class PerturbedSystem(CondensedSystem):
    """Symmetric, and unsymmetric matrices that preconditioners leave out"""

    def __init__(
        self, K: petsc4py.PETSc.Mat, extra: list[petsc4py.PETSc.Mat], pinned: NDArray[numpy.bool_], diagonal: float
    ) -> None: ...

class PythonContact(dolfinx_impact._cpp.enforcement.MultiplierContact):
    """A contact written in Python"""

    def __init__(self, contact: object) -> None: ...

class RepeatedStates:
    """Recognises active sets of a linearised problem that come again"""

    def __init__(self, comm: mpi4py.MPI.Comm, later: int = 0) -> None: ...
    def stops(self, contacts: Sequence[dolfinx_impact._cpp.enforcement.MultiplierContact]) -> bool:
        """Whether further updates are useless. Collective"""

class RigidBodyModes:
    """Linearised rigid motions of all bodies"""

    def __init__(
        self, V: dolfinx.cpp.fem.FunctionSpace_float64, u: NDArray[numpy.floating[Any]], axisymmetric: bool
    ) -> None:
        """Collective"""

    @property
    def body(self) -> NDArray[numpy.int32]: ...
    @property
    def num_owned(self) -> int: ...
    @property
    def num_modes(self) -> int: ...
    @property
    def count(self) -> int: ...
    @property
    def names(self) -> list[str]: ...
    def rows(
        self, body: NDArray[numpy.integer[Any]], x: NDArray[numpy.floating[Any]], vectors: NDArray[numpy.floating[Any]]
    ) -> NDArray[numpy.float64]:
        """Work of unit forces on the modes, (n, num_modes)"""

    def everywhere(self, number: int) -> NDArray[numpy.float64]:
        """Displacements of the owned nodes under one mode, (num_owned, gdim)"""

class SaddlePointSystem(LinearSystem):
    """Multipliers kept as unknowns"""

    def __init__(
        self, K: petsc4py.PETSc.Mat, extra: list[petsc4py.PETSc.Mat], rows: dolfinx_impact._cpp.multipliers.SaddlePoint
    ) -> None: ...

def lowest_eigenvalues(
    A: petsc4py.PETSc.Mat, B: petsc4py.PETSc.Mat, count: int, shift: float, tolerance: float
) -> NDArray[numpy.float64]:
    """Eigenvalues near a shift, ascending. Collective"""

def num_negative_eigenvalues(A: petsc4py.PETSc.Mat) -> int:
    """Negative eigenvalues of a symmetric matrix, counted. Collective"""

def quadratic_eigenpairs(
    K: petsc4py.PETSc.Mat,
    G: petsc4py.PETSc.Mat,
    M: petsc4py.PETSc.Mat,
    count: int,
    shift: float,
    tolerance: float,
    max_iterations: int,
) -> list[tuple[complex, petsc4py.PETSc.Vec, petsc4py.PETSc.Vec]]:
    """
    Solutions of (s^2 M + s G + K) x = 0 nearest to a shift: s, x (two parts). Collective
    """
