# SPDX-License-Identifier: MIT
"""Contact that finds itself in explicit problems; docs/explicit/general_contact.md."""

from __future__ import annotations

from typing import Any

import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...amplitude import Amplitude
from ...common.types import FloatArray, IntArray
from ..general_surface import GeneralSurface
from ..protocol import ExplicitContactProblem
from .nodal_output import NodalOutput

RESULTS = ("normal", "gap", "pressure", "traction", "slip", "status")  # arrays by node


class GeneralOutput(NodalOutput):
    """General contact of an explicit problem, a view of cpp/dolfinx_impact/enforcement/general/GeneralContact.h; points
    are the surface nodes that this rank owns.

    A node is pushed by springs of its own, as corner of facets that other nodes have come through, and as end of edges:
    traction and pressure have all of it. Status, gap and slip are those of its own spring; in a corner between facets,
    where it has up to three, of that with the largest force.

    Args:
        pair: the surface.
        problem: the problem.

    Attributes:
        nodes: owned surface nodes, (n).
        weight: areas of the nodes, (n) [L^2].
        pressure: part of the traction along the outward normal, positive in compression, (n) [F/L^2].
        traction: contact force on the node over its area, (n, gdim) [F/L^2].
        normal: mean outward normals of the surface at the nodes, (n, gdim) [1].
        gap: gap of the node's own spring, negative; infinite while it is open, (n) [L].
        slip: accumulated since the node's own spring has closed, (n, gdim) [L].
        status: ContactStatus numbers of the nodes' own springs, (n).
        stored: energy stored in the springs, of all ranks [F L].
        penetration_share: energy in the springs over that in springs and bodies [1].
        deepest: deepest penetration of all ranks in the last step [L].
        num_springs: closed springs of all ranks: of nodes, and of crossed edges.

    Raises:
        ValueError: surfaces that do not fit the problem; on all ranks.
    """

    initial = None
    kind, kinematic, is_penalty, body, penalty = "GeneralContact", False, True, None, 0.0
    motion: Amplitude | None = None
    nodes: IntArray
    weight: FloatArray
    points: FloatArray
    normal: FloatArray
    gap: FloatArray
    pressure: FloatArray
    traction: FloatArray
    slip: FloatArray
    status: IntArray
    penetration_share = deepest = 0.0
    num_springs = (0, 0)

    def __init__(self, pair: GeneralSurface, problem: ExplicitContactProblem) -> None:
        self.pair: Any = pair
        self.problem, self.V = problem, problem.space
        V = problem.space
        self.comm, self.gdim = V.mesh.comm, V.mesh.geometry.dim
        self._facets = pair.facets(V, problem.axisymmetric)
        surfaces = [other.surfaces(V) for other in problem.named_pairs]
        named = [(slave, master) for slave, master in surfaces if master is not None]
        self._general = _cpp.nodal.GeneralContact(
            V._cpp_object, self._facets, pair.friction, named, problem.axisymmetric
        )
        self._cpp_object = _cpp.nodal.NodalPair([self._general])
        self.nodes, self.weight = self._general.nodes, self._general.areas
        self._X = self._general.X.reshape(-1, self.gdim)

    @property
    def options(self) -> dict[str, Any]:
        return {}

    def facets(self) -> tuple[_cpp.surface.Facets, None]:
        return self._facets, None

    def sides(self) -> list[Any]:
        return [self._general]

    def refresh(self) -> None:
        self.update_results()

    def update_results(self) -> None:
        gdim = self.gdim
        results = self._general.results()
        self.status, self.gap, self.slip = (results[name] for name in ("status", "gap", "slip"))
        self.points = self._X + self.problem.u.x.array.reshape(-1, gdim)[self.nodes]
        self.normal = self._general.normals().reshape(-1, gdim)
        forces = self._general.nodal_forces().reshape(-1, gdim)
        self.traction = forces / self.weight[:, None]
        self.pressure = np.maximum(0.0, -np.sum(self.traction * self.normal, axis=1))
        springs = self._general.num_springs
        sums = self.sum_up(forces, forces.sum(axis=0), np.any(forces != 0.0, axis=1), *map(float, springs))
        self.num_springs = int(sums[0]), int(sums[1])
        self.deepest = self.comm.allreduce(self._general.deepest, MPI.MAX)

    def force_on(self, tag: int) -> FloatArray:
        """Contact force on the surface with a tag, at the present time. Collective.

        Forces at nodes that it shares with other surfaces count to it.

        Args:
            tag: tag of facets.

        Returns:
            Force, (gdim) [F].

        Raises:
            ValueError: no facet of the boundary has the tag; on all ranks.
        """
        mask = self.pair.nodes_with(tag, self.V)
        forces = (self.traction * self.weight[:, None])[mask[self.nodes]]
        return np.asarray(self.comm.allreduce(forces.sum(axis=0), MPI.SUM))

    def results_state(self) -> tuple[_cpp.state.State, _cpp.state.State]:
        return self.state_of(RESULTS)

    def resume_results(self, rows: _cpp.state.State, totals: _cpp.state.State) -> None:
        """There are no contact forces in a checkpoint to compute them from."""
        for name in RESULTS:
            now = getattr(self, name)
            setattr(self, name, rows.array(name).reshape(now.shape).astype(now.dtype))
        self.resume_totals(totals)

    def covered(self) -> FloatArray:
        """One or zero: a node is in contact or not."""
        return np.any(self.traction != 0.0, axis=1).astype(float)
