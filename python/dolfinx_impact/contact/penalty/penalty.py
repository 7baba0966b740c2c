# SPDX-License-Identifier: MIT
"""Contact by penalty: Gauss point to surface, exact tangent, friction by return mapping; docs/contact.md."""

from typing import Any

import basix
import numpy as np
from mpi4py import MPI
from petsc4py import PETSc

from ... import _cpp
from ...common.arguments import integer, number
from ...common.collective import comm_of, guard
from ...common.fixed import Fixed
from ...common.types import AnyArray, ArrayLike, BoolArray, FloatArray, IntArray
from .automatic import automatic_penalty, check_penalty
from .facets import WIDEST, FacetKeeper
from ..nodal_sum import NodalSum
from ..explicit.nodal import NodalResult
from ..output import ContactOutput
from ..pair import ContactPair, ContactStatus, check_pair, check_quadrature_degree
from ..body_size import body_size
from ..crossing import describe, through_master, through_obstacle
from ..initial_penetration import InitialPenetration, check_side, nearly_touching
from ..saved_history import SavedHistory
from ..protocol import ExplicitContactProblem, StaticContactProblem
from .uzawa import Uzawa

RULES = ("auto", "step")  # for penalties that are no numbers
# The automatic penalty is this many times the nodal stiffness per area of the softer surface. Penetrations are then a
# tenth of the compression of the outermost cells, and the matrix is about as well conditioned as that of elasticity.
FACTOR = 10.0
# A slave is much coarser than its master from this ratio of the sizes of their facets on.
COARSE = 2.0
# Gaps below this part of the bodies' size count as closed, so that round-off does not decide at first contact.
TOUCH = 1e-12
# Least cosine between a master's normal and the slave's inward one where the surfaces face each other. Beside the rim
# the direction to the master lies along the slave, cosine zero; where surfaces touch, normals differ by a facet's turn.
FACING = 0.5
ROUND_OFF = 1e-15  # part of the bodies' size below which a penetration is round-off of positions
STILL = 1e-12  # part of the bodies' size below which a change of closest points is round-off


