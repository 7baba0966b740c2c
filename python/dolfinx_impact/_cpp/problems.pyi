# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Callable, Mapping, Sequence
import enum
from typing import Any

import dolfinx.cpp
import numpy
from numpy.typing import NDArray
import petsc4py.PETSc

import dolfinx_impact._cpp

class AmplitudeTable:
    """Function of time from a table of times and values"""

    def __init__(
        self,
        times: NDArray[numpy.floating[Any]],
        values: NDArray[numpy.floating[Any]],
        smooth: bool,
        refuse_before: bool,
        refuse_after: bool,
        name: str,
    ) -> None: ...
    @staticmethod
    def from_csv(file: str, smooth: bool, refuse_before: bool, refuse_after: bool, name: str) -> AmplitudeTable: ...
    @property
    def size(self) -> int: ...
    @property
    def times(self) -> NDArray[numpy.float64]: ...
    @property
    def values(self) -> NDArray[numpy.float64]: ...
    def sample(self, times: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]: ...

class AssembledBody(dolfinx_impact._cpp.solve.Body):
    """Bodies that kernels, forms of DOLFINx, or both assemble"""

    def __init__(
        self,
        u: dolfinx.cpp.fem.Function_float64,
        residual: dolfinx.cpp.fem.Form_float64 | None,
        tangent: dolfinx_impact._cpp.operators.KernelTangent,
        forces: Sequence[KernelForce],
        loads: Sequence[KernelForce],
        tangent_constants: Sequence[Sequence[dolfinx.cpp.fem.Constant_float64]],
        functions: Sequence[dolfinx.cpp.fem.Function_float64],
        properties: dolfinx_impact._cpp.solve.BodyProperties,
    ) -> None: ...
    def set_energies(
        self, energies: Sequence[KernelForce], functions: Sequence[dolfinx.cpp.fem.Function_float64]
    ) -> None:
        """
        What stores energy beside laws with internal variables: all energy is known then
        """

class CellFrequencies:
    """Highest frequencies of the cells of bodies, and their damping"""

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        stiffness: dolfinx_impact._cpp.operators.CellBounds,
        damping: dolfinx_impact._cpp.operators.CellBounds | None,
        masses: Callable[[], NDArray[numpy.floating[Any]]],
    ) -> None: ...
    def masses(self) -> NDArray[numpy.float64]: ...
    def by_cell(
        self, only: NDArray[numpy.bool_] | None = None
    ) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
        """Squares of frequencies, and damping over mass. Collective"""

    def scale_mass(self, dt: float) -> float:
        """Added mass. Collective"""

    @property
    def num_looks(self) -> int: ...
    @property
    def num_cells_looked_at(self) -> int: ...

class ContactInTime:
    """A contact, and the motion of its rigid master"""

    def __init__(
        self,
        contact: dolfinx_impact._cpp.nodal.NodalPair,
        name: str,
        start: NDArray[numpy.floating[Any]] | None,
        body: RigidBodyInTime | None = None,
        rotation: NDArray[numpy.floating[Any]] | None = None,
    ) -> None: ...

class ExplicitBody:
    """Bodies as explicit steps need them"""

    def __init__(
        self,
        internal: dolfinx_impact._cpp.integrators.FormForces,
        linear: bool,
        mass: NDArray[numpy.floating[Any]],
        frequencies: CellFrequencies,
        damping: UniformDamping,
        watched: bool,
        periodic: bool,
        flows: bool,
    ) -> None: ...
    def add_term(
        self, forces: dolfinx_impact._cpp.integrators.FormForces, kind: dolfinx_impact._cpp.integrators.WorkKind
    ) -> None: ...
    def set_matrices(
        self,
        stiffness: Callable[[], dolfinx_impact._cpp.operators.KernelTangent],
        cell_damping: Callable[[], dolfinx_impact._cpp.operators.KernelTangent] | None,
    ) -> None:
        """Functions that assemble new matrices; they must not know the problem"""

    def set_elasticity(self, moduli: NDArray[numpy.floating[Any]], wave_speeds: NDArray[numpy.floating[Any]]) -> None:
        """Of each owned cell"""

