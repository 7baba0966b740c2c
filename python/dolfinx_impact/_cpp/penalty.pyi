# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Callable, Sequence
from typing import Any, overload

import dolfinx.cpp
import mpi4py.MPI
import numpy
from numpy.typing import NDArray
import petsc4py.PETSc

import dolfinx_impact._cpp

class FacetKeeper:
    """Keeps points from alternating between facets"""

    def __init__(self, comm: mpi4py.MPI.Comm) -> None: ...

    margin: float

    widest: float

    @property
    def stay(self) -> bool: ...
    def begin(self, margins: NDArray[numpy.float64]) -> None: ...
    def watch(self, facets: NDArray[numpy.integer[Any]], kept: bool, margins: NDArray[numpy.float64]) -> int: ...
    def leave(self) -> bool: ...

class PenaltyForces:
    """Gaps, tractions, forces and tangent of one pair"""

    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        points: NDArray[numpy.floating[Any]],
        weights: NDArray[numpy.floating[Any]],
        axisymmetric: bool = False,
        search_distance: float = 0.0,
    ) -> None: ...
    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.gap.Rigid,
        points: NDArray[numpy.floating[Any]],
        weights: NDArray[numpy.floating[Any]],
        axisymmetric: bool = False,
    ) -> None: ...
    @property
    def parameters(self) -> PenaltyParameters: ...
    @property
    def history(self) -> PenaltyHistory: ...
    @property
    def points(self) -> Points: ...
    @property
    def state(self) -> PenaltyState: ...
    @property
    def map(self) -> dolfinx.cpp.common.IndexMap: ...
    @property
    def search(self) -> dolfinx_impact._cpp.search.PairSearch: ...
    def share_of(self, q: int) -> float:
        """
        Part of the penalties that a point has, in general contact that of the softer body
        """

    def energy(self) -> float:
        """Energy of the springs, this rank's part"""

    def update_gap(self, u: NDArray[numpy.floating[Any]], start: NDArray[numpy.floating[Any]], stay: bool) -> None: ...
    @overload
    def evaluate(self, increment: NDArray[numpy.floating[Any]], rigid: Sequence[float]) -> None: ...
    @overload
    def evaluate(self) -> None: ...
    def forget(self) -> None:
        """Forget candidates and the places of the tangent"""

    def accept_step(self) -> None: ...
    def add_residual(self, b: petsc4py.PETSc.Vec) -> None: ...
    def contact_forces(self) -> NDArray[numpy.float64]: ...
    def closing_forces(self) -> NDArray[numpy.float64]: ...
    def tangent(self, convex: bool = False) -> petsc4py.PETSc.Mat:
        """PETSc matrix, kept by this object"""

