# SPDX-License-Identifier: MIT
"""Checks of users' arguments on one rank, without communication, for use under a guard (collective.py).

Each check raises TypeError for an argument of a wrong type and ValueError for a value that does not fit. The message
says what was found and what to do.
"""

import math
import os
from typing import Any

import numpy as np
import ufl
from dolfinx import fem
from dolfinx.fem import FunctionSpace
from dolfinx.mesh import Mesh

from .types import FloatArray


ROUND_OFF = 1e-12  # part of the mesh's extent; smaller coordinates count as zero
LARGEST_DEGREE = 60  # of quadrature rules; higher degrees have thousands of points on every facet
RULES = ("default", "Gauss-Jacobi", "Gauss-Legendre", "GL", "Gauss-Lobatto-Legendre", "GLL", "Xiao-Gimbutas", "vertex",
         "custom", "gauss_jacobi", "gll", "xiao_gimbutas")  # fmt: skip


def number(name: str, value: Any, low: float | None = None, unit: str = "") -> float:
    """Check a finite number.

    Args:
        name: name of the argument, for the message.
        value: the argument.
        low: exclusive lower bound; None: no bound.
        unit: unit for the message, with a blank before it.

    Returns:
        The number.

    Raises:
        TypeError: `value` is not a number.
        ValueError: `value` is not finite, or not greater than `low`.
    """
    try:
        if isinstance(value, (str, bytes, bool)):
            raise TypeError
        found = float(value)
    except (TypeError, ValueError):
        raise TypeError(f"{name} must be a number, found {value!r}") from None
    if not math.isfinite(found):
        raise ValueError(f"{name} is {found}: give a finite number{unit}")
    if low is not None and not found > low:
        raise ValueError(f"{name} is {found}: it must be greater than {low}{unit}")
    return found


def integer(name: str, value: Any, low: int, high: int | None = None, unit: str = "") -> int:
    """Check an integer.

    Args:
        name: name of the argument, for the message.
        value: the argument.
        low: smallest permitted value.
        high: largest permitted value; None: no bound.
        unit: unit for the message, with a blank before it.

    Returns:
        The integer.

    Raises:
        TypeError: `value` is not a number.
        ValueError: `value` is not an integer, or outside the bounds.
    """
    if isinstance(value, (bool, np.bool_, str, bytes)) or np.ndim(value) != 0:
        raise TypeError(f"{name} is {value!r}: give {_range(low, high)}{unit}")
    try:
        whole = int(value)
        fits = whole == value
    except TypeError:
        raise TypeError(f"{name} is {value!r}: give {_range(low, high)}{unit}") from None
    except (ValueError, OverflowError):  # nan, inf
        fits = False
    if not fits or whole < low or (high is not None and whole > high):
        raise ValueError(f"{name} is {value!r}: give {_range(low, high)}{unit}")
    return whole


def tolerance(name: str, value: Any) -> float:
    """Check a relative or absolute tolerance of a solver.

    Args:
        name: name of the argument; "rtol" must be less than one.
        value: the argument.

    Returns:
        The tolerance.

    Raises:
        TypeError: `value` is not a number.
        ValueError: `value` is negative or not finite, or a relative tolerance is one or more.
    """
    found = number(name, value)
    if found < 0.0 or (name == "rtol" and found >= 1.0):
        raise ValueError(f"{name} is {found}: give {'a number from 0 to 1' if name == 'rtol' else 'zero or more'}")
    return found


def _range(low: int, high: int | None) -> str:
    """Name of a range of integers, for messages."""
    if high is not None:
        return f"an integer from {low} to {high}"
    return {0: "an integer, zero or positive", 1: "a positive integer"}.get(low, f"an integer, {low} or more")


