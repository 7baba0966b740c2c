# SPDX-License-Identifier: MIT
"""Composes material, loads, prescribed motion and contact into an explicit problem; seed (3.67)-(3.80)."""

import math
from collections.abc import Callable

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from mpi4py import MPI
from ufl.algorithms import expand_derivatives

from .. import _cpp
from ..common import arguments
from ..assembly import operators, problem_arguments
from ..assembly import lumped_mass as lumps
from ..amplitude import Amplitude, PrescribedMotion
from ..common.collective import comm_of, guard, same
from ..contact.explicit.springs import stiffness
from ..forms import elasticity, viscosity
from ..forms import materials as laws
from ..loads import DeadLoad
from ..common.arguments import number
from ..materials import Rayleigh
from ..io.mesh_check import check_cells
from ..assembly.residual import check_radius, split
from . import energy_gain
from .current_state import CurrentState
from .functions_of_time import FunctionsOfTime
from .inputs import Inputs
from .recorder import Recorder, check_arguments
from .restart import Restart
from .run_history import RunHistory
from .stable_step import METHODS, Frequencies, cell_sizes, damped
from .time_stepper import TimeStepper
from ..common.unique import Unique, claim


class ExplicitProblem(Unique):
    """Motion of bodies under lumped mass by central differences; docs/explicit/scheme.md has the equations.

    Args:
        u: displacement function; its value is the start and follows the run [L].
        material: material or MaterialMap with densities; or give `residual` and `density`.
        residual: UFL residual of your own in u (rank 1): internal less external forces. Where it contains the function
            given as `velocity` this stands for the velocity half a step before; that part resists, its work is
            `damping`. Constants and other functions of it are read anew after every callback.
        density: for a residual of your own: number, function or UFL expression per reference volume, positive; read
            once [M/L^3].
        velocity: function on u's space at the start [L/T]. A residual that contains it makes it follow the run as u
            does: then it is the attribute `velocity` as well. Else it stays as it is.
        bcs: list of DirichletBC (values stay) and PrescribedMotion (functions of time).
        loads: list of loads; their `amplitude` is a function of time.
        contact: list of contacts: dolfinx_impact.Penalty(pair), dolfinx_impact.Kinematic(pair).
        damping: Rayleigh(alpha, beta) or None.
        bulk_viscosity: pair (linear, quadratic) of factors, for example (0.06, 1.2), or None [1].
        scheme: "half_step" (seed 3.72-3.77) or "classical" (seed 3.68-3.71).
        lumping: as for lumped_mass. mass_scaling: None, or the step that cells with a smaller one of their own get mass
            for [T]; `added_mass` tells how much.
        hypothesis: of a residual of your own: "axisymmetric" where its integrals carry 2 pi r; None or another one
            where they do not.

    Attributes:
        time [T], step: reached. velocity, acceleration: functions at that time. contact: with results. mass: lumped,
        per degree of freedom [M]. added_mass: by mass scaling, in all [M].

    Raises:
        TypeError, ValueError: what does not fit, or differs between ranks; on all ranks.

    Warns:
        UserWarning: another ExplicitProblem that is alive has the same u.
    """

    _instead = "use save and restore, or make another one on a displacement function of its own"

    def __init__(
        self,
        u,
        material=None,
        residual=None,
        density=None,
        velocity=None,
        bcs=(),
        loads=(),
        contact=(),
        damping=None,
        bulk_viscosity=None,
        scheme="half_step",
        lumping="auto",
        mass_scaling=None,
        hypothesis=None,
    ):
        with guard(comm_of(u, velocity, residual, bcs, material, loads, contact), "ExplicitProblem") as ranks:
            if residual is not None and (loads or density is None):
                what = "write the loads into your own residual" if loads else "a residual of your own needs a density"
                raise ValueError(what)
            if material is not None and (density is not None or hypothesis is not None):
                raise ValueError("density and hypothesis are those of the material: give them there")
            axisymmetric = hypothesis == "axisymmetric"
            given = problem_arguments.problem(u, material, residual, bcs, loads, contact, axisymmetric, explicit=True)
            self._check_velocity(velocity, u)
            if damping is not None and not isinstance(damping, Rayleigh):
                raise TypeError(f"damping must be Rayleigh(alpha, beta) or None, found {type(damping).__name__}")
            if scheme not in ("half_step", "classical"):
                raise ValueError(f"scheme {scheme!r} is unknown: use 'half_step' or 'classical'")
            ranks.same(**given, density=density, damping=damping, bulk_viscosity=bulk_viscosity, scheme=scheme,
                       lumping=lumping, mass_scaling=mass_scaling, hypothesis=hypothesis)  # fmt: skip
        self.u, self.space, self.material = u, u.function_space, material
        V, mesh = self.space, self.space.mesh
        self.comm, self.num_owned = mesh.comm, V.dofmap.index_map.size_local * V.dofmap.index_map_bs
        self.damping, self.scheme = damping or Rayleigh(), scheme
        self.lumping, self.mass_scaling = lumping, mass_scaling
        self.loads, self._residual_form, self._given_density = list(loads), residual, density
        check_cells(mesh)
        claim(u, self, explicit=True)
        v, du = ufl.TestFunction(V), ufl.TrialFunction(V)
        resisting = damping_tangent = None
        if residual is None:
            hypothesis = material.hypothesis_on(mesh)
            internal = operators.internal_force_form(u, v, material)
            tangent = operators.tangent_form(u, du, v, material)
            linear = all(m.law(mesh).linear for _, m in material.parts())
            parts, tags = [(t, m.mass_density(mesh)) for t, m in material.parts()], material.cell_tags
        else:
            if hypothesis is not None:
                laws.check_hypothesis(hypothesis, mesh.geometry.dim)
            internal, resisting = split(residual, velocity)
            tangent, linear = expand_derivatives(ufl.derivative(internal, u, du)), False
            if resisting is not None:
                if scheme == "classical":
                    raise ValueError(
                        "the residual contains the velocity: scheme 'classical' takes mass-proportional damping only"
                    )
                damping_tangent = expand_derivatives(ufl.derivative(resisting, velocity, du))
            parts, tags = [(None, self._density(density, mesh))], None
        self.axisymmetric = hypothesis == "axisymmetric"
        self._frequencies = Frequencies(
            u, tangent, lambda: lumps.cell_masses(V, parts, hypothesis or "3d", tags, lumping), damping_tangent,
            velocity,
        )  # fmt: skip
        tangents = [t for t in (tangent, damping_tangent) if t is not None]
        self._nonlinear = any(c is u or c is velocity for t in tangents for c in t.coefficients())
        if residual is not None:
            if hypothesis in (None, "axisymmetric"):
                check_radius(self._frequencies.stiffness, u, self.axisymmetric)
            self._frequencies.check_signs()
        self.added_mass = 0.0 if mass_scaling is None else self._scale_mass(number("mass_scaling", mass_scaling, 0.0))
        self.mass = lumps.assemble_masses(V, self._frequencies_masses(), lumping)
        self._viscosity = self._check_viscosity(bulk_viscosity)
        self._internal = operators.SplitForce(internal, u)
        self._cpp_object = _cpp.integrators.CentralDifference(
            V._cpp_object, self._internal.forces(), linear, self.mass.array, self.damping.alpha,
            getattr(_cpp.integrators.Scheme, scheme),
        )  # fmt: skip
        self._terms = [self._internal]
        if resisting is None:
            self.velocity = fem.Function(V, name="velocity")
            self.velocity.x.array[:] = velocity.x.array
        else:
            self.velocity = velocity
            self._term(resisting, _cpp.integrators.WorkKind.damping)
        self.acceleration = fem.Function(V, name="acceleration")
        self._add_damping(v)
        self._functions = FunctionsOfTime()
        self._set_loads(self.loads, v)
        self._set_motion(bcs)
        self.contact = [c._bind_explicit(self) for c in contact]
        for c in self.contact:
            motion = c.motion
            columns = [-1] * 3 if motion is None else self._functions.add(motion)
            self._cpp_object.add_contact(c._cpp_object, columns)
        inputs = Inputs(self.comm, self._cpp_object, self._terms, self._loads, self._frequencies)
        self._history = RunHistory(len(self.contact), mesh.geometry.dim)
        self._state = CurrentState(
            self._cpp_object, u, self.velocity, self.acceleration, self.contact, self._history
        )  # fmt: skip
        self._stepper = TimeStepper(self, self._functions, inputs, self._state, self._history, self._nonlinear)
        self._restart = Restart(self, self._stepper)
        self._stepper.start(u.x.array[: self.num_owned], self.velocity.x.array[: self.num_owned])
        _cpp.integrators.release_memory()

    # --- set-up ----------------------------------------------------------------------------------------------------

    def __repr__(self):
        size = self.space.dofmap.index_map.size_global * self.space.dofmap.index_map_bs
        what = "residual of its own" if self.material is None else repr(self.material)
        parts = f"{len(self.loads)} loads, {len(self.contact)} contacts"
        return f"ExplicitProblem({size} unknowns, {what}, {parts}, step {self.step}, time {self.time:g})"

    @staticmethod
    def _check_velocity(velocity, u):
        if velocity is None:
            raise ValueError("give the velocity at the start: a Function on u's space (zero: fem.Function(V))")
        arguments.function("velocity", velocity)
        if velocity is u:
            raise ValueError("displacement and velocity are one function: give two")
        V, W = u.function_space, velocity.function_space
        if W.element != V.element or W.mesh != V.mesh:
            raise ValueError("the velocity is on another space than the displacement")
        if not all(np.all(np.isfinite(f.x.array)) for f in (u, velocity)):
            raise ValueError("displacement or velocity at the start is not a number")

    def _density(self, density, mesh):
        if isinstance(density, ufl.core.expr.Expr):
            return density
        return fem.Constant(mesh, default_scalar_type(number("density", density, 0.0, " [M/L^3]")))

    def _frequencies_masses(self):
        masses = self._frequencies.masses()
        return [(np.arange(len(masses), dtype=np.int32), masses)]

    def _scale_mass(self, dt):
        """Mass for cells whose own stable step is less than dt; returns how much, of all ranks. Collective."""
        f = self._frequencies
        squares, rates = f.by_cell()
        factor = np.maximum(1.0, squares * (dt / 2.0) ** 2 + rates * (dt / 2.0))
        added = self.comm.allreduce(float((factor - 1.0) @ f.masses().sum(axis=1)), MPI.SUM)
        f.factor = factor
        return added / self.space.mesh.geometry.dim

    def _check_viscosity(self, factors):
        if factors is None:
            return (0.0, 0.0)
        if np.shape(factors) != (2,) or not np.all(np.isfinite(factors)) or np.any(np.asarray(factors) < 0):
            raise ValueError(
                f"bulk_viscosity is {factors!r}: give two factors that are not negative, linear, quadratic"
            )
        if self.material is None:
            raise ValueError("bulk viscosity needs the wave speed of a material: write it into your own residual")
        return tuple(float(f) for f in factors)

    def _add_damping(self, v):
        kinds = _cpp.integrators.WorkKind
        if self.damping.beta > 0.0:
            if self.scheme == "classical":
                raise ValueError("scheme 'classical' takes mass-proportional damping only: its matrix must be diagonal")
            if self.material is None:
                raise ValueError("stiffness-proportional damping needs a material: write it into your own residual")
            beta = fem.Constant(self.space.mesh, default_scalar_type(self.damping.beta))
            form = operators._sum(
                self.u, self.material, lambda law, dx: beta * elasticity.tangent(self.u, self.velocity, v, law, dx)
            )
            self._term(form, kinds.damping)
        if any(self._viscosity):
            mesh = self.space.mesh
            factors = [fem.Constant(mesh, default_scalar_type(f)) for f in self._viscosity]
            form = operators.sum_materials(
                self.u, self.material,
                lambda m, dx: viscosity.bulk(
                    self.u, self.velocity, v, m.law(mesh), m.density_constant(mesh), *factors, dx
                ),
            )  # fmt: skip
            self._term(form, kinds.viscosity)

    def _term(self, form, account):
        term = operators.SplitForce(form, self.u, self.velocity)
        self._terms.append(term)
        self._cpp_object.add_term(term.forces(), account)

    def _set_loads(self, loads, v):
        self._loads = []
        for load in loads:
            form = load.form(self.u, v, self.material)
            amplitude = Amplitude(getattr(load, "amplitude", None), f"amplitude of {type(load).__name__}")
            if self.u in form.coefficients():
                if getattr(load, "amplitude", None) is not None:
                    raise ValueError(f"{type(load).__name__} follows the body: it takes no amplitude")
                self._term(form, _cpp.integrators.WorkKind.external)
                continue
            dead = DeadLoad(load, form, self.space)
            self._cpp_object.add_load(dead.dofs, dead.values(), self._functions.add(amplitude)[0])
            self._loads.append(dead)

    def _set_motion(self, bcs):
        taken, self._supports = np.zeros(len(self.u.x.array), dtype=bool), []
        for bc in bcs:
            amplitude = bc.amplitude if isinstance(bc, PrescribedMotion) else None
            bc = bc.bc if amplitude else bc
            dofs = bc.dof_indices()[0]
            dofs = dofs[(dofs < self.num_owned) & ~taken[dofs]]
            taken[dofs] = True
            values = np.zeros(len(self.u.x.array))
            bc.set(values)
            column = -1 if amplitude is None else self._functions.add(amplitude)[0]
            start = values[dofs] * (1.0 if amplitude is None else amplitude.sample([0.0])[0, 0])
            jump = float(np.max(np.abs(start - self.u.x.array[dofs]), initial=0.0))
            size = self.comm.allreduce(float(np.max(np.abs(start), initial=0.0)), MPI.MAX)
            if self.comm.allreduce(jump, MPI.MAX) > 1e-12 * size:
                raise ValueError(
                    "a prescribed displacement jumps at the start: let u have its value, or use PrescribedMotion with "
                    "an amplitude that begins where u is"
                )
            self._cpp_object.prescribe(dofs.astype(np.int32), values[dofs], column)
            self._supports.append((dofs, values[dofs], column))
        self.prescribed = taken

    # --- running ---------------------------------------------------------------------------------------------------

    def advance(
        self,
        until: float,
        dt: float | str = "auto",
        callback: Callable[["ExplicitProblem"], None] | None = None,
        progress: bool = True,
        unsafe: bool = False,
        energy_limits: tuple[float, float] | None = energy_gain.LIMITS,
    ) -> None:
        """Go on to a time. Collective.

        Args:
            until: time to reach [T].
            dt: step, or "auto": 0.9 of the stable step; steps are equal and at most that [T].
            callback: called as callback(problem) after each step, and before the first step of a run (at step 0). What
                it changes, constants, functions and loads of forms, holds from the time at which it is called; ghosts
                are brought up to date.
            progress: show a bar on rank 0.
            unsafe: take a dt beyond the stable step all the same, with a warning.
            energy_limits: two numbers, or None for no limits. The energy that the run has gained without the work of
                loads and supports, relative to the energies so far (docs/explicit/energies.md): beyond the first it
                warns, once; beyond the second it stops [1].

        Raises:
            TypeError, ValueError: a time that has passed, dt not positive, beyond the stable step, or so small that the
                time cannot be reached; energy limits that are no two positive numbers in order; arguments that differ
                between ranks.
            RuntimeError: called from a callback of `advance`; or the run went unstable or gained energy beyond the
                limit; the message says when and where, displacement and velocity are back at the last good state, from
                which works count anew and friction has no history.
            KeyboardInterrupt: Ctrl-C, on all ranks after the same step, once the callback has returned.

        What the callback raises on one rank is raised on all. After KeyboardInterrupt, or an exception of the callback,
        the problem is as after the last step: it may be saved, and `advance` to the same time goes on with the very
        steps that were left.
        """
        with guard(self.comm, "advance", callback=callback, unsafe=bool(unsafe)) as ranks:
            until, limits = self._stepper.check_arguments(until, callback), energy_gain.checked(energy_limits)
            ranks.same(until=until, dt=dt, energy_limits=limits)
        if until != self.time:
            self._stepper.advance(until, dt, callback, progress, unsafe, limits)

    @property
    def time(self) -> float:
        """Time that was reached [T]."""
        return self._stepper.time

    @property
    def step(self) -> int:
        """Number of steps that were taken."""
        return self._stepper.step

    @property
    def energy(self) -> dict[str, float]:
        """Energies at the present time: kinetic, internal, contact, friction, impact, damping, viscosity, external,
        total [F L] and drift [1]; docs/explicit/energies.md."""
        return dict(self._state.energy)

    @property
    def energy_history(self) -> np.ndarray:
        """Time and energies before every step, the first at the start of the run, (num_steps, 9): time [T], then those
        of `energy` in its order, external last [F L]. Runs of more than `history_limit` steps: every second, fourth,
        ... step."""
        return self._history.energies

    @property
    def force_history(self) -> list[np.ndarray]:
        """Contact forces on the slaves, by contact: list of arrays (num_steps, gdim) at the times of `energy_history`
        [F]."""
        return self._history.forces

    @property
    def history_limit(self) -> int:
        """Largest number of rows that histories keep in memory, 250,000 unless set; a Recorder writes all rows [1]."""
        return self._history.limit

    @history_limit.setter
    def history_limit(self, value: int) -> None:
        self._history.limit = value

    # --- files -----------------------------------------------------------------------------------------------------

    def record(
        self, path=None, fields=("displacement", "velocity"), every=100, points=None, points_every=10
    ) -> Recorder:
        """Write fields and histories into a folder from now on; see Recorder. Collective.

        Args:
            path: folder; None as for RunFolder.
            fields: some of displacement, velocity, acceleration.
            every: steps between frames.
            points: (n, gdim) places whose nearest nodes' motion is kept every `points_every` steps [L].
            points_every: steps between samples of points.

        Returns:
            Recorder; `close()` it at the end.

        Raises:
            ValueError: unknown fields, intervals that are no positive integers.
            RuntimeError: the folder cannot be written; on all ranks.
        """
        with guard(self.comm, "record", path=path, fields=fields, every=every, points_every=points_every) as ranks:
            fields, points = check_arguments(self, path, fields, every, points, points_every)
            ranks.same(points=points)
        return Recorder(self, self._stepper, self._state, path, fields, every, points, points_every)

    def save(self, path) -> None:
        """Write a checkpoint, HDF5: all that a run needs to go on as if it had not stopped. Collective.

        It is written as PATH.part and then renamed: if anything goes wrong with it an earlier file at `path` is as it
        was. Recorders write their histories up to now after it. Ctrl-C waits until that is done.

        Args:
            path: file to write.

        Raises:
            RuntimeError: the folder cannot be written, no space is left; on all ranks.
        """
        self._restart.save(path)

    def restore(self, path) -> None:
        """Go on from a checkpoint of the same problem, written on any number of ranks. Collective.

        The same are mesh, materials, damping, scheme, supports, loads, contacts, and their functions of time up to the
        time of the checkpoint, to the last digit. Values of loads (`constant.value`) must be those that they had when
        it was written; afterwards they may be changed, as between any two calls of `advance`.

        On as many ranks as wrote it the run goes on bit for bit (if DOLFINx numbers the mesh as it did then, which it
        does not always on three ranks and more), on others to round-off. `advance` with the time that
        the interrupted call had continues with its very steps. Constants, functions and loads that were changed in the
        course of the run are not in the file: set them before.

        Args:
            path: file that `save` has written.

        Raises:
            RuntimeError: the file cannot be read, or is damaged.
            ValueError: it is of another mesh, material, ...; on all ranks. The problem is then as it was.
        """
        self._restart.restore(path)

    # --- the stable step -------------------------------------------------------------------------------------------

    def stable_step(self, method="element"):
        """Largest stable step at the present state [T]. Collective.

        Args:
            method: "length": L/c_d, seed (3.79), (3.80), an estimate that distorted cells may exceed; "element": from
                the highest frequency of the cells, never more than the true limit; "eigenvalue": the true limit, from
                the highest frequency of the assembled system. Contact springs of given stiffness lower the first two
                by a bound that holds wherever the bodies meet; the last has the springs of all slave nodes that have a
                master now, closed or not.

        Raises:
            ValueError: unknown method; "length" for a residual of your own.
        """
        same(self.comm, "stable_step", method=method)
        if method not in METHODS:
            raise ValueError(f"method {method!r} is unknown: use one of {', '.join(METHODS)}")
        if method == "length":
            if self.material is None:
                raise ValueError("L/c_d needs a material: use method 'element' or 'eigenvalue'")
            smallest = float(np.min(self._cell_times(), initial=np.inf))
            omega = 2.0 / self.comm.allreduce(smallest, MPI.MIN)
        elif method == "element":
            if self._frequencies.damps:
                springs = math.hypot(*(c.spring_frequency() for c in self.contact))
                return self._frequencies.step_bound(self.damping.alpha, springs)
            omega = self._frequencies.bound()
        else:
            inverse = 1.0 / self.mass.array[: self.num_owned]
            inverse[self.prescribed[: self.num_owned]] = 0.0
            springs = stiffness(self.contact, self.space, self.u.x.array)
            if self._frequencies.damps:
                found = self._frequencies.critical_step(inverse, springs, self.damping.alpha, self.stable_step())
            else:
                omega = self._frequencies.highest(inverse, springs)
            if springs is not None:
                springs.destroy()
            if self._frequencies.damps:
                return found
        if method != "eigenvalue":
            omega = math.hypot(omega, *(c.spring_frequency() for c in self.contact))
        return damped(omega, self.damping.alpha, self.damping.beta, self._viscosity[0], self.scheme)

    def _cell_times(self):
        """Time a dilatational wave takes through each owned cell [T]."""
        mesh = self.space.mesh
        times = cell_sizes(mesh) / self.space.element.basix_element.degree
        for tag, m in self.material.parts():
            cells = operators._entities(mesh, "cell", -1 if tag is None else tag, self.material.cell_tags)
            times[cells] /= m.wave_speed
        return times
