# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Callable, Sequence
import enum
from typing import Any

import dolfinx.cpp
import numpy
from numpy.typing import NDArray
import petsc4py.PETSc

import dolfinx_impact._cpp

class CentralDifference:
    """Explicit integration; docs/explicit/scheme.md"""

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        internal: FormForces,
        linear: bool,
        mass: NDArray[numpy.floating[Any]],
        alpha: float,
        scheme: Scheme,
    ) -> None: ...
    def add_term(self, forces: FormForces, kind: WorkKind) -> None: ...
    def add_load(self, arg0: NDArray[numpy.integer[Any]], arg1: NDArray[numpy.floating[Any]], arg2: int, /) -> None: ...
    def set_load(self, arg0: int, arg1: NDArray[numpy.floating[Any]], /) -> None: ...
    def prescribe(
        self, arg0: NDArray[numpy.integer[Any]], arg1: NDArray[numpy.floating[Any]], arg2: int, /
    ) -> None: ...
    def add_contact(
        self, pair: dolfinx_impact._cpp.nodal.NodalPair, columns: Sequence[int], rotation: Sequence[int] = [-1, -1, -1]
    ) -> None: ...
    def set_contact_step(self, arg: float, /) -> None: ...
    @property
    def contact_step(self) -> float: ...
    @property
    def last_step(self) -> float: ...
    @property
    def deformed(self) -> bool: ...
    def start(self, arg0: NDArray[numpy.floating[Any]], arg1: NDArray[numpy.floating[Any]], /) -> None: ...
    def run(
        self,
        steps: NDArray[numpy.floating[Any]],
        table: NDArray[numpy.floating[Any]],
        columns: int,
        history: NDArray[numpy.float64],
        asked: Callable[[Any], bool] | None = None,
    ) -> int:
        """
        Steps done. asked: callable that tells whether to stop; it is given what a signal's handler raised, or None
        """

    @property
    def stopped(self) -> bool: ...
    def energies(self) -> NDArray[numpy.float64]: ...
    def motion(self, arg0: NDArray[numpy.float64], arg1: NDArray[numpy.float64], /) -> None: ...
    def support_forces(self) -> NDArray[numpy.float64]:
        """Forces of the supports on the bodies, owned. Collective"""

    def displacement(self) -> NDArray[numpy.float64]: ...
    def saved_state(self) -> dolfinx_impact._cpp.state.State:
        """What the run goes on from beside contacts and materials"""

    def empty_state(self) -> dolfinx_impact._cpp.state.State:
        """A state of that structure, of zeros"""

    def resume(self, saved: dolfinx_impact._cpp.state.State) -> None:
        """Go on from what saved_state has returned"""

    @property
    def gain(self) -> float: ...
    @property
    def most_gained(self) -> float: ...
    @property
    def released(self) -> float: ...
    @property
    def release_limit(self) -> float: ...
    @release_limit.setter
    def release_limit(self, arg: float, /) -> None: ...
    def fastest(self) -> tuple[int, float]: ...
    def revise(self) -> None:
        """Forces of forms anew: what they read has changed. Collective"""

    def passage(self) -> tuple[int, int, float]:
        """
        Contact (-1: none), local node, facets per step of the slave node that went through a master fastest
        """

    def update_gaps(self) -> None: ...
    @property
    def traffic(self) -> tuple[int, int]: ...
    @property
    def waited(self) -> float:
        """Time that this rank has waited for its neighbours' messages so far [s]"""

    @property
    def contact_seconds(self) -> float: ...

