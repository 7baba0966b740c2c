# SPDX-License-Identifier: MIT
"""Newton's method for steady rolling with friction: displacements and multipliers together, docs/rolling.md.

Contact and Coulomb's law are equations of semi-smooth functions (Alart and Curnier 1991; Hueeber, Stadler and Wohlmuth
2008), with the slip velocity in place of the slip of an increment. Each iteration linearises bodies and geometry once,
and then updates the status of the nodes on the linearised problem until it stays.
"""

from __future__ import annotations

import itertools
from typing import Any

import numpy as np
from mpi4py import MPI

from ..common.interrupts import Interrupts
from ..common.types import BoolArray, FloatArray
from ..statics.linear_solver import LinearSolver
from ..statics.load_steps import Increment, StepLog
from ..statics.newton import Newton
from ..statics.problem import StaticProblem
from .contact import RollingContact
from .friction_law import Linearised, linearise
from .saddle_system import SteadySystem
from .torque import TorqueControl

VIOLATION = 1e-9  # gap of an active node over the size of the bodies; slip velocity of a stuck one over the speed
MAX_CHANGES = 40  # updates of the status on one linearised problem
# Trial tractions take so much of the slip velocity over what a traction of the node's stiffness changes it by. With
# more, nodes change from one direction of slip to the other without sticking between, and errors travel with the flow.
CAUTION = 0.1
STILL = 1e-11  # relative change of the tractions at which the linearised problem is solved


