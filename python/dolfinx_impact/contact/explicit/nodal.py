# SPDX-License-Identifier: MIT
"""Contact in explicit dynamics: slave nodes against the master's surface; docs/explicit/penalty.md."""

import math

import numpy as np
import ufl
from mpi4py import MPI

from ... import _cpp
from ...assembly import operators
from ...amplitude import Amplitude
from ...common.arguments import integer
from ...common.collective import comm_of, guard
from ...forms.materials import weight
from ..output import ContactOutput
from ..pair import check_pair
from .springs import searched
from ..initial_penetration import check_side


class Kinematic:
    """Enforce contact of a pair in explicit dynamics by correcting a predicted configuration; seed, five steps after
    (3.48).

    Args:
        pair: ContactPair. sweeps: corrections per step; matching nodes need one [1].

    Raises:
        TypeError, ValueError: sweeps that are no positive integer.
    """

    def __init__(self, pair, sweeps=3):
        with guard(comm_of(pair), "Kinematic", pair=pair, sweeps=sweeps):
            check_pair(pair)
            self.pair, self.sweeps = pair, integer("sweeps", sweeps, 1)

    def __repr__(self):
        return f"Kinematic({self.pair!r}, sweeps={self.sweeps})"

    def _bind(self, problem):
        raise ValueError("kinematic contact is for explicit dynamics: use Lagrange or Penalty in a StaticProblem")

    def _bind_explicit(self, problem):
        return NodalResult(self.pair, problem, _cpp.nodal.KinematicContact, sweeps=self.sweeps)


GAPS = ("gap", "normal")
RESULTS = (*GAPS, "pressure", "traction", "slip", "status", "stiffness")  # by node


