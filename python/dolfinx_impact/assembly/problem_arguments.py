# SPDX-License-Identifier: MIT
"""Checks of the arguments that problems have in common, on one rank, without communication, for use
under a guard (common/collective.py)."""

from typing import Any

from ..common import arguments
from ..materials import MaterialMap, _Material
from .one_point import check_explicit, check_integration
from .residual import check_residual, check_tangent


def material(m: Any) -> None:
    """Check a material.

    Args:
        m: the argument.

    Raises:
        TypeError: `m` is neither a material nor a MaterialMap.
    """
    if isinstance(m, (_Material, MaterialMap)):
        return
    if isinstance(m, type) and issubclass(m, (_Material, MaterialMap)):
        raise TypeError(f"material is the class {m.__name__}: make a material of it, {m.__name__}(E=..., nu=..., ...)")
    found = repr(m) if isinstance(m, str) else type(m).__name__
    raise TypeError(
        f"material must be a material, found {found}: for example LinearElastic(E=..., nu=..., density=...)"
    )


def contacts(contact: Any) -> list[Any]:
    """Contacts that were given as one object or a list.

    Args:
        contact: the argument.

    Returns:
        A list; what is in it has not been checked.

    Raises:
        TypeError: `contact` is neither.
    """
    # A pair alone passes: that it is not said how to enforce it is told later.
    return arguments.one_or_list("contact", contact, "a contact", ("pair", "master"))


def lists(bcs: Any, loads: Any, contact: Any) -> tuple[list[Any], list[Any], list[Any]]:
    """Arguments of problems that are one object or a list.

    Args:
        bcs: Dirichlet conditions.
        loads: loads.
        contact: contacts.

    Returns:
        The three as lists; what is in them has not been checked.

    Raises:
        TypeError: one of them is neither.
    """
    loads = arguments.one_or_list("loads", loads, "a load", ("form",))
    return arguments.one_or_list("bcs", bcs, "a DirichletBC", ("dof_indices", "bc")), loads, contacts(contact)


def problem(
    u: Any,
    given_material: Any,
    residual: Any,
    bcs: list[Any],
    loads: list[Any],
    contact: list[Any],
    axisymmetric: bool = False,
    explicit: bool = False,
    implicit: bool = False,
    tangent: Any = None,
    evaluate: Any = None,
    accept: Any = None,
) -> dict[str, Any]:
    """Check the arguments of a problem.

    Args:
        u: displacement function.
        given_material: material or MaterialMap; None with a residual.
        residual: UFL residual of a user's own; None with a material.
        bcs: Dirichlet conditions, as `lists` returns them.
        loads: loads, likewise.
        contact: contacts, likewise.
        axisymmetric: whether the residual is that of an axisymmetric body.
        explicit: whether the problem is an explicit one.
        implicit: whether it is an implicit one in time; static if neither.
        tangent: derivative of the residual, or None.
        evaluate: function that sets what residual and tangent read, or None.
        accept: function that is called when a step has converged, or None.

    Returns:
        Values that must be the same on all ranks, by name.

    Raises:
        TypeError: an argument of a wrong type.
        ValueError: both or neither of material and residual, or an argument that does not fit the displacement.
    """
    if (given_material is None) == (residual is None):
        raise ValueError("give either a material or a residual of your own")
    in_time = explicit or implicit
    _own_tangent(u, residual, tangent, evaluate, accept)
    needed_by = "a material" if residual is None else "contact" if contact else "loads" if loads else ""
    arguments.displacement(u, needed_by)
    V, mesh = u.function_space, u.function_space.mesh
    tdim = mesh.topology.dim
    if residual is None:
        material(given_material)
        if given_material.cell_tags is not None:
            arguments.tags("MaterialMap", given_material.cell_tags, mesh, tdim)
        arguments.radii(given_material.hypothesis_on(mesh), mesh)
        check_integration(u, given_material)
        if not explicit:
            check_explicit(given_material)
    else:
        check_residual(residual, u, tangent is not None)
        arguments.radii("axisymmetric" if axisymmetric else None, mesh)
    for bc in bcs:
        arguments.boundary_values("bcs", getattr(bc, "bc", bc) if in_time else bc, V)
    for load in loads:
        if not hasattr(load, "form"):
            kinds = "Traction, BodyForce, FollowerPressure, Foundation, AddedMass"
            raise TypeError(f"loads must hold {kinds}, found {type(load).__name__}")
        if not in_time and getattr(load, "amplitude", None) is not None:
            raise ValueError(
                f"{type(load).__name__} has an amplitude, a function of time: that is for problems in time; static "
                "ones go to the present value of the load in steps: set load.constant.value = table(t) * ... between "
                "two solves"
            )
        if hasattr(load, "facet_tags"):
            arguments.tags(type(load).__name__, load.facet_tags, mesh, tdim - 1)
    for c in contact:
        if hasattr(c, "facet_tags"):
            ways = ("Penalty", "Kinematic") if explicit else ("Lagrange", "Penalty")
            hint = " or ".join(f"contact=[di.{way}(pair)]" for way in ways)
            raise TypeError(f"contact holds a ContactPair: say how it is enforced, {hint}")
        if not hasattr(c, "_bind") or isinstance(c, type):
            found = c.__name__ if isinstance(c, type) else type(c).__name__
            raise TypeError(f"contact must hold Lagrange, Penalty, Kinematic or Tie of pairs, found {found}")
        arguments.tags(c.pair.name, c.pair.facet_tags, mesh, tdim - 1)
    return {
        "material": given_material,
        "residual": residual,
        "u among the coefficients": None if residual is None else [f is u for f in residual.coefficients()],
        "bcs": [arguments.value_of(bc) for bc in bcs],
        "loads": loads,
        "contact": contact,
        "axisymmetric": axisymmetric,
        "tangent": tangent,
        "evaluate": evaluate,
        "accept": accept,
    }


def computes(u: Any, residual: Any, evaluate: Any) -> None:
    """Refuse a residual that Newton's method cannot change.

    Args:
        u: displacement function.
        residual: residual of a user's own, or None.
        evaluate: function that sets what it reads, or None.

    Raises:
        ValueError: the residual does not contain u, and nothing computes what it reads from u.
    """
    if residual is not None and evaluate is None and not any(c is u for c in residual.coefficients()):
        raise ValueError(
            "the residual does not contain u: give evaluate=, a function that computes what it reads from u in every "
            "iteration"
        )


def _own_tangent(u: Any, residual: Any, tangent: Any, evaluate: Any, accept: Any) -> None:
    """Check what is given with a residual beside it."""
    given = {"tangent": tangent, "evaluate": evaluate, "accept": accept}
    names = [name for name, value in given.items() if value is not None]
    if names and residual is None:
        raise ValueError(f"{names[0]} is for a residual of your own; a material has its own tangent")
    for name in ("evaluate", "accept"):
        if given[name] is not None and not callable(given[name]):
            raise TypeError(f"{name} must be a function of u, found {type(given[name]).__name__}")
    if evaluate is not None and tangent is None:
        raise ValueError("evaluate needs tangent: UFL does not know how what it sets depends on u")
    if accept is not None and evaluate is None:
        raise ValueError("accept belongs to evaluate, which is not given")
    if tangent is not None:
        arguments.displacement(u)
        check_tangent(tangent, u)
