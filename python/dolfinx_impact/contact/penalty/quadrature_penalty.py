# SPDX-License-Identifier: MIT
"""Penalty contact of static problems, seen from Python; docs/contact.md."""

import weakref
from typing import Any

import numpy as np

from ... import _cpp
from ...common.types import AnyArray, ArrayLike, FloatArray, IntArray
from ..pair import ContactPair, ContactStatus
from ..protocol import StaticContactProblem
from ..static_view import StaticContactView


class QuadraturePenalty(StaticContactView):
    """Penalty contact of one pair in a static problem; points are the quadrature points of this rank's slave facets.

    Args:
        pair: the pair of surfaces.
        problem: the problem.
        options: penalty, tangential, augmented, tolerance, quadrature_degree and max_augmentations of Penalty; None:
            the contact chooses.

    Attributes:
        has_multipliers: False, there are no multipliers to condense.
        options: as given, for the signature of a checkpoint.
    """

    has_multipliers = False
    all_in_cpp = True
    _cpp_object: _cpp.penalty.QuadraturePenalty

    def __init__(self, pair: ContactPair, problem: StaticContactProblem, **options: Any) -> None:
        self.pair, self.problem, self.options, V = pair, problem, options, problem.space
        self.V, self.comm, self.gdim = V, V.mesh.comm, V.mesh.geometry.dim
        pair.refuse_rigid_body("this problem", problem)
        if problem.axisymmetric:
            pair.refuse_angle("an axisymmetric problem does not turn a rigid master")
        self.slave, self.master = pair.surfaces(V)
        self.obstacle = pair.rigid_master.obstacle(self.gdim) if self.master is None else None
        if self.obstacle is not None:
            self.obstacle.orientation_hint = pair.rigid_master.orientation_hint()
            self.obstacle.rotates = pair.rigid_master.turns_in(problem)
        parameters = _cpp.penalty.PenaltyOptions()
        law = options.pop("law", None)
        for name, value in options.items():
            if value is not None:
                setattr(parameters, name, value)
        if law is not None:
            parameters.law = law.in_cpp(V)
            self.options = {**options, "law": law.identity(self.gdim)}
        parameters.friction = pair.constant_friction("Penalty")
        parameters.axisymmetric = problem.axisymmetric
        parameters.search_distance, parameters.adjustment = pair.search_distance or 0.0, pair.adjustment
        owner = weakref.ref(problem)  # the problem has this contact, and C++ would keep both for ever

        def bodies() -> Any:
            made = owner()
            assert made is not None  # it calls its contact
            return made.tangent.assemble()

        master = self.master or self.obstacle
        assert master is not None  # one of the two
        self._cpp_object = _cpp.penalty.QuadraturePenalty(
            pair.name, V._cpp_object, self.slave, master, parameters, bodies
        )
        self._totals = self._cpp_object.totals
        self._tell_of_penetration()

    @property
    def kind(self) -> str:
        return "penalty at quadrature points"

    def facets(self) -> tuple[Any, Any]:
        return self.slave, self.master

    @property
    def penalty(self) -> float | None:
        """Penalty in use; None before the first increment with an automatic one [F/L^3]."""
        return self._cpp_object.penalty or None

    @property
    def tangential(self) -> float | None:
        """Tangential penalty in use; None before the first increment [F/L^3]."""
        return self._cpp_object.tangential or None

    @property
    def displacement(self) -> FloatArray:
        """Displacement of a rigid master at the end of the present increment, (3) [L]."""
        return self._state_array("displacement")

    @property
    def convex(self) -> bool:
        """Whether `tangent` returns the positive semi-definite part of the tangent only."""
        return bool(self._cpp_object.convex)

    @convex.setter
    def convex(self, value: bool) -> None:
        self._cpp_object.set_convex(value)

    @property
    def history(self) -> _cpp.penalty.PenaltyHistory:
        """What the points remember of the last converged state (C++)."""
        return self._cpp_object.forces.history

    @property
    def evaluated(self) -> _cpp.penalty.PenaltyState:
        """The points in the present state (C++)."""
        return self._cpp_object.forces.state

    @property
    def uzawa(self) -> _cpp.penalty.Uzawa:
        """Augmented multipliers (C++)."""
        return self._cpp_object.uzawa

    def _state_array(self, name: str) -> FloatArray:
        return np.array(self._cpp_object.state().array(name)).reshape(-1)

    def update_gap(self, u: FloatArray) -> None:
        if not self._cpp_object.has_begun:  # a state is asked for before anything was solved
            self.begin_step(u, self.pair.rigid_master.displacement if self.pair.rigid else None)
        super().update_gap(u)

    def update_multipliers(self, residual: FloatArray) -> None:
        """Nothing: tractions follow from gaps."""

    def closing_forces(self) -> FloatArray | None:
        return self._cpp_object.closing_forces() if self._cpp_object.closes_nearest else None

    # --- results -----------------------------------------------------------------------------------------------------

    def nodal(self, values: ArrayLike) -> tuple[IntArray, FloatArray]:
        """Means of point values at the slave's nodes, weighted with squares of the shape functions. Collective.

        Args:
            values: values at the points, (n) or (n, ...).

        Returns:
            Owned nodes, (m), and means, (m, number of values per point).
        """
        given = np.asarray(values, dtype=float)
        columns = int(np.prod(given.shape[1:]))
        nodes, means = self._cpp_object.nodal_means(np.ascontiguousarray(given.reshape(len(given), columns)))
        return nodes, means

    def at_nodes(self, values: ArrayLike) -> tuple[IntArray, AnyArray]:
        """Real values become means over the points with finite ones, as a gap without master is infinite; a node
        without finite values gets an infinite one. Integers, as status, become the one with the largest part of the
        node's area."""
        values = np.asarray(values)
        if np.issubdtype(values.dtype, np.integer):
            nodes, parts = self.nodal(values[:, None] == np.arange(len(ContactStatus)))
            return nodes, np.argmax(parts, axis=1).astype(float)
        known = np.isfinite(values)
        nodes, sums = self.nodal(np.where(known, values, 0.0))
        parts = self.nodal(known)[1]
        means = np.divide(sums, parts, out=np.full_like(sums, np.inf), where=parts > 0.0)
        return nodes, means.reshape(-1, *values.shape[1:])
