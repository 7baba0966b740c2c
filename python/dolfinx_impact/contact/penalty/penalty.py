# SPDX-License-Identifier: MIT
"""Contact by penalty: Gauss point to surface, exact tangent, friction by return mapping; docs/contact.md."""

import basix
import numpy as np
from mpi4py import MPI

from ... import _cpp
from ...common.arguments import integer
from ...common.collective import comm_of, guard
from ...common.arguments import number
from .automatic import automatic_penalty, check_penalty
from .facets import FacetKeeper
from ..nodal_sum import NodalSum
from ..explicit.nodal import NodalResult
from ..output import ContactOutput
from ..pair import ContactStatus, check_pair, check_quadrature_degree
from ..body_size import body_size
from ..initial_penetration import InitialPenetration, check_side, nearly_touching
from .uzawa import Uzawa

# The automatic penalty is this many times the stiffness per area of the softer surface's nodes: penetrations
# are a tenth of what the outermost cells are compressed by, the matrix is about as well conditioned as elasticity's.
FACTOR = 10.0
# From this ratio of their facets on a slave's surface is much coarser than the master's.
COARSE = 2.0
# Where bodies just touch, round-off must not decide: gaps up to this times their size are closed.
TOUCH = 1e-12
STILL = 1e-12  # of the size: round-off of projections


class Penalty:
    """Enforce contact of a pair by a penalty, seed (3.48), corrected.

    Args:
        pair: ContactPair.
        penalty: pressure per penetration [F/L^3]; "auto": ten times the stiffness per area of the nodes of the softer
            surface where its facets are smallest, from material and mesh. Printed when it is found.
        tangential: the same along the surface, with friction; None: equal to `penalty` [F/L^3].
        augmented: repeat each increment with multipliers from the penetrations reached (Uzawa), until the penetration,
            averaged around each corner of the slave's facets, is below `tolerance` times the size of the bodies.
        max_augmentations: of one increment; each takes the part penalty/(penalty + stiffness per area of the bodies) of
            the penetration away.
        quadrature_degree: on slave facets; None: 2 degree + 2.
        balanced: in explicit problems, once in each direction with half the stiffness.

    In explicit problems (docs/explicit/penalty.md) the slave's nodes are the points, and "auto" is a stiffness from
    nodal masses and the step; `tangential`, `augmented` and `quadrature_degree` are for static ones.

    Raises:
        TypeError, ValueError: a penalty that is no positive number.
    """

    def __init__(self, pair, penalty="auto", tangential=None, augmented=False, tolerance=1e-8, quadrature_degree=None,
                 balanced=False, max_augmentations=200):  # fmt: skip
        given = dict(penalty=penalty, tangential=tangential, augmented=bool(augmented), tolerance=tolerance,
                     balanced=bool(balanced), max_augmentations=max_augmentations)  # fmt: skip
        with guard(comm_of(pair), "Penalty", pair=pair, quadrature_degree=quadrature_degree, **given):
            check_pair(pair)
            self.quadrature_degree = check_quadrature_degree(quadrature_degree)
            auto = isinstance(penalty, str) and penalty == "auto"
            self.penalty = None if auto else number("penalty", penalty, 0.0, " [F/L^3]")
            self.tangential = None if tangential is None else number("tangential penalty", tangential, 0.0, " [F/L^3]")
            self.tolerance = number("tolerance", tolerance, 0.0)
            self.max_augmentations = integer("max_augmentations", max_augmentations, 1)
        self.pair, self.augmented, self.balanced = pair, bool(augmented), bool(balanced)

    def __repr__(self):
        options = [f"penalty={self.penalty or 'auto'!r}"]
        if self.tangential is not None:
            options.append(f"tangential={self.tangential}")
        options += [f"{name}=True" for name in ("augmented", "balanced") if getattr(self, name)]
        return f"Penalty({self.pair!r}, {', '.join(options)})"

    def _bind_explicit(self, problem):
        if self.augmented or self.tangential is not None or self.quadrature_degree is not None:
            raise ValueError("tangential, augmented and quadrature_degree are options of static penalty contact")
        law = _cpp.nodal.PenaltyContact
        return NodalResult(self.pair, problem, law, penalty=self.penalty or 0.0, balanced=self.balanced)

    def _bind(self, problem):
        if self.balanced:
            raise ValueError("balanced penalty contact is for explicit dynamics")
        return PenaltyContact(self, problem)


