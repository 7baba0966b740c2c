# SPDX-License-Identifier: MIT
"""Stress at the nodes of a rail joint, evaluated many times."""

from __future__ import annotations

from typing import Any

import numpy as np
import ufl
from dolfinx import fem, la

from dolfinx_impact.assembly.operators import PointValues
from dolfinx_impact.common.types import FloatArray
from .model import PATH_TAG, JointModel
from .wheel import HUB_TAGS, RIM_TAG

# Along, across and normal to the rail, and the shear in its plane.
NAMES = ("von_mises", "sigma_xx", "sigma_yy", "sigma_zz", "tau_xz")


class NodalStress:
    """Von Mises stress and four components at the nodes: means over the cells at a node that are of the same part.

    Parts are the wheel, the steel of rails and bars, the end post and the insulating layer: where two of them meet, a
    node has the larger von Mises stress. Cauchy's stress; on the wheel from the first one of Piola and Kirchhoff.

    Args:
        model: the joint.
        u: displacement, read at each evaluation [m].
    """

    def __init__(self, model: JointModel, u: fem.Function) -> None:
        self._model, self._u = model, u
        mesh, materials = model.mesh, model.material.materials
        F = ufl.Identity(3) + ufl.grad(u)
        laws: dict[int, Any] = {RIM_TAG: materials[RIM_TAG].stress(u) * F.T / ufl.det(F)}
        for name in ("end_post", "glue"):
            laws[model.tags[name]] = materials[model.tags[name]].stress(u)
        W = fem.functionspace(mesh, ("DG", 0))
        stress = model.rail_law.stress(u)
        self._parts = [np.setdiff1d(model.cell_tags.indices, self._cells((*laws, *HUB_TAGS)))]
        for tag, law in laws.items():
            marker = fem.Function(W)
            cells = self._cells((RIM_TAG, *HUB_TAGS) if tag == RIM_TAG else (tag,))
            marker.x.array[W.dofmap.list[cells, 0]] = 1.0
            stress = ufl.conditional(ufl.gt(marker, 0.5), law, stress)
            self._parts.append(cells)
        self.space = fem.functionspace(mesh, ("Lagrange", 1))
        vertices = self.space.element.basix_element.points
        self._values = PointValues(stress, vertices)
        self._num_cells = mesh.topology.index_map(3).size_local
        self._part_of = np.zeros(self._num_cells, dtype=np.int32)
        for k, cells in enumerate(self._parts):
            self._part_of[cells[cells < self._num_cells]] = k
        self._dofs = self.space.dofmap.list[: self._num_cells]
        self._sum = fem.Function(self.space)
        ones = np.ones(self._dofs.shape)
        self._counts = [self._summed(k, ones).copy() for k in range(len(self._parts))]  # cells of a part at each node

    def _cells(self, tags: tuple[int, ...]) -> Any:
        return self._model.cell_tags.indices[np.isin(self._model.cell_tags.values, tags)]

    def evaluate(self, history: Any = None) -> dict[str, fem.Function]:
        """Stress of the present displacement. Collective.

        Args:
            history: of the materials near the path (`problem.history`); None: all are elastic.

        Returns:
            Functions of degree 1 by name, of NAMES [Pa].
        """
        sigma = self._values.values()
        s = sigma.reshape(*sigma.shape[:2], 3, 3)
        deviator = s - np.trace(s, axis1=2, axis2=3)[..., None, None] / 3.0 * np.eye(3)
        values = {
            "von_mises": np.sqrt(1.5 * np.einsum("cpij,cpij->cp", deviator, deviator)),
            "sigma_xx": s[..., 0, 0], "sigma_yy": s[..., 1, 1], "sigma_zz": s[..., 2, 2], "tau_xz": s[..., 0, 2],
        }  # fmt: skip
        if history is not None:
            yielding = self._model.cell_tags.find(PATH_TAG)
            yielding = yielding[yielding < self._num_cells]
            stress = history["stress"].values[yielding].mean(axis=1)
            for name, k in (("sigma_xx", 0), ("sigma_yy", 1), ("sigma_zz", 2), ("tau_xz", 5)):
                values[name][yielding] = stress[:, k, None]
            values["von_mises"][yielding] = history["von_mises"].values[yielding].mean(axis=1)[:, None]
        return {name: self._average(name, v) for name, v in values.items()}

    def _summed(self, part: int, values: FloatArray) -> FloatArray:
        """Sums of values at the vertices of the cells of a part over these cells, at the nodes. Collective."""
        x, cells = self._sum.x, self._part_of == part
        x.array[:] = np.bincount(self._dofs[cells].ravel(), values[cells].ravel(), len(x.array))
        x.scatter_reverse(la.InsertMode.add)
        x.scatter_forward()
        return x.array

    def _average(self, name: str, values: FloatArray) -> fem.Function:
        out = fem.Function(self.space, name=name)
        for k, count in enumerate(self._counts):
            mean = np.divide(self._summed(k, values), count, out=np.zeros_like(count), where=count > 0.0)
            larger = np.abs(mean) > np.abs(out.x.array)
            out.x.array[larger] = mean[larger]
        return out
