# SPDX-License-Identifier: MIT
"""Limits and messages for energy that an explicit run gains without external work; docs/explicit/energies.md."""

import math
from collections.abc import Iterable

import numpy as np
from dolfinx import fem

from .. import _cpp
from ..common.types import FloatArray

# Gain relative to the energies so far at which a run warns and at which it stops. A correct run with contact gains less
# than 0.01.
LIMITS = (0.1, 0.5)
# Kinetic energy over all energy put in, beyond which a run grows.
GROWTH: float = _cpp.integrators.largest_growth


def release_limit(V: fem.FunctionSpace, stiffness: FloatArray) -> float:
    """Energy that a residual of the user's own may give, beside that of the displacement at the start: what its bodies
    store when all their cells are strained by about a tenth. Collective.

    Args:
        V: displacement space; of others nothing is known.
        stiffness: of owned degrees of freedom: mass times the square of the highest frequency, or the diagonal of the
            stiffness matrix [F/L].

    Returns:
        The energy; infinite if the space is none of displacements, or bodies have no stiffness [F L].
    """
    return float(_cpp.problems.release_limit(V._cpp_object, np.ascontiguousarray(stiffness)))


def released_message(released: float, limit: float, go_on: str) -> str:
    """Text of an error about energy that a residual has given.

    Args:
        released: the energy [F L].
        limit: what bodies may have stored [F L].
        go_on: how to let the run go on.

    Returns:
        What was found and what to do.
    """
    return str(_cpp.problems.released_message(released, limit, go_on))


def checked(limits: Iterable[float] | None) -> tuple[float, float]:
    """Check the argument `energy_limits` of `advance`.

    Args:
        limits: gain at which the run warns and gain at which it stops; None: no limits [1].

    Returns:
        The two limits; infinite for None [1].

    Raises:
        ValueError: `limits` are not two numbers, or not in increasing order.
    """
    if limits is None:
        return math.inf, math.inf
    try:
        warn, stop = (float(limit) for limit in limits)
    except (TypeError, ValueError) as e:
        raise ValueError(f"energy_limits is {limits!r}: give two numbers, for the warning and the stop, or None") from e
    if not 0.0 < warn <= stop:
        raise ValueError(f"energy_limits is {limits!r}: the first must be positive, the second no smaller")
    return warn, stop
