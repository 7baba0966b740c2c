# SPDX-License-Identifier: MIT
"""Stable steps of explicit integration: seed (3.78)-(3.80), docs/explicit/stable_step.md."""

import warnings
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import ufl
from dolfinx import fem
from mpi4py import MPI
from ufl.algorithms import extract_coefficients

from .. import _cpp, compat
from ..assembly import operators
from ..assembly.cell_matrices import CellMatrices
from ..assembly.curvature import NOISE, WRONG, check_curvature, extremes
from ..common.cell_numbers import input_cell_numbers
from ..common.collective import common
from ..common.types import BoolArray, FloatArray, IntArray

METHODS = tuple(_cpp.problems.StableStepMethod.__members__)

CellMasses: TypeAlias = list[tuple[IntArray, FloatArray]]  # of lumped_mass.cell_masses


class Frequencies:
    """Highest frequencies of the cells and of the assembled system.

    Args:
        u: displacement function.
        tangent: UFL form of rank 2, derivative of the internal force.
        masses: function that returns what lumped_mass.cell_masses does; called when needed, its values are not kept.
        damping: UFL form of rank 2, derivative of the residual with respect to the velocity, or the dashpots of
            foundations; None: there is none.
        velocity: velocity function of the residual.

    Attributes:
        stiffness: cell matrices of the tangent.
        tangent: as given.
        damping_form: as given, `damping`.
    """

    def __init__(
        self,
        u: fem.Function,
        tangent: ufl.Form,
        masses: Callable[[], CellMasses],
        damping: ufl.Form | None = None,
        velocity: fem.Function | None = None,
    ) -> None:
        V = u.function_space
        self.u, self.tangent, self.comm = u, tangent, V.mesh.comm
        shape = V.mesh.topology.index_map(V.mesh.topology.dim).size_local, V.dofmap.bs * V.dofmap.dof_layout.num_dofs
        motion = (u, velocity)
        self.stiffness = CellMatrices(u, tangent, motion)
        self.damping_form = damping
        self._damping = None if damping is None else CellMatrices(u, damping, motion)

        def by_cell() -> FloatArray:  # it does not know this object, which has it
            parts = masses()
            if len(parts) == 1 and np.array_equal(parts[0][0], np.arange(shape[0])):
                return parts[0][1].ravel()  # without a copy
            out = np.zeros(shape)
            for cells, values in parts:
                out[cells] += values
            return out.ravel()

        bounds = None if self._damping is None else self._damping.bounds
        self._cpp_object = _cpp.problems.CellFrequencies(V._cpp_object, self.stiffness.bounds, bounds, by_cell)

    @property
    def depends_on_jumps(self) -> bool:
        """Whether the stiffness of facets between cells depends on the displacement: on jumps, which deform no cell."""
        inner = [i for i in self.tangent.integrals() if i.integral_type() == "interior_facet"]
        return any(f is self.u for i in inner for f in extract_coefficients(i.integrand()))

    @property
    def damps(self) -> bool:
        """Whether there is damping that differs between cells: of a residual, or of dashpots."""
        return self._damping is not None

    def changed(self) -> bool:
        """Compare the values that the frequencies depend on, other than the motion, with those of `store_inputs`.

        Returns:
            Whether any has changed on this rank.
        """
        return self.stiffness.changed() or (self._damping is not None and self._damping.changed())

    def change(self) -> float:
        """Largest relative change of these values on this rank since `store_inputs` [1]."""
        parts = (self.stiffness, self._damping)
        return max(matrices.change() for matrices in parts if matrices is not None)

    def store_inputs(self) -> None:
        """Store the values that the frequencies depend on, which `changed` compares with. Collective."""
        for matrices in (self.stiffness, self._damping):
            if matrices is not None:
                matrices.store_inputs()

    def masses(self) -> FloatArray:
        """Lumped masses of every owned cell. Collective.

        Returns:
            Masses, (num_cells, local degrees of freedom) [M].
        """
        V = self.u.function_space
        found: FloatArray = self._cpp_object.masses().reshape(-1, V.dofmap.bs * V.dofmap.dof_layout.num_dofs)
        return found

    def scale_mass(self, dt: float) -> float:
        """Add mass to cells whose own stable step is less than dt. Collective.

        Args:
            dt: step [T].

        Returns:
            Added mass, of all ranks [M].
        """
        self.update()
        return float(self._cpp_object.scale_mass(dt))

    def update(self) -> None:
        """Take the present constants and the ghosts of coefficients. Collective."""
        for matrices in (self.stiffness, self._damping):
            if matrices is not None:
                matrices.update()

    def by_cell(self, only: BoolArray | None = None) -> tuple[FloatArray, FloatArray]:
        """Largest eigenvalues of owned cells. Collective.

        Args:
            only: mask of the cells that are asked for; None: all.

        Returns:
            Square of the highest angular frequency, (cells asked for) [1/T^2], and largest eigenvalue of damping over
            mass [1/T].

        Raises:
            ValueError: the stiffness of a cell is not finite; on all ranks.
        """
        self.update()
        squares, rates = self._cpp_object.by_cell(only)
        return squares, rates

    def check_signs(self, free: BoolArray) -> None:
        """Refuse a stiffness or damping of the wrong sign. Collective.

        Args:
            free: mask of owned degrees of freedom that are not prescribed.

        Raises:
            ValueError: the stiffness or the damping of a cell, or the assembled stiffness, is negative; on all ranks.

        Warns:
            UserWarning: the stiffness is negative a little, or the damping is not symmetric.
        """
        masses = self.masses()
        asked = "is the residual internal minus external forces?"
        parts = [(self.stiffness, f"the stiffness of the residual is negative: {asked}")]
        if self._damping is not None:
            parts.append((self._damping, f"the velocity's part of the residual feeds energy in: {asked}"))
        for matrices, what in parts:
            low, high, skew = matrices.spectra(masses).T
            size = self.comm.allreduce(float(np.max(np.maximum(-low, high), initial=0.0)), MPI.MAX)
            # Of a facet between two cells, the consistency terms of a good interior penalty alone are indefinite.
            bad = np.flatnonzero((-low > high) & (-low > 1e-9 * size) & (not matrices.joins_cells))
            first = None
            if len(bad):
                mesh, cell = self.u.function_space.mesh, bad[0]
                middle = mesh.geometry.x[compat.geometry_dofmap(mesh)[cell], : mesh.geometry.dim].mean(axis=0)
                first = (int(input_cell_numbers(mesh.topology)[cell]), middle.round(9).tolist())
            found = [f for f in self.comm.allgather(first) if f is not None]
            if found:
                number, place = found[0]
                raise ValueError(f"{what} Found in cell {number} (number in the mesh's input) at {place}")
            # Of several integrals over a cell the sum of their lowest values is a bound: the whole matrix tells.
            doubtful = bool(np.any((-low > NOISE * high) & (-low > 1e-9 * size)))
            if matrices is self.stiffness and self.comm.allreduce(doubtful, MPI.LOR):
                K = operators.Tangent(self.tangent)
                check_curvature(K.assemble(), free)
                K.matrix.destroy()
            if matrices is self._damping and matrices.joins_cells and self.comm.allreduce(doubtful, MPI.LOR):
                assert self.damping_form is not None  # these are its matrices
                C = operators.Tangent(self.damping_form)
                lowest, highest = extremes(C.assemble(), free)
                C.matrix.destroy()
                if -lowest > WRONG * max(-lowest, highest):
                    raise common(ValueError(what))
            if (
                matrices is self._damping
                and self.comm.allreduce(float(np.max(skew, initial=0.0)), MPI.MAX) > 1e-6 * size
            ):
                if self.comm.rank == 0:
                    warnings.warn(
                        "the velocity's part of the residual is not symmetric (Coriolis forces, convection?): taken "
                        "half a step late it feeds in energy, which energy['damping'] tells",
                        stacklevel=4,
                    )
