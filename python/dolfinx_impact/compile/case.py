# SPDX-License-Identifier: MIT
"""Cells, degrees and hypothesis that kernels are written for."""

from __future__ import annotations

from typing import NamedTuple

from ..forms import quadrature


class Case(NamedTuple):
    """What kernels are made for, in the order of kernels::Key.

    Attributes:
        cell: one of forms.registry.CELLS.
        degree: degree of the unknown [1].
        geometry_degree: degree of the geometry [1].
        hypothesis: one of forms.materials.HYPOTHESES.
    """

    cell: str
    degree: int
    geometry_degree: int
    hypothesis: str

    def __str__(self) -> str:
        return f"{self.cell}, degree {self.degree}, geometry degree {self.geometry_degree}, {self.hypothesis}"

    @property
    def stiffness_degree(self) -> int:
        """Quadrature degree of the package's own laws [1]."""
        return int(quadrature.stiffness_degree(*self))

    @property
    def mass_degree(self) -> int:
        """Quadrature degree of masses [1]."""
        return int(quadrature.mass_degree(*self))
