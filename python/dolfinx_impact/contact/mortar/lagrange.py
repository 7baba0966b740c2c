# SPDX-License-Identifier: MIT
"""Contact by Lagrange multipliers: dual mortar, primal-dual active set, multipliers condensed; docs/contact.md."""

import copy
from typing import Any

import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from ... import _cpp
from ...common.collective import comm_of, guard
from ...common.fixed import Fixed
from ...common.types import AnyArray, BoolArray, FloatArray, IntArray
from .geometry import make_geometry
from .prescribed_overlap import prescribed_overlap
from ..crossing import describe, through_master, through_obstacle
from ..pair import ContactPair, ContactStatus, check_pair, check_quadrature_degree
from ..initial_penetration import InitialPenetration, check_side, nearly_touching
from ..output import ContactOutput
from ..saved_history import SavedHistory

NO_MASTER = -1.0  # stands for an infinite opening in checkpoints; openings are not negative
BASES = ("dual", "standard", "linear")
TURNED = 1e-6  # of the largest bound: friction tractions of a converged state are off by less
PENETRATES = 1e-6  # of the bodies' size: a gap of a linearised problem, which is solved to a few digits
SHARP = 60.0  # between the sides of an edge, whose mean normal is then 30 degrees off both [degrees]
LEAST_ANGLE = 0.1  # between two normals whose edge is a direction of its own [rad]
# Arrays by node that all contacts of a joined node have alike.
_STATE = ("active", "sliding", "direction", "multiplier", "friction_traction", "traction_n", "total_slip")


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