class ExplicitProblem:
    """Motion of bodies with lumped mass by central differences"""

    def __init__(
        self,
        u: dolfinx.cpp.fem.Function_float64,
        velocity: dolfinx.cpp.fem.Function_float64,
        acceleration: dolfinx.cpp.fem.Function_float64,
        body: ExplicitBody,
        supports: Sequence[PrescribedMotion],
        loads: Sequence[LoadInTime],
        contacts: Sequence[ContactInTime],
        scheme: dolfinx_impact._cpp.integrators.Scheme,
    ) -> None:
        """Collective; `start` computes the first forces"""

    @property
    def time(self) -> float: ...
    @property
    def lost_at_start(self) -> float:
        """Kinetic energy that ties have taken [F L]"""

    @property
    def step(self) -> int: ...
    @property
    def next_time(self) -> float: ...
    @property
    def nominal_step(self) -> float: ...
    @property
    def schedule(self) -> StepSchedule | None: ...
    @property
    def supports(self) -> Supports: ...
    @property
    def integrator(self) -> dolfinx_impact._cpp.integrators.CentralDifference: ...
    @property
    def safe_step(self) -> SafeStep: ...
    @property
    def history(self) -> RunHistory: ...
    def state(self) -> dolfinx_impact._cpp.state.State: ...
    def update_motion(self) -> None:
        """
        Functions of displacement, velocity and acceleration get the present motion. Collective
        """

    def update_gaps(self) -> None: ...
    def unsolved(self) -> str:
        """Which local equations were not solved; empty: all were. Collective"""

    def stable_step(self, method: StableStepMethod) -> float:
        """Of the displacement that the function has. Collective"""

    def begin_anew(self) -> None:
        """Take the present displacement for another start. Collective"""

    def start(self, observer: object) -> tuple[str, str] | None:
        """Forces of the start; what all ranks throw, or None. Collective"""

    def advance(
        self, until: float, dt: float | None, unsafe: bool, gain_warning: float, gain_limit: float, observer: object
    ) -> tuple[str, str] | None:
        """What all ranks throw, or None. Collective"""

    def saved_state(self) -> dolfinx_impact._cpp.state.State:
        """What the run goes on from, beside the schedule. Collective"""

    def empty_state(self) -> dolfinx_impact._cpp.state.State:
        """A state of that structure, whose values do not matter"""

    def resume(self, saved: dolfinx_impact._cpp.state.State, schedule: StepSchedule | None, observer: object) -> None:
        """Go on from what saved_state has returned. Collective"""

class ImplicitBody:
    """Bodies as implicit steps need them: residual, tangent, mass, damping"""

    def __init__(
        self,
        body: dolfinx_impact._cpp.solve.Body,
        inertia: dolfinx_impact._cpp.integrators.Inertia,
        mass: NDArray[numpy.floating[Any]],
        alpha: float,
        damping: dolfinx_impact._cpp.integrators.VelocityForce | None,
        work: dolfinx.cpp.fem.Form_float64 | None,
        loads: Sequence[KernelForce],
        scaled: Sequence[tuple[dolfinx.cpp.fem.Constant_float64, NDArray[numpy.floating[Any]]]],
    ) -> None:
        """
        work: of loads that are forms; loads: those by kernels; scaled: constants of loads, and their amplitudes at the start
        """

class ImplicitBodyInTime:
    """A rigid body that moves by forces in implicit steps"""

    def __init__(
        self,
        mass: float,
        inertia: Sequence[float],
        centre: Sequence[float],
        displacement: Sequence[float],
        velocity: Sequence[float],
        spin: Sequence[float],
        fixed_velocity: Sequence[bool],
        fixed_spin: Sequence[bool],
        length: float,
        contacts: Sequence[int],
        force: NDArray[numpy.floating[Any]] | None,
        torque: NDArray[numpy.floating[Any]] | None,
    ) -> None:
        """Force and torque: their values at the start, or None"""

    @property
    def position(self) -> list[float]: ...
    @property
    def rotation(self) -> list[float]: ...
    def velocity(self, dt: float) -> list[float]:
        """At the present time; dt: not used"""

    def spin(self, dt: float) -> list[float]:
        """At the present time; dt: not used"""

    def momentum(self, dt: float) -> list[float]:
        """At the present time; dt: not used"""

    def angular_momentum(self, dt: float) -> list[float]:
        """At the present time; dt: not used"""

    def kinetic_energy(self, dt: float) -> float:
        """At the present time; dt: not used"""

    @property
    def contact_force(self) -> list[float]: ...
    @property
    def contact_torque(self) -> list[float]: ...

