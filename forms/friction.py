# SPDX-License-Identifier: MIT
"""Laws of friction in UFL: Coulomb's coefficient at a contact point, made into a form of one point.

A law sees the contact pressure p, the slip velocity v (of the slave relative to the master, along the surface), the
unit normal n out of the master, and fields of both sides. It returns the coefficient mu of |t| <= mu p, which the
contact fulfils exactly, by multipliers or by the kinematic method; laws of the interface (interface.py) have springs.

As there, a law becomes a form on an interval with one quadrature point. Its outputs are the coefficient and its
derivatives by pressure and slip velocity; those that are zero are left out.
"""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any, Protocol

import ufl
from ufl.algorithms import expand_derivatives
from ufl.constantvalue import Zero

from .interface import DERIVATIVE, check_inputs, plain, point_function, point_mesh
from .point_law import PointLaw


class FrictionResponse(Protocol):
    """What kernels ask of a law of friction."""

    def coefficient(self, point: Any) -> Any:
        """Coulomb's coefficient of a point in UFL.

        Args:
            point: has the attributes `pressure` [F/L^2], `slip_rate`, (gdim) [L/T], `normal`, (gdim), `fields` and
                `parameters`, the last two by names.
        """
        ...


class FrictionForm:
    """The kernel's form of a law of friction, and the names of its functions.

    Args:
        law: the law.
        gdim: dimension of space [1].
        fields: names of fields; a law sees each of them on both sides, `NAME_slave` and `NAME_master`.
        parameters: names of constants.

    Attributes:
        form: the form, of rank 0; its value does not count.
        point_law: outputs.
        names: names of coefficients and constants for kernels.
        parameters: UFL constants by name.

    Raises:
        ValueError: the coefficient is no scalar, or contains functions that are no inputs of the law.
    """

    def __init__(
        self, law: FrictionResponse, gdim: int, fields: tuple[str, ...] = (), parameters: tuple[str, ...] = ()
    ) -> None:
        mesh = point_mesh()
        inputs = {name: point_function(mesh, (gdim,) if name != "pressure" else ()) for name in INPUTS}
        values = {f"{name}_{side}": point_function(mesh, ()) for name in fields for side in ("slave", "master")}
        self.parameters = {name: ufl.Constant(mesh) for name in parameters}
        point = SimpleNamespace(
            **inputs, fields=SimpleNamespace(**values), parameters=SimpleNamespace(**self.parameters)
        )
        coefficient = ufl.as_ufl(law.coefficient(point))
        if coefficient.ufl_shape:
            raise ValueError(f"a coefficient of friction is a number, found the shape {coefficient.ufl_shape}")
        outputs = {"coefficient": coefficient}
        for name in ("pressure", "slip_rate"):
            variable = ufl.variable(inputs[name])
            found = expand_derivatives(ufl.diff(ufl.replace(coefficient, {inputs[name]: variable}), variable))
            if not isinstance(found, Zero):
                outputs[DERIVATIVE + name] = found
        outputs = {name: plain(value) for name, value in outputs.items()}
        check_inputs(outputs.values(), {**inputs, **values}.values(), self.parameters.values())
        self.point_law = PointLaw(outputs=outputs)
        self.form = inputs["pressure"] * ufl.dx(domain=mesh, degree=0)
        self.names = {c: name for name, c in {**inputs, **values}.items()}
        self.names |= {c: name for name, c in self.parameters.items()}


INPUTS = ("pressure", "slip_rate", "normal")
