# SPDX-License-Identifier: MIT
"""Residuals of a user's own: checks, and the part that depends on the velocity."""

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np
import ufl
from dolfinx.fem import Function
from mpi4py import MPI
from ufl.algorithms import expand_derivatives

from ..common.collective import common
from .cell_matrices import CellMatrices
from .fields import same_spaces

NAME = "the residual"
SAMPLE = 20  # cells of a rank that are tested for their resistance to rigid translations
# Resistance over the largest entry of a cell's matrix: what rounding leaves of none, and how much more hoops have.
NOISE, CLEAR = 1e-13, 1e3


def check_tangent(form: Any, u: Function) -> None:
    """Refuse a form that is not the tangent of a residual of the displacement, on this rank; for use under a guard.

    Args:
        form: the argument that a user gave.
        u: displacement function.

    Raises:
        TypeError: `form` is not a UFL form.
        ValueError: `form` is not of rank 2 on u's space, or is on another mesh.
    """
    if not isinstance(form, ufl.Form):
        raise TypeError(f"tangent must be a UFL form of rank 2, found {type(form).__name__}: {form!r:.80}")
    V, rank = u.function_space, len(form.arguments())
    if rank != 2:
        raise ValueError(f"tangent must have a test and a trial function, this form has rank {rank}")
    if not all(same_spaces(a.ufl_function_space(), V) for a in form.arguments()):
        raise ValueError("test and trial function of tangent must be on u.function_space")
    if any(d.ufl_cargo() is not V.mesh._cpp_object for d in form.ufl_domains()):
        raise ValueError("tangent is on another mesh than the displacement")


def check_residual(form: Any, u: Function, has_tangent: bool = False) -> None:
    """Refuse a form that is not a residual of the displacement, on this rank; for use under a guard (collective.py).

    Args:
        form: the argument that a user gave.
        u: displacement function.
        has_tangent: whether a tangent is given with it, so that it need not contain u.

    Raises:
        TypeError: `form` is not a UFL form.
        ValueError: `form` has no test function, a trial function or a test function of another space, does not contain
            u, or is on another mesh.
    """
    if not isinstance(form, ufl.Form):
        raise TypeError(f"residual must be a UFL form of rank 1, found {type(form).__name__}: {form!r:.80}")
    V = u.function_space
    try:
        arguments = form.arguments()
    except ValueError as e:
        raise ValueError(f"{NAME} has test functions of several spaces: use ufl.TestFunction(u.function_space)") from e
    if not arguments:
        raise ValueError(
            "residual must have a test function, this one has rank 0: of an energy take ufl.derivative(energy, u, v)"
        )
    if any(a.number() > 0 for a in arguments):
        raise ValueError(f"{NAME} has a TrialFunction: write it in the displacement u, linear or not")
    if len(arguments) > 1:
        raise ValueError(f"{NAME} has {len(arguments)} test functions: it must have one")
    domains = [d.ufl_cargo() for d in form.ufl_domains()]
    if any(d is None for d in domains):
        raise ValueError(f"{NAME} is on a symbolic mesh: use functions and constants of a DOLFINx mesh")
    functions = [c.function_space.mesh for c in form.coefficients() if hasattr(c, "function_space")]
    if any(d is not V.mesh._cpp_object for d in domains + [m._cpp_object for m in functions]):
        raise ValueError(f"{NAME} is on another mesh than the displacement, or on several")
    if not has_tangent and not any(c is u for c in form.coefficients()):
        points = [f for f in form.coefficients() if f.ufl_function_space().ufl_element().has_custom_quadrature]
        if points:
            raise ValueError(
                f"{NAME} does not contain the displacement u, but {points[0].name}, a function at quadrature points: "
                "without u it has no tangent, and no bound of the step. Give the derivative as tangent=, a form of "
                "rank 2 (docs: your own form), or write the law as a di.InelasticMaterial (docs: a material of your "
                "own)"
            )
        raise ValueError(f"{NAME} does not contain the displacement u: there is nothing to move")
    W = arguments[0].ufl_function_space()
    if not same_spaces(W, V):
        raise ValueError(
            f"the test function of {NAME} is of another space than u: use ufl.TestFunction(u.function_space)"
        )