class ImplicitContact:
    """A contact of implicit steps"""

    def __init__(
        self,
        contact: dolfinx_impact._cpp.enforcement.StaticContact,
        start: Sequence[float] | None,
        motion: NDArray[numpy.floating[Any]] | None,
        rotation: NDArray[numpy.floating[Any]] | None,
    ) -> None:
        """
        start: displacement of a rigid master; motion: that beside it, rotation: its rotation vector, at the start
        """

class InputChanges:
    """Changes of what the stable step depends on, since it was found"""

    def __init__(self) -> None: ...
    @property
    def stale(self) -> bool: ...
    @stale.setter
    def stale(self, arg: bool, /) -> None: ...
    @property
    def total(self) -> float: ...
    @total.setter
    def total(self, arg: float, /) -> None: ...
    @property
    def allowed(self) -> float: ...
    @allowed.setter
    def allowed(self, arg: float, /) -> None: ...
    def add(self, change: float) -> None: ...
    @property
    def due(self) -> bool: ...
    def done(self, before: float, after: float) -> None: ...

    effect: float

class KernelForce:
    """An operator, and the constants of each of its integrals"""

    def __init__(
        self,
        force: dolfinx_impact._cpp.operators.InternalForce_float64,
        constants: Sequence[Sequence[dolfinx.cpp.fem.Constant_float64]],
    ) -> None: ...

class LoadInTime:
    """Nodal forces times an amplitude"""

    def __init__(
        self,
        dofs: NDArray[numpy.integer[Any]],
        values: NDArray[numpy.floating[Any]],
        start: NDArray[numpy.floating[Any]] | None,
    ) -> None: ...

class NewmarkProblem:
    """Motion of bodies by Newmark's method or generalised-alpha"""

    def __init__(
        self,
        u: dolfinx.cpp.fem.Function_float64,
        v: dolfinx.cpp.fem.Function_float64,
        a: dolfinx.cpp.fem.Function_float64,
        body: ImplicitBody,
        supports: Sequence[PrescribedMotion],
        contacts: Sequence[ImplicitContact],
        scheme: dolfinx_impact._cpp.integrators.ImplicitScheme,
        petsc: Mapping[str, str],
        prefix: str,
        axisymmetric: bool,
        limits: dolfinx_impact._cpp.solve.LinearSolverLimits,
        warn: Callable[[str], None],
        table: Callable[[NDArray[numpy.float64]], NDArray[numpy.floating[Any]]],
        bodies: Sequence[ImplicitBodyInTime],
    ) -> None:
        """table: samples all functions of time; bodies: rigid ones. Collective"""

    def advance(
        self,
        until: float,
        dt: float,
        tolerance: float | None,
        smallest: float,
        rtol: float,
        atol: float,
        max_iterations: int,
        log: Callable[[str], None],
        progress: Callable[[str], None],
        iteration: Callable[[int, float, float, int, int], None],
        update: Callable[[float], None] | None,
        started: Callable[[], None],
        begins: Callable[[], None],
        goal: Callable[[], float],
        accepted: Callable[[], None],
        table: Callable[[NDArray[numpy.float64]], NDArray[numpy.floating[Any]]],
    ) -> None:
        """Advance to a time. Collective"""

    def energies(self) -> NDArray[numpy.float64]:
        """Energies in the order of run_history.ENERGIES. Collective"""

    def stable_step(self) -> float:
        """Infinite for schemes that are stable with any. Collective"""

    def saved_state(self) -> dolfinx_impact._cpp.state.State:
        """What the problem goes on from, values of its own. Collective"""

    def resume(
        self,
        saved: dolfinx_impact._cpp.state.State,
        table: Callable[[NDArray[numpy.float64]], NDArray[numpy.floating[Any]]],
    ) -> None:
        """Go on from what saved_state has returned. Collective"""

    def forget(self) -> None:
        """Forget what a state does not have. Collective"""

    @property
    def time(self) -> float: ...
    @property
    def step(self) -> int: ...
    @property
    def supports(self) -> Supports: ...
    @property
    def control(self) -> dolfinx_impact._cpp.integrators.StepControl | None: ...
    @property
    def history(self) -> RunHistory: ...
    @property
    def stepper(self) -> dolfinx_impact._cpp.integrators.ImplicitStepper: ...
    @property
    def equilibrium(self) -> dolfinx_impact._cpp.solve.EquilibriumProblem: ...

