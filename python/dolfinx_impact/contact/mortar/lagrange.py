# SPDX-License-Identifier: MIT
"""Contact by Lagrange multipliers: dual mortar, primal-dual active set, multipliers condensed; docs/contact.md."""

import functools
from typing import Any

import numpy as np
from petsc4py import PETSc

from ... import _cpp
from ...common.collective import comm_of, guard
from ...common.fixed import Fixed
from ...common.types import BoolArray, FloatArray, IntArray
from ...interface.friction_law import FrictionLaw
from ..pair import ContactPair, check_pair, check_quadrature_degree
from ..static_view import StaticContactView

BASES = ("dual", "standard", "linear")


class Lagrange(Fixed):
    """Enforce contact of a pair by Lagrange multipliers, seed (3.47), corrected.

    Args:
        pair: ContactPair.
        quadrature_degree: of the integrals over segments; None: exact on flat, affine facets.
        basis: "dual": multipliers are condensed, the linear system keeps the size and character of elasticity;
            "standard": the shape functions of the displacements; "linear": linear functions also for displacements of
            degree 2. These two stay in the system, a saddle point for a direct solver. Obstacles take the dual one.

    Raises:
        TypeError: not a ContactPair. ValueError: another basis, or one that an obstacle does not take.
    """

    def __init__(self, pair: ContactPair, quadrature_degree: int | None = None, basis: str = "dual") -> None:
        with guard(comm_of(pair), "Lagrange", pair=pair, quadrature_degree=quadrature_degree, basis=basis):
            check_pair(pair)
            if basis not in BASES:
                raise ValueError(f"basis is {basis!r}: give one of {', '.join(BASES)}")
            if pair.rigid and basis != "dual":
                raise ValueError(f"basis is {basis!r}: against a rigid obstacle multipliers are nodal, give 'dual'")
            quadrature_degree = check_quadrature_degree(quadrature_degree)
        self.pair, self.quadrature_degree, self.basis = pair, quadrature_degree, basis

    def __repr__(self) -> str:
        more = "" if self.quadrature_degree is None else f", quadrature_degree={self.quadrature_degree}"
        return f"Lagrange({self.pair!r}, basis={self.basis!r}{more})"

    def _bind_explicit(self, problem: Any) -> Any:
        raise ValueError("multipliers are for static problems: use Penalty or Kinematic in an ExplicitProblem")

    def _bind(self, problem: Any) -> "LagrangeContact":
        return LagrangeContact(self, problem)


