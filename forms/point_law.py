# SPDX-License-Identifier: MIT
"""Laws with internal variables: history at quadrature points, and local equations that are solved at each point.

A form contains the law's stress as an ordinary UFL expression, of the strain, of the history and of the local unknowns
x. A PointLaw says the rest: what the new history is, and the equations r(x; strain, history) = 0 that define x. A
kernel of both evaluates the form and writes the new history in one pass.

    p_n = ufl.Coefficient(Q)                            # equivalent plastic strain of the last step
    dp = ufl.Coefficient(Q)                             # its increment, the local unknown
    law = PointLaw({"p": p_n + dp}, history={"p": p_n}, unknown=dp, residual=..., start=ufl.zero())
    kernels = compile_form(F, law=law)

Closed-form laws have no unknown.
"""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field

import numpy as np
import ufl
from ufl.algorithms import expand_derivatives
from ufl.core.expr import Expr

from .reference_derivatives import constants_for_positions


def flatten(expression: Expr) -> list[Expr]:
    """Components of an expression of any shape, the last index fastest."""
    if not expression.ufl_shape:
        return [expression]
    return [expression[index] for index in np.ndindex(*expression.ufl_shape)]


def _size(shape: Sequence[int]) -> int:
    return int(np.prod(shape, dtype=int))


def _element(coefficient: ufl.Coefficient):
    return coefficient.ufl_function_space().ufl_element()


def stored_components(coefficient: ufl.Coefficient) -> list[int]:
    """Flat component of the value that each stored value of a coefficient is: all, or those of a symmetric tensor that
    differ."""
    if getattr(_element(coefficient), "is_symmetric", False):
        n = coefficient.ufl_shape[0]
        return [n * i + j for i in range(n) for j in range(i + 1)]
    return list(range(_size(coefficient.ufl_shape)))


def _is_expression(thing: object) -> bool:
    return isinstance(thing, Expr)


