# SPDX-License-Identifier: MIT
"""PETSc linear solvers for the problems: chosen by size, factors kept while they serve, every solution checked."""

import itertools
import warnings
import weakref
from typing import Any, Iterable, Protocol

import numpy as np
from petsc4py import PETSc

from ..common.described import Described
from .. import _cpp
from ..assembly.curvature import is_displacement
from ..assembly.fields import is_mixed
from ..common.memory import free_garbage
from ..common.types import BoolArray, FloatArray

# LU by MUMPS, which counts pivots that are round-off of the largest entries: a body that is free to move has such
# pivots. One iteration with factors of its own matrix, some more with those of an earlier one.
DIRECT: dict[str, Any] = {
    "ksp_type": "gmres",
    "pc_type": "lu",
    "pc_factor_mat_solver_type": "mumps",
    "mat_mumps_icntl_24": 1,
    "mat_mumps_cntl_3": 1e-14,
}
# Conjugate gradients with smoothed aggregation, which needs the rigid motions as near-nullspace.
CG: dict[str, Any] = {"ksp_type": "cg", "ksp_max_it": 500}
ITERATIVE: dict[str, Any] = {
    **CG,
    "pc_type": "gamg",
    "pc_gamg_threshold": 0.01,
    "mg_levels_ksp_type": "chebyshev",
    "mg_levels_pc_type": "jacobi",
}
# Above these numbers of unknowns factors of 3D and 2D meshes cost more than iterations (measured: 108k unknowns in 3D,
# factorisation 10 s, conjugate gradients 3 s). Factors of lines are band matrices, at any size.
LARGEST_DIRECT = {1: 4_000_000, 2: 400_000, 3: 40_000}
# Up to these numbers of unknowns a system whose iterations do not converge is factorised after all. Factors in space
# take some 2 GB at 200k unknowns, and grow with the power 4/3.
LARGEST_LAST_RESORT = {1: 4_000_000, 2: 4_000_000, 3: 400_000}
# Vectors that GMRES keeps before it begins anew. With PETSc's 30 a wheel on a rail of 235,000 unknowns takes 105
# iterations for three digits instead of 65; they take less memory than the matrix.
RESTART = 100
WORTH = 10  # iterations that cost as much as factors of other packages than MUMPS, which do not tell
# Operations of a factorisation run this much faster than those of a solution with the factors (measured: 4.5 on meshes
# of the plane, 5.5 in space).
BLOCKED = 5.0
MOST_WORK_SPACE = 1000  # beyond what MUMPS foresees [%]
_SOLVERS = itertools.count()


def _forget(keys: Iterable[str]) -> None:
    """Take the options of a solver out of PETSc's database; else PETSc reports those never read when it ends."""
    database = PETSc.Options()
    for key in keys:
        if database.hasName(key):
            database.delValue(key)


def rigid_motions(V: Any) -> PETSc.NullSpace:
    """Near-nullspace of elasticity: translations and rotations, orthonormal. Collective.

    Args:
        V: blocked Lagrange space.
    """
    gdim, index_map = V.mesh.geometry.dim, V.dofmap.index_map
    x = V.tabulate_dof_coordinates()[: index_map.size_local]
    fields = [np.tile(np.eye(gdim)[a], (len(x), 1)) for a in range(gdim)]
    for a, b in ((0, 1), (1, 2), (2, 0))[: 1 if gdim == 2 else 3]:
        turn = np.zeros((len(x), gdim))
        turn[:, a], turn[:, b] = -x[:, b], x[:, a]
        fields.append(turn)
    vectors: list[PETSc.Vec] = []
    for field in fields:
        v = PETSc.Vec().createMPI((field.size, None), gdim, V.mesh.comm)
        v.array[:] = field.ravel()
        for w in vectors:
            v.axpy(-v.dot(w), w)
        v.normalize()
        vectors.append(v)
    return PETSc.NullSpace().create(vectors=vectors, comm=V.mesh.comm)