class PowerBalance:
    """Powers of a steady state [F L/T]"""

    @property
    def driving(self) -> float: ...
    @property
    def friction(self) -> float: ...
    @property
    def rolling(self) -> float: ...

class PrescribedMotion:
    """Displacements of a boundary condition times an amplitude"""

    def __init__(self, bc: dolfinx.cpp.fem.DirichletBC_float64, start: NDArray[numpy.floating[Any]] | None) -> None:
        """start: amplitude at the start; None: it is constant"""

class RigidBodyInTime:
    """A rigid body that moves by the forces of contacts and loads"""

    def __init__(
        self,
        mass: float,
        inertia: Sequence[float],
        centre: Sequence[float],
        displacement: Sequence[float],
        velocity: Sequence[float],
        spin: Sequence[float],
        fixed_velocity: Sequence[bool],
        fixed_spin: Sequence[bool],
        force: NDArray[numpy.floating[Any]] | None,
        torque: NDArray[numpy.floating[Any]] | None,
    ) -> None:
        """Force and torque: their values at the start, or None without"""

    @property
    def position(self) -> list[float]: ...
    @property
    def rotation(self) -> list[float]: ...
    def velocity(self, dt: float) -> list[float]:
        """At the present time level; dt: the step that led to it, 0 at the start"""

    def spin(self, dt: float) -> list[float]: ...
    def momentum(self, dt: float) -> list[float]: ...
    def angular_momentum(self, dt: float) -> list[float]: ...
    def kinetic_energy(self, dt: float) -> float: ...
    def meet(
        self,
        points: NDArray[numpy.floating[Any]],
        areas: NDArray[numpy.floating[Any]],
        radius: float,
        master: dolfinx_impact._cpp.gap.Rigid,
        friction: float,
        body: RigidBodyInTime | None,
    ) -> None:
        """
        Contact of its points, or of a ball around one, with another body or an obstacle
        """

    @property
    def meeting_gaps(self) -> list[float]:
        """Smallest gap of each of these contacts"""

    @property
    def meeting_forces(self) -> list[list[float]]:
        """Force of each of these contacts on the body"""

    @property
    def contact_force(self) -> list[float]: ...
    @property
    def contact_torque(self) -> list[float]: ...

class RollingProblem:
    """Bodies through whose meshes the material flows steadily"""

    def __init__(self, equilibrium: StaticProblem, flow: dolfinx_impact._cpp.rolling.Flow) -> None:
        """Collective"""

    def solve(
        self,
        steps: int,
        rtol: float,
        atol: float,
        max_iterations: int,
        cut_backs: int | None,
        torque: float | None,
        log: Callable[[str], None],
        progress: Callable[[str], None],
        iteration: Callable[[int, float, float, int, int], None],
        begins: Callable[[int, float, float], None],
        accepted: Callable[[float], None],
    ) -> tuple[dolfinx_impact._cpp.solve.LoadStepReport, str]:
        """
        Find the steady state: its report and a warning, or an empty text. Collective
        """

    def torque(self, motion: int) -> float:
        """Torque that drives the body of a Spin [F L]. Collective"""

    def axle(self, motion: int) -> list[float]:
        """Displacement of its axis, (3) [L]. Collective"""

    def power_balance(self) -> PowerBalance:
        """Collective"""

    def critical_factor(self, W: petsc4py.PETSc.Mat) -> float:
        """
        Factor on the present rates at which stiffness minus W becomes singular. Collective
        """

    def frequencies(
        self, G: petsc4py.PETSc.Mat, M: petsc4py.PETSc.Mat, along: petsc4py.PETSc.Mat, count: int, tolerance: float
    ) -> tuple[NDArray[numpy.float64], int]:
        """
        Signed frequencies, sorted by modulus, and the number of modes found that grow. Collective
        """

    @property
    def stable_rates(self) -> list[float]:
        """Rates up to which the problem is known to be stable"""

    def saved_state(self) -> dolfinx_impact._cpp.state.State:
        """What a solve starts from, values of its own"""

    def bring_back(self, saved: dolfinx_impact._cpp.state.State) -> None:
        """Be in the state that saved_state has returned. Collective"""

    def mark_reached(self) -> None:
        """Take present rates and loads as those that the last solve has reached"""

