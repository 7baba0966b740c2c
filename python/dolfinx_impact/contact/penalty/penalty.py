# SPDX-License-Identifier: MIT
"""Contact by penalty: Gauss point to surface, exact tangent, friction by return mapping; docs/contact.md."""

from typing import Any

from ... import _cpp
from ...common.arguments import integer, number
from ...common.collective import comm_of, guard
from ...common.fixed import Fixed
from ...interface import InterfaceLaw
from ..explicit.nodal import NodalPair
from ..pair import ContactPair, check_pair, check_quadrature_degree
from ..protocol import ExplicitContactProblem, StaticContactProblem
from .quadrature_penalty import QuadraturePenalty

RULES = ("auto", "step")  # for penalties that are no numbers
ROUND_OFF = 1e-15  # part of the bodies' size below which a penetration is round-off of positions


class Penalty(Fixed):
    """Enforce contact of a pair by a penalty, seed (3.48), corrected.

    In explicit problems (docs/explicit/penalty.md) the contact points are the slave's nodes, and "auto" is half of the
    stiffness of the outermost cells of both bodies, within what their nodal masses bear; `tangential`, `augmented` and
    `quadrature_degree` are options of static problems.

    Args:
        pair: the pair of surfaces.
        penalty: pressure per penetration; "auto": ten times the nodal stiffness per area of the softer surface where
            its facets are smallest, printed when it is computed; "step": in explicit problems half of the nodal
            masses over the square of the time step, as stiff as the step bears, for loads that stay [F/L^3].
        tangential: tangential traction per slip, with friction; None: equal to `penalty` [F/L^3].
        augmented: whether each increment is repeated with augmented multipliers (Uzawa) until the mean penetration
            around each corner of the slave's facets is below `tolerance`.
        tolerance: largest mean penetration with `augmented`, relative to the size of the bodies [1].
        quadrature_degree: degree of the quadrature on slave facets; None: 2 degree + 2.
        balanced: whether an explicit problem applies the contact in both directions with half the stiffness each.
        max_augmentations: largest number of augmentations of an increment; each one reduces the penetration by the
            part penalty/(penalty + stiffness per area of the bodies).
        law: law of the interface in the place of penalty and friction (docs/interface_laws.md); None: none.

    Raises:
        TypeError: an argument of a wrong type; on all ranks.
        ValueError: a penalty or tolerance that is not positive, or a degree without quadrature rule; on all ranks.
    """

    def __init__(
        self,
        pair: ContactPair,
        penalty: float | str = "auto",
        tangential: float | None = None,
        augmented: bool = False,
        tolerance: float = 1e-8,
        quadrature_degree: int | None = None,
        balanced: bool = False,
        max_augmentations: int = 200,
        law: InterfaceLaw | None = None,
    ) -> None:
        given: dict[str, Any] = dict(
            penalty=penalty,
            tangential=tangential,
            augmented=bool(augmented),
            tolerance=tolerance,
            balanced=bool(balanced),
            max_augmentations=max_augmentations,
            law=law,
        )
        with guard(comm_of(pair), "Penalty", pair=pair, quadrature_degree=quadrature_degree, **given):
            check_pair(pair)
            self.quadrature_degree = check_quadrature_degree(quadrature_degree)
            rule = penalty if isinstance(penalty, str) and penalty in RULES else None
            self.penalty = None if rule else number("penalty", penalty, 0.0, " [F/L^3]")
            self.tangential = None if tangential is None else number("tangential penalty", tangential, 0.0, " [F/L^3]")
            self.tolerance = number("tolerance", tolerance, 0.0)
            if self.tolerance < ROUND_OFF:
                raise ValueError(
                    f"tolerance is {self.tolerance:g}: penetrations below {ROUND_OFF:g} of the bodies' size are "
                    "round-off of positions; take a larger one"
                )
            self.max_augmentations = integer("max_augmentations", max_augmentations, 1)
            if law is not None:
                _check_law(law, pair, penalty != "auto" or tangential is not None or augmented or balanced)
        self.law = law
        self.pair, self.augmented, self.balanced = pair, bool(augmented), bool(balanced)
        self.by_step = rule == "step"

    def __repr__(self) -> str:
        if self.law is not None:
            return f"Penalty({self.pair!r}, law={self.law!r})"
        options = [f"penalty={self.penalty or ('step' if self.by_step else 'auto')!r}"]
        if self.tangential is not None:
            options.append(f"tangential={self.tangential}")
        options += [f"{name}=True" for name in ("augmented", "balanced") if getattr(self, name)]
        if self.augmented:
            options += [f"tolerance={self.tolerance:g}", f"max_augmentations={self.max_augmentations}"]
        if self.quadrature_degree is not None:
            options.append(f"quadrature_degree={self.quadrature_degree}")
        return f"Penalty({self.pair!r}, {', '.join(options)})"

    def _bind_explicit(self, problem: ExplicitContactProblem) -> NodalPair:
        if self.augmented or self.tangential is not None or self.quadrature_degree is not None:
            raise ValueError("tangential, augmented and quadrature_degree are options of static penalty contact")
        if self.law is not None:
            return NodalPair(self.pair, problem, _cpp.nodal.NodeLaw, law=self.law)
        penalty = self.penalty or 0.0
        by_class = _cpp.nodal.NodePenalty
        return NodalPair(self.pair, problem, by_class, self.by_step, penalty=penalty, balanced=self.balanced)

    def _bind(self, problem: StaticContactProblem) -> QuadraturePenalty:
        if self.balanced:
            raise ValueError("balanced penalty contact is for explicit dynamics")
        if self.by_step:
            raise ValueError("'step' is a penalty of explicit dynamics: give a number or 'auto'")
        return QuadraturePenalty(
            self.pair,
            problem,
            penalty=self.penalty,
            tangential=self.tangential,
            augmented=self.augmented,
            tolerance=self.tolerance,
            quadrature_degree=self.quadrature_degree,
            max_augmentations=self.max_augmentations,
            law=self.law,
        )


def _check_law(law: InterfaceLaw, pair: ContactPair, others: bool) -> None:
    """Refuse a law of the interface beside what it stands in the place of."""
    if not isinstance(law, InterfaceLaw):
        raise TypeError(f"law must be an InterfaceLaw, found {type(law).__name__}")
    if others:
        raise ValueError("a law of the interface stands in the place of penalty, tangential, augmented and balanced")
    if pair.has_friction:
        raise ValueError(
            f"{pair.name} has the friction {pair.friction}, and the law of the interface has its own: give it there"
        )
