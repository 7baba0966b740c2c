# SPDX-License-Identifier: MIT
"""Residuals of a user's own: checks, and the part that depends on the velocity."""

from typing import Any, Protocol

import numpy as np
import ufl
from dolfinx.fem import Function
from mpi4py import MPI
from ufl.algorithms import expand_derivatives

from ..common.types import FloatArray

NAME = "the residual"
SAMPLE = 20  # cells of a rank that are tested for their resistance to rigid translations


class CellTangents(Protocol):
    """Matrices of a bilinear form cell by cell, as dynamics.stable_step.CellMatrices provides them.

    Attributes:
        has_place: whether the form depends on the place (ufl.SpatialCoordinate).
    """

    has_place: bool

    def resistance(self, direction: FloatArray, count: int) -> FloatArray:
        """Relative resistance of cells to a translation.

        Args:
            direction: direction of the translation, (gdim) [1].
            count: largest number of cells that are tested.

        Returns:
            Largest force over the largest entry of the cell's matrix, (number of tested cells) [1].
        """


def check_residual(form: Any, u: Function) -> None:
    """Refuse a form that is not a residual of the displacement, on this rank; for use under a guard (collective.py).

    Args:
        form: the argument that a user gave.
        u: displacement function.

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
    if not any(c is u for c in form.coefficients()):
        raise ValueError(f"{NAME} does not contain the displacement u: there is nothing to move")
    W = arguments[0].ufl_function_space()
    if W.element != V.element or not np.array_equal(W.dofmap.list, V.dofmap.list):
        raise ValueError(
            f"the test function of {NAME} is of another space than u: use ufl.TestFunction(u.function_space)"
        )


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


def check_radius(tangent: CellTangents, u: Function, axisymmetric: bool) -> None:
    """Refuse a residual on a plane mesh whose integrals do not belong to its hypothesis. Collective.

    A body of revolution resists a translation along the radius x[0] by its hoop strain, and has no resistance along its
    axis. A plane body resists neither translation.

    Args:
        tangent: cell matrices of the derivative of the residual.
        u: displacement function.
        axisymmetric: whether the hypothesis of the problem is "axisymmetric".

    Raises:
        ValueError: the hypothesis and the integrals do not agree; on all ranks.
    """
    mesh = u.function_space.mesh
    if mesh.geometry.dim != 2:
        return
    radial, axial = tangent.resistance(np.array([1.0, 0.0]), SAMPLE), tangent.resistance(np.array([0.0, 1.0]), SAMPLE)
    hoops = [bool(len(radial)) and np.all(radial > 1e-8) and np.all(axial < 1e-10), np.any(radial > 1e-8)]
    everywhere = mesh.comm.allreduce(bool(hoops[0]) or not len(radial), MPI.LAND)
    anywhere = mesh.comm.allreduce(bool(hoops[1]), MPI.LOR)
    if axisymmetric and not anywhere:
        raise ValueError(
            f"the hypothesis is axisymmetric, but {NAME} does not resist a widening of its hoops: its integrals need "
            "the hoop strain u_r/r and the weight 2 pi r, or another hypothesis"
        )
    if not axisymmetric and everywhere and tangent.has_place:
        raise ValueError(
            f"{NAME} looks axisymmetric: its integrals depend on the place, a motion along x[0] strains every cell. "
            "Give hypothesis='axisymmetric' (masses and areas get 2 pi r), or 'plane_strain' if it is not"
        )
