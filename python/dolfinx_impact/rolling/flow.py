# SPDX-License-Identifier: MIT
"""Inertia of the flow of material through a mesh, as a load of a static problem; seed (3.53)-(3.57), corrected."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import MeshTags

from ..assembly import operators
from ..common.types import FloatArray, IntArray
from ..forms import ale
from ..inelastic import InelasticMaterial
from ..materials import Material
from .motions import Spin, Translation


class Flow:
    """Forces of inertia of bodies whose material moves steadily: their derivative is W, and load steps ramp them.

    Args:
        u: displacement function [L].
        material: material, with densities.
        cell_tags: tags of the bodies.
        motions: motion by tag.
        rigid: rigid masters, whose surfaces move with their velocity.
    """

    def __init__(
        self,
        u: fem.Function,
        material: Material,
        cell_tags: MeshTags,
        motions: Mapping[int, Spin | Translation],
        rigid: Sequence[Any] = (),
    ) -> None:
        mesh = u.function_space.mesh
        self._material, self._motions = material, dict(motions)
        self._cell_tags = cell_tags
        self._constants = {tag: motion.constant(mesh) for tag, motion in self._motions.items()}
        self._reached = {tag: np.array(c.value) for tag, c in self._constants.items()}
        # Indicators, as materials may bring tags of their own, and a form takes one set of tags.
        self._indicators: dict[int, Any] = {tag: 1 for tag in self._motions}
        if len(self._motions) > 1:
            piecewise = fem.functionspace(mesh, ("DG", 0))
            for tag in self._motions:
                self._indicators[tag] = fem.Function(piecewise)
                self._indicators[tag].x.array[cell_tags.find(tag)] = 1.0
                self._indicators[tag].x.scatter_forward()

        V = u.function_space
        self._comm = mesh.comm
        self._places = V.tabulate_dof_coordinates()[:, : mesh.geometry.dim].copy()
        self._nodes = {tag: np.unique(V.dofmap.list[cell_tags.find(tag)]) for tag in self._motions}
        # Creepages besides those of the motions, see `creepage`.
        self.lateral, self.turn = 0.0, 0.0
        self._rigid = {id(master): (master, fem.Constant(mesh, np.zeros(3)), np.zeros(3)) for master in rigid}

    def at_nodes(self) -> FloatArray:
        """Velocity of the undeformed material through the mesh at the nodes, (nodes, gdim), owned and ghosts [L/T]."""
        w = np.zeros_like(self._places)
        for tag, nodes in self._nodes.items():
            w[nodes] = self._motions[tag].at(self._places[nodes], self._constants[tag].value)
        return w

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
        return np.unique(np.concatenate(parts))

    def settle(self) -> None:
        """The present rates are those that the last solve has reached."""
        for constant, reached in self.ramps():
            reached[...] = constant.value

    def rigid_velocity(self, master: Any) -> FloatArray:
        """Velocity of the surface of a rigid master, (3) [L/T].

        Args:
            master: rigid master of one of the pairs.
        """
        return np.array(self._rigid[id(master)][1].value)

    def creepage(self, contact: Any) -> FloatArray:
        """Rigid slip velocity of slave against master besides that of the motions, (n, gdim) [L/T].

        The body that spins moves along its axis by `lateral` times the speed, and turns about the contact's normal by
        `turn` times the speed, against the other body.

        Args:
            contact: RollingContact.
        """
        out = np.zeros((len(contact.nodes), contact.gdim))
        if self.lateral == 0.0 and self.turn == 0.0:
            return out
        spin = next(m for m in self._motions.values() if isinstance(m, Spin))
        spinning = np.isin(contact.nodes, next(n for t, n in self._nodes.items() if self._motions[t] is spin))
        speed, gdim = contact.speed(), contact.gdim
        out += self.lateral * speed * spin.axis[:gdim]
        if self.turn != 0.0:
            out += self.turn * speed * contact.turn_about_normal()
        return np.where(spinning[:, None], out, -out)

    def same_on_all_ranks(self) -> list[Any]:
        """What must be the same on all ranks."""
        return [self._motions]

    def update(self) -> None:
        """Take over the present rates of the motions."""
        for tag, constant in self._constants.items():
            constant.value = self._motions[tag].rate
        for master, constant, _ in self._rigid.values():
            constant.value = master.velocity

    def scale(self, factor: float) -> None:
        """Change the rates of the motions, until `update`.

        Args:
            factor: by which they are multiplied.
        """
        for constant in self._constants.values():
            constant.value = factor * np.asarray(constant.value)

    def ramps(self) -> list[tuple[fem.Constant, FloatArray]]:
        """Pairs (constant, value reached by earlier solves): what load steps run through."""
        bodies = [(self._constants[tag], self._reached[tag]) for tag in self._motions]
        return bodies + [(constant, reached) for _, constant, reached in self._rigid.values()]

    def reached(self) -> list[FloatArray]:
        """Copies of the rates that earlier solves reached."""
        return [value.copy() for _, value in self.ramps()]

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
                term(motion, self._constants[tag], self._indicators[tag] * m.mass_density(mesh), dx)
                for tag, motion in self._motions.items()
            ),
            inertia=exact,
        )
