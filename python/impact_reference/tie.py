# SPDX-License-Identifier: MIT
"""Tied surfaces as docs/tie.md states them: the conditions as rows of a dense matrix, all multipliers kept as unknowns.

The integrals are those of the hand-written mortar contact in the reference configuration. Slave nodes must be free: the
text leaves to the code what becomes of multipliers at supports.
"""

from dataclasses import dataclass

import numpy as np

from .array_types import ArrayLike, FloatArray, Rule, floats, integers, vector
from .contact import Contact
from .discretisation import Discretisation


@dataclass
class TieSolution:
    """Result of `Tie.solve_static`."""

    u: FloatArray  # displacements (num_dofs) [L]
    multipliers: FloatArray  # tractions on the slave by node of the field (num_nodes, gdim) [F/L^2]
    force: FloatArray  # nodal forces of the tie on both bodies (num_dofs) [F]


class Tie:
    """Two parts of the surface of a Model that are tied to each other in all directions.

    Args:
        model: the bodies.
        slave: points of every slave facet, shape (num_facets, nodes per facet); its vertices suffice.
        master: points of every master facet, as `slave`.
        rule: as of Contact, for the intervals or triangles that the facets are divided into.

    Raises:
        ValueError: facets that are repeated or not on the boundary, or numbers out of range.
    """

    def __init__(self, model: Discretisation, slave: ArrayLike, master: ArrayLike, rule: Rule | float = None) -> None:
        self.model = model
        self.gdim = model.field_points.shape[1]
        found = Contact(model, slave, master, rule=rule).mortar(np.zeros(model.num_dofs))
        self.nodes = np.flatnonzero(found.participates)
        one = found.D.toarray()[self.nodes] - found.M.toarray()[self.nodes]
        #: rows of the conditions, node after node, component after component (num_nodes * gdim, num_dofs) [L^2]
        self.conditions: FloatArray = floats(np.kron(one, np.eye(self.gdim)))

    def solve_static(self, fixed_dofs: ArrayLike, values: ArrayLike, load: ArrayLike | None = None) -> TieSolution:
        """Solve the saddle point [K -C^T; C 0] of linear bodies.

        Args:
            fixed_dofs: prescribed degrees of freedom.
            values: their values, one for all or one each [L].
            load: nodal forces, shape (num_dofs); None for zero [F].

        Returns:
            Displacements, multipliers and forces.
        """
        fixed, C, n = integers(fixed_dofs, "fixed_dofs", 1), self.conditions, self.model.num_dofs
        f = np.zeros(n) if load is None else vector(load)
        u = np.zeros(n)
        u[fixed] = np.broadcast_to(floats(values), fixed.shape)
        free = np.setdiff1d(np.arange(n), fixed)
        K = self.model.stiffness().toarray()
        # Multipliers in units of the stiffness: the matrix is then well scaled.
        scale = np.abs(K.diagonal()).mean() / np.abs(C).max()
        A = np.zeros((len(free) + len(C),) * 2)
        A[: len(free), : len(free)] = K[np.ix_(free, free)]
        A[len(free) :, : len(free)] = scale * C[:, free]
        A[: len(free), len(free) :] = -scale * C[:, free].T
        b = np.concatenate([(f - K @ u)[free], -scale * (C @ u)])
        x = np.linalg.solve(A, b)
        x += np.linalg.solve(A, b - A @ x)
        u[free] = x[: len(free)]
        return self._solution(u, scale * x[len(free) :])

    def _solution(self, u: FloatArray, z: FloatArray) -> TieSolution:
        multipliers = np.zeros((len(self.model.field_points), self.gdim))
        multipliers[self.nodes] = z.reshape(-1, self.gdim)
        return TieSolution(u, multipliers, self.conditions.T @ z)

    def run_explicit(self, velocity: ArrayLike, dt: float, steps: int, fixed_dofs: ArrayLike = ()) -> list[TieSolution]:
        """Central differences of linear bodies without loads from rest in place: accelerations M a = C^T z - K u, with
        the z that keeps C a = 0, from a dense solution in every step.

        Args:
            velocity: at the start, in the null space of the conditions, shape (num_dofs) [L/T].
            dt: time step [T].
            steps: number of steps.
            fixed_dofs: degrees of freedom that stay.

        Returns:
            Displacements, multipliers and forces: those of the start of each step, with the displacement at its end.
        """
        K, C = self.model.stiffness(), self.conditions
        inverse = 1.0 / self.model.mass(lumped=True)
        inverse[integers(fixed_dofs, "fixed_dofs", 1)] = 0.0
        S = (C * inverse) @ C.T
        u: FloatArray = np.zeros(self.model.num_dofs)
        v, out = vector(velocity).copy(), []
        v[inverse == 0.0] = 0.0
        for k in range(steps):
            internal = K @ u
            z = floats(np.linalg.solve(S, C @ (inverse * internal)))
            v += (dt if k else 0.5 * dt) * inverse * (C.T @ z - internal)
            u = u + dt * v
            out.append(self._solution(u, z))
        return out
