# SPDX-License-Identifier: MIT
"""Resultants of nodal forces: at supports, and across sections of bodies."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np
from dolfinx import fem
from dolfinx.fem import Function, FunctionSpace

from .. import _cpp
from ..common import arguments
from ..common.types import ArrayLike, FloatArray, IntArray
from ..inelastic import InelasticMaterial
from ..materials import LinearElastic, Material
from .fields import is_mixed


@dataclass(frozen=True, eq=False)
class Resultant:
    """Sum of nodal forces, the same on all ranks.

    Attributes:
        force: the force, (gdim) [F].
        moment: its moment about `point`, (1) in the plane, (3) in space: at the deformed positions, or of bodies of
            small strain alone at the undeformed ones, where theirs are in equilibrium [F L].
        point: the point, (gdim) [L].
    """

    force: FloatArray
    moment: FloatArray
    point: FloatArray


def checked_point(point: ArrayLike | None, gdim: int) -> FloatArray:
    """Check a point that moments are about, on this rank.

    Args:
        point: the argument; None: the origin.
        gdim: dimension of the mesh.

    Raises:
        TypeError: it is not made of numbers. ValueError: it has another number of finite components.
    """
    try:
        array = np.zeros(gdim) if point is None else np.asarray(point, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"point must be {gdim} numbers, found {point!r:.60}") from None
    if array.shape != (gdim,) or not np.all(np.isfinite(array)):
        raise ValueError(f"point must be {gdim} finite numbers, found {array.tolist()}")
    return array


def checked_tag(tag: Any) -> int:
    """Check a tag, on this rank.

    Args:
        tag: the argument.

    Raises:
        TypeError: it is no integer.
    """
    if isinstance(tag, bool) or not isinstance(tag, (int, np.integer)):
        raise TypeError(f"a tag must be an integer, found {tag!r:.60}")
    return int(tag)


def check_where(where: Any, V: FunctionSpace) -> None:
    """Check where forces are summed, on this rank.

    Args:
        where: None, a boundary condition, a PrescribedMotion, or a pair of facet tags and a tag.
        V: displacement space.

    Raises:
        TypeError: it is of another kind. ValueError: it is on another mesh or space; u is on a mixed space.
    """
    if is_mixed(V):
        raise ValueError("u is on a mixed space, whose components are no forces: take reactions(), its residual")
    if where is None:
        return
    if isinstance(where, tuple) and len(where) == 2 and hasattr(where[0], "find"):
        arguments.tags("reaction", where[0], V.mesh, V.mesh.topology.dim - 1)
        checked_tag(where[1])
        return
    bc = getattr(where, "bc", where)
    if not hasattr(bc, "dof_indices"):
        raise TypeError(
            "reaction takes a DirichletBC, a PrescribedMotion, a pair (facet_tags, tag) or None, found "
            f"{type(where).__name__}"
        )
    arguments.boundary_values("reaction", bc, V)


def dofs_of(where: Any, V: FunctionSpace) -> IntArray:
    """Degrees of freedom of this rank that check_where has accepted.

    Args:
        where: as of check_where.
        V: displacement space.
    """
    bs = V.dofmap.index_map_bs
    if where is None:
        return np.arange(V.dofmap.index_map.size_local * bs, dtype=np.int32)
    if isinstance(where, tuple):
        nodes = fem.locate_dofs_topological(V, where[0].dim, where[0].find(int(where[1])))
        return (bs * nodes[:, None] + np.arange(bs)).ravel().astype(np.int32)
    dofs: IntArray = getattr(where, "bc", where).dof_indices()[0]
    return dofs


def small_strain(material: Material | None) -> bool:
    """Whether all materials are of small strain, whose equilibrium is that of undeformed bodies.

    Args:
        material: material of the bodies; None: a residual of the user's own, which is not known to be.
    """
    if material is None:
        return False
    laws = [law for _, law in material.parts()]
    return all(
        isinstance(law, LinearElastic) or (isinstance(law, InelasticMaterial) and not law.finite_strain) for law in laws
    )


def resultant(
    u: Function, material: Material | None, forces: FloatArray, dofs: IntArray, point: FloatArray
) -> Resultant:
    """Sum nodal forces. Collective.

    Args:
        u: displacement [L].
        material: material of the bodies, which tells at which positions moments are taken.
        forces: forces, owned degrees of freedom first [F].
        dofs: degrees of freedom that count; those of other ranks do not.
        point: point that moments are about, (gdim) [L].
    """
    V, gdim = u.function_space, len(point)
    about = [*map(float, point), *[0.0] * (3 - gdim)]
    places = np.zeros_like(u.x.array) if small_strain(material) else u.x.array
    force, moment = _cpp.operators.resultant(
        V._cpp_object, places, np.ascontiguousarray(forces, dtype=float), dofs.astype(np.int32), about
    )
    return Resultant(np.array(force[:gdim]), np.array(moment[2:] if gdim == 2 else moment), point)
