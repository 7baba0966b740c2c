# SPDX-License-Identifier: MIT
"""Internal variables of a problem by name."""

from __future__ import annotations

from collections.abc import Iterator, Mapping

from .cauchy_stress import VON_MISES
from ..forms.elasticity import STRESS
from .history_field import HistoryField
from .inelastic_part import InelasticParts
from .point_values import PointHistory
from .stress_fields import StressFields

__all__ = ["HistoryField", "MaterialHistory", "existing"]


class MaterialHistory(Mapping[str, HistoryField]):
    """Internal variables of a problem by name; also the Cauchy stress, "stress" (xx, yy, zz, xy, and in space yz, xz),
    and "von_mises", which are evaluated when they are asked for.

    Args:
        parts: inelastic parts of the problem.
        points: the values at the points.
    """

    def __init__(self, parts: InelasticParts, points: PointHistory) -> None:
        self._parts, self._points = parts, points
        self._stress: StressFields | None = None

    @property
    def parts(self) -> InelasticParts:
        """Inelastic parts of the problem."""
        return self._parts

    @property
    def points(self) -> PointHistory:
        """Values at the quadrature points (C++)."""
        return self._points

    def __iter__(self) -> Iterator[str]:
        return iter(dict.fromkeys(name for part in self._parts for name in part.history))

    def __len__(self) -> int:
        return len(list(iter(self)))

    def __repr__(self) -> str:
        return f"MaterialHistory({', '.join(self)})"

    def __getitem__(self, name: str) -> HistoryField:
        if name in (STRESS, VON_MISES):
            if self._stress is None:
                self._stress = StressFields(next(iter(self._parts)).u, self._parts.material, self._points)
            return self._stress[name]
        found = {part.response.history[name]: part for part in self._parts if name in part.history}
        if not found:
            raise KeyError(f"no material has the internal variable {name!r}: there are {', '.join(self)}")
        if len(found) > 1:
            raise ValueError(f"the materials have {name!r} with different shapes, {sorted(found)}")
        ((shape, part),) = found.items()
        points = self._points
        return HistoryField(
            name, shape, part.degree, part.mesh, lambda: points.values(name), lambda v: points.set_values(name, v)
        )


def existing(history: MaterialHistory | None) -> MaterialHistory:
    """Internal variables of a problem that has some.

    Args:
        history: internal variables, or None.

    Returns:
        `history`.

    Raises:
        ValueError: there are none.
    """
    if history is None:
        raise ValueError("no material of the problem has internal variables")
    return history