@contextlib.contextmanager
def differentiable() -> Iterator[None]:
    """Context in which a residual is differentiated: what UFL cannot do is told, as it is on all ranks.

    Raises:
        ValueError: UFL does not know the derivative.
    """
    try:
        yield
    except NotImplementedError as error:
        raise common(
            ValueError(
                f"UFL cannot differentiate {NAME} ({error}): give its derivative as tangent=, a form of rank 2. On "
                "surfaces of quadrilaterals UFL does not know the gradient of ufl.CellNormal(mesh): write grad(r x n) "
                "as that of r alone, or mesh with triangles"
            )
        ) from error


def split(form: ufl.Form, velocity: Function) -> tuple[ufl.Form, ufl.Form | None]:
    """Split a residual F(u, v) into the sum of F(u, 0) and F(u, v) - F(u, 0).

    Args:
        form: UFL form of rank 1.
        velocity: the function v.

    Returns:
        F(u, 0), and the part that depends on the velocity, None without one. If F is linear in v, the second part is
        the derivative of F in the direction of v, without the terms that do not contain v.
    """
    if not any(c is velocity for c in form.coefficients()):
        return form, None
    zero = ufl.zero(velocity.ufl_shape) if velocity.ufl_shape else 0.0
    form = expand_derivatives(form)
    still = ufl.replace(form, {velocity: zero})
    direction = ufl.Coefficient(velocity.ufl_function_space())
    slope = expand_derivatives(ufl.derivative(form, velocity, direction))
    if not any(c is velocity for c in slope.coefficients()):
        return still, ufl.replace(slope, {direction: velocity})
    moving = [i for i in form.integrals() if velocity in ufl.algorithms.extract_coefficients(i.integrand())]
    moving = ufl.Form(moving)
    return still, moving - ufl.replace(moving, {velocity: zero})


def check_hypothesis(form: ufl.Form, u: Function, hypothesis: str | None, tangent: ufl.Form | None = None) -> None:
    """Refuse a residual on a plane mesh whose integrals do not belong to its hypothesis. Collective.

    A body of revolution resists a translation along the radius x[0] by its hoop strain, and has no resistance along its
    axis. A plane body resists neither translation.

    Args:
        form: the residual, its part without the velocity.
        u: displacement function.
        hypothesis: that of the problem; None, "axisymmetric", or another one, which ends the search for hoops.
        tangent: derivative of the residual, given with it; None: found by UFL.

    Raises:
        ValueError: the hypothesis and the integrals do not agree; on all ranks.
    """
    mesh = u.function_space.mesh
    axisymmetric = hypothesis == "axisymmetric"
    has_place = ufl.algorithms.analysis.has_type(form, ufl.SpatialCoordinate)
    solid = u.function_space.num_sub_spaces == mesh.geometry.dim == u.function_space.dofmap.bs
    if mesh.geometry.dim != 2 or not solid or not (axisymmetric or hypothesis is None and has_place):
        return
    cells = ufl.Form([i for i in (tangent or form).integrals() if i.integral_type() == "cell"])
    if tangent is None:
        cells = expand_derivatives(ufl.derivative(cells, u, ufl.TrialFunction(u.function_space)))
    if cells.empty():
        return
    matrices = CellMatrices(u, cells, ())
    radial, axial = (matrices.resistance(np.array(e), SAMPLE) for e in ((1.0, 0.0), (0.0, 1.0)))
    # Of a thin ring without Poisson's ratio, hoops resist by the square of its thickness over its radius.
    hoops = radial > np.maximum(NOISE, CLEAR * axial)
    everywhere = mesh.comm.allreduce(bool(np.all(hoops)), MPI.LAND)
    anywhere = mesh.comm.allreduce(bool(np.any(radial > NOISE)), MPI.LOR)
    if axisymmetric and not anywhere:
        raise ValueError(
            f"the hypothesis is axisymmetric, but {NAME} does not resist a widening of its hoops: its integrals need "
            "the hoop strain u_r/r and the weight 2 pi r, or another hypothesis"
        )
    if not axisymmetric and everywhere and anywhere:
        raise ValueError(
            f"{NAME} looks axisymmetric: its integrals depend on the place, a motion along x[0] strains every cell. "
            "Give hypothesis='axisymmetric' (masses and areas get 2 pi r), or 'plane_strain' if it is not"
        )
