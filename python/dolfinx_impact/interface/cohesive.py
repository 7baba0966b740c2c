# SPDX-License-Identifier: MIT
"""Surfaces that hold together until they break: a bilinear cohesive zone of mixed mode."""

from __future__ import annotations

from typing import Any

import ufl

from ..common.arguments import number
from .law import InterfaceLaw, InterfaceUpdate


def cohesive_zone(
    stiffness: float,
    strength: float,
    energy: float,
    shear_strength: float | None = None,
    shear_energy: float | None = None,
    exponent: float = 2.0,
    reach: float | None = None,
) -> InterfaceLaw:
    """Bilinear cohesive zone: elastic up to the strength, then softening until the energy of fracture is spent.

    With the opening d_n = max(g, 0), the slip s and the mixed separation d = sqrt(d_n^2 + |s|^2), tractions are
    (1 - D) k times opening and slip; overlaps are resisted with k. The damage D grows from the separation of the onset
    to that of the end, which depend on the part B = |s|^2/d^2 of the shear mode by the criterion of Benzeggagh and
    Kenane, with an exponent (Camanho and Davila 2002; Turon et al. 2006):

        d_0^2 = d_n0^2 + (d_s0^2 - d_n0^2) B^e,    d_0 d_f = d_n0 d_nf + (d_s0 d_sf - d_n0 d_nf) B^e.

    Args:
        stiffness: k, of the bond that is not damaged [F/L^3].
        strength: largest traction across the interface [F/L^2].
        energy: energy of fracture in opening, G_Ic [F/L].
        shear_strength: largest traction along the interface; None: `strength` [F/L^2].
        shear_energy: energy of fracture in shear, G_IIc; None: `energy` [F/L].
        exponent: e [1].
        reach: largest gap at which the law is asked; None: twice the largest separation at which the bond breaks [L].

    Raises:
        TypeError: a value that is no number.
        ValueError: a value that is not positive, or an energy that is less than what the bond has stored at its
            strength.
    """
    k = number("stiffness", stiffness, 0.0, " [F/L^3]")
    tau = [number("strength", strength, 0.0, " [F/L^2]")]
    tau.append(tau[0] if shear_strength is None else number("shear_strength", shear_strength, 0.0, " [F/L^2]"))
    G = [number("energy", energy, 0.0, " [F/L]")]
    G.append(G[0] if shear_energy is None else number("shear_energy", shear_energy, 0.0, " [F/L]"))
    onset, end = [t / k for t in tau], [2 * g / t for g, t in zip(G, tau)]
    for what, a, b, g in zip(("opening", "shear"), onset, end, G):
        if not b > a:
            raise ValueError(
                f"in {what} the bond stores {k * a * a / 2:g} at its strength, and the energy of fracture is {g:g}: "
                "take a larger stiffness, or a smaller strength"
            )
    names = ("onset_n", "onset_s", "end_n", "end_s")
    values = dict(zip(names, (*onset, *end)), stiffness=k, exponent=number("exponent", exponent, 0.0, " [1]"))

    def respond(point: Any) -> InterfaceUpdate:
        P = point.parameters
        opening, squared = ufl.max_value(point.gap, 0), ufl.dot(point.slip, point.slip)
        total = opening**2 + squared
        whole = ufl.gt(total, 0)
        separation = ufl.sqrt(ufl.conditional(whole, total, P.onset_n**2))
        mode = ufl.conditional(whole, squared, 0.0) / separation**2
        part = ufl.conditional(ufl.gt(mode, 0), ufl.max_value(mode, 1e-300) ** P.exponent, 0.0)
        first = ufl.sqrt(P.onset_n**2 + (P.onset_s**2 - P.onset_n**2) * part)
        last = (P.onset_n * P.end_n + (P.onset_s * P.end_s - P.onset_n * P.end_n) * part) / first
        damage = last * (separation - first) / (separation * (last - first))
        damage = ufl.max_value(ufl.min_value(damage, 1), 0)
        damage = ufl.max_value(point.history.damage, ufl.conditional(whole, damage, 0.0))
        bond = (1 - damage) * P.stiffness
        overlap = ufl.min_value(point.gap, 0)
        return InterfaceUpdate(
            pressure=-bond * opening - P.stiffness * overlap,
            shear=-bond * point.slip,
            energy=bond * total / 2 + P.stiffness * overlap**2 / 2,
            history={"damage": damage},
            sticks=ufl.lt(damage, 1),
        )

    return InterfaceLaw(
        response=respond,
        history={"damage": ()},
        parameters=values,
        reach=2 * max(end) if reach is None else reach,
        name="cohesive zone",
    )
