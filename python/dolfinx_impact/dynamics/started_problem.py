# SPDX-License-Identifier: MIT
"""What starts and checkpoints of explicit problems ask of them."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any, Protocol

from .. import _cpp
from ..assembly.material_history import MaterialHistory
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
    def contact(self) -> Sequence[Any]: ...

    @property
    def has_history(self) -> bool: ...

    @property
    def history(self) -> MaterialHistory: ...

    @property
    def contact_step(self) -> float: ...

    def restart_forces(self, equilibrium: _cpp.solve.EquilibriumProblem | None = None) -> None: ...
