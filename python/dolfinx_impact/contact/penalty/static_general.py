# SPDX-License-Identifier: MIT
"""General contact of static and implicit problems, seen from Python; docs/general_contact.md."""

from __future__ import annotations

import weakref
from typing import Any

import numpy as np

from ... import _cpp
from ...common.types import FloatArray
from ..general_surface import GeneralSurface
from ..protocol import StaticContactProblem
from .quadrature_penalty import QuadraturePenalty

SIDES = 2.0  # whose points press, each with half of the penalty


class StaticGeneral(QuadraturePenalty):
    """General contact of a static or implicit problem; points are the quadrature points of this rank's facets.

    A point has half of the penalty, as points of the other surface press as well. Its pressure and its traction are
    twice those of its spring, so that they are what both surfaces transmit where both are pressed alike.

    Args:
        pair: the surface.
        problem: the problem.

    Attributes:
        deepest: deepest penetration of all ranks in the present state [L].

    Raises:
        ValueError: surfaces that do not fit the problem, or bodies that overlap; on all ranks.
    """

    all_in_cpp = True

    def __init__(self, pair: GeneralSurface, problem: StaticContactProblem) -> None:
        self.pair: Any = pair
        self.problem, self.options, V = problem, {}, problem.space
        self.V, self.comm, self.gdim = V, V.mesh.comm, V.mesh.geometry.dim
        self.slave = self.master = pair.facets(V, problem.axisymmetric)
        self.obstacle = None
        parameters = _cpp.penalty.PenaltyOptions()
        parameters.friction, parameters.axisymmetric = pair.friction, problem.axisymmetric
        surfaces = [other.surfaces(V) for other in problem.named_pairs]
        named = [(slave, master) for slave, master in surfaces if master is not None]
        owner = weakref.ref(problem)  # the problem has this contact, and C++ would keep both for ever

        def bodies() -> Any:
            made = owner()
            assert made is not None  # it calls its contact
            return made.tangent.assemble()

        self._cpp_object = _cpp.penalty.QuadraturePenalty(
            pair.name, V._cpp_object, self.slave, named, parameters, bodies
        )
        self._totals = self._cpp_object.totals
        self._tell_of_penetration()

    @property
    def kind(self) -> str:
        return "general contact at quadrature points"

    def facets(self) -> tuple[Any, Any]:
        return self.slave, None

    @property
    def pressure(self) -> FloatArray:
        return SIDES * super().pressure

    @property
    def traction(self) -> FloatArray:
        return SIDES * super().traction

    @property
    def deepest(self) -> float:
        """Deepest penetration of all ranks in the present state, zero without any [L]. Collective."""
        return float(self._cpp_object.deepest)

    def force_on(self, tag: int) -> FloatArray:
        """Contact force on the surface with a tag, in the present state. Collective.

        Forces at nodes that it shares with other surfaces count to it.

        Args:
            tag: tag of facets.

        Returns:
            Force, (gdim) [F].

        Raises:
            ValueError: no facet of the boundary has the tag; on all ranks.
        """
        mask = self.pair.nodes_with(tag, self.V)[: self.V.dofmap.index_map.size_local]
        forces = np.asarray(self._cpp_object.contact_forces()).reshape(-1, self.gdim)[mask]
        return np.asarray(self.comm.allreduce(forces.sum(axis=0)))
