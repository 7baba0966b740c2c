# SPDX-License-Identifier: MIT
"""Limits and messages for energy that an explicit run gains without external work; docs/explicit/energies.md."""

import math
from collections.abc import Iterable

# Gain relative to the energies so far at which a run warns and at which it stops. A correct run with contact gains less
# than 0.01.
LIMITS = (0.1, 0.5)


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


def message(gain: float) -> str:
    """Text of a warning or error about gained energy.

    Args:
        gain: gained energy relative to the energies so far [1].

    Returns:
        What was found and what to do.
    """
    return (
        f"it has gained energy without the work of loads or supports: {100 * gain:.3g} % of the energies so far. "
        "Contact or the steps bring it in: take a smaller step, damping or bulk viscosity, or check that bodies do not "
        "pass through each other; energy_limits=... of advance changes the limits."
    )
