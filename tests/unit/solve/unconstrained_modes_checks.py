# SPDX-License-Identifier: MIT
"""Bodies whose rigid body modes only contact constrains, on any partition of the mesh; see on_ranks.py."""

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI

import dolfinx_impact as di
from dolfinx_impact import compat, meshes

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
        return compat.adjacencylist(((part + shift) % num_parts).astype(np.int32))

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


class OnSprings:
    """A block on another one, pressed by a traction; the upper one hangs on springs of its own residual, on its top.

    Args:
        method: of METHODS. stiffness: (2) of the springs along x and y, per area.
    """

    def __init__(self, method, stiffness):
        made = meshes.make("two_blocks", COMM)
        domain, facets, tags = made.mesh, made.facet_tags, made.tags
        V = fem.functionspace(domain, ("Lagrange", 1, (2,)))
        self.u, v = fem.Function(V), ufl.TestFunction(V)
        top = ufl.Measure("ds", domain, subdomain_data=facets)(tags["top"])
        spring = ufl.as_vector([k * self.u[c] for c, k in enumerate(stiffness)])
        F = 1e6 * ufl.inner(ufl.sym(ufl.grad(self.u)), ufl.sym(ufl.grad(v))) * ufl.dx
        F += ufl.inner(spring - ufl.as_vector([0.0, -1e3]), v) * top
        bottom = fem.locate_dofs_topological(V, 1, facets.find(tags["bottom"]))
        pair = di.ContactPair(facets, tags["slave_surface"], tags["master_surface"])
        bcs = [fem.dirichletbc(np.zeros(2), bottom, V)]
        self.problem = di.StaticProblem(self.u, residual=F, bcs=bcs, contact=[METHODS[method](pair)])
        self._force = fem.form(-spring[1] * top)

    def force(self):
        """Vertical force of the springs on the upper block."""
        return COMM.allreduce(fem.assemble_scalar(self._force))


def check_springs_in_a_residual_hold_a_body():
    """A body that only springs of a residual hold is solved, from soft springs to stiff ones, also from a deformed
    state: springs and contact carry the traction together. Springs along y alone leave it free along x."""
    for method in METHODS:
        for stiffness in (1.0, 1e3, 1e6):
            block = OnSprings(method, (stiffness, stiffness))
            for _ in range(2):
                block.problem.solve()
            contact, springs = block.problem.contact[0].force[1], block.force()
            assert contact > 0.0 and springs > 0.0
            assert abs(contact + springs - 1e3) < 1e-6 * 1e3, (method, stiffness, contact, springs)
        text = ""
        try:
            OnSprings(method, (0.0, 1e3)).problem.solve()
        except RuntimeError as error:
            text = str(error)
        assert text == "not held against rigid motion: the body around (0.5, 0.75) is free to move along x", text


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