class Penalty(Fixed):
    """Enforce contact of a pair by a penalty, seed (3.48), corrected.

    In explicit problems (docs/explicit/penalty.md) the contact points are the slave's nodes, and "auto" is half of the
    stiffness of the outermost cells of both bodies, within what their nodal masses bear; `tangential`, `augmented` and
    `quadrature_degree` are options of static problems.

    Args:
        pair: the pair of surfaces.
        penalty: pressure per penetration; "auto": ten times the nodal stiffness per area of the softer surface where
            its facets are smallest, printed when it is computed; "step": in explicit problems half of the nodal
            masses over the square of the time step, as stiff as the step bears, for loads that stay [F/L^3].
        tangential: tangential traction per slip, with friction; None: equal to `penalty` [F/L^3].
        augmented: whether each increment is repeated with augmented multipliers (Uzawa) until the mean penetration
            around each corner of the slave's facets is below `tolerance`.
        tolerance: largest mean penetration with `augmented`, relative to the size of the bodies [1].
        quadrature_degree: degree of the quadrature on slave facets; None: 2 degree + 2.
        balanced: whether an explicit problem applies the contact in both directions with half the stiffness each.
        max_augmentations: largest number of augmentations of an increment; each one reduces the penetration by the
            part penalty/(penalty + stiffness per area of the bodies).

    Raises:
        TypeError: an argument of a wrong type; on all ranks.
        ValueError: a penalty or tolerance that is not positive, or a degree without quadrature rule; on all ranks.
    """

    def __init__(
        self,
        pair: ContactPair,
        penalty: float | str = "auto",
        tangential: float | None = None,
        augmented: bool = False,
        tolerance: float = 1e-8,
        quadrature_degree: int | None = None,
        balanced: bool = False,
        max_augmentations: int = 200,
    ) -> None:
        given: dict[str, Any] = dict(
            penalty=penalty,
            tangential=tangential,
            augmented=bool(augmented),
            tolerance=tolerance,
            balanced=bool(balanced),
            max_augmentations=max_augmentations,
        )
        with guard(comm_of(pair), "Penalty", pair=pair, quadrature_degree=quadrature_degree, **given):
            check_pair(pair)
            self.quadrature_degree = check_quadrature_degree(quadrature_degree)
            rule = penalty if isinstance(penalty, str) and penalty in RULES else None
            self.penalty = None if rule else number("penalty", penalty, 0.0, " [F/L^3]")
            self.tangential = None if tangential is None else number("tangential penalty", tangential, 0.0, " [F/L^3]")
            self.tolerance = number("tolerance", tolerance, 0.0)
            if self.tolerance < ROUND_OFF:
                raise ValueError(
                    f"tolerance is {self.tolerance:g}: penetrations below {ROUND_OFF:g} of the bodies' size are "
                    "round-off of positions; take a larger one"
                )
            self.max_augmentations = integer("max_augmentations", max_augmentations, 1)
        self.pair, self.augmented, self.balanced = pair, bool(augmented), bool(balanced)
        self.by_step = rule == "step"

    def __repr__(self) -> str:
        options = [f"penalty={self.penalty or ('step' if self.by_step else 'auto')!r}"]
        if self.tangential is not None:
            options.append(f"tangential={self.tangential}")
        options += [f"{name}=True" for name in ("augmented", "balanced") if getattr(self, name)]
        if self.augmented:
            options += [f"tolerance={self.tolerance:g}", f"max_augmentations={self.max_augmentations}"]
        if self.quadrature_degree is not None:
            options.append(f"quadrature_degree={self.quadrature_degree}")
        return f"Penalty({self.pair!r}, {', '.join(options)})"

    def _bind_explicit(self, problem: ExplicitContactProblem) -> NodalResult:
        if self.augmented or self.tangential is not None or self.quadrature_degree is not None:
            raise ValueError("tangential, augmented and quadrature_degree are options of static penalty contact")
        law = _cpp.nodal.PenaltyContact
        penalty = self.penalty or 0.0
        return NodalResult(self.pair, problem, law, self.by_step, penalty=penalty, balanced=self.balanced)

    def _bind(self, problem: StaticContactProblem) -> "PenaltyContact":
        if self.balanced:
            raise ValueError("balanced penalty contact is for explicit dynamics")
        if self.by_step:
            raise ValueError("'step' is a penalty of explicit dynamics: give a number or 'auto'")
        return PenaltyContact(self, problem)


