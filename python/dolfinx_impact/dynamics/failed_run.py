# SPDX-License-Identifier: MIT
"""Message about where and why an explicit run failed."""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

import numpy as np
from dolfinx.fem import FunctionSpace
from mpi4py import MPI

from ..common.cell_numbers import input_cell_numbers
from . import energy_gain

if TYPE_CHECKING:
    from .explicit import ExplicitProblem


def describe_node(V: FunctionSpace, node: int) -> str:
    """Describe a node by its number, a cell and its undeformed coordinates.

    Args:
        V: displacement space.
        node: number of the node on this rank.

    Returns:
        Text for an error message, with numbers as in the mesh's input.
    """
    cell = int(np.argmax(np.any(V.dofmap.list == node, axis=1)))
    x = V.tabulate_dof_coordinates()[node]
    number = int(input_cell_numbers(V.mesh.topology)[cell])
    text = f"cell {number} (number in the mesh's input) at {x[: V.mesh.geometry.dim].round(9).tolist()}"
    geometry = V.mesh.geometry
    vertices = geometry.x[geometry.dofmap[cell]]
    distance = np.linalg.norm(vertices - x, axis=1)
    nearest = int(np.argmin(distance))
    if distance[nearest] < 1e-9 * np.ptp(vertices, axis=0).max():
        text = f"node {int(geometry.input_global_indices[geometry.dofmap[cell, nearest]])} of {text}"
    return text


class FailedRun:
    """Finds why the C++ integrator stopped before the last step. Collective.

    Args:
        problem: ExplicitProblem.
        time: time of the step that failed [T].
        step: length of the steps [T].
        stable_step: largest stable step [T].

    Attributes:
        gain: energy gained without external work, relative to the energies so far [1].
        gain_limit: gain at which the integrator stops [1].
        released: energy that a residual of the user's own has given beyond what bodies may have stored; 0: it has not
            [F L].
        release_limit: that limit [F L].
        passed: depth by which a slave node passed through the master in one step, in facets; 0 if none did [1].
        unsolved: which local equations of the materials were not solved, or an empty text.
        place: description of the node that passed, or else of the fastest node.
        contact: name of the pair whose node passed, or an empty text.
    """

    def __init__(self, problem: ExplicitProblem, time: float, step: float, stable_step: float) -> None:
        comm, integrator = problem.comm, problem._cpp_object
        self.time, self.step, self.stable_step = time, step, stable_step
        self.gain: float = integrator.gain
        self.gain_limit: float = integrator.gain_limit
        self.release_limit: float = integrator.release_limit
        self.released: float = integrator.released if integrator.released > self.release_limit else 0.0
        pair, node, facets = integrator.passage()
        # In a run with steps beyond the stable step, passing nodes are an effect of the instability, not its cause.
        stable = step <= stable_step * (1 + 1e-12)
        self.passed: float = comm.allreduce(facets, MPI.MAX) if stable else 0.0
        if self.passed > 0.0:
            rank = comm.allreduce(comm.rank if facets == self.passed else comm.size, MPI.MIN)
        else:
            dof, speed = integrator.fastest()
            node = dof // problem.space.dofmap.index_map_bs
            worst = -1.0 if dof < 0 else math.inf if math.isnan(speed) else speed
            rank = int(np.argmax(comm.allgather(worst)))
        self.unsolved: str = problem.unsolved_points()
        self.place: str = comm.bcast(describe_node(problem.space, node) if comm.rank == rank else None, root=rank)
        self.contact: str = comm.bcast(problem.contact[pair].pair.name if pair >= 0 else "", root=rank)

    def message_of(self, fault: str, back_at: float) -> str:
        """Text of the error about a fault that is known.

        Args:
            fault: what is wrong.
            back_at: time of the state that the problem has returned to [T].

        Returns:
            What happened, when, and what to do.
        """
        return (
            f"{fault}, at the time {self.time:.6g}; the problem is back at the time {back_at:.6g}. Take a smaller "
            "step, or check the law"
        )

    def message(self, back_at: float, stable_step: float) -> str:
        """Text of the error that the run raises.

        Args:
            back_at: time of the state that the problem has returned to [T].
            stable_step: stable step of that state [T].

        Returns:
            What happened, when and where, and what to do.
        """
        if self.passed > 0.0:
            return (
                f"{self.contact}: a slave node went through the master at the time {self.time:.6g}: {self.place}. "
                "Contact holds back nodes that come through the surface by up to one facet in a step, this one came by "
                f"{self.passed:.3g}; the problem is back at the time {back_at:.6g}. Take steps below "
                f"{0.9 * self.step / self.passed:.3g} (now {self.step:.3g}), or coarser facets"
            )
        if self.unsolved:
            return self.message_of(self.unsolved, back_at)
        stable = min(stable_step, self.stable_step)
        if self.released and not self.step > stable * (1 + 1e-12):
            go_on = "energy_limits=None of advance lets the run go on"
            text = energy_gain.released_message(self.released, self.release_limit, go_on)
            return (
                f"{text}. It was stopped at the time {self.time:.6g}; what moves fastest is in {self.place}; the "
                f"problem is back at the time {back_at:.6g}"
            )
        gained = self.gain > self.gain_limit
        why = f"{energy_gain.message(self.gain)} What moves fastest is" if gained else "first"
        advice = "" if gained else " Take a smaller step, or check loads and contact"
        return (
            f"the run went unstable at the time {self.time:.6g}, step {self.step:.6g} (stable: {stable:.6g}),"
            f" {why} in {self.place}; the problem is back at the time {back_at:.6g}.{advice}"
        )
