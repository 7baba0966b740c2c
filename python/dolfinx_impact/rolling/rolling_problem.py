# SPDX-License-Identifier: MIT
"""Steady rolling in the ALE frame: the mesh stands, the material flows through it."""

from __future__ import annotations

import warnings
from collections.abc import Mapping, Sequence
from typing import TYPE_CHECKING, Any, cast

import dolfinx.fem.petsc as petsc
import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import MeshTags
from petsc4py import PETSc

from ..assembly.ffcx_form import ffcx_form
from .. import _cpp
from ..assembly import problem_arguments
from ..assembly.material_history import HistoryField, MaterialHistory
from ..assembly.resultant import Resultant
from ..common import arguments
from ..io.given_arguments import GivenArguments, cells_with
from ..common.collective import comm_of, guard
from ..common.progress_bar import ProgressBar
from ..common.types import ArrayLike, FilePath, FloatArray, IntArray
from ..common.unique import Unique
from ..common.units import Units
from ..added_mass import added_masses
from ..foundation import foundations
from ..loads import Load
from ..materials import MaterialMap, _Material
from ..recording.field_arguments import check_fields
from ..recording.output_options import output_options
from ..statics.linear_solver import LinearSolver
from ..statics.load_step_recorder import LoadStepRecorder
from ..statics.load_steps import Limits, Report
from ..statics.static_problem import StaticProblem
from . import inputs, revolution, sweep
from .rolling_contact import RollingContact, RollingLagrange
from .flow import Flow
from .motions import Spin, Translation
from .power_balance import PowerBalance
from .recorded_states import RecordedStates
from .sweep import Fingerprint
from .sweep_state import SweepState
from .transport import Transport

if TYPE_CHECKING:
    from ..contact.mortar.lagrange import Lagrange, LagrangeContact
    from ..contact.mortar.tie import TieContact
    from ..contact.penalty.penalty import Penalty
    from ..contact.penalty.quadrature_penalty import QuadraturePenalty


# Of the projection of velocities: systems of a mass matrix.
PROJECTION = {"ksp_type": "cg", "pc_type": "jacobi", "ksp_rtol": 1e-13, "ksp_max_it": 2000}


