# SPDX-License-Identifier: MIT
"""Speed of hyperelastic laws of a user's own, derivatives of energies in UFL, against the package's neo-Hookean law.

Both are measured in turn in one process. The energies are those of Holzapfel (2000), Nonlinear solid mechanics, chapter
6, of the deformation gradient F, per reference volume; their parameters are numbers without a meaning.
"""

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any, TypeAlias

import numpy as np
import ufl
from dolfinx import cpp

from dolfinx_impact import materials
from dolfinx_impact.assembly import operators
from dolfinx_impact.assembly.ffcx_form import ffcx_form
from .rows import Job, Row, row
from .setup import Case, Setup, best_time

Energy: TypeAlias = Callable[[Any], Any]
SHEAR, BULK = 385.0, 833.0  # [F/L^2]
ROUNDS = 5
# Less than half as many cells as elsewhere: forces of two kernels on one mesh are compared, which are bound by
# arithmetic. Ratios agree within 4 % with those of 22 and 50 cells along a side.
CASES: tuple[Case, ...] = (("tetrahedron", 2, 16), ("hexahedron", 1, 36))
# Round-off of forces whose terms are larger than they, in two orders of the algebra.
TOLERANCE = 1e-11


def _invariants(F: Any) -> tuple[Any, Any, Any]:
    """First two invariants of the isochoric part of C = F^T F, and J = det F."""
    C, J = F.T * F, ufl.det(F)
    first, second = ufl.tr(C), (ufl.tr(C) ** 2 - ufl.tr(C * C)) / 2
    return J ** (-2 / 3) * first, J ** (-4 / 3) * second, J


def _volumetric(J: Any) -> Any:
    return BULK / 2 * (J - 1) ** 2


def saint_venant(F: Any) -> Any:
    E = (F.T * F - ufl.Identity(3)) / 2
    return BULK / 2 * ufl.tr(E) ** 2 + SHEAR * ufl.inner(E, E)


def isochoric_neo_hookean(F: Any) -> Any:
    first, _, J = _invariants(F)
    return SHEAR / 2 * (first - 3) + _volumetric(J)


def mooney_rivlin(F: Any) -> Any:
    first, second, J = _invariants(F)
    return SHEAR / 4 * (first - 3) + SHEAR / 4 * (second - 3) + _volumetric(J)


def yeoh(F: Any) -> Any:
    first, _, J = _invariants(F)
    return SHEAR / 2 * (first - 3) + 20 * (first - 3) ** 2 + 3 * (first - 3) ** 3 + _volumetric(J)


def gent(F: Any) -> Any:
    first, _, J = _invariants(F)
    return -15 * SHEAR * ufl.ln(1 - (first - 3) / 30) + BULK / 2 * ((J**2 - 1) / 2 - ufl.ln(J))


def arruda_boyce(F: Any) -> Any:
    first, _, J = _invariants(F)
    terms = ((1, 1 / 2), (2, 1 / 160), (3, 11 / 67200), (4, 19 / 3584000), (5, 519 / 2759680000))
    return SHEAR * sum(c * (first**k - 3**k) for k, c in terms) + BULK / 2 * ((J**2 - 1) / 2 - ufl.ln(J))


def compressible_ogden(F: Any) -> Any:
    """Foam of one term with a real exponent of J."""
    J = ufl.det(F)
    return SHEAR / 2 * (ufl.tr(F.T * F) - 3 + (J**-0.72 - 1) / 0.36)


def fung(F: Any) -> Any:
    E, J = (F.T * F - ufl.Identity(3)) / 2, ufl.det(F)
    axial = 2 * E[0, 0] ** 2 + 1.5 * E[1, 1] ** 2 + E[2, 2] ** 2 + 0.5 * E[0, 0] * E[1, 1]
    return 50 * (ufl.exp(axial + 3 * E[0, 1] ** 2 + 2 * E[1, 2] ** 2 + E[0, 2] ** 2) - 1) + _volumetric(J)


def holzapfel(F: Any) -> Any:
    """Two families of fibres that bear tension only (Holzapfel, Gasser & Ogden 2000)."""
    first, _, J = _invariants(F)
    energy = SHEAR / 2 * (first - 3) + _volumetric(J)
    for side in (0.6, -0.6):
        along = F * ufl.as_vector([0.8, side, 0.0])
        stretch = J ** (-2 / 3) * ufl.dot(along, along) - 1
        energy += 25 * ufl.conditional(ufl.gt(stretch, 0), ufl.exp(2 * stretch**2) - 1, 0)
    return energy


