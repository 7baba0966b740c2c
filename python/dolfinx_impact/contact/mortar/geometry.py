# SPDX-License-Identifier: MIT
"""Nodal gaps, normals and weights of a contact by multipliers: C++, MortarGeometry.h."""

from typing import Any

from ... import _cpp
from ...common.types import BoolArray


def make_geometry(spec: Any, V: Any, axisymmetric: bool, fixed: BoolArray) -> Any:
    """The C++ geometry of a pair. Collective.

    Args:
        spec: Lagrange.
        V: displacement space.
        axisymmetric: x is the radius.
        fixed: mask of prescribed dofs, owned and ghosts.
    """
    pair, gdim = spec.pair, V.mesh.geometry.dim
    slave, master = pair.surfaces(V)
    options = _cpp.multipliers.MortarOptions(
        name=pair.name, friction=pair.friction, basis=getattr(_cpp.gap.Multipliers, spec.basis),
        quadrature_degree=spec.quadrature_degree, search_distance=pair.search_distance or 0.0,
        axisymmetric=axisymmetric,
    )  # fmt: skip
    if pair.rigid:
        return _cpp.multipliers.RigidGeometry(V._cpp_object, slave, pair.rigid_master.obstacle(gdim), options, fixed)
    return _cpp.multipliers.DeformableGeometry(V._cpp_object, slave, master, options, fixed)