class RollingProblem(Unique):
    """Bodies through whose meshes the material flows steadily, in contact or not.

    The equations are those of a StaticProblem with the forces of inertia of the flow: stiffness minus W, and for a Spin
    the centrifugal load, which thus acts at the deformed radius.

    Args:
        u: displacement function. Its value is the initial guess, and becomes the solution [L].
        material: material or MaterialMap, with densities; internal variables flow along streamlines.
        cell_tags: tags of the bodies; every owned cell must carry one.
        motions: dict from cell tag to Spin or Translation.
        contact: contact, or a list of them: dolfinx_impact.Lagrange(pair), with friction or without;
            dolfinx_impact.Penalty(pair) without.
        bcs: boundary condition, or a list of them.
        loads: load (dolfinx_impact.Traction, ...), or a list of them.
        options: PETSc options, as of StaticProblem.
        prefix: prefix of PETSc options on the command line.

    Attributes:
        u: displacement [L].
        material, cell_tags, bcs, loads: as given.
        motions: motion by cell tag; a new Spin.omega or Translation.velocity counts from the next solve.
        contact: contacts with their results, in the order given.

    Raises:
        TypeError: an argument is of the wrong type; on all ranks.
        ValueError: cells without a motion, motions without cells, a Spin of a body that is neither one of revolution
            about its axis nor a sector that is held at its cuts, friction by penalty, materials without density, bodies
            with internal variables that stand, have friction or no streamlines of quadrature points; or what
            StaticProblem refuses. On all ranks.
    """

    def __init__(
        self,
        u: fem.Function,
        material: _Material | MaterialMap,
        cell_tags: MeshTags,
        motions: Mapping[int, Spin | Translation],
        contact: Lagrange | Penalty | Sequence[Lagrange | Penalty] = (),
        bcs: fem.DirichletBC | Sequence[fem.DirichletBC] = (),
        loads: Load | Sequence[Load] = (),
        options: dict[str, Any] | None = None,
        prefix: str = "impact_rolling_",
    ) -> None:
        with guard(comm_of(u, bcs, material, cell_tags, loads, contact), "RollingProblem") as ranks:
            bcs, loads, contact = problem_arguments.lists(bcs, loads, contact)
            given = problem_arguments.problem(u, material, None, bcs, loads, contact)
            inputs.check(u.function_space.mesh, material, cell_tags, motions, contact)
            if any(f.damps for f in foundations(loads)):
                raise ValueError("a RollingProblem takes no dashpots: give a Foundation without damping")
            if added_masses(loads):
                raise ValueError("a RollingProblem takes no AddedMass: what flows has its density")
            arguments.options(options)
            ranks.same(**given, motions=dict(motions), options=options, prefix=prefix)
        self.u, self.motions = u, {int(tag): motion for tag, motion in motions.items()}
        self.material, self.cell_tags, self.bcs, self.loads = material, cell_tags, tuple(bcs), tuple(loads)
        self._check_tags(cell_tags)
        for tag, motion in self.motions.items():
            if isinstance(motion, Spin):
                complaint = revolution.fault(u.function_space, cell_tags, tag, motion, bcs)
                if complaint:
                    raise ValueError(complaint)
        self._flow = Flow(u, material, cell_tags, self.motions)
        everything: list[Any] = [*loads, self._flow]
        self._rubs = any(c.pair.has_friction for c in contact)
        if self._rubs:
            contact = [RollingLagrange(cast("Lagrange", c), self._flow) for c in contact]
        self._equilibrium = StaticProblem(
            u, material, bcs=bcs, loads=everything, contact=contact, options=options, prefix=prefix
        )
        self._recorded = RecordedStates(self._equilibrium)
        self._transport = (
            Transport(self._equilibrium, self._flow) if self._equilibrium.body.properties.inelastic else None
        )
        self._cpp_object = _cpp.problems.RollingProblem(self._equilibrium._cpp_object, self._flow._cpp_object)

    def _check_tags(self, cell_tags: MeshTags) -> None:
        """Raise ValueError on all ranks unless cells and motions have the same tags."""
        mesh = self.u.function_space.mesh
        num_owned = mesh.topology.index_map(mesh.topology.dim).size_local
        owned = cell_tags.indices < num_owned
        found = mesh.comm.allgather((np.unique(cell_tags.values[owned]), int(num_owned - np.count_nonzero(owned))))
        tags = {int(t) for values, _ in found for t in values}
        missing, unknown = sorted(tags - set(self.motions)), sorted(set(self.motions) - tags)
        if missing:
            raise ValueError(f"cells carry the tags {missing}, which have no motion: give each a Spin or a Translation")
        if unknown:
            raise ValueError(f"motions has the tags {unknown}, which no cell carries; the mesh has {sorted(tags)}")
        untagged = sum(count for _, count in found)
        if untagged:
            raise ValueError(f"{untagged} cells carry no tag: every cell needs a motion")

    def __repr__(self) -> str:
        return f"RollingProblem({self.motions}, {self._equilibrium!r})"

    @property
    def contact(self) -> tuple[LagrangeContact | QuadraturePenalty | TieContact, ...]:
        """Contacts with their results."""
        return self._equilibrium.contact

    @property
    def history(self) -> MaterialHistory:
        """Internal variables of the materials by name, in the steady state.

        Raises:
            ValueError: no material has any.
        """
        return self._equilibrium.history

    @property
    def stress(self) -> HistoryField:
        """Cauchy stress at the quadrature points, as of StaticProblem [F/L^2]."""
        return self._equilibrium.stress

    @property
    def von_mises(self) -> HistoryField:
        """Von Mises' equivalent stress at the quadrature points [F/L^2]."""
        return self._equilibrium.von_mises

    @property
    def turn_changes(self) -> FloatArray:
        """Change of the internal variables of rings in each turn of the last solve, relative to the largest, at the
        places where turns begin, (turns) [1]. Empty without rings that have internal variables."""
        return np.array(self._transport.turn_changes if self._transport else [])

    @property
    def omega(self) -> float:
        """Angular velocity of the first Spin [1/T].

        Raises:
            ValueError: no body spins.
        """
        return self._first_spin().omega

    @property
    def _spin(self) -> Spin | None:
        """First of the motions that is a Spin."""
        return next((motion for motion in self.motions.values() if isinstance(motion, Spin)), None)

    def nodes_of(self, motion: Spin | Translation) -> IntArray:
        """Nodes of the bodies that have a motion, owned and ghosts.

        Args:
            motion: one of the motions.
        """
        return self._flow.nodes_of(motion)

    def _first_spin(self) -> Spin:
        if self._spin is None:
            raise ValueError("no body has a Spin")
        return self._spin

    def solve(
        self,
        steps: int = 1,
        rtol: float = 1e-10,
        atol: float = 0.0,
        max_iterations: int = 25,
        cut_backs: int | None = None,
        verbose: bool = False,
        torque: float | None = None,
        turns: int | None = None,
    ) -> Report:
        """Find the steady state for the present rates, loads, boundary conditions and obstacles, in steps from those of
        the last solve. Collective.

        After an exception u, contacts, rates, loads and obstacles are those of the last converged state.

        Args:
            steps: number of equal steps [1].
            rtol: tolerance of the free residual, as in StaticProblem.solve [1].
            atol: tolerance of the free residual [F].
            max_iterations: largest number of iterations per step [1].
            cut_backs: largest number of times that the increment is halved, as in StaticProblem.solve [1].
            verbose: print every iteration on rank 0.
            torque: that drives the body of the first Spin; its omega is then an unknown, found from its present value
                on. Zero is free rolling. None: omega is given [F L]; per length in the plane.
            turns: turns of a ring with internal variables, which goes on with the history that it has; None: until a
                turn leaves the history that it began with [1].

        Returns:
            Report, as of StaticProblem.solve; with a torque, its last increment finds omega.

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: as in StaticProblem.solve; a torque without friction or without a Spin; turns without a whole
                ring that has internal variables; bodies that move against each other at the contact, or friction
                between bodies that do not move; on all ranks.
            RuntimeError: no convergence, also because friction cannot bear the torque, or because turns do not repeat;
                or a speed beyond the critical one: the tangent, stiffness minus W, is not positive definite; on all
                ranks.

        Warns:
            UserWarning: Lagrange contacts, and the bodies without them are beyond the critical speed.
        """
        p = self._equilibrium
        with guard(self.u.function_space.mesh.comm, "RollingProblem.solve") as ranks:
            numbers = inputs.solver(steps, rtol, atol, max_iterations, cut_backs, torque, self._rubs, self._spin)
            numbers["turns"] = inputs.turns(turns, self._transport is not None and self._transport.closes)
            p.check_start()
            ranks.same(motions=self.motions, **numbers, **p.targets())
        self._flow.update()
        for contact in self._rolling_contacts():
            contact.update_obstacle()
        good = self._cpp_object.saved_state()

        def equilibrium(number: int) -> Report:
            solve = _SolveInCpp(self._cpp_object, numbers["torque"])
            limits = Limits(number, *(numbers[k] for k in ("cut_backs", "rtol", "atol", "max_iterations")))
            report = p.solve_checked(limits, verbose, False, solve)
            if torque is not None:
                self._first_spin().omega = float(self._flow.rate_of(self._first_spin()))
            if solve.warning and p.space.mesh.comm.rank == 0:
                warnings.warn(solve.warning, stacklevel=3)
            return report

        if self._transport is None:
            report = equilibrium(steps)
            self._recorded.solved()
            return report
        self._transport.update()
        found = False
        try:
            report = self._transport.solve(lambda first: equilibrium(steps if first else 1), turns)
            found = True
        finally:
            if not found:
                self._cpp_object.bring_back(good)
        self._recorded.solved()
        return report

    def record(
        self,
        path: FilePath | None = None,
        fields: Sequence[str] = ("displacement",),
        expressions: Mapping[str, ufl.core.expr.Expr] | None = None,
        ending: str = ".bp",
        units: Units | None = None,
    ) -> LoadStepRecorder:
        """Write fields and contact forces of each steady state into a folder: after each `solve`, and after each point
        of a `sweep`. Collective.

        Args:
            path: folder; None as for RunFolder.
            fields: as of StaticProblem.record; of contacts with friction also slip_velocity.
            expressions: further fields, as of StaticProblem.record.
            ending: ".bp" or ".xdmf".
            units: units that the names of fields end with; None: names alone.

        Returns:
            Recorder, whose load steps are the numbers of the steady states; call its `close()` at the end.

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: a field is unknown; on all ranks.
            RuntimeError: the folder cannot be written; on all ranks.
        """
        with guard(self.u.function_space.mesh.comm, "RollingProblem.record", path=path, fields=fields) as ranks:
            if path is not None:
                arguments.path("path", path)
            options = output_options(expressions, ending, units)
            names = check_fields(self._recorded, fields, ["displacement"], options)
            ranks.same(output=options)
        return LoadStepRecorder(self._recorded, path, names, 1, options)

    def sweep(
        self,
        creep: ArrayLike | None = None,
        lateral: ArrayLike | None = None,
        spin: ArrayLike | None = None,
        file: FilePath | None = None,
        progress: bool = True,
        identity: Mapping[str, Any] | None = None,
        **options: Any,
    ) -> dict[str, FloatArray]:
        """Steady states for a sequence of creepages, each found from the one before: a creep curve. Collective.

        The creepages count from the present rates of the motions (after `solve(torque=0)`, from free rolling); speed is
        the larger speed of the two surfaces. The problem is left in the last state, whose creepages stay.

        Args:
            creep: longitudinal: omega is (1 + creep) times that of the beginning, (n) or one number [1].
            lateral: speed of the first spinning body along its axis against the other, over the speed, (n) or one
                number [1].
            spin: turn of that body about the contact's normal that points into it, against the other, over the speed,
                (n) or one number; meshes in space [1/L].
            file: HDF5 file that is written after every point. Points that it has already are not solved again.
            progress: show a progress bar on rank 0.
            identity: numbers and texts by name that the problem was made from, for example all parameters of a study.
                The file has them, and a sweep with others, to the last digit, refuses it. The file has what the
                problem was made of in any case, but sums over the mesh and rates that were found only to round-off.
            options: of `solve`.

        Returns:
            Arrays by name: creep, lateral, spin, omega (n) [1/T], force (n, gdim) on the slave of the first contact
            [F], torque (n) [F L].

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: no body has a Spin, no contact friction; creepages of different lengths; lateral or spin creep
                in the plane; a spin of zero; a file of another sweep or problem; on all ranks.
            RuntimeError: a point did not converge, or the file cannot be written; on all ranks. The file has the points
                before it.
        """
        comm = self.u.function_space.mesh.comm
        with guard(comm, "RollingProblem.sweep") as ranks:
            points = sweep.creepages(creep, lateral, spin)
            first = self._first_spin()
            if not self._rubs:
                raise ValueError("no contact has friction: there is no creep force")
            if first.omega == 0.0:
                raise ValueError("omega is zero: creep is a part of it")
            flat = self.u.function_space.mesh.geometry.dim == 2
            if flat and (np.any(points["lateral"]) or np.any(points["spin"])):
                raise ValueError("lateral and spin creep need a mesh in space")
            own = sweep.stated(identity)
            ranks.same(
                points=[points[name] for name in sweep.INPUTS], file=None if file is None else str(file), identity=own
            )
        start = first.omega

        def solve(creep: float, lateral: float, spin: float) -> dict[str, Any]:
            first.omega = start * (1.0 + creep)
            self._flow.set_creepage(lateral, spin)
            self.solve(**options)
            force = self.contact[0].force
            assert force is not None
            return {"omega": first.omega, "force": force.copy(), "torque": self.torque}

        def begin_from(row: dict[str, Any], state: tuple[FloatArray, FloatArray]) -> None:
            """As after the solve of a point that a file has."""
            first.omega = float(row["omega"])
            self._flow.set_creepage(float(row["lateral"]), float(row["spin"]))
            self._flow.update()
            kept.set(*state)

        kept = SweepState(self._equilibrium, self._cpp_object.mark_reached)
        problem = self._fingerprint(options)
        problem.arguments = own | problem.arguments
        return sweep.run(comm, points, solve, file, progress, problem, kept, begin_from)

    def _fingerprint(self, options: dict[str, Any]) -> Fingerprint:
        """What tells the points of another problem. Collective.

        Args:
            options: of `solve`.
        """
        p, V = self._equilibrium, self._equilibrium.space
        given = GivenArguments(V.mesh, (self.u,))
        given.add_mesh(V)
        given.add_material("material", self.material)
        for tag, motion in self.motions.items():
            given.table[f"motions[{tag}]"] = f"{type(motion).__name__}, {cells_with(self.cell_tags, tag)}"
            given.add_attributes(f"motions[{tag}]", motion, but=("omega", "velocity"))
        given.table["contact"] = ", ".join(c.kind for c in p.contact)
        for k, c in enumerate(p.contact):
            given.add_contact(f"contact[{k}]", c.kind, c.options, c.pair, c.facets())
        given.table["loads"] = ", ".join(type(load).__name__ for load in self.loads)
        for k, load in enumerate(self.loads):
            given.add_load(f"loads[{k}]", load)
        values = self.u.copy()
        for bc in p.bcs:
            bc.set(values.x.array)
        fixed = np.flatnonzero(p.fixed[: p.num_owned])
        given.add_prescribed("bcs", V, fixed, values.x.array[fixed])
        given.add("options", {name: options[name] for name in sorted(options)})
        rates: list[FloatArray] = [np.ravel(motion.rate) for motion in self.motions.values()]
        return Fingerprint(given.table, np.concatenate(rates))

    def _rolling_contacts(self) -> list[RollingContact]:
        """Contacts, if they have friction."""
        return cast("list[RollingContact]", list(self._equilibrium.contact)) if self._rubs else []

    def reactions(self) -> fem.Function:
        """Support forces at prescribed degrees of freedom, round-off elsewhere [F]. Collective."""
        return self._equilibrium.reactions()

    def reaction(self, where: Any = None, point: ArrayLike | None = None) -> Resultant:
        """Force and moment of supports on the bodies, as of StaticProblem.reaction. Collective.

        Args:
            where: boundary condition, pair (facet_tags, tag), or None: all supports.
            point: point that the moment is about, (gdim); None: the origin [L].

        Returns:
            Resultant.

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: a condition or tags of another mesh or space; on all ranks.
        """
        return self._equilibrium.reaction(where, point)

    @property
    def has_history(self) -> bool:
        """Whether a material has internal variables."""
        return self._equilibrium.has_history

    @property
    def torque(self) -> float:
        """Torque that drives the body of the first Spin: minus the moment of the contact forces about its axis, at
        deformed places, positive along the axis [F L]; per length in the plane. Collective.

        The axis moves with the body's supports, by the mean of their prescribed displacements.

        Raises:
            ValueError: no body spins.
        """
        return self._cpp_object.torque(self._flow.number_of(self._first_spin()))

    def axle(self, spin: Spin) -> FloatArray:
        """Displacement of the axis of a body that spins: in each component the mean of the displacements that its
        supports prescribe, zero where they prescribe none, (3) [L]. Collective.

        Args:
            spin: one of the motions.
        """
        return np.array(self._cpp_object.axle(self._flow.number_of(spin)))

    def power_balance(self) -> PowerBalance:
        """Power that drives the bodies, and where it goes, in the present state. Collective.

        Returns:
            Driving, friction and rolling power [F L/T]; per length in the plane.

        Raises:
            ValueError: no contact has friction; on all ranks.
        """
        if not self._rubs:
            raise ValueError("no contact has friction: steady rolling takes no power")
        found = self._cpp_object.power_balance()
        return PowerBalance(found.driving, found.friction, found.rolling)

    def velocity(self) -> fem.Function:
        """Velocity of the material, w + (Grad u) w, projected on the displacement space. Collective.

        With the displacement it is the start of an ExplicitProblem or NewmarkProblem of the same mesh, whose nodes then
        move with the material: the bodies go on in their steady state, without settling. Motion is that in the frame of
        the axle; for another frame add its velocity.

        Returns:
            Function on the displacement space [L/T].

        Raises:
            RuntimeError: the projection was not solved; on all ranks.
        """
        p = self._equilibrium
        self._flow.update()
        v, dv = ufl.TestFunction(p.space), ufl.TrialFunction(p.space)
        mass = petsc.assemble_matrix(ffcx_form(self._flow.mass(self.u, dv, v)))
        mass.assemble()
        b = petsc.assemble_vector(ffcx_form(self._flow.momentum(self.u, v)))
        b.ghostUpdate(PETSc.InsertMode.ADD_VALUES, PETSc.ScatterMode.REVERSE)
        found = fem.Function(p.space, name="velocity")
        system = _cpp.solve.CondensedSystem(mass, [], True, None, np.zeros(p.num_owned, dtype=np.int8), 1.0)
        fault = LinearSolver(p.space, PROJECTION, "impact_velocity_").solve(system, b, found.x.petsc_vec)
        del system
        mass.destroy()
        b.destroy()
        if fault:
            raise RuntimeError(f"the velocity was not found: {fault}")
        found.x.scatter_forward()
        return found

    def frequencies(self, n: int, tolerance: float = 1e-10) -> FloatArray:
        """Angular frequencies of small vibrations about the present state, in the ALE frame. Collective.

        A wave exp(i (omega t - m theta)), m > 0 counted along the spin, has its own sign of omega: positive for waves
        that travel with the flow, negative against it. Waves without a direction (no spin, m = 0) are positive.
        Free rigid motions, of frequency zero, are left out.

        Args:
            n: number of frequencies, of smallest modulus [1].
            tolerance: relative tolerance of the eigenvalues [1].

        Returns:
            Signed frequencies, sorted by modulus, (n) [rad/T].

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: an argument is not positive, or there are Lagrange contacts; on all ranks.
            RuntimeError: the eigensolver found fewer; on all ranks.

        Warns:
            UserWarning: modes grow, as the state is beyond a critical speed; they are left out.
        """
        p = self._equilibrium
        with guard(p.space.mesh.comm, "RollingProblem.frequencies", n=n, tolerance=tolerance):
            n = arguments.integer("n", n, 1)
            tolerance = arguments.number("tolerance", tolerance, 0.0)
            if any(c.has_multipliers for c in p.contact):
                raise ValueError("frequencies are those of bodies with contact by penalty: replace Lagrange by Penalty")
        self._flow.update()
        v, du = ufl.TestFunction(p.space), ufl.TrialFunction(p.space)
        forms = [f(self.u, du, v) for f in (self._flow.gyroscopic, self._flow.mass, self._flow.direction)]
        G, M, along = (self._matrix(form) for form in forms)
        found, growing = self._cpp_object.frequencies(G, M, along, n, tolerance)
        for matrix in (G, M, along):
            matrix.destroy()
        if growing and p.space.mesh.comm.rank == 0:
            warnings.warn(f"{growing} modes grow: beyond a critical speed; they are left out", stacklevel=2)
        return found

    def campbell(self, omegas: ArrayLike, n: int, progress: bool = True, **options: Any) -> dict[str, FloatArray]:
        """Campbell diagram: steady state and frequencies for a sequence of spins of the first body. Collective.

        The problem is left in the last state.

        Args:
            omegas: angular velocities, (m) [1/T].
            n: number of frequencies of each [1].
            progress: show a progress bar on rank 0.
            options: of `solve`.

        Returns:
            Arrays by name: omega (m) [1/T]; frequencies (m, n), signed, sorted by modulus [rad/T].

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: no body has a Spin; no or other than finite numbers; or as in `frequencies`; on all ranks.
            RuntimeError: as in `solve` and `frequencies`; on all ranks.
        """
        comm = self.u.function_space.mesh.comm
        with guard(comm, "RollingProblem.campbell", n=n) as ranks:
            spin = self._first_spin()
            values = np.array([arguments.number("omegas", x) for x in np.ravel(np.asarray(omegas, dtype=object))])
            if len(values) == 0:
                raise ValueError("omegas is empty: give at least one angular velocity")
            ranks.same(omegas=values)
        rows = []
        with ProgressBar(comm, progress, len(values), counted=True) as bar:
            for k, omega in enumerate(values):
                bar.show(k, lambda: f"omega {omega:.4g}")
                spin.omega = float(omega)
                self.solve(**options)
                rows.append(self.frequencies(n))
            bar.show(len(values), str)
        return {"omega": values, "frequencies": np.array(rows)}

    def critical_factor(self) -> float:
        """Factor on the present rates at which stiffness minus W becomes singular: times omega it is the critical
        angular velocity, at which a wave that runs against the spin stands still. Collective.

        The stiffness is that of the present state, with contacts by penalty and without those by multipliers: exact for
        `LinearElastic` bodies; with finite strain it changes with the spin, and the factor at a state near the critical
        one, where it is near 1, tells.

        Returns:
            The factor; infinite where nothing moves [1].

        Raises:
            ValueError: a body is not held against rigid motion; on all ranks.
            RuntimeError: the eigensolver found none; on all ranks.
        """
        p = self._equilibrium
        self._flow.update()
        v, du = ufl.TestFunction(p.space), ufl.TrialFunction(p.space)
        W = self._matrix(self._flow.softening(self.u, du, v))
        factor = self._cpp_object.critical_factor(W)
        W.destroy()
        return factor

    def _matrix(self, form: ufl.Form) -> PETSc.Mat:
        """Matrix of a bilinear form, zero at supports."""
        matrix = petsc.assemble_matrix(ffcx_form(form), list(self._equilibrium.bcs), 0.0)
        matrix.assemble()
        return matrix


class _SolveInCpp:
    """`solve` of a rolling problem in C++ as one of a static problem, which it has.

    Args:
        problem: in C++.
        torque: that drives the first spinning body, whose rate is then found; None: rates are given [F L].

    Attributes:
        warning: of the last call; empty if there is none.
    """

    def __init__(self, problem: _cpp.problems.RollingProblem, torque: float | None) -> None:
        self._problem, self._torque, self.warning = problem, torque, ""

    def __call__(
        self, steps: int, rtol: float, atol: float, max_iterations: int, cut_backs: int | None, **told: Any
    ) -> _cpp.solve.LoadStepReport:
        report, self.warning = self._problem.solve(steps, rtol, atol, max_iterations, cut_backs, self._torque, **told)
        return report