class NodalResult(ContactOutput):
    """Contact of one pair in an explicit problem. Points are the slave nodes that this rank owns; see ContactOutput.

    Gaps are as they are now; they are found when they are asked for, as the steps look at nodes only when these could
    touch. Without a master within the search distance a gap is infinite, its normal zero.
    """

    initial = None
    _known = None  # gaps, when they were asked for since `update_results`

    def __init__(self, pair, problem, law, **options):
        self.pair, self.problem, self.V = pair, problem, problem.space
        V = problem.space
        self.comm, self.gdim = V.mesh.comm, V.mesh.geometry.dim
        if pair.remove_penetration:
            raise ValueError(
                f"{pair.name}: remove_penetration is for static problems; move the bodies apart, explicit contact "
                "pushes small overlaps out"
            )
        slave, master = pair.surfaces(V)
        self.obstacle = pair.master._obstacle(self.gdim) if pair.rigid else None
        if pair.rigid:
            self.obstacle.displacement = pair.master.displacement.tolist()
            check_side(pair, V, slave, self.obstacle)
        self._law, self.options = law, options
        self._surfaces = slave, self.obstacle if pair.rigid else master
        facet = float(np.max(np.linalg.norm(np.ptp(slave.X, axis=1), axis=-1), initial=0.0))
        self._facet = self.comm.allreduce(facet, MPI.MAX)  # longest, at rest
        self._cpp_object = self.make(law, **options)
        self.nodes, self.weight = self._cpp_object.nodes, self._cpp_object.areas
        self._X = self._cpp_object.X.reshape(-1, self.gdim)
        self.motion = None
        if pair.rigid:
            place, motion = pair.master.displacement, pair.master.motion
            moving = Amplitude(motion, f"motion of the rigid master of {pair.name}", size=3)
            self.motion = Amplitude(lambda t: place + moving.sample([t])[0], moving.name, size=3)

    def make(self, law, **options):
        """A C++ contact of this pair by a law: PenaltyContact, KinematicContact. Collective."""
        pair = self.pair
        return law(
            self.V._cpp_object,
            *self._surfaces,
            friction=pair.friction,
            search_distance=pair.search_distance or 0.0,
            axisymmetric=self.problem.axisymmetric,
            **options,
        )

    @property
    def penalty(self):
        """Pressure per penetration that was given [F/L^3]; 0: stiffness from masses and step, or none."""
        return self.options.get("penalty", 0.0)

    @property
    def kinematic(self):
        return self._law is _cpp.nodal.KinematicContact

    def sides(self):
        """The C++ contact, and for balanced contact that of the other direction."""
        other = None if self.kinematic else self._cpp_object.other
        return [self._cpp_object] if other is None else [self._cpp_object, other]

    def reset_history(self):
        """Friction and energies begin anew, all nodes open."""
        for side in self.sides():
            history = {name: np.zeros_like(values) for name, values in side.history().items()}
            history["facet"][:] = -1
            side.set_history(history)
            side.set_energy(0.0, 0.0, 0.0)

    def spring_frequency(self):
        """Largest angular frequency that springs of given stiffness add at most, wherever slave and master come to
        meet; automatic ones leave the step alone [1/T]. Collective."""
        if not self.penalty:
            return 0.0

        def most(values):
            return self.comm.allreduce(float(np.max(values, initial=0.0)), MPI.MAX)

        mass = self.problem.mass.array[:: self.gdim]
        slave = self.weight, mass[self.nodes]
        if self.pair.rigid:
            return float(np.sqrt(self.penalty * most(slave[0] / slave[1])))
        areas = self._master_areas()
        near = np.flatnonzero(areas)
        master = areas[near], mass[near]
        # The largest sum of |phi_j| on a facet.
        phi = 1.0 if self.V.element.basix_element.degree == 1 else {2: 1.25, 3: 5 / 3}[self.gdim]
        sums = [
            most(a[0] / a[1]) + phi * most((b[0] + most(a[0])) / b[1]) for a, b in ((slave, master), (master, slave))
        ]
        balanced = self.options.get("balanced", False)  # half of it in each direction
        return float(np.sqrt(self.penalty * (0.5 * (sums[0] + sums[1]) if balanced else sums[0])))

    def _master_areas(self):
        V, mesh = self.V, self.V.mesh
        v = ufl.TestFunction(V)
        ds = ufl.Measure("ds", domain=mesh, subdomain_data=self.pair.facet_tags)(self.pair.master)
        hypothesis = "axisymmetric" if self.problem.axisymmetric else "3d"
        area = operators.InternalForce(ufl.inner(ufl.as_vector([1.0] * self.gdim), v) * weight(mesh, hypothesis) * ds)
        return np.abs(area.apply().array[:: self.gdim])

    def check_start(self):
        """Refuse bodies that overlap by more than half a facet. Collective.

        Raises:
            ValueError: on all ranks.
        """
        deep = int(self._cpp_object.counters()["implausible"])  # kinematic contact looks at gaps in steps
        if self.problem.step == 0 and self.pair.rigid:
            deep = self._deep_in_obstacle()
        elif self.problem.step == 0 and self.kinematic:
            deep = self._deep_by_springs()
        deep = self.comm.allreduce(deep, MPI.SUM)
        if deep:
            raise ValueError(
                f"{self.pair.name}: {deep} slave nodes lie deeper in the master than half a facet: the bodies overlap "
                "at the start; move them apart"
            )

    def _deep_by_springs(self):
        """How many nodes springs in place of the steps' correction would find too deep. Collective."""
        twin, halo, u = searched(self, self.problem.u.x.array, _cpp.nodal.PenaltyContact)
        zero = np.zeros_like(u)
        twin.add_forces(halo, u, zero, np.ones_like(u), 1.0, zero.copy())
        return int(twin.counters()["implausible"])

    def _deep_in_obstacle(self):
        moved = (self.motion.sample([self.problem.time])[0] - self.pair.master.displacement)[: self.gdim]
        x = self._X + self.problem.u.x.array.reshape(-1, self.gdim)[self.nodes] - moved
        gap = self.obstacle.evaluate(np.ascontiguousarray(x).ravel())[0]
        return int(np.count_nonzero(gap < -0.5 * self._facet))

    @property
    def gap(self):
        return self._gaps()["gap"]

    @property
    def normal(self):
        return self._gaps()["normal"]

    def _gaps(self):
        """Gaps and normals, of open nodes as they are now."""
        if self._known is None:
            self.problem._cpp_object.update_gaps()
            results = self._cpp_object.results()
            self._known = {name: results[name] for name in GAPS}
        return self._known

    def update_results(self):
        """Copy results of the last step. Collective."""
        results = self._cpp_object.results()
        for name in RESULTS[len(GAPS) :]:
            setattr(self, name, results[name])
        self._known = None
        u = self.problem.u.x.array.reshape(-1, self.gdim)[self.nodes]
        self.points = self._X + u
        forces = self.weight[:, None] * self.traction
        if self.gdim == 2:
            moments = (self.points[:, 0] * forces[:, 1] - self.points[:, 1] * forces[:, 0])[:, None]
        else:
            moments = np.cross(self.points, forces)
        energy = self._cpp_object.energy()
        totals = [self._cpp_object.force, moments.sum(axis=0), [self.weight[self.status > 0].sum(), energy["friction"]]]
        sums = self.comm.allreduce(np.concatenate(totals), MPI.SUM)
        gdim = self.gdim
        self.force, self.moment, self.area = sums[:gdim], sums[gdim:-2], float(sums[-2])
        self.dissipated = float(sums[-1])

    def save_results(self):
        """What `update_results` found, for checkpoints: rows by node, and the totals."""
        rows = [np.asarray(getattr(self, name), dtype=float) for name in RESULTS]
        rows = [values.reshape(len(values), math.prod(values.shape[1:])) for values in rows]
        return np.hstack(rows), np.concatenate([self.force, self.moment, [self.area, self.dissipated]])

    def restore_results(self, rows, totals):
        """Results as `save_results` gave them, for a state whose forces are not there any more."""
        first = 0
        for name in RESULTS:
            now = getattr(self, name)
            count = math.prod(now.shape[1:])
            values = np.ascontiguousarray(rows[:, first : first + count].reshape(now.shape).astype(now.dtype))
            if name in GAPS:
                self._known[name] = values
            else:
                setattr(self, name, values)
            first += count
        gdim = self.gdim
        self.force, self.moment = totals[:gdim], totals[gdim:-2]
        self.area, self.dissipated = float(totals[-2]), float(totals[-1])

    def covered(self):
        """Part of each node's area that is in contact: all of it or nothing, (n)."""
        return (self.status > 0).astype(float)
