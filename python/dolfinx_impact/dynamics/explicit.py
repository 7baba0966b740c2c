# SPDX-License-Identifier: MIT
"""Composes material, loads, prescribed motion and contact into an explicit problem; seed (3.67)-(3.80)."""

from __future__ import annotations

import functools
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING, Any

import numpy as np
import ufl
from dolfinx import fem

from .. import _cpp
from ..added_mass import AddedMass
from ..amplitude import Amplitude, PrescribedMotion
from ..assembly import problem_arguments
from ..assembly.body_stress import BodyStress
from ..assembly.fields import check_inertia
from ..assembly.material_history import MaterialHistory
from ..assembly.interior_facets import check_neighbours, has_interior_facets
from ..assembly.large_rotation import RotationWarning
from ..assembly.locking import warn_of_locking
from ..assembly.softening import warn_of_softening
from ..common.arguments import integer
from ..common.collective import comm_of, guard, same
from ..common.memory import free_garbage
from ..common.messages import LOG
from ..common.types import ArrayLike, BoolArray, FilePath, FloatArray
from ..common.unique import claim
from ..common.units import Units
from ..contact.general import named_pairs
from ..forms.compiler.frontend import check_kinds
from ..foundation import Foundation
from ..io.mesh_check import check_cells
from ..loads import DeadLoad, Load
from ..materials import MaterialMap, Rayleigh, _Material
from ..recording.output_options import output_options
from . import energy_gain, rolling_start, static_start
from .advance_calls import AdvanceCalls
from .current_state import CurrentState
from .explicit_bodies import ExplicitBodies
from .functions_of_time import FunctionsOfTime
from ..contact.names import named_apart
from .in_time import contacts_in_time, prescribed_motion
from .hourglass import HourglassEnergy
from .inputs import Inputs
from .penetration_share import PenetrationShare
from .precision import DOUBLE, MIXED, check_precision
from .read_once import ReadOnce
from .recorder import Recorder, check_arguments
from .restart import Restart
from .run_history import RunHistory
from .stable_step import METHODS
from .start_values import check_velocity, residual_bodies, velocity_or_rest
from .time_stepper import TimeStepper
from .transient_problem import TransientProblem

if TYPE_CHECKING:
    from ..contact.explicit.general import GeneralOutput
    from ..contact.general import GeneralContact
    from ..contact.explicit.nodal import Kinematic, NodalPair
    from ..contact.explicit.tied import ExplicitTie
    from ..contact.mortar.tie import Tie
    from ..contact.penalty.penalty import Penalty
    from ..rolling.rolling_problem import RollingProblem
    from ..statics.static_problem import StaticProblem

    ExplicitMethod = Penalty | Kinematic | Tie | GeneralContact


SEEN = 1e-12  # part of the kinetic energy that is more than round-off


