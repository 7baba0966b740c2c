"""Nodal gaps, normals and weights of a contact by multipliers: against rigid obstacles, and by mortar integrals."""

import basix
import numpy as np
from mpi4py import MPI

from .. import _cpp
from .matrices import NodalSum, global_dofs, matrix, owned_rows


def _rule(shape, degree):
    """Points (flat) and weights of a rule on a reference facet."""
    points, weights = basix.make_quadrature(getattr(basix.CellType, shape), degree)
    return np.ascontiguousarray(points).ravel(), np.ascontiguousarray(weights)


class _Geometry:
    """Common part: the slave's nodes on this rank and what belongs to each.

    Attributes:
        nodes: (n) owned nodes of the slave surface. weight: (n) integral of the node's shape function over the part of
        the surface that faces a master [L^2]. participates: (n) mask. gap: (n) [L]. normal: (n, gdim).
        tolerance: gaps below it are none [L]. start: displacements at the beginning of the increment.
    """

    def __init__(self, spec, V, axisymmetric):
        self.pair, self.V, self.axisymmetric = spec.pair, V, axisymmetric
        self.comm, self.gdim = V.mesh.comm, V.mesh.geometry.dim
        self.slave, self.master = self.pair.surfaces(V)
        self.index_map = V.dofmap.index_map
        self.sum = NodalSum(self.index_map, 1)
        self.start = np.zeros(self.gdim * (self.index_map.size_local + self.index_map.num_ghosts))
        self.start_displacement = np.zeros(3)
        self.displacement = np.zeros(3)
        element = self.slave.displacement
        # Exact for the shape functions on flat, affine facets, with the radius as weight.
        points, weights = _rule(element.shape, 2 * element.degree + 2)
        self.whole = _cpp.gap.whole_facets(self.slave, points, weights, axisymmetric)
        mortar = _cpp.gap.mortar(self.slave, self.slave, self.whole, False, self.whole)
        full = np.zeros(len(self.sum._vector.array))
        np.add.at(full, self.slave.nodes.ravel(), mortar.share)
        share = self.sum(full).ravel()
        owned = share[: self.index_map.size_local]
        largest = self.comm.allreduce(float(np.max(share, initial=0.0)), MPI.MAX)
        # On quadratic triangles the shares of the corners vanish: the multipliers live at the midpoints of the edges.
        self.nodes = np.flatnonzero(owned > 1e-6 * largest)
        self.share = owned[self.nodes]
        self.rest = V.tabulate_dof_coordinates()[:, : self.gdim].copy()
        x = V.mesh.geometry.x
        low, high = np.min(x, axis=0, initial=np.inf), np.max(x, axis=0, initial=-np.inf)
        low, high = self.comm.allreduce(low, op=_MIN), self.comm.allreduce(high, op=_MAX)
        self.size = float(np.linalg.norm(high - low))
        self.tolerance = 1e-12 * self.size

    def begin(self, u, displacement):
        """An increment starts at u; the rigid master is to go to `displacement`."""
        self.start = np.array(u)
        self.start_displacement, self.displacement = self.displacement, np.array(displacement, dtype=float)

    def _move(self, u):
        u = np.ascontiguousarray(u)
        self.u = u
        self.slave.move(u)
        self.points = (self.rest + u.reshape(-1, self.gdim))[self.nodes]

    def diagonal_stiffness(self, K):
        """Mean diagonal entry of each slave node's block [F/L]."""
        diagonal = K.getDiagonal()
        values = np.abs(diagonal.array.reshape(-1, self.gdim)[self.nodes]).mean(axis=1)
        diagonal.destroy()
        return values


_MIN = MPI.Op.Create(lambda a, b: np.minimum(a, b), commute=True)
_MAX = MPI.Op.Create(lambda a, b: np.maximum(a, b), commute=True)


class RigidGeometry(_Geometry):
    """The slave's nodes against an obstacle whose gap is known in closed form."""

    def __init__(self, spec, V, axisymmetric, fixed):
        super().__init__(spec, V, axisymmetric)
        self.obstacle = self.pair.master._obstacle(self.gdim)
        self.weight, self.participates = self.share, np.ones(len(self.nodes), dtype=bool)

    def update(self, u):
        """Gaps and normals at u. Collective."""
        self._move(u)
        self.obstacle.displacement = self.displacement.tolist()
        self.gap, self.normal, self.hessian = self.obstacle.evaluate(np.ascontiguousarray(self.points).ravel())

    def slip(self):
        """Tangential displacement of the nodes against the obstacle in this increment, (n, gdim) [L]."""
        moved = (self.u - self.start).reshape(-1, self.gdim)[self.nodes]
        moved = moved - (self.displacement - self.start_displacement)[: self.gdim]
        return moved - np.einsum("na,nb,nb->na", self.normal, self.normal, moved)

    def master_rows(self, rows):
        """No master nodes."""
        return np.zeros(len(rows) + 1, dtype=int), np.empty(0, dtype=int), np.empty(0)

    def add_stiffness(self, K, multiplier, traction, active):
        """The normal turns where a node slides over a curved obstacle: K - D lambda d n/dx. Collective."""
        rows = np.flatnonzero(active & (multiplier != 0.0))
        blocks = -(self.weight * multiplier)[rows, None, None] * self.hessian[rows]
        dofs = global_dofs(self.index_map, self.nodes[rows], self.gdim).astype(np.int32)
        for d, block in zip(dofs, blocks):
            K.setValues(d, d, block, addv=True)
        K.assemble()
        return K

    def forces(self, traction):
        """Nodal forces on the slave, array over owned dofs [F]."""
        out = np.zeros((self.index_map.size_local, self.gdim))
        out[self.nodes] = self.weight[:, None] * traction
        return out.ravel()


class MortarGeometry(_Geometry):
    """Weighted gaps between two deformable surfaces."""

    def __init__(self, spec, V, axisymmetric, fixed):
        super().__init__(spec, V, axisymmetric)
        raise NotImplementedError


__all__ = ["MortarGeometry", "RigidGeometry", "matrix", "owned_rows"]
