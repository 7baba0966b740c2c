"""Largest steps of explicit integration: seed (3.78)-(3.80), docs/explicit.md."""

import math

import basix
import numpy as np
from mpi4py import MPI

from . import _cpp, operators
from .jit import compile_form

METHODS = ("length", "element", "eigenvalue")


def damped(omega, alpha=0.0, beta=0.0, viscosity=0.0, scheme="half_step"):
    """Limit of the step at the angular frequency omega [1/T], with damping; seed (3.78), corrected [T].

    Rayleigh's factors alpha and beta and linear bulk viscosity are a fraction xi of critical damping, which the
    classical scheme's limit does not feel.
    """
    if omega == 0.0:
        return math.inf
    xi = 0.5 * (alpha / omega + beta * omega) + viscosity
    return 2.0 / omega * (1.0 if scheme == "classical" else math.sqrt(1.0 + xi**2) - xi)


def cell_sizes(mesh):
    """Shortest edge between corners of each owned cell [L]."""
    cell = getattr(basix.CellType, mesh.topology.cell_name())
    num_cells = mesh.topology.index_map(mesh.topology.dim).size_local
    x = mesh.geometry.x[mesh.geometry.dofmap[:num_cells]]
    edges = np.array(basix.topology(cell)[1])
    return np.min(np.linalg.norm(x[:, edges[:, 0]] - x[:, edges[:, 1]], axis=2), axis=1)


class Frequencies:
    """Highest frequencies of a body by cells and as a whole.

    Args:
        u: displacement function. tangent: UFL form of rank 2, derivative of the internal force. masses: function
            without arguments, returns what mass.cell_masses does; called when needed, nothing is kept.

    Attributes:
        factor: of each owned cell's mass, or None [1].
    """

    def __init__(self, u, tangent, masses):
        V = u.function_space
        self.u, self.tangent, self.comm = u, tangent, V.mesh.comm
        self._num_cells = V.mesh.topology.index_map(V.mesh.topology.dim).size_local
        self._masses, self.factor = masses, None
        self._compiled = compile_form(tangent)
        tags = next(iter(tangent.subdomain_data().values())).get("cell", [])
        self._tags = next((t for t in tags if t is not None), None)

    def masses(self):
        """Lumped mass of every owned cell, (num_cells, local degrees of freedom) [M]. Collective."""
        V = self.u.function_space
        out = np.zeros((self._num_cells, V.dofmap.bs * V.dofmap.dof_layout.num_dofs))
        for cells, values in self._masses():
            out[cells] += values
        return out if self.factor is None else out * self.factor[:, None]

    def by_cell(self):
        """Square of the highest angular frequency of every owned cell [1/T^2]. Collective."""
        V, of_cells = self.u.function_space, self.masses()
        out = np.zeros(self._num_cells)
        for kernel in self._compiled.kernels:
            if kernel.integral_type != "cell":  # loads that follow the body
                continue
            functions = {c["name"]: self._compiled.coefficients[c["position"]] for c in kernel.coefficients}
            for f in functions.values():
                f.x.scatter_forward()
            functions = {name: f._cpp_object for name, f in functions.items()}
            constants = operators._constants(self._compiled, kernel)
            for subdomain in kernel.subdomains:
                cells = np.ascontiguousarray(operators._entities(V.mesh, "cell", subdomain, self._tags))
                integral = _cpp.operators.Integral(kernel.address, cells, constants)
                masses = np.ascontiguousarray(of_cells[cells]).ravel()
                out[cells] += _cpp.operators.cell_frequencies(integral, V._cpp_object, functions, masses)
        return out

    def bound(self):
        """Angular frequency that no mode of the body exceeds [1/T]. Collective.

        Raises:
            ValueError: a stiffness that is not a number; on all ranks.
        """
        try:
            largest = float(np.max(self.by_cell(), initial=0.0))
        except RuntimeError:
            largest = math.inf
        largest = self.comm.allreduce(largest, MPI.MAX)
        if not math.isfinite(largest):
            raise ValueError("the stiffness of a cell is not a number: check the material, the mesh and the state")
        return math.sqrt(largest)

    def highest(self, inverse_mass, extra=None):
        """Highest angular frequency of the assembled system, by SLEPc's Krylov-Schur method [1/T]. Collective.

        Args:
            inverse_mass: owned entries, zero where prescribed [1/M]. extra: PETSc matrix to add, or None.

        Raises:
            RuntimeError: no convergence.
        """
        from slepc4py import SLEPc

        matrix = operators.Tangent(self.tangent).assemble()
        if extra is not None:
            matrix.axpy(1.0, extra)
        root = matrix.createVecRight()
        root.array[:] = np.sqrt(inverse_mass)
        matrix.diagonalScale(root, root)
        solver = SLEPc.EPS().create(self.comm)
        solver.setOperators(matrix)
        solver.setProblemType(SLEPc.EPS.ProblemType.HEP)
        solver.setWhichEigenpairs(SLEPc.EPS.Which.LARGEST_REAL)
        solver.setTolerances(1e-8, 1000)
        solver.solve()
        value = solver.getEigenvalue(0).real if solver.getConverged() else None
        for thing in (solver, root, matrix):
            thing.destroy()
        if value is None:
            raise RuntimeError("the highest frequency was not found: use stable_step(method='element')")
        return math.sqrt(max(value, 0.0))
