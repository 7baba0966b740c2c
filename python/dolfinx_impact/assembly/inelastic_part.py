# SPDX-License-Identifier: MIT
"""Cells of one inelastic material: internal force with its point law, tangent with the history as functions."""

from __future__ import annotations

from collections.abc import Iterator
from typing import Any

import numpy as np
import ufl
from dolfinx.fem import Function
from dolfinx.mesh import Mesh

from ..common.types import FloatArray, IntArray
from ..forms import consistent_tangent, inelastic
from ..forms.averaged_pressure import AveragedKinematics
from ..forms.one_point_flow import OnePointResponse
from ..forms.point_law import PointLaw
from ..inelastic import InelasticMaterial
from ..materials import REDUCED, Material
from .jit import compile_form
from .nodal_mean import NodalMean, is_averaged, mean_of
from .operators import BilinearKernels, cells_measure
from .point_values import PointHistory


def quadrature_element(mesh: Mesh, shape: tuple[int, ...], degree: int) -> Any:
    """Element with values at the points of the rule that forms of a quadrature degree have.

    Args:
        mesh: mesh.
        shape: shape of a value, () or (n,).
        degree: quadrature degree [1].
    """
    return inelastic.quadrature_element(mesh.basix_cell(), shape, degree)


class InelasticPart:
    """Cells of one inelastic material.

    The kernels know history and unknowns as symbols, whose values they keep themselves (operators/PointHistory.h).

    Args:
        u: displacement function [L].
        material: material of the cells.
        dx: UFL measure of the cells, with the quadrature degree.
        degree: that quadrature degree [1].
        tag: tag of the cells; None: all cells.
        whole: material of the body, of which these cells are a part; None: they are all of it.

    Attributes:
        mean: means of the change of volume at the nodes, or None.
        kinematics: strains that the law sees.
        response: the law.
        symbols: symbols of its history and unknowns.
    """

    def __init__(
        self,
        u: Function,
        material: InelasticMaterial,
        dx: ufl.Measure,
        degree: int,
        tag: int | None,
        whole: Material | None = None,
    ) -> None:
        V = u.function_space
        self.u, self.material, self.dx, self.degree, self.tag, self.mesh = u, material, dx, degree, tag, V.mesh
        self.kinematics = material.kinematics(V.mesh, V.element.basix_element.degree)
        self.mean: NodalMean | None = None
        if is_averaged(material):
            whole = material if whole is None else whole
            self.mean = mean_of(u, material, whole, cells_measure(u, whole)[0])
            finite = material.finite_strain
            self.kinematics = AveragedKinematics(material.hypothesis_on(V.mesh), finite, self.mean)
        self.response = material.response(V.mesh)
        if material.integration == REDUCED:
            self.response = OnePointResponse(self.response, V.mesh.geometry.dim)
        self.symbols = inelastic.Symbols(self.response, V.mesh.ufl_domain(), degree)

    @property
    def history(self) -> dict[str, ufl.Coefficient]:
        """Symbols of the history by name."""
        return self.symbols.history

    def force(self, v: ufl.Argument, with_stress: bool = False) -> tuple[ufl.Form, PointLaw]:
        """Internal virtual work and the point law of its kernel.

        Args:
            v: test function.
            with_stress: whether the Cauchy stress is an output, "stress".
        """
        return inelastic.force_and_law(self.u, v, self.response, self.kinematics, self.symbols, self.dx, with_stress)

    def tangent_form(self) -> tuple[ufl.Form, dict[Any, str]]:
        """Form of rank 1 of the consistent tangent in a direction, and names of the coefficients that stand for
        history, local unknowns and the direction.

        Raises:
            ValueError: the stress has a maximum over a cell, which has no derivative.
        """
        V = self.u.function_space
        du, v = Function(V, name=consistent_tangent.DIRECTION), ufl.TestFunction(V)
        of_law = self.response, self.kinematics, self.symbols
        return (
            consistent_tangent.consistent_tangent(self.u, du, v, *of_law, self.dx),
            consistent_tangent.names_of(self.symbols, du),
        )

    def tangent(self, history: PointHistory) -> BilinearKernels:
        """Kernels of the consistent tangent. Collective.

        Args:
            history: internal variables of the force's kernels.

        Raises:
            ValueError: as tangent_form.
        """
        form, names = self.tangent_form()
        fields = {symbol: name for symbol, name in names.items() if name != consistent_tangent.DIRECTION}
        own = history.of_tag(-1 if self.tag is None else self.tag)
        return BilinearKernels(form, compile_form(form, names), fields, own)

    def elastic_tangent(self, du: ufl.Argument, v: ufl.Argument) -> ufl.Form:
        """Stiffness of the elastic part in the deformed shape, an upper bound of the inelastic one.

        Args:
            du: trial function.
            v: test function.
        """
        return inelastic.elastic_tangent(self.u, du, v, self.material.elastic_law(self.mesh), self.kinematics, self.dx)


def set_values(f: Function, cells: IntArray, values: FloatArray) -> None:
    """Set a function on a quadrature element.

    Args:
        f: the function.
        cells: owned cells, (n).
        values: values at their points, (n, num_points, num_components).
    """
    dofmap = f.function_space.dofmap
    num = dofmap.list.shape[1]  # not -1: a rank may have no cells
    f.x.array.reshape(-1, dofmap.bs)[dofmap.list[cells]] = np.asarray(values).reshape(len(cells), num, dofmap.bs)


class InelasticParts:
    """Inelastic parts of a body.

    Args:
        u: displacement function [L].
        material: material of the body.
    """

    def __init__(self, u: Function, material: Material) -> None:
        self.material = material
        dx, degree = cells_measure(u, material)
        self._parts = [
            InelasticPart(u, m, dx if tag is None else dx(tag), degree, tag, material)
            for tag, m in material.parts()
            if isinstance(m, InelasticMaterial)
        ]

    def __len__(self) -> int:
        return len(self._parts)

    def __iter__(self) -> Iterator[InelasticPart]:
        return iter(self._parts)

    def force(self, v: ufl.Argument) -> tuple[ufl.Form, PointLaw | dict[int, PointLaw]]:
        """Internal virtual work of the parts, and the laws of its kernels: one, or by cell tag.

        Args:
            v: test function.
        """
        found = [(part.tag, *part.force(v)) for part in self._parts]
        form = sum(f for _, f, _ in found)
        if found[0][0] is None:
            return form, found[0][2]
        return form, {tag: law for tag, _, law in found if tag is not None}

    def elastic_tangent(self, du: ufl.Argument, v: ufl.Argument) -> ufl.Form:
        """Sum of InelasticPart.elastic_tangent.

        Args:
            du: trial function.
            v: test function.
        """
        return sum(part.elastic_tangent(du, v) for part in self._parts)
