# SPDX-License-Identifier: MIT
"""What a contact tells: totals over the ranks, fields."""

import numpy as np
from dolfinx import fem
from mpi4py import MPI

from ..common.collective import guard


class ContactOutput:
    """Results of a contact; arrays are over this rank's contact points, totals over all ranks and the same on all.

    A class derived from this has points, gap, normal, pressure, traction, slip, status, weight, covered(),
    contact_forces() and `comm`.
    """

    @property
    def initial(self):
        """InitialPenetration: penetrations before anything was loaded."""
        return self.geometry.initial

    @property
    def initial_penetration(self):
        """Largest penetration before anything was loaded, of all ranks; removed or not [L]."""
        return self.initial.depth

    force = None  #: total contact force on the slave, (gdim); on the master it is the opposite [F]
    moment = None  #: of these forces about the origin, (1) in the plane, (3) in space [F L]
    area = 0.0  #: area in contact (2D: length), see covered() [L^2]
    dissipated = 0.0  #: work of friction so far: in each increment, tractions at its end times its slip [F L]
    _slip_before = 0.0

    fault = ""  #: why a converged state is none, if it is not

    def largest_violation(self):
        """A sentence about the condition of contact that is violated most, or an empty text. Collective."""
        return ""

    def coarse_slave(self):
        """A sentence about a slave's surface that is much coarser than the master's, or an empty text. Collective."""
        return ""

    def check_parameters(self):
        """Refuse, before a solution, what cannot be solved for. Collective."""

    def add_residual(self, b):
        """Subtract the nodal contact forces from a residual (PETSc vector) [F]. Collective."""
        b.array[:] -= self.contact_forces()

    def prescribed_overlap(self):
        """What is wrong with a converged state that the method cannot see, or an empty text. Collective."""
        return ""

    def close_nearest(self):
        """Take the nearest points as touching, if they nearly do; returns whether there are any. Collective."""
        return False

    def update_totals(self):
        """Sum up force, moment, area and work of the present state. Collective; a converged increment calls it."""
        touching = self.status > 0
        forces = np.where(touching, self.weight, 0.0)[:, None] * self.traction
        if forces.shape[1] == 2:
            moments = (self.points[:, 0] * forces[:, 1] - self.points[:, 1] * forces[:, 0])[:, None]
        else:
            moments = np.cross(self.points, forces)
        slip = np.array(self.slip)
        work = -np.sum(forces * (slip - self._slip_before))
        self._slip_before = slip
        parts = [forces.sum(axis=0), moments.sum(axis=0), [np.sum(self.weight * self.covered()), work]]
        sums = self.comm.allreduce(np.concatenate(parts), MPI.SUM)
        gdim = forces.shape[1]
        self.force, self.moment, self.area = sums[:gdim], sums[gdim:-2], float(sums[-2])
        self.dissipated += float(sums[-1])

    def at_nodes(self, values):
        """A contact array by nodes: their numbers on this rank, (m), and values, (m) or (m, gdim)."""
        return self.nodes, np.asarray(values, dtype=float)

    def field(self, problem, values, name):
        """A contact array as a function on the displacement's mesh, zero elsewhere, for ParaView. Collective.

        Values at quadrature points (penalty) become means at the slave's nodes; see PenaltyContact.at_nodes.

        Args:
            problem: StaticProblem.
            values: one of the arrays, (n) or (n, gdim).
            name: of the function.
        """
        with guard(self.comm, "field", name=name):
            if len(np.atleast_1d(values)) != len(self.points):
                raise ValueError(
                    f"the array has {len(np.atleast_1d(values))} rows, the contact {len(self.points)} points"
                )
        V = problem.space
        mesh, degree = V.mesh, V.element.basix_element.degree
        nodes, values = self.at_nodes(values)
        shape = values.shape[1:]
        f = fem.Function(fem.functionspace(mesh, ("Lagrange", degree, shape)), name=name)
        flat = f.x.array.reshape(-1, *shape)
        flat[nodes] = np.where(np.isfinite(values), values, 0.0)
        f.x.scatter_forward()
        return f
