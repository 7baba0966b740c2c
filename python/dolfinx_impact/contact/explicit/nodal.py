# SPDX-License-Identifier: MIT
"""Contact in explicit dynamics: slave nodes against the master's surface; docs/explicit/penalty.md."""

from typing import Any, cast

from ... import _cpp
from ...amplitude import Amplitude
from ...common.arguments import integer
from ...common.collective import comm_of, guard
from ...common.fixed import Fixed
from ...common.types import FloatArray, IntArray
from ...interface.friction_law import FrictionLaw
from ..pair import ContactPair, check_pair
from ..protocol import ExplicitContactProblem
from .nodal_output import NodalOutput


class Kinematic(Fixed):
    """Enforce contact of a pair in explicit dynamics by correction of a predicted configuration.

    Seed, five steps after (3.48).

    Args:
        pair: the pair of surfaces.
        sweeps: number of corrections per step; matching nodes need one. Kinematic contacts of a problem act together:
            the largest of their numbers counts [1].

    Raises:
        TypeError: `pair` is not a ContactPair, or `sweeps` not a number; on all ranks.
        ValueError: `sweeps` is not a positive integer; on all ranks.
    """

    def __init__(self, pair: ContactPair, sweeps: int = 3) -> None:
        with guard(comm_of(pair), "Kinematic", pair=pair, sweeps=sweeps):
            check_pair(pair)
            self.pair, self.sweeps = pair, integer("sweeps", sweeps, 1)

    def __repr__(self) -> str:
        return f"Kinematic({self.pair!r}, sweeps={self.sweeps})"

    def _bind(self, problem: object) -> None:
        raise ValueError("kinematic contact is for explicit dynamics: use Lagrange or Penalty in a StaticProblem")

    def _bind_explicit(self, problem: ExplicitContactProblem) -> "NodalPair":
        return NodalPair(self.pair, problem, _cpp.nodal.KinematicContact, sweeps=self.sweeps)


GAPS = ("gap", "normal")
RESULTS = (*GAPS, "pressure", "traction", "slip", "status", "stiffness")  # arrays by node


