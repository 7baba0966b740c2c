# SPDX-License-Identifier: MIT
"""Newton's method for equilibrium and contact; seed (3.61)-(3.66), figure 3.5.

Every iteration linearises the bodies and the geometry of contact about the present displacements, and updates the
active set on the linearised problem to convergence. This is a primal-dual active set method with constant stiffness, so
that its linear systems differ in few rows and share a preconditioner.
"""

from __future__ import annotations

import contextlib
import itertools
import time
from collections.abc import Callable, Iterator, Sequence
from typing import TYPE_CHECKING, cast

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from ..common.described import Described
from ..assembly import rigid_body_modes
from ..assembly.fields import is_mixed
from .. import _cpp
from .linearised_active_set import LinearisedActiveSet, LinearisedSystem
from .equilibrium import open_contacts, out_of_balance
from .field_residuals import FieldResiduals
from .active_set_iteration import VIOLATION, ActiveSetIteration, RepeatedStates, did_not_converge
from .load_steps import StepLog
from ..common.types import FloatArray, IntArray
from ..contact.mortar.shared_nodes import over_constrained
from ..contact.protocol import MultiplierContact

if TYPE_CHECKING:
    from ..contact.mortar.lagrange import LagrangeContact
    from ..contact.penalty.penalty import PenaltyContact
    from .equilibrium_problem import EquilibriumProblem

LOOSE_DIGITS = 1e-3  # relative tolerance of linear solutions while the active set changes
MAX_CHANGES = 60  # updates of the active set in one linearised problem
PLAIN = 6  # iterations without a line search
INELASTIC_PLAIN = 2  # those with internal variables and without multipliers
FAR = 1e-6  # round-off over the largest force at which displacements are those of a body that has flown away
PARTS = (1.0, 0.5, 0.25, 0.125, 0.0625)  # fractions of a Newton step that a line search tries
SEARCHES, STEEP = 8, 0.5  # evaluations of a line search; slope at its end relative to that at its start


