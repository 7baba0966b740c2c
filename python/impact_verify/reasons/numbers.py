# SPDX-License-Identifier: MIT
"""Numbers that were found in a fit, named by what they are for every value of the constants."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, TypeAlias

import numpy as np

from dolfinx_impact.common.types import FloatArray

CLOSE = 1e-7  # fits are exact to 1e-9 and better where their parts are the right ones
Draws: TypeAlias = Sequence[Mapping[str, Any]]  # values of the constants, one set for each draw
Moduli: TypeAlias = Callable[[Mapping[str, Any]], float]

# Moduli that stand in the place of lambda.
IN_PLACE_OF_LAMBDA: tuple[tuple[str, Moduli], ...] = (
    ("lambda of plane stress, E nu/(1 - nu^2), that is 2 lambda mu/(lambda + 2 mu) or a (1 - nu) where (1 - 2 nu) "
     "should be", lambda c: 2 * c["lambda"] * c["mu"] / (c["lambda"] + 2 * c["mu"])),
    ("mu", lambda c: c["mu"]),
    ("2 mu", lambda c: 2 * c["mu"]),
    ("the bulk modulus lambda + 2 mu/3", lambda c: c["lambda"] + 2 * c["mu"] / 3),
    ("Young's modulus E", lambda c: c["E"]),
    ("E/(1 - 2 nu)", lambda c: c["E"] / (1 - 2 * c["nu"])),
    ("E nu/(1 + nu)", lambda c: c["E"] * c["nu"] / (1 + c["nu"])),
    ("E nu/(1 - 2 nu)", lambda c: c["E"] * c["nu"] / (1 - 2 * c["nu"])),
)  # fmt: skip
IN_PLACE_OF_MU: tuple[tuple[str, Moduli], ...] = (
    ("lambda", lambda c: c["lambda"]),
    ("Young's modulus E", lambda c: c["E"]),
    ("E/2", lambda c: c["E"] / 2),
    ("E/(1 - nu^2)/2", lambda c: c["E"] / (1 - c["nu"] ** 2) / 2),
    ("E/(1 - nu)/2", lambda c: c["E"] / (1 - c["nu"]) / 2),
)  # fmt: skip


def close(a: FloatArray, b: FloatArray | float) -> bool:
    """Whether numbers agree in all draws."""
    return bool(np.all(np.abs(a - b) <= CLOSE * np.maximum(np.abs(a), 1.0)))


def modulus(found: FloatArray, draws: Draws, known: Sequence[tuple[str, Moduli]]) -> str:
    """Name of a modulus.

    Args:
        found: its value in each draw.
        draws: constants of each draw.
        known: names and formulas.

    Returns:
        The name; an empty text if it is none of them.
    """
    for name, formula in known:
        if close(found / np.array([formula(c) for c in draws]), 1.0):
            return name
    return ""


def scale(s: FloatArray, draws: Draws, name: str, law: bool, rank: int) -> str:
    """What it means that a form is a number of times the right one.

    Args:
        s: the number, in each draw [1].
        draws: constants of each draw.
        name: operator.
        law: whether it is an operator of elasticity.
        rank: rank of the form.

    Returns:
        A sentence; an empty text if the number is one.
    """
    if close(s, 1.0):
        return ""
    if close(s, -1.0):
        return "the sign is wrong: the form is the operator with the opposite sign"
    if close(s, 4.0) and law:
        return (
            "every strain is twice too large: the 1/2 of sym(grad u) is missing (volumetric part 4.00 times, shear "
            "4.00 times)"
        )
    if close(s, 2.0) and rank == 0:
        return "the factor 1/2 of the energy is missing (2.00 times)"
    if close(s, 2 * np.pi):
        return "the form has a factor 2 pi too many"
    if close(s, 1 / (2 * np.pi)):
        return "the factor 2 pi of the circumference is missing (0.159 times)"
    symbols = {"density": "density", "k": "k", "p": "pressure p", "E": "Young's modulus E"}
    for key, text in symbols.items():
        values = np.array([float(np.ravel(c[key])[0]) for c in draws])
        if np.ptp(values) == 0.0:
            continue
        if close(s * values, 1.0):
            return f"the {text} is missing"
        if close(s / values, 1.0):
            return f"the {text} occurs once too often ({text} squared)"
    if np.ptp(s) <= CLOSE * abs(s[0]):
        return f"every entry is {s[0]:.6g} times that of the operator {name}: a factor is wrong or missing"
    return f"every entry is the same number of times that of the operator {name}, which depends on the constants"


def parts_of_linear(found: Mapping[str, FloatArray], draws: Draws) -> str:
    """What the factors of the parts of a linear law mean.

    Args:
        found: factors of the parts "lambda", "normal", "shear" and "rotation", in each draw [1].
        draws: constants of each draw.

    Returns:
        Sentences.
    """
    a, b, c, d = (found[k] for k in ("lambda", "normal", "shear", "rotation"))
    lmbda, mu = (np.array([v[k] for v in draws]) for k in ("lambda", "mu"))
    out = []
    if not close(d, 0.0):
        if close(d, b):
            out.append("the gradient is not symmetrised: grad(u) stands in the place of sym(grad(u)), so that "
                       "rotations cause stress")  # fmt: skip
        else:
            out.append(f"the gradient is not symmetrised: rotations count {d[0] / b[0]:.2f} times as much as strains")
    if close(b, c):
        if close(a * lmbda / mu, 1.0) and close(b * mu / lmbda, 1.0):
            return "; ".join(["Lame's constants lambda and mu are swapped", *out])
        out += _factor(b, mu, draws, IN_PLACE_OF_MU, "shear", "mu")
    else:
        text = f"shear strains count {c[0]:.2f} times, normal ones {b[0]:.2f} times"
        if close(c, 2 * b):
            text += ": shear angles (2 eps_xy) stand in the place of strains"
        elif close(c, 4 * b):
            text += ": the 1/2 of shear strains is missing"
        out.append(text)
    out += _factor(a, lmbda, draws, IN_PLACE_OF_LAMBDA, "the volumetric part", "lambda")
    return "; ".join(out)


def parts_of_finite(found: Mapping[str, FloatArray], draws: Draws) -> str:
    """What the factors of the parts "lambda" and "mu" of a law of finite strain mean."""
    a, b = found["lambda"], found["mu"]
    lmbda, mu = (np.array([v[k] for v in draws]) for k in ("lambda", "mu"))
    if close(a * lmbda / mu, 1.0) and close(b * mu / lmbda, 1.0):
        return "Lame's constants lambda and mu are swapped"
    out = _factor(b, mu, draws, IN_PLACE_OF_MU, "the part of mu", "mu")
    return "; ".join(out + _factor(a, lmbda, draws, IN_PLACE_OF_LAMBDA, "the part of lambda", "lambda"))


def _factor(
    s: FloatArray, right: FloatArray, draws: Draws, known: Sequence[tuple[str, Moduli]], part: str, name: str
) -> list[str]:
    """What a factor of one part means; nothing if it is one."""
    if close(s, 1.0):
        return []
    if close(s, 0.0):
        return [f"{part} is missing"]
    if close(s, -1.0):
        return [f"{part} has the wrong sign"]
    found = modulus(s * right, draws, known)
    if found:
        return [f"in the place of {name} stands {found}"]
    if np.ptp(s) <= CLOSE * abs(s[0]):
        return [f"{part} counts {s[0]:.2f} times"]
    return [f"{name} is another modulus than it should be ({s[0]:.4g} times for nu = {draws[0]['nu']:.3g})"]
