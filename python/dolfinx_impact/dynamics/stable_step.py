# SPDX-License-Identifier: MIT
"""Stable steps of explicit integration: seed (3.78)-(3.80), docs/explicit/stable_step.md."""

import math
import warnings
from collections.abc import Callable
from typing import TypeAlias

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.mesh import Mesh
from mpi4py import MPI
from petsc4py import PETSc
from ufl.algorithms import extract_coefficients

from .. import _cpp
from ..assembly import operators
from ..assembly.cell_matrices import CellMatrices
from ..assembly.curvature import NOISE, WRONG, check_curvature, extremes
from ..common.cell_numbers import input_cell_numbers
from ..common.collective import common
from ..common.types import BoolArray, FloatArray, IntArray

METHODS = ("length", "element", "eigenvalue")
TOLERANCE = 1e-8  # relative, of the largest eigenvalue

CellMasses: TypeAlias = list[tuple[IntArray, FloatArray]]  # of lumped_mass.cell_masses


def cell_sizes(mesh: Mesh) -> FloatArray:
    """Shortest edge between vertices of each owned cell.

    Args:
        mesh: mesh of the body.

    Returns:
        Lengths, (num_cells) [L].
    """
    sizes: FloatArray = _cpp.problems.cell_sizes(mesh._cpp_object)
    return sizes


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
        self._damping_form = damping
        self._damping = None if damping is None else CellMatrices(u, damping, motion)

        def by_cell() -> FloatArray:  # it does not know this object, which has it
            out = np.zeros(shape)
            for cells, values in masses():
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

    def nodal_stiffness(self, nodes: BoolArray) -> FloatArray:
        """Sum over the cells at a node of its mass in the cell times the square of the cell's highest frequency, at
        rest: displacement zero, facets left out. Collective.

        Args:
            nodes: mask of the nodes that are asked for, owned and ghosts.

        Returns:
            Sums, owned and ghosts, right at these nodes; zero without stiffness, or if it is not a number [F/L].
        """
        given = self.u.x.array.copy()
        self.u.x.array[:] = 0.0
        try:
            self.update()
            found: FloatArray = self._cpp_object.nodal_stiffness(np.ascontiguousarray(nodes))
        finally:
            self.u.x.array[:] = given
        return found

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
                middle = mesh.geometry.x[mesh.geometry.dofmap[cell], : mesh.geometry.dim].mean(axis=0)
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
                assert self._damping_form is not None  # these are its matrices
                C = operators.Tangent(self._damping_form)
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

    def bound(self) -> float:
        """Upper bound of the angular frequencies of the body. Collective.

        Returns:
            Angular frequency [1/T].

        Raises:
            ValueError: the stiffness of a cell is not finite; on all ranks.
        """
        largest = float(np.max(self.by_cell()[0], initial=0.0))
        return math.sqrt(self.comm.allreduce(largest, MPI.MAX))

    def highest(self, inverse_mass: FloatArray, extra: PETSc.Mat | None = None) -> float:
        """Highest angular frequency of the assembled system, by SLEPc's Krylov-Schur method. Collective.

        Args:
            inverse_mass: inverse lumped mass over owned degrees of freedom, zero where motion is prescribed [1/M].
            extra: matrix that is added to the stiffness; None: nothing [F/L].

        Returns:
            Angular frequency [1/T].

        Raises:
            RuntimeError: the eigenvalue solver does not converge.
        """
        matrix, root = self._scaled(self.tangent, inverse_mass, extra)
        value, vector = largest_eigenvalue(matrix)
        for thing in (vector, root, matrix):
            thing.destroy()
        return math.sqrt(max(value, 0.0))

    def critical_step(
        self, inverse_mass: FloatArray, extra: PETSc.Mat | None, uniform: _cpp.problems.UniformDamping, start: float
    ) -> float:
        """Stable step of the assembled system with damping that differs between cells. Collective.

        At the stable step dt the largest eigenvalue of dt^2/4 K + dt/2 C over the mass is one. Each iteration computes
        the eigenvector of the largest eigenvalue at the present step, then the step at which this vector's Rayleigh
        quotient is one. The stable step is the minimum over all vectors, so that the iterates decrease to it.

        Args:
            inverse_mass: inverse lumped mass over owned degrees of freedom, zero where motion is prescribed [1/M].
            extra: matrix that is added to the stiffness; None: nothing [F/L].
            uniform: damping of all cells alike; bulk viscosity takes part in the step of a vector, not in the search
                for it.
            start: step that the iteration starts from [T].

        Returns:
            Stable step [T].

        Raises:
            RuntimeError: the eigenvalue solver does not converge.
        """
        K, root = self._scaled(self.tangent, inverse_mass, extra)
        C, other = self._scaled(self._damping_form, inverse_mass, None)
        transposed = C.copy()
        transposed.transpose()
        C.axpy(1.0, transposed)
        C.scale(0.5)
        dt = start
        for _ in range(30):
            matrix = K.copy()
            matrix.scale(0.25 * dt**2)
            matrix.axpy(0.5 * dt, C)
            matrix.axpy(0.5 * dt * uniform.beta, K)
            matrix.shift(0.5 * dt * uniform.alpha)
            _, x = largest_eigenvalue(matrix)
            y = x.duplicate()
            K.mult(x, y)
            square = max(x.dot(y).real, 0.0)
            C.mult(x, y)
            half = 0.5 * (max(x.dot(y).real, 0.0) + uniform.rate(square))
            old, dt = dt, 2.0 / (half + math.sqrt(half**2 + square))
            for thing in (x, y, matrix):
                thing.destroy()
            if abs(dt - old) <= 1e-9 * dt:
                break
        for thing in (K, C, transposed, root, other):
            thing.destroy()
        return dt

    def _scaled(self, form: ufl.Form, inverse_mass: FloatArray, extra: PETSc.Mat | None) -> tuple[PETSc.Mat, PETSc.Vec]:
        """Matrix of a form, scaled by the root of the inverse mass from both sides, and that root."""
        matrix = operators.Tangent(form).assemble()
        if extra is not None:
            matrix.axpy(1.0, extra)
        root = matrix.createVecRight()
        root.array[:] = np.sqrt(inverse_mass)
        matrix.diagonalScale(root, root)
        return matrix, root


def largest_eigenvalue(matrix: PETSc.Mat) -> tuple[float, PETSc.Vec]:
    """Largest eigenvalue of a symmetric matrix. Collective.

    Args:
        matrix: symmetric matrix.

    Returns:
        Eigenvalue, and eigenvector of norm one.

    Raises:
        RuntimeError: the eigenvalue solver does not converge.
    """
    found: tuple[float, PETSc.Vec] | None = _cpp.solve.largest_eigenvalue(matrix, None, TOLERANCE)
    if found is None:
        raise RuntimeError("the highest frequency was not found: use stable_step(method='element')")
    return found
