# SPDX-License-Identifier: MIT
"""Tied surfaces whose meshes need not match: mortar conditions of the reference configuration; docs/tie.md."""

import functools
from typing import Any, NamedTuple

import numpy as np
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import Mesh
from mpi4py import MPI

from ... import _cpp
from ...common.collective import comm_of, guard
from ...common.fixed import Fixed
from ...common.types import BoolArray, FloatArray, IntArray
from ..explicit.tied import ExplicitTie
from ..pair import ContactPair, check_pair, check_quadrature_degree
from ..protocol import ExplicitContactProblem
from ..static_view import StaticContactView
from .lagrange import BASES

DIRECTIONS = ("all", "normal")
ROUND_OFF = 1e-14  # of the bodies' size


class Adjusted(NamedTuple):
    """What `Tie.adjust` has moved.

    Attributes:
        number: nodes of all ranks that moved [1].
        largest: largest motion of a node [L].
    """

    number: int
    largest: float


class Tie(Fixed):
    """Tie the two surfaces of a pair to each other, whose meshes need not match.

    Slave nodes that face the master move with it, from the reference configuration on and whatever the load: tractions
    may pull. In static and implicit problems by multipliers, which are condensed with the dual basis, in explicit ones
    by the forces that solve the conditions in every step; docs/tie.md.

    Args:
        pair: the pair of surfaces, without friction; the finer mesh as slave.
        directions: "all", or "normal": the surfaces slide along each other without friction, and do not part. Normals
            are those of the reference configuration.
        partial: leave slave nodes without a master free; else they are an error that names them.
        quadrature_degree: of the integrals over segments; None: exact on flat, affine facets.
        basis: of the tractions: "dual" is condensed in static and implicit problems; "standard" and "linear" stay in
            the system there, as of Lagrange. "linear" has multipliers at the corners of facets alone.

    Raises:
        TypeError: not a ContactPair.
        ValueError: other directions or another basis; a pair with a rigid master, friction, removed penetration or
            smooth surfaces. On all ranks.
    """

    _adjusted: tuple[Mesh, int, tuple[_cpp.surface.Facets, _cpp.surface.Facets]] | None = None

    def __init__(
        self,
        pair: ContactPair,
        directions: str = "all",
        partial: bool = False,
        quadrature_degree: int | None = None,
        basis: str = "dual",
    ) -> None:
        given: dict[str, Any] = dict(pair=pair, directions=directions, partial=bool(partial))
        with guard(comm_of(pair), "Tie", **given, quadrature_degree=quadrature_degree, basis=basis):
            check_pair(pair)
            if directions not in DIRECTIONS:
                raise ValueError(f"directions is {directions!r}: give one of {', '.join(DIRECTIONS)}")
            if basis not in BASES:
                raise ValueError(f"basis is {basis!r}: give one of {', '.join(BASES)}")
            if pair.rigid:
                raise ValueError(
                    f"{pair.name}: a tie needs a surface of the mesh as master; what is tied to a rigid obstacle is "
                    "prescribed: give boundary conditions"
                )
            if pair.has_friction:
                raise ValueError(f"{pair.name}: tied surfaces do not rub: leave friction out, or take Lagrange")
            if pair.remove_penetration:
                raise ValueError(
                    f"{pair.name}: remove_penetration is of contacts; a tie keeps the distance of the surfaces as it "
                    "is, and its method adjust removes it"
                )
            if any(side is not False for side in pair.smooth):
                raise ValueError(f"{pair.name}: a tie takes the facets as they are: leave smooth out")
            quadrature_degree = check_quadrature_degree(quadrature_degree)
        self.pair, self.directions, self.partial = pair, directions, bool(partial)
        self.quadrature_degree, self.basis = quadrature_degree, basis

    def __repr__(self) -> str:
        more = "" if self.directions == "all" else f", directions={self.directions!r}"
        more += ", partial=True" if self.partial else ""
        more += "" if self.quadrature_degree is None else f", quadrature_degree={self.quadrature_degree}"
        more += "" if self.basis == "dual" else f", basis={self.basis!r}"
        return f"Tie({self.pair!r}{more})"

    @property
    def options(self) -> dict[str, Any]:
        """What was given beside the pair, by name."""
        return {name: getattr(self, name) for name in ("directions", "partial", "basis", "quadrature_degree")}

    def options_in_cpp(self, axisymmetric: bool) -> _cpp.multipliers.TieOptions:
        """Options of the tie in C++.

        Args:
            axisymmetric: whether x is the radius.
        """
        return _cpp.multipliers.TieOptions(
            name=self.pair.name, normal_only=self.directions == "normal", partial=self.partial,
            basis=getattr(_cpp.gap.Multipliers, self.basis), quadrature_degree=self.quadrature_degree,
            search_distance=self.pair.search_distance or 0.0, axisymmetric=axisymmetric,
        )  # fmt: skip

    def adjust(self, V: FunctionSpace) -> Adjusted:
        """Move the slave's nodes of the mesh onto the master, in the mean over each node's function, so that rigid
        rotations give no force. The conditions stay those of the surfaces before. Call it before problems are made: the
        mesh changes in place. Collective.

        Args:
            V: displacement space, of the degree of the mesh's geometry.

        Returns:
            What was moved.

        Raises:
            TypeError: V is no function space.
            ValueError: slave nodes without a master, or nodes of displacements that are not those of the geometry.
            On all ranks.
        """
        with guard(comm_of(self.pair), "Tie.adjust"):
            if not isinstance(V, FunctionSpace):
                raise TypeError(f"adjust takes the FunctionSpace of the displacement, found {type(V).__name__}")
        mesh, nodes = V.mesh, V.dofmap.index_map
        fixed = np.zeros((nodes.size_local + nodes.num_ghosts) * V.dofmap.index_map_bs, dtype=bool)
        slave, master = self.surfaces(V)
        conditions = _cpp.multipliers.TieConditions(V._cpp_object, slave, master, self.options_in_cpp(False), fixed)
        before = mesh.geometry.x.copy()
        largest = _cpp.multipliers.adjust_tie(mesh._cpp_object, conditions)
        moved = np.linalg.norm(mesh.geometry.x - before, axis=1)[: mesh.geometry.index_map().size_local]
        number = mesh.comm.allreduce(int(np.count_nonzero(moved > ROUND_OFF * conditions.size)), MPI.SUM)
        self._adjusted = mesh, V.element.basix_element.degree, (slave, master)
        return Adjusted(number, largest)

    def surfaces(self, V: FunctionSpace) -> tuple[_cpp.surface.Facets, _cpp.surface.Facets]:
        """This rank's slave and master facets, those before `adjust` if it was called. Collective.

        Args:
            V: displacement space.

        Raises:
            ValueError: as ContactPair.surfaces, or another mesh or degree than those of `adjust`; on all ranks.
        """
        if self._adjusted is None:
            slave, master = self.pair.surfaces(V)
            assert master is not None  # pairs with rigid masters were refused
            return slave, master
        mesh, degree, found = self._adjusted
        if V.mesh is not mesh or V.element.basix_element.degree != degree:
            raise ValueError(f"{self.pair.name}: the tie was adjusted on another mesh or degree: make another Tie")
        return found

    def _bind(self, problem: Any) -> "TieContact":
        return TieContact(self, problem)

    def _bind_explicit(self, problem: ExplicitContactProblem) -> ExplicitTie:
        surfaces = self.surfaces(problem.space)
        return ExplicitTie(self.pair, problem, self.options, self.options_in_cpp(problem.axisymmetric), surfaces)


