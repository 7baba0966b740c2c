# SPDX-License-Identifier: MIT
"""Which cells, degrees and hypotheses kernels are written for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass

from ..forms.materials import HYPOTHESES
from ..forms.registry import CELLS, DEGREES, default_hypothesis
from .case import Case
from .own_law import KINDS


@dataclass
class Choice:
    """What a user asks for; None: not said.

    Attributes:
        cells: names of cells.
        degrees: degrees of the unknown [1].
        geometry_degrees: degrees of the geometry [1].
        hypotheses: hypotheses.
        kernels: kinds of kernels, of own_law.KINDS.
    """

    cells: Sequence[str] | None = None
    degrees: Sequence[int] | None = None
    geometry_degrees: Sequence[int] | None = None
    hypotheses: Sequence[str] | None = None
    kernels: Sequence[str] | None = None

    def check(self) -> None:
        """Refuse what kernels are not written for.

        Raises:
            ValueError: an unknown cell, degree, hypothesis or kind of kernel, or hypotheses that fit no cell.
        """
        for what, given, known in (
            ("cell", self.cells, CELLS),
            ("degree", self.degrees, DEGREES),
            ("geometry degree", self.geometry_degrees, DEGREES),
            ("hypothesis", self.hypotheses, HYPOTHESES),
            ("kind of kernel", self.kernels, KINDS),
        ):
            for value in given or ():
                if value not in known:
                    raise ValueError(f"{what} {value!r} is unknown: use {', '.join(map(str, known))}")
        for cell in self.cells or ():
            if self.hypotheses and not self.hypotheses_on(cell):
                raise ValueError(f"none of the hypotheses {', '.join(self.hypotheses)} fits cells {cell!r}")

    def hypotheses_on(self, cell: str) -> list[str]:
        """Hypotheses on a cell.

        Args:
            cell: one of CELLS.
        """
        given = self.hypotheses or [default_hypothesis(cell)]
        return [h for h in given if (h == "3d") == (CELLS[cell] == 3)]

    def cases(self, cells: Sequence[str] | None) -> Iterator[Case]:
        """All cases.

        Args:
            cells: cells of a file, which count where the user asks for none; None: all.
        """
        for cell in self.cells or cells or tuple(CELLS):
            for geometry_degree in self.geometry_degrees or (1,):
                for hypothesis in self.hypotheses_on(cell):
                    for degree in self.degrees or (1,):
                        yield Case(cell, degree, geometry_degree, hypothesis)

    def only(self, case: Case) -> Choice:
        """What of this choice asks for a case: where nothing is said, still nothing.

        Args:
            case: one of `cases`.
        """
        return Choice(
            [case.cell] if self.cells else None,
            [case.degree] if self.degrees else None,
            [case.geometry_degree] if self.geometry_degrees else None,
            [case.hypothesis] if self.hypotheses else None,
        )

    def contradiction(self, case: Case) -> str:
        """What a case has that was not asked for; an empty text if nothing.

        Args:
            case: cells that a form is bound to.
        """
        asked = (self.cells, self.degrees, self.geometry_degrees, self.hypotheses)
        for what, given, own in zip(("cell", "degree", "geometry degree", "hypothesis"), asked, case):
            if given and own not in given:
                return f"{what} {own}, not for {', '.join(map(str, given))}"
        return ""