class RunHistory:
    """Time, energies and contact forces of a run by step, in bounded memory"""

    def __init__(self, num_contacts: int) -> None: ...
    def add(self, times: NDArray[numpy.floating[Any]], steps: NDArray[numpy.floating[Any]]) -> None: ...
    def columns(self, first: int, count: int) -> NDArray[numpy.float64]:
        """Some columns of the rows that are kept"""

    @property
    def last(self) -> NDArray[numpy.float64]: ...
    def begin_anew(self) -> None: ...
    def drift(self, energies: NDArray[numpy.floating[Any]]) -> float: ...
    @property
    def num_rows(self) -> int: ...
    @property
    def stride(self) -> int: ...
    @property
    def memory(self) -> int: ...
    @property
    def limit(self) -> int: ...
    @limit.setter
    def limit(self, arg: int, /) -> None: ...

class SafeStep:
    """The stable step of a run, found again where it may have changed"""

    @property
    def value(self) -> float: ...
    def steps(
        self, squares: NDArray[numpy.floating[Any]], rates: NDArray[numpy.floating[Any]]
    ) -> NDArray[numpy.float64]:
        """Stable steps of cells, contact springs included [T]"""

    @property
    def changes(self) -> InputChanges: ...
    @property
    def watch(self) -> StableStepWatch: ...
    @property
    def deformed(self) -> bool: ...
    @property
    def num_found(self) -> int:
        """How often the stable step was found anew"""

    @property
    def check_step(self) -> int: ...
    @property
    def check_interval(self) -> int: ...
    @property
    def longest_interval(self) -> int: ...
    @longest_interval.setter
    def longest_interval(self, arg: int, /) -> None: ...

    safety: float

class SpringStart:
    """
    Springs of an explicit contact that bear what a contact in equilibrium does
    """

    def __init__(
        self,
        steady: dolfinx_impact._cpp.enforcement.StaticContact,
        problem: ExplicitProblem,
        contact: int,
        supports_move: bool,
    ) -> None:
        """Collective"""

    def approach(self) -> float:
        """
        How far the slave body must be moved against the normal for the springs to bear the force. Collective [L]
        """

    def move(self, u: NDArray[numpy.float64], distance: float) -> None:
        """Move the slave body against the normal (a view is changed)"""

    def hand_over(self) -> None:
        """Give the springs the nodal forces of the equilibrium. Collective"""

class StableStepMethod(enum.Enum):
    """How the stable step is found"""

    length = 0

    element = 1

    eigenvalue = 2

class StableStepWatch:
    """Frequencies of the cells, each at its last look"""

    @property
    def squares(self) -> NDArray[numpy.float64]: ...
    @property
    def rates(self) -> NDArray[numpy.float64]: ...
    @property
    def since(self) -> NDArray[numpy.float64]: ...
    @property
    def reference(self) -> NDArray[numpy.float64]: ...
    @property
    def sensitivity(self) -> float: ...

