# SPDX-License-Identifier: MIT
"""Fields of a mixed space: displacement and pressure, ...; components of a blocked one: displacement and rotation."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, TypeAlias

import numpy as np
import ufl
from dolfinx import default_scalar_type, fem
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import Mesh

from ..common import arguments
from ..common.types import IntArray

# Density in UFL; or one for each field of a mixed space, or component of a blocked one, None for one without inertia
# [M/L^3].
Density: TypeAlias = "ufl.core.expr.Expr | tuple[ufl.core.expr.Expr | None, ...]"


def is_mixed(V: FunctionSpace) -> bool:
    """Whether a space is mixed, so that its functions have several fields.

    Args:
        V: the space.
    """
    return bool(V.ufl_element().is_mixed)


def same_spaces(V: FunctionSpace, W: FunctionSpace) -> bool:
    """Whether functions of two spaces have the same degrees of freedom, on this rank.

    Args:
        V, W: the spaces.
    """
    # Mixed elements of DOLFINx cannot be compared, those of UFL can.
    return (
        V.mesh._cpp_object is W.mesh._cpp_object
        and V.ufl_element() == W.ufl_element()
        and np.array_equal(V.dofmap.list, W.dofmap.list)
    )


@dataclass(frozen=True)
class Field:
    """One field of a mixed space, or one component of a blocked one.

    Attributes:
        number: number of the sub-space.
        element: its element in UFL.
        first: first of its degrees of freedom in a cell.
        stride: distance of its degrees of freedom in a cell.
    """

    number: int
    element: Any
    first: int
    stride: int = 1

    @property
    def dofs(self) -> slice:
        """Its degrees of freedom in a cell."""
        return slice(self.first, self.first + self.stride * self.element.dim, self.stride)

    @property
    def is_lagrange(self) -> bool:
        """Whether its degrees of freedom are values at nodes."""
        element = self.element
        if element.is_mixed:
            return False
        return bool(element.family_name == "P")

    @property
    def degree(self) -> int:
        """Degree of its polynomials, per direction on quadrilaterals and hexahedra if it is of Lagrange's."""
        scalar = self.element.sub_elements[0] if self.element.block_size > 1 else self.element
        return int(scalar.basix_element.degree if self.is_lagrange else scalar.embedded_superdegree)

    def __str__(self) -> str:
        element = self.element
        if self.stride > 1:
            return f"component {self.number}"
        shape = tuple(element.reference_value_shape)
        what = "scalar" if not shape else f"{shape[0]} components" if len(shape) == 1 else f"values of shape {shape}"
        if element.is_mixed:
            return f"field {self.number} (mixed, {what})"
        family = "Lagrange" if self.is_lagrange else element.family_name
        return f"field {self.number} ({family} of degree {self.degree}, {what})"


def fields_of(V: FunctionSpace) -> list[Field]:
    """Fields of a mixed space, or components of a blocked one.

    Args:
        V: the space.

    Returns:
        One for each sub-space.
    """
    element = V.ufl_element()
    if not is_mixed(V):
        bs = int(element.block_size)
        return [Field(i, element.sub_elements[0], i, bs) for i in range(bs)] if bs > 1 else []
    first = np.cumsum([0, *(e.dim for e in element.sub_elements)])
    return [Field(i, e, int(first[i])) for i, e in enumerate(element.sub_elements)]


def field_dofs(V: FunctionSpace) -> list[IntArray]:
    """Owned degrees of freedom of every field of a mixed space, or component of a blocked one.

    Args:
        V: the space.

    Returns:
        Numbers of this rank, sorted, for each field.
    """
    bs = V.dofmap.index_map_bs
    num_owned = V.dofmap.index_map.size_local * bs
    if not is_mixed(V):
        return [np.arange(i, num_owned, bs) for i in range(bs)]
    dofs = [np.unique(V.dofmap.list[:, field.dofs]) for field in fields_of(V)]
    return [d[d < num_owned] for d in dofs]


def densities(given: Any, V: FunctionSpace) -> Density:
    """Densities that a user has given with a residual; for use under a guard.

    Args:
        given: number, function or UFL expression; a list with one of them for each field of a mixed space, which needs
            it, or for each component of a vector, 0 for a field without inertia [M/L^3].
        V: space of the displacement.

    Returns:
        Density, or densities.

    Raises:
        TypeError: `given` is none of these.
        ValueError: a number is not positive, or a mixed space has not one density for each field.
    """
    is_list, fields = isinstance(given, (list, tuple)), fields_of(V)
    if not is_list and not is_mixed(V):
        return _density(given, V.mesh)
    if is_list and len(V.value_shape) > 1 and not is_mixed(V):
        raise ValueError("the values of u are tensors: give one density for all components")
    if not is_list or len(given) != len(fields):
        names = f"fields, {', '.join(map(str, fields))}" if is_mixed(V) else "components"
        raise ValueError(
            f"u has {len(fields) or 1} {names}: give a density for each, density=[...], 0 for one without inertia; "
            f"found {given!r:.80}"
        )
    return tuple(None if _is_zero(d) else _density(d, V.mesh) for d in given)


def _is_zero(density: Any) -> bool:
    return not isinstance(density, (ufl.core.expr.Expr, str, bytes, bool)) and np.ndim(density) == 0 and density == 0


def _density(given: Any, mesh: Mesh) -> ufl.core.expr.Expr:
    if isinstance(given, ufl.core.expr.Expr):
        return given
    return fem.Constant(mesh, default_scalar_type(arguments.number("density", given, 0.0, " [M/L^3]")))


def check_inertia(density: Density, V: FunctionSpace, everywhere: bool, lumping: str | None) -> None:
    """Refuse fields whose inertia a problem cannot take; for use under a guard.

    Args:
        density: densities of fields or components, or one density.
        V: space of the displacement.
        everywhere: whether every field must have inertia: explicit steps divide by the mass.
        lumping: scheme of lumping; None: the mass is consistent.

    Raises:
        ValueError: a field has no inertia, or its element has no lumped mass.
    """
    if not isinstance(density, tuple):
        return
    for field, value in zip(fields_of(V), density):
        if value is None and everywhere:
            raise ValueError(
                f"{field} of u has no inertia, and explicit steps divide by the mass of every field: take "
                "NewmarkProblem, where a density of 0 is a field without inertia, or StaticProblem"
            )
        if value is not None and lumping is not None and not field.is_lagrange:
            raise ValueError(
                f"{field} of u has no lumped mass, which needs Lagrange elements: take NewmarkProblem with its "
                "consistent mass (lumping=None), or a Lagrange element"
            )
