# SPDX-License-Identifier: MIT
"""Composes material, inertia, loads, prescribed motion and contact into an implicit problem; seed (3.81), corrected."""

from __future__ import annotations

import math
import warnings
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem

from ... import _cpp
from ...amplitude import Amplitude, PrescribedMotion
from ...assembly import problem_arguments
from ...assembly.curvature import check_curvature, is_displacement
from ...assembly.body_forms import stiffness_damping
from ...assembly.operators import Inputs, InternalForce
from ...assembly.ffcx_form import ffcx_form
from ...assembly.fields import check_inertia, is_mixed
from ...assembly.locking import warn_of_locking
from ...assembly.measures import check_measures
from ...assembly.residual import check_hypothesis, split
from ...assembly.quadrature_degree import warn_of_degree
from ...assembly.body_stress import BodyStress
from ...assembly.softening import warn_of_softening
from ...common import arguments
from ...common.collective import agree, attempt, comm_of, guard
from ...common.types import ArrayLike, BoolArray, FilePath, FloatArray
from ...common.units import Units
from ...common.unique import claim
from ...contact.general import GeneralContact, named_pairs
from ...contact.mortar.tie import Tie, TieContact
from ...io.mesh_check import check_cells
from ...added_mass import added_masses
from ...foundation import dashpot_form, foundations
from ...loads import DeadLoad, Load
from ...materials import MaterialMap, Rayleigh, _Material
from ...statics.load_forms import load_forms
from ...statics.make_body import make_body
from ...statics.material_body import MaterialBody, history_of
from ...statics.linear_solver import LIMITS, LinearSolver, make_room, petsc_options, warnings_on
from ..energy_gain import release_limit
from ..functions_of_time import FunctionsOfTime
from ..start_values import check_velocity, residual_bodies, velocity_or_rest
from ...recording.output_options import output_options
from ..recorder import Recorder, check_arguments
from ...contact.names import named_apart
from ..in_time import implicit_bodies, implicit_contact, prescribed_motion
from ..hourglass import HourglassEnergy
from ..run_history import ENERGIES, RunHistory, total_energy
from ..subject import in_time
from ..transient_problem import TransientProblem
from ..read_once import ReadOnce
from .mass_redistribution import MassRedistribution
from .damping import DampingForce
from .growth_guard import GrowthGuard
from .inertia import Inertia
from .restart import ImplicitRestart
from .scheme import scheme_of
from .stepper import MOST_STEPS, ImplicitStepper, StepLimits
from .stored_energies import stored_energies

if TYPE_CHECKING:
    from ...contact.mortar.lagrange import Lagrange, LagrangeContact
    from ...contact.penalty.penalty import Penalty
    from ...contact.penalty.quadrature_penalty import QuadraturePenalty
    from ...contact.protocol import BodyTangent

IMPACT = ("mass_redistribution", "none")
# Smallest tolerance of local errors: they follow from differences of accelerations, whose round-off in double
# precision, 2e-16, a stiff mesh multiplies by (omega dt)^2, up to some thousand.
SMALLEST_ERROR = 1e-12
SMALLEST = 1e-3  # default for the smallest step, relative to the largest: ten cut-backs
STEPS = (1e-140, 1e140)  # whose squares, times anything that physics has, are numbers [T]