def one_or_list(name: str, value: Any, what: str, marks: tuple[str, ...]) -> list[Any]:
    """Check an argument that is one object, or a list or tuple of them.

    Args:
        name: name of the argument, for the message.
        value: the argument.
        what: what one object is, with its article, for the message.
        marks: attributes of which such an object has at least one; those in a list are not looked at.

    Returns:
        The objects as a list.

    Raises:
        TypeError: `value` is neither list nor tuple nor such an object.
    """
    if isinstance(value, (list, tuple)):
        return list(value)
    if not isinstance(value, type) and any(hasattr(value, mark) for mark in marks):
        return [value]
    if isinstance(value, type):
        found, hint = f"the class {value.__name__}", f"make an object of it, {value.__name__}(...)"
    else:
        found, hint = type(value).__name__, f"put what there is into a list, {name}=[...]"
    hint = "leave it out, or give ()" if value is None else hint
    raise TypeError(f"{name} must be {what} or a list of them, found {found}: {hint}")


def function(name: str, u: Any) -> None:
    """Check a DOLFINx function of double precision.

    Args:
        name: name of the argument, for the message.
        u: the argument.

    Raises:
        TypeError: `u` is not a function, or has values of another type than float64.
    """
    if not isinstance(u, fem.Function):
        hint = ": make a function of it, fem.Function(V)" if isinstance(u, fem.FunctionSpace) else ""
        raise TypeError(f"{name} must be a Function of dolfinx.fem, found {type(u).__name__}{hint}")
    double_precision(name, u.x.array)


def function_space(name: str, V: Any) -> None:
    """Check a DOLFINx function space on a mesh of double precision.

    Args:
        name: name of the argument, for the message.
        V: the argument.

    Raises:
        TypeError: `V` is not a function space, or its mesh has coordinates of another type than float64.
    """
    if not isinstance(V, fem.FunctionSpace):
        raise TypeError(f"{name} must be a dolfinx.fem.FunctionSpace, found {type(V).__name__}")
    double_precision(f"the mesh of {name}", V.mesh.geometry.x)


def double_precision(name: str, array: Any) -> None:
    """Check that an array has values of type float64, the only type of the kernels.

    Args:
        name: name of the argument, for the message.
        array: the argument.

    Raises:
        TypeError: `array` has values of another type.
    """
    kind = getattr(array, "dtype", None)
    if kind != np.float64:
        hint = "make mesh and functions with dtype=numpy.float64"
        raise TypeError(f"{name} has numbers of type {kind}: float64 is needed; {hint}")


def displacement(u: Any, needed_by: str = "") -> None:
    """Check a displacement: a vector function of a Lagrange space with one component per direction of space.

    Args:
        u: the argument.
        needed_by: what asks for a displacement, "a material", "contact", "loads", for the message; empty: nothing does,
            the problem has a residual of the user's own, whose unknowns need not be displacements.

    Raises:
        TypeError: `u` is not a function of double precision.
        ValueError: the mesh is not a 2D or 3D body or has coordinates that are not finite, or the space is not a
            continuous Lagrange space with one component per direction.
    """
    function("u", u)
    V, mesh = u.function_space, u.function_space.mesh
    double_precision("the mesh of u", mesh.geometry.x)
    tdim, gdim = mesh.topology.dim, mesh.geometry.dim
    if not np.all(np.isfinite(mesh.geometry.x)):
        raise ValueError("the mesh of u has nodes whose coordinates are not finite numbers: read or make it again")
    if not needed_by:
        return
    if tdim < 2 or tdim != gdim:
        raise ValueError(_no_body(tdim, gdim, needed_by))
    if V.ufl_element().is_mixed:
        raise ValueError(_mixed(needed_by))
    element = V.ufl_element()
    needed = f'fem.functionspace(mesh, ("Lagrange", degree, ({gdim},)))'
    if V.value_shape != (gdim,):
        what = "a scalar" if V.value_shape == () else f"values of shape {tuple(V.value_shape)}"
        raise ValueError(f"u is {what}: a displacement on this mesh has {gdim} components; use {needed}")
    # Mixed elements have no family; vector-valued families have blocks of one.
    lagrange = element.block_size == gdim and element.family_name == "P" and not element.discontinuous
    if not lagrange:
        kind = (
            "discontinuous" if element.block_size == gdim and element.family_name == "P" else "not of Lagrange's kind"
        )
        raise ValueError(f"the space of u is {kind} ({element}): a displacement needs a continuous one; use {needed}")


