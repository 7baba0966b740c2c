# SPDX-License-Identifier: MIT
"""Internal variables, stresses and expressions of the user's own in the bodies, averaged at the vertices."""

from __future__ import annotations

from collections.abc import Sequence

from dolfinx import fem
from dolfinx.mesh import Mesh

from ..forms.elasticity import STRESS
from ..forms.materials import stress_components
from ..assembly.history_field import HistoryField
from .names import AXES


def component_names(field: HistoryField, gdim: int) -> list[str]:
    """Names of the components of a field.

    Args:
        field: the field.
        gdim: dimension.

    Returns:
        The field's name for a number; stress_xx, ... for the stress; else the name with the number of each component.
    """
    if not field.shape:
        return [field.name]
    if field.name == STRESS:
        return [f"{field.name}_{AXES[i]}{AXES[j]}" for i, j in stress_components(gdim)]
    return [f"{field.name}_{k}" for k in range(field.shape[0])]


class BodyFields:
    """Fields of bodies; see FieldSource. A series has functions of one element, so that each component is a scalar.

    Args:
        mesh: mesh of the problem.
        fields: the fields.
        dimensions: dimension of each.
    """

    series = "materials"

    def __init__(self, mesh: Mesh, fields: Sequence[HistoryField], dimensions: Sequence[str]) -> None:
        self._fields, self.functions, self.dimensions = list(fields), [], []
        space = fem.functionspace(mesh, ("Lagrange", 1))
        for field, dimension in zip(self._fields, dimensions):
            names = component_names(field, mesh.geometry.dim)
            self.functions += [fem.Function(space, name=name) for name in names]
            self.dimensions += [dimension] * len(names)

    def update(self) -> None:
        """Set the functions to averages at the vertices. Collective."""
        first = 0
        for field in self._fields:
            bs = field.shape[0] if field.shape else 1
            values = field.at_nodes().x.array.reshape(-1, bs)
            for k in range(bs):
                self.functions[first + k].x.array[:] = values[:, k]
            first += bs