class NodalPair(NodalOutput):
    """Contact of one pair in an explicit problem, a view of cpp/dolfinx_impact/enforcement/node_to_surface/NodalPair.h;
    points are the slave nodes that this rank owns.

    Gaps and normals belong to the present configuration. They are evaluated on access, because the time steps evaluate
    only nodes that may be in contact. Without a master within the search distance a gap is infinite and its normal
    zero.

    Args:
        pair: the pair of surfaces.
        problem: the problem.
        cpp_class: C++ class of the contact, NodePenalty, NodeLaw or KinematicContact.
        by_step: springs without a given penalty follow from masses and time step instead of the bodies' stiffness.
        options: kept as `parameters`, those of the C++ class; `law` of NodeLaw is an InterfaceLaw.

    Attributes:
        nodes: owned slave nodes, (n).
        weight: areas of the nodes, (n) [L^2].
        pressure: contact pressure, (n); in balanced contact twice that of the springs of this direction, which bear
            half [F/L^2].
        traction: contact traction on the slave, (n, gdim), likewise [F/L^2].
        stiffness: contact stiffness of the nodes, (n) [F/L].
        motion: displacement of a rigid master as a function of time; None for deformable masters, and for rigid
            bodies, which move by forces [L].
        body: rigid body on the C++ side; None: the master is none.
        stored: energy stored in the springs, of all ranks; zero in kinematic contact [F L].
        penetration_share: energy in the springs over that in all springs and in the deformation of the bodies: how much
            of the deformation is penetration. Zero in kinematic contact; not a number in problems of a residual of
            one's own, whose energy is not known [1].

        initial: penetrations in the reference configuration; None unless the pair adjusts gaps.

    Raises:
        ValueError: surfaces that do not fit the problem, or balanced contact with a rigid master; on all ranks.
    """

    initial: _cpp.gap.InitialPenetration | None
    nodes: IntArray
    weight: FloatArray
    points: FloatArray
    pressure: FloatArray
    traction: FloatArray
    slip: FloatArray
    status: IntArray
    stiffness: FloatArray
    force: FloatArray
    moment: FloatArray
    motion: Amplitude | None
    body: _cpp.problems.RigidBodyInTime | None
    penetration_share = 0.0
    _known: dict[str, FloatArray] | None = None  # gaps and normals of the last step, after they have been evaluated

    def __init__(
        self,
        pair: ContactPair,
        problem: ExplicitContactProblem,
        cpp_class: type[_cpp.nodal.NodePenalty] | type[_cpp.nodal.NodeLaw] | type[_cpp.nodal.KinematicContact],
        by_step: bool = False,
        **options: Any,
    ) -> None:
        self.pair, self.problem, self.V, self.by_step = pair, problem, problem.space, by_step
        V = problem.space
        self.comm, self.gdim = V.mesh.comm, V.mesh.geometry.dim
        if pair.rigid and options.get("balanced"):
            raise ValueError(f"{pair.name}: contact with a rigid master has one direction, it cannot be balanced")
        if cpp_class is _cpp.nodal.NodePenalty:
            pair.constant_friction("Penalty")
        if cpp_class is _cpp.nodal.KinematicContact:
            pair.refuse_rigid_body("kinematic contact")
            pair.refuse_angle("kinematic contact does not turn a rigid master: take Penalty")
        if getattr(problem, "axisymmetric", False):
            pair.refuse_angle("an axisymmetric problem does not turn a rigid master")
        slave, master = pair.surfaces(V)
        self.obstacle = pair.rigid_master.obstacle(self.gdim) if master is None else None
        if self.obstacle is not None:
            self.obstacle.displacement = list(map(float, pair.rigid_master.displacement))
            if self.obstacle.rotates:
                self.obstacle.rotation = pair.rigid_master.rotation_at_start(pair.name)
            self.obstacle.orientation_hint = pair.rigid_master.orientation_hint()
            _cpp.gap.check_side(pair.name, V._cpp_object, slave, self.obstacle)
        self._class, self.parameters = cpp_class, options
        met = master or self.obstacle
        assert met is not None  # one of the two
        self._surfaces = slave, met
        by_class = {**options, "by_step": by_step} if cpp_class is _cpp.nodal.NodePenalty else dict(options)
        if cpp_class is _cpp.nodal.NodeLaw:
            by_class["law"] = options["law"].in_cpp(V)
            self.parameters = {**options, "law": options["law"].identity(self.gdim)}
        self._cpp_object = self._make(**by_class)
        self._sides = cast(list[_cpp.nodal.NodeToSurface], self._cpp_object.directions)
        self.initial = self._sides[0].initial
        self._tell_of_penetration()
        self.nodes, self.weight = self._sides[0].nodes, self._sides[0].areas
        self._X = self._sides[0].X.reshape(-1, self.gdim)
        self.motion = None
        self.body = None if pair.rigid_body is None else pair.rigid_body.bind(problem)
        if pair.rigid and self.body is None:
            place, motion = pair.rigid_master.displacement, pair.rigid_master.motion
            moving = Amplitude(motion, f"motion of the rigid master of {pair.name}", size=3)
            self.motion = Amplitude(lambda t: place + moving.sample([t])[0], moving.name, size=3)

    @property
    def options(self) -> dict[str, Any]:
        return {**self.parameters, "by_step": self.by_step}

    @property
    def facet_length(self) -> float:
        """Longest slave facet of all ranks in the reference configuration [L]."""
        return float(self._sides[0].facet_length)

    @property
    def kind(self) -> str:
        if self._class is _cpp.nodal.NodeLaw:
            return "NodeLaw"
        return "KinematicContact" if self.kinematic else "PenaltyContact"

    def facets(self) -> tuple[_cpp.surface.Facets, _cpp.surface.Facets | _cpp.gap.Rigid]:
        return self._surfaces

    def _make(self, balanced: bool = False, **options: Any) -> _cpp.nodal.NodalPair:
        """Make the C++ contact of this pair in one or both directions, of the options of its class. Collective."""
        pair = self.pair
        options |= dict(
            friction=0.0 if isinstance(pair.friction, FrictionLaw) else pair.friction,
            search_distance=pair.search_distance or 0.0,
            axisymmetric=self.problem.axisymmetric,
            name=pair.name,
            adjustment=pair.adjustment,
        )
        if self.kinematic and isinstance(pair.friction, FrictionLaw):
            options["friction_law"] = pair.friction.in_cpp(self.V)
        slave, master = self._surfaces
        if balanced:
            assert isinstance(master, _cpp.surface.Facets)  # rigid masters were refused
            return _cpp.nodal.balanced_penalty(self.V._cpp_object, slave, master, **options)
        return _cpp.nodal.NodalPair([self._class(self.V._cpp_object, slave, master, **options)])

    @property
    def penalty(self) -> float:
        """Given penalty; 0 if the stiffness follows from the bodies, and in kinematic contact [F/L^3]."""
        return self.parameters.get("penalty", 0.0)

    @property
    def kinematic(self) -> bool:
        return self._class is _cpp.nodal.KinematicContact

    @property
    def is_penalty(self) -> bool:
        return self._class is _cpp.nodal.NodePenalty

    def sides(self) -> list[_cpp.nodal.NodeToSurface]:
        return self._sides

    @property
    def gap(self) -> FloatArray:
        return self._gaps()["gap"]

    @property
    def normal(self) -> FloatArray:
        return self._gaps()["normal"]

    def _gaps(self) -> dict[str, FloatArray]:
        """Gaps and normals in the present configuration, of open nodes as well."""
        if self._known is None:
            self.problem._cpp_object.update_gaps()
            results = self._sides[0].results()
            self._known = {name: results[name] for name in GAPS}
        return self._known

    def refresh(self) -> None:
        self.update_results()

    def update_results(self) -> None:
        results = self._sides[0].results()
        for name in RESULTS[len(GAPS) :]:
            setattr(self, name, results[name])
        if self.parameters.get("balanced", False):
            # The springs of this direction bear half of the contact; those of the other one meet the same surface.
            self.pressure, self.traction = 2.0 * self.pressure, 2.0 * self.traction
        self._known = None
        u = self.problem.u.x.array.reshape(-1, self.gdim)[self.nodes]
        self.points = self._X + u
        forces = self.weight[:, None] * self.traction
        self.sum_up(forces, self._cpp_object.force[: self.gdim], self.status > 0)

    def results_state(self) -> tuple[_cpp.state.State, _cpp.state.State]:
        return self.state_of(RESULTS)

    def resume_results(self, rows: _cpp.state.State, totals: _cpp.state.State) -> None:
        """There are no contact forces in a checkpoint to compute them from."""
        for name in RESULTS:
            now, values = getattr(self, name), rows.array(name)
            values = values.reshape(now.shape).astype(now.dtype)
            if name in GAPS:
                self._gaps()[name] = values
            else:
                setattr(self, name, values)
        self.resume_totals(totals)

    def covered(self) -> FloatArray:
        """One or zero: a node is in contact or not."""
        return (self.status > 0).astype(float)