class LagrangeContact(ContactOutput):
    """Multipliers of one pair in a problem. Points are the slave's nodes that this rank owns; see ContactOutput.

    Args:
        spec: Lagrange.
        problem: StaticProblem.

    Attributes:
        nodes: (n) owned nodes of the slave.
        active: (n) mask of nodes in contact; sliding: (n) of those that slip.
        direction: (n, gdim) of the friction traction of slipping nodes, unit vectors [1].
        multiplier: (n) [F/L^2]. friction_traction: (n, gdim) [F/L^2]; traction_n: that of the last converged state.
        total_slip: (n, gdim) since a node last stuck [L].
        opening: (n) gap at the start of the increment where a node is open then, else zero [L]; None before the first.
        basis: basis of the multipliers.
        quadrature_degree: degree of the quadrature; None: exact on flat, affine facets.
        edges: other contacts that constrain nodes of this one along another normal: contact, index of the nodes among
            this contact's and among its own.
        partners: other contacts with which nodes are joined, and the index of each node among theirs, (n), -1: none.
        redundant: mask of nodes whose normal condition other conditions of the same node imply, (n).
        coulomb: tractions that no equilibrium of a node tells: CoulombFriction (C++).
        nodal_stiffness, facing_stiffness: (n) of the bodies at the slave's nodes and opposite to them [F/L].
    """

    may_share_nodes = True  # with other contacts by multipliers

    nodes: IntArray
    gdim: int
    active: BoolArray
    sliding: BoolArray
    direction: FloatArray
    multiplier: FloatArray
    friction_traction: FloatArray
    traction_n: FloatArray
    nodal_stiffness: FloatArray
    facing_stiffness: FloatArray
    # Of the state that is linearised about, and of the present linear solution.
    _at: tuple[FloatArray, FloatArray]
    _gap: FloatArray
    _slip: FloatArray
    _linear_tilt: FloatArray

    def __init__(self, spec: Lagrange, problem: Any) -> None:
        self.pair, self.comm, self.problem = spec.pair, problem.space.mesh.comm, problem
        self.basis, self.quadrature_degree = spec.basis, spec.quadrature_degree
        self.geometry = make_geometry(spec, problem.space, problem.axisymmetric, problem.fixed)
        self._obstacle = self.pair.rigid_master.obstacle(self.geometry.gdim) if self.pair.rigid else None
        self._initial = self._initial_penetration()
        self.nodes, self.gdim = self.geometry.nodes, self.geometry.gdim
        n = len(self.nodes)
        self.fixed = self.geometry.fixed
        self.active = np.zeros(n, dtype=bool)
        self.sliding = np.zeros(n, dtype=bool)
        self.direction = np.zeros((n, self.gdim))
        self.multiplier = np.zeros(n)
        self.friction_traction = np.zeros((n, self.gdim))
        self.traction_n = np.zeros((n, self.gdim))
        self.total_slip = np.zeros((n, self.gdim))
        self.opening: FloatArray | None = None
        self.coulomb = _cpp.multipliers.CoulombFriction(self.gdim, n)
        self._lock, self._no_tilt = np.zeros(0), np.zeros((n, self.gdim))
        self.nodal_stiffness = np.ones(n)
        self.facing_stiffness = np.zeros(n)
        self.last_change = -1
        self.partners: list[tuple[LagrangeContact, IntArray]] = []
        self.edges: list[tuple[LagrangeContact, IntArray, IntArray]] = []
        self.redundant: BoolArray = np.zeros(n, dtype=bool)
        self._crowded: BoolArray = np.zeros(n, dtype=bool)

    def _initial_penetration(self) -> InitialPenetration:
        """The state before anything is loaded, and the offsets of gaps that follow from it. Collective."""
        g, V = self.geometry, self.problem.space
        if self._obstacle is not None:
            check_side(self.pair, V, g.slave, self._obstacle)
        g.update_gap(np.zeros(len(self.problem.fixed)))
        initial = InitialPenetration(self.pair, V, g.slave, g.master, g.points, g.gap)
        g.offset = initial.offset
        return initial

    @property
    def _coefficient(self) -> float:
        """Coefficient of friction, the largest of those that act at a node [1]."""
        return max([self.pair.friction, *(c.pair.friction for c, _ in self.partners)])

    @property
    def _friction(self) -> bool:
        return self._coefficient > 0.0

    def _coefficients(self) -> FloatArray:
        """Coefficients of friction of the nodes, (n) [1]."""
        if not self.geometry.joined:
            return np.full(len(self.nodes), self.pair.friction)
        friction = {self.geometry.member: self.pair.friction}
        friction |= {c.geometry.member: c.pair.friction for c, _ in self.partners}
        return self.geometry.mean([friction[k] for k in sorted(friction)])

    # --- nodes that belong to several pairs --------------------------------------------------------------------------

    @property
    def _part(self) -> BoolArray:
        """Nodes at which this pair has a force where it is active, mask (n)."""
        return self.geometry.part & (self.place >= 0)

    @property
    def _own(self) -> BoolArray:
        """Nodes whose state this contact decides, mask (n)."""
        return self.geometry.carrier

    def _tell_partners(self) -> None:
        """Joined nodes have the state of their carrier in all contacts."""
        for other, index in self.partners:
            mine = np.flatnonzero((index >= 0) & self._own)
            theirs = index[mine]
            mine, theirs = mine[~other._own[theirs]], theirs[~other._own[theirs]]
            for name in _STATE:
                getattr(other, name)[theirs] = getattr(self, name)[mine]
            if self._friction:
                imposed = other.coulomb.imposed
                imposed[theirs] = self.coulomb.imposed[mine]
                other.coulomb.imposed = imposed

    # --- state of an increment -------------------------------------------------------------------------------------

    def save_state(self) -> dict[str, Any]:
        """State that an increment starts from, as a dict of copies."""
        names = ("active", "sliding", "direction", "multiplier", "friction_traction", "total_slip", "opening")
        state = {name: copy.copy(getattr(self, name)) for name in (*names, "traction_n")}
        return state | {"imposed": self.coulomb.imposed, "geometry": self.geometry.state().copy()}

    def restore_state(self, state: dict[str, Any]) -> None:
        """Back to a saved state.

        Args:
            state: of save_state.
        """
        for name, value in state.items():
            if name == "geometry":
                self.geometry.state().assign(value)
            elif name == "imposed":
                self.coulomb.imposed = value
            else:
                setattr(self, name, copy.copy(value))

    @property
    def kind(self) -> str:
        """Name of the method that enforces the contact."""
        return "multipliers"

    def facets(self) -> tuple[Any, Any]:
        """Facets of slave and master on this rank (C++); None: the master is rigid."""
        return self.geometry.slave, self.geometry.master

    @property
    def options(self) -> dict[str, Any]:
        """Options by name, for the signature of a checkpoint."""
        return {"basis": self.basis, "quadrature_degree": self.quadrature_degree}

    def save_history(self) -> SavedHistory:
        """What the next increment starts from, for a checkpoint."""
        n, opening = len(self.nodes), np.zeros(len(self.nodes)) if self.opening is None else self.opening
        scalars = {"active": self.active, "sliding": self.sliding, "multiplier": self.multiplier, "opening": opening}
        vectors = {
            "direction": self.direction, "friction_traction": self.friction_traction, "traction_n": self.traction_n,
            "total_slip": self.total_slip, "imposed": np.reshape(self.coulomb.imposed, (n, self.gdim)),
        }  # fmt: skip
        columns = {name: np.asarray(v, dtype=float).reshape(n, 1) for name, v in scalars.items()} | vectors
        # Gaps without a master are infinite, which a table of numbers must not be.
        columns["opening"] = np.where(np.isfinite(columns["opening"]), columns["opening"], NO_MASTER)
        return SavedHistory(False, self.nodes, columns, self.save_totals() | {"master": self.displacement})

    def restore_history(self, saved: SavedHistory, u: FloatArray) -> None:
        """Continue from a checkpoint. Collective.

        Args:
            saved: as save_history returned it.
            u: displacements of the checkpoint, owned and ghost dofs [L].
        """
        rows = saved.columns
        self.geometry.begin_step(u, saved.totals["master"] if self.pair.rigid else None)
        self.update_gap(u)
        self.active, self.sliding = (rows[name][:, 0] != 0.0 for name in ("active", "sliding"))
        self.multiplier, opening = rows["multiplier"][:, 0].copy(), rows["opening"][:, 0]
        self.opening = np.where(opening == NO_MASTER, np.inf, opening)
        for name in ("direction", "friction_traction", "traction_n", "total_slip"):
            setattr(self, name, rows[name].copy())
        self.coulomb.imposed = rows["imposed"]
        self.restore_totals(saved.totals)

    def forget(self) -> None:
        """Forget candidates; see ContactOutput."""
        self.geometry.forget()

    def begin_step(self, u: FloatArray, displacement: Any, target: FloatArray | None = None) -> None:
        """An increment starts. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
            displacement: of a rigid master at the end of the increment, (3); None for deformable masters [L].
            target: prescribed values at its end, over all dofs, prescribed entries count; None: they stay [L].
        """
        self._crowded[:] = False
        if self.opening is None:
            self.geometry.update_gap(u)
            self.opening = self._opened(self.geometry.gap)
        self.geometry.begin_step(u, displacement, target)

    def _opened(self, gap: FloatArray) -> FloatArray:
        return np.where(~self.active & (gap > self.geometry.tolerance), gap, 0.0)

    def accept_step(self) -> None:
        """The increment has converged: slip adds up, less what a node slides before it closes. Collective."""
        slip, opening = self._slip, np.zeros(0) if self.opening is None else self.opening
        if self._friction:  # along locked directions nothing slips
            slip = slip - np.einsum("nab,nb->na", self._lock + self._edge_locks(), slip)
        length = np.linalg.norm(slip, axis=1)
        free = np.where(np.isfinite(opening), opening, 0.0) * self._coefficients()
        part = np.where(opening > 0.0, np.maximum(0.0, 1.0 - free / np.maximum(length, 1e-300)), 1.0)
        self.total_slip += np.where(self.active[:, None], part[:, None] * slip, 0.0)
        self.total_slip[~self.active] = 0.0
        self._tell_partners()
        self.opening = self._opened(self.linearised_gap)
        self.traction_n = np.where(self.active[:, None], self.friction_traction, 0.0)
        self.update_totals()

    def update_gap(self, u: FloatArray) -> None:
        """Search, gaps and normals. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """
        g = self.geometry
        g.update_gap(u)
        self.frames, self.place, self.free_length = _cpp.multipliers.frames_at(g.normal, self.fixed)
        self._align_frames()
        self.usable = g.participates & (self.place >= 0) & g.carrier
        self.redundant = np.zeros(len(self.nodes), dtype=bool)
        self.linearised_gap, self._slip = g.gap, g.slip()
        self._at = self.linearised_gap, self._slip
        if self._friction:
            self.coulomb.update_directions(self.usable, self._geometry(), g.locked)
            self._lock = self.coulomb.locked

    def _edge_locks(self) -> FloatArray | float:
        """Projectors on the directions along the surface that other contacts of the same nodes hold, (n, gdim, gdim);
        0 without any."""
        if not self.edges or not self._friction:
            return 0.0
        g = self.geometry
        basis, count = np.zeros((len(self.nodes), self.gdim, self.gdim)), np.zeros(len(self.nodes), dtype=int)
        for other, mine, theirs in self.edges:
            on = (self.active & self.usable)[mine] & (other.active & other.geometry.participates)[theirs]
            rows, normals = mine[on], other.geometry.normal[theirs[on]]
            # Gram-Schmidt: less the node's own normal, and what others hold.
            own = g.normal[rows]
            part = normals - np.einsum("na,na->n", own, normals)[:, None] * own
            part -= np.einsum("nab,nb->na", basis[rows], part)
            length = np.linalg.norm(part, axis=1)
            new = length > LEAST_ANGLE
            axis = part[new] / length[new, None]
            basis[rows[new]] += axis[:, :, None] * axis[:, None, :]
            count[rows[new]] += 1
        basis[count == 0] = 0.0
        basis[np.any(self.fixed, axis=1)] = 0.0  # there prescribed components decide
        return basis

    def _align_frames(self) -> None:
        """At nodes with two normals in space one tangent lies along the edge between them: what sticks or slips there
        is told apart from what the other normal holds."""
        if self.gdim == 2 or not self._friction:
            return
        for other, mine, theirs in self.edges:
            normal = self.geometry.normal[mine]
            edge = np.cross(normal, other.geometry.normal[theirs])
            length = np.linalg.norm(edge, axis=1)
            free = (length > LEAST_ANGLE) & ~np.any(self.fixed[mine], axis=1)
            rows, edge = mine[free], edge[free] / length[free, None]
            tangents = np.stack([edge, np.cross(edge, normal[free])], axis=1)
            for k in range(2):
                column = (self.place[rows] + 1 + k) % 3
                self.frames[rows, :, column] = tangents[:, k]

    def update_linearised_gap(self, increments: FloatArray) -> None:
        """Gaps and slips after a linear solution, linear in its increments. Collective.

        Args:
            increments: of displacement, owned dofs [L].
        """
        self.linearised_gap, self._slip = _cpp.multipliers.add_jump(self._geometry(), self.geometry.jump(increments))
        if self._friction:
            self.coulomb.raise_imposed(self._state(), self._coefficient)

    def linearised_response(self, increments: FloatArray, forces: FloatArray) -> tuple[FloatArray, FloatArray]:
        """What gaps and multipliers gain by increments and the forces they cause, without friction. Collective.

        Args:
            increments: of displacement, owned dofs [L].
            forces: nodal, owned dofs [F].

        Returns:
            gaps (n) [L], multipliers (n) [F/L^2].
        """
        gap = np.einsum("na,na->n", self.geometry.normal, self.geometry.jump(increments))
        return gap, _cpp.multipliers.normal_tractions(self.usable, self._geometry(), self._at_nodes(forces))

    def correct_linearisation(self, u: FloatArray) -> None:
        """After update_linearised_gap: take in what gaps and slips differ from the linear ones. Collective.

        A second-order correction, as in sequential quadratic programming: normals turn and points slide over the master
        also in the conditions, which condensed multipliers cannot see in their matrix.

        Args:
            u: displacements that the linear problem leads to, owned and ghost dofs [L].
        """
        gap, slip = self.geometry.evaluate_at(u)
        self._at = _cpp.multipliers.add_linearisation_error(
            self._state(), self._geometry(), self.gdim, self._coefficient, gap, slip
        )

    # --- active set ------------------------------------------------------------------------------------------------

    def _state(self) -> dict[str, AnyArray]:
        """Arrays of the nodes' state, as C++ names them (NodalMultipliers)."""
        return {
            "usable": self.usable, "active": self.active, "sliding": self.sliding, "gap": self.linearised_gap,
            "multiplier": self.multiplier, "slip": self._slip, "traction": self.friction_traction,
            "direction": self.direction,
            "stiffness": self.nodal_stiffness / np.where(self.usable, self.geometry.weight, 1.0),
            "opening": np.zeros(0) if self.opening is None else self.opening, "lock": self._lock + self._edge_locks(),
            "roughness": self._coefficients() / self._coefficient if self.partners and self._friction else np.zeros(0),
        }  # fmt: skip

    def _geometry(self) -> dict[str, AnyArray]:
        """Arrays of the nodes where the linear problem is linearised, as C++ names them (NodalGeometry)."""
        g = self.geometry
        return {
            "nodes": self.nodes, "normal": g.normal, "gap": self._at[0], "slip": self._at[1], "weight": g.weight,
            "cover": g.cover, "fixed": self.fixed, "ahead": g.ahead(), "frames": self.frames, "place": self.place,
            "length": self.free_length,
        }  # fmt: skip

    def _at_nodes(self, values: FloatArray) -> FloatArray:
        """Values over owned dofs at the slave's nodes, (n, gdim)."""
        return values.reshape(-1, self.gdim)[self.nodes]

    def _law(self) -> tuple[int, float]:
        return self.gdim, self._coefficient

    def _tilt(self) -> FloatArray:
        """Friction traction per pressure, (n, gdim), of nodes that slip or have closed in this increment; else zero."""
        return _cpp.multipliers.friction_tilt(self._state(), *self._law()) if self._friction else self._no_tilt

    def unit_gap(self, number: int) -> FloatArray:
        """Displacements that open a gap of one at a node, owned dofs [L].

        Args:
            number: of the node, of all ranks.
        """
        here = np.flatnonzero(self.geometry.numbers == number)
        known = np.zeros((self.geometry.index_map.size_local, self.gdim))
        known[self.nodes[here]] = self.frames[here, :, self.place[here]] / self.free_length[here, None]
        return known.ravel()

    @property
    def numbers(self) -> IntArray:
        """Global numbers of the nodes, (n)."""
        return self.geometry.numbers

    def unit_force(self, number: int) -> FloatArray:
        """Nodal forces of a unit traction along the normal at a node, on both bodies, owned dofs [F]. Collective.

        Args:
            number: of the node, of all ranks.
        """
        here = self.geometry.numbers == number
        return self.geometry.forces(np.where(here[:, None], self.geometry.normal, 0.0))

    def update_multipliers(self, residual: FloatArray) -> None:
        """Multipliers from equilibrium of the slave's nodes.

        Args:
            residual: nodal, owned dofs, without contact forces [F].
        """
        tilt: FloatArray
        tilt, known, follow, state = self._no_tilt, np.zeros(0), np.zeros(0), self._state()
        if self._friction:
            tilt = self._linear_tilt if self.coulomb.has_springs else self._tilt()
            known = self.coulomb.known_tractions(state, self._coefficient)
            follow = self.coulomb.prescribed
        found = _cpp.multipliers.evaluate_multipliers(
            state, self._geometry(), *self._law(), self._at_nodes(residual), tilt, known, follow
        )
        self._set(found[0], found[1] if self._friction else self.friction_traction)

    def set_multipliers(self, forces: FloatArray) -> None:
        """Multipliers from a saddle point. After `constraints` and `friction_springs`, whose state the solution is of,
        and `update_linearised_gap`.

        Args:
            forces: (n, gdim) along the directions of the frames, zero where nothing is constrained [F].
        """
        state, known = self._state(), self.coulomb.known_tractions(self._state(), self._coefficient)
        multiplier, traction = _cpp.multipliers.take_multipliers(
            state, self._geometry(), *self._law(), forces, self._linear_tilt, known
        )
        self._set(multiplier, traction)

    def _set(self, multiplier: FloatArray, traction: FloatArray) -> None:
        """Take over multipliers and friction tractions at the nodes that are this contact's, and tell its partners."""
        self.multiplier = np.where(self._own, multiplier, self.multiplier)
        self.friction_traction = np.where(self._own[:, None], traction, self.friction_traction)
        self._tell_partners()

    def rotate_friction_traction(self) -> None:
        """Friction tractions known from a saddle point follow the surface and the slip to the present state."""
        self._set(
            self.multiplier,
            _cpp.multipliers.rotate_friction_traction(self._state(), *self._law(), self.geometry.normal),
        )

    def update_active_set(self, first: bool, last: int | None = None) -> int:
        """Change the active set and who sticks. Collective.

        Args:
            first: the increment has just begun: no multipliers yet, only gaps count.
            last: change no node but the one with this number, of all nodes of all ranks; see `last_change`.

        Returns:
            number of nodes of all ranks that would change.
        """
        state = self._state()
        active, sliding, direction = self._proposed_active_set(state, first)
        changed = ((active != self.active) | (sliding != self.sliding)) & self._own
        number = self.geometry.numbers
        self.last_change = self.comm.allreduce(int(np.max(number[changed], initial=-1)), MPI.MAX)
        take = self._own if last is None else self._own & (number == last)
        self.active = np.where(take, active, self.active)
        self.sliding = np.where(take, sliding, self.sliding)
        self.direction = np.where(take[:, None], direction, self.direction)
        if self._friction and not first:
            was_stuck = _cpp.multipliers.sticking(state, *self._law())
            changed = changed | self.coulomb.update_imposed(
                self._state(), self._coefficient, was_stuck, self.traction_n
            )
        self._tell_partners()
        return self.comm.allreduce(int(np.count_nonzero(changed)))

    def _proposed_active_set(self, state: Any, first: bool) -> tuple[BoolArray, BoolArray, FloatArray]:
        """Masks of active and of sliding nodes and directions of friction that follow from the state. Collective.

        Args:
            state: state of the nodes (C++).
            first: as in update_active_set.
        """
        tolerance = self.geometry.tolerance
        largest = self.comm.allreduce(float(np.max(self.multiplier, initial=0.0)), MPI.MAX)
        self._crowded |= self.redundant & self.active & (self.linearised_gap < -PENETRATES * self.geometry.size)
        active, sliding, direction = _cpp.multipliers.update_active_set(state, *self._law(), first, tolerance, largest)
        # A node whose condition was left out has no multiplier to open it.
        opened = self.redundant & (self.linearised_gap > tolerance)
        return active & ~opened, sliding & ~opened, direction

    def num_turning(self) -> int:
        """Nodes whose friction traction is not yet that of Coulomb's law: the direction of slip has turned since the
        linear problem was made, which in space it may without any change of the active set. Collective."""
        if not self._friction or self.gdim == 2:
            return 0
        slides = self.active & self.usable & self.sliding
        law = (self._coefficients() * self.multiplier)[:, None] * self.direction
        still = self._lock + self._edge_locks()
        traction = self.friction_traction - np.einsum("nab,nb->na", still, self.friction_traction)
        largest = self.comm.allreduce(float(np.max(self.multiplier, initial=0.0)), MPI.MAX)
        error = np.linalg.norm(traction - law, axis=1)
        turned = slides & (error > TURNED * self._coefficient * largest)
        return self.comm.allreduce(int(np.count_nonzero(turned)))

    def set_redundant(self, nodes: IntArray) -> None:
        """Take over which normal conditions a linear problem has left out, as others of the same nodes imply them.

        Args:
            nodes: index of the nodes.
        """
        self.redundant = np.isin(np.arange(len(self.nodes)), nodes)

    def over_constrained(self) -> IntArray:
        """Owned nodes whose condition was left out in this increment, as others contradict it."""
        return self.nodes[self._crowded]

    @property
    def num_active(self) -> int:
        """Active nodes of all ranks. Collective."""
        return self.comm.allreduce(int(np.count_nonzero(self.active & self.geometry.part)))

    def _violations(self) -> tuple[FloatArray, FloatArray]:
        """Gaps of active nodes and slips of those that stick, (n), (n) [L]."""
        return _cpp.multipliers.violations(self._state(), *self._law(), self.geometry.gap)

    def violation(self) -> float:
        """Largest gap of an active node, or slip of one that sticks, of all ranks, in sizes of the bodies [1].
        Collective."""
        largest = max(float(np.max(values, initial=0.0)) for values in self._violations())
        return self.comm.allreduce(largest, MPI.MAX) / self.geometry.size

    def round_off(self) -> float:
        """Round-off in the contact forces: none, as the multipliers do not follow from gaps.

        Returns:
            Zero [F].
        """
        return 0.0

    def gap_round_off(self) -> float:
        """Norm of the forces that close gaps of the size of their round-off: what multipliers are when bodies touch and
        nothing presses them. Collective.

        Returns:
            The norm [F].
        """
        positions = 4 * np.finfo(float).eps * np.linalg.norm(self.points, axis=1)
        forces = ((self.nodal_stiffness + self.facing_stiffness) * positions)[self._own]
        return float(np.sqrt(self.comm.allreduce(float(forces @ forces))))

    def largest_violation(self) -> str:
        """A sentence about the node whose gap or slip is largest. Collective."""
        mine = []
        for what, values in zip(("a gap of an active node", "a slip of a node that sticks"), self._violations()):
            if len(values):
                at = int(np.argmax(values))
                mine.append((float(values[at]), what, int(self.geometry.numbers[at]), self.points[at].tolist()))
        value, what, number, x = max(sum(self.comm.allgather(mine), []))
        return f"{self.pair.name}: {what}, number {number} at ({', '.join(f'{c:.4g}' for c in x)}), is {value:.3e}"

    def mesh_advice(self) -> str:
        """A sentence about a sharp edge of the slave with both sides at the master, or an empty text. Collective."""
        angles, near = self.geometry.edge_angles(), self.geometry.gap < self.geometry.facet_sizes()
        at = np.flatnonzero(near & self.geometry.part & (angles > SHARP))
        mine = [(float(angles[i]), int(self.geometry.numbers[i]), self.points[i].tolist()) for i in at]
        sharp = [edge for part in self.comm.allgather(mine) for edge in part]
        if not sharp:
            return ""
        angle, number, x = max(sharp)
        place = ", ".join(f"{c:.4g}" for c in x)
        return (
            f"{self.pair.name}: the slave has an edge of {angle:.0f} degrees at {len(sharp)} of its nodes beside the "
            f"master (number {number} at ({place})), where the normal is the mean of both sides: leave one side out of "
            "its tag, or make a pair of each"
        )

    def prescribed_overlap(self) -> str:
        """A sentence about slave nodes whose displacement along the normal is prescribed and that lie in the master, or
        an empty text: there is nothing that a multiplier could move. Collective."""
        prescribed = self.geometry.participates & (self.place < 0)
        return prescribed_overlap(self.pair.name, self.comm, self.geometry, prescribed, self._initial.depth)

    def passed_through(self) -> str:
        """A sentence about nodes that have passed through the master since the last converged state, or an empty text.
        Collective."""
        had_master = np.isfinite(self.opening) if self.opening is not None else np.zeros(len(self.nodes), dtype=bool)
        g = self.geometry
        if self._obstacle is not None:
            self._obstacle.displacement = g.displacement.tolist()
            moved = (g.u - g.start).reshape(-1, self.gdim)[self.nodes]
            moved = moved - (g.displacement - g.start_displacement)[: self.gdim]
            passed = through_obstacle(self._obstacle, g.points - moved, g.points, g.offset, g.tolerance)
        else:
            passed = through_master(self.comm, had_master & ~g.participates, g.facet_sizes(), g.gap_on_the_way)
        return describe(self.pair.name, self.comm, self.points, passed)

    def augment(self) -> bool:
        """Multipliers need no further rounds."""
        return False

    def close_nearest(self) -> bool:
        """Close the nodes nearest to the master, if they nearly touch; were there any? Collective."""
        gap = nearly_touching(self.comm, self.gap, self.geometry.facet_sizes())
        if gap is None:
            return False
        self.active = self.active | ((self.gap < gap) & self.usable)
        self._tell_partners()
        return True

    def closing_forces(self) -> None:
        """No force besides: constraints close the nearest nodes. See close_nearest."""

    # --- linear system ---------------------------------------------------------------------------------------------

    @property
    def displacement(self) -> FloatArray:
        """Of a rigid master, as reached, (3) [L]."""
        return self.geometry.displacement

    has_multipliers = True
    symmetric = True  # what makes it not so is known to the transformation

    def constraints(self) -> Any:
        """Constraints of the active nodes for the linear system: Constraints (C++)."""
        rows = np.flatnonzero(self.active & self.usable).astype(np.int32)
        self._linear_tilt = self._tilt()
        return _cpp.multipliers.constrain(
            self._state(),
            self._geometry(),
            *self._law(),
            self._linear_tilt,
            self.geometry.master_rows(rows.astype(np.int32)),
        )

    def friction_springs(self) -> tuple[PETSc.Mat, FloatArray] | None:
        """What Newton's method sees of tractions that change with the slip. Collective.

        Returns:
            matrix [F/L], and force over owned dofs to take from the right-hand side [F], of springs and of imposed
            tractions; or None.
        """
        if not self._friction:
            return None
        self.coulomb.set_edges(np.asarray(self._edge_locks()) if self.edges else np.zeros(0))
        rows, blocks, traction = self.coulomb.update_springs(
            self._state(), self._geometry(), self._coefficient, self.nodal_stiffness, self.facing_stiffness
        )
        if not self.comm.allreduce(len(rows) + int(np.any(self.coulomb.imposed))):
            return None
        return self.geometry.springs(rows, blocks), self.geometry.joined_forces(traction)

    def imposed_friction_forces(self) -> FloatArray | None:
        """Nodal forces on both bodies of tractions imposed along prescribed directions, owned dofs [F]; or None.
        Collective."""
        if not self._friction:
            return None
        imposed = self.coulomb.imposed
        return self.geometry.joined_forces(imposed) if self.comm.allreduce(int(np.any(imposed))) else None

    def update_nodal_stiffness(self, K: PETSc.Mat) -> None:
        """Take from the bodies' stiffness what the changes of state need. Collective.

        Args:
            K: tangent of the bodies [F/L].
        """
        self.nodal_stiffness, self.facing_stiffness = self.geometry.diagonal_stiffness(K)

    def tangent(self) -> PETSc.Mat | None:
        """Geometric stiffness of the contact forces [F/L]; None: it is zero. Collective."""
        return self.geometry.tangent(self.multiplier, self.traction, self.active & self._part)

    def rigid_body_constraints(self, motions: Any) -> list[FloatArray]:
        """Jumps at active nodes under the rigid body modes; see StaticContact. Collective.

        Args:
            motions: RigidBodyModes (C++).
        """
        held = np.flatnonzero(self.active & self.usable)
        rows = self._rigid_body_jumps(motions, held)
        along = np.einsum("na,anm->nm", self.normal[held], rows)
        if not self._friction:
            return [along]
        if self.opening is not None:  # nothing holds a node along the surface that closes only in this increment
            fresh = self.opening[held] > 0.0
            rows[:, fresh] = np.einsum("na,nm->anm", self.normal[held][fresh], along[fresh])
        return list(rows)

    def _rigid_body_jumps(self, motions: Any, held: IntArray) -> FloatArray:
        """Displacements against the master of some nodes in all rigid motions, (gdim, held nodes, motions). Collective.

        Args:
            motions: RigidBodyModes.
            held: index of the nodes.
        """
        rows = np.zeros((self.gdim, len(held), motions.num_modes))
        touched = np.zeros(motions.count, dtype=np.int32)
        geometries = [self.geometry, *(c.geometry for c, _ in self.partners)]
        surfaces = [s for g in geometries for s in (g.slave, g.master) if s is not None]
        touched[np.concatenate([motions.body[s.nodes.ravel()] for s in surfaces])] = 1
        touched = np.sum(self.comm.allgather(touched), axis=0) > 0
        for number in np.flatnonzero(np.repeat(touched, len(motions.names))):
            rows[:, :, number] = self.geometry.jump(motions.everywhere(number).ravel())[held].T
        return rows

    # --- results ---------------------------------------------------------------------------------------------------

    @property
    def initial(self) -> InitialPenetration:
        """Penetrations in the reference configuration."""
        return self._initial

    @property
    def points(self) -> FloatArray:
        """Current positions of the slave's nodes, (n, gdim) [L]."""
        return self.geometry.points

    @property
    def gap(self) -> FloatArray:
        """Gap, positive open; infinite where there is no master, (n) [L]."""
        return self.geometry.gap

    @property
    def pressure(self) -> FloatArray:
        """Contact pressure per reference area, (n) [F/L^2]."""
        return np.maximum(np.where(self._touching, self.multiplier, 0.0), 0.0)

    @property
    def _touching(self) -> BoolArray:
        """Nodes at which this pair is in contact, mask (n): an active node that pairs share need not lie on both."""
        return self.active & self.geometry.part

    @property
    def normal(self) -> FloatArray:
        """Unit normals out of the master, (n, gdim)."""
        return self.geometry.normal

    @property
    def traction(self) -> FloatArray:
        """Contact traction on the slave per reference area, (n, gdim) [F/L^2]."""
        return np.where(
            self._touching[:, None], self.multiplier[:, None] * self.geometry.normal + self.friction_traction, 0.0
        )

    @property
    def slip(self) -> FloatArray:
        """Tangential displacement of slave against master since it last stuck to it, (n, gdim) [L]."""
        return self.total_slip

    @property
    def status(self) -> IntArray:
        """ContactStatus numbers, (n)."""
        slips = self.sliding | (self.pair.friction == 0.0)
        return np.where(~self._touching, ContactStatus.open, np.where(slips, ContactStatus.slip, ContactStatus.stick))

    @property
    def weight(self) -> FloatArray:
        """Area that belongs to each point, (n) [L^2]; a length in 2D."""
        return self.geometry.own_cover

    def covered(self) -> FloatArray:
        """Part of each point's area that is in contact, (n). Collective."""
        return self.geometry.part_in_contact(self.pressure, self.active & self._part)

    def contact_forces(self) -> FloatArray:
        """Nodal contact forces on both bodies, array over owned dofs [F]. Collective."""
        return self.geometry.forces(self.traction)