class ExplicitProblem(TransientProblem):
    """Motion of bodies with lumped mass by central differences; docs/explicit/scheme.md has the equations.

    Args:
        u: displacement function. Its value is the initial displacement; the problem updates it [L].
        material: material or MaterialMap with densities; or give `residual` and `density`.
        residual: UFL residual of your own in u (rank 1): internal minus external forces. If it contains the function
            given as `velocity`, that function stands for the velocity half a step before, and the work of the terms
            with it counts as `damping`. Constants and other functions in it are read again after every callback.
        density: density per undeformed volume for a residual of your own: number, function or UFL expression,
            positive; a list with one of them for each field of a mixed space, or component of a vector; read once
            [M/L^3].
        velocity: initial velocity, a function on u's space; None: at rest. If the residual contains it, the problem
            updates it and it is the attribute `velocity`; otherwise it is not changed [L/T].
        bcs: DirichletBC (values are constant), PrescribedMotion (function of time), or a list of them.
        loads: load, or a list of them; their `amplitude` is a function of time.
        contact: contact, or a list of them: dolfinx_impact.Penalty(pair), dolfinx_impact.Kinematic(pair),
            dolfinx_impact.GeneralContact(facet_tags).
        damping: Rayleigh(alpha, beta) or None.
        bulk_viscosity: factors (linear, quadratic), for example (0.06, 1.2), or None [1].
        scheme: "half_step" (seed 3.72-3.77) or "classical" (seed 3.68-3.71).
        lumping: lumping scheme, as for lumped_mass.
        mass_scaling: step to which the stable step of cells is raised by added mass; None: no mass is added [T].
        hypothesis: for a residual of your own: "axisymmetric" if its integrals contain 2 pi r, otherwise None or
            another hypothesis.
        tangent: for a residual of your own: its derivative, a UFL form of rank 2, from which the stable step follows;
            None: UFL finds it. Needed where the residual reads a stress that a callback computes, as a function at
            quadrature points. The elastic tangent will do where the true one is never stiffer.
        precision: "double"; or "mixed", element forces of LinearElastic and NeoHookean in single precision, on twice
            the cells at once, all else in double (docs/mixed_precision.md).

    Attributes:
        u: displacement at the present time [L].
        velocity: velocity at the present time [L/T].
        acceleration: acceleration at the present time [L/T^2].
        contact: contacts with results.
        mass: lumped mass per degree of freedom [M].
        added_mass: mass that mass scaling has added, of all ranks [M].
        precision: of the element forces, "double" or "mixed".
        bulk_viscosity: factors (linear, quadratic) in force [1].
        residual_form: residual of your own, or None.
        given_density: density given with it, or None [M/L^3].
        dead_loads: loads that do not follow the body, as nodal forces.
        supports: prescribed owned degrees of freedom, their values [L] and the column of their function of time
            (-1: constant), for every support.
        prescribed: mask of prescribed degrees of freedom, owned and ghosts.
        num_owned: number of degrees of freedom that this rank owns [1].

    Raises:
        TypeError: an argument is of the wrong type; on all ranks.
        ValueError: a value does not fit, or differs between ranks; on all ranks.

    Warns:
        UserWarning: another ExplicitProblem with the same u exists; or materials with internal variables are on cells
            that lock.
    """

    _instead = "use save and restore, or make another one on a displacement function of its own"

    _cpp_object: _cpp.problems.ExplicitProblem

    def __init__(
        self,
        u: fem.Function,
        material: _Material | MaterialMap | None = None,
        residual: ufl.Form | None = None,
        density: float | ufl.core.expr.Expr | Sequence[float | ufl.core.expr.Expr] | None = None,
        velocity: fem.Function | None = None,
        bcs: fem.DirichletBC | PrescribedMotion | Sequence[fem.DirichletBC | PrescribedMotion] = (),
        loads: Load | Sequence[Load] = (),
        contact: Penalty | Kinematic | Tie | GeneralContact | Sequence[Penalty | Kinematic | Tie | GeneralContact] = (),
        damping: Rayleigh | None = None,
        bulk_viscosity: tuple[float, float] | None = None,
        scheme: str = "half_step",
        lumping: str = "auto",
        mass_scaling: float | None = None,
        hypothesis: str | None = None,
        tangent: ufl.Form | None = None,
        precision: str = DOUBLE,
    ) -> None:
        with guard(comm_of(u, velocity, residual, bcs, material, loads, contact), "ExplicitProblem") as ranks:
            if residual is not None and density is None:
                raise ValueError("a residual of your own needs a density")
            if material is not None and (density is not None or hypothesis is not None):
                raise ValueError("density and hypothesis are those of the material: give them there")
            axisymmetric = hypothesis == "axisymmetric"
            bcs, loads, contact = problem_arguments.lists(bcs, loads, contact)
            given = problem_arguments.problem(
                u, material, residual, bcs, loads, contact, axisymmetric, explicit=True, tangent=tangent
            )
            pairs = named_pairs(contact)
            check_velocity(velocity, u)
            own: Any = None
            if residual is not None:
                own = residual_bodies(u.function_space, hypothesis, density)
                check_inertia(own.density_constant(u.function_space.mesh), u.function_space, True, lumping)
                check_kinds("the residual", residual)
            if damping is not None and not isinstance(damping, Rayleigh):
                raise TypeError(f"damping must be Rayleigh(alpha, beta) or None, found {type(damping).__name__}")
            if scheme not in ("half_step", "classical"):
                raise ValueError(f"scheme {scheme!r} is unknown: use 'half_step' or 'classical'")
            check_precision(precision, u, material)
            ranks.same(**given, density=density, damping=damping, bulk_viscosity=bulk_viscosity, scheme=scheme,
                       precision=precision, lumping=lumping, mass_scaling=mass_scaling, hypothesis=hypothesis,
                       velocity_given=velocity is not None)  # fmt: skip
        velocity = velocity_or_rest(velocity, u)
        self.u, self.space, self.material = u, u.function_space, material
        self._stress = BodyStress(u, material)
        V, mesh = self.space, self.space.mesh
        self.comm, self.num_owned = mesh.comm, V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        free_garbage(self.comm, V.dofmap.index_map.size_global * V.dofmap.index_map_bs)
        self.damping, self.scheme = damping or Rayleigh(), scheme
        self.lumping, self.mass_scaling, self.precision = lumping, mass_scaling, precision
        self.loads, self.residual_form, self.given_density = tuple(loads), residual, density
        check_cells(mesh)
        if residual is not None and has_interior_facets(residual):
            check_neighbours(mesh._cpp_object)
        claim(u, self, explicit=True)
        if material is not None:
            warn_of_locking(u, material)
            warn_of_softening(u, material)
        self._bodies = bodies = ExplicitBodies(
            u,
            velocity,
            material,
            residual,
            tangent,
            own,
            hypothesis,
            self.loads,
            scheme,
            lumping,
            mixed=precision == MIXED,
        )
        self.axisymmetric = bodies.hypothesis == "axisymmetric"
        self._frequencies = bodies.frequencies
        self.prescribed: BoolArray = np.zeros(len(u.x.array), dtype=bool)
        for bc in bcs:
            self.prescribed[(bc.bc if isinstance(bc, PrescribedMotion) else bc).dof_indices()[0]] = True
        if residual is not None:
            bodies.check_signs(self.prescribed[: self.num_owned])
        bodies.assemble_mass(mass_scaling)
        self.mass, self.added_mass = bodies.mass, bodies.added_mass
        self.bulk_viscosity = self._check_viscosity(bulk_viscosity)
        self.velocity, self.acceleration = bodies.motion_velocity, fem.Function(V, name="acceleration")
        bodies.add_damping(self.damping, self.bulk_viscosity)
        bodies.add_foundations()
        parts = bodies.parts
        self._material_history = None if parts is None else MaterialHistory(parts, bodies.internal.history)
        functions = FunctionsOfTime()
        dead = self._make_loads(functions)
        motions = [prescribed_motion(bc, functions) for bc in bcs]
        self.named_pairs = pairs
        bound = [c._bind_explicit(self) for c in named_apart(contact)]
        self.contact: tuple[NodalPair | ExplicitTie | GeneralOutput, ...] = tuple(bound)
        alpha, beta = self.damping.alpha, self.damping.beta
        uniform = _cpp.problems.UniformDamping(alpha, beta, self.bulk_viscosity[0])
        self._cpp_object = _cpp.problems.ExplicitProblem(
            u._cpp_object, self.velocity._cpp_object, self.acceleration._cpp_object,
            bodies.body(uniform), motions, dead,
            contacts_in_time(self.contact, functions), getattr(_cpp.integrators.Scheme, scheme),
        )  # fmt: skip
        self.supports = self._cpp_object.supports.parts
        integrator, safe = self._cpp_object.integrator, self._cpp_object.safe_step
        inputs = Inputs(self.comm, integrator, bodies.terms, self.dead_loads, bodies.frequencies, safe.changes)
        self._history = RunHistory(len(self.contact), mesh.geometry.dim, self._cpp_object.history)
        # Springs between rigid bodies are among those of contacts, and nothing deforms beside them: no share is judged.
        met = [c.pair.rigid_body.meets for c in self.contact if c.pair.rigid_body is not None]
        share = PenetrationShare(
            u, material, self.loads, [c.is_penalty and not any(met) for c in self.contact],
            from_rest=not bodies.linear and not self.has_history,
        )  # fmt: skip
        self._state = CurrentState(
            self._cpp_object, u, self.velocity, self.acceleration, self.contact, self._history, share,
            HourglassEnergy(u, material, self._material_history),
            ReadOnce(self._cpp_object.supports, self.contact),
        )  # fmt: skip
        self._calls = AdvanceCalls()
        self._stepper = TimeStepper(
            self._cpp_object, mesh, functions, inputs, self._state, RotationWarning(material), self.unsolved_points,
        )  # fmt: skip
        if residual is not None:
            stiffness_of_mass = self.mass.array[: self.num_owned] * (2.0 / safe.value) ** 2
            integrator.release_limit = energy_gain.release_limit(V, stiffness_of_mass)
        self._restart = Restart(self, self._stepper)
        self._stepper.start()
        self._tell_of_ties()
        _cpp.integrators.release_memory()

    def _tell_of_ties(self) -> None:
        """Log the energy of initial velocities that contradict ties, on rank 0."""
        lost = float(self._cpp_object.lost_at_start)
        kinetic = self.energy["kinetic"]
        if lost > SEEN * kinetic and self.comm.rank == 0:
            LOG.warning(
                "the velocity at the start moves tied surfaces apart: what contradicts the ties was removed, and "
                "%.3g of a kinetic energy of %.3g with it",
                lost,
                lost + kinetic,
            )

    # --- set-up ----------------------------------------------------------------------------------------------------

    @classmethod
    def from_rolling(cls, rolling: RollingProblem, penalty: float | str = "auto", **given: Any) -> ExplicitProblem:
        """A run that goes on from a state of steady rolling, without settling. Collective.

        Its nodes move with the material, in the frame of the rolling problem: displacement and velocity of the
        material, supports that move on with their bodies, penalty contact of the same pair. The springs begin with the
        steady tractions of friction, and with the steady force: the slave body, with its supports, is moved against the
        master by what the springs yield. `u` of the rolling problem is not changed. docs/rolling.md.

        Args:
            rolling: steady state, solved.
            penalty: of the contact, as in Penalty [F/L^3].
            given: further arguments of ExplicitProblem: damping, bulk_viscosity, mass_scaling, ...; `bcs` instead of
                the moving supports, `loads`.

        Returns:
            The problem at time zero.

        Raises:
            TypeError: `rolling` is no RollingProblem, or an argument is given by it; on all ranks.
            ValueError: a spinning body whose law takes a turn for a strain, loads that are not given, several contacts,
                supports that cannot turn; or what ExplicitProblem refuses; on all ranks.
            RuntimeError: the springs do not bear the steady force; on all ranks.
        """
        comm = comm_of(getattr(rolling, "u", None))
        with guard(comm, "ExplicitProblem.from_rolling", penalty=penalty):
            rolling_start.check(rolling, given)
        return rolling_start.make(cls, rolling, penalty, given)

    @classmethod
    def from_static(cls, static: StaticProblem, **given: Any) -> ExplicitProblem:
        """A run that begins with the displacement, the history of the materials and the contact forces of an
        equilibrium. Collective.

        Contacts by multipliers have no penetration, penalty springs need one: bodies that press are moved against their
        master until the springs bear the static force, and the springs begin with the static forces of the nodes.
        docs/explicit/penalty.md. `u` of the static problem is not changed.

        Args:
            static: equilibrium, solved.
            given: arguments of ExplicitProblem besides u and material: `contact`, one Penalty for each contact of the
                static problem and of the same surfaces, bcs, loads, velocity (default: at rest), ...

        Returns:
            The problem at time zero.

        Raises:
            TypeError: `static` is no StaticProblem, an argument is given by it, or a contact is no Penalty; on all
                ranks.
            ValueError: contacts of other surfaces, a residual of one's own, or what ExplicitProblem refuses; on all
                ranks.
            RuntimeError: the springs do not bear the static force; on all ranks.
        """
        with guard(comm_of(getattr(static, "u", None)), "ExplicitProblem.from_static"):
            static_start.check(static, given)
        return static_start.make(cls, static, given)

    @property
    def contact_step(self) -> float:
        """Step for which contact springs that follow from it are made: 0.9 of the stable one at the start, or a longer
        one that was taken [T]."""
        return float(self._cpp_object.integrator.contact_step)

    def restart_forces(self, equilibrium: _cpp.solve.EquilibriumProblem | None = None) -> None:
        """Compute the forces of the start once more, after contacts have got a history. Collective.

        Args:
            equilibrium: bodies and contacts in equilibrium, whose internal variables the materials and whose forces the
                springs begin with; bodies that press are moved against their master for it. None: there is none.

        Raises:
            RuntimeError: the springs do not bear the static force; on all ranks.
        """
        self._stepper.start(equilibrium)

    def __repr__(self) -> str:
        size = self.space.dofmap.index_map.size_global * self.space.dofmap.index_map_bs
        what = "residual of its own" if self.material is None else repr(self.material)
        parts = f"{len(self.loads)} loads, {len(self.contact)} contacts"
        return f"ExplicitProblem({size} unknowns, {what}, {parts}, step {self.step}, time {self.time:g})"

    def _check_viscosity(self, factors: tuple[float, float] | None) -> tuple[float, float]:
        if factors is None:
            return (0.0, 0.0)
        if np.shape(factors) != (2,) or not np.all(np.isfinite(factors)) or np.any(np.asarray(factors) < 0):
            raise ValueError(
                f"bulk_viscosity is {factors!r}: give two factors that are not negative, linear, quadratic"
            )
        if self.material is None:
            raise ValueError("bulk viscosity needs the wave speed of a material: write it into your own residual")
        linear, quadratic = factors
        return float(linear), float(quadratic)

    def _make_loads(self, functions: FunctionsOfTime) -> list[_cpp.problems.LoadInTime]:
        """Loads that do not follow the body, for the C++ side; those that do become terms of the bodies.

        Args:
            functions: receives the amplitudes.
        """
        self.dead_loads: list[DeadLoad] = []
        out = []
        for load in self.loads:
            if isinstance(load, (Foundation, AddedMass)):
                continue  # parts of the bodies
            form = load.form(self.u, ufl.TestFunction(self.space), self._bodies.bodies)
            amplitude = Amplitude(getattr(load, "amplitude", None), f"amplitude of {type(load).__name__}")
            if self.u in form.coefficients():
                if getattr(load, "amplitude", None) is not None:
                    raise ValueError(f"{type(load).__name__} follows the body: it takes no amplitude")
                self._bodies.add(form, _cpp.integrators.WorkKind.external)
                continue
            dead = DeadLoad(load, form, self.space)
            functions.add(amplitude)
            out.append(_cpp.problems.LoadInTime(dead.dofs, dead.values(), np.ones(1)))
            self.dead_loads.append(dead)
        return out

    # --- running ---------------------------------------------------------------------------------------------------

    def advance(
        self,
        until: float,
        dt: float | str = "auto",
        callback: Callable[[ExplicitProblem], object] | None = None,
        progress: bool = True,
        unsafe: bool = False,
        energy_limits: tuple[float, float] | None = energy_gain.LIMITS,
        update: Callable[[ExplicitProblem, float], object] | None = None,
        callback_every: int = 1,
    ) -> None:
        """Advance to a time. Collective.

        An exception of the callback on one rank is raised on all ranks. After it, and after KeyboardInterrupt, the
        problem has the state of the last step: it may be saved, and `advance` to the same time continues with the
        remaining steps.

        Args:
            until: time to advance to [T].
            dt: largest step; "auto": 0.9 of the stable step. All steps are equal [T].
            callback: function that is called as callback(problem) after each step, or each of `callback_every`, and
                before the first step of a run (at step 0). Its changes of constants, functions and loads are in force
                from the time at which it is called; the problem updates their ghosts.
            progress: whether rank 0 shows a progress bar.
            unsafe: accept a dt beyond the stable step, with a warning.
            energy_limits: two limits for the energy that the run has gained without the work of loads and supports,
                relative to the energies so far (docs/explicit/energies.md). Beyond the first the run warns, once;
                beyond the second it stops. None: no limits [1].
            update: function that is called as update(problem, time) before the forces of a time are computed, the start
                included, and before `callback`. What it sets, constants and functions of a residual of your own, values
                of loads, holds at this time, as in implicit runs.
            callback_every: steps between calls of `callback`, which come after the steps whose number is a multiple of
                it. Each call brings functions, energies and contact results up to date, which takes about as long as a
                step [1].

        Raises:
            TypeError: an argument is of the wrong type.
            ValueError: the time has passed; `callback_every` is not positive; dt is not positive, beyond the stable
                step, or so small that the time cannot be reached; the energy limits are not two positive numbers in
                increasing order; an argument differs between ranks.
            RuntimeError: the call came from a callback of `advance`; or the run went unstable or gained energy beyond
                the limit. The message says when and where. Displacement and velocity are then those of the last good
                state; works are zero and friction has no history there.
            KeyboardInterrupt: Ctrl-C, on all ranks after the same step, once the callback has returned.
        """
        with guard(self.comm, "advance", callback=callback, update=update, unsafe=bool(unsafe)) as ranks:
            until, limits = self._calls.check(self.time, until, callback, update), energy_gain.checked(energy_limits)
            every = integer("callback_every", callback_every, 1, unit=" [1]")
            self._stepper.check_unchanged()
            ranks.same(until=until, dt=dt, energy_limits=limits, callback_every=every)
        if until == self.time:
            return
        with self._calls.running():
            first = self._called(self._calls.at_present(None if self.step > 0 else callback, update))
            each = self._called(self._calls.at_present(callback, update, every))
            pause = every if update is None else 1
            self._stepper.advance(until, dt, first, each, pause, progress, unsafe, limits)

    def _called(self, function: Callable[[ExplicitProblem], object] | None) -> Callable[[], object] | None:
        """A function of this problem as one without arguments; None stays None."""
        return None if function is None else functools.partial(function, self)

    @property
    def energy(self) -> dict[str, float]:
        """Energies at the present time: kinetic, internal, contact, friction, impact, damping, viscosity, plastic,
        external, total [F L] and drift [1], docs/explicit/energies.md; of bodies with integration="reduced" hourglass,
        a part of internal [F L], docs/one_point.md."""
        return dict(self._state.energy)

    def unsolved_points(self) -> str:
        """Which local equations the last evaluation could not solve; an empty text if all were. Collective."""
        return self._bodies.internal.fault() or self._cpp_object.unsolved()

    @property
    def history_limit(self) -> int:
        """Largest number of history rows in memory, 250,000 unless set; a Recorder writes all rows [1]."""
        return self._history.limit

    @history_limit.setter
    def history_limit(self, value: int) -> None:
        """Set the largest number of history rows in memory.

        Args:
            value: number of rows, two or more [1].

        Raises:
            ValueError: the value is no integer, or less than two.
        """
        self._history.limit = value

    # --- files -----------------------------------------------------------------------------------------------------

    def record(
        self,
        path: FilePath | None = None,
        fields: Sequence[str] = ("displacement", "velocity"),
        every: int = 100,
        points: ArrayLike | None = None,
        points_every: int = 10,
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
            ValueError: a field is unknown, or an interval is no positive integer; on all ranks.
            RuntimeError: the folder cannot be written; on all ranks.
        """
        with guard(self.comm, "record", path=path, fields=fields, every=every, points_every=points_every) as ranks:
            options = output_options(expressions, ending, units)
            names, places = check_arguments(self, path, fields, every, points, points_every, options)
            ranks.same(output=options, points=places)
        output = self._stepper.recorders, self._state.update_functions
        return Recorder(self, *output, path, names, every, places, points_every, options=options)

    def reactions(self) -> fem.Function:
        """Forces of the supports on the bodies at prescribed degrees of freedom, zero elsewhere, at the present time:
        what inertia, damping and internal forces lack to loads and contact forces. Those of kinematic contact are of
        the last step. Collective.

        Returns:
            Function on the displacement space [F].
        """
        r = fem.Function(self.space, name="reaction")
        r.x.array[: self.num_owned] = self._cpp_object.integrator.support_forces()
        r.x.scatter_forward()
        return r

    def save(self, path: FilePath) -> None:
        """Write a checkpoint in HDF5 with everything that a run needs to continue. Collective.

        The file is written as PATH.part and then renamed. If writing fails, an earlier file at `path` is not changed.
        Afterwards, recorders write their histories up to the present time. Ctrl-C takes effect after that.

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
        functions of time up to the time of the checkpoint, to round-off. The values of loads (`constant.value`) must be
        those at the time when the file was written; they may be changed afterwards, as between any two calls of
        `advance`. The file does not contain constants, functions and loads that were changed during the run: set them
        before.

        On the number of ranks that wrote the file, the run continues bit for bit if DOLFINx numbers the mesh in the
        same way, which is not always so on three or more ranks. On another number of ranks it continues to round-off.
        After an interrupted `advance`, `advance` to the same time continues with the remaining steps.

        Args:
            path: file that `save` has written.

        Raises:
            TypeError: `path` is no name of a file; on all ranks.
            RuntimeError: the file cannot be read, or is damaged; on all ranks.
            ValueError: the file belongs to another mesh, material, ...; on all ranks. The problem is then unchanged.
        """
        self._restart.restore(path)

    # --- the stable step -------------------------------------------------------------------------------------------

    def stable_step(self, method: str = "element") -> float:
        """Largest stable step at the present state. Collective.

        Contact springs of given stiffness reduce the step. For "length" and "element" they do so by a bound that holds
        wherever the bodies meet; for "eigenvalue" the system contains the springs of all slave nodes that have a master
        now, closed or not.

        Args:
            method: "length": L/c_d, seed (3.79), (3.80), an estimate that may be too large for distorted cells;
                "element": lower bound of the true limit, from the highest frequency of the cells; "eigenvalue": the
                true limit, from the highest frequency of the assembled system.

        Returns:
            Stable step; infinite where nothing limits it [T].

        Raises:
            ValueError: the method is unknown, or "length" for a residual of your own.
            RuntimeError: the eigenvalue solver does not converge.
        """
        same(self.comm, "stable_step", method=method)
        if method not in METHODS:
            raise ValueError(f"method {method!r} is unknown: use one of {', '.join(METHODS)}")
        if method == "length" and self.material is None:
            raise ValueError("L/c_d needs a material: use method 'element' or 'eigenvalue'")
        self._frequencies.update()
        return float(self._cpp_object.stable_step(getattr(_cpp.problems.StableStepMethod, method)))

    def frequencies_by_cell(self, only: BoolArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Largest eigenvalues of owned cells at the present state; see Frequencies.by_cell. Collective.

        Args:
            only: mask of the cells that are asked for; None: all.

        Returns:
            Squares of the highest angular frequencies [1/T^2], eigenvalues of damping over mass [1/T].

        Raises:
            ValueError: the stiffness of a cell is not finite; on all ranks.
        """
        return self._frequencies.by_cell(only)

    def steps_by_cell(self, squares: FloatArray, rates: FloatArray) -> FloatArray:
        """Stable steps of cells, contact springs included.

        Args:
            squares: squares of their highest angular frequencies, (n) [1/T^2].
            rates: largest eigenvalues of damping over mass, (n) [1/T].

        Returns:
            Steps, infinite where nothing limits them, (n) [T].
        """
        steps: FloatArray = self._cpp_object.safe_step.steps(squares, rates)
        return steps
