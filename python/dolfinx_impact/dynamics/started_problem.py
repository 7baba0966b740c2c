# SPDX-License-Identifier: MIT
"""What starts and checkpoints of explicit problems ask of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from .. import _cpp
from ..assembly.history import MaterialHistory
from ..common.types import BoolArray
from ..io.signature import Problem


class StartedProblem(Problem, Protocol):
    """An explicit problem.

    Attributes:
        prescribed: mask of prescribed degrees of freedom, owned and ghosts.
    """

    prescribed: BoolArray

    @property
    def _cpp_object(self) -> _cpp.problems.ExplicitProblem:
        """The problem in C++."""

    @property
    def contact(self) -> Sequence[Any]:
        """Contacts with results."""

    @property
    def has_history(self) -> bool:
        """Whether a material has internal variables."""

    @property
    def history(self) -> MaterialHistory:
        """Internal variables of the materials."""

    @property
    def contact_step(self) -> float:
        """Step for which contact springs that follow from it are made [T]."""

    def restart_forces(self, equilibrium: _cpp.solve.EquilibriumProblem | None = None) -> None:
        """Compute the forces of the start once more, after contacts have got a history. Collective.

        Args:
            equilibrium: what materials and springs begin with; None: nothing.
        """