class LagrangeContact(StaticContactView):
    """Multipliers of one pair in a problem, a view of MortarContact (C++). Points are the slave's nodes that this rank
    owns; see ContactOutput. Arrays are copies.

    Args:
        spec: Lagrange.
        problem: StaticProblem.

    Attributes:
        spec: as given.
        basis: basis of the multipliers.
        quadrature_degree: degree of the quadrature; None: exact on flat, affine facets.
        geometry: gaps, normals and weights of the nodes: MortarGeometry (C++).
        nodes: (n) owned nodes of the slave.
        fixed: mask of their prescribed components, (n, gdim).
    """

    may_share_nodes = True  # with other contacts by multipliers
    has_multipliers = True
    all_in_cpp = True
    kind = "multipliers"  #: name of the method that enforces the contact

    _cpp_object: _cpp.multipliers.MortarContact
    nodes: IntArray
    fixed: BoolArray

    def __init__(self, spec: Lagrange, problem: Any) -> None:
        self.spec = spec
        self.pair, self.comm, self.problem = spec.pair, problem.space.mesh.comm, problem
        self.basis, self.quadrature_degree = spec.basis, spec.quadrature_degree
        pair, gdim = self.pair, problem.space.mesh.geometry.dim
        pair.refuse_rigid_body("this problem", problem)
        if problem.axisymmetric:
            pair.refuse_angle("an axisymmetric problem does not turn a rigid master")
        slave, facets = pair.surfaces(problem.space)
        master = facets or pair.rigid_master.shared(gdim, pair.rigid_master.turns_in(problem))
        law = pair.friction.in_cpp(problem.space) if isinstance(pair.friction, FrictionLaw) else None
        friction = 0.0 if isinstance(pair.friction, FrictionLaw) else pair.friction
        options = _cpp.multipliers.MortarOptions(
            name=pair.name, friction=friction, basis=getattr(_cpp.gap.Multipliers, spec.basis),
            quadrature_degree=spec.quadrature_degree, search_distance=pair.search_distance or 0.0,
            axisymmetric=problem.axisymmetric, adjustment=pair.adjustment,
            may_share_nodes=self.may_share_nodes, friction_law=law,
        )  # fmt: skip
        self._cpp_object = self._in_cpp(
            problem.space._cpp_object, slave, master, options, problem.fixed,
        )  # fmt: skip
        self.geometry = self._cpp_object.geometry
        self.nodes, self.gdim, self.fixed = self.geometry.nodes, gdim, self.geometry.fixed
        self._tell_of_penetration()

    def _in_cpp(self, V: Any, slave: Any, master: Any, options: Any, fixed: Any) -> _cpp.multipliers.MortarContact:
        """The contact in C++."""
        return _cpp.multipliers.MortarContact(V, slave, master, options, fixed)

    @functools.cached_property
    def _totals(self) -> _cpp.enforcement.ContactTotals:
        return self._cpp_object.totals

    @property
    def options(self) -> dict[str, Any]:
        return {"basis": self.basis, "quadrature_degree": self.quadrature_degree}

    def facets(self) -> tuple[Any, Any]:
        return self.geometry.slave, self.geometry.master

    # --- state of the nodes ------------------------------------------------------------------------------------------

    @property
    def active(self) -> BoolArray:
        """Mask of nodes in contact, (n)."""
        return self._cpp_object.active

    @active.setter
    def active(self, value: BoolArray) -> None:
        self._cpp_object.active = value

    @property
    def sliding(self) -> BoolArray:
        """Mask of those that slip, (n)."""
        return self._cpp_object.sliding

    @sliding.setter
    def sliding(self, value: BoolArray) -> None:
        self._cpp_object.sliding = value

    @property
    def direction(self) -> FloatArray:
        """Directions of the friction traction of slipping nodes, unit vectors, (n, gdim) [1]."""
        return self._cpp_object.direction

    @property
    def multiplier(self) -> FloatArray:
        """Multipliers, (n) [F/L^2]."""
        return self._cpp_object.multiplier

    @multiplier.setter
    def multiplier(self, value: FloatArray) -> None:
        self._cpp_object.multiplier = np.asarray(value, dtype=np.float64)

    @property
    def friction_traction(self) -> FloatArray:
        """Friction tractions, (n, gdim) [F/L^2]."""
        return self._cpp_object.friction_traction

    @friction_traction.setter
    def friction_traction(self, value: FloatArray) -> None:
        self._cpp_object.friction_traction = np.asarray(value, dtype=np.float64)

    @property
    def friction_coefficient(self) -> FloatArray:
        """Coefficients of friction of the present state, (n) [1]. Collective."""
        return self._cpp_object.friction_coefficients

    @property
    def traction_n(self) -> FloatArray:
        """Friction tractions of the last converged state, (n, gdim) [F/L^2]."""
        return self._cpp_object.traction_n

    @property
    def total_slip(self) -> FloatArray:
        """Slip since a node last stuck, (n, gdim) [L]."""
        return self._cpp_object.total_slip

    @property
    def opening(self) -> FloatArray | None:
        """Gap at the start of the increment where a node is open then, else zero, (n); None before the first [L]."""
        return self._cpp_object.opening

    @opening.setter
    def opening(self, value: FloatArray) -> None:
        self._cpp_object.opening = np.asarray(value, dtype=np.float64)

    @property
    def linearised_gap(self) -> FloatArray:
        """Gaps of the linearised problem, (n) [L]."""
        return self._cpp_object.linearised_gap

    @linearised_gap.setter
    def linearised_gap(self, value: FloatArray) -> None:
        self._cpp_object.linearised_gap = np.asarray(value, dtype=np.float64)

    @property
    def usable(self) -> BoolArray:
        """Mask of nodes that carry a multiplier and may be moved along the normal, (n)."""
        return self._cpp_object.usable

    @property
    def nodal_stiffness(self) -> FloatArray:
        """Stiffness of the bodies at the nodes, (n) [F/L]."""
        return self._cpp_object.nodal_stiffness

    @property
    def numbers(self) -> IntArray:
        """Global numbers of the nodes, (n)."""
        return self.geometry.numbers

    @property
    def last_change(self) -> int:
        return int(self._cpp_object.last_change)

    # --- Newton iterations -------------------------------------------------------------------------------------------

    def num_turning(self) -> int:
        """In space the direction of slip may turn without any change of the active set."""
        return int(self._cpp_object.num_turning())

    def set_redundant(self, nodes: IntArray) -> None:
        self._cpp_object.set_redundant(nodes)

    def over_constrained(self) -> IntArray:
        return self._cpp_object.over_constrained()

    def gap_round_off(self) -> float:
        """These are what multipliers are when bodies touch and nothing presses them."""
        return float(self._cpp_object.gap_round_off())

    def closing_forces(self) -> None:
        """No force besides: constraints close the nearest nodes. See close_nearest."""

    # --- linear system -----------------------------------------------------------------------------------------------

    def constraints(self) -> _cpp.multipliers.Constraints:
        return self._cpp_object.constraints()

    def friction_springs(self) -> tuple[PETSc.Mat, FloatArray] | None:
        return self._cpp_object.friction_springs()

    def imposed_friction_forces(self) -> FloatArray | None:
        found: FloatArray = self._cpp_object.imposed_friction_forces()
        return found if len(found) else None

    def update_linearised_gap(self, increments: FloatArray) -> None:
        self._cpp_object.update_linearised_gap(increments)

    def linearised_response(self, increments: FloatArray, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
        gap, multiplier = self._cpp_object.linearised_response(np.ascontiguousarray(increments), forces)
        return gap, multiplier

    def correct_linearisation(self, u: FloatArray) -> None:
        """As in sequential quadratic programming: normals turn and points slide over the master also in the conditions,
        which condensed multipliers cannot see in their matrix. It comes after `update_linearised_gap`."""
        self._cpp_object.correct_linearisation(u)

    def update_multipliers(self, residual: FloatArray) -> None:
        """From the equilibrium of the slave's nodes."""
        self._cpp_object.update_multipliers(residual)

    def set_multipliers(self, forces: FloatArray) -> None:
        """It comes after `constraints` and `friction_springs`, whose state the solution is of, and
        `update_linearised_gap`."""
        self._cpp_object.set_multipliers(forces)

    def rotate_friction_traction(self) -> None:
        self._cpp_object.rotate_friction_traction()

    def unit_gap(self, number: int) -> FloatArray:
        """Displacements that open a gap of one at a node, owned dofs [L].

        Args:
            number: of the node, of all ranks.
        """
        return self._cpp_object.unit_gap(int(number))

    def unit_force(self, number: int) -> FloatArray:
        """Nodal forces of a unit pressure at one node, on both bodies, owned dofs [F]. Collective.

        Args:
            number: of the node, of all ranks.
        """
        return self._cpp_object.unit_force(int(number))

    # --- results -----------------------------------------------------------------------------------------------------

    @property
    def displacement(self) -> FloatArray:
        """Of a rigid master, as reached, (3) [L]."""
        return self.geometry.displacement
