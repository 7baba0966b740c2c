# SPDX-License-Identifier: MIT
"""Warning about cells that lock where plastic flow keeps the volume."""

import warnings

from dolfinx.fem import Function

from ..forms import quadrature
from ..inelastic import InelasticMaterial
from ..materials import FULL, Material


class Locking(UserWarning):
    """Cells of degree 1 lock where plastic flow keeps the volume."""


def warn_of_locking(u: Function, material: Material) -> None:
    """Warn on rank 0, once for a problem, if inelastic materials are on tetrahedra or triangles of degree 1.

    Their strain is constant, and a mesh of them has too few degrees of freedom to keep the volume of every cell. In
    plane stress nothing keeps the area, and with integration="averaged_pressure" nodes do instead of cells.

    Args:
        u: displacement function.
        material: material of the bodies.
    """
    V = u.function_space
    mesh, cell = V.mesh, V.mesh.topology.cell_name()
    if cell not in quadrature.SIMPLICES or V.element.basix_element.degree > 1:
        return
    inelastic = any(isinstance(m, InelasticMaterial) and m.integration == FULL for _, m in material.parts())
    if not inelastic or material.hypothesis_on(mesh) == "plane_stress" or mesh.comm.rank != 0:
        return
    other, better = ("tetrahedra", "hexahedra") if cell == "tetrahedron" else ("triangles", "quadrilaterals")
    warnings.warn(
        f"{other} of degree 1 lock where plastic flow keeps the volume: the body is too stiff, its stress oscillates; "
        f'take integration="averaged_pressure" for the material, {other} of degree 2, or {better}',
        Locking,
        stacklevel=3,
    )