class TieContact(StaticContactView):
    """A tie in a static or implicit problem, a view of enforcement/mortar/Tie.h. Points are the slave's nodes that this
    rank owns and that face the master; see ContactOutput. Pressures are negative where the tie pulls, gaps the distance
    of the surfaces in the reference configuration, to round-off. Components that are prescribed at a node have no
    traction. Arrays are copies.

    Args:
        spec: Tie.
        problem: StaticProblem.

    Attributes:
        spec: as given.
        nodes: (n) owned nodes of the slave.
        num_free: slave nodes of all ranks without a master, left free [1].
    """

    initial = None  # type: ignore[assignment]
    has_multipliers = True
    all_in_cpp = True
    kind = "tie"  #: name of the method that enforces the contact

    _cpp_object: _cpp.multipliers.Tie  # type: ignore[assignment]
    nodes: IntArray

    def __init__(self, spec: Tie, problem: Any) -> None:
        self.spec = spec
        self.pair, self.comm, self.problem = spec.pair, problem.space.mesh.comm, problem
        self.gdim = problem.space.mesh.geometry.dim
        self._surfaces = slave, master = spec.surfaces(problem.space)
        self._cpp_object = _cpp.multipliers.Tie(
            problem.space._cpp_object, slave, master, spec.options_in_cpp(problem.axisymmetric), problem.fixed,
        )  # fmt: skip
        self.nodes = self._cpp_object.conditions.nodes

    @functools.cached_property
    def _totals(self) -> _cpp.enforcement.ContactTotals:
        return self._cpp_object.totals

    @property
    def options(self) -> dict[str, Any]:
        return self.spec.options

    def facets(self) -> tuple[Any, Any]:
        return self._surfaces

    @property
    def num_free(self) -> int:
        return int(self._cpp_object.conditions.num_free)

    @property
    def offset(self) -> FloatArray:
        """Distance of slave from master in the reference configuration, by the mortar integrals, (n, gdim); zero along
        directions without a condition [L]."""
        return self._cpp_object.conditions.offset

    @property
    def active(self) -> BoolArray:
        """Mask of nodes in contact, (n): all."""
        return np.ones(len(self.nodes), dtype=bool)