class StaticProblem:
    """Equilibrium of bodies, in contact or not"""

    def __init__(
        self,
        u: dolfinx.cpp.fem.Function_float64,
        body: dolfinx_impact._cpp.solve.Body,
        bcs: Sequence[dolfinx.cpp.fem.DirichletBC_float64],
        contacts: Sequence[dolfinx_impact._cpp.enforcement.StaticContact],
        petsc: Mapping[str, str],
        prefix: str,
        axisymmetric: bool,
        limits: dolfinx_impact._cpp.solve.LinearSolverLimits,
        warn: Callable[[str], None],
    ) -> None:
        """Collective"""

    def share_linear_solver(self, other: StaticProblem) -> None:
        """
        Solve with the linear solver of another problem, and its factors while they serve. Collective
        """

    def add_load(self, value: NDArray[numpy.float64], reached: NDArray[numpy.float64]) -> None:
        """
        A load that is applied in parts: views of its value and of that which was reached
        """

    def add_rigid_body(
        self,
        contacts: Sequence[int],
        fixed: Sequence[bool],
        force: NDArray[numpy.float64],
        torque: NDArray[numpy.float64],
    ) -> None:
        """
        A rigid master that loads and contacts move; views of force and torque on it
        """

    def turn_obstacle(self, contact: int, angle: NDArray[numpy.float64], reached: NDArray[numpy.float64]) -> None:
        """
        Turn a contact's rigid master: views of its rotation vector, and of that which was reached
        """

    def move_obstacle(self, contact: int, displacement: Sequence[float]) -> None:
        """
        Displacement of a contact's rigid master that the next solve leads to [L]
        """

    def solve(
        self,
        steps: int,
        rtol: float,
        atol: float,
        max_iterations: int,
        cut_backs: int,
        log: Callable[[str], None],
        progress: Callable[[str], None],
        iteration: Callable[[int, float, float, int, int], None],
        begins: Callable[[int, float, float], None],
        accepted: Callable[[float], None],
    ) -> dolfinx_impact._cpp.solve.LoadStepReport:
        """
        Solve for the present values of loads, boundary conditions and obstacles. Collective
        """

    def solve_by(
        self,
        solver: Callable[[NDArray[numpy.float64]], dolfinx_impact._cpp.solve.Increment],
        steps: int,
        cut_backs: int,
        log: Callable[[str], None],
        begins: Callable[[int, float, float], None],
        accepted: Callable[[float], None],
    ) -> dolfinx_impact._cpp.solve.LoadStepReport:
        """The same, increments solved by a function of Python's. Collective"""

    def reactions(self) -> NDArray[numpy.float64]:
        """Residual of equilibrium, owned [F]. Collective"""

    def saved_state(self) -> dolfinx_impact._cpp.state.State:
        """What the next solve starts from, values of its own. Collective"""

    def resume(self, saved: dolfinx_impact._cpp.state.State) -> None:
        """Go on from what saved_state has returned. Collective"""

    def forget(self) -> None:
        """Forget what `state` does not have. Collective"""

    @property
    def equilibrium(self) -> dolfinx_impact._cpp.solve.EquilibriumProblem: ...

class StepSchedule:
    """Equal steps between two times, numbered as the steps of the run"""

    def __init__(self, begin: float, until: float, first: int, last: int, auto: bool = False) -> None: ...
    @property
    def begin(self) -> float: ...
    @property
    def until(self) -> float: ...
    @property
    def first(self) -> int: ...
    @property
    def last(self) -> int: ...
    @property
    def auto(self) -> bool: ...
    @property
    def dt(self) -> float: ...
    def time(self, step: int) -> float: ...
    def __eq__(self, other: object, /) -> bool: ...

class Supports:
    """Prescribed degrees of freedom"""

    @property
    def parts(self) -> list[tuple[NDArray[numpy.int32], NDArray[numpy.float64], int]]: ...
    @property
    def mask(self) -> NDArray[numpy.int8]: ...
    def check(self) -> None:
        """Raises if the value of a condition has been changed"""

class UniformDamping:
    """Damping of all cells alike"""

    def __init__(self, alpha: float, beta: float, viscosity: float) -> None: ...
    @property
    def alpha(self) -> float: ...
    @property
    def beta(self) -> float: ...
    @property
    def viscosity(self) -> float: ...
    def rate(self, square: float) -> float:
        """Eigenvalue of the damping over the mass [1/T]"""

def highest_frequency(stiffness: petsc4py.PETSc.Mat, inverse_mass: NDArray[numpy.floating[Any]]) -> float:
    """Of a matrix, which is scaled by the lumped mass. Collective [1/T]"""

def release_limit(V: dolfinx.cpp.fem.FunctionSpace_float64, stiffness: NDArray[numpy.floating[Any]]) -> float:
    """Energy that a residual of one's own may give. Collective [F L]"""

def released_message(released: float, limit: float, go_on: str) -> str: ...
def start_from_equilibrium(
    problem: ExplicitProblem, equilibrium: dolfinx_impact._cpp.solve.EquilibriumProblem, observer: object
) -> tuple[str, str] | None:
    """
    Begin from an equilibrium with contact; what all ranks throw, or None. Collective
    """