def _no_body(tdim: int, gdim: int, needed_by: str) -> str:
    """A sentence on what a mesh of bars or surfaces cannot have, and what works."""
    kind = "bars, trusses and beams" if tdim < 2 else "shells and membranes"
    what = f"the mesh of u has cells of dimension {tdim} in {gdim} dimension{'s' if gdim > 1 else ''}, for {kind}"
    if needed_by == "loads":
        return f"{what}: loads=... do not act on it; write the load into the residual, as - ufl.inner(traction, v)*ds"
    if needed_by == "contact":
        return (
            f"{what}: contact=[...] needs the surface of a body, mesh the volume for it; contact with a rigid obstacle "
            "can be written into the residual as a penalty, - penalty*ufl.max_value(-gap, 0)*ufl.inner(normal, v)*dx"
        )
    return f"{what}: {needed_by} is that of a body; give a residual of your own and its density, or mesh the volume"


def _mixed(needed_by: str) -> str:
    """A sentence on what a mixed space cannot have."""
    if needed_by == "loads":
        return (
            "u is on a mixed space, on which loads=... do not act: write the load into the residual, with the "
            "displacement's test function v of ufl.TestFunctions(V), as - ufl.inner(traction, v)*ds"
        )
    if needed_by == "contact":
        return (
            "u is on a mixed space, on which contact=[...] is not supported: use a space of the displacement alone, "
            "with the pressure eliminated in each cell, p = bulk*ufl.cell_avg(ufl.div(u)) in explicit runs, or a "
            "material (J2Plasticity has B-bar and F-bar), or write the contact into the residual as a penalty"
        )
    return f"u is on a mixed space: {needed_by} needs a space of the displacement alone; or give a residual of your own"


def measures(form: ufl.Form) -> None:
    """Check the quadrature degrees and rules in the measures of a form.

    Args:
        form: UFL form.

    Raises:
        TypeError: a quadrature degree is not a number.
        ValueError: a quadrature degree is not an integer or too high, or a rule is unknown.
    """
    for integral in form.integrals():
        degree = integral.metadata().get("quadrature_degree")
        if degree not in (None, -1, "auto", "default"):
            integer("quadrature_degree", degree, 0, LARGEST_DEGREE)
        rule = integral.metadata().get("quadrature_rule")
        if rule not in (None, *RULES):
            raise ValueError(f"quadrature_rule is {rule!r}: use one of {', '.join(RULES)}")


def radii(hypothesis: str | None, mesh: Mesh) -> None:
    """Check that no node of an axisymmetric body has a negative radius x.

    Args:
        hypothesis: hypothesis of the material; meshes of other hypotheses than "axisymmetric" are not checked.
        mesh: mesh of the body.

    Raises:
        ValueError: a node has a negative radius.
    """
    if hypothesis != "axisymmetric":
        return
    x = mesh.geometry.x
    lowest = float(np.min(x[:, 0], initial=np.inf))
    if lowest < -ROUND_OFF * float(np.max(np.abs(x), initial=0.0)):
        number = int(np.count_nonzero(x[:, 0] < 0.0))
        raise ValueError(
            f"axisymmetric: x is the radius, but {number} nodes of the mesh have x < 0, down to {lowest:g}: move the "
            "mesh, or mesh the half with x >= 0 only"
        )


def tags(name: str, found: Any, mesh: Mesh, dim: int) -> None:
    """Check the mesh tags of a problem.

    Args:
        name: name of the argument, for the message.
        found: the argument.
        mesh: mesh of the displacement.
        dim: topological dimension that the tagged entities must have.

    Raises:
        TypeError: `found` is not a MeshTags object.
        ValueError: the tags are of entities of another dimension, or on another mesh.
    """
    if not hasattr(found, "find") or not hasattr(found, "topology"):
        raise TypeError(f"{name} must be dolfinx MeshTags, found {type(found).__name__}")
    if found.dim != dim:
        what = "cells" if dim == mesh.topology.dim else "facets"
        raise ValueError(f"{name} needs tags of {what} (dimension {dim}), found tags of dimension {found.dim}")
    if found.topology is not mesh.topology._cpp_object:
        raise ValueError(f"{name}: the tags are of another mesh than u: make them on u.function_space.mesh")


