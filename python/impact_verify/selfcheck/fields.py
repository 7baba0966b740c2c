# SPDX-License-Identifier: MIT
"""The fields of a space, plain or mixed: displacement, micro-rotation and others, and how they move rigidly."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
from dolfinx import fem

from dolfinx_impact import compat
from dolfinx_impact.common.types import FloatArray, IntArray
from dolfinx_impact.own_forms.own_form import OwnForm


@dataclass
class Field:
    """One field of a space.

    Args:
        number: number of the subspace; 0 in a space that is not mixed.
        space: its own space.
        dofs: degrees of freedom of the whole space that are its own, in the order of its space.
        degree: degree of the polynomials that it holds completely [1].
        continuous: whether the nodes on the boundary can be prescribed.
    """

    number: int
    space: fem.FunctionSpace
    dofs: IntArray
    degree: int
    continuous: bool

    @property
    def shape(self) -> tuple[int, ...]:
        """Shape of its values."""
        return tuple(
            self.space.element.basix_element.value_shape if self.space.dofmap.bs == 1 else (self.space.dofmap.bs,)
        )

    @property
    def num_components(self) -> int:
        """Number of components of a value."""
        return int(np.prod(self.shape, dtype=int))

    @property
    def nodal(self) -> bool:
        """Whether its degrees of freedom are values at nodes, the component the fastest."""
        return bool(self.space.element.interpolation_ident) and (self.space.dofmap.bs > 1 or not self.shape)

    @property
    def nodes(self) -> FloatArray:
        """Positions of its nodes, shape (num_nodes, gdim) [L]."""
        return self.space.tabulate_dof_coordinates()[:, : self.space.mesh.geometry.dim]

    def interpolate(self, f: Callable[[FloatArray], FloatArray]) -> FloatArray:
        """Values of its degrees of freedom.

        Args:
            f: function of places, shape (3, n), with values of shape (num_components, n), or (n) of a scalar.

        Returns:
            Values, shape (len(dofs)).
        """
        w = fem.Function(self.space)
        w.interpolate(f)
        return np.array(w.x.array)


def fields_of(V: fem.FunctionSpace) -> list[Field]:
    """Fields of a space.

    Args:
        V: space.

    Returns:
        One field per subspace of a mixed space; the space itself if it is not mixed.
    """
    if V.num_sub_spaces == 0 or V.dofmap.bs > 1 or V.num_sub_spaces == 1:
        dofs = np.arange(V.dofmap.bs * (V.dofmap.index_map.size_local + V.dofmap.index_map.num_ghosts))
        return [_field(0, V, dofs)]
    out = []
    for i in range(V.num_sub_spaces):
        space, dofs = compat.collapse(V.sub(i))
        out.append(_field(i, space, dofs.astype(np.int64)))
    return out


def _field(number: int, space: fem.FunctionSpace, dofs: IntArray) -> Field:
    element = space.ufl_element()
    continuous = not getattr(element, "discontinuous", False) and element.family_name in ("P", "Lagrange")
    return Field(number, space, dofs, int(element.embedded_subdegree), continuous)


def displacement_of(own: OwnForm, fields: list[Field]) -> Field | None:
    """The displacement among the fields.

    Args:
        own: what the user says.
        fields: fields of its space.

    Returns:
        The field that is named, or else the first vector with as many components as space has; None: there is none.

    Raises:
        ValueError: the number is no field's, or that of a field that is no displacement.
    """
    gdim = own.u.function_space.mesh.geometry.dim
    fitting = [f for f in fields if f.shape == (gdim,) and f.nodal]
    if own.displacement is None:
        return fitting[0] if fitting else None
    for f in fitting:
        if f.number == own.displacement:
            return f
    raise ValueError(f"displacement is {own.displacement}: no subspace of this number is a Lagrange vector")


def rotation_of(own: OwnForm, fields: list[Field]) -> Field | None:
    """The micro-rotation among the fields; None without one.

    Raises:
        ValueError: the number is no field's, or that of a field with another number of components.
    """
    if own.rotation is None:
        return None
    components = 1 if own.u.function_space.mesh.geometry.dim == 2 else 3
    for f in fields:
        if f.number == own.rotation and f.num_components == components and f.nodal:
            return f
    raise ValueError(f"rotation is {own.rotation}: no subspace of this number has {components} components")


def spins(dim: int) -> list[tuple[str, FloatArray]]:
    """Generators of rotations: name of the axis and W with W x = omega cross x.

    Args:
        dim: dimension of space.
    """
    if dim == 2:
        return [("in the plane", np.array([[0.0, -1.0], [1.0, 0.0]]))]
    out: list[tuple[str, FloatArray]] = []
    for axis in range(3):
        W = np.zeros((3, 3))
        i, j = (axis + 1) % 3, (axis + 2) % 3
        W[j, i], W[i, j] = 1.0, -1.0
        out.append((f"about x[{axis}]", W))
    return out


def rotation_matrix(W: FloatArray, angle: float) -> FloatArray:
    """Rotation by an angle with the generator of a spin (Rodrigues' formula)."""
    dim = len(W)
    return np.asarray(np.eye(dim) + np.sin(angle) * W + (1 - np.cos(angle)) * W @ W)