class NewmarkProblem(TransientProblem):
    """Motion of bodies by Newmark's method or generalised-alpha, in contact or not; docs/implicit/scheme.md.

    Args:
        u: displacement function. Its value is the initial displacement; the problem updates it [L].
        material: material or MaterialMap with densities; or give `residual` and `density`.
        residual: UFL residual of your own in u (rank 1): internal minus external forces. If it contains the function
            given as `velocity`, that function stands for the velocity at the end of a step.
        density: density per undeformed volume for a residual of your own: number, function or UFL expression; a list
            with one of them for each field of a mixed space, or component of a vector, 0 for one without inertia, whose
            velocity is the mean of a step (Euler's implicit rule) [M/L^3].
        velocity: initial velocity, a function on u's space; None: at rest. Where motion is prescribed, its own velocity
            counts. The function is not changed unless the residual contains it [L/T].
        bcs: DirichletBC (values are constant), PrescribedMotion (function of time), or a list of them.
        loads: load, or a list of them; their `amplitude` is a function of time.
        contact: contact, or a list of them: dolfinx_impact.Lagrange(pair), dolfinx_impact.Penalty(pair). Rigid masters
            move by `motion`.
        beta: Newmark's beta, positive; None: 1/4 [1].
        gamma: Newmark's gamma, at least 1/2; None: 1/2 [1].
        rho_inf: spectral radius at infinite frequency, 0 to 1: the parameters of Chung and Hulbert; None: Newmark [1].
        hht: alpha of Hilber, Hughes and Taylor, -1/3 to 0; None: Newmark [1].
        damping: Rayleigh(alpha, beta) or None.
        lumping: lumping scheme, as for lumped_mass; None: consistent mass.
        impact: what is done about the mass of contact surfaces. "mass_redistribution": nodes of contact surfaces pass
            it on to the nodes behind them, so that they neither rattle nor take up kinetic energy at impact; "none":
            they keep it. Without contact it makes no difference.
        options: PETSc options for KSP and SNES by name, without prefix, as for StaticProblem.
        prefix: prefix of PETSc options on the command line, which take precedence over `options`.
        hypothesis: for a residual of your own: "axisymmetric" if its integrals contain 2 pi r, otherwise None or
            another hypothesis.
        tangent: for a residual of your own: its derivative, a UFL form of rank 2; None: UFL finds it. Needed where the
            residual reads a stress that is computed elsewhere, as a function at quadrature points.
        evaluate: with `tangent`: function that is called as evaluate(u) before residual or tangent are assembled at a
            u, in every iteration. It sets the functions that they read, and not u; docs/howto/own_form.md.
        accept: with `evaluate`: function that is called as accept(u) when a step has converged, for example to make
            internal variables those that the next step begins from.

    Attributes:
        u: displacement at the present time [L].
        velocity: velocity at the present time [L/T].
        acceleration: acceleration at the present time [L/T^2].
        contact: contacts with results.
        scheme: parameters of the scheme.
        inertia: mass matrix.
        impact: as given.
        fixed: mask of prescribed degrees of freedom, owned and ghosts.
        num_owned: number of degrees of freedom that this rank owns [1].
        functions: functions of time of loads, supports and obstacles.
        supports: prescribed owned degrees of freedom, their values [L] and the column of their function of time
            (-1: constant), for every support.
        mass: lumped mass per degree of freedom, by which a checkpoint recognises the bodies [M].
        evaluates: whether a function of the user computes what the residual reads.
        body: bodies without inertia.
        read: values of supports and rigid masters that the problem goes on with.
        stepper: time stepping.
        inputs: constants and functions that residual and loads read.
        linear_solver: solver of the linear systems.

    Raises:
        TypeError: an argument is of the wrong type; on all ranks.
        ValueError: a value does not fit, or differs between ranks; on all ranks.

    Warns:
        UserWarning: beta is less than gamma/2, so that the scheme is stable with small steps only; an ExplicitProblem
            with the same u exists; or materials with internal variables soften, or are on cells that lock.
    """

    _cpp_object: _cpp.problems.NewmarkProblem
    moves_rigid_bodies = True  # what RigidBody asks
    _instead = "use save and restore, or make another one on a displacement function of its own"

    def __init__(
        self,
        u: fem.Function,
        material: _Material | MaterialMap | None = None,
        residual: ufl.Form | None = None,
        density: float | ufl.core.expr.Expr | Sequence[float | ufl.core.expr.Expr] | None = None,
        velocity: fem.Function | None = None,
        bcs: fem.DirichletBC | PrescribedMotion | Sequence[fem.DirichletBC | PrescribedMotion] = (),
        loads: Load | Sequence[Load] = (),
        contact: Lagrange | Penalty | Tie | GeneralContact | Sequence[Lagrange | Penalty | Tie | GeneralContact] = (),
        beta: float | None = None,
        gamma: float | None = None,
        rho_inf: float | None = None,
        hht: float | None = None,
        damping: Rayleigh | None = None,
        lumping: str | None = None,
        impact: str = "mass_redistribution",
        options: dict[str, Any] | None = None,
        prefix: str = "impact_implicit_",
        hypothesis: str | None = None,
        tangent: ufl.Form | None = None,
        evaluate: Callable[[fem.Function], object] | None = None,
        accept: Callable[[fem.Function], object] | None = None,
    ) -> None:
        with guard(comm_of(u, velocity, residual, bcs, material, loads, contact), "NewmarkProblem") as ranks:
            if residual is not None and density is None:
                raise ValueError("a residual of your own needs a density")
            if material is not None and (density is not None or hypothesis is not None):
                raise ValueError("density and hypothesis are those of the material: give them there")
            axisymmetric = hypothesis == "axisymmetric"
            bcs, loads, contact = problem_arguments.lists(bcs, loads, contact)
            given = problem_arguments.problem(
                u, material, residual, bcs, loads, contact, axisymmetric, implicit=True, tangent=tangent,
                evaluate=evaluate, accept=accept,
            )  # fmt: skip
            problem_arguments.computes(u, residual, evaluate)
            named = named_pairs(contact)
            check_velocity(velocity, u)
            own: Any = None
            if residual is not None:
                own = residual_bodies(u.function_space, hypothesis, density)
                check_inertia(own.density_constant(u.function_space.mesh), u.function_space, False, lumping)
            if damping is not None and not isinstance(damping, Rayleigh):
                raise TypeError(f"damping must be Rayleigh(alpha, beta) or None, found {type(damping).__name__}")
            if impact not in IMPACT:
                raise ValueError(f"impact is {impact!r}: use one of {', '.join(IMPACT)}")
            if damping is not None and damping.beta > 0.0 and material is None:
                raise ValueError("stiffness-proportional damping needs a material: write it into your own residual")
            self.scheme = scheme_of(beta, gamma, rho_inf, hht)
            arguments.options(options)
            ranks.same(**given, density=density, damping=damping, scheme=str(self.scheme), lumping=lumping,
                       impact=impact, hypothesis=hypothesis, options=options, prefix=prefix,
                       velocity_given=velocity is not None)  # fmt: skip
        velocity = velocity_or_rest(velocity, u)
        self.u, self.space, self.material = u, u.function_space, material
        self._stress = BodyStress(u, material)
        V, mesh = self.space, self.space.mesh
        self.comm, self.num_owned = mesh.comm, V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        self.damping, self.lumping, self.impact = damping or Rayleigh(), lumping, impact
        self.loads, self.residual_form, self.given_density = tuple(loads), residual, density
        check_cells(mesh)
        claim(u, self)
        moving = residual
        resisting: ufl.Form | None = None
        if residual is None:
            assert material is not None  # checked above
            warn_of_locking(u, material)
            warn_of_softening(u, material)
            hypothesis = material.hypothesis_on(mesh)
            densities, tags = [(t, m.mass_density(mesh)) for t, m in material.parts()], material.cell_tags
            bodies: Any = material
        else:
            moving, resisting = split(residual, velocity)
            bodies = own
            check_hypothesis(moving, u, hypothesis, tangent)
            warn_of_degree(residual, u, hypothesis)
            densities, tags = [(None, bodies.density_constant(mesh))], None
        self.axisymmetric = hypothesis == "axisymmetric"
        self.velocity = velocity
        if resisting is None:
            self.velocity = fem.Function(V, name="velocity")
            self.velocity.x.array[:] = velocity.x.array
        self.acceleration = fem.Function(V, name="acceleration")
        given_bodies = None if residual is None else bodies
        self.body = make_body(u, material, moving, self.loads, given_bodies, tangent, evaluate, accept)
        self._material_history = history_of(self.body)
        # What `evaluate` sets is no value that comes late.
        self.evaluates = evaluate is not None
        self.functions = FunctionsOfTime()
        with_amplitude = [load for load in self.loads if getattr(load, "amplitude", None) is not None]
        scaled: list[tuple[Any, FloatArray]] = []  # constants of these loads, and their amplitudes at the start
        for load in with_amplitude:
            self.functions.add(Amplitude(load.amplitude, f"amplitude of {type(load).__name__}"))
            scaled.append((load.constant._cpp_object, np.ones(1)))
        motions = [prescribed_motion(bc, self.functions) for bc in bcs]
        self.fixed: BoolArray = np.zeros(len(u.x.array), dtype=bool)
        for bc in bcs:
            self.fixed[(bc.bc if isinstance(bc, PrescribedMotion) else bc).dof_indices()[0]] = True
        # Tied surfaces do not strike each other, and of general contact all outer surfaces would be massless.
        pairs = [c.pair for c in contact if not isinstance(c, (Tie, GeneralContact))]
        surface = MassRedistribution(V, pairs) if pairs and impact == "mass_redistribution" else None
        owned = self.fixed[: self.num_owned]
        self.inertia = Inertia(V, densities, hypothesis or "3d", tags, lumping, surface, owned, added_masses(loads))
        self.mass = self.inertia.total
        # Forces of springs to the ground count as internal ones, and their energy with that of the bodies.
        springs = foundations(self.loads)
        if isinstance(self.body, MaterialBody):
            self.body.set_energies(stored_energies(u, bodies, springs))
        damping_force = self._damping_force(resisting, bodies)
        loaded = load_forms(u, bodies, [load for load in self.loads if load not in springs])
        work = loaded.work()
        self.named_pairs = named
        self.contact: tuple[LagrangeContact | QuadraturePenalty | TieContact, ...] = tuple(
            [c._bind(self) for c in named_apart(contact)]
        )
        read = [form for form in (residual, work) if form is not None]
        self.inputs = Inputs(
            [c for form in read for c in form.constants()], [f for form in read for f in form.coefficients()],
            (u, self.velocity),
        )  # fmt: skip
        make_room(V)
        by_kernels = [InternalForce(form) for form in loaded.dead] if material is not None else []
        rest = loaded.other if material is not None else work
        self._work = None if rest is None else ffcx_form(rest)  # FFCx's functions are Python's
        in_steps = [implicit_contact(c, self.functions) for c in self.contact]
        rigid = implicit_bodies(self, self.contact, self.functions)
        self._cpp_object = _cpp.problems.NewmarkProblem(
            u._cpp_object, self.velocity._cpp_object, self.acceleration._cpp_object,
            _cpp.problems.ImplicitBody(
                self.body.in_cpp(), self.inertia._cpp_object, self.inertia.total.array[: self.num_owned],
                self.damping.alpha, None if damping_force is None else damping_force.in_cpp(),
                None if self._work is None else self._work._cpp_object, [load.live() for load in by_kernels], scaled,
            ),
            motions, in_steps, self.scheme,
            petsc_options(options), prefix, self.axisymmetric, LIMITS, warnings_on(self.comm), self.sample, rigid,
        )  # fmt: skip
        self.supports = self._cpp_object.supports.parts
        self.linear_solver = LinearSolver.of(self._cpp_object.equilibrium.linear_solver)
        self.read = ReadOnce(self._cpp_object.supports, self.contact)
        self._history = RunHistory(len(self.contact), mesh.geometry.dim, self._cpp_object.history)
        self.stepper = ImplicitStepper(
            self._cpp_object, self.comm, u, self.velocity, material, self.inputs, self.read, self.evaluates
        )
        self._hourglass = HourglassEnergy(u, material)
        self._restart = ImplicitRestart(in_time(self), self, self._set_energy)
        self._set_energy()
        self._warn_of_small_steps()
        self._growth: GrowthGuard | None = None
        if residual is not None and is_displacement(V):
            self._growth = self._check_signs()

    # --- set-up ----------------------------------------------------------------------------------------------------

    def __repr__(self) -> str:
        size = self.space.dofmap.index_map.size_global * self.space.dofmap.index_map_bs
        what = "residual of its own" if self.material is None else repr(self.material)
        parts = f"{len(self.loads)} loads, {len(self.contact)} contacts"
        now = f"step {self.step}, time {self.time:g}"
        return f"NewmarkProblem({size} unknowns, {what}, {parts}, {self.scheme}, {now})"

    def _damping_force(self, resisting: ufl.Form | None, bodies: Any) -> DampingForce | None:
        v = ufl.TestFunction(self.space)
        form = dashpot_form(self.loads, self.velocity, v, bodies)
        if resisting is not None:
            form = resisting if form is None else resisting + form
            check_measures(form)
        if self.damping.beta > 0.0:
            assert self.material is not None  # checked by the constructor
            beta = fem.Constant(self.space.mesh, default_scalar_type(self.damping.beta))
            rayleigh = stiffness_damping(self.u, self.velocity, v, self.material, beta)
            form = rayleigh if form is None else rayleigh + form
        return None if form is None else DampingForce(form, self.u, self.velocity)

    def stable_step(self) -> float:
        """Largest stable step at the present displacement, of a scheme with beta < gamma/2; others have none.
        Collective.

        Returns:
            Step; infinite for schemes that are stable with any step [T].

        Raises:
            RuntimeError: the eigenvalue solver does not converge.
        """
        return float(self._cpp_object.stable_step())

    def _warn_of_small_steps(self) -> None:
        step = self.stable_step()
        if math.isfinite(step) and self.comm.rank == 0:
            warnings.warn(
                f"beta = {self.scheme.beta:g} is less than gamma/2 = {0.5 * self.scheme.gamma:g}: the scheme is stable "
                f"only with steps up to {step:.4g} (at the start, without damping)",
                stacklevel=4,
            )

    # --- forces and energies -----------------------------------------------------------------------------------------

    @property
    def tangent(self) -> BodyTangent:
        """Derivative of the bodies' residual without inertia, at the present u [F/L]."""
        return self.body.tangent

    def _check_signs(self) -> GrowthGuard:
        """Look at the signs of the tangent of a residual of the user's own. Collective.

        Returns:
            Guard against growth of what this does not see.

        Raises:
            ValueError: the tangent is strongly negative; on all ranks.
        """
        K = self.tangent.assemble()
        check_curvature(K, ~self.fixed[: self.num_owned])
        diagonal = K.getDiagonal()
        limit = release_limit(self.space, diagonal.array_r)
        diagonal.destroy()
        work = 0.5 * float(self.stepper.energy_balance.forces.internal @ self.stepper.motion.displacement)
        return GrowthGuard(limit + abs(self.comm.allreduce(work)), self._energy["kinetic"])

    def sample(self, times: FloatArray) -> FloatArray:
        """Values of all functions of time; an error on one rank is raised on all. Collective.

        Args:
            times: times, (n) [T].

        Returns:
            (n, num_columns).
        """
        found, error = attempt(self.functions.table, times)
        agree(self.comm, error, "functions of time")
        return np.ascontiguousarray(found)

    def _take_row(self) -> None:
        """Tell recorders and `energy` of the last row of the history, which is new. Collective."""
        last = self._history.last
        assert last is not None
        for recorder in self.stepper.recorders:
            recorder.add(np.array([last]))
        self._set_energy({name: float(last[name]) for name in ENERGIES})

    def _accepted(self) -> float:
        """A step is in the history. Collective.

        Returns:
            Drift of the energy [1].

        Raises:
            RuntimeError: a residual of the user's own makes the body move ever faster; on all ranks.
        """
        self._take_row()
        if self._growth is not None:
            self._growth.check(self._energy, self.time)
        return float(self._energy["drift"])

    def _set_energy(self, values: dict[str, float] | None = None) -> None:
        """Set the energies that `energy` shows. Collective.

        Args:
            values: energies, if they are known [F L].
        """
        if values is None:
            values = dict(zip(ENERGIES, map(float, self._cpp_object.energies())))
        self._hourglass.add(values["internal"])
        own = self._hourglass.entry()
        self._energy = {**values, **own, "total": total_energy(values), "drift": self._history.drift(values)}

    # --- running ---------------------------------------------------------------------------------------------------

    def advance(
        self,
        until: float,
        dt: float | None = None,
        tolerance: float | None = None,
        smallest: float | None = None,
        callback: Callable[[NewmarkProblem], object] | None = None,
        progress: bool = True,
        rtol: float = 1e-10,
        atol: float = 0.0,
        max_iterations: int = 25,
        verbose: bool = False,
        update: Callable[[NewmarkProblem, float], object] | None = None,
        callback_every: int = 1,
    ) -> None:
        """Advance to a time. Collective.

        A step that does not converge is repeated with half its length, and so on down to `smallest`; later steps are
        longer again. An exception of the callback on one rank is raised on all ranks; after it, and after
        KeyboardInterrupt, the problem has the state of the last step.

        Args:
            until: time to advance to; a step ends there [T].
            dt: largest step, to be given; without `tolerance` all steps are equal unless one fails [T].
            tolerance: local error of a step's displacement, relative to the largest displacement so far, by which steps
                are chosen; None: they are not [1].
            smallest: smallest step; None: a thousandth of dt [T].
            callback: function that is called as callback(problem) after each step, or each of `callback_every`, and
                before the first step of a run (at step 0). The next step is solved for its end: what a callback sets
                for the present time comes a step late there. Functions of time belong into `update`.
            progress: whether rank 0 shows a progress bar.
            rtol: tolerance of the free residual, relative to the largest force in the step [1].
            atol: tolerance of the free residual [F].
            max_iterations: largest number of Newton iterations per step [1].
            verbose: whether rank 0 prints every iteration.
            update: function that is called as update(problem, time) before a step to `time` is solved, once more where
                it is repeated with another length, and for the start. What it sets, constants and functions of a
                residual of your own, values of loads, holds at this time, as in explicit runs. The state of the problem
                is still that of the last step.
            callback_every: steps between calls of `callback`, which come after the steps whose number is a multiple of
                it [1].

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: the time has passed, or a value is out of its range; an argument differs between ranks; on all
                ranks.
            RuntimeError: the call came from a callback of `advance`, or a step did not converge with the smallest
                length; on all ranks. The problem is then in its last converged state.
            KeyboardInterrupt: Ctrl-C, on all ranks.
        """
        with guard(self.comm, "advance", callback=callback, update=update) as ranks:
            until = self.stepper.calls.check(self.time, until, callback, update)
            self.read.check()
            if dt is None:
                raise TypeError("advance needs dt, the largest step [T]: implicit steps have no stable step to follow")
            dt = arguments.number("dt", dt, 0.0, " [T]")
            if tolerance is not None:
                tolerance = arguments.number("tolerance", tolerance, 0.0)
                if is_mixed(self.space):
                    raise ValueError(
                        "tolerance: the error of a step is relative to the largest displacement, and u has several "
                        "fields, in units of their own: give dt alone"
                    )
                if tolerance < SMALLEST_ERROR:
                    raise ValueError(
                        f"tolerance is {tolerance:g}: local errors below {SMALLEST_ERROR:g} of the displacement are "
                        "round-off, to which steps would be shortened in vain; take a larger one"
                    )
            if until > self.time and not STEPS[0] <= min(dt, until - self.time) <= STEPS[1]:
                raise ValueError(
                    f"dt is {dt:g}, the time to advance by {until - self.time:g}: steps from {STEPS[0]:g} to "
                    f"{STEPS[1]:g} [T] can be taken, whose squares are numbers; choose another unit of time"
                )
            smallest = SMALLEST * dt if smallest is None else arguments.number("smallest", smallest, 0.0, " [T]")
            if smallest > dt:
                raise ValueError(f"smallest is {smallest:g}: it must not be greater than dt = {dt:g}")
            if (until - self.time) / dt > MOST_STEPS or dt < np.spacing(until):
                raise ValueError(f"a step of {dt:g} takes too many steps to the time {until:g}; take a larger dt")
            max_iterations = arguments.integer("max_iterations", max_iterations, 1)
            every = arguments.integer("callback_every", callback_every, 1, unit=" [1]")
            rtol, atol = (arguments.tolerance(name, value) for name, value in (("rtol", rtol), ("atol", atol)))
            ranks.same(until=until, dt=dt, tolerance=tolerance, smallest=smallest, rtol=rtol, atol=atol,
                       max_iterations=max_iterations, callback_every=every)  # fmt: skip
        if until == self.time:
            return
        after = None if callback is None else lambda: callback(self)
        setting = None if update is None else lambda time: update(self, time)
        limits = StepLimits(dt, tolerance, smallest, rtol, atol, max_iterations)
        told = self._take_row, self._accepted
        self.stepper.advance(until, limits, after, every, setting, self.sample, *told, progress, verbose)
        self._hourglass.warn(stacklevel=3)
        self.linear_solver.warn_of_unused()

    @property
    def energy(self) -> dict[str, float]:
        """Energies at the present time: kinetic, internal, contact, friction, impact, damping, viscosity, plastic,
        external, total [F L] and drift [1]; docs/implicit/energies.md."""
        return dict(self._energy)

    # What a checkpoint asks of a problem in time, and implicit ones do not have.
    mass_scaling: float | None = None
    bulk_viscosity = (0.0, 0.0)

    @property
    def dead_loads(self) -> list[DeadLoad]:
        """None: all loads are forms."""
        return []

    # --- files -----------------------------------------------------------------------------------------------------

    def record(
        self,
        path: FilePath | None = None,
        fields: Sequence[str] = ("displacement", "velocity"),
        every: int = 1,
        points: ArrayLike | None = None,
        points_every: int = 1,
        times: Sequence[float] = (),
        expressions: Mapping[str, ufl.core.expr.Expr] | None = None,
        ending: str = ".bp",
        units: Units | None = None,
    ) -> Recorder:
        """Write fields and histories into a folder from now on; see Recorder. Collective.

        Args:
            path: folder; None as for RunFolder.
            fields: some of displacement, velocity, acceleration; of bodies stress, von_mises and the names of internal
                variables; of contacts pressure, gap, traction, shear_traction, slip, status.
            every: steps between frames [1].
            points: points, (n, gdim); the motion of their nearest nodes is sampled [L].
            points_every: steps between samples of points [1].
            times: times of frames, in place of `every`; steps end at these times exactly [T].
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
            ValueError: a field is unknown, an interval is no positive integer, or a time no number; on all ranks.
            RuntimeError: the folder cannot be written; on all ranks.
        """
        with guard(self.comm, "record", path=path, fields=fields, every=every, points_every=points_every) as ranks:
            options = output_options(expressions, ending, units)
            names, places = check_arguments(self, path, fields, every, points, points_every, options)
            moments = [arguments.number("times", t, unit=" [T]") for t in times]
            ranks.same(output=options, points=places, times=moments)
        output = self.stepper.recorders, self._cpp_object.stepper.show_motion
        return Recorder(self, *output, path, names, every, places, points_every, moments, "implicit", options)

    def reactions(self) -> fem.Function:
        """Forces of the supports on the bodies at prescribed degrees of freedom, zero elsewhere, at the present time:
        what inertia, damping and internal forces lack to loads and contact forces. Collective.

        Returns:
            Function on the displacement space [F].
        """
        r = fem.Function(self.space, name="reaction")
        support = self.stepper.energy_balance.forces.support
        r.x.array[: len(support)] = support
        r.x.scatter_forward()
        return r

    def save(self, path: FilePath) -> None:
        """Write a checkpoint in HDF5 with everything that a run needs to continue. Collective.

        The file is written as PATH.part and then renamed. If writing fails, an earlier file at `path` is not changed.
        Afterwards, recorders write their histories up to the present time.

        Args:
            path: file to write.

        Raises:
            TypeError: `path` is no name of a file; on all ranks.
            RuntimeError: the folder cannot be written, or no space is left; on all ranks.
        """
        self._restart.save(path)

    def restore(self, path: FilePath) -> None:
        """Continue from a checkpoint of the same problem, written on any number of ranks. Collective.

        The problem must have the same mesh, materials, damping, scheme, supports, loads and contacts, and the same
        functions of time up to the time of the checkpoint. The state is that of the file bit for bit if
        DOLFINx numbers the mesh in the same way. One rank then continues bit for bit; several continue to the solver's
        tolerance, as MUMPS does not sum in the same order twice.

        Args:
            path: file that `save` has written.

        Raises:
            TypeError: `path` is no name of a file; on all ranks.
            RuntimeError: the file cannot be read, or is damaged; on all ranks.
            ValueError: the file belongs to another mesh, material, ...; on all ranks. The problem is then unchanged.
        """
        self._restart.restore(path)
