"""Composes material, loads and boundary values into a static problem solved by Newton's method; seed (3.61)-(3.66)."""

import itertools
import weakref
from dataclasses import dataclass, field

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from . import operators

# LU by MUMPS, which counts pivots that are round-off of the largest entries: a body that is free to move has such
# pivots.
DIRECT = {
    "ksp_type": "preonly",
    "pc_type": "lu",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_24": 1,
    "mat_mumps_cntl_3": 1e-14,
}
_PROBLEMS = itertools.count()


def _forget(keys):
    """Take the options of a problem out of PETSc's database; else PETSc reports those never read when it ends."""
    database = PETSc.Options()
    for key in keys:
        if database.hasName(key):
            database.delValue(key)


@dataclass
class Report:
    """What a solve did.

    Attributes:
        converged: of all steps. iterations: Newton iterations per step.
        residual_norms: per step, the norms of the free residual by iteration [F].
    """

    converged: bool = True
    iterations: list = field(default_factory=list)
    residual_norms: list = field(default_factory=list)


class StaticProblem:
    """Equilibrium of a body: internal virtual work equals external virtual work.

    Args:
        u: displacement function; its value is the start and becomes the solution [L].
        material: material or MaterialMap; or give `residual`.
        residual: a UFL residual of your own in u (rank 1), instead of a material.
        bcs: list of DirichletBC. loads: list of loads (dolfinx_impact.Traction, ...).
        options: dict of PETSc options for the linear solver, without prefix; default: LU by MUMPS.
        prefix: of PETSc options for this problem's linear solver.

    Raises:
        ValueError: neither or both of material and residual, or loads that do not fit.
    """

    def __init__(self, u, material=None, residual=None, bcs=(), loads=(), options=None, prefix="impact_static_"):
        if (material is None) == (residual is None):
            raise ValueError("give either a material or a residual of your own")
        if residual is not None and loads:
            raise ValueError("write the loads into your own residual: they need the hypothesis of a material")
        self.u, self.material, self.bcs = u, material, list(bcs)
        V = u.function_space
        self.space = V
        v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
        if residual is None:
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
        self.residual = residual
        self._residual = fem.form(residual)
        self._tangent = operators.Tangent(tangent, self.bcs)
        self._b = petsc.create_vector(self._residual)
        self._du = fem.Function(V)
        self._solver = PETSc.KSP().create(V.mesh.comm)
        self._solver.setOperators(self._tangent.matrix)
        # A prefix of its own keeps the options of one problem from the next; what the command line says of `prefix`
        # goes first.
        database, own = PETSc.Options(), f"{prefix}{next(_PROBLEMS)}_"
        given = {k: v for k, v in PETSc.Options(prefix).getAll().items() if not k[0].isdigit()}
        chosen = {**DIRECT, **(options or {}), **given}
        if chosen["pc_type"] not in ("lu", "cholesky"):
            chosen = {k: v for k, v in chosen.items() if k not in DIRECT or k in ("ksp_type", "pc_type")}
        for key, value in chosen.items():
            database[own + key] = value
        weakref.finalize(self, _forget, [own + key for key in chosen])
        self._solver.setOptionsPrefix(own)
        self._solver.setFromOptions()

    def _assemble_residual(self):
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
        b = self._assemble_residual()
        r = fem.Function(self.space, name="reaction")
        r.x.array[: b.getLocalSize()] = b.array
        r.x.scatter_forward()
        return r

    def _fault(self, A, b, x):
        """What is wrong with the solution x of A x = b, or None. Collective."""
        reason, pc = self._solver.getConvergedReason(), self._solver.getPC()
        if reason < 0:
            return f"PETSc reason {reason}"
        if pc.getType() in ("lu", "cholesky") and pc.getFactorSolverType() == "mumps":
            null_pivots = pc.getFactorMatrix().getMumpsInfog(28)
            if null_pivots > 0:
                return f"{null_pivots} pivots vanish"
        residual = b.duplicate()
        A.mult(x, residual)
        residual.axpy(-1.0, b)
        error = residual.norm()
        residual.destroy()
        # Far from any solver's tolerance: a nearly singular matrix, whose solution is round-off.
        return (
            None
            if error <= 1e-2 * b.norm()
            else f"the residual of the linear system is {error:.1e}, its right side {b.norm():.1e}"
        )

    def _constrained(self):
        owned = self.space.dofmap.index_map.size_local * self.space.dofmap.index_map_bs
        dofs = [bc.dof_indices()[0] for bc in self.bcs]
        dofs = np.unique(np.concatenate(dofs)) if dofs else np.empty(0, dtype=np.int32)
        return dofs[dofs < owned]

    def _tangent_force(self, A, fixed):
        """Norm of tangent times u, free entries [F]: how large the forces are that cancel where loads balance each
        other."""
        product = A.createVecLeft()
        A.mult(self.u.x.petsc_vec, product)
        forces = product.array.copy()
        forces[fixed] = 0.0
        return np.sqrt(self.space.mesh.comm.allreduce(float(forces @ forces)))

    def solve(self, rtol=1e-10, atol=0.0, max_iterations=25):
        """Newton's method from the present u.

        Args:
            rtol: of the free residual against the largest force seen, at the supports and from the tangent times u [1].
            atol: of the free residual [F]. max_iterations: per solve.

        Returns:
            Report.

        Raises:
            RuntimeError: no convergence, a residual that is not a number, or a singular matrix; u keeps its start.
        """
        report = Report()
        start = self.u.x.array.copy()
        fixed = self._constrained()
        target = self.u.copy()
        for bc in self.bcs:
            bc.set(target.x.array)
        target.x.scatter_forward()
        scale, inner, norms = 0.0, 0.0, []
        comm = self.space.mesh.comm
        for iteration in range(max_iterations + 1):
            b = self._assemble_residual()
            # The first correction brings the boundary values in; from then on their rows carry the reactions.
            scale = max(scale, b.norm(PETSc.NormType.NORM_2))
            free = b.array.copy()
            free[fixed] = 0.0
            norm = np.sqrt(comm.allreduce(float(free @ free)))
            norms.append(norm)
            if not np.isfinite(norm):
                self.u.x.array[:] = start
                raise RuntimeError(
                    f"the residual is {norm} in Newton iteration {iteration}: the state cannot be evaluated (inverted "
                    "cells?); apply the load in smaller parts"
                )
            moved = iteration > 0 or not np.any(target.x.array != self.u.x.array)
            moved = comm.allreduce(int(moved)) == comm.size
            if moved and norm <= max(atol, rtol * max(scale, inner)):
                report.iterations.append(iteration)
                report.residual_norms.append(norms)
                return report
            if iteration == max_iterations:
                break
            A = self._tangent.assemble()
            inner = self._tangent_force(A, fixed)
            jump = fem.Function(self.space)
            jump.x.array[:] = target.x.array - self.u.x.array
            with b.localForm() as local:  # ghosts were sent to their owners already: they must not be sent twice
                local.array_w[b.getLocalSize() :] = 0.0
            petsc.apply_lifting(b, [self._tangent.form], [self.bcs], x0=[self.u.x.petsc_vec], alpha=-1.0)
            b.ghostUpdate(PETSc.InsertMode.ADD, PETSc.ScatterMode.REVERSE)
            b.scale(-1.0)
            owned = b.array
            owned[fixed] = jump.x.array[fixed]
            b.array = owned
            self._solver.setOperators(A)
            x = self._du.x.petsc_vec
            self._solver.solve(b, x)
            fault = self._fault(A, b, x)
            if fault:
                self.u.x.array[:] = start
                raise RuntimeError(f"the linear solver failed ({fault}): is the body held against rigid motion?")
            self._du.x.scatter_forward()
            self.u.x.array[:] += self._du.x.array
        self.u.x.array[:] = start
        raise RuntimeError(
            f"Newton's method did not converge in {max_iterations} iterations; residual norms: "
            f"{', '.join(f'{n:.3e}' for n in norms)}. Apply the load in smaller parts, or pass more iterations"
        )