class System(Protocol):
    """What a LinearSolver asks of a linear system A y = b.

    Attributes:
        K: matrix of the displacements [F/L].
        mask: pinned unknowns of this rank.
        symmetric: is A?
    """

    K: PETSc.Mat
    mask: BoolArray
    symmetric: bool

    @property
    def sizes(self) -> Any:
        """Of the operator, as PETSc takes them."""

    def mult(self, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = A x. Collective.

        Args:
            x: unknowns.
            y: is overwritten.
        """

    def assemble(self) -> PETSc.Mat:
        """A as a matrix of its own, for a preconditioner. Collective."""


class Product:
    """Products with the present system; one operator for all systems, as preconditioners keep it.

    It is an object of its own because PETSc's operator keeps it, and the garbage collector does not see through PETSc's
    objects: a solver that were its own operator would never be freed, and neither would its factors.

    Attributes:
        system: that products are taken with.
    """

    def __init__(self) -> None:
        self.system: System | None = None

    def mult(self, _: PETSc.Mat, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """Product with the system; PETSc calls it.

        Args:
            x: unknowns.
            y: is overwritten.
        """
        assert self.system is not None
        self.system.mult(x, y)


class LinearSolver(Described):
    """A KSP with options of its own.

    Args:
        V: displacement space.
        options: PETSc options without prefix; None chooses by size.
        prefix: what the command line says of it goes first; a number is added to it, so that the options of one
            problem are not those of the next.
        indefinite: the systems are saddle points: a direct solver is the default at any size.

    Attributes:
        near_nullspace: of preconditioners, None for direct solvers.
        num_set_ups: preconditioners made so far; num_iterations: of all solutions.

    Raises:
        ValueError: options that PETSc does not take, or that choose an iterative solver for saddle points.
    """

    def __init__(self, V: Any, options: dict[str, Any] | None, prefix: str, indefinite: bool = False) -> None:
        size = V.dofmap.index_map.size_global * V.dofmap.index_map_bs
        # Lines and surfaces have factors as short as meshes of their own dimension.
        dim = V.mesh.topology.dim
        mixed = is_mixed(V)  # saddle points, or not known to be none
        self.default = DIRECT if indefinite or mixed or size <= LARGEST_DIRECT[dim] else ITERATIVE
        database, own = PETSc.Options(), f"{prefix}{next(_SOLVERS)}_"
        given = {k: v for k, v in PETSc.Options(prefix).getAll().items() if not k[0].isdigit()}
        chosen = {**(options or {}), **given}
        named = chosen.get("pc_type", self.default["pc_type"])
        iterative = {**CG, "ksp_type": "gmres"} if mixed else CG
        factors = named in ("lu", "cholesky")
        base = self.default if named == self.default["pc_type"] else DIRECT if factors else iterative
        chosen = {**base, **chosen}
        for key, value in chosen.items():
            database[own + key] = value
        weakref.finalize(self, _forget, [own + key for key in chosen])
        free_garbage(V.mesh.comm, size)
        self.ksp = PETSc.KSP().create(V.mesh.comm)
        self.ksp.setOptionsPrefix(own)
        try:
            self.ksp.setFromOptions()
        except PETSc.Error as error:
            said = " ".join(str(error).split("[0]")[-1].split())
            raise ValueError(f"PETSc does not take the options {chosen}: {said}") from error
        self._asked = {key: own + key for key in {**(options or {}), **given}}
        if indefinite and not self.direct:
            raise ValueError(
                f"pc_type is {named!r}: multipliers with another basis than 'dual', and those of several contacts at "
                "the same nodes, stay in a saddle point, which needs a direct solver (pc_type lu); or take the dual "
                "basis, and leave common nodes out of the tags"
            )
        self.near_nullspace = rigid_motions(V) if is_displacement(V) and not self.direct else None
        self._given_rtol = "ksp_rtol" in chosen
        self._prefix = own
        by_size = not {"ksp_type", "pc_type"} & {*(options or {}), *given}
        self._may_factorise = by_size and not self.direct and size <= LARGEST_LAST_RESORT[dim]
        self._pins = chosen.get("ksp_type") == "cg"
        # A change of the method forgets its options, so that the user's own length is given again.
        self._restart = int(chosen.get("ksp_gmres_restart", RESTART)) if self._pins else 0
        # A method of the user's own is taken by the word: no iterations with a preconditioner of an earlier matrix.
        self._keeps = chosen.get("ksp_type") == base["ksp_type"]
        self._max_it = self.ksp.getTolerances()[3]
        if self._keeps:
            self.ksp.setTolerances(divtol=1e30)  # the guess may be far worse than none
        self._operator: PETSc.Mat | None = None
        self._product = Product()
        self._own: System | None = None  # that the preconditioner was made of
        self._matrix: PETSc.Mat | None = None
        self._pinned: BoolArray = np.zeros(0, dtype=bool)
        self._pace, self._worth, self._spent = 1.0, 0, 0
        self.num_set_ups, self.num_iterations = 0, 0

    def warn_of_unused(self) -> None:
        """After a solution: warn, once and on rank 0, of options that were asked for and that nobody has read."""
        unused = sorted(key for key, name in self._asked.items() if not _cpp.linear.option_used(name))
        self._asked = {}
        if unused and self.ksp.getComm().rank == 0:
            warnings.warn(
                f"nobody has read the PETSc options {unused}: check how they are written, and whether the solver in "
                f"use (ksp_type {self.ksp.getType()}, pc_type {self.ksp.getPC().getType()}) knows them",
                stacklevel=3,
            )

    def reset(self) -> None:
        """Forget the preconditioner and give back its memory: the next solution does not depend on earlier systems.
        Collective."""
        self._forget_matrix()
        self._own, self._product.system, self._spent = None, None, 0

    def _forget_matrix(self) -> None:
        """Free the preconditioner's matrix and its factors or hierarchy. Collective."""
        if self._matrix is not None:
            self._matrix.destroy()
            self.ksp.getPC().reset()
        self._matrix = None

    @property
    def direct(self) -> bool:
        """Does it factorise?"""
        return self.ksp.getPC().getType() in ("lu", "cholesky")

    def solve(self, system: System, b: PETSc.Vec, x: PETSc.Vec, rtol: float = 1e-10) -> str | None:
        """Solve a linear system. Collective.

        Factors (or the multigrid hierarchy) of an earlier system serve as preconditioner as long as that needs few
        iterations; then the present one is factorised.

        Args:
            system: what it is.
            b: right-hand side.
            x: a guess, becomes the solution.
            rtol: of the residual, for tolerances that the options do not set [1].

        Returns:
            what is wrong with the solution, or None.
        """
        self._choose_method("cg" if system.symmetric else "gmres")
        if b.norm() == 0.0:
            x.set(0.0)  # from another guess a solver comes near zero, which no relative tolerance takes for an answer
        self.ksp.setInitialGuessNonzero(self._keeps)
        if not self._given_rtol:
            self.ksp.setTolerances(rtol=10.0 ** -self._digits(rtol))
        if self._keeps and self._matrix is not None and self._solved(system, b, x, rtol):
            return None
        if self._keeps and self._serves(system, rtol):
            self._run(system, b, x)
            self._spent += max(self.ksp.getIterationNumber() - 1, 0)
            if self.ksp.getConvergedReason() > 0 and not self._fault(system, b, x):
                return None
        if not np.isfinite(x.norm()):
            x.set(0.0)
        self._prepare(system)
        self._run(system, b, x)
        while self._short_of_work_space():
            x.set(0.0)
            self._prepare(system)
            self._run(system, b, x)
        if self._pins and self.ksp.getConvergedReason() == PETSc.KSP.ConvergedReason.DIVERGED_INDEFINITE_PC:
            # Where the stiffness jumps by orders of magnitude and a material is nearly incompressible, multigrid may be
            # indefinite. Conjugate gradients end there; GMRES goes on with it.
            self._choose_method("gmres")
            self._run(system, b, x)
        fault = self._fault(system, b, x)
        if fault and not self.direct and not self._given_rtol:
            # Preconditioned residuals say little where a body hangs on a few points: once more, and to the end.
            self.ksp.setTolerances(rtol=1e-10)
            self._run(system, b, x)
            fault = self._fault(system, b, x)
        self._judge(rtol)
        if fault and self._may_factorise and np.isfinite(b.norm()):
            self._factorise(fault)
            x.set(0.0)
            return self.solve(system, b, x, rtol)
        return fault

    def _factorise(self, fault: str) -> None:
        """From now on solve by factors: the iterations that were chosen by size do not converge. Collective."""
        if self.ksp.getComm().rank == 0:
            warnings.warn(
                f"conjugate gradients with multigrid do not solve the linear system ({fault}): it is factorised, as "
                "those that follow are, which takes more memory and time; options choose another solver",
                stacklevel=4,
            )
        self._may_factorise, self._pins, self.near_nullspace = False, False, None
        self.reset()
        database = PETSc.Options()
        for key, value in DIRECT.items():
            database[self._prefix + key] = value
        weakref.finalize(self, _forget, [self._prefix + key for key in DIRECT])
        self.ksp.reset()
        self.ksp.setFromOptions()
        self.ksp.setNormType(PETSc.KSP.NormType.DEFAULT)

    def _choose_method(self, method: str) -> None:
        """Set the Krylov method where it is not the user's own, and how its residuals are measured."""
        if self._pins:
            self.ksp.setType(method)
        # Residuals as they are: preconditioned ones are all displacement where a body hangs on a few points.
        if self.ksp.getType() == "gmres":
            if self._restart:
                self.ksp.setGMRESRestart(self._restart)
            self.ksp.setPCSide(PETSc.PC.Side.RIGHT)
        elif self.ksp.getType() == "cg":
            self.ksp.setPCSide(PETSc.PC.Side.LEFT)
            self.ksp.setNormType(PETSc.KSP.NormType.UNPRECONDITIONED)

    def factors(self, system: System) -> PETSc.Mat | None:
        """Factors of a system, if it is the one that was factorised last; else None.

        Args:
            system: as it was solved.
        """
        if not self.direct or not self._keeps or self._own is not system:
            return None
        return self.ksp.getPC().getFactorMatrix()

    def _solved(self, system: System, b: PETSc.Vec, x: PETSc.Vec, rtol: float) -> bool:
        """Is the guess good enough? Collective."""
        residual = b.duplicate()
        system.mult(x, residual)
        residual.axpy(-1.0, b)
        norms = residual.norm(), b.norm()
        residual.destroy()
        return norms[0] <= 10.0 ** -self._digits(rtol) * norms[1]

    def _serves(self, system: System, rtol: float) -> bool:
        """May the earlier preconditioner be tried? Sets how many iterations it may take. Collective.

        At a time it may spend as much as a new one costs, in all twice that.
        """
        if self._matrix is None:
            return False
        worth = self._worth if self.direct else int(2 * self._pace * self._digits(rtol)) + 10
        left = min(worth, 2 * worth - self._spent) if self.direct else worth
        # Every unknown that was pinned and is not, or the other way round, takes an iteration at least.
        differ = np.count_nonzero(self._pinned != system.mask)
        if system.K.getComm().tompi4py().allreduce(differ) >= left:
            return False
        self.ksp.setTolerances(max_it=left)
        return True

    @staticmethod
    def _digits(rtol: float) -> float:
        """Decimal digits of a tolerance, within sensible bounds."""
        return -np.log10(min(max(rtol, 1e-12), 1e-3))

    def _judge(self, rtol: float) -> None:
        """How long the preconditioner that has just solved its own system may serve others."""
        self._spent = 0
        self._pace = max(self.ksp.getIterationNumber(), 1) / self._digits(rtol)  # iterations per digit
        pc = self.ksp.getPC()
        if self.direct and self._keeps and pc.getFactorSolverType() == "mumps":
            factors = pc.getFactorMatrix()
            entries = factors.getMumpsInfog(29)
            entries = entries if entries > 0 else -1e6 * entries  # large numbers are told in millions
            self._worth = int(factors.getMumpsRinfog(3) / (4 * entries) / BLOCKED)
        else:
            self._worth = WORTH

    def _prepare(self, system: System) -> None:
        """Preconditioner of the present system."""
        self._forget_matrix()
        self._matrix = system.assemble()
        if self.near_nullspace is not None:
            self._matrix.setNearNullSpace(self.near_nullspace)
        self.ksp.setTolerances(max_it=self._max_it)
        self.ksp.getPC().setReusePreconditioner(False)
        self.num_set_ups += 1
        self._pinned, self._own = system.mask, system

    def _short_of_work_space(self) -> bool:
        """Has MUMPS ended because pivots that it put off took more memory than it had foreseen? Then ask for more.
        Small indefinite matrices do that. Collective."""
        pc = self.ksp.getPC()
        if self.ksp.getConvergedReason() >= 0 or not self.direct or pc.getFactorSolverType() != "mumps":
            return False
        key = self._prefix + "mat_mumps_icntl_14"
        given = PETSc.Options().getInt(key, 20)
        if pc.getFactorMatrix().getMumpsInfog(1) not in (-8, -9) or given >= MOST_WORK_SPACE:
            return False
        PETSc.Options()[key] = 4 * given
        weakref.finalize(self, _forget, [key])
        return True

    def _run(self, system: System, b: PETSc.Vec, x: PETSc.Vec) -> None:
        """Solve with the present preconditioner. Collective."""
        if self._operator is None:
            self._operator = PETSc.Mat().createPython(system.sizes, self._product, comm=system.K.getComm())
            self._operator.setUp()
            self.ksp.getPC().setUseAmat(False)
        self._product.system = system
        self.ksp.setOperators(self._operator, self._matrix)
        self.ksp.solve(b, x)
        self.ksp.getPC().setReusePreconditioner(True)
        self.num_iterations += self.ksp.getIterationNumber()

    def _fault(self, system: System, b: PETSc.Vec, x: PETSc.Vec) -> str | None:
        """What is wrong with a solution, or None. Collective."""
        reason, pc = self.ksp.getConvergedReason(), self.ksp.getPC()
        if reason < 0:
            return f"PETSc reason {reason}"
        if pc.getType() in ("lu", "cholesky") and pc.getFactorSolverType() == "mumps":
            null_pivots = pc.getFactorMatrix().getMumpsInfog(28)
            if null_pivots > 0:
                return f"{null_pivots} pivots vanish"
        residual = b.duplicate()  # not the solver's own word for it
        system.mult(x, residual)
        residual.axpy(-1.0, b)
        error, right = residual.norm(), b.norm()
        residual.destroy()
        # Far from any solver's tolerance: a nearly singular matrix, whose solution is round-off.
        if error <= 2e-2 * right:
            return None
        return f"the residual of the linear system is {error:.1e}, its right side {right:.1e}"


class Stiffness:
    """K and what contacts add to it, a sum that is not formed.

    Args:
        K: matrix of the displacements [F/L].
        extra: matrices of the same size, which are added to it [F/L].
    """

    def __init__(self, K: PETSc.Mat, extra: list[PETSc.Mat]) -> None:
        self.K, self.extra = K, extra

    def stiffness(self, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = (K + sum of extra) x. Collective.

        Args:
            x: displacements [L].
            y: is overwritten [F].
        """
        self.K.mult(x, y)
        for E in self.extra:
            E.multAdd(x, y, y)


class LinearSystem(Stiffness):
    """Stiffness and what contacts add to it, condensed by a transformation, some unknowns pinned.

    A = Q T_L^T (K + sum of extra) T Q + d (1 - Q), where Q sets pinned unknowns to zero. Products need no A; only a
    preconditioner forms it.

    Args:
        K: matrix of the displacements [F/L].
        extra: matrices of the same size, which are added to it [F/L].
        symmetric: are they?
        transformation: Condensation (C++) or None.
        pinned: mask over owned degrees of freedom.
        diagonal: d, an entry of the size of K's [F/L].

    Attributes:
        mask, pinned: the pinned unknowns as a mask and by number.
    """

    def __init__(
        self,
        K: PETSc.Mat,
        extra: list[PETSc.Mat],
        symmetric: bool,
        transformation: Any,
        pinned: BoolArray,
        diagonal: float,
    ) -> None:
        super().__init__(K, extra)
        self.transformation = transformation
        self.symmetric = symmetric and (transformation is None or transformation.symmetric)
        self.mask, self.pinned, self.diagonal = pinned, np.flatnonzero(pinned), diagonal
        self._work = [K.createVecRight() for _ in range(3)]

    @property
    def sizes(self) -> Any:
        """Of the operator, as PETSc takes them."""
        return self.K.getSizes()

    def create(self) -> PETSc.Vec:
        """A vector of the unknowns."""
        return self.K.createVecRight()

    def free(self) -> None:
        """Give back the memory of what was made here. Collective."""
        for vector in self._work:
            vector.destroy()

    def mult(self, x: PETSc.Vec, y: PETSc.Vec) -> None:
        """y = A x. Collective.

        Args:
            x: unknowns [L].
            y: is overwritten [F].
        """
        free, moved, force = self._work
        x.copy(free)
        free.array[self.pinned] = 0.0
        if self.transformation is None:
            self.stiffness(free, y)
        else:
            self.transformation.right.mult(free, moved)
            self.stiffness(moved, force)
            self.transformation.left.multTranspose(force, y)
        y.array[self.pinned] = self.diagonal * x.array_r[self.pinned]

    def load(self, residual: FloatArray, values: PETSc.Vec, b: PETSc.Vec) -> None:
        """Right-hand side b. Collective.

        Args:
            residual: nodal, owned dofs [F].
            values: unknowns, of which the pinned ones count [L].
            b: is overwritten [F].
        """
        pinned, moved, force = self._work
        pinned.set(0.0)
        pinned.array[self.pinned] = values.array_r[self.pinned]
        moved.array[:] = self.displacements(pinned)
        self.stiffness(moved, force)
        force.array[:] = -residual - force.array
        if self.transformation is None:
            force.copy(b)
        else:
            self.transformation.left.multTranspose(force, b)
        b.array[self.pinned] = self.diagonal * values.array_r[self.pinned]

    def displacements(self, y: PETSc.Vec) -> FloatArray:
        """Increments of displacement that unknowns stand for, owned dofs [L]. Collective.

        Args:
            y: unknowns [L].
        """
        return y.array_r.copy() if self.transformation is None else self.transformation.increment(y)

    def assemble(self) -> PETSc.Mat:
        """A as a matrix of its own. Collective."""
        total = self.K.copy() if self.extra or self.transformation is None else self.K
        for E in self.extra:
            total.axpy(1.0, E, PETSc.Mat.Structure.DIFFERENT_NONZERO_PATTERN)
        A = total
        if self.transformation is not None:
            A = self.transformation.condense(total)
            if total is not self.K:
                total.destroy()
        A.zeroRowsColumns(A.getOwnershipRange()[0] + self.pinned.astype(np.int32), self.diagonal)
        return A
