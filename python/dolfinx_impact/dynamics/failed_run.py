# SPDX-License-Identifier: MIT
"""Where and why an explicit run failed, in words."""

import math

import numpy as np
from mpi4py import MPI

from ..common.cell_numbers import input_cell_numbers
from . import energy_gain


def describe_node(V, node: int) -> str:
    """Number, cell and place at rest of a node of this rank.

    Args:
        V: displacement space.
        node: number of the node on this rank.
    """
    cell = int(np.argmax(np.any(V.dofmap.list == node, axis=1)))
    x = V.tabulate_dof_coordinates()[node]
    number = int(input_cell_numbers(V.mesh.topology)[cell])
    text = f"cell {number} (number in the mesh's input) at {x[: V.mesh.geometry.dim].round(9).tolist()}"
    geometry = V.mesh.geometry
    places = geometry.x[geometry.dofmap[cell]]
    distance = np.linalg.norm(places - x, axis=1)
    nearest = int(np.argmin(distance))
    if distance[nearest] < 1e-9 * np.ptp(places, axis=0).max():
        text = f"node {int(geometry.input_global_indices[geometry.dofmap[cell, nearest]])} of {text}"
    return text


class FailedRun:
    """What has stopped the C++ integrator before the last step. Collective.

    Args:
        problem: ExplicitProblem.
        time: of the step that failed [T].
        step: length of the steps [T].
        stable_step: largest stable step [T].
    """

    def __init__(self, problem, time: float, step: float, stable_step: float) -> None:
        comm, integrator = problem.comm, problem._cpp_object
        self.time, self.step, self.stable_step = time, step, stable_step
        self.gain, self.gain_limit = integrator.gain, integrator.gain_limit
        pair, node, facets = integrator.passage()
        # Nodes of a run with steps beyond the stable one go everywhere.
        stable = step <= stable_step * (1 + 1e-12)
        self.passed = comm.allreduce(facets, MPI.MAX) if stable else 0.0  # facets in a step
        if self.passed > 0.0:
            rank = comm.allreduce(comm.rank if facets == self.passed else comm.size, MPI.MIN)
        else:
            dof, speed = integrator.fastest()
            node = dof // problem.space.dofmap.index_map_bs
            worst = -1.0 if dof < 0 else math.inf if math.isnan(speed) else speed
            rank = int(np.argmax(comm.allgather(worst)))
        self.place = comm.bcast(describe_node(problem.space, node) if comm.rank == rank else None, root=rank)
        self.contact = comm.bcast(problem.contact[pair].pair.name if pair >= 0 else "", root=rank)

    def message(self, back_at: float) -> str:
        """Text of the error.

        Args:
            back_at: time to which the problem has gone back [T].
        """
        if self.passed > 0.0:
            return (
                f"{self.contact}: a slave node went through the master at the time {self.time:.6g}: {self.place}. "
                "Contact holds back nodes that come through the surface by up to one facet in a step, this one came by "
                f"{self.passed:.3g}; the problem is back at the time {back_at:.6g}. Take steps below "
                f"{0.9 * self.step / self.passed:.3g} (now {self.step:.3g}), or coarser facets"
            )
        gained = self.gain > self.gain_limit
        why = f"{energy_gain.told(self.gain)} What moves fastest is" if gained else "first"
        advice = "" if gained else " Take a smaller step, or check loads and contact"
        return (
            f"the run went unstable at the time {self.time:.6g}, step {self.step:.6g} (stable: {self.stable_step:.6g}),"
            f" {why} in {self.place}; the problem is back at the time {back_at:.6g}.{advice}"
        )