class Forces:
    """Forces at one time, over owned degrees of freedom"""

    def __init__(
        self,
        internal: NDArray[numpy.floating[Any]],
        external: NDArray[numpy.floating[Any]],
        damping: NDArray[numpy.floating[Any]],
        support: NDArray[numpy.floating[Any]],
        obstacles: NDArray[numpy.floating[Any]],
    ) -> None: ...
    @property
    def internal(self) -> NDArray[numpy.float64]: ...
    @internal.setter
    def internal(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def external(self) -> NDArray[numpy.float64]: ...
    @external.setter
    def external(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def damping(self) -> NDArray[numpy.float64]: ...
    @damping.setter
    def damping(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def support(self) -> NDArray[numpy.float64]: ...
    @support.setter
    def support(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def obstacles(self) -> NDArray[numpy.float64]: ...

class FormForces:
    """Forces of a form, and which coefficients the integrator provides"""

    def __init__(
        self,
        early: dolfinx_impact._cpp.operators.InternalForce_float64 | None,
        outer: dolfinx_impact._cpp.operators.InternalForce_float64 | None,
        late: dolfinx_impact._cpp.operators.InternalForce_float64 | None,
        displacement: str = "",
        velocity: str = "",
    ) -> None: ...

class FunctionVelocityForce(VelocityForce):
    """Those that are functions"""

    def __init__(
        self,
        forces: Callable[[], NDArray[numpy.floating[Any]]],
        tangent: Callable[[petsc4py.PETSc.Vec], list[petsc4py.PETSc.Mat]],
        linear: bool,
    ) -> None: ...

class ImplicitEnergyBalance:
    """Sums up the works of implicit steps by the trapezoidal rule"""

    @property
    def forces(self) -> Forces: ...
    @forces.setter
    def forces(self, arg: Forces, /) -> None: ...
    @property
    def works(self) -> Works: ...
    @works.setter
    def works(self, arg: Works, /) -> None: ...

class ImplicitScheme:
    """Generalised-alpha method by four parameters; docs/implicit/scheme.md"""

    def __init__(self, beta: float = 0.25, gamma: float = 0.5, alpha_m: float = 0.0, alpha_f: float = 0.0) -> None: ...
    @staticmethod
    def newmark(beta: float, gamma: float) -> ImplicitScheme:
        """Newmark's method (1959)"""

    @staticmethod
    def generalised_alpha(rho_inf: float) -> ImplicitScheme:
        """Chung and Hulbert (1993), by the spectral radius at infinite frequency"""

    @staticmethod
    def hht(alpha: float) -> ImplicitScheme:
        """Hilber, Hughes and Taylor (1977)"""

    @property
    def beta(self) -> float: ...
    @property
    def gamma(self) -> float: ...
    @property
    def alpha_m(self) -> float: ...
    @property
    def alpha_f(self) -> float: ...
    @property
    def second_order(self) -> bool: ...
    def stable_frequency(self) -> float:
        """
        Largest product of frequency and step at which nothing grows; infinite if all are stable
        """

    def spectral_radius(self, product: float, damping: float = 0.0) -> float:
        """Largest absolute eigenvalue of a step of an oscillator"""

    def amplification(self, product: float, damping: float = 0.0) -> NDArray[numpy.float64]:
        """
        Matrix (3, 3) of a step of an oscillator: maps (u, h v, h^2 A) at its start to that at its end
        """

    def __str__(self) -> str: ...
    def __repr__(self) -> str: ...

class ImplicitStepper:
    """Implicit steps, repeated with half the length where one fails"""

    def update_gaps(self) -> None:
        """Gaps of the present displacement. Collective"""

    def show_motion(self) -> None:
        """Set velocity and acceleration functions. Collective"""

    def energies(self) -> NDArray[numpy.float64]:
        """Energies in the order of run_history.ENERGIES. Collective"""

    @property
    def time(self) -> float: ...
    @property
    def step(self) -> int: ...
    @property
    def motion(self) -> Motion: ...
    @property
    def energy_balance(self) -> ImplicitEnergyBalance: ...
    @property
    def iterations(self) -> int: ...
    @property
    def cut_backs(self) -> int: ...
    @property
    def rejected(self) -> int: ...

class Inertia:
    """Mass matrix, and the degrees of freedom that have no mass"""

    def __init__(self, matrix: petsc4py.PETSc.Mat, massless: NDArray[numpy.bool_]) -> None: ...
    def times(self, x: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """M x, owned. Collective"""

class MassRedistribution:
    """Cells that pass the mass of contact nodes on"""

    def __init__(self, V: dolfinx.cpp.fem.FunctionSpace_float64, facets: NDArray[numpy.integer[Any]]) -> None:
        """Collective"""

    @property
    def on_surface(self) -> NDArray[numpy.bool_]: ...
    @property
    def massless(self) -> NDArray[numpy.bool_]: ...
    @property
    def cells(self) -> NDArray[numpy.int32]: ...
    def matrix(self, cell: int, M: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """Mass matrix of a cell after redistribution"""

    def lumped(self, cell: int, masses: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """Lumped masses of a cell after redistribution"""

class Motion:
    """Motion at one time, over owned degrees of freedom"""

    def __init__(
        self,
        displacement: NDArray[numpy.floating[Any]],
        velocity: NDArray[numpy.floating[Any]],
        acceleration: NDArray[numpy.floating[Any]],
        mean: NDArray[numpy.floating[Any]],
    ) -> None: ...
    @property
    def displacement(self) -> NDArray[numpy.float64]: ...
    @displacement.setter
    def displacement(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def velocity(self) -> NDArray[numpy.float64]: ...
    @velocity.setter
    def velocity(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def acceleration(self) -> NDArray[numpy.float64]: ...
    @acceleration.setter
    def acceleration(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def mean(self) -> NDArray[numpy.float64]: ...
    @mean.setter
    def mean(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    def state(self, block_size: int) -> dolfinx_impact._cpp.state.State:
        """Its arrays as a State"""

class Scheme(enum.Enum):
    half_step = 0

    classical = 1

class StepControl:
    """Lengths of implicit steps: equal, by a local error, after failures"""

    def __init__(
        self,
        largest: float,
        smallest: float,
        tolerance: float | None = None,
        length: float | None = None,
        last: float = 0.0,
    ) -> None: ...
    def next(self, time: float, goal: float) -> tuple[float, float]:
        """Length of the next step, time at its end"""

    def failed(self, step: float) -> bool:
        """Halve it; returns whether it is long enough to be tried"""

    def accepts(self, step: float, error: float | None) -> bool:
        """Judge the error of a step"""

    def choose_next_step(self, step: float, iterations: int, error: float | None) -> None:
        """Choose the next length after an accepted step"""

    @property
    def largest(self) -> float: ...
    @property
    def smallest(self) -> float: ...
    @property
    def tolerance(self) -> float | None: ...
    @property
    def last(self) -> float: ...
    @property
    def length(self) -> float: ...
    @length.setter
    def length(self, arg: float, /) -> None: ...

    many: int

    few: int

class VelocityForce:
    """Nodal forces that depend on the velocity"""

class WorkKind(enum.Enum):
    """Which energy the work of a force counts to"""

    damping = 1

    viscosity = 2

    foundation = 4

    external = 3

class Works:
    """Works so far, over all ranks"""

    def __init__(self, internal: float = 0.0, external: float = 0.0, damping: float = 0.0) -> None: ...
    @property
    def internal(self) -> float: ...
    @internal.setter
    def internal(self, arg: float, /) -> None: ...
    @property
    def external(self) -> float: ...
    @external.setter
    def external(self, arg: float, /) -> None: ...
    @property
    def damping(self) -> float: ...
    @damping.setter
    def damping(self, arg: float, /) -> None: ...

def highest_frequency(stiffness: petsc4py.PETSc.Mat, mass: petsc4py.PETSc.Mat, held: NDArray[numpy.bool_]) -> float:
    """Highest angular frequency. Collective"""

largest_growth: float = 1000.0

def release_memory() -> None:
    """Give memory that set-up no longer needs back to the system"""