class Newton(Described):
    """Solves one increment of a problem.

    Args:
        problem: problem.
        rtol: relative tolerance of the residual, as in StaticProblem.solve [1].
        atol: absolute tolerance of the residual, as in StaticProblem.solve [F].
        max_iterations: largest number of iterations [1].
        tell: function that is called with the number of every iteration and the norm of its residual, or None.

    Attributes:
        seconds: time spent on this rank so far in "bodies" (residual, stiffness), "contact" (search, integrals,
            assembly, active set) and "linear" (condensation, preconditioner, solution) [s].
    """

    def __init__(
        self,
        problem: EquilibriumProblem,
        rtol: float,
        atol: float,
        max_iterations: int,
        tell: Callable[[int, float], None] | None = None,
    ) -> None:
        self.problem, self.rtol, self.atol, self.max_iterations = problem, rtol, atol, max_iterations
        self._tell = tell or (lambda iteration, norm: None)
        self.comm, self.num_owned = problem.space.mesh.comm, problem.num_owned
        self.fixed: IntArray = np.flatnonzero(problem.fixed[: self.num_owned])
        self.multipliers: list[MultiplierContact] = [
            cast(MultiplierContact, c) for c in problem.contact if c.has_multipliers
        ]
        self.saddle = problem.keeps_multipliers
        # Contact by penalty has kinks where points close, slip or change facets; there is no active set for them.
        self.rough = bool(problem.contact) and not self.multipliers
        # Perfect plasticity near collapse: the tangents of two iterations may be far apart. The body's residual
        # is the gradient of the increment's energy, or nearly so (recovery of the back stress, finite strain).
        self.inelastic = problem.body.inelastic
        searches = self.inelastic and not self.multipliers
        self.plain = INELASTIC_PLAIN if searches else PLAIN
        self.rough = self.rough or searches
        self.conservative = self.rough and all(c.pair.friction == 0.0 for c in problem.contact)
        # Linear solutions are more accurate than asked for by this factor; with factors, accuracy is cheap.
        self.margin = 1e-3 if problem.linear_solver.direct else 0.3
        self._diameters: FloatArray | None = None
        mixed = is_mixed(problem.space)
        self._fields = FieldResiduals(problem.space, problem.fixed) if mixed else None
        self._factorised: tuple[int, int] = (0, 0)  # matrix and its state that factors are of, with several fields
        self.seconds: dict[str, float] = dict.fromkeys(("bodies", "contact", "linear"), 0.0)
        if self.saddle:
            sizes, gdim = [len(c.nodes) for c in self.multipliers], problem.space.mesh.geometry.dim
            self._rows = _cpp.multipliers.SaddlePoint(self.comm, self.num_owned, gdim, sizes)
            self._forces = np.zeros(gdim * sum(sizes))

    def run(self, target: FloatArray, log: StepLog) -> _cpp.solve.Increment:
        """Solve from the present u to prescribed values. Collective.

        Args:
            target: displacements over all degrees of freedom, of which only prescribed entries are used [L].
            log: log of the iterations.

        Returns:
            Increment; its `fault` says why it did not converge.
        """
        p, result = self.problem, _cpp.solve.Increment()
        scale, inner, noise, round_start, before, settling = 0.0, 0.0, 0.0, 0, None, 0
        unbalanced = np.inf
        self._K: PETSc.Mat | None = None
        if self._fields is not None:
            self._fields.begin()
        for iteration in itertools.count():
            with self._clock("bodies"):
                b = p.assemble_residual()
                unsolved = p.body.fault()
            if unsolved:
                result.add(float("nan"), 0, 0)
                return result.failed(f"{unsolved} in Newton iteration {iteration}")
            if not np.isfinite(b.norm()):
                result.add(float("nan"), 0, 0)
                return result.failed(f"the residual is nan in Newton iteration {iteration}: the state cannot be "
                                     "evaluated (inverted cells?)")  # fmt: skip
            with self._clock("contact"):
                bodies = b.array.copy()
                for contact in p.contact:
                    contact.update_gap(p.u.x.array)
                    if not contact.has_multipliers:
                        contact.add_residual(b)
                residual = b.array.copy()
                if self.saddle and iteration > 0:
                    for multiplier in self.multipliers:
                        multiplier.rotate_friction_traction()
                changes, pending = self._update_active_sets(residual, iteration == 0)
                if self.saddle:
                    residual -= sum(c.contact_forces() for c in self.multipliers)
                imposed = [] if self.saddle else [c.imposed_friction_forces() for c in self.multipliers]
                scale = max(scale, self.norm(residual))
                norm = self._free_norm(residual - sum(f for f in imposed if f is not None))
            jump = target[self.fixed] - p.u.x.array[self.fixed]
            moved = self.comm.allreduce(int(np.any(jump))) == 0
            violation = max((c.violation() for c in p.contact), default=0.0)
            result.add(norm, sum(c.num_active for c in p.contact), changes + settling)
            log.iteration(iteration, norm, max(scale, inner), result.active_set_sizes[-1], result.changes[-1])
            self._tell(iteration, norm)
            settled = iteration > 0 or not p.contact
            tolerance = max(self.atol, noise, self.rtol * max(scale, inner))
            small = norm <= tolerance
            if self._fields is not None:
                if self._K is not None:
                    self._measure_fields(self._K, residual)
                small = self._fields.small(residual, self.rtol, self.atol) and small
            if iteration > 0 and self.multipliers and max(scale, inner) <= self._gap_round_off():
                # Nothing acts: the multipliers that close gaps of round-off have no state that could be found.
                small, pending = True, 0
            if iteration == 0:
                result.closed = [c.num_active > 0 for c in p.contact]
            if moved and settled and pending == 0 and violation < VIOLATION and small:
                lost = self._lost_contact(result.closed)
                if lost:
                    return result.failed(lost)
                again = any([c.augment() for c in p.contact])
                faults = [c.fault for c in p.contact if c.fault]
                if faults:
                    return result.failed("; ".join(faults), hopeless=True)
                if again:
                    round_start = iteration
                    continue
                missing = out_of_balance(p, bodies, tolerance)
                if missing is None:
                    return result.converged()
                # Directions of friction follow the normals one iteration later: what is missing falls then.
                last = iteration - round_start == self.max_iterations
                if last or missing.norm > 0.5 * unbalanced:
                    return result.failed(missing.text, hopeless=True)
                unbalanced = missing.norm
            if iteration - round_start == self.max_iterations or result.stalled():
                break
            period = result.cycle() if iteration - round_start > 0 else 0
            K = self._stiffness()
            if iteration == 0 and p.contact and not p.body.has_inertia:
                loose = self.unconstrained_modes(K)
                if loose:
                    return result.failed(loose, hopeless=True)
            inner = max(inner, self.tangent_force(K))
            if self._fields is not None:
                self._measure_fields(K, residual)
                self._forget_factors(K)
            in_bodies = self._round_off_of_bodies(K)
            noise = in_bodies + self._round_off_of_contact()
            if self.inelastic and iteration > 0 and in_bodies > FAR * scale > 0.0:
                return result.failed(f"Newton's method diverged: in iteration {iteration} the displacements are so "
                                     "large that the residual is round-off")  # fmt: skip
            # The accuracy that is still needed, but no more than the quadratic convergence of the next step.
            digits = 1e-10 if not p.contact and p.body.linear else LOOSE_DIGITS
            if moved and norm > 0:
                enough = self.margin * max(self.atol, self.rtol * max(scale, inner)) / norm
                likely = 0.1 * (norm / before) ** 2 if before else 1e-4
                digits = min(digits, max(enough, min(likely, LOOSE_DIGITS)))
            before, start = norm if moved else None, p.u.x.array.copy()
            fault, settling, left = self._solve(K, residual, jump, digits, log, result.unsettled)
            result.iterations += 1
            result.unsettled += left > 0
            result.unsettled_in_succession = result.unsettled_in_succession + 1 if left > 0 else 0
            p.u.x.array[p.fixed] = target[p.fixed]  # without round-off
            if fault and p.contact and not p.body.has_inertia:
                loose = self.unconstrained_modes(K)
                if loose:
                    return result.failed(f"{loose}; the linear solver failed ({fault})", hopeless=True)
            if fault:
                crowded = over_constrained(self.multipliers)
                if crowded:
                    return result.failed(f"the linear problem has no solution: {crowded}", advice="")
                collapse = " Is the load more than the body can bear?" if self.inelastic else ""
                return result.failed(
                    f"the linear solver failed ({fault}): is the body held against rigid motion?{collapse}"
                )
            if period and moved:  # half a step leaves the cycle
                p.u.x.array[:] = start + 0.5 * (p.u.x.array - start)
            elif self.rough and moved and iteration - round_start >= self.plain:
                if self.conservative:
                    self._descend(K, start, residual, digits, log)
                else:
                    self._backtrack(start, norm)
        return did_not_converge(result, self, moved, small, pending, violation)

    def _lost_contact(self, closed: Sequence[bool]) -> str:
        """Message about points that have passed through a master, or bodies that nothing holds any more as contacts
        have opened; an empty text if there are none. Collective.

        Args:
            closed: whether each contact was closed at the start of the increment.
        """
        p = self.problem
        passed = [text for text in [c.passed_through() for c in p.contact] if text]
        if passed:
            return "; ".join(passed)
        if p.body.has_inertia:
            return ""
        lost = open_contacts(p, closed)
        if not lost:
            return ""
        bearing = [c for c in p.contact if c.num_active > 0]
        springs = self._stiffness() if p.body.has_springs else None
        loose = rigid_body_modes.unconstrained_modes(p.space, p.fixed, bearing, p.u.x.array, p.axisymmetric, springs)
        return f"contact was lost ({'; '.join(lost)}), and {'; '.join(loose)}" if loose else ""

    @contextlib.contextmanager
    def _clock(self, part: str) -> Iterator[None]:
        """Add the time of a `with` block to a part of `seconds`."""
        start = time.perf_counter()
        yield
        self.seconds[part] += time.perf_counter() - start

    def _backtrack(self, start: FloatArray, norm: float) -> None:
        """Halve the step from `start`, at most four times, until the norm of the residual is less than `norm`, which it
        is at the start. Collective.

        Newton's method can cycle where points change between stick and slip.
        """
        p, step = self.problem, self.problem.u.x.array - start
        norms = {}
        for part in PARTS:
            p.u.x.array[:] = start + part * step
            norms[part] = self._residual_norm()
            if norms[part] < norm:
                return
        p.u.x.array[:] = start + min(PARTS, key=lambda part: norms[part]) * step

    def _descend(self, K: PETSc.Mat, start: FloatArray, residual: FloatArray, digits: float, log: StepLog) -> None:
        """Line search along the step from `start` for a problem without friction. Collective.

        Without friction the residual is the gradient of an energy, which may decrease while the norm of the residual
        increases. If Newton's step is no descent direction, a step with the positive semi-definite part of the contact
        tangent is taken instead.

        Args:
            K: stiffness of the bodies [F/L].
            start: displacements at the start of the step [L].
            residual: residual at the start [F].
            digits: relative tolerance of a linear solution [1].
            log: log of the iterations.
        """
        p, free = self.problem, np.ones(self.num_owned, dtype=bool)
        free[self.fixed] = False

        end: FloatArray = p.u.x.array.copy()

        def slope(forces: FloatArray) -> float:
            return self.comm.allreduce(float(forces[free] @ (end - start)[: self.num_owned][free]))

        steep = slope(residual)
        if steep >= 0.0 and not p.contact:
            return
        if steep >= 0.0:
            p.u.x.array[:] = start
            penalties = cast("list[PenaltyContact]", p.contact)  # only these have no multipliers
            for contact in penalties:
                contact.update_gap(start)
                contact.convex = True
            fault, *_ = self._solve(K, residual, np.zeros(len(self.fixed)), digits, log)
            for contact in penalties:
                contact.convex = False
            if fault:
                p.u.x.array[:] = start
                return
            end = p.u.x.array.copy()
            steep = slope(residual)
        low, high = 0.0, 1.0
        part = high
        for _ in range(SEARCHES):
            p.u.x.array[:] = start + part * (end - start)
            here = slope(self._residual())
            if here <= STEEP * abs(steep) and (part == 1.0 or here >= -STEEP * abs(steep)):
                return
            low, high = (part, high) if here < 0.0 else (low, part)
            part = 0.5 * (low + high)

    def _residual(self) -> FloatArray:
        """Free residual at u of a problem without multipliers, over owned degrees of freedom [F]. Collective."""
        b = self.problem.assemble_residual()
        with self._clock("contact"):
            for contact in self.problem.contact:
                contact.update_gap(self.problem.u.x.array)
                contact.add_residual(b)
        residual = b.array.copy()
        residual[self.fixed] = 0.0
        return residual

    def _residual_norm(self) -> float:
        """Norm of `_residual`, infinite where it is not a number [F]. Collective."""
        norm = self.norm(self._residual())
        return norm if np.isfinite(norm) and not self.problem.body.fault() else np.inf

    # --- checks of an iteration ------------------------------------------------------------------------------------

    def norm(self, values: FloatArray) -> float:
        return float(np.sqrt(self.comm.allreduce(float(values @ values))))

    def _update_active_sets(self, residual: FloatArray, first: bool) -> tuple[int, int]:
        """Update multipliers and active sets. Collective.

        Returns:
            Number of points that changed, and number of those that must not change in a converged state.
        """
        changes, pending = 0, 0
        for contact in self.problem.contact:
            if not first and not self.saddle:
                contact.update_multipliers(residual)
            changed = contact.update_active_set(first)
            changes += changed
            # The residual of penalty contact is already that of the new status; where the friction limit is reached
            # exactly, round-off decides on the status.
            pending += changed if contact.has_multipliers else 0
        if not first:
            pending += sum([c.num_turning() for c in self.multipliers])
        return changes, pending

    def _free_norm(self, residual: FloatArray) -> float:
        """Norm of a residual without the equations of multipliers and supports [F]. Collective."""
        transformation = self._transformation()
        free = transformation.residual(residual) if transformation else residual.copy()
        free[self.fixed] = 0.0
        return self.norm(free)

    def unconstrained_modes(self, K: PETSc.Mat) -> str:
        """Message about bodies that neither supports nor contacts constrain, or an empty text. Collective.

        Args:
            K: tangent of the bodies [F/L].
        """
        p = self.problem
        springs = K if p.body.has_springs else None
        loose = rigid_body_modes.unconstrained_modes(p.space, p.fixed, p.contact, p.u.x.array, p.axisymmetric, springs)
        if not loose:
            return ""
        gaps = [(c.pair.name, self.comm.allreduce(float(np.min(c.gap, initial=np.inf)), MPI.MIN)) for c in p.contact]
        apart = [f"{name}: smallest gap {gap:.3e}" for name, gap in gaps if gap > 0]
        hint = f" ({'; '.join(apart)}: let them touch first, or hold or move the body)" if apart else ""
        return f"not held against rigid motion: {'; '.join(loose)}{hint}"

    def _stiffness(self) -> PETSc.Mat:
        """Tangent of the bodies at u [F/L]; that of a linear law is assembled once per increment. Collective."""
        if self._K is None or not self.problem.body.linear:
            with self._clock("bodies"):
                self._K = self.problem.tangent.assemble()
        return self._K

    def tangent_force(self, K: PETSc.Mat) -> float:
        """Norm of the free entries of tangent times u [F]: the size of internal forces that balance each other. With
        inertia, u is the displacement of the step. Collective."""
        origin = self.problem.body.origin
        moved = self.problem.u.x.array[: self.num_owned]
        forces = self._product([K], moved if origin is None else moved - origin)
        forces[self.fixed] = 0.0
        return self.norm(forces)

    def _measure_fields(self, K: PETSc.Mat, residual: FloatArray) -> None:
        """Measure the equations of all fields at u, with a tangent near it. Collective."""
        assert self._fields is not None
        origin = self.problem.body.origin
        moved = self.problem.u.x.array[: self.num_owned]
        self._fields.measure(K, moved if origin is None else moved - origin, residual)

    def _forget_factors(self, K: PETSc.Mat) -> None:
        """Forget factors of another tangent: they would solve the equations of several fields in one norm of all, in
        which the small ones are lost. Collective."""
        state = (K.handle, K.stateGet())
        if state != self._factorised:
            self.problem.linear_solver.reset()
            self._factorised = state

    def fields_balance(self, K: PETSc.Mat, residual: FloatArray) -> bool:
        """Whether the equation of each field of a mixed space holds; true for others. Collective.

        Args:
            K: tangent.
            residual: residual over owned degrees of freedom.
        """
        if self._fields is None:
            return True
        self._fields.begin()
        self._fields.measure(K, self.problem.u.x.array[: self.num_owned], residual)
        return self._fields.small(residual, self.rtol, self.atol)

    def round_off(self, K: PETSc.Mat) -> float:
        """Norm of the round-off in the residual [F]. Collective.

        Args:
            K: tangent of the bodies [F/L].
        """
        return self._round_off_of_bodies(K) + self._round_off_of_contact()

    def _round_off_of_contact(self) -> float:
        """Norm of the round-off in the contact forces [F]. Collective."""
        return sum(c.round_off() for c in self.problem.contact)

    def _gap_round_off(self) -> float:
        """Norm of the forces that gaps of round-off make [F]. Collective."""
        return sum(c.gap_round_off() for c in self.multipliers)

    def _round_off_of_bodies(self, K: PETSc.Mat) -> float:
        """Norm of the round-off in the residual of the bodies [F]. Collective.

        That of a stiff body with a rigid displacement; with finite strain also that of 1 + Grad u, which is the
        stiffness times a cell's size, however small u is.
        """
        p = self.problem
        moved = np.abs(p.u.x.array[: self.num_owned])
        if p.material is not None and not p.body.linear and not p.body.has_inertia:
            moved = moved + self._sizes()
        diagonal = K.getDiagonal()
        forces = diagonal.array * moved
        diagonal.destroy()
        return 4 * np.finfo(float).eps * self.norm(forces)

    def _sizes(self) -> FloatArray:
        """Diameter of the smallest cell at each owned degree of freedom [L]."""
        if self._diameters is None:
            V = self.problem.space
            mesh, dofs = V.mesh, V.dofmap.list
            cells = np.arange(len(dofs), dtype=np.int32)
            smallest = np.full(V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts, np.inf)
            np.minimum.at(smallest, dofs, mesh.h(mesh.topology.dim, cells)[:, None])
            self._diameters = np.repeat(smallest, V.dofmap.index_map_bs)[: self.num_owned]
        return self._diameters

    # --- the linear problem ----------------------------------------------------------------------------------------

    def _transformation(self) -> _cpp.multipliers.Condensation | None:
        """Condensation of the multipliers; None if there are none, or if they stay in the system."""
        if not self.multipliers or self.saddle:
            return None
        space = self.problem.space
        start = space.dofmap.index_map.local_range[0] * space.dofmap.index_map_bs
        parts = [c.constraints() for c in self.multipliers]
        return _cpp.multipliers.Condensation(self.comm, self.num_owned, start, space.mesh.geometry.dim, parts)

    def _solve(
        self, K: PETSc.Mat, residual: FloatArray, jump: FloatArray, rtol: float, log: StepLog, unsettled: int = 0
    ) -> tuple[str | None, int, int]:
        """Solve the linearised problem with updates of its active set, and update u. Collective.

        Args:
            K: stiffness of the bodies [F/L].
            residual: residual without contact forces of multipliers, over owned degrees of freedom [F].
            jump: increments of the prescribed displacements, over `fixed` [L].
            rtol: relative tolerance of the linear solution [1].
            log: log of the iterations.
            unsettled: number of linearised problems of this increment whose active set did not converge [1].

        Returns:
            What went wrong, or None; number of changes of the active set; number of nodes that were still wrong.
        """
        p, changes = self.problem, 0
        if self.saddle:
            residual = residual + sum(c.contact_forces() for c in self.multipliers)
            self._start = self._forces.copy()
        with self._clock("contact"):
            for contact in p.contact:
                contact.update_nodal_stiffness(K)
            parts = [(c, c.tangent()) for c in p.contact]
            penalties = [s for c, s in parts if not c.has_multipliers]
            geometric = [s for c, s in parts if c.has_multipliers and s is not None]
            symmetric = p.body.symmetric and all([c.symmetric for c in p.contact])
            for force in [c.closing_forces() for c in p.contact]:
                residual = residual if force is None else residual + force
        diagonal = K.getDiagonal()
        mean = self.comm.allreduce(float(np.abs(diagonal.array).sum())) / diagonal.getSize() or 1.0
        diagonal.destroy()
        moved: FloatArray = np.zeros(self.num_owned)
        moved[self.fixed] = jump
        digits, settle, corrected, left = (LOOSE_DIGITS if self.multipliers else rtol), ActiveSetIteration(), False, 0
        repeated = RepeatedStates(self.comm, unsettled)
        while True:
            fault, moved, forces, found = self.one_solution(
                K, penalties, geometric, symmetric, residual, moved, mean, digits
            )
            changes += found
            if fault or not self.multipliers:
                break
            with self._clock("contact"):
                for multiplier in self.multipliers:
                    multiplier.update_linearised_gap(moved)
                    if not self.saddle:
                        multiplier.update_multipliers(residual + forces)
                if self.saddle:
                    self._set_multipliers(mean)
                found = settle.change(self.multipliers)
                log.progress.show(f"update {settle.count} of the active set: {found} nodes change")
            if found == 0:
                if corrected and digits <= rtol:
                    break
                digits = rtol
                if not corrected:
                    with self._clock("contact"):
                        self._correct(moved)
                    corrected = True
            elif settle.count == MAX_CHANGES or self._repeats(settle, repeated):
                log(f"    active set not converged after {settle.count} updates: {found} nodes still change")
                left = found
                break
            changes += found
        p.u.x.array[: self.num_owned] += moved
        p.u.x.scatter_forward()
        return fault, changes, left

    def _repeats(self, settle: ActiveSetIteration, repeated: RepeatedStates) -> bool:
        """Do updates of single nodes go round? Collective."""
        if settle.patience > 0:
            repeated.forget()
            return False
        return repeated.stops(self.multipliers)

    def _correct(self, moved: FloatArray) -> None:
        """Apply the second-order correction of contacts at the solution of the linearised problem. Collective.

        Args:
            moved: displacement increments over owned degrees of freedom [L].
        """
        u = self.problem.u.x
        here = u.array.copy()
        u.array[: self.num_owned] += moved
        u.scatter_forward()
        for contact in self.multipliers:
            contact.correct_linearisation(u.array)
        u.array[:] = here

    def one_solution(
        self,
        K: PETSc.Mat,
        penalties: Sequence[PETSc.Mat],
        geometric: Sequence[PETSc.Mat],
        symmetric: bool,
        residual: FloatArray,
        guess: FloatArray,
        mean: float,
        rtol: float,
    ) -> tuple[str | None, FloatArray, FloatArray, int]:
        """Solve the linear system of the present active set. Collective.

        Args:
            K: stiffness of the bodies [F/L].
            penalties: tangents of penalty contacts [F/L].
            geometric: tangents of multiplier contacts at given multipliers [F/L].
            symmetric: whether all contact tangents are symmetric.
            residual: residual over owned degrees of freedom [F].
            guess: displacement increments that the solver starts from, over owned degrees of freedom [L].
            mean: mean diagonal entry of the stiffness [F/L].
            rtol: relative tolerance [1].

        Returns:
            What went wrong, or None; displacement increments [L]; their product with the stiffness of bodies and
            contacts [F]; number of changes of the active set that they contain.
        """
        with self._clock("contact"):
            transformation = self._transformation()
            springs = [s for s in (c.friction_springs() for c in self.multipliers) if s is not None]
        pinned = np.zeros(self.num_owned, dtype=bool)
        pinned[self.fixed] = True
        if transformation:
            pinned |= transformation.pinned
        for _, force in springs:
            residual = residual + force
        extra = [*penalties] + [matrix for matrix, _ in springs]
        if self.problem.exact_tangent:
            extra += geometric
        elif geometric:  # from the guess: small, but not symmetric
            residual = residual + self._product(geometric, guess)
        system: _cpp.solve.CondensedSystem | _cpp.solve.SaddlePointSystem
        if self.saddle:
            self._rows.assign([c.constraints() for c in self.multipliers], pinned, self._start, mean)
            for multiplier, nodes in zip(self.multipliers, self._rows.redundant):
                multiplier.set_redundant(nodes)
            system = _cpp.solve.SaddlePointSystem(K, extra, self._rows)
            start = self._rows.unknowns(guess, self._forces)
        else:
            system = _cpp.solve.CondensedSystem(K, extra, symmetric, transformation, pinned, mean)
            start = transformation.unknowns(guess) if transformation else guess
        x, b = system.create_vector(), system.create_vector()
        x.array[:] = start
        system.load(residual, x, b)
        with self._clock("linear"):
            fault = self.problem.linear_solver.solve(system, b, x, rtol)
        moved = system.displacements(x)
        if self.saddle:
            self._forces = self._rows.forces(x)
        matrices = [K, *penalties, *geometric]
        forces, changes = self._product(matrices, moved), 0
        factors = self.problem.linear_solver.factors(system)
        several = self.saddle or len(self.multipliers) != 1
        if not fault and factors is not None and not several and transformation is not None:
            found = LinearisedSystem(system, transformation, pinned)
            moved, forces, changes = self._update_by_responses(found, factors, residual, moved, forces, matrices)
        for thing in (x, b, *(matrix for matrix, _ in springs)):
            thing.destroy()
        return fault, moved, forces, changes

    def _update_by_responses(
        self,
        system: LinearisedSystem,
        factors: PETSc.Mat,
        residual: FloatArray,
        moved: FloatArray,
        forces: FloatArray,
        matrices: Sequence[PETSc.Mat],
    ) -> tuple[FloatArray, FloatArray, int]:
        """Update the active set of a contact without friction by LinearisedActiveSet. Collective.

        Args:
            system: linear system that was solved.
            factors: its factor matrix.
            residual: residual over owned degrees of freedom [F].
            moved: displacement increments of the solution [L].
            forces: their product with `matrices` [F].
            matrices: stiffness of bodies and contacts [F/L].

        Returns:
            Displacement increments [L], forces [F] and number of changes.
        """
        contact = cast("LagrangeContact", self.multipliers[0])  # the only one with a dual basis
        if contact.pair.friction > 0.0:
            return moved, forces, 0
        with self._clock("linear"):
            contact.update_linearised_gap(moved)
            contact.update_multipliers(residual + forces)
            found = LinearisedActiveSet(contact, system, factors, lambda v: self._product(matrices, v)).update()
        if found is None or found[1] == 0:
            return moved, forces, 0
        moved = moved + found[0]
        return moved, self._product(matrices, moved), found[1]

    def _product(self, matrices: Sequence[PETSc.Mat], values: FloatArray) -> FloatArray:
        """Sum of the products of matrices with values over owned dofs. Collective."""
        x, y = matrices[0].createVecRight(), matrices[0].createVecLeft()
        x.array[:] = values
        y.set(0.0)
        for matrix in matrices:
            matrix.multAdd(x, y, y)
        product = y.array.copy()
        x.destroy()
        y.destroy()
        return product

    def _set_multipliers(self, unit: float) -> None:
        """Set the multipliers of all contacts from the solution of the saddle point, whose unit of force is `unit`."""
        start = 0
        for contact in self.multipliers:
            end = start + contact.gdim * len(contact.nodes)
            contact.set_multipliers(unit * self._forces[start:end].reshape(-1, contact.gdim))
            start = end
