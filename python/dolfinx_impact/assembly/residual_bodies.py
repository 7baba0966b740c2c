# SPDX-License-Identifier: MIT
"""Bodies whose residual is a user's own, as loads see them."""

from typing import Any

import ufl
from dolfinx.mesh import Mesh

from ..forms.materials import check_hypothesis


class ResidualBodies:
    """What loads ask of the bodies they act on, in place of a material: hypothesis and density.

    Args:
        mesh: mesh of the bodies.
        hypothesis: hypothesis of the residual; None: its integrals have no weight of their own.
        density: density in UFL; None: not known [M/L^3].
        value: density as a number; None: it varies, or is not known [M/L^3].

    Raises:
        ValueError: the hypothesis is unknown, or does not fit the mesh.
    """

    cell_tags = None

    def __init__(self, mesh: Mesh, hypothesis: str | None, density: Any = None, value: float | None = None) -> None:
        if hypothesis is not None:
            check_hypothesis(hypothesis, mesh.geometry.dim)
        plane = "3d" if mesh.geometry.dim == 3 else "plane_strain"
        self._hypothesis, self._density, self.density = hypothesis or plane, density, value

    def hypothesis_on(self, mesh: Mesh) -> str:
        """Hypothesis of the bodies.

        Args:
            mesh: their mesh.
        """
        return self._hypothesis

    def parts(self) -> list[tuple[None, "ResidualBodies"]]:
        """All cells and these bodies."""
        return [(None, self)]

    def density_constant(self, mesh: Mesh) -> ufl.core.expr.Expr:
        """Density in UFL [M/L^3].

        Args:
            mesh: mesh of the bodies.

        Raises:
            ValueError: it is not known.
        """
        if self._density is None:
            raise ValueError(
                "a BodyForce per mass needs a density, which a residual of your own in a static problem has not: give "
                "the force per volume, per_mass=False"
            )
        return self._density
