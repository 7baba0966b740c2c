# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Sequence
from typing import Any, overload

import dolfinx.cpp
import mpi4py.MPI
import numpy
from numpy.typing import NDArray
import petsc4py.PETSc

import dolfinx_impact._cpp

class Condensation:
    """Unknowns and equations of constrained nodes exchanged: T_L^T K T"""

    def __init__(
        self, comm: mpi4py.MPI.Comm, num_owned: int, first: int, gdim: int, parts: Sequence[Constraints]
    ) -> None: ...
    @property
    def right(self) -> petsc4py.PETSc.Mat: ...
    @property
    def left(self) -> petsc4py.PETSc.Mat: ...
    @property
    def symmetric(self) -> bool: ...
    @property
    def known(self) -> NDArray[numpy.float64]:
        """Known increments, a view"""

    @property
    def pinned(self) -> NDArray[numpy.bool_]: ...
    def residual(self, values: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """T_L^T times a nodal residual, zero at pinned unknowns. Collective"""

    def unknowns(self, increments: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """Unknowns that stand for displacement increments"""

    def increment(self, y: petsc4py.PETSc.Vec) -> NDArray[numpy.float64]:
        """Displacement increments T y + known. Collective"""

    def condense(self, K: petsc4py.PETSc.Mat) -> petsc4py.PETSc.Mat:
        """T_L^T K T. Collective"""

class Constraints:
    """Constrained slave nodes of one contact; properties are copies"""

    def __init__(
        self,
        rows: NDArray[numpy.integer[Any]],
        nodes: NDArray[numpy.integer[Any]],
        frames: NDArray[numpy.floating[Any]],
        over: NDArray[numpy.floating[Any]],
        constrained: NDArray[numpy.bool_],
        known: NDArray[numpy.floating[Any]],
        tilt: NDArray[numpy.floating[Any]],
        normal: NDArray[numpy.integer[Any]],
        pointers: NDArray[numpy.integer[Any]],
        columns: NDArray[numpy.integer[Any]],
        values: NDArray[numpy.floating[Any]],
    ) -> None: ...
    @property
    def rows(self) -> NDArray[numpy.int32]: ...
    @property
    def nodes(self) -> NDArray[numpy.int32]: ...
    @property
    def frames(self) -> NDArray[numpy.float64]: ...
    @property
    def over(self) -> NDArray[numpy.float64]: ...
    @property
    def constrained(self) -> NDArray[numpy.bool_]: ...
    @property
    def known(self) -> NDArray[numpy.float64]: ...
    @property
    def tilt(self) -> NDArray[numpy.float64]: ...
    @property
    def normal(self) -> NDArray[numpy.int32]: ...
    @property
    def pointers(self) -> NDArray[numpy.int64]: ...
    @property
    def columns(self) -> NDArray[numpy.int64]: ...
    @property
    def values(self) -> NDArray[numpy.float64]: ...

class DeformableGeometry(MortarGeometry):
    """Between two deformable surfaces"""

    @property
    def integrals(self) -> MortarIntegrals: ...
    @property
    def search(self) -> dolfinx_impact._cpp.search.PairSearch: ...
    @property
    def mortar(self) -> dolfinx_impact._cpp.gap.Mortar:
        """Mortar integrals by entries, numbered as the facets' nodes"""

    @property
    def symmetry(self) -> float:
        """Largest tilt of a normal at a plane of symmetry, its sine [1]"""

    @symmetry.setter
    def symmetry(self, arg: float, /) -> None: ...
    @property
    def map(self) -> dolfinx.cpp.common.IndexMap: ...
    def jump_matrix(self) -> petsc4py.PETSc.Mat:
        """D - M, kept by this object [L^2]. Collective"""

class MortarContact(dolfinx_impact._cpp.enforcement.MultiplierContact):
    """Contact of a pair by multipliers; arrays are copies"""

    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        options: MortarOptions,
        fixed: NDArray[numpy.bool_],
    ) -> None:
        """Collective"""

    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.gap.Rigid,
        options: MortarOptions,
        fixed: NDArray[numpy.bool_],
    ) -> None: ...
    def update_totals(self) -> None:
        """Force, moment, area and work of friction. Collective"""

    @property
    def geometry(self) -> MortarGeometry: ...
    @property
    def initial(self) -> dolfinx_impact._cpp.gap.InitialPenetration: ...
    @property
    def totals(self) -> dolfinx_impact._cpp.enforcement.ContactTotals: ...
    @property
    def friction(self) -> float:
        """The largest coefficient that acts at a node [1]"""

    @property
    def friction_coefficients(self) -> NDArray[numpy.float64]:
        """At the nodes, (n) [1]. Collective"""

    @property
    def usable(self) -> NDArray[numpy.bool_]:
        """Nodes that carry a multiplier and may be moved along the normal, (n)"""

    @property
    def nodal_stiffness(self) -> NDArray[numpy.float64]:
        """(n) [F/L]"""

    def state(self) -> dolfinx_impact._cpp.state.State:
        """What an increment starts from, views"""

    @property
    def active(self) -> NDArray[numpy.bool_]:
        """In contact, (n)"""

    @active.setter
    def active(self, arg: NDArray[numpy.bool_], /) -> None: ...
    @property
    def sliding(self) -> NDArray[numpy.bool_]:
        """Of those, slipping, (n)"""

    @sliding.setter
    def sliding(self, arg: NDArray[numpy.bool_], /) -> None: ...
    @property
    def direction(self) -> NDArray[numpy.float64]: ...
    @direction.setter
    def direction(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def multiplier(self) -> NDArray[numpy.float64]:
        """(n) [F/L^2]"""

    @multiplier.setter
    def multiplier(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def friction_traction(self) -> NDArray[numpy.float64]: ...
    @friction_traction.setter
    def friction_traction(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def traction_n(self) -> NDArray[numpy.float64]: ...
    @traction_n.setter
    def traction_n(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def total_slip(self) -> NDArray[numpy.float64]: ...
    @total_slip.setter
    def total_slip(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def opening(self) -> NDArray[numpy.float64] | None:
        """
        Gap at the start of the increment where a node is open, else zero; None before the first, (n) [L]
        """

    @opening.setter
    def opening(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def linearised_gap(self) -> NDArray[numpy.float64]:
        """Gaps of the linearised problem, (n) [L]"""

    @linearised_gap.setter
    def linearised_gap(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    def update_multipliers(self, residual: NDArray[numpy.floating[Any]]) -> None:
        """Multipliers from equilibrium of the slave's nodes"""

    def set_multipliers(self, forces: NDArray[numpy.floating[Any]]) -> None:
        """Multipliers from a saddle point's forces"""

    def rotate_friction_traction(self) -> None: ...
    def constraints(self) -> Constraints:
        """Constraints of the active nodes for the linear system"""

    def friction_springs(self) -> tuple[petsc4py.PETSc.Mat, NDArray[numpy.float64]] | None:
        """Matrix of the caller's own and forces, or None. Collective"""

    def imposed_friction_forces(self) -> NDArray[numpy.float64]: ...
    def update_linearised_gap(self, increments: NDArray[numpy.floating[Any]]) -> None:
        """Gaps and slips after a linear solution. Collective"""

    def linearised_response(
        self, increments: NDArray[numpy.floating[Any]], forces: NDArray[numpy.floating[Any]]
    ) -> tuple[NDArray[numpy.float64], NDArray[numpy.float64]]:
        """What gaps and multipliers gain, without friction. Collective"""

    def correct_linearisation(self, u: NDArray[numpy.floating[Any]]) -> None:
        """Second-order correction. Collective"""

    def num_turning(self) -> int: ...
    def set_redundant(self, nodes: NDArray[numpy.integer[Any]]) -> None: ...
    def over_constrained(self) -> NDArray[numpy.int32]: ...
    def gap_round_off(self) -> float: ...
    def unit_gap(self, number: int) -> NDArray[numpy.float64]: ...
    def unit_force(self, number: int) -> NDArray[numpy.float64]:
        """Collective"""

    @property
    def last_change(self) -> int: ...

class MortarGeometry:
    """Nodal gaps, normals and weights of a contact by multipliers; copies"""

    @property
    def slave(self) -> dolfinx_impact._cpp.surface.Facets: ...
    @property
    def master(self) -> dolfinx_impact._cpp.surface.Facets:
        """None: it is rigid"""

    @property
    def gdim(self) -> int: ...
    @property
    def basis(self) -> dolfinx_impact._cpp.gap.Multipliers: ...
    @property
    def size(self) -> float:
        """Diagonal of the box around the bodies [L]"""

    @property
    def tolerance(self) -> float:
        """Gaps below it are none [L]"""

    @property
    def index_map(self) -> dolfinx.cpp.common.IndexMap:
        """Of the space's nodes"""

    @property
    def nodes(self) -> NDArray[numpy.int32]:
        """Owned blocks of the space, (n)"""

    @property
    def numbers(self) -> NDArray[numpy.int64]:
        """Their global numbers, (n)"""

    @property
    def fixed(self) -> NDArray[numpy.bool_]:
        """Prescribed components, (n, gdim)"""

    @property
    def offset(self) -> NDArray[numpy.float64]:
        """Added to gaps, (n) [L]"""

    @offset.setter
    def offset(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def points(self) -> NDArray[numpy.float64]:
        """Positions, (n, gdim) [L]"""

    @property
    def u(self) -> NDArray[numpy.float64]: ...
    @property
    def displacement(self) -> NDArray[numpy.float64]: ...
    @property
    def participates(self) -> NDArray[numpy.bool_]: ...
    @property
    def part(self) -> NDArray[numpy.bool_]: ...
    @property
    def weight(self) -> NDArray[numpy.float64]:
        """Diagonal of D, (n) [L^2]"""

    @property
    def cover(self) -> NDArray[numpy.float64]:
        """What faces a master, (n) [L^2]"""

    @property
    def gap(self) -> NDArray[numpy.float64]:
        """Infinite without master, (n) [L]"""

    @property
    def normal(self) -> NDArray[numpy.float64]: ...
    def begin_step(
        self,
        u: NDArray[numpy.floating[Any]],
        displacement: Sequence[float] | None = None,
        target: NDArray[numpy.floating[Any]] | None = None,
    ) -> None:
        """An increment starts"""

    def update_gap(self, u: NDArray[numpy.floating[Any]]) -> None:
        """Gaps, normals, weights. Collective"""

    def jump(self, moved: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """Mean displacements of slave against master, (n, gdim) [L]. Collective"""

    def slip(self) -> NDArray[numpy.float64]:
        """Of this increment, (n, gdim) [L]. Collective"""

    def springs(self, rows: NDArray[numpy.integer[Any]], blocks: NDArray[numpy.floating[Any]]) -> petsc4py.PETSc.Mat:
        """Springs between nodes and what they face [F/L]. Collective"""

    def tangent(
        self,
        multiplier: NDArray[numpy.floating[Any]],
        traction: NDArray[numpy.floating[Any]],
        active: NDArray[numpy.bool_],
    ) -> petsc4py.PETSc.Mat | None:
        """
        Derivative of minus the contact force at given multipliers, kept by this object; None: zero. Collective
        """

    def forces(self, traction: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """Nodal forces on both bodies, owned dofs [F]. Collective"""

class MortarIntegrals:
    """Mortar integrals of a pair"""

    @property
    def normal_sums(self) -> NDArray[numpy.float64]: ...
    @property
    def segments(self) -> dolfinx_impact._cpp.gap.Segments: ...
    @property
    def M(self) -> petsc4py.PETSc.Mat: ...

class MortarOptions:
    """What may be chosen of a contact by multipliers"""

    def __init__(
        self,
        *,
        name: str = "contact",
        friction: float = 0.0,
        basis: dolfinx_impact._cpp.gap.Multipliers = dolfinx_impact._cpp.gap.Multipliers.dual,
        quadrature_degree: int | None = None,
        search_distance: float = 0.0,
        axisymmetric: bool = False,
        adjustment: dolfinx_impact._cpp.gap.GapAdjustment = ...,
        may_share_nodes: bool = True,
        friction_law: dolfinx_impact._cpp.enforcement.FrictionLaw | None = None,
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def friction(self) -> float: ...
    @property
    def basis(self) -> dolfinx_impact._cpp.gap.Multipliers: ...

class RigidGeometry(MortarGeometry):
    """Against a rigid obstacle"""

    @property
    def hessian(self) -> NDArray[numpy.float64]:
        """Derivatives of the normals, (n, gdim, gdim) [1/L]"""

class SaddlePoint:
    """
    Displacements and multipliers as unknowns; `stiffness`: list of matrices
    """

    def __init__(self, comm: mpi4py.MPI.Comm, num_owned: int, gdim: int, sizes: Sequence[int]) -> None:
        """Collective"""

    def assign(
        self,
        parts: Sequence[Constraints],
        pinned: NDArray[numpy.bool_],
        forces: NDArray[numpy.floating[Any]],
        diagonal: float,
    ) -> None:
        """A new linear problem. Collective"""

    @property
    def pinned(self) -> NDArray[numpy.bool_]:
        """Mask of the pinned unknowns, a copy"""

    @property
    def right(self) -> petsc4py.PETSc.Mat:
        """C, kept by this object"""

    @property
    def left(self) -> petsc4py.PETSc.Mat:
        """C_L, kept by this object"""

    def mult(self, stiffness: list[petsc4py.PETSc.Mat], x: petsc4py.PETSc.Vec, y: petsc4py.PETSc.Vec) -> None:
        """y = A x. Collective"""

    def load(
        self,
        stiffness: list[petsc4py.PETSc.Mat],
        residual: NDArray[numpy.floating[Any]],
        values: petsc4py.PETSc.Vec,
        b: petsc4py.PETSc.Vec,
    ) -> None:
        """Right-hand side. Collective"""

    def assemble(self, stiffness: list[petsc4py.PETSc.Mat]) -> petsc4py.PETSc.Mat:
        """A as a matrix of its own. Collective"""

    def unknowns(
        self, increments: NDArray[numpy.floating[Any]], forces: NDArray[numpy.floating[Any]]
    ) -> NDArray[numpy.float64]:
        """
        Unknowns that stand for displacement increments and the multipliers' forces
        """

    def forces(self, y: petsc4py.PETSc.Vec) -> NDArray[numpy.float64]:
        """The multipliers' forces that unknowns stand for"""

class Tie(dolfinx_impact._cpp.enforcement.MultiplierContact):
    """Two surfaces tied to each other; arrays are copies"""

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        options: TieOptions,
        fixed: NDArray[numpy.bool_],
    ) -> None:
        """Collective"""

    @property
    def conditions(self) -> TieConditions: ...
    @property
    def totals(self) -> dolfinx_impact._cpp.enforcement.ContactTotals: ...
    def constraints(self) -> Constraints:
        """Constraints of all nodes for the linear system"""

class TieConditions:
    """Conditions C u = 0 of a tie; arrays are copies"""

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        options: TieOptions,
        fixed: NDArray[numpy.bool_],
    ) -> None:
        """Collective"""

    @property
    def nodes(self) -> NDArray[numpy.int32]: ...
    @property
    def numbers(self) -> NDArray[numpy.int64]: ...
    @property
    def points(self) -> NDArray[numpy.float64]:
        """Reference, (n, gdim) [L]"""

    @property
    def normal(self) -> NDArray[numpy.float64]:
        """Reference, (n, gdim)"""

    @property
    def size(self) -> float:
        """Diagonal of the box around the bodies [L]"""

    @property
    def num_free(self) -> int:
        """Slave nodes of all ranks without a master"""

    @property
    def area(self) -> NDArray[numpy.float64]:
        """(n) [L^2]"""

    @property
    def offset(self) -> NDArray[numpy.float64]:
        """(n, gdim) [L]"""

    @property
    def rows(self) -> Constraints: ...
    @property
    def matrix(self) -> petsc4py.PETSc.Mat:
        """C, kept by this object"""

    def jump(self, u: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """C u over the weights, (n, gdim) [L]. Collective"""

    def forces(self, z: NDArray[numpy.floating[Any]]) -> NDArray[numpy.float64]:
        """C^T z, owned [F]. Collective"""

class TieOptions:
    """What may be chosen of a tie"""

    def __init__(
        self,
        *,
        name: str = "tie",
        normal_only: bool = False,
        partial: bool = False,
        basis: dolfinx_impact._cpp.gap.Multipliers = dolfinx_impact._cpp.gap.Multipliers.dual,
        quadrature_degree: int | None = None,
        search_distance: float = 0.0,
        axisymmetric: bool = False,
    ) -> None: ...
    @property
    def name(self) -> str: ...
    @property
    def normal_only(self) -> bool: ...
    @property
    def basis(self) -> dolfinx_impact._cpp.gap.Multipliers: ...

def adjust_tie(mesh: dolfinx.cpp.mesh.Mesh_float64, conditions: TieConditions) -> float:
    """
    Move the slave's nodes by what the surfaces are apart. Returns the largest motion [L]. Collective
    """

def coo_matrix(
    comm: mpi4py.MPI.Comm,
    num_rows: int,
    num_columns: int,
    rows: NDArray[numpy.integer[Any]],
    columns: NDArray[numpy.integer[Any]],
    values: NDArray[numpy.floating[Any]],
) -> petsc4py.PETSc.Mat:
    """
    Matrix from entries of any rows, global numbers; equal places add up. Collective
    """

def frames_at(
    normals: NDArray[numpy.floating[Any]], fixed: NDArray[numpy.bool_]
) -> tuple[NDArray[numpy.float64], NDArray[numpy.int32], NDArray[numpy.float64]]:
    """
    Frames (n, gdim, gdim), place of the normal direction (n), length of the normal's free part (n)
    """
