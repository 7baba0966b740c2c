# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Mapping, Sequence
from typing import Any

import dolfinx.cpp
import mpi4py.MPI
import numpy
from numpy.typing import NDArray
import petsc4py.PETSc

import dolfinx_impact._cpp

class ContactTotals:
    """Totals of a contact over all ranks; force and moment have 3 entries"""

    def __init__(self) -> None: ...
    @property
    def known(self) -> bool: ...
    @known.setter
    def known(self, arg: bool, /) -> None: ...
    @property
    def force(self) -> list[float]: ...
    @force.setter
    def force(self, arg: Sequence[float], /) -> None: ...
    @property
    def moment(self) -> list[float]: ...
    @moment.setter
    def moment(self, arg: Sequence[float], /) -> None: ...
    @property
    def area(self) -> float: ...
    @area.setter
    def area(self, arg: float, /) -> None: ...
    @property
    def dissipated(self) -> float: ...
    @dissipated.setter
    def dissipated(self, arg: float, /) -> None: ...
    @property
    def slip(self) -> NDArray[numpy.float64]:
        """Slips whose work is counted"""

    @slip.setter
    def slip(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    def update(
        self,
        comm: mpi4py.MPI.Comm,
        x: NDArray[numpy.floating[Any]],
        traction: NDArray[numpy.floating[Any]],
        slip: NDArray[numpy.floating[Any]],
        status: NDArray[numpy.integer[Any]],
        weight: NDArray[numpy.floating[Any]],
        covered: NDArray[numpy.floating[Any]],
    ) -> None:
        """Sum up a converged increment. Collective"""

class FrictionCoefficients:
    """Coefficients of friction at points; flat copies"""

    @property
    def value(self) -> NDArray[numpy.float64]: ...
    @property
    def by_pressure(self) -> NDArray[numpy.float64]:
        """Empty: the law does not depend on it"""

    @property
    def by_slip_rate(self) -> NDArray[numpy.float64]:
        """(n, gdim) flat; empty: the law does not depend on it"""

class FrictionLaw:
    """A law of friction by a kernel"""

    def __init__(
        self,
        kernel: int,
        gdim: int,
        constants: Mapping[str, float],
        fields: Mapping[str, dolfinx.cpp.fem.Function_float64],
    ) -> None: ...
    def set_constant(self, name: str, value: float) -> None: ...
    @property
    def gdim(self) -> int: ...
    @property
    def has_rates(self) -> bool: ...
    @property
    def has_pressure(self) -> bool: ...
    def evaluate(self, values: Mapping[str, NDArray[numpy.floating[Any]]]) -> FrictionCoefficients:
        """
        At points: flat arrays by name: pressure, slip_rate, normal, NAME_slave and NAME_master of fields
        """

class InterfaceLaw:
    """A law of the interface by a kernel"""

    def __init__(
        self,
        kernel: int,
        gdim: int,
        constants: Mapping[str, float],
        fields: Mapping[str, dolfinx.cpp.fem.Function_float64],
        tangential: Sequence[str],
        reach: float,
    ) -> None: ...
    def set_constant(self, name: str, value: float) -> None: ...
    @property
    def gdim(self) -> int: ...
    @property
    def reach(self) -> float: ...
    @property
    def has_rates(self) -> bool: ...
    @property
    def has_shear(self) -> bool: ...
    @property
    def has_energy(self) -> bool: ...
    def evaluate(self, values: Mapping[str, NDArray[numpy.floating[Any]]]) -> InterfaceTractions:
        """
        At points: flat arrays by name: gap, slip, gap_rate, slip_rate, normal, NAME_slave and NAME_master of fields, 'history NAME' of internal variables
        """

class InterfaceTractions:
    """What a law returns at points; flat copies"""

    @property
    def pressure(self) -> NDArray[numpy.float64]: ...
    @property
    def shear(self) -> NDArray[numpy.float64]: ...
    @property
    def energy(self) -> NDArray[numpy.float64]:
        """Empty where the law does not know it"""

    @property
    def sticks(self) -> NDArray[numpy.float64]: ...
    @property
    def num_unsolved(self) -> int: ...
    def by(self, input: str) -> NDArray[numpy.float64]:
        """
        Derivative of pressure and shear by an input, (n, 1 + gdim, size) flat; empty: zero
        """

    def history(self, name: str) -> NDArray[numpy.float64]:
        """New values of an internal variable"""

class MultiplierContact(StaticContact):
    """One whose normal tractions are unknowns"""

class StaticContact:
    """A contact of one pair in equilibrium; arrays are flat copies"""

    @property
    def name(self) -> str: ...
    @property
    def fault(self) -> str: ...
    def check_parameters(self) -> None: ...
    def set_time_step(self, dt: float) -> None:
        """Of the increments that follow; 0: none [T]"""

    def begin_step(
        self,
        u: NDArray[numpy.floating[Any]],
        displacement: Sequence[float] | None,
        target: NDArray[numpy.floating[Any]] | None = None,
    ) -> None: ...
    @property
    def displacement(self) -> list[float] | None: ...
    def state(self) -> dolfinx_impact._cpp.state.State:
        """What an increment starts from; views"""

    def accept_step(self) -> None: ...
    def augment(self) -> bool: ...
    def prescribed_overlap(self) -> str: ...
    def passed_through(self) -> str: ...
    def update_gap(self, u: NDArray[numpy.floating[Any]]) -> None: ...
    def update_active_set(self, first: bool, last: int | None) -> int: ...
    def contact_forces(self) -> NDArray[numpy.float64]: ...
    def add_residual(self, b: petsc4py.PETSc.Vec) -> None: ...
    def update_nodal_stiffness(self, K: petsc4py.PETSc.Mat) -> None: ...
    def tangent(self) -> petsc4py.PETSc.Mat | None:
        """PETSc matrix, kept by this object; None: zero. Collective"""

    def set_convex(self, convex: bool) -> None: ...
    @property
    def symmetric(self) -> bool: ...
    @property
    def num_active(self) -> int: ...
    def violation(self) -> float: ...
    def round_off(self) -> float: ...
    def largest_violation(self) -> str: ...
    def mesh_advice(self) -> str: ...
    def smallest_gap(self) -> float: ...
    def saved_state(self) -> dolfinx_impact._cpp.state.State:
        """What a checkpoint holds of the last converged state"""

    def resume(self, saved: dolfinx_impact._cpp.state.State, u: NDArray[numpy.floating[Any]]) -> None:
        """Continue from a checkpoint. Collective"""

    def forget(self) -> None: ...
    def rigid_body_products(self, modes: dolfinx_impact._cpp.solve.RigidBodyModes) -> NDArray[numpy.float64]: ...
    def close_nearest(self) -> bool: ...
    def closing_forces(self) -> NDArray[numpy.float64]: ...
    @property
    def points(self) -> NDArray[numpy.float64]: ...
    @property
    def gap(self) -> NDArray[numpy.float64]: ...
    @property
    def normal(self) -> NDArray[numpy.float64]: ...
    @property
    def pressure(self) -> NDArray[numpy.float64]: ...
    @property
    def traction(self) -> NDArray[numpy.float64]: ...
    @property
    def slip(self) -> NDArray[numpy.float64]: ...
    @property
    def status(self) -> NDArray[numpy.int8]: ...
    @property
    def weight(self) -> NDArray[numpy.float64]: ...
    def covered(self) -> NDArray[numpy.float64]: ...
    def stored_energy(self) -> float:
        """Energy of the springs of a penalty. Collective"""
