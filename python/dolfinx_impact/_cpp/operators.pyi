# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Mapping, Sequence
import enum
from typing import Any

import dolfinx.cpp
import numpy
from numpy.typing import NDArray
import petsc4py.PETSc

class AveragedNeoHookean:
    """Forces of averaged strains of neo-Hookean tetrahedra"""

    def __init__(
        self,
        integrals: Sequence[int],
        log_mean: dolfinx.cpp.fem.Function_float64,
        gradients: NodalAverage,
        space: dolfinx.cpp.fem.FunctionSpace_float64,
        displacement: str,
        lmbda: float,
        nodes_mu: float,
        cells_mu: float,
    ) -> None:
        """
        integrals: numbers of those over the material's cells. gradients: as added to the operator. displacement: its name in the operator's kernels. Collective
        """

class CellBounds:
    """Bounds of the eigenvalues of cell matrices over the cells' masses"""

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        parts: Sequence[tuple[Integral, Mapping[str, dolfinx.cpp.fem.Function_float64], bool]],
    ) -> None:
        """parts: integral, functions by name, does it read any?"""

    def set_constants(self, part: int, constants: NDArray[numpy.floating[Any]]) -> None: ...
    @property
    def joins_cells(self) -> bool: ...
    def spectra(
        self, masses: NDArray[numpy.floating[Any]], only: NDArray[numpy.bool_] | None, facets: bool
    ) -> NDArray[numpy.float64]:
        """
        Lower bound, upper bound and norm of the skew part by owned cell. Collective
        """

class Halo:
    """
    Exchange of nodal values between ranks: owned nodes of an IndexMap, then its ghosts
    """

    def __init__(self, index_map: dolfinx.cpp.common.IndexMap, used: NDArray[numpy.integer[Any]] | None = None) -> None:
        """
        used: nonzero for each ghost that takes part in exchanges; None: all. Collective
        """

    @property
    def traffic(self) -> tuple[int, int]: ...
    @property
    def num_owned(self) -> int: ...
    @property
    def num_nodes(self) -> int: ...
    def forward(self, values: NDArray[numpy.float64], bs: int) -> None:
        """Owned values to their ghosts (a view is changed). Collective"""

    def reverse(self, values: NDArray[numpy.float64], bs: int) -> None:
        """Ghost values added to their owners' (a view is changed). Collective"""

class Integral:
    """A kernel, where it acts and its constants (copied)"""

    def __init__(
        self,
        kernel: int,
        entities: NDArray[numpy.integer[Any]],
        constants: NDArray[numpy.floating[Any]],
        history: PointHistory | None = None,
    ) -> None:
        """
        history: internal variables of another operator on the same cells, to read only
        """

class InternalForce_float64:
    """Matrix-free vector of a form of rank 1, value of a form of rank 0"""

    def __init__(
        self,
        mesh: dolfinx.cpp.mesh.Mesh_float64,
        test: dolfinx.cpp.fem.FunctionSpace_float64 | None,
        integrals: Sequence[Integral],
        coefficients: Mapping[str, dolfinx.cpp.fem.Function_float64],
        width: int = 0,
    ) -> None: ...
    def assemble(self, b: NDArray[numpy.float64]) -> None:
        """Add this rank's contributions to b (a view is changed)"""

    def apply(self, b: dolfinx.cpp.la.Vector_float64) -> None:
        """b = f, ghosts exchanged"""

    def value(self) -> float: ...
    def set_constants(self, arg0: int, arg1: NDArray[numpy.floating[Any]], /) -> None: ...
    def history(self, integral: int) -> PointHistory:
        """Internal variables of an integral, or None"""

    def set_in_place(self, in_place: bool) -> None: ...
    def set_mixed(self) -> None:
        """Compute element vectors in float from now on"""

    def sum(self, name: str) -> float:
        """Of this rank's cells, in the last evaluation"""

    def store_snapshot(self) -> None: ...
    def restore_snapshot(self) -> None: ...
    def commit(self) -> None: ...
    def revert(self) -> None: ...
    def has_history(self) -> bool: ...
    def failures(self) -> tuple[int, int, int, float, list[float]]:
        """
        Points not solved in the last evaluation on this rank: number, then cell, point, relative residual and unknowns of the first
        """

    def fault(self) -> str:
        """
        Which local equations were not solved in the last evaluation. Collective
        """

    def width(self, integral: int = 0) -> int: ...
    def swept(self, integral: int) -> bool:
        """
        Did the last evaluation of an integral gather, compute and scatter in one function?
        """

    def repeat(self, b: NDArray[numpy.float64], times: int) -> None:
        """Assemble several times in a row (for timing)"""

    def add_average(self, average: NodalAverage, displacement: str, stress: MeanStress | None = None) -> None:
        """
        Compute averages at the nodes before every evaluation, then collective. stress: of averages that no kernel reads
        """

    def add_together(self, forces: AveragedNeoHookean) -> None:
        """
        Forces of kernels and averages that are added together from now on, where they can be
        """

    @property
    def flops(self) -> float: ...

