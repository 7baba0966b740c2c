# SPDX-License-Identifier: MIT
"""Means of a change of volume at the nodes, of materials with integration="averaged_pressure"."""

from __future__ import annotations

from typing import Any

import ufl
from dolfinx import fem
from dolfinx.fem import Function

from .. import compat
from ..forms import averaged_pressure
from ..inelastic import InelasticMaterial
from ..materials import AVERAGED_PRESSURE, Material, _Material


class NodalMean(Function):
    """Means at the nodes of tr(eps), ln J or J over the cells of one material; operators whose forms contain it compute
    it before every evaluation (operators/NodalAverage.h).

    Args:
        u: displacement function [L].
        material: material of the cells.
        dx: measure of its cells.
        name: name of the function.

    Attributes:
        displacement: as `u`.
        material: as given.
        law: elastic law that reads the means; None for a material with internal variables.
        is_linear: whether what is averaged is linear in the displacement, as tr(eps).
        measure: form of rank 1 of what is averaged.
        volume: form of rank 1 of the volume that belongs to each node.
        own_average: what computes the means of the displacement function's values (C++), once it is made.

    Raises:
        ValueError: cells, hypothesis or law are not among those for which the pressure is averaged.
    """

    def __init__(self, u: Function, material: _Material, dx: ufl.Measure, name: str) -> None:
        V, mesh = u.function_space, u.function_space.mesh
        hypothesis = material.hypothesis_on(mesh)
        degree, geometry_degree = V.element.basix_element.degree, compat.coordinate_element(mesh).degree
        averaged_pressure.check(mesh.topology.cell_name(), degree, geometry_degree, hypothesis)
        super().__init__(_space_of(u), name=name)
        self.displacement, self.material = u, material
        self.own_average: Any = None
        test = ufl.TestFunction(self.function_space)
        self.law: Any = None
        if isinstance(material, InelasticMaterial):
            kinematics = material.kinematics(mesh, degree)
            measured, self.is_linear = kinematics.dilatation(u), not kinematics.finite_strain
        else:
            law = material.elastic_law(mesh)
            if law.name not in averaged_pressure.LAWS:
                raise ValueError(
                    f'integration="averaged_pressure" is for the laws {", ".join(averaged_pressure.LAWS)} and for '
                    f'plasticity: {law.name} has no volumetric part of its own, use integration="full"'
                )
            self.law = averaged_pressure.LAWS[law.name](law.E, law.nu, hypothesis, self)
            measured, self.is_linear = self.law.measure(u), self.law.linear
        self.measure = averaged_pressure.average(measured, test, hypothesis, dx)
        self.volume = averaged_pressure.average(1, test, hypothesis, dx)


def _space_of(u: Function) -> fem.FunctionSpace:
    """Scalar functions of degree 1, one space for all means of a displacement."""
    known = u.__dict__
    if "_space_of_means" not in known:
        known["_space_of_means"] = fem.functionspace(u.function_space.mesh, ("Lagrange", 1))
    space: fem.FunctionSpace = known["_space_of_means"]
    return space


def is_averaged(material: _Material) -> bool:
    """Whether the pressure of a material is averaged at the nodes.

    Args:
        material: material of a body or of some of its cells.
    """
    return material.integration == AVERAGED_PRESSURE


def mean_of(u: Function, material: _Material, whole: Material, dx: ufl.Measure) -> NodalMean:
    """Means at the nodes of the cells of a material: one function for all forms of a displacement. Collective.

    Tags that share a material have means over the cells of all of them. Other materials around a node have other means:
    the pressure of two materials is not the same.

    Args:
        u: displacement function [L].
        material: material of the cells.
        whole: material of the body.
        dx: measure of the body's cells.

    Raises:
        ValueError: as NodalMean.
    """
    known = u.__dict__.setdefault("_means", {})
    tags = tuple(tag for tag, m in whole.parts() if m is material and tag is not None)
    key = id(material), id(whole.cell_tags), tags
    if key not in known:
        mean = NodalMean(u, material, dx(tags) if tags else dx, f"volume_change_{len(known)}")
        known[key] = mean, whole  # the material lives as long as its number counts
    found: NodalMean = known[key][0]
    return found
