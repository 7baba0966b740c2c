# SPDX-License-Identifier: MIT
"""Warning about bodies of small strain that turn: their law takes a rotation for a strain."""

import math
import warnings

import basix
import numpy as np
from dolfinx.fem import Function, FunctionSpace
from mpi4py import MPI

from .. import _cpp, compat
from ..common.cell_numbers import input_cell_numbers
from ..common.types import IntArray
from ..inelastic import InelasticMaterial
from ..materials import LinearElastic, Material

LARGE = 0.2  # rotation that is warned of [rad]: the small strain of it alone is -0.02
FLATTEST = 10.0  # longest over shortest length of a cell, for a quick look; flatter ones are looked at too late


class LargeRotation(UserWarning):
    """Cells of a law of small strain have turned far."""


def largest_rotation(u: Function, cells: IntArray, beyond: float) -> tuple[float, int]:
    """The cell that has turned furthest at its middle, by the skew part of F = I + grad u; exact where F only turns.

    Args:
        u: displacement function [L].
        cells: numbers of cells of this rank; those without volume do not count.
        beyond: only rotations that are larger count [rad].

    Returns:
        Angle from 0 to pi [rad] and number of the cell; 0 and -1 if none has turned further.
    """
    V: FunctionSpace = u.function_space
    x, gdim = V.mesh.geometry.x, V.mesh.geometry.dim
    dofmap = compat.geometry_dofmap(V.mesh)
    coordinates = V.mesh.ufl_domain().ufl_coordinate_element().basix_element
    middle = np.asarray(basix.geometry(coordinates.cell_type)).mean(axis=0)[None, :]
    shape = V.element.basix_element.tabulate(1, middle)[1:, 0, :, 0]
    shape_of_place = coordinates.tabulate(1, middle)[1:, 0, :, 0]
    places = x.ravel(), dofmap.ravel(), shape_of_place.ravel()
    nodes = u.x.array, V.dofmap.list.ravel(), shape.ravel()
    return _cpp.operators.largest_rotation(*places, *nodes, cells, gdim, beyond)


def _small_strain(material: object) -> bool:
    finite = getattr(material, "finite_strain", False)
    return isinstance(material, LinearElastic) or (isinstance(material, InelasticMaterial) and not finite)


class RotationWarning:
    """Warns once, on rank 0, when cells of small strain have turned far.

    Args:
        material: material of the bodies; None: a residual of the user's own, of which nothing is known.
    """

    def __init__(self, material: Material | None) -> None:
        parts = [] if material is None else list(material.parts())
        self._parts = [(tag, part) for tag, part in parts if _small_strain(part)]
        self._tags = None if material is None else material.cell_tags
        self._warned = False
        self._shortest: float | None = None  # edge of this rank's cells [L]

    def _may_have_turned(self, u: Function) -> bool:
        """Whether displacements on this rank differ so much that a cell may have turned far."""
        mesh = u.function_space.mesh
        if self._shortest is None:
            num_owned = mesh.topology.index_map(mesh.topology.dim).size_local
            sizes = mesh.h(mesh.topology.dim, np.arange(num_owned, dtype=np.int32))
            self._shortest = float(sizes.min(initial=np.inf)) / FLATTEST
        values, gdim = u.x.array, mesh.geometry.dim
        # By component: a reduction over the first axis of short rows takes ten times as long.
        spread = max(float(np.ptp(values[c::gdim])) for c in range(gdim)) if len(values) else 0.0
        return spread > 0.5 * LARGE * self._shortest

    def look(self, u: Function, stacklevel: int) -> None:
        """Look at a displacement. Collective.

        Args:
            u: displacement function [L].
            stacklevel: of the warning, as seen from the caller of this method [1].
        """
        mesh = u.function_space.mesh
        if self._warned or not self._parts or mesh.topology.dim != mesh.geometry.dim:
            return
        num_owned = mesh.topology.index_map(mesh.topology.dim).size_local
        for tag, part in self._parts:
            cells: IntArray = np.arange(num_owned, dtype=np.int32)
            if tag is not None and self._tags is not None:
                cells = self._tags.find(tag)
                cells = cells[cells < num_owned]
            mine, cell = largest_rotation(u, cells, LARGE) if self._may_have_turned(u) else (0.0, -1)
            largest = mesh.comm.allreduce(mine, MPI.MAX)
            if largest == 0.0:
                continue
            here = int(input_cell_numbers(mesh.topology)[cell]) if mine == largest else None
            number = next(n for n in mesh.comm.allgather(here) if n is not None)
            self._warned = True
            if mesh.comm.rank == 0:
                warnings.warn(_text(part, largest, number), LargeRotation, stacklevel=stacklevel + 1)
            return


def _text(part: object, angle: float, cell: int) -> str:
    name, false_strain = type(part).__name__, 1.0 - math.cos(angle)
    other = "NeoHookean or StVenantKirchhoff" if isinstance(part, LinearElastic) else "finite_strain=True"
    return (
        f"{name} is a law of small strain, but its cells have turned by up to {angle:.3g} rad (cell {cell}, number "
        f"in the mesh's input). It takes a rotation alone for a strain of -{100 * false_strain:.2g} %: a body that "
        f"turns grows, and is strained where nothing strains it. Take {other}, which know rotations of any size"
    )