def boundary_values(name: str, bc: Any, V: FunctionSpace) -> None:
    """Check a Dirichlet condition on a space, on a subspace of it, or on an equal space of the same mesh.

    Args:
        name: name of the argument, for the message.
        bc: the argument.
        V: displacement space.

    Raises:
        TypeError: `bc` is not a DirichletBC.
        ValueError: the condition is on another mesh or on another space.
    """
    if not hasattr(bc, "dof_indices"):
        raise TypeError(f"{name} must hold DirichletBC objects of dolfinx, found {type(bc).__name__}")
    space = getattr(bc.function_space, "_cpp_object", bc.function_space)
    if space.mesh is not V.mesh._cpp_object:
        raise ValueError(f"{name}: a boundary condition is of another mesh than u: make it on u.function_space")
    own, other = V.dofmap, space.dofmap
    equal = (own.index_map.size_global, own.index_map_bs) == (other.index_map.size_global, other.index_map_bs)
    if not V._cpp_object.contains(space) and not equal:
        raise ValueError(f"{name}: a boundary condition is on another space than u: make it on u.function_space")


def value_of(bc: Any) -> list[Any]:
    """Value of a boundary condition in a form that can be compared between ranks.

    Args:
        bc: DirichletBC, or PrescribedMotion with its `bc` and `amplitude`.

    Returns:
        The constant, or the name of the value's type; the amplitude, None without one.
    """
    value = getattr(bc, "bc", bc).g
    return [getattr(value, "value", type(value).__name__), getattr(bc, "amplitude", None)]


def reference_points(points: Any, tdim: int, cell: str) -> FloatArray:
    """Check points in a reference cell.

    Args:
        points: the argument, (num_points, tdim) [1].
        tdim: topological dimension of the cell.
        cell: name of the cell.

    Returns:
        The points, (num_points, tdim), C-contiguous [1].

    Raises:
        TypeError: `points` are not numbers.
        ValueError: `points` have another shape, or one of them lies outside the cell.
    """
    try:
        points = np.asarray(points, dtype=float)
    except (TypeError, ValueError):
        raise TypeError(f"points must be numbers of shape (num_points, {tdim}), found {points!r:.60}") from None
    if points.ndim != 2 or points.shape[1] != tdim:
        raise ValueError(f"points have shape {points.shape}: (num_points, {tdim}) is needed, coordinates in the {cell}")
    simplex = cell in ("interval", "triangle", "tetrahedron")
    limits = [points, 1.0 - points] + ([1.0 - points.sum(axis=1, keepdims=True)] if simplex else [])
    lowest = np.min([np.min(limit, axis=1, initial=np.inf) for limit in limits], axis=0)
    outside = np.flatnonzero(~(lowest > -1e-9))  # nan as well
    if len(outside) and cell != "prism":
        raise ValueError(
            f"the point {points[outside[0]].tolist()} lies outside the reference {cell}, whose coordinates go from 0 "
            "to 1: points are given in each cell, not in space"
        )
    return np.ascontiguousarray(points)


def options(given: Any) -> None:
    """Check PETSc options.

    Args:
        given: the argument: None, or a dict from names without prefix to values.

    Raises:
        TypeError: `given` is not a dict.
        ValueError: a key is not the name of an option.
    """
    if given is None:
        return
    if not isinstance(given, dict):
        raise TypeError(f"options must be a dict of PETSc options, found {type(given).__name__}: {given!r:.60}")
    for key in given:
        if not isinstance(key, str) or not key or key.startswith("-"):
            raise ValueError(f"options: {key!r} is no name of a PETSc option: write it without dash and prefix")


def path(name: str, value: Any) -> None:
    """Check the name of a file or folder.

    Args:
        name: name of the argument, for the message.
        value: the argument.

    Raises:
        TypeError: `value` is neither a text nor a path.
        ValueError: `value` is empty.
    """
    if not isinstance(value, (str, os.PathLike)):
        raise TypeError(f"{name} must be the name of a file, found {type(value).__name__}")
    if not os.fspath(value):
        raise ValueError(f"{name} is empty: give the name of a file")