class PenaltyContact(ContactOutput):
    """Penalty contact of one pair in a static problem; points are the quadrature points of this rank's slave facets.

    Args:
        spec: parameters of the contact.
        problem: the problem.

    Attributes:
        penalty: penalty in use; None before the first increment with an automatic one [F/L^3].
        tangential: tangential penalty in use; None before the first increment [F/L^3].
        displacement: displacement of a rigid master at the end of the present increment, (3) [L].
        start_displacement: its displacement at the beginning, (3) [L].
        start: displacements at the beginning of the increment, owned and ghost dofs [L].
        has_multipliers: False, there are no multipliers to condense.
        convex: whether `tangent` returns the positive semi-definite part of the tangent only.
    """

    has_multipliers = False
    convex = False
    displacement: FloatArray
    start_displacement: FloatArray
    start: FloatArray

    def __init__(self, spec: Penalty, problem: StaticContactProblem) -> None:
        self.spec, self.pair, self.problem = spec, spec.pair, problem
        V = problem.space
        self.V, self.comm, self.gdim = V, V.mesh.comm, V.mesh.geometry.dim
        self.slave, self.master = self.pair.surfaces(V)
        self.size = body_size(V.mesh)
        element = self.slave.displacement
        degree = spec.quadrature_degree or 2 * element.degree + 2
        rule = basix.make_quadrature(getattr(basix.CellType, element.shape), degree)
        self._rule = [np.ascontiguousarray(a) for a in rule]
        self.obstacle = self.pair.rigid_master.obstacle(self.gdim) if self.pair.rigid else None
        distance = () if self.pair.rigid else (self.pair.search_distance or 0.0,)
        self._cpp = _cpp.penalty.QuadraturePenalty(
            V._cpp_object, self.slave, self.obstacle or self.master, *self._rule, problem.axisymmetric, *distance
        )
        self._points, self.history = self._cpp.points, self._cpp.history
        self._cpp.parameters.friction = self.pair.friction
        self.displacement, self.start_displacement = np.zeros(3), np.zeros(3)
        self.start, self.penalty, self.tangential = np.zeros_like(problem.u.x.array), spec.penalty, spec.tangential
        self._known_status: IntArray | None = None  # that of a checkpoint, until the next evaluation
        self.uzawa, self.fault = Uzawa(V, self.slave, self._rule), ""
        num = self._points.size
        self._status: IntArray = np.zeros(num, dtype=np.int8)  # of the last iteration
        self._touched = np.zeros(num, dtype=bool)  # points that were closed in the last converged state
        # Least trial pressure of points that close in an increment's first evaluation; None: no increment has begun.
        self._touch: float | None = None
        self._keeper = None if self.pair.rigid else FacetKeeper(self.comm, self._points, self._cpp.search)
        if self.pair.rigid:
            check_side(self.pair, V, self.slave, self.obstacle)
        self._seen = False  # whether points have been assigned to facets; not in the reference configuration
        self._locate(self.start)
        self._initial = InitialPenetration(self.pair, V, self.slave, self.master, self._points.x, self._points.gap)
        self.history.offset = self._initial.offset
        self._gap_before = self.gap  # in the last converged state

    @property
    def initial(self) -> InitialPenetration:
        """Penetrations in the reference configuration."""
        return self._initial

    def check_parameters(self) -> None:
        """Refuse a given penalty that is much larger than the stiffness of the bodies. Collective.

        Raises:
            ValueError: on all ranks.
        """
        if self.spec.penalty is not None:
            check_penalty(self, self.spec.penalty, FACTOR)

    # --- state of an increment -------------------------------------------------------------------------------------

    def save_state(self) -> dict[str, Any]:
        """Copy the state from which an increment starts.

        Returns:
            Arrays by name, for restore_state.
        """
        h = self.history
        return {
            "multiplier": h.multiplier,
            "traction": h.traction,
            "slip": h.slip,
            "touched": self._touched.copy(),
            "corners": self.uzawa.multiplier.copy(),
            "start": self.start.copy(),
            "displacements": (self.start_displacement.copy(), self.displacement.copy()),
        }

    def restore_state(self, state: dict[str, Any]) -> None:
        """Restore the state from which an increment started.

        Args:
            state: as save_state returned it.
        """
        for name in ("multiplier", "traction", "slip"):
            setattr(self.history, name, state[name])
        self.start, self.uzawa.multiplier = state["start"].copy(), state["corners"].copy()
        self._touched = state["touched"].copy()
        self.start_displacement, self.displacement = (d.copy() for d in state["displacements"])

    @property
    def kind(self) -> str:
        """Name of the method that enforces the contact."""
        return "penalty at quadrature points"

    def facets(self) -> tuple[Any, Any]:
        """Facets of slave and master on this rank (C++); None: the master is rigid."""
        return self.slave, self.master

    @property
    def options(self) -> dict[str, Any]:
        """Options by name, for the signature of a checkpoint."""
        names = ("penalty", "tangential", "augmented", "tolerance", "quadrature_degree", "max_augmentations")
        return {name: getattr(self.spec, name) for name in names}

    def save_history(self) -> SavedHistory:
        """What the next increment starts from, for a checkpoint."""
        h, per_facet = self.history, len(self._rule[1])
        rows = {"multiplier": h.multiplier, "touched": self._touched.astype(float), "status": self.status.astype(float)}
        rows["facet"] = self._facet_ids()
        vectors = {"traction": h.traction, "slip": h.slip}
        columns = {name: v.reshape(-1, per_facet) for name, v in rows.items()}
        columns |= {name: v.reshape(-1, per_facet * self.gdim) for name, v in vectors.items()}
        places = {"master": self.displacement, "penalties": np.array([self.penalty or 0.0, self.tangential or 0.0])}
        num_owned = self.V.dofmap.index_map.size_local
        corners = self.uzawa.multiplier[:num_owned, None].copy() if self.spec.augmented else None
        return SavedHistory(True, self.slave.id, columns, self.save_totals() | places, corners)

    def restore_history(self, saved: SavedHistory, u: FloatArray) -> None:
        """Continue from a checkpoint. Collective.

        Args:
            saved: as save_history returned it.
            u: displacements of the checkpoint, owned and ghost dofs [L].
        """
        rows, penalties = saved.columns, saved.totals["penalties"]
        self.penalty, self.tangential = (float(value) or None for value in penalties)
        for name in ("multiplier", "traction", "slip"):
            setattr(self.history, name, rows[name].ravel())
        self._touched = rows["touched"].ravel() != 0.0
        if saved.corners is not None:
            values = np.zeros_like(self.uzawa.multiplier)
            values[: len(saved.corners)] = saved.corners[:, 0]
            self.uzawa.multiplier = NodalSum(self.V.dofmap.index_map, 1).forward(values).ravel()
        self.displacement = self.start_displacement = saved.totals["master"].copy()
        self.begin_step(u, saved.totals["master"] if self.pair.rigid else None)
        self.update_gap(u)
        self._keep_facets(u, rows["facet"].ravel())
        # A point that has slipped is on the edge of its friction limit, where the evaluation alone says that it sticks.
        self._known_status = self._status = rows["status"].ravel().astype(np.int8)
        self._gap_before = self.gap
        self.restore_totals(saved.totals)

    def _facet_ids(self) -> FloatArray:
        """Facet of the master that each point is on, by a number that does not depend on the ranks; -1: none, (n)."""
        facets, out = self._points.master, np.full(self._points.size, -1.0)
        if not self.pair.rigid:
            on = facets >= 0
            out[on] = self._cpp.search.master.id[facets[on]]
        return out

    def _keep_facets(self, u: FloatArray, ids: FloatArray) -> None:
        """Put points a little beside a facet that they were kept on back on it. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
            ids: of `_facet_ids`.
        """
        if self._keeper is None:
            return
        known = self._cpp.search.master.id
        order = np.argsort(known)
        place = np.minimum(np.searchsorted(known, ids, sorter=order), max(len(known) - 1, 0))
        facets: IntArray = np.full(len(ids), -1, dtype=np.int32)
        if len(known):
            facets = np.where(known[order[place]] == ids, order[place], -1).astype(np.int32)
        self._points.master = facets
        self._keeper.begin(WIDEST)
        self.update_gap(u)

    def forget(self) -> None:
        """Forget candidates and the places of the tangent; see ContactOutput."""
        self._cpp.forget()

    def begin_step(self, u: FloatArray, displacement: FloatArray | None, target: FloatArray | None = None) -> None:
        """Begin an increment. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
            displacement: displacement of a rigid master at the end of the increment, (3); None for deformable masters
                [L].
            target: prescribed displacements at the end of the increment; not used [L].
        """
        if self.penalty is None:
            self.penalty = automatic_penalty(self, FACTOR)
        self.tangential = self.tangential or self.penalty
        self.start = np.array(u)
        parameters = self._cpp.parameters
        parameters.normal, parameters.tangential = self.penalty, self.tangential
        self._touch = TOUCH * self.size * self.penalty
        self.uzawa.begin()
        self.fault = ""
        if self._keeper is not None:
            self._keeper.begin()
        if self.pair.friction > 0.0:  # the slip of a point is measured from the place where it closes
            self._locate(self.start)
            gap = self.gap
            self.history.gap = np.where(self._touched | (gap <= TOUCH * self.size), 0.0, gap)
        if displacement is not None:
            self.start_displacement, self.displacement = self.displacement, np.array(displacement, dtype=float)

    def accept_step(self) -> None:
        """Accept a converged increment: tractions and slips become history, totals are updated. Collective."""
        self._cpp.accept_step()
        self._touched, self._gap_before = self.status > 0, self.gap
        self.update_totals()

    def augment(self) -> bool:
        """Begin another round after convergence if it is needed: new closest points or augmented multipliers.
        Collective; `fault` is set if the number of augmentations is exhausted.

        Returns:
            Whether the iteration must continue.
        """
        if self._leave_facets():
            return True
        if not self.spec.augmented:
            return False
        assert self.penalty is not None  # begin_step has set it
        tolerance = self.spec.tolerance * self.size
        gap = np.where(self._beside_master(), np.inf, self.gap)
        multiplier = self.uzawa.augment(gap, self._points.weight, self.penalty, tolerance)
        if multiplier is None:
            return False
        self.history.multiplier = multiplier
        if self.uzawa.rounds <= self.spec.max_augmentations:
            return True
        self.fault = f"{self.pair.name}: {self.uzawa.fault(self.penalty, tolerance)}"
        return False

    def _beside_master(self) -> BoolArray:
        """Open points that the master does not face, mask (n): their gap is the way to its rim, which is no gap that a
        pressure could close. On a slave's facet that the master covers in part they would keep the mean gap open."""
        sums = np.zeros(len(self._u))
        self.slave.move(self._u)
        _cpp.gap.add_normals(self.slave, sums)
        inward = sums.reshape(-1, self.gdim)[self.slave.nodes].sum(axis=1)
        inward = np.repeat(
            inward / np.maximum(np.linalg.norm(inward, axis=1), 1e-300)[:, None], self._points.per_facet, 0
        )
        facing = np.einsum("na,na->n", self.normal, inward)
        return np.asarray((self.gap > 0.0) & (facing < FACING))

    def update_gap(self, u: FloatArray) -> None:
        """Update candidates, gaps, normals and tractions. Collective.

        Args:
            u: displacements, owned and ghost dofs [L].
        """
        if self._touch is None:  # a state is asked for before anything was solved
            self.begin_step(u, self.pair.rigid_master.displacement if self.pair.rigid else None)
        self._u = np.array(u)
        self._known_status = None
        self._locate(self._u)
        self._seen = True
        self._cpp.parameters.touch = self._touch
        self._cpp.evaluate(self._u - self.start, (self.displacement - self.start_displacement).tolist())
        self._touch, self._closes_nearest = 0.0, False

    def _leave_facets(self) -> bool:
        """Release points from their facets, once in an increment, and project them anew. Collective.

        Returns:
            Whether a closest point or a traction changes, so that the iteration must continue.
        """
        if self._keeper is None or not self._keeper.leave():
            return False
        assert self.penalty is not None  # begin_step has set it
        before = self._closest_points(), self.traction
        self.update_gap(self._u)
        closed, after = self.status > 0, self._closest_points()
        parts = (after - before[0])[closed], (self.traction - before[1]) / self.penalty
        moved = max(float(np.max(np.abs(p), initial=0.0)) for p in parts)
        return self.comm.allreduce(moved, MPI.MAX) > STILL * self.size

    def _closest_points(self) -> FloatArray:
        """Closest points on the master, (n, gdim) [L]; without meaning for points without master."""
        gap = self._points.gap
        return self._points.x - np.where(np.isfinite(gap), gap, 0.0)[:, None] * self._points.normal

    def mesh_advice(self) -> str:
        """Describe a slave that is much coarser than its master: its points dent the master. Collective.

        Returns:
            A sentence, or an empty text.
        """
        sizes = [self.slave.X] if self.master is None else [self.slave.X, self.master.X]
        sums = [(float(np.linalg.norm(np.ptp(X, axis=1), axis=1).sum()), len(X)) for X in sizes]
        means = [total / number for total, number in np.sum(self.comm.allgather(sums), axis=0)]
        if len(means) < 2 or means[0] < COARSE * means[1]:
            return ""
        return (
            f"{self.pair.name}: the slave's facets are {means[0] / means[1]:.1f} times as long as the master's, "
            "which is dented between its points: exchange slave and master, refine the slave, or take multipliers"
        )

    def close_nearest(self) -> bool:
        """Close the points nearest to the master in this iteration, if no point is closed and the bodies nearly touch.
        Collective.

        Bodies that are supported by contact alone need this: the forces of `closing_forces` bring them into contact.

        Returns:
            Whether there are such points.
        """
        size = np.linalg.norm(np.ptp(self.slave.X, axis=1), axis=1)
        gap = nearly_touching(self.comm, self.gap, np.repeat(size, self._points.per_facet))
        if gap is None or self.num_active > 0:
            return False
        assert self.penalty is not None  # begin_step has set it
        self._cpp.parameters.touch = gap * self.penalty
        self._cpp.evaluate()
        self._closes_nearest = True
        return True

    def passed_through(self) -> str:
        """Describe points that have passed through the master since the last converged state. Collective.

        Returns:
            A sentence, or an empty text.
        """
        if self.obstacle is not None:
            element = self.slave.displacement
            table = np.array([element.tabulate(*xi)[0] for xi in self._points.xi[: self._points.per_facet]])
            nodal = (self._u - self.start).reshape(-1, self.gdim)[self.slave.nodes]
            moved = np.einsum("qn,fna->fqa", table, nodal).reshape(-1, self.gdim) if len(nodal) else 0.0 * self.points
            moved = moved - (self.displacement - self.start_displacement)[: self.gdim]
            passed = through_obstacle(
                self.obstacle, self.points - moved, self.points, self.initial.offset, TOUCH * self.size
            )
        else:
            sizes = np.repeat(np.linalg.norm(np.ptp(self.slave.X, axis=1), axis=1), self._points.per_facet)
            suspects = np.isfinite(self._gap_before) & np.isinf(self.gap)
            passed, here = np.zeros(len(suspects), dtype=bool), self._u
            if self.comm.allreduce(int(np.any(suspects))):
                passed = through_master(self.comm, suspects, sizes, self._gap_on_the_way)
                self.update_gap(here)
        return describe(self.pair.name, self.comm, self.points, passed)

    def _gap_on_the_way(self, part: float) -> FloatArray:
        """Gaps at a fraction of the way from the start of the increment to the present state, (n) [L]. Collective."""
        self._locate(self.start + part * (self._u - self.start))
        return self.gap.copy()

    def _locate(self, u: FloatArray) -> None:
        """Update closest points and gaps at the displacements u. Collective."""
        if self.obstacle is not None:
            self.obstacle.displacement = self.displacement.tolist()
        self._cpp.update_gap(u, self.start, self._seen and self._keeper is not None and self._keeper.stay)

    def update_active_set(self, first: bool, last: int | None = None) -> int:
        """Compare the state of the points with that of the last iteration; called once per iteration. Collective.

        Args:
            first: whether the increment has just begun; not used.
            last: global number of the only node that may change; not used.

        Returns:
            Number of points of all ranks whose status or facet has changed.
        """
        status = self.status
        changed = np.count_nonzero(status != self._status)
        if self._keeper is not None:
            changed += self._keeper.watch(status > 0)
        self._status = status
        return self.comm.allreduce(changed)

    def update_multipliers(self, residual: FloatArray) -> None:
        """Do nothing: tractions follow from gaps.

        Args:
            residual: nodal residual without contact forces, owned dofs [F].
        """

    def violation(self) -> float:
        """Largest violation of the constraints; the penalty method permits penetrations.

        Returns:
            Zero [1].
        """
        return 0.0

    def round_off(self) -> float:
        """Norm of the round-off in the contact forces: penalty times round-off of the positions, at points that are
        closed, or open by no more than that. Collective.

        Returns:
            The norm [F].
        """
        assert self.penalty is not None  # begin_step has set it
        positions = np.finfo(float).eps * np.linalg.norm(self._points.x, axis=1)
        near = self.gap <= positions
        forces = self.penalty * self._points.weight[near] * positions[near]
        return float(np.sqrt(self.comm.allreduce(float(forces @ forces))))

    @property
    def num_active(self) -> int:
        """Number of closed points of all ranks. Collective."""
        return self.comm.allreduce(int(np.count_nonzero(self.status)))

    # --- linear system ---------------------------------------------------------------------------------------------

    def contact_forces(self) -> FloatArray:
        """Assemble the nodal contact forces on both bodies. Collective.

        Returns:
            Forces, owned dofs [F].
        """
        return self._cpp.contact_forces()

    def add_residual(self, b: PETSc.Vec) -> None:
        """Subtract the nodal contact forces from a residual. Collective.

        Args:
            b: residual [F].
        """
        self._cpp.add_residual(b)

    @property
    def symmetric(self) -> bool:
        """Whether the tangent is symmetric; it is not if points slip with friction. Collective."""
        slips = self.pair.friction > 0.0 and bool(np.any(self.status == 2))
        return self.comm.allreduce(int(slips)) == 0

    def update_nodal_stiffness(self, K: PETSc.Mat) -> None:
        """Do nothing: the penalty is the scale of force per displacement.

        Args:
            K: tangent of the bodies [F/L].
        """

    def tangent(self) -> PETSc.Mat:
        """Derivative of minus the contact force. Collective.

        Returns:
            Matrix of this contact, valid until the next call [F/L].
        """
        return self._cpp.tangent(self.convex)

    def closing_forces(self) -> FloatArray | None:
        """Forces that close the gaps of the points of close_nearest. Collective.

        Returns:
            Forces to be subtracted from the right-hand side, owned dofs; None without such points [F].
        """
        return -self._cpp.closing_forces() if self._closes_nearest else None

    def rigid_body_products(self, modes: _cpp.solve.RigidBodyModes) -> FloatArray:
        """Products of the active constraints applied to the rigid body modes. Collective.

        Args:
            modes: rigid body modes of the bodies.

        Returns:
            Sums over this rank's closed points, (num_modes, num_modes).
        """
        products = np.zeros((modes.num_modes, modes.num_modes))
        for rows in self._rigid_body_constraints(modes):
            products += rows.T @ rows
        return products

    def _rigid_body_constraints(self, motions: _cpp.solve.RigidBodyModes) -> list[FloatArray]:
        """Relative displacements of slave and master at closed points under the rigid body modes. Collective.

        Args:
            motions: rigid body modes of the bodies.

        Returns:
            Arrays (num_points, motions.num_modes).
        """
        touching = np.flatnonzero(self.status)
        slave, master, body = self.slave, None, motions.body
        if not self.pair.rigid:  # the search knows facets of other ranks as well
            search = self._cpp.search
            slave, master, near = search.slave, search.master, search.map
            known = np.zeros(near.size_local + near.num_ghosts)
            known[: motions.num_owned] = motions.body[: motions.num_owned]
            body = NodalSum(near, 1).forward(known).ravel().astype(int)
        closest, facing, parts = self._closest_points(), self._points.master, []
        for at in np.array_split(touching, max(1, len(touching) // 10000)):
            directions = [self.normal[at]]
            if self.pair.friction > 0.0:
                directions = [np.tile(e, (len(at), 1)) for e in np.eye(self.gdim)]
            slaves = body[slave.nodes[at // self._points.per_facet, 0]]
            if self.pair.friction > 0.0:  # nothing holds a point along the surface that closes only in this increment
                fresh = np.asarray(self.history.gap)[at] > 0.0
                normal = self.normal[at]
                directions = [
                    np.where(fresh[:, None], normal * np.sum(normal * d, axis=1)[:, None], d) for d in directions
                ]
            for d in directions:
                rows = motions.rows(slaves, self.points[at], d)
                if master is not None:
                    masters = body[master.nodes[facing[at], 0]]
                    rows -= motions.rows(masters, closest[at], d)
                parts.append(rows)
        return parts

    # --- results ---------------------------------------------------------------------------------------------------

    @property
    def points(self) -> FloatArray:
        """Present positions, (n, gdim) [L]."""
        return self._points.x

    @property
    def gap(self) -> FloatArray:
        """Gaps, (n), positive if open, infinite without master [L]."""
        return self._points.gap + self.initial.offset

    @property
    def normal(self) -> FloatArray:
        """Unit normals out of the master, (n, gdim) [1]."""
        return self._points.normal

    @property
    def pressure(self) -> FloatArray:
        """Contact pressure per reference area, (n) [F/L^2]; at_nodes(contact.pressure) is smoother in plots."""
        return self._cpp.state.pressure

    @property
    def traction(self) -> FloatArray:
        """Contact traction on the slave per reference area, (n, gdim) [F/L^2]."""
        # Evaluated again, friction at its limit is scaled to it once more, which rounds.
        tangential = self._cpp.state.tangential if self._known_status is None else self.history.traction
        on = np.flatnonzero(self.status > 0)
        out = np.zeros((len(self.pressure), self.gdim))
        out[on] = self.pressure[on, None] * self.normal[on] + tangential.reshape(-1, self.gdim)[on]
        return out

    @property
    def slip(self) -> FloatArray:
        """Tangential displacement of slave relative to master, accumulated in contact, (n, gdim) [L]."""
        return self._cpp.state.slip.reshape(-1, self.gdim)

    @property
    def status(self) -> IntArray:
        """ContactStatus numbers, (n)."""
        return self._cpp.state.status if self._known_status is None else self._known_status

    @property
    def weight(self) -> FloatArray:
        """Area of each point, a length in 2D, (n) [L^2]."""
        return self._points.weight

    def covered(self) -> FloatArray:
        """Part of each point's area that is in contact: one or zero.

        Returns:
            Fractions, (n) [1].
        """
        return (self.status > 0).astype(float)

    def nodal(self, values: ArrayLike) -> tuple[IntArray, FloatArray]:
        """Means of point values at the slave's nodes, weighted with squares of the shape functions. Collective.

        Args:
            values: values at the points, (n) or (n, ...).

        Returns:
            Owned nodes, (m), and means, (m, number of values per point).
        """
        points, element = self._points, self.slave.displacement
        # Of the rule, not of the points: a rank without slave facets has no points, but takes part in the sums.
        places = np.pad(self._rule[0], ((0, 0), (0, 2 - self._rule[0].shape[1])))
        table = np.array([element.tabulate(*xi)[0] for xi in places])
        w = points.weight.reshape(-1, points.per_facet)[:, :, None] * (table**2)[None]
        values = np.asarray(values, dtype=float)
        values = values.reshape(-1, points.per_facet, int(np.prod(values.shape[1:])))
        index_map = self.V.dofmap.index_map
        size = index_map.size_local + index_map.num_ghosts
        total, weight = np.zeros((size, values.shape[-1])), np.zeros(size)
        np.add.at(total, self.slave.nodes, np.einsum("fqn,fqv->fnv", w, values))
        np.add.at(weight, self.slave.nodes, w.sum(axis=1))
        totals = NodalSum(index_map, values.shape[-1])(total)
        weights = NodalSum(index_map, 1)(weight).ravel()
        nodes = np.flatnonzero(weights[: index_map.size_local])
        return nodes, totals[nodes] / weights[nodes, None]

    def at_nodes(self, values: ArrayLike) -> tuple[IntArray, AnyArray]:
        """Values of the contact points by nodes. Collective.

        Real values become means over the points with finite ones, as a gap without master is infinite; a node without
        finite values gets an infinite one. Integers, as status, become the one with the largest part of the node's
        area.

        Args:
            values: an array over the contact points, (n) or (n, gdim).

        Returns:
            Numbers of nodes on this rank, (m), and their values, (m) or (m, gdim).
        """
        values = np.asarray(values)
        if np.issubdtype(values.dtype, np.integer):
            nodes, parts = self.nodal(values[:, None] == np.arange(len(ContactStatus)))
            return nodes, np.argmax(parts, axis=1).astype(float)
        known = np.isfinite(values)
        nodes, sums = self.nodal(np.where(known, values, 0.0))
        parts = self.nodal(known)[1]
        means = np.divide(sums, parts, out=np.full_like(sums, np.inf), where=parts > 0.0)
        return nodes, means.reshape(-1, *values.shape[1:])
