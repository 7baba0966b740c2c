# SPDX-License-Identifier: MIT
"""State of a rolling problem at a point of a sweep, as a table by cells that does not depend on the ranks."""

from __future__ import annotations

from collections.abc import Callable
from typing import TYPE_CHECKING

import numpy as np

from .. import _cpp
from ..common.cell_numbers import input_cell_numbers
from ..common.types import FloatArray, IntArray
from ..contact.nodal_sum import NodalSum
from ..contact.saved_contacts import add_contacts, resume_contacts
from ..io.checkpoint import Place, State

if TYPE_CHECKING:
    from ..statics.static_problem import StaticProblem


class SweepState:
    """Reads and sets displacement and contacts of the equilibrium of a rolling problem with friction.

    Args:
        problem: its equilibrium; contacts are by multipliers.
        mark_reached: function that takes loads and rates as reached by the last solve.
    """

    def __init__(self, problem: StaticProblem, mark_reached: Callable[[], None]) -> None:
        self._problem, self._mark_reached, self._comm = problem, mark_reached, problem.space.mesh.comm

    def read(self) -> tuple[FloatArray, FloatArray] | None:
        """Values at the nodes of every cell, by its number in the mesh's input, (cells, nodes, columns): displacement,
        then what the contacts remember at slave nodes; and totals of the contacts, (n). On rank 0, else None.
        Collective."""
        V, (nodal, totals) = self._problem.space, _blocks(self._contacts())
        num, bs = V.dofmap.index_map.size_local, V.dofmap.index_map_bs
        columns = [self._problem.u.x.array[: num * bs].reshape(-1, bs)]
        for block in nodal:
            values = block.values()
            rows = np.zeros((num, values.shape[1]))
            rows[block.numbers] = values
            columns.append(rows)
        table = self._with_ghosts(np.hstack(columns))
        numbers, dofs = self._cells()
        found = self._comm.gather((numbers, table[dofs]), root=0)
        if found is None:
            return None
        order = np.argsort(np.concatenate([n for n, _ in found]))
        flat = np.concatenate([np.zeros(0), *(block.values() for block in totals)])
        return np.concatenate([rows for _, rows in found])[order], flat

    def set(self, table: FloatArray, totals: FloatArray) -> None:
        """Set displacement and contacts. Collective.

        Args:
            table: values by cells, as `read` returned them.
            totals: totals of the contacts, as `read` returned them.
        """
        V, u = self._problem.space, self._problem.u.x
        numbers, dofs = self._cells()
        bs, first = V.dofmap.index_map_bs, V.dofmap.index_map_bs
        values = np.zeros((V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts, table.shape[2]))
        values[dofs] = table[numbers]
        # A rank may own a node of which it has no cell: it takes the value from those who have.
        known = np.zeros((len(values), 1))
        known[dofs] = 1.0
        sums, counts = self._sum(values), self._sum(known)
        values = self._with_ghosts(np.where(known > 0.0, values, sums / np.maximum(counts, 1.0)))
        u.array[:] = values[:, :bs].ravel()
        start, saved = 0, self._contacts()
        nodal, of_contacts = _blocks(saved)
        for block in nodal:
            end = first + block.width
            block.assign(np.ascontiguousarray(values[block.numbers, first:end]))
            first = end
        for block in of_contacts:
            end = start + block.width
            block.assign(totals[start:end])
            start = end
        resume_contacts(saved, self._problem.contact, u.array)
        self._mark_reached()

    @property
    def shape(self) -> tuple[int, int, int]:
        """Shape of the table that `read` returns."""
        V = self._problem.space
        width = V.dofmap.index_map_bs + sum(block.width for block in _blocks(self._contacts())[0])
        topology = V.mesh.topology
        return int(topology.index_map(topology.dim).size_global), V.dofmap.list.shape[1], width

    @property
    def num_totals(self) -> int:
        """Number of totals that `read` returns."""
        return sum(block.width for block in _blocks(self._contacts())[1])

    def _contacts(self) -> _cpp.state.State:
        """States of the contacts, with values of their own."""
        out = State("contacts")
        add_contacts(out, self._problem.contact)
        return out

    def _cells(self) -> tuple[IntArray, IntArray]:
        """Numbers in the input, and nodes, of this rank's owned cells."""
        V = self._problem.space
        num = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        return input_cell_numbers(V.mesh.topology)[:num], V.dofmap.list[:num]

    def _with_ghosts(self, rows: FloatArray) -> FloatArray:
        """Values of owned nodes at ghosts as well. Collective."""
        size = self._problem.space.dofmap.index_map
        values = np.zeros((size.size_local + size.num_ghosts, rows.shape[1]))
        values[: size.size_local] = rows[: size.size_local]
        return NodalSum(size, rows.shape[1]).forward(values)

    def _sum(self, rows: FloatArray) -> FloatArray:
        """Sums of the values of all ranks at owned nodes and ghosts. Collective."""
        return NodalSum(self._problem.space.dofmap.index_map, rows.shape[1])(rows)


def _blocks(contacts: _cpp.state.State) -> tuple[list[_cpp.files.Block], list[_cpp.files.Block]]:
    """Values at slave nodes, and totals, of the states of contacts in their order."""
    found = _cpp.files.blocks(contacts)
    return [b for b in found if b.place == Place.node], [b for b in found if b.place == Place.all]
