"""Composes material, loads, boundary values and contact into a static problem; seed (3.61)-(3.66), figure 3.5."""

import itertools

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from petsc4py import PETSc

from . import held, operators
from .contact.condense import Transformation
from .linear import LinearSolver
from .steps import Increment, Report, run_steps

__all__ = ["Report", "StaticProblem"]


class StaticProblem:
    """Equilibrium of bodies, in contact or not: internal virtual work and that of contact equal external virtual work.

    Args:
        u: displacement function; its value is the start and becomes the solution [L].
        material: material or MaterialMap; or give `residual`.
        residual: a UFL residual of your own in u (rank 1), instead of a material.
        bcs: list of DirichletBC. loads: list of loads (dolfinx_impact.Traction, ...).
        contact: list of contacts: dolfinx_impact.Lagrange(pair), dolfinx_impact.Penalty(pair).
        options: dict of PETSc options for the linear solver, without prefix; default: LU by MUMPS, for large problems
            conjugate gradients with algebraic multigrid.
        prefix: of PETSc options for this problem's linear solver.
        axisymmetric: of a residual of your own, for contact: x is the radius, integrals carry 2 pi r.

    Attributes:
        contact: the contacts with their results (points, gap, pressure, force, ...), in the order given.

    Raises:
        ValueError: neither or both of material and residual, loads or contacts that do not fit; on all ranks.
    """

    def __init__(
        self,
        u,
        material=None,
        residual=None,
        bcs=(),
        loads=(),
        contact=(),
        options=None,
        prefix="impact_static_",
        axisymmetric=False,
    ):
        if (material is None) == (residual is None):
            raise ValueError("give either a material or a residual of your own")
        if residual is not None and loads:
            raise ValueError("write the loads into your own residual: they need the hypothesis of a material")
        self.u, self.material, self.bcs, self.loads = u, material, list(bcs), list(loads)
        V = u.function_space
        self.space = V
        v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
        if residual is None:
            axisymmetric = material.hypothesis_on(V.mesh) == "axisymmetric"
            residual = operators.internal_force_form(u, v, material)
            tangent = operators.tangent_form(u, du, v, material)
            for load in loads:
                external = load.form(u, v, material)
                residual = residual - external
                if u in external.coefficients():
                    tangent = tangent - ufl.derivative(external, u, du)
        else:
            tangent = ufl.derivative(residual, u, du)
        for measure, data in next(iter(residual.subdomain_data().values())).items():
            if any(d is not data[0] for d in data):
                raise ValueError(
                    f"the {measure} integrals must share one subdomain_data: "
                    "put the tags of all loads into one MeshTags"
                )
        self.residual, self.axisymmetric = residual, axisymmetric
        self._residual = fem.form(residual)
        self._tangent = operators.Tangent(tangent)
        self._tangent.matrix.setOption(PETSc.Mat.Option.KEEP_NONZERO_PATTERN, True)
        self._b = petsc.create_vector(self._residual)
        self._x = self._b.duplicate()
        self._solver = LinearSolver(V, options, prefix)
        # Contact forces between deformable bodies have a tangent that is not symmetric. Newton's method converges
        # nearly as fast without it (by pressure over stiffness), conjugate gradients do not converge with it.
        self.exact_tangent = self._solver.direct
        self._num_owned = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        self._start = V.dofmap.index_map.local_range[0] * V.dofmap.index_map_bs
        dofs = [bc.dof_indices()[0] for bc in self.bcs]
        self._fixed = np.unique(np.concatenate(dofs)) if dofs else np.empty(0, dtype=np.int32)
        self.fixed = np.zeros(len(u.x.array), dtype=bool)  # prescribed degrees of freedom, owned and ghosts
        self.fixed[self._fixed] = True
        self._fixed = self._fixed[self._fixed < self._num_owned]
        self.contact = [c._bind(self) for c in contact]

    # --- residuals -------------------------------------------------------------------------------------------------

    def _assemble_residual(self):
        """Internal minus external forces, without contact: PETSc vector, owned entries complete."""
        self.u.x.scatter_forward()
        with self._b.localForm() as local:
            local.set(0.0)
        petsc.assemble_vector(self._b, self._residual)
        self._b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
        return self._b

    def reactions(self):
        """Residual with all entries: support forces at constrained degrees of freedom, round-off elsewhere [F].

        Returns:
            fem.Function on the displacement space.
        """
        forces = self._assemble_residual().array.copy()
        for contact in self.contact:
            forces -= contact.forces()
        r = fem.Function(self.space, name="reaction")
        r.x.array[: self._num_owned] = forces
        r.x.scatter_forward()
        return r

    def _norm(self, values):
        return float(np.sqrt(self.space.mesh.comm.allreduce(float(values @ values))))

    # --- one increment ---------------------------------------------------------------------------------------------

    def _newton(self, target, rtol, atol, max_iterations, log):
        """Newton's method and the active set together, from the present u to prescribed values `target`.

        Returns:
            Increment; its `fault` says why it did not converge.
        """
        result, comm, fixed = Increment(), self.space.mesh.comm, self._fixed
        scale, inner, noise, round_start = 0.0, 0.0, 0.0, 0
        for iteration in itertools.count():
            b = self._assemble_residual()
            residual = b.array.copy()
            if not np.isfinite(self._norm(residual)):
                result.residual_norms.append(float("nan"))
                return result.failed(f"the residual is nan in Newton iteration {iteration}: the state cannot be "
                                     "evaluated (inverted cells?)")  # fmt: skip
            for contact in self.contact:
                contact.update(self.u.x.array)
                if not contact.constraints:
                    residual -= contact.forces()
            changes, pending = 0, 0
            for contact in self.contact:
                if iteration > 0:
                    contact.measure(residual)
                changed = contact.switch(iteration == 0)
                changes += changed
                # A penalty's residual is that of the new state already; at |t| = friction p round-off decides on it.
                pending += changed if contact.constraints else 0
            sizes = sum(c.num_active for c in self.contact)
            transformation = self._transformation()
            scale = max(scale, self._norm(residual))
            free = transformation.residual(residual) if transformation else residual.copy()
            free[fixed] = 0.0
            norm = self._norm(free)
            jump = target[fixed] - self.u.x.array[fixed]
            moved = comm.allreduce(int(np.any(jump))) == 0
            violation = max((c.violation() for c in self.contact), default=0.0)
            result.add(norm, sizes, changes)
            log.iteration(iteration, norm, max(scale, inner), sizes, changes)
            settled = iteration > 0 or not self.contact
            small = norm <= max(atol, noise, rtol * max(scale, inner))
            if moved and settled and pending == 0 and violation < 1e-11 and small:
                if not any([c.refine() for c in self.contact]):
                    return result.converged()
                round_start = iteration
                continue
            if iteration - round_start == max_iterations:
                break
            if iteration == 0 and self.contact:
                loose = self._loose()
                if loose:
                    return result.failed(loose, hopeless=True)
            K = self._tangent.assemble()
            inner = max(inner, self._tangent_force(K))
            noise = self._round_off(K)
            # While the active set moves, three digits are enough; afterwards, what is still asked for.
            enough = 0.3 * max(atol, rtol * max(scale, inner)) / norm if norm > 0 else 1e-10
            fault = self._solve(K, residual, jump, transformation, 1e-3 if changes else enough if moved else 1e-10)
            self.u.x.array[self.fixed] = target[self.fixed]  # to the last digit
            if fault:
                return result.failed(f"the linear solver failed ({fault}): is the body held against rigid motion?")
        return result.failed(
            f"Newton's method did not converge in {max_iterations} iterations; residual norms: "
            f"{', '.join(f'{n:.3e}' for n in result.residual_norms)}"
        )

    def _loose(self):
        """What is wrong with the supports, or an empty string: bodies that supports and contact leave free.
        Collective."""
        loose = held.free_motions(self.space, self.fixed, self.contact, self.axisymmetric)
        if not loose:
            return ""
        comm = self.space.mesh.comm
        gaps = [(c.pair.name, comm.allreduce(float(np.min(c.gap, initial=np.inf)), MPI.MIN)) for c in self.contact]
        apart = [f"{name}: smallest gap {gap:.3e}" for name, gap in gaps if gap > 0]
        hint = f" ({'; '.join(apart)}: let them touch first, or hold or move the body)" if apart else ""
        return f"not held against rigid motion: {'; '.join(loose)}{hint}"

    def _transformation(self):
        parts = [c.constraints() for c in self.contact if c.constraints]
        if not parts:
            return None
        gdim = self.space.mesh.geometry.dim
        return Transformation(self.space.mesh.comm, self._num_owned, self._start, gdim, parts)

    def _solve(self, K, residual, jump, transformation, rtol):
        """One linear solution and the update of u; returns what went wrong, or None."""
        b, x = self._b, self._x
        b.array[:] = -residual
        for contact in self.contact:
            K, force = contact.add_stiffness(K)
            if force is not None:
                b.array[:] -= force
        pinned = self._fixed
        x.set(0.0)
        x.array[self._fixed] = jump
        A, symmetric = K, all([c.symmetric for c in self.contact])
        if transformation:
            transformation.load(K, b)
            A, symmetric = transformation.condense(K), symmetric and transformation.symmetric
            pinned = np.union1d(pinned, np.flatnonzero(transformation.dummies))
        diagonal = K.getDiagonal()
        mean = np.abs(diagonal.array)
        mean = self.space.mesh.comm.allreduce(mean.sum()) / self.space.dofmap.index_map.size_global
        A.zeroRowsColumns(self._start + pinned.astype(np.int32), mean or 1.0, x, b)
        fault = self._solver.solve(A, b, x, symmetric, rtol)
        if fault:
            return fault
        self.u.x.array[: self._num_owned] += transformation.increment(x) if transformation else x.array
        self.u.x.scatter_forward()
        return None

    def _tangent_force(self, K):
        """Norm of tangent times u, free entries [F]: how large the forces are that cancel where loads balance each
        other."""
        product = K.createVecLeft()
        K.mult(self.u.x.petsc_vec, product)
        forces = product.array.copy()
        product.destroy()
        forces[self._fixed] = 0.0
        return self._norm(forces)

    def _round_off(self, K):
        """Norm of the round-off in the residual [F]: forces of a stiff body that moves as a whole cancel to that."""
        diagonal = K.getDiagonal()
        forces = diagonal.array * self.u.x.array[: self._num_owned]
        diagonal.destroy()
        return 4 * np.finfo(float).eps * self._norm(forces)

    # --- load steps ------------------------------------------------------------------------------------------------

    def solve(self, steps=1, rtol=1e-10, atol=0.0, max_iterations=25, cut_backs=None, verbose=False):
        """Bring loads, boundary values and rigid obstacles from where they were to their present values.

        Args:
            steps: equal parts. rtol: of the free residual against the largest force seen, at the supports and from the
                tangent times u [1]. atol: of the free residual [F]. max_iterations: per step.
            cut_backs: how often the increment may be halved where it does not converge; None: 8 with contact or several
                steps, else 0.
            verbose: print every iteration on rank 0; always written to the log "dolfinx_impact" at level INFO.

        Returns:
            Report.

        Raises:
            RuntimeError: no convergence, a residual that is not a number, or a singular matrix; u keeps the last
            converged state.
        """
        if isinstance(steps, bool) or int(steps) != steps or steps < 1:
            raise ValueError(f"steps is {steps!r}: give a positive integer")
        if cut_backs is None:
            cut_backs = 8 if self.contact or steps > 1 else 0
        return run_steps(self, int(steps), rtol, atol, max_iterations, cut_backs, verbose)
