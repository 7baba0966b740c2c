# SPDX-License-Identifier: MIT
"""Inertia of the flow of material through a mesh, as a load of a static problem; seed (3.53)-(3.57), corrected."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import MeshTags

from .. import _cpp
from ..assembly import operators
from ..common.types import FloatArray, IntArray
from ..forms import ale
from ..inelastic import InelasticMaterial
from ..materials import Material
from .motions import Spin, Translation


class Flow:
    """Forces of inertia of bodies whose material moves steadily, as a load: their derivative is W. Load steps run
    through the rates, which rolling::Flow in C++ has, too.

    Args:
        u: displacement function [L].
        material: material, with densities.
        cell_tags: tags of the bodies.
        motions: motion by tag.
    """

    def __init__(
        self, u: fem.Function, material: Material, cell_tags: MeshTags, motions: Mapping[int, Spin | Translation]
    ) -> None:
        V, mesh = u.function_space, u.function_space.mesh
        self._material, self._motions = material, dict(motions)
        self._cell_tags = cell_tags
        # A motion that several tags have is one, with one rate.
        self._distinct = list(dict.fromkeys(self._motions.values()))
        self._constants = {motion: motion.constant(mesh) for motion in self._distinct}
        # Indicators, as materials may bring tags of their own, and a form takes one set of tags.
        self._indicators: dict[int, Any] = {tag: 1 for tag in self._motions}
        if len(self._motions) > 1:
            piecewise = fem.functionspace(mesh, ("DG", 0))
            for tag in self._motions:
                self._indicators[tag] = fem.Function(piecewise)
                self._indicators[tag].x.array[cell_tags.find(tag)] = 1.0
                self._indicators[tag].x.scatter_forward()
        self._nodes = {tag: np.unique(V.dofmap.list[cell_tags.find(tag)]) for tag in self._motions}
        moving = [motion.in_cpp(self._constants[motion], self.nodes_of(motion)) for motion in self._distinct]
        self._cpp_object = _cpp.rolling.Flow(V._cpp_object, moving)

    def number_of(self, motion: Spin | Translation) -> int:
        """Number of a motion among those of the flow in C++.

        Args:
            motion: one of the motions.
        """
        return self._distinct.index(motion)

    def rate_of(self, motion: Spin | Translation) -> FloatArray:
        """Present rate of a motion: an angular velocity [1/T], or a velocity [L/T].

        Args:
            motion: one of the motions.
        """
        return np.array(self._constants[motion].value)

    def set_creepage(self, lateral: float, turn: float) -> None:
        """Set the creepages besides those of the motions.

        Args:
            lateral: speed of the first spinning body along its axis against the other, over the speed [1].
            turn: turn of that body about the contact's normal that points into it, over the speed [1/L].
        """
        self._cpp_object.lateral, self._cpp_object.turn = lateral, turn

    @property
    def motions(self) -> dict[int, Spin | Translation]:
        """Motion by cell tag."""
        return self._motions

    def cells_of(self, tag: int) -> IntArray:
        """Cells with a tag, owned and ghosts.

        Args:
            tag: cell tag of a motion.
        """
        return self._cell_tags.find(tag)

    def nodes_of(self, motion: Spin | Translation) -> IntArray:
        """Nodes of the bodies with a motion, owned and ghosts.

        Args:
            motion: one of the motions.
        """
        parts = [nodes for tag, nodes in self._nodes.items() if self._motions[tag] is motion]
        return np.unique(np.concatenate(parts)).astype(np.int32)

    def same_on_all_ranks(self) -> list[Any]:
        """What must be the same on all ranks."""
        return [self._motions]

    def update(self) -> None:
        """Take over the present rates of the motions."""
        for motion, constant in self._constants.items():
            constant.value = motion.rate

    def form(self, u: fem.Function, v: Any, material: Any) -> ufl.Form:
        """Virtual work of the forces of inertia: at the deformed place for a spin, so that its derivative is W.

        Args:
            u: displacement function [L].
            v: test function.
            material: material of the bodies.
        """
        mesh = u.function_space.mesh

        def inertia(motion: Spin | Translation, constant: Any, density: Any, dx: Any) -> Any:
            if isinstance(motion, Spin):
                w = motion.velocity(mesh, constant)
                return ale.centrifugal_load(v, density, w, dx) + ale.ale_inertia(u, v, density, w, dx)
            # A straight flow without deformation has no acceleration: no load at zero displacement.
            return ale.ale_inertia(u, v, density, constant, dx)

        # Kernels of laws with internal variables have one quadrature rule, that of the stiffness.
        inelastic = any(isinstance(m, InelasticMaterial) for _, m in material.parts())
        return self._sum(inertia, u, material, not inelastic)

    def softening(self, u: fem.Function, du: Any, v: Any) -> ufl.Form:
        """Bilinear form W; seed (3.57).

        Args:
            u: displacement function [L].
            du: trial function.
            v: test function.
        """
        return ufl.derivative(self.form(u, v, self._material), u, du)

    def gyroscopic(self, u: fem.Function, du: Any, v: Any) -> ufl.Form:
        """Bilinear form G, skew-symmetric; seed (3.56).

        Args:
            u: displacement function [L].
            du: trial function.
            v: test function.
        """
        mesh = u.function_space.mesh

        def gyro(motion: Spin | Translation, constant: Any, density: Any, dx: Any) -> Any:
            w = motion.velocity(mesh, constant) if isinstance(motion, Spin) else constant
            return ale.gyroscopic(du, v, density, w, dx)

        return self._sum(gyro, u, self._material)

    def momentum(self, u: fem.Function, v: Any) -> ufl.Form:
        """Linear form of the momentum of the material, whose velocity is w + (Grad u) w.

        Args:
            u: displacement function [L].
            v: test function.
        """
        mesh = u.function_space.mesh

        def flowing(motion: Spin | Translation, constant: Any, density: Any, dx: Any) -> Any:
            w = motion.velocity(mesh, constant) if isinstance(motion, Spin) else constant
            return density * ufl.inner(w + ufl.grad(u) * w, v) * dx

        return self._sum(flowing, u, self._material)

    def direction(self, u: fem.Function, du: Any, v: Any) -> ufl.Form:
        """Bilinear form of the derivative along the flow as the material sees it, without the turn of vectors: its
        sign on a complex mode is the direction in which the wave travels.

        Args:
            u: displacement function [L].
            du: trial function.
            v: test function.
        """
        mesh = u.function_space.mesh

        def along(motion: Spin | Translation, constant: Any, density: Any, dx: Any) -> Any:
            if isinstance(motion, Translation):
                return density * ufl.inner(ufl.grad(du) * constant, v) * dx
            w = motion.velocity(mesh, constant)
            return density * ufl.inner(ufl.grad(du) * w - motion.turned(du, constant), v) * dx

        return self._sum(along, u, self._material)

    def mass(self, u: fem.Function, du: Any, v: Any) -> ufl.Form:
        """Bilinear form of the mass.

        Args:
            u: displacement function [L].
            du: trial function.
            v: test function.
        """
        mesh = u.function_space.mesh
        return operators.sum_materials(
            u, self._material, lambda m, dx: m.mass_density(mesh) * ufl.inner(du, v) * dx, inertia=True
        )

    def _sum(
        self, term: Callable[[Any, Any, Any, Any], Any], u: fem.Function, material: Material, exact: bool = True
    ) -> Any:
        """Sum of a term over materials and motions, with the quadrature rule of the mass if it is to be exact."""
        mesh = u.function_space.mesh
        return operators.sum_materials(
            u,
            material,
            lambda m, dx: sum(
                term(motion, self._constants[motion], self._indicators[tag] * m.mass_density(mesh), dx)
                for tag, motion in self._motions.items()
            ),
            inertia=exact,
        )
