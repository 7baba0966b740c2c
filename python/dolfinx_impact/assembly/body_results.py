# SPDX-License-Identifier: MIT
"""What problems of all kinds tell of their bodies."""

from __future__ import annotations

from typing import Any

from dolfinx.fem import Function

from ..common.collective import guard
from ..common.types import ArrayLike
from ..common.unique import Unique
from ..materials import Material
from .body_stress import BodyStress
from .cauchy_stress import VON_MISES
from ..forms.elasticity import STRESS
from .material_history import MaterialHistory, existing
from .history_field import HistoryField
from .resultant import Resultant, check_where, checked_point, dofs_of, resultant


class BodyResults(Unique):
    """Base of problems: stress and internal variables of their bodies.

    A derived class sets `_stress` and `_material_history`; None: no material has internal variables.
    """

    u: Function
    material: Material | None
    _stress: BodyStress
    _material_history: MaterialHistory | None

    def reactions(self) -> Function:
        """Forces of the supports on the bodies at prescribed degrees of freedom. Collective.

        Returns:
            Function on the displacement space [F].
        """
        raise NotImplementedError

    def reaction(self, where: Any = None, point: ArrayLike | None = None) -> Resultant:
        """Force and moment of supports on the bodies, from the residual of equilibrium. Collective.

        Args:
            where: one of the boundary conditions (a DirichletBC, or a PrescribedMotion), whose prescribed components
                count; or a pair (facet_tags, tag), all components at the nodes of these facets; None: all supports.
            point: point that the moment is about, (gdim); None: the origin [L].

        Returns:
            Resultant: `force`, (gdim) [F], and `moment`, (1) in the plane, (3) in space [F L], at
            deformed positions, of bodies of small strain alone at undeformed ones.

        Raises:
            TypeError: an argument is of the wrong type; on all ranks.
            ValueError: a condition or tags of another mesh or space; u is on a mixed space; on all ranks.
        """
        V = self.u.function_space
        with guard(V.mesh.comm, "reaction") as ranks:
            check_where(where, V)
            about = checked_point(point, V.mesh.geometry.dim)
            ranks.same(point=about.tolist(), tag=int(where[1]) if isinstance(where, tuple) else None)
        return resultant(self.u, self.material, self.reactions().x.array, dofs_of(where, V), about)

    @property
    def stress(self) -> HistoryField:
        """Cauchy stress at the quadrature points, components xx, yy, zz, xy and in space yz, xz [F/L^2].

        Raises:
            ValueError: the residual is the user's own, and its stress not known.
        """
        return self._stress.field(STRESS, self._material_history)

    @property
    def von_mises(self) -> HistoryField:
        """Von Mises' equivalent stress at the quadrature points [F/L^2].

        Raises:
            ValueError: the residual is the user's own, and its stress not known.
        """
        return self._stress.field(VON_MISES, self._material_history)

    @property
    def has_history(self) -> bool:
        """Whether a material has internal variables."""
        return self._material_history is not None

    @property
    def history(self) -> MaterialHistory:
        """Internal variables of the materials by name, at the present time; in static problems after the last converged
        step.

        Raises:
            ValueError: no material has any.
        """
        return existing(self._material_history)