class PenaltyContact(ContactOutput):
    """Penalty of one pair in a problem. Points are the quadrature points of this rank's slave facets; see
    ContactOutput. `penalty` is the one in use [F/L^3]."""

    initial = None
    has_multipliers = False  # nothing to condense
    convex = False  # the stiffness is the positive semi-definite part of the tangent

    def __init__(self, spec, problem):
        self.spec, self.pair, self.problem = spec, spec.pair, problem
        V = problem.space
        self.V, self.comm, self.gdim = V, V.mesh.comm, V.mesh.geometry.dim
        self.slave, self.master = self.pair.surfaces(V)
        self.size = body_size(V.mesh)
        element = self.slave.displacement
        degree = spec.quadrature_degree or 2 * element.degree + 2
        rule = basix.make_quadrature(getattr(basix.CellType, element.shape), degree)
        self._rule = [np.ascontiguousarray(a) for a in rule]
        self.obstacle = self.pair.master._obstacle(self.gdim) if self.pair.rigid else None
        distance = () if self.pair.rigid else (self.pair.search_distance or 0.0,)
        self._cpp = _cpp.penalty.QuadraturePenalty(
            V._cpp_object, self.slave, self.obstacle or self.master, *self._rule, problem.axisymmetric, *distance
        )
        self._points, self.history = self._cpp.points, self._cpp.history
        self._cpp.parameters.friction = self.pair.friction
        self.displacement, self.start_displacement = np.zeros(3), np.zeros(3)
        self.start, self.penalty, self.tangential = np.zeros_like(problem.u.x.array), spec.penalty, spec.tangential
        self.uzawa, self.fault = Uzawa(V, self.slave, rule), ""
        num = self._points.size
        self._status = np.zeros(num, dtype=np.int8)  # of the last iteration
        self._touched = np.zeros(num, dtype=bool)  # closed in the last converged state
        self._keeper = None if self.pair.rigid else FacetKeeper(self.comm, self._points, self._cpp.search)
        if self.pair.rigid:
            check_side(self.pair, V, self.slave, self.obstacle)
        self._seen = False  # the state before the first increment is nothing to stay on a facet from
        self._locate(self.start)
        self.initial = InitialPenetration(self.pair, V, self.slave, self.master, self._points.x, self._points.gap)
        self.history.offset = self.initial.offset

    def check_parameters(self):
        """Refuse a given penalty that is out of all proportion. Collective."""
        if self.spec.penalty is not None:
            check_penalty(self, FACTOR)

    # --- state of an increment -------------------------------------------------------------------------------------

    def save_state(self):
        """State that an increment starts from, as a dict of copies."""
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

    def restore_state(self, state):
        """Back to a saved state."""
        for name in ("multiplier", "traction", "slip"):
            setattr(self.history, name, state[name])
        self.start, self.uzawa.multiplier = state["start"].copy(), state["corners"].copy()
        self._touched = state["touched"].copy()
        self.start_displacement, self.displacement = (d.copy() for d in state["displacements"])

    def begin_step(self, u, displacement, target=None):
        """An increment starts at u; a rigid master goes to `displacement` in it. Collective."""
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
        if self.pair.friction > 0.0:  # motion counts from where a point closes
            self._locate(self.start)
            gap = self.gap
            self.history.gap = np.where(self._touched | (gap <= TOUCH * self.size), 0.0, gap)
        if displacement is not None:
            self.start_displacement, self.displacement = self.displacement, np.array(displacement, dtype=float)

    def accept_step(self):
        """The increment has converged: tractions and slip are history."""
        self._cpp.accept_step()
        self._touched = self.status > 0
        self.update_totals()

    def augment(self):
        """Augment where the surfaces still penetrate; returns whether another round is needed, or sets `fault`.
        Collective."""
        if self._leave_facets():
            return True
        if not self.spec.augmented:
            return False
        tolerance = self.spec.tolerance * self.size
        multiplier = self.uzawa.augment(self.gap, self._points.weight, self.penalty, tolerance)
        if multiplier is None:
            return False
        self.history.multiplier = multiplier
        if self.uzawa.rounds <= self.spec.max_augmentations:
            return True
        self.fault = f"{self.pair.name}: {self.uzawa.fault(self.penalty, tolerance)}"
        return False

    def update_gap(self, u):
        """Search, gaps and tractions at the displacements u. Collective."""
        self._u = np.array(u)
        self._locate(self._u)
        self._seen = True
        self._cpp.parameters.touch = self._touch
        self._cpp.evaluate(self._u - self.start, (self.displacement - self.start_displacement).tolist())
        self._touch, self._pulls = 0.0, False

    def _leave_facets(self):
        """Converged with points that stay on a facet they are a little beside: project anew; returns whether that
        moves any, so that the iteration must go on, without staying. Once per increment. Collective."""
        if self._keeper is None or not self._keeper.leave():
            return False
        before = self._feet(), self.traction
        self.update_gap(self._u)
        closed, feet = self.status > 0, self._feet()
        parts = (feet - before[0])[closed], (self.traction - before[1]) / self.penalty
        moved = max(float(np.max(np.abs(p), initial=0.0)) for p in parts)
        return self.comm.allreduce(moved, MPI.MAX) > STILL * self.size

    def _feet(self):
        """Closest points on the master, (n, gdim) [L]; meaningless where there is none."""
        gap = self._points.gap
        return self._points.x - np.where(np.isfinite(gap), gap, 0.0)[:, None] * self._points.normal

    def coarse_slave(self):
        """Facets of the slave that are far longer than the master's: points press dents in between. Collective."""
        sizes = [self.slave.X] if self.pair.rigid else [self.slave.X, self.master.X]
        sums = [(float(np.linalg.norm(np.ptp(X, axis=1), axis=1).sum()), len(X)) for X in sizes]
        means = [total / number for total, number in np.sum(self.comm.allgather(sums), axis=0)]
        if len(means) < 2 or means[0] < COARSE * means[1]:
            return ""
        return (
            f"{self.pair.name}: the slave's facets are {means[0] / means[1]:.1f} times as long as the master's, "
            "which is dented between its points: exchange slave and master, refine the slave, or take multipliers"
        )

    def close_nearest(self):
        """Close the points nearest to the master in this iteration, which draws them together, if they nearly touch and
        no point does; returns whether there are any. For bodies that nothing else holds. Collective."""
        size = np.linalg.norm(np.ptp(self.slave.X, axis=1), axis=1)
        gap = nearly_touching(self.comm, self.gap, np.repeat(size, self._points.per_facet))
        if gap is None or self.num_active > 0:
            return False
        self._cpp.parameters.touch = gap * self.penalty
        self._cpp.evaluate()
        self._pulls = True
        return True

    def _locate(self, u):
        """Closest points and gaps at the displacements u. Collective."""
        if self.pair.rigid:
            self.obstacle.displacement = self.displacement.tolist()
        self._cpp.update_gap(u, self.start, self._seen and self._keeper is not None and self._keeper.stay)

    def update_active_set(self, first, last=None):
        """How many points of all ranks changed their state, or the facet they touch, since the last iteration. Once an
        iteration. Collective."""
        status = self.status
        changed = np.count_nonzero(status != self._status)
        if self._keeper is not None:
            changed += self._keeper.watch(status > 0)
        self._status = status
        return self.comm.allreduce(changed)

    def update_multipliers(self, residual):
        """Nothing: tractions follow from gaps."""

    def violation(self):
        """Penetrations are part of the method."""
        return 0.0

    @property
    def num_active(self):
        """Points in contact, of all ranks. Collective."""
        return self.comm.allreduce(int(np.count_nonzero(self.status)))

    # --- linear system ---------------------------------------------------------------------------------------------

    def contact_forces(self):
        """Nodal contact forces on both bodies, array over owned dofs [F]. Collective."""
        return self._cpp.contact_forces()

    def add_residual(self, b):
        """Subtract the nodal contact forces from a residual (PETSc vector) [F]. Collective."""
        self._cpp.add_residual(b)

    @property
    def symmetric(self):
        """Is the tangent symmetric? Not where points slip with friction. Collective."""
        slips = self.pair.friction > 0.0 and bool(np.any(self.status == 2))
        return self.comm.allreduce(int(slips)) == 0

    def update_nodal_stiffness(self, K):
        """Nothing: the penalty is known."""

    def tangent(self):
        """Derivative of minus the contact force, a matrix that is kept; see StaticContact. Collective."""
        return self._cpp.tangent(self.convex)

    def closing_forces(self):
        """Force (array over owned dofs) that brings the nearest points to touch, to take from the right-hand side; or
        None. Collective."""
        return -self._cpp.closing_forces() if self._pulls else None

    def rigid_body_constraints(self, motions):
        """Jumps at touching points under the rigid body modes; see StaticContact. Collective."""
        touching = np.flatnonzero(self.status)
        slave, master, body = self.slave, None, motions.body
        if not self.pair.rigid:  # facets that other ranks know
            search = self._cpp.search
            slave, master, near = search.slave, search.master, search.map
            body = np.zeros(near.size_local + near.num_ghosts)
            body[: motions.num_owned] = motions.body[: motions.num_owned]
            body = NodalSum(near, 1).forward(body).ravel().astype(int)
        feet, facing, parts = self._feet(), self._points.master, []
        for at in np.array_split(touching, max(1, len(touching) // 10000)):
            directions = [self.normal[at]]
            if self.pair.friction > 0.0:
                directions = [np.tile(e, (len(at), 1)) for e in np.eye(self.gdim)]
            slaves = body[slave.nodes[at // self._points.per_facet, 0]]
            for d in directions:
                rows = motions.rows(slaves, self.points[at], d)
                if master is not None:
                    masters = body[master.nodes[facing[at], 0]]
                    rows -= motions.rows(masters, feet[at], d)
                parts.append(rows)
        return parts

    # --- results ---------------------------------------------------------------------------------------------------

    @property
    def points(self):
        """Current positions, (n, gdim) [L]."""
        return self._points.x

    @property
    def gap(self):
        """Gap, positive open; infinite where there is no master, (n) [L]."""
        return self._points.gap + self.initial.offset

    @property
    def normal(self):
        """Unit normals out of the master, (n, gdim)."""
        return self._points.normal

    @property
    def pressure(self):
        """Pressure per reference area at quadrature points, (n) [F/L^2]; to plot it: at_nodes(contact.pressure)."""
        return self._cpp.state.pressure

    @property
    def traction(self):
        """Contact traction on the slave per reference area, (n, gdim) [F/L^2]."""
        return self._cpp.state.traction.reshape(-1, self.gdim)

    @property
    def slip(self):
        """Tangential displacement of slave against master, added up while in contact, (n, gdim) [L]."""
        return self._cpp.state.slip.reshape(-1, self.gdim)

    @property
    def status(self):
        """ContactStatus numbers, (n)."""
        return self._cpp.state.status

    @property
    def weight(self):
        """Area that belongs to each point, (n) [L^2]; a length in 2D."""
        return self._points.weight

    def covered(self):
        """Part of each point's area that is in contact: all of it or nothing, (n)."""
        return (self.status > 0).astype(float)

    def nodal(self, values):
        """Means of point values at the slave's nodes: (nodes, values); weights are squares of the shape functions."""
        points, element = self._points, self.slave.displacement
        table = np.array([element.tabulate(*xi)[0] for xi in points.xi[: points.per_facet]])
        w = points.weight.reshape(-1, points.per_facet)[:, :, None] * (table**2)[None]
        values = np.asarray(values, dtype=float)
        values = values.reshape(-1, points.per_facet, int(np.prod(values.shape[1:])))
        size = self.V.dofmap.index_map.size_local + self.V.dofmap.index_map.num_ghosts
        total, weight = np.zeros((size, values.shape[-1])), np.zeros(size)
        np.add.at(total, self.slave.nodes, np.einsum("fqn,fqv->fnv", w, values))
        np.add.at(weight, self.slave.nodes, w.sum(axis=1))
        total = NodalSum(self.V.dofmap.index_map, values.shape[-1])(total)
        weight = NodalSum(self.V.dofmap.index_map, 1)(weight).ravel()
        nodes = np.flatnonzero(weight[: self.V.dofmap.index_map.size_local])
        return nodes, total[nodes] / weight[nodes, None]

    def at_nodes(self, values):
        """A contact array by nodes: their numbers on this rank, (m), and values, (m) or (m, gdim). Collective.

        Numbers are means over the points that know one (a gap without master is none; nodes without any: infinite). Of
        whole numbers, as status, it is the one that most of the node's area has.
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