class KernelTangent:
    """Matrix of kernels and of a form of DOLFINx, made once"""

    def __init__(
        self,
        test: dolfinx.cpp.fem.FunctionSpace_float64,
        trial: dolfinx.cpp.fem.FunctionSpace_float64,
        integrals: Sequence[Integral],
        sources: Sequence[Sequence[Source]],
        other: dolfinx.cpp.fem.Form_float64 | None,
    ) -> None:
        """
        sources: of the coefficients of each integral, in the kernel's order. Collective
        """

    def assemble(self, bcs: Sequence[dolfinx.cpp.fem.DirichletBC_float64]) -> None:
        """Rows and columns of bcs are zeroed. Collective"""

    def add_average(self, average: NodalAverage, force: KernelTangent, measure: KernelTangent) -> None:
        """
        Add the derivative by averages at the nodes: force (by average) times measure (by displacement). Collective
        """

    def set_constants(self, arg0: int, arg1: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def matrix(self) -> petsc4py.PETSc.Mat: ...

class MeanLaw(enum.Enum):
    """Laws of the stress of means at nodes"""

    linear_elastic = 0

    neo_hookean = 1

class MeanStress:
    """Stress of the mean strain or gradient of a node: its law and moduli"""

    def __init__(self, law: MeanLaw, lmbda: float, mu: float) -> None: ...

class NodalAverage:
    """Averages at the nodes of a measure of the cells around them"""

    def __init__(
        self,
        measure: InternalForce_float64,
        volume: InternalForce_float64,
        average: dolfinx.cpp.fem.Function_float64,
        displacement: str,
        linear: bool,
    ) -> None:
        """
        displacement: its name in the kernels of measure. linear: is the measure linear in it? Collective
        """

    def update(self) -> None:
        """At the present displacement. Collective"""

class PointHistory:
    """Internal variables at the points of the cells of one integral"""

    @property
    def cells(self) -> NDArray[numpy.int32]: ...
    @property
    def num_points(self) -> int: ...
    @property
    def names(self) -> list[str]: ...
    def num_components(self, arg: str, /) -> int: ...
    def is_history(self, arg: str, /) -> bool: ...
    def values(self, name: str, trial: bool = False) -> NDArray[numpy.float64]:
        """
        Flat array of shape (num_cells, num_points, num_components), in the order of `cells`
        """

    def set_values(self, name: str, values: NDArray[numpy.floating[Any]]) -> None:
        """Replace committed values; the last evaluation is forgotten"""

    def set_in_place(self, in_place: bool) -> None: ...
    @property
    def in_place(self) -> bool: ...
    def store_snapshot(self) -> None: ...
    def restore_snapshot(self) -> None: ...
    def commit(self) -> None: ...
    def revert(self) -> None: ...
    @property
    def memory(self) -> int:
        """Bytes of all values"""

class Source:
    """Where a coefficient comes from: a function, a history, or neither"""

    def __init__(self, function: dolfinx.cpp.fem.Function_float64 | None = None, field: str = "") -> None: ...

def cell_masses_hrz(
    mass: Integral,
    V: dolfinx.cpp.fem.FunctionSpace_float64,
    coefficients: Mapping[str, dolfinx.cpp.fem.Function_float64],
) -> NDArray[numpy.float64]:
    """HRZ-lumped mass by cell and local degree of freedom"""

def cell_masses_nodal(
    nodal: Integral,
    row_sum: Integral,
    V: dolfinx.cpp.fem.FunctionSpace_float64,
    coefficients: Mapping[str, dolfinx.cpp.fem.Function_float64],
) -> NDArray[numpy.float64]:
    """Lumped mass of a nodal rule by cell and local degree of freedom"""

def largest_rotation(
    x: NDArray[numpy.floating[Any]],
    x_nodes: NDArray[numpy.integer[Any]],
    x_derivatives: NDArray[numpy.floating[Any]],
    u: NDArray[numpy.floating[Any]],
    u_nodes: NDArray[numpy.integer[Any]],
    u_derivatives: NDArray[numpy.floating[Any]],
    cells: NDArray[numpy.integer[Any]],
    gdim: int,
    beyond: float,
) -> tuple[float, int]:
    """
    Angle and cell of the largest rotation beyond an angle at the point of the derivatives [rad]; 0, -1: none
    """

def nodal_averages(
    V: dolfinx.cpp.fem.FunctionSpace_float64,
    points: NDArray[numpy.floating[Any]],
    weights: NDArray[numpy.floating[Any]],
    values: NDArray[numpy.floating[Any]],
) -> NDArray[numpy.float64]:
    """
    Averages at the nodes of values at quadrature points, at owned nodes. Collective
    """

def nodes_of_bodies(
    V: dolfinx.cpp.fem.FunctionSpace_float64, nodes: NDArray[numpy.integer[Any]]
) -> NDArray[numpy.int32]:
    """
    Nodes of the bodies that some nodes of any rank belong to, owned and ghosts. Collective
    """

def resultant(
    V: dolfinx.cpp.fem.FunctionSpace_float64,
    u: NDArray[numpy.floating[Any]],
    forces: NDArray[numpy.floating[Any]],
    dofs: NDArray[numpy.integer[Any]],
    point: Sequence[float],
) -> tuple[list[float], list[float]]:
    """Force and moment of nodal forces, of all ranks. Collective"""
