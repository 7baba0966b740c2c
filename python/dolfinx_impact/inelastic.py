# SPDX-License-Identifier: MIT
"""Materials with internal variables: what a law of one's own must say, and what problems ask of it."""

from __future__ import annotations

from typing import Any

from dolfinx.mesh import Mesh

from .forms import inelastic
from .forms import materials as laws
from .forms.one_point_flow import OnePointKinematics
from .materials import AVERAGED_STRAIN, FULL, REDUCED, _Material

# What `respond` of a law of one's own returns, and its `flow`.
MaterialUpdate = inelastic.Update
MaterialFlow = inelastic.Flow


class InelasticMaterial(_Material):
    """Material with internal variables at the quadrature points; base class of J2Plasticity and of laws of your own.

    A law of your own derives from it, sets `history` and `unknown`, and writes `respond`. See docs/plasticity.md and
    demos/own_plasticity.py.

    Args:
        E: Young's modulus of the elastic part, positive [F/L^2].
        nu: Poisson's ratio of the elastic part, between -1 and 0.5, both excluded [1].
        density: None where no mass is asked for [M/L^3].
        hypothesis: "3d" (default on 3D meshes), "plane_strain", "plane_stress", "axisymmetric".
        integration: "full"; "reduced", one point and hourglass control, on quadrilaterals and hexahedra of degree 1,
            for laws whose update has the flow of a step, `MaterialUpdate(..., flow=MaterialFlow(...))`
            (docs/one_point.md); or "averaged_pressure", for laws that give the mean stress of their update, on
            tetrahedra and triangles of degree 1. Averaged strains are refused.

    Attributes:
        finite_strain: whether the law sees the deformation gradient instead of the small strain.
        history: shape of every internal variable by name; all are zero in the virgin state.
        unknown: shape of the unknown of the local equations, () or (n,); None for a law in closed form.
        average: whether the law sees the mean dilatation of each cell (B-bar, F-bar): True, False; "linear", the
            projection of the dilatation on linear functions of each cell; or "auto", the mean on quadrilaterals and
            hexahedra of degree 1 and the projection on those of degree 2, which lock without. With one point it does
            not count: the law sees the mean of the whole gradient.

    Raises:
        TypeError: a value that is not a number.
        ValueError: a value outside its range; the message says which and what to do.
    """

    finite_strain: bool = False
    average: bool | str = "auto"

    history: dict[str, tuple[int, ...]] = {}
    unknown: tuple[int, ...] | None = None

    def _check_integration(self, integration: str, hypothesis: str | None) -> None:
        if integration == AVERAGED_STRAIN:
            raise ValueError(
                f"{type(self).__name__} has internal variables, in the cells: strains averaged at the nodes "
                "(integration='averaged_strain') would need histories of the nodes' own. Take "
                "integration='averaged_pressure', which does not lock"
            )
        super()._check_integration(integration, hypothesis)

    def respond(self, strain: Any, history: dict[str, Any], unknown: Any) -> inelastic.Update:
        """Stress and new history at a point, in UFL; a law of one's own writes this.

        Args:
            strain: small strain, or with `finite_strain` the deformation gradient, 3 x 3 [1].
            history: committed values by the names of `history`.
            unknown: unknown of the local equations, of the shape of `unknown`; None without.

        Raises:
            TypeError: the material does not say how it responds.
        """
        raise TypeError(f"{type(self).__name__} does not say how it responds: write its method `respond`")

    def response(self, mesh: Mesh) -> inelastic.PointResponse:
        """The law in UFL (forms/inelastic.py) on a mesh: the material itself, or an object with constants of the mesh.

        Args:
            mesh: mesh.
        """
        return self

    def law(self, mesh: Mesh) -> laws.Law:
        """Elastic laws only: there is no stress without the history.

        Raises:
            TypeError: always.
        """
        raise TypeError(
            f"{type(self).__name__} has internal variables: its stress needs their history. Give the material to a "
            "problem, and read `problem.history` and `problem.stress`"
        )

    def elastic_law(self, mesh: Mesh) -> laws.Law:
        """The elastic part, of small strain; for bounds of the stable step and for bulk viscosity."""
        integration = REDUCED if self.integration == REDUCED else FULL
        E, nu = self._constant(mesh, "E", self.E), self._constant(mesh, "nu", self.nu)
        return laws.LinearElastic(E, nu, self.hypothesis_on(mesh), integration)

    def kinematics(self, mesh: Mesh, degree: int) -> inelastic.Kinematics:
        """Strains that the law sees on a mesh.

        Args:
            mesh: mesh.
            degree: degree of the displacement space [1].
        """
        if self.integration == REDUCED:
            return OnePointKinematics(mesh.ufl_domain(), self.elastic_law(mesh), self.finite_strain)
        cell, average = mesh.topology.cell_name(), self.average
        if average == "auto":
            average = inelastic.default_average(cell, degree)
        elif average == "linear" and (degree != 2 or cell not in ("quadrilateral", "hexahedron")):
            raise ValueError(
                f'average="linear" is for quadrilaterals and hexahedra of degree 2, these are {cell} cells of degree '
                f'{degree}: use "auto"'
            )
        return inelastic.Kinematics(self.hypothesis_on(mesh), self.finite_strain, average)

    def constant(self, mesh: Mesh, name: str, value: float) -> Any:
        """A number as a UFL constant of a mesh; it is made once, so that it may be changed and kernels are kept.

        Args:
            mesh: mesh.
            name: name of the constant.
            value: its value.
        """
        return self._constant(mesh, name, value)
