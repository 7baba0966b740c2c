# SPDX-License-Identifier: MIT
# Written by `make stub` from cpp/bindings: not to be changed by hand.
from collections.abc import Sequence
from typing import Any, overload

import dolfinx.cpp
import numpy
from numpy.typing import NDArray

import dolfinx_impact._cpp

class ExplicitTie(NodalContact):
    """Two surfaces tied in an explicit problem"""

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        options: dolfinx_impact._cpp.multipliers.TieOptions,
        fixed: NDArray[numpy.bool_],
    ) -> None:
        """Collective"""

    @property
    def conditions(self) -> dolfinx_impact._cpp.multipliers.TieConditions: ...
    @property
    def traction(self) -> NDArray[numpy.float64]:
        """Of the last step, (n, gdim) [F/L^2]"""

    def forces(self) -> NDArray[numpy.float64]:
        """Nodal forces of the last step on both surfaces, owned [F]. Collective"""

class GeneralContact(NodalContact):
    """All facets of a surface against each other; all arrays are copies"""

    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        facets: dolfinx_impact._cpp.surface.Facets,
        friction: float = 0.0,
        named: Sequence[tuple[dolfinx_impact._cpp.surface.Facets, dolfinx_impact._cpp.surface.Facets]] = [],
        axisymmetric: bool = False,
    ) -> None:
        """named: pairs of surfaces that other contacts push apart. Collective"""

    @property
    def nodes(self) -> NDArray[numpy.int32]: ...
    @property
    def X(self) -> NDArray[numpy.float64]: ...
    @property
    def areas(self) -> NDArray[numpy.float64]: ...
    def normals(self) -> NDArray[numpy.float64]: ...
    def nodal_forces(self) -> NDArray[numpy.float64]:
        """Collective"""

    def results(self) -> dict[str, NDArray[Any]]: ...
    @property
    def deepest(self) -> float: ...
    @property
    def num_springs(self) -> tuple[int, int]:
        """Springs of nodes, and of crossed edges, on this rank"""

    @property
    def num_candidates(self) -> tuple[int, int]:
        """Listed pairs of nodes and facets, and of edges, on this rank"""

    @property
    def searches(self) -> int: ...
    def energy(self) -> dict[str, float]: ...

class KinematicContact(NodeToSurface):
    """Forces that correct a predicted step"""

    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        friction: float = 0.0,
        sweeps: int = 3,
        search_distance: float = 0.0,
        axisymmetric: bool = False,
        name: str = "contact",
        adjustment: dolfinx_impact._cpp.gap.GapAdjustment = ...,
        friction_law: dolfinx_impact._cpp.enforcement.FrictionLaw | None = None,
    ) -> None: ...
    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.gap.Rigid,
        friction: float = 0.0,
        sweeps: int = 3,
        search_distance: float = 0.0,
        axisymmetric: bool = False,
        name: str = "contact",
        adjustment: dolfinx_impact._cpp.gap.GapAdjustment = ...,
        friction_law: dolfinx_impact._cpp.enforcement.FrictionLaw | None = None,
    ) -> None: ...
    def correct(
        self,
        halo: dolfinx_impact._cpp.operators.Halo,
        u: NDArray[numpy.float64],
        du: NDArray[numpy.floating[Any]],
        inverse_mass: NDArray[numpy.floating[Any]],
        h: float,
        dt: float,
        f: NDArray[numpy.float64],
        share: float = 1.0,
    ) -> None:
        """
        Correct u and add the forces to f (views are changed); before the step nothing moved. Collective
        """

class NodalContact:
    """Contact as the explicit integrator sees it"""

    def saved_state(self) -> dolfinx_impact._cpp.state.State:
        """What the next step starts from, values of its own"""

    def resume(self, saved: dolfinx_impact._cpp.state.State) -> None:
        """Go on from what saved_state has returned"""

    def reset(self) -> None:
        """All nodes become open, energies and histories those of the start"""

class NodalPair:
    """
    Contact of a pair in an explicit problem: one direction, or both (balanced)
    """

    def __init__(self, directions: Sequence[NodalContact]) -> None:
        """
        The first direction has the slave of the pair, a second one has both surfaces exchanged
        """

    @property
    def directions(self) -> list[NodalContact]: ...
    @property
    def force(self) -> NDArray[numpy.float64]:
        """
        Three components of the force on the slave in the last step, of this rank
        """

    def energy(self) -> dict[str, float]: ...