def ogden(F: Any) -> Any:
    """Three terms of the isochoric principal stretches (Ogden 1972; parameters of his fit to rubber).

    Their squares are the roots of the characteristic polynomial of C by the formula with a cosine (Smith 1961). Where
    two of them are equal, its angle has no derivative; a margin keeps it from there.
    """
    C, J, margin = F.T * F, ufl.det(F), 1e-7
    mean = ufl.tr(C) / 3
    B = C - mean * ufl.Identity(3)
    size = ufl.sqrt(ufl.inner(B, B) / 6 + margin**2)
    cosine = ufl.max_value(ufl.min_value(ufl.det(B) / (2 * size**3), 1 - margin), margin - 1)
    angle = ufl.acos(cosine) / 3
    squares = [J ** (-2 / 3) * (mean + 2 * size * ufl.cos(angle + 2 * np.pi * k / 3)) for k in range(3)]
    energy = _volumetric(J)
    for modulus, exponent in ((630.0, 1.3), (1.2, 5.0), (-10.0, -2.0)):
        energy += modulus / exponent * (sum(square ** (exponent / 2) for square in squares) - 3)
    return energy


LAWS: tuple[Energy, ...] = (
    saint_venant, isochoric_neo_hookean, mooney_rivlin, yeoh, gent, arruda_boyce, compressible_ogden, fung, holzapfel,
    ogden,
)  # fmt: skip


def law_rows(energies: Sequence[Energy] = LAWS, cases: Sequence[Case] = CASES, rounds: int = ROUNDS) -> list[Row]:
    """Measure forces that are derivatives of energies against those of the neo-Hookean law of the package.

    Args:
        energies: functions of the deformation gradient.
        cases: cell, degree and cells per side.
        rounds: number of rounds of both, of which the best counts.

    Returns:
        Rows.

    Raises:
        RuntimeError: a force differs from that of FFCx's kernel.
    """
    rows = []
    for cell, degree, n in cases:
        setup = Setup(cell, degree, n, materials.NeoHookean)
        neo = operators.InternalForce(setup.form)
        (measure,) = {i.metadata()["quadrature_degree"] for i in setup.form.integrals()}
        dx, test = ufl.dx(metadata={"quadrature_degree": measure}), ufl.TestFunction(setup.V)
        for energy in energies:
            F = ufl.Identity(3) + ufl.grad(setup.u)
            form = ufl.derivative(energy(F) * dx, setup.u, test)
            own = operators.InternalForce(form)
            _check(setup, form, own, f"{energy.__name__}, {cell} P{degree}")
            calls = [partial(operator._cpp_object.assemble, setup.b) for operator in (own, neo)]
            times = [[best_time(call, rounds=1)[0] for call in calls] for _ in range(rounds)]
            rate, baseline = setup.num_cells / np.min(times, axis=0) * 1e-6
            label = f"{energy.__name__} force / neo_hookean"
            rows.append(row(label, f"{cell} P{degree}", 1, rate, "million cells/s", baseline))
    return rows


def _check(setup: Setup, form: ufl.Form, own: operators.InternalForce, what: str) -> None:
    """RuntimeError unless the force is that of FFCx's kernel."""
    reference, found = np.zeros_like(setup.b), np.zeros_like(setup.b)
    compiled = ffcx_form(form)._cpp_object
    constants, coefficients = cpp.fem.pack_constants(compiled), cpp.fem.pack_coefficients(compiled)
    cpp.fem.assemble_vector(reference, compiled, constants, coefficients)
    own.assemble(found)
    difference = np.max(np.abs(found - reference)) / np.max(np.abs(reference))
    if not difference < TOLERANCE:
        raise RuntimeError(f"{what}: the force differs from FFCx's by {difference:.1e}: no timing counts")


def jobs() -> list[Job]:
    """Measurements of laws of a user's own.

    Returns:
        A text and a function that returns rows, for each measurement.
    """
    return [
        (f"{energy.__name__}, {case[0]} P{case[1]}", partial(law_rows, (energy,), (case,)))
        for case in CASES
        for energy in LAWS
    ]
