# SPDX-License-Identifier: MIT
"""Bodies whose rigid body modes only contact constrains, on any partition of the mesh; see on_ranks.py."""

import numpy as np
from dolfinx import fem, graph
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import meshes

COMM = MPI.COMM_WORLD
METHODS = {
    "multipliers": di.Lagrange,
    "linear": lambda pair: di.Lagrange(pair, basis="linear"),
    "penalty": lambda pair: di.Penalty(pair, penalty=1e6),
}


def consecutive_cells(shift):
    """Partitioner that gives equal parts of the cells, in the order of the input, to the ranks from `shift` on.

    The cells of the first body come first, so that slave and master are on different ranks.
    """

    def partition(comm, num_parts, cell_types, cells):
        num = len(cells[0]) // 4
        counts = comm.allgather(num)
        first, total = sum(counts[: comm.rank]), sum(counts)
        part = (np.arange(first, first + num) * num_parts) // total
        return graph.adjacencylist(((part + shift) % num_parts).astype(np.int32))

    return partition


class Stack:
    """A block on another one, under a traction: vertically only contact supports it.

    Args:
        partitioner: partitioner of the mesh.
        method: key of METHODS.
        swapped: the lower block is the slave.
        friction: Coulomb's friction coefficient [1].
        supported: the upper block has a support in the horizontal direction.
    """

    def __init__(self, partitioner, method, swapped, friction, supported):
        made = meshes.make("two_blocks", COMM, partitioner=partitioner)
        facets, tags = made.facet_tags, made.tags
        V = fem.functionspace(made.mesh, ("Lagrange", 1, (2,)))
        self.u = fem.Function(V)
        supports = [("bottom", 0), ("bottom", 1)] + ([("slave_left", 0)] if supported else [])
        bcs = [
            fem.dirichletbc(0.0, fem.locate_dofs_topological(V.sub(axis), 1, facets.find(tags[side])), V.sub(axis))
            for side, axis in supports
        ]
        names = ("master_surface", "slave_surface") if swapped else ("slave_surface", "master_surface")
        pair = di.ContactPair(facets, *(tags[name] for name in names), friction=friction)
        press = di.Traction(facets, tags["top"], (0.0, -1e3))
        law = di.LinearElastic(1e6, 0.0, 1.0, "plane_strain")
        self.problem = di.StaticProblem(self.u, law, bcs=bcs, loads=[press], contact=[METHODS[method](pair)])


def check_contact_constrains_rigid_body_modes():
    """Slave or master may be the body without vertical support: contact carries the traction on every partition."""
    for method, friction in (("multipliers", 0.0), ("linear", 0.3), ("penalty", 0.0)):
        for swapped in (False, True):
            for shift in (0, 1):
                stack = Stack(consecutive_cells(shift), method, swapped, friction, supported=True)
                stack.problem.solve()
                force = stack.problem.contact[0].force
                assert abs((-force[1] if swapped else force[1]) - 1e3) < 1e-6 * 1e3, (method, swapped, shift, force)


def check_unconstrained_modes_are_reported():
    """Without friction and support the body can slide, whichever body is the slave; the error names the mode."""
    cases = [("multipliers", True, 0.0), ("penalty", False, 0.0), ("penalty", True, 0.0), ("multipliers", True, 0.3)]
    for method, swapped, friction in cases:
        stack = Stack(consecutive_cells(0), method, swapped, friction, supported=False)
        try:
            stack.problem.solve()
            text = ""
        except RuntimeError as error:
            text = str(error)
        assert all(t == text for t in COMM.allgather(text))
        expected = "not held against rigid motion: the body around (0.5, 0.75) is free to move along x"
        assert text == (expected if friction == 0.0 else ""), (method, swapped, friction, text)
