# SPDX-License-Identifier: MIT
"""Largest steps of explicit integration: seed (3.78)-(3.80), docs/explicit/stable_step.md."""

import math
import warnings

import basix
import numpy as np
import ufl
from mpi4py import MPI

from .. import _cpp
from ..assembly import operators
from ..assembly.jit import compile_form
from ..common.cell_numbers import input_cell_numbers

METHODS = ("length", "element", "eigenvalue")


def damped(omega, alpha=0.0, beta=0.0, viscosity=0.0, scheme="half_step", rate=0.0):
    """Limit of the step at the angular frequency omega [1/T], with damping; seed (3.78), corrected [T].

    Rayleigh's factors alpha and beta, linear bulk viscosity and the eigenvalue `rate` of damping over mass [1/T] are a
    fraction xi of critical damping, 2 xi omega = rate + ..., which the classical scheme's limit does not feel.
    """
    half = 0.0 if scheme == "classical" else 0.5 * (rate + alpha + beta * omega**2) + viscosity * omega
    largest = half + math.sqrt(half**2 + omega**2)
    return 2.0 / largest if largest > 0.0 else math.inf


def cell_sizes(mesh):
    """Shortest edge between corners of each owned cell [L]."""
    cell = getattr(basix.CellType, mesh.topology.cell_name())
    num_cells = mesh.topology.index_map(mesh.topology.dim).size_local
    x = mesh.geometry.x[mesh.geometry.dofmap[:num_cells]]
    edges = np.array(basix.topology(cell)[1])
    return np.min(np.linalg.norm(x[:, edges[:, 0]] - x[:, edges[:, 1]], axis=2), axis=1)


