# SPDX-License-Identifier: MIT
"""Means of a change of volume or of a strain at the nodes, of materials with integration="averaged_pressure" or
"averaged_strain"."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import ufl
from dolfinx import fem
from dolfinx.fem import Function
from dolfinx.mesh import Mesh

from .. import _cpp, compat
from ..forms import averaged_pressure, averaged_strain
from ..inelastic import InelasticMaterial
from ..materials import AVERAGED, AVERAGED_PRESSURE, AVERAGED_STRAIN, Material, _Material

LAWS = {AVERAGED_PRESSURE: averaged_pressure.LAWS, AVERAGED_STRAIN: averaged_strain.LAWS}
LAWS_OF_MEANS = {
    "linear_elastic": _cpp.operators.MeanLaw.linear_elastic,
    "neo_hookean": _cpp.operators.MeanLaw.neo_hookean,
}


class NodalMean(Function):
    """Means at the nodes of tr(eps), ln J or J, or of a strain, over the cells of one material; operators whose forms
    contain it compute it before every evaluation (operators/NodalAverage.h).

    Args:
        u: displacement function [L].
        material: material of the cells.
        dx: measure of its cells.
        name: name of the function.
        kind: elastic law in terms of the means (forms/averaged_pressure.py, averaged_strain.py); None: that of the
            material.

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

    def __init__(self, u: Function, material: _Material, dx: ufl.Measure, name: str, kind: Any = None) -> None:
        V, mesh = u.function_space, u.function_space.mesh
        hypothesis = material.hypothesis_on(mesh)
        degree, geometry_degree = V.element.basix_element.degree, compat.coordinate_element(mesh).degree
        averaged_pressure.check(mesh.topology.cell_name(), degree, geometry_degree, hypothesis, material.integration)
        if kind is None and not isinstance(material, InelasticMaterial):
            kind = _law_class(material, mesh)
        super().__init__(_space_of(u, 1 if kind is None else kind.num_means(mesh.geometry.dim)), name=name)
        self.displacement, self.material = u, material
        self.own_average: Any = None
        test = ufl.TestFunction(self.function_space)
        self.law: Any = None
        if isinstance(material, InelasticMaterial):
            kinematics = material.kinematics(mesh, degree)
            measured, self.is_linear = kinematics.dilatation(u), not kinematics.finite_strain
        else:
            law = material.elastic_law(mesh)
            self.law = kind(law.E, law.nu, hypothesis, self)
            measured, self.is_linear = self.law.measure(u), self.law.linear
        self.measure = averaged_pressure.average(measured, test, hypothesis, dx)
        self.volume = averaged_pressure.average(1, test, hypothesis, dx)


def _law_class(material: _Material, mesh: Mesh) -> Any:
    """Law in terms of means of an elastic material."""
    name, laws = material.elastic_law(mesh).name, LAWS[material.integration]
    if name not in laws:
        plastic = " and for plasticity" if material.integration == AVERAGED_PRESSURE else ""
        raise ValueError(
            f'integration="{material.integration}" is for the laws {", ".join(laws)}{plastic}: {name} has no '
            'volumetric part of its own, use integration="full"'
        )
    return laws[name]


def _space_of(u: Function, num_means: int) -> fem.FunctionSpace:
    """Functions of degree 1, one space for all means of a displacement that are as many at a node."""
    known = u.__dict__.setdefault("_spaces_of_means", {})
    if num_means not in known:
        element = ("Lagrange", 1) if num_means == 1 else ("Lagrange", 1, (num_means,))
        known[num_means] = fem.functionspace(u.function_space.mesh, element)
    space: fem.FunctionSpace = known[num_means]
    return space


def is_averaged(material: _Material) -> bool:
    """Whether a pressure or strain of a material is averaged at the nodes.

    Args:
        material: material of a body or of some of its cells.
    """
    return material.integration in AVERAGED


def tags_of(material: _Material, whole: Material) -> tuple[int, ...]:
    """Tags of the cells of a material; empty where it is that of all cells.

    Args:
        material: material of the cells.
        whole: material of the body.
    """
    return tuple(tag for tag, m in whole.parts() if m is material and tag is not None)


def mean_of(u: Function, material: _Material, whole: Material, dx: ufl.Measure, kind: Any = None) -> NodalMean:
    """Means at the nodes of the cells of a material: one function for all forms of a displacement. Collective.

    Tags that share a material have means over the cells of all of them. Other materials around a node have other means:
    the pressure of two materials is not the same.

    Args:
        u: displacement function [L].
        material: material of the cells.
        whole: material of the body.
        dx: measure of the body's cells.
        kind: as for NodalMean.

    Raises:
        ValueError: as NodalMean.
    """
    known = u.__dict__.setdefault("_means", {})
    tags = tags_of(material, whole)
    key = id(material), id(whole.cell_tags), tags, kind
    if key not in known:
        mean = NodalMean(u, material, dx(tags) if tags else dx, f"volume_change_{len(known)}", kind)
        known[key] = mean, whole  # the material lives as long as its number counts
    found: NodalMean = known[key][0]
    return found


@dataclass
class StrainParts:
    """Internal forces of a material with averaged strains in two parts.

    Attributes:
        cells: elastic law of the cells.
        mean: means of the strain or gradient at the nodes, which no kernel reads.
        stress: their stress, whose forces are added node by node (operators/LinearSums.h).
        moduli: of neo-Hooke's law: lambda, shear moduli of the nodes and of the cells, whose forces can be added
            together (operators/AveragedNeoHookean.h) [F/L^2]; None for other laws.
        tags: tags of the material's cells; empty: all cells.
    """

    cells: Any
    mean: NodalMean
    stress: _cpp.operators.MeanStress
    moduli: tuple[float, float, float] | None
    tags: tuple[int, ...]


def strain_parts(u: Function, material: _Material, whole: Material, dx: ufl.Measure) -> StrainParts:
    """Split the forces of a material with integration="averaged_strain". Collective.

    Args:
        u: displacement function [L].
        material: material of the cells.
        whole: material of the body.
        dx: measure of the body's cells.

    Raises:
        ValueError: as NodalMean.
    """
    law, moduli = material.elastic_law(u.function_space.mesh), None
    _law_class(material, u.function_space.mesh)  # refuses laws without a volumetric part
    of_cells, of_nodes = averaged_strain.SPLIT[law.name]
    lmbda, mu = averaged_strain.moduli_at_nodes(*material.lame)
    if hasattr(of_cells, "num_means"):
        cells = mean_of(u, material, whole, dx, of_cells).law
        moduli = lmbda, mu, averaged_strain.cells_shear_modulus(material.lame[1])
    else:
        cells = of_cells(law.E, law.nu, material.hypothesis_on(u.function_space.mesh))
    stress = _cpp.operators.MeanStress(LAWS_OF_MEANS[law.name], lmbda, mu)
    return StrainParts(cells, mean_of(u, material, whole, dx, of_nodes), stress, moduli, tags_of(material, whole))