class NodeLaw(NodeToSurface):
    """A law of the interface at slave nodes"""

    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        law: dolfinx_impact._cpp.enforcement.InterfaceLaw,
        friction: float = 0.0,
        search_distance: float = 0.0,
        axisymmetric: bool = False,
        name: str = "contact",
        adjustment: dolfinx_impact._cpp.gap.GapAdjustment = ...,
    ) -> None: ...
    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.gap.Rigid,
        law: dolfinx_impact._cpp.enforcement.InterfaceLaw,
        friction: float = 0.0,
        search_distance: float = 0.0,
        axisymmetric: bool = False,
        name: str = "contact",
        adjustment: dolfinx_impact._cpp.gap.GapAdjustment = ...,
    ) -> None: ...

class NodePenalty(NodeToSurface):
    """Springs between slave nodes and the master"""

    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.surface.Facets,
        friction: float = 0.0,
        penalty: float = 0.0,
        kappa: float = 0.5,
        share: float = 1.0,
        search_distance: float = 0.0,
        axisymmetric: bool = False,
        by_step: bool = False,
        name: str = "contact",
        adjustment: dolfinx_impact._cpp.gap.GapAdjustment = ...,
    ) -> None: ...
    @overload
    def __init__(
        self,
        V: dolfinx.cpp.fem.FunctionSpace_float64,
        slave: dolfinx_impact._cpp.surface.Facets,
        master: dolfinx_impact._cpp.gap.Rigid,
        friction: float = 0.0,
        penalty: float = 0.0,
        kappa: float = 0.5,
        share: float = 1.0,
        search_distance: float = 0.0,
        axisymmetric: bool = False,
        by_step: bool = False,
        name: str = "contact",
        adjustment: dolfinx_impact._cpp.gap.GapAdjustment = ...,
    ) -> None: ...
    def add_forces(
        self,
        halo: dolfinx_impact._cpp.operators.Halo,
        u: NDArray[numpy.floating[Any]],
        du: NDArray[numpy.floating[Any]],
        inverse_mass: NDArray[numpy.floating[Any]],
        dt: float,
        f: NDArray[numpy.float64],
        times: int = 1,
    ) -> None:
        """Add the forces to f (a view is changed); several times for timing"""

class NodeToSurface(NodalContact):
    """Slave nodes against a surface, step after step; all arrays are copies"""

    def search(self, u: NDArray[numpy.floating[Any]], du: NDArray[numpy.floating[Any]]) -> None:
        """
        Find candidates; u: displacements of owned nodes, du: what they move in a step, or empty. Collective
        """

    @property
    def remote_nodes(self) -> NDArray[numpy.int64]: ...
    @property
    def remote_owners(self) -> NDArray[numpy.int32]: ...
    @property
    def facet_length(self) -> float: ...
    def assign_numbers(self, halo: dolfinx_impact._cpp.operators.Halo, mass: NDArray[numpy.floating[Any]]) -> None:
        """Take the numbers of nodes from a Halo. Collective"""

    def increment_used(
        self,
        halo: dolfinx_impact._cpp.operators.Halo,
        u: NDArray[numpy.floating[Any]],
        du: NDArray[numpy.floating[Any]],
        inverse_mass: NDArray[numpy.floating[Any]],
        dt: float,
    ) -> float: ...
    def update_gaps(self, halo: dolfinx_impact._cpp.operators.Halo, u: NDArray[numpy.floating[Any]]) -> None:
        """Bring the gaps of open nodes up to date"""

    def keep_normals(self, keep: bool) -> None:
        """For tests of tests: judge facing by the normals of the last search"""

    def set_obstacle(self, displacement: Sequence[float], increment: Sequence[float]) -> None: ...
    @property
    def nodes(self) -> NDArray[numpy.int32]: ...
    @property
    def X(self) -> NDArray[numpy.float64]: ...
    @property
    def areas(self) -> NDArray[numpy.float64]: ...
    @property
    def search_distance(self) -> float: ...
    @property
    def force(self) -> NDArray[numpy.float64]: ...
    def results(self) -> dict[str, NDArray[Any]]: ...
    def energy(self) -> dict[str, float]: ...
    @property
    def passage(self) -> tuple[int, float]:
        """
        Local number (-1: none) of the slave node that went through the master fastest, facets per step
        """

    def counters(self) -> dict[str, int]: ...
    @property
    def initial(self) -> dolfinx_impact._cpp.gap.InitialPenetration | None:
        """Penetrations in the reference configuration, where gaps are adjusted"""

def balanced_penalty(
    V: dolfinx.cpp.fem.FunctionSpace_float64,
    slave: dolfinx_impact._cpp.surface.Facets,
    master: dolfinx_impact._cpp.surface.Facets,
    friction: float = 0.0,
    penalty: float = 0.0,
    kappa: float = 0.5,
    search_distance: float = 0.0,
    axisymmetric: bool = False,
    by_step: bool = False,
    name: str = "contact",
    adjustment: dolfinx_impact._cpp.gap.GapAdjustment = ...,
) -> NodalPair:
    """
    Both directions of contact by penalty, each with half of the stiffness. Collective
    """