class CellMatrices:
    """Matrices of a bilinear form, cell by cell; a cell's facets count with it.

    Args:
        u: displacement function. form: UFL form of rank 2 over dx and ds. without: functions whose changes count for
            nothing.

    Attributes:
        has_place: does the form depend on the place (ufl.SpatialCoordinate)?
    """

    def __init__(self, u, form, without):
        self.space = u.function_space
        self._compiled = compile_form(form)
        data = next(iter(form.subdomain_data().values()))
        self._tags = {kind: next((t for t in tags if t is not None), None) for kind, tags in data.items()}
        self.has_place = ufl.algorithms.analysis.has_type(form, ufl.SpatialCoordinate)
        self._inputs = operators.Inputs(self._compiled.constants, self._compiled.coefficients, without)

    def changed(self):
        """Have constants or coefficients changed on this rank since `take`?"""
        return self._inputs.changed()

    def take(self):
        """Remember the present constants and coefficients. Collective."""
        self._inputs.store()

    def _integrals(self):
        """Kernel, functions by name, entities and constants of each integral. Collective."""
        for f in self._compiled.coefficients:
            f.x.scatter_forward()
        for kernel in self._compiled.kernels:
            functions = {c["name"]: self._compiled.coefficients[c["position"]] for c in kernel.coefficients}
            constants, kind = operators._constants(self._compiled, kernel), kernel.integral_type
            for subdomain in kernel.subdomains:
                entities = operators._entities(self.space.mesh._cpp_object, kind, subdomain, self._tags.get(kind))
                yield kernel, functions, np.ascontiguousarray(entities), constants

    def spectra(self, masses):
        """Of every owned cell's matrix over its mass, (num_cells, 3): a lower bound of the eigenvalues, an upper one,
        and the norm of the skew-symmetric part. Collective.

        Args:
            masses: lumped, (num_cells, local degrees of freedom) [M].

        Raises:
            ValueError: a matrix that is not a number; on all ranks.
        """
        V, failed = self.space, False
        out = np.zeros((len(masses), 3))
        for kernel, functions, entities, constants in self._integrals():
            cells = entities if kernel.integral_type == "cell" else np.ascontiguousarray(entities[::2])
            integral = _cpp.operators.Integral(kernel.address, entities, constants)
            functions = {name: f._cpp_object for name, f in functions.items()}
            given = np.ascontiguousarray(masses[cells]).ravel()
            try:
                found = _cpp.operators.cell_spectra(integral, V._cpp_object, functions, given)
                np.add.at(out, cells, found.reshape(-1, 3))
            except RuntimeError:
                failed = True
        if V.mesh.comm.allreduce(bool(failed or not np.all(np.isfinite(out))), MPI.LOR):
            raise ValueError("the stiffness of a cell is not a number: check the material, the mesh and the state")
        return out

    def resistance(self, direction, count):
        """Size of a cell's matrix times a translation, over that of the matrix: of the first `count` cells [1]."""
        mesh, bs, parts = self.space.mesh, self.space.dofmap.bs, []
        for kernel, functions, entities, constants in self._integrals():
            if kernel.integral_type != "cell":
                continue
            for cell in entities[:count]:
                w = np.zeros(sum(c["num_dofs"] for c in kernel.coefficients))
                for c in kernel.coefficients:
                    f = functions[c["name"]]
                    dofs = f.function_space.dofmap.cell_dofs(cell)
                    values = f.x.array.reshape(-1, f.function_space.dofmap.bs)[dofs]
                    w[c["offset"] : c["offset"] + c["num_dofs"]] = values.ravel()
                n = kernel.shape[0]
                A, x = np.zeros((n, n)), np.ascontiguousarray(mesh.geometry.x[mesh.geometry.dofmap[cell]])
                kernel.tabulate(A.reshape(-1), w, constants, x.reshape(-1))
                size = np.abs(A).max()
                if size > 0.0:
                    parts.append(np.abs(A @ np.tile(direction, n // bs)).max() / size)
        return np.array(parts)


class Frequencies:
    """Highest frequencies of a body by cells and as a whole.

    Args:
        u: displacement function. tangent: UFL form of rank 2, derivative of the internal force. masses: function
            without arguments, returns what mass.cell_masses does; called when needed, nothing is kept.
        damping: UFL form of rank 2, derivative of the residual with respect to the velocity, or None. velocity: the
            function of it.

    Attributes:
        factor: of each owned cell's mass, or None [1]. damps: is there damping of the residual's own?
    """

    def __init__(self, u, tangent, masses, damping=None, velocity=None):
        V = u.function_space
        self.u, self.tangent, self.comm = u, tangent, V.mesh.comm
        self._num_cells = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        self._masses, self.factor = masses, None
        motion = (u, velocity)
        self.stiffness = CellMatrices(u, tangent, motion)
        self._damping_form = damping
        self._damping = None if damping is None else CellMatrices(u, damping, motion)

    @property
    def damps(self):
        return self._damping is not None

    def changed(self):
        """Has anything but the displacement changed on this rank that frequencies depend on, since `take`?"""
        return self.stiffness.changed() or (self.damps and self._damping.changed())

    def take(self):
        """Remember what frequencies depend on. Collective."""
        for matrices in (self.stiffness, self._damping):
            if matrices is not None:
                matrices.take()

    def masses(self):
        """Lumped mass of every owned cell, (num_cells, local degrees of freedom) [M]. Collective."""
        V = self.u.function_space
        out = np.zeros((self._num_cells, V.dofmap.bs * V.dofmap.dof_layout.num_dofs))
        for cells, values in self._masses():
            out[cells] += values
        return out if self.factor is None else out * self.factor[:, None]

    def by_cell(self):
        """Of every owned cell: square of the highest angular frequency [1/T^2], largest eigenvalue of damping over mass
        [1/T]. Collective."""
        masses = self.masses()
        rates = self._damping.spectra(masses)[:, 1] if self.damps else np.zeros(len(masses))
        return np.maximum(self.stiffness.spectra(masses)[:, 1], 0.0), np.maximum(rates, 0.0)

    def check_signs(self):
        """Refuse a stiffness or damping of the wrong sign. Collective.

        Raises:
            ValueError: on all ranks.
        """
        masses = self.masses()
        asked = "is the residual internal minus external forces?"
        parts = [(self.stiffness, f"the stiffness of the residual is negative: {asked}")]
        if self.damps:
            parts.append((self._damping, f"the velocity's part of the residual feeds energy in: {asked}"))
        for matrices, what in parts:
            low, high, skew = matrices.spectra(masses).T
            size = self.comm.allreduce(float(np.max(np.maximum(-low, high), initial=0.0)), MPI.MAX)
            bad = np.flatnonzero((-low > high) & (-low > 1e-9 * size))
            first = None
            if len(bad):
                mesh, cell = self.u.function_space.mesh, bad[0]
                middle = mesh.geometry.x[mesh.geometry.dofmap[cell], : mesh.geometry.dim].mean(axis=0)
                first = int(input_cell_numbers(mesh.topology)[cell]), middle.round(9).tolist()
            found = [f for f in self.comm.allgather(first) if f is not None]
            if found:
                number, place = found[0]
                raise ValueError(f"{what} Found in cell {number} (number in the mesh's input) at {place}")
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

    def bound(self):
        """Angular frequency that no mode of the body exceeds [1/T]. Collective.

        Raises:
            ValueError: a stiffness that is not a number; on all ranks.
        """
        largest = float(np.max(self.by_cell()[0], initial=0.0))
        return math.sqrt(self.comm.allreduce(largest, MPI.MAX))

    def step_bound(self, alpha, springs):
        """Step that every cell allows, with damping of the residual's own [T]. Collective.

        Args:
            alpha: factor of mass-proportional damping [1/T]. springs: angular frequency that contact adds [1/T].
        """
        squares, rates = self.by_cell()
        half = 0.5 * (rates + alpha)
        largest = float(np.max(half + np.sqrt(half**2 + squares + springs**2), initial=0.0))
        largest = self.comm.allreduce(largest, MPI.MAX)
        return 2.0 / largest if largest > 0.0 else math.inf

    def highest(self, inverse_mass, extra=None):
        """Highest angular frequency of the assembled system, by SLEPc's Krylov-Schur method [1/T]. Collective.

        Args:
            inverse_mass: owned entries, zero where prescribed [1/M]. extra: PETSc matrix to add, or None.

        Raises:
            RuntimeError: no convergence.
        """
        matrix, root = self._scaled(self.tangent, inverse_mass, extra)
        value, vector = largest_eigenvalue(matrix)
        for thing in (vector, root, matrix):
            thing.destroy()
        return math.sqrt(max(value, 0.0))

    def critical_step(self, inverse_mass, extra, alpha, start):
        """Step at which the assembled system with damping of the residual's own is at its limit [T]. Collective.

        This is where dt^2/4 K + dt/2 C has the eigenvalue one over the mass. From a step, take the eigenvector of the
        largest eigenvalue and the step that it allows: the limit is the least over all vectors, so that the steps fall
        to it.

        Args:
            inverse_mass, extra: as for `highest`. alpha: factor of mass-proportional damping [1/T]. start: a step [T].

        Raises:
            RuntimeError: no convergence.
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
            matrix.shift(0.5 * dt * alpha)
            _, x = largest_eigenvalue(matrix)
            y = x.duplicate()
            K.mult(x, y)
            square = max(x.dot(y).real, 0.0)
            C.mult(x, y)
            half = 0.5 * (max(x.dot(y).real, 0.0) + alpha)
            old, dt = dt, 2.0 / (half + math.sqrt(half**2 + square))
            for thing in (x, y, matrix):
                thing.destroy()
            if abs(dt - old) <= 1e-9 * dt:
                break
        for thing in (K, C, transposed, root, other):
            thing.destroy()
        return dt

    def _scaled(self, form, inverse_mass, extra):
        """Matrix of a form, times the inverse root of the mass from both sides, and a vector of its kind."""
        matrix = operators.Tangent(form).assemble()
        if extra is not None:
            matrix.axpy(1.0, extra)
        root = matrix.createVecRight()
        root.array[:] = np.sqrt(inverse_mass)
        matrix.diagonalScale(root, root)
        return matrix, root


def largest_eigenvalue(matrix):
    """Largest eigenvalue of a symmetric PETSc matrix and its vector of norm one. Collective.

    Raises:
        RuntimeError: no convergence.
    """
    from slepc4py import SLEPc

    solver = SLEPc.EPS().create(matrix.comm)
    solver.setOperators(matrix)
    solver.setProblemType(SLEPc.EPS.ProblemType.HEP)
    solver.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_REAL)
    solver.setTolerances(1e-8, 1000)
    solver.solve()
    if not solver.getConverged():
        solver.destroy()
        raise RuntimeError("the highest frequency was not found: use stable_step(method='element')")
    vector = matrix.createVecRight()
    value = solver.getEigenpair(0, vector).real
    solver.destroy()
    return value, vector