class RollingNewton:
    """Solves one increment of a rolling problem with friction.

    Args:
        problem: static problem whose contacts are RollingContact.
        rtol: relative tolerance of the residual [1].
        atol: absolute tolerance of the residual [F].
        max_iterations: largest number of iterations [1].
        interrupts: looks for Ctrl-C between iterations.
        linear_solver: for displacements and multipliers together.
        control: of the torque, which makes the spin an unknown; or None.

    Attributes:
        control: as given; may be changed between runs.
        seconds: time by part, as in Newton.
    """

    def __init__(
        self,
        problem: StaticProblem,
        rtol: float,
        atol: float,
        max_iterations: int,
        interrupts: Interrupts,
        linear_solver: LinearSolver,
        control: TorqueControl | None = None,
    ) -> None:
        self.problem, self.rtol, self.atol, self.max_iterations = problem, rtol, atol, max_iterations
        self._interrupts, self._linear_solver, self.control = interrupts, linear_solver, control
        self.contacts: list[RollingContact] = list(problem.contact)  # type: ignore[arg-type]
        # Without friction, to begin with: active sets and forces to start from.
        self._frictionless = Newton(problem, rtol, atol, max_iterations, lambda *_: interrupts.check())
        self.seconds = self._frictionless.seconds
        self.comm, self.num_owned = problem.space.mesh.comm, problem.num_owned
        self.fixed = np.flatnonzero(problem.fixed[: self.num_owned])
        self._caution = CAUTION

    def free(self) -> None:
        """Nothing is kept beyond the problem's own solver."""

    def run(self, target: FloatArray, log: StepLog) -> Increment:
        """Solve from the present u to prescribed values. Collective.

        Args:
            target: displacements over all degrees of freedom, of which only prescribed entries are used [L].
            log: log of the iterations.
        """
        self._caution = CAUTION
        for contact in self.contacts:
            contact.update_flow()
        if not any(c.num_active for c in self.contacts):
            log("  without friction")
            result = self._frictionless.run(target, log)
            if result.fault:
                return result
            log("  with friction")
        return self._with_friction(target, log)

    def _with_friction(self, target: FloatArray, log: StepLog) -> Increment:
        p, result, scale = self.problem, Increment(), 0.0
        changes, K = 0, None
        for iteration in itertools.count():
            residual = p.assemble_residual().array.copy()
            if not np.all(np.isfinite(self.comm.allgather(float(residual @ residual)))):
                return result.failed(f"the residual is nan in Newton iteration {iteration}")
            for contact in self.contacts:
                contact.update_gap(p.u.x.array)
                contact.turn_to_normals()
                contact.update_matrices()
                contact.slip_velocity = contact.tangential(contact.relative_velocity(p.u.x.array[: self.num_owned]))
            if K is None or not p.body.linear or self.control:  # with a control, W changes with the spin
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
                and wrong < VIOLATION
                and off < VIOLATION
                and norm <= max(self.atol, self.rtol * scale)
            ):
                return result.converged()
            if self.control and self.control.fault:
                return result.failed(self.control.fault, hopeless=True)
            if iteration == self.max_iterations:
                return result.failed(
                    f"steady rolling did not converge in {iteration} iterations: residual {norm:.1e} of {scale:.1e}, "
                    f"violation of contact and friction {wrong:.1e}",
                    advice="Approach the load, the creep or the friction in smaller steps",
                )
            fault, changes = self._solve_linearised(K, residual, jump)
            result.iterations += 1
            if fault:
                return result.failed(f"a linear system of steady rolling was not solved: {fault}")
            if changes == MAX_CHANGES:
                log(f"    status not settled after {changes} updates")
                result.unsettled += 1
                self._caution = max(0.1 * self._caution, 1e-4)

    def _norm(self, values: Any) -> float:
        return float(np.sqrt(self.comm.allreduce(float(values @ values))))

    def _wrong(self) -> float:
        """Largest violation of contact and friction, relative, of all ranks. Collective."""
        largest = 0.0
        for c in self.contacts:
            speed, size = c.speed(), c.geometry.size
            law = self._law(c, c.geometry.gap, c.slip_velocity, c.vector, 1.0)
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

    def _law(
        self, c: RollingContact, gap: FloatArray, slip: FloatArray, vectors: FloatArray, caution: float
    ) -> Linearised:
        weight = np.where(c.carriers, c.geometry.weight, 1.0)
        stiffness = c.nodal_stiffness / weight
        return linearise(
            c.geometry.normal,
            c.friction,
            stiffness,
            caution * stiffness / self._rate(c),
            c.carriers,
            gap,
            slip,
            vectors,
        )

    def _rate(self, c: RollingContact) -> float:
        """Slip velocity per displacement, largest [1/T]: what stick conditions are scaled by."""
        assert c.velocity_jump is not None
        if c.rate is None:
            diagonal = np.abs(c.velocity_jump.getDiagonal().array[c.nodes])
            diagonal /= np.where(c.carriers, c.geometry.cover, np.inf)
            c.rate = float(self.comm.allreduce(float(np.max(diagonal, initial=0.0)), op=MPI.MAX)) or 1.0
        return c.rate

    def _solve_linearised(self, K: Any, residual: FloatArray, jump: FloatArray) -> tuple[str | None, int]:
        """Update u and multipliers by the linearised problem, its status updated until it stays. Collective."""
        p, count = self.problem, 0
        system = SteadySystem(K, [c.tangent() for c in self.contacts], self.contacts, self.fixed, self._rate)
        moved: FloatArray = np.zeros(self.num_owned)
        vectors = [c.vector.copy() for c in self.contacts]
        gaps, slips = [c.geometry.gap for c in self.contacts], [c.slip_velocity for c in self.contacts]
        change, forces = 0.0, sum(c.contact_forces() for c in self.contacts)
        if self.control:
            self.control.linearise(self.contacts)
        before: list[BoolArray] | None = None
        fault: str | None = None
        while True:
            laws = [self._law(*args, self._caution) for args in zip(self.contacts, gaps, slips, vectors)]
            status = [np.stack([law.active, law.sliding]) for law in laws]
            if before is not None:
                differ = sum(int(np.count_nonzero(a != b)) for a, b in zip(status, before))
                changed = self.comm.allreduce(differ)
                still = self._change(laws, vectors)
                if (changed == 0 and still < STILL) or count == MAX_CHANGES:
                    break
            before = status
            system.assign(laws, slips, vectors)
            b, x = system.load(residual, jump), system.guess(moved, vectors)
            fault = system.solve(self._linear_solver, b, x)
            if self.control and not fault:
                fault, change = self.control.correction(
                    system, lambda b, x: system.solve(self._linear_solver, b, x), x, forces
                )
            moved, vectors = system.displacements(x), system.vectors(x)
            b.destroy()
            x.destroy()
            if fault:
                break
            gaps, slips = self._linear_state(moved)
            if self.control:
                slips = [s + change * slope for s, slope in zip(slips, self.control.slopes())]
            count += 1
        system.destroy()
        if fault:
            return fault, count
        for c, law, vector in zip(self.contacts, laws, vectors):
            c.set_vector(vector, law.active, law.sliding)
        p.u.x.array[: self.num_owned] += moved
        p.u.x.scatter_forward()
        if self.control:
            self.control.apply(change)
            for contact in self.contacts:
                contact.update_flow()
        return None, count

    def _linear_state(self, moved: FloatArray) -> tuple[list[FloatArray], list[FloatArray]]:
        """Gaps and slip velocities of the linearised problem. Collective."""
        gaps, slips = [], []
        for c in self.contacts:
            assert c.jump is not None and c.velocity_jump is not None
            gaps.append(c.geometry.gap + np.einsum("na,na->n", c.geometry.normal, c.means(c.jump, moved)))
            slips.append(c.slip_velocity + c.tangential(c.means(c.velocity_jump, moved)))
        return gaps, slips

    def _change(self, laws: list[Linearised], vectors: list[FloatArray]) -> float:
        """How far tractions are from what the law makes of them, relative to the largest. Collective."""
        pairs = [(np.abs(law.target - v).max(initial=0.0), np.abs(v).max(initial=0.0)) for law, v in zip(laws, vectors)]
        off, largest = (self.comm.allreduce(max((float(q[k]) for q in pairs), default=0.0), op=MPI.MAX) for k in (0, 1))
        return off / largest if largest > 0.0 else off
