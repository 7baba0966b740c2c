# SPDX-License-Identifier: MIT
"""Composes material, loads, boundary values and contact into a static problem; seed (3.61)-(3.66), figure 3.5."""

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from ..common import arguments
from ..assembly import operators, problem_arguments
from ..common.collective import comm_of, guard
from ..common.interrupts import Interrupts
from .linear_solver import LinearSolver
from ..io.mesh_check import check_cells
from .snes import Solver
from .load_steps import Report, run_steps
from ..common.unique import Unique, claim

__all__ = ["Report", "StaticProblem"]


class StaticProblem(Unique):
    """Equilibrium of bodies, in contact or not: internal virtual work and that of contact equal external virtual work.

    Args:
        u: displacement function; its value is the start and becomes the solution [L].
        material: material or MaterialMap; or give `residual`.
        residual: a UFL residual of your own in u (rank 1), instead of a material.
        bcs: list of DirichletBC. loads: list of loads (dolfinx_impact.Traction, ...).
        contact: list of contacts: dolfinx_impact.Lagrange(pair), dolfinx_impact.Penalty(pair).
        options: dict of PETSc options for KSP and SNES, without prefix; default: LU by MUMPS, for large problems
            conjugate gradients with algebraic multigrid, and the package's own Newton's method. Another snes_type
            (newtonls, newtontr, ...) works without contact and with Penalty; snes_rtol and snes_atol are those of
            `solve`.
        prefix: of PETSc options on the command line; they go before those given here.
        axisymmetric: of a residual of your own, for contact: x is the radius, integrals carry 2 pi r.

    Attributes:
        contact: the contacts with their results (points, gap, pressure, force, ...), in the order given.

    Raises:
        TypeError: arguments of another kind. ValueError: neither or both of material and residual; mesh, space, loads,
        supports or contacts that do not fit; arguments that differ between ranks. On all ranks.

    Warns:
        UserWarning: an ExplicitProblem that is alive has the same u. After the first solve: options that nobody read.
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
        with guard(comm_of(u, residual, bcs, material, loads, contact), "StaticProblem") as ranks:
            if residual is not None and loads:
                raise ValueError("write the loads into your own residual: they need the hypothesis of a material")
            given = problem_arguments.problem(u, material, residual, bcs, loads, contact, axisymmetric)
            arguments.options(options)
            ranks.same(**given, options=options, prefix=prefix)
        self.u, self.material, self.bcs, self.loads = u, material, list(bcs), list(loads)
        V = u.function_space
        self.space = V
        check_cells(V.mesh)
        claim(u, self)
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
        # Multipliers with other bases than the dual one cannot be condensed: then all stay in the system.
        self._saddle = any(getattr(c, "basis", "dual") != "dual" for c in contact)
        self._solver = LinearSolver(V, options, prefix, indefinite=self._saddle)
        # Forces of multipliers between deformable bodies have a tangent that is not symmetric: conjugate gradients do
        # not converge with it. They get it on the right-hand side, from the last guess: it is small, pressure over
        # stiffness.
        self.exact_tangent = self._solver.direct
        self._num_owned = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        dofs = [bc.dof_indices()[0] for bc in self.bcs]
        self.fixed = np.zeros(len(u.x.array), dtype=bool)  # prescribed degrees of freedom, owned and ghosts
        for d in dofs:
            self.fixed[d] = True
        self.contact = [c._bind(self) for c in contact]
        # A tangent without u is that of a linear law: the same in all iterations of an increment.
        self._linear = not any(c is u for c in tangent.coefficients())

    def __repr__(self):
        size = self.space.dofmap.index_map.size_global * self.space.dofmap.index_map_bs
        what = "residual of its own" if self.material is None else repr(self.material)
        parts = f"{len(self.bcs)} boundary conditions, {len(self.loads)} loads, {len(self.contact)} contacts"
        return f"StaticProblem({size} unknowns, {what}, {parts})"

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
        b = self._assemble_residual()
        for contact in self.contact:
            contact.add_residual(b)
        r = fem.Function(self.space, name="reaction")
        r.x.array[: self._num_owned] = b.array_r
        r.x.scatter_forward()
        return r

    def _norm(self, values):
        return float(np.sqrt(self.space.mesh.comm.allreduce(float(values @ values))))

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
            TypeError, ValueError: steps or max_iterations is not a positive integer, cut_backs not one from zero, a
            tolerance is not a number from 0 to 1; arguments, loads or supports that differ between ranks; multipliers
            with another SNES than the package's own.
            RuntimeError: no convergence, a residual that is not a number, or a singular matrix.
            KeyboardInterrupt: Ctrl-C, on all ranks between two iterations.

        After an exception u, contacts, loads and obstacles are those of the last converged increment, from which the
        next solve goes on.
        """
        with guard(self.space.mesh.comm, "StaticProblem.solve", cut_backs=cut_backs) as ranks:
            steps = arguments.integer("steps", steps, 1)
            max_iterations = arguments.integer("max_iterations", max_iterations, 1)
            if cut_backs is None:
                cut_backs = 8 if self.contact or steps > 1 else 0
            cut_backs = arguments.integer("cut_backs", cut_backs, 0)
            rtol, atol = (arguments.tolerance(name, value) for name, value in (("rtol", rtol), ("atol", atol)))
            if not np.all(np.isfinite(self.u.x.array)):
                raise ValueError("u has values that are not finite numbers: give it a start, u.x.array[:] = 0")
            ranks.same(steps=steps, rtol=rtol, atol=atol, max_iterations=max_iterations, **self._targets())
        for contact in self.contact:
            contact.check_parameters()
        with Interrupts(self.space.mesh.comm) as interrupts:
            solver = Solver(self, rtol, atol, max_iterations, interrupts)
            try:
                report = run_steps(self, solver, steps, cut_backs, verbose)
            finally:
                solver.free()
            interrupts.check()
        self._solver.warn_of_unused()
        return report

    def _targets(self):
        """What a solve goes to, as far as it is numbers: to be the same on all ranks."""
        return {
            "loads": [load.constant.value for load in self.loads if hasattr(load, "constant")],
            "bcs": [arguments.value_of(bc) for bc in self.bcs],
            "displacement of the masters": [c.pair.rigid_master.displacement for c in self.contact if c.pair.rigid],
        }
