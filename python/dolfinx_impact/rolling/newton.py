# SPDX-License-Identifier: MIT
"""Newton's method for steady rolling with friction: displacements and multipliers together, docs/rolling.md.

Each iteration linearises bodies and geometry once, and solves contact and friction of the linear bodies, reduced to the
multipliers of the nodes that touch (ReducedContacts).
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import partial
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from .. import _cpp
from ..common.interrupts import Interrupts
from ..common.types import BoolArray, FloatArray
from ..statics.load_steps import StepLog
from ..statics.problem import StaticProblem
from .contact import RollingContact
from .friction_law import Linearised, linearise
from .contact_operators import ContactOperators
from .reduced_contacts import ReducedContacts
from .torque import NO_FRICTION, OUT_OF_REACH, ReducedTorque, TorqueControl

# Gap of an active node over the size of the bodies; slip velocity of a stuck one over the speed. The option
# contact_tolerance sets another one.
VIOLATION = 1e-9
STILL = 1e-11  # relative change of the tractions at which the linearised problem is solved
NEARLY = 1e-8  # and this one, if corrections do not make it smaller
MAX_CORRECTIONS = 16
POOR = 7  # corrections after which the compliance is that of a state too far away
HELD_BY_CONTACT = "a body is held by nothing but contact and friction: prescribe its displacement somewhere"


@dataclass
class _Trial:
    """A state of the linearised problem.

    Attributes:
        moved: displacements from the state that is linearised about, owned dofs [L].
        vectors: multipliers of the contacts, (n, gdim) each [F/L^2].
        gaps, slips: of the contacts, (n) each [L], (n, gdim) each [L/T].
        laws: contact and friction at these.
        off: what the multipliers differ by from those that the laws make of them, over the largest [1].
    """

    moved: FloatArray
    vectors: list[FloatArray]
    gaps: list[FloatArray]
    slips: list[FloatArray]
    laws: list[Linearised]
    off: float


class RollingNewton:
    """Solves one increment of a rolling problem with friction.

    Args:
        problem: static problem whose contacts are RollingContact.
        rtol: relative tolerance of the residual [1].
        atol: absolute tolerance of the residual [F].
        max_iterations: largest number of iterations [1].
        interrupts: looks for Ctrl-C between iterations.
        reduced: contacts, reduced to the nodes that touch.
        control: of the torque, which makes the spin an unknown; or None.

    Attributes:
        control: as given; may be changed between runs.
    """

    def __init__(
        self,
        problem: StaticProblem,
        rtol: float,
        atol: float,
        max_iterations: int,
        interrupts: Interrupts,
        reduced: ReducedContacts,
        control: TorqueControl | None = None,
    ) -> None:
        self.problem, self.rtol, self.atol, self.max_iterations = problem, rtol, atol, max_iterations
        self._interrupts, self._reduced, self.control = interrupts, reduced, control
        self.contacts: list[RollingContact] = list(problem.contact)  # type: ignore[arg-type]
        # Without friction, to begin with: active sets and forces to start from.
        options = _cpp.solve.NewtonOptions().with_database(problem.linear_solver.prefix)
        options.rtol, options.atol, options.max_iterations = rtol, atol, max_iterations
        self._frictionless = _cpp.solve.Newton(problem.equilibrium, options)
        self._violation = PETSc.Options(problem.linear_solver.prefix).getReal("contact_tolerance", VIOLATION)
        self.comm, self.num_owned = problem.space.mesh.comm, problem.num_owned
        self.fixed = np.flatnonzero(problem.fixed[: self.num_owned])

    @property
    def seconds(self) -> dict[str, float]:
        """Time by part, as in Newton [s]."""
        return self._frictionless.seconds

    def free(self) -> None:
        """Nothing is kept beyond the problem's own solver."""

    def run(self, target: FloatArray, log: StepLog) -> _cpp.solve.Increment:
        """Solve from the present u to prescribed values. Collective.

        Args:
            target: displacements over all degrees of freedom, of which only prescribed entries are used [L].
            log: log of the iterations.
        """
        for contact in self.contacts:
            contact.update_flow()
        if not any(c.num_active for c in self.contacts):
            log("  without friction")
            result = self._frictionless.run(target, log, log.progress.show, partial(self._iteration, log))
            if result.fault:
                return result
            log("  with friction")
        return self._with_friction(target, log)

    def _iteration(self, log: StepLog, i: int, norm: float, scale: float, size: int, changes: int) -> None:
        """An iteration without friction. Collective."""
        log.iteration(i, norm, scale, size, changes)
        self._interrupts.check()

    def _with_friction(self, target: FloatArray, log: StepLog) -> _cpp.solve.Increment:
        p, result, scale = self.problem, _cpp.solve.Increment(), 0.0
        changes, K = 0, None
        iteration = -1
        while True:
            iteration += 1
            residual = p.assemble_residual().array.copy()
            if not np.all(np.isfinite(self.comm.allgather(float(residual @ residual)))):
                return result.failed(f"the residual is nan in Newton iteration {iteration}")
            for contact in self.contacts:
                contact.update_gap(p.u.x.array)
                contact.turn_to_normals()
                contact.update_matrices()
                contact.slip_velocity = contact.tangential(contact.relative_velocity(p.u.x.array[: self.num_owned]))
            if K is None or not p.body.properties.linear or self.control:  # with a control, W changes with the spin
                K = p.tangent.assemble()
            for contact in self.contacts:
                contact.update_nodal_stiffness(K)
            equilibrium = residual - sum(c.contact_forces() for c in self.contacts)
            scale = max(scale, self._norm(equilibrium), self._norm(residual))
            free = equilibrium.copy()
            free[self.fixed] = 0.0
            norm = self._norm(free)
            jump = target[self.fixed] - p.u.x.array[self.fixed]
            moved = self.comm.allreduce(int(np.any(jump))) == 0
            wrong = self._wrong()
            off = self.control.error(self.contacts) if self.control else 0.0
            result.add(norm, sum(c.num_active for c in self.contacts), changes)
            log.iteration(iteration, norm, scale, result.active_set_sizes[-1], changes)
            log(f"    violation of contact and friction {wrong:.2e}" + (f", torque off {off:.2e}" if off else ""))
            self._interrupts.check()
            if (
                moved
                and iteration > 0
                and wrong < self._violation
                and off < self._violation
                and norm <= max(self.atol, self.rtol * scale)
            ):
                return result.converged()
            if iteration == self.max_iterations:
                return result.failed(
                    f"steady rolling did not converge in {iteration} iterations: residual {norm:.1e} of {scale:.1e}, "
                    f"violation of contact and friction {wrong:.1e}",
                    advice="Approach the load, the creep or the friction in smaller steps",
                )
            fault, changes = self._solve_linearised(K, residual, jump)
            result.iterations += 1
            if fault:
                if self.control is not None and fault in (OUT_OF_REACH, NO_FRICTION):
                    wanted, omega = self.control.target, self.control.omega
                    fault = f"the torque {wanted:.4g} was not reached at omega = {omega:.6g}: {fault}"
                    return result.failed(fault, hopeless=True)
                fault = f"steady rolling was not solved: {fault}"
                return result.failed(fault, hopeless=HELD_BY_CONTACT in fault)

    def _norm(self, values: Any) -> float:
        return float(np.sqrt(self.comm.allreduce(float(values @ values))))

    def _wrong(self) -> float:
        """Largest violation of contact and friction, relative, of all ranks. Collective."""
        largest = 0.0
        for c in self.contacts:
            speed, size = c.speed(), c.geometry.size
            law = self._law(c, c.geometry.gap, c.slip_velocity, c.vector)
            pressure = self.comm.allreduce(float(np.max(c.multiplier, initial=0.0)), op=MPI.MAX)
            here = [0.0]
            if len(c.nodes):
                here.append(float(np.max(np.where(law.active & c.carriers, np.abs(c.geometry.gap), 0.0))) / size)
                stuck = law.active & ~law.sliding & c.carriers
                if speed > 0.0 and c.friction > 0.0:
                    here.append(float(np.max(np.where(stuck, np.linalg.norm(c.slip_velocity, axis=1), 0.0))) / speed)
                if pressure > 0.0:
                    here.append(float(np.max(np.abs(law.target - c.vector))) / pressure * 1e-2)
            largest = max(largest, *here)
        return float(self.comm.allreduce(largest, op=MPI.MAX))

    def _law(self, c: RollingContact, gap: FloatArray, slip: FloatArray, vectors: FloatArray) -> Linearised:
        weight = np.where(c.carriers, c.geometry.weight, 1.0)
        stiffness = c.nodal_stiffness / weight
        return linearise(
            c.geometry.normal, c.friction, stiffness, stiffness / self._rate(c), c.carriers, gap, slip, vectors
        )

    def _rate(self, c: RollingContact) -> float:
        """Slip velocity per displacement, largest [1/T]: what stick conditions are scaled by."""
        assert c.velocity_jump is not None
        if c.rate is None:
            diagonal = np.abs(c.velocity_jump.getDiagonal().array[c.nodes])
            diagonal /= np.where(c.carriers, c.geometry.cover, np.inf)
            c.rate = float(self.comm.allreduce(float(np.max(diagonal, initial=0.0)), op=MPI.MAX)) or 1.0
        return c.rate

    def _solve_linearised(self, K: Any, residual: FloatArray, jump: FloatArray) -> tuple[str, int]:
        """Update u and multipliers by the linearised problem. Collective.

        The compliance of the candidates is that of an earlier geometry; what it leaves is corrected with the present
        one.
        """
        response = self._reduced.response
        operators = ContactOperators(K, self.contacts)
        response.update(K, [c.tangent() for c in self.contacts])
        if response.null_pivots:
            operators.destroy()
            return HELD_BY_CONTACT, 0
        weights = operators.weights()
        torque = self.control.linearise(self.contacts, operators, response) if self.control else None
        forces: list[FloatArray] = [w[:, None] * c.vector for w, c in zip(weights, self.contacts)]
        best, corrections, change = np.inf, 0, 0.0
        while True:
            load = operators.nodal_forces(forces) - residual
            if torque:
                load -= change * torque.load
            moved, fault = response.solve(load, jump)
            if fault:
                break
            vectors: list[FloatArray] = [f / np.where(w > 0.0, w, 1.0)[:, None] for f, w in zip(forces, weights)]
            trial = self._trial(moved, vectors, change, torque)
            off = max(trial.off, torque.missing(operators, forces, moved) if torque else 0.0)
            if corrections and (off < STILL or (off < NEARLY and off > 0.5 * best)):
                break
            if corrections == MAX_CORRECTIONS:
                break
            if corrections == POOR:
                self._reduced.renew()
                response.update(K, [c.tangent() for c in self.contacts])
            best = min(best, off)
            if torque:
                torque.at(operators, forces, moved)
            forces, further, fault = self._reduced.forces(
                operators, self._near(trial), (forces, trial.gaps, trial.slips), torque
            )
            change += further
            if fault:
                break
            corrections += 1
        operators.destroy()
        if fault:
            return fault, corrections
        for c, law, vector in zip(self.contacts, trial.laws, trial.vectors):
            c.set_vector(vector, law.active, law.sliding)
        p = self.problem
        p.u.x.array[: self.num_owned] += moved
        p.u.x.scatter_forward()
        if self.control:
            self.control.apply(change)
            for contact in self.contacts:
                contact.update_flow()
        return "", corrections

    def _near(self, trial: _Trial) -> list[BoolArray]:
        """Nodes that touch, or have a facet in common with one that does. Collective."""
        return [
            c.with_neighbours(c.carriers & (law.active | np.any(vector != 0.0, axis=1))) & c.carriers
            for c, law, vector in zip(self.contacts, trial.laws, trial.vectors)
        ]

    def _trial(
        self, moved: FloatArray, vectors: list[FloatArray], change: float, torque: ReducedTorque | None
    ) -> _Trial:
        """Gaps, slip velocities and law of the linearised problem. Collective."""
        gaps: list[FloatArray] = []
        slips: list[FloatArray] = []
        for c in self.contacts:
            assert c.jump is not None and c.velocity_jump is not None
            gaps.append(c.geometry.gap + np.einsum("na,na->n", c.geometry.normal, c.means(c.jump, moved)))
            slips.append(c.slip_velocity + c.tangential(c.means(c.velocity_jump, moved)))
        if torque:
            slips = [s + change * slope for s, slope in zip(slips, torque.slopes)]
        laws = [self._law(*args) for args in zip(self.contacts, gaps, slips, vectors)]
        return _Trial(moved, vectors, gaps, slips, laws, self._change(laws, vectors))

    def _change(self, laws: list[Linearised], vectors: list[FloatArray]) -> float:
        """How far tractions are from what the law makes of them, relative to the largest. Collective."""
        pairs = [(np.abs(law.target - v).max(initial=0.0), np.abs(v).max(initial=0.0)) for law, v in zip(laws, vectors)]
        off, largest = (self.comm.allreduce(max((float(q[k]) for q in pairs), default=0.0), op=MPI.MAX) for k in (0, 1))
        return off / largest if largest > 0.0 else off
