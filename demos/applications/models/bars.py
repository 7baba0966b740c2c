# SPDX-License-Identifier: MIT
"""Bars of impact_bars: meshes, runs, what they are compared with."""

from dataclasses import dataclass

import numpy as np
from mpi4py import MPI
from dolfinx import fem

import dolfinx_impact as di
from dolfinx_impact import meshes
from dolfinx_impact.io.gather import gather_rows
from dolfinx_impact.theory import waves


@dataclass(frozen=True)
class Case:
    """A striker that moves towards positive x, and what it meets at x = 0.

    Attributes:
        velocity: of approach [L/T]. second: E, density, length of the bar it meets; None: a rigid wall. frame: velocity
        of the second bar at the start [L/T]. confined: the sides are on rollers, uniaxial strain.
    """

    title: str
    E: float
    density: float
    length: float
    velocity: float
    gap: float
    second: tuple | None = None
    frame: float = 0.0
    nu: float = 0.0
    confined: bool = False

    @property
    def modulus(self):
        """Of the waves: E, or that of uniaxial strain [F/L^2]."""
        nu = self.nu
        return self.E * (1 - nu) / ((1 + nu) * (1 - 2 * nu)) if self.confined else self.E

    @property
    def bars(self):
        """Arguments of bar_impact and bar_waves."""
        other = () if self.second is None else (self.second[1], self.second[0])
        return self.velocity, self.length, self.density, self.modulus, *other

    @property
    def exact(self):
        return di.theory.bar_impact(*self.bars)

    @property
    def echo(self):
        """How the contact hears of the release: of the striker, and of the second bar if its own is back then, too."""
        if self.second is None:
            return 2.0
        Z1, Z2 = np.sqrt(self.E * self.density), np.sqrt(self.second[0] * self.second[1])
        both = np.isclose(self.second[2] / np.sqrt(self.second[0] / self.second[1]), self.exact.release_time / 2)
        return 2.0 if both else 2 * Z2 / (Z1 + Z2)


