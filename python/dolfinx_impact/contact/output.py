"""What a contact tells: totals over the ranks, fields."""

import numpy as np
from dolfinx import fem
from mpi4py import MPI


class ContactOutput:
    """Results of a contact; arrays are over this rank's contact points, totals over all ranks.

    A class derived from this has points, gap, normal, pressure, traction, slip, status, weight, forces() and `comm`.
    """

    def _sum(self, values):
        return self.comm.allreduce(np.ascontiguousarray(values, dtype=float), MPI.SUM)

    @property
    def force(self):
        """Total contact force on the slave, (gdim); on the master it is the opposite [F]. Collective."""
        return self._sum(np.einsum("n,na->a", np.where(self.status > 0, self.weight, 0.0), self.traction))

    @property
    def moment(self):
        """Moment of the contact forces on the slave about the origin, (1) in the plane, (3) in space [F L].
        Collective."""
        local = np.where(self.status > 0, self.weight, 0.0)[:, None] * self.traction
        if local.shape[1] == 2:
            moments = (self.points[:, 0] * local[:, 1] - self.points[:, 1] * local[:, 0])[:, None]
        else:
            moments = np.cross(self.points, local)
        return self._sum(moments.sum(axis=0))

    @property
    def area(self):
        """Area in contact (2D: length), from the points that touch [L^2]. Collective."""
        return float(self._sum(np.sum(self.weight[self.status > 0])))

    def field(self, problem, values, name):
        """A nodal contact array as a function on the displacement's mesh, zero elsewhere, for ParaView.

        Args:
            problem: StaticProblem. values: one of the arrays, (n) or (n, gdim). name: of the function.
        """
        V = problem.space
        mesh, degree = V.mesh, V.element.basix_element.degree
        values = np.asarray(values, dtype=float)
        shape = values.shape[1:]
        f = fem.Function(fem.functionspace(mesh, ("Lagrange", degree, shape)), name=name)
        flat = f.x.array.reshape(-1, *shape)
        flat[self.nodes] = np.where(np.isfinite(values), values, 0.0)
        f.x.scatter_forward()
        return f
