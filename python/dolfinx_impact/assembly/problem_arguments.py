# SPDX-License-Identifier: MIT
"""Checks of what static and explicit problems have in common: of one rank, without communication, for use under a guard
(common/collective.py)."""

from ..common import arguments
from ..materials import MaterialMap, _Material
from .residual import check_residual


def material(m):
    """A material or a MaterialMap."""
    if isinstance(m, (_Material, MaterialMap)):
        return
    if isinstance(m, type) and issubclass(m, (_Material, MaterialMap)):
        raise TypeError(f"material is the class {m.__name__}: make a material of it, {m.__name__}(E=..., nu=..., ...)")
    found = repr(m) if isinstance(m, str) else type(m).__name__
    raise TypeError(
        f"material must be a material, found {found}: for example LinearElastic(E=..., nu=..., density=...)"
    )


def problem(u, given_material, residual, bcs, loads, contact, axisymmetric=False, explicit=False):
    """What static and explicit problems have in common; values that must be the same on all ranks, as a dict."""
    if (given_material is None) == (residual is None):
        raise ValueError("give either a material or a residual of your own")
    contact = arguments.sequence("contact", contact, "contacts")
    arguments.displacement(u, solid=residual is None or bool(contact))
    V, mesh = u.function_space, u.function_space.mesh
    tdim = mesh.topology.dim
    if residual is None:
        material(given_material)
        if given_material.cell_tags is not None:
            arguments.tags("MaterialMap", given_material.cell_tags, mesh, tdim)
        arguments.radii(given_material.hypothesis_on(mesh), mesh)
    else:
        check_residual(residual, u)
        arguments.radii("axisymmetric" if axisymmetric else None, mesh)
    for bc in arguments.sequence("bcs", bcs, "DirichletBC"):
        arguments.boundary_values("bcs", getattr(bc, "bc", bc) if explicit else bc, V)
    for load in arguments.sequence("loads", loads, "loads"):
        if not hasattr(load, "form"):
            raise TypeError(f"loads must hold Traction, BodyForce, FollowerPressure, found {type(load).__name__}")
        if not explicit and getattr(load, "amplitude", None) is not None:
            raise ValueError(
                f"{type(load).__name__} has an amplitude, a function of time: that is for explicit problems; static "
                "ones go to the present value of the load in steps"
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
            raise TypeError(f"contact must hold Lagrange, Penalty or Kinematic of pairs, found {found}")
        arguments.tags(c.pair.name, c.pair.facet_tags, mesh, tdim - 1)
    return {
        "material": given_material,
        "residual": residual,
        "u among the coefficients": None if residual is None else [f is u for f in residual.coefficients()],
        "bcs": [arguments.value_of(bc) for bc in bcs],
        "loads": list(loads),
        "contact": contact,
        "axisymmetric": axisymmetric,
    }
