# SPDX-License-Identifier: MIT
"""Parts that stresses are sums of, right ones and ones that people write in their place."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from dolfinx_impact.common.types import FloatArray
from .sample import Stress

Energy = Callable[[FloatArray], FloatArray]  # density, shape (num_points)
# Name of the part -> stress, from constants (lambda, mu, ...).
Parts = Callable[[Mapping[str, Any]], dict[str, Stress]]
EYE = np.eye(3)


def transpose(A: Any) -> Any:
    """Transposes of an array of matrices."""
    return np.swapaxes(A, -1, -2)


def trace(A: Any) -> Any:
    """Traces as an array of shape (n, 1, 1)."""
    return np.trace(A, axis1=-2, axis2=-1)[:, None, None]


def determinant(F: Any) -> Any:
    """Determinants of an array of complex 3 x 3 matrices, shape (n, 1, 1)."""
    return np.einsum("qi,qi->q", F[:, 0], np.cross(F[:, 1], F[:, 2]))[:, None, None]


def inverse(F: Any) -> Any:
    """Inverses of an array of complex 3 x 3 matrices."""
    rows = [np.cross(F[:, (i + 1) % 3], F[:, (i + 2) % 3]) for i in range(3)]
    return transpose(np.stack(rows, axis=1)) / determinant(F)


def _symmetric(H: Any) -> Any:
    return (H + transpose(H)) / 2


def _green(H: Any) -> Any:
    return (H + transpose(H) + transpose(H) @ H) / 2


def linear(c: Mapping[str, Any]) -> dict[str, Stress]:
    """Parts of isotropic linear laws: volumetric, normal strains, shear strains, rotations."""
    mu, lmbda = c["mu"], c["lambda"]
    return {
        "lambda": lambda H: lmbda * trace(H) * EYE,
        "normal": lambda H: 2 * mu * _symmetric(H) * EYE,
        "shear": lambda H: 2 * mu * _symmetric(H) * (1 - EYE),
        "rotation": lambda H: mu * (H - transpose(H)),
    }


def neo_hookean(c: Mapping[str, Any]) -> dict[str, Stress]:
    """Parts of the neo-Hookean law mu (F - F^-T) + lambda ln J F^-T."""
    mu, lmbda = c["mu"], c["lambda"]

    def deviatoric(H: Any) -> Any:
        F = EYE + H
        return mu * (F - transpose(inverse(F)))

    def volumetric(H: Any) -> Any:
        F = EYE + H
        return lmbda * np.log(determinant(F)) * transpose(inverse(F))

    return {"lambda": volumetric, "mu": deviatoric}


def st_venant_kirchhoff(c: Mapping[str, Any]) -> dict[str, Stress]:
    """Parts of F (lambda tr E I + 2 mu E)."""
    mu, lmbda = c["mu"], c["lambda"]
    return {
        "lambda": lambda H: (EYE + H) @ (lmbda * trace(_green(H)) * EYE),
        "mu": lambda H: (EYE + H) @ (2 * mu * _green(H)),
    }


def _over_j(parts: Parts) -> Parts:
    def wrapped(c: Mapping[str, Any]) -> dict[str, Stress]:
        whole = total(parts(c))
        return {"all": lambda H: whole(H) / determinant(EYE + H)}

    return wrapped


def total(parts: Mapping[str, Stress]) -> Stress:
    """Sum of parts."""
    return lambda H: sum(part(H) for part in parts.values())


def _neo_without_transpose(c: Mapping[str, Any]) -> dict[str, Stress]:
    def stress(H: Any) -> Any:
        F = EYE + H
        return c["mu"] * F + (c["lambda"] * np.log(determinant(F)) - c["mu"]) * inverse(F)

    return {"all": stress}


def _neo_other_volume(kind: str) -> Parts:
    def parts(c: Mapping[str, Any]) -> dict[str, Stress]:
        def volumetric(H: Any) -> Any:
            F = EYE + H
            J = determinant(F)
            slope = (J - 1) * J if kind == "(J - 1)^2" else (J**2 - 1) / 2
            return c["lambda"] * slope * transpose(inverse(F))

        return {"all": lambda H: neo_hookean(c)["mu"](H) + volumetric(H)}

    return parts


def _neo_without_log(c: Mapping[str, Any]) -> dict[str, Stress]:
    return {"all": lambda H: c["mu"] * (EYE + H) + neo_hookean(c)["lambda"](H)}


def _kirchhoff(left: str) -> Parts:
    """P = S, S F, F^T S in the place of F S, or strains that lack a part."""

    def parts(c: Mapping[str, Any]) -> dict[str, Stress]:
        def hooke(E: Any) -> Any:
            return c["lambda"] * trace(E) * EYE + 2 * c["mu"] * E

        return {
            "none": {"all": lambda H: hooke(_green(H))},
            "right": {"all": lambda H: hooke(_green(H)) @ (EYE + H)},
            "transposed": {"all": lambda H: transpose(EYE + H) @ hooke(_green(H))},
            "small": {"all": lambda H: (EYE + H) @ hooke(_symmetric(H))},
            "left_green": {"all": lambda H: (EYE + H) @ hooke((H + transpose(H) + H @ transpose(H)) / 2)},
        }[left]

    return parts


def _linear_whole(c: Mapping[str, Any]) -> dict[str, Stress]:
    return {"all": total({k: v for k, v in linear(c).items() if k != "rotation"})}


def _whole(parts: Parts) -> Parts:
    return lambda c: {"all": total(parts(c))}


def other_energies(c: Mapping[str, Any]) -> dict[str, Energy]:
    """Neo-Hookean energies with another part of the volume, by what it is."""

    def energy(volume: Energy) -> Energy:
        return lambda H: energy_parts("neo_hookean", c)["mu"](H) + c["lambda"] * volume(determinant(EYE + H)[:, 0, 0])

    return {
        SQUARE: energy(lambda J: (J - 1) ** 2 / 2),
        SIMO: energy(lambda J: (J**2 - 1 - 2 * np.log(J)) / 4),
    }


@dataclass(frozen=True)
class Candidate:
    """A law that is written in the place of the right one.

    Args:
        parts: its one part.
        reason: what it is.
    """

    parts: Parts
    reason: str


RIGHT: dict[str, Parts] = {
    "linear_elastic": linear, "neo_hookean": neo_hookean, "st_venant_kirchhoff": st_venant_kirchhoff,
}  # fmt: skip
DET = "det F is missing: the stress is the right one over J (a Cauchy stress is pulled back without its J)"
SQUARE = "another energy of the volume: lambda/2 (J - 1)^2 in the place of lambda/2 (ln J)^2"
SIMO = "another energy of the volume: lambda/4 (J^2 - 1 - 2 ln J) in the place of lambda/2 (ln J)^2"
NO_LOG = "the term -mu ln J of the energy is missing: the body is not free of stress at rest"
SMALL = "it is linear elasticity: the form is of small strain"
CANDIDATES: dict[str, tuple[Candidate, ...]] = {
    "linear_elastic": (
        Candidate(_whole(st_venant_kirchhoff), "it is St. Venant-Kirchhoff's law of finite strain"),
        Candidate(_whole(neo_hookean), "it is the neo-Hookean law of finite strain"),
    ),
    "neo_hookean": (
        Candidate(_neo_without_transpose, "a transpose is missing: F^-1 stands in the place of F^-T"),
        Candidate(_over_j(neo_hookean), DET),
        Candidate(_neo_other_volume("(J - 1)^2"), SQUARE),
        Candidate(_neo_other_volume("(J^2 - 1)/2"), SIMO),
        Candidate(_neo_without_log, NO_LOG),
        Candidate(_whole(st_venant_kirchhoff), "it is St. Venant-Kirchhoff's law"),
        Candidate(_linear_whole, SMALL),
    ),
    "st_venant_kirchhoff": (
        Candidate(_kirchhoff("none"), "F is missing in F S: the second Piola-Kirchhoff stress stands in the place of "
                  "the first"),
        Candidate(_kirchhoff("right"), "S F stands in the place of F S"),
        Candidate(_kirchhoff("transposed"), "a transpose is too much: F^T S stands in the place of F S"),
        Candidate(_kirchhoff("small"), "the strain lacks its quadratic part: sym(grad u) in the place of E"),
        Candidate(_kirchhoff("left_green"), "a transpose is at the wrong place: E is of F F^T in the place of F^T F"),
        Candidate(_over_j(st_venant_kirchhoff), DET),
        Candidate(_whole(neo_hookean), "it is the neo-Hookean law"),
        Candidate(_linear_whole, SMALL),
    ),
}  # fmt: skip


def _work(stress: Stress) -> Energy:
    """Energy of a part of a linear law."""
    return lambda H: np.einsum("qij,qij->q", stress(H), H) / 2


def energy_parts(law: str, c: Mapping[str, Any]) -> dict[str, Energy]:
    """Energy densities of the parts of a law, of shape (num_points).

    Args:
        law: name of the law.
        c: constants.
    """
    if law == "linear_elastic":
        return {name: _work(part) for name, part in linear(c).items()}
    if law == "st_venant_kirchhoff":
        return {
            "lambda": lambda H: c["lambda"] / 2 * trace(_green(H))[:, 0, 0] ** 2,
            "mu": lambda H: c["mu"] * np.einsum("qij,qij->q", _green(H), _green(H)),
        }

    def volume(H: FloatArray) -> FloatArray:
        return np.asarray(determinant(EYE + H)[:, 0, 0])

    return {
        "lambda": lambda H: c["lambda"] / 2 * np.log(volume(H)) ** 2,
        "mu": lambda H: c["mu"] * (np.einsum("qij,qij->q", EYE + H, EYE + H) / 2 - 1.5 - np.log(volume(H))),
    }