class PenaltyHistory:
    """What points remember; flat arrays, properties are copies"""

    @property
    def multiplier(self) -> NDArray[numpy.float64]: ...
    @multiplier.setter
    def multiplier(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def traction(self) -> NDArray[numpy.float64]: ...
    @traction.setter
    def traction(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def slip(self) -> NDArray[numpy.float64]: ...
    @slip.setter
    def slip(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def gap(self) -> NDArray[numpy.float64]:
        """Of points that were open; of others not positive"""

    @gap.setter
    def gap(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def offset(self) -> NDArray[numpy.float64]:
        """Added to the gaps"""

    @offset.setter
    def offset(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...

class PenaltyOptions:
    """Parameters of penalty contact at quadrature points"""

    def __init__(self) -> None: ...
    @property
    def penalty(self) -> float: ...
    @penalty.setter
    def penalty(self, arg: float, /) -> None: ...
    @property
    def tangential(self) -> float: ...
    @tangential.setter
    def tangential(self, arg: float, /) -> None: ...
    @property
    def friction(self) -> float: ...
    @friction.setter
    def friction(self, arg: float, /) -> None: ...
    @property
    def augmented(self) -> bool: ...
    @augmented.setter
    def augmented(self, arg: bool, /) -> None: ...
    @property
    def tolerance(self) -> float: ...
    @tolerance.setter
    def tolerance(self, arg: float, /) -> None: ...
    @property
    def max_augmentations(self) -> int: ...
    @max_augmentations.setter
    def max_augmentations(self, arg: int, /) -> None: ...
    @property
    def quadrature_degree(self) -> int: ...
    @quadrature_degree.setter
    def quadrature_degree(self, arg: int, /) -> None: ...
    @property
    def search_distance(self) -> float: ...
    @search_distance.setter
    def search_distance(self, arg: float, /) -> None: ...
    @property
    def adjustment(self) -> dolfinx_impact._cpp.gap.GapAdjustment: ...
    @adjustment.setter
    def adjustment(self, arg: dolfinx_impact._cpp.gap.GapAdjustment, /) -> None: ...
    @property
    def axisymmetric(self) -> bool: ...
    @axisymmetric.setter
    def axisymmetric(self, arg: bool, /) -> None: ...
    @property
    def law(self) -> dolfinx_impact._cpp.enforcement.InterfaceLaw:
        """A law of the interface instead; None: there is none"""

    @law.setter
    def law(self, law: dolfinx_impact._cpp.enforcement.InterfaceLaw | None) -> None: ...

class PenaltyParameters:
    """Penalties [F/L^3], friction [1], touch [F/L^2]"""

    @property
    def normal(self) -> float: ...
    @normal.setter
    def normal(self, arg: float, /) -> None: ...
    @property
    def tangential(self) -> float: ...
    @tangential.setter
    def tangential(self, arg: float, /) -> None: ...
    @property
    def friction(self) -> float: ...
    @friction.setter
    def friction(self, arg: float, /) -> None: ...
    @property
    def touch(self) -> float: ...
    @touch.setter
    def touch(self, arg: float, /) -> None: ...

class PenaltyState:
    """Points in one state of displacements; properties are copies"""

    @property
    def status(self) -> NDArray[numpy.int8]:
        """0 open, 1 stick, 2 slip"""

    @property
    def pressure(self) -> NDArray[numpy.float64]: ...
    @property
    def tangential(self) -> NDArray[numpy.float64]: ...
    @property
    def traction(self) -> NDArray[numpy.float64]: ...
    @property
    def slip(self) -> NDArray[numpy.float64]: ...

class Points:
    """Slave quadrature points and their gaps; properties are copies"""

    def __init__(
        self,
        slave: dolfinx_impact._cpp.surface.Facets,
        points: NDArray[numpy.floating[Any]],
        weights: NDArray[numpy.floating[Any]],
        axisymmetric: bool = False,
    ) -> None: ...
    def update(
        self,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.search.SurfaceSearch,
        reach: float,
        keep: bool = False,
    ) -> None:
        """
        Gaps against a deformable master; keep: points over a common edge stay on their facet
        """

    def update_rigid(
        self, slave: dolfinx_impact._cpp.surface.Facets, master: dolfinx_impact._cpp.gap.Rigid
    ) -> None: ...
    @property
    def size(self) -> int: ...
    @property
    def margin(self) -> NDArray[numpy.float64]:
        """
        How far beside a facet that they keep points may be, in reference coordinates
        """

    @margin.setter
    def margin(self, arg: NDArray[numpy.floating[Any]], /) -> None: ...
    @property
    def gdim(self) -> int: ...
    @property
    def per_facet(self) -> int: ...
    @property
    def facet(self) -> NDArray[numpy.int32]: ...
    @property
    def xi(self) -> NDArray[numpy.float64]: ...
    @property
    def weight(self) -> NDArray[numpy.float64]: ...
    @property
    def x(self) -> NDArray[numpy.float64]: ...
    @property
    def status(self) -> NDArray[numpy.int8]: ...
    @property
    def master(self) -> NDArray[numpy.int32]:
        """
        Facet of the master of each point, which an update with `keep` begins from
        """

    @master.setter
    def master(self, arg: NDArray[numpy.integer[Any]], /) -> None: ...
    @property
    def master_xi(self) -> NDArray[numpy.float64]: ...
    @property
    def gap(self) -> NDArray[numpy.float64]: ...
    @property
    def normal(self) -> NDArray[numpy.float64]: ...

class QuadraturePenalty(dolfinx_impact._cpp.enforcement.StaticContact):
    """Penalty contact of one pair in increments"""

    @overload
    def __init__(
        self,
        name: str,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        options: PenaltyOptions,
        bodies: Callable[[], petsc4py.PETSc.Mat],
    ) -> None: ...
    @overload
    def __init__(
        self,
        name: str,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.gap.Rigid,
        options: PenaltyOptions,
        bodies: Callable[[], petsc4py.PETSc.Mat],
    ) -> None: ...
    @overload
    def __init__(
        self,
        name: str,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        facets: dolfinx_impact._cpp.surface.Facets,
        named: Sequence[tuple[dolfinx_impact._cpp.surface.Facets, dolfinx_impact._cpp.surface.Facets]],
        options: PenaltyOptions,
        bodies: Callable[[], petsc4py.PETSc.Mat],
    ) -> None:
        """General contact of a surface with itself"""

    @property
    def deepest(self) -> float:
        """Deepest penetration of all ranks. Collective"""

    @property
    def penalty(self) -> float: ...
    @property
    def tangential(self) -> float: ...
    @property
    def convex(self) -> bool: ...
    @property
    def has_begun(self) -> bool: ...
    @property
    def closes_nearest(self) -> bool: ...
    @property
    def initial(self) -> dolfinx_impact._cpp.gap.InitialPenetration: ...
    @property
    def totals(self) -> dolfinx_impact._cpp.enforcement.ContactTotals: ...
    @property
    def forces(self) -> PenaltyForces: ...
    @property
    def uzawa(self) -> Uzawa: ...
    def nodal_means(self, values: NDArray[numpy.floating[Any]]) -> tuple[NDArray[numpy.int32], NDArray[numpy.float64]]:
        """Owned nodes and means of point values there"""

class Uzawa:
    """Multipliers at the corners of the slave's facets"""

    @property
    def multiplier(self) -> NDArray[numpy.float64]: ...
    @property
    def rounds(self) -> int: ...
