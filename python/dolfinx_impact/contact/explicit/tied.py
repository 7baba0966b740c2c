# SPDX-License-Identifier: MIT
"""Tied surfaces in explicit dynamics; docs/tie.md."""

from typing import Any

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...amplitude import Amplitude
from ...common.types import FloatArray, IntArray
from ..nodal_sum import NodalSum
from ..output import ContactOutput
from ..pair import ContactPair, ContactStatus
from ..protocol import ExplicitContactProblem

Place = _cpp.state.Place


class ExplicitTie(ContactOutput):
    """A tie in an explicit problem, a view of enforcement/mortar/ExplicitTie.h; points are the slave's nodes that this
    rank owns and that face the master. Tractions are those of the last step, pressures negative where the tie pulls.

    Args:
        pair: the pair of surfaces.
        problem: the problem.
        options: what was given beside the pair, by name.
        in_cpp: options of the tie in C++.
        surfaces: this rank's facets of slave and master.

    Attributes:
        nodes: owned slave nodes, (n).
        weight: areas of the nodes, (n) [L^2].
        motion: None, there is no rigid master.
        stored, penetration_share: zero, there are no springs.
    """

    initial = None
    motion: Amplitude | None = None
    kind = "tie"
    stored = penetration_share = 0.0
    kinematic = True
    body = None
    is_penalty = False
    nodes: IntArray
    weight: FloatArray
    points: FloatArray
    traction: FloatArray
    normal: FloatArray
    force: FloatArray
    moment: FloatArray

    def __init__(
        self,
        pair: ContactPair,
        problem: ExplicitContactProblem,
        options: dict[str, Any],
        in_cpp: _cpp.multipliers.TieOptions,
        surfaces: tuple[_cpp.surface.Facets, _cpp.surface.Facets],
    ) -> None:
        self.pair, self.problem, self._options = pair, problem, options
        self._normal_only = in_cpp.normal_only
        V = problem.space
        self.comm, self.gdim = V.mesh.comm, V.mesh.geometry.dim
        self._surfaces = slave, master = surfaces
        self.tie = _cpp.nodal.ExplicitTie(V._cpp_object, slave, master, in_cpp, problem.prescribed)
        self._cpp_object = _cpp.nodal.NodalPair([self.tie])
        conditions = self.tie.conditions
        self.nodes, self.weight = conditions.nodes, conditions.area
        self._X, self.normal = conditions.points, conditions.normal
        # A rank may own nodes of the slave without having a facet of it.
        nodes = V.dofmap.index_map
        marks = np.zeros((nodes.size_local + nodes.num_ghosts, 1))
        marks[slave.nodes] = 1.0
        self._slave = np.flatnonzero(NodalSum(nodes, 1)(marks)[: nodes.size_local, 0] > 0.0)
        self.traction = np.zeros_like(self._X)

    @property
    def options(self) -> dict[str, Any]:
        return self._options

    def facets(self) -> tuple[_cpp.surface.Facets, _cpp.surface.Facets]:
        return self._surfaces

    def sides(self) -> list[Any]:
        return self._cpp_object.directions

    @property
    def num_free(self) -> int:
        """Slave nodes of all ranks without a master, left free [1]."""
        return int(self.tie.conditions.num_free)

    @property
    def offset(self) -> FloatArray:
        """Distance of slave from master in the reference configuration, (n, gdim) [L]."""
        return self.tie.conditions.offset

    @property
    def gap(self) -> FloatArray:
        """Distance along the normal, which ties keep, (n) [L]."""
        return np.einsum("ij,ij->i", self.normal, self.offset)

    @property
    def pressure(self) -> FloatArray:
        """Part of the traction along the normal, (n) [F/L^2]."""
        return np.einsum("ij,ij->i", self.normal, self.traction)

    @property
    def slip(self) -> FloatArray:
        """Zero: tied surfaces do not slip, or their slip is not followed, (n, gdim) [L]."""
        return np.zeros_like(self._X)

    @property
    def status(self) -> IntArray:
        """All nodes stick, or slip where they are tied along the normal alone, (n)."""
        tied = ContactStatus.slip if self._normal_only else ContactStatus.stick
        return np.full(len(self.nodes), tied, dtype=np.int8)

    def refresh(self) -> None:
        self.update_results()

    def update_results(self) -> None:
        g = self.gdim
        self.points = self._X + self.problem.u.x.array.reshape(-1, g)[self.nodes]
        self.traction = self.tie.traction
        # Nodal forces on the slave, with what multipliers of prescribed nodes give to their neighbours.
        forces = self.tie.forces().reshape(-1, g)
        own, f = self._slave, forces[self._slave]
        x = self.problem.space.tabulate_dof_coordinates()[own, :g] + self.problem.u.x.array.reshape(-1, g)[own]
        moment = (x[:, 0] * f[:, 1] - x[:, 1] * f[:, 0])[:, None] if g == 2 else np.cross(x, f)
        totals = np.concatenate([f.sum(axis=0), moment.sum(axis=0), [self.weight.sum()]])
        sums = self.comm.allreduce(totals, MPI.SUM)
        self.force, self.moment, self.area = sums[:g], sums[g:-1], float(sums[-1])
        self.dissipated = 0.0

    def results_state(self) -> tuple[_cpp.state.State, _cpp.state.State]:
        rows, totals = _cpp.state.State("results"), _cpp.state.State("contact")
        rows.at(Place.node, self.nodes.astype(np.int64))
        rows.add("traction", Place.node, np.ascontiguousarray(self.traction))
        for name in ("force", "moment"):
            totals.add(name, Place.all, np.array(getattr(self, name), dtype=float))
        totals.add("area", Place.all, np.array([self.area, self.dissipated]))
        return rows, totals

    def resume_results(self, rows: _cpp.state.State, totals: _cpp.state.State) -> None:
        self.traction = rows.array("traction").reshape(self.traction.shape)
        self.force, self.moment = totals.array("force"), totals.array("moment")
        self.area, self.dissipated = (float(value) for value in totals.array("area"))

    def covered(self) -> FloatArray:
        return np.ones(len(self.nodes))
