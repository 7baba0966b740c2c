# SPDX-License-Identifier: MIT
"""Problems in time as checkpoints see them."""

from dolfinx.fem import FunctionSpace

from ..assembly.fields import is_mixed
from ..io.checkpoint import Subject
from ..io.signature import Problem, signature, supports


def in_time(problem: Problem) -> Subject:
    """A problem in time, explicit or implicit, as a checkpoint sees it.

    Args:
        problem: the problem.
    """
    return Subject(problem.space, lambda x: signature(problem, x), lambda: supports(problem))


def check_nodal(space: FunctionSpace, call: str) -> None:
    """Refuse spaces whose functions are no values at nodes.

    Args:
        space: displacement space.
        call: what was called.

    Raises:
        ValueError: the space is mixed.
    """
    if is_mixed(space):
        raise ValueError(
            f"{call}: checkpoints hold values at nodes, u is on a mixed space: keep the arrays of u, velocity and "
            "acceleration with a tool of DOLFINx, and begin again with u and velocity"
        )
