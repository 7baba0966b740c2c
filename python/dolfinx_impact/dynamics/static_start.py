# SPDX-License-Identifier: MIT
"""Equilibrium as the start of an explicit run: displacement, history of materials, springs under the static load."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from dolfinx import fem
from mpi4py import MPI

from .. import _cpp
from ..assembly import problem_arguments
from ..common.types import BoolArray, IntArray
from ..contact.penalty.penalty import Penalty
from ..statics.problem import StaticProblem
from .spring_start import SpringStart
from .started_problem import StartedProblem


def check(static: StaticProblem, given: dict[str, Any]) -> None:
    """Refuse what cannot go on in time, on this rank.

    Args:
        static: the equilibrium.
        given: further arguments of the explicit problem.

    Raises:
        TypeError: `static` is no StaticProblem, an argument follows from it, or a contact is not by penalty.
        ValueError: the contacts are of other surfaces; a residual of one's own, whose density is not known.
    """
    if not isinstance(static, StaticProblem):
        raise TypeError(f"from_static takes a StaticProblem, found {type(static).__name__}")
    twice = sorted({"u", "material", "residual"} & set(given))
    if twice:
        raise TypeError(f"{', '.join(twice)}: given by the StaticProblem")
    if static.material is None:
        raise ValueError("from_static needs a problem of a material: make the ExplicitProblem of your residual itself")
    contact = problem_arguments.contacts(given.get("contact", ()))
    if len(contact) != len(static.contact):
        raise ValueError(f"the StaticProblem has {len(static.contact)} contacts, given are {len(contact)}")
    for k, (new, old) in enumerate(zip(contact, static.contact)):
        if not isinstance(new, Penalty):
            raise TypeError(f"contact {k}: from_static hands over to Penalty, found {type(new).__name__}")
        pairs = [(p.slave, p.master) for p in (new.pair, old.pair)]
        if pairs[0] != pairs[1]:
            raise ValueError(f"contact {k} is between {pairs[0]}, that of the StaticProblem between {pairs[1]}")


def free_directions(problem: StartedProblem, nodes: IntArray) -> BoolArray:
    """Directions in which no node of a body is held, (gdim). Collective.

    Args:
        problem: the explicit problem.
        nodes: of the body, owned and ghosts.
    """
    gdim = problem.space.mesh.geometry.dim
    held = problem.prescribed.reshape(-1, gdim)[nodes].sum(axis=0)
    return np.asarray(problem.comm.allreduce(held, MPI.SUM)) == 0


def make(kind: Callable[..., StartedProblem], static: StaticProblem, given: dict[str, Any]) -> Any:
    """Make the explicit problem; arguments are checked. Collective.

    Args:
        kind: ExplicitProblem.
        static: the equilibrium.
        given: further arguments of the explicit problem.
    """
    V = static.u.function_space
    history = {name: field.values for name, field in static.history.items()} if static.has_history else {}
    given = {"velocity": fem.Function(V, name="velocity"), **given}

    def build(u: fem.Function) -> StartedProblem:
        problem = kind(u, static.material, **given)
        for name, values in history.items():
            problem.history[name].values = values
        return problem

    u = fem.Function(V, name=static.u.name)
    u.x.array[:] = static.u.x.array
    problem = build(u)
    bearing = [k for k, c in enumerate(static.contact) if V.mesh.comm.allreduce(int(np.any(c.pressure > 0.0)))]
    bodies = {}
    for k in bearing:
        slave, _ = static.contact[k].pair.surfaces(V)
        nodes = _cpp.operators.nodes_of_bodies(V._cpp_object, np.unique(slave.nodes))
        start = SpringStart(static.contact[k], nodes, problem, free_directions(problem, nodes), k)
        u.x.array[:] = start.moved(u.x.array, start.approach())
        bodies[k] = start
    if bearing:
        moved = fem.Function(V, name=static.u.name)
        moved.x.array[:] = u.x.array
        problem = build(moved)
    for k, start in bodies.items():
        # Static springs are compressed like these ones: the approach is enough, and leaves no offset behind.
        if static.contact[k].has_multipliers:
            SpringStart(static.contact[k], start.nodes, problem, None, k).hand_over()
    problem.restart_forces()
    return problem
