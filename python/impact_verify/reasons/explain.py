# SPDX-License-Identifier: MIT
"""Fits a user's form by the parts of an operator, and says in words what is wrong with it."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from dolfinx_impact.assembly.jit import Compiled
from dolfinx_impact.common.types import FloatArray
from dolfinx_impact.forms import registry
from dolfinx_impact.forms.compiler.integrands import integrands
from .. import catalogue, element, nodes
from ..catalogue import Case
from ..nodes import TheirRule
from . import laws, numbers
from .sample import Sample, derivative, sample

CELLS = 4  # random ones for each set of constants: many more numbers than there are parts
FITS = 1e-9  # largest residual of a fit whose parts are the right ones, relative to the largest number


@dataclass
class _Observation:
    """What the user's form gives on one cell, with all that is needed to compute the same of other forms."""

    sample: Sample
    constants: Mapping[str, Any]
    u: FloatArray
    direction: FloatArray
    found: FloatArray
    expected: FloatArray


class Explanation:
    """Reasons for which a form differs from an operator.

    Args:
        case: name, cell, degree, geometry_degree and hypothesis of the operator.
        compiled: kernels of the user's form.
        names: names of its constants and coefficients.
        draws: two sets of values of the constants.
        integrals: integrals of the form, whose rules are read.
        theirs: rule of the other side by type of integral.
    """

    def __init__(
        self,
        case: Case,
        compiled: Compiled,
        names: Any,
        draws: Sequence[Mapping[str, Any]],
        integrals: Sequence[Any],
        theirs: Mapping[str, TheirRule],
    ) -> None:
        self.case, self.draws = case, draws
        self.name, self.cell, self.degree, self.geometry_degree, self.hypothesis = case
        self.dim = registry.CELLS[self.cell]
        self.law = self.name.split(".")[0] if self.name in registry.LAW_FORMS else ""
        self.observations: list[list[_Observation]] = []
        (kernel, *more) = compiled.kernels
        (integral, *_) = integrals
        (rule, _), *rules = integrands(integral.ir)
        self.rank: int = kernel.rank
        self.usable = not more and not rules and not self.name.startswith("poisson")
        if self.usable:
            facet = None if kernel.integral_type == "cell" else 0
            their_rule = theirs.get(kernel.integral_type)
            self._observe(kernel, compiled, names, rule, their_rule, facet)

    def _observe(
        self, kernel: Any, compiled: Compiled, names: Any, rule: Any, theirs: TheirRule, facet: int | None
    ) -> None:
        rng = np.random.default_rng(2026)
        order = nodes.dofs(self.cell, self.degree, self.dim)
        geometry = nodes.permutation(self.cell, self.geometry_degree)
        vertices = None if facet is None else nodes.facet_vertices(self.cell, facet)
        for constants in self.draws:
            rows = []
            for _ in range(CELLS):
                X = nodes.random_cell(rng, self.cell, self.geometry_degree, self.hypothesis)
                size = 0.08 / self.degree**2 * np.ptp(X, axis=0).min()
                u, d = (size * rng.uniform(-1, 1, len(order)) for _ in range(2))
                fields = {name: u for name in ("u", "velocity", "acceleration")}
                w, c = element.pack(kernel, compiled, names, constants, fields)
                found = element.tabulate(kernel, [X], [w], c, facet or 0, 1)[0]
                mine = {name: nodes.to_theirs(values, order) for name, values in fields.items()}
                tensor = catalogue.evaluate(
                    self.name, self.case[1:], nodes.to_theirs(X, geometry), constants, mine, theirs, vertices
                )
                for _ in range(self.rank):
                    tensor = np.moveaxis(tensor, 0, -1)[..., order]
                if self.rank == 2:  # a tangent is compared by its product with one direction
                    found, tensor = found.reshape(kernel.shape) @ d, tensor @ d
                points = sample(self.cell, self.degree, self.geometry_degree, X, rule, facet)
                rows.append(_Observation(points, constants, u, d, np.ravel(found), np.ravel(tensor)))
            self.observations.append(rows)

    # --- fits ------------------------------------------------------------------------------------------------------

    def _fit(self, columns: Callable[[_Observation], Mapping[str, FloatArray]]) -> dict[str, FloatArray] | None:
        """Factors of parts in each draw; None where the form is no sum of them."""
        out: dict[str, list[float]] = {}
        for rows in self.observations:
            y = np.concatenate([o.found for o in rows])
            parts = [columns(o) for o in rows]
            names = list(parts[0])
            A = np.column_stack([np.concatenate([p[name] for p in parts]) for name in names])
            if not np.all(np.isfinite(A)):
                return None
            sizes = np.maximum(np.abs(A).max(axis=0), 1e-300)
            factors = np.linalg.lstsq(A / sizes, y, rcond=1e-10)[0] / sizes
            if not np.abs(A @ factors - y).max() <= FITS * np.abs(y).max():
                return None
            for name, factor in zip(names, factors):
                out.setdefault(name, []).append(float(factor))
        return {name: np.array(values) for name, values in out.items()}

    def _column(self, o: _Observation, stress: Any, hoop: bool, weight: FloatArray) -> FloatArray:
        """Forces, or their change in the direction, of one part of a stress."""
        H = o.sample.gradient(o.u, hoop)
        if self.rank == 2:
            return o.sample.forces(derivative(stress, H, o.sample.gradient(o.direction, hoop)), hoop, weight)
        return o.sample.forces(np.real(stress(H + 0j)), hoop, weight)

    def _parts(self, o: _Observation, hoop: bool, weight: FloatArray) -> dict[str, FloatArray]:
        """Columns of the parts of the right law."""
        c = self._moduli(o.constants)
        if self.rank == 0:
            H = o.sample.gradient(o.u, hoop)
            energies = laws.energy_parts(self.law, c)
            return {n: np.array([np.sum(o.sample.weights * weight * W(H))]) for n, W in energies.items()}
        return {n: self._column(o, stress, hoop, weight) for n, stress in laws.RIGHT[self.law](c).items()}

    def _moduli(self, c: Mapping[str, Any]) -> Mapping[str, Any]:
        """Constants; lambda is that of the plane in plane stress."""
        if self.hypothesis != "plane_stress":
            return c
        return {**c, "lambda": 2 * c["lambda"] * c["mu"] / (c["lambda"] + 2 * c["mu"])}

    # --- words -----------------------------------------------------------------------------------------------------

    def text(self) -> str:
        """Why the form differs; an empty text where no part that is known explains it."""
        if not self.usable:
            return ""
        found = self._fit(lambda o: {"all": o.expected})
        if found is not None:
            return numbers.scale(found["all"], self.draws, self.name, bool(self.law), self.rank)
        if self.law and (self.law == "linear_elastic" or self.hypothesis != "plane_stress"):
            return self._text_of_law()
        if self.name.startswith("follower_pressure") and self.rank == 1:
            return self._text_of_pressure()
        if self.name in ("mass", "mass_action"):
            return self._text_of_mass()
        return ""

    def _measures(self) -> list[tuple[str, bool, Callable[[Sample], FloatArray]]]:
        """What is wrong with the measure or the hoop strain, whether there is a hoop strain, and the weight."""
        one: tuple[str, bool, Callable[[Sample], FloatArray]] = ("", False, lambda s: np.ones(len(s.weights)))
        if self.hypothesis != "axisymmetric":
            return [one]

        def ring(s: Sample) -> FloatArray:
            return 2 * np.pi * s.x[:, 0]

        return [
            ("", True, ring),
            ("the hoop strain u_r/r is missing", False, ring),
            ("2 pi is missing in the measure", True, lambda s: s.x[:, 0]),
            ("2 pi and the hoop strain u_r/r are missing", False, lambda s: s.x[:, 0]),
            ("the weight 2 pi r is missing in the measure", True, one[2]),
            ("the weight 2 pi r and the hoop strain u_r/r are missing: it is plane strain", False, one[2]),
        ]

    def _text_of_law(self) -> str:
        fits: list[tuple[str, str]] = []
        for wrong, hoop, weight in self._measures():
            found = self._fit(lambda o: self._parts(o, hoop, weight(o.sample)))
            if found is not None:
                words = numbers.parts_of_linear if self.law == "linear_elastic" else numbers.parts_of_finite
                fits.append((wrong, words(found, [self._moduli(c) for c in self.draws])))
        if fits:  # of several measures that fit, the one with which nothing else is wrong
            return "; ".join(text for text in min(fits, key=lambda texts: bool(texts[1])) if text)
        if self.rank == 0:
            return self._text_of_energy()
        for wrong, hoop, weight in self._measures():
            for candidate in laws.CANDIDATES[self.law]:
                found = self._fit(
                    lambda o: {
                        n: self._column(o, stress, hoop, weight(o.sample))
                        for n, stress in candidate.parts(self._moduli(o.constants)).items()
                    }
                )
                if found is not None and numbers.close(np.abs(found["all"]), 1.0):
                    sign = "the sign is wrong" if found["all"][0] < 0 else ""
                    return "; ".join(text for text in (wrong, sign, candidate.reason) if text)
            if self.rank == 2 and self.law != "linear_elastic":
                text = self._text_of_tangent(hoop, weight)
                if text:
                    return "; ".join(t for t in (wrong, text) if t)
        return self._text_with_values()

    def _text_of_energy(self) -> str:
        """Is it another energy of the volume?"""
        if self.law != "neo_hookean":
            return ""
        _, hoop, weight = self._measures()[0]
        for reason in laws.other_energies(self.draws[0]):

            def column(o: _Observation) -> dict[str, FloatArray]:
                density = laws.other_energies(o.constants)[reason](o.sample.gradient(o.u, hoop))
                return {"all": np.array([np.sum(o.sample.weights * weight(o.sample) * density)])}

            found = self._fit(column)
            if found is not None and numbers.close(found["all"], 1.0):
                return reason
        return ""

    def _text_of_tangent(self, hoop: bool, weight: Callable[[Sample], FloatArray]) -> str:
        """Is the geometric part missing, that of the stress which turns with the body, or the material one?"""

        def columns(o: _Observation) -> dict[str, FloatArray]:
            stress = laws.total(laws.RIGHT[self.law](self._moduli(o.constants)))
            H, change = (o.sample.gradient(a, hoop) for a in (o.u, o.direction))
            second = laws.inverse(laws.EYE + H) @ np.real(stress(H + 0j))
            turned = o.sample.forces(change @ second, hoop, weight(o.sample))
            whole = o.sample.forces(derivative(stress, H, change), hoop, weight(o.sample))
            return {"material": whole - turned, "geometric": turned}

        found = self._fit(columns)
        if found is None:
            return ""
        if numbers.close(found["geometric"], 0.0):
            return "the geometric tangent is missing: the part grad(du) S of the stress that turns with the body"
        if numbers.close(found["material"], 0.0):
            return "the material tangent is missing: only the stress that turns with the body is there"
        a, b = found["material"][0], found["geometric"][0]
        return f"the material tangent counts {a:.2f} times, the geometric one {b:.2f} times"

    def _text_with_values(self) -> str:
        """Is there a load, or a term in the value of u, beside the right form?"""
        weight = self._measures()[0][2]

        def columns(o: _Observation) -> dict[str, FloatArray]:
            values = o.direction if self.rank == 2 else o.u
            u = np.zeros((len(o.sample.weights), 3))
            u[:, : self.dim] = o.sample.N @ values.reshape(-1, self.dim)
            return {"right": o.expected, "value": o.sample.loads(u, weight(o.sample))}

        def with_load(o: _Observation) -> dict[str, FloatArray]:
            f = np.zeros((len(o.sample.weights), 3))
            f[:, : self.dim] = np.ravel(o.constants["f"])[: self.dim]
            return {"right": o.expected, "load": o.sample.loads(f, weight(o.sample))}

        if self.rank == 1 and self._fit(with_load) is not None:
            return "there is a body force beside the operator: loads are operators of their own (body_force)"
        found = self._fit(columns)
        if found is None or not numbers.close(found["right"], 1.0):
            return ""
        return f"there is a term in the value of u beside the operator, {found['value'][0]:.3g} inner(u, v): a spring"

    def _text_of_pressure(self) -> str:
        weights = [w for _, hoop, w in self._measures() if hoop or self.hypothesis != "axisymmetric"]

        def load(kind: str, weight: Callable[[Sample], FloatArray]) -> Callable[[_Observation], dict[str, FloatArray]]:
            def columns(o: _Observation) -> dict[str, FloatArray]:
                F = laws.EYE + o.sample.gradient(o.u, self.hypothesis == "axisymmetric")
                inverse, J = laws.inverse(F), laws.determinant(F)[:, :, 0]
                N = o.sample.normal
                t = {"transpose": J * np.einsum("qij,qj->qi", inverse, N), "dead": N,
                     "det": np.einsum("qji,qj->qi", inverse, N)}[kind]  # fmt: skip
                return {"all": o.sample.loads(float(o.constants["p"]) * t, weight(o.sample))}

            return columns

        for kind, reason in (
            ("transpose", "a transpose is missing: J F^-1 N stands in the place of J F^-T N (Nanson)"),
            ("det", "det F is missing: F^-T N stands in the place of J F^-T N (Nanson)"),
            ("dead", "the pressure does not follow the surface: N is the normal of the undeformed body"),
        ):
            for weight in weights:
                if self._fit(load(kind, weight)) is not None:
                    return reason
        return ""

    def _text_of_mass(self) -> str:
        for wrong, hoop, weight in self._measures():

            def columns(o: _Observation) -> dict[str, FloatArray]:
                values = o.direction if self.rank == 2 else o.u
                u = np.zeros((len(o.sample.weights), 3))
                u[:, : self.dim] = o.sample.N @ values.reshape(-1, self.dim)
                return {"all": float(o.constants["density"]) * o.sample.loads(u, weight(o.sample))}

            found = self._fit(columns) if wrong and hoop else None
            if found is not None:
                rest = numbers.scale(found["all"], self.draws, self.name, False, self.rank)
                return "; ".join(text for text in (wrong, rest) if text)
        return ""
