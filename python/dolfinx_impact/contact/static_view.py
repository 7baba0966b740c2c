# SPDX-License-Identifier: MIT
"""What static contacts in C++ have in common, as Python sees it."""

import numpy as np
from petsc4py import PETSc

from .. import _cpp
from ..common.types import FloatArray, IntArray
from .output import ContactOutput


class StaticContactView(ContactOutput):
    """A static contact whose state and algorithms are an object of C++. Its members are those of
    protocol.StaticContact, its results those of ContactOutput.

    A derived class has the attributes `pair`, `comm`, `gdim` and `_cpp_object`.
    """

    _cpp_object: _cpp.multipliers.MortarContact | _cpp.penalty.QuadraturePenalty

    @property
    def fault(self) -> str:
        return str(self._cpp_object.fault)

    @property
    def initial(self) -> _cpp.gap.InitialPenetration:
        """Penetrations in the reference configuration."""
        return self._cpp_object.initial

    # --- load steps --------------------------------------------------------------------------------------------------

    def check_parameters(self) -> None:
        self._cpp_object.check_parameters()

    def begin_step(self, u: FloatArray, displacement: FloatArray | None, target: FloatArray | None = None) -> None:
        self._cpp_object.begin_step(u, None if displacement is None else list(map(float, displacement)), target)

    def state(self) -> _cpp.state.State:
        return self._cpp_object.state()

    def accept_step(self) -> None:
        self._cpp_object.accept_step()

    def augment(self) -> bool:
        return bool(self._cpp_object.augment())

    def prescribed_overlap(self) -> str:
        return str(self._cpp_object.prescribed_overlap())

    def passed_through(self) -> str:
        return str(self._cpp_object.passed_through())

    def saved_state(self) -> _cpp.state.State:
        return self._cpp_object.saved_state()

    def resume(self, saved: _cpp.state.State, u: FloatArray) -> None:
        self._cpp_object.resume(saved, np.ascontiguousarray(u))

    def forget(self) -> None:
        self._cpp_object.forget()

    def stored_energy(self) -> float:
        """Energy of the springs of a penalty, of all ranks; zero with multipliers [F L]. Collective."""
        return float(self._cpp_object.stored_energy())

    # --- Newton iterations -------------------------------------------------------------------------------------------

    def update_gap(self, u: FloatArray) -> None:
        self._cpp_object.update_gap(np.ascontiguousarray(u))

    def update_active_set(self, first: bool, last: int | None = None) -> int:
        return int(self._cpp_object.update_active_set(first, last))

    def contact_forces(self) -> FloatArray:
        return np.asarray(self._cpp_object.contact_forces())

    def add_residual(self, b: PETSc.Vec) -> None:
        self._cpp_object.add_residual(b)

    def update_nodal_stiffness(self, K: PETSc.Mat) -> None:
        self._cpp_object.update_nodal_stiffness(K)

    def tangent(self) -> PETSc.Mat | None:
        return self._cpp_object.tangent()

    @property
    def symmetric(self) -> bool:
        return bool(self._cpp_object.symmetric)

    @property
    def num_active(self) -> int:
        return int(self._cpp_object.num_active)

    def violation(self) -> float:
        return float(self._cpp_object.violation())

    def round_off(self) -> float:
        return float(self._cpp_object.round_off())

    def largest_violation(self) -> str:
        return str(self._cpp_object.largest_violation())

    def mesh_advice(self) -> str:
        return str(self._cpp_object.mesh_advice())

    def rigid_body_products(self, modes: _cpp.solve.RigidBodyModes) -> FloatArray:
        return np.asarray(self._cpp_object.rigid_body_products(modes))

    def close_nearest(self) -> bool:
        return bool(self._cpp_object.close_nearest())

    # --- results -----------------------------------------------------------------------------------------------------

    @property
    def points(self) -> FloatArray:
        return self._rows(self._cpp_object.points)

    @property
    def gap(self) -> FloatArray:
        return np.asarray(self._cpp_object.gap)

    @property
    def normal(self) -> FloatArray:
        return self._rows(self._cpp_object.normal)

    @property
    def pressure(self) -> FloatArray:
        return np.asarray(self._cpp_object.pressure)

    @property
    def traction(self) -> FloatArray:
        return self._rows(self._cpp_object.traction)

    @property
    def slip(self) -> FloatArray:
        return self._rows(self._cpp_object.slip)

    @property
    def status(self) -> IntArray:
        return np.asarray(self._cpp_object.status)

    @property
    def weight(self) -> FloatArray:
        return np.asarray(self._cpp_object.weight)

    def covered(self) -> FloatArray:
        return np.asarray(self._cpp_object.covered())

    def _rows(self, values: FloatArray) -> FloatArray:
        """A flat array as vectors, (n, gdim)."""
        return values.reshape(-1, self.gdim)
