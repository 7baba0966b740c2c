# SPDX-License-Identifier: MIT
"""Laws of the interface in UFL: pressure and shear traction at a contact point, made into a form of one point.

A law sees a point of the slave and its projection on the master: the gap g, the slip s (tangential displacement of the
slave relative to the master), their rates, the unit normal n out of the master, fields of both sides, and internal
variables. It returns the contact pressure p (positive in compression) and the shear traction t on the slave. The
traction on the slave is p n + t, that on the master its opposite.

Vectors have components of space, so that an expression of dot products is objective: nothing refers to a frame of the
surface. A direction of the material is projected with the normal.

Kernels know nothing of contact. A law becomes a form on an interval with one quadrature point, whose coefficients are
what the law sees and whose outputs (point_law.py) are what it returns, with all derivatives that Newton's method needs:

    d(p, t)/dx   for each x of gap, slip, gap rate, slip rate, normal and tangential history,

of the converged local unknowns where the law has some: dx'/dx = -(dr/dx')^-1 dr/dx (consistent_tangent.py). Derivatives
that are zero have no output.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from types import SimpleNamespace
from typing import Any, Protocol

import basix.ufl
import ufl
from ufl.algorithms import expand_derivatives
from ufl.algorithms.transformer import strip_variables
from ufl.constantvalue import Zero

from .consistent_tangent import solve
from .inelastic import UNKNOWN
from .point_law import PointLaw

TANGENTIAL = "tangential"  # shape of a history that is a vector along the surface, and turns with it
DERIVATIVE = "derivative by "  # before the name of the input, in names of outputs


@dataclass
class InterfaceUpdate:
    """What a law of the interface returns at a point.

    Attributes:
        pressure: contact pressure, positive in compression [F/L^2].
        shear: traction on the slave along the surface, (gdim); its part along the normal does not count [F/L^2].
        energy: energy stored per area; what is left of the work of the traction is dissipated. None: not known, the
            work of the pressure counts as stored [F/L].
        shear_energy: without `energy`, the part of it that the shear traction stores; None: its work counts as stored
            [F/L].
        history: new internal variables by name.
        sticks: a condition that is true where the point sticks; None: a point sticks where the law has a traction.
        residual: residual of the local equations, of the shape of the unknown; None without unknowns.
        start: where Newton's method begins, of the shape of the unknown.
        scale: size of the terms of the residual.
    """

    pressure: Any
    shear: Any = None
    energy: Any = None
    shear_energy: Any = None
    history: dict[str, Any] = field(default_factory=dict)
    sticks: Any = None
    residual: Any = None
    start: Any = None
    scale: Any = 1.0


class InterfaceResponse(Protocol):
    """What kernels ask of a law of the interface.

    Attributes:
        history: shape of every internal variable by name: (), (n,) or TANGENTIAL; all are zero at first.
        unknown: shape of the unknown of the local equations, () or (n,); None: a law in closed form.
    """

    history: dict[str, Any]
    unknown: tuple[int, ...] | None

    def respond(self, point: Any) -> InterfaceUpdate:
        """Pressure and shear traction of a point.

        Args:
            point: has the attributes `gap` [L], `slip`, (gdim) [L], `gap_rate` [L/T], `slip_rate`, (gdim) [L/T],
                `normal`, (gdim), `history`, `unknown`, `fields` and `parameters`, the last three by names.
        """
        ...


def plain(expression: Any) -> Any:
    """An expression without derivatives and variables.

    Args:
        expression: UFL.
    """
    return strip_variables(expand_derivatives(expression))


def point_mesh() -> ufl.Mesh:
    """The interval whose only quadrature point stands for a contact point."""
    return ufl.Mesh(basix.ufl.element("Lagrange", "interval", 1, shape=(1,)))


def point_function(mesh: ufl.Mesh, shape: tuple[int, ...]) -> ufl.Coefficient:
    """A function with one value, at the point.

    Args:
        mesh: point_mesh.
        shape: of the value.
    """
    element = basix.ufl.quadrature_element("interval", value_shape=shape, degree=0, scheme="default")
    return ufl.Coefficient(ufl.FunctionSpace(mesh, element))


def check_inputs(expressions: Iterable[Any], functions: Iterable[Any], constants: Iterable[Any]) -> None:
    """Refuse functions and constants in expressions that are no inputs of a law.

    Args:
        expressions: of the law.
        functions: that are inputs.
        constants: that are parameters.

    Raises:
        ValueError: an expression contains another one.
    """
    functions, constants = list(functions), list(constants)
    for e in expressions:
        for c in ufl.algorithms.extract_coefficients(e):
            if c not in functions:
                name = getattr(c, "name", str(c))
                raise ValueError(f"the law contains the function {name}: give it in `fields`, by a name")
        for c in ufl.algorithms.analysis.extract_constants(e):
            if c not in constants:
                raise ValueError("the law contains a constant of a mesh: give its value in `parameters`, by a name")


class InterfaceForm:
    """The kernel's form of a law, and the names of its functions.

    Args:
        law: the law.
        gdim: dimension of space [1].
        fields: names of fields; a law sees each of them on both sides, `NAME_slave` and `NAME_master`.
        parameters: names of constants.

    Attributes:
        form: the form, of rank 0; its value does not count.
        point_law: outputs and history.
        names: names of coefficients and constants for kernels.
        parameters: UFL constants by name.

    Raises:
        TypeError: the law returns something else than an InterfaceUpdate.
        ValueError: shapes or names that do not fit, or functions that are no inputs of the law.
    """

    def __init__(
        self, law: InterfaceResponse, gdim: int, fields: tuple[str, ...] = (), parameters: tuple[str, ...] = ()
    ) -> None:
        self.gdim = gdim
        self._mesh = point_mesh()
        names = ("gap", "slip", "gap_rate", "slip_rate", "normal")
        vectors = ("slip", "slip_rate", "normal")
        inputs = {name: self._coefficient((gdim,) if name in vectors else ()) for name in names}
        sides = [f"{name}_{side}" for name in fields for side in ("slave", "master")]
        values = {name: self._coefficient(()) for name in sides}
        shapes = {name: (gdim,) if shape == TANGENTIAL else shape for name, shape in law.history.items()}
        history = {name: self._coefficient(shape) for name, shape in shapes.items()}
        unknown = None if law.unknown is None else self._coefficient(law.unknown)
        self.parameters = {name: ufl.Constant(self._mesh) for name in parameters}
        point = SimpleNamespace(
            **inputs,
            fields=SimpleNamespace(**values),
            history=SimpleNamespace(**history),
            parameters=SimpleNamespace(**self.parameters),
            unknown=unknown,
        )
        update = law.respond(point)
        if not isinstance(update, InterfaceUpdate):
            raise TypeError(f"the law returns {type(update).__name__}, not an InterfaceUpdate")
        known = {**inputs, **values, **{f"history {name}": c for name, c in history.items()}}
        known |= {} if unknown is None else {UNKNOWN: unknown}
        tangential = {name: history[name] for name, shape in law.history.items() if shape == TANGENTIAL}
        outputs = self._outputs(update, inputs | {f"history {n}": c for n, c in tangential.items()}, unknown)
        outputs |= self._history(update, shapes)
        # Variables have numbers that count up through a process, with which the same law had another signature.
        outputs = {name: plain(value) for name, value in outputs.items()}
        local = [ufl.as_ufl(e) for e in (update.residual, update.start, update.scale) if e is not None]
        check_inputs([*outputs.values(), *local], known.values(), self.parameters.values())
        self.point_law = PointLaw(
            outputs=outputs | ({} if unknown is None else {UNKNOWN: unknown}),
            history=history,
            unknown=unknown,
            residual=None if unknown is None else plain(ufl.as_ufl(update.residual)),
            start=None if unknown is None else plain(ufl.as_ufl(update.start)),
            scale=plain(ufl.as_ufl(update.scale)),
        )
        self.form = inputs["gap"] * ufl.dx(domain=self._mesh, degree=0)
        self.names = {c: name for name, c in {**inputs, **values}.items()}
        self.names |= {c: name for name, c in self.parameters.items()}

    def _coefficient(self, shape: tuple[int, ...]) -> ufl.Coefficient:
        return point_function(self._mesh, shape)

    def _outputs(self, update: InterfaceUpdate, inputs: Mapping[str, Any], unknown: Any) -> dict[str, Any]:
        """Pressure, shear traction, energy, state and derivatives by name."""
        pressure = ufl.as_ufl(update.pressure)
        shear = ufl.as_vector([0.0] * self.gdim) if update.shear is None else ufl.as_ufl(update.shear)
        if pressure.ufl_shape or shear.ufl_shape != (self.gdim,):
            raise ValueError(
                f"the law returns a pressure of shape {pressure.ufl_shape} and a shear traction of shape "
                f"{shear.ufl_shape}: they must be () and ({self.gdim},)"
            )
        out = {"pressure": pressure, "shear": shear}
        if update.energy is not None:
            out["energy"] = ufl.as_ufl(update.energy)
        elif update.shear_energy is not None:
            out["shear_energy"] = ufl.as_ufl(update.shear_energy)
        if update.sticks is not None:
            out["sticks"] = ufl.conditional(update.sticks, 1.0, 0.0)
        traction = [pressure, *(shear[c] for c in range(self.gdim))]
        for name, x in inputs.items():
            rows = [self._derivative(z, x, update, unknown) for z in traction]
            entries = [e for row in rows for e in row]
            if not all(isinstance(e, Zero) for e in entries):
                out[DERIVATIVE + name] = ufl.as_vector(entries)
        return out

    @staticmethod
    def _derivative(z: Any, x: Any, update: InterfaceUpdate, unknown: Any) -> list[Any]:
        """Derivatives of a scalar by the components of an input, through the local unknowns as well."""

        def by(expression: Any, what: Any) -> list[Any]:
            variable = ufl.variable(what)
            found = expand_derivatives(ufl.diff(ufl.replace(expression, {what: variable}), variable))
            return [found[i] for i in range(what.ufl_shape[0])] if what.ufl_shape else [found]

        entries = by(z, x)
        if unknown is None:
            return entries
        residual = ufl.as_ufl(update.residual)
        equations = [residual[i] for i in range(residual.ufl_shape[0])] if residual.ufl_shape else [residual]
        matrix = ufl.as_matrix([by(r, unknown) for r in equations])
        to_x, to_unknown = [by(r, x) for r in equations], by(z, unknown)
        for k in range(len(entries)):
            right = [row[k] for row in to_x]
            if all(isinstance(e, Zero) for e in right) or all(isinstance(e, Zero) for e in to_unknown):
                continue
            change = [right[0] / matrix[0, 0]] if len(right) == 1 else solve(matrix, right)
            entries[k] = entries[k] - sum(a * b for a, b in zip(to_unknown, change))
        return entries

    @staticmethod
    def _history(update: InterfaceUpdate, shapes: Mapping[str, tuple[int, ...]]) -> dict[str, Any]:
        """New internal variables."""
        if set(update.history) != set(shapes):
            raise ValueError(f"the law returns history {sorted(update.history)}, it has {sorted(shapes)}")
        out = {name: ufl.as_ufl(value) for name, value in update.history.items()}
        for name, value in out.items():
            if value.ufl_shape != shapes[name]:
                raise ValueError(f"history {name!r} is returned with shape {value.ufl_shape}, it has {shapes[name]}")
        return out
