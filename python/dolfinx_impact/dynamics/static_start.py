# SPDX-License-Identifier: MIT
"""Equilibrium as the start of an explicit run: displacement, history of materials, springs under the static load."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from dolfinx import fem

from ..assembly import problem_arguments
from ..contact.mortar.tie import Tie, TieContact
from ..contact.penalty.penalty import Penalty
from ..contact.penalty.static_general import StaticGeneral
from ..statics.static_problem import StaticProblem
from .started_problem import StartedProblem


def check(static: StaticProblem, given: dict[str, Any]) -> None:
    """Refuse what cannot go on in time, on this rank.

    Args:
        static: the equilibrium.
        given: further arguments of the explicit problem.

    Raises:
        TypeError: `static` is no StaticProblem, an argument follows from it, or a contact is neither by penalty nor a
            tie.
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
        if isinstance(new, Tie) != isinstance(old, TieContact):
            raise TypeError(f"contact {k}: a tie goes on as a tie, {type(old).__name__} does as {type(new).__name__}")
        if isinstance(old, StaticGeneral):
            raise TypeError(f"contact {k}: springs of general contact are not handed over: name the surfaces in pairs")
        if not isinstance(new, (Penalty, Tie)):
            raise TypeError(f"contact {k}: from_static hands over to Penalty, found {type(new).__name__}")
        new.pair.refuse_rigid_body("a run that begins with an equilibrium")
        pairs = [(p.slave, p.master) for p in (new.pair, old.pair)]
        if pairs[0] != pairs[1]:
            raise ValueError(f"contact {k} is between {pairs[0]}, that of the StaticProblem between {pairs[1]}")


def make(kind: Callable[..., StartedProblem], static: StaticProblem, given: dict[str, Any]) -> Any:
    """Make the explicit problem; arguments are checked. Collective.

    Args:
        kind: ExplicitProblem.
        static: the equilibrium.
        given: further arguments of the explicit problem.
    """
    V = static.u.function_space
    u = fem.Function(V, name=static.u.name)
    u.x.array[:] = static.u.x.array
    problem = kind(u, static.material, **{"velocity": fem.Function(V, name="velocity"), **given})
    problem.restart_forces(static.equilibrium)
    return problem


def start_again(problem: StartedProblem, static: StaticProblem, velocity: fem.Function) -> None:
    """Begin with another equilibrium of the same bodies, as a new problem would that takes seconds to set up: forms are
    analysed and masses assembled once. Collective.

    Args:
        problem: explicit problem that `from_static` has made and that has made no step; its displacement and velocity
            are overwritten.
        static: the equilibrium, with contacts of the same surfaces.
        velocity: velocity at the start [L/T].

    Raises:
        ValueError: steps have been made; on all ranks.
        RuntimeError: the springs do not bear the static force; on all ranks.
    """
    problem.u.x.array[:] = static.u.x.array
    problem.velocity.x.array[:] = velocity.x.array
    problem._cpp_object.begin_anew()
    problem.restart_forces(static.equilibrium)
