# SPDX-License-Identifier: MIT
"""Parameters of implicit schemes; cpp/dolfinx_impact/integrators/newmark/ImplicitScheme.h has the equations."""

from __future__ import annotations

from ... import _cpp
from ...common.arguments import number


def scheme_of(
    beta: float | None, gamma: float | None, rho_inf: float | None, hht: float | None
) -> _cpp.integrators.ImplicitScheme:
    """Scheme of the arguments of a problem; each may be None.

    Args:
        beta: Newmark's beta [1].
        gamma: Newmark's gamma [1].
        rho_inf: spectral radius at infinite frequency [1].
        hht: alpha of Hilber, Hughes and Taylor [1].

    Returns:
        Scheme.

    Raises:
        TypeError: an argument is no number.
        ValueError: arguments exclude each other, or are out of their ranges.
    """
    families = {"beta, gamma": (beta, gamma), "rho_inf": (rho_inf,), "hht": (hht,)}
    given = [name for name, values in families.items() if any(v is not None for v in values)]
    if len(given) > 1:
        raise ValueError(f"{' and '.join(given)} are given: each of them determines all parameters, give one")
    if rho_inf is not None:
        return _cpp.integrators.ImplicitScheme.generalised_alpha(number("rho_inf", rho_inf))
    if hht is not None:
        return _cpp.integrators.ImplicitScheme.hht(number("hht", hht))
    gamma = 0.5 if gamma is None else number("gamma", gamma)
    return _cpp.integrators.ImplicitScheme.newmark(0.25 if beta is None else number("beta", beta), gamma)
