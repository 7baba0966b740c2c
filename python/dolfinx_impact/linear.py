"""PETSc linear solvers for the problems: chosen by size, checked after every solution."""

import itertools
import weakref

import numpy as np
from petsc4py import PETSc

# LU by MUMPS, which counts pivots that are round-off of the largest entries: a body that is free to move has such
# pivots.
DIRECT = {
    "ksp_type": "preonly",
    "pc_type": "lu",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_24": 1,
    "mat_mumps_cntl_3": 1e-14,
}
# Conjugate gradients with smoothed aggregation, which needs the rigid motions as near-nullspace.
ITERATIVE = {
    "ksp_type": "cg",
    "ksp_max_it": 500,
    "pc_type": "gamg",
    "pc_gamg_threshold": 0.01,
    "mg_levels_ksp_type": "chebyshev",
    "mg_levels_pc_type": "jacobi",
}
# Above these numbers of unknowns factors of 3D and 2D meshes cost more than iterations (measured: 108k unknowns in 3D,
# factorisation 10 s, conjugate gradients 3 s).
LARGEST_DIRECT = {2: 400_000, 3: 40_000}
_SOLVERS = itertools.count()


def _forget(keys):
    """Take the options of a solver out of PETSc's database; else PETSc reports those never read when it ends."""
    database = PETSc.Options()
    for key in keys:
        if database.hasName(key):
            database.delValue(key)


def rigid_motions(V):
    """Near-nullspace of elasticity on a blocked Lagrange space: translations and rotations, orthonormal."""
    gdim, index_map = V.mesh.geometry.dim, V.dofmap.index_map
    x = V.tabulate_dof_coordinates()[: index_map.size_local]
    fields = [np.tile(np.eye(gdim)[a], (len(x), 1)) for a in range(gdim)]
    for a, b in ((0, 1), (1, 2), (2, 0))[: 1 if gdim == 2 else 3]:
        turn = np.zeros((len(x), gdim))
        turn[:, a], turn[:, b] = -x[:, b], x[:, a]
        fields.append(turn)
    vectors = []
    for field in fields:
        v = PETSc.Vec().createMPI((field.size, None), gdim, V.mesh.comm)
        v.array[:] = field.ravel()
        for w in vectors:
            v.axpy(-v.dot(w), w)
        v.normalize()
        vectors.append(v)
    return PETSc.NullSpace().create(vectors=vectors, comm=V.mesh.comm)


class LinearSolver:
    """A KSP with options of its own.

    Args:
        V: displacement space. options: dict of PETSc options without prefix; None chooses by size.
        prefix: what the command line says of it goes first; a number is added to it, so that the options of one
            problem are not those of the next.
    """

    def __init__(self, V, options, prefix):
        size = V.dofmap.index_map.size_global * V.dofmap.index_map_bs
        self.default = DIRECT if size <= LARGEST_DIRECT[V.mesh.geometry.dim] else ITERATIVE
        database, own = PETSc.Options(), f"{prefix}{next(_SOLVERS)}_"
        given = {k: v for k, v in PETSc.Options(prefix).getAll().items() if not k[0].isdigit()}
        chosen = {**(options or {}), **given}
        named = chosen.get("pc_type", self.default["pc_type"])
        base = self.default if named == self.default["pc_type"] else DIRECT if named in ("lu", "cholesky") else {}
        chosen = {**base, **chosen}
        for key, value in chosen.items():
            database[own + key] = value
        weakref.finalize(self, _forget, [own + key for key in chosen])
        self.ksp = PETSc.KSP().create(V.mesh.comm)
        self.ksp.setOptionsPrefix(own)
        self.ksp.setFromOptions()
        self.near_nullspace = None if self.direct else rigid_motions(V)
        self._given_rtol = "ksp_rtol" in chosen
        self._pins = chosen.get("ksp_type") == "cg"

    @property
    def direct(self):
        """Does it factorise?"""
        return self.ksp.getPC().getType() in ("lu", "cholesky")

    def solve(self, A, b, x, symmetric=True, rtol=1e-10, reuse=False):
        """Solve A x = b; returns what is wrong with the solution, or None. Collective.

        Args:
            symmetric: may conjugate gradients be used? rtol: of the residual, for iterative methods whose tolerance
                the options do not set. reuse: the matrix has hardly changed, the preconditioner is still good.
        """
        if not self.direct and not self._given_rtol:
            self.ksp.setTolerances(rtol=min(max(rtol, 1e-10), 1e-3))
        if self._pins:
            self.ksp.setType("cg" if symmetric else "gmres")
        if self.near_nullspace is not None:
            A.setNearNullSpace(self.near_nullspace)
        self.ksp.setOperators(A)
        pc = self.ksp.getPC()
        pc.setReusePreconditioner(not self.direct and reuse)
        self.ksp.solve(b, x)
        fault = self._fault(A, b, x)
        if fault and not self.direct and not self._given_rtol:
            # Preconditioned residuals say little where a body hangs on a few points: once more, and to the end.
            self.ksp.setTolerances(rtol=1e-10)
            pc.setReusePreconditioner(False)
            self.ksp.solve(b, x)
            fault = self._fault(A, b, x)
        return fault

    def _fault(self, A, b, x):
        reason, pc = self.ksp.getConvergedReason(), self.ksp.getPC()
        if reason < 0:
            return f"PETSc reason {reason}"
        if pc.getType() in ("lu", "cholesky") and pc.getFactorSolverType() == "mumps":
            null_pivots = pc.getFactorMatrix().getMumpsInfog(28)
            if null_pivots > 0:
                return f"{null_pivots} pivots vanish"
        residual = b.duplicate()  # not the solver's own word for it
        A.mult(x, residual)
        residual.axpy(-1.0, b)
        error, right = residual.norm(), b.norm()
        residual.destroy()
        # Far from any solver's tolerance: a nearly singular matrix, whose solution is round-off.
        if error <= 2e-2 * right:
            return None
        return f"the residual of the linear system is {error:.1e}, its right side {right:.1e}"
