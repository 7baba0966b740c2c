# SPDX-License-Identifier: MIT
"""Mass matrix of an implicit problem, made from forms: consistent or lumped, with or without mass on contact surfaces;
a view of cpp/dolfinx_impact/integrators/newmark/Inertia.h."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import ufl
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import MeshTags
from mpi4py import MPI
from petsc4py import PETSc

from ... import _cpp
from ...common.described import Described
from ...added_mass import AddedMass
from ...assembly import lumped_mass, operators
from ...assembly.consistent_mass import ConsistentMass, Densities, diagonal_matrix
from ...assembly.fields import field_dofs, fields_of
from ...common.types import BoolArray, FloatArray
from .mass_redistribution import MassRedistribution


class Inertia(Described):
    """Mass matrix M of bodies.

    Args:
        V: displacement space.
        densities: density by cell tag, or those of fields or components; the tag None stands for all cells
            [M/L^3].
        hypothesis: hypothesis of the materials.
        cell_tags: cell tags of the densities; None: one density.
        lumping: lumping scheme, as for lumped_mass; None: consistent mass.
        surface: contact nodes whose mass goes to the nodes behind them; None: all nodes keep theirs.
        fixed: mask of prescribed degrees of freedom, owned: they follow their functions of time, with or without mass.
        added: masses on surfaces.

    Attributes:
        matrix: M [M].
        massless: mask of owned degrees of freedom without mass that are not prescribed.
        total: lumped mass of all degrees of freedom, wherever it goes [M].
        lumping: lumping scheme, or None.

    Raises:
        ValueError: a density is not positive, the lumping scheme does not fit, or a mass is added to contact nodes that
            pass theirs on; on all ranks.
    """

    def __init__(
        self,
        V: FunctionSpace,
        densities: Densities,
        hypothesis: str,
        cell_tags: MeshTags | None,
        lumping: str | None,
        surface: MassRedistribution | None,
        fixed: BoolArray,
        added: Sequence[AddedMass] = (),
    ) -> None:
        self.space, self.lumping = V, lumping
        bs = V.dofmap.index_map_bs
        self._num_owned: int = V.dofmap.index_map.size_local * bs
        nodes = np.zeros(V.dofmap.index_map.size_local, dtype=bool) if surface is None else surface.massless
        self.massless: BoolArray = np.repeat(nodes[: V.dofmap.index_map.size_local], bs)
        # The lumped mass is made in any case: it finds densities that are not positive.
        masses = lumped_mass.cell_masses(V, densities, hypothesis, cell_tags, lumping or "auto")
        consistent = ConsistentMass(V, densities, hypothesis, cell_tags)
        if any(isinstance(density, tuple) for _, density in densities):
            self.total = lumped_mass.sum_masses(V, masses)
            self._check_fields(densities, consistent)
        else:
            self.total = lumped_mass.assemble_masses(V, masses, lumping or "auto")
        if lumping is None:
            self.matrix: PETSc.Mat = consistent.assemble()
            if surface is not None:
                self._redistribute(consistent, surface)
        else:
            diagonal = self.total.array[: self._num_owned]
            if surface is not None:
                diagonal = self._redistributed(masses, surface)
            self.matrix = diagonal_matrix(V, diagonal)
        for mass in added:
            self._add(mass, hypothesis)
        self.massless &= ~fixed
        self._cpp_object = _cpp.integrators.Inertia(self.matrix, self.massless)

    def _check_fields(self, densities: Densities, consistent: ConsistentMass) -> None:
        """Find the degrees of freedom that have no mass; ValueError if a density is not positive.
        Collective."""
        V, ((_, given),) = self.space, densities
        assert isinstance(given, tuple)  # checked with the arguments
        diagonal = None
        for field, density, dofs in zip(fields_of(V), given, field_dofs(V)):
            if density is None:
                self.massless[dofs] = True
                continue
            if not field.is_lagrange:  # no lumped mass: the entries of the matrix take its place
                diagonal = consistent.assemble().getDiagonal() if diagonal is None else diagonal
                self.total.array[dofs] = diagonal.array_r[dofs]
            smallest = V.mesh.comm.allreduce(float(np.min(self.total.array[dofs], initial=np.inf)), MPI.MIN)
            if not smallest > 0.0:
                raise ValueError(f"{field} has a nodal mass of {smallest}: its density must be positive in every cell")
        self.total.scatter_forward()

    def _add(self, mass: AddedMass, hypothesis: str) -> None:
        """Add a mass on a surface. Collective."""
        V, nodal = self.space, mass.nodal(self.space, hypothesis)
        if V.mesh.comm.allreduce(bool(np.any(nodal[: self._num_owned][self.massless] != 0.0)), MPI.LOR):
            raise ValueError("an AddedMass is on a contact surface, whose nodes pass on their mass: give impact='none'")
        self.total.array[:] += nodal
        if self.lumping is None:
            form = mass.matrix_form(ufl.TrialFunction(V), ufl.TestFunction(V), hypothesis)
            self.matrix.axpy(1.0, operators.Tangent(form).assemble())
        else:
            diagonal = self.matrix.createVecRight()
            diagonal.array[:] = nodal[: self._num_owned]
            self.matrix.setDiagonal(diagonal, PETSc.InsertMode.ADD_VALUES)
            self.matrix.assemble()

    def _redistribute(self, consistent: ConsistentMass, surface: MassRedistribution) -> None:
        """Replace the matrix M_e of each cell at the surface by T^T M_e T; see MassRedistribution. Collective."""
        dofmap = self.space.dofmap
        for cell, matrix in consistent.of_cells(surface.cells):
            dofs = (dofmap.bs * dofmap.cell_dofs(cell)[:, None] + np.arange(dofmap.bs)).ravel().astype(np.int32)
            change = surface.matrix(cell, matrix) - matrix
            self.matrix.setValuesLocal(dofs, dofs, change, PETSc.InsertMode.ADD_VALUES)
        self.matrix.assemble()

    def _redistributed(self, masses: lumped_mass.CellMasses, surface: MassRedistribution) -> FloatArray:
        """Lumped masses of owned degrees of freedom after redistribution [M]. Collective."""
        moved, wanted = [], np.zeros(self.space.mesh.topology.index_map(self.space.mesh.topology.dim).size_local, bool)
        wanted[surface.cells] = True
        for cells, values in masses:
            values = values.copy()
            for row in np.flatnonzero(wanted[cells]):
                values[row] = surface.lumped(int(cells[row]), values[row])
            moved.append((cells, values))
        return lumped_mass.sum_masses(self.space, moved).array[: self._num_owned]

    def times(self, values: FloatArray) -> FloatArray:
        """Product M x. Collective.

        Args:
            values: x over owned degrees of freedom.

        Returns:
            Product over owned degrees of freedom.
        """
        return self._cpp_object.times(np.ascontiguousarray(values))