class Impact:
    """A case on a mesh of n square cells along the striker, one across, by a method: di.Penalty or di.Kinematic."""

    def __init__(self, comm, case, n, method):
        self.comm, self.case, self.h = comm, case, case.length / n
        self.first = case.gap / case.velocity
        h = self.h
        if case.second is None:
            made = meshes.make("block", comm, size=(case.length, h), cells=(n, 1), origin=(-case.length - case.gap, 0))
            law = di.LinearElastic(case.E, case.nu, case.density, "plane_strain")
            self.faces = (-case.gap,)
        else:
            cells = (n, 1), (round(case.second[2] / h), 1)
            made = meshes.make(
                "two_bars", comm, lengths=(case.length, case.second[2]), section=(h,), gap=case.gap,
                striker_cells=cells[0], target_cells=cells[1],
            )  # fmt: skip
            bodies = {"slave_body": (case.E, case.density), "master_body": case.second[:2]}
            laws = {made.tags[b]: di.LinearElastic(E, 0.0, rho, "plane_strain") for b, (E, rho) in bodies.items()}
            law = di.MaterialMap(made.cell_tags, laws)
            self.faces = (-case.gap, 0.0)
        V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
        self.X, self.V = V.tabulate_dof_coordinates()[:, 0], V
        velocity = fem.Function(V)
        self.striker = self.X < -case.gap / 2
        velocity.x.array[::2] = np.where(self.striker, case.velocity + case.frame, case.frame)
        bcs, tags = [], made.tags
        for side in ("bottom", "top") if case.confined else ():
            dofs = fem.locate_dofs_topological(V.sub(1), 1, made.facet_tags.find(tags[side]))
            bcs.append(fem.dirichletbc(0.0, dofs, V.sub(1)))
        if case.second is None:
            pair = di.ContactPair(made.facet_tags, tags["right"], di.RigidPlane((0.0, 0.0), (-1.0, 0.0)))
        else:
            pair = di.ContactPair(made.facet_tags, tags["slave_surface"], tags["master_surface"])
        self.u, self.springs = fem.Function(V, name="displacement"), method is di.Penalty
        self.problem = di.ExplicitProblem(self.u, law, velocity=velocity, bcs=bcs, contact=[method(pair)])
        self._at = [np.flatnonzero(np.isclose(self.X[: self._owned], x, atol=1e-3 * case.gap)) for x in self.faces]
        self._rows, self._chi = [], 0.0

    @property
    def _owned(self):
        return self.V.dofmap.index_map.size_local

    def _look(self, problem):
        """Time, then displacement and velocity of every end at the contact."""
        u, v = (f.x.array[::2] for f in (problem.u, problem.velocity))
        sums = np.array([(u[at].sum(), v[at].sum(), len(at)) for at in self._at])
        sums = self.comm.allreduce(sums, MPI.SUM)
        self._rows.append([problem.time, *(sums[:, :2] / sums[:, 2:]).ravel()])

    def run(self, until, ends=False):
        """Go to `until` times the contact after first touch; `ends`: look at the bars' ends after every step.

        Collective. Sets `force`, rows of time and contact stress, `ends`, rows of `_look`, and `courant`.
        """
        problem, case = self.problem, self.case
        for part in (0.5, until):  # half way springs are closed: their stiffness
            time = self.first + part * case.exact.release_time
            problem.advance(time, callback=self._look if ends else None, progress=False)
            contact = problem.contact[0]
            self._chi = max(self._chi, float(np.max(contact.stiffness / contact.weight, initial=0.0)))
        times = problem.energy_history[:, 0]
        self.force = np.column_stack([times, -problem.force_history[0][:, 0] / self.h])
        self.ends, self.courant = np.array(self._rows), np.diff(times[-2:])[0] * case.exact.wave_speed / self.h
        return self

    @property
    def lag(self):
        """Of the springs times the striker's wave speed [L]; kinematic contact has none. Collective."""
        case, chi = self.case, self.comm.allreduce(self._chi, MPI.MAX)
        if not self.springs:
            return 0.0
        c, Z = case.exact.wave_speed, case.density * case.exact.wave_speed
        return c / (chi * (1 / Z + (0 if case.second is None else 1 / np.sqrt(case.second[0] * case.second[1]))))

    def shift(self):
        """Mean velocity of the striker [L/T]. Collective."""
        n = self._owned
        mass, v = self.problem.mass.array[: 2 * n : 2], self.problem.velocity.x.array[: 2 * n : 2]
        mine = self.striker[:n]
        momentum, total = self.comm.allreduce(np.array([mass[mine] @ v[mine], mass[mine].sum()]), MPI.SUM)
        return momentum / total

    def profile(self):
        """Rows for this rank's cells: x of both ends, stress (positive in compression), velocity of both ends."""
        dofs = self.V.dofmap.list[: self.V.mesh.topology.index_map(2).size_local]
        x, u = self.X[dofs], self.problem.u.x.array[::2][dofs]
        v, order = self.problem.velocity.x.array[::2][dofs], np.argsort(x, axis=1)
        x, u, v = (np.take_along_axis(a, order, axis=1).reshape(-1, 2, 2).mean(axis=2) for a in (x, u, v))
        E = np.where(x[:, 1] <= -0.5 * self.case.gap, self.case.modulus, (self.case.second or (0.0,))[0])
        return np.column_stack([x, -E * (u[:, 1] - u[:, 0]) / (x[:, 1] - x[:, 0]), v])

    def exact_profile(self, x):
        """Exact stress and velocity at places of the undeformed bars, now."""
        place = np.where(x < -0.5 * self.case.gap, x + self.case.gap, x)  # the faces are x = 0 where they touch
        stress, v = waves.bar_waves(
            place, self.problem.time - self.first, *self.case.bars, *(self.case.second or ())[2:]
        )
        return stress, v + self.case.frame

    def errors(self):
        """L2 errors of stress and velocity over both bars, relative to those behind the wave. Collective."""
        rows, sums = self.profile(), np.zeros(3)
        s = (np.arange(20) + 0.5) / 20  # places in a cell, more than a jump in one can be told by
        x = rows[:, :1] + s * (rows[:, 1:2] - rows[:, :1])
        stress, v = self.exact_profile(x)
        found = rows[:, 3:4] + s * (rows[:, 4:] - rows[:, 3:4])
        sums[0] = np.sum((rows[:, 2:3] - stress) ** 2) * self.h / len(s)
        sums[1] = np.sum((found - v) ** 2) * self.h / len(s)
        sums[2] = len(rows) * self.h
        sums = self.comm.allreduce(sums, MPI.SUM)
        jump = self.case.exact.stress, self.case.velocity - self.case.exact.interface_velocity
        return np.sqrt(sums[:2] / sums[2]) / jump

    def expected_error(self, lag):
        """What `errors` must find where each bar has one front that began at the contact: waves.front_error."""
        distance = self.case.exact.wave_speed * (self.problem.time - self.first)
        return waves.front_error(distance, self.h, self.courant, lag) / np.sqrt(self.case.length)

    def expected(self):
        """Duration and velocity afterwards as in `summary`, and how far they may be off. Collective.

        Springs: from waves.contact_pulse. Without: the release's front comes early by dispersion, the duration by less
        than its width. Contact begins and ends in a step: two steps off the duration, one off the impulse.
        """
        case, T = self.case, self.case.exact.release_time
        c, lag, way = case.exact.wave_speed, self.lag, 2 * case.length
        step, width = self.courant * self.h / way, waves.front_width(way, self.h, self.courant) / way
        if lag:
            t = np.linspace(0.0, 1.9 * T, 40001)
            pulse = waves.contact_pulse(t, T, lag / c, case.echo)
            duration, impulse, off = np.count_nonzero(pulse > 0.5) * t[1] / T, np.sum(pulse) * t[1] / T, 2 * step
        else:
            duration, impulse, off = 1.0, 1.0 - waves.early_release(case.echo) * width, 2 * step + width
        change = case.exact.stress * T / (case.density * case.length)
        final = case.exact.rear_velocity + case.frame
        velocity = case.velocity + case.frame - impulse * change
        return {"duration": (duration, off), "velocity": (velocity / final, step * change / abs(final))}

    def rows(self):
        """`profile` of all ranks, sorted by place; None but on rank 0. Collective."""
        rows = gather_rows(self.comm, self.profile())
        return None if rows is None else rows[np.argsort(rows[:, 0])]

    def summary(self):
        """Dict of what was found over what is exact; energies over that at the start. Collective."""
        t, stress = self.force[:, 0] - self.first, self.force[:, 1] / self.case.exact.stress
        T = self.case.exact.release_time
        impulse = np.concatenate([[0.0], np.cumsum(np.diff(t) * (stress[1:] + stress[:-1]) / 2)])
        low, high = 0.1 * T, 0.9 * T
        above = np.flatnonzero(stress > 0.5)
        energy = self.problem.energy_history[:, 1:]
        total = energy[:, :-1].sum(axis=1) - energy[:, -1]
        return {
            "stress": (np.interp(high, t, impulse) - np.interp(low, t, impulse)) / (high - low),
            "largest": stress.max(),
            "duration": (t[above[-1]] - t[above[0]]) / T,
            "release": t[above[-1]] / T,
            "velocity": self.shift() / (self.case.exact.rear_velocity + self.case.frame),
            "energy": self.problem.energy["total"] / total[0],
            "drift": np.abs(total / total[0] - 1).max(),
        }