@dataclass(frozen=True, eq=False)
class PointLaw:
    """Internal variables of a form, at the points of its quadrature rule.

    The scale decides when the local equations are solved: |r_i| <= 1e-12 scale for each of them. It is the size of the
    terms that r is the sum of, the yield stress for a yield condition in stresses: round-off leaves some 1e-16 of it.

    Args:
        outputs: new values at the points by name; those of the history and others.
        history: coefficients on quadrature elements that stand for the committed values of the outputs of these names.
        unknown: coefficient on a quadrature element, scalar or vector, that stands for the solution x of the local
            equations; None: a law in closed form.
        residual: r(x; ...), of the shape of the unknown.
        start: first iterate, of the shape of the unknown; it must not depend on the unknown.
        scale: size of the residual's terms, a number or an expression that does not depend on the unknown, of the
            residual's unit.
        sums: densities that are integrated over each cell and summed, by name, with the weight and |det J| of the
            form's rule; an axisymmetric density holds 2 pi r itself.
        start_error: bound of the distance of the first iterate of a scalar unknown from the solution, in units of the
            residual, whose derivative is about one in size; where it is below round-off of the scale, the first iterate
            is taken and the equations are not evaluated. None: it is not known.

    Raises:
        TypeError: an argument is no UFL expression or coefficient.
        ValueError: shapes or names do not fit, an element is no quadrature element, or residual and start are missing.
    """

    outputs: Mapping[str, Expr]
    history: Mapping[str, ufl.Coefficient] = field(default_factory=dict)
    unknown: ufl.Coefficient | None = None
    residual: Expr | None = None
    start: Expr | None = None
    scale: Expr | float = 1.0
    sums: Mapping[str, Expr] = field(default_factory=dict)
    start_error: Expr | None = None

    def __post_init__(self) -> None:
        for name, expression in self.outputs.items():
            if not _is_expression(expression):
                raise TypeError(f"output {name!r} must be a UFL expression, found {type(expression).__name__}")
        for name, coefficient in self.history.items():
            self._check_coefficient(f"history {name!r}", coefficient)
            if name not in self.outputs:
                raise ValueError(f"history {name!r} has no output of its name: the outputs are {sorted(self.outputs)}")
            if self.outputs[name].ufl_shape != coefficient.ufl_shape:
                raise ValueError(
                    f"output {name!r} has shape {self.outputs[name].ufl_shape}, its history "
                    f"{coefficient.ufl_shape}: they must be the same"
                )
        if len(set(self.history.values())) != len(self.history):
            raise ValueError("two names of the history have the same coefficient")
        self._check_unknown()
        for name, density in self.sums.items():
            if not _is_expression(density):
                raise TypeError(f"sum {name!r} must be a UFL expression, found {type(density).__name__}")
            if density.ufl_shape:
                raise ValueError(f"sum {name!r} must be of a scalar density, found shape {density.ufl_shape}")
        if not self.outputs and not self.sums:
            raise ValueError("a point law needs an output or a sum")

    @staticmethod
    def _check_coefficient(what: str, coefficient: object) -> None:
        if not isinstance(coefficient, ufl.Coefficient):
            raise TypeError(f"{what} must be a coefficient, found {type(coefficient).__name__}")
        if not _element(coefficient).has_custom_quadrature:
            raise ValueError(f"{what} must be on a quadrature element (basix.ufl.quadrature_element)")

    def _check_unknown(self) -> None:
        if self.unknown is None:
            if any(e is not None for e in (self.residual, self.start, self.start_error)):
                raise ValueError("residual and start belong to an unknown: name the coefficient that stands for it")
            return
        self._check_coefficient("the unknown", self.unknown)
        if self.unknown in self.history.values():
            raise ValueError("the unknown cannot be history: give the history a coefficient of its own")
        if len(self.unknown.ufl_shape) > 1:
            raise ValueError(f"the unknown must be a scalar or a vector, found shape {self.unknown.ufl_shape}")
        for what, expression in (("residual", self.residual), ("start", self.start)):
            if not _is_expression(expression):
                raise TypeError(f"{what} must be a UFL expression, found {type(expression).__name__}")
            assert expression is not None
            if expression.ufl_shape != self.unknown.ufl_shape:
                raise ValueError(
                    f"{what} has shape {expression.ufl_shape}, the unknown {self.unknown.ufl_shape}: one equation and "
                    "one first value for each unknown"
                )
        scale = ufl.as_ufl(self.scale)
        if scale.ufl_shape:
            raise ValueError(f"scale must be one number, found shape {scale.ufl_shape}")
        if self.start_error is not None and (self.unknown.ufl_shape or self.start_error.ufl_shape):
            raise ValueError("the start has an error of one number where the unknown is one number")
        error = ufl.zero() if self.start_error is None else self.start_error
        for what, expression in (("start", self.start), ("scale", scale), ("start_error", error)):
            if self.unknown in ufl.algorithms.extract_coefficients(expression):
                raise ValueError(f"{what} must not depend on the unknown")

    @property
    def num_unknowns(self) -> int:
        """Number of local unknowns at a point."""
        return 0 if self.unknown is None else _size(self.unknown.ufl_shape)

    def jacobian(self) -> list[Expr]:
        """Derivatives of the residual by the unknowns, rows first; empty without an unknown."""
        if self.unknown is None:
            return []
        assert self.residual is not None
        x, constants = ufl.variable(self.unknown), constants_for_positions(self.residual)
        derivative = ufl.diff(ufl.replace(self.residual, {self.unknown: x, **constants}), x)
        if constants:
            derivative = ufl.replace(expand_derivatives(derivative), {c: e for e, c in constants.items()})
        return flatten(derivative)

    def stored(self, name: str) -> list[Expr]:
        """Components of an output that are stored at each point: of symmetric history, each value once."""
        components = flatten(self.outputs[name])
        coefficient = self.history.get(name)
        return components if coefficient is None else [components[i] for i in stored_components(coefficient)]

    def parts(self) -> dict[str, list[Expr]]:
        """What a kernel evaluates: "start", "scale", "start_error", "residual", "jacobian", "output NAME" and
        "sum NAME"."""
        parts: dict[str, list[Expr]] = {}
        if self.unknown is not None:
            assert self.residual is not None and self.start is not None
            parts["start"] = flatten(self.start)
            parts["scale"] = [ufl.as_ufl(self.scale)]
            if self.start_error is not None:
                parts["start_error"] = [self.start_error]
            parts["residual"] = flatten(self.residual)
            parts["jacobian"] = self.jacobian()
        for name in self.outputs:
            parts[f"output {name}"] = self.stored(name)
        for name, density in self.sums.items():
            parts[f"sum {name}"] = [density]
        return parts

    def expressions(self) -> list[Expr]:
        """The expressions as given: what identifies the law, and what its coefficients are found in."""
        given = [*self.outputs.values(), *self.sums.values()]
        if self.unknown is not None:
            assert self.residual is not None and self.start is not None
            given += [self.residual, self.start, ufl.as_ufl(self.scale)]
            given += [] if self.start_error is None else [self.start_error]
        return given

    def coefficients(self) -> list[ufl.Coefficient]:
        """Coefficients that a kernel of the law reads: all but the unknown, by number."""
        found = {c for e in self.expressions() for c in ufl.algorithms.extract_coefficients(e)}
        found |= set(self.history.values())
        return sorted(found - {self.unknown}, key=lambda c: c.count())

    def constants(self) -> list[ufl.Constant]:
        """Constants of the law's expressions, by number."""
        found = {c for e in self.expressions() for c in ufl.algorithms.analysis.extract_constants(e)}
        return sorted(found, key=lambda c: c.count())
