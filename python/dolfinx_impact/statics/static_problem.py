# SPDX-License-Identifier: MIT
"""Composes material, loads, boundary values and contact into a static problem; seed (3.61)-(3.66), figure 3.5."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import fem
from petsc4py import PETSc

from .. import _cpp
from ..common import arguments
from ..assembly import problem_arguments
from ..assembly.curvature import check_curvature, is_displacement
from ..assembly.residual import check_hypothesis
from ..assembly.residual_bodies import ResidualBodies
from ..assembly.body_results import BodyResults
from ..assembly.body_stress import BodyStress
from ..assembly.large_rotation import RotationWarning
from ..assembly.locking import warn_of_locking
from ..assembly.quadrature_degree import warn_of_degree
from ..assembly.softening import warn_of_softening
from ..common.collective import comm_of, guard
from ..common.interrupts import Interrupts
from .make_body import make_body
from .body import Body
from .material_body import history_of
from .linear_solver import LIMITS, LinearSolver, make_room, petsc_options, warnings_on
from ..io.mesh_check import check_cells
from .load_steps import Limits, Report, SolveInCpp, run_steps
from ..common.types import BoolArray, FilePath
from ..common.units import Units
from ..common.unique import claim
from ..contact import in_cpp
from ..contact.general import named_pairs
from ..contact.names import named_apart
from ..contact.protocol import BodyTangent
from ..loads import Load
from ..materials import MaterialMap, _Material
from ..recording.field_arguments import check_fields
from ..recording.output_options import output_options
from .load_step_recorder import LoadStepRecorder
from .restart import Solves, StaticRestart

if TYPE_CHECKING:
    from ..contact.general import GeneralContact
    from ..contact.mortar.lagrange import Lagrange, LagrangeContact
    from ..contact.mortar.tie import Tie, TieContact
    from ..contact.penalty.penalty import Penalty
    from ..contact.penalty.quadrature_penalty import QuadraturePenalty

__all__ = ["Report", "StaticProblem"]


class StaticProblem(BodyResults):
    """Equilibrium of bodies, in contact or not: internal virtual work and that of contact equal external virtual work.

    Args:
        u: displacement function. Its value is the initial guess, and becomes the solution [L].
        material: material or MaterialMap; or give `residual`.
        residual: UFL residual of your own in u (rank 1): internal minus external forces.
        bcs: boundary condition, or a list of them.
        loads: load (dolfinx_impact.Traction, ...), or a list of them.
        contact: contact, or a list of them: dolfinx_impact.Lagrange(pair), dolfinx_impact.Penalty(pair),
            dolfinx_impact.Tie(pair), dolfinx_impact.GeneralContact(facet_tags).
        options: PETSc options for KSP and SNES by name, without prefix. Default: LU by MUMPS, for large problems
            conjugate gradients with algebraic multigrid, and the package's own Newton's method. Another snes_type
            (newtonls, newtontr, ...) works without contact and with Penalty; snes_rtol and snes_atol are those of
            `solve`. Of contact: contact_tolerance, largest violation of its conditions in a converged state in sizes
            of the bodies (1e-11), contact_max_updates of the active set in one linearised problem (60), and
            contact_condense: multipliers are condensed where they can be (true).
        prefix: prefix of PETSc options on the command line, which take precedence over `options`.
        hypothesis: for a residual of your own: "axisymmetric" if x is the radius and its integrals contain 2 pi r,
            otherwise None or another hypothesis.
        tangent: for a residual of your own: its derivative, a UFL form of rank 2; None: UFL finds it. Needed where the
            residual reads a stress that is computed elsewhere, as a function at quadrature points.
        evaluate: with `tangent`: function that is called as evaluate(u) before residual or tangent are assembled at a
            u, in every iteration. It sets the functions that they read, and not u; docs/howto/own_form.md.
        accept: with `evaluate`: function that is called as accept(u) when a step has converged, for example to make
            internal variables those that the next step begins from.

    Attributes:
        u: displacement [L].
        contact: contacts with their results (points, gap, pressure, force, ...), in the order given.
        fixed: mask of prescribed degrees of freedom, owned and ghosts.
        body: residual of the bodies and its tangent.
        recorders: recorders that write during a solve.
        num_owned: number of degrees of freedom that this rank owns [1].
        residual_form: as `residual`.
        solves: how far the problem has come.

    Raises:
        TypeError: an argument is of the wrong type; on all ranks.
        ValueError: neither or both of material and residual are given; a residual on a plane mesh does not belong to
            its hypothesis; mesh, space, loads, supports or contacts do not
            fit; an argument differs between ranks. On all ranks.

    Warns:
        UserWarning: an ExplicitProblem with the same u exists; materials with internal variables are on cells
            that lock; or, after the first solve, options were not used.
    """

    moves_rigid_bodies = True  # what RigidBody asks

    def __init__(
        self,
        u: fem.Function,
        material: _Material | MaterialMap | None = None,
        residual: ufl.Form | None = None,
        bcs: fem.DirichletBC | Sequence[fem.DirichletBC] = (),
        loads: Load | Sequence[Load] = (),
        contact: Lagrange | Penalty | Tie | GeneralContact | Sequence[Lagrange | Penalty | Tie | GeneralContact] = (),
        options: dict[str, Any] | None = None,
        prefix: str = "impact_static_",
        hypothesis: str | None = None,
        tangent: ufl.Form | None = None,
        evaluate: Callable[[fem.Function], object] | None = None,
        accept: Callable[[fem.Function], object] | None = None,
    ) -> None:
        with guard(comm_of(u, residual, bcs, material, loads, contact), "StaticProblem") as ranks:
            if material is not None and hypothesis is not None:
                raise ValueError("the hypothesis is that of the material: give it there")
            axisymmetric = hypothesis == "axisymmetric"
            bcs, loads, contact = problem_arguments.lists(bcs, loads, contact)
            given = problem_arguments.problem(
                u, material, residual, bcs, loads, contact, axisymmetric, tangent=tangent, evaluate=evaluate,
                accept=accept,
            )  # fmt: skip
            problem_arguments.computes(u, residual, evaluate)
            bodies = None if residual is None else ResidualBodies(u.function_space.mesh, hypothesis)
            pairs = named_pairs(contact)
            arguments.options(options)
            ranks.same(**given, options=options, prefix=prefix, hypothesis=hypothesis)
        self.u, self.material, self.bcs, self.loads = u, material, tuple(bcs), tuple(loads)
        self._stress = BodyStress(u, material)
        V = u.function_space
        self.space = V
        check_cells(V.mesh)
        claim(u, self)
        if material is not None:
            warn_of_locking(u, material)
            warn_of_softening(u, material)
        self._rotation_warning = RotationWarning(material)
        if residual is not None:
            check_hypothesis(residual, u, hypothesis, tangent)
            warn_of_degree(residual, u, hypothesis)
        self.axisymmetric = axisymmetric if material is None else material.hypothesis_on(V.mesh) == "axisymmetric"
        self.body: Body = make_body(u, material, residual, loads, bodies, tangent, evaluate, accept)
        self._material_history = history_of(self.body)
        self.residual_form = residual
        self.solves = Solves(signs_are_checked=residual is None or not is_displacement(V))
        self.num_owned: int = V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        self.fixed: BoolArray = np.zeros(len(u.x.array), dtype=bool)
        for bc in self.bcs:
            self.fixed[bc.dof_indices()[0]] = True
        self.recorders: list[LoadStepRecorder] = []
        self.named_pairs = pairs
        self.contact: tuple[LagrangeContact | QuadraturePenalty | TieContact, ...] = tuple(
            [c._bind(self) for c in named_apart(contact)]
        )
        make_room(V)
        self._cpp_object = _cpp.problems.StaticProblem(
            u._cpp_object, self.body.in_cpp(), [bc._cpp_object for bc in self.bcs],
            [in_cpp.contact_in_cpp(c) for c in self.contact], petsc_options(options), prefix, self.axisymmetric,
            LIMITS, warnings_on(V.mesh.comm),
        )  # fmt: skip
        # A load of a user's own class without `ramps` acts in full from the first increment.
        for load in self.loads:
            for constant, reached in load.ramps() if hasattr(load, "ramps") else ():
                self._cpp_object.add_load(constant.value, reached)
        #: rotation vectors of rigid masters that turn as prescribed, by number of the contact: at the present part of a
        #: load step, and of the last solve
        self.angles: dict[int, tuple[Any, Any]] = {}
        for k, c in enumerate(self.contact):
            if c.pair.rigid and c.pair.rigid_body is None and c.pair.rigid_master.angle is not None:
                self.angles[k] = np.zeros(3), np.zeros(3)
                self._cpp_object.turn_obstacle(k, *self.angles[k])
        for body in dict.fromkeys(c.pair.rigid_body for c in self.contact):
            if body is not None:
                bound = body.bind_static(self)
                self._cpp_object.add_load(bound.force, bound.reached)
                if not all(bound.fixed[3:]):
                    self._cpp_object.add_load(bound.torque, bound.reached_torque)
                self._cpp_object.add_rigid_body(bound.contacts, bound.fixed, bound.force, bound.torque)
        self._restart = StaticRestart(self)

    @property
    def linear_solver(self) -> LinearSolver:
        """Solver of the linear systems."""
        return LinearSolver.of(self.equilibrium.linear_solver)

    @property
    def tangent(self) -> BodyTangent:
        """Derivative of the bodies' residual, assembled at the present u [F/L]."""
        return self.body.tangent

    def __repr__(self) -> str:
        size = self.space.dofmap.index_map.size_global * self.space.dofmap.index_map_bs
        what = "residual of its own" if self.material is None else repr(self.material)
        parts = f"{len(self.bcs)} boundary conditions, {len(self.loads)} loads, {len(self.contact)} contacts"
        return f"StaticProblem({size} unknowns, {what}, {parts})"

    # --- files -----------------------------------------------------------------------------------------------------

    def record(
        self,
        path: FilePath | None = None,
        fields: Sequence[str] = ("displacement",),
        every: int = 1,
        expressions: Mapping[str, ufl.core.expr.Expr] | None = None,
        ending: str = ".bp",
        units: Units | None = None,
    ) -> LoadStepRecorder:
        """Write fields and contact forces into a folder after converged increments; see LoadStepRecorder. Collective.

        Args:
            path: folder; None as for RunFolder.
            fields: displacement; of bodies stress, von_mises and the names of internal variables; of contacts pressure,
                gap, traction, shear_traction, slip, status.
            every: increments between frames; the end of a solve is always written [1].
            expressions: further fields by name, UFL expressions of functions on the mesh, which are recorded as well:
                numbers, vectors or tensors, averaged at the vertices. With a residual of your own "stress", the Cauchy
                stress, a 3 x 3 tensor, gives von_mises.
            ending: ".bp" for ADIOS2's format, ".xdmf" for XDMF with HDF5.
            units: units that the names of fields end with, as "von_mises [Pa]" with dolfinx_impact.SI; None: names
                alone.

        Returns:
            Recorder; call its `close()` at the end.

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: a field is unknown, or `every` is no positive integer; on all ranks.
            RuntimeError: the folder cannot be written; on all ranks.
        """
        with guard(self.space.mesh.comm, "StaticProblem.record", path=path, fields=fields, every=every) as ranks:
            if path is not None:
                arguments.path("path", path)
            options = output_options(expressions, ending, units)
            names = check_fields(self, fields, ["displacement"], options)
            every = arguments.integer("every", every, 1, unit=" of increments")
            ranks.same(output=options)
        return LoadStepRecorder(self, path, names, every, options)

    def save(self, path: FilePath) -> None:
        """Write a checkpoint in HDF5 with everything that the next solve starts from. Collective.

        The file is written as PATH.part and then renamed. If writing fails, an earlier file at `path` is not changed.

        Args:
            path: file to write.

        Raises:
            TypeError: `path` is no name of a file; on all ranks.
            RuntimeError: the folder cannot be written, or no space is left; on all ranks.
            ValueError: a solve is under way, or u is on a mixed space with other values than those at nodes; on all
                ranks.
        """
        self._restart.save(path)

    def restore(self, path: FilePath) -> None:
        """Continue from a checkpoint of the same problem, written on any number of ranks. Collective.

        Mesh, materials, contacts and options of contacts must be the same, loads and obstacles of the same kinds in the
        same order, and the same degrees of freedom prescribed. Values of loads, boundary conditions and obstacles are
        what the next solve leads to, from those that were reached: set them before or after. What a residual of your
        own reads, and what `evaluate` and `accept` keep, is not in the file.

        The next solve goes on bit for bit on the rank count that wrote the file, if DOLFINx numbers the mesh in the
        same way and the linear solver adds up in the same order, as on one rank; else to the solver's tolerance.

        Args:
            path: file that `save` has written.

        Raises:
            TypeError: `path` is no name of a file; on all ranks.
            RuntimeError: the file cannot be read, or is damaged; on all ranks.
            ValueError: the file belongs to another mesh, material, ..., or a solve is under way; on all ranks. The
                problem is then unchanged.
        """
        self._restart.restore(path)

    # --- residuals -------------------------------------------------------------------------------------------------

    def assemble_residual(self) -> PETSc.Vec:
        """Assemble internal minus external forces, without contact; owned entries are complete [F]. Collective."""
        return self.body.in_cpp().residual()

    @property
    def equilibrium(self) -> _cpp.solve.EquilibriumProblem:
        """Bodies and contacts as Newton's method in C++ sees them."""
        return self._cpp_object.equilibrium

    def reactions(self) -> fem.Function:
        """Residual of equilibrium: support forces at prescribed degrees of freedom, round-off elsewhere. Collective.

        Returns:
            Function on the displacement space [F].
        """
        r = fem.Function(self.space, name="reaction")
        r.x.array[: self.num_owned] = self._cpp_object.reactions()
        r.x.scatter_forward()
        return r

    def share_linear_solver(self, other: StaticProblem) -> None:
        """Solve with the linear solver of another problem in the place of one's own: with its options, and with its
        factors or multigrid hierarchy as long as they need few iterations. For states of the same bodies one after the
        other: loaded, with other supports, lifted off. Collective.

        Both problems can solve afterwards, one at a time. `linear_solver.reset()` gives the memory of the factors back.

        Args:
            other: problem with a displacement on the same space.

        Raises:
            TypeError: `other` is no StaticProblem; on all ranks.
            ValueError: the spaces are not the same, or multipliers stay in the linear systems of one of them (another
                basis than "dual", ties beside contact at one node); on all ranks.
        """
        with guard(self.space.mesh.comm, "StaticProblem.share_linear_solver"):
            if not isinstance(other, StaticProblem):
                raise TypeError(f"other is {other!r:.80}: give a StaticProblem")
            self._cpp_object.share_linear_solver(other._cpp_object)

    # --- load steps ------------------------------------------------------------------------------------------------

    def solve(
        self,
        steps: int = 1,
        rtol: float = 1e-10,
        atol: float = 0.0,
        max_iterations: int = 25,
        cut_backs: int | None = None,
        verbose: bool = False,
        progress: bool = True,
    ) -> Report:
        """Solve for the present values of loads, boundary conditions and rigid obstacles, in steps from the values of
        the last solve. Collective.

        Bodies that are apart and that contact alone can hold are brought together where the loads leave one way only,
        see `Report.brought_together`; otherwise the error says why not.

        After an exception u, contacts, loads and obstacles are those of the last converged increment, from which the
        next solve continues.

        Args:
            steps: number of equal steps [1].
            rtol: tolerance of the free residual, relative to the largest force: that at the supports, or that of the
                tangent times u, in the present state or at the start of the increment [1].
            atol: tolerance of the free residual [F].
            max_iterations: largest number of iterations per step [1].
            cut_backs: largest number of times that the increment is halved if it does not converge; None: 8 with
                contact or several steps, otherwise 0 [1].
            verbose: print every iteration on rank 0. It is always written to the log "dolfinx_impact" at level INFO.
            progress: a solve that takes longer than five seconds says on rank 0 (error output) from time to time how
                far it is.

        Returns:
            Report.

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: steps or max_iterations is not a positive integer, cut_backs is negative, or a tolerance is not
                a number from 0 to 1; arguments, loads or supports differ between ranks; multipliers with another SNES
                than the package's own; a residual of your own with a tangent that is strongly negative. On all ranks.
            RuntimeError: no convergence, a residual that is not finite, or a singular matrix; on all ranks.
            KeyboardInterrupt: Ctrl-C, on all ranks between two iterations.
        """
        with guard(self.space.mesh.comm, "StaticProblem.solve", cut_backs=cut_backs) as ranks:
            steps = arguments.integer("steps", steps, 1)
            max_iterations = arguments.integer("max_iterations", max_iterations, 1)
            if cut_backs is None:
                cut_backs = 8 if self.contact or steps > 1 else 0
            most = arguments.integer("cut_backs", cut_backs, 0)
            rtol, atol = (arguments.tolerance(name, value) for name, value in (("rtol", rtol), ("atol", atol)))
            self.check_start()
            ranks.same(steps=steps, rtol=rtol, atol=atol, max_iterations=max_iterations, **self.targets())
        return self.solve_checked(Limits(steps, most, rtol, atol, max_iterations), verbose, bool(progress))

    def solve_checked(self, limits: Limits, verbose: bool, progress: bool, solve: SolveInCpp | None = None) -> Report:
        """As `solve`, whose arguments have been checked on all ranks. Collective.

        Args:
            limits: how far the solve goes.
            verbose: whether iterations are printed on the terminal.
            progress: whether a solve that takes long says from time to time how far it is.
            solve: function of a problem in C++ that has this one; None: this one's own.

        Returns:
            Report.
        """
        if not self.solves.signs_are_checked:
            check_curvature(self.tangent.assemble(), ~self.fixed[: self.num_owned])
            self.solves.signs_are_checked = True
        self.solves.under_way = True
        try:
            with Interrupts(self.space.mesh.comm) as interrupts:
                report = run_steps(self, solve or self._cpp_object.solve, limits, interrupts, verbose, progress)
                interrupts.check()
        finally:
            self.solves.under_way = False
        self.linear_solver.warn_of_unused()
        self._rotation_warning.look(self.u, stacklevel=3)
        return report

    def check_start(self) -> None:
        """Refuse displacements that no solve can start from, on this rank.

        Raises:
            ValueError: u has values that are not finite numbers.
        """
        if not np.all(np.isfinite(self.u.x.array)):
            raise ValueError("u has values that are not finite numbers: give it a start, u.x.array[:] = 0")

    def targets(self) -> dict[str, list[Any]]:
        """Numbers of loads, boundary conditions and obstacles, which must be the same on all ranks."""
        return {
            "loads": [load.constant.value for load in self.loads if hasattr(load, "constant")],
            "bcs": [arguments.value_of(bc) for bc in self.bcs],
            "forces on rigid bodies": [c.pair.rigid_body.external_force for c in self.contact if c.pair.rigid_body],
            "torques on rigid bodies": [c.pair.rigid_body.external_torque for c in self.contact if c.pair.rigid_body],
            "angles of the masters": [c.pair.rigid_master.angle for c in self.contact if c.pair.rigid],
            "displacement of the masters": [c.pair.rigid_master.displacement for c in self.contact if c.pair.rigid],
        }
